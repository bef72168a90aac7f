//! What a document means: resolved materials, normals, tangents, poses and bounds.
//!
//! Nothing here changes a [`crate::Document`]; every function takes one (or a part) and returns plain values. Numbers
//! from the file are made harmless on the way: what is not finite, out of range or contradictory has a documented
//! replacement, so that nothing downstream meets a NaN.

mod bounds;
mod materials;
mod mesh;
mod normals;
mod pose;
mod smoothing;
mod summary;
mod tangents;
mod tracks;

pub use bounds::Bounds;
pub use materials::{LeafMaterial, Lookup, Materials, TextureLayer};
pub use mesh::{ObjectMesh, ObjectSubset};
pub use normals::{corner_normals, face_normal, frame_normals, object_normals};
pub use pose::{
    Hierarchy, Motion, frame_range, frames_per_second, has_local_coordinates, local_transform, object_motions,
    world_transforms,
};
pub use smoothing::SmoothingRule;
pub use summary::{MaterialSummary, ObjectSummary, Summary, TextureSummary};
pub use tangents::tangents;
