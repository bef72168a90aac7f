//! The separable Gaussian blur, read through exponential maps: a receiver at the depth of what a single texel holds sees
//! that texel's weight. Digest requirements 52 to 59.

use super::*;
use crate::common::renderer;

const SIZE: u32 = 32;
const TEXEL: f32 = 2.0 / SIZE as f32;

/// A roof with a hole of one texel, the one at (16, 16), above a floor: what is lit are the weights of the kernel.
fn pinhole(radius: i32) -> Scene {
    let mut scene = stage(&format!("esm:resolution={SIZE},radius={radius}"));
    let hole = 0.0..TEXEL;
    sheet(&mut scene, 0.1, -3.0..0.0, ALL);
    sheet(&mut scene, 0.1, TEXEL..3.0, ALL);
    sheet(&mut scene, 0.1, hole.clone(), -3.0..0.0);
    sheet(&mut scene, 0.1, hole, TEXEL..3.0);
    sheet(&mut scene, 0.9, ALL, ALL);
    scene
}

#[test]
fn the_blur_is_the_outer_product_of_its_weights() {
    let Some(mut renderer) = renderer() else { return };
    for radius in 1..=10 {
        let seen = texels(&mut renderer, &pinhole(radius), SIZE);
        let weights = gaussian(radius);
        let weight = |offset: i32| {
            if offset.abs() > radius { 0.0 } else { weights[(offset + radius) as usize] }
        };
        let mut sum = 0.0;
        for y in 0..SIZE {
            for x in 0..SIZE {
                let expected = weight(x as i32 - 16) * weight(y as i32 - 16);
                let found = f64::from(seen.at(x, y));
                assert!(
                    (found - expected).abs() <= 1e-5 * expected + 1e-12,
                    "radius {radius} at ({x}, {y}): {found}, not {expected}"
                );
                sum += found;
            }
        }
        assert!((sum - 1.0).abs() < 1e-5, "radius {radius}: the weights sum to {sum}");
        // 2r + 1 samples: nothing comes from farther away, and something does from r texels.
        let along = |offset: i32| seen.at((16 + offset) as u32, 16);
        assert!(along(radius) > 0.0 && along(-radius) > 0.0);
        assert_eq!((along(radius + 1), along(-radius - 1)), (along(radius + 2), along(-radius - 2)));
        // Rows and columns are treated alike, to a few roundings.
        for offset in 0..=radius {
            let [a, b] = [along(offset), seen.at(16, (16 + offset) as u32)];
            assert!((a - b).abs() <= 2e-6 * a, "{a} and {b}");
            let [corner, product] = [seen.at((16 + offset) as u32, (16 + offset) as u32), a * b / along(0)];
            assert!((corner - product).abs() <= 4e-6 * product + 1e-12, "{corner} and {product}");
        }
    }
}

#[test]
fn the_weights_are_those_that_were_published() {
    let published: [&[f64]; 10] = [
        &[0.9734, 0.0133],
        &[0.5984, 0.1942, 0.0066],
        &[0.3990, 0.2421, 0.0540, 0.0044],
        &[0.2994, 0.2260, 0.0972, 0.0238, 0.0033],
        &[0.2396, 0.2001, 0.1166, 0.0474, 0.0134, 0.0027],
        &[0.1996, 0.1762, 0.1212, 0.0648, 0.0270, 0.0088, 0.0022],
        &[0.1712, 0.1562, 0.1186, 0.0749, 0.0393, 0.0172, 0.0063, 0.0019],
        &[0.1498, 0.1396, 0.1131, 0.0796, 0.0486, 0.0258, 0.0119, 0.0048, 0.0017],
        &[0.1332, 0.1260, 0.1067, 0.0808, 0.0547, 0.0332, 0.0180, 0.0087, 0.0038, 0.0015],
        &[0.1198, 0.1146, 0.1002, 0.0799, 0.0584, 0.0390, 0.0237, 0.0132, 0.0067, 0.0031, 0.0013],
    ];
    let Some(mut renderer) = renderer() else { return };
    for (radius, row) in (1..).zip(published) {
        let seen = texels(&mut renderer, &pinhole(radius), SIZE);
        let across: f32 = (0..SIZE).map(|y| seen.at(16, y)).sum();
        for (offset, weight) in row.iter().enumerate() {
            // The column's sum is the weight along the row. The first row was published without being normalised.
            let column: f32 = (0..SIZE).map(|y| seen.at(16 + offset as u32, y)).sum();
            assert_close(column, *weight, if radius == 1 { 5e-3 } else { 1.6e-4 });
        }
        assert!(across > 0.0);
    }
}

#[test]
fn constant_maps_are_kept() {
    let Some(mut renderer) = renderer() else { return };
    let look = |renderer: &mut Renderer, radius: u32| {
        // A sheet over everything: light is the warped difference of depths, not 0.
        let mut scene = stage(&format!("esm:resolution=16,exponent=1,radius={radius}"));
        sheet(&mut scene, 0.2, ALL, ALL);
        sheet(&mut scene, 0.9, ALL, ALL);
        texels(renderer, &scene, 16).lit
    };
    let expected = (-0.7_f64).exp();
    for radius in 1..=10 {
        for lit in look(&mut renderer, radius) {
            assert!((f64::from(lit) / expected - 1.0).abs() < 1e-6, "radius {radius}: {lit}, not {expected}");
        }
    }
}

#[test]
fn borders_do_not_wrap_and_darken_nothing() {
    let Some(mut renderer) = renderer() else { return };
    for technique in MOMENTS {
        for radius in [1, 5, 10] {
            let mut scene = stage(&format!("{technique}:resolution={SIZE},radius={radius}"));
            let floor = sheet(&mut scene, 0.9, ALL, ALL);
            let empty = texels(&mut renderer, &scene, SIZE);
            assert!(empty.min() > 0.999, "{technique}: a frame of {}", empty.min());
            sheet(&mut scene, 0.3, -3.0..-1.0 + 2.0 * TEXEL, ALL);
            let seen = texels(&mut renderer, &scene, SIZE);
            let last = 2 + radius;
            for x in 0..SIZE {
                let (lit, before) = (seen.at(x, 9), empty.at(x, 9));
                assert!((lit < before) == (x < last) || x + 1 >= last && lit <= before, "{technique}, {radius}: {x}");
            }
            assert_eq!(&seen.row(9)[last as usize..], &empty.row(9)[last as usize..]);
            assert!(scene.nodes.len() == 2 && floor.index() == 0);
        }
    }
}

#[test]
fn sizes_out_of_range_are_refused() {
    let Some(mut renderer) = renderer() else { return };
    for radius in [0, 11] {
        assert!(format!("evsm4:radius={radius}").parse::<ShadowSettings>().is_err());
        let mut scene = pinhole(1);
        shadows(&mut scene).sources[0].settings.radius = radius;
        let seen = texels(&mut renderer, &scene, 8);
        assert!(seen.all(1.0) && seen.stats.warnings[0].contains("a whole number from 1 to 10"));
    }
}

#[test]
fn all_moments_are_filtered_alike() {
    let Some(mut renderer) = renderer() else { return };
    // A share of two depths comes back from any number of channels.
    for radius in [2, 4, 7, 10] {
        let mut rows = Vec::new();
        for technique in MOMENTS {
            let mut scene = stage(&format!("{technique}:resolution={SIZE},radius={radius}"));
            sheet(&mut scene, 0.1, -3.0..0.0, ALL);
            sheet(&mut scene, 0.9, ALL, ALL);
            rows.push(profile(&mut renderer, &scene, 0.5 * TEXEL, SIZE));
        }
        for row in &rows[1..] {
            for (a, b) in row.iter().zip(&rows[0]) {
                assert!((a - b).abs() < 2e-3, "{radius}: {a} and {b}");
            }
        }
    }
}

#[test]
fn penumbras_are_as_wide_as_the_kernel() {
    let Some(mut renderer) = renderer() else { return };
    for radius in 3..=10 {
        let mut scene = stage(&format!("evsm4:resolution={SIZE},radius={radius}"));
        sheet(&mut scene, 0.1, -3.0..0.0, ALL);
        sheet(&mut scene, 0.9, ALL, ALL);
        let fine = profile(&mut renderer, &scene, 0.5 * TEXEL, 16 * SIZE);
        let width = penumbra(&fine) / 16.0;
        assert!((width / (0.85 * radius as f32) - 1.0).abs() < 0.15, "radius {radius}: {width}");
        // The ramp itself: 2r texels have a share of both, and none beyond has.
        let coarse = profile(&mut renderer, &scene, 0.5 * TEXEL, SIZE);
        let edges = (coarse[(15 - radius) as usize], coarse[(16 - radius) as usize], coarse[(16 + radius) as usize]);
        assert!(edges.0 < 1e-4 && edges.1 > 1e-5 && edges.2 > 0.9999, "{radius}: {edges:?}");
        assert!(coarse[(15 + radius) as usize] < 1.0);
    }
}
