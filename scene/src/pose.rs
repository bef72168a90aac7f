//! A scene and its meshes at a frame of the animation.

use std::borrow::Cow;

use glam::{Affine3A, Vec3};

use crate::{Mesh, MeshFrame, Scene};

impl Scene {
    /// Node to world for every node at a frame, in order. Past the last frame an animation stands still.
    pub fn world_transforms_at(&self, frame: usize) -> Vec<Affine3A> {
        let mut locals: Vec<Affine3A> = self.nodes.iter().map(|node| node.local).collect();
        for motion in self.animation.iter().flat_map(|animation| &animation.nodes) {
            let last = motion.locals.len().saturating_sub(1);
            if let (Some(local), Some(moved)) =
                (locals.get_mut(motion.node.index()), motion.locals.get(frame.min(last)))
            {
                *local = *moved;
            }
        }
        let mut world: Vec<Affine3A> = Vec::with_capacity(locals.len());
        for (node, local) in self.nodes.iter().zip(locals) {
            let parent = node.parent.and_then(|id| world.get(id.index()));
            world.push(parent.map_or(local, |parent| *parent * local));
        }
        world
    }
}

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
