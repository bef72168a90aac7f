//! Metallic-roughness to Phong and back.
//!
//! The mapping is chosen by measurement: `docs/techniques/phong-from-ggx.md` has the metric, the candidates and the
//! chart, and `cargo run -p aam-convert --example phong_from_ggx` redraws them.
//!
//! **Spaces.** [`MetallicRoughness`] holds linear colours, as the factors of a glTF material are. [`Phong`] holds
//! sRGB-encoded colours, as an AAM document does. Texels need no change: glTF's base colour and AAM's diffuse layer
//! both store sRGB, and both multiply.
//!
//! **The rule.** With α = roughness², F the reflectance at normal incidence (the mix of dielectric and metal) and B
//! the body's reflectance `base·(1 − metallic)·(1 − dielectric_f0)`, all linear, and F* the largest channel of F:
//!
//! ```text
//! share d(α) = 2.15 α^1.5 (1 − 0.82 α)         the part of the lobe so wide that it is diffuse
//! diffuse    = encode(B + d·F)
//! specular   = encode(F/F* · min(1, F*·(1/(4α²) − d)))       the lobe's peak above that part, hue kept
//! exponent   = (0.47/α + 1.9)/√F*              0 where specular is 0 (roughness of about 0.83 and above)
//! ambient    = encode(B + F)                   what comes back of light from everywhere
//! ```

/// Reflectance at normal incidence of a dielectric with index of refraction 1.5, glTF's default.
pub const DEFAULT_F0: f32 = 0.04;

/// Coefficient and fall of the diffuse share, fitted.
const SHARE: [f64; 2] = [2.15, 0.82];
/// The exponent's dependence on the lobe's width, fitted.
const WIDTH: [f64; 2] = [0.47, 1.9];
/// Narrower lobes than this are taken as this wide: a roughness of 0.032.
const MIN_ALPHA: f64 = 1e-3;
/// Where the lobe's peak equals its diffuse share, and the highlight ends.
const MAX_ALPHA: f64 = 0.684;
/// Where the diffuse share is largest.
const TOP_ALPHA: f64 = 0.6 / SHARE[1];
/// Exponents above this show no difference.
const MAX_EXPONENT: f64 = 1e4;
/// Encoded colours closer than this look the same, even in files with four decimals.
const SAME: f32 = 1.0 / 512.0;

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

impl Phong {
    /// Whether two materials look the same: colours within 1/512, exponents within 2 %. An exponent without specular
    /// colour, and a specular colour without exponent, mean nothing.
    pub fn same(&self, other: &Self) -> bool {
        self.distance(other) <= SAME
    }

    /// The largest difference of any channel, a tenth of the exponents' relative difference counting as much.
    fn distance(&self, other: &Self) -> f32 {
        let (a, b) = (self.highlight(), other.highlight());
        let colors = [(self.ambient, other.ambient), (self.diffuse, other.diffuse), (a.0, b.0)];
        let exponents = (a.1 - b.1).abs() / a.1.max(b.1).max(f32::MIN_POSITIVE);
        let channels = colors.into_iter().flat_map(|(a, b)| a.into_iter().zip(b)).map(|(a, b)| (a - b).abs());
        channels.fold(0.1 * exponents, |largest, value| if value > largest || value.is_nan() { value } else { largest })
    }

    /// Specular colour and exponent, both 0 where either is.
    fn highlight(&self) -> ([f32; 3], f32) {
        if self.exponent > 0.0 && self.specular.iter().any(|&value| value > 0.0) {
            (self.specular, self.exponent)
        } else {
            ([0.0; 3], 0.0)
        }
    }
}

/// The `Sh:` that stands for an exponent: `n/128` up to 128, `n` itself above.
pub fn shininess(exponent: f32) -> f32 {
    if exponent <= 128.0 { exponent / 128.0 } else { exponent }
}

/// sRGB encoding of one linear value in `[0, 1]` (IEC 61966-2-1); values outside are carried on by the same curve.
pub fn encode_srgb(linear: f32) -> f32 {
    encode(f64::from(linear)) as f32
}

/// The linear value of one sRGB-encoded value; the inverse of [`encode_srgb`].
pub fn decode_srgb(encoded: f32) -> f32 {
    decode(f64::from(encoded)) as f32
}

fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

fn decode(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

type Color = [f64; 3];

fn unit(value: f32) -> f64 {
    if value.is_nan() { 0.0 } else { f64::from(value).clamp(0.0, 1.0) }
}

fn largest(color: Color) -> f64 {
    color.into_iter().fold(0.0, f64::max)
}

fn sum(color: Color) -> f64 {
    color.into_iter().sum()
}

fn zip(a: Color, b: Color, f: impl Fn(f64, f64) -> f64) -> Color {
    std::array::from_fn(|i| f(a[i], b[i]))
}

/// The part of a lobe of width α that is as good as diffuse.
fn share(alpha: f64) -> f64 {
    SHARE[0] * alpha.powf(1.5) * (1.0 - SHARE[1] * alpha)
}

/// Height of the lobe above its diffuse share, for F = 1, where light and eye stand along the normal.
fn peak(alpha: f64) -> f64 {
    (0.25 / (alpha * alpha) - share(alpha)).max(0.0)
}

/// What [`from_metallic_roughness`] starts from: the reflectance of the body and of the surface, and the lobe's width.
#[derive(Clone, Copy)]
struct Reflectance {
    body: Color,
    surface: Color,
    alpha: f64,
}

fn phong_of(Reflectance { body, surface, alpha }: Reflectance) -> Phong {
    let strongest = largest(surface);
    let height = (strongest * peak(alpha)).min(1.0);
    let shines = height > 0.0 && alpha < MAX_ALPHA;
    let encoded = |color: Color| color.map(|value| encode(value.min(1.0)) as f32);
    Phong {
        ambient: encoded(zip(body, surface, |body, surface| body + surface)),
        diffuse: encoded(zip(body, surface, |body, surface| body + share(alpha) * surface)),
        specular: if shines { encoded(surface.map(|value| value / strongest * height)) } else { [0.0; 3] },
        exponent: if shines {
            ((WIDTH[0] / alpha + WIDTH[1]) / strongest.sqrt()).min(MAX_EXPONENT) as f32
        } else {
            0.0
        },
    }
}

/// The Phong material that shows most like this metallic-roughness one.
///
/// Values out of range are clamped.
pub fn from_metallic_roughness(material: &MetallicRoughness) -> Phong {
    let metallic = unit(material.metallic);
    let base = material.base_color.map(unit);
    let dielectric = material.dielectric_f0.map(unit);
    phong_of(Reflectance {
        body: base.map(|base| base * (1.0 - metallic) * (1.0 - largest(dielectric))),
        surface: zip(base, dielectric, |base, dielectric| dielectric * (1.0 - metallic) + base * metallic),
        alpha: unit(material.roughness).powi(2).max(MIN_ALPHA),
    })
}

/// The metallic-roughness material that [`from_metallic_roughness`] takes to this Phong one, or near it.
///
/// A material that the forward mapping made comes back: the same metallic, roughness and base colour. Any other gives
/// back its diffuse colour, highlight and exponent with a [`MetallicRoughness::dielectric_f0`] of its own, as far as
/// metallic-roughness has such a material; its ambient colour, for which metallic-roughness has no word, is not used.
/// The page names the bounds.
pub fn to_metallic_roughness(phong: &Phong) -> MetallicRoughness {
    let (specular, exponent) = phong.highlight();
    let given = Given {
        ambient: phong.ambient.map(|value| decode(unit(value))),
        diffuse: phong.diffuse.map(|value| decode(unit(value))),
        specular: specular.map(|value| decode(unit(value))),
        exponent: f64::from(exponent.max(0.0)).min(MAX_EXPONENT),
    };
    let own = given.own();
    // Of several that fit equally well, the one that glTF writes without an extension.
    let candidates = own.iter().copied().map(split).chain(own.iter().copied().map(fold));
    candidates
        .map(|material| (from_metallic_roughness(&material).distance(phong), material))
        .filter(|(distance, _)| *distance <= SAME)
        .min_by_key(|(distance, _)| (distance / 1e-4) as u32)
        .map_or_else(|| fold(given.foreign()), |(_, material)| material)
}

/// A Phong material, linear.
struct Given {
    ambient: Color,
    diffuse: Color,
    specular: Color,
    exponent: f64,
}

impl Given {
    /// F* that gives this exponent at a width.
    fn strongest(&self, alpha: f64) -> f64 {
        ((WIDTH[0] / alpha + WIDTH[1]) / self.exponent).powi(2)
    }

    /// Solves the forward rule, ambient and all. Without a highlight several widths are possible.
    fn own(&self) -> Vec<Reflectance> {
        let above = zip(self.ambient, self.diffuse, |ambient, diffuse| (ambient - diffuse).max(0.0));
        let widths = if self.exponent > 0.0 {
            vec![bisect(MIN_ALPHA, MAX_ALPHA, |alpha| self.strongest(alpha) * (1.0 - share(alpha)) > largest(above))]
        } else {
            // Only the diffuse share is left to tell how rough: of 4 % in a dielectric, of all colour in a metal.
            let dielectric = 1.0 - sum(above) / (3.0 * f64::from(DEFAULT_F0));
            let metal = sum(self.diffuse) / sum(self.ambient);
            let range = share(1.0)..=share(TOP_ALPHA);
            let told = [dielectric, metal].into_iter().filter(|wanted| range.contains(wanted));
            told.map(|wanted| bisect(TOP_ALPHA, 1.0, |alpha| share(alpha) > wanted)).chain([1.0]).collect()
        };
        let reflectance = |alpha| {
            let surface = above.map(|above| above / (1.0 - share(alpha)));
            let body = zip(self.ambient, surface, |ambient, surface| (ambient - surface).max(0.0));
            Reflectance { body, surface, alpha }
        };
        widths.into_iter().map(reflectance).collect()
    }

    /// Keeps diffuse colour, specular colour and exponent.
    fn foreign(&self) -> Reflectance {
        let default = f64::from(DEFAULT_F0);
        if self.exponent <= 0.0 {
            // Fully rough; its diffuse share must fit under the diffuse colour.
            let fits = self.diffuse.iter().all(|&diffuse| diffuse >= share(1.0) * default);
            let surface = [if fits { default } else { 0.0 }; 3];
            let body = zip(self.diffuse, surface, |diffuse, surface| diffuse - share(1.0) * surface);
            return Reflectance { body, surface, alpha: 1.0 };
        }
        let height = largest(self.specular);
        let clipped = height > 0.9999;
        let grey = self.specular.iter().all(|&value| value > 0.98 * height);
        let plastic = WIDTH[0] / (self.exponent * default.sqrt() - WIDTH[1]);
        let is_plastic = (MIN_ALPHA..MAX_ALPHA).contains(&plastic)
            && clipped
            && grey
            && default * peak(plastic) >= 1.0
            && self.diffuse.iter().any(|&diffuse| diffuse > share(plastic) * default);
        let alpha = if is_plastic {
            plastic
        } else {
            // F* ≤ 1 bounds the width from below.
            let narrowest = WIDTH[0] / (self.exponent - WIDTH[1]);
            let narrowest = if narrowest > 0.0 { narrowest.clamp(MIN_ALPHA, MAX_ALPHA) } else { MAX_ALPHA };
            bisect(narrowest, MAX_ALPHA, |alpha| self.strongest(alpha) * peak(alpha) > height)
        };
        let strongest = self.strongest(alpha).min(1.0);
        let surface = self.specular.map(|value| value / height * strongest);
        let body = zip(self.diffuse, surface, |diffuse, surface| (diffuse - share(alpha) * surface).max(0.0));
        Reflectance { body, surface, alpha }
    }
}

/// The value in `[low, high]` up to which `above` holds.
fn bisect(mut low: f64, mut high: f64, above: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if above(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Body and surface as a base colour and a metallic between a dielectric of the default reflectance and a metal.
fn split(Reflectance { body, surface, alpha }: Reflectance) -> MetallicRoughness {
    let f0 = f64::from(DEFAULT_F0);
    let full = body.map(|body| body / (1.0 - f0));
    // Per channel F = f0·(1 − m) + m·base and base = full/(1 − m); m from the sums of the channels.
    let (s, b) = (sum(surface) / 3.0, sum(full) / 3.0);
    let metallic = if s <= f0 {
        0.0
    } else {
        let q = b + s - 2.0 * f0;
        (2.0 * (s - f0) / (q + (q * q + 4.0 * f0 * (s - f0)).max(0.0).sqrt())).clamp(0.0, 1.0)
    };
    // What is all but one of the two is that one, and the rest rounding.
    let metallic = if (1e-4..1.0 - 1e-4).contains(&metallic) { metallic } else { metallic.round() };
    let base = if metallic > 0.5 {
        surface.map(|surface| (surface - f0 * (1.0 - metallic)) / metallic)
    } else {
        full.map(|full| full / (1.0 - metallic))
    };
    MetallicRoughness {
        base_color: base.map(|value| value.clamp(0.0, 1.0) as f32),
        metallic: metallic as f32,
        roughness: alpha.sqrt() as f32,
        dielectric_f0: [DEFAULT_F0; 3],
    }
}

/// Body and surface as a dielectric with a reflectance of its own, or as a metal where there is no body.
fn fold(Reflectance { body, surface, alpha }: Reflectance) -> MetallicRoughness {
    let f0 = f64::from(DEFAULT_F0);
    let roughness = alpha.sqrt() as f32;
    if largest(body) < 1e-4 && surface.iter().any(|&value| value > f0) {
        let base_color = surface.map(|value| value.min(1.0) as f32);
        return MetallicRoughness { base_color, metallic: 1.0, roughness, dielectric_f0: [DEFAULT_F0; 3] };
    }
    let plain = surface.iter().all(|&value| (value - f0).abs() < 0.01 * f0);
    let surface = if plain { [f0; 3] } else { surface.map(|value| value.min(1.0)) };
    let under = (1.0 - largest(surface)).max(1e-6);
    MetallicRoughness {
        base_color: body.map(|body| (body / under).min(1.0) as f32),
        metallic: 0.0,
        roughness,
        dielectric_f0: if plain { [DEFAULT_F0; 3] } else { surface.map(|value| value as f32) },
    }
}
