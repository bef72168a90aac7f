//! Lines over the picture.

use std::sync::Arc;

use aam_renderer::{Overlays, RenderOptions, Shape, ShapeKind, ShapeVertex, Show};
use aam_scene::*;
use glam::{Affine3A, Quat, Vec3};

use crate::common::*;

fn with(overlays: Overlays) -> RenderOptions {
    RenderOptions { overlays, ..options() }
}

fn small_cube() -> Scene {
    let mut mesh = Mesh { name: "cube".into(), ..Mesh::default() };
    for turn in [
        Quat::IDENTITY,
        Quat::from_rotation_x(1.570_796_4),
        Quat::from_rotation_x(-1.570_796_4),
        Quat::from_rotation_y(1.570_796_4),
        Quat::from_rotation_y(-1.570_796_4),
        Quat::from_rotation_x(std::f32::consts::PI),
    ] {
        let base = mesh.positions.len() as u32;
        mesh.positions.extend(quad().positions.iter().map(|p| turn * p.with_z(1.0)));
        mesh.normals.extend([turn * Vec3::Z; 4]);
        mesh.indices.extend(quad().indices.iter().map(|index| base + index));
    }
    finish(&mut mesh);
    let material = Material { diffuse: Vec3::splat(0.5), ambient: Vec3::splat(0.2), ..black() };
    let mut scene = scene_of(mesh, material, vec![directional(Vec3::new(-0.5, -0.3, -1.0), Vec3::ONE)]);
    let turn = Quat::from_rotation_x(0.5) * Quat::from_rotation_y(0.6);
    scene.nodes[0].local = Affine3A::from_scale_rotation_translation(Vec3::splat(0.4), turn, Vec3::ZERO);
    scene
}

/// How many pixels of the second picture are not as in the first.
fn changed(before: &Picture, after: &Picture) -> usize {
    before.bytes.chunks(4).zip(after.bytes.chunks(4)).filter(|(a, b)| a != b).count()
}

#[test]
fn wireframe_normals_and_bounds_are_drawn_over_the_surface() {
    let Some(mut renderer) = renderer() else { return };
    let scene = small_cube();
    let size = 256;
    let mut draw = |overlays: Overlays, name: &str| {
        draw_sized(&mut renderer, &scene, &front(), &with(overlays), size, size).save(name)
    };
    let plain = draw(Overlays::default(), "overlay-none");
    let wire = draw(Overlays { wireframe: true, ..Overlays::default() }, "overlay-wireframe");
    let normals = draw(Overlays { normals: Some(0.2), ..Overlays::default() }, "overlay-normals");
    let bounds = draw(Overlays { bounds: true, ..Overlays::default() }, "overlay-bounds");
    // Three faces are seen, with their outlines and diagonals: about 12 edges of some 80 pixels.
    assert!((500..2000).contains(&changed(&plain, &wire)), "{}", changed(&plain, &wire));
    assert!((150..1500).contains(&changed(&plain, &normals)), "{}", changed(&plain, &normals));
    assert!((300..2000).contains(&changed(&plain, &bounds)), "{}", changed(&plain, &bounds));
    assert_eq!((plain.stats.draws, wire.stats.draws, wire.stats.triangles), (1, 2, 12));
    let all = Overlays { wireframe: true, normals: Some(0.2), bounds: true, shapes: vec![] };
    draw(all, "overlay-all");
}

#[test]
fn lines_behind_a_surface_are_hidden_and_those_on_it_are_not() {
    let Some(mut renderer) = renderer() else { return };
    let scene = scene_of(quad(), glow(Vec3::splat(0.5)), vec![dark()]);
    let color = [1.0, 0.0, 0.0, 1.0];
    let line = |z: f32, depth_test: bool| {
        let end = |x: f32| ShapeVertex { position: Vec3::new(x, 0.01, z), color };
        Arc::new(Shape { vertices: vec![end(-0.9), end(0.9)], kind: ShapeKind::Lines, depth_test })
    };
    for camera in [front(), perspective(Vec3::new(0.0, 0.0, 1.5))] {
        for (z, depth_test, seen) in [(0.1, true, true), (0.0, true, true), (-0.1, true, false), (-0.1, false, true)] {
            let overlays = Overlays { shapes: vec![line(z, depth_test)], ..Overlays::default() };
            let picture = draw(&mut renderer, &scene, &camera, &with(overlays));
            assert_eq!(picture.bytes.chunks(4).any(|p| p == [255, 0, 0, 255]), seen, "z = {z}, {depth_test}");
        }
    }
}

#[test]
fn shapes_blend_and_keep_their_colour_in_both_modes() {
    let Some(mut renderer) = renderer() else { return };
    let corner = |x: f32, y: f32| ShapeVertex { position: Vec3::new(x, y, 0.0), color: [0.8, 0.4, 0.2, 1.0] };
    let vertices = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0), corner(0.0, 0.0)];
    let mut shape = Shape { vertices, kind: ShapeKind::Triangles, depth_test: true };
    let scene = Scene { lights: vec![dark()], ..Scene::default() };
    for shading in [Shading::Source, Shading::Linear] {
        let overlays = Overlays { shapes: vec![Arc::new(shape.clone())], ..Overlays::default() };
        let options = RenderOptions { shading: Some(shading), ..with(overlays) };
        let picture = draw(&mut renderer, &scene, &front(), &options);
        assert_color(picture.center(), Vec3::new(0.8, 0.4, 0.2));
        // The fourth vertex is a rest.
        assert_eq!(picture.stats.triangles, 1);
    }
    shape.vertices.iter_mut().for_each(|vertex| vertex.color[3] = 0.5);
    let overlays = Overlays { shapes: vec![Arc::new(shape)], ..Overlays::default() };
    let picture = draw(&mut renderer, &scene, &front(), &with(overlays));
    assert_color(picture.center(), Vec3::new(0.4, 0.2, 0.1));
}

#[test]
fn shapes_are_uploaded_once() {
    let Some(mut renderer) = renderer() else { return };
    let end = |x: f32| ShapeVertex { position: Vec3::new(x, 0.0, 0.0), color: [1.0; 4] };
    let shape = Arc::new(Shape { vertices: vec![end(0.0), end(1.0)], kind: ShapeKind::Lines, depth_test: true });
    let options =
        RenderOptions { show: Show::Normals, ..with(Overlays { shapes: vec![shape], ..Overlays::default() }) };
    let scene = Scene { lights: vec![dark()], ..Scene::default() };
    assert!(draw(&mut renderer, &scene, &front(), &options).stats.bytes_uploaded >= 56);
    assert_eq!(draw(&mut renderer, &scene, &front(), &options).stats.bytes_uploaded, 0);
}
