//! Acting on bodies: moves, forces, velocities, parameters, joints. Nothing of it outlives the simulation.

use aam::document::BodyMode;
use aam_scene::NodeId;
use glam::{Affine3A, DAffine3, DMat3, Quat, Vec3};
use rapier3d::prelude::{RigidBodyBuilder, RigidBodyType};

use crate::joint::Joint;
use crate::mesh::Material;
use crate::pose::{Pose, Split};
use crate::world::{Body, World};
use crate::{PhysicsError, Simulator};

/// # Acting on bodies
///
/// Forces, impulses and velocities are for dynamic bodies, moves and joints for dynamic and kinematic ones. A body that
/// sleeps is woken.
impl Simulator {
    /// Begins to move a kinematic or dynamic body by hand. Until [`Simulator::end_move`] a dynamic body is held: it moves
    /// as a kinematic one.
    ///
    /// # Errors
    /// The node is not simulated, or static, or another move has begun.
    pub fn begin_move(&mut self, node: NodeId) -> Result<(), PhysicsError> {
        let (world, index) = self.find_mut(node)?;
        if world.held.is_some() {
            return Err(PhysicsError::Move("a move has begun already; end it first"));
        }
        if world.bodies[index].mode == BodyMode::Static {
            return Err(wrong_mode(&world.bodies[index], "a move", "for kinematic and dynamic bodies"));
        }
        if world.bodies[index].mode == BodyMode::Dynamic {
            world.engine_body_mut(index).set_body_type(RigidBodyType::KinematicPositionBased, true);
        }
        world.held = Some(index);
        Ok(())
    }

    /// Moves the body between begin and end to where its node's world transform would be this one; only its place and
    /// turn count. It goes there in the course of the next step, pushing what is in its way.
    ///
    /// # Errors
    /// No move has begun, or the transform has no turn.
    pub fn move_to(&mut self, transform: &Affine3A) -> Result<(), PhysicsError> {
        let (world, index) = self.held("move_to")?;
        let body = world.bodies[index].frame.inverse();
        let rigid = double(transform) * double(&body);
        let split = Split::of(&rigid).ok_or(PhysicsError::Value("a transform to move to"))?;
        let pose = Pose { position: split.translation.as_vec3(), rotation: split.rotation.as_quat().normalize() };
        if !(pose.position.is_finite() && pose.rotation.is_finite()) {
            return Err(PhysicsError::Value("a transform to move to"));
        }
        world.targets.insert(index, pose);
        Ok(())
    }

    /// Moves the body between begin and end by this much from where it is or was last moved to: first turned about its
    /// centre of mass, then shifted in metres.
    ///
    /// # Errors
    /// No move has begun, or a value is not finite.
    pub fn move_by(&mut self, shift: Vec3, turn: Quat) -> Result<(), PhysicsError> {
        let (world, index) = self.held("move_by")?;
        let turn = turn.normalize();
        if !(shift.is_finite() && turn.is_finite()) {
            return Err(PhysicsError::Value("a move"));
        }
        let from = world.targets.get(&index).copied().unwrap_or_else(|| world.pose(index));
        let pose = Pose { position: from.position + shift, rotation: (turn * from.rotation).normalize() };
        world.targets.insert(index, pose);
        Ok(())
    }

    /// Ends a move. A kinematic body that has not been stepped since still goes where it was moved to in the next step; a
    /// dynamic one is put there at once, at rest. A dynamic one that was stepped meanwhile keeps the speed of its last
    /// step, as a thing that is thrown.
    ///
    /// # Errors
    /// No move has begun.
    pub fn end_move(&mut self) -> Result<(), PhysicsError> {
        let (world, index) = self.held("end_move")?;
        world.held = None;
        if world.bodies[index].mode == BodyMode::Dynamic {
            let target = world.targets.remove(&index);
            let body = world.engine_body_mut(index);
            let velocity = (body.linvel(), body.angvel());
            body.set_body_type(RigidBodyType::Dynamic, true);
            let velocity = match target {
                Some(pose) => {
                    body.set_position(pose.to_engine(), true);
                    (Vec3::ZERO, Vec3::ZERO)
                }
                None => velocity,
            };
            body.set_linvel(velocity.0, true);
            body.set_angvel(velocity.1, true);
        }
        Ok(())
    }

    /// A force in newtons during the next step, at a point in the world or at the centre of mass. Forces add up.
    ///
    /// # Errors
    /// The node is not simulated or not dynamic, or a value is not finite.
    pub fn apply_force(&mut self, node: NodeId, force: Vec3, point: Option<Vec3>) -> Result<(), PhysicsError> {
        let (world, index) = self.dynamic(node, "a force", [force, point.unwrap_or(Vec3::ZERO)])?;
        world.forced.push(index);
        let body = world.engine_body_mut(index);
        match point {
            Some(point) => body.add_force_at_point(force, point, true),
            None => body.add_force(force, true),
        }
        Ok(())
    }

    /// A torque in newton metres during the next step. Torques add up.
    ///
    /// # Errors
    /// The node is not simulated or not dynamic, or a value is not finite.
    pub fn apply_torque(&mut self, node: NodeId, torque: Vec3) -> Result<(), PhysicsError> {
        let (world, index) = self.dynamic(node, "a torque", [torque, Vec3::ZERO])?;
        world.forced.push(index);
        world.engine_body_mut(index).add_torque(torque, true);
        Ok(())
    }

    /// An impulse in newton seconds, at a point in the world or at the centre of mass: the velocity changes at once.
    ///
    /// # Errors
    /// The node is not simulated or not dynamic, or a value is not finite.
    pub fn apply_impulse(&mut self, node: NodeId, impulse: Vec3, point: Option<Vec3>) -> Result<(), PhysicsError> {
        let (world, index) = self.dynamic(node, "an impulse", [impulse, point.unwrap_or(Vec3::ZERO)])?;
        let body = world.engine_body_mut(index);
        match point {
            Some(point) => body.apply_impulse_at_point(impulse, point, true),
            None => body.apply_impulse(impulse, true),
        }
        Ok(())
    }

    /// Sets the velocity of the centre of mass in m/s and the angular velocity in rad/s.
    ///
    /// # Errors
    /// The node is not simulated or not dynamic, or a value is not finite.
    pub fn set_velocity(&mut self, node: NodeId, velocity: Vec3, angular: Vec3) -> Result<(), PhysicsError> {
        let (world, index) = self.dynamic(node, "a velocity", [velocity, angular])?;
        let body = world.engine_body_mut(index);
        body.set_linvel(velocity, true);
        body.set_angvel(angular, true);
        Ok(())
    }

    /// Sets the mass in kilograms, spread evenly.
    ///
    /// # Errors
    /// The node is not simulated or not dynamic, or the mass is not above 0.
    pub fn set_mass(&mut self, node: NodeId, mass: f64) -> Result<(), PhysicsError> {
        let (world, index) = self.dynamic(node, "a mass", [Vec3::ZERO; 2])?;
        if !((mass as f32) > 0.0 && (mass as f32).is_finite()) {
            return Err(PhysicsError::Value("a mass"));
        }
        world.set_mass(index, mass);
        Ok(())
    }

    /// Sets friction and restitution of any body.
    ///
    /// # Errors
    /// The node is not simulated, or a value is out of its range.
    pub fn set_material(&mut self, node: NodeId, material: Material) -> Result<(), PhysicsError> {
        let (world, index) = self.find_mut(node)?;
        if !material.is_valid() {
            return Err(PhysicsError::Value("friction or restitution"));
        }
        world.set_material(index, material);
        Ok(())
    }

    /// Adds a joint to a prepared simulation, with the bodies standing as they do.
    ///
    /// # Errors
    /// A node is not simulated or is static, both are the same, or axis and anchor are no direction and place.
    pub fn add_joint(&mut self, joint: &Joint) -> Result<(), PhysicsError> {
        let (world, index) = self.find_mut(joint.body)?;
        let other = match joint.other {
            None => None,
            Some(node) => Some(*world.by_node.get(&node).ok_or(PhysicsError::NotSimulated(node))?),
        };
        if other == Some(index) {
            return Err(PhysicsError::Joint("both ends are the same body"));
        }
        if [Some(index), other].into_iter().flatten().any(|index| world.bodies[index].mode == BodyMode::Static) {
            return Err(PhysicsError::Joint("a static body cannot have one; join the other body to the world"));
        }
        let ground = match other {
            Some(other) => world.bodies[other].handle,
            None => *world.ground.get_or_insert_with(|| world.engine.bodies.insert(RigidBodyBuilder::fixed())),
        };
        let body = world.bodies[index].handle;
        let (place, other_place) = (world.engine.bodies[body].position(), world.engine.bodies[ground].position());
        let engine_joint = joint
            .to_engine(place, other_place)
            .ok_or(PhysicsError::Joint("its axis is no direction, or its anchor no place"))?;
        world.engine.insert_impulse_joint(body, ground, engine_joint);
        Ok(())
    }

    fn held(&mut self, call: &'static str) -> Result<(&mut World, usize), PhysicsError> {
        let world = self.prepared(call)?;
        let index = world.held.ok_or(PhysicsError::Move("no move has begun; begin one first"))?;
        Ok((world, index))
    }

    fn dynamic(
        &mut self,
        node: NodeId,
        call: &'static str,
        values: [Vec3; 2],
    ) -> Result<(&mut World, usize), PhysicsError> {
        let (world, index) = self.find_mut(node)?;
        if world.bodies[index].mode != BodyMode::Dynamic {
            return Err(wrong_mode(&world.bodies[index], call, "for dynamic bodies"));
        }
        if !values.iter().all(|value| value.is_finite()) {
            return Err(PhysicsError::Value(call));
        }
        Ok((world, index))
    }
}

fn wrong_mode(body: &Body, call: &'static str, only: &'static str) -> PhysicsError {
    let mode = match body.mode {
        BodyMode::Static => "static",
        BodyMode::Kinematic => "kinematic",
        BodyMode::Dynamic => "dynamic",
    };
    PhysicsError::Mode { name: body.name.clone(), mode, call, only }
}

fn double(transform: &Affine3A) -> DAffine3 {
    DAffine3 {
        matrix3: DMat3::from_cols_array(&transform.matrix3.to_cols_array().map(f64::from)),
        translation: transform.translation.as_dvec3(),
    }
}
