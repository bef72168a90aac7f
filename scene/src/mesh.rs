//! Welded meshes.

use std::collections::{BTreeSet, HashMap};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use aam::document::{Layer, Object};
use aam::meaning::{Materials, ObjectMesh, SmoothingRule};
use glam::{Vec2, Vec3, Vec4};

use crate::frames::{NormalKeys, mesh_frames};
use crate::materials::Textures;
use crate::weld::{Bits, first_corners, weld};
use crate::{Aabb, Displacement, MaterialId, Mesh, MeshId, Subset};

/// What all meshes of a document are made with.
pub(crate) struct Shared<'a> {
    pub(crate) materials: &'a Materials,
    pub(crate) textures: &'a Textures,
    pub(crate) rule: SmoothingRule,
}

/// What must agree for two corners to be one vertex, as one array, which hashes fastest: where it is, how it moves, and
/// the bits of its normal, its tangent, and the texture coordinates of four layers.
type CornerKey = [u32; 19];

fn corner_key(place: u32, motion: [u32; 3], normal: [u32; 3], tangent: [u32; 4], uvs: [[u32; 2]; 4]) -> CornerKey {
    let mut key = [place; 19];
    key[1..4].copy_from_slice(&motion);
    key[4..7].copy_from_slice(&normal);
    key[7..11].copy_from_slice(&tangent);
    key[11..].copy_from_slice(uvs.as_flattened());
    key
}

/// The attributes of corners that are drawn.
struct Attributes<'a> {
    tangents: Option<Vec<Vec4>>,
    uvs: [Option<&'a Vec<Vec2>>; 4],
}

impl<'a> Attributes<'a> {
    fn used(object: &Object, mesh: &'a ObjectMesh, materials: &Materials, textures: &Textures) -> Self {
        let mut any = [false; 4];
        let mut bumpy = BTreeSet::new();
        for subset in &mesh.subsets {
            let Some(leaf) = subset.material else {
                continue;
            };
            let drawn = textures.drawn_layers(&materials.leaves()[leaf], subset);
            any = std::array::from_fn(|layer| any[layer] || drawn[layer]);
            // A light map replaces lighting, so that no normals are needed.
            if drawn[Layer::Normal as usize] && !drawn[Layer::LightMap as usize] {
                bumpy.insert(leaf);
            }
        }
        Self {
            tangents: mesh.tangents(object, materials, |leaf| bumpy.contains(&leaf)),
            uvs: std::array::from_fn(|layer| mesh.uvs[layer].as_ref().filter(|_| any[layer])),
        }
    }
}

/// The mesh of an object. `ids` are the materials of its subsets, `later` is the object in later frames.
pub(crate) fn weld_mesh(
    object: &Object,
    mesh: &ObjectMesh,
    ids: &[MaterialId],
    later: &[&Object],
    shared: &Shared<'_>,
) -> Mesh {
    let (order, subsets) = join_subsets(mesh, ids);
    let Attributes { tangents, uvs } = Attributes::used(object, mesh, shared.materials, shared.textures);
    let position = |vertex: usize| Vec3::from(object.vertices[vertex]);
    let color = |vertex: usize| mesh.colors.as_ref().map_or(Vec3::ONE, |colors| colors[vertex]);
    // Vertices that move may part later: only those that never move are one when they lie in one place.
    let still = later.is_empty();
    let place_of: Vec<u32> = if still {
        weld((0..object.vertices.len()).map(|vertex| (position(vertex).bits(), color(vertex).bits())))
    } else {
        (0..object.vertices.len() as u32).collect()
    };
    let motion = NormalKeys::new(object, later, shared.rule);
    let vertex_of = weld(order.iter().map(|&corner| {
        let motion = if still { [0; 3] } else { motion.of(mesh.triangles[corner / 3], corner % 3) };
        let tangent = tangents.as_ref().map_or([0; 4], |tangents| tangents[corner].bits());
        let uvs = uvs.map(|uvs| uvs.map_or([0; 2], |uvs| uvs[corner].bits()));
        corner_key(place_of[mesh.corners[corner] as usize], motion, mesh.normals[corner].bits(), tangent, uvs)
    }));

    let corners: Vec<usize> = first_corners(&vertex_of).into_iter().map(|at| order[at as usize]).collect();
    let vertices: Vec<usize> = corners.iter().map(|&corner| mesh.corners[corner] as usize).collect();
    let positions: Vec<Vec3> = vertices.iter().map(|&vertex| position(vertex)).collect();
    let frames = mesh_frames(object, later, mesh, &corners, shared.rule);
    let moved = frames.iter().flat_map(|frame| &frame.positions);
    Mesh {
        name: object.name.decoded(),
        bounds: Aabb::of(positions.iter().chain(moved).copied()),
        positions,
        normals: corners.iter().map(|&corner| mesh.normals[corner]).collect(),
        tangents: tangents.map(|tangents| corners.iter().map(|&corner| tangents[corner]).collect()),
        colors: mesh.colors.as_ref().map(|_| vertices.iter().map(|&vertex| color(vertex).extend(1.0)).collect()),
        uvs: uvs.map(|uvs| uvs.map(|uvs| corners.iter().map(|&corner| uvs[corner]).collect())),
        indices: vertex_of,
        subsets,
        displacement: displacement(object),
        frames,
    }
}

/// The corners in drawing order, and one subset for each material, in order of first use.
fn join_subsets(mesh: &ObjectMesh, ids: &[MaterialId]) -> (Vec<usize>, Vec<Subset>) {
    let mut order = Vec::with_capacity(mesh.corners.len());
    let mut subsets: Vec<Subset> = Vec::new();
    let mut by_material: Vec<(usize, usize)> =
        weld(ids.iter()).into_iter().map(|place| place as usize).zip(0..).collect();
    by_material.sort_unstable();
    for run in by_material.chunk_by(|a, b| a.0 == b.0) {
        let first = order.len();
        for &(_, subset) in run {
            let subset = &mesh.subsets[subset];
            order.extend(3 * subset.first..3 * (subset.first + subset.count));
        }
        subsets.push(Subset {
            first_index: first as u32,
            index_count: (order.len() - first) as u32,
            material: ids[run[0].1],
        });
    }
    (order, subsets)
}

fn displacement(object: &Object) -> Option<Displacement> {
    object.displacement.map(|written| Displacement {
        tessellation: written.tessellation.max(1),
        bias: written.bias,
        scale: written.scale,
    })
}

/// The meshes of a scene, equal ones once.
#[derive(Default)]
pub(crate) struct Meshes {
    /// The meshes, in order of first use.
    pub(crate) list: Vec<Arc<Mesh>>,
    by_hash: HashMap<u64, Vec<MeshId>>,
}

impl Meshes {
    /// The mesh itself, or the one that it is equal to in everything but its name.
    pub(crate) fn share(&mut self, mesh: Arc<Mesh>) -> MeshId {
        let same = self.by_hash.entry(hash(&mesh)).or_default();
        let equal = |other: &Arc<Mesh>| {
            if Arc::ptr_eq(other, &mesh) {
                return true;
            }
            let Mesh {
                name: _,
                positions,
                normals,
                tangents,
                colors,
                uvs,
                indices,
                subsets,
                bounds,
                displacement,
                frames,
            } = &**other;
            *positions == mesh.positions
                && *normals == mesh.normals
                && *tangents == mesh.tangents
                && *colors == mesh.colors
                && *uvs == mesh.uvs
                && *indices == mesh.indices
                && *subsets == mesh.subsets
                && *bounds == mesh.bounds
                && *displacement == mesh.displacement
                && *frames == mesh.frames
        };
        if let Some(&id) = same.iter().find(|id| equal(&self.list[id.index()])) {
            return id;
        }
        let id = MeshId(self.list.len() as u32);
        same.push(id);
        self.list.push(mesh);
        id
    }
}

/// A hash of nearly all that a mesh holds; equal ones are compared.
fn hash(mesh: &Mesh) -> u64 {
    let mut hasher = DefaultHasher::new();
    mesh.indices.hash(&mut hasher);
    for subset in &mesh.subsets {
        (subset.first_index, subset.material).hash(&mut hasher);
    }
    for vector in mesh.positions.iter().chain(&mesh.normals) {
        vector.bits().hash(&mut hasher);
    }
    for uv in mesh.uvs.iter().flatten().flatten() {
        uv.bits().hash(&mut hasher);
    }
    for color in mesh.colors.iter().flatten() {
        color.bits().hash(&mut hasher);
    }
    hasher.finish()
}
