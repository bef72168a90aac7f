//! Bodies and their collision shapes.

use super::Unknown;
use crate::Text;

/// `PHYSICS` (an extension of this project).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Physics {
    /// `Body:` blocks.
    pub bodies: Vec<Body>,
    /// Unknown tags.
    pub unknown: Vec<Unknown>,
}

/// `Body: objId objName { … }`.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The object's id, which decides.
    pub object: i32,
    /// The object's name, for people.
    pub name: Text,
    /// `Mode:`.
    pub mode: BodyMode,
    /// `SF:`, static friction, at least 0.
    pub static_friction: f32,
    /// `DF:`, dynamic friction, at least 0.
    pub dynamic_friction: f32,
    /// `Re:`, restitution in `[0, 1]`.
    pub restitution: f32,
    /// `Ma:`, mass in kilograms; dynamic bodies only.
    pub mass: Option<f32>,
    /// `NPrim:` and its lines; `None` when the tag is absent.
    pub primitives: Option<Vec<Primitive>>,
    /// `NConvex:` and its pieces; `None` when the tag is absent (static bodies).
    pub pieces: Option<Vec<Convex>>,
    /// Unknown tags.
    pub unknown: Vec<Unknown>,
}

/// `Mode:` of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyMode {
    /// Never moves; its shape is the object's own triangles.
    Static,
    /// Moved by the program, pushes dynamic bodies.
    Kinematic,
    /// Moved by forces.
    Dynamic,
}

impl BodyMode {
    /// The word in the file.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Static => "Static",
            Self::Kinematic => "Kinematic",
            Self::Dynamic => "Dynamic",
        }
    }
}

/// A simple collision shape in the object's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Primitive {
    /// `Box: c3 q4 half3`.
    Box {
        /// Centre.
        center: [f32; 3],
        /// Orientation, x y z w.
        orientation: [f32; 4],
        /// Half extents.
        half: [f32; 3],
    },
    /// `Sphere: c3 r`.
    Sphere {
        /// Centre.
        center: [f32; 3],
        /// Radius.
        radius: f32,
    },
    /// `Capsule: a3 b3 r`.
    Capsule {
        /// One end of the segment.
        a: [f32; 3],
        /// The other end.
        b: [f32; 3],
        /// Radius.
        radius: f32,
    },
}

/// `Convex: i { … }`: a closed convex triangle mesh in the object's coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Convex {
    /// The number after `Convex:`.
    pub number: i32,
    /// `V_List:`.
    pub vertices: Vec<[f32; 3]>,
    /// `I:`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}
