//! A small stage for bodies.
#![allow(dead_code, unused_imports, reason = "each of the tests uses a part")]

use std::sync::Arc;

use aam::document::{BodyMode, Primitive};
use aam_physics::{Material, PhysicsMesh, Registration, Settings, Shape, Simulator};
use aam_scene::{Node, NodeId, Scene};
use glam::{Affine3A, Quat, Vec3};

pub(crate) use BodyMode::{Dynamic, Kinematic, Static};

/// A scene with bodies, Z up.
#[derive(Default)]
pub(crate) struct Stage {
    pub(crate) scene: Scene,
    pub(crate) meshes: Vec<(NodeId, Arc<PhysicsMesh>)>,
}

impl Stage {
    /// A node without a body.
    pub(crate) fn node(&mut self, name: &str, parent: Option<NodeId>, local: Affine3A) -> NodeId {
        self.scene.nodes.push(Node { name: name.into(), parent, local, mesh: None, visible: true });
        NodeId(self.scene.nodes.len() as u32 - 1)
    }

    pub(crate) fn place(&mut self, mesh: &Arc<PhysicsMesh>, parent: Option<NodeId>, local: Affine3A) -> NodeId {
        let node = self.node(&mesh.name, parent, local);
        self.meshes.push((node, Arc::clone(mesh)));
        node
    }

    pub(crate) fn add(&mut self, mesh: PhysicsMesh, at: Vec3) -> NodeId {
        self.place(&Arc::new(mesh), None, Affine3A::from_translation(at))
    }

    /// A floor whose top is at z = 0: two triangles, 200 m wide.
    pub(crate) fn floor(&mut self, material: Material) -> NodeId {
        let vertices = [(-1, -1), (1, -1), (1, 1), (-1, 1)];
        let vertices = vertices.map(|(x, y)| Vec3::new(100.0 * x as f32, 100.0 * y as f32, 0.0)).to_vec();
        let shape = Shape::Triangles { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] };
        self.add(PhysicsMesh { name: "floor".into(), mode: Static, material, mass: None, shape }, Vec3::ZERO)
    }

    pub(crate) fn started(&self, settings: Settings) -> Simulator {
        let mut simulator = self.registered(settings);
        assert_eq!(simulator.prepare(&self.scene), []);
        simulator.start().expect("prepared");
        simulator
    }

    pub(crate) fn registered(&self, settings: Settings) -> Simulator {
        let mut simulator = Simulator::new(settings, Registration::Automatic).expect("settings");
        for (node, mesh) in &self.meshes {
            simulator.object_created(*node, mesh);
        }
        simulator
    }
}

pub(crate) fn body(name: &str, mode: BodyMode, primitive: Primitive, material: Material) -> PhysicsMesh {
    let shape = Shape::Compound { primitives: vec![primitive], pieces: vec![] };
    let mass = (mode == Dynamic).then_some(1.0);
    PhysicsMesh { name: name.into(), mode, material, mass, shape }
}

pub(crate) fn boxed(half: Vec3) -> Primitive {
    Primitive::Box { center: [0.0; 3], orientation: [0.0; 4], half: half.to_array() }
}

pub(crate) fn ball(radius: f32) -> Primitive {
    Primitive::Sphere { center: [0.0; 3], radius }
}

/// A cube of a metre.
pub(crate) fn cube(mode: BodyMode) -> PhysicsMesh {
    body("cube", mode, boxed(Vec3::splat(0.5)), Material::default())
}

pub(crate) fn rough(friction: f32) -> Material {
    Material { static_friction: friction, dynamic_friction: friction, restitution: 0.0 }
}

pub(crate) fn bouncy(restitution: f32) -> Material {
    Material { static_friction: 0.0, dynamic_friction: 0.0, restitution }
}

pub(crate) fn run(simulator: &mut Simulator, seconds: f64) {
    let steps = (seconds / f64::from(simulator.settings().time_step)).round() as u64;
    for _ in 0..steps {
        simulator.step().expect("a good step");
    }
}

pub(crate) fn position(simulator: &Simulator, node: NodeId) -> Vec3 {
    simulator.state(node).expect("simulated").pose.position
}

pub(crate) fn turned(axis: Vec3, angle: f32) -> Affine3A {
    Affine3A::from_quat(Quat::from_axis_angle(axis, angle))
}

pub(crate) fn every(time_step: f32) -> Settings {
    Settings { time_step, ..Settings::default() }
}
