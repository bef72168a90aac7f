//! The material mapping: how near it is to GGX, and that it comes back.

#[path = "../examples/phong_from_ggx/lobe.rs"]
#[allow(dead_code, reason = "the example draws more than the test needs")]
mod lobe;

use aam_convert::phong::{
    MetallicRoughness, Phong, decode_srgb, encode_srgb, from_metallic_roughness, shininess, to_metallic_roughness,
};

#[test]
fn the_mapped_lobe_is_three_times_nearer_to_ggx_than_the_textbook_exponent() {
    let incidences = lobe::Incidence::all();
    let mut squares = [0.0; 4];
    for surface in &lobe::SURFACES {
        for step in 1..=10_u32 {
            let alpha = (0.1 * f64::from(step)).powi(2);
            for (sum, (_, candidate)) in squares.iter_mut().zip(lobe::CANDIDATES) {
                *sum += lobe::error(&incidences, surface, alpha, candidate(alpha, surface.f0)).rms.powi(2);
            }
        }
    }
    let [half_vector, quarter, half_width, chosen] = squares.map(|sum| (sum / 40.0).sqrt());
    println!("{half_vector:.4} {quarter:.4} {half_width:.4} {chosen:.4}");
    assert!(chosen < 0.075, "{chosen}");
    assert!(3.0 * chosen < quarter.min(half_vector).min(half_width));
}

/// Points of a grid in `[0, 1]`.
fn grid(steps: u32) -> impl Iterator<Item = f32> + Clone {
    (0..=steps).map(move |step| step as f32 / steps as f32)
}

/// The largest difference of any channel.
fn far(a: [f32; 3], b: [f32; 3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

const COLORS: [[f32; 3]; 5] = [[0.8, 0.8, 0.8], [1.0, 0.77, 0.34], [0.05, 0.3, 0.02], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]];

#[test]
fn metallic_roughness_comes_back() {
    let mut worst = (0.0_f32, 0.0_f32, 0.0_f32);
    for base_color in COLORS {
        for metallic in grid(10) {
            for roughness in grid(40).filter(|roughness| *roughness >= 0.05) {
                let material = MetallicRoughness { base_color, metallic, roughness, ..Default::default() };
                let phong = from_metallic_roughness(&material);
                let back = to_metallic_roughness(&phong);
                assert!(from_metallic_roughness(&back).same(&phong), "{material:?} {phong:?} {back:?}");
                // What is no brighter than a dielectric's 4 % looks the same as metal and as none.
                let dark = base_color.iter().all(|&value| value <= 0.04);
                if dark || (metallic > 0.0 && metallic < 1.0 && roughness > 0.82) {
                    continue;
                }
                worst.0 = worst.0.max(far(back.base_color, base_color));
                worst.1 = worst.1.max((back.metallic - metallic).abs());
                // Here the diffuse share turns, and two roughnesses give the same material.
                if (0.82..0.89).contains(&roughness) {
                    assert!((back.roughness - roughness).abs() < 0.08, "{material:?} {back:?}");
                } else {
                    worst.2 = worst.2.max((back.roughness - roughness).abs());
                }
                assert_eq!(back.dielectric_f0, [0.04; 3], "{material:?}");
            }
        }
    }
    println!("base colour {:.5}, metallic {:.5}, roughness {:.5}", worst.0, worst.1, worst.2);
    assert!(worst.0 < 0.01 && worst.1 < 0.01 && worst.2 < 0.01, "{worst:?}");
}

#[test]
fn foreign_phong_comes_back() {
    let (mut count, mut exact) = (0, 0);
    for diffuse in [0.0, 0.1, 0.35, 0.588, 0.8, 1.0] {
        for specular in [[0.1; 3], [0.5; 3], [0.9; 3], [1.0; 3], [0.9, 0.7, 0.3]] {
            for exponent in [0.0, 2.6, 5.0, 12.8, 32.0, 64.0, 128.0, 1000.0] {
                let phong = Phong { ambient: [0.2; 3], diffuse: [diffuse; 3], specular, exponent };
                let material = to_metallic_roughness(&phong);
                let back = from_metallic_roughness(&material);
                let context = format!("{phong:?} {material:?} {back:?}");
                if exponent == 0.0 {
                    assert_eq!((back.exponent, back.specular), (0.0, [0.0; 3]));
                } else if exponent >= 5.0 {
                    assert!(far(back.specular, specular) < 0.005, "{context}");
                    assert!((back.exponent / exponent - 1.0).abs() < 0.01, "{context}");
                }
                // The diffuse colour is kept where the surface leaves the body that much light, and does not itself
                // look as diffuse as that; else it is the nearest.
                let surface = if material.metallic > 0.0 { material.base_color } else { material.dielectric_f0 };
                let f0 = surface.into_iter().fold(0.0, f32::max);
                let black =
                    MetallicRoughness { base_color: [0.0; 3], metallic: 0.0, dielectric_f0: surface, ..material };
                let share = decode_srgb(from_metallic_roughness(&black).diffuse[0]);
                let light = decode_srgb(diffuse);
                count += 1;
                if light >= share && light - share <= 1.0 - f0 {
                    exact += 1;
                    assert!((back.diffuse[0] - diffuse).abs() < 0.004, "{context}");
                } else {
                    let nearest = encode_srgb(light.clamp(share, 1.0 - f0 + share));
                    assert!((back.diffuse[0] - nearest).abs() < 0.02, "{nearest} {context}");
                }
            }
        }
    }
    println!("{exact} of {count} keep their diffuse colour");
    assert!(2 * exact > count);
}

#[test]
fn the_ends_are_as_the_format_says() {
    let dielectric = |roughness| MetallicRoughness { roughness, metallic: 0.0, ..Default::default() };
    let rough = from_metallic_roughness(&dielectric(1.0));
    assert_eq!((rough.exponent, rough.specular), (0.0, [0.0; 3]));
    let smooth = from_metallic_roughness(&dielectric(0.05));
    assert!(smooth.exponent > 500.0, "{smooth:?}");
    let metal = from_metallic_roughness(&MetallicRoughness { roughness: 0.2, ..Default::default() });
    assert!(metal.diffuse[0] < 0.2 && metal.ambient[0] > 0.999 && metal.specular[0] > 0.999, "{metal:?}");
    assert_eq!((shininess(64.0), shininess(128.0), shininess(200.0)), (0.5, 1.0, 200.0));
}

#[test]
fn values_that_are_no_numbers_do_no_harm() {
    let phong = from_metallic_roughness(&MetallicRoughness {
        base_color: [f32::NAN; 3],
        metallic: f32::NAN,
        roughness: -1.0,
        dielectric_f0: [f32::INFINITY; 3],
    });
    assert!(phong.exponent.is_finite() && phong.diffuse.iter().chain(&phong.specular).all(|value| value.is_finite()));
    for exponent in [f32::NAN, f32::INFINITY, -1.0, 1e-30] {
        for value in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
            let phong = Phong { ambient: [value; 3], diffuse: [value; 3], specular: [1.0; 3], exponent };
            let back = to_metallic_roughness(&phong);
            assert!(back.roughness.is_finite() && back.metallic.is_finite(), "{phong:?} {back:?}");
            assert!(back.base_color.iter().chain(&back.dielectric_f0).all(|value| value.is_finite()));
        }
    }
}

#[test]
fn more_roughness_is_never_a_sharper_highlight() {
    for metallic in [0.0, 0.5, 1.0] {
        let exponents: Vec<f32> = grid(100)
            .map(|roughness| MetallicRoughness { base_color: [0.7; 3], metallic, roughness, ..Default::default() })
            .map(|material| from_metallic_roughness(&material).exponent)
            .collect();
        assert!(exponents.windows(2).all(|pair| pair[1] <= pair[0]), "{exponents:?}");
    }
}
