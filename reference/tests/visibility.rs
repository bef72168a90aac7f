//! What surfaces see of lights, against areas and solid angles worked out by hand.

mod common;

use std::f64::consts::PI;

use aam_reference::{LightSize, Options, Seen, visibility};
use aam_scene::{Falloff, LightKind, LightShape, Material, Scene, View};
use common::*;
use glam::{Affine3A, Vec2, Vec3};

/// Height of the light, and of the edge of the blade below it.
const HEIGHT: f32 = 2.0;
const BLADE: f32 = 0.5;

/// A spot from straight above that is as bright to all sides below.
fn spot_above() -> LightKind {
    let position = Vec3::new(0.0, 0.0, HEIGHT);
    LightKind::Spot { position, direction: Vec3::NEG_Z, inner: 1.5, outer: 1.55, falloff: Falloff::None }
}

/// The square −1..1 under a blade that covers all of x > 0, and its light.
fn blade(kind: LightKind, shape: LightShape) -> Scene {
    let mut scene = scene(vec![quad(0.0), quad(BLADE)], chalk(), kind);
    scene.nodes[1].local =
        Affine3A::from_translation(Vec3::X * 50.0) * Affine3A::from_scale(Vec3::new(50.0, 50.0, 1.0));
    scene.lights[0].shape = Some(shape);
    scene
}

/// Straight down from below the blade.
fn under_the_blade(side: u32) -> View {
    let mut view = from_above(side);
    view.camera.position.z = 0.9 * BLADE;
    view.camera.near = 0.01;
    view
}

fn looked(scene: &Scene, view: &View, samples: u32, seed: u32) -> Vec<Option<Seen>> {
    let options = Options { light_samples: samples, seed, ..Options::default() };
    visibility(scene, view, LightSize::Area, &options).unwrap().0.lights.remove(0)
}

/// The middle of a pixel on the square −1..1.
fn place(index: usize, side: u32) -> (f64, f64) {
    let side = side as usize;
    let middle = |pixel: usize| 2.0 * (pixel as f64 + 0.5) / side as f64 - 1.0;
    (middle(index % side), -middle(index / side))
}

/// The share of a disc beyond a chord, which is at `t` radii from the middle.
fn segment(t: f64) -> f64 {
    let t = t.clamp(-1.0, 1.0);
    0.5 + (t.asin() + t * (1.0 - t * t).sqrt()) / PI
}

/// Where the blade's edge is seen in the plane of the light, from a point of the floor.
fn edge_at_the_light(x: f64) -> f64 {
    x * (1.0 - f64::from(HEIGHT / BLADE))
}

/// Root mean squares over the pixels of a penumbra: the errors, and the standard errors as stated.
fn errors(seen: &[Option<Seen>], side: u32, exact: impl Fn(f64, f64) -> f64) -> (f64, f64) {
    let (mut error, mut stated, mut count) = (0.0, 0.0, 0.0);
    for (index, seen) in seen.iter().enumerate() {
        let (x, y) = place(index, side);
        let (seen, exact) = (seen.unwrap(), exact(x, y));
        if exact > 0.01 && exact < 0.99 {
            error += (f64::from(seen.share) - exact).powi(2);
            stated += f64::from(seen.standard_error).powi(2);
            count += 1.0;
        } else if exact == 0.0 || exact == 1.0 {
            assert_eq!((f64::from(seen.share), seen.standard_error), (exact, 0.0), "({x}, {y})");
        }
    }
    assert!(count > 100.0, "a penumbra of {count} pixels");
    ((error / count).sqrt(), (stated / count).sqrt())
}

#[test]
fn the_penumbra_of_a_blade_is_the_segment_of_the_disc() {
    let scene = blade(spot_above(), LightShape::Disc { radius: 1.2 });
    let exact = |x: f64, _: f64| segment(edge_at_the_light(x) / 1.2);
    let (error, stated) = errors(&looked(&scene, &under_the_blade(48), 1024, 0), 48, exact);
    assert!(error < 0.003, "{error}");
    assert!((0.85..1.15).contains(&(error / stated)), "{error} where {stated} is stated");
}

#[test]
fn the_penumbra_of_a_blade_under_a_rectangle_is_a_ramp() {
    let scene = blade(spot_above(), LightShape::Rectangle { width: 2.0, height: 1.0 });
    // From straight above the width runs along X.
    let exact = |x: f64, _: f64| (0.5 + edge_at_the_light(x) / 2.0).clamp(0.0, 1.0);
    let (error, stated) = errors(&looked(&scene, &under_the_blade(48), 1024, 0), 48, exact);
    assert!(error < 0.003 && (0.8..1.2).contains(&(error / stated)), "{error} where {stated} is stated");
}

#[test]
fn a_sun_is_as_wide_as_at_one_metre() {
    let sun = LightKind::Directional { direction: Vec3::NEG_Z };
    let scene = blade(sun, LightShape::Disc { radius: 0.8 });
    let exact = |x: f64, _: f64| segment(-x / f64::from(BLADE) / 0.8);
    let (error, _) = errors(&looked(&scene, &under_the_blade(48), 1024, 0), 48, exact);
    assert!(error < 0.003, "{error}");
}

/// The share of a cone's solid angle beyond a plane through its apex, at an angle from its axis: Mazonka, "Solid Angle
/// of Conical Surfaces, Polyhedral Cones, and Intersecting Spherical Caps", 2012.
fn cone_segment(half_angle: f64, plane: f64) -> f64 {
    let (a, g) = (half_angle, plane.abs());
    let beyond = if g >= a { 0.0 } else { 2.0 * ((g.sin() / a.sin()).acos() - a.cos() * (g.tan() / a.tan()).acos()) };
    let share = beyond / (2.0 * PI * (1.0 - a.cos()));
    if plane > 0.0 { 1.0 - share } else { share }
}

#[test]
fn of_a_sphere_the_share_of_its_solid_angle_is_seen() {
    let radius = 1.1;
    let position = Vec3::new(0.0, 0.0, HEIGHT);
    let scene = blade(LightKind::Point { position, falloff: Falloff::None }, LightShape::Sphere { radius });
    let side = 65;
    let seen = looked(&scene, &under_the_blade(side), 4096, 0);
    let row = side as usize * (side as usize / 2);
    let mut worst: f64 = 0.0;
    for column in 0..side as usize {
        let (x, y) = place(row + column, side);
        assert!(y.abs() < 1e-9);
        let distance = x.hypot(f64::from(HEIGHT));
        let half_angle = (f64::from(radius) / distance).asin();
        // From the axis to the blade's edge, both seen from the floor; the lit side is that of smaller x.
        let plane = (-x).atan2(f64::from(BLADE)) - (-x).atan2(f64::from(HEIGHT));
        let exact = cone_segment(half_angle, -plane);
        let exact = if x < 0.0 { exact.max(1.0 - exact) } else { exact.min(1.0 - exact) };
        worst = worst.max((f64::from(seen[row + column].unwrap().share) - exact).abs());
    }
    assert!(worst < 0.006, "{worst}");
}

#[test]
fn the_error_falls_faster_than_that_of_random_points() {
    let scene = blade(spot_above(), LightShape::Disc { radius: 1.2 });
    let exact = |x: f64, _: f64| segment(edge_at_the_light(x) / 1.2);
    let counts = [16, 64, 256, 1024, 4096];
    let found = counts.map(|samples| {
        let (error, stated) = errors(&looked(&scene, &under_the_blade(32), samples, 1), 32, exact);
        println!("{samples:5} shadow rays: error {error:.5}, stated {stated:.5}");
        error
    });
    let (few, many) = (found[1], found[4]);
    let slope = (many / few).ln() / 64.0_f64.ln();
    // Random points give −1/2; points that are stratified in both dimensions −3/4 at a straight edge.
    assert!((-0.85..-0.65).contains(&slope), "{slope}: {few} {many}");
    // One random point of a disc half seen deviates by 1/2.
    assert!(few < 0.5 / 8.0 * 0.7, "{few}");
}

#[test]
fn means_over_seeds_are_unbiased() {
    let scene = blade(spot_above(), LightShape::Disc { radius: 1.2 });
    let side = 24;
    let mut means = vec![0.0; (side * side) as usize];
    for seed in 0..32 {
        for (mean, seen) in means.iter_mut().zip(looked(&scene, &under_the_blade(side), 8, seed)) {
            *mean += f64::from(seen.unwrap().share) / 32.0;
        }
    }
    let biases =
        means.iter().enumerate().map(|(index, mean)| mean - segment(edge_at_the_light(place(index, side).0) / 1.2));
    let bias = biases.sum::<f64>() / means.len() as f64;
    assert!(bias.abs() < 0.002, "{bias}");
}

#[test]
fn as_a_point_a_light_is_seen_or_not() {
    let scene = blade(spot_above(), LightShape::Disc { radius: 1.2 });
    let (seen, stats) = visibility(&scene, &under_the_blade(32), LightSize::Point, &Options::default()).unwrap();
    for (index, seen) in seen.lights[0].iter().enumerate() {
        let lit = if place(index, 32).0 < 0.0 { 1.0 } else { 0.0 };
        assert_eq!(*seen, Some(Seen { share: lit, standard_error: 0.0 }));
    }
    assert_eq!((stats.camera_rays, stats.shadow_rays), (1024, 1024));
    // A light without a shape is a point in both.
    let mut bare = scene.clone();
    bare.lights[0].shape = None;
    assert_eq!(looked(&bare, &under_the_blade(32), 16, 0), seen.lights[0]);
}

#[test]
fn only_surfaces_that_face_the_light_count() {
    let mut scene = scene(vec![sphere(48)], chalk(), LightKind::Directional { direction: Vec3::NEG_X });
    scene.lights.push(light(LightKind::Directional { direction: Vec3::NEG_Z }));
    scene.lights.push(light(LightKind::Directional { direction: Vec3::Z }));
    let view = from_above(40);
    let (seen, _) = visibility(&scene, &view, LightSize::Area, &Options::default()).unwrap();
    let count = |light: usize| seen.lights[light].iter().flatten().count() as f64;
    let disc = 1600.0 * PI / 4.0;
    assert!((count(0) - disc / 2.0).abs() < 12.0, "half of the disc faces the light at the side: {}", count(0));
    assert!((count(1) - disc).abs() < 12.0 && count(2) == 0.0, "{} {}", count(1), count(2));
    assert!(seen.lights[1].iter().flatten().all(|seen| seen.share == 1.0));
}

#[test]
fn transparent_surfaces_are_looked_through_and_let_their_share_of_light_pass() {
    let mut scene = blade(spot_above(), LightShape::Disc { radius: 0.3 });
    scene.materials.push(Material { opacity: 0.25, ..chalk() });
    std::sync::Arc::make_mut(&mut scene.meshes[1]).subsets[0].material = aam_scene::MaterialId(1);
    // From above the blade: its pane is in front of half the floor.
    let view = View { camera: aam_scene::Camera { position: Vec3::Z * 5.0, ..from_above(8).camera }, ..from_above(8) };
    let seen = looked(&scene, &view, 8, 0);
    let share = |x: usize| seen[8 * 4 + x].unwrap().share;
    assert_eq!((share(0), share(7)), (1.0, 0.75));
}

#[test]
fn pictures_with_lights_of_a_size_are_the_mean_over_their_points() {
    // Half of the disc is seen below the blade's edge, and its points light the floor as so many point lights do.
    let scene = blade(spot_above(), LightShape::Disc { radius: 0.2 });
    let options = Options { shadows: Some(LightSize::Area), light_samples: 256, ..Options::default() };
    let picture = draw_with(&scene, &under_the_blade(33), &options);
    let points = 2000;
    for column in [2, 12, 16, 20] {
        let x = place(16 * 33 + column, 33).0;
        let mut expected = 0.0;
        for point in 0..points {
            // A spiral of equal areas.
            let radius = 0.2 * ((f64::from(point) + 0.5) / f64::from(points)).sqrt();
            let at = Vec2::from_angle(2.399_963 * point as f32).as_dvec2() * radius;
            if at.x < edge_at_the_light(x) {
                let to = glam::DVec3::new(at.x - x, at.y, f64::from(HEIGHT));
                expected += to.z / to.length() / f64::from(points);
            }
        }
        let found = f64::from(picture.at(column as u32, 16)[0]) / 255.0;
        assert!((found - expected).abs() < 0.01, "column {column}: {found} {expected}");
    }
}

#[test]
fn shadows_take_diffuse_and_specular_light_only() {
    let mut scene = blade(spot_above(), LightShape::Disc { radius: 0.3 });
    scene.materials[0] = Material {
        ambient: Vec3::new(0.5, 1.0, 0.0),
        emission: Vec3::new(0.1, 0.0, 0.2),
        specular: Vec3::ONE,
        exponent: 3.0,
        ..chalk()
    };
    scene.lights[0].ambient = Vec3::splat(0.4);
    for size in [LightSize::Point, LightSize::Area] {
        let options = Options { shadows: Some(size), ..Options::default() };
        let picture = draw_with(&scene, &under_the_blade(8), &options);
        assert_color(picture.at(7, 4), [0.3, 0.4, 0.2, 1.0]);
        assert_eq!(picture.at(0, 4), draw(&scene, &under_the_blade(8), 16).at(0, 4), "in full light nothing changes");
    }
}
