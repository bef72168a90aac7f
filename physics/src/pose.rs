//! Places and turns of bodies.

use std::collections::BTreeMap;

use aam_scene::{NodeId, Scene};
use glam::{Affine3A, DAffine3, DMat3, DQuat, DVec3, Quat, Vec3};
use rapier3d::math::Pose as EnginePose;

/// A rigid place: where a body's centre of mass is, and how the body is turned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// The centre of mass in the world, in metres.
    pub position: Vec3,
    /// The turn, a unit quaternion.
    pub rotation: Quat,
}

impl Pose {
    /// As a transform from the body's frame to the world.
    pub fn to_affine(self) -> Affine3A {
        Affine3A::from_rotation_translation(self.rotation, self.position)
    }

    /// The pose between two, linear in place and on the shortest way in turn; `share` 0 gives `self`, 1 gives `other`.
    #[must_use]
    pub fn lerp(self, other: Self, share: f32) -> Self {
        Self {
            position: self.position.lerp(other.position, share),
            rotation: self.rotation.slerp(other.rotation, share),
        }
    }

    pub(crate) fn of_engine(pose: &EnginePose) -> Self {
        Self { position: pose.translation, rotation: pose.rotation }
    }

    pub(crate) fn to_engine(self) -> EnginePose {
        EnginePose::from_parts(self.position, self.rotation)
    }
}

/// The poses of all bodies at one moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Poses {
    /// Simulated time in seconds.
    pub time: f64,
    /// One for each body, in the order of [`crate::Simulator::bodies`].
    pub poses: Vec<Pose>,
}

impl Poses {
    /// The poses between two moments of the same bodies, at a time that is clamped to lie between them.
    pub fn between(before: &Self, after: &Self, time: f64) -> Self {
        let span = after.time - before.time;
        let share = if span > 0.0 { ((time - before.time) / span).clamp(0.0, 1.0) } else { 1.0 };
        let poses = before.poses.iter().zip(&after.poses).map(|(a, b)| a.lerp(*b, share as f32)).collect();
        Self { time: before.time + share * span, poses }
    }
}

/// Which nodes are bodies, and how each is stretched: what turns poses into the transforms of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Places {
    /// By node: the place in [`Poses::poses`], and from the node's coordinates to the body's.
    pub(crate) bodies: BTreeMap<NodeId, (usize, Affine3A)>,
}

impl Places {
    /// Node to world for every node of the scene, with the bodies at these poses.
    ///
    /// A simulated node takes its transform from its pose, whatever its parent and the scene say, with the scale that it
    /// had when the simulation was prepared. Every other node follows its parent as usual.
    pub fn transforms(&self, scene: &Scene, poses: &Poses) -> Vec<Affine3A> {
        let mut world: Vec<Affine3A> = Vec::with_capacity(scene.nodes.len());
        for (index, node) in scene.nodes.iter().enumerate() {
            let simulated = self
                .bodies
                .get(&NodeId(index as u32))
                .and_then(|(body, frame)| Some(poses.poses.get(*body)?.to_affine() * *frame));
            world.push(simulated.unwrap_or_else(|| {
                let parent = node.parent.and_then(|id| world.get(id.index()));
                parent.map_or(node.local, |parent| *parent * node.local)
            }));
        }
        world
    }
}

/// A transform as a rigid turn with a place, after a stretch that holds scale, shear and reflection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Split {
    pub(crate) rotation: DQuat,
    pub(crate) translation: DVec3,
    pub(crate) stretch: DMat3,
}

impl Split {
    /// `transform = translation · rotation · stretch`, the rotation being the nearest to the matrix (polar decomposition
    /// by Newton's iteration, Higham 1986). `None` where the matrix is not finite or flattens space.
    pub(crate) fn of(transform: &DAffine3) -> Option<Self> {
        let matrix = transform.matrix3;
        let size = matrix.to_cols_array().into_iter().fold(0.0, |size: f64, value| size.max(value.abs()));
        if !(transform.is_finite() && size > 0.0) {
            return None;
        }
        let unit = matrix * size.recip();
        if unit.determinant().abs() < 1e-12 {
            return None;
        }
        let mut turn = unit;
        for _ in 0..64 {
            let next = (turn + turn.inverse().transpose()) * 0.5;
            let moved = (next - turn).to_cols_array().into_iter().fold(0.0, |moved: f64, value| moved.max(value.abs()));
            turn = next;
            if moved < 1e-15 {
                break;
            }
        }
        if turn.determinant() < 0.0 {
            turn = -turn;
        }
        let rotation = DQuat::from_mat3(&turn).normalize();
        let stretch = DMat3::from_quat(rotation.conjugate()) * matrix;
        (rotation.is_finite() && stretch.is_finite()).then_some(Self {
            rotation,
            translation: transform.translation,
            stretch,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transform_splits_and_joins() {
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.5, -1.0, 2.5);
        for scale in [DVec3::ONE, DVec3::new(2.0, 0.5, 3.0), DVec3::new(-1.0, 2.0, 1e-3), DVec3::splat(-1e3)] {
            let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.7, 1.0, 0.0), DVec3::new(0.0, -0.3, 1.0));
            let place = DVec3::new(1.0, 2.0, 3.0);
            let matrix = DMat3::from_quat(turn) * DMat3::from_diagonal(scale) * shear;
            let split = Split::of(&DAffine3::from_mat3_translation(matrix, place)).expect("it has a volume");
            assert!(split.rotation.is_normalized());
            let joined = DMat3::from_quat(split.rotation) * split.stretch;
            let size = scale.abs().max_element();
            assert!((joined - matrix).to_cols_array().into_iter().all(|v| v.abs() < 1e-12 * size), "{scale}");
            let skew = split.stretch - split.stretch.transpose();
            assert!(skew.to_cols_array().into_iter().all(|v| v.abs() < 1e-6 * size), "a stretch has no turn");
        }
    }

    #[test]
    fn a_flat_or_broken_transform_is_none() {
        let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
        let broken = DAffine3::from_translation(DVec3::NAN);
        assert!(Split::of(&flat).is_none() && Split::of(&broken).is_none());
        assert!(Split::of(&DAffine3::from_scale(DVec3::splat(1e-6))).is_some());
    }

    #[test]
    fn poses_are_interpolated() {
        let at = |time: f64, x: f32, angle: f32| Poses {
            time,
            poses: vec![Pose { position: Vec3::new(x, 0.0, 0.0), rotation: Quat::from_rotation_z(angle) }],
        };
        let (before, after) = (at(1.0, 0.0, 0.0), at(1.5, 2.0, 1.0));
        let middle = Poses::between(&before, &after, 1.125);
        assert_eq!((middle.time, middle.poses[0].position.x), (1.125, 0.5));
        assert!(middle.poses[0].rotation.angle_between(Quat::from_rotation_z(0.25)) < 1e-3);
        assert_eq!(Poses::between(&before, &after, 9.0), after);
        assert_eq!(Poses::between(&before, &before, 1.0).poses, before.poses);
    }
}
