//! The scene's triangles in the world, at one frame.

use std::borrow::Cow;
use std::sync::Arc;

use aam_scene::{Mesh, Scene};
use glam::{Affine3A, Mat3, Vec3};

use crate::bvh::{Bvh, Ray};
use crate::options::Error;
use crate::surface::{Surface, Surfaces};
use crate::{MAX_COORDINATE, MAX_TRIANGLES};

/// Fragments found by one walk, at most; a ray through more transparent layers walks again.
const HITS: usize = 16;

/// A mesh in its place.
#[derive(Debug)]
pub(crate) struct Instance<'a> {
    /// Position in the scene's list of nodes.
    pub(crate) node: u32,
    pub(crate) mesh: &'a Mesh,
    pub(crate) normals: Arc<Cow<'a, [Vec3]>>,
    /// Normals of the object to the world: the inverse transpose, up to a positive factor.
    pub(crate) normal_matrix: Mat3,
    /// −1 where the transform mirrors, so that corners run the other way round in the world.
    pub(crate) winding: f32,
}

/// What instances of a mesh share: where its surfaces begin, and its normals.
type Shared<'a> = (usize, Arc<Cow<'a, [Vec3]>>);

impl<'a> Instance<'a> {
    fn new(node: usize, mesh: &'a Mesh, normals: Arc<Cow<'a, [Vec3]>>, world: &Affine3A) -> Self {
        let linear = Mat3::from(world.matrix3);
        let Mat3 { x_axis, y_axis, z_axis } = linear;
        // The matrix of cofactors is the inverse transpose times the determinant, and exists for flattened objects too.
        let cofactors = Mat3::from_cols(y_axis.cross(z_axis), z_axis.cross(x_axis), x_axis.cross(y_axis));
        let winding = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
        Self { node: node as u32, mesh, normals, normal_matrix: cofactors * winding, winding }
    }
}

/// What a triangle is part of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    pub(crate) instance: u32,
    pub(crate) surface: u32,
    /// Position of its three corners in [`Mesh::indices`].
    pub(crate) first_index: u32,
    rank: u32,
    opaque: bool,
}

/// A point where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub(crate) t: f32,
    /// Position of the triangle in [`Geometry::faces`].
    pub(crate) face: u32,
    /// Weights of the second and third corner.
    pub(crate) weights: [f32; 2],
    rank: u32,
}

impl Hit {
    fn before(&self, other: &Self) -> bool {
        self.t < other.t || self.t == other.t && self.rank < other.rank
    }
}

/// Which of coinciding triangles is in front, lowest first: of those that blend, the one drawn last, on top of
/// everything; of the others, the one drawn first, as with a depth test that passes what is nearer.
fn rank(drawn: usize, blends: bool) -> u32 {
    const HALF: u32 = 1 << 31;
    if blends { HALF - 1 - drawn as u32 } else { HALF + drawn as u32 }
}

/// The nearest hits in order, ending with the first opaque one.
#[derive(Debug)]
pub(crate) struct Hits {
    hits: [Hit; HITS],
    length: usize,
    ends_opaque: bool,
}

impl Hits {
    pub(crate) const fn new() -> Self {
        const NONE: Hit = Hit { t: 0.0, face: 0, weights: [0.0; 2], rank: 0 };
        Self { hits: [NONE; HITS], length: 0, ends_opaque: false }
    }

    pub(crate) fn as_slice(&self) -> &[Hit] {
        &self.hits[..self.length]
    }

    /// True where something may follow behind the last.
    pub(crate) fn may_go_on(&self) -> bool {
        !self.ends_opaque && self.length == HITS
    }

    /// How far further hits can matter.
    fn end(&self, far: f32) -> f32 {
        let full = self.ends_opaque || self.length == HITS;
        self.as_slice().last().filter(|_| full).map_or(far, |last| last.t)
    }

    #[inline]
    fn insert(&mut self, hit: Hit, opaque: bool) {
        let place = self.as_slice().iter().position(|known| hit.before(known)).unwrap_or(self.length);
        if place == self.length && (self.ends_opaque || self.length == HITS) {
            return;
        }
        if opaque {
            self.hits[place] = hit;
            (self.length, self.ends_opaque) = (place + 1, true);
            return;
        }
        if self.length == HITS {
            self.ends_opaque = false;
        } else {
            self.length += 1;
        }
        self.hits.copy_within(place..self.length - 1, place + 1);
        self.hits[place] = hit;
    }
}

/// All triangles, in the order of the hierarchy's leaves.
#[derive(Debug)]
pub(crate) struct Geometry<'a> {
    pub(crate) instances: Vec<Instance<'a>>,
    pub(crate) surfaces: Vec<Surface<'a>>,
    pub(crate) corners: Vec<[Vec3; 3]>,
    pub(crate) faces: Vec<Face>,
    pub(crate) skipped: usize,
    bvh: Bvh,
}

impl<'a> Geometry<'a> {
    /// Puts the visible meshes of a frame into the world.
    pub(crate) fn new(scene: &'a Scene, index: usize, surfaces: &mut Surfaces<'a>) -> Result<Self, Error> {
        let visible = scene.visibility();
        let drawn = || {
            let pairs = scene.nodes.iter().enumerate().filter(|(index, _)| visible[*index]);
            pairs.filter_map(|(index, node)| {
                let mesh = node.mesh?.index();
                Some((index, mesh, scene.meshes.get(mesh)?.as_ref()))
            })
        };
        let count = drawn().map(|(_, _, mesh)| mesh.indices.len() / 3).fold(0, usize::saturating_add);
        if count > MAX_TRIANGLES {
            return Err(Error::Triangles(count));
        }
        let world = scene.world_transforms_at(index);
        let mut geometry = Self {
            instances: Vec::new(),
            surfaces: Vec::new(),
            corners: Vec::new(),
            faces: Vec::new(),
            skipped: 0,
            bvh: Bvh::default(),
        };
        geometry.corners.reserve(count);
        geometry.faces.reserve(count);
        let mut shared: Vec<Option<Shared<'a>>> = vec![None; scene.meshes.len()];
        for (node, mesh_index, mesh) in drawn() {
            let (first_surface, normals) = shared[mesh_index].get_or_insert_with(|| {
                let first = geometry.surfaces.len();
                for subset in &mesh.subsets {
                    let material = scene.materials.get(subset.material.index());
                    geometry.surfaces.push(surfaces.surface(mesh, material));
                }
                (first, Arc::new(mesh.normals_at(index)))
            });
            let instance = Instance::new(node, mesh, Arc::clone(normals), &world[node]);
            geometry.add(instance, mesh.positions_at(index), &world[node], *first_surface);
        }
        let (bvh, order) = Bvh::build(&geometry.corners);
        geometry.bvh = bvh;
        geometry.corners = order.iter().map(|index| geometry.corners[*index as usize]).collect();
        geometry.faces = order.iter().map(|index| geometry.faces[*index as usize]).collect();
        Ok(geometry)
    }

    fn add(&mut self, instance: Instance<'a>, positions: &[Vec3], world: &Affine3A, first_surface: usize) {
        let mesh = instance.mesh;
        let index = self.instances.len() as u32;
        self.instances.push(instance);
        for (offset, subset) in mesh.subsets.iter().enumerate() {
            let begin = (subset.first_index as usize).min(mesh.indices.len());
            let end = begin.saturating_add(subset.index_count as usize).min(mesh.indices.len());
            let surface = (first_surface + offset) as u32;
            let Surface { opaque, blends, .. } = self.surfaces[surface as usize];
            for (triangle, corners) in mesh.indices[begin..end].chunks_exact(3).enumerate() {
                let place = |index: u32| {
                    let point = world.transform_point3(*positions.get(index as usize)?);
                    (point.abs().max_element() <= MAX_COORDINATE).then_some(point)
                };
                let (Some(a), Some(b), Some(c)) = (place(corners[0]), place(corners[1]), place(corners[2])) else {
                    self.skipped += 1;
                    continue;
                };
                let rank = rank(self.faces.len(), blends);
                let first_index = (begin + 3 * triangle) as u32;
                self.corners.push([a, b, c]);
                self.faces.push(Face { instance: index, surface, first_index, rank, opaque });
            }
        }
    }

    /// Collects the nearest hits between two distances, up to the first opaque one; behind `after` if given.
    pub(crate) fn collect(&self, ray: &Ray, range: (f32, f32), after: Option<Hit>, hits: &mut Hits) {
        let (near, far) = range;
        (hits.length, hits.ends_opaque) = (0, false);
        let mut end = far;
        self.bvh.walk::<true>(ray, near, far, |leaf| {
            let met = ray.leaf(leaf);
            for (t, face, weights) in met.each(leaf) {
                if t >= near && t <= end {
                    let Face { rank, opaque, .. } = self.faces[face as usize];
                    let hit = Hit { t, face, weights, rank };
                    if after.is_none_or(|after| after.before(&hit)) {
                        hits.insert(hit, opaque);
                        end = hits.end(far);
                    }
                }
            }
            end
        });
    }

    /// The distance of the nearest triangle, whatever its material.
    pub(crate) fn nearest(&self, ray: &Ray, range: (f32, f32)) -> Option<f32> {
        let (near, far) = range;
        let mut found = None;
        self.bvh.walk::<true>(ray, near, far, |leaf| {
            for (t, _, _) in ray.leaf(leaf).each(leaf) {
                if t > near && t < found.unwrap_or(far) {
                    found = Some(t);
                }
            }
            found.unwrap_or(far)
        });
        found
    }

    /// Calls `visit` for hits between two distances in no particular order, until it returns false.
    pub(crate) fn any(&self, ray: &Ray, range: (f32, f32), mut visit: impl FnMut(&Hit, bool) -> bool) {
        let (near, far) = range;
        self.bvh.walk::<false>(ray, near, far, |leaf| {
            let met = ray.leaf(leaf);
            for (t, face, weights) in met.each(leaf) {
                if t > near && t < far {
                    let Face { rank, opaque, .. } = self.faces[face as usize];
                    if !visit(&Hit { t, face, weights, rank }, opaque) {
                        return -1.0;
                    }
                }
            }
            far
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Inserts `(t, opaque)` in the given order and lists the distances kept.
    fn kept(all: &[(f32, bool)]) -> (Vec<f32>, bool) {
        let mut hits = Hits::new();
        for (index, (t, opaque)) in all.iter().enumerate() {
            let rank = rank(index, !opaque);
            hits.insert(Hit { t: *t, face: 0, weights: [0.0; 2], rank }, *opaque);
        }
        (hits.as_slice().iter().map(|hit| hit.t).collect(), hits.may_go_on())
    }

    #[test]
    fn hits_are_sorted_and_end_at_the_first_opaque_one() {
        assert_eq!(
            kept(&[(3.0, false), (1.0, false), (2.0, true), (2.5, false), (4.0, true)]),
            (vec![1.0, 2.0], false)
        );
        assert_eq!(kept(&[(2.0, true), (1.0, false), (0.5, true)]), (vec![0.5], false));
        assert_eq!(kept(&[]), (vec![], false));
    }

    #[test]
    fn a_full_list_keeps_the_nearest_and_says_that_there_may_be_more() {
        let mut all: Vec<(f32, bool)> = (0..HITS + 3).rev().map(|t| (t as f32, false)).collect();
        all.insert(2, (HITS as f32 + 0.5, true));
        let nearest: Vec<f32> = (0..HITS).map(|t| t as f32).collect();
        assert_eq!(kept(&all), (nearest.clone(), true));
        // An opaque hit inside the list hides all that was dropped.
        all.push((3.5, true));
        assert_eq!(kept(&all), (vec![0.0, 1.0, 2.0, 3.0, 3.5], false));
    }

    #[test]
    fn coinciding_hits_lie_as_drawing_in_order_leaves_them() {
        assert!(rank(0, false) < rank(1, false), "the depth test keeps what was drawn first");
        assert!(rank(1, true) < rank(0, true), "blending puts what is drawn last on top");
        assert!(rank(7, true) < rank(0, false), "blending comes after all that is opaque");
    }
}
