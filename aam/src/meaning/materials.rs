//! Materials with resolved values.

use glam::{Mat3, Vec3};

use crate::Document;
use crate::document::NormalSpace;

/// A single material, resolved: Multi materials are flattened to the singles in them.
#[derive(Clone, Debug, PartialEq)]
pub struct LeafMaterial {
    /// The name.
    pub name: String,
    /// Where it stands: the position in [`Document::materials`], then in each Multi on the way.
    pub path: Vec<usize>,
    /// Emission E, non-negative.
    pub emission: Vec3,
    /// Ambient reflectance A.
    pub ambient: Vec3,
    /// Diffuse reflectance D.
    pub diffuse: Vec3,
    /// Specular reflectance S.
    pub specular: Vec3,
    /// Phong exponent n, at least 0; 0 means no highlight.
    pub exponent: f32,
    /// 1 − `Tr`, in `[0, 1]`.
    pub opacity: f32,
    /// Fragments with alpha below it are discarded.
    pub alpha_cutoff: Option<f32>,
    /// The layers that are present, by [`crate::document::Layer`].
    pub layers: [Option<TextureLayer>; 4],
}

/// A present texture layer, resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureLayer {
    /// The file's name as the document gives it.
    pub file: String,
    /// Applied to `(u, v, 1)` before sampling; v is 0 at the bottom. Always finite.
    pub transform: Mat3,
    /// Scales xy of a tangent-space normal map.
    pub intensity: f32,
    /// Space of a normal map; [`NormalSpace::Object`] where the file says nothing.
    pub normal_space: NormalSpace,
}

/// Which material a group of an object gets. Numbers are positions in [`Materials::leaves`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lookup {
    /// The one that the ids name.
    Named(usize),
    /// The group's id is no sub-material's number: the sub at position `id mod count` stands in, as in 3ds Max.
    Substitute(usize),
    /// `MatID: -1`: the default material.
    Default,
    /// The id names nothing (beyond the list, or an empty Multi): the default material.
    Missing,
}

impl Lookup {
    /// The leaf, or `None` for the default material.
    pub const fn leaf(self) -> Option<usize> {
        match self {
            Self::Named(leaf) | Self::Substitute(leaf) => Some(leaf),
            Self::Default | Self::Missing => None,
        }
    }
}

/// The materials of a document, flattened.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Materials {
    leaves: Vec<LeafMaterial>,
}

impl Materials {
    /// Resolves a document's materials.
    pub fn of(document: &Document) -> Self {
        let _ = document;
        Self::default()
    }

    /// The single materials, in file order.
    pub fn leaves(&self) -> &[LeafMaterial] {
        &self.leaves
    }

    /// The material of an object's group: `material` is the object's `MatID:`, `group` its `NEWGROUP:` id.
    pub fn lookup(&self, material: i32, group: i32) -> Lookup {
        let _ = (material, group);
        Lookup::Default
    }
}
