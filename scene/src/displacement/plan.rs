//! What a tessellated surface is made of, before it is displaced: points on base triangles, and triangles between them.

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};

use super::base::Base;
use super::{DisplacementError, MAX_TESSELLATION, MAX_TRIANGLES};

/// A point of a base triangle: `(n₀ X₀ + n₁ X₁ + n₂ X₂) / d` for every attribute X of its three corners.
///
/// The corners are in the order of their classes, those without weight last. So a point on an edge is worked out with the
/// same numbers in the same order whatever triangle it is looked at from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Place {
    /// Vertices of the base mesh.
    pub corners: [u32; 3],
    /// Numerators n₀, n₁, n₂ of their weights, and the denominator d.
    pub weights: [u16; 4],
}

/// A vertex of the tessellated surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Point {
    /// Where it is.
    pub place: Place,
    /// First of [`Plan::samples`].
    pub first_sample: u32,
    /// How many samples its height is the mean of; 0 takes the height at its own place.
    pub sample_count: u32,
}

/// A tessellated surface before it is displaced. It does not depend on positions, so that it serves all frames of an
/// animation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    /// Its vertices.
    pub points: Vec<Point>,
    /// The places whose heights points on edges and corners take the mean of: one for each base triangle there, so that
    /// all vertices at a seam of the texture coordinates get one height.
    pub samples: Vec<Place>,
    /// Triples of points, wound like the base triangles, in their order.
    pub indices: Vec<u32>,
    /// For each base triangle, where its triangles end in `indices`.
    pub ends: Vec<u32>,
}

/// Puts a plan together, each point once.
pub(crate) struct Builder<'a> {
    base: &'a Base,
    denominator: u16,
    pub(crate) plan: Plan,
    /// Point of each vertex.
    corners: Vec<u32>,
    /// Points on edges, by edge and numerator of its second end.
    on_edges: HashMap<(u32, u16), u32>,
    /// Samples of points on edges, by edge group and the same.
    edge_samples: HashMap<(u32, u16), (u32, u32)>,
    /// Samples of corners, by class.
    corner_samples: HashMap<u32, (u32, u32)>,
    /// Points inside the triangle at hand, by the numerators of its first two corners.
    inside: HashMap<[u16; 2], u32>,
}

const NONE: u32 = u32::MAX;

impl<'a> Builder<'a> {
    pub(crate) fn new(base: &'a Base, denominator: u16) -> Self {
        Self {
            base,
            denominator,
            plan: Plan::default(),
            corners: vec![NONE; base.classes.len()],
            on_edges: HashMap::new(),
            edge_samples: HashMap::new(),
            corner_samples: HashMap::new(),
            inside: HashMap::new(),
        }
    }

    /// The point at numerators of the corners of base triangle `triangle`, the one at hand.
    pub(crate) fn point(&mut self, triangle: u32, numerators: [u16; 3]) -> u32 {
        let vertices = self.base.triangles[triangle as usize];
        match numerators.iter().filter(|numerator| **numerator > 0).count() {
            1 => {
                let corner = numerators.iter().position(|numerator| *numerator > 0).unwrap_or(0);
                self.corner(triangle, vertices[corner])
            }
            2 => {
                let side = (0..3).find(|side| numerators[(side + 2) % 3] == 0).unwrap_or(0);
                let edge = self.base.triangle_edges[triangle as usize][side];
                let second = self.base.edges[edge as usize].ends[1];
                let along = if vertices[side] == second { numerators[side] } else { numerators[(side + 1) % 3] };
                self.on_edge(triangle, edge, along)
            }
            _ => {
                let key = [numerators[0], numerators[1]];
                if let Some(point) = self.inside.get(&key) {
                    return *point;
                }
                let mut order = [0, 1, 2];
                order.sort_unstable_by_key(|&k: &usize| (self.base.classes[vertices[k] as usize], vertices[k]));
                let place = self.place(order.map(|k| vertices[k]), order.map(|k| numerators[k]));
                let point = self.push(place, (0, 0));
                self.inside.insert(key, point);
                point
            }
        }
    }

    /// Ends a base triangle.
    pub(crate) fn end_triangle(&mut self) {
        self.inside.clear();
        self.plan.ends.push(self.plan.indices.len() as u32);
    }

    fn place(&self, corners: [u32; 3], [a, b, c]: [u16; 3]) -> Place {
        Place { corners, weights: [a, b, c, self.denominator] }
    }

    fn push(&mut self, place: Place, (first_sample, sample_count): (u32, u32)) -> u32 {
        self.plan.points.push(Point { place, first_sample, sample_count });
        self.plan.points.len() as u32 - 1
    }

    fn corner(&mut self, triangle: u32, vertex: u32) -> u32 {
        let known = self.corners[vertex as usize];
        if known != NONE {
            return known;
        }
        let class = self.base.classes[vertex as usize];
        let of_class = |vertex: u32| self.base.classes[vertex as usize] == class;
        let numerators = [self.denominator, 0, 0];
        let samples = match self.corner_samples.get(&class) {
            Some(samples) => *samples,
            None => {
                let there = self.base.corner_groups.get(class);
                let samples = shared_samples(&mut self.plan.samples, there, |triangle| {
                    let vertices = self.base.triangles[triangle as usize];
                    let first = vertices.iter().position(|&vertex| of_class(vertex)).unwrap_or(0);
                    Place {
                        corners: [0, 1, 2].map(|k| vertices[(first + k) % 3]),
                        weights: [self.denominator, 0, 0, self.denominator],
                    }
                });
                self.corner_samples.insert(class, samples);
                samples
            }
        };
        let vertices = self.base.triangles[triangle as usize];
        let first = vertices.iter().position(|&other| other == vertex).unwrap_or(0);
        let place = self.place([0, 1, 2].map(|k| vertices[(first + k) % 3]), numerators);
        let point = self.push(place, samples);
        self.corners[vertex as usize] = point;
        point
    }

    fn on_edge(&mut self, triangle: u32, edge: u32, along: u16) -> u32 {
        if let Some(point) = self.on_edges.get(&(edge, along)) {
            return *point;
        }
        let super::base::Edge { ends, group } = self.base.edges[edge as usize];
        let numerators = [self.denominator - along, along, 0];
        let samples = match self.edge_samples.get(&(group, along)) {
            Some(samples) => *samples,
            None => {
                let classes = ends.map(|vertex| self.base.classes[vertex as usize]);
                let there = self.base.edge_groups.get(group);
                let [a, b, c] = numerators;
                let weights = [a, b, c, self.denominator];
                let samples = shared_samples(&mut self.plan.samples, there, |triangle| {
                    let vertices = self.base.triangles[triangle as usize];
                    let is = |k: usize, which: usize| self.base.classes[vertices[k] as usize] == classes[which];
                    let first = (0..3).find(|&k| is(k, 0)).unwrap_or(0);
                    let second = (0..3).find(|&k| k != first && is(k, 1)).unwrap_or((first + 1) % 3);
                    Place { corners: [first, second, 3 - first - second].map(|k| vertices[k]), weights }
                });
                self.edge_samples.insert((group, along), samples);
                samples
            }
        };
        let vertices = self.base.triangles[triangle as usize];
        let third = vertices.into_iter().find(|vertex| !ends.contains(vertex)).unwrap_or(vertices[0]);
        let place = self.place([ends[0], ends[1], third], numerators);
        let point = self.push(place, samples);
        self.on_edges.insert((edge, along), point);
        point
    }
}

/// Appends a sample for each triangle; none if there is but one, whose own place will do.
fn shared_samples(samples: &mut Vec<Place>, triangles: &[u32], place: impl Fn(u32) -> Place) -> (u32, u32) {
    if triangles.len() < 2 {
        return (0, 0);
    }
    let first = samples.len() as u32;
    samples.extend(triangles.iter().map(|&triangle| place(triangle)));
    (first, triangles.len() as u32)
}

/// Refuses what would take more memory than is allowed.
pub(crate) fn check_count(mesh: &str, factor: u32, triangles: u64, allowed: u64) -> Result<(), DisplacementError> {
    if triangles > allowed {
        return Err(DisplacementError::TooManyTriangles { mesh: mesh.to_owned(), factor, triangles });
    }
    Ok(())
}

impl Plan {
    /// Cuts each edge into `factor` parts and each triangle into `factor²`: point (a, b) of a base triangle, `0 ≤ b ≤ a ≤
    /// factor`, lies a parts along its first edge and b along its second (VR3Lib §4.6).
    ///
    /// `mesh` is for messages; `allowed` is how many triangles may come of it.
    ///
    /// # Errors
    /// More triangles than `allowed`.
    pub fn uniform(base: &Base, factor: u32, mesh: &str, allowed: u64) -> Result<Self, DisplacementError> {
        let factor = factor.clamp(1, MAX_TESSELLATION);
        let many = u64::from(factor) * u64::from(factor);
        check_count(mesh, factor, many * base.triangles.len() as u64, allowed.min(MAX_TRIANGLES))?;
        let parts = factor as u16;
        let mut builder = Builder::new(base, parts);
        builder.plan.indices.reserve(3 * many as usize * base.triangles.len());
        let mut rows: [Vec<u32>; 2] = Default::default();
        for triangle in 0..base.triangles.len() as u32 {
            let point = |builder: &mut Builder<'_>, a: u16, b: u16| builder.point(triangle, [parts - a, a - b, b]);
            rows[0] = vec![point(&mut builder, 0, 0)];
            for a in 0..parts {
                rows[1].clear();
                for b in 0..=a + 1 {
                    let next = point(&mut builder, a + 1, b);
                    rows[1].push(next);
                }
                let [upper, lower] = &rows;
                for b in 0..=usize::from(a) {
                    builder.plan.indices.extend([upper[b], lower[b], lower[b + 1]]);
                    if b < usize::from(a) {
                        builder.plan.indices.extend([upper[b], lower[b + 1], upper[b + 1]]);
                    }
                }
                rows.swap(0, 1);
            }
            builder.end_triangle();
        }
        Ok(builder.plan)
    }

    /// How many triangles there are.
    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }
}
