//! Blending, its order, and the cutoff: digest requirements 41–43.

use std::sync::Arc;

use aam_renderer::{Msaa, RenderOptions};
use aam_scene::*;
use glam::{Affine3A, Quat, Vec3, Vec4};

use crate::common::*;

fn glass(color: Vec3, opacity: f32) -> Material {
    Material { opacity, ..glow(color) }
}

/// Squares of the given materials at the given depths.
fn panes(panes: &[(Material, f32)]) -> Scene {
    let mut scene = scene_of(quad(), black(), vec![dark()]);
    scene.nodes.clear();
    scene.meshes.clear();
    scene.materials.clear();
    for (number, (material, z)) in (0..).zip(panes) {
        let mut mesh = quad();
        mesh.subsets[0].material = MaterialId(number);
        scene.meshes.push(Arc::new(mesh));
        scene.materials.push(material.clone());
        scene.nodes.push(node(number, at(*z)));
    }
    scene
}

fn over(front: Vec3, alpha: f32, behind: Vec3) -> Vec3 {
    front * alpha + behind * (1.0 - alpha)
}

#[test]
fn r41_alpha_is_opacity_times_texel() {
    let Some(mut renderer) = renderer() else { return };
    let white_over_black = |renderer: &mut _, scene: &Scene| draw(renderer, scene, &front(), &options()).center();
    for (opacity, expected) in [(1.0, 1.0), (0.5, 0.5), (0.25, 0.25), (0.0, 0.0), (7.0, 1.0), (-1.0, 0.0)] {
        let scene = panes(&[(glass(Vec3::ONE, opacity), 0.0)]);
        assert_color(white_over_black(&mut renderer, &scene), Vec3::splat(expected));
    }
    let mut scene = panes(&[(glass(Vec3::ONE, 0.5), 0.0)]);
    let used = layer(&mut scene, image8(1, 1, |_, _| [255, 255, 255, 102]));
    scene.materials[0].layers[Layer::Diffuse as usize] = Some(used);
    assert_color(white_over_black(&mut renderer, &scene), Vec3::splat(0.5 * 0.4));
    // The texture's alpha alone makes a surface blend, and so do vertex colours.
    scene.materials[0].opacity = 1.0;
    assert_color(white_over_black(&mut renderer, &scene), Vec3::splat(0.4));
    Arc::make_mut(&mut scene.meshes[0]).colors = Some(vec![Vec4::new(1.0, 1.0, 1.0, 0.5); 4]);
    assert_color(white_over_black(&mut renderer, &scene), Vec3::splat(0.4 * 0.5));
}

#[test]
fn r43_order_of_submission_does_not_matter() {
    let Some(mut renderer) = renderer() else { return };
    let (red, green, blue) = (glass(Vec3::X, 0.5), glass(Vec3::Y, 0.4), glow(Vec3::Z));
    let expected = over(Vec3::X, 0.5, over(Vec3::Y, 0.4, Vec3::Z));
    let mut all = [(red, 1.0), (green, 0.0), (blue, -1.0)];
    for swap in [(0, 0), (0, 1), (1, 2), (0, 1), (1, 2), (0, 1)] {
        all.swap(swap.0, swap.1);
        assert_color(draw(&mut renderer, &panes(&all), &front(), &options()).center(), expected);
    }
    // Seen from behind, the opaque one hides the rest.
    let behind = Camera { position: Vec3::new(0.0, 0.0, -5.0), ..front() };
    assert_color(draw(&mut renderer, &panes(&all), &behind, &options()).center(), Vec3::Z);
}

#[test]
fn r42_transparent_surfaces_are_hidden_by_opaque_ones_and_hide_nothing() {
    let Some(mut renderer) = renderer() else { return };
    let scene = panes(&[(glass(Vec3::X, 0.5), -1.0), (glow(Vec3::Y), 0.0), (glass(Vec3::Z, 0.0), 1.0)]);
    let picture = draw(&mut renderer, &scene, &front(), &options());
    assert_color(picture.center(), Vec3::Y);
    // What is invisible is not drawn at all.
    assert_eq!((picture.stats.draws, picture.stats.sorted_triangles), (2, 2));
}

#[test]
fn r43_triangles_are_sorted_within_and_across_objects() {
    let Some(mut renderer) = renderer() else { return };
    // Two stacks of panes in one mesh each, interleaved in depth, in an order that is neither.
    let stack = |material: u32, depths: &[f32]| {
        let mut mesh = Mesh { name: "stack".into(), ..Mesh::default() };
        for &z in depths {
            let base = mesh.positions.len() as u32;
            mesh.positions.extend(quad().positions.iter().map(|p| p.with_z(z)));
            mesh.normals.extend([Vec3::Z; 4]);
            mesh.indices.extend(quad().indices.iter().map(|index| base + index));
        }
        finish(&mut mesh);
        mesh.subsets[0].material = MaterialId(material);
        mesh
    };
    let mut scene = scene_of(stack(0, &[0.5, -0.5, 0.0]), glass(Vec3::X, 0.5), vec![dark()]);
    scene.meshes.push(Arc::new(stack(1, &[-0.25, 0.75, 0.25])));
    scene.materials.push(glass(Vec3::Y, 0.3));
    scene.nodes.push(node(1, Affine3A::IDENTITY));
    let blend = |front_to_back: [(Vec3, f32); 6]| {
        front_to_back.into_iter().rev().fold(Vec3::ZERO, |behind, (color, alpha)| over(color, alpha, behind))
    };
    let (red, green) = ((Vec3::X, 0.5), (Vec3::Y, 0.3));
    let picture = draw(&mut renderer, &scene, &front(), &options());
    assert_near(picture.center(), blend([green, red, green, red, green, red]).extend(1.0).to_array(), 2.0);
    assert_eq!((picture.stats.draws, picture.stats.sorted_triangles), (6, 12));
    let behind = Camera { position: Vec3::new(0.0, 0.0, -5.0), ..front() };
    let picture = draw(&mut renderer, &scene, &behind, &options());
    assert_near(picture.center(), blend([red, green, red, green, red, green]).extend(1.0).to_array(), 2.0);
    // Moving one object moves its triangles in the order.
    scene.nodes[1].local = at(-10.0);
    let picture = draw(&mut renderer, &scene, &front(), &options());
    assert_near(picture.center(), blend([red, red, red, green, green, green]).extend(1.0).to_array(), 2.0);
    assert_eq!(picture.stats.draws, 2);
}

#[test]
fn a_closed_transparent_sphere_shows_its_back_through_its_front() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = scene_of(sphere(24), glass(Vec3::splat(0.8), 0.5), vec![dark()]);
    scene.nodes[0].local = Affine3A::from_quat(Quat::from_rotation_x(0.3));
    let picture = draw(&mut renderer, &scene, &front(), &options()).save("glass-sphere");
    let two_layers = over(Vec3::splat(0.8), 0.5, over(Vec3::splat(0.8), 0.5, Vec3::ZERO));
    for (x, y) in [(32, 32), (20, 40), (45, 25)] {
        assert_color(picture.at(x, y), two_layers);
    }
}

#[test]
fn the_order_is_kept_until_something_moves() {
    let Some(mut renderer) = renderer() else { return };
    let scene = panes(&[(glass(Vec3::X, 0.5), 0.0), (glass(Vec3::Y, 0.5), 1.0)]);
    let first = draw(&mut renderer, &scene, &front(), &options());
    let again = draw(&mut renderer, &scene, &front(), &options());
    assert_eq!((again.stats.bytes_uploaded, &again.bytes), (0, &first.bytes));
    let from_behind = Camera { position: Vec3::new(0.0, 0.0, -5.0), ..front() };
    let turned = draw(&mut renderer, &scene, &from_behind, &options());
    assert_color(turned.center(), over(Vec3::X, 0.5, over(Vec3::Y, 0.5, Vec3::ZERO)));
}

#[test]
fn fragments_below_the_cutoff_are_discarded_and_the_rest_is_opaque() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = panes(&[(glow(Vec3::ONE), 0.0), (glow(Vec3::X), -1.0)]);
    let used = layer(&mut scene, image8(32, 1, |x, _| [255, 255, 255, if x < 16 { 100 } else { 200 }]));
    scene.materials[0].layers[Layer::Diffuse as usize] = Some(used);
    scene.materials[0].alpha_cutoff = Some(0.5);
    let picture = draw(&mut renderer, &scene, &front(), &options());
    assert_eq!((picture.at(10, 32), picture.at(50, 32)), ([255, 0, 0, 255], [255; 4]));
    assert_eq!(picture.stats.sorted_triangles, 0);
    // With an opacity below 1 what is left blends.
    scene.materials[0].opacity = 0.7;
    let picture = draw(&mut renderer, &scene, &front(), &options());
    assert_color(picture.at(10, 32), Vec3::X);
    assert_color(picture.at(50, 32), over(Vec3::ONE, 0.7 * 200.0 / 255.0, Vec3::X));
}

#[test]
fn blending_is_linear_in_linear_light() {
    let Some(mut renderer) = renderer() else { return };
    let scene = panes(&[(glass(Vec3::splat(0.9), 0.5), 0.0), (glow(Vec3::splat(0.2)), -1.0)]);
    let linear = RenderOptions { shading: Some(Shading::Linear), ..options() };
    let expected = encode(0.5 * decode(0.9) + 0.5 * decode(0.2));
    assert_color(draw(&mut renderer, &scene, &front(), &linear).center(), Vec3::splat(expected));
}

#[test]
fn pictures_have_straight_alpha() {
    let Some(mut renderer) = renderer() else { return };
    let color = Vec3::new(0.9, 0.3, 0.6);
    for shading in [Shading::Source, Shading::Linear] {
        let transparent =
            RenderOptions { shading: Some(shading), background: Some(Background::Transparent), ..options() };
        // Even a faint pane keeps its colour.
        for opacity in [0.5, 0.02] {
            let scene = panes(&[(glass(color, opacity), 0.0)]);
            let found = draw(&mut renderer, &scene, &front(), &transparent).center();
            assert_near(found, color.extend(opacity).to_array(), 1.0);
        }
        // Two panes: the result over black is what is drawn over black.
        let scene = panes(&[(glass(Vec3::X, 0.5), 0.0), (glass(Vec3::Y, 0.4), 1.0)]);
        let alpha = 0.4 + 0.5 * 0.6;
        let straight = Vec3::new(0.3, 0.4, 0.0) / alpha;
        let straight = if shading == Shading::Linear { straight.map(encode) } else { straight };
        let found = draw(&mut renderer, &scene, &front(), &transparent).center();
        assert_near(found, straight.extend(alpha).to_array(), 1.0);
        let nothing = Scene { nodes: vec![], ..scene };
        assert_eq!(draw(&mut renderer, &nothing, &front(), &transparent).center(), [0; 4]);
    }
}

#[test]
fn outlines_are_smoothed_in_the_space_of_the_mode() {
    let Some(mut renderer) = renderer() else { return };
    // The quad's left edge runs through the middle of the pixels of column 32.
    let mut scene = scene_of(quad(), glow(Vec3::ONE), vec![dark()]);
    scene.nodes[0].local = Affine3A::from_translation(Vec3::new(1.0 + 0.5 / 32.0, 0.0, 0.0));
    for (shading, half) in [(Shading::Source, 0.5), (Shading::Linear, encode(0.5))] {
        let smooth = RenderOptions { msaa: Msaa::X4, shading: Some(shading), ..options() };
        let picture = draw(&mut renderer, &scene, &front(), &smooth);
        assert_color(picture.at(32, 20), Vec3::splat(half));
        assert_eq!((picture.at(31, 20)[0], picture.at(33, 20)[0]), (0, 255));
        let transparent = RenderOptions { background: Some(Background::Transparent), ..smooth };
        let picture = draw(&mut renderer, &scene, &front(), &transparent);
        assert_near(picture.at(32, 20), [1.0, 1.0, 1.0, 0.5], 1.0);
    }
}
