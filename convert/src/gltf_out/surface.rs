//! Phong terms under a diffuse texture.
//!
//! AAM's diffuse texel T multiplies the whole lit colour, glTF's only the base colour. A highlight S of AAM is thus seen as
//! T·S, and of glTF's untinted constants `S · ΣT² / ΣT` over the surface is the one that the importer takes back to S (it
//! writes the constant whose product with T comes nearest in least squares). Metals need nothing: glTF tints their highlight
//! too.

use aam::document::Layer;
use aam_scene::Image;
use glam::Vec3;

use crate::phong::{self, MetallicRoughness, Phong, from_metallic_roughness, to_metallic_roughness};

use super::image::bilinear;
use super::model::{Model, Variant};

/// Samples that a material gets at most, more or less.
const SAMPLES: f64 = (1 << 18) as f64;

/// `ΣT / ΣT²` of the linear diffuse texel, by channel, over the surface that a variant covers.
pub(super) fn untint(model: &Model<'_>, variant: &Variant, texture: &Image) -> [f32; 3] {
    let layer = Layer::Diffuse as usize;
    let Some(map) = model.leaf(variant).and_then(|leaf| leaf.layers[layer].as_ref()) else { return [1.0; 3] };
    let texels = f64::from(texture.width) * f64::from(texture.height);
    let mut triangles = Vec::new();
    for &of in &variant.uses {
        let (mesh, subset) = (&model.meshes[of.0], model.subset(of));
        let vertices = &model.document.objects()[of.0].vertices;
        let corners = &mesh.corners[3 * subset.first..3 * (subset.first + subset.count)];
        for (corners, uvs) in corners.chunks_exact(3).zip(model.uvs(of, Layer::Diffuse).chunks_exact(3)) {
            let [a, b, c] = [0, 1, 2].map(|at| Vec3::from(vertices[corners[at] as usize]).as_dvec3());
            let area = (b - a).cross(c - a).length();
            let uvs = [0, 1, 2].map(|at| map.transform.transform_point2(uvs[at]).as_dvec2());
            let covered = 0.5 * (uvs[1] - uvs[0]).perp_dot(uvs[2] - uvs[0]).abs() * texels;
            if area > 0.0 && area.is_finite() {
                // About one sample for two by two texels.
                triangles.push((uvs, area, (0.25 * covered).sqrt().ceil().clamp(4.0, 512.0)));
            }
        }
    }
    let wanted: f64 = triangles.iter().map(|(_, _, parts)| parts * parts).sum();
    let thin = (SAMPLES / wanted).min(1.0).sqrt();
    let (mut sums, mut squares) = ([0.0_f64; 3], [0.0_f64; 3]);
    for (uvs, area, parts) in triangles {
        let parts = (parts * thin).ceil().max(1.0) as u32;
        let weight = area / f64::from(parts * parts);
        for row in 0..parts {
            for column in 0..2 * (parts - row) - 1 {
                let shift = if column % 2 == 0 { 1.0 / 3.0 } else { 2.0 / 3.0 };
                let b = (f64::from(column / 2) + shift) / f64::from(parts);
                let c = (f64::from(row) + shift) / f64::from(parts);
                let at = uvs[0] * (1.0 - b - c) + uvs[1] * b + uvs[2] * c;
                let texel = bilinear(texture, at.x, at.y);
                for channel in 0..3 {
                    let value = f64::from(phong::decode_srgb(texel[channel]));
                    sums[channel] += weight * value;
                    squares[channel] += weight * value * value;
                }
            }
        }
    }
    let total = |channel: usize| squares[channel] / sums[channel];
    // Where the texture is black, nothing is seen whatever the highlight.
    [0, 1, 2].map(|channel| if total(channel) > 1e-3 { (1.0 / total(channel)) as f32 } else { 1.0 })
}

/// The metallic-roughness material of Phong terms whose untinted parts were multiplied by `untint`.
pub(super) fn untinted(phong: &Phong, untint: [f32; 3]) -> (MetallicRoughness, Phong) {
    let plain = to_metallic_roughness(phong);
    let fits = |material: &MetallicRoughness, phong: &Phong| from_metallic_roughness(material).same(phong);
    if untint.iter().all(|factor| (factor - 1.0).abs() < 1e-3) || plain.metallic > 0.99 && fits(&plain, phong) {
        return (plain, *phong);
    }
    let bare = |roughness: f32| {
        from_metallic_roughness(&MetallicRoughness {
            base_color: [0.0; 3],
            metallic: 0.0,
            roughness,
            ..MetallicRoughness::default()
        })
    };
    let linear = |color: [f32; 3]| color.map(phong::decode_srgb);
    let spread =
        |phong: &Phong| linear(phong.ambient).iter().zip(linear(phong.diffuse)).map(|(a, d)| a - d).sum::<f32>();
    // What a dielectric with this exponent or, without a highlight, with this much ambient above its diffuse gives back.
    let roughness = bisect(|roughness| {
        let bare = bare(roughness);
        if phong.exponent > 0.0 {
            bare.exponent > phong.exponent
        } else {
            bare.exponent > 0.0 || untint.iter().sum::<f32>() / 3.0 * spread(&bare) < spread(phong)
        }
    });
    let bare = bare(roughness);
    let without = |whole: [f32; 3], part: [f32; 3]| -> [f32; 3] {
        let (whole, part) = (linear(whole), linear(part));
        std::array::from_fn(|channel| {
            phong::encode_srgb((whole[channel] - (untint[channel] - 1.0) * part[channel]).max(0.0))
        })
    };
    let specular = linear(phong.specular);
    let specular = std::array::from_fn(|channel| phong::encode_srgb((specular[channel] / untint[channel]).min(1.0)));
    let dielectric = Phong {
        ambient: without(phong.ambient, bare.ambient),
        diffuse: without(phong.diffuse, bare.diffuse),
        specular,
        exponent: phong.exponent,
    };
    let material = to_metallic_roughness(&dielectric);
    if material.metallic == 0.0 && material.dielectric_f0 == [phong::DEFAULT_F0; 3] && fits(&material, &dielectric) {
        return (material, dielectric);
    }
    if let Some(material) = half_metal(phong, untint) {
        return (material, from_metallic_roughness(&material));
    }
    let highlight = Phong { specular, ..*phong };
    (to_metallic_roughness(&highlight), highlight)
}

/// The material between dielectric and metal that the importer takes to these terms, if there is one. For a metallic and a
/// roughness the diffuse colour gives the base colour; the pair that fits the other terms best is searched for, from a
/// grid down (the exponent does not fall evenly with roughness, so that nothing simpler finds it).
fn half_metal(phong: &Phong, untint: [f32; 3]) -> Option<MetallicRoughness> {
    const STARTS: usize = 8;
    const ROUNDS: u32 = 24;
    if phong.exponent <= 0.0 {
        return None;
    }
    let wanted = phong.diffuse.map(phong::decode_srgb);
    let attempt = |metallic: f32, roughness: f32| {
        let (metallic, roughness) = (metallic.clamp(0.0, 1.0), roughness.clamp(0.0, 1.0));
        let black =
            MetallicRoughness { base_color: [0.0; 3], metallic: 0.0, roughness, ..MetallicRoughness::default() };
        let share = phong::decode_srgb(from_metallic_roughness(&black).diffuse[0]) / phong::DEFAULT_F0;
        let surface = share * phong::DEFAULT_F0 * (1.0 - metallic);
        let body = (1.0 - metallic) * (1.0 - phong::DEFAULT_F0) + share * metallic;
        let base = |channel: usize| ((wanted[channel] - untint[channel] * surface) / body.max(1e-6)).clamp(0.0, 1.0);
        let material = MetallicRoughness { base_color: std::array::from_fn(base), metallic, ..black };
        (far(&tinted(&material, untint), phong), material)
    };
    let grid = (0..=40_u8).flat_map(|m| (1..=40_u8).map(move |r| (f32::from(m) / 40.0, f32::from(r) / 40.0)));
    let mut starts: Vec<_> = grid.map(|(metallic, roughness)| attempt(metallic, roughness)).collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    starts.truncate(STARTS);
    let refined = starts.into_iter().map(|mut best| {
        let mut step = 0.025;
        for _ in 0..ROUNDS {
            let (metallic, roughness) = (best.1.metallic, best.1.roughness);
            let around = [-step, 0.0, step].into_iter().flat_map(|m| [-step, 0.0, step].map(|r| (m, r)));
            let next = around.map(|(m, r)| attempt(metallic + m, roughness + r)).min_by(|a, b| a.0.total_cmp(&b.0));
            match next {
                Some(next) if next.0 < best.0 => best = next,
                _ => step *= 0.5,
            }
        }
        best
    });
    let (distance, material) = refined.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (distance < 1.0 / 256.0).then_some(material)
}

/// The largest difference of any colour, or a tenth of the exponents' relative one.
fn far(a: &Phong, b: &Phong) -> f32 {
    let colors = [(a.ambient, b.ambient), (a.diffuse, b.diffuse), (a.specular, b.specular)];
    let exponents = 0.1 * (a.exponent - b.exponent).abs() / a.exponent.max(b.exponent).max(f32::MIN_POSITIVE);
    colors.iter().flat_map(|(a, b)| a.iter().zip(b)).map(|(a, b)| (a - b).abs()).fold(exponents, f32::max)
}

/// What the importer makes of a material under a texture: what the dielectric surface gives back is multiplied.
fn tinted(material: &MetallicRoughness, untint: [f32; 3]) -> Phong {
    let whole = from_metallic_roughness(material);
    let bare = from_metallic_roughness(&MetallicRoughness { base_color: [0.0; 3], ..*material });
    let times = |whole: [f32; 3], part: [f32; 3]| -> [f32; 3] {
        std::array::from_fn(|channel| {
            let part = (untint[channel] - 1.0) * phong::decode_srgb(part[channel]);
            phong::encode_srgb((phong::decode_srgb(whole[channel]) + part).clamp(0.0, 1.0))
        })
    };
    let specular = |channel: usize| {
        let dielectric = material.dielectric_f0[channel] * (1.0 - material.metallic);
        let all = dielectric + material.base_color[channel] * material.metallic;
        let share = if all > 0.0 { dielectric / all } else { 0.0 };
        let whole = phong::decode_srgb(whole.specular[channel]);
        phong::encode_srgb((whole * (1.0 + (untint[channel] - 1.0) * share)).clamp(0.0, 1.0))
    };
    Phong {
        ambient: times(whole.ambient, bare.ambient),
        diffuse: times(whole.diffuse, bare.diffuse),
        specular: std::array::from_fn(specular),
        exponent: whole.exponent,
    }
}

/// The roughness up to which `above` holds.
fn bisect(above: impl Fn(f32) -> bool) -> f32 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if above(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_importer_did_is_undone() {
        for untint in [[1.0; 3], [1.4, 1.5, 1.6], [3.0, 2.0, 2.5]] {
            for roughness in [0.35, 0.5, 0.6, 0.75, 0.9, 1.0] {
                for base in [0.5, 0.8, 1.0] {
                    let material = MetallicRoughness {
                        base_color: [base, 0.9 * base, 0.8 * base],
                        metallic: 0.0,
                        roughness,
                        ..MetallicRoughness::default()
                    };
                    let phong = tinted(&material, untint);
                    if phong.ambient.contains(&1.0) || phong.specular.contains(&1.0) {
                        // What was clipped is gone.
                        continue;
                    }
                    let (back, _) = untinted(&phong, untint);
                    let context = format!("{untint:?} {material:?} {back:?}");
                    assert_eq!(back.metallic, 0.0, "{context}");
                    assert_eq!(back.dielectric_f0, [phong::DEFAULT_F0; 3], "{context}");
                    assert!((back.roughness - roughness).abs() < 0.02, "{context}");
                    for (a, b) in back.base_color.iter().zip(material.base_color) {
                        assert!((a - b).abs() < 0.01, "{context}");
                    }
                }
            }
        }
    }

    #[test]
    fn half_metals_give_the_same_terms_again() {
        for (metallic, roughness) in [(0.3, 0.5), (0.7, 0.4), (0.9, 0.7)] {
            let base_color = [0.9, 0.8, 0.7];
            let material = MetallicRoughness { base_color, metallic, roughness, ..MetallicRoughness::default() };
            let phong = tinted(&material, [2.0, 2.5, 3.0]);
            let (back, _) = untinted(&phong, [2.0, 2.5, 3.0]);
            let again = tinted(&back, [2.0, 2.5, 3.0]);
            assert!(far(&again, &phong) < 1.0 / 256.0, "{material:?} {back:?} {phong:?} {again:?}");
        }
    }

    #[test]
    fn metals_stay_as_they_are() {
        let metal = MetallicRoughness { base_color: [1.0, 0.77, 0.34], roughness: 0.4, ..MetallicRoughness::default() };
        let (back, _) = untinted(&from_metallic_roughness(&metal), [2.0; 3]);
        assert_eq!(back.metallic, 1.0);
        assert!((back.roughness - 0.4).abs() < 1e-4);
    }

    #[test]
    fn a_foreign_highlight_is_as_bright_as_its_picture_made_it() {
        let phong = Phong { ambient: [0.3; 3], diffuse: [1.0; 3], specular: [0.9; 3], exponent: 32.0 };
        let (material, _) = untinted(&phong, [2.0; 3]);
        let back = from_metallic_roughness(&material);
        let expected = phong::encode_srgb(0.5 * phong::decode_srgb(0.9));
        assert!((back.specular[0] - expected).abs() < 0.005, "{back:?} {expected}");
    }
}
