//! What the document means, computed once for all parts of the export.

use std::collections::BTreeMap;

use aam::Document;
use aam::document::{AnimationMode, Layer, Material, MaterialBody, Object, SingleMaterial};
use aam::meaning::{Hierarchy, LeafMaterial, Materials, ObjectMesh, ObjectSubset, SmoothingRule, tangents};
use glam::{Vec2, Vec3, Vec4};

use crate::ConvertError;

/// A document and its meaning.
#[derive(Debug)]
pub(super) struct Model<'a> {
    pub document: &'a Document,
    pub materials: Materials,
    /// For each of [`Materials::leaves`] the material as written, and the way to it: the position in the document, then
    /// in each Multi.
    pub singles: Vec<(Vec<usize>, &'a SingleMaterial)>,
    pub rule: SmoothingRule,
    pub hierarchy: Hierarchy,
    /// One for each object of frame 0.
    pub meshes: Vec<ObjectMesh>,
    /// What needs a glTF material of its own, in order of first use.
    pub variants: Vec<Variant>,
    /// For each object the positions in [`Model::variants`] of its mesh's subsets.
    pub variants_of: Vec<Vec<usize>>,
}

/// A material with the layers that its triangles have texture coordinates for: glTF forbids a texture without them.
#[derive(Clone, Debug)]
pub(super) struct Variant {
    /// A position in [`Materials::leaves`], or `None` for the default material.
    pub leaf: Option<usize>,
    /// Layers with texture coordinates.
    pub uv_layers: [bool; 4],
    /// The `TEXCOORD` set of each such layer; layers whose coordinates are the same everywhere share one.
    pub sets: [Option<u32>; 4],
    /// The objects and subsets that use it.
    pub uses: Vec<(usize, usize)>,
}

impl Variant {
    /// The layers that [`Variant::sets`] takes its coordinates from, set by set.
    pub(super) fn set_layers(&self) -> Vec<Layer> {
        let mut layers = Vec::new();
        for layer in Layer::ALL {
            if self.sets[layer as usize].is_some_and(|set| set as usize == layers.len()) {
                layers.push(layer);
            }
        }
        layers
    }
}

/// A name for people.
pub(super) fn subject_of(object: &Object) -> String {
    format!("object {} \"{}\"", object.id, object.name)
}

impl<'a> Model<'a> {
    /// Computes what a document means.
    ///
    /// # Errors
    /// A position that is not a number.
    pub(super) fn of(document: &'a Document) -> Result<Self, ConvertError> {
        let materials = Materials::of(document);
        let rule = SmoothingRule::of(document);
        check_positions(document)?;
        let meshes: Vec<ObjectMesh> =
            document.objects().iter().map(|object| ObjectMesh::of(object, &materials, rule)).collect();
        let variants = variants(&meshes);
        let mut variants_of: Vec<Vec<usize>> = meshes.iter().map(|mesh| vec![0; mesh.subsets.len()]).collect();
        for (place, variant) in variants.iter().enumerate() {
            for &(object, subset) in &variant.uses {
                variants_of[object][subset] = place;
            }
        }
        let hierarchy = Hierarchy::of(document.objects());
        let singles = singles(document);
        Ok(Self { document, materials, singles, rule, hierarchy, meshes, variants, variants_of })
    }

    /// The material of a variant.
    pub(super) fn leaf(&self, variant: &Variant) -> Option<&LeafMaterial> {
        variant.leaf.map(|leaf| &self.materials.leaves()[leaf])
    }

    /// The subset of a use.
    pub(super) fn subset(&self, (object, subset): (usize, usize)) -> ObjectSubset {
        self.meshes[object].subsets[subset]
    }

    /// Texture coordinates of a layer for the corners of a use, as the object has them.
    pub(super) fn uvs(&self, of: (usize, usize), layer: Layer) -> &[Vec2] {
        let subset = self.subset(of);
        self.meshes[of.0].uvs[layer as usize]
            .as_deref()
            .map_or(&[], |uvs| &uvs[3 * subset.first..3 * (subset.first + subset.count)])
    }

    /// For each corner of an object its tangent (xyz) and bitangent sign (w), for the normal maps (of either space) of
    /// the variants that `wanted` accepts by position; `None` where no subset is of one.
    pub(super) fn tangents(&self, object: usize, wanted: impl Fn(usize) -> bool) -> Option<Vec<Vec4>> {
        let mesh = &self.meshes[object];
        let mut uvs = vec![Vec2::ZERO; mesh.corners.len()];
        let mut any = false;
        for (subset, &variant) in self.variants_of[object].iter().enumerate().filter(|(_, variant)| wanted(**variant)) {
            let leaf = self.leaf(&self.variants[variant]);
            let Some(map) = leaf.and_then(|leaf| leaf.layers[Layer::Normal as usize].as_ref()) else { continue };
            let first = 3 * mesh.subsets[subset].first;
            for (corner, uv) in self.uvs((object, subset), Layer::Normal).iter().enumerate() {
                uvs[first + corner] = map.transform.transform_point2(*uv);
                any = true;
            }
        }
        any.then(|| {
            let vertices = &self.document.objects()[object].vertices;
            let positions: Vec<Vec3> =
                mesh.corners.iter().map(|&vertex| Vec3::from(vertices[vertex as usize])).collect();
            tangents(&positions, &mesh.normals, &uvs)
        })
    }

    /// Frames after the first of a `Full` animation, each object beside that of frame 0: `None` where it does not fit.
    pub(super) fn later(&self, object: usize) -> impl Iterator<Item = Option<&'a Object>> {
        let frames = match self.document.geometry.animation {
            AnimationMode::Full => self.document.geometry.frames.get(1..).unwrap_or(&[]),
            AnimationMode::None | AnimationMode::Keyframe => &[],
        };
        let count = self.document.objects()[object].vertices.len();
        frames.iter().map(move |frame| frame.objects.get(object).filter(|later| later.vertices.len() == count))
    }
}

/// The single materials in file order, each with the way to it.
fn singles(document: &Document) -> Vec<(Vec<usize>, &SingleMaterial)> {
    let mut singles = Vec::new();
    let mut pending: Vec<(Vec<usize>, &Material)> =
        document.materials.iter().enumerate().rev().map(|(at, material)| (vec![at], material)).collect();
    while let Some((path, material)) = pending.pop() {
        match &material.body {
            MaterialBody::Single(single) => singles.push((path, &**single)),
            MaterialBody::Multi(subs) => {
                let below = |at| path.iter().copied().chain([at]).collect();
                pending.extend(subs.iter().enumerate().rev().map(|(at, sub)| (below(at), sub)));
            }
        }
    }
    singles
}

fn check_positions(document: &Document) -> Result<(), ConvertError> {
    for frame in &document.geometry.frames {
        for object in &frame.objects {
            // Half of the largest number, so that the way from one frame to another is a number too.
            let usable = |value: &f32| value.abs() <= 0.5 * f32::MAX;
            let bad = object.vertices.iter().position(|vertex| !vertex.iter().all(usable));
            if let Some(vertex) = bad {
                return Err(ConvertError::Option(format!(
                    "{}: vertex {vertex} of frame {} has a coordinate that is not a finite number, which glTF cannot \
                     hold; mend it (`aam check` names the line) or leave the object out",
                    subject_of(object),
                    frame.number,
                )));
            }
        }
    }
    Ok(())
}

fn variants(meshes: &[ObjectMesh]) -> Vec<Variant> {
    let mut variants: Vec<Variant> = Vec::new();
    let mut places: BTreeMap<(Option<usize>, [bool; 4]), usize> = BTreeMap::new();
    for (object, mesh) in meshes.iter().enumerate() {
        for (index, subset) in mesh.subsets.iter().enumerate() {
            let place = *places.entry((subset.material, subset.uv_layers)).or_insert_with(|| {
                let (leaf, uv_layers) = (subset.material, subset.uv_layers);
                variants.push(Variant { leaf, uv_layers, sets: [None; 4], uses: Vec::new() });
                variants.len() - 1
            });
            variants[place].uses.push((object, index));
        }
    }
    for variant in &mut variants {
        let mut sets = 0;
        for layer in Layer::ALL.into_iter().filter(|&layer| variant.uv_layers[layer as usize]) {
            let same = Layer::ALL[..layer as usize]
                .iter()
                .copied()
                .filter(|&earlier| variant.uv_layers[earlier as usize])
                .find(|&earlier| variant.uses.iter().all(|&of| same_coordinates(meshes, of, earlier, layer)));
            let set = match same {
                Some(earlier) => variant.sets[earlier as usize],
                None => {
                    sets += 1;
                    Some(sets - 1)
                }
            };
            variant.sets[layer as usize] = set;
        }
    }
    variants
}

fn same_coordinates(meshes: &[ObjectMesh], (object, subset): (usize, usize), a: Layer, b: Layer) -> bool {
    let mesh = &meshes[object];
    let subset = mesh.subsets[subset];
    let corners = 3 * subset.first..3 * (subset.first + subset.count);
    match (&mesh.uvs[a as usize], &mesh.uvs[b as usize]) {
        (Some(a), Some(b)) => a[corners.clone()] == b[corners],
        _ => false,
    }
}
