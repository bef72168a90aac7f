//! Bounding volume hierarchy: built by the crate `bvh` (surface area heuristic), laid out and walked here.
//!
//! The walk is our own because the crate's compares boxes without an error bound, and because transparency needs the
//! nearest few hits in order; with two siblings in a cache line it is also several times as fast.

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy as _};
use bvh::bvh::BvhNode;
use glam::Vec3;

/// Triangles in a leaf, at most.
const LEAF_SIZE: u32 = 4;

/// A rounding bound for the distance to a box, as a factor: Ize, "Robust BVH Ray Traversal", JCGT 2013.
const SLAB: f32 = 1.0 + 4.0 * f32::EPSILON;

/// Two sibling nodes, so that one fetch serves one step down.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Pair {
    min: [Vec3; 2],
    max: [Vec3; 2],
    /// Where the child's own pair stands, or its first triangle.
    first: [u32; 2],
    /// Triangles in the child; 0 when it is an inner node.
    count: [u32; 2],
}

/// The hierarchy over triangles that the caller stores in the order that [`Bvh::build`] returns.
#[derive(Debug, Default)]
pub(crate) struct Bvh {
    pairs: Vec<Pair>,
    /// Number of triangles when there are too few for a pair.
    single_leaf: u32,
}

/// A ray prepared for boxes and triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    origin: Vec3,
    inverse: Vec3,
    /// Axes in the order of Woop's shear: the last is the direction's largest.
    axes: [usize; 3],
    shear: Vec3,
}

impl Ray {
    pub(crate) fn new(origin: Vec3, direction: Vec3) -> Self {
        // A component of 1e-30 moves a ray by nothing, and keeps 0·∞ away.
        let invert = |d: f32| if d.abs() < 1e-30 { 1e30_f32.copysign(d) } else { 1.0 / d };
        let magnitude = direction.abs();
        let z = if magnitude.x > magnitude.y && magnitude.x > magnitude.z {
            0
        } else if magnitude.y > magnitude.z {
            1
        } else {
            2
        };
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if direction[z] < 0.0 {
            (x, y) = (y, x);
        }
        let shear = Vec3::new(direction[x] / direction[z], direction[y] / direction[z], 1.0 / direction[z]);
        let inverse = Vec3::new(invert(direction.x), invert(direction.y), invert(direction.z));
        Self { origin, inverse, axes: [x, y, z], shear }
    }

    /// Where the ray is inside a box: `(enter, leave)`, inside when `enter <= leave`.
    #[inline]
    fn slab(&self, min: Vec3, max: Vec3) -> (f32, f32) {
        let a = (min - self.origin) * self.inverse;
        let b = (max - self.origin) * self.inverse;
        (a.min(b).max_element(), a.max(b).min_element() * SLAB)
    }

    /// Distance and the weights of the second and third vertex where the ray meets a triangle, from either side.
    ///
    /// Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2013: rays never slip between two triangles
    /// that share an edge, nor between those around a vertex. As with a rasteriser's fill rule, neither do they meet
    /// both, which would blend transparent surfaces twice along the edge.
    #[inline]
    pub(crate) fn triangle(&self, vertices: &[Vec3; 3]) -> Option<(f32, f32, f32)> {
        let [x, y, z] = self.axes;
        let [a, b, c] = vertices.map(|vertex| vertex - self.origin);
        let sheared = |v: Vec3| (v[x] - self.shear.x * v[z], v[y] - self.shear.y * v[z]);
        let (p, q, r) = (sheared(a), sheared(b), sheared(c));
        let ((u, right_of_u), (v, right_of_v), (w, right_of_w)) = (edge(r, q), edge(p, r), edge(q, p));
        if right_of_u != right_of_v || right_of_v != right_of_w {
            return None;
        }
        let determinant = u + v + w;
        let t = (u * a[z] + v * b[z] + w * c[z]) * self.shear.z / determinant;
        // Also false for the not-a-number of a triangle seen edge on.
        t.is_finite().then(|| (t, v / determinant, w / determinant))
    }
}

/// Twice the area of the triangle (origin, p, q), and on which side of the edge from p to q the origin is. An origin on
/// the edge is taken to be moved by (ε, ε²), so that it is on one side only.
#[inline]
fn edge(p: (f32, f32), q: (f32, f32)) -> (f32, bool) {
    let area = p.0 * q.1 - p.1 * q.0;
    if area != 0.0 {
        return (area, area > 0.0);
    }
    // The products are exact in double precision.
    let exact = f64::from(p.0) * f64::from(q.1) - f64::from(p.1) * f64::from(q.0);
    let side = if exact != 0.0 {
        exact > 0.0
    } else if p.1 != q.1 {
        p.1 > q.1
    } else {
        q.0 > p.0
    };
    (exact as f32, side)
}

/// A triangle's box, for the crate.
struct Bounds {
    min: Vec3,
    max: Vec3,
    node: usize,
}

impl Bounded<f32, 3> for Bounds {
    fn aabb(&self) -> Aabb<f32, 3> {
        Aabb::with_bounds(self.min.to_array().into(), self.max.to_array().into())
    }
}

impl BHShape<f32, 3> for Bounds {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

/// Nodes still to visit. Hierarchies of sane scenes stay within the array.
struct Stack {
    array: [u32; 64],
    length: usize,
    spill: Vec<u32>,
}

impl Stack {
    const fn new() -> Self {
        Self { array: [0; 64], length: 0, spill: Vec::new() }
    }

    #[inline]
    fn push(&mut self, node: u32) {
        if let Some(slot) = self.array.get_mut(self.length) {
            *slot = node;
            self.length += 1;
        } else {
            self.spill.push(node);
        }
    }

    #[inline]
    fn pop(&mut self) -> Option<u32> {
        if let Some(node) = self.spill.pop() {
            return Some(node);
        }
        self.length = self.length.checked_sub(1)?;
        Some(self.array[self.length])
    }
}

impl Bvh {
    /// Builds over boxes, and returns the order in which their triangles must be stored.
    pub(crate) fn build(boxes: impl Iterator<Item = (Vec3, Vec3)>) -> (Self, Vec<u32>) {
        let mut boxes: Vec<Bounds> = boxes.map(|(min, max)| Bounds { min, max, node: 0 }).collect();
        let nodes = bvh::bvh::Bvh::build_par(&mut boxes).nodes;
        let mut order = Vec::with_capacity(boxes.len());
        let mut pairs: Vec<Pair> = Vec::new();
        // The crate's nodes stand depth first, so that a node and all below it are a range, with one leaf more than
        // inner nodes. Each entry is a range and the pair and side that shall point to it.
        let mut open = vec![(0..nodes.len(), None)];
        while let Some((range, parent)) = open.pop() {
            let count = range.len().div_ceil(2) as u32;
            let (first, count) = match nodes.get(range.start) {
                Some(BvhNode::Node { child_l_aabb, child_r_index, child_r_aabb, .. }) if count > LEAF_SIZE => {
                    let boxes = [child_l_aabb, child_r_aabb];
                    let corner = |point: &[f32; 3]| Vec3::from_array(*point);
                    let pair = pairs.len();
                    pairs.push(Pair {
                        min: boxes.map(|aabb| corner(aabb.min.coords.as_ref())),
                        max: boxes.map(|aabb| corner(aabb.max.coords.as_ref())),
                        first: [0; 2],
                        count: [0; 2],
                    });
                    open.push((*child_r_index..range.end, Some((pair, 1))));
                    open.push((range.start + 1..*child_r_index, Some((pair, 0))));
                    (pair as u32, 0)
                }
                _ => {
                    let first = order.len() as u32;
                    order.extend(nodes[range].iter().filter_map(|node| match node {
                        BvhNode::Leaf { shape_index, .. } => Some(*shape_index as u32),
                        BvhNode::Node { .. } => None,
                    }));
                    (first, count)
                }
            };
            if let Some((pair, side)) = parent {
                (pairs[pair].first[side], pairs[pair].count[side]) = (first, count);
            }
        }
        let single_leaf = if pairs.is_empty() { order.len() as u32 } else { 0 };
        (Self { pairs, single_leaf }, order)
    }

    /// Visits every leaf that the ray may meet between `near` and a far end, roughly front to back. `visit` takes the
    /// leaf's first triangle and count, and returns the far end from then on; a negative one ends the walk.
    #[inline]
    pub(crate) fn walk(&self, ray: &Ray, near: f32, mut far: f32, mut visit: impl FnMut(u32, u32) -> f32) {
        if self.pairs.is_empty() {
            if self.single_leaf > 0 {
                visit(0, self.single_leaf);
            }
            return;
        }
        let mut stack = Stack::new();
        let mut current = 0;
        loop {
            let pair = &self.pairs[current as usize];
            let spans = [0, 1].map(|side| ray.slab(pair.min[side], pair.max[side]));
            let nearer = usize::from(spans[1].0 < spans[0].0);
            let mut down = None;
            for side in [nearer, 1 - nearer] {
                let (enter, leave) = spans[side];
                if enter.max(near) > leave.min(far) {
                    continue;
                }
                if pair.count[side] > 0 {
                    far = visit(pair.first[side], pair.count[side]);
                    if far < 0.0 {
                        return;
                    }
                } else if down.is_none() {
                    down = Some(pair.first[side]);
                } else {
                    stack.push(pair.first[side]);
                }
            }
            let Some(node) = down.or_else(|| stack.pop()) else { return };
            current = node;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fixed sequence of numbers in −1..1.
    fn random(seed: u32) -> impl FnMut() -> f32 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        }
    }

    fn boxes(triangles: &[[Vec3; 3]]) -> impl ExactSizeIterator<Item = (Vec3, Vec3)> {
        triangles.iter().map(|[a, b, c]| (a.min(*b).min(*c), a.max(*b).max(*c)))
    }

    fn nearest(triangles: impl Iterator<Item = [Vec3; 3]>, ray: &Ray) -> Option<f32> {
        triangles.filter_map(|triangle| ray.triangle(&triangle)).map(|hit| hit.0).filter(|t| *t > 0.0).reduce(f32::min)
    }

    #[test]
    fn the_walk_finds_the_hits_that_testing_every_triangle_finds() {
        let mut next = random(7);
        let mut point = move |scale: f32| Vec3::new(next(), next(), next()) * scale;
        for count in [0, 1, 3, 40, 2000] {
            let triangles: Vec<[Vec3; 3]> = (0..count)
                .map(|_| {
                    let corner = point(1.0);
                    [corner, corner + point(0.2), corner + point(0.2)]
                })
                .collect();
            let (bvh, order) = Bvh::build(boxes(&triangles));
            assert_eq!(order.len(), triangles.len());
            for sample in 0..500 {
                // Every third ray runs along an axis, where slabs divide by zero.
                let direction = if sample % 3 == 0 { Vec3::AXES[sample % 9 / 3] } else { point(1.0) };
                let ray = Ray::new(point(2.0), direction);
                let mut found: Option<f32> = None;
                bvh.walk(&ray, 0.0, f32::INFINITY, |first, length| {
                    let leaf = order[first as usize..(first + length) as usize].iter();
                    let hit = nearest(leaf.map(|index| triangles[*index as usize]), &ray);
                    found = [found, hit].into_iter().flatten().reduce(f32::min);
                    found.unwrap_or(f32::INFINITY)
                });
                assert_eq!(found, nearest(triangles.iter().copied(), &ray));
            }
        }
    }

    #[test]
    fn rays_at_edges_and_vertices_meet_exactly_one_of_the_triangles_around() {
        // A fan of slivers around a point, aimed at exactly: the hub, and along the spokes.
        let eye = Vec3::new(0.3, -0.2, 3.7);
        let rim = |i: usize| {
            let angle = i as f32 / 400.0 * std::f32::consts::TAU;
            Vec3::new(angle.cos(), angle.sin(), 0.1 * (5.0 * angle).sin())
        };
        let fan: Vec<[Vec3; 3]> = (0..400).map(|i| [Vec3::ZERO, rim(i), rim((i + 1) % 400)]).collect();
        let met = |triangles: &[[Vec3; 3]], ray: &Ray| triangles.iter().filter(|t| ray.triangle(t).is_some()).count();
        assert_eq!(met(&fan, &Ray::new(eye, -eye)), 1);
        for i in 0..400 {
            for step in 1..50 {
                let target = rim(i) * (step as f32 / 50.0);
                assert_eq!(met(&fan, &Ray::new(eye, target - eye)), 1, "spoke {i} at {step}/50");
            }
        }
        // A grid of squares, seen straight on through all of its vertices, edges and diagonals.
        let corner = |x: i32, y: i32| Vec3::new(x as f32, y as f32, 0.0);
        let squares = (-4..4).flat_map(|x| (-4..4).map(move |y| (x, y)));
        let grid: Vec<[Vec3; 3]> = squares
            .flat_map(|(x, y)| {
                let (a, b, c, d) = (corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1));
                [[a, b, c], [a, c, d]]
            })
            .collect();
        for (x, y) in (-8..=8).flat_map(|x| (-8..=8).map(move |y| (x, y))) {
            let above = Vec3::new(0.25 * x as f32, 0.25 * y as f32, 2.0);
            for direction in [Vec3::NEG_Z, Vec3::new(0.0, 0.5, -1.0)] {
                assert_eq!(met(&grid, &Ray::new(above, direction)), 1, "{above} {direction}");
            }
        }
    }

    #[test]
    fn degenerate_and_edge_on_triangles_are_not_hit() {
        let ray = Ray::new(Vec3::ZERO, Vec3::Z);
        let flat = [Vec3::new(0.0, -1.0, 1.0), Vec3::new(0.0, 1.0, 1.0), Vec3::new(0.0, 0.0, 2.0)];
        assert_eq!(ray.triangle(&flat), None);
        assert_eq!(ray.triangle(&[Vec3::Z; 3]), None);
    }
}
