//! Light from all around: digest requirements 23–29, 32 and 44.

use std::sync::Arc;

use aam_renderer::{DiffuseLight, EnvironmentDetail, RenderOptions, Renderer};
use aam_scene::*;
use glam::{Affine3A, Quat, Vec2, Vec3};

use crate::common::*;

fn floats(width: u32, height: u32, value: impl Fn(u32, u32) -> Vec3) -> Image {
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    Image { width, height, pixels: Pixels::RgbF32(places.flat_map(|(x, y)| value(x, y).to_array()).collect()) }
}

fn constant(light: Vec3) -> Environment {
    Environment::new(Arc::new(EnvironmentMap::panorama(floats(8, 4, |_, _| light)).unwrap()))
}

fn panorama(light: impl Fn(Vec3) -> Vec3) -> Environment {
    let at = |x: u32, y: u32| panorama_direction((Vec2::new(x as f32, y as f32) + 0.5) / Vec2::new(128.0, 64.0));
    Environment::new(Arc::new(EnvironmentMap::panorama(floats(128, 64, |x, y| light(at(x, y)))).unwrap()))
}

/// Six plain faces: red grows to the right, green upwards, blue to the front.
fn labelled() -> Environment {
    let color = |face| match face {
        CubeFace::Right => Vec3::new(1.0, 0.5, 0.5),
        CubeFace::Left => Vec3::new(0.0, 0.5, 0.5),
        CubeFace::Up => Vec3::new(0.5, 1.0, 0.5),
        CubeFace::Down => Vec3::new(0.5, 0.0, 0.5),
        CubeFace::Front => Vec3::new(0.5, 0.5, 1.0),
        CubeFace::Back => Vec3::new(0.5, 0.5, 0.0),
    };
    // The left half of each is darker, and the top row black.
    let face =
        |face| floats(64, 64, move |x, y| color(face) * if y < 8 { 0.0 } else { 1.0 } * if x < 32 { 0.5 } else { 1.0 });
    Environment::new(Arc::new(EnvironmentMap::cube(CubeFace::ALL.map(face)).unwrap()))
}

fn lit_by(mesh: Mesh, material: Material, environment: Environment) -> Scene {
    Scene { environment: Some(environment), up: Up::Y, ..scene_of(mesh, material, vec![]) }
}

fn mirror(specular: Vec3) -> Material {
    Material { specular, exponent: 50.0, ..black() }
}

fn sky_of(environment: Environment) -> Scene {
    Scene { environment: Some(environment), up: Up::Y, background: Background::Environment, ..Scene::default() }
}

/// The scene's own background.
fn own() -> RenderOptions {
    RenderOptions { background: None, ..options() }
}

/// Looks along a direction from a place, a right angle wide.
fn looking(position: Vec3, direction: Vec3) -> Camera {
    Camera { target: position + direction, ..perspective(position) }
}

#[test]
fn r23_constant_environments_light_all_normals_alike() {
    let Some(mut renderer) = renderer() else { return };
    let light = Vec3::new(0.5, 0.25, 1.5);
    let material = Material {
        emission: Vec3::new(0.1, 0.0, 0.05),
        ambient: Vec3::ONE,
        diffuse: Vec3::new(0.4, 0.6, 0.1),
        specular: Vec3::new(0.2, 0.4, 0.3),
        exponent: 12.0,
        ..Material::default()
    };
    let expected = material.emission + (material.diffuse + material.specular) * light;
    let mut scene = lit_by(sphere(24), material, constant(light));
    // Lights and the ambient term have no effect.
    scene.lights = vec![Light { ambient: Vec3::ONE, ..point(Vec3::new(0.0, 0.0, 9.0), Vec3::splat(7.0)) }];
    for filter in [SpecularFilter::Mirror, SpecularFilter::Phong] {
        scene.environment.as_mut().unwrap().filter = Some(filter);
        for bands in [None, Some(2), Some(3), Some(5)] {
            let detail = bands.map_or_else(EnvironmentDetail::default, |bands| EnvironmentDetail {
                diffuse: DiffuseLight::Harmonics(bands),
                ..EnvironmentDetail::default()
            });
            let options = RenderOptions { environment: detail, ..options() };
            let picture = draw(&mut renderer, &scene, &front(), &options);
            for (x, y) in [(32, 32), (12, 30), (50, 40), (32, 4), (20, 55)] {
                assert_color(picture.at(x, y), expected);
            }
            assert_eq!((picture.stats.lights, picture.stats.camera_light), (0, false));
        }
    }
}

#[test]
fn r24_modes_switch_terms_without_new_meshes_or_materials() {
    let Some(mut renderer) = renderer() else { return };
    let material = Material { diffuse: Vec3::splat(0.5), specular: Vec3::splat(0.25), exponent: 8.0, ..black() };
    let mut scene = lit_by(quad(), material, constant(Vec3::new(0.4, 0.8, 1.2)));
    scene.lights = vec![directional(Vec3::NEG_Z, Vec3::new(1.0, 0.0, 0.0))];
    let light = Vec3::new(0.4, 0.8, 1.2);
    let direct = Vec3::new(0.75, 0.0, 0.0);
    for (diffuse, specular, expected) in
        [(true, true, 0.75 * light), (true, false, 0.5 * light), (false, true, 0.25 * light), (false, false, direct)]
    {
        let environment = scene.environment.as_mut().unwrap();
        (environment.diffuse, environment.specular) = (diffuse, specular);
        // Twice, so that what each mode needs is there.
        for _ in 0..2 {
            assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), expected);
        }
        let again = draw(&mut renderer, &scene, &front(), &options());
        assert_eq!((again.stats.bytes_uploaded, again.stats.pipelines_built), (0, 0));
        assert_eq!(renderer.resources().meshes, 1);
    }
}

#[test]
fn only_what_the_scene_uses_is_made() {
    let Some(mut renderer) = renderer() else { return };
    let diffuse_only = Material { diffuse: Vec3::ONE, ..black() };
    let mut scene = lit_by(quad(), diffuse_only, Environment { specular: false, ..constant(Vec3::ONE) });
    draw(&mut renderer, &scene, &front(), &options());
    assert_eq!(renderer.resources().environment_bytes, 6 * 16 * 16 * 8);
    // An environment that only is there costs nothing, and neither does one that lights nothing.
    for change in [
        |scene: &mut Scene| scene.environment.as_mut().unwrap().diffuse = false,
        |scene: &mut Scene| scene.materials[0] = glow(Vec3::ONE),
    ] {
        change(&mut scene);
        let mut fresh = Renderer::new(renderer.gpu().clone());
        draw(&mut fresh, &scene, &front(), &options());
        assert_eq!(fresh.resources().environment_bytes, 0);
        scene.environment.as_mut().unwrap().diffuse = true;
    }
    // It goes with its map.
    scene.environment = None;
    draw(&mut renderer, &scene, &front(), &options());
    draw(&mut renderer, &scene, &front(), &options());
    assert_eq!(renderer.resources().environment_bytes, 0);
}

#[test]
fn r25_a_mirror_sphere_does_not_depend_on_how_its_size_is_said() {
    let Some(mut renderer) = renderer() else { return };
    let sky = || panorama(|d| Vec3::new(0.5 + 0.5 * d.x, 0.5 + 0.5 * d.y, 0.5 + 0.5 * d.z));
    let mut scaled = lit_by(sphere(32), mirror(Vec3::ONE), sky());
    scaled.nodes[0].local = Affine3A::from_scale(Vec3::splat(0.8));
    let mut mesh = sphere(32);
    mesh.positions.iter_mut().for_each(|position| *position *= 0.8);
    mesh.normals.iter_mut().for_each(|normal| *normal *= 3.0);
    mesh.bounds = Aabb::of(mesh.positions.iter().copied());
    let modelled = lit_by(mesh, mirror(Vec3::ONE), sky());
    let one = draw(&mut renderer, &scaled, &front(), &options()).save("environment-mirror-sphere");
    let other = draw(&mut renderer, &modelled, &front(), &options());
    assert!(one.bytes.iter().zip(&other.bytes).all(|(a, b)| a.abs_diff(*b) <= 1));
    // Where the sphere is seen at 45° it shows what is above.
    assert_near(one.at(32, 32 - (0.8 * 32.0 * 0.5_f32.sqrt()) as u32), [0.5, 1.0, 0.5, 1.0], 12.0);
}

#[test]
fn r26_mirrors_and_sky_box_agree_on_directions_and_are_not_mirrored() {
    let Some(mut renderer) = renderer() else { return };
    let sky = sky_of(labelled());
    let faces = [
        (Vec3::NEG_Z, Vec3::new(0.5, 0.5, 1.0)),
        (Vec3::Z, Vec3::new(0.5, 0.5, 0.0)),
        (Vec3::X, Vec3::new(1.0, 0.5, 0.5)),
        (Vec3::NEG_X, Vec3::new(0.0, 0.5, 0.5)),
        (Vec3::Y, Vec3::new(0.5, 1.0, 0.5)),
        (Vec3::NEG_Y, Vec3::new(0.5, 0.0, 0.5)),
    ];
    for (direction, color) in faces {
        // Facing the front, and tilting the head from there.
        let up = match direction.y {
            y if y > 0.0 => Vec3::Z,
            y if y < 0.0 => Vec3::NEG_Z,
            _ => Vec3::Y,
        };
        let camera = Camera { up, ..looking(Vec3::ZERO, direction) };
        let picture = draw(&mut renderer, &sky, &camera, &own());
        assert_color(picture.at(20, 40), 0.5 * color);
        assert_color(picture.at(44, 40), color);
        assert_color(picture.at(40, 3), Vec3::ZERO);
    }
    // A mirror that faces the camera shows the face behind it, the right half of which is to the left of who looks at the
    // mirror.
    let scene = lit_by(quad(), mirror(Vec3::ONE), labelled());
    for filter in [SpecularFilter::Mirror, SpecularFilter::Phong] {
        let sharp = Material { exponent: 1e6, ..mirror(Vec3::ONE) };
        let mut scene = Scene { materials: vec![sharp], ..scene.clone() };
        scene.environment.as_mut().unwrap().filter = Some(filter);
        let near = looking(Vec3::new(0.0, 0.0, 0.9), Vec3::NEG_Z);
        let picture = draw(&mut renderer, &scene, &near, &options());
        let back = Vec3::new(0.5, 0.5, 0.0);
        assert_color(picture.at(20, 40), back);
        assert_color(picture.at(44, 40), 0.5 * back);
        assert_color(picture.at(40, 2), Vec3::ZERO);
    }
}

#[test]
fn with_z_up_the_front_is_where_the_view_from_the_front_looks() {
    let Some(mut renderer) = renderer() else { return };
    let sky = Scene { up: Up::Z, ..sky_of(labelled()) };
    let camera = Camera { up: Vec3::Z, ..looking(Vec3::ZERO, Vec3::Y) };
    assert_color(draw(&mut renderer, &sky, &camera, &own()).at(44, 40), Vec3::new(0.5, 0.5, 1.0));
    // Turned a quarter counter-clockwise, what was in front is to the left.
    let mut turned = sky.clone();
    turned.environment.as_mut().unwrap().rotation = std::f32::consts::FRAC_PI_2;
    let camera = Camera { up: Vec3::Z, ..looking(Vec3::ZERO, Vec3::NEG_X) };
    assert_color(draw(&mut renderer, &turned, &camera, &own()).at(44, 40), Vec3::new(0.5, 0.5, 1.0));
}

#[test]
fn diffuse_light_follows_the_cosine_exactly() {
    let Some(mut renderer) = renderer() else { return };
    // Light 0.5 + 0.5 y: its mean over the cosine about N is 0.5 + N.y / 3.
    let sky = panorama(|d| Vec3::splat(0.5 + 0.5 * d.y));
    let mut scene = lit_by(quad(), Material { diffuse: Vec3::ONE, ..black() }, sky);
    for degrees in [-80.0_f32, -45.0, 0.0, 30.0, 60.0, 85.0] {
        scene.nodes[0].local = Affine3A::from_quat(Quat::from_rotation_x(-degrees.to_radians()));
        let expected = 0.5 + degrees.to_radians().sin() / 3.0;
        assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), Vec3::splat(expected));
    }
}

#[test]
fn wider_lobes_reflect_softer() {
    let Some(mut renderer) = renderer() else { return };
    // The upper half shines: a lobe of exponent n about a level axis sees half of it; about an axis 20° up its mean is
    // between that and all.
    let sky = panorama(|d| Vec3::splat(if d.y > 0.0 { 0.9 } else { 0.0 }));
    let mut scene = lit_by(quad(), mirror(Vec3::ONE), Environment { filter: Some(SpecularFilter::Phong), ..sky });
    scene.nodes[0].local = Affine3A::from_quat(Quat::from_rotation_x(-10.0_f32.to_radians()));
    let mut before = 230;
    for exponent in [1e4, 200.0, 50.0, 12.0, 4.0] {
        scene.materials[0].exponent = exponent;
        let found = draw(&mut renderer, &scene, &front(), &options()).center()[0];
        assert!(found <= before && found > 115, "n = {exponent}: {found} after {before}");
        before = found;
    }
    assert!(before < 190);
    // The source's filter does not look at the exponent.
    scene.environment.as_mut().unwrap().filter = Some(SpecularFilter::Mirror);
    assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), Vec3::splat(0.9));
    // And a surface without exponent reflects nothing, as it has no highlight.
    scene.materials[0].exponent = 0.0;
    assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), Vec3::ZERO);
}

#[test]
fn r28_r29_light_is_computed_before_it_is_exposed_and_cut() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene =
        lit_by(quad(), Material { diffuse: Vec3::new(0.1, 0.2, 0.5), ..black() }, constant(Vec3::splat(4.0)));
    let light = Vec3::new(0.4, 0.8, 2.0);
    let mut shown = |scene: &Scene| draw(&mut renderer, scene, &front(), &options()).center();
    assert_color(shown(&scene), light);
    scene.exposure = -1.0;
    assert_color(shown(&scene), 0.5 * light);
    scene.environment.as_mut().unwrap().intensity = 0.5;
    assert_color(shown(&scene), 0.25 * light);
    scene.environment.as_mut().unwrap().intensity = 1.0;
    scene.exposure = 0.0;
    scene.tone_map = ToneMap::Reinhard;
    assert_color(shown(&scene), light / (1.0 + light));
    for tone_map in [ToneMap::Aces, ToneMap::Neutral] {
        scene.tone_map = tone_map;
        let [r, g, b, _] = shown(&scene);
        assert!(r < g && g < b && b < 255 && r > 20, "{tone_map:?}: {r} {g} {b}");
    }
    // Light-mapped and plain surfaces are exposed too; a background colour is not light.
    let mut lamp = scene_of(quad(), glow(Vec3::splat(0.25)), vec![]);
    lamp.exposure = 1.0;
    assert_color(shown(&lamp), Vec3::splat(0.5));
    lamp.background = Background::Color(Vec3::splat(0.25));
    lamp.nodes.clear();
    assert_color(draw(&mut renderer, &lamp, &front(), &own()).center(), Vec3::splat(0.25));
}

#[test]
fn r32_normal_maps_work_with_environments() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = lit_by(quad(), Material { diffuse: Vec3::ONE, ..black() }, labelled());
    let used = layer(&mut scene, image8(1, 1, |_, _| [255, 128, 128, 255]));
    scene.materials[0].layers[Layer::Normal as usize] = Some(used);
    let bumped = draw(&mut renderer, &scene, &front(), &options()).center();
    scene.materials[0].layers[Layer::Normal as usize] = None;
    scene.nodes[0].local = Affine3A::from_quat(Quat::from_rotation_y(1.5));
    let turned = draw(&mut renderer, &scene, &front(), &options()).center();
    assert!(bumped[0] > 130 && bumped[0] > bumped[1] + 30, "the right face lights it: {bumped:?}");
    assert!(bumped.iter().zip(turned).all(|(a, b)| a.abs_diff(b) < 12), "{bumped:?} {turned:?}");
}

#[test]
fn r21_light_maps_stay_what_they_are() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = lit_by(quad(), Material { diffuse: Vec3::ONE, ..black() }, constant(Vec3::splat(9.0)));
    let used = layer(&mut scene, image8(1, 1, |_, _| [51, 102, 153, 255]));
    scene.materials[0].layers[Layer::LightMap as usize] = Some(used);
    assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), Vec3::new(0.2, 0.4, 0.6));
}

#[test]
fn r44_the_sky_box_turns_with_the_camera_does_not_move_and_hides_nothing() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = sky_of(labelled());
    let here = draw(&mut renderer, &scene, &looking(Vec3::ZERO, Vec3::new(0.3, 0.1, -1.0)), &own());
    let there = looking(Vec3::new(1024.0, -256.0, 8.0), Vec3::new(0.3, 0.1, -1.0));
    let moved = draw(&mut renderer, &scene, &there, &own());
    // Target minus position loses bits so far out: pixels at the edges of faces may differ.
    assert!(here.bytes.iter().zip(&moved.bytes).filter(|(a, b)| a.abs_diff(**b) > 2).count() < 400);
    let turned = draw(&mut renderer, &scene, &looking(Vec3::ZERO, Vec3::new(1.0, 0.1, 0.3)), &own());
    assert_ne!(here.bytes, turned.bytes);
    // However far away: the sky wrote no depth.
    let far = scene_of(sphere(12), glow(Vec3::ONE), vec![]);
    scene = Scene { nodes: far.nodes, meshes: far.meshes, materials: far.materials, ..scene };
    scene.nodes[0].local =
        Affine3A::from_scale_rotation_translation(Vec3::splat(4e4), Quat::IDENTITY, Vec3::new(0.0, 0.0, -9.9e4));
    scene.environment.as_mut().unwrap().diffuse = false;
    let camera = Camera { far: 1e6, ..looking(Vec3::ZERO, Vec3::NEG_Z) };
    assert_color(draw(&mut renderer, &scene, &camera, &own()).center(), Vec3::ONE);
    // Without an environment there is the default colour.
    scene = Scene { environment: None, nodes: vec![], ..scene };
    let expected = draw(&mut renderer, &Scene::default(), &front(), &own()).center();
    assert_eq!(draw(&mut renderer, &scene, &front(), &own()).center(), expected);
}

#[test]
fn in_linear_light_encoded_pictures_are_decoded_and_the_sky_comes_out_as_it_is() {
    let Some(mut renderer) = renderer() else { return };
    let grey = Image { width: 4, height: 2, pixels: Pixels::Rgba8([188, 100, 20, 255].repeat(8)) };
    let mut sky = sky_of(Environment::new(Arc::new(EnvironmentMap::of_picture(grey).unwrap())));
    let camera = looking(Vec3::ZERO, Vec3::NEG_Z);
    for shading in [Shading::Source, Shading::Linear] {
        sky.shading = shading;
        let found = draw(&mut renderer, &sky, &camera, &own()).center();
        assert_near(found, [188.0, 100.0, 20.0, 255.0].map(|c| c / 255.0), 1.0);
    }
    let white = Material { diffuse: Vec3::ONE, ..black() };
    let lit = Scene { shading: Shading::Linear, ..lit_by(quad(), white, sky.environment.unwrap()) };
    assert_near(
        draw(&mut renderer, &lit, &front(), &options()).center(),
        [188.0, 100.0, 20.0, 255.0].map(|c| c / 255.0),
        1.0,
    );
}

#[test]
fn hostile_numbers_give_pictures() {
    let Some(mut renderer) = renderer() else { return };
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e38, -1.0];
    let broken = floats(8, 4, |x, y| Vec3::new(odd[(x % 5) as usize], odd[(y % 5) as usize], 0.5));
    let map = Arc::new(EnvironmentMap::panorama(broken).unwrap());
    let material = Material { diffuse: Vec3::ONE, specular: Vec3::ONE, ..black() };
    for (number, value) in odd.into_iter().enumerate() {
        let environment = Environment { intensity: value, rotation: value, ..Environment::new(Arc::clone(&map)) };
        let mut scene = lit_by(sphere(8), Material { exponent: value.abs(), ..material.clone() }, environment);
        scene.background = Background::Environment;
        scene.exposure = value;
        scene.tone_map = [ToneMap::Clamp, ToneMap::Reinhard, ToneMap::Aces, ToneMap::Neutral][number % 4];
        for shading in [Shading::Source, Shading::Linear] {
            let options = RenderOptions { shading: Some(shading), ..own() };
            let picture = draw(&mut renderer, &scene, &perspective(Vec3::new(0.0, 0.0, 3.0)), &options);
            assert!(picture.bytes.chunks(4).all(|pixel| pixel[3] == 255), "{value} {shading:?}");
        }
    }
}
