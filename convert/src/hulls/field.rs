//! How far points are outside of a solid: a grid of distances, filled where it is asked for.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::{DVec3, Vec3};
use parry3d::query::PointQuery;
use parry3d::shape::TriMesh;
use parry3d::transformation::voxelization::VoxelSet;

/// Nodes around the voxels.
const MARGIN: usize = 2;
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
    /// Of a surface and its voxels; `None` if there is no triangle.
    pub(super) fn new(vertices: &[DVec3], triangles: &[[u32; 3]], voxels: &VoxelSet) -> Option<Self> {
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
        let mut field = Self {
            surface,
            origin: voxels.origin.as_dvec3() - step * MARGIN as f64,
            step,
            size,
            inside: vec![false; count],
            nodes: (0..count).map(|_| AtomicU32::new(UNKNOWN)).collect(),
        };
        for voxel in voxels.voxels().iter().filter(|voxel| !voxel.is_on_surface) {
            let at = field.place(coordinates(voxel.coords).map(|value| value + MARGIN));
            field.inside[at] = true;
        }
        Some(field)
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
