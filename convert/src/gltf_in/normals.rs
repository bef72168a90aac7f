//! Smoothing masks and explicit normals of a surface as it stands.

use std::collections::HashMap;

use glam::{DAffine3, DVec3, Vec3};

use crate::smoothing::{self, ExplicitNormals, Recovered};

use super::graph::to_aam;
use super::pose::{Placement, normal_matrix};
use super::surface::{Surface, wound};

/// Finds masks for a surface whose vertices stand at `vertices`, or explicit normals.
pub(super) fn recover(
    surface: &Surface,
    placement: &Placement,
    weights: &[f32],
    vertices: &[[f32; 3]],
    tolerance: f32,
) -> Recovered {
    if !surface.has_normals {
        // glTF 2.0 §3.7.2.1: without normals, flat ones.
        return Recovered { masks: vec![0; surface.triangles.len()], ..Recovered::default() };
    }
    let mirrored = placement.mirrors();
    let all: Vec<u32> = (0..surface.positions.len() as u32).collect();
    let normals = placement.normals(surface, weights, &all);
    let triangles: Vec<[u32; 3]> = surface.vertex_triangles().map(|triangle| wound(triangle, mirrored)).collect();
    let corners: Vec<[[f32; 3]; 3]> = surface
        .triangles
        .iter()
        .zip(&triangles)
        .zip(&surface.flat)
        .map(|((sources, corners), flat)| {
            if *flat {
                [face_normal(vertices, corners); 3]
            } else {
                wound(sources.map(|source| normals[source as usize]), mirrored)
            }
        })
        .collect();
    smoothing::recover(vertices, &triangles, &corners, tolerance)
}

/// What was found for a surface in its own coordinates, for the same surface turned, moved and scaled evenly.
pub(super) fn moved(found: &Recovered, place: &DAffine3) -> Recovered {
    let mirrored = place.matrix3.determinant() < 0.0;
    let matrix = normal_matrix(&place.matrix3);
    let mut found = found.clone();
    if let Some(explicit) = &mut found.explicit {
        for normal in &mut explicit.normals {
            let [x, y, z] = normal.map(f64::from);
            // From AAM's axes to glTF's and back.
            let turned = (matrix * DVec3::new(x, z, -y)).normalize_or_zero();
            *normal = to_aam(turned).as_vec3().to_array();
        }
        explicit.indices.iter_mut().for_each(|triangle| *triangle = wound(*triangle, mirrored));
    }
    found
}

/// Whether a transform keeps all angles.
pub(super) fn keeps_angles(place: &DAffine3) -> bool {
    let columns = [place.matrix3.x_axis, place.matrix3.y_axis, place.matrix3.z_axis];
    let [x, y, z] = columns.map(|column| column.length_squared());
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * x;
    let [a, b, c] = columns;
    x > 0.0 && close(x, y) && close(x, z) && close(a.dot(b), 0.0) && close(b.dot(c), 0.0) && close(c.dot(a), 0.0)
}

/// The unit normal of a triangle; zero if it has no area.
fn face_normal(vertices: &[[f32; 3]], corners: &[u32; 3]) -> [f32; 3] {
    let [a, b, c] = corners.map(|corner| Vec3::from(vertices[corner as usize]).as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array()
}

/// Explicit normals that stay apart in later frames wherever their sources do.
#[derive(Debug)]
pub(super) struct MovingNormals {
    entries: Vec<Entry>,
    pub indices: Vec<[u32; 3]>,
}

/// Where a normal comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Entry {
    /// A source's authored normal.
    Source(u32),
    /// The normal of a face, by its position.
    Face(u32),
}

impl MovingNormals {
    /// The normals of a surface, in order of first use.
    pub(super) fn of(surface: &Surface, mirrored: bool) -> Self {
        let classes = surface.normal_classes();
        let mut found = Self { entries: Vec::new(), indices: Vec::new() };
        let mut known: HashMap<(bool, u32), u32> = HashMap::new();
        for (number, (triangle, flat)) in (0..).zip(surface.triangles.iter().zip(&surface.flat)) {
            let corners = triangle.map(|source| {
                let flat = *flat || surface.normals[source as usize] == [0.0; 3];
                let key = if flat { number } else { classes[source as usize] };
                *known.entry((flat, key)).or_insert_with(|| {
                    found.entries.push(if flat { Entry::Face(number) } else { Entry::Source(source) });
                    found.entries.len() as u32 - 1
                })
            });
            found.indices.push(wound(corners, mirrored));
        }
        found
    }

    /// The normals where the surface stands now.
    pub(super) fn at(
        &self,
        surface: &Surface,
        placement: &Placement,
        weights: &[f32],
        vertices: &[[f32; 3]],
        mirrored: bool,
    ) -> Vec<[f32; 3]> {
        let sources: Vec<u32> = self
            .entries
            .iter()
            .map(|entry| match entry {
                Entry::Source(source) => *source,
                Entry::Face(face) => surface.triangles[*face as usize][0],
            })
            .collect();
        let mut normals = placement.normals(surface, weights, &sources);
        for (entry, normal) in self.entries.iter().zip(&mut normals) {
            if let Entry::Face(face) = entry {
                let corners = surface.triangles[*face as usize].map(|source| surface.vertex_of[source as usize]);
                *normal = face_normal(vertices, &wound(corners, mirrored));
            }
            if *normal == [0.0; 3] {
                *normal = [0.0, 0.0, 1.0];
            }
        }
        normals
    }

    /// The normals of the first frame, as an object holds them.
    pub(super) fn explicit(&self, normals: Vec<[f32; 3]>) -> ExplicitNormals {
        ExplicitNormals { normals, indices: self.indices.clone() }
    }
}
