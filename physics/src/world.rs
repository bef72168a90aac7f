//! A prepared simulation: the engine's world and which node each of its bodies belongs to.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use aam::Finding;
use aam::document::BodyMode;
use aam_scene::{NodeId, Scene};
use glam::{Affine3A, DAffine3, DMat3, Vec3};
use rapier3d::prelude::{
    ActiveHooks, Collider as EngineCollider, ColliderBuilder, ColliderHandle, FrictionModel, MassProperties,
    PhysicsWorld, RigidBody, RigidBodyBuilder, RigidBodyHandle, RigidBodyType,
};

use crate::collider::{Collider, collider};
use crate::error::{Divergence, What};
use crate::friction::{TwoCoefficients, pack};
use crate::grab::Grab;
use crate::mesh::{Material, PhysicsMesh, left_out};
use crate::pose::{Pose, Poses, Split};
use crate::settings::{Continuous, Settings};

/// Gravity at the Earth's surface in m/s².
const GRAVITY: f32 = 9.81;

/// Natural frequencies of contacts in Hz: the engine's own, and one that 32 bits still resolve.
const SOFTEST: f32 = 30.0;
const STIFFEST: f32 = 1000.0;

pub(crate) struct World {
    pub(crate) engine: PhysicsWorld,
    pub(crate) bodies: Vec<Body>,
    pub(crate) by_node: HashMap<NodeId, usize>,
    /// Bodies with a force for the next step only.
    pub(crate) forced: Vec<usize>,
    /// Where kinematic bodies, and dynamic ones that are held, go in the next step.
    pub(crate) targets: BTreeMap<usize, Pose>,
    /// The body between a begin and an end of moving.
    pub(crate) held: Option<usize>,
    /// The body that a hand pulls.
    pub(crate) grab: Option<Grab>,
    /// The body that stands for the world in joints.
    pub(crate) ground: Option<RigidBodyHandle>,
    pub(crate) steps: u64,
    pub(crate) hash: u64,
    pub(crate) broken: Option<Divergence>,
    hooks: TwoCoefficients,
    settings: Settings,
    center: Vec3,
}

pub(crate) struct Body {
    pub(crate) node: NodeId,
    pub(crate) name: String,
    pub(crate) mode: BodyMode,
    pub(crate) handle: RigidBodyHandle,
    pub(crate) collider: ColliderHandle,
    /// From the node's coordinates to the body's frame: scale, shear and reflection, frozen when it was prepared.
    pub(crate) frame: Affine3A,
    pub(crate) material: Material,
    /// Its shape and mass.
    made: Collider,
    pub(crate) mass: f64,
}

impl Body {
    /// Around the centre of mass, along the body's axes.
    pub(crate) fn inertia(&self) -> DMat3 {
        self.made.moments.inertia(self.mass)
    }
}

impl World {
    /// The registered nodes of a scene as bodies at their places. Nodes that cannot be bodies are left out with a warning.
    pub(crate) fn new(
        scene: &Scene,
        registered: &BTreeMap<NodeId, Arc<PhysicsMesh>>,
        settings: &Settings,
    ) -> (Self, Vec<Finding>) {
        let mut world = Self {
            engine: PhysicsWorld::new(),
            bodies: Vec::with_capacity(registered.len()),
            by_node: HashMap::with_capacity(registered.len()),
            forced: Vec::new(),
            targets: BTreeMap::new(),
            held: None,
            grab: None,
            ground: None,
            steps: 0,
            hash: FNV_OFFSET,
            broken: None,
            hooks: TwoCoefficients::new(1.0),
            settings: *settings,
            center: Vec3::ZERO,
        };
        let mut findings = Vec::new();
        let places = scene.world_transforms();
        let mut shapes: HashMap<(usize, [u64; 9]), Result<Collider, &'static str>> = HashMap::new();
        let mut ready = Vec::with_capacity(registered.len());
        for (&node, mesh) in registered {
            let refused = |reason| left_out(format!("node {} \"{}\"", node.index(), mesh.name), reason);
            let Some(place) = places.get(node.index()) else {
                findings.push(refused("the scene has no such node"));
                continue;
            };
            let Some(split) = Split::of(&DAffine3 {
                matrix3: DMat3::from_cols_array(&place.matrix3.to_cols_array().map(f64::from)),
                translation: place.translation.as_dvec3(),
            }) else {
                findings.push(refused("its transform flattens it, or is no transform"));
                continue;
            };
            let bits = split.stretch.to_cols_array().map(|value| (value as f32 + 0.0).to_bits().into());
            let shape = shapes.entry((Arc::as_ptr(mesh).addr(), bits));
            match shape.or_insert_with(|| collider(&mesh.shape, mesh.mode, &split.stretch)) {
                Ok(made) => ready.push((node, mesh, split, made.clone())),
                Err(reason) => findings.push(refused(reason)),
            }
        }
        let unit = settings.length_unit.unwrap_or_else(|| {
            let moving = ready.iter().filter(|(_, mesh, _, _)| mesh.mode == BodyMode::Dynamic);
            typical_size(moving.map(|(_, _, _, made)| made.radius).collect())
        });
        world.configure(scene, unit);
        for (node, mesh, split, made) in ready {
            world.add(node, mesh, &split, made);
        }
        let sum: Vec3 = world.bodies.iter().map(|body| world.engine.bodies[body.handle].translation()).sum();
        world.center = sum / world.bodies.len().max(1) as f32;
        (world, findings)
    }

    fn configure(&mut self, scene: &Scene, unit: f32) {
        let settings = self.settings;
        self.hooks = TwoCoefficients::new(unit);
        self.engine.gravity = settings.gravity.unwrap_or(-GRAVITY * scene.up.axis());
        let parameters = &mut self.engine.integration_parameters;
        parameters.dt = settings.time_step;
        parameters.num_solver_iterations = settings.iterations;
        parameters.length_unit = unit;
        // One friction constraint for each patch of contact. The engine's other model, one for each point, brakes a sliding
        // box 13 % too weakly.
        parameters.friction_model = FrictionModel::Simplified;
        // A body that is too fast is told of, not slowed down in silence.
        parameters.normalized_max_linear_velocity = f32::MAX;
        // Merging the contacts of a compound's pieces lets a stool creep on its three legs instead of coming to rest.
        parameters.contact_clustering = false;
        // Contacts are springs. The stiffer they are, the less bodies sink in, and an eighth of the rate of the solver's
        // substeps is as stiff as piles stand; the engine's fixed value would make more iterations useless.
        let rate = settings.iterations as f32 / settings.time_step;
        let stiffness = (rate / 8.0).clamp(SOFTEST, STIFFEST);
        parameters.contact_softness.natural_frequency = stiffness;
        parameters.static_contact_softness.natural_frequency = 2.0 * stiffness;
        // Joints keep their shape better under load when they start from what held them in the step before.
        parameters.warmstart_joints = true;
        parameters.max_ccd_substeps = usize::from(settings.continuous != Continuous::Off);
        parameters.min_ccd_dt = settings.time_step / 100.0;
    }

    fn add(&mut self, node: NodeId, mesh: &PhysicsMesh, split: &Split, made: Collider) {
        let kind = match mesh.mode {
            BodyMode::Static => RigidBodyType::Fixed,
            BodyMode::Kinematic => RigidBodyType::KinematicPositionBased,
            BodyMode::Dynamic => RigidBodyType::Dynamic,
        };
        let origin = DMat3::from_quat(split.rotation) * made.center + split.translation;
        let pose = Pose { position: origin.as_vec3(), rotation: split.rotation.as_quat().normalize() };
        let mut body = RigidBodyBuilder::new(kind)
            .pose(pose.to_engine())
            .can_sleep(self.settings.sleeping)
            .allow_fast_rotation(true)
            .user_data(self.bodies.len() as u128)
            .build();
        // Spread evenly: the mass goes with the volume.
        let mass = mesh.mass.map_or(0.0, |mass| f64::from(mass) * split.stretch.determinant().abs());
        if mesh.mode == BodyMode::Dynamic {
            body.set_additional_mass_properties(mass_properties(&made, mass), true);
        }
        let handle = self.engine.insert_body(body);
        let collider = ColliderBuilder::new(made.shape.clone()).position(made.place).density(0.0).build();
        let collider = self.engine.insert_collider(collider, Some(handle));
        self.measure(handle);
        let frame = DAffine3::from_translation(-made.center) * DAffine3::from_mat3(split.stretch);
        self.by_node.insert(node, self.bodies.len());
        self.bodies.push(Body {
            node,
            name: mesh.name.clone(),
            mode: mesh.mode,
            handle,
            collider,
            frame: single(&frame),
            material: mesh.material,
            made,
            mass,
        });
        self.set_material(self.bodies.len() - 1, mesh.material);
    }

    pub(crate) fn set_material(&mut self, index: usize, material: Material) {
        let body = &mut self.bodies[index];
        body.material = material;
        let Material { static_friction, dynamic_friction, restitution } = material;
        let collider = &mut self.engine.colliders[body.collider];
        collider.set_friction(static_friction);
        collider.set_restitution(restitution);
        collider.user_data = pack(static_friction, dynamic_friction);
        collider.set_active_hooks(if static_friction == dynamic_friction {
            ActiveHooks::empty()
        } else {
            ActiveHooks::MODIFY_SOLVER_CONTACTS
        });
    }

    pub(crate) fn set_mass(&mut self, index: usize, mass: f64) {
        let body = &mut self.bodies[index];
        body.mass = mass;
        let properties = mass_properties(&body.made, mass);
        let handle = body.handle;
        self.engine.bodies[handle].set_additional_mass_properties(properties, true);
        self.measure(handle);
    }

    /// Lets a new mass count at once, not only from the next step on: impulses use it.
    fn measure(&mut self, body: RigidBodyHandle) {
        self.engine.bodies[body].recompute_mass_properties_from_colliders(&self.engine.colliders);
    }

    pub(crate) fn engine_body(&self, index: usize) -> &RigidBody {
        &self.engine.bodies[self.bodies[index].handle]
    }

    pub(crate) fn engine_body_mut(&mut self, index: usize) -> &mut RigidBody {
        &mut self.engine.bodies[self.bodies[index].handle]
    }

    pub(crate) fn time_step(&self) -> f32 {
        self.settings.time_step
    }

    /// The body that a collider is part of.
    pub(crate) fn body_of_collider(&self, collider: &EngineCollider) -> Option<usize> {
        let body = self.engine.bodies.get(collider.parent()?)?;
        usize::try_from(body.user_data).ok().filter(|index| *index < self.bodies.len())
    }

    pub(crate) fn time(&self) -> f64 {
        self.steps as f64 * f64::from(self.settings.time_step)
    }

    pub(crate) fn pose(&self, index: usize) -> Pose {
        Pose::of_engine(self.engine_body(index).position())
    }

    pub(crate) fn poses(&self) -> Poses {
        Poses { time: self.time(), poses: (0..self.bodies.len()).map(|index| self.pose(index)).collect() }
    }

    /// One step. Once broken it stays as it is.
    pub(crate) fn step(&mut self) -> Result<(), Divergence> {
        if let Some(broken) = &self.broken {
            return Err(broken.clone());
        }
        self.pull();
        for (index, target) in std::mem::take(&mut self.targets) {
            self.engine_body_mut(index).set_next_kinematic_position(target.to_engine());
        }
        if self.settings.continuous == Continuous::All {
            self.sweep_fast_bodies();
        }
        self.engine.step_with_events(&self.hooks, &());
        for index in std::mem::take(&mut self.forced) {
            let body = self.engine_body_mut(index);
            body.reset_forces(false);
            body.reset_torques(false);
        }
        self.steps += 1;
        self.judge()?;
        self.count();
        Ok(())
    }

    /// The engine sweeps no body that is to be swept against another such body, so that only fast ones may be: those that
    /// would go farther in a step than they are thick.
    fn sweep_fast_bodies(&mut self) {
        for body in self.bodies.iter().filter(|body| body.mode == BodyMode::Dynamic) {
            let Some(state) = self.engine.bodies.get(body.handle) else { continue };
            let fast = state.linvel().length() * self.settings.time_step > body.made.thickness;
            if fast != state.is_ccd_enabled()
                && let Some(state) = self.engine.bodies.get_mut(body.handle)
            {
                state.enable_ccd(fast);
            }
        }
    }

    /// Whether all bodies are where bodies can be.
    fn judge(&mut self) -> Result<(), Divergence> {
        let lost = self.engine.quarantine().bodies().to_vec();
        let broken = self.bodies.iter().find_map(|body| {
            let state = &self.engine.bodies[body.handle];
            let speed = state.linvel().length();
            let distance = state.translation().distance(self.center);
            let finite = speed.is_finite() && distance.is_finite() && state.angvel().is_finite();
            let what = if lost.contains(&body.handle) || !finite || !state.rotation().is_finite() {
                What::NotFinite
            } else if body.mode == BodyMode::Static {
                return None;
            } else if speed > self.settings.max_speed {
                What::TooFast(speed)
            } else if distance > self.settings.max_distance {
                What::Lost(distance)
            } else {
                return None;
            };
            let (node, name) = (body.node, body.name.clone());
            Some(Divergence { step: self.steps, time: self.time(), node, name, what })
        });
        self.broken.clone_from(&broken);
        broken.map_or(Ok(()), Err)
    }

    /// Adds the state of all bodies to the hash.
    fn count(&mut self) {
        let mut hash = self.hash;
        for body in &self.bodies {
            let state = &self.engine.bodies[body.handle];
            let place = state.translation().to_array().into_iter().chain(state.rotation().to_array());
            for value in place.chain(state.linvel().to_array()).chain(state.angvel().to_array()) {
                for byte in value.to_bits().to_le_bytes() {
                    hash = (hash ^ u64::from(byte)).wrapping_mul(FNV_PRIME);
                }
            }
        }
        self.hash = hash;
    }
}

/// The hash of Fowler, Noll and Vo, variant 1a, in 64 bits.
const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0100_0000_01b3;

fn mass_properties(made: &Collider, mass: f64) -> MassProperties {
    MassProperties::with_inertia_matrix(Vec3::ZERO, mass as f32, made.moments.inertia(mass).as_mat3())
}

/// The edge of a cube as large as the middle one of bodies with these radii, so that a crate of a metre gives 1.
fn typical_size(mut radii: Vec<f32>) -> f32 {
    radii.sort_by(f32::total_cmp);
    let middle = radii.get(radii.len() / 2).copied().unwrap_or(0.0);
    let size = middle * 2.0 / 3.0_f32.sqrt();
    if size > 0.0 && size.is_finite() { size } else { 1.0 }
}

pub(crate) fn single(transform: &DAffine3) -> Affine3A {
    Affine3A::from_mat3_translation(transform.matrix3.as_mat3(), transform.translation.as_vec3())
}
