//! What a document says about the bodies of its objects.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use aam::document::{Body, BodyMode, Object, Primitive};
use aam::{Document, Finding, Severity};
use glam::Vec3;

/// The body of one object: how it moves, what it is made of, and its collision shape in the object's coordinates.
///
/// It is read once, never changes, and is shared by all simulators and by all places where the object stands.
#[derive(Clone, Debug, PartialEq)]
pub struct PhysicsMesh {
    /// The object's name.
    pub name: String,
    /// How it moves.
    pub mode: BodyMode,
    /// What it is made of.
    pub material: Material,
    /// Mass in kilograms at scale 1, above 0 for dynamic bodies; others have none.
    pub mass: Option<f32>,
    /// The collision shape.
    pub shape: Shape,
}

/// How a surface touches others. Where two touch, each value is the mean of both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Friction while the surfaces stick, at least 0.
    pub static_friction: f32,
    /// Friction while they slide, at least 0.
    pub dynamic_friction: f32,
    /// Speed after a bounce over speed before, in `[0, 1]`.
    pub restitution: f32,
}

impl Default for Material {
    /// Friction 0.5, no bounce.
    fn default() -> Self {
        Self { static_friction: 0.5, dynamic_friction: 0.5, restitution: 0.0 }
    }
}

impl Material {
    pub(crate) fn is_valid(&self) -> bool {
        let friction = [self.static_friction, self.dynamic_friction];
        friction.iter().all(|value| *value >= 0.0 && value.is_finite()) && (0.0..=1.0).contains(&self.restitution)
    }
}

/// A collision shape in the object's coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// The drawn triangles: static bodies, which are touched from both sides. As a moving body they have to be a closed
    /// surface, counter-clockwise seen from outside: exact, but slow, and thin enough to pass through others.
    Triangles {
        /// Positions.
        vertices: Vec<Vec3>,
        /// Indices of the positions.
        triangles: Vec<[u32; 3]>,
    },
    /// One compound of simple solids and of the convex hulls of point sets: kinematic and dynamic bodies.
    Compound {
        /// Boxes, balls and capsules.
        primitives: Vec<Primitive>,
        /// The corners of each convex piece.
        pieces: Vec<Vec<Vec3>>,
    },
}

/// The bodies of a document's objects, by the object's position in frame 0, and why others are left out.
///
/// A body is left out when it names no object, is a second one of its object, or lacks what its mode needs. A document
/// without `PHYSICS` gives none.
pub fn physics_meshes(document: &Document) -> (BTreeMap<usize, Arc<PhysicsMesh>>, Vec<Finding>) {
    let mut meshes = BTreeMap::new();
    let mut findings = Vec::new();
    let mut places: HashMap<i32, usize> = HashMap::new();
    for (index, object) in document.objects().iter().enumerate() {
        places.entry(object.id).or_insert(index);
    }
    for body in document.physics.iter().flat_map(|physics| &physics.bodies) {
        let made = match places.get(&body.object) {
            None => Err("no object has this id"),
            Some(index) if meshes.contains_key(index) => Err("its object has a body already"),
            Some(index) => mesh(body, &document.objects()[*index]).map(|mesh| (*index, mesh)),
        };
        match made {
            Ok((index, mesh)) => {
                meshes.insert(index, Arc::new(mesh));
            }
            Err(reason) => {
                findings.push(left_out(format!("body {} \"{}\"", body.object, body.name.decoded()), reason));
            }
        }
    }
    (meshes, findings)
}

/// A warning that a body is not simulated.
pub(crate) fn left_out(subject: String, reason: &str) -> Finding {
    Finding {
        code: "physics/left-out",
        severity: Severity::Warning,
        position: None,
        subject,
        message: format!("it is not simulated: {reason}"),
    }
}

fn mesh(body: &Body, object: &Object) -> Result<PhysicsMesh, &'static str> {
    let material = Material {
        static_friction: body.static_friction,
        dynamic_friction: body.dynamic_friction,
        restitution: body.restitution,
    };
    if !material.is_valid() {
        return Err("friction or restitution is out of its range");
    }
    let mass = match (body.mode, body.mass) {
        (BodyMode::Dynamic, Some(mass)) if mass > 0.0 && mass.is_finite() => Some(mass),
        (BodyMode::Dynamic, _) => return Err("a dynamic body needs a mass above 0"),
        (BodyMode::Static | BodyMode::Kinematic, _) => None,
    };
    let shape = if body.mode == BodyMode::Static { drawn(object)? } else { compound(body)? };
    Ok(PhysicsMesh { name: object.name.decoded(), mode: body.mode, material, mass, shape })
}

fn drawn(object: &Object) -> Result<Shape, &'static str> {
    let vertices: Vec<Vec3> = object.vertices.iter().copied().map(Vec3::from).collect();
    let drawable = |index: &u32| vertices.get(*index as usize).is_some_and(|vertex| vertex.is_finite());
    let triangles: Vec<[u32; 3]> = object
        .faces
        .iter()
        .flat_map(|faces| &faces.triangles)
        .map(|triangle| triangle.vertices)
        .filter(|triangle| triangle.iter().all(drawable))
        .collect();
    if triangles.is_empty() {
        return Err("its object has no triangles");
    }
    // The engine looks at all of them.
    let vertices = vertices.into_iter().map(|vertex| if vertex.is_finite() { vertex } else { Vec3::ZERO }).collect();
    Ok(Shape::Triangles { vertices, triangles })
}

fn compound(body: &Body) -> Result<Shape, &'static str> {
    let primitives = body.primitives.clone().unwrap_or_default();
    let pieces: Vec<Vec<Vec3>> =
        body.pieces.iter().flatten().map(|piece| piece.vertices.iter().copied().map(Vec3::from).collect()).collect();
    if primitives.is_empty() && pieces.is_empty() {
        return Err("it has neither primitives nor convex pieces; `aam convert --physics` makes some");
    }
    if pieces.iter().flatten().any(|vertex| !vertex.is_finite()) {
        return Err("a convex piece has a coordinate that is no number");
    }
    Ok(Shape::Compound { primitives, pieces })
}
