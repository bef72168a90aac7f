//! The triangles that are tessellated, and how they meet.

use std::collections::HashMap;

use crate::weld::{Bits, weld};
use crate::{Mesh, Subset};

/// For each vertex of a mesh, a number that it shares with all vertices that are in the same place with the same normal at
/// every frame: where texture coordinates have a seam, several vertices are one point of the surface.
pub fn classes(mesh: &Mesh) -> Vec<u32> {
    let pairs = |positions: &[glam::Vec3], normals: &[glam::Vec3]| {
        let normal = |index: usize| normals.get(index).copied().unwrap_or_default();
        positions
            .iter()
            .enumerate()
            .map(|(index, position)| (position.bits(), normal(index).bits()))
            .collect::<Vec<_>>()
    };
    let mut classes = weld(pairs(&mesh.positions, &mesh.normals).into_iter());
    for frame in mesh.frames.iter().filter(|frame| frame.positions.len() == mesh.positions.len()) {
        classes = weld(classes.iter().copied().zip(pairs(&frame.positions, &frame.normals)));
    }
    classes
}

/// An edge between two vertices, the one of the lower class first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    pub(crate) ends: [u32; 2],
    /// Position in [`Base::edge_groups`].
    pub(crate) group: u32,
}

/// Triangles of a subset that have an area to tessellate.
#[derive(Debug)]
pub struct Base {
    /// Vertices of each triangle.
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) edges: Vec<Edge>,
    /// Edge k of a triangle joins its corners k and k + 1.
    pub(crate) triangle_edges: Vec<[u32; 3]>,
    /// For each pair of classes that an edge joins, the triangles there.
    pub(crate) edge_groups: Groups,
    /// For each class, the triangles there.
    pub(crate) corner_groups: Groups,
    pub(crate) classes: Vec<u32>,
}

/// Lists of triangles, one after the other.
#[derive(Debug, Default)]
pub(crate) struct Groups {
    ends: Vec<u32>,
    triangles: Vec<u32>,
}

impl Groups {
    /// From pairs of a group and a triangle.
    fn new(count: usize, pairs: &[(u32, u32)]) -> Self {
        let mut ends = vec![0_u32; count];
        for (group, _) in pairs {
            ends[*group as usize] += 1;
        }
        let mut sum = 0;
        let mut next: Vec<u32> = Vec::with_capacity(count);
        for end in &mut ends {
            next.push(sum);
            sum += *end;
            *end = sum;
        }
        let mut triangles = vec![0; pairs.len()];
        for (group, triangle) in pairs {
            let place = &mut next[*group as usize];
            triangles[*place as usize] = *triangle;
            *place += 1;
        }
        Self { ends, triangles }
    }

    pub(crate) fn get(&self, group: u32) -> &[u32] {
        let start = if group == 0 { 0 } else { self.ends[group as usize - 1] };
        &self.triangles[start as usize..self.ends[group as usize] as usize]
    }
}

impl Base {
    /// The triangles of a subset. Those that two corners share a vertex in, or whose corners are not there or not finite,
    /// are left out: they are not drawn either.
    pub fn new(mesh: &Mesh, subset: &Subset, classes: &[u32]) -> Self {
        let begin = (subset.first_index as usize).min(mesh.indices.len());
        let end = begin.saturating_add(subset.index_count as usize).min(mesh.indices.len());
        let is_good = |vertex: u32| mesh.positions.get(vertex as usize).is_some_and(|position| position.is_finite());
        let triangles: Vec<[u32; 3]> = mesh.indices[begin..end]
            .chunks_exact(3)
            .map(|corners| [corners[0], corners[1], corners[2]])
            .filter(|&[a, b, c]| a != b && b != c && c != a && [a, b, c].into_iter().all(is_good))
            .collect();
        let mut edges: Vec<Edge> = Vec::new();
        let mut by_ends: HashMap<[u32; 2], u32> = HashMap::with_capacity(2 * triangles.len());
        let mut by_classes: HashMap<[u32; 2], u32> = HashMap::new();
        let mut at_edges: Vec<(u32, u32)> = Vec::with_capacity(3 * triangles.len());
        let mut at_corners: Vec<(u32, u32)> = Vec::with_capacity(3 * triangles.len());
        let triangle_edges = (0..).zip(&triangles).map(|(number, corners)| {
            at_corners.extend(corners.map(|vertex| (classes[vertex as usize], number)));
            [0, 1, 2].map(|k| {
                let mut ends = [corners[k], corners[(k + 1) % 3]];
                ends.sort_unstable_by_key(|&vertex| (classes[vertex as usize], vertex));
                let next_edge = edges.len() as u32;
                let edge = *by_ends.entry(ends).or_insert_with(|| {
                    let next_group = by_classes.len() as u32;
                    let group = *by_classes.entry(ends.map(|vertex| classes[vertex as usize])).or_insert(next_group);
                    edges.push(Edge { ends, group });
                    next_edge
                });
                at_edges.push((edges[edge as usize].group, number));
                edge
            })
        });
        let triangle_edges = triangle_edges.collect();
        let class_count = classes.iter().max().map_or(0, |last| *last as usize + 1);
        Self {
            edge_groups: Groups::new(by_classes.len(), &at_edges),
            corner_groups: Groups::new(class_count, &at_corners),
            classes: classes.to_vec(),
            triangles,
            edges,
            triangle_edges,
        }
    }

    /// How many triangles there are.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// True when nothing is to be tessellated.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The vertices of a triangle.
    pub fn triangle(&self, number: usize) -> [u32; 3] {
        self.triangles[number]
    }
}
