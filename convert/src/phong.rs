//! Metallic-roughness to Phong and back.
//!
//! The mapping is chosen by measurement: `docs/techniques/phong-from-ggx.md` has the metric, the candidates and the
//! chart.
//!
//! **Spaces.** [`MetallicRoughness`] holds linear colours, as the factors of a glTF material are. [`Phong`] holds
//! sRGB-encoded colours, as an AAM document does. Texels need no change: glTF's base colour and AAM's diffuse layer
//! both store sRGB, and both multiply.

/// Reflectance at normal incidence of a dielectric with index of refraction 1.5, glTF's default.
pub const DEFAULT_F0: f32 = 0.04;

/// A metallic-roughness material without its textures. Colours are linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetallicRoughness {
    /// Base colour, linear, in `[0, 1]`.
    pub base_color: [f32; 3],
    /// 0 dielectric … 1 metal.
    pub metallic: f32,
    /// Perceptual roughness in `[0, 1]`; the GGX width is its square.
    pub roughness: f32,
    /// Reflectance at normal incidence of the dielectric part, linear, in `[0, 1]`: [`DEFAULT_F0`] unless
    /// `KHR_materials_specular`, `KHR_materials_ior` or specular-glossiness say otherwise. (Specular-glossiness is
    /// `base_color` = diffuse, `metallic` = 0, `roughness` = 1 − glossiness, `dielectric_f0` = specular.)
    pub dielectric_f0: [f32; 3],
}

impl Default for MetallicRoughness {
    /// glTF's default material.
    fn default() -> Self {
        Self { base_color: [1.0; 3], metallic: 1.0, roughness: 1.0, dielectric_f0: [DEFAULT_F0; 3] }
    }
}

/// The lighting terms of an AAM material. Colours are sRGB-encoded, as in the document.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Phong {
    /// Ambient reflectance, `Am:`.
    pub ambient: [f32; 3],
    /// Diffuse reflectance, `Di:`.
    pub diffuse: [f32; 3],
    /// Specular reflectance, `Sp:`.
    pub specular: [f32; 3],
    /// Phong exponent n of `(V·R)ⁿ`; 0 means no highlight. [`shininess`] makes it the `Sh:` of a document.
    pub exponent: f32,
}

/// The `Sh:` that stands for an exponent: `n/128` up to 128, `n` itself above.
pub fn shininess(exponent: f32) -> f32 {
    if exponent <= 128.0 { exponent / 128.0 } else { exponent }
}

/// sRGB encoding of one linear value in `[0, 1]` (IEC 61966-2-1); values outside are carried on by the same curve.
pub fn encode_srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The linear value of one sRGB-encoded value; the inverse of [`encode_srgb`].
pub fn decode_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The Phong material that shows most like this metallic-roughness one.
pub fn from_metallic_roughness(material: &MetallicRoughness) -> Phong {
    let metallic = material.metallic.clamp(0.0, 1.0);
    let alpha = material.roughness.clamp(0.0, 1.0).powi(2).max(1e-4);
    let f0: [f32; 3] = std::array::from_fn(|i| {
        let base = material.base_color[i].clamp(0.0, 1.0);
        material.dielectric_f0[i].clamp(0.0, 1.0) * (1.0 - metallic) + base * metallic
    });
    let largest = f0.iter().copied().fold(0.0, f32::max);
    let dielectric = material.dielectric_f0.iter().copied().fold(0.0, f32::max).clamp(0.0, 1.0);
    let diffuse: [f32; 3] =
        std::array::from_fn(|i| material.base_color[i].clamp(0.0, 1.0) * (1.0 - metallic) * (1.0 - dielectric));
    let exponent = (0.5 / (alpha * alpha) - 0.5).clamp(0.0, 1e4);
    let peak = (largest / (4.0 * alpha * alpha)).min(1.0);
    let specular = if exponent > 0.0 && largest > 0.0 { f0.map(|f| encode_srgb(f / largest * peak)) } else { [0.0; 3] };
    Phong {
        ambient: std::array::from_fn(|i| encode_srgb((diffuse[i] + f0[i]).min(1.0))),
        diffuse: diffuse.map(encode_srgb),
        specular,
        exponent,
    }
}

/// The metallic-roughness material that [`from_metallic_roughness`] takes nearest to this Phong one.
pub fn to_metallic_roughness(phong: &Phong) -> MetallicRoughness {
    let alpha = (1.0 / (2.0 * phong.exponent.max(0.0) + 1.0)).sqrt();
    MetallicRoughness {
        base_color: phong.diffuse.map(|value| decode_srgb(value.clamp(0.0, 1.0))),
        metallic: 0.0,
        roughness: alpha.sqrt(),
        dielectric_f0: phong.specular.map(|value| (decode_srgb(value.clamp(0.0, 1.0)) * 4.0 * alpha * alpha).min(1.0)),
    }
}
