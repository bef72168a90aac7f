//! Displacement mapping: VR3Lib rendering requirements 33–41, and what breaks it.

use std::sync::Arc;

use aam_renderer::{Msaa, Overlays, RenderError, RenderOptions, Show};
use aam_scene::*;
use glam::{Affine3A, Vec2, Vec3, Vec4};

use crate::common::*;

/// A mesh displaced by a map of its own.
fn displaced(mut mesh: Mesh, displacement: Displacement, map: Image, material: Material) -> Scene {
    mesh.displacement = Some(displacement);
    let mut scene = scene_of(mesh, material, vec![dark()]);
    let layer = layer(&mut scene, map);
    scene.materials[0].layers[Layer::Displacement as usize] = Some(layer);
    scene
}

fn by(tessellation: u32, bias: f32, scale: f32) -> Displacement {
    Displacement { tessellation, bias, scale }
}

fn grey(value: u8) -> Image {
    image8(2, 2, |_, _| [value, 255 - value, 99, 0])
}

fn rough(width: u32) -> Image {
    image8(width, width, |x, y| [((x * 97 + y * 57) % 251) as u8, 0, 0, 255])
}

/// A sphere with coordinates around it, for all layers.
fn globe(rings: u32) -> Mesh {
    let mut mesh = sphere(rings);
    let across = 2 * rings;
    // The seam's vertices in one place, to the last bit.
    let at = |index: usize| (index as u32 / (across + 1), index as u32 % (across + 1));
    for index in 0..mesh.positions.len() {
        let (j, i) = at(index);
        let first = (j * (across + 1)) as usize;
        if i == across || j == 0 || j == rings {
            mesh.positions[index] = if j == 0 {
                Vec3::Z
            } else if j == rings {
                Vec3::NEG_Z
            } else {
                mesh.positions[first]
            };
            mesh.normals[index] = mesh.positions[index];
        }
    }
    let uvs: Vec<Vec2> = (0..mesh.positions.len())
        .map(|index| Vec2::new(at(index).1 as f32 / across as f32, 1.0 - at(index).0 as f32 / rings as f32))
        .collect();
    mesh.uvs = [0; 4].map(|_| Some(uvs.clone()));
    mesh
}

fn mode(displacement: DisplacementMode) -> RenderOptions {
    RenderOptions { displacement, ..options() }
}

#[test]
fn r33_the_factor_says_how_many_triangles_are_drawn() {
    let Some(mut renderer) = renderer() else { return };
    for factor in [1, 2, 5, 9, 16, 64] {
        let scene = displaced(quad(), by(factor, 0.0, 0.1), grey(99), glow(Vec3::ONE));
        let picture = draw(&mut renderer, &scene, &front(), &options());
        assert_eq!(picture.stats.triangles, 2 * u64::from(factor * factor));
        assert_color(picture.center(), Vec3::ONE);
    }
}

#[test]
fn r34_r35_heights_move_points_by_bias_and_scale_along_the_normal() {
    let Some(mut renderer) = renderer() else { return };
    // A quad that faces +Z comes nearer by 0.5 + 1.5·h, and so is seen larger: 90° from 5 m away, 64 pixels.
    for (value, bias, scale) in [(0, 0.5, 1.5), (255, 0.5, 1.5), (255, 0.5, -1.5), (51, 0.0, 2.5)] {
        let scene = displaced(quad(), by(3, bias, scale), grey(value), glow(Vec3::ONE));
        let picture = draw_sized(&mut renderer, &scene, &perspective(Vec3::Z * 5.0), &options(), 256, 256);
        let lit = (0..256).filter(|&x| picture.at(x, 128)[0] > 0).count() as f32;
        let expected = 256.0 / (5.0 - bias - scale * f32::from(value) / 255.0);
        assert!((lit - expected).abs() <= 2.0, "{lit} pixels, not {expected}");
    }
    // Moved by nothing, or almost: the picture of the base mesh.
    let light = vec![point(Vec3::new(2.0, 3.0, 4.0), Vec3::ONE)];
    let material = Material { specular: Vec3::splat(0.4), exponent: 12.0, ..Material::default() };
    let mut plain = displaced(globe(8), by(5, 0.0, 1e-20), rough(16), material);
    plain.lights = light;
    let base = draw(&mut renderer, &plain, &front(), &mode(DisplacementMode::Off));
    let drawn = draw(&mut renderer, &plain, &front(), &options());
    assert_eq!(drawn.stats.triangles, 25 * base.stats.triangles);
    let worst = base.bytes.iter().zip(&drawn.bytes).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(worst <= Some(1), "{worst:?}");
    Arc::make_mut(&mut plain.meshes[0]).displacement = Some(by(5, 0.0, 0.0));
    let still = draw(&mut renderer, &plain, &front(), &options());
    assert_eq!((still.bytes, still.stats.displaced_points), (base.bytes, 0));
}

#[test]
fn r38_no_light_comes_through_the_edges_of_a_closed_surface() {
    let Some(mut renderer) = renderer() else { return };
    // A glowing ball around the camera, seen from inside: every pixel must be lit, whatever the map.
    let outside = Camera { target: Vec3::new(0.3, 1.0, 0.2), position: Vec3::ZERO, ..perspective(Vec3::ZERO) };
    for displacement in [DisplacementMode::Uniform, DisplacementMode::Adaptive { pixel_error: 24.0 }] {
        for (turn, factor) in [3, 7, 8, 16].into_iter().enumerate() {
            let scene = displaced(globe(6), by(factor, -0.2, 0.4), rough(37), glow(Vec3::ONE));
            // Towards a pole, the seam, and between.
            let target =
                [Vec3::new(1.0, 0.01, 0.0), Vec3::new(0.1, 0.05, 1.0), Vec3::new(-1.0, 0.4, -0.6), Vec3::Y][turn];
            let camera = Camera { target, ..outside.clone() };
            let picture = draw_sized(&mut renderer, &scene, &camera, &mode(displacement), 512, 512);
            let holes = picture.bytes.chunks_exact(4).filter(|pixel| pixel[0] < 255).count();
            assert_eq!(holes, 0, "{displacement:?}, factor {factor}");
        }
    }
}

#[test]
fn r39_outlines_change_and_lighting_uses_displaced_positions_and_normals() {
    let Some(mut renderer) = renderer() else { return };
    let bump = |x: u32, y: u32| {
        let d = Vec2::new(x as f32 - 31.5, y as f32 - 31.5).length() / 32.0;
        (255.0 * (1.0 - d * d).max(0.0)) as u8
    };
    let map = image8(64, 64, |x, y| [bump(x, y), 0, 0, 255]);
    let mut scene = displaced(
        quad(),
        by(32, 0.0, 0.8),
        map,
        Material { diffuse: Vec3::ONE, ambient: Vec3::ZERO, ..Material::default() },
    );
    scene.lights = vec![directional(Vec3::NEG_X, Vec3::ONE)];
    // From the side, the flat quad is a line and the bump stands above it.
    let side = Camera { position: Vec3::new(5.0, 0.0, 0.0), target: Vec3::ZERO, up: Vec3::Z, ..front() };
    let picture = draw(&mut renderer, &scene, &side, &options()).save("displacement-profile");
    assert!(picture.at(32, 32 - 10)[0] > 0 && picture.at(32, 32 - 28)[0] == 0 && picture.at(32, 40)[0] == 0);
    // From above, its slope towards the light is bright, the other dark; the flat quad would be black.
    let above = draw(&mut renderer, &scene, &front(), &options()).save("displacement-slopes");
    let (right, left) = (above.at(46, 32)[0], above.at(18, 32)[0]);
    assert!(right > 100 && left < 5, "{right} {left}");
    assert!(draw(&mut renderer, &scene, &front(), &mode(DisplacementMode::Off)).at(46, 32)[0] == 0);
    // A light in the hollow between the base and the top of the bump is below the surface there.
    scene.lights = vec![point(Vec3::new(0.0, 0.0, 0.4), Vec3::ONE)];
    assert!(draw(&mut renderer, &scene, &front(), &options()).center()[0] < 5);
    // The box around it holds the bump.
    let boxed = RenderOptions { overlays: Overlays { bounds: true, ..Overlays::default() }, ..options() };
    draw(&mut renderer, &scene, &side, &boxed).save("displacement-bounds");
}

#[test]
fn light_maps_and_normal_maps_stay_on_the_displaced_surface() {
    let Some(mut renderer) = renderer() else { return };
    for which in [Layer::Diffuse, Layer::LightMap, Layer::Normal] {
        let material = Material { diffuse: Vec3::ONE, ambient: Vec3::ZERO, ..Material::default() };
        let mut scene = displaced(quad(), by(4, 0.25, 0.5), grey(255), material);
        // Left half and right half differ.
        let used =
            layer(&mut scene, image8(2, 1, |x, _| if x == 0 { [255, 128, 128, 255] } else { [128, 128, 255, 255] }));
        scene.materials[0].layers[which as usize] = Some(used);
        scene.lights = vec![directional(Vec3::NEG_Z, Vec3::ONE)];
        let flat = draw(&mut renderer, &scene, &front(), &mode(DisplacementMode::Off));
        let drawn = draw(&mut renderer, &scene, &front(), &options());
        assert_eq!(flat.bytes, drawn.bytes, "seen straight on, a plane that came nearer is the same: {which:?}");
        assert_ne!(drawn.at(10, 32), drawn.at(54, 32));
    }
}

#[test]
fn nothing_is_computed_again_while_nothing_changes_and_nothing_for_other_scenes() {
    let Some(mut renderer) = renderer() else { return };
    let plain = scene_of(quad(), glow(Vec3::ONE), vec![dark()]);
    draw(&mut renderer, &plain, &front(), &options());
    let before = renderer.resources();
    assert_eq!((before.displaced_surfaces, before.shaders_built), (0, 1));

    let mut scene = displaced(quad(), by(8, 0.0, 0.2), rough(8), glow(Vec3::ONE));
    let first = draw(&mut renderer, &scene, &front(), &options());
    assert_eq!(first.stats.displaced_points, 81);
    let again = draw(&mut renderer, &scene, &perspective(Vec3::Z * 3.0), &options());
    assert_eq!((again.stats.displaced_points, again.stats.pipelines_built), (0, 0));
    let with = renderer.resources();
    assert_eq!(with.displaced_surfaces, 1);

    // Another matrix of the map: the same points, elsewhere.
    scene.materials[0].layers[3].as_mut().unwrap().transform = glam::Mat3::from_scale(Vec2::splat(2.0));
    assert_eq!(draw(&mut renderer, &scene, &front(), &options()).stats.displaced_points, 81);
    assert_eq!(draw(&mut renderer, &scene, &front(), &options()).stats.displaced_points, 0);
    // Adaptively, only a view that differs changes anything.
    let adaptive = mode(DisplacementMode::ADAPTIVE);
    assert!(draw(&mut renderer, &scene, &front(), &adaptive).stats.displaced_points > 4);
    assert_eq!(draw(&mut renderer, &scene, &front(), &adaptive).stats.displaced_points, 0);
    assert!(draw(&mut renderer, &scene, &perspective(Vec3::Z * 2.0), &adaptive).stats.displaced_points > 4);

    drop(scene);
    draw(&mut renderer, &plain, &front(), &options());
    let after = renderer.resources();
    assert_eq!((after.displaced_surfaces, after.bytes), (0, before.bytes));
}

#[test]
fn mirrored_and_scaled_nodes_show_the_same_surface() {
    let Some(mut renderer) = renderer() else { return };
    let map = image8(64, 64, |x, _| [(127.0 + 120.0 * (0.2 * x as f32).sin()) as u8, 0, 0, 255]);
    let material = Material { diffuse: Vec3::ONE, ambient: Vec3::ZERO, ..Material::default() };
    let mut scene = displaced(quad(), by(32, -0.1, 0.2), map, material);
    scene.lights = vec![directional(Vec3::new(-0.6, 0.0, -0.8), Vec3::ONE)];
    let plain = draw(&mut renderer, &scene, &front(), &options());
    // Mirrored in x together with the light, the picture is mirrored.
    scene.nodes[0].local = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    scene.lights = vec![directional(Vec3::new(0.6, 0.0, -0.8), Vec3::ONE)];
    let mirrored = draw(&mut renderer, &scene, &front(), &options());
    let mut worst = 0;
    for y in 2..62 {
        for x in 2..62 {
            worst = worst.max(plain.at(x, y)[0].abs_diff(mirrored.at(63 - x, y)[0]));
        }
    }
    assert!(worst <= 3, "{worst}");
    // Flattened or of no size, it is drawn or not, without an error.
    for scale in [Vec3::new(1.0, 1.0, 0.0), Vec3::ZERO, Vec3::splat(1e-30), Vec3::splat(1e20)] {
        scene.nodes[0].local = Affine3A::from_scale(scale);
        draw(&mut renderer, &scene, &front(), &options());
        draw(&mut renderer, &scene, &front(), &mode(DisplacementMode::ADAPTIVE));
        draw(&mut renderer, &scene, &front(), &mode(DisplacementMode::Parallax));
    }
}

#[test]
fn transparent_surfaces_are_sorted_where_they_are_displaced_to() {
    let Some(mut renderer) = renderer() else { return };
    // Two quads; displacement takes the far one in front of the near one.
    let mut scene = displaced(quad(), by(2, 1.0, 0.0), grey(0), Material { opacity: 0.5, ..glow(Vec3::X) });
    scene.meshes.push(Arc::new(Mesh { displacement: None, ..quad() }));
    Arc::make_mut(&mut scene.meshes[1]).subsets[0].material = MaterialId(1);
    scene.materials.push(Material { opacity: 0.5, ..glow(Vec3::Y) });
    scene.nodes.push(node(1, at(0.5)));
    let picture = draw(&mut renderer, &scene, &front(), &options());
    assert_near(picture.at(20, 30), [0.5, 0.25, 0.0, 1.0], 2.0);
    let base = draw(&mut renderer, &scene, &front(), &mode(DisplacementMode::Off));
    assert_near(base.at(20, 30), [0.25, 0.5, 0.0, 1.0], 2.0);
}

#[test]
fn r37_too_much_is_refused_with_a_sentence_or_clamped_with_a_warning() {
    let Some(mut renderer) = renderer() else { return };
    let mut mesh = quad();
    mesh.indices = mesh.indices.repeat(20_000);
    finish(&mut mesh);
    let scene = displaced(mesh, by(64, 0.0, 1.0), grey(9), glow(Vec3::ONE));
    let view = View { camera: front(), width: 32, height: 32, frame: 0.0 };
    let refused = renderer.render_to_image(&scene, &view, &options());
    let Err(RenderError::Displacement(error)) = refused else { panic!("{refused:?}") };
    assert!(error.to_string().contains("163840000 triangles"), "{error}");
    // The renderer is still of use.
    let scene = displaced(quad(), by(5000, 0.0, f32::NAN), grey(9), glow(Vec3::ONE));
    let picture = draw(&mut renderer, &scene, &front(), &options());
    assert_eq!(picture.stats.displaced_points, 0, "a scale that is no number moves nothing");
    let scene = displaced(quad(), by(5000, 0.1, f32::NAN), grey(9), glow(Vec3::ONE));
    let picture = draw(&mut renderer, &scene, &front(), &options());
    assert_eq!(picture.stats.triangles, 2 * 1024 * 1024);
    let warnings = picture.stats.warnings.join("\n");
    assert!(warnings.contains("factor of 5000") && warnings.contains("scale of NaN"), "{warnings}");
    assert_color(picture.center(), Vec3::ONE);
}

#[test]
fn maps_wider_than_the_gpu_takes_are_drawn_smaller_with_a_warning() {
    let Some(mut renderer) = renderer() else { return };
    let limit = renderer.gpu().device().limits().max_texture_dimension_2d;
    for width in [limit, 2 * limit + 1] {
        let map = image8(width, 2, |x, _| [if x > width / 2 { 255 } else { 0 }, 0, 0, 255]);
        let scene = displaced(quad(), by(16, 0.0, 0.5), map, glow(Vec3::ONE));
        let picture = draw(&mut renderer, &scene, &front(), &options());
        assert_eq!(picture.stats.warnings.len(), usize::from(width > limit), "{:?}", picture.stats.warnings);
        assert_color(picture.center(), Vec3::ONE);
    }
}

#[test]
fn every_kind_of_map_gives_the_same_surface() {
    let Some(mut renderer) = renderer() else { return };
    let ramp = |x: u32| f32::from((x * 17 % 256) as u8) / 255.0;
    let each = |value: &dyn Fn(f32) -> Pixels| Image { width: 16, height: 1, pixels: value(0.0) };
    let bytes = each(&|_| Pixels::Rgba8((0..16).flat_map(|x| [(255.0 * ramp(x)).round() as u8, 0, 0, 0]).collect()));
    let words =
        each(&|_| Pixels::Rgba16((0..16).flat_map(|x| [(65535.0 * ramp(x)).round() as u16, 0, 0, 0]).collect()));
    let floats = each(&|_| Pixels::RgbF32((0..16).flat_map(|x| [ramp(x), 0.0, 0.0]).collect()));
    let pictures = [bytes, words, floats].map(|map| {
        let mut scene = displaced(quad(), by(24, -0.2, 0.4), map, Material::default());
        scene.lights = vec![point(Vec3::new(1.0, 1.0, 2.0), Vec3::ONE)];
        draw(&mut renderer, &scene, &perspective(Vec3::Z * 1.5), &options()).bytes
    });
    for other in &pictures[1..] {
        let worst = pictures[0].iter().zip(other).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(worst <= Some(1), "{worst:?}");
    }
}

#[test]
fn other_aspects_and_overlays_show_the_displaced_surface() {
    let Some(mut renderer) = renderer() else { return };
    let mut mesh = globe(8);
    mesh.colors = Some(vec![Vec4::ONE; mesh.positions.len()]);
    let scene = displaced(mesh, by(6, -0.2, 0.5), rough(24), Material::default());
    for displacement in [DisplacementMode::Uniform, DisplacementMode::Adaptive { pixel_error: 8.0 }] {
        for show in [Show::Normals, Show::Uvs(Layer::Displacement), Show::Layer(Layer::Displacement)] {
            let shown = RenderOptions { show, msaa: Msaa::X4, ..mode(displacement) };
            let picture = draw_sized(&mut renderer, &scene, &perspective(Vec3::Z * 3.0), &shown, 256, 256);
            picture.save(&format!("displacement-{displacement:?}-{show:?}"));
        }
        let overlays = Overlays { wireframe: true, normals: Some(0.1), bounds: true, shapes: Vec::new() };
        let wired = RenderOptions { overlays, ..mode(displacement) };
        let picture = draw_sized(&mut renderer, &scene, &perspective(Vec3::Z * 3.0), &wired, 256, 256);
        let wire = picture.bytes.chunks_exact(4).filter(|pixel| pixel[0] > 220 && pixel[2] < 90).count();
        assert!(wire > 2000, "{wire} pixels of wire");
        picture.save(&format!("displacement-{displacement:?}-wireframe"));
    }
}

/// Mean difference of two pictures.
fn apart(a: &Picture, b: &Picture) -> f64 {
    let sum: u64 = a.bytes.iter().zip(&b.bytes).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.bytes.len() as f64
}

/// A camera that looks down at the origin at a slant.
fn slanted() -> Camera {
    let position = Vec3::new(0.0, -1.6, 1.5);
    Camera { target: Vec3::new(0.0, 0.1, 0.0), position, up: Vec3::Z, ..perspective(position) }
}

#[test]
fn parallax_of_a_plane_is_where_the_displaced_plane_is() {
    let Some(mut renderer) = renderer() else { return };
    for (bias, scale, value) in [(-0.3, 0.3, 102), (0.1, 0.2, 128), (0.2, -0.4, 200)] {
        let mut scene = displaced(quad(), by(1, bias, scale), grey(value), glow(Vec3::ONE));
        let squares =
            image8(8, 8, |x, y| [if (x + y) % 2 == 0 { 255 } else { 40 }, (x * 30) as u8, (y * 30) as u8, 255]);
        let used = layer(&mut scene, squares);
        scene.materials[0].layers[Layer::Diffuse as usize] = Some(used);
        let camera =
            Camera { target: Vec3::ZERO, position: Vec3::new(0.0, -0.5, 0.7), up: Vec3::Z, ..perspective(Vec3::ZERO) };
        let [base, truth, parallax] = [DisplacementMode::Off, DisplacementMode::Uniform, DisplacementMode::Parallax]
            .map(|displacement| draw_sized(&mut renderer, &scene, &camera, &mode(displacement), 128, 128));
        // In the middle of the picture both planes are seen.
        let worst = (40..88)
            .flat_map(|y| (40..88).map(move |x| (x, y)))
            .filter(|&(x, y)| truth.at(x, y).iter().zip(parallax.at(x, y)).any(|(a, b)| a.abs_diff(b) > 24));
        let share = worst.count() as f64 / (48.0 * 48.0);
        assert!(share < 0.01, "{share} of the pixels for {bias}, {scale}, {value}");
        assert!(apart(&base, &truth) > 4.0 * apart(&parallax, &truth).min(1.0), "the base mesh is somewhere else");
    }
}

#[test]
fn parallax_shows_bumps_nearer_to_geometry_than_the_base_mesh_does() {
    let Some(mut renderer) = renderer() else { return };
    let map = image8(64, 64, |x, y| {
        let wave = (0.4 * x as f32).sin() * (0.4 * y as f32).cos();
        [(127.0 + 120.0 * wave) as u8, 0, 0, 255]
    });
    let material = Material { diffuse: Vec3::ONE, ambient: Vec3::ZERO, ..Material::default() };
    for (bias, local) in [(-0.1, Affine3A::IDENTITY), (-0.05, Affine3A::from_scale(Vec3::new(-1.2, 1.2, 1.2)))] {
        let mut scene = displaced(quad(), by(64, bias, 0.1), map.clone(), material.clone());
        scene.lights = vec![directional(Vec3::new(-0.7, 0.2, -0.7), Vec3::ONE)];
        scene.nodes[0].local = local;
        let [base, truth, parallax] = [DisplacementMode::Off, DisplacementMode::Uniform, DisplacementMode::Parallax]
            .map(|displacement| draw_sized(&mut renderer, &scene, &slanted(), &mode(displacement), 256, 256));
        let (without, with) = (apart(&base, &truth), apart(&parallax, &truth));
        println!("off {without}, parallax {with}");
        assert!(with < 0.3 * without, "{with} of {without}");
        assert_eq!((parallax.stats.triangles, parallax.stats.displaced_points), (2, 0));
        truth.save("parallax-truth");
        parallax.save("parallax");
    }
}

#[test]
fn parallax_of_what_should_not_be_is_drawn_without_an_error() {
    let Some(mut renderer) = renderer() else { return };
    for value in [f32::NAN, f32::INFINITY, 1e30, -1e-30, 0.0] {
        let mut mesh = globe(6);
        mesh.uvs[3].as_mut().unwrap().fill(Vec2::splat(value));
        let mut scene = displaced(mesh, by(4, value, 0.1), rough(8), Material::default());
        scene.lights = vec![point(Vec3::new(2.0, 2.0, 2.0), Vec3::ONE)];
        draw(&mut renderer, &scene, &front(), &mode(DisplacementMode::Parallax));
        let scene = displaced(quad(), by(4, 0.1, value), rough(8), glow(Vec3::ONE));
        let picture = draw(&mut renderer, &scene, &front(), &mode(DisplacementMode::Parallax));
        assert_color(picture.center(), Vec3::ONE);
    }
}
