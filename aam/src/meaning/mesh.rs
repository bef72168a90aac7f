//! What an object draws.

use glam::{Vec2, Vec3, Vec4};

use crate::Finding;
use crate::document::Object;
use crate::meaning::{Bounds, Materials, SmoothingRule};

/// The triangles of an object, corner by corner, grouped by material.
///
/// Corner `3 t + c` is corner `c` of triangle `t`. Triangles stand in the order of [`ObjectMesh::subsets`], and within
/// a subset in file order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectMesh {
    /// For each triangle its position in [`crate::document::Faces::triangles`].
    pub triangles: Vec<u32>,
    /// For each corner its position in [`Object::vertices`]; always in range, and the position is finite.
    pub corners: Vec<u32>,
    /// For each corner its unit normal.
    pub normals: Vec<Vec3>,
    /// For each layer, if any subset has texture coordinates for it: those of each corner (zero in the other subsets).
    pub uvs: [Option<Vec<Vec2>>; 4],
    /// For each corner its tangent (xyz) and bitangent sign (w), if a subset has a tangent-space normal map.
    pub tangents: Option<Vec<Vec4>>,
    /// For each vertex its colour, if the object has a colour for every vertex.
    pub colors: Option<Vec<Vec3>>,
    /// Runs of triangles with one material.
    pub subsets: Vec<ObjectSubset>,
    /// The box around the positions that are used.
    pub bounds: Option<Bounds>,
    /// What was left out, and why.
    pub findings: Vec<Finding>,
}

/// A run of triangles with one material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjectSubset {
    /// A position in [`Materials::leaves`], or `None` for the default material.
    pub material: Option<usize>,
    /// The layers that these triangles have texture coordinates for. A layer of the material without them is not drawn.
    pub uv_layers: [bool; 4],
    /// First triangle.
    pub first: usize,
    /// How many.
    pub count: usize,
}

impl ObjectMesh {
    /// The mesh of an object of frame 0.
    pub fn of(object: &Object, materials: &Materials, rule: SmoothingRule) -> Self {
        let _ = (object, materials, rule);
        Self::default()
    }
}
