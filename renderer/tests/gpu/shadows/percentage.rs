//! Percentage-closer filtering and soft shadows. Digest requirements 38 to 44.

use glam::Vec3;

use super::hard::{darkest_on_tilted, tilted};
use super::*;
use crate::common::renderer;

const SIZE: u32 = 32;
const TEXEL: f32 = 2.0 / SIZE as f32;

/// Half a roof at a depth above the floor, with its edge at the middle of the map.
fn roof(text: &str, depth: f32) -> Scene {
    let mut scene = stage(&format!("{text},resolution={SIZE}"));
    sheet(&mut scene, depth, -3.0..0.0, ALL);
    sheet(&mut scene, 0.9, ALL, ALL);
    scene
}

#[test]
fn the_result_is_the_mean_of_comparisons() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = stage(&format!("pcf:kernel=box,radius=1,resolution={SIZE}"));
    // Around the texel (16, 16): the column before it, and two texels of its own column.
    sheet(&mut scene, 0.3, -TEXEL..0.0, -TEXEL..2.0 * TEXEL);
    sheet(&mut scene, 0.3, 0.0..TEXEL, 0.0..2.0 * TEXEL);
    sheet(&mut scene, 0.9, ALL, ALL);
    let seen = texels(&mut renderer, &scene, SIZE);
    assert_close(seen.at(16, 16), 4.0 / 9.0, 1e-6);
    assert_close(seen.at(17, 17), 1.0 - 2.0 / 9.0, 1e-6);
}

#[test]
fn kernels_have_the_weights_that_they_are_named_after() {
    let Some(mut renderer) = renderer() else { return };
    for radius in 1..=10 {
        for (kernel, weights) in
            [("box", vec![1.0 / f64::from(2 * radius + 1); (2 * radius + 1) as usize]), ("gaussian", gaussian(radius))]
        {
            let scene = roof(&format!("pcf:kernel={kernel},radius={radius}"), 0.4);
            let row = profile(&mut renderer, &scene, 0.5 * TEXEL, SIZE);
            for offset in -radius..radius {
                // Lit is what lies at or beyond the edge.
                let expected: f64 = weights.iter().rev().take((radius + 1 + offset) as usize).sum();
                assert_close(row[(16 + offset) as usize], expected, 1e-5);
            }
        }
    }
}

#[test]
fn penumbras_do_not_depend_on_height_and_grow_with_the_kernel() {
    let Some(mut renderer) = renderer() else { return };
    for kernel in ["box", "tent", "gaussian"] {
        let mut width = |radius: u32, depth: f32| {
            let row =
                profile(&mut renderer, &roof(&format!("pcf:kernel={kernel},radius={radius}"), depth), 0.02, 8 * SIZE);
            penumbra(&row) / 8.0
        };
        for radius in [2, 5, 10] {
            let widths = [0.1, 0.5, 0.8].map(|depth| width(radius, depth));
            assert!(widths.iter().all(|w| (w - widths[0]).abs() < 1.0), "{kernel}: {widths:?}");
        }
        let [small, large] = [width(3, 0.4), width(9, 0.4)];
        assert!((large / small - 19.0 / 7.0).abs() < 0.45, "{kernel}: {small} and {large}");
    }
}

#[test]
fn kernels_need_a_bias_that_grows_with_them() {
    let Some(mut renderer) = renderer() else { return };
    for radius in [1_u32, 4] {
        for degrees in [20_f32, 60.0] {
            let bound = std::f32::consts::SQRT_2 * (radius as f32 + 0.5) * TEXEL * degrees.to_radians().tan();
            for (bias, acne) in [(0.5 * bound, true), (1.05 * bound + 1e-4, false)] {
                let text = format!("pcf:kernel=box,resolution={SIZE},radius={radius},slope_bias=0,bias={bias}");
                let scene = tilted(&text, degrees.to_radians());
                assert_eq!(darkest_on_tilted(&mut renderer, &scene) < 1.0, acne, "radius {radius}, {degrees}°, {bias}");
            }
        }
    }
}

#[test]
fn equal_weights_band_and_scattered_samples_do_not() {
    let Some(mut renderer) = renderer() else { return };
    let levels = |renderer: &mut Renderer, kernel: &str| {
        let scene = roof(&format!("pcf:kernel={kernel},radius=4"), 0.4);
        let seen = see(renderer, &scene, from_below((0.0, 0.02), 0.1), 320, 16);
        let mut levels: Vec<u32> = seen.lit.iter().map(|lit| lit.to_bits()).collect();
        levels.sort_unstable();
        levels.dedup();
        (levels.len(), seen)
    };
    let (banded, _) = levels(&mut renderer, "box");
    assert!(banded <= 10, "{banded} levels of a kernel of 9");
    let (smooth, _) = levels(&mut renderer, "tent");
    assert!(smooth > 40, "{smooth}");
    let (scattered, seen) = levels(&mut renderer, "poisson");
    assert!(scattered > 15, "{scattered}");
    // Noise: rows differ where the edge is straight.
    assert!((1..16).any(|y| seen.row(y) != seen.row(0)));
}

/// A light of a size above a floor, and half a roof between them; everything at distances from the light.
fn blade(size: f32, blocker: f32, floor: f32, extra: &str) -> Scene {
    let mut scene = stage(&format!("pcss:resolution=512,samples=64,light_size={size}{extra}"));
    shadows(&mut scene).sources[0].volume = Some(Camera {
        projection: Projection::Perspective { fov_y: 0.9 },
        position: Vec3::Z,
        near: 0.5,
        far: 12.0,
        ..above()
    });
    sheet(&mut scene, blocker, -9.0..0.0, -9.0..9.0);
    sheet(&mut scene, floor, -9.0..9.0, -9.0..9.0);
    scene
}

/// The width of a penumbra as of equal weights over a disc: from the standard deviation of the edge's derivative, which
/// is a quarter of the diameter. Mean of several rows, for noise.
fn disc_penumbra(renderer: &mut Renderer, scene: &Scene, across: f32) -> f32 {
    let camera = Camera {
        position: Vec3::new(0.0, 0.1, -20.0),
        target: Vec3::new(0.0, 0.1, 0.0),
        ..from_below((0.0, 0.1), across / 8.0)
    };
    let seen = see(renderer, scene, camera, 256, 32);
    let mean: Vec<f32> = (0..256).map(|x| (0..32).map(|y| seen.at(x, y)).sum::<f32>() / 32.0).collect();
    let slopes: Vec<f32> = mean.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let total: f32 = slopes.iter().sum();
    let center = slopes.iter().enumerate().map(|(i, s)| i as f32 * s).sum::<f32>() / total;
    let variance = slopes.iter().enumerate().map(|(i, s)| (i as f32 - center).powi(2) * s).sum::<f32>() / total;
    4.0 * variance.max(0.0).sqrt() * across / 256.0
}

#[test]
fn penumbras_grow_as_similar_triangles_do() {
    let Some(mut renderer) = renderer() else { return };
    for (blocker, floor, size) in [(4.0, 8.0, 0.4), (4.0, 6.0, 0.4), (4.0, 10.0, 0.2), (6.0, 9.0, 0.6)] {
        let expected = (floor - blocker) / blocker * size;
        let width = disc_penumbra(&mut renderer, &blade(size, blocker, floor, ""), 3.0 * expected);
        assert!((width / expected - 1.0).abs() < 0.15, "{blocker}, {floor}, {size}: {width}, not {expected}");
    }
}

#[test]
fn without_blockers_all_is_lit_and_blockers_at_the_source_are_bounded() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = blade(0.5, 4.0, 8.0, "");
    scene.nodes.remove(0);
    let camera = Camera { position: Vec3::NEG_Z * 20.0, ..from_below((0.0, 0.0), 2.0) };
    assert!(see(&mut renderer, &scene, camera.clone(), 16, 16).all(1.0));
    for blocker in [0.5, 0.500_01, 0.51] {
        for size in [0.0, 0.5, 1e5] {
            let seen = see(&mut renderer, &blade(size, blocker, 8.0, ""), camera.clone(), 16, 16);
            assert!(seen.lit.iter().all(|lit| (0.0..=1.0).contains(lit)), "{blocker}, {size}");
        }
    }
}
