//! Where objects are: local transforms, hierarchy, and both over time.

use glam::Affine3A;

use crate::document::{NodeTransform, Object};
use crate::{Document, Finding};

/// The transform from an object to its parent that `Mir` and `TM` say, as a column-vector transform.
pub fn local_transform(node: &NodeTransform) -> Affine3A {
    let _ = node;
    Affine3A::IDENTITY
}

/// The transform from an object to its parent at a frame: its keys where it has any, else its `TM`.
///
/// An object without `TM` and keys is in world coordinates: identity.
pub fn local_at(object: &Object, frame: f32) -> Affine3A {
    let _ = (object, frame);
    Affine3A::IDENTITY
}

/// Who is whose parent, checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hierarchy {
    /// For each object of frame 0 its parent's position, if it has one.
    pub parents: Vec<Option<usize>>,
    /// All positions, parents before children, otherwise in file order.
    pub order: Vec<usize>,
    /// Cycles that were cut, parents that do not exist, ids that stand twice.
    pub findings: Vec<Finding>,
}

impl Hierarchy {
    /// The hierarchy of the objects of a frame.
    pub fn of(objects: &[Object]) -> Self {
        Self { parents: vec![None; objects.len()], order: (0..objects.len()).collect(), findings: Vec::new() }
    }
}

/// The transform from each object of frame 0 to its parent at a frame: identity for all in a document whose vertices
/// are world coordinates (`None` and `Full`).
pub fn object_locals(document: &Document, frame: f32) -> Vec<Affine3A> {
    document.objects().iter().map(|object| local_at(object, frame)).collect()
}

/// The transform from each object of frame 0 to the world at a frame.
pub fn world_transforms(document: &Document, hierarchy: &Hierarchy, frame: f32) -> Vec<Affine3A> {
    let _ = hierarchy;
    object_locals(document, frame)
}

/// The first and last frame of the animation, or `None` if nothing moves.
pub fn frame_range(document: &Document) -> Option<(f32, f32)> {
    let _ = document;
    None
}

/// `FPS:` if it is a usable number, else 30.
pub fn frames_per_second(document: &Document) -> f32 {
    document.geometry.frames_per_second.filter(|fps| fps.is_finite() && *fps > 0.0).unwrap_or(30.0)
}
