//! Tangent frames by MikkTSpace.

use glam::{Vec2, Vec3, Vec4};

/// For each corner a unit tangent (xyz) and the sign of the bitangent (w): B = w·cross(N, T).
///
/// The three slices run corner by corner, three for each triangle, and must be equally long.
pub fn tangents(positions: &[Vec3], normals: &[Vec3], uvs: &[Vec2]) -> Vec<Vec4> {
    let _ = (normals, uvs);
    vec![Vec4::new(1.0, 0.0, 0.0, 1.0); positions.len()]
}
