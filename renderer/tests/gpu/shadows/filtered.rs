//! What prefiltered maps have in common. Digest requirements 45 to 51, 59, 78 and 79.

use glam::{Affine3A, Quat, Vec3};

use super::*;
use crate::common::renderer;

const SIZE: u32 = 32;
const TEXEL: f32 = 2.0 / SIZE as f32;

#[test]
fn maps_have_the_channels_of_their_moments() {
    let Some(mut renderer) = renderer() else { return };
    for (technique, bytes) in [
        ("hard", 4),
        ("hard:bits=16", 2),
        ("pcf", 4),
        ("pcss", 4),
        ("esm", 4),
        ("vsm", 8),
        ("evsm2", 8),
        ("evsm4", 16),
        ("msm", 16),
    ] {
        let mut scene = stage(technique);
        shadows(&mut scene).sources[0].settings.resolution = SIZE;
        sheet(&mut scene, 0.5, ALL, ALL);
        let stats = texels(&mut renderer, &scene, 8).stats;
        assert_eq!(stats.shadow_bytes, bytes * u64::from(SIZE * SIZE), "{technique}");
    }
}

/// A plane alone under the source that loses this much depth per texel along x.
fn slope(text: &str, delta: f32) -> Scene {
    let mut scene = stage(text);
    let angle = (delta / TEXEL).atan();
    placed(
        &mut scene,
        Affine3A::from_rotation_translation(Quat::from_rotation_y(angle), Vec3::Z * 0.5)
            * Affine3A::from_scale(Vec3::new(3.0, 3.0, 1.0)),
    );
    scene
}

#[test]
fn lit_slopes_are_darkened_by_at_most_the_bound() {
    let Some(mut renderer) = renderer() else { return };
    let mut worst = [1.0_f32; 2];
    for radius in [1, 2, 3, 5, 10] {
        for delta in [0.001, 0.004, 0.0085, 0.012, 0.024, 0.035, 0.0475] {
            // Only where the plane is within the volume, and the kernel within the map.
            let half = (0.45 * TEXEL / delta).min(1.0 - 12.0 * TEXEL);
            for (technique, least) in [("evsm4", 0.88), ("vsm", 0.99), ("evsm2", 0.98)] {
                let scene = slope(&format!("{technique}:resolution={SIZE},radius={radius}"), delta);
                let seen = see(&mut renderer, &scene, from_below((0.0, 0.01), half / 64.0), 128, 1);
                let clear = (radius as f32 + 1.0) * TEXEL < 0.5 * TEXEL / delta - half;
                if clear || technique != "evsm4" {
                    assert!(seen.min() >= least, "{technique}, radius {radius}, {delta} a texel: {}", seen.min());
                    let place = usize::from(technique == "evsm4");
                    worst[place] = worst[place].min(seen.min());
                }
            }
        }
    }
    assert!(worst[1] < 0.95, "the darkening that is predicted is there: {}", worst[1]);
}

#[test]
fn two_depths_are_bounded_exactly() {
    let Some(mut renderer) = renderer() else { return };
    let radius = 6;
    let weights = gaussian(radius);
    for technique in MOMENTS {
        for (a, b) in [(0.1, 0.9), (0.3, 0.7), (0.05, 0.5)] {
            let mut scene = stage(&format!("{technique}:resolution={SIZE},radius={radius}"));
            sheet(&mut scene, a, -3.0..0.0, ALL);
            sheet(&mut scene, b, ALL, ALL);
            let row = profile(&mut renderer, &scene, 0.5 * TEXEL, SIZE);
            for offset in -radius..radius {
                let share: f64 = weights.iter().rev().take((radius + 1 + offset) as usize).sum();
                assert_close(row[(16 + offset) as usize], share, 2e-3);
            }
        }
    }
}

#[test]
fn bounds_are_never_below_what_they_bound() {
    let Some(mut renderer) = renderer() else { return };
    for radius in [2, 5] {
        let build = |text: &str| {
            let mut scene = stage(&format!("{text},resolution={SIZE},radius={radius}"));
            sheet(&mut scene, 0.15, -3.0..-0.25, ALL);
            sheet(&mut scene, 0.4, -0.5..0.25, -0.5..0.5);
            sheet(&mut scene, 0.55, -0.125..0.5, -0.75..0.25);
            sheet(&mut scene, 0.8, ALL, ALL);
            scene
        };
        let truth = texels(&mut renderer, &build("pcf:kernel=gaussian"), SIZE);
        for technique in MOMENTS {
            let seen = texels(&mut renderer, &build(&format!("{technique}:bleed_reduction=0")), SIZE);
            for (found, least) in seen.lit.iter().zip(&truth.lit) {
                assert!(*found >= least - 1e-3, "{technique}: {found} below {least}");
            }
        }
    }
}

#[test]
fn penumbras_do_not_depend_on_height() {
    let Some(mut renderer) = renderer() else { return };
    for technique in MOMENTS {
        let mut look = |depth: f32| {
            let mut scene = stage(&format!("{technique}:resolution={SIZE},radius=5"));
            sheet(&mut scene, depth, -3.0..0.0, ALL);
            sheet(&mut scene, 0.9, ALL, ALL);
            penumbra(&profile(&mut renderer, &scene, 0.5 * TEXEL, 8 * SIZE)) / 8.0
        };
        let widths = [0.1, 0.4, 0.7].map(&mut look);
        assert!(widths.iter().all(|width| (width - widths[0]).abs() < 0.25), "{technique}: {widths:?}");
    }
}

#[test]
fn shadows_on_a_floor_that_does_not_cast_are_where_they_were() {
    let Some(mut renderer) = renderer() else { return };
    let mut edge = |technique: &str, casts: bool| {
        let mut scene = stage(&format!("{technique}:resolution={SIZE},radius=4"));
        let roof = sheet(&mut scene, 0.3, -3.0..0.0, ALL);
        sheet(&mut scene, 0.6, ALL, ALL);
        if !casts {
            shadows(&mut scene).casters = Members::Only(vec![roof]);
        }
        let row = profile(&mut renderer, &scene, 0.5 * TEXEL, 8 * SIZE);
        crossing(&row, 0.5).unwrap() / 8.0
    };
    assert!((edge("evsm4", false) - edge("evsm4", true)).abs() <= 1.0);
    // The exponential map loses nearly the kernel's radius.
    let lost = edge("esm", true) - edge("esm", false);
    assert!((2.5..=5.0).contains(&lost), "{lost}");
    assert!(edge("evsm2", true) - edge("evsm2", false) > 2.0);
}
