//! The surface in each part of a decomposition, as points whose hull is that of the surface.

use glam::{DVec3, IVec3};
use parry3d::transformation::voxelization::VoxelSet;

/// No part.
const NONE: u32 = u32::MAX;

/// For each part the corners of the triangles, cut where they lead from one part to another.
pub(super) fn of_parts(vertices: &[DVec3], triangles: &[[u32; 3]], parts: &[VoxelSet]) -> Vec<Vec<DVec3>> {
    let Some(grid) = Grid::new(parts) else { return Vec::new() };
    let mut clouds = vec![Vec::new(); parts.len()];
    let mut polygon = Vec::new();
    let mut clipped = Vec::new();
    for triangle in triangles {
        let corners = triangle.map(|index| vertices[index as usize]);
        let [a, b, c] = corners;
        let (low, high) = (grid.voxel(a.min(b).min(c)), grid.voxel(a.max(b).max(c)));
        if let Some(only) = grid.only_part(low, high) {
            clouds[only as usize].extend(corners);
            continue;
        }
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let reach = 0.5 * grid.scale * normal.abs().element_sum() * 1.001;
        for (x, y, z) in range(low, high) {
            let part = grid.parts[grid.place(IVec3::new(x, y, z))];
            let center = grid.origin + grid.scale * DVec3::new(f64::from(x), f64::from(y), f64::from(z));
            if part == NONE || (center - a).dot(normal).abs() > reach {
                continue;
            }
            polygon.clear();
            polygon.extend(corners);
            let half = DVec3::splat(0.5 * grid.scale);
            for axis in 0..3 {
                clip(&polygon, &mut clipped, |point| point[axis] - (center - half)[axis]);
                clip(&clipped, &mut polygon, |point| (center + half)[axis] - point[axis]);
            }
            clouds[part as usize].extend_from_slice(&polygon);
        }
    }
    for cloud in &mut clouds {
        cloud.sort_unstable_by(|a, b| a.to_array().map(f64::to_bits).cmp(&b.to_array().map(f64::to_bits)));
        cloud.dedup();
    }
    clouds
}

fn range(low: IVec3, high: IVec3) -> impl Iterator<Item = (i32, i32, i32)> {
    (low.x..=high.x).flat_map(move |x| (low.y..=high.y).flat_map(move |y| (low.z..=high.z).map(move |z| (x, y, z))))
}

/// The part of a convex polygon where `inside` is not negative (I. Sutherland, G. Hodgman, 1974).
fn clip(polygon: &[DVec3], clipped: &mut Vec<DVec3>, inside: impl Fn(DVec3) -> f64) {
    clipped.clear();
    for (index, &to) in polygon.iter().enumerate() {
        let from = polygon[(index + polygon.len() - 1) % polygon.len()];
        let (before, after) = (inside(from), inside(to));
        if (before < 0.0) != (after < 0.0) {
            clipped.push(from + (to - from) * (before / (before - after)));
        }
        if after >= 0.0 {
            clipped.push(to);
        }
    }
}

/// Which part each voxel belongs to.
struct Grid {
    origin: DVec3,
    scale: f64,
    size: IVec3,
    parts: Vec<u32>,
}

impl Grid {
    fn new(parts: &[VoxelSet]) -> Option<Self> {
        let voxels = || parts.iter().flat_map(VoxelSet::voxels);
        let first = parts.iter().find(|part| !part.voxels().is_empty())?;
        let size = voxels().fold(IVec3::ZERO, |size, voxel| size.max(voxel.coords + 1));
        let count = size.to_array().into_iter().map(|value| value as usize).product();
        let mut grid =
            Self { origin: first.origin.as_dvec3(), scale: f64::from(first.scale), size, parts: vec![NONE; count] };
        for (number, part) in parts.iter().enumerate() {
            for voxel in part.voxels() {
                let at = grid.place(voxel.coords);
                grid.parts[at] = number as u32;
            }
        }
        Some(grid)
    }

    fn place(&self, at: IVec3) -> usize {
        let [x, y, z] = at.to_array().map(|value| value as usize);
        (x * self.size.y as usize + y) * self.size.z as usize + z
    }

    /// The voxel that holds a point, or the nearest; voxels are centred on their coordinates.
    fn voxel(&self, point: DVec3) -> IVec3 {
        ((point - self.origin) / self.scale).round().as_ivec3().clamp(IVec3::ZERO, self.size - 1)
    }

    /// The part that all of some voxels belong to, if they belong to one at most.
    fn only_part(&self, low: IVec3, high: IVec3) -> Option<u32> {
        let mut found = NONE;
        for (x, y, z) in range(low, high) {
            let part = self.parts[self.place(IVec3::new(x, y, z))];
            if part != NONE && found != NONE && part != found {
                return None;
            }
            found = found.min(part);
        }
        (found != NONE).then_some(found)
    }
}
