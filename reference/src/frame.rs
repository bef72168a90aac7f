//! The scene at a frame of its animation.

use std::borrow::Cow;

use aam_scene::{Mesh, MeshFrame, Scene};
use glam::{Affine3A, Vec3};

/// The frame number as a position: rounded down, and 0 where it is negative or not a number.
pub(crate) fn index(frame: f32) -> usize {
    frame as usize
}

/// Node to world for every node. Past the last frame an animation stands still.
pub(crate) fn world_transforms(scene: &Scene, frame: usize) -> Vec<Affine3A> {
    let mut locals: Vec<Affine3A> = scene.nodes.iter().map(|node| node.local).collect();
    for motion in scene.animation.iter().flat_map(|animation| &animation.nodes) {
        let last = motion.locals.len().saturating_sub(1);
        if let (Some(local), Some(moved)) = (locals.get_mut(motion.node.index()), motion.locals.get(frame.min(last))) {
            *local = *moved;
        }
    }
    let mut world: Vec<Affine3A> = Vec::with_capacity(locals.len());
    for (node, local) in scene.nodes.iter().zip(locals) {
        let parent = node.parent.and_then(|id| world.get(id.index()));
        world.push(parent.map_or(local, |parent| *parent * local));
    }
    world
}

/// Positions of a mesh: of frame 0 itself, then of its later frames, the last of which stays.
pub(crate) fn positions(mesh: &Mesh, frame: usize) -> &[Vec3] {
    let positions = later(mesh, frame).map_or(&mesh.positions, |frame| &frame.positions);
    &positions[..positions.len().min(mesh.positions.len())]
}

/// Normals of a mesh at a frame. One that is missing, zero or not finite is the mean of its triangles' normals instead.
pub(crate) fn normals(mesh: &Mesh, frame: usize) -> Cow<'_, [Vec3]> {
    let normals = later(mesh, frame).map_or(&mesh.normals, |frame| &frame.normals);
    let positions = positions(mesh, frame);
    let usable = |normal: &Vec3| normal.is_finite() && *normal != Vec3::ZERO;
    if normals.len() >= positions.len() && normals.iter().all(usable) {
        return Cow::Borrowed(normals);
    }
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for triangle in mesh.indices.chunks_exact(3) {
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

fn later(mesh: &Mesh, frame: usize) -> Option<&MeshFrame> {
    frame.min(mesh.frames.len()).checked_sub(1).map(|index| &mesh.frames[index])
}
