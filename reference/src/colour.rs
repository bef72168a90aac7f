//! sRGB encoding (IEC 61966-2-1), continued above 1 for emission and lights.

use glam::Vec3;

/// From the encoded value to linear light.
pub(crate) fn decode(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// From linear light to the encoded value.
pub(crate) fn encode(value: f32) -> f32 {
    if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

/// [`decode`] for three channels.
pub(crate) fn decode_rgb(colour: Vec3) -> Vec3 {
    Vec3::new(decode(colour.x), decode(colour.y), decode(colour.z))
}

/// [`encode`] for three channels.
pub(crate) fn encode_rgb(colour: Vec3) -> Vec3 {
    Vec3::new(encode(colour.x), encode(colour.y), encode(colour.z))
}

/// Clamped to `[0, 1]`, 0 where it is not a number.
pub(crate) fn saturate(colour: Vec3) -> Vec3 {
    Vec3::new(saturate_one(colour.x), saturate_one(colour.y), saturate_one(colour.z))
}

/// [`saturate`] for one channel.
pub(crate) fn saturate_one(value: f32) -> f32 {
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}
