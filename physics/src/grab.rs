//! Pulling a body by one of its points, as a hand does.

use aam::document::BodyMode;
use aam_scene::NodeId;
use glam::{DMat3, DVec3, Vec3};

use crate::pose::Pose;
use crate::world::World;
use crate::{PhysicsError, Simulator};

/// How often a body would swing about the hand in a second, were it not damped.
const FREQUENCY: f64 = 6.0;
/// The hand pulls with no more than so many times the weight of the body, so that it drags no body through another.
const STRENGTH: f64 = 50.0 * 9.81;
/// How fast a held body loses its spin, in 1/s.
const SPIN_DAMPING: f32 = 4.0;

/// A body that is held.
#[derive(Clone, Copy)]
pub(crate) struct Grab {
    index: usize,
    /// Where, in the body's frame.
    local: Vec3,
    /// Where the hand is.
    hand: Vec3,
}

/// # Pulling a body
impl Simulator {
    /// Takes hold of a body at a point in the world. A dynamic body then hangs on a critically damped spring of 6 Hz,
    /// whatever its mass, that pulls with at most 50 times its weight; a kinematic one follows the hand exactly. What was
    /// held before is let go.
    ///
    /// # Errors
    /// The node is not simulated, or static, the point is not finite, or a move has begun.
    pub fn grab(&mut self, node: NodeId, point: Vec3) -> Result<(), PhysicsError> {
        self.release();
        if !point.is_finite() {
            return Err(PhysicsError::Value("a point to hold"));
        }
        let (world, index) = self.find_mut(node)?;
        let local = world.pose(index).to_affine().inverse().transform_point3(point);
        if world.bodies[index].mode == BodyMode::Dynamic {
            let body = world.engine_body_mut(index);
            body.set_angular_damping(SPIN_DAMPING);
            body.wake_up(true);
        } else {
            self.begin_move(node)?;
        }
        self.prepared("grab")?.grab = Some(Grab { index, local, hand: point });
        Ok(())
    }

    /// Moves the hand; the body follows in the next steps.
    ///
    /// # Errors
    /// Nothing is held, or the point is not finite.
    pub fn pull_to(&mut self, point: Vec3) -> Result<(), PhysicsError> {
        let world = self.prepared("pull_to")?;
        let Some(grab) = &mut world.grab else { return Err(PhysicsError::Move("nothing is held; grab a body first")) };
        if !point.is_finite() {
            return Err(PhysicsError::Value("a point to pull to"));
        }
        grab.hand = point;
        Ok(())
    }

    /// Lets go; the body keeps its speed. Nothing happens if nothing is held.
    pub fn release(&mut self) {
        let Ok(world) = self.prepared("release") else { return };
        let Some(grab) = world.grab.take() else { return };
        if world.bodies[grab.index].mode == BodyMode::Dynamic {
            world.engine_body_mut(grab.index).set_angular_damping(0.0);
        } else {
            world.held = None;
        }
    }

    /// The held body, the point of it that is held, and the hand, both in the world.
    pub fn grabbed(&self) -> Option<(NodeId, [Vec3; 2])> {
        let world = self.peek()?;
        let grab = world.grab.as_ref()?;
        let point = world.pose(grab.index).to_affine().transform_point3(grab.local);
        Some((world.bodies[grab.index].node, [point, grab.hand]))
    }
}

impl World {
    /// What the hand does in the next step.
    pub(crate) fn pull(&mut self) {
        let Some(Grab { index, local, hand }) = self.grab else { return };
        let pose = self.pose(index);
        let arm = pose.rotation * local;
        if self.bodies[index].mode != BodyMode::Dynamic {
            self.targets.insert(index, Pose { position: hand - arm, ..pose });
            return;
        }
        let (step, mass) = (f64::from(self.time_step()), self.bodies[index].mass);
        let state = self.engine_body(index);
        // The speed that the point would have after the step, without the hand.
        let velocity =
            (state.velocity_at_point(pose.position + arm) + self.engine.gravity * self.time_step()).as_dvec3();
        let away = (pose.position + arm - hand).as_dvec3();
        // A spring that is solved for the end of the step (E. Catto, "Soft Constraints", 2011), so that none is too long.
        let omega = std::f64::consts::TAU * FREQUENCY;
        let (stiffness, damping) = (mass * omega * omega, 2.0 * mass * omega);
        let softness = 1.0 / (step * (damping + step * stiffness));
        let turn = DMat3::from_quat(pose.rotation.as_dquat());
        let inertia = turn * self.bodies[index].inertia() * turn.transpose();
        let cross = cross_matrix(arm.as_dvec3());
        let compliance = DMat3::from_diagonal(DVec3::splat(1.0 / mass + softness)) - cross * inertia.inverse() * cross;
        let impulse = -(compliance.inverse() * (velocity + away * (step * stiffness * softness)));
        // As a force, which the engine spreads over the step as it does gravity: what hangs still stays still.
        let force = (impulse / step).clamp_length_max(STRENGTH * mass).as_vec3();
        if force.is_finite() {
            self.forced.push(index);
            self.engine_body_mut(index).add_force_at_point(force, pose.position + arm, true);
        }
    }
}

/// The matrix whose product with a vector is the cross product.
fn cross_matrix(v: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, v.z, -v.y), DVec3::new(-v.z, 0.0, v.x), DVec3::new(v.y, -v.x, 0.0))
}
