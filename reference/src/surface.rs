//! Materials as the meshes that wear them see them: layers resolved, colours in the values that lighting computes on.

use std::collections::BTreeMap;
use std::sync::Arc;

use aam_scene::{Image, Layer, Material, Mesh, NormalSpace, Scene, Shading, TextureLayer};
use glam::{Mat3, Vec2, Vec3, Vec4};
use rayon::prelude::*;

use crate::colour;
use crate::texture::{Encoding, Texture, Wrap};

/// A subset's material.
#[derive(Clone, Debug)]
pub(crate) struct Surface<'a> {
    pub(crate) emission: Vec3,
    pub(crate) ambient: Vec3,
    pub(crate) diffuse: Vec3,
    pub(crate) specular: Vec3,
    pub(crate) exponent: f32,
    pub(crate) opacity: f32,
    pub(crate) alpha_cutoff: Option<f32>,
    pub(crate) diffuse_map: Option<Map<'a>>,
    pub(crate) light_map: Option<Map<'a>>,
    pub(crate) normal_map: Option<NormalMap<'a>>,
    pub(crate) colors: Option<&'a [Vec4]>,
    /// True where fragments mix with what is behind them by their alpha.
    pub(crate) blends: bool,
    /// True where every fragment hides what is behind it: nothing blends and nothing is cut off.
    pub(crate) opaque: bool,
}

impl Surface<'_> {
    /// False where a light map replaces lighting.
    pub(crate) fn is_lit(&self) -> bool {
        self.light_map.is_none()
    }

    /// True where there is a highlight: an exponent of 0 means none.
    pub(crate) fn is_glossy(&self) -> bool {
        self.exponent > 0.0 && self.specular != Vec3::ZERO
    }
}

/// A texture layer with the coordinates that address it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Map<'a> {
    /// Position in the textures that [`Surfaces::into_textures`] gives.
    pub(crate) texture: usize,
    pub(crate) transform: Mat3,
    pub(crate) uvs: &'a [Vec2],
}

/// A normal map and how to read it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NormalMap<'a> {
    pub(crate) map: Map<'a>,
    /// Tangents of a tangent-space map, and the scale of its xy.
    pub(crate) tangent: Option<(&'a [Vec4], f32)>,
}

/// Replaces what a colour or an exponent cannot be.
pub(crate) fn or_zero(value: f32) -> f32 {
    if value > 0.0 && value.is_finite() { value } else { 0.0 }
}

/// Makes surfaces, noting the textures that they use.
#[derive(Debug)]
pub(crate) struct Surfaces<'a> {
    scene: &'a Scene,
    shading: Shading,
    /// Textures used, each once for each encoding.
    images: Vec<(&'a Arc<Image>, Encoding)>,
    /// Where a scene's texture stands in `images`.
    positions: BTreeMap<(usize, Encoding), usize>,
    /// Whether a scene's texture has texels with alpha below 1, once known.
    alpha: Vec<Option<bool>>,
}

impl<'a> Surfaces<'a> {
    pub(crate) fn new(scene: &'a Scene, shading: Shading) -> Self {
        let alpha = vec![None; scene.textures.len()];
        Self { scene, shading, images: Vec::new(), positions: BTreeMap::new(), alpha }
    }

    /// The surface of a subset of a mesh. A material that the scene lacks is the default one.
    pub(crate) fn surface(&mut self, mesh: &'a Mesh, material: Option<&'a Material>) -> Surface<'a> {
        let fallback = Material::default();
        let material = material.unwrap_or(&fallback);
        let value = |color: Vec3| {
            let color = Vec3::from_array(color.to_array().map(or_zero));
            match self.shading {
                Shading::Source => color,
                Shading::Linear => colour::decode_rgb(color),
            }
        };
        let [emission, ambient, diffuse, specular] =
            [material.emission, material.ambient, material.diffuse, material.specular].map(value);
        let color = match self.shading {
            Shading::Source => Encoding::Stored,
            Shading::Linear => Encoding::Srgb,
        };
        let colors = mesh.colors.as_deref().filter(|colors| colors.len() == mesh.positions.len());
        let diffuse_map = self.map(mesh, material, Layer::Diffuse, color);
        let light_map = self.map(mesh, material, Layer::LightMap, color);
        // A light map replaces lighting, and with it the normal.
        let normal_map = if light_map.is_none() { self.normal_map(mesh, material) } else { None };
        let opacity = if material.opacity.is_nan() { 1.0 } else { material.opacity.clamp(0.0, 1.0) };
        let blends = opacity < 1.0
            || material.alpha_cutoff.is_none()
                && (colors.is_some_and(|colors| colors.iter().any(|color| color.w < 1.0 || color.w.is_nan()))
                    || diffuse_map.is_some() && self.has_alpha(material.layers[Layer::Diffuse as usize]));
        Surface {
            emission,
            ambient,
            diffuse,
            specular,
            exponent: or_zero(material.exponent),
            opacity,
            alpha_cutoff: material.alpha_cutoff,
            diffuse_map,
            light_map,
            normal_map,
            colors,
            blends,
            opaque: !blends && material.alpha_cutoff.is_none(),
        }
    }

    /// Builds the textures noted so far, and ends.
    pub(crate) fn into_textures(self) -> Vec<Texture> {
        self.images.par_iter().map(|(image, encoding)| Texture::new(image, *encoding, Wrap::Repeat)).collect()
    }

    fn map(&mut self, mesh: &'a Mesh, material: &Material, layer: Layer, encoding: Encoding) -> Option<Map<'a>> {
        let TextureLayer { texture, transform, .. } = material.layers[layer as usize]?;
        let uvs = mesh.uvs[layer as usize].as_deref().filter(|uvs| uvs.len() == mesh.positions.len())?;
        let image = self.scene.textures.get(texture.index())?.image.as_ref().ok()?;
        if !Texture::is_whole(image) {
            return None;
        }
        let texture = *self.positions.entry((texture.index(), encoding)).or_insert_with(|| {
            self.images.push((image, encoding));
            self.images.len() - 1
        });
        Some(Map { texture, transform, uvs })
    }

    fn normal_map(&mut self, mesh: &'a Mesh, material: &Material) -> Option<NormalMap<'a>> {
        let layer = material.layers[Layer::Normal as usize]?;
        let tangent = match layer.normal_space {
            NormalSpace::Object => None,
            NormalSpace::Tangent => {
                let tangents = mesh.tangents.as_deref();
                Some((tangents.filter(|tangents| tangents.len() == mesh.positions.len())?, layer.intensity))
            }
        };
        let map = self.map(mesh, material, Layer::Normal, Encoding::Normal)?;
        Some(NormalMap { map, tangent })
    }

    fn has_alpha(&mut self, layer: Option<TextureLayer>) -> bool {
        let Some(index) = layer.map(|layer| layer.texture.index()) else { return false };
        let Some(known) = self.alpha.get_mut(index) else { return false };
        *known.get_or_insert_with(|| {
            self.scene.textures[index].image.as_ref().is_ok_and(|image| Texture::has_alpha(image))
        })
    }
}
