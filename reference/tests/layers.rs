//! Transparency, cutoffs, shadows, backgrounds and clipping against values worked out by hand.

mod common;

use aam_reference::{LightSize, Options};
use aam_scene::{Background, Image, Layer, LightKind, Material, MaterialId, Pixels, Projection, Scene, Shading};
use common::*;
use glam::{Affine3A, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// Sheets from the lowest to the highest, each with its own material.
fn sheets(materials: Vec<Material>) -> Scene {
    let meshes: Vec<_> = (0..materials.len()).map(|index| quad(0.05 * index as f32)).collect();
    let mut scene = scene(meshes, chalk(), straight_down());
    for (index, mesh) in scene.meshes.iter_mut().enumerate() {
        Arc::make_mut(mesh).subsets[0].material = MaterialId(index as u32);
    }
    scene.materials = materials;
    scene
}

fn glass(r: f32, g: f32, b: f32, opacity: f32) -> Material {
    Material { opacity, ..glowing(r, g, b) }
}

#[test]
fn sheets_blend_back_to_front_in_any_order() {
    let materials = vec![glowing(0.0, 0.0, 1.0), glass(0.0, 1.0, 0.0, 0.5), glass(1.0, 0.0, 0.0, 0.25)];
    let mut scene = sheets(materials);
    // ((0,0,1)·½ + (0,1,0)·½)·¾ + (1,0,0)·¼
    let expected = [0.25, 0.375, 0.375, 1.0];
    for _ in 0..3 {
        assert_color(draw(&scene, &from_above(2), 4).at(0, 0), expected);
        scene.nodes.rotate_left(1);
    }
    let linear = Options { shading: Some(Shading::Linear), ..Options::default() };
    // The same mixture of linear values, encoded: 0.25 → 0.5371, 0.375 → 0.6470.
    assert_color(draw_with(&scene, &from_above(2), &linear).at(0, 0), [0.5371, 0.6470, 0.6470, 1.0]);
}

#[test]
fn intersecting_sheets_are_right_on_both_sides() {
    let mut scene = sheets(vec![glass(1.0, 0.0, 0.0, 0.5), glass(0.0, 1.0, 0.0, 0.5)]);
    // The second crosses the first along the line x = 0.
    scene.nodes[1].local = Affine3A::from_rotation_y(0.5) * Affine3A::from_translation(Vec3::new(0.0, 0.0, -0.05));
    let picture = draw(&scene, &from_above(8), 1);
    assert_color(picture.at(1, 4), [1.0 / 3.0, 2.0 / 3.0, 0.0, 0.75]);
    assert_color(picture.at(6, 4), [2.0 / 3.0, 1.0 / 3.0, 0.0, 0.75]);
}

#[test]
fn the_picture_has_straight_alpha_and_clear_sheets_leave_no_trace() {
    let mut scene = sheets(vec![glass(1.0, 0.5, 0.0, 0.5), glass(0.0, 1.0, 0.0, 0.0)]);
    let at = |scene: &Scene| draw(scene, &from_above(4), 4).at(1, 2);
    assert_color(at(&scene), [1.0, 0.5, 0.0, 0.5]);
    scene.background = Background::Color(Vec3::ONE);
    assert_color(at(&scene), [1.0, 0.75, 0.5, 1.0]);
    scene.nodes.clear();
    assert_color(at(&scene), [1.0; 4]);
}

#[test]
fn more_sheets_than_one_walk_collects_are_all_seen() {
    // 60 sheets of 2 %: 1 − 0.98⁶⁰. And with an opaque one below the 40th.
    let mut scene = sheets(vec![glass(1.0, 1.0, 1.0, 0.02); 60]);
    let alpha = 1.0 - 0.98_f32.powi(60);
    assert_color(draw(&scene, &from_above(2), 1).at(0, 0), [1.0, 1.0, 1.0, alpha]);
    scene.materials[19] = glowing(0.0, 0.0, 0.0);
    let white = 1.0 - 0.98_f32.powi(40);
    assert_color(draw(&scene, &from_above(2), 1).at(0, 0), [white, white, white, 1.0]);
}

#[test]
fn a_cutoff_discards_below_it_and_makes_the_rest_opaque() {
    let material = Material { alpha_cutoff: Some(0.5), ..glowing(1.0, 1.0, 1.0) };
    let mut scene = sheets(vec![glowing(1.0, 0.0, 0.0), material]);
    let texels = image(2, 1, |x, _| [255, 255, 255, if x == 0 { 127 } else { 128 }]);
    put_texture(&mut scene, Layer::Diffuse, texels);
    scene.materials[1].layers[0] = scene.materials[0].layers[0].take();
    let picture = draw(&scene, &from_above(4), 1);
    assert_color(picture.at(0, 0), [1.0, 0.0, 0.0, 1.0]);
    assert_color(picture.at(3, 0), [1.0; 4]);
    // Below full opacity what passes the cutoff still blends.
    scene.materials[1].opacity = 0.99;
    scene.materials[1].alpha_cutoff = Some(0.4);
    assert_color(draw(&scene, &from_above(4), 1).at(3, 0), [1.0, 0.497, 0.497, 1.0]);
}

#[test]
fn alpha_of_textures_and_vertex_colours_blends() {
    let mut scene = sheets(vec![glowing(1.0, 1.0, 1.0)]);
    put_texture(&mut scene, Layer::Diffuse, image(1, 1, |_, _| [255, 0, 0, 128]));
    Arc::make_mut(&mut scene.meshes[0]).colors = Some(vec![Vec4::new(1.0, 1.0, 1.0, 0.5); 4]);
    assert_color(draw(&scene, &from_above(2), 1).at(0, 0), [1.0, 0.0, 0.0, 128.0 / 510.0]);
}

#[test]
fn a_blade_casts_its_shadow_where_similar_triangles_put_it() {
    // Floor at z = 0, blade over x < 0 at z = 0.5, light at (−0.3, 0, 2): the edge falls on
    // x = −0.3 + (0 − −0.3)·2/1.5 = 0.1.
    let mut scene = scene(vec![quad(0.0), quad(0.5)], chalk(), point_light(-0.3, 0.0, 2.0));
    scene.nodes[1].local = Affine3A::from_translation(Vec3::NEG_X);
    scene.lights[0].ambient = Vec3::splat(0.25);
    scene.materials[0].ambient = Vec3::ONE;
    let mut view = from_above(100);
    view.camera.position = Vec3::new(0.0, 0.0, 0.4);
    view.camera.near = 0.01;
    let shadows = Options { shadows: Some(LightSize::Point), samples_per_pixel: 16, ..Options::default() };
    let picture = draw_with(&scene, &view, &shadows);
    assert_eq!(picture.at(54, 50)[0], 64, "ambient light reaches the shadow");
    assert!(picture.at(55, 50)[0] > 250);
    let plain = draw(&scene, &view, 16);
    let dark: f64 = (0..100)
        .map(|x| {
            let (lit, shadowed) = (f64::from(plain.at(x, 50)[0]) - 63.75, f64::from(picture.at(x, 50)[0]) - 63.75);
            1.0 - shadowed / lit
        })
        .sum();
    assert!((dark / 50.0 - 1.1).abs() < 2e-3, "edge at {}", dark / 50.0 - 1.0);
}

#[test]
fn coloured_sheets_let_their_share_of_light_through() {
    let mut scene = sheets(vec![chalk(), glass(0.0, 0.0, 0.0, 0.25), glass(0.0, 0.0, 0.0, 0.5)]);
    let mut view = from_above(2);
    view.camera.position.z = 0.03;
    view.camera.near = 0.01;
    let shadows = Options { shadows: Some(LightSize::Point), ..Options::default() };
    assert_color(draw_with(&scene, &view, &shadows).at(0, 0), [0.375, 0.375, 0.375, 1.0]);
    scene.lights[0].kind = point_light(0.0, 0.0, 0.07);
    assert!(draw_with(&scene, &view, &shadows).at(0, 0)[0] < 100);
    // Beyond the light nothing casts.
    scene.lights[0].kind = point_light(0.0, 0.0, 0.04);
    let plain = draw(&scene, &view, 16);
    assert_eq!(draw_with(&scene, &view, &shadows).bytes, plain.bytes);
}

#[test]
fn a_lit_sphere_does_not_shadow_itself_on_its_lit_side() {
    for (scale, offset) in [(1.0, 0.0), (1e-3, 0.0), (100.0, 0.0), (1.0, 1000.0)] {
        let mut scene = scene(vec![sphere(200)], chalk(), straight_down());
        let offset = Vec3::splat(offset);
        scene.nodes[0].local = Affine3A::from_scale(Vec3::splat(scale));
        scene.nodes[0].local.translation = offset.into();
        let mut view = from_above(100);
        view.camera.position = offset + Vec3::Z * (5.0 * scale);
        view.camera.target = offset;
        view.camera.projection = Projection::Orthographic { height: 2.0 * scale };
        view.camera.near = 0.1 * scale;
        view.camera.far = 100.0 * scale;
        let shadows = Options { shadows: Some(LightSize::Point), samples_per_pixel: 4, ..Options::default() };
        let (with, without) = (draw_with(&scene, &view, &shadows), draw(&scene, &view, 4));
        let apart = with.bytes.iter().zip(&without.bytes).filter(|(a, b)| a.abs_diff(**b) > 1).count();
        assert_eq!(apart, 0, "scale {scale} at {offset}");
    }
}

#[test]
fn backgrounds_come_out_as_they_are_in_both_modes() {
    let empty = Scene::default();
    let pixels = |x: u32, y: u32| [(x * 30) as u8, (y * 60) as u8, 77, (100 + 10 * x) as u8];
    for shading in [Shading::Source, Shading::Linear] {
        let draw = |background| {
            let options = Options { background: Some(background), shading: Some(shading), ..Options::default() };
            draw_with(&empty, &from_above(4), &options)
        };
        assert_eq!(draw(Background::Color(Vec3::new(0.2, 0.6, 1.0))).at(1, 3), [51, 153, 255, 255]);
        assert_eq!(draw(Background::Transparent).at(0, 0), [0; 4]);
        let picture = draw(Background::Picture(image(4, 4, |_, _| [10, 130, 240, 255])));
        assert_eq!(picture.at(2, 2), [10, 130, 240, 255]);
        let float = Image { width: 1, height: 1, pixels: Pixels::RgbF32(vec![0.5, 2.0, 0.0]) };
        assert_eq!(draw(Background::Picture(Arc::new(float))).at(2, 2), [188, 255, 0, 255]);
    }
    // A picture of the view's own size, sampled at pixel centres, alpha kept.
    let options = Options {
        background: Some(Background::Picture(image(4, 4, pixels))),
        samples_per_pixel: 1,
        ..Options::default()
    };
    let picture = draw_with(&empty, &from_above(4), &options);
    assert!((0..16).all(|i| picture.at(i % 4, i / 4) == pixels(i % 4, i / 4)));
}

#[test]
fn nothing_is_seen_before_the_near_or_beyond_the_far_plane() {
    let mut scene = scene(vec![quad(0.0)], glowing(1.0, 1.0, 1.0), straight_down());
    let seen = |scene: &Scene, fov: bool, near: f32, far: f32| {
        let mut view = from_above(4);
        (view.camera.near, view.camera.far) = (near, far);
        if fov {
            view.camera.projection = Projection::Perspective { fov_y: 0.7 };
        }
        (0..16).filter(|i| draw(scene, &view, 1).at(i % 4, i / 4)[3] > 0).count()
    };
    for perspective in [false, true] {
        // Depth counts along the axis: all of the quad is 5 away, its corners are not nearer or farther.
        let counts = [(1.0, 4.99), (1.0, 5.01), (4.99, 9.0), (5.01, 9.0)].map(|(n, f)| seen(&scene, perspective, n, f));
        let all = seen(&scene, perspective, 0.1, 100.0);
        assert!(all > 3);
        assert_eq!(counts, [0, all, all, 0]);
    }
    scene.nodes[0].visible = false;
    assert_eq!(seen(&scene, true, 0.1, 100.0), 0);
}

#[test]
fn a_spot_lights_its_disc() {
    let kind = LightKind::Spot {
        position: Vec3::new(0.0, 0.0, 2.0),
        direction: Vec3::NEG_Z,
        inner: 0.2,
        outer: 0.200_1,
        falloff: aam_scene::Falloff::None,
    };
    let picture = draw(&scene(vec![quad(0.0)], chalk(), kind), &from_above(201), 1);
    let radius = 2.0 * 0.2_f32.tan();
    for x in 0..201 {
        let at = Vec2::new((x as f32 + 0.5) / 100.5 - 1.0, 0.0).length();
        if (at - radius).abs() > 0.01 {
            assert_eq!(picture.at(x, 100)[0] > 200, at < radius, "column {x}");
        }
    }
}
