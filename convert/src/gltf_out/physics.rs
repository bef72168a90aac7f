//! `PHYSICS` as the draft extensions `KHR_physics_rigid_bodies` and `KHR_implicit_shapes` (their texts of October 2025,
//! github.com/eoineoineoin/glTF_Physics).
//!
//! A body's motion stands at its object's node. Each shape has a node below it that bears the collider: a box, sphere or
//! capsule is an implicit shape, a convex piece is a mesh. Meshes that only collide belong to nodes outside of the scene,
//! which the draft allows, so that no viewer draws them.

use aam::document::{Body, BodyMode, Convex, Primitive};
use glam::{Quat, Vec3};
use serde_json::{Map, json};

use crate::ConvertError;

use super::axes;
use super::buffer::Buffers;
use super::extras::{unknown, wrap};
use super::json::{
    BoxShape, CapsuleShape, Collider, ColliderGeometry, Index, Mesh, Node, PhysicsMaterial, RigidBody, RigidMotion,
    Root, Shape, SphereShape,
};
use super::model::Model;
use super::notes::Notes;

/// Adds the bodies of the document to the nodes of its objects.
pub(super) fn bodies(
    model: &Model<'_>,
    root: &mut Root,
    buffers: &mut Buffers,
    notes: &mut Notes,
) -> Result<(), ConvertError> {
    let Some(physics) = &model.document.physics else { return Ok(()) };
    let mut writer = Writer { root, buffers, notes, materials: Vec::new(), shapes: Vec::new() };
    for body in &physics.bodies {
        let subject = format!("body {} \"{}\"", body.object, body.name);
        let place = model.document.objects().iter().position(|object| object.id == body.object);
        match place {
            Some(object) => writer.body(body, object as Index, &subject)?,
            None => writer.notes.lost(&subject, "body", "no object has this id"),
        }
    }
    let Writer { materials, shapes, .. } = writer;
    if !materials.is_empty() {
        root.extensions.physics = Some(super::json::PhysicsMaterials { physics_materials: materials });
    }
    if !shapes.is_empty() {
        root.extensions.shapes = Some(super::json::Shapes { shapes });
    }
    Ok(())
}

struct Writer<'a> {
    root: &'a mut Root,
    buffers: &'a mut Buffers,
    notes: &'a mut Notes,
    materials: Vec<PhysicsMaterial>,
    shapes: Vec<Shape>,
}

impl Writer<'_> {
    fn body(&mut self, body: &Body, object: Index, subject: &str) -> Result<(), ConvertError> {
        let not_below_0 = |value: f32| if value > 0.0 && value.is_finite() { value } else { 0.0 };
        let material = PhysicsMaterial {
            static_friction: not_below_0(body.static_friction),
            dynamic_friction: not_below_0(body.dynamic_friction),
            restitution: not_below_0(body.restitution).min(1.0),
        };
        let material = position_or_push(&mut self.materials, material);
        let mass = body.mass.filter(|mass| *mass > 0.0 && mass.is_finite());
        let motion = match body.mode {
            BodyMode::Static => None,
            BodyMode::Kinematic => Some(RigidMotion { is_kinematic: true, mass: None }),
            BodyMode::Dynamic => Some(RigidMotion { is_kinematic: false, mass }),
        };
        if let Some(motion) = motion {
            self.root.nodes[object as usize].extensions.physics =
                Some(RigidBody { motion: Some(motion), collider: None });
        } else if let Some(mesh) = self.root.nodes[object as usize].mesh {
            // A geometry takes its node's children with it, so the mesh gets a node without.
            let name = format!("{} collider", self.root.nodes[object as usize].name);
            let shape = self.push(Node { name: name.clone(), mesh: Some(mesh), ..Node::default() });
            self.collider(object, name, body, material, ColliderGeometry { node: Some(shape), ..Default::default() });
        }
        for (number, primitive) in body.primitives.iter().flatten().enumerate() {
            self.primitive(primitive, number, object, body, material, subject);
        }
        for piece in body.pieces.iter().flatten() {
            self.piece(piece, object, body, material, subject)?;
        }
        if unknown(&body.unknown).is_some() {
            self.notes.kept(subject, "unknown tags", "in extras");
        }
        Ok(())
    }

    fn push(&mut self, node: Node) -> Index {
        self.root.nodes.push(node);
        self.root.nodes.len() as Index - 1
    }

    /// Adds a node with a collider below an object's node.
    fn collider(
        &mut self,
        object: Index,
        name: String,
        body: &Body,
        material: Index,
        geometry: ColliderGeometry,
    ) -> Index {
        let mut members = Map::from_iter([("body".to_owned(), json!(body.object))]);
        if let Some(lines) = unknown(&body.unknown) {
            members.insert("unknown".into(), lines);
        }
        let mut node = Node { name, extras: wrap(members), ..Node::default() };
        let collider = Some(Collider { geometry, physics_material: material });
        node.extensions.physics = Some(RigidBody { motion: None, collider });
        let index = self.push(node);
        self.root.nodes[object as usize].children.push(index);
        index
    }

    fn primitive(
        &mut self,
        primitive: &Primitive,
        number: usize,
        object: Index,
        body: &Body,
        material: Index,
        subject: &str,
    ) {
        let Some((word, shape, center, turn)) = implicit(primitive) else {
            self.notes.lost(subject, "collision shape", format!("shape {number} has no extent"));
            return;
        };
        let shape = position_or_push(&mut self.shapes, shape);
        let name = format!("{} {word} {number}", self.root.nodes[object as usize].name);
        let geometry = ColliderGeometry { shape: Some(shape), ..Default::default() };
        let node = self.collider(object, name, body, material, geometry);
        let node = &mut self.root.nodes[node as usize];
        node.translation = (center != Vec3::ZERO).then(|| center.to_array());
        node.rotation = (turn != Quat::IDENTITY).then(|| turn.to_array());
    }

    fn piece(
        &mut self,
        piece: &Convex,
        object: Index,
        body: &Body,
        material: Index,
        subject: &str,
    ) -> Result<(), ConvertError> {
        let inside = |index: &u32| (*index as usize) < piece.vertices.len();
        if piece.triangles.is_empty() || !piece.triangles.as_flattened().iter().all(inside) {
            self.notes.lost(subject, "collision shape", format!("piece {} has no or broken triangles", piece.number));
            return Ok(());
        }
        if !piece.vertices.as_flattened().iter().all(|value| value.is_finite()) {
            return Err(ConvertError::Option(format!(
                "{subject}: piece {} has a coordinate that is not a finite number, which glTF cannot hold; mend it or make \
                 the pieces anew (--hulls)",
                piece.number
            )));
        }
        let name = format!("{} hull {}", self.root.nodes[object as usize].name, piece.number);
        let positions = self.buffers.positions(piece.vertices.iter().map(|&vertex| axes::vector(Vec3::from(vertex))));
        let indices = self.buffers.indices(piece.triangles.as_flattened(), piece.vertices.len());
        let primitive = super::json::Primitive {
            attributes: [("POSITION".to_owned(), positions)].into(),
            indices,
            material: None,
            targets: Vec::new(),
        };
        let mesh = Some(self.root.meshes.len() as Index);
        self.root.meshes.push(Mesh { name: name.clone(), primitives: vec![primitive] });
        let shape = self.push(Node { name: name.clone(), mesh, ..Node::default() });
        let geometry = ColliderGeometry { convex_hull: true, node: Some(shape), shape: None };
        self.collider(object, name, body, material, geometry);
        Ok(())
    }
}

fn position_or_push<T: PartialEq>(list: &mut Vec<T>, value: T) -> Index {
    let place = list.iter().position(|other| *other == value).unwrap_or_else(|| {
        list.push(value);
        list.len() - 1
    });
    place as Index
}

/// A primitive as an implicit shape with its place, in glTF's axes; `None` where it is degenerate, which the draft forbids.
fn implicit(primitive: &Primitive) -> Option<(&'static str, Shape, Vec3, Quat)> {
    let positive = |value: f32| value > 0.0 && value.is_finite();
    let point = |v: [f32; 3]| Some(axes::vector(Vec3::from(v))).filter(|v| v.is_finite());
    match *primitive {
        Primitive::Sphere { center, radius } => {
            let shape = Shape::Sphere { sphere: SphereShape { radius } };
            positive(radius).then_some(("sphere", shape, point(center)?, Quat::IDENTITY))
        }
        Primitive::Box { center, orientation, half } => {
            let size = axes::lengths(half).map(|half| 2.0 * half);
            let turn = Quat::from_array(axes::rotation(orientation));
            // As for `Piv`, all zero means identity.
            let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { Quat::IDENTITY };
            let shape = Shape::Box { r#box: BoxShape { size } };
            (size.into_iter().all(positive) && turn.is_finite()).then_some(("box", shape, point(center)?, turn))
        }
        Primitive::Capsule { a, b, radius } => {
            let (a, b) = (point(a)?, point(b)?);
            let middle = 0.5 * (a + b);
            let height = a.distance(b);
            if !positive(radius) || !height.is_finite() {
                return None;
            }
            let Some(direction) = (a - b).try_normalize() else {
                return Some(("sphere", Shape::Sphere { sphere: SphereShape { radius } }, middle, Quat::IDENTITY));
            };
            let capsule = CapsuleShape { height, radius_bottom: radius, radius_top: radius };
            let turn = Quat::from_rotation_arc(Vec3::Y, direction).normalize();
            Some(("capsule", Shape::Capsule { capsule }, middle, turn))
        }
    }
}
