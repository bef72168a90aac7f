//! A document in numbers.

use serde::Serialize;

use crate::Document;
use crate::meaning::Bounds;

/// A document in numbers, for `aam info`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// `ascii` or `binary`.
    pub encoding: &'static str,
    /// The header word, if there is one.
    pub header: Option<&'static str>,
    /// `None`, `Full` or `Keyframe`.
    pub animation: &'static str,
    /// How many frames are in the file.
    pub frames: usize,
    /// Frames a second.
    pub frames_per_second: f32,
    /// From the first to the last frame, in seconds; 0 if nothing moves.
    pub duration: f32,
    /// Vertices of all objects in frame 0.
    pub vertices: usize,
    /// Triangles of all objects.
    pub triangles: usize,
    /// The box around everything in frame 0, in world coordinates.
    pub bounds: Option<Bounds>,
    /// The objects of frame 0, in file order.
    pub objects: Vec<ObjectSummary>,
    /// The single materials, Multi ones flattened.
    pub materials: Vec<MaterialSummary>,
    /// The texture files that materials name, each once, in order of first use.
    pub textures: Vec<TextureSummary>,
    /// How many physics bodies: static, kinematic, dynamic.
    pub bodies: [usize; 3],
    /// How many convex pieces and primitives all bodies have.
    pub collision_shapes: usize,
}

/// An object in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectSummary {
    /// The id.
    pub id: i32,
    /// The name.
    pub name: String,
    /// The position of its parent in [`Summary::objects`].
    pub parent: Option<usize>,
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// The box in the object's own coordinates.
    pub bounds: Option<Bounds>,
    /// How many keys.
    pub keys: usize,
    /// Whether it has explicit normals.
    pub explicit_normals: bool,
    /// Whether it has vertex colours.
    pub vertex_colors: bool,
    /// Whether it has displacement parameters.
    pub displacement: bool,
}

/// A material in words.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MaterialSummary {
    /// The name.
    pub name: String,
    /// Triangles that use it.
    pub triangles: usize,
    /// The Phong exponent.
    pub exponent: f32,
    /// 1 − transparency.
    pub opacity: f32,
    /// The texture file of each layer.
    pub layers: [Option<String>; 4],
}

/// A texture file that materials name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TextureSummary {
    /// The file as the document names it.
    pub file: String,
    /// How many material layers use it.
    pub uses: usize,
}

impl Summary {
    /// Counts a document.
    pub fn of(document: &Document) -> Self {
        let _ = document;
        Self::default()
    }
}
