//! What keeps lit surfaces free of acne, and what it costs. Digest requirements 20 to 27.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};

use super::hard::{darkest_on_tilted, tilted};
use super::*;
use crate::common::{finish, renderer, sphere};

/// A closed cube, [−1, 1]³, wound so that its faces point outwards.
fn cube() -> Mesh {
    let mut mesh = Mesh { name: "cube".into(), ..Mesh::default() };
    let quad = quad();
    for turn in [
        Quat::IDENTITY,
        Quat::from_rotation_y(std::f32::consts::FRAC_PI_2),
        Quat::from_rotation_y(std::f32::consts::PI),
        Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2),
        Quat::from_rotation_x(std::f32::consts::FRAC_PI_2),
        Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2),
    ] {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(quad.positions.iter().map(|p| turn * (*p + Vec3::Z)));
        mesh.normals.extend([turn * Vec3::Z; 4]);
        mesh.indices.extend(quad.indices.iter().map(|index| first + index));
    }
    finish(&mut mesh);
    mesh
}

/// The same surface, wound the other way.
fn reversed(mesh: &Mesh) -> Mesh {
    let mut mesh = mesh.clone();
    for triangle in mesh.indices.chunks_exact_mut(3) {
        triangle.swap(1, 2);
    }
    mesh
}

/// A mesh above the floor, half a metre wide.
fn floating(text: &str, mesh: Mesh, turn: Affine3A) -> Scene {
    let mut scene = stage(text);
    scene.meshes.push(Arc::new(mesh));
    scene.nodes.push(node(
        1,
        Affine3A::from_translation(Vec3::new(0.1, 0.0, 0.5)) * turn * Affine3A::from_scale(Vec3::splat(0.25)),
    ));
    sheet(&mut scene, 0.9, ALL, ALL);
    scene
}

#[test]
fn biases_are_options_of_their_own() {
    let Some(mut renderer) = renderer() else { return };
    // A sheet 0.1 above the floor: lost where the bias that is left is larger.
    for (text, casts) in [
        ("bias=0.05", true),
        ("bias=0.15", false),
        ("bias=0.15,max_bias=0.05", true),
        ("bias=0.05,slope_bias=8", true),
        ("bias=0.05,normal_offset=4", true),
    ] {
        let mut scene = stage(&format!("hard:resolution=16,{text}"));
        sheet(&mut scene, 0.5, ALL, ALL);
        sheet(&mut scene, 0.6, ALL, ALL);
        assert!(texels(&mut renderer, &scene, 8).all(if casts { 0.0 } else { 1.0 }), "{text}");
    }
    // Each of two is enough on a slope, and none is not.
    for (text, acne) in [
        ("slope_bias=0", true),
        ("slope_bias=1.05", false),
        ("slope_bias=0,normal_offset=1.5", false),
        ("slope_bias=0,bias=0.2", false),
        ("slope_bias=1.05,max_bias=0.01", true),
    ] {
        let scene = tilted(&format!("hard:resolution=32,{text}"), 1.0);
        assert_eq!(darkest_on_tilted(&mut renderer, &scene) < 1.0, acne, "{text}");
    }
}

#[test]
fn maps_of_back_faces_need_no_bias_on_closed_meshes() {
    let Some(mut renderer) = renderer() else { return };
    // Seen from where the source is: the lit hemisphere.
    for (faces, acne) in [("both", true), ("front", true), ("back", false)] {
        let mut scene =
            floating(&format!("hard:resolution=64,slope_bias=0,faces={faces}"), sphere(24), Affine3A::IDENTITY);
        scene.nodes.pop();
        let camera = Camera {
            projection: Projection::Orthographic { height: 0.34 },
            target: Vec3::new(0.1, 0.0, 0.0),
            position: Vec3::new(0.1, 0.0, 5.0),
            ..crate::common::front()
        };
        assert_eq!(see(&mut renderer, &scene, camera, 48, 48).min() < 1.0, acne, "{faces}");
    }
}

#[test]
fn maps_of_one_side_lose_open_meshes() {
    let Some(mut renderer) = renderer() else { return };
    // Its only face looks up, at the source.
    for (faces, turn, casts) in [
        ("back", 0.0, false),
        ("front", 0.0, true),
        ("both", 0.0, true),
        ("back", std::f32::consts::PI, true),
        ("front", std::f32::consts::PI, false),
    ] {
        let scene = floating(&format!("hard:resolution=64,faces={faces}"), quad(), Affine3A::from_rotation_x(turn));
        assert_eq!(texels(&mut renderer, &scene, 32).min() == 0.0, casts, "{faces}, turned by {turn}");
    }
}

#[test]
fn meshes_wound_the_wrong_way_cast_as_the_others_from_maps_of_both_sides() {
    let Some(mut renderer) = renderer() else { return };
    let look = |renderer: &mut Renderer, text: &str, mesh: Mesh, turn: Affine3A| {
        texels(renderer, &floating(&format!("hard:resolution=64,{text}"), mesh, turn), 64).lit
    };
    let turn = Affine3A::from_rotation_x(0.5);
    let expected = look(&mut renderer, "faces=both", cube(), turn);
    assert!(expected.contains(&0.0));
    assert_eq!(look(&mut renderer, "faces=both", reversed(&cube()), turn), expected);
    // A mirrored node turns the winding of its triangles, which is made up for.
    let mirror = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    for faces in ["front", "back"] {
        let text = format!("faces={faces}");
        let upright = look(&mut renderer, &text, cube(), turn);
        assert_eq!(look(&mut renderer, &text, cube(), turn * mirror), upright, "{faces}");
    }
    // A closed mesh casts the same shadow from either side of its surface.
    assert_eq!(look(&mut renderer, "faces=back", cube(), turn), expected);
}

/// The least bias without acne, in metres, by halving.
fn least_bias(renderer: &mut Renderer, angle: f32) -> f32 {
    let (mut low, mut high) = (0.0, 2.0);
    for _ in 0..9 {
        let middle = 0.5 * (low + high);
        let scene = tilted(&format!("hard:resolution=32,slope_bias=0,bias={middle}"), angle);
        if darkest_on_tilted(renderer, &scene) < 1.0 { low = middle } else { high = middle }
    }
    high
}

#[test]
fn one_slope_bias_suits_every_slope_and_no_constant_one_does() {
    let Some(mut renderer) = renderer() else { return };
    for technique in
        ["hard", "pcf", "pcf:kernel=box,radius=3", "pcf:kernel=poisson,radius=3", "pcf:receiver_plane=true,radius=3"]
    {
        for degrees in [0, 15, 30, 45, 60, 75, 85] {
            let mut scene = tilted(technique, (degrees as f32).to_radians());
            shadows(&mut scene).sources[0].settings.resolution = 32;
            let darkest = darkest_on_tilted(&mut renderer, &scene);
            assert_eq!(darkest, 1.0, "{technique} at {degrees}°");
        }
    }
    let [steep, shallow] = [85_f32, 30.0].map(|degrees| least_bias(&mut renderer, degrees.to_radians()));
    assert!(steep > 5.0 * shallow, "{steep} and {shallow}");
}

#[test]
fn sheets_nearer_than_the_bias_lose_their_shadow() {
    let Some(mut renderer) = renderer() else { return };
    let bias = 0.1;
    for (height, casts) in [(0.02, false), (0.0999, false), (0.1001, true), (0.3, true)] {
        let mut scene = stage(&format!("hard:resolution=16,slope_bias=0,bias={bias}"));
        sheet(&mut scene, 0.8 - height, ALL, ALL);
        sheet(&mut scene, 0.8, ALL, ALL);
        assert!(texels(&mut renderer, &scene, 8).all(if casts { 0.0 } else { 1.0 }), "{height}");
    }
}

#[test]
fn maps_of_back_faces_leave_a_slit_under_boxes() {
    let Some(mut renderer) = renderer() else { return };
    let (bias, texel) = (0.2, 4.0 / 256.0);
    for degrees in [30_f32, 45.0, 60.0] {
        let elevation = degrees.to_radians();
        let mut scene = stage(&format!("hard:resolution=256,slope_bias=0,bias={bias},faces=back"));
        let towards = Vec3::new(-elevation.cos(), 0.0, elevation.sin());
        shadows(&mut scene).sources[0].volume = Some(Camera {
            position: towards * 5.0,
            projection: Projection::Orthographic { height: 4.0 },
            near: 0.1,
            far: 20.0,
            ..above()
        });
        // The shadow falls to +x, from the box's foot at x = 0.5.
        scene.meshes.push(Arc::new(cube()));
        scene
            .nodes
            .push(node(1, Affine3A::from_scale_rotation_translation(Vec3::splat(0.5), Quat::IDENTITY, Vec3::Z * 0.5)));
        sheet(&mut scene, 1.0, ALL, ALL);
        let camera = from_below((0.7, 0.05), 0.4 / 400.0);
        let row = see(&mut renderer, &scene, camera, 400, 1).lit;
        // Pixels of a millimetre from x = 0.5; the floor below the box is not looked at.
        let slit = row.iter().take_while(|lit| **lit == 1.0).count() as f32 * 1e-3;
        let expected = bias * elevation.cos();
        assert!((slit - expected).abs() <= texel / elevation.sin(), "{degrees}°: {slit}, not {expected}");
    }
}

#[test]
fn a_bias_moves_no_edge_sideways() {
    let Some(mut renderer) = renderer() else { return };
    let mut edges = Vec::new();
    for bias in [0.0, 0.001, 0.01, 0.1] {
        let mut scene = stage(&format!("hard:resolution=512,bias={bias}"));
        shadows(&mut scene).sources[0].volume =
            Some(Camera { projection: Projection::Orthographic { height: 2.0 }, ..above() });
        sheet(&mut scene, 0.4, -3.0..0.1, ALL);
        sheet(&mut scene, 0.9, ALL, ALL);
        edges.push(crossing(&profile(&mut renderer, &scene, 0.001, 1024), 0.5));
    }
    assert!(edges.iter().all(|edge| edge.is_some() && *edge == edges[0]), "{edges:?}");
}
