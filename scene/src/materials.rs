//! The materials and textures that a scene's triangles use, each once.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use aam::document::{Layer, NormalSpace as DocumentSpace};
use aam::meaning::{LeafMaterial, Materials, ObjectSubset};
use aam::{Finding, Severity};

use crate::texture::{FoundTexture, TextureData, TextureSource, load_texture};
use crate::{Material, MaterialId, NormalSpace, Texture, TextureId, TextureLayer};

/// The textures that layers name: each name once, and each file once.
pub(crate) struct Textures {
    by_name: BTreeMap<String, TextureId>,
    /// The textures, in order of first use.
    pub(crate) list: Vec<Texture>,
}

impl Textures {
    /// Finds and decodes the textures of all layers that `subsets` draw, and warns of each that cannot be had.
    pub(crate) fn load<'a>(
        materials: &Materials,
        subsets: impl Iterator<Item = &'a ObjectSubset>,
        source: &dyn TextureSource,
        warnings: &mut Vec<Finding>,
    ) -> Self {
        let mut textures = Self { by_name: BTreeMap::new(), list: Vec::new() };
        let mut by_key: BTreeMap<String, TextureId> = BTreeMap::new();
        let mut found: Vec<Option<FoundTexture>> = Vec::new();
        for subset in subsets {
            let Some(leaf) = subset.material.map(|leaf| &materials.leaves()[leaf]) else {
                continue;
            };
            for (layer, _) in leaf.layers.iter().zip(subset.uv_layers).filter(|(_, drawn)| *drawn) {
                let Some(layer) = layer.as_ref().filter(|layer| !textures.by_name.contains_key(&layer.file)) else {
                    continue;
                };
                let next = TextureId(textures.list.len() as u32);
                let result = source.find(&layer.file);
                let known = result.as_ref().ok().and_then(|texture| by_key.get(&texture.key).copied());
                textures.by_name.insert(layer.file.clone(), known.unwrap_or(next));
                if known.is_some() {
                    continue;
                }
                let (path, image) = match &result {
                    Ok(texture) => {
                        by_key.insert(texture.key.clone(), next);
                        let path = match &texture.data {
                            TextureData::OnDisk(path) => Some(path.clone()),
                            TextureData::InMemory(_) => None,
                        };
                        (path, Err(String::new()))
                    }
                    Err(reason) => (None, Err(reason.clone())),
                };
                textures.list.push(Texture { name: layer.file.clone(), path, image });
                found.push(result.ok());
            }
        }
        decode_all(&mut textures.list, &found, source);
        for texture in &textures.list {
            if let Err(reason) = &texture.image {
                warnings.push(Finding {
                    code: "texture/missing",
                    severity: Severity::Warning,
                    position: None,
                    subject: format!("texture \"{}\"", texture.name),
                    message: format!("{reason}; its layers are not drawn"),
                });
            }
        }
        textures
    }

    /// The texture of a layer if it has an image.
    fn drawn(&self, layer: &aam::meaning::TextureLayer) -> bool {
        self.by_name.get(&layer.file).is_some_and(|id| self.list[id.index()].image.is_ok())
    }

    /// Which layers of a subset have texture coordinates and an image.
    pub(crate) fn drawn_layers(&self, leaf: &LeafMaterial, subset: &ObjectSubset) -> [bool; 4] {
        Layer::ALL.map(|layer| {
            let layer = layer as usize;
            subset.uv_layers[layer] && leaf.layers[layer].as_ref().is_some_and(|map| self.drawn(map))
        })
    }
}

/// Decodes what was found, on all processors: decoding is most of the time that a textured scene takes to load.
fn decode_all(textures: &mut [Texture], found: &[Option<FoundTexture>], source: &dyn TextureSource) {
    let limits = source.limits();
    let jobs: Vec<(usize, &FoundTexture)> =
        found.iter().enumerate().filter_map(|(index, found)| Some((index, found.as_ref()?))).collect();
    let threads = thread::available_parallelism().map_or(1, usize::from).min(jobs.len());
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::with_capacity(jobs.len()));
    let work = || {
        while let Some((index, found)) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            let image = load_texture(found, &limits).map(std::sync::Arc::new);
            results.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push((*index, image));
        }
    };
    thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(work);
        }
        work();
    });
    for (index, image) in results.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner) {
        textures[index].image = image;
    }
}

/// The materials of a scene, each once.
#[derive(Default)]
pub(crate) struct MaterialList {
    /// The materials, in order of first use.
    pub(crate) list: Vec<Material>,
    known: BTreeMap<(Option<usize>, [bool; 4]), MaterialId>,
    same: BTreeMap<(String, Vec<u32>), MaterialId>,
}

impl MaterialList {
    /// The material of a subset. Layers that its triangles have no texture coordinates for are left out.
    pub(crate) fn of(&mut self, subset: &ObjectSubset, materials: &Materials, textures: &Textures) -> MaterialId {
        let key = (subset.material, subset.uv_layers);
        if let Some(&id) = self.known.get(&key) {
            return id;
        }
        let material = match subset.material {
            Some(leaf) => from_leaf(&materials.leaves()[leaf], subset.uv_layers, textures),
            None => Material { name: "(default)".to_owned(), ..Material::default() },
        };
        let id = self.share(material);
        self.known.insert(key, id);
        id
    }

    /// The material itself, or the one that it is equal to.
    pub(crate) fn share(&mut self, material: Material) -> MaterialId {
        let next = MaterialId(self.list.len() as u32);
        let id = *self.same.entry((material.name.clone(), words(&material))).or_insert(next);
        if id == next {
            self.list.push(material);
        }
        id
    }
}

fn from_leaf(leaf: &LeafMaterial, uv_layers: [bool; 4], textures: &Textures) -> Material {
    Material {
        name: leaf.name.clone(),
        emission: leaf.emission,
        ambient: leaf.ambient,
        diffuse: leaf.diffuse,
        specular: leaf.specular,
        exponent: leaf.exponent,
        opacity: leaf.opacity,
        alpha_cutoff: leaf.alpha_cutoff,
        layers: Layer::ALL.map(|layer| {
            let map = leaf.layers[layer as usize].as_ref().filter(|_| uv_layers[layer as usize])?;
            Some(TextureLayer {
                texture: *textures.by_name.get(&map.file)?,
                transform: map.transform,
                normal_space: match map.normal_space {
                    DocumentSpace::Object => NormalSpace::Object,
                    DocumentSpace::Tangent => NormalSpace::Tangent,
                },
                intensity: map.intensity,
            })
        }),
    }
}

/// Every value of a material but its name, as bits: equal for equal materials.
fn words(material: &Material) -> Vec<u32> {
    let Material { name: _, emission, ambient, diffuse, specular, exponent, opacity, alpha_cutoff, layers } = material;
    let mut words: Vec<u32> = Vec::new();
    let mut floats = |values: &[f32]| words.extend(values.iter().map(|value| value.to_bits()));
    for color in [emission, ambient, diffuse, specular] {
        floats(&color.to_array());
    }
    // A cutoff is finite, so that NaN stands for none.
    floats(&[*exponent, *opacity, alpha_cutoff.unwrap_or(f32::NAN)]);
    for layer in layers {
        match layer {
            Some(TextureLayer { texture, transform, normal_space, intensity }) => {
                words.extend([1, texture.0, u32::from(*normal_space == NormalSpace::Tangent), intensity.to_bits()]);
                words.extend(transform.to_cols_array().map(f32::to_bits));
            }
            None => words.push(0),
        }
    }
    words
}
