//! What a material's textures hold where the model uses them: means weighted by surface area.
//!
//! Texture atlases have unused corners, so the mean over a whole picture says little. Each triangle is sampled on a
//! regular grid, about one sample for 2 × 2 texels of the largest picture (fewer where that would be too many), and each
//! sample counts by the area that it stands for.

use std::sync::{Arc, LazyLock};

use glam::Vec3;

use crate::phong;

use super::bake::{Pixels, occluded};
use super::model::UvTransform;
use super::primitive::Primitive;

/// Samples that a material gets at most, more or less.
const SAMPLES: f64 = (1 << 18) as f64;
/// Texels along an edge that one sample stands for.
const TEXELS: f64 = 2.0;
/// Parts that a triangle's edge is cut into, at least and at most, before the number of samples is bounded.
const PARTS: [f64; 2] = [4.0, 512.0];

/// The linear value of each stored sRGB value.
static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|value| phong::decode_srgb(value as f32 / 255.0)));

/// A picture and the coordinates that it is looked up with.
#[derive(Clone, Debug)]
pub(super) struct Slot {
    pub pixels: Arc<Pixels>,
    pub set: u32,
    pub transform: UvTransform,
}

/// The pictures of a material that are to be looked at.
#[derive(Clone, Debug, Default)]
pub(super) struct Slots {
    /// By [`BASE`], [`SURFACE`], [`EMISSIVE`], [`OCCLUSION`].
    pub pictures: [Option<Slot>; 4],
    pub occlusion_strength: f32,
    /// Whether occlusion darkens the base colour.
    pub bake_occlusion: bool,
}

/// Base colour.
pub(super) const BASE: usize = 0;
/// Metallic-roughness or specular-glossiness.
pub(super) const SURFACE: usize = 1;
/// Emission.
pub(super) const EMISSIVE: usize = 2;
/// Occlusion.
pub(super) const OCCLUSION: usize = 3;

/// The coordinates of a primitive for each picture.
type Lookups<'a> = [Option<&'a [[f32; 2]]>; 4];

impl Slots {
    fn lookups<'a>(&self, primitive: &'a Primitive) -> Lookups<'a> {
        [0, 1, 2, 3].map(|at| self.pictures[at].as_ref().and_then(|slot| primitive.uv(slot.set)))
    }

    /// Into how many parts each edge of a triangle is cut, for the picture that has most texels in it.
    fn parts(&self, uvs: &Lookups<'_>, triangle: &[u32; 3]) -> f64 {
        let texels = self.pictures.iter().zip(uvs).filter_map(|(slot, uvs)| {
            let slot = slot.as_ref()?;
            let [a, b, c] = triangle.map(|vertex| uvs.map_or([0.0; 2], |uvs| uvs[vertex as usize]).map(f64::from));
            let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            let scale = f64::from(slot.transform.scale[0]) * f64::from(slot.transform.scale[1]);
            Some((0.5 * doubled * scale).abs() * f64::from(slot.pixels.width) * f64::from(slot.pixels.height))
        });
        (texels.fold(0.0, f64::max) / (TEXELS * TEXELS)).sqrt().ceil().clamp(PARTS[0], PARTS[1])
    }
}

/// A mean and how much the values vary around it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Mean {
    sum: f64,
    squares: f64,
    weight: f64,
}

impl Mean {
    fn add(&mut self, value: f64, weight: f64) {
        self.sum += value * weight;
        self.squares += value * value * weight;
        self.weight += weight;
    }

    /// The mean, or a value where nothing was seen.
    pub(super) fn or(&self, otherwise: f32) -> f32 {
        if self.weight > 0.0 { (self.sum / self.weight) as f32 } else { otherwise }
    }

    /// The standard deviation.
    pub(super) fn deviation(&self) -> f32 {
        if self.weight <= 0.0 {
            return 0.0;
        }
        let mean = self.sum / self.weight;
        (self.squares / self.weight - mean * mean).max(0.0).sqrt() as f32
    }

    /// The mean square, or a value where nothing was seen.
    pub(super) fn square_or(&self, otherwise: f32) -> f32 {
        if self.weight > 0.0 { (self.squares / self.weight) as f32 } else { otherwise }
    }
}

/// What the pictures hold.
#[derive(Clone, Debug, Default)]
pub(super) struct Usage {
    /// Linear base colour as it will be written, by channel.
    pub base: [Mean; 3],
    /// Linear emission, by channel.
    pub emissive: [Mean; 3],
    /// Base colour times emission, by channel.
    pub base_emissive: [Mean; 3],
    /// The four channels of the surface picture as stored, 0 to 1; the first three decoded too for specular-glossiness.
    pub surface: [Mean; 4],
    pub surface_linear: [Mean; 3],
    /// What occlusion leaves of light.
    pub occlusion: Mean,
}

impl Usage {
    /// Looks at the pictures where these primitives use them.
    pub(super) fn of(slots: &Slots, primitives: &[&Primitive]) -> Self {
        let mut usage = Self::default();
        if slots.pictures.iter().all(Option::is_none) {
            return usage;
        }
        let mut wanted = 0.0;
        for primitive in primitives {
            let uvs = slots.lookups(primitive);
            wanted += primitive.triangles.iter().map(|triangle| slots.parts(&uvs, triangle).powi(2)).sum::<f64>();
        }
        let thin = (SAMPLES / wanted).min(1.0).sqrt();
        for primitive in primitives {
            let uvs = slots.lookups(primitive);
            for triangle in &primitive.triangles {
                let [a, b, c] = triangle.map(|at| Vec3::from(primitive.positions[at as usize]));
                let area = f64::from((b - a).cross(c - a).length());
                if area.is_finite() && area > 0.0 {
                    let parts = (slots.parts(&uvs, triangle) * thin).ceil().max(1.0);
                    usage.sample(slots, &uvs, triangle, parts as u32, area / (parts * parts));
                }
            }
        }
        usage
    }

    /// Samples the middle of each of the `parts`² small triangles.
    fn sample(&mut self, slots: &Slots, uvs: &Lookups<'_>, triangle: &[u32; 3], parts: u32, weight: f64) {
        let step = 1.0 / parts as f32;
        for row in 0..parts {
            for column in 0..2 * (parts - row) - 1 {
                // Upright triangles stand between the hanging ones.
                let shift = if column % 2 == 0 { 1.0 / 3.0 } else { 2.0 / 3.0 };
                let b = ((column / 2) as f32 + shift) * step;
                let c = (row as f32 + shift) * step;
                self.look(slots, uvs, triangle, [1.0 - b - c, b, c], weight);
            }
        }
    }

    fn look(&mut self, slots: &Slots, uvs: &Lookups<'_>, triangle: &[u32; 3], at: [f32; 3], weight: f64) {
        let texel = |number: usize| {
            let slot = slots.pictures[number].as_ref()?;
            let [a, b, c] = triangle.map(|vertex| uvs[number].map_or([0.0; 2], |uvs| uvs[vertex as usize]));
            let uv = [0, 1].map(|axis| a[axis] * at[0] + b[axis] * at[1] + c[axis] * at[2]);
            Some(slot.pixels.nearest(slot.transform.apply(uv)))
        };
        let plain = |value: u8| f32::from(value) / 255.0;
        let linear = |[r, g, b, _]: [u8; 4]| [r, g, b].map(|value| LINEAR[usize::from(value)]);
        let mut base = texel(BASE).map_or([1.0; 3], linear);
        if let Some([light, ..]) = texel(OCCLUSION) {
            let left = occluded(plain(light), slots.occlusion_strength);
            self.occlusion.add(left.into(), weight);
            if slots.bake_occlusion {
                base = base.map(|value| value * left);
            }
        }
        add(&mut self.base, base, weight);
        if let Some(stored) = texel(SURFACE) {
            add(&mut self.surface, stored.map(plain), weight);
            add(&mut self.surface_linear, linear(stored), weight);
        }
        if let Some(stored) = texel(EMISSIVE) {
            let emissive = linear(stored);
            add(&mut self.emissive, emissive, weight);
            add(&mut self.base_emissive, [0, 1, 2].map(|channel| base[channel] * emissive[channel]), weight);
        }
    }
}

fn add<const N: usize>(means: &mut [Mean; N], values: [f32; N], weight: f64) {
    for (mean, value) in means.iter_mut().zip(values) {
        mean.add(value.into(), weight);
    }
}
