//! Which objects are simulated, and where they are.

use std::collections::BTreeMap;
use std::sync::Arc;

use aam::Finding;
use aam::document::BodyMode;
use aam_scene::{NodeId, Scene};
use glam::{Affine3A, Vec3};

use crate::mesh::{Material, PhysicsMesh};
use crate::pose::{Places, Pose, Poses};
use crate::settings::Settings;
use crate::world::World;
use crate::{Divergence, PhysicsError};

/// Who registers objects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Registration {
    /// [`Simulator::object_created`] registers.
    #[default]
    Automatic,
    /// Only [`Simulator::register`] does.
    Manual,
}

/// Simulates the bodies of a scene.
///
/// There may be several, for several sets of objects. A program draws with the transforms of one of them; which one is
/// its own choice.
pub struct Simulator {
    settings: Settings,
    registration: Registration,
    registered: BTreeMap<NodeId, Arc<PhysicsMesh>>,
    world: Option<World>,
    started: bool,
}

/// The state of a simulated body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyState {
    /// How it moves.
    pub mode: BodyMode,
    /// Its centre of mass and turn.
    pub pose: Pose,
    /// In m/s, of the centre of mass.
    pub velocity: Vec3,
    /// In rad/s, about the world's axes.
    pub angular_velocity: Vec3,
    /// In kilograms; 0 for bodies that are not dynamic.
    pub mass: f64,
    /// What it is made of, in this simulation.
    pub material: Material,
    /// At rest, and costing nothing until something acts on it.
    pub sleeping: bool,
}

impl Simulator {
    /// A simulator with no objects.
    ///
    /// # Errors
    /// A setting is outside its range.
    pub fn new(settings: Settings, registration: Registration) -> Result<Self, PhysicsError> {
        settings.check()?;
        Ok(Self { settings, registration, registered: BTreeMap::new(), world: None, started: false })
    }

    /// How it simulates.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Other settings, from the next [`Simulator::prepare`] on.
    ///
    /// # Errors
    /// A setting is outside its range.
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), PhysicsError> {
        settings.check()?;
        self.settings = settings;
        Ok(())
    }

    /// Told of every object that a program creates: registers it if registration is automatic.
    pub fn object_created(&mut self, node: NodeId, mesh: &Arc<PhysicsMesh>) {
        if self.registration == Registration::Automatic {
            self.register(node, mesh);
        }
    }

    /// Registers an object for the next simulation. The running one stays as it is.
    pub fn register(&mut self, node: NodeId, mesh: &Arc<PhysicsMesh>) {
        self.registered.insert(node, Arc::clone(mesh));
    }

    /// Takes an object out, from the next simulation on; false if it was not registered.
    pub fn unregister(&mut self, node: NodeId) -> bool {
        self.registered.remove(&node).is_some()
    }

    /// The registered objects.
    pub fn registered(&self) -> impl Iterator<Item = NodeId> {
        self.registered.keys().copied()
    }

    /// Copies the registered objects, with the world transforms that the scene gives them, into a world of their own.
    /// A simulation that was prepared before is ended.
    ///
    /// Gives a warning for each object that cannot be simulated: it has no volume, or its transform flattens it.
    pub fn prepare(&mut self, scene: &Scene) -> Vec<Finding> {
        self.end();
        let (world, findings) = World::new(scene, &self.registered, &self.settings);
        self.world = Some(world);
        findings
    }

    /// Lets a prepared simulation run.
    ///
    /// # Errors
    /// None is prepared.
    pub fn start(&mut self) -> Result<(), PhysicsError> {
        self.world("start")?;
        self.started = true;
        Ok(())
    }

    /// Ends the simulation: every object is where the scene says, and nothing of what happened is kept. Registered
    /// objects stay registered.
    pub fn end(&mut self) {
        self.world = None;
        self.started = false;
    }

    /// Whether a simulation is prepared, started or not.
    pub fn is_prepared(&self) -> bool {
        self.world.is_some()
    }

    /// Whether a simulation is started.
    pub fn is_started(&self) -> bool {
        self.started
    }

    /// One step of [`Settings::time_step`].
    ///
    /// # Errors
    /// No simulation is started, or it broke: then it is stopped, and every later call gives the same error.
    pub fn step(&mut self) -> Result<(), PhysicsError> {
        let started = self.started;
        match &mut self.world {
            Some(world) if started => Ok(world.step()?),
            _ => Err(PhysicsError::State { call: "step", state: "started" }),
        }
    }

    /// Simulated time in seconds; 0 if nothing is prepared.
    pub fn time(&self) -> f64 {
        self.world.as_ref().map_or(0.0, World::time)
    }

    /// Steps done; 0 if nothing is prepared.
    pub fn steps(&self) -> u64 {
        self.world.as_ref().map_or(0, |world| world.steps)
    }

    /// Where the simulation broke, if it did.
    pub fn divergence(&self) -> Option<&Divergence> {
        self.world.as_ref()?.broken.as_ref()
    }

    /// A hash over poses and velocities of all bodies after every step so far: equal for runs that are equal bit for bit.
    pub fn hash(&self) -> u64 {
        self.world.as_ref().map_or(0, |world| world.hash)
    }

    /// The simulated nodes, in the order of [`Poses::poses`].
    pub fn bodies(&self) -> impl Iterator<Item = NodeId> {
        self.world.iter().flat_map(|world| world.bodies.iter().map(|body| body.node))
    }

    /// The name of a simulated body.
    pub fn name(&self, node: NodeId) -> Option<&str> {
        let (world, index) = self.find(node).ok()?;
        Some(&world.bodies[index].name)
    }

    /// The state of a simulated body.
    ///
    /// # Errors
    /// The node is not simulated.
    pub fn state(&self, node: NodeId) -> Result<BodyState, PhysicsError> {
        let (world, index) = self.find(node)?;
        let (body, engine) = (&world.bodies[index], world.engine_body(index));
        Ok(BodyState {
            mode: body.mode,
            pose: world.pose(index),
            velocity: engine.linvel(),
            angular_velocity: engine.angvel(),
            mass: body.mass,
            material: body.material,
            sleeping: engine.is_sleeping(),
        })
    }

    /// The poses of all bodies now.
    pub fn poses(&self) -> Poses {
        self.world.as_ref().map(World::poses).unwrap_or_default()
    }

    /// Node to world for every node of the scene, as [`Scene::world_transforms`] but with the bodies where they are now.
    pub fn world_transforms(&self, scene: &Scene) -> Vec<Affine3A> {
        self.transforms_at(scene, &self.poses())
    }

    /// [`Places::transforms`] of this simulation.
    pub fn transforms_at(&self, scene: &Scene, poses: &Poses) -> Vec<Affine3A> {
        self.places().transforms(scene, poses)
    }

    /// What is needed to draw at any poses; it stays the same until the simulation ends.
    pub fn places(&self) -> Places {
        let bodies = self.world.iter().flat_map(|world| world.bodies.iter().enumerate());
        Places { bodies: bodies.map(|(index, body)| (body.node, (index, body.frame))).collect() }
    }

    /// Whether each body sleeps, in the order of [`Poses::poses`].
    pub fn sleeping(&self) -> Vec<bool> {
        let bodies = self.world.iter().flat_map(|world| (0..world.bodies.len()).map(|index| world.engine_body(index)));
        bodies.map(|body| body.is_sleeping()).collect()
    }

    pub(crate) fn peek(&self) -> Option<&World> {
        self.world.as_ref()
    }

    pub(crate) fn body_of(&self, node: NodeId) -> Option<usize> {
        self.world.as_ref()?.by_node.get(&node).copied()
    }

    fn world(&mut self, call: &'static str) -> Result<&mut World, PhysicsError> {
        self.world.as_mut().ok_or(PhysicsError::State { call, state: "prepared" })
    }

    fn find(&self, node: NodeId) -> Result<(&World, usize), PhysicsError> {
        let found = self.world.as_ref().and_then(|world| Some((world, *world.by_node.get(&node)?)));
        found.ok_or(PhysicsError::NotSimulated(node))
    }

    /// A simulated body to act on.
    pub(crate) fn find_mut(&mut self, node: NodeId) -> Result<(&mut World, usize), PhysicsError> {
        let (_, index) = self.find(node)?;
        Ok((self.world("this")?, index))
    }

    pub(crate) fn prepared(&mut self, call: &'static str) -> Result<&mut World, PhysicsError> {
        self.world(call)
    }
}
