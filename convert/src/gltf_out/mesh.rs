//! Objects as glTF meshes: welded, indexed primitives, one for each material; later frames as morph targets.

use std::collections::{BTreeMap, HashMap};

use aam::meaning::frame_normals;
use glam::{Vec3, Vec4};

use crate::phong;

use super::axes;
use super::buffer::Buffers;
use super::json::{Index, Mesh, Primitive};
use super::model::{Model, Variant, subject_of};
use super::notes::Notes;

/// More frames than this are cut: the weights of n targets are n² numbers.
pub(super) const MAX_TARGETS: usize = 4095;

/// A mesh of the file.
#[derive(Debug)]
pub(super) struct ObjectMeshOut {
    pub mesh: Mesh,
    /// How many morph targets it has; 0 when the object keeps its form.
    pub targets: usize,
}

/// The vertices of one primitive.
struct Welded {
    /// For each triangle corner its vertex.
    corners: Vec<u32>,
    /// For each vertex a corner of the object's mesh.
    first: Vec<usize>,
}

/// What one object needs beside the model.
struct Builder<'m, 'a> {
    model: &'m Model<'a>,
    object: usize,
    tangents: Option<Vec<Vec4>>,
    targets: usize,
}

/// Writes an object's mesh; `None` where it has nothing to draw. `material_of` gives each variant's glTF material, and
/// whether it has a normal map.
pub(super) fn build(
    model: &Model<'_>,
    object: usize,
    material_of: &[(Index, bool)],
    buffers: &mut Buffers,
    notes: &mut Notes,
) -> Option<ObjectMeshOut> {
    if model.meshes[object].triangles.is_empty() {
        return None;
    }
    let builder = Builder {
        model,
        object,
        tangents: model.tangents(object, |variant| material_of[variant].1),
        targets: count_targets(model, object, notes),
    };
    let subsets = model.variants_of[object].iter().enumerate();
    let primitives = subsets.map(|(subset, &variant)| {
        let (material, normal_map) = material_of[variant];
        builder.primitive(&model.variants[variant], (object, subset), material, normal_map, buffers)
    });
    let name = model.document.objects()[object].name.decoded();
    let mesh = Mesh { name, primitives: primitives.collect() };
    Some(ObjectMeshOut { mesh, targets: builder.targets })
}

/// How many later frames the object has, if it looks different in any.
fn count_targets(model: &Model<'_>, object: usize, notes: &mut Notes) -> usize {
    let first = &model.document.objects()[object];
    let mut count = 0;
    let mut moves = false;
    let mut unfit = 0;
    for later in model.later(object) {
        count += 1;
        match later {
            Some(later) => moves |= later.vertices != first.vertices || later.frame_normals.is_some(),
            None => unfit += 1,
        }
    }
    if unfit > 0 {
        let note = "frames without the object, or with another number of vertices, show it as in frame 0";
        notes.lost(&subject_of(first), "frames", note);
    }
    if count > MAX_TARGETS {
        notes.lost("", "frames", format!("frames after {MAX_TARGETS} are left out: morph targets would grow too many"));
    }
    if moves { count.min(MAX_TARGETS) } else { 0 }
}

fn bits(v: Vec3) -> [u32; 3] {
    v.to_array().map(f32::to_bits)
}

impl Builder<'_, '_> {
    fn primitive(
        &self,
        variant: &Variant,
        of: (usize, usize),
        material: Index,
        normal_map: bool,
        buffers: &mut Buffers,
    ) -> Primitive {
        let (model, mesh) = (self.model, &self.model.meshes[self.object]);
        let object = &model.document.objects()[self.object];
        let subset = model.subset(of);
        let start = 3 * subset.first;
        let end = start + 3 * subset.count;
        let layers = variant.set_layers();
        let tangents = self.tangents.as_ref().filter(|_| normal_map);
        let uv_of = |layer: aam::document::Layer, corner: usize| model.uvs(of, layer)[corner - start];

        let mut classes: HashMap<[u32; 16], u32> = HashMap::new();
        let mut welded = Welded { corners: Vec::with_capacity(end - start), first: Vec::new() };
        for corner in start..end {
            let mut key = [0_u32; 16];
            key[0] = mesh.corners[corner];
            key[1..4].copy_from_slice(&bits(mesh.normals[corner]));
            for (set, &layer) in layers.iter().enumerate() {
                key[4 + 2 * set..6 + 2 * set].copy_from_slice(&uv_of(layer, corner).to_array().map(f32::to_bits));
            }
            if let Some(tangents) = tangents {
                key[12..16].copy_from_slice(&tangents[corner].to_array().map(f32::to_bits));
            }
            welded.corners.push(*classes.entry(key).or_insert_with(|| {
                welded.first.push(corner);
                welded.first.len() as u32 - 1
            }));
        }
        drop(classes);
        if self.targets > 0 {
            self.split_by_later_normals(&mut welded, start);
        }

        let position = |corner: usize| axes::vector(Vec3::from(object.vertices[mesh.corners[corner] as usize]));
        let normal = |corner: usize| axes::vector(mesh.normals[corner]);
        let corners = || welded.first.iter().copied();
        let mut attributes = BTreeMap::new();
        let indices = buffers.indices(&welded.corners, welded.first.len());
        attributes.insert("POSITION".to_owned(), buffers.positions(corners().map(position)));
        attributes.insert("NORMAL".to_owned(), buffers.vectors(corners().map(normal)));
        if let Some(tangents) = tangents {
            let rows = corners().map(|corner| axes::vector(tangents[corner].truncate()).extend(tangents[corner].w));
            attributes.insert("TANGENT".to_owned(), buffers.tangents(rows));
        }
        for (set, &layer) in layers.iter().enumerate() {
            let rows = corners().map(|corner| {
                let uv = uv_of(layer, corner);
                glam::Vec2::new(uv.x, 1.0 - uv.y)
            });
            attributes.insert(format!("TEXCOORD_{set}"), buffers.coordinates(rows));
        }
        if let Some(colors) = &mesh.colors {
            let linear =
                |corner: usize| colors[mesh.corners[corner] as usize].to_array().map(phong::decode_srgb).into();
            attributes.insert("COLOR_0".to_owned(), buffers.vectors(corners().map(linear)));
        }
        let targets = if self.targets > 0 { self.morph_targets(&welded, buffers) } else { Vec::new() };
        Primitive { attributes, indices, material: Some(material), targets }
    }

    /// The normals of each later frame, corner by corner; those of frame 0 where the frame has no such object.
    fn later_normals(&self) -> impl Iterator<Item = Vec<Vec3>> {
        let (model, mesh) = (self.model, &self.model.meshes[self.object]);
        let object = &model.document.objects()[self.object];
        model.later(self.object).take(self.targets).map(move |later| match later {
            Some(later) => {
                let normals = frame_normals(object, later, model.rule);
                mesh.triangles.iter().flat_map(|&triangle| normals[triangle as usize]).collect()
            }
            None => mesh.normals.clone(),
        })
    }

    /// Corners whose normals part in a later frame need vertices of their own.
    fn split_by_later_normals(&self, welded: &mut Welded, start: usize) {
        for normals in self.later_normals() {
            let mut classes: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
            let mut first = Vec::new();
            for (at, vertex) in welded.corners.iter_mut().enumerate() {
                let corner = start + at;
                *vertex = *classes.entry((*vertex, bits(normals[corner]))).or_insert_with(|| {
                    first.push(corner);
                    first.len() as u32 - 1
                });
            }
            welded.first = first;
        }
    }

    fn morph_targets(&self, welded: &Welded, buffers: &mut Buffers) -> Vec<BTreeMap<&'static str, Index>> {
        let (model, mesh) = (self.model, &self.model.meshes[self.object]);
        let object = &model.document.objects()[self.object];
        let later = model.later(self.object).take(self.targets);
        later
            .zip(self.later_normals())
            .map(|(later, normals)| {
                let moved = welded.first.iter().map(|&corner| {
                    let vertex = mesh.corners[corner] as usize;
                    let to = later.map_or(object.vertices[vertex], |later| later.vertices[vertex]);
                    axes::vector(Vec3::from(to) - Vec3::from(object.vertices[vertex]))
                });
                let turned = welded.first.iter().map(|&corner| axes::vector(normals[corner] - mesh.normals[corner]));
                BTreeMap::from([("POSITION", buffers.positions(moved)), ("NORMAL", buffers.vectors(turned))])
            })
            .collect()
    }
}
