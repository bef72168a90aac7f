//! Variance and exponential maps against their bounds computed on the CPU. Digest requirements 60 to 81.

use glam::Vec3;

use super::*;
use crate::common::{Random, renderer};

const SIZE: u32 = 32;
const TEXEL: f32 = 2.0 / SIZE as f32;

/// A sheet over a part of x, in texels, at a depth.
type Sheet = (f32, Range<i32>);

/// What a row of an unblurred map holds; 1 where there is nothing.
fn depths(sheets: &[Sheet]) -> Vec<f64> {
    let nearest = |x: i32| sheets.iter().filter(move |(_, span)| span.contains(&x)).map(|(depth, _)| f64::from(*depth));
    (0..SIZE as i32).map(|x| nearest(x).fold(1.0, f64::min)).collect()
}

fn chebyshev(mean: f64, square: f64, value: f64, least: f64) -> f64 {
    let variance = (square - mean * mean).max(least);
    if value <= mean { 1.0 } else { variance / (variance + (value - mean).powi(2)) }
}

/// What a technique makes of depths with weights at a receiver's depth.
fn bound(settings: &ShadowSettings, samples: &[(f64, f64)], receiver: f64) -> f64 {
    let mean = |f: &dyn Fn(f64) -> f64| samples.iter().map(|(weight, depth)| weight * f(*depth)).sum::<f64>();
    let (k, v) = (f64::from(settings.exponent), f64::from(settings.min_variance));
    let warped = |k: f64| {
        let warp = move |depth: f64| k.signum() * (k * depth).exp();
        let value = warp(receiver);
        chebyshev(mean(&warp), mean(&|depth| warp(depth).powi(2)), value, v * (k * value).powi(2))
    };
    let lit = match settings.technique.filter {
        ShadowFilter::Vsm => chebyshev(mean(&|d| d), mean(&|d| d * d), receiver, v),
        ShadowFilter::Esm => (mean(&|depth| (k * (depth - receiver)).exp())).min(1.0),
        ShadowFilter::Evsm2 => warped(k),
        ShadowFilter::Evsm4 => warped(k).min(warped(-k)),
        _ => unreachable!("no closed form here"),
    };
    let beta = f64::from(settings.bleed_reduction);
    let intensity = f64::from(settings.intensity);
    1.0 - intensity + intensity * ((lit - beta) / (1.0 - beta)).clamp(0.0, 1.0)
}

/// Sheets on top of each other, from the left to the right of the map.
fn stacked(text: &str, sheets: &[Sheet]) -> Scene {
    let mut scene = stage(&format!("{text},resolution={SIZE}"));
    for (depth, span) in sheets {
        let edge = |texel: i32| {
            if texel <= 0 {
                -3.0
            } else if texel >= SIZE as i32 {
                3.0
            } else {
                texel as f32 * TEXEL - 1.0
            }
        };
        sheet(&mut scene, *depth, edge(span.start)..edge(span.end), ALL);
    }
    scene
}

/// Compares all texels of a row with the bound; the last sheet is the receiver, whether it casts or not.
#[track_caller]
fn compare(renderer: &mut Renderer, text: &str, sheets: &[Sheet], receiver_casts: bool, tolerance: f64) {
    let mut scene = stacked(text, sheets);
    let settings = shadows(&mut scene).sources[0].settings;
    let (receiver, above) = sheets.split_last().unwrap();
    if !receiver_casts {
        let casters = (0..above.len() as u32).map(NodeId).collect();
        shadows(&mut scene).casters = Members::Only(casters);
    }
    let row = profile(renderer, &scene, 0.5 * TEXEL, SIZE);
    let held = depths(if receiver_casts { sheets } else { above });
    let radius = settings.radius as i32;
    let weights = gaussian(radius);
    for (x, found) in (0..SIZE as i32).zip(&row) {
        let tap = |i: i32| held[(x + i).clamp(0, SIZE as i32 - 1) as usize];
        let samples: Vec<_> = (-radius..=radius).zip(&weights).map(|(i, weight)| (*weight, tap(i))).collect();
        let expected = bound(&settings, &samples, f64::from(receiver.0));
        let apart = (f64::from(*found) - expected).abs();
        assert!(apart <= tolerance, "{settings} over {sheets:?} at texel {x}: {found}, not {expected}");
    }
}

const WHOLE: Range<i32> = 0..SIZE as i32;

#[test]
fn stacked_sheets_bleed_as_the_bound_says() {
    let Some(mut renderer) = renderer() else { return };
    // Casters, first receivers and second receivers of the published tables.
    for (a, b, c) in [(0.2, 0.3, 0.4), (0.2, 0.3, 0.32), (0.2, 0.5, 0.52), (0.2, 0.5, 0.6), (0.1, 0.6, 0.61)] {
        for technique in ["vsm:min_variance=1e-7", "evsm2", "evsm4", "esm", "evsm2:exponent=20", "evsm4:exponent=20"] {
            for radius in [3, 8] {
                let text = format!("{technique}{}radius={radius}", if technique.contains(':') { "," } else { ":" });
                compare(&mut renderer, &text, &[(a, 0..16), (b, WHOLE), (c, WHOLE)], true, 2e-3);
            }
        }
    }
}

#[test]
fn edges_of_receivers_over_a_deep_background_glow_as_the_bound_says() {
    let Some(mut renderer) = renderer() else { return };
    for (a, b, c) in [(0.2, 0.4, 0.9), (0.2, 0.25, 0.9), (0.38, 0.4, 0.9), (0.38, 0.4, 0.45), (0.39, 0.4, 0.9)] {
        for technique in ["vsm:radius=6,min_variance=1e-7", "evsm2:radius=6", "evsm4:radius=6", "esm:radius=6"] {
            // The receiver does not cast: what the map holds beside the caster is the background, below which nobody looks.
            let mut scene = stacked(technique, &[(a, 0..16), (c, WHOLE), (b, WHOLE)]);
            shadows(&mut scene).casters = Members::Only(vec![NodeId(0), NodeId(1)]);
            let settings = shadows(&mut scene).sources[0].settings;
            let held = depths(&[(a, 0..16), (c, WHOLE)]);
            let between = Camera {
                position: Vec3::new(0.0, 0.5 * TEXEL, 1.0 - 0.5 * (b + c)),
                target: Vec3::new(0.0, 0.5 * TEXEL, 2.0),
                near: 1e-4,
                ..from_below((0.0, 0.0), TEXEL)
            };
            let row = see(&mut renderer, &scene, between, SIZE, 1).lit;
            for (x, found) in (6..26_i32).zip(&row[6..26]) {
                let samples: Vec<_> =
                    (-6..=6).zip(gaussian(6)).map(|(i, weight)| (weight, held[(x + i) as usize])).collect();
                let expected = bound(&settings, &samples, f64::from(b));
                assert!(
                    (f64::from(*found) - expected).abs() < 4e-3,
                    "{technique} ({a}, {b}, {c}) at {x}: {found}, not {expected}"
                );
            }
        }
    }
}

#[test]
fn random_stacks_are_as_the_bounds_say() {
    let Some(mut renderer) = renderer() else { return };
    let mut random = Random(7);
    for round in 0..12 {
        let mut sheets: Vec<Sheet> = (0..3)
            .map(|_| {
                let [start, length] = [24.0, 12.0].map(|most| (most * random.next()) as i32);
                (0.05 + 0.8 * random.next(), start..start + 1 + length)
            })
            .collect();
        sheets.push((0.93, WHOLE));
        for technique in ["vsm", "esm:exponent=30", "evsm2:exponent=15", "evsm4:exponent=15", "evsm4"] {
            let more = "radius=4,bleed_reduction=0.1,intensity=0.8";
            let text = format!("{technique}{}{more}", if technique.contains(':') { "," } else { ":" });
            compare(&mut renderer, &text, &sheets, round % 2 == 0, 3e-3);
        }
    }
}

#[test]
fn the_worst_bleeding_is_the_closed_form() {
    let Some(mut renderer) = renderer() else { return };
    for ratio in [1.0_f32, 2.0, 4.0, 8.0] {
        let dy = 0.05;
        let (a, b, c) = (0.9 - dy - ratio * dy, 0.9 - dy, 0.9);
        let scene = stacked("vsm:radius=10,min_variance=1e-8", &[(a, 0..16), (b, WHOLE), (c, WHOLE)]);
        let row = profile(&mut renderer, &scene, 0.5 * TEXEL, 64 * SIZE);
        let worst = row.iter().copied().fold(0.0, f32::max);
        let expected = (ratio / (ratio + 2.0)).powi(2);
        assert!((worst / expected - 1.0).abs() < 0.02, "R = {ratio}: {worst}, not {expected}");
    }
}

#[test]
fn leaks_at_contact_are_the_closed_forms() {
    let Some(mut renderer) = renderer() else { return };
    let mut leak = |text: &str, s: f32| {
        let mut scene = stage(text);
        shadows(&mut scene).sources[0].settings.resolution = SIZE;
        sheet(&mut scene, 0.5 - s, ALL, ALL);
        sheet(&mut scene, 0.5, ALL, ALL);
        f64::from(texels(&mut renderer, &scene, 4).at(2, 2))
    };
    for s in [0.001, 0.003, 0.01, 0.02, 0.05, 0.1] {
        for k in [20.0, 40.0, 80.0] {
            let expected = (-f64::from(s) * k).exp();
            assert!((leak(&format!("esm:exponent={k}"), s) - expected).abs() < 2e-3, "esm {k} at {s}");
        }
        for v in [1e-6, 1e-5, 1e-4] {
            let s2 = f64::from(s).powi(2);
            assert!((leak(&format!("vsm:min_variance={v}"), s) - v / (v + s2)).abs() < 1e-2, "vsm {v} at {s}");
            for filter in ["evsm2", "evsm4"] {
                let k = 40.0;
                let apart = if filter == "evsm4" {
                    // The sharper of both warps, as seen from the receiver.
                    (1.0 - (-k * f64::from(s)).exp()).max((k * f64::from(s)).exp() - 1.0)
                } else {
                    1.0 - (-k * f64::from(s)).exp()
                };
                let expected = v * k * k / (v * k * k + apart.powi(2));
                let found = leak(&format!("{filter}:min_variance={v}"), s);
                assert!((found - expected).abs() < 1e-2, "{filter} {v} at {s}: {found}, not {expected}");
            }
        }
    }
    let half = leak("evsm4:min_variance=1e-6", 1e-3);
    assert!((half - 0.5).abs() < 0.05, "{half} at the root of the smallest variance");
}

#[test]
fn order_is_bound_then_bleeding_then_intensity() {
    let Some(mut renderer) = renderer() else { return };
    // Light of the exponential map at a depth is known: half a range below the caster with k = −2 ln P.
    for (lit, expected) in [(0.1_f64, 0.0), (0.6, 0.5), (0.3, 0.125)] {
        let k = -2.0 * lit.ln();
        let mut scene = stage(&format!("esm:exponent={k},bleed_reduction=0.2,resolution=8"));
        sheet(&mut scene, 0.25, ALL, ALL);
        sheet(&mut scene, 0.75, ALL, ALL);
        if k >= 1.0 {
            assert_close(texels(&mut renderer, &scene, 4).at(1, 1), expected, 1e-4);
            shadows(&mut scene).sources[0].settings.intensity = 0.75;
            assert_close(texels(&mut renderer, &scene, 4).at(1, 1), 0.25 + 0.75 * expected, 1e-4);
        }
    }
    let mut scene = stage("hard:intensity=0.75,resolution=8");
    sheet(&mut scene, 0.25, ALL, ALL);
    sheet(&mut scene, 0.75, ALL, ALL);
    assert!(texels(&mut renderer, &scene, 4).all(0.25));
}

#[test]
fn moving_the_source_away_changes_no_exponential_shadow() {
    let Some(mut renderer) = renderer() else { return };
    let mut rows = Vec::new();
    for away in [0.0, 0.17, 0.4] {
        let mut scene = stacked("esm:radius=4,exponent=40", &[(0.5, 0..16), (0.55, WHOLE)]);
        let volume = shadows(&mut scene).sources[0].volume.as_mut().unwrap();
        volume.position.z += away;
        rows.push(profile(&mut renderer, &scene, 0.5 * TEXEL, SIZE));
    }
    for row in &rows[1..] {
        assert!(row.iter().zip(&rows[0]).all(|(a, b)| (a - b).abs() < 1e-3), "{rows:?}");
    }
}

#[test]
fn exponents_that_leave_the_range_of_floats_are_refused() {
    let refused = |text: &str| text.parse::<ShadowSettings>().is_err();
    assert!(refused("esm:exponent=88") && refused("evsm4:exponent=88") && refused("evsm2:exponent=44,centred=false"));
    assert!(
        !refused("esm:exponent=87") && !refused("evsm4:exponent=87") && !refused("evsm4:exponent=43,centred=false")
    );
    assert!(refused("evsm4:bleed_reduction=1") && refused("vsm:min_variance=0") && refused("vsm:min_variance=-1"));
    // What is set past the text is not drawn, and lit.
    let Some(mut renderer) = renderer() else { return };
    let mut scene = stacked("evsm4:radius=2", &[(0.3, WHOLE), (0.9, WHOLE)]);
    for (exponent, centred) in [(90.0, true), (45.0, false), (f32::NAN, true)] {
        let settings = &mut shadows(&mut scene).sources[0].settings;
        (settings.exponent, settings.centred) = (exponent, centred);
        let seen = texels(&mut renderer, &scene, 4);
        assert!(
            seen.all(1.0) && seen.stats.warnings[0].contains("is not drawn: exponent"),
            "{:?}",
            seen.stats.warnings
        );
    }
}

#[test]
fn the_ends_of_the_range_are_sound() {
    let Some(mut renderer) = renderer() else { return };
    for technique in ["vsm", "esm", "evsm2", "evsm4", "evsm2:centred=false", "evsm4:centred=false", "msm"] {
        for k in [5.0, 20.0, 40.0, 43.0, 87.0] {
            for v in [1e-7, 1e-6, 3e-6, 1e-5, 1e-4] {
                for radius in [1, 10] {
                    for depth in [0.0, 1e-6, 1e-3, 0.5, 0.999, 1.0 - 1e-6, 1.0] {
                        let mut scene = stage(technique);
                        let source = &mut shadows(&mut scene).sources[0].settings;
                        (source.exponent, source.min_variance, source.radius, source.resolution) = (k, v, radius, 16);
                        if source.check().is_err() {
                            continue;
                        }
                        sheet(&mut scene, depth, ALL, ALL);
                        let seen = texels(&mut renderer, &scene, 4);
                        assert!(seen.min() > 0.99, "{technique}, k {k}, v {v}, r {radius} at {depth}: {}", seen.min());
                        assert!(seen.lit.iter().all(|lit| *lit <= 1.0));
                    }
                }
            }
        }
    }
}

#[test]
fn bleeding_of_two_warps_is_below_that_of_none() {
    let Some(mut renderer) = renderer() else { return };
    let most = |row: Vec<f32>| row.into_iter().fold(0.0, f32::max);
    let mut random = Random(3);
    for _ in 0..10 {
        let [a, dx, dy] = [0.2, 0.3, 0.15].map(|most| 0.01 + most * random.next());
        let sheets = [(a, 0..16), (a + dx, WHOLE), (a + dx + dy, WHOLE)];
        let mut bleeding = |text: &str| most(profile(&mut renderer, &stacked(text, &sheets), 0.5 * TEXEL, 8 * SIZE));
        let [none, two, one] = ["vsm:radius=5", "evsm4:radius=5", "evsm2:radius=5"].map(&mut bleeding);
        assert!(two <= none + 1e-3 && one <= none + 1e-3, "{sheets:?}: {none}, {two}, {one}");
        let residual = (2.0 * (40.0 * dy).exp() - 1.0).powi(-2) + 1e-6 * 40.0 * 40.0 + 1e-3;
        assert!(two <= residual, "{sheets:?}: {two} above {residual}");
    }
}

#[test]
fn light_is_monotonic_in_parameters() {
    let Some(mut renderer) = renderer() else { return };
    let mut sum = |text: &str, sheets: &[Sheet]| {
        profile(&mut renderer, &stacked(text, sheets), 0.5 * TEXEL, SIZE).iter().sum::<f32>()
    };
    let bleeding = [(0.3, 0..16), (0.5, WHOLE), (0.53, WHOLE)];
    let contact = [(0.5, WHOLE), (0.51, WHOLE)];
    let edge = [(0.3, 0..16), (0.8, WHOLE)];
    let mut falls = |text: &str, values: &[f32], sheets: &[Sheet]| {
        let sums: Vec<f32> = values.iter().map(|value| sum(&format!("{text}={value}"), sheets)).collect();
        assert!(sums.windows(2).all(|pair| pair[1] <= pair[0] + 1e-3), "{text}: {sums:?}");
    };
    falls("vsm:intensity", &[0.1, 0.4, 0.7, 1.0], &edge);
    falls("evsm4:intensity", &[0.1, 0.4, 0.7, 1.0], &edge);
    falls("evsm4:bleed_reduction", &[0.0, 0.1, 0.3, 0.6, 0.9], &edge);
    falls("vsm:bleed_reduction", &[0.0, 0.1, 0.3, 0.6, 0.9], &bleeding);
    falls("evsm4:exponent", &[5.0, 10.0, 20.0, 40.0, 80.0], &bleeding);
    falls("esm:exponent", &[20.0, 40.0, 80.0], &contact);
    falls("evsm4:exponent", &[5.0, 10.0, 20.0, 40.0], &contact);
    falls("vsm:min_variance", &[1e-3, 1e-4, 1e-5, 1e-6], &contact);
    falls("evsm4:min_variance", &[1e-3, 1e-4, 1e-5, 1e-6], &contact);
}

#[test]
fn glow_at_edges_grows_with_exponent_and_radius() {
    let Some(mut renderer) = renderer() else { return };
    let mut lost = |k: f32, radius: u32| {
        // A floor that does not cast: behind every edge is the end of the range.
        let mut scene = stacked(&format!("esm:exponent={k},radius={radius}"), &[(0.3, 0..16), (0.9, WHOLE)]);
        shadows(&mut scene).casters = Members::Only(vec![NodeId(0)]);
        profile(&mut renderer, &scene, 0.5 * TEXEL, 8 * SIZE)[..128].iter().filter(|lit| **lit > 0.5).count()
    };
    for radius in [3, 6] {
        let widths = [20.0, 40.0, 80.0].map(|k| lost(k, radius));
        assert!(widths[0] < widths[1] && widths[1] < widths[2], "{widths:?}");
    }
    assert!(lost(40.0, 3) < lost(40.0, 6));
}

#[test]
fn positive_warp_alone_glows_and_both_do_not() {
    let Some(mut renderer) = renderer() else { return };
    let mut glow = |technique: &str| {
        let mut scene = stacked(&format!("{technique}:radius=6"), &[(0.2, 0..16), (0.4, WHOLE)]);
        shadows(&mut scene).casters = Members::Only(vec![NodeId(0)]);
        profile(&mut renderer, &scene, 0.5 * TEXEL, SIZE)[12]
    };
    // Four texels inside of the shadow, where a share of a few percent sees the light.
    assert!(glow("evsm2") > 0.99 && glow("evsm4") < 0.1);
}

/// A source of 90° one metre above the floor.
fn lamp(text: &str, far: f32) -> Scene {
    let mut scene = stage(text);
    shadows(&mut scene).sources[0].volume = Some(Camera {
        projection: Projection::Perspective { fov_y: std::f32::consts::FRAC_PI_2 },
        near: 0.25,
        far,
        ..above()
    });
    scene
}

#[test]
fn depth_is_distance_from_the_source() {
    let Some(mut renderer) = renderer() else { return };
    let (near, far, k) = (0.25_f64, 2.0_f64, 10.0_f64);
    for (metric, radial) in [("auto", true), ("radial", true), ("planar", false)] {
        let mut scene = lamp(&format!("esm:exponent={k},metric={metric},resolution=256,radius=1"), far as f32);
        sheet(&mut scene, 0.6, ALL, ALL);
        sheet(&mut scene, 1.0, ALL, ALL);
        let seen = see(&mut renderer, &scene, from_below((0.0, 0.0), 1.8), 9, 9);
        for y in 0..9 {
            for x in 0..9 {
                let at = |i: u32| 1.8 * ((f64::from(i) + 0.5) / 9.0 - 0.5);
                let distance = if radial { at(x).hypot(at(y)).hypot(1.0) } else { 1.0 };
                // What hides it lies on the same ray, at 0.6 of its distance.
                let expected = (-k * 0.4 * distance / (far - near)).exp();
                assert_close(seen.at(x, y), expected, 2e-3);
            }
        }
    }
}

#[test]
fn beyond_the_far_sphere_is_lit_unless_depth_is_planar() {
    let Some(mut renderer) = renderer() else { return };
    for technique in MOMENTS {
        for (metric, corner_lit) in [("auto", true), ("planar", false)] {
            let mut scene = lamp(&format!("{technique}:metric={metric},resolution=64"), 1.2);
            sheet(&mut scene, 0.5, ALL, ALL);
            sheet(&mut scene, 1.0, ALL, ALL);
            let seen = see(&mut renderer, &scene, from_below((0.0, 0.0), 1.9), 32, 32);
            // The corner is √(1 + 2 · 0.92²) = 1.64 m away, the middle 1.
            assert!(seen.at(16, 16) < 0.05, "{technique}");
            assert_eq!(seen.at(0, 0) == 1.0, corner_lit, "{technique}, {metric}: {}", seen.at(0, 0));
        }
    }
    // From infinitely far away there is no distance.
    let mut scene = stacked("evsm4:radius=1", &[(0.3, WHOLE), (0.99, WHOLE)]);
    for metric in [DepthMetric::Auto, DepthMetric::Radial, DepthMetric::Planar] {
        shadows(&mut scene).sources[0].settings.metric = metric;
        assert!(texels(&mut renderer, &scene, 16).lit.iter().all(|lit| *lit < 1e-3), "{metric}");
    }
}
