//! `KHR_texture_transform` in the terms of an AAM texture block.
//!
//! In glTF's texture space (v down) the extension scales, turns and moves: with c, s the cosine and sine of the
//! rotation, `u' = c·sx·u + s·sy·v + ox`, `v' = −s·sx·u + c·sy·v + oy`. (The listing in the extension's text turns the
//! other way; its worked example, the sample model and every implementation turn this way: Khronos glTF issue 1563.)
//! With v up that is `R(rotation)·S(sx, sy)·uv + t`, `t = (s·sy + ox, 1 − c·sy − oy)`. AAM's block means
//! `½ + R(WA)·S(UT, VT)·(uv − ½ − (UO, VO))`, so `WA`, `UT` and `VT` are the extension's own numbers, and
//! `(UO, VO) = S⁻¹·R(−WA)·(½ − t) − ½`. That is exact unless a scale is zero.

use aam::document::Texture;
use glam::{DMat2, DVec2};

use super::model::UvTransform;

impl UvTransform {
    /// A texture coordinate after the transform, in glTF's space.
    pub(super) fn apply(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        if *self == Self::default() {
            return [u, v];
        }
        let (s, c) = f64::from(self.rotation).sin_cos();
        let [x, y] = [f64::from(u) * f64::from(self.scale[0]), f64::from(v) * f64::from(self.scale[1])];
        let moved = [c * x + s * y + f64::from(self.offset[0]), c * y - s * x + f64::from(self.offset[1])];
        moved.map(|value| value as f32)
    }

    /// Writes the transform into a texture block; false where the block cannot express it.
    pub(super) fn write(&self, texture: &mut Texture) -> bool {
        if *self == Self::default() {
            return true;
        }
        let (s, c) = f64::from(self.rotation).sin_cos();
        let scale = DVec2::new(self.scale[0].into(), self.scale[1].into());
        let moved = DVec2::new(s * scale.y + f64::from(self.offset[0]), 1.0 - c * scale.y - f64::from(self.offset[1]));
        let center = DVec2::splat(0.5);
        let offset = (DMat2::from_cols(DVec2::new(c, -s), DVec2::new(s, c)) * (center - moved)) / scale - center;
        let offset = offset.as_vec2();
        // What the block says, against what was asked, over the unit square.
        let turn = DMat2::from_cols(DVec2::new(c, s), DVec2::new(-s, c));
        let linear = turn * DMat2::from_diagonal(scale);
        let error = linear * (center + offset.as_dvec2()) - (center - moved);
        // An error that is not a number is no small one.
        if !offset.is_finite() || !(error.length() < TOLERANCE) {
            return false;
        }
        texture.rotation = [0.0, 0.0, self.rotation];
        texture.tiling = self.scale;
        texture.offset = offset.to_array();
        true
    }
}

/// Largest shift of the picture that rounding the offset may cause: a hundredth of a texel of a texture of 1024.
const TOLERANCE: f64 = 1e-5;
