//! AAM materials as glTF materials.
//!
//! | AAM | glTF |
//! |---|---|
//! | `Am Di Sp Sh` | base colour, metallic, roughness and `KHR_materials_specular`, by [`phong`] |
//! | `Tx` | base colour texture; emissive texture too where `SI` is not black, since it multiplies emission as well |
//! | `SI` | emissive factor, above 1 with `KHR_materials_emissive_strength` |
//! | `SI` alone, `Am Di Sp` black | `KHR_materials_unlit` |
//! | `TS` | `KHR_materials_unlit` with `Tx ⊗ (SI + Di ⊗ TS)` in one picture: light maps replace lighting |
//! | `TN`, tangent space, `In` | normal texture, scale |
//! | `TN`, object space | baked into a tangent-space one |
//! | `Tr`, alpha of `Tx` | alpha of the base colour, BLEND |
//! | `AC` | MASK |
//! | `TD` | nothing (`extras`) |

use aam::document::{Layer, NormalSpace, SingleMaterial};
use aam::meaning::{LeafMaterial, TextureLayer};
use glam::Vec3;
use serde_json::{Map, Value, json};

use crate::ConvertError;
use crate::phong::{self, MetallicRoughness, Phong};

use super::image::{Images, mean};
use super::json::{self, EmissiveStrength, Empty, Index, NormalTexture, Specular, TextureInfo};
use super::model::{Model, Variant};
use super::notes::Notes;
use super::{bake, extras, surface, uv_transform};

/// A material of the file.
#[derive(Debug)]
pub(super) struct MaterialOut {
    pub material: json::Material,
    /// Whether it has a normal map, for which meshes give tangents.
    pub normal_map: bool,
}

/// The material of each variant.
pub(super) fn build(
    model: &Model<'_>,
    images: &mut Images<'_>,
    notes: &mut Notes,
) -> Result<Vec<MaterialOut>, ConvertError> {
    (0..model.variants.len())
        .map(|place| match model.leaf(&model.variants[place]) {
            Some(leaf) => {
                let variant = &model.variants[place];
                let subject = format!("material \"{}\"", leaf.name);
                Mapper { model, place, variant, leaf, subject, images, notes, kept: Map::new() }.map()
            }
            None => Ok(fallback()),
        })
        .collect()
}

/// The material of objects without one: light grey, without highlight.
fn fallback() -> MaterialOut {
    let grey = phong::to_metallic_roughness(&Phong { ambient: [0.8; 3], diffuse: [0.8; 3], ..Phong::default() });
    let mut material = json::Material { name: "default".into(), double_sided: true, ..json::Material::default() };
    set_surface(&mut material, &grey, 1.0);
    material.extras = extras::wrap(Map::from_iter([("default".to_owned(), true.into())]));
    MaterialOut { material, normal_map: false }
}

fn set_surface(material: &mut json::Material, surface: &MetallicRoughness, opacity: f32) {
    let [r, g, b] = surface.base_color;
    material.pbr_metallic_roughness.base_color_factor = [r, g, b, opacity];
    material.pbr_metallic_roughness.metallic_factor = surface.metallic;
    material.pbr_metallic_roughness.roughness_factor = surface.roughness;
    material.extensions.specular = specular(surface);
}

/// The extension that says a reflectance other than the default.
fn specular(surface: &MetallicRoughness) -> Option<Specular> {
    let f0 = surface.dielectric_f0;
    if surface.metallic >= 1.0 || f0 == [phong::DEFAULT_F0; 3] {
        return None;
    }
    // Reflectance is min(0.04 · colour, 1) · factor; a factor below 1 would also weaken the edge, so it is the colour.
    if f0 == [0.0; 3] {
        return Some(Specular { specular_factor: 0.0, specular_color_factor: [1.0; 3] });
    }
    Some(Specular { specular_factor: 1.0, specular_color_factor: f0.map(|value| value / phong::DEFAULT_F0) })
}

fn linear(color: Vec3) -> [f32; 3] {
    color.to_array().map(phong::decode_srgb)
}

struct Mapper<'m, 'a, 'i> {
    model: &'m Model<'a>,
    place: usize,
    variant: &'m Variant,
    leaf: &'m LeafMaterial,
    subject: String,
    images: &'m mut Images<'i>,
    notes: &'m mut Notes,
    /// Textures that only `extras` name.
    kept: Map<String, Value>,
}

impl<'m> Mapper<'m, '_, '_> {
    fn map(mut self) -> Result<MaterialOut, ConvertError> {
        let mut material =
            json::Material { name: self.leaf.name.clone(), double_sided: true, ..json::Material::default() };
        let mut normal_map = false;
        let leaf = self.leaf;
        if self.image(Layer::LightMap).is_some() {
            self.light_map(&mut material)?;
            if self.image(Layer::Normal).is_some() {
                self.notes.lost(&self.subject, "normal map", "the light map replaces all lighting, as in AAM");
                self.keep(Layer::Normal);
            }
        } else if leaf.ambient == Vec3::ZERO
            && leaf.diffuse == Vec3::ZERO
            && leaf.specular == Vec3::ZERO
            && leaf.emission != Vec3::ZERO
        {
            let [r, g, b] = linear(leaf.emission);
            self.unlit(&mut material, [r, g, b]);
            material.pbr_metallic_roughness.base_color_texture = self.info(Layer::Diffuse);
        } else {
            self.lit(&mut material);
            normal_map = self.normal_map(&mut material)?;
        }
        self.alpha(&mut material);
        self.displacement();
        let mut members = Map::from_iter([("material".to_owned(), json!(self.single().0))]);
        if !self.kept.is_empty() {
            members.insert("textures".into(), self.kept.into());
        }
        material.extras = extras::wrap(members);
        Ok(MaterialOut { material, normal_map })
    }

    /// The way to the material in the document, and it as written.
    fn single(&self) -> (&'m [usize], Option<&'m SingleMaterial>) {
        let single = self.variant.leaf.and_then(|leaf| self.model.singles.get(leaf));
        single.map_or((&[], None), |(path, single)| (path, Some(single)))
    }

    /// A layer that is drawn, as far as texture coordinates go.
    fn layer(&self, layer: Layer) -> Option<&'m TextureLayer> {
        self.leaf.layers[layer as usize].as_ref().filter(|_| self.variant.uv_layers[layer as usize])
    }

    fn image(&mut self, layer: Layer) -> Option<Index> {
        let name = &self.layer(layer)?.file;
        self.images.named(name, self.notes)
    }

    /// The use of a layer's own picture.
    fn info(&mut self, layer: Layer) -> Option<TextureInfo> {
        let index = self.image(layer)?;
        Some(self.info_of(layer, index))
    }

    /// The use of a picture in the coordinates of a layer.
    fn info_of(&self, layer: Layer, index: Index) -> TextureInfo {
        let resolved = self.leaf.layers[layer as usize].as_ref();
        let (_, single) = self.single();
        let written = single.and_then(|single| single.layers[layer as usize].as_ref());
        let transform = written.zip(resolved).and_then(|(written, resolved)| uv_transform::of(written, resolved));
        TextureInfo {
            index,
            tex_coord: self.variant.sets[layer as usize].unwrap_or(0),
            extensions: json::TextureExtensions { transform },
        }
    }

    /// Keeps a layer's picture although no part of the material shows it.
    fn keep(&mut self, layer: Layer) {
        if let Some(info) = self.info(layer) {
            let tag = layer.tag().trim_end_matches(':').to_owned();
            self.kept.insert(tag, json!({ "index": info.index, "texCoord": info.tex_coord }));
        }
    }

    fn unlit(&mut self, material: &mut json::Material, [r, g, b]: [f32; 3]) {
        let largest = r.max(g).max(b);
        if largest > 1.0 {
            let note = "an unlit colour above 1 is clipped, as a display clips it";
            self.notes.changed_by(&self.subject, "emission", note, (largest.into(), format!("{largest:.2}")));
        }
        material.extensions.unlit = Some(Empty {});
        let surface = &mut material.pbr_metallic_roughness;
        surface.base_color_factor = [r.min(1.0), g.min(1.0), b.min(1.0), self.leaf.opacity];
        // What a reader without the extension should do (KHR_materials_unlit, "Implementation Note").
        surface.metallic_factor = 0.0;
        surface.roughness_factor = 0.9;
    }

    fn lit(&mut self, material: &mut json::Material) {
        let leaf = self.leaf;
        let clipped = |color: Vec3| color.min(Vec3::ONE).to_array();
        let phong = Phong {
            ambient: clipped(leaf.ambient),
            diffuse: clipped(leaf.diffuse),
            specular: clipped(leaf.specular),
            exponent: leaf.exponent,
        };
        let texture = self.layer(Layer::Diffuse).and_then(|layer| self.images.pixels(&layer.file));
        let untint = texture.map_or([1.0; 3], |texture| surface::untint(self.model, self.variant, &texture));
        let (mapped, wanted) = surface::untinted(&phong, untint);
        set_surface(material, &mapped, leaf.opacity);
        self.report_surface(&mapped, &wanted);
        if wanted.specular != phong.specular {
            let note = "AAM's texture tints it, glTF's does not; the constant nearest to it stands in";
            self.notes.changed(&self.subject, "highlight", note);
        }
        material.pbr_metallic_roughness.base_color_texture = self.info(Layer::Diffuse);
        let [r, g, b] = linear(leaf.emission);
        let strength = r.max(g).max(b);
        if strength > 0.0 {
            let scale = strength.max(1.0);
            material.emissive_factor = Some([r / scale, g / scale, b / scale]);
            material.emissive_texture = self.info(Layer::Diffuse);
            if self.variant.uses.iter().any(|of| self.model.meshes[of.0].colors.is_some()) {
                self.notes.lost(&self.subject, "vertex colours", "glTF's do not tint emission; they tint the rest");
            }
            if strength > 1.0 {
                material.extensions.emissive_strength = Some(EmissiveStrength { emissive_strength: strength });
            }
        }
    }

    /// Says how far the material is from what importing it again gives.
    fn report_surface(&mut self, mapped: &MetallicRoughness, phong: &Phong) {
        let back = phong::from_metallic_roughness(mapped);
        let far = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        let diffuse = far(phong.diffuse, back.diffuse);
        let shines = phong.exponent > 0.0 && phong.specular != [0.0; 3];
        let specular = if shines { far(phong.specular, back.specular) } else { 0.0 };
        let exponent = if shines { (back.exponent / phong.exponent - 1.0).abs() } else { 0.0 };
        let size = f64::from(diffuse.max(specular));
        let text = format!("Di {diffuse:.3}, Sp {specular:.3}, n {:.1} %", 100.0 * exponent);
        if size > 0.01 || exponent > 0.02 {
            let note = "metallic-roughness has no such surface; the nearest stands in";
            self.notes.changed_by(&self.subject, "surface", note, (size, text));
        } else {
            self.notes.kept(&self.subject, "surface", "as metallic-roughness that shows the same");
        }
        let ambient = far(phong.ambient, back.ambient);
        if ambient > 0.01 {
            let note = "glTF has no ambient colour of its own";
            self.notes.lost(&self.subject, "ambient", note);
        }
    }

    fn normal_map(&mut self, material: &mut json::Material) -> Result<bool, ConvertError> {
        let Some(layer) = self.layer(Layer::Normal) else { return Ok(false) };
        let Some(index) = self.image(Layer::Normal) else { return Ok(false) };
        let (index, scale) = if layer.normal_space == NormalSpace::Tangent {
            (index, layer.intensity)
        } else {
            self.keep(Layer::Normal);
            let baked =
                self.images.pixels(&layer.file).and_then(|map| bake::tangent_normals(self.model, self.place, &map));
            let Some(baked) = baked else {
                let note = "normals in object axes need a picture in which each surface has its own texels; it has not";
                self.notes.lost(&self.subject, "normal map", note);
                return Ok(false);
            };
            let note = "baked from object axes into tangent axes, as glTF has them";
            self.notes.changed(&self.subject, "normal map", note);
            (self.images.add(&layer.file, "_tangent", &baked)?, 1.0)
        };
        let info = self.info_of(Layer::Normal, index);
        material.normal_texture =
            Some(NormalTexture { index, tex_coord: info.tex_coord, scale, extensions: info.extensions });
        Ok(true)
    }

    /// What the light map shows, as one picture without lighting.
    fn light_map(&mut self, material: &mut json::Material) -> Result<(), ConvertError> {
        let leaf = self.leaf;
        let Some(layer) = self.layer(Layer::LightMap) else { return Ok(()) };
        let diffuse_image = self.image(Layer::Diffuse);
        // The light map's own alpha means nothing, but would show where alpha counts.
        let sees_alpha = leaf.opacity < 1.0 || leaf.alpha_cutoff.is_some();
        let holes = sees_alpha && self.images.is_transparent(&layer.file, self.notes);
        if diffuse_image.is_none() && leaf.emission == Vec3::ZERO && !holes {
            // The light map's own picture is all there is to show.
            self.unlit(material, linear(leaf.diffuse));
            material.pbr_metallic_roughness.base_color_texture = self.info(Layer::LightMap);
            self.notes.changed(&self.subject, "light map", "an unlit picture: light maps replace lighting");
            return Ok(());
        }
        let Some(light) = self.images.pixels(&layer.file) else { return Ok(()) };
        let diffuse = self.layer(Layer::Diffuse).filter(|_| diffuse_image.is_some());
        let diffuse = diffuse.and_then(|layer| self.images.pixels(&layer.file));
        // Without emission the diffuse colour stays a factor, and the picture keeps its full range.
        let (emission, reflectance, factor) = if leaf.emission == Vec3::ZERO {
            (Vec3::ZERO, Vec3::ONE, linear(leaf.diffuse))
        } else {
            (leaf.emission, leaf.diffuse, [1.0; 3])
        };
        let shade = |texel: [f32; 4], light: [f32; 4]| {
            let lit = Vec3::from_slice(&texel) * (emission + reflectance * Vec3::from_slice(&light));
            [lit.x, lit.y, lit.z, texel[3]]
        };
        self.keep(Layer::Diffuse);
        self.keep(Layer::LightMap);
        if let Some(baked) = bake::light_map(self.model, self.variant, diffuse.as_ref(), &light, shade) {
            let index = self.images.add(&layer.file, "_lit", &baked)?;
            self.unlit(material, factor);
            material.pbr_metallic_roughness.base_color_texture = Some(self.info_of(Layer::LightMap, index));
            let note = "baked with the diffuse texture into one unlit picture";
            self.notes.changed(&self.subject, "light map", note);
        } else {
            let light = Vec3::from(mean(&light));
            self.unlit(material, linear(leaf.emission + leaf.diffuse * light));
            material.pbr_metallic_roughness.base_color_texture = self.info(Layer::Diffuse);
            let note = "surfaces share its texels but not the diffuse texture's, and glTF multiplies no two pictures: its \
                        mean colour stands in";
            self.notes.lost(&self.subject, "light map", note);
        }
        Ok(())
    }

    fn alpha(&mut self, material: &mut json::Material) {
        let leaf = self.leaf;
        if let Some(cutoff) = leaf.alpha_cutoff {
            material.alpha_mode = Some("MASK");
            material.alpha_cutoff = Some(cutoff.max(0.0));
            if leaf.opacity < 1.0 {
                self.notes.lost(&self.subject, "opacity", "glTF cuts at an alpha or blends, not both; it cuts");
            }
            return;
        }
        let name = self.layer(Layer::Diffuse).map(|layer| &layer.file);
        let holes = name.is_some_and(|name| self.images.is_transparent(name, self.notes));
        if leaf.opacity < 1.0 || holes {
            material.alpha_mode = Some("BLEND");
        }
    }

    fn displacement(&mut self) {
        if self.layer(Layer::Displacement).is_some() {
            self.notes.lost(&self.subject, "displacement map", "glTF has none; its name stays in extras");
            self.keep(Layer::Displacement);
        }
    }
}
