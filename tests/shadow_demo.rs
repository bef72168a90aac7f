//! The shadow-mapping demo's three scenes: what its light sees, and its hard shadows beside the tracer's.

use std::error::Error;
use std::path::Path;

use aam_lab::load;
use aam_reference::{LightSize, Options, Tracer};
use aam_renderer::{Gpu, RenderOptions, Renderer, Show};
use aam_scene::{Camera, CasterOutside, Pixels, Scene, ShadowSettings, Shadows, View};
use glam::{Vec2, Vec3};

type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

const SCENES: [&str; 3] = ["demo-torus", "demo-spheres", "demo-teapot"];

/// Side of the square pictures, in pixels.
const SIDE: u32 = 256;

fn scene(name: &str) -> Result<(Scene, View)> {
    let path = format!("{}/fixtures/assets/{name}.scene.toml", env!("CARGO_MANIFEST_DIR"));
    let (scene, camera) = load(Path::new(&path))?;
    let camera = camera.ok_or("the file names a camera")?;
    Ok((scene, View { camera, width: SIDE, height: SIDE, frame: 0.0 }))
}

fn shadows(scene: &Scene) -> &Shadows {
    scene.shadows.as_ref().expect("the file has a shadow")
}

fn volume(scene: &Scene) -> &Camera {
    shadows(scene).sources[0].volume.as_ref().expect("a volume of its own")
}

/// A renderer, or `None` (said aloud) where there is no adapter; on CI that is an error.
fn renderer() -> Result<Option<Renderer>> {
    match Gpu::headless() {
        Ok(gpu) => Ok(Some(Renderer::new(gpu))),
        Err(error) if std::env::var("CI").is_ok_and(|value| value == "true") => Err(error.into()),
        Err(error) => {
            println!("skipped: no GPU adapter ({error})");
            Ok(None)
        }
    }
}

/// Position in a volume: −1 to 1 across, 0 to 1 deep; `None` behind it.
fn seen(volume: &Camera, point: Vec3) -> Option<Vec3> {
    let clip = volume.projection_matrix(1.0) * volume.view() * point.extend(1.0);
    (clip.w > 0.0).then(|| clip.truncate() / clip.w)
}

/// Inside by a margin; outside by one if it is negative.
fn is_inside(volume: &Camera, point: Vec3, margin: f32) -> bool {
    seen(volume, point).is_some_and(|seen| {
        seen.x.abs() < 1.0 - margin && seen.y.abs() < 1.0 - margin && seen.z > margin && seen.z < 1.0 - margin
    })
}

/// The ray through the middle of a pixel of a square picture.
fn ray(camera: &Camera, x: u32, y: u32) -> (Vec3, Vec3) {
    let to_world = (camera.projection_matrix(1.0) * camera.view()).inverse();
    let at = (Vec2::new(x as f32, y as f32) + 0.5) / SIDE as f32;
    let far = to_world.project_point3(Vec3::new(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y, 1.0));
    (camera.position, (far - camera.position).normalize())
}

/// The surface in the middle of each pixel.
fn positions(scene: &Scene, camera: &Camera) -> Result<Vec<Option<Vec3>>> {
    let tracer = Tracer::new(scene, 0.0)?;
    let pixels = (0..SIDE * SIDE).map(|pixel| ray(camera, pixel % SIDE, pixel / SIDE));
    Ok(pixels.map(|(origin, way)| tracer.nearest(origin, way).map(|distance| origin + way * distance)).collect())
}

/// Whether each pixel's surface sees the light as a point; `None` where it faces away or there is none.
fn truth(scene: &Scene, view: &View) -> Result<Vec<Option<bool>>> {
    let (visibility, _) = aam_reference::visibility(scene, view, LightSize::Point, &Options::default())?;
    Ok(visibility.lights[0].iter().map(|seen| seen.map(|seen| seen.share > 0.5)).collect())
}

/// What the source lets through, with its settings changed.
fn drawn(renderer: &mut Renderer, scene: &Scene, view: &View, settings: &str) -> Result<Vec<f32>> {
    let mut scene = scene.clone();
    scene.shadows.as_mut().expect("shadows").sources[0].settings = settings.parse::<ShadowSettings>()?;
    Ok(renderer.visibility(&scene, view, 0, &RenderOptions::default())?.0)
}

/// Whether all pixels within a distance are the same.
fn is_even(truth: &[Option<bool>], pixel: usize, reach: i64) -> bool {
    let side = i64::from(SIDE);
    let (x, y) = (pixel as i64 % side, pixel as i64 / side);
    (-reach..=reach).all(|dy| {
        (-reach..=reach).all(|dx| {
            let (x, y) = (x + dx, y + dy);
            (0..side).contains(&x) && (0..side).contains(&y) && truth.get((y * side + x) as usize) == truth.get(pixel)
        })
    })
}

#[test]
fn r97_the_light_is_the_demos() -> Result<()> {
    for name in SCENES {
        let (scene, _) = scene(name)?;
        let light = volume(&scene);
        assert_eq!((light.position, light.target), (Vec3::new(2.0, 2.0, 3.0), Vec3::ZERO));
        assert_eq!((light.near, light.far), (2.0, 8.0));
        let settings = shadows(&scene).sources[0].settings;
        assert_eq!(settings.to_string(), "hard:resolution=512,intensity=0.8,slope_bias=0,faces=back");
    }
    Ok(())
}

#[test]
fn r102_casters_outside_of_the_lights_volume_are_counted() -> Result<()> {
    for (name, middles, cut) in [("demo-torus", 0, 0), ("demo-spheres", 3, 5), ("demo-teapot", 0, 0)] {
        let (scene, view) = scene(name)?;
        let outside = shadows(&scene).casters_outside(&scene, volume(&scene));
        let (bases, others): (Vec<&CasterOutside>, Vec<&CasterOutside>) =
            outside.iter().partition(|caster| scene.nodes[caster.node.index()].name == "Base");
        assert_eq!(bases.len(), 1, "{name}: the base reaches out at its corners");
        assert_eq!(others.iter().filter(|caster| caster.middle).count(), middles, "{name}");
        assert_eq!(others.iter().filter(|caster| !caster.middle).count(), cut, "{name}");
        let told: Vec<String> =
            aam_renderer::shadow_limits(&scene, &view, 0).iter().map(|limit| limit.reason().to_owned()).collect();
        let wanted = match middles {
            0 => "1 caster reaches out of its volume",
            _ => "3 casters stand outside of its volume and 6 casters reach out of it",
        };
        assert!(told.iter().any(|reason| reason.starts_with(wanted)), "{name}: {told:?}");
        let mut fitted = scene.clone();
        fitted.shadows.as_mut().expect("shadows").sources[0].volume = None;
        let fit = aam_renderer::shadow_camera(&fitted, &view, 0)?;
        assert_eq!(shadows(&fitted).casters_outside(&fitted, &fit), [], "{name}: a fitted volume holds all");
    }
    Ok(())
}

#[test]
fn r101_what_lies_outside_of_the_lights_volume_is_lit() -> Result<()> {
    let mut renderer = renderer()?;
    for (name, half, height, share) in
        [("demo-torus", 2.0, 0.1, 0.26), ("demo-spheres", 2.25, 0.1125, 0.343), ("demo-teapot", 2.0, 0.1, 0.26)]
    {
        let (scene, view) = scene(name)?;
        let steps = 400;
        let at = |step: i32| half * ((step as f32 + 0.5) / steps as f32 * 2.0 - 1.0);
        let top = (0..steps * steps).map(|cell| Vec3::new(at(cell % steps), at(cell / steps), height));
        let outside = top.filter(|point| !is_inside(volume(&scene), *point, 0.0)).count();
        let measured = outside as f32 / (steps * steps) as f32;
        assert!((measured - share).abs() < 0.005, "{name}: {measured} of the top is outside");
        let Some(renderer) = &mut renderer else { continue };
        for settings in ["hard:faces=back,slope_bias=0", "evsm4:radius=10", "pcf:radius=10,bias=0.01"] {
            let lit = drawn(renderer, &scene, &view, settings)?;
            let positions = positions(&scene, &view.camera)?;
            let outside = |point: &Option<Vec3>| point.is_some_and(|point| !is_inside(volume(&scene), point, -1e-3));
            let mut pixels = 0;
            for (pixel, _) in positions.iter().enumerate().filter(|(_, point)| outside(point)) {
                assert_eq!(lit[pixel], 1.0, "{name} {settings}: pixel {pixel}");
                pixels += 1;
            }
            assert!(pixels > 1000, "{name}: {pixels} pixels are outside");
        }
    }
    Ok(())
}

#[test]
fn r100_hard_shadows_agree_with_the_tracer_inside_the_lights_volume() -> Result<()> {
    let Some(mut renderer) = renderer()? else { return Ok(()) };
    for name in SCENES {
        let (scene, view) = scene(name)?;
        let (truth, positions) = (truth(&scene, &view)?, positions(&scene, &view.camera)?);
        for (settings, reach) in [("hard:resolution=2048", 2), ("hard:resolution=512,faces=back,slope_bias=0", 3)] {
            let lit = drawn(&mut renderer, &scene, &view, settings)?;
            let (mut compared, mut wrong) = (0, 0);
            for (pixel, expected) in truth.iter().enumerate() {
                let (Some(expected), Some(point)) = (*expected, positions[pixel]) else { continue };
                if is_inside(volume(&scene), point, 0.01) && is_even(&truth, pixel, reach) {
                    compared += 1;
                    wrong += usize::from((lit[pixel] > 0.5) != expected);
                }
            }
            println!("{name} {settings}: {wrong} of {compared} pixels differ");
            assert!(compared > 10_000 && wrong * 1000 <= compared, "{name} {settings}: {wrong} of {compared}");
        }
    }
    Ok(())
}

#[test]
fn r99_maps_may_be_larger_than_the_picture() -> Result<()> {
    let Some(mut renderer) = renderer()? else { return Ok(()) };
    let (mut scene, view) = scene("demo-spheres")?;
    let small = View { width: 64, height: 48, ..view };
    for resolution in [128, 256, 512, 1024, 2048] {
        scene.shadows.as_mut().expect("shadows").sources[0].settings.resolution = resolution;
        let (_, stats) = renderer.render_to_image(&scene, &small, &RenderOptions::default())?;
        assert_eq!((stats.shadow_maps, stats.shadow_bytes), (1, 4 * u64::from(resolution).pow(2)));
    }
    Ok(())
}

#[test]
fn r103_the_map_is_shown_as_grey_and_near_is_light() -> Result<()> {
    let Some(mut renderer) = renderer()? else { return Ok(()) };
    let (mut scene, view) = scene("demo-spheres")?;
    let light = volume(&scene).clone();
    let tracer = Tracer::new(&scene, 0.0)?;
    let mut lit = |scene: &Scene, show| -> Result<Vec<u8>> {
        let options = RenderOptions { show, ..RenderOptions::default() };
        match renderer.render_to_image(scene, &view, &options)?.0.pixels {
            Pixels::Rgba8(bytes) => Ok(bytes),
            _ => Err("not 8 bit".into()),
        }
    };
    let forward = (light.target - light.position).normalize();
    let depths: Vec<Option<f32>> = (0..SIDE * SIDE)
        .map(|pixel| {
            let (origin, way) = ray(&light, pixel % SIDE, pixel / SIDE);
            tracer.nearest(origin, way).map(|distance| distance * way.dot(forward))
        })
        .collect();
    for settings in [
        "hard:resolution=256",
        "evsm4:resolution=256,radius=1,metric=planar",
        "vsm:resolution=256,radius=1,metric=planar",
    ] {
        scene.shadows.as_mut().expect("shadows").sources[0].settings = settings.parse()?;
        let grey = lit(&scene, Show::ShadowMap(0))?;
        // Where the light sees nothing the map is as if it were far.
        let expected = |pixel: usize| {
            let depth = depths[pixel].unwrap_or(light.far);
            255.0 * (1.0 - ((depth - light.near) / (light.far - light.near)).clamp(0.0, 1.0))
        };
        let side = SIDE as usize;
        let inner = (1..side - 1).flat_map(|y| (1..side - 1).map(move |x| y * side + x));
        // Away from outlines, which the blur mixes.
        let even = inner.filter(|pixel| {
            let around = [pixel - side - 1, pixel - side + 1, pixel + side - 1, pixel + side + 1];
            around.into_iter().all(|other| (expected(other) - expected(*pixel)).abs() < 8.0)
        });
        let is_wrong = |pixel: &usize| (f32::from(grey[4 * pixel]) - expected(*pixel)).abs() > 3.0;
        let (wrong, right): (Vec<usize>, Vec<usize>) = even.partition(is_wrong);
        assert!(right.len() > 40_000 && wrong.len() < 100, "{settings}: {} of {}", wrong.len(), right.len());
        assert!(grey.chunks_exact(4).all(|pixel| pixel[0] == pixel[1] && pixel[1] == pixel[2] && pixel[3] == 255));
    }
    let shadowed = lit(&scene, Show::Lit)?;
    scene.shadows = None;
    let unshadowed = lit(&scene, Show::Lit)?;
    assert_eq!(lit(&scene, Show::ShadowMap(0))?.iter().map(|byte| u32::from(*byte)).max(), Some(255), "opaque black");
    let darker = shadowed.iter().zip(&unshadowed).filter(|(a, b)| a < b).count();
    assert!(darker > 5000 && shadowed.iter().zip(&unshadowed).all(|(a, b)| a <= b), "{darker} values are darker");
    Ok(())
}

#[test]
fn r104_bias_too_small_and_too_large() -> Result<()> {
    let Some(mut renderer) = renderer()? else { return Ok(()) };
    let (scene, view) = scene("demo-torus")?;
    let (truth, positions) = (truth(&scene, &view)?, positions(&scene, &view.camera)?);
    // Shares of lit pixels that are dark, and of dark ones that are lit, away from edges.
    let mut faults = |settings: &str| -> Result<(f32, f32)> {
        let lit = drawn(&mut renderer, &scene, &view, settings)?;
        let mut counts = [[0; 2]; 2];
        for (pixel, expected) in truth.iter().enumerate() {
            let (Some(expected), Some(point)) = (*expected, positions[pixel]) else { continue };
            if is_inside(volume(&scene), point, 0.01) && is_even(&truth, pixel, 3) {
                counts[usize::from(expected)][usize::from((lit[pixel] > 0.5) == expected)] += 1;
            }
        }
        let share = |[wrong, right]: [i32; 2]| wrong as f32 / (wrong + right).max(1) as f32;
        Ok((share(counts[1]), share(counts[0])))
    };
    let (acne, _) = faults("hard:resolution=512,slope_bias=0")?;
    assert!(acne > 0.1, "without bias front faces show moiré: {acne}");
    let (acne, panning) = faults("hard:resolution=512")?;
    assert!(acne < 0.002 && panning < 0.01, "the usual bias: {acne} {panning}");
    let (acne, _) = faults("hard:resolution=512,slope_bias=0,faces=back")?;
    assert!(acne < 0.002, "back faces: {acne}");
    // More than there is between the torus' upper side and the base along the light.
    let (_, panning) = faults("hard:resolution=512,bias=1.2")?;
    assert!(panning > 0.1, "the shadow leaves its caster: {panning}");
    Ok(())
}
