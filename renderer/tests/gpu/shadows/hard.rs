//! Maps whose depths are compared texel by texel. Digest requirements 12 to 19.

use glam::{Affine3A, Quat, Vec3};

use super::*;
use crate::common::renderer;

#[test]
fn nearer_and_equal_is_lit_farther_is_not() {
    let Some(mut renderer) = renderer() else { return };
    for (depth, lit) in [(0.499, 1.0), (0.5, 1.0), (0.501, 0.0)] {
        let mut scene = stage("hard:resolution=8,slope_bias=1");
        let caster = sheet(&mut scene, 0.5, ALL, ALL);
        // What is seen is the lower one; where it is the upper one, the caster has to be out of the way of the eye.
        let receiver = sheet(&mut scene, depth, ALL, ALL);
        shadows(&mut scene).casters = Members::Only(vec![caster]);
        shadows(&mut scene).receivers = Members::Only(vec![receiver]);
        let camera = if depth < 0.5 { crate::common::front() } else { from_below((0.0, 0.0), 2.0) };
        assert!(see(&mut renderer, &scene, camera, 8, 8).all(lit), "{depth}");
    }
}

#[test]
fn depths_are_never_averaged() {
    let Some(mut renderer) = renderer() else { return };
    let mut edges = Vec::new();
    for receiver in [0.3, 0.5, 0.75] {
        let mut scene = stage("hard:resolution=16,slope_bias=0");
        let caster = sheet(&mut scene, 0.2, -3.0..0.03, ALL);
        sheet(&mut scene, receiver, ALL, ALL);
        shadows(&mut scene).casters = Members::Only(vec![caster]);
        let row = profile(&mut renderer, &scene, 0.01, 256);
        assert!(row.iter().all(|lit| [0.0, 1.0].contains(lit)));
        edges.push(crossing(&row, 0.5));
    }
    assert!(edges[0].is_some() && edges.iter().all(|edge| *edge == edges[0]), "{edges:?}");
}

#[test]
fn eight_bits_are_too_few_for_a_hundred_metres() {
    let Some(mut renderer) = renderer() else { return };
    for (bits, acne) in [(8, true), (16, false), (24, false), (32, false)] {
        let mut darkest = 1.0_f32;
        for step in 0..12 {
            let mut scene = stage(&format!("hard:resolution=8,slope_bias=0,bias=0.01,bits={bits}"));
            shadows(&mut scene).sources[0].volume =
                Some(Camera { position: Vec3::Z * 50.0, near: 0.0, far: 100.0, ..above() });
            sheet(&mut scene, 0.37 + 0.83 * step as f32, ALL, ALL);
            let camera = Camera { position: Vec3::NEG_Z * 60.0, ..from_below((0.0, 0.0), 2.0) };
            darkest = darkest.min(see(&mut renderer, &scene, camera, 8, 8).min());
        }
        assert_eq!(darkest < 1.0, acne, "{bits} bits");
    }
}

/// A source of 60° one metre above the floor, and a caster half way whose edge runs along y, turned.
fn slanted_edge(resolution: u32, turn: f32) -> Scene {
    let mut scene = stage(&format!("hard:resolution={resolution}"));
    shadows(&mut scene).sources[0].volume = Some(Camera {
        projection: Projection::Perspective { fov_y: 60_f32.to_radians() },
        near: 0.1,
        far: 2.0,
        ..above()
    });
    placed(
        &mut scene,
        Affine3A::from_rotation_translation(Quat::from_rotation_z(turn), Vec3::Z * 0.5)
            * Affine3A::from_translation(Vec3::NEG_X),
    );
    sheet(&mut scene, 1.0, ALL, ALL);
    scene
}

/// Where the edge of the shadow is in each row, in metres.
fn edges(renderer: &mut Renderer, scene: &Scene, size: f32, width: u32, height: u32) -> Vec<f32> {
    let seen = see(renderer, scene, from_below((0.0, 0.0), size * height as f32 / width as f32), width, height);
    let at = |row| crossing(row, 0.5).unwrap() / width as f32 * size - 0.5 * size;
    (0..height).map(|y| at(seen.row(y))).collect()
}

#[test]
fn stairs_are_as_wide_as_a_texel() {
    let Some(mut renderer) = renderer() else { return };
    for resolution in [128, 256, 512, 1024] {
        let texel = 2.0 * 30_f32.to_radians().tan() / resolution as f32;
        let scene = slanted_edge(resolution, 0.6);
        let edges = edges(&mut renderer, &scene, 16.0 * texel, 320, 64);
        let steps: Vec<f32> =
            edges.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.2 * texel).collect();
        assert!(!steps.is_empty());
        for step in steps {
            assert!((step / texel - 1.0).abs() < 0.1, "{resolution}: {step}, not {texel}");
        }
    }
}

#[test]
fn twice_the_resolution_halves_the_error() {
    let Some(mut renderer) = renderer() else { return };
    let turn = 0.37_f32;
    let mut errors = Vec::new();
    for resolution in [64, 128, 256] {
        let scene = slanted_edge(resolution, turn);
        let (size, rows) = (0.6, 64_u32);
        let edges = edges(&mut renderer, &scene, size, 512, rows);
        // From below, at y the edge is at x = −y tan(turn).
        let height = size * rows as f32 / 512.0;
        let error = edges.iter().enumerate().map(|(row, edge)| {
            let y = (row as f32 + 0.5) / rows as f32 * height - 0.5 * height;
            (edge + y * turn.tan()).abs()
        });
        errors.push(error.sum::<f32>() / rows as f32);
    }
    for pair in errors.windows(2) {
        assert!((pair[0] / pair[1] / 2.0 - 1.0).abs() < 0.2, "{errors:?}");
    }
}

#[test]
fn shadows_move_when_casters_cross_texels_and_soft_ones_by_less() {
    let Some(mut renderer) = renderer() else { return };
    for (technique, most) in [("hard", 1.0), ("pcf", 0.26), ("vsm:radius=4", 0.31), ("evsm4:radius=4", 0.31)] {
        let mut rows: Vec<Vec<f32>> = Vec::new();
        for frame in 0..=40 {
            let mut scene = stage(technique);
            shadows(&mut scene).sources[0].settings.resolution = 64;
            sheet(&mut scene, 0.3, -3.0..0.005 + frame as f32 * 0.1 * (2.0 / 64.0), ALL);
            sheet(&mut scene, 0.9, ALL, ALL);
            rows.push(profile(&mut renderer, &scene, 0.015_625, 64));
        }
        let jump = |pair: &[Vec<f32>]| pair[0].iter().zip(&pair[1]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        let jumps: Vec<f32> = rows.windows(2).map(jump).filter(|jump| *jump > 0.0).collect();
        // A tenth of a texel a frame: one frame in ten.
        assert_eq!(jumps.len(), 4, "{technique}");
        assert!(jumps.iter().all(|jump| *jump <= most), "{technique}: {jumps:?}");
    }
}

#[test]
fn casters_end_at_the_volume() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = stage("hard:resolution=64");
    sheet(&mut scene, 0.4, 1.1..2.0, ALL);
    sheet(&mut scene, 0.9, ALL, ALL);
    assert!(texels(&mut renderer, &scene, 64).all(1.0), "a caster outside casts nothing");
    // One that leaves through the side, and one that leaves through the near end.
    let mut scene = stage("hard:resolution=64");
    sheet(&mut scene, 0.4, 0.5..2.0, ALL);
    let tilted =
        Affine3A::from_translation(Vec3::new(-0.5, 0.0, 1.0)) * Affine3A::from_rotation_y(-std::f32::consts::FRAC_PI_4);
    placed(&mut scene, tilted * Affine3A::from_scale(Vec3::new(0.4, 3.0, 1.0)));
    sheet(&mut scene, 0.9, ALL, ALL);
    let seen = see(&mut renderer, &scene, from_below((0.0, 0.0), 4.0 / 128.0), 128, 1);
    let half = 0.4 * std::f32::consts::FRAC_1_SQRT_2;
    for (index, lit) in seen.lit.iter().enumerate() {
        let x = (index as f32 + 0.5) / 32.0 - 2.0;
        let near_edge = [0.5, 1.0, -0.5, -0.5 - half].iter().any(|edge| (x - edge).abs() < 0.04);
        let dark = (0.5..1.0).contains(&x) || (-0.5 - half..-0.5).contains(&x);
        assert!(near_edge || *lit == f32::from(u8::from(!dark)), "{x}: {lit}");
    }
}

/// A plane alone under the source, tilted about a diagonal of the texels.
pub(super) fn tilted(text: &str, angle: f32) -> Scene {
    let mut scene = stage(text);
    let axis = Vec3::new(1.0, -1.0, 0.0).normalize();
    let local = Affine3A::from_rotation_translation(Quat::from_axis_angle(axis, angle), Vec3::Z * 0.5)
        * Affine3A::from_scale(Vec3::new(20.0, 20.0, 1.0));
    placed(&mut scene, local);
    // Deep enough for the steepest plane.
    shadows(&mut scene).sources[0].volume = Some(Camera { position: Vec3::Z * 40.0, far: 80.0, ..above() });
    scene
}

pub(super) fn darkest_on_tilted(renderer: &mut Renderer, scene: &Scene) -> f32 {
    let camera = Camera { position: Vec3::NEG_Z * 50.0, ..from_below((0.003, 0.002), 1.2) };
    see(renderer, scene, camera, 61, 61).min()
}

#[test]
fn acne_ends_at_the_bound() {
    let Some(mut renderer) = renderer() else { return };
    let texel = 2.0 / 32.0;
    for angle in [10_f32, 45.0, 80.0] {
        let bound = texel / std::f32::consts::SQRT_2 * angle.to_radians().tan();
        for (bias, acne) in [(0.0, true), (0.5 * bound, true), (1.05 * bound + 1e-4, false)] {
            let scene = tilted(&format!("hard:resolution=32,slope_bias=0,bias={bias}"), angle.to_radians());
            assert_eq!(darkest_on_tilted(&mut renderer, &scene) < 1.0, acne, "{angle}° with a bias of {bias}");
        }
    }
}
