//! glTF materials as AAM materials.
//!
//! | glTF | AAM |
//! |---|---|
//! | base colour factor | `Am Di Sp` by [`phong`], sRGB-encoded |
//! | base colour texture | `Tx` as it is; alpha removed where the material is opaque |
//! | metallic, roughness | `Sp`, `Sh` by [`phong`]; of their texture the mean over the surface |
//! | normal texture, scale | `TN`, `NS: TANGENT`, `In` |
//! | occlusion | multiplied into `Tx` where it has the same coordinates, else lost |
//! | emission × strength | `SI`; of its texture the constant nearest in least squares |
//! | MASK, BLEND | `AC` = cutoff / alpha; `Tr` = 1 − alpha |
//! | unlit | `SI` = colour, `Am Di Sp` = 0 |
//!
//! **What the texture must not tint.** AAM multiplies the whole lit colour by the diffuse texel T, emission and
//! highlights too, where glTF tints only the base colour. A term c that glTF leaves untinted is written as
//! `c · ΣT / ΣT²` over the material's surface: the constant x for which T·x comes nearest to c in least squares.

use aam::Text;
use aam::document::{Flagged, Layer, NormalSpace, SingleMaterial, Texture};

use crate::phong::{self, MetallicRoughness, Phong};

use super::bake::Recipe;
use super::fault::Checked;
use super::log::Log;
use super::model::{AlphaMode, Material, TextureRef, UvTransform, Workflow};
use super::primitive::Primitive;
use super::texture::Textures;
use super::usage::{BASE, EMISSIVE, Mean, OCCLUSION, SURFACE, Slot, Slots, Usage};

/// A glTF material in AAM's terms.
#[derive(Clone, Debug)]
pub(super) struct Mapped {
    pub single: SingleMaterial,
    /// Where the coordinates of each present layer come from.
    pub layers: [Option<LayerCoords>; 4],
}

/// Where a layer's texture coordinates come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LayerCoords {
    /// The `TEXCOORD` set.
    pub set: u32,
    /// A transform that the texture block cannot express, to be applied to the coordinates themselves.
    pub baked: Option<UvTransform>,
}

/// The `TEXCOORD` sets that a material's pictures use.
pub(super) fn sets(material: &Material) -> Vec<u32> {
    let mut sets: Vec<u32> = material.textures().map(|texture| texture.set).collect();
    sets.sort_unstable();
    sets.dedup();
    sets
}

/// Maps a material. `primitives` are those that use it, to weight its textures by.
pub(super) fn map(
    material: &Material,
    subject: &str,
    primitives: &[&Primitive],
    textures: &mut Textures<'_>,
    log: &mut Log,
) -> Checked<Mapped> {
    let mut mapper = Mapper { material, subject, textures, log };
    mapper.report_rest(primitives);
    let mut mapped = Mapped {
        single: SingleMaterial { class: Text::from("Standard"), ..SingleMaterial::default() },
        layers: [None; 4],
    };
    mapped.single.layers = [Flagged::No, Flagged::No, Flagged::Omitted, Flagged::Omitted];
    mapper.transparency(&mut mapped.single);
    if matches!(material.workflow, Workflow::Unlit) {
        mapper.unlit(&mut mapped)?;
        return Ok(mapped);
    }
    let slots = mapper.slots()?;
    let square;
    let usage = if primitives.is_empty() {
        square = unit_square(&slots);
        Usage::of(&slots, &[&square])
    } else {
        Usage::of(&slots, primitives)
    };
    let diffuse = mapper.diffuse_layer(&slots, &usage, &mut mapped)?;
    mapper.terms(&usage, diffuse, &mut mapped.single);
    mapper.normal_layer(&mut mapped)?;
    Ok(mapped)
}

/// What stands in the diffuse layer.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Diffuse {
    /// Base colour, perhaps with occlusion, or nothing.
    Base,
    /// The emissive texture, on a material whose base colour is black.
    Emission,
}

struct Mapper<'a, 'b, 't> {
    material: &'a Material,
    subject: &'a str,
    textures: &'a mut Textures<'t>,
    log: &'b mut Log,
}

impl Mapper<'_, '_, '_> {
    fn transparency(&self, single: &mut SingleMaterial) {
        let alpha = self.material.base_color[3];
        match self.material.alpha {
            AlphaMode::Opaque => {}
            AlphaMode::Blend => single.transparency = 1.0 - alpha,
            // The document compares the texel's alpha alone; where the factor is 0 nothing reaches the cutoff.
            AlphaMode::Mask { cutoff } => {
                single.alpha_cutoff = Some(if alpha > 0.0 || cutoff <= 0.0 { cutoff / alpha.max(1e-6) } else { 2.0 });
            }
        }
    }

    fn unlit(&mut self, mapped: &mut Mapped) -> Checked<()> {
        let [r, g, b, _] = self.material.base_color;
        mapped.single.emission = Some([r, g, b].map(phong::encode_srgb));
        if let Some(texture) = self.material.base_texture {
            let opaque = self.has_alpha_to_remove(&texture)?;
            let Some(image) = self.textures.image(&texture) else { return Ok(()) };
            let recipe = Recipe { base: Some(image), occlusion: None, opaque };
            self.layer(Layer::Diffuse, &texture, recipe, mapped)?;
        }
        Ok(())
    }

    /// Whether the material is opaque although its picture is not.
    fn has_alpha_to_remove(&mut self, texture: &TextureRef) -> Checked<bool> {
        let Some(image) = self.textures.image(texture) else { return Ok(false) };
        if self.material.alpha != AlphaMode::Opaque || !self.textures.may_have_alpha(image) {
            return Ok(false);
        }
        Ok(self.textures.pixels(image, self.log)?.is_some_and(|pixels| pixels.has_alpha()))
    }

    fn slots(&mut self) -> Checked<Slots> {
        let surface = match &self.material.workflow {
            Workflow::MetallicRoughness { texture, .. } | Workflow::SpecularGlossiness { texture, .. } => *texture,
            Workflow::Unlit => None,
        };
        let occlusion = self.material.occlusion;
        let emissive = self.material.emissive_texture.filter(|_| self.material.emissive != [0.0; 3]);
        let mut slots = Slots {
            pictures: [None, None, None, None],
            occlusion_strength: occlusion.map_or(0.0, |(_, strength)| strength),
            bake_occlusion: false,
        };
        let wanted = [
            (BASE, self.material.base_texture),
            (SURFACE, surface),
            (EMISSIVE, emissive),
            (OCCLUSION, occlusion.map(|(texture, _)| texture)),
        ];
        for (number, texture) in wanted {
            let Some(texture) = texture else { continue };
            let Some(image) = self.textures.image(&texture) else { continue };
            if let Some(pixels) = self.textures.pixels(image, self.log)? {
                slots.pictures[number] = Some(Slot { pixels, set: texture.set, transform: texture.transform });
            }
        }
        slots.bake_occlusion = match (&slots.pictures[OCCLUSION], self.material.base_texture) {
            (None, _) => false,
            (Some(_), None) => true,
            (Some(slot), Some(base)) => {
                slots.pictures[BASE].is_some() && slot.set == base.set && slot.transform == base.transform
            }
        } && slots.occlusion_strength > 0.0;
        Ok(slots)
    }

    fn diffuse_layer(&mut self, slots: &Slots, usage: &Usage, mapped: &mut Mapped) -> Checked<Diffuse> {
        let [r, g, b, _] = self.material.base_color;
        let brightest = [r, g, b]
            .iter()
            .zip(&usage.base)
            .map(|(factor, mean)| factor * factor * mean.square_or(1.0))
            .fold(0.0, f32::max);
        if let (Some(emissive), Some(_)) = (self.material.emissive_texture, &slots.pictures[EMISSIVE]) {
            let alpha_in_base = self.material.base_texture.is_some() && self.material.alpha != AlphaMode::Opaque;
            if brightest < 1e-4 && !alpha_in_base {
                let opaque = self.has_alpha_to_remove(&emissive)?;
                let image = self.textures.image(&emissive);
                self.layer(Layer::Diffuse, &emissive, Recipe { base: image, occlusion: None, opaque }, mapped)?;
                let note = "the base colour is black, so the diffuse layer holds the emissive texture";
                self.log.changed(self.subject, "emissive texture", note, None);
                return Ok(Diffuse::Emission);
            }
        }
        // Occlusion that takes nothing away where the model uses it is no reason to touch a picture.
        let darkens = usage.occlusion.or(1.0) < 0.9995;
        let occlusion = match self.material.occlusion {
            Some((texture, strength)) if slots.bake_occlusion && darkens => {
                self.textures.image(&texture).map(|image| (image, strength.to_bits()))
            }
            _ => None,
        };
        let base = self.material.base_texture.or(self
            .material
            .occlusion
            .map(|(texture, _)| texture)
            .filter(|_| occlusion.is_some()));
        if let Some(texture) = base {
            let image = self.material.base_texture.and_then(|base| self.textures.image(&base));
            let opaque = match self.material.base_texture {
                Some(base) => self.has_alpha_to_remove(&base)?,
                None => false,
            };
            if opaque {
                let note = "the material is opaque, so its picture's transparency was removed";
                self.log.changed(self.subject, "base colour texture", note, None);
            }
            self.layer(Layer::Diffuse, &texture, Recipe { base: image, occlusion, opaque }, mapped)?;
        }
        self.report_occlusion(slots, usage, occlusion.is_some());
        Ok(Diffuse::Base)
    }

    fn report_occlusion(&mut self, slots: &Slots, usage: &Usage, baked: bool) {
        if self.material.occlusion.is_none_or(|(_, strength)| strength == 0.0) {
            return;
        }
        let darkening = format!("{:.1} % darker on average", 100.0 * (1.0 - usage.occlusion.or(1.0)));
        if baked {
            let note =
                "multiplied into the diffuse texture; glTF darkens only light from everywhere, this darkens all light";
            self.log.changed(self.subject, "occlusion texture", note, Some(darkening));
        } else if slots.pictures[OCCLUSION].is_none() {
            self.log.lost(self.subject, "occlusion texture", "its picture cannot be decoded");
        } else if !slots.bake_occlusion {
            let note = format!("its coordinates are not those of the base colour texture ({darkening})");
            self.log.lost(self.subject, "occlusion texture", note);
        }
    }

    fn normal_layer(&mut self, mapped: &mut Mapped) -> Checked<()> {
        let Some((texture, scale)) = self.material.normal else { return Ok(()) };
        let Some(image) = self.textures.image(&texture) else { return Ok(()) };
        self.layer(Layer::Normal, &texture, Recipe::image_alone(image), mapped)?;
        if let Flagged::Yes(layer) = &mut mapped.single.layers[Layer::Normal as usize] {
            layer.intensity = scale;
            layer.normal_space = Some(NormalSpace::Tangent);
        }
        Ok(())
    }

    fn layer(&mut self, layer: Layer, texture: &TextureRef, recipe: Recipe, mapped: &mut Mapped) -> Checked<()> {
        let mut name = self.textures.file(recipe, self.log)?;
        if name.is_none() {
            // What cannot be baked is used as it is; the picture's own report line says why.
            if let Some(image) = recipe.base {
                name = self.textures.file(Recipe::image_alone(image), self.log)?;
            }
        }
        let Some(name) = name else { return Ok(()) };
        let mut block = Texture::new(name);
        let baked = (!texture.transform.write(&mut block)).then_some(texture.transform);
        if baked.is_some() {
            let note = "the texture block cannot express its transform; applied to the coordinates";
            self.log.changed(self.subject, layer.name(), note, None);
        }
        mapped.layers[layer as usize] = Some(LayerCoords { set: texture.set, baked });
        mapped.single.layers[layer as usize] = Flagged::Yes(Box::new(block));
        Ok(())
    }

    /// The colours and the exponent.
    fn terms(&mut self, usage: &Usage, diffuse: Diffuse, single: &mut SingleMaterial) {
        let (surface, maps) = self.surface(usage);
        let whole = phong::from_metallic_roughness(&surface);
        // What the dielectric surface alone gives back, which a texture does not tint in glTF.
        let bare = phong::from_metallic_roughness(&MetallicRoughness { base_color: [0.0; 3], ..surface });
        let texel = match diffuse {
            Diffuse::Base => &usage.base,
            Diffuse::Emission => &usage.emissive,
        };
        let untint = texel.map(|mean| untint(&mean));
        let terms = correct(&whole, &bare, &surface, untint);
        single.ambient = terms.ambient;
        single.diffuse = terms.diffuse;
        single.specular = terms.specular;
        single.shininess = phong::shininess(terms.exponent);
        if terms.exponent == 0.0 {
            single.specular = [0.0; 3];
        } else if terms.specular != whole.specular {
            let [before, after] =
                [whole.specular, terms.specular].map(|rgb| rgb.map(phong::decode_srgb).into_iter().fold(0.0, f32::max));
            let note = "AAM multiplies highlights by the diffuse texture; Sp makes up for that on average, up to 1";
            self.log.changed(self.subject, "highlight", note, Some(format!("× {:.1}", after / before)));
        }
        if let Some((note, size)) = maps {
            self.log.changed(self.subject, "metallic and roughness texture", note, Some(size));
        }
        self.emission(usage, diffuse, untint, single);
    }

    /// The metallic-roughness parameters, textures averaged, and what to say of that.
    fn surface(&self, usage: &Usage) -> (MetallicRoughness, Option<(String, String)>) {
        let [r, g, b, _] = self.material.base_color;
        let base_color = [r, g, b];
        match &self.material.workflow {
            Workflow::MetallicRoughness { metallic, roughness, texture, f0 } => {
                let [_, rough, metal, _] = usage.surface;
                let surface = MetallicRoughness {
                    base_color,
                    metallic: metallic * metal.or(1.0),
                    roughness: roughness * rough.or(1.0),
                    dielectric_f0: *f0,
                };
                let size = format!(
                    "metallic {:.2} ± {:.2}, roughness {:.2} ± {:.2}",
                    surface.metallic,
                    metallic * metal.deviation(),
                    surface.roughness,
                    roughness * rough.deviation()
                );
                let note = "AAM has no such layer; the mean over the surface is used".to_owned();
                (surface, texture.map(|_| (note, size)))
            }
            Workflow::SpecularGlossiness { specular, glossiness, texture } => {
                let mean = usage.surface_linear.map(|mean| mean.or(1.0));
                let gloss = usage.surface[3];
                let surface = MetallicRoughness {
                    base_color,
                    metallic: 0.0,
                    roughness: 1.0 - glossiness * gloss.or(1.0),
                    dielectric_f0: [0, 1, 2].map(|channel| (specular[channel] * mean[channel]).clamp(0.0, 1.0)),
                };
                let spread = usage.surface_linear.map(|mean| mean.deviation()).into_iter().fold(0.0, f32::max);
                let size = format!(
                    "specular ± {spread:.2}, glossiness {:.2} ± {:.2}",
                    1.0 - surface.roughness,
                    glossiness * gloss.deviation()
                );
                let note = "of the specular-glossiness texture the mean over the surface is used".to_owned();
                (surface, texture.map(|_| (note, size)))
            }
            Workflow::Unlit => (MetallicRoughness { base_color, ..MetallicRoughness::default() }, None),
        }
    }

    fn emission(&mut self, usage: &Usage, diffuse: Diffuse, untint: [f32; 3], single: &mut SingleMaterial) {
        let factor = self.material.emissive;
        if factor == [0.0; 3] {
            return;
        }
        let emission = if diffuse == Diffuse::Emission {
            factor
        } else if self.material.emissive_texture.is_some() {
            let nearest = [0, 1, 2].map(|channel| {
                let squares = usage.base[channel].square_or(1.0);
                if squares > DARKEST { usage.base_emissive[channel].or(1.0) / squares } else { 0.0 }
            });
            self.report_emissive(usage, nearest);
            [0, 1, 2].map(|channel| factor[channel] * nearest[channel])
        } else {
            [0, 1, 2].map(|channel| factor[channel] * untint[channel])
        };
        if emission != [0.0; 3] {
            single.emission = Some(emission.map(phong::encode_srgb));
        }
    }

    /// How far the constant is from the texture, as a part of the texture's own strength.
    fn report_emissive(&mut self, usage: &Usage, nearest: [f32; 3]) {
        let mut whole = 0.0;
        let mut left = 0.0;
        for (channel, nearest) in nearest.into_iter().enumerate() {
            let weight = self.material.emissive[channel].powi(2);
            let square = usage.emissive[channel].square_or(0.0);
            whole += weight * square;
            left += weight * (square - nearest * usage.base_emissive[channel].or(0.0)).max(0.0);
        }
        let size = (whole > 0.0).then(|| format!("{:.0} % RMS of the emission", 100.0 * (left / whole).sqrt()));
        let note = "AAM has no such layer; SI is the constant nearest to it in least squares";
        self.log.changed(self.subject, "emissive texture", note, size);
    }

    /// Everything of the material that has no counterpart.
    fn report_rest(&mut self, primitives: &[&Primitive]) {
        for name in &self.material.ignored {
            self.log.lost(self.subject, "material extension", format!("{name}: AAM materials have nothing like it"));
        }
        if let Some(extras) = &self.material.extras {
            self.log.lost(self.subject, "extras", extras.chars().take(120).collect::<String>());
        }
        let normal = self.material.normal.map(|(texture, _)| texture);
        for texture in [self.material.base_texture, normal].into_iter().flatten() {
            if let Some(sampler) = self.textures.sampler(&texture) {
                if let Some(wrap) = sampler.wrap.filter(|_| leaves_unit_square(&texture, primitives)) {
                    let note = format!("{wrap}: AAM repeats every texture, and the coordinates leave the picture");
                    self.log.lost(self.subject, "texture wrapping", note);
                }
                if let Some(filter) = sampler.filter {
                    let note = format!("{filter}: AAM filters every texture smoothly");
                    self.log.lost(self.subject, "texture filter", note);
                }
            }
        }
    }
}

/// Means of squares below this are black: nothing multiplied by them can come out light.
const DARKEST: f32 = 1e-6;

/// ΣT / ΣT²: what an untinted term is multiplied by so that T times it comes nearest to it.
fn untint(texel: &Mean) -> f32 {
    let squares = texel.square_or(1.0);
    if squares > DARKEST { texel.or(1.0) / squares } else { 1.0 }
}

/// The Phong terms with the untinted parts corrected. `bare` is the same surface without base colour.
fn correct(whole: &Phong, bare: &Phong, surface: &MetallicRoughness, untint: [f32; 3]) -> Phong {
    let linear = phong::decode_srgb;
    let corrected = |whole: f32, part: f32, untint: f32| {
        if untint == 1.0 { whole } else { phong::encode_srgb((linear(whole) + (untint - 1.0) * part).clamp(0.0, 1.0)) }
    };
    let by_channel = |whole: &[f32; 3], part: [f32; 3]| {
        [0, 1, 2].map(|channel| corrected(whole[channel], part[channel], untint[channel]))
    };
    // Of the highlight, the dielectric's share of the reflectance.
    let highlight = [0, 1, 2].map(|channel| {
        let dielectric = surface.dielectric_f0[channel] * (1.0 - surface.metallic);
        let all = dielectric + surface.base_color[channel] * surface.metallic;
        if all > 0.0 { linear(whole.specular[channel]) * dielectric / all } else { 0.0 }
    });
    Phong {
        ambient: by_channel(&whole.ambient, bare.ambient.map(linear)),
        diffuse: by_channel(&whole.diffuse, bare.diffuse.map(linear)),
        specular: by_channel(&whole.specular, highlight),
        exponent: whole.exponent,
    }
}

/// A square that shows each picture once, to weight the textures of a material that nothing uses.
fn unit_square(slots: &Slots) -> Primitive {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut square = Primitive {
        positions: corners.iter().map(|[x, y]| [*x, *y, 0.0]).collect(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Primitive::default()
    };
    for slot in slots.pictures.iter().flatten() {
        if square.uv(slot.set).is_none() {
            square.uvs.push((slot.set, corners.to_vec()));
        }
    }
    square
}

/// Whether a texture is used beyond its edges.
fn leaves_unit_square(texture: &TextureRef, primitives: &[&Primitive]) -> bool {
    let inside = |value: f32| (-1e-4..=1.0 + 1e-4).contains(&value);
    primitives.iter().any(|primitive| {
        let uvs = primitive.uv(texture.set).unwrap_or(&[]);
        let used = primitive.triangles.iter().flatten().filter_map(|&vertex| uvs.get(vertex as usize));
        used.map(|uv| texture.transform.apply(*uv)).any(|uv| !uv.into_iter().all(inside))
    })
}
