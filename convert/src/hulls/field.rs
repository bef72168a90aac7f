//! How far points are outside of a solid: a grid of distances, filled where it is asked for.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::{DVec3, Vec3};
use parry3d::query::PointQuery;
use parry3d::shape::TriMesh;
use parry3d::transformation::voxelization::VoxelSet;

/// Nodes around the voxels.
const MARGIN: usize = SEAL + 2;
/// Gaps of an open mesh that are no wider than twice so many voxels are sealed: 1/32 of its longest side.
const SEAL: usize = 2;
/// A node without a distance yet.
const UNKNOWN: u32 = u32::MAX;

/// Distances to a surface, 0 inside of it.
pub(super) struct Field {
    surface: TriMesh,
    origin: DVec3,
    step: f64,
    size: [usize; 3],
    inside: Vec<bool>,
    /// Distances at the centres of voxels, as the bits of an `f32`. Whoever needs one first works it out; all would find
    /// the same.
    nodes: Vec<AtomicU32>,
}

impl Field {
    /// Of a surface and the voxels that it goes through; of an `open` one, narrow gaps are sealed. `None` if there is no
    /// triangle.
    pub(super) fn new(vertices: &[DVec3], triangles: &[[u32; 3]], voxels: &VoxelSet, open: bool) -> Option<Self> {
        let points = vertices.iter().map(|vertex| vertex.as_vec3()).collect();
        let surface = TriMesh::new(points, triangles.to_vec()).ok()?;
        let coordinates = |coords: glam::IVec3| coords.to_array().map(|value| usize::try_from(value).unwrap_or(0));
        let mut size = [0; 3];
        for voxel in voxels.voxels() {
            let at = coordinates(voxel.coords);
            (0..3).for_each(|i| size[i] = size[i].max(at[i] + 1 + 2 * MARGIN));
        }
        let count = size.iter().product();
        let step = f64::from(voxels.scale);
        let mut on_surface = Grid { size, full: vec![false; count] };
        for voxel in voxels.voxels() {
            let at = on_surface.place(coordinates(voxel.coords).map(|value| value + MARGIN));
            on_surface.full[at] = true;
        }
        Some(Self {
            surface,
            origin: voxels.origin.as_dvec3() - step * MARGIN as f64,
            step,
            size,
            inside: on_surface.enclosed(if open { SEAL } else { 0 }),
            nodes: (0..count).map(|_| AtomicU32::new(UNKNOWN)).collect(),
        })
    }

    fn place(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.size[1] + y) * self.size[2] + z
    }

    /// The distance to the surface, on either side of it.
    pub(super) fn to_surface(&self, point: DVec3) -> f64 {
        let point: Vec3 = point.as_vec3();
        f64::from(self.surface.project_local_point(point, false).point.distance(point))
    }

    /// The nearest point of the surface.
    pub(super) fn nearest(&self, point: DVec3) -> DVec3 {
        self.surface.project_local_point(point.as_vec3(), false).point.as_dvec3()
    }

    /// Whether a point is in a voxel that is full and not on the surface.
    pub(super) fn is_inside(&self, point: DVec3) -> bool {
        let at = ((point - self.origin) / self.step).round().to_array();
        let within = (0..3).all(|i| at[i] >= 0.0 && at[i] < self.size[i] as f64);
        within && self.inside[self.place(at.map(|value| value as usize))]
    }

    /// So far from a face on its own no voxel is on the surface.
    pub(super) fn clear_of_surface(&self) -> f64 {
        2.0 * self.step
    }

    /// About how far a point is outside, by interpolation.
    pub(super) fn outside(&self, point: DVec3) -> f64 {
        let at = (point - self.origin) / self.step;
        let low = at.floor();
        let part = (at - low).to_array();
        let low = low.to_array();
        if !(0..3).all(|i| low[i] >= 0.0 && low[i] + 1.0 < self.size[i] as f64) {
            return self.to_surface(point);
        }
        let [x, y, z] = low.map(|value| value as usize);
        let mix = |from: f64, to: f64, part: f64| from + (to - from) * part;
        let along_z = |x: usize, y: usize| mix(self.node([x, y, z]), self.node([x, y, z + 1]), part[2]);
        let along_y = |x: usize| mix(along_z(x, y), along_z(x, y + 1), part[1]);
        mix(along_y(x), along_y(x + 1), part[0])
    }

    fn node(&self, at: [usize; 3]) -> f64 {
        let place = self.place(at);
        let bits = self.nodes[place].load(Ordering::Relaxed);
        if bits != UNKNOWN {
            return f64::from(f32::from_bits(bits));
        }
        let center = self.origin + self.step * DVec3::from(at.map(|value| value as f64));
        let distance = if self.inside[place] { 0.0 } else { self.to_surface(center) };
        self.nodes[place].store((distance as f32).to_bits(), Ordering::Relaxed);
        distance
    }
}

/// Voxels that are full or not.
struct Grid {
    size: [usize; 3],
    full: Vec<bool>,
}

impl Grid {
    fn place(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.size[1] + y) * self.size[2] + z
    }

    /// From one place to the next along each axis.
    fn strides(&self) -> [usize; 3] {
        [self.size[1] * self.size[2], self.size[2], 1]
    }

    /// Full also where one of the 26 neighbours is. The outermost layer stays as it is.
    fn grown(&self) -> Vec<bool> {
        let mut full = self.full.clone();
        for stride in self.strides() {
            let before = full.clone();
            for at in stride..full.len() - stride {
                full[at] = before[at] || before[at - stride] || before[at + stride];
            }
        }
        full
    }

    /// What nothing reaches from outside, when walls are so many voxels thicker; without the walls themselves.
    fn enclosed(&self, thicker: usize) -> Vec<bool> {
        let mut walls = Self { size: self.size, full: self.full.clone() };
        for _ in 0..thicker {
            walls.full = walls.grown();
        }
        let mut outside = Self { size: self.size, full: vec![false; self.full.len()] };
        let mut pending = vec![0_usize];
        outside.full[0] = true;
        while let Some(at) = pending.pop() {
            for stride in self.strides() {
                // Beyond an end of a row is the beginning of the next, which is outside as well.
                for next in [at.wrapping_sub(stride), at + stride] {
                    if outside.full.get(next).is_some_and(|reached| !reached) && !walls.full[next] {
                        outside.full[next] = true;
                        pending.push(next);
                    }
                }
            }
        }
        for _ in 0..thicker {
            outside.full = outside.grown();
        }
        self.full.iter().zip(outside.full).map(|(wall, outside)| !wall && !outside).collect()
    }
}
