//! Pictures against values worked out by hand.

mod common;

use std::f32::consts::{FRAC_1_SQRT_2, PI};

use aam_reference::{LightSize, Options};
use aam_scene::{Background, Falloff, Layer, LightKind, Material, NormalSpace, Projection, Scene, Shading, View};
use common::*;
use glam::{Affine3A, Mat3, Quat, Vec2, Vec3, Vec4};

#[test]
fn a_sphere_covers_the_area_of_its_silhouette() {
    let scene = scene(vec![sphere(128)], chalk(), straight_down());
    let mut view = from_above(200);
    view.camera.projection = Projection::Orthographic { height: 2.5 };
    let coverage = |view: &View| draw(&scene, view, 16).mean(3) / 255.0;
    // Seen along its axis it is a regular 256-gon.
    let polygon = 128.0 * (2.0 * std::f64::consts::PI / 256.0).sin();
    assert!((coverage(&view) - polygon / (2.5 * 2.5)).abs() < 1e-4, "orthographic: {}", coverage(&view));
    // In perspective a unit sphere at distance d fills a cone of half angle asin(1/d).
    view.camera.projection = Projection::Perspective { fov_y: 0.5 };
    let circle = std::f64::consts::PI * (1.0_f64 / 5.0).asin().tan().powi(2);
    let expected = circle / (2.0 * 0.25_f64.tan()).powi(2);
    assert!((coverage(&view) - expected).abs() < 2e-4, "perspective: {} {expected}", coverage(&view));
}

#[test]
fn diffuse_light_follows_the_cosine_and_ends_at_the_horizon() {
    let material = Material { diffuse: Vec3::new(1.0, 0.5, 0.0), ..chalk() };
    let at = |angle: f32| {
        let direction = Vec3::new(-angle.sin(), 0.0, -angle.cos());
        let scene = scene(vec![quad(0.0)], material.clone(), LightKind::Directional { direction });
        draw(&scene, &from_above(4), 1).at(1, 1)
    };
    assert_color(at(PI / 3.0), [0.5, 0.25, 0.0, 1.0]);
    assert_color(at(0.0), [1.0, 0.5, 0.0, 1.0]);
    assert_color(at(0.6 * PI), [0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn highlights_are_the_power_of_the_cosine_and_exponent_zero_is_none() {
    let specular = Vec3::new(1.0, 0.5, 0.25);
    let at = |angle: f32, exponent: f32| {
        let material = Material { diffuse: Vec3::ZERO, specular, exponent, ..chalk() };
        let direction = Vec3::new(-angle.sin(), 0.0, -angle.cos());
        let scene = scene(vec![quad(0.0)], material, LightKind::Directional { direction });
        let picture = draw(&scene, &from_above(4), 1);
        assert_eq!(picture.at(0, 0), picture.at(3, 3), "an orthographic viewer is in one direction");
        picture.at(1, 1)
    };
    for exponent in [0.5, 1.0, 30.0, 5000.0] {
        assert_color(at(0.0, exponent), [1.0, 0.5, 0.25, 1.0]);
    }
    assert_color(at(PI / 3.0, 2.0), [0.25, 0.125, 0.0625, 1.0]);
    assert_color(at(0.0, 0.0), [0.0, 0.0, 0.0, 1.0]);
    // Not gated by N·L: the mirror direction of a light 20° below the horizon is still 70° from the viewer's.
    assert_color(at(110.0 / 180.0 * PI, 1.0), [0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn a_near_light_makes_a_highlight_inside_a_single_face() {
    let material = Material { diffuse: Vec3::ZERO, specular: Vec3::ONE, exponent: 80.0, ..chalk() };
    let picture = draw(&scene(vec![quad(0.0)], material, point_light(0.0, 0.0, 0.5)), &from_above(33), 1);
    assert_color(picture.at(16, 16), [1.0; 4]);
    assert_color(picture.at(0, 0), [0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn ambient_is_a_colour_of_each_light_and_emission_needs_none() {
    let material = Material { ambient: Vec3::new(0.5, 1.0, 0.0), emission: Vec3::new(0.1, 0.0, 0.2), ..chalk() };
    let away = LightKind::Directional { direction: Vec3::Z };
    let mut scene = scene(vec![quad(0.0)], material, away);
    scene.lights[0].ambient = Vec3::new(0.2, 0.4, 0.6);
    scene.lights.push(scene.lights[0].clone());
    assert_color(draw(&scene, &from_above(2), 1).at(0, 0), [0.3, 0.8, 0.2, 1.0]);
}

#[test]
fn falloff_weakens_diffuse_light_but_not_ambient() {
    let mut scene = scene(vec![quad(0.0)], Material { ambient: Vec3::ONE, ..chalk() }, straight_down());
    let position = Vec3::new(0.0, 0.0, 2.0);
    scene.lights[0].kind = LightKind::Point { position, falloff: Falloff::InverseSquare };
    scene.lights[0].ambient = Vec3::splat(0.25);
    let picture = draw(&scene, &from_above(65), 1);
    assert_color(picture.at(32, 32), [0.5, 0.5, 0.5, 1.0]);
}

#[test]
fn texture_coordinates_start_at_the_lower_left_and_the_texture_multiplies_the_highlight() {
    let material = Material { specular: Vec3::ONE, exponent: 1.0, emission: Vec3::ONE, ..chalk() };
    let mut scene = scene(vec![quad(0.0)], material, straight_down());
    put_texture(&mut scene, Layer::Diffuse, image(4, 4, |x, y| [(60 * x) as u8, (60 * y) as u8, 200, 255]));
    // The sum of emission, diffuse and highlight is 3; clamped after the texel.
    let picture = draw(&scene, &from_above(4), 1);
    for (x, y) in [(0, 0), (3, 0), (0, 3), (3, 3), (1, 2)] {
        let texel = [60 * x, 60 * y, 200].map(|value| (3.0 * value as f32 / 255.0).min(1.0));
        assert_color(picture.at(x, y), [texel[0], texel[1], texel[2], 1.0]);
    }
}

#[test]
fn the_texture_matrix_acts_before_v_is_flipped() {
    let mut scene = scene(vec![quad(0.0)], chalk(), straight_down());
    // Only the lowest left quarter is white.
    put_texture(
        &mut scene,
        Layer::Diffuse,
        image(2, 2, |x, y| if (x, y) == (0, 1) { [255; 4] } else { [0, 0, 0, 255] }),
    );
    let layer = scene.materials[0].layers[0].as_mut().unwrap();
    layer.transform = Mat3::from_scale(Vec2::splat(2.0));
    let tiled = draw(&scene, &from_above(4), 1);
    let white: Vec<(u32, u32)> = (0..16).map(|i| (i % 4, i / 4)).filter(|(x, y)| tiled.at(*x, *y)[0] == 255).collect();
    assert_eq!(white, [(0, 1), (2, 1), (0, 3), (2, 3)]);
    // Moved by half the image along v: what was at the bottom is found where v' = v + ½ is below ½.
    scene.materials[0].layers[0].as_mut().unwrap().transform = Mat3::from_translation(Vec2::new(0.0, 0.5));
    let moved = draw(&scene, &from_above(2), 1);
    assert_eq!([moved.at(0, 0)[0], moved.at(0, 1)[0], moved.at(1, 0)[0]], [255, 0, 0]);
}

#[test]
fn a_distant_checkerboard_is_grey() {
    let mut scene = scene(vec![quad(0.0)], chalk(), straight_down());
    put_texture(
        &mut scene,
        Layer::Diffuse,
        image(2, 2, |x, y| if (x + y) % 2 == 0 { [0, 0, 0, 255] } else { [255; 4] }),
    );
    scene.materials[0].layers[0].as_mut().unwrap().transform = Mat3::from_scale(Vec2::splat(300.0));
    for samples in [1, 16] {
        let picture = draw(&scene, &from_above(20), samples);
        assert!((0..400).all(|i| (126..=129).contains(&picture.at(i % 20, i / 20)[0])), "{samples} samples");
    }
    // In linear light the mean of black and white is 0.5, which is encoded as 188.
    let linear = Options { shading: Some(Shading::Linear), ..Options::default() };
    assert_eq!(draw_with(&scene, &from_above(20), &linear).at(7, 7)[0], 188);
}

#[test]
fn slanted_textures_are_averaged_over_the_pixels_true_area() {
    // Stripes along the viewing direction, at a slant where a pixel is 50 texels deep and 2 wide. A level for the longer
    // side alone blurs them away.
    let mut scene = scene(vec![quad(0.0)], chalk(), straight_down());
    let stripes = |x: u32, _: u32| [if (x / 8).is_multiple_of(2) { 0 } else { 255 }, 0, 0, 255];
    put_texture(&mut scene, Layer::Diffuse, image(64, 256, stripes));
    let mut view = from_above(64);
    view.camera.position = Vec3::new(0.0, -5.0, 0.4);
    view.camera.target = Vec3::ZERO;
    view.camera.up = Vec3::Z;
    let contrast = |samples| {
        let picture = draw(&scene, &view, samples);
        let row: Vec<u8> = (16..48).map(|x| picture.at(x, 32)[0]).collect();
        row.iter().max().unwrap() - row.iter().min().unwrap()
    };
    assert!(contrast(1) < 30, "one sample uses the level of the longer side: {}", contrast(1));
    assert!(contrast(256) > 200, "many samples see the stripes: {}", contrast(256));
}

#[test]
fn a_light_map_replaces_lighting() {
    let material = Material {
        emission: Vec3::splat(0.1),
        ambient: Vec3::ONE,
        diffuse: Vec3::new(0.5, 1.0, 0.5),
        specular: Vec3::ONE,
        exponent: 3.0,
        ..chalk()
    };
    let mut scene = scene(vec![quad(0.0)], material, straight_down());
    put_texture(&mut scene, Layer::LightMap, image(1, 1, |_, _| [102, 51, 204, 255]));
    put_texture(&mut scene, Layer::Diffuse, image(1, 1, |_, _| [255, 255, 0, 255]));
    put_texture(&mut scene, Layer::Normal, image(1, 1, |_, _| [0, 0, 0, 255]));
    let shadowed = Options { shadows: Some(LightSize::Point), ..Options::default() };
    assert_color(draw_with(&scene, &from_above(2), &shadowed).at(1, 1), [0.3, 0.3, 0.0, 1.0]);
}

#[test]
fn normal_maps_turn_the_normal_in_either_space() {
    let light = LightKind::Directional { direction: Vec3::NEG_X };
    let mut scene = scene(vec![quad(0.0)], chalk(), light);
    // 45° between +X and +Z.
    put_texture(&mut scene, Layer::Normal, image(1, 1, |_, _| [218, 128, 218, 255]));
    let at = |scene: &Scene| draw(scene, &from_above(2), 1).at(0, 0);
    assert_color(at(&scene), [FRAC_1_SQRT_2, FRAC_1_SQRT_2, FRAC_1_SQRT_2, 1.0]);

    // Turned about Z by 90°, the object's +X is the world's +Y, and the light sees the normal edge on.
    scene.nodes[0].local = Affine3A::from_rotation_z(PI / 2.0);
    assert_color(at(&scene), [0.0, 0.0, 0.0, 1.0]);

    // In tangent space with the tangent along −Y: +x is −Y, and with w = 1, +y is Z × (−Y) = +X.
    scene.nodes[0].local = Affine3A::IDENTITY;
    let mesh = std::sync::Arc::make_mut(&mut scene.meshes[0]);
    mesh.tangents = Some(vec![Vec4::new(0.0, -1.0, 0.0, 1.0); 4]);
    let layer = scene.materials[0].layers[Layer::Normal as usize].as_mut().unwrap();
    layer.normal_space = NormalSpace::Tangent;
    assert_color(at(&scene), [0.0, 0.0, 0.0, 1.0]);
    scene.lights[0].kind = LightKind::Directional { direction: Vec3::Y };
    assert_color(at(&scene), [FRAC_1_SQRT_2, FRAC_1_SQRT_2, FRAC_1_SQRT_2, 1.0]);
    // Intensity 2 makes the slope 2 : 1.
    scene.materials[0].layers[Layer::Normal as usize].as_mut().unwrap().intensity = 2.0;
    let slope = 2.0 / 5.0_f32.sqrt();
    assert_color(at(&scene), [slope, slope, slope, 1.0]);
    // Without tangents a tangent-space map counts as absent.
    std::sync::Arc::make_mut(&mut scene.meshes[0]).tangents = None;
    assert_color(at(&scene), [0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn normals_are_right_under_non_uniform_scale() {
    // A sphere squeezed to a third in x, and an ellipsoid whose normals are worked out directly.
    let scale = Vec3::new(1.0 / 3.0, 1.0, 0.7);
    let light = LightKind::Directional { direction: Vec3::new(-1.0, 0.3, -0.5) };
    let mut squeezed = scene(vec![sphere(64)], chalk(), light);
    squeezed.nodes[0].local = Affine3A::from_scale(scale);
    let picture = draw(&squeezed, &from_above(65), 1);
    let towards = -Vec3::new(-1.0, 0.3, -0.5).normalize();
    for (x, y) in [(32, 32), (40, 20), (26, 40), (36, 50)] {
        // The point of the ellipsoid below this pixel; its normal is the gradient of Σ (pᵢ/sᵢ)².
        let p = Vec2::new((x as f32 + 0.5) / 32.5 - 1.0, 1.0 - (y as f32 + 0.5) / 32.5);
        let z = scale.z * (1.0 - (p.x / scale.x).powi(2) - (p.y / scale.y).powi(2)).sqrt();
        let normal = (p.extend(z) / (scale * scale)).normalize();
        let expected = normal.dot(towards).max(0.0);
        let found = f32::from(picture.at(x, y)[0]) / 255.0;
        assert!((found - expected).abs() < 0.012, "({x}, {y}): {found} {expected}");
    }
}

#[test]
fn both_sides_are_lit_and_mirroring_does_not_turn_faces_round() {
    let half = |scale: f32, light: f32| {
        let mut scene = scene(vec![quad(0.0)], chalk(), LightKind::Directional { direction: Vec3::Z * light });
        scene.nodes[0].local = Affine3A::from_scale(Vec3::new(1.0, 1.0, scale));
        draw(&scene, &from_above(2), 1).at(0, 0)[0]
    };
    // Lit from the viewer's side: bright whichever side the viewer sees; from the other side: dark.
    for scale in [1.0, -1.0] {
        assert_eq!((half(scale, -1.0), half(scale, 1.0)), (255, 0), "scale {scale}");
    }
    // Mirroring everything but the light's height leaves a sphere as it was.
    let light = LightKind::Directional { direction: Vec3::new(0.0, 0.3, -1.0) };
    let mut scene = scene(vec![sphere(32)], chalk(), light);
    let plain = draw(&scene, &from_above(32), 4);
    scene.nodes[0].local = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let mirrored = draw(&scene, &from_above(32), 4);
    let apart = plain.bytes.iter().zip(&mirrored.bytes).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(apart <= Some(2), "{apart:?}");
}

#[test]
fn interpolated_normals_are_made_unit_again() {
    // Normals 45° to either side: in the middle full light, where the mean alone would have length 0.71.
    let mut mesh = quad(0.0);
    let lean = |x: f32| Vec3::new(x, 0.0, 1.0).normalize();
    mesh.normals = vec![lean(-1.0), lean(1.0), lean(1.0), lean(-1.0)];
    let picture = draw(&scene(vec![mesh], chalk(), straight_down()), &from_above(33), 1);
    assert_color(picture.at(16, 16), [1.0; 4]);
    assert_color(picture.at(0, 16), [0.718, 0.718, 0.718, 1.0]);
}

#[test]
fn vertex_colours_multiply_and_are_decoded_before_they_are_interpolated() {
    let mut mesh = quad(0.0);
    let (black, white) = (Vec4::new(0.0, 0.5, 0.0, 1.0), Vec4::new(1.0, 0.5, 0.0, 1.0));
    mesh.colors = Some(vec![black, white, white, black]);
    let mut scene = scene(vec![mesh], chalk(), straight_down());
    let view = from_above(5);
    assert_color(draw(&scene, &view, 1).at(2, 2), [0.5, 0.5, 0.0, 1.0]);
    scene.shading = Shading::Linear;
    assert_color(draw(&scene, &view, 1).at(2, 2), [188.0 / 255.0, 0.5, 0.0, 1.0]);
}

#[test]
fn linear_shading_decodes_lights_and_encodes() {
    // 0.5 decodes to 0.214; half of it, by a light at 60°, encodes to 0.361.
    let direction = Vec3::new(-3.0_f32.sqrt(), 0.0, -1.0);
    let material = Material { diffuse: Vec3::splat(0.5), emission: Vec3::new(0.0, 0.0, 0.5), ..chalk() };
    let mut scene = scene(vec![quad(0.0)], material, LightKind::Directional { direction });
    scene.shading = Shading::Linear;
    let half = 0.360_97;
    assert_color(draw(&scene, &from_above(2), 4).at(0, 0), [half, half, 0.604, 1.0]);
    // A light colour is linear already.
    scene.lights[0].diffuse = Vec3::new(0.5, 2.0, 0.0);
    assert_color(draw(&scene, &from_above(2), 4).at(0, 0), [0.2542, 0.5, 0.5, 1.0]);
}

#[test]
fn anti_aliasing_averages_the_values_that_lighting_computes_on() {
    let mut scene = scene(vec![quad(0.0)], glowing(1.0, 1.0, 1.0), straight_down());
    scene.nodes[0].local = Affine3A::from_translation(Vec3::X);
    scene.background = Background::Color(Vec3::ZERO);
    // Three pixels across: the middle one is half covered.
    let middle = |scene: &Scene| draw(scene, &from_above(3), 16).at(1, 1)[0];
    assert_eq!(middle(&scene), 128);
    scene.shading = Shading::Linear;
    assert_eq!(middle(&scene), 188);
}

#[test]
fn a_rotated_quad_covers_its_area() {
    let mut scene = scene(vec![quad(0.0)], glowing(1.0, 1.0, 1.0), straight_down());
    for degrees in [0.0_f32, 1.0, 17.0, 44.0] {
        let turn = Quat::from_rotation_z(degrees.to_radians());
        scene.nodes[0].local = Affine3A::from_scale_rotation_translation(Vec3::splat(0.6), turn, Vec3::splat(0.01));
        let area = draw(&scene, &from_above(50), 16).mean(3) / 255.0;
        assert!((area - 0.36).abs() < 3e-4, "{degrees}°: {area}");
    }
}
