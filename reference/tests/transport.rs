//! Light from surfaces and from lights with a size, against irradiances in closed form.

mod common;

use std::f32::consts::PI;
use std::sync::Arc;

use aam_reference::{Error, LightSize, Options, radiance, render};
use aam_scene::{Falloff, LightKind, LightShape, Material, MaterialId, Mesh, Scene, Shading};
use common::*;
use glam::{Affine3A, Vec2, Vec3, Vec4};

/// A reflectance as it stands in a material: encoded.
fn encoded(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

fn reflecting(linear: Vec3) -> Material {
    Material { diffuse: Vec3::from_array(linear.to_array().map(encoded)), ..chalk() }
}

fn dark() -> LightKind {
    LightKind::Directional { direction: Vec3::ZERO }
}

/// The middle pixel of a picture of the square −1..1 from straight above, so many bounces on.
fn middle(scene: &Scene, bounces: u32, environment: f32, samples: u32) -> Vec4 {
    let options = Options {
        samples_per_pixel: samples,
        bounces,
        shadows: Some(LightSize::Area),
        environment: Vec3::splat(environment),
        shading: Some(Shading::Linear),
        ..Options::default()
    };
    let mut view = from_above(1);
    view.camera.projection = aam_scene::Projection::Orthographic { height: 0.02 };
    // Below whatever hangs above the square.
    view.camera.position.z = 0.2;
    view.camera.near = 0.01;
    radiance(scene, &view, &options).unwrap().0.pixels[0]
}

/// The floor, which reflects, and a mesh above it, which shines.
fn lamp_above(lamp: Mesh, local: Affine3A) -> Scene {
    let mut scene = scene(vec![quad(0.0), lamp], reflecting(Vec3::splat(0.5)), dark());
    scene.materials.push(glowing(1.0, 1.0, 1.0));
    Arc::make_mut(&mut scene.meshes[1]).subsets[0].material = MaterialId(1);
    scene.nodes[1].local = local;
    scene
}

#[test]
fn a_shining_rectangle_lights_by_its_form_factor() {
    // Half sides a and b at height h, parallel to the floor (Howell, configuration B-3, four times).
    for (a, b, h) in [(1.0_f32, 0.5, 1.0), (0.2, 0.2, 2.0), (3.0, 0.4, 0.5)] {
        let local = Affine3A::from_translation(Vec3::Z * h) * Affine3A::from_scale(Vec3::new(a, b, 1.0));
        let (x, y) = (a / h, b / h);
        let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
        let factor = 2.0 / PI * (x / p * (y / p).atan() + y / q * (x / q).atan());
        let found = middle(&lamp_above(quad(0.0), local), 1, 0.0, 4096).x;
        assert!((found - 0.5 * factor).abs() < 0.003, "{a} {b} {h}: {found} {}", 0.5 * factor);
    }
}

#[test]
fn a_shining_disc_lights_by_its_form_factor() {
    let corners: Vec<Vec3> = (0..256).map(|i| Vec2::from_angle(PI * i as f32 / 128.0).extend(0.0)).collect();
    let fan = (1..255).flat_map(|i| [0, i, i + 1]).collect();
    let disc = mesh(corners, vec![Vec3::Z; 256], vec![Vec2::ZERO; 256], fan);
    for (radius, h) in [(1.0_f32, 1.0_f32), (0.3, 1.0), (0.5, 0.4)] {
        let local = Affine3A::from_translation(Vec3::Z * h) * Affine3A::from_scale(Vec3::new(radius, radius, 1.0));
        let factor = radius * radius / (radius * radius + h * h);
        let found = middle(&lamp_above(disc.clone(), local), 1, 0.0, 4096).x;
        assert!((found - 0.5 * factor).abs() < 0.003, "{radius} {h}: {found} {}", 0.5 * factor);
    }
}

#[test]
fn a_shining_sphere_lights_by_inverse_square_and_cosine() {
    for (position, radius) in
        [(Vec3::new(0.0, 0.0, 1.0), 0.4_f32), (Vec3::new(0.0, 0.0, 2.0), 0.4), (Vec3::new(1.0, 1.0, 1.5), 0.5)]
    {
        let local = Affine3A::from_translation(position) * Affine3A::from_scale(Vec3::splat(radius));
        let distance = position.length();
        let factor = (radius / distance).powi(2) * position.z / distance;
        let found = middle(&lamp_above(sphere(64), local), 1, 0.0, 4096).x;
        assert!((found - 0.5 * factor).abs() < 0.0025, "{position} {radius}: {found} {}", 0.5 * factor);
    }
}

/// The floor under a light with a size whose strength falls with the inverse square.
fn lit(position: Vec3, shape: LightShape, direction: Option<Vec3>) -> f32 {
    let falloff = Falloff::InverseSquare;
    let kind = match direction {
        Some(direction) => LightKind::Spot { position, direction, inner: 1.5, outer: 1.55, falloff },
        None => LightKind::Point { position, falloff },
    };
    let mut scene = scene(vec![quad(0.0)], chalk(), kind);
    scene.lights[0].shape = Some(shape);
    middle(&scene, 0, 0.0, 256).x
}

#[test]
fn flat_lights_give_the_solid_angle_over_their_area() {
    // Each point shines to all sides, so that the mean of cos θ / d² is the solid angle over the area.
    for h in [0.5_f32, 2.0] {
        let above = Vec3::new(0.0, 0.0, h);
        let (a, b) = (0.8_f32, 0.3_f32);
        let angle = 4.0 * (a * b / ((a * a + h * h) * (b * b + h * h)).sqrt()).asin();
        let found = lit(above, LightShape::Rectangle { width: 2.0 * a, height: 2.0 * b }, Some(Vec3::NEG_Z));
        let expected = angle / (4.0 * a * b);
        assert!((found / expected - 1.0).abs() < 2e-3, "{h}: {found} {expected}");
        let radius = 0.7_f32;
        let angle = 2.0 * PI * (1.0 - h / (h * h + radius * radius).sqrt());
        let found = lit(above, LightShape::Disc { radius }, Some(Vec3::NEG_Z));
        let expected = angle / (PI * radius * radius);
        assert!((found / expected - 1.0).abs() < 2e-3, "{h}: {found} {expected}");
    }
}

#[test]
fn a_sphere_of_light_gives_what_its_middle_would() {
    // A Lambertian sphere all above the horizon: the irradiance is that of a point, whatever its radius.
    for position in [Vec3::new(0.0, 0.0, 1.0), Vec3::new(0.0, 0.0, 2.0), Vec3::new(2.0, -1.0, 1.5)] {
        let expected = position.z / position.length().powi(3);
        for radius in [0.01, 0.3, 0.9] {
            let found = lit(position, LightShape::Sphere { radius }, None);
            assert!((found / expected - 1.0).abs() < 2e-3, "{position} {radius}: {found} {expected}");
        }
    }
}

/// A closed box around the origin, of a material that shines as much as 1.
fn furnace(reflectance: Vec3) -> Scene {
    let sides = [
        Affine3A::from_translation(Vec3::NEG_Z),
        Affine3A::from_translation(Vec3::Z),
        Affine3A::from_rotation_x(0.5 * PI) * Affine3A::from_translation(Vec3::NEG_Z),
        Affine3A::from_rotation_x(0.5 * PI) * Affine3A::from_translation(Vec3::Z),
        Affine3A::from_rotation_y(0.5 * PI) * Affine3A::from_translation(Vec3::NEG_Z),
        Affine3A::from_rotation_y(0.5 * PI) * Affine3A::from_translation(Vec3::Z),
    ];
    let material = Material { emission: Vec3::ONE, ..reflecting(reflectance) };
    let mut scene = scene(vec![quad(0.0)], material, dark());
    scene.nodes = sides.into_iter().map(|local| node(0, local)).collect();
    scene
}

#[test]
fn the_white_furnace_sums_the_powers_of_the_reflectance() {
    let reflectance = Vec3::new(0.2, 0.5, 0.8);
    let scene = furnace(reflectance);
    for bounces in [0, 1, 2, 5] {
        let expected = |r: f32| (0..=bounces).map(|power| r.powi(power as i32)).sum::<f32>();
        let found = middle(&scene, bounces, 0.0, 1024);
        for channel in 0..3 {
            let expected = expected(reflectance[channel]);
            // Until chance ends paths every one carries the same.
            let bound = if bounces <= 4 { 1e-4 } else { 0.02 };
            assert!((found[channel] / expected - 1.0).abs() < bound, "{bounces} bounces: {found} {expected}");
        }
    }
    let found = middle(&scene, 1024, 0.0, 4096);
    for channel in 0..3 {
        let expected = 1.0 / (1.0 - reflectance[channel]);
        assert!((found[channel] / expected - 1.0).abs() < 0.03, "{found} {expected}");
    }
}

#[test]
fn a_surface_in_a_uniform_environment_gives_its_reflectance_back() {
    let open = |material: Material| middle(&scene(vec![quad(0.0)], material, dark()), 1, 1.0, 1024);
    let found = open(reflecting(Vec3::new(0.25, 0.5, 1.0)));
    assert!(found.truncate().abs_diff_eq(Vec3::new(0.25, 0.5, 1.0), 1e-5), "{found}");
    // Seen at right angles the normalised highlight gives back all of S, whatever the exponent.
    for exponent in [1.0, 20.0, 1000.0] {
        let material = Material { specular: Vec3::splat(encoded(0.6)), exponent, ..glowing(0.0, 0.0, 0.0) };
        let found = open(material).x;
        assert!((found - 0.6).abs() < 0.005, "{exponent}: {found}");
    }
    // What would give back twice what it gets gives back all of it.
    let greedy = open(Material { specular: Vec3::ONE, exponent: 10.0, ..reflecting(Vec3::ONE) }).x;
    assert!((greedy - 1.0).abs() < 0.02, "{greedy}");
}

#[test]
fn bounced_light_takes_the_place_of_ambient_light() {
    let mut scene = scene(vec![quad(0.0)], Material { ambient: Vec3::ONE, ..chalk() }, straight_down());
    scene.lights[0].ambient = Vec3::splat(0.3);
    scene.lights[0].diffuse = Vec3::splat(0.5);
    assert!((middle(&scene, 0, 0.0, 16).x - 0.8).abs() < 1e-5);
    assert!((middle(&scene, 1, 0.0, 16).x - 0.5).abs() < 1e-5);
}

#[test]
fn light_that_lights_give_bounces_too() {
    // A floor lit from straight above gives D to a ceiling turned away from the light, which gives that back by its
    // share; the ceiling is so wide that the floor's small middle sees nothing else.
    let mut scene = scene(vec![quad(0.0), quad(0.5)], reflecting(Vec3::splat(0.5)), point_light(0.0, 0.0, 0.25));
    for node in &mut scene.nodes {
        node.local = Affine3A::from_scale(Vec3::new(400.0, 400.0, 1.0));
    }
    // Both planes get the light's cosine, which at the sides tends to 0; their radiance is 0.5 cos θ. Seen from right
    // below the light, a ceiling point at angle β is lit under the angle β' with tan β' = tan β · 0.5/0.25.
    let direct = middle(&scene, 0, 0.0, 16).x;
    assert!((direct - 0.5).abs() < 1e-3, "{direct}");
    let steps = 200_000;
    let gathered: f64 = (0..steps)
        .map(|i| {
            // Equal shares of cos β sin β dβ.
            let sine_squared = (f64::from(i) + 0.5) / f64::from(steps);
            let tangent = 2.0 * (sine_squared / (1.0 - sine_squared)).sqrt();
            0.5 / (1.0 + tangent * tangent).sqrt() / f64::from(steps)
        })
        .sum();
    let expected = 0.5 + 0.5 * gathered as f32;
    let once = middle(&scene, 1, 0.0, 4096).x;
    assert!((once - expected).abs() < 0.003, "{once} {expected}");
}

#[test]
fn light_passes_transparent_surfaces_by_their_share() {
    // A pane that lets three quarters through, between the floor and the environment.
    let mut scene = scene(vec![quad(0.0), quad(0.3)], reflecting(Vec3::splat(0.8)), dark());
    scene.materials.push(Material { opacity: 0.25, diffuse: Vec3::ZERO, ..chalk() });
    Arc::make_mut(&mut scene.meshes[1]).subsets[0].material = MaterialId(1);
    scene.nodes[1].local = Affine3A::from_scale(Vec3::new(1000.0, 1000.0, 1.0));
    let found = middle(&scene, 1, 1.0, 1024).x;
    assert!((found - 0.6).abs() < 0.01, "{found}");
}

#[test]
fn a_path_ends_where_a_light_map_says_what_a_surface_gives() {
    let mut scene = furnace(Vec3::splat(0.5));
    put_texture(&mut scene, aam_scene::Layer::LightMap, image(1, 1, |_, _| [255, 255, 255, 255]));
    for bounces in [0, 1, 7] {
        let found = middle(&scene, bounces, 0.0, 16).x;
        assert!((found - 1.5).abs() < 1e-4, "{bounces} bounces: {found}");
    }
}

#[test]
fn the_stated_error_is_not_below_the_true_one() {
    let local = Affine3A::from_translation(Vec3::Z) * Affine3A::from_scale(Vec3::new(0.4, 0.4, 1.0));
    let scene = lamp_above(quad(0.0), local);
    let mut view = from_above(24);
    view.camera.projection = aam_scene::Projection::Orthographic { height: 0.001 };
    view.camera.position.z = 0.5;
    let options = Options { samples_per_pixel: 64, bounces: 1, shading: Some(Shading::Linear), ..Options::default() };
    let (found, _) = radiance(&scene, &view, &options).unwrap();
    let (p, y) = (1.16_f32.sqrt(), 0.4_f32);
    let exact = 0.5 * 4.0 / PI * (y / p * (y / p).atan());
    let count = found.pixels.len() as f32;
    let error = (found.pixels.iter().map(|pixel| (pixel.x - exact).powi(2)).sum::<f32>() / count).sqrt();
    let stated = (found.standard_error.iter().map(|error| error * error).sum::<f32>() / count).sqrt();
    assert!(error < stated && error > 0.2 * stated, "{error} {stated}");
}

#[test]
fn options_out_of_range_are_refused() {
    let scene = furnace(Vec3::ONE);
    let refused = |options: Options<'_>| render(&scene, &from_above(1), &options).map(|_| ()).unwrap_err();
    let linear = Options { shading: Some(Shading::Linear), ..Options::default() };
    assert_eq!(refused(Options { bounces: 1, ..Options::default() }), Error::BouncesInSource);
    assert_eq!(refused(Options { bounces: 1025, ..linear.clone() }), Error::Bounces(1025));
    assert_eq!(refused(Options { light_samples: 0, ..linear.clone() }), Error::LightSamples(0));
    assert_eq!(refused(Options { light_samples: 65_537, ..linear }), Error::LightSamples(65_537));
}
