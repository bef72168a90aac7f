//! Joints: what two bodies, or a body and the world, keep of their relative place.

use aam_scene::NodeId;
use glam::{Quat, Vec3};
use rapier3d::math::Pose as EnginePose;
use rapier3d::prelude::{GenericJoint, GenericJointBuilder, JointAxesMask};

/// A joint, described in the world as the bodies stand when it is added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// What it leaves free.
    pub kind: JointKind,
    /// One body; dynamic or kinematic.
    pub body: NodeId,
    /// The other; `None` is the world, which never moves.
    pub other: Option<NodeId>,
    /// The point in the world that both share.
    pub anchor: Vec3,
    /// Whether the two collide with each other. Jointed bodies mostly overlap, so mostly not.
    pub collide: bool,
}

/// What a joint leaves free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    /// Nothing: both move as one.
    Fixed,
    /// Turning about an axis through the anchor.
    Hinge {
        /// In the world; need not be unit.
        axis: Vec3,
    },
    /// Turning about the anchor.
    Ball,
    /// Moving along an axis, without turning.
    Slider {
        /// In the world; need not be unit.
        axis: Vec3,
    },
}

impl Joint {
    /// The engine's joint for bodies that stand at these poses; `None` where the axis or the anchor is no direction or place.
    pub(crate) fn to_engine(self, body: &EnginePose, other: &EnginePose) -> Option<GenericJoint> {
        let linear = JointAxesMask::LIN_X | JointAxesMask::LIN_Y | JointAxesMask::LIN_Z;
        let angular = JointAxesMask::ANG_X | JointAxesMask::ANG_Y | JointAxesMask::ANG_Z;
        // The engine's free axis is x.
        let (locked, axis) = match self.kind {
            JointKind::Fixed => (linear | angular, Vec3::X),
            JointKind::Hinge { axis } => (linear | JointAxesMask::ANG_Y | JointAxesMask::ANG_Z, axis),
            JointKind::Ball => (linear, Vec3::X),
            JointKind::Slider { axis } => (angular | JointAxesMask::LIN_Y | JointAxesMask::LIN_Z, axis),
        };
        let axis = axis.try_normalize()?;
        if !self.anchor.is_finite() {
            return None;
        }
        let frame = EnginePose::from_parts(self.anchor, Quat::from_rotation_arc(Vec3::X, axis).normalize());
        let joint = GenericJointBuilder::new(locked)
            .local_frame1(body.inv_mul(&frame))
            .local_frame2(other.inv_mul(&frame))
            .contacts_enabled(self.collide);
        Some(joint.build())
    }
}
