//! The shading equation: digest requirements 6–16.

use std::sync::Arc;

use aam_renderer::{MAX_LIGHTS, RenderError, Show};
use aam_scene::*;
use glam::{Affine3A, Quat, Vec3};

use crate::common::*;

/// The equation of `docs/techniques/shading.md` §1 for point lights, once more.
fn phong(material: &Material, lights: &[Light], p: Vec3, n: Vec3, v: Vec3) -> Vec3 {
    let mut sum = material.emission;
    for light in lights {
        let LightKind::Point { position, .. } = light.kind else { panic!("a point light") };
        let l = (position - p).normalize();
        let r = 2.0 * n.dot(l) * n - l;
        sum += material.ambient * light.ambient + material.diffuse * light.diffuse * n.dot(l).clamp(0.0, 1.0);
        if material.exponent > 0.0 {
            sum += material.specular * light.specular * v.dot(r).clamp(0.0, 1.0).powf(material.exponent);
        }
    }
    sum
}

/// World position of a pixel of [`front`] at z = 0.
fn seen_at(x: u32, y: u32) -> Vec3 {
    Vec3::new((x as f32 + 0.5) / 32.0 - 1.0, 1.0 - (y as f32 + 0.5) / 32.0, 0.0)
}

#[test]
fn r6_without_light_there_is_emission_alone() {
    let Some(mut renderer) = renderer() else { return };
    let emission = Vec3::new(0.2, 0.4, 0.6);
    let material =
        Material { emission, ambient: Vec3::ONE, diffuse: Vec3::ONE, specular: Vec3::ONE, exponent: 9.0, ..black() };
    let mut scene = scene_of(quad(), material, vec![dark()]);
    assert_eq!(draw(&mut renderer, &scene, &front(), &options()).center(), [51, 102, 153, 255]);
    scene.materials[0].emission = Vec3::ZERO;
    assert_eq!(draw(&mut renderer, &scene, &front(), &options()).center(), [0, 0, 0, 255]);
}

#[test]
fn a_scene_without_lights_is_lit_from_the_camera_and_says_so() {
    let Some(mut renderer) = renderer() else { return };
    let scene = scene_of(quad(), Material { diffuse: Vec3::splat(0.5), ..black() }, vec![]);
    let picture = draw(&mut renderer, &scene, &perspective(Vec3::new(0.0, 0.0, 2.0)), &options());
    assert!(picture.stats.camera_light && picture.stats.lights == 1);
    assert_color(picture.center(), Vec3::splat(0.5));
}

#[test]
fn r7_equal_places_add_their_colours() {
    let Some(mut renderer) = renderer() else { return };
    let material = Material { diffuse: Vec3::splat(0.9), specular: Vec3::splat(0.3), exponent: 5.0, ..black() };
    let place = Vec3::new(0.5, 0.5, 1.0);
    let split: Vec<Light> = [0.1, 0.2, 0.3].map(|c| point(place, Vec3::new(c, 0.5 * c, 0.1))).into();
    let one = vec![point(place, Vec3::new(0.6, 0.3, 0.3))];
    let [a, b] = [split, one]
        .map(|lights| draw(&mut renderer, &scene_of(quad(), material.clone(), lights), &front(), &options()).bytes);
    assert!(a.iter().zip(&b).all(|(a, b)| a.abs_diff(*b) <= 1));
}

#[test]
fn r8_diffuse_light_follows_the_cosine() {
    let Some(mut renderer) = renderer() else { return };
    let material = Material { diffuse: Vec3::new(1.0, 0.5, 0.0), ..black() };
    let towards = |degrees: f32| Vec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
    for (degrees, expected) in [(60.0, 0.5), (0.0, 1.0), (120.0, 0.0)] {
        let lights = vec![directional(-3.0 * towards(degrees), Vec3::ONE)];
        let scene = scene_of(quad(), material.clone(), lights);
        let picture = draw(&mut renderer, &scene, &front(), &options());
        assert_color(picture.center(), expected * Vec3::new(1.0, 0.5, 0.0));
    }
}

#[test]
fn r9_highlights_follow_the_power_of_the_mirrored_cosine() {
    let Some(mut renderer) = renderer() else { return };
    let specular = Vec3::new(0.8, 0.4, 0.2);
    let mut shade = |degrees: f32, specular: Vec3, exponent: f32| {
        let towards = Vec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
        let material = Material { specular, exponent, ..black() };
        let scene = scene_of(quad(), material, vec![directional(-towards, Vec3::ONE)]);
        draw(&mut renderer, &scene, &front(), &options()).center()
    };
    // V = R for any exponent.
    for exponent in [0.01, 1.0, 20.0, 128.0, 5000.0] {
        assert_color(shade(0.0, specular, exponent), specular);
    }
    assert_color(shade(60.0, specular, 2.0), 0.25 * specular);
    assert_color(shade(30.0, specular, 7.0), 0.75f32.powf(3.5) * specular);
    // No specular colour, or exponent 0: nothing, not even where 0⁰ would be 1.
    assert_color(shade(0.0, Vec3::ZERO, 20.0), Vec3::ZERO);
    assert_color(shade(0.0, specular, 0.0), Vec3::ZERO);
    assert_color(shade(100.0, specular, 0.001), Vec3::ZERO);
}

#[test]
fn highlights_are_not_bound_to_the_lit_side() {
    let Some(mut renderer) = renderer() else { return };
    // The light is 5° below the surface's horizon; seen from 20° above it, V·R = cos 25° still.
    let material = Material { specular: Vec3::ONE, exponent: 1.0, ..black() };
    let angle = |degrees: f32| Vec3::new(degrees.to_radians().cos(), 0.0, degrees.to_radians().sin());
    let scene = scene_of(quad(), material, vec![directional(-angle(-5.0), Vec3::ONE)]);
    let camera = Camera { position: 5.0 * angle(160.0), ..front() };
    let picture = draw(&mut renderer, &scene, &camera, &options());
    assert_color(picture.center(), Vec3::splat(25f32.to_radians().cos()));
}

#[test]
fn r10_distance_changes_nothing_unless_asked_for() {
    let Some(mut renderer) = renderer() else { return };
    let towards = Vec3::new(0.2, 0.1, 1.0).normalize();
    let mut shade = |distance: f32, falloff: Falloff, diffuse: Vec3| {
        // The pixel right and below of the centre.
        let p = seen_at(32, 32);
        let kind = LightKind::Point { position: p + distance * towards, falloff };
        let lights = vec![Light { kind, ..point(Vec3::ZERO, Vec3::ONE) }];
        let scene = scene_of(quad(), Material { diffuse, ..black() }, lights);
        draw(&mut renderer, &scene, &front(), &options()).center()
    };
    let full = towards.z * Vec3::splat(0.8);
    assert_color(shade(1.0, Falloff::None, Vec3::splat(0.8)), full);
    assert_color(shade(50.0, Falloff::None, Vec3::splat(0.8)), full);
    // The inverse square: full at a metre, no more than 10⁴ times that.
    assert_color(shade(1.0, Falloff::InverseSquare, Vec3::splat(0.8)), full);
    assert_color(shade(2.0, Falloff::InverseSquare, Vec3::splat(0.8)), 0.25 * full);
    assert_color(shade(0.001, Falloff::InverseSquare, Vec3::splat(5e-5)), 0.5 * Vec3::splat(towards.z));
}

#[test]
fn spots_fade_between_their_cones() {
    let Some(mut renderer) = renderer() else { return };
    let (inner, outer) = (0.2f32, 0.5f32);
    let position = Vec3::new(0.0, 0.0, 2.0);
    let kind = LightKind::Spot { position, direction: Vec3::new(0.0, 0.0, -7.0), inner, outer, falloff: Falloff::None };
    let lights = vec![Light { kind, ..point(Vec3::ZERO, Vec3::ONE) }];
    let scene = scene_of(quad(), Material { diffuse: Vec3::ONE, ..black() }, lights);
    let picture = draw(&mut renderer, &scene, &front(), &options()).save("spot");
    for (x, y) in [(32, 32), (38, 30), (45, 32), (48, 48), (50, 32), (62, 62)] {
        let l = (position - seen_at(x, y)).normalize();
        let cone = ((l.z - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0).powi(2);
        assert_color(picture.at(x, y), Vec3::splat(cone * l.z));
    }
}

#[test]
fn kinds_of_light_add_up() {
    let Some(mut renderer) = renderer() else { return };
    let position = Vec3::new(0.3, 0.2, 1.5);
    let spot =
        LightKind::Spot { position, direction: -position, inner: 1.0, outer: 1.2, falloff: Falloff::InverseSquare };
    let lights = vec![
        directional(Vec3::new(-0.3, 0.0, -1.0), Vec3::new(0.3, 0.0, 0.1)),
        Light { kind: spot, ..point(Vec3::ZERO, Vec3::new(0.0, 0.5, 0.1)) },
        point(Vec3::new(-1.0, 1.0, 2.0), Vec3::new(0.2, 0.1, 0.2)),
        Light { ambient: Vec3::new(0.1, 0.2, 0.3), ..dark() },
    ];
    let material = Material {
        ambient: Vec3::splat(0.5),
        diffuse: Vec3::splat(0.9),
        specular: Vec3::splat(0.4),
        exponent: 12.0,
        ..black()
    };
    let together = draw(&mut renderer, &scene_of(quad(), material.clone(), lights.clone()), &front(), &options());
    let mut sum = vec![0u32; together.bytes.len()];
    for light in lights {
        let alone = draw(&mut renderer, &scene_of(quad(), material.clone(), vec![light]), &front(), &options());
        sum.iter_mut().zip(alone.bytes).for_each(|(sum, byte)| *sum += u32::from(byte));
    }
    let colors = together.bytes.iter().zip(sum).enumerate().filter(|(i, _)| i % 4 < 3);
    let worst = colors.map(|(_, (a, b))| u32::from(*a).abs_diff(b.min(255))).max();
    assert!(worst <= Some(3), "{worst:?}");
}

#[test]
fn r11_moving_everything_together_changes_nothing() {
    let Some(mut renderer) = renderer() else { return };
    let material = Material {
        ambient: Vec3::splat(0.1),
        diffuse: Vec3::splat(0.6),
        specular: Vec3::splat(0.5),
        exponent: 30.0,
        ..black()
    };
    let light = Vec3::new(2.0, 3.0, 4.0);
    let camera = perspective(Vec3::new(0.0, 0.0, 2.5));
    let mut scene = scene_of(sphere(48), material, vec![point(light, Vec3::ONE)]);
    let before = draw(&mut renderer, &scene, &camera, &options());
    let (rotation, scale, shift) =
        (Quat::from_axis_angle(Vec3::new(1.0, -2.0, 0.5).normalize(), 1.1), 3.0, Vec3::new(10.0, -20.0, 5.0));
    let moved = Affine3A::from_scale_rotation_translation(Vec3::splat(scale), rotation, shift);
    scene.nodes[0].local = moved;
    scene.lights = vec![point(moved.transform_point3(light), Vec3::ONE)];
    let camera = Camera {
        position: moved.transform_point3(camera.position),
        target: moved.transform_point3(camera.target),
        up: rotation * camera.up,
        ..camera
    };
    let after = draw(&mut renderer, &scene, &camera, &options());
    let differing = before.bytes.iter().zip(&after.bytes).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    // Rounding may move a pixel of the outline.
    assert!(differing <= 4 * 4, "{differing} bytes differ");
}

#[test]
fn r11_normals_follow_the_inverse_transpose_under_non_uniform_scale() {
    let Some(mut renderer) = renderer() else { return };
    // A sphere scaled to an ellipsoid x²/a² + y²/b² + z²/c² = 1, whose normal is (x/a², y/b², z/c²).
    let radii = Vec3::new(0.9, 0.5, 0.3);
    let light = point(Vec3::new(1.0, 2.0, 3.0), Vec3::ONE);
    let material = Material { diffuse: Vec3::splat(0.7), specular: Vec3::splat(0.3), exponent: 8.0, ..black() };
    let mut scene = scene_of(sphere(128), material, vec![light.clone()]);
    scene.nodes[0].local = Affine3A::from_scale(radii);
    let picture = draw(&mut renderer, &scene, &front(), &options()).save("ellipsoid");
    for (x, y) in [(32, 32), (44, 28), (20, 36), (32, 22), (50, 34)] {
        let p = seen_at(x, y);
        let z = radii.z * (1.0 - (p.x / radii.x).powi(2) - (p.y / radii.y).powi(2)).sqrt();
        let p = Vec3::new(p.x, p.y, z);
        let expected = phong(&scene.materials[0], &scene.lights, p, (p / (radii * radii)).normalize(), Vec3::Z);
        // The mesh has edges.
        assert_near(picture.at(x, y), expected.extend(1.0).to_array(), 2.0);
    }
}

#[test]
fn r12_lighting_is_per_fragment() {
    let Some(mut renderer) = renderer() else { return };
    let light = point(Vec3::new(0.1, -0.2, 0.3), Vec3::ONE);
    let material = Material { specular: Vec3::ONE, exponent: 40.0, diffuse: Vec3::splat(0.2), ..black() };
    let scene = scene_of(quad(), material, vec![light]);
    let picture = draw(&mut renderer, &scene, &front(), &options()).save("r12-highlight");
    for i in (0..64 * 64).step_by(7) {
        let (x, y) = (i % 64, i / 64);
        let expected = phong(&scene.materials[0], &scene.lights, seen_at(x, y), Vec3::Z, Vec3::Z);
        assert_color(picture.at(x, y), expected);
    }
    assert!(picture.at(35, 38)[0] > 240 && picture.at(0, 0)[0] < 20);
}

#[test]
fn r13_too_many_lights_are_an_error() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = scene_of(quad(), Material { diffuse: Vec3::ONE, ..black() }, vec![]);
    scene.lights = vec![directional(Vec3::NEG_Z, Vec3::splat(1.0 / MAX_LIGHTS as f32)); MAX_LIGHTS];
    assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), Vec3::ONE);
    scene.lights.push(dark());
    let view = View { camera: front(), width: 8, height: 8, frame: 0.0 };
    let error = renderer.render_to_image(&scene, &view, &options()).err().unwrap();
    assert!(matches!(error, RenderError::TooManyLights { count } if count == MAX_LIGHTS + 1));
}

#[test]
fn r15_flat_and_smooth_meshes_share_a_pipeline() {
    let Some(mut renderer) = renderer() else { return };
    let smooth = sphere(8);
    let mut flat = Mesh { name: "flat".into(), ..Mesh::default() };
    for triangle in smooth.indices.chunks(3) {
        let [a, b, c] = [0, 1, 2].map(|i| smooth.positions[triangle[i] as usize]);
        let normal = (b - a).cross(c - a).normalize_or(Vec3::Z);
        flat.positions.extend([a, b, c]);
        flat.normals.extend([normal; 3]);
        flat.indices.extend([0, 1, 2].map(|i| flat.indices.len() as u32 + i));
    }
    finish(&mut flat);
    let mut scene =
        scene_of(smooth, Material { diffuse: Vec3::ONE, ..black() }, vec![directional(-Vec3::ONE, Vec3::ONE)]);
    scene.meshes.push(Arc::new(flat));
    scene.nodes.push(node(1, Affine3A::IDENTITY));
    let shrink =
        |x: f32| Affine3A::from_scale_rotation_translation(Vec3::splat(0.45), Quat::IDENTITY, Vec3::new(x, 0.0, 0.0));
    scene.nodes[0].local = shrink(-0.5);
    scene.nodes[1].local = shrink(0.5);
    let picture = draw(&mut renderer, &scene, &front(), &options()).save("r15-flat-smooth");
    assert_eq!((picture.stats.draws, picture.stats.pipelines_built, picture.stats.pipeline_switches), (2, 1, 1));
}

#[test]
fn r16_interpolated_normals_are_made_unit_again() {
    let Some(mut renderer) = renderer() else { return };
    let mut mesh = quad();
    let tilted = |x: f32| Vec3::new(x, 0.0, 1.0).normalize();
    mesh.normals = mesh.positions.iter().map(|p| tilted(p.x)).collect();
    let scene = scene_of(mesh, Material { diffuse: Vec3::ONE, ..black() }, vec![directional(Vec3::NEG_Z, Vec3::ONE)]);
    let picture = draw(&mut renderer, &scene, &front(), &options());
    assert_color(picture.center(), Vec3::ONE);
    assert_color(picture.at(0, 32), Vec3::splat(tilted(seen_at(0, 32).x).z));
}

#[test]
fn linear_shading_decodes_lights_and_encodes() {
    let Some(mut renderer) = renderer() else { return };
    let material =
        Material { ambient: Vec3::ZERO, diffuse: Vec3::new(0.5, 0.8, 0.2), emission: Vec3::splat(0.1), ..black() };
    let towards = Vec3::new(3f32.sqrt(), 0.0, 1.0);
    let scene = scene_of(quad(), material, vec![directional(-towards, Vec3::splat(0.7))]);
    let expected = [0.5, 0.8, 0.2].map(|d| encode(decode(0.1) + decode(d) * 0.7 * 0.5));
    let linear = aam_renderer::RenderOptions { shading: Some(Shading::Linear), ..options() };
    assert_color(draw(&mut renderer, &scene, &front(), &linear).center(), Vec3::from_array(expected));
    // The scene's own choice.
    let scene = Scene { shading: Shading::Linear, ..scene };
    assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), Vec3::from_array(expected));
}

#[test]
fn shading_normals_can_be_shown() {
    let Some(mut renderer) = renderer() else { return };
    let scene = scene_of(sphere(64), black(), vec![]);
    let shown = aam_renderer::RenderOptions { show: Show::Normals, ..options() };
    let picture = draw(&mut renderer, &scene, &front(), &shown).save("normals");
    for (x, y) in [(32, 32), (50, 20), (12, 40)] {
        let p = seen_at(x, y);
        let n = Vec3::new(p.x, p.y, (1.0 - p.x * p.x - p.y * p.y).sqrt());
        assert_near(picture.at(x, y), (0.5 * n + 0.5).extend(1.0).to_array(), 2.0);
    }
}

#[test]
fn the_view_is_parallel_in_an_orthographic_picture() {
    let Some(mut renderer) = renderer() else { return };
    // A mirror-like plane under a parallel light and a parallel view: the same everywhere.
    let material = Material { specular: Vec3::ONE, exponent: 50.0, ..black() };
    let scene = scene_of(quad(), material, vec![directional(Vec3::new(-0.1, 0.0, -1.0), Vec3::ONE)]);
    let picture = draw(&mut renderer, &scene, &front(), &options());
    let expected = (1.0f32 / 1.01f32.sqrt()).powf(50.0);
    for (x, y) in [(0, 0), (32, 32), (63, 10)] {
        assert_color(picture.at(x, y), Vec3::splat(expected));
    }
}
