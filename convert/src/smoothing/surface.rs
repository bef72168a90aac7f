//! Faces, their normals, and which corners meet at a vertex.

use aam::meaning::face_normal;
use glam::{DVec3, Vec3};

/// A mesh as the smoothing rule sees it.
pub(super) struct Surface {
    /// The unit normal of each face; zero where it is degenerate.
    pub(super) normals: Vec<DVec3>,
    /// For each vertex the start of its run in `corners`, and the end of the last.
    starts: Vec<u32>,
    /// Corners (3·face + position) that have a face normal, vertex by vertex.
    corners: Vec<u32>,
}

impl Surface {
    pub(super) fn new(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let at = |index: u32| vertices.get(index as usize).copied().map(Vec3::from);
        let normals: Vec<DVec3> = triangles
            .iter()
            .map(|&[a, b, c]| {
                let normal = at(a).zip(at(b)).zip(at(c)).and_then(|((a, b), c)| face_normal(a, b, c));
                normal.map_or(DVec3::ZERO, |normal| normal.as_dvec3())
            })
            .collect();
        let regular = || {
            triangles.iter().zip(&normals).enumerate().filter(|(_, (_, normal))| **normal != DVec3::ZERO).flat_map(
                |(face, (triangle, _))| (0..3).map(move |at| (3 * face as u32 + at, triangle[at as usize] as usize)),
            )
        };
        let mut starts = vec![0_u32; vertices.len() + 1];
        for (_, vertex) in regular() {
            starts[vertex + 1] += 1;
        }
        for vertex in 0..vertices.len() {
            starts[vertex + 1] += starts[vertex];
        }
        let mut next = starts.clone();
        let mut corners = vec![0; next[vertices.len()] as usize];
        for (corner, vertex) in regular() {
            corners[next[vertex] as usize] = corner;
            next[vertex] += 1;
        }
        Self { normals, starts, corners }
    }

    pub(super) fn vertex_count(&self) -> usize {
        self.starts.len() - 1
    }

    /// The corners at a vertex, in order of their faces.
    pub(super) fn corners_at(&self, vertex: usize) -> &[u32] {
        &self.corners[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// The normal of a corner's face.
    pub(super) fn face_normal(&self, corner: u32) -> DVec3 {
        self.normals[corner as usize / 3]
    }
}

/// The angle in radians between two unit vectors, accurate near 0.
pub(super) fn angle(a: DVec3, b: DVec3) -> f64 {
    2.0 * (0.5 * (a - b).length()).min(1.0).asin()
}
