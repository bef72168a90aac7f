//! From light to a colour that can be shown: `docs/techniques/shading.md`, section 5.

use aam_scene::{Scene, ToneMap, exposure_factor};
use glam::{Mat3, Vec3};

use crate::colour;

/// More than this is as bright as this; it keeps the curves away from infinity.
const MOST: f32 = 65504.0;

/// Exposure and tone mapping.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Display {
    factor: f32,
    tone_map: ToneMap,
}

impl Display {
    pub(crate) fn new(scene: &Scene) -> Self {
        Self { factor: exposure_factor(scene.exposure), tone_map: scene.tone_map }
    }

    /// In `[0, 1]`; 0 where it is not a number.
    pub(crate) fn apply(&self, light: Vec3) -> Vec3 {
        let c = Vec3::from_array((light * self.factor).to_array().map(|c| if c > 0.0 { c.min(MOST) } else { 0.0 }));
        colour::saturate(match self.tone_map {
            ToneMap::Clamp => c,
            ToneMap::Reinhard => c / (1.0 + c),
            ToneMap::Aces => aces(c),
            ToneMap::Neutral => neutral(c),
        })
    }
}

/// S. Hill's fit of the reference rendering and output transforms of ACES, by rows.
fn aces(c: Vec3) -> Vec3 {
    let from_srgb = Mat3::from_cols(
        Vec3::new(0.59719, 0.07600, 0.02840),
        Vec3::new(0.35458, 0.90834, 0.13383),
        Vec3::new(0.04823, 0.01566, 0.83777),
    );
    let to_srgb = Mat3::from_cols(
        Vec3::new(1.60475, -0.10208, -0.00327),
        Vec3::new(-0.53108, 1.10813, -0.07276),
        Vec3::new(-0.07367, -0.00605, 1.07602),
    );
    let v = from_srgb * c;
    let above = v * (v + 0.024_578_6) - 0.000_090_537;
    let below = v * (0.983_729 * v + 0.432_951) + 0.238_081;
    to_srgb * (above / below)
}

/// Khronos PBR Neutral.
fn neutral(c: Vec3) -> Vec3 {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let least = c.min_element();
    let c = c - if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let peak = c.max_element();
    if peak < START {
        return c;
    }
    let room = 1.0 - START;
    let shown = 1.0 - room * room / (peak + room - START);
    let grey = 1.0 - 1.0 / (DESATURATION * (peak - shown) + 1.0);
    (c * (shown / peak)).lerp(Vec3::splat(shown), grey)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [ToneMap; 4] = [ToneMap::Clamp, ToneMap::Reinhard, ToneMap::Aces, ToneMap::Neutral];

    fn shown(tone_map: ToneMap, stops: f32, light: Vec3) -> Vec3 {
        Display::new(&Scene { tone_map, exposure: stops, ..Scene::default() }).apply(light)
    }

    #[test]
    fn clamping_is_the_default_and_exposure_doubles() {
        let light = Vec3::new(0.2, 0.7, 3.0);
        assert_eq!(Display::new(&Scene::default()).apply(light), Vec3::new(0.2, 0.7, 1.0));
        assert_eq!(shown(ToneMap::Clamp, 1.0, light), Vec3::new(0.4, 1.0, 1.0));
        assert_eq!(shown(ToneMap::Reinhard, 0.0, Vec3::ONE), Vec3::splat(0.5));
        // Published values: ACES of middle grey 0.18, and Neutral below its shoulder less its offset.
        assert!((shown(ToneMap::Aces, 0.0, Vec3::splat(0.18)).y - 0.1056).abs() < 2e-3);
        assert!((shown(ToneMap::Neutral, 0.0, Vec3::splat(0.5)) - Vec3::splat(0.46)).abs().max_element() < 1e-6);
    }

    #[test]
    fn curves_rise_stay_in_range_and_survive_everything() {
        for tone_map in ALL {
            let mut before = 0.0;
            for step in 0..2000 {
                let grey = (step as f32 * 0.02 - 20.0).exp2();
                let value = shown(tone_map, 0.0, Vec3::splat(grey)).y;
                assert!((0.0..=1.0).contains(&value) && value >= before, "{tone_map:?} {grey} {value}");
                before = value;
            }
            assert!(before > 0.98, "{tone_map:?} {before}");
            for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 1e38] {
                for stops in [0.0, 100.0, -100.0, f32::NAN] {
                    let value = shown(tone_map, stops, Vec3::new(odd, 0.5, 0.0));
                    assert!(value.is_finite() && value.min_element() >= 0.0 && value.max_element() <= 1.0);
                }
            }
        }
    }
}
