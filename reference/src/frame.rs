//! The scene at a frame of its animation.

use aam_scene::Scene;
use glam::Affine3A;

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
