//! Meshes at a frame of their animation.

use std::borrow::Cow;

use glam::Vec3;

use crate::{Mesh, MeshFrame};

impl Mesh {
    /// Positions: of frame 0 the mesh's own, then those of its later frames, the last of which stays.
    pub fn positions_at(&self, frame: usize) -> &[Vec3] {
        let positions = self.later(frame).map_or(&self.positions, |frame| &frame.positions);
        &positions[..positions.len().min(self.positions.len())]
    }

    /// Normals at a frame. One that is missing, zero or not finite is the mean of its triangles' normals instead, and +Z
    /// where that is zero.
    pub fn normals_at(&self, frame: usize) -> Cow<'_, [Vec3]> {
        let normals = self.later(frame).map_or(&self.normals, |frame| &frame.normals);
        let positions = self.positions_at(frame);
        let usable = |normal: &Vec3| normal.is_finite() && *normal != Vec3::ZERO;
        if normals.len() >= positions.len() && normals.iter().all(usable) {
            return Cow::Borrowed(normals);
        }
        let mut sums = vec![Vec3::ZERO; positions.len()];
        for triangle in self.indices.chunks_exact(3) {
            let corner = |k: usize| positions.get(triangle[k] as usize).copied();
            if let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) {
                let normal = (b - a).cross(c - a).normalize_or_zero();
                triangle.iter().for_each(|index| sums[*index as usize] += normal);
            }
        }
        let repair = |(index, sum): (usize, Vec3)| {
            normals.get(index).copied().filter(usable).unwrap_or_else(|| sum.normalize_or(Vec3::Z))
        };
        sums.into_iter().enumerate().map(repair).collect()
    }

    fn later(&self, frame: usize) -> Option<&MeshFrame> {
        frame.min(self.frames.len()).checked_sub(1).map(|index| &self.frames[index])
    }
}
