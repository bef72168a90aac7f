//! Bounding volume hierarchy: built by the crate `bvh` (surface area heuristic), laid out and walked here.
//!
//! Each node has four children, whose boxes are tested at once, and each leaf four triangles, tested at once too. The walk
//! is our own because the crate's compares boxes without an error bound, and because transparency needs the nearest few
//! hits in order.

use std::ops::Range;

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy as _};
use bvh::bvh::BvhNode;
use glam::{Vec3, Vec4};

/// Children of a node and triangles of a leaf, at most.
const WIDTH: usize = 4;

/// A rounding bound for the distance to a box, as a factor: Ize, "Robust BVH Ray Traversal", JCGT 2013.
const SLAB: f32 = 1.0 + 4.0 * f32::EPSILON;

/// Marks a child that is a leaf.
const LEAF: u32 = 1 << 31;

/// The boxes of four children, so that one step tests all.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Node {
    /// By side (min, max) and axis. A child that is not there has an inside-out box.
    bounds: [[Vec4; 3]; 2],
    /// Position of a node, or of a leaf with [`LEAF`].
    children: [u32; WIDTH],
}

/// Up to four triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf {
    /// By corner and axis; lanes without a triangle hold no numbers, which nothing hits.
    corners: [[Vec4; 3]; 3],
    /// The first triangle's position in the order that [`Bvh::build`] gives.
    pub(crate) first: u32,
}

/// The hierarchy over triangles.
#[derive(Debug, Default)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
}

/// Where a ray meets the triangles of a leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Met {
    /// Bit `i` for triangle `i` of the leaf.
    pub(crate) mask: u32,
    /// Distances.
    pub(crate) t: Vec4,
    /// Weights of the second and of the third corner.
    pub(crate) weights: [Vec4; 2],
}

impl Met {
    /// Distance, triangle and weights of each hit.
    #[inline]
    pub(crate) fn each(self, leaf: &Leaf) -> impl Iterator<Item = (f32, u32, [f32; 2])> {
        let mut mask = self.mask;
        let first = leaf.first;
        std::iter::from_fn(move || {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask.checked_sub(1)?;
            Some((self.t[lane], first + lane as u32, self.weights.map(|weight| weight[lane])))
        })
    }
}

/// A ray prepared for boxes and triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    origin: Vec3,
    /// The same and the inverse of the direction, by axis, each four times.
    origins: [Vec4; 3],
    inverses: [Vec4; 3],
    /// Axes in the order of Woop's shear: the last is the direction's largest.
    axes: [usize; 3],
    /// The side of boxes that the ray meets first, by axis.
    first_side: [usize; 3],
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
        let first_side = inverse.to_array().map(|d| usize::from(d.is_sign_negative()));
        let (origins, inverses) = (origin.to_array().map(Vec4::splat), inverse.to_array().map(Vec4::splat));
        Self { origin, origins, inverses, axes: [x, y, z], first_side, shear }
    }

    /// Where the ray enters the boxes of a node's children, and a bit for each that it meets in a range.
    #[inline]
    fn boxes(&self, node: &Node, near: f32, far: f32) -> (Vec4, u32) {
        let (mut enter, mut leave) = (Vec4::splat(near), Vec4::splat(f32::INFINITY));
        for axis in 0..3 {
            let side = self.first_side[axis];
            let distance = |side: usize| (node.bounds[side][axis] - self.origins[axis]) * self.inverses[axis];
            enter = distance(side).max(enter);
            leave = distance(1 - side).min(leave);
        }
        (enter, enter.cmple((leave * SLAB).min(Vec4::splat(far))).bitmask())
    }

    /// Where the ray meets the triangles of a leaf. The same as [`Ray::triangle`] for each.
    #[inline]
    pub(crate) fn leaf(&self, leaf: &Leaf) -> Met {
        let [x, y, z] = self.axes;
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = leaf.corners.each_ref().map(|corner| {
            let [x, y, z] = [x, y, z].map(|axis| corner[axis] - self.origins[axis]);
            [x - self.shear.x * z, y - self.shear.y * z, z]
        });
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        let zero = Vec4::ZERO;
        let (least, most) = (u.min(v).min(w), u.max(v).max(w));
        let inside = least.cmpgt(zero) | most.cmplt(zero);
        let mut close = (u.cmpeq(zero) | v.cmpeq(zero) | w.cmpeq(zero)).bitmask();
        if inside.bitmask() | close == 0 {
            return Met { mask: 0, t: zero, weights: [zero; 2] };
        }
        let determinant = u + v + w;
        let t = (u * az + v * bz + w * cz) * self.shear.z / determinant;
        let mask = (inside & t.abs().cmplt(Vec4::INFINITY)).bitmask();
        let mut met = Met { mask, t, weights: [v / determinant, w / determinant] };
        // On an edge all depends on the last bit.
        while close != 0 {
            let lane = close.trailing_zeros() as usize;
            close &= close - 1;
            let corner = |corner: usize| Vec3::from_array(leaf.corners[corner].map(|axis| axis[lane]));
            if let Some((t, v, w)) = self.triangle(&[corner(0), corner(1), corner(2)]) {
                met.mask |= 1 << lane;
                (met.t[lane], met.weights[0][lane], met.weights[1][lane]) = (t, v, w);
            }
        }
        met
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

/// Children still to visit and where the ray enters them. Hierarchies of sane scenes stay within the array.
struct Stack {
    array: [(f32, u32); 48],
    length: usize,
    spill: Vec<(f32, u32)>,
}

impl Stack {
    const fn new() -> Self {
        Self { array: [(0.0, 0); 48], length: 0, spill: Vec::new() }
    }

    #[inline]
    fn push(&mut self, child: (f32, u32)) {
        if let Some(slot) = self.array.get_mut(self.length) {
            *slot = child;
            self.length += 1;
        } else {
            self.spill.push(child);
        }
    }

    /// Pushes below those above `begin` that are nearer. What has spilled is not sorted.
    #[inline]
    fn push_sorted(&mut self, begin: usize, child: (f32, u32)) {
        let end = self.length;
        self.push(child);
        let mut place = end;
        while self.length > end && place > begin && self.array[place - 1].0 < child.0 {
            self.array.swap(place - 1, place);
            place -= 1;
        }
    }

    #[inline]
    fn pop(&mut self) -> Option<(f32, u32)> {
        if let Some(child) = self.spill.pop() {
            return Some(child);
        }
        self.length = self.length.checked_sub(1)?;
        Some(self.array[self.length])
    }
}

/// A part of the crate's hierarchy with its box. The crate's nodes stand depth first, so that a node and all below it are
/// a range, with one leaf more than inner nodes.
#[derive(Clone)]
struct Branch {
    range: Range<usize>,
    min: Vec3,
    max: Vec3,
}

impl Branch {
    fn is_leaf(&self) -> bool {
        self.range.len().div_ceil(2) <= WIDTH
    }

    fn area(&self) -> f32 {
        let size = self.max - self.min;
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    /// The two parts of one that is no leaf.
    fn parts(&self, nodes: &[BvhNode<f32, 3>]) -> Option<[Self; 2]> {
        let BvhNode::Node { child_l_aabb, child_r_index, child_r_aabb, .. } = &nodes[self.range.start] else {
            return None;
        };
        let part = |range: Range<usize>, aabb: &Aabb<f32, 3>| {
            let corner = |point: &[f32; 3]| Vec3::from_array(*point);
            Self { range, min: corner(aabb.min.coords.as_ref()), max: corner(aabb.max.coords.as_ref()) }
        };
        let left = part(self.range.start + 1..*child_r_index, child_l_aabb);
        Some([left, part(*child_r_index..self.range.end, child_r_aabb)])
    }

    /// Up to four parts: always the largest that is no leaf is parted.
    fn children(self, nodes: &[BvhNode<f32, 3>]) -> Vec<Self> {
        let mut children = vec![self];
        while children.len() < WIDTH {
            let inner = (0..children.len()).filter(|child| !children[*child].is_leaf());
            let largest = inner.max_by(|a, b| children[*a].area().total_cmp(&children[*b].area()));
            let Some((largest, parts)) = largest.and_then(|at| Some((at, children[at].parts(nodes)?))) else { break };
            children.splice(largest..=largest, parts);
        }
        children
    }
}

impl Bvh {
    /// Builds over triangles, and returns the order in which the caller must number them.
    pub(crate) fn build(triangles: &[[Vec3; 3]]) -> (Self, Vec<u32>) {
        if triangles.is_empty() {
            return (Self::default(), Vec::new());
        }
        let bounds = |[a, b, c]: &[Vec3; 3]| Bounds { min: a.min(*b).min(*c), max: a.max(*b).max(*c), node: 0 };
        let mut boxes: Vec<Bounds> = triangles.iter().map(bounds).collect();
        let nodes = bvh::bvh::Bvh::build_par(&mut boxes).nodes;
        let mut order = Vec::with_capacity(boxes.len());
        let mut bvh = Self::default();
        let whole = Branch { range: 0..nodes.len(), min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };
        // Each entry is a branch and the node and child that shall point to it.
        let mut open = vec![(whole, None)];
        while let Some((branch, parent)) = open.pop() {
            let place = if branch.is_leaf() && parent.is_some() {
                bvh.leaves.push(leaf(&nodes[branch.range], triangles, &mut order));
                LEAF | (bvh.leaves.len() - 1) as u32
            } else {
                let place = bvh.nodes.len();
                let mut node = Node { bounds: [[Vec4::INFINITY; 3], [Vec4::NEG_INFINITY; 3]], children: [0; WIDTH] };
                for (child, branch) in branch.children(&nodes).into_iter().enumerate() {
                    for axis in 0..3 {
                        node.bounds[0][axis][child] = branch.min[axis];
                        node.bounds[1][axis][child] = branch.max[axis];
                    }
                    open.push((branch, Some((place, child))));
                }
                bvh.nodes.push(node);
                place as u32
            };
            if let Some((node, child)) = parent {
                bvh.nodes[node].children[child] = place;
            }
        }
        (bvh, order)
    }

    /// Visits every leaf that the ray may meet between `near` and a far end, roughly front to back if `SORTED`. `visit`
    /// returns the far end from then on; a negative one ends the walk.
    #[inline]
    pub(crate) fn walk<const SORTED: bool>(
        &self,
        ray: &Ray,
        near: f32,
        mut far: f32,
        mut visit: impl FnMut(&Leaf) -> f32,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = Stack::new();
        let mut current = 0;
        loop {
            if current & LEAF != 0 {
                far = visit(&self.leaves[(current & !LEAF) as usize]);
                if far < 0.0 {
                    return;
                }
            } else {
                let node = &self.nodes[current as usize];
                let (enter, mut mask) = ray.boxes(node, near, far);
                let enter = enter.to_array();
                let begin = stack.length;
                while mask != 0 {
                    let child = mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    let child = (enter[child], node.children[child]);
                    if SORTED {
                        stack.push_sorted(begin, child);
                    } else {
                        stack.push(child);
                    }
                }
            }
            current = loop {
                match stack.pop() {
                    None => return,
                    Some((enter, child)) if enter <= far => break child,
                    Some(_) => {}
                }
            };
        }
    }
}

/// The leaf of the crate's leaves in a range, whose triangles come next in the order.
fn leaf(nodes: &[BvhNode<f32, 3>], triangles: &[[Vec3; 3]], order: &mut Vec<u32>) -> Leaf {
    let mut leaf = Leaf { corners: [[Vec4::NAN; 3]; 3], first: order.len() as u32 };
    let indices = nodes.iter().filter_map(|node| match node {
        BvhNode::Leaf { shape_index, .. } => Some(*shape_index),
        BvhNode::Node { .. } => None,
    });
    for (lane, index) in indices.enumerate() {
        for (corner, position) in triangles[index].iter().enumerate() {
            for axis in 0..3 {
                leaf.corners[corner][axis][lane] = position[axis];
            }
        }
        order.push(index as u32);
    }
    leaf
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
            let (bvh, order) = Bvh::build(&triangles);
            assert_eq!(order.len(), triangles.len());
            for sample in 0..500 {
                // Every third ray runs along an axis, where slabs divide by zero.
                let direction = if sample % 3 == 0 { Vec3::AXES[sample % 9 / 3] } else { point(1.0) };
                let ray = Ray::new(point(2.0), direction);
                let mut found: Option<(f32, u32)> = None;
                bvh.walk::<true>(&ray, 0.0, f32::INFINITY, |leaf| {
                    let met = ray.leaf(leaf);
                    for lane in (0..WIDTH).filter(|lane| met.mask >> lane & 1 == 1 && met.t[*lane] > 0.0) {
                        let hit = (met.t[lane], order[leaf.first as usize + lane]);
                        found = Some(found.filter(|found| found.0 <= hit.0).unwrap_or(hit));
                    }
                    found.map_or(f32::INFINITY, |found| found.0)
                });
                let expected = (0..)
                    .zip(&triangles)
                    .filter_map(|(index, triangle)| Some((ray.triangle(triangle).filter(|hit| hit.0 > 0.0)?.0, index)));
                assert_eq!(found, expected.min_by(|a, b| a.0.total_cmp(&b.0)));
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
        let met = |triangles: &[[Vec3; 3]], ray: &Ray| {
            let mut met = 0;
            Bvh::build(triangles).0.walk::<true>(ray, 0.0, f32::INFINITY, |leaf| {
                met += ray.leaf(leaf).mask.count_ones() as usize;
                f32::INFINITY
            });
            assert_eq!(met, triangles.iter().filter(|triangle| ray.triangle(triangle).is_some()).count());
            met
        };
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
