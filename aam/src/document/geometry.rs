//! Frames, objects and triangles.

use super::{Flagged, Rgb, Track, Unknown};
use crate::Text;

/// `GEOMETRY`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometry {
    /// `SmGEnabled` stands after `GEOMETRY`: the fourth number of a triangle means smoothing groups.
    pub smoothing_groups: bool,
    /// `Animation_mode:`.
    pub animation: AnimationMode,
    /// `FPS:`, frames a second; absent means 30 (an extension of this project).
    pub frames_per_second: Option<f32>,
    /// `NFrames:` of a `Keyframe` animation, whose single frame block says nothing about its length. In the other
    /// modes the number of [`Geometry::frames`] is written, whatever stands here; the reader sets it to that number.
    pub animation_frames: u32,
    /// The frames. All but the first of a `Full` animation hold objects without [`Object::faces`].
    pub frames: Vec<Frame>,
    /// Unknown tags.
    pub unknown: Vec<Unknown>,
}

/// `Animation_mode:`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AnimationMode {
    /// No animation, one frame.
    #[default]
    None,
    /// Every frame repeats the vertices of every object.
    Full,
    /// One frame; objects move by keys.
    Keyframe,
}

impl AnimationMode {
    /// The word in the file.
    pub const fn word(self) -> &'static str {
        match self {
            Self::None => "None",
            Self::Full => "Full",
            Self::Keyframe => "Keyframe",
        }
    }
}

/// `Frame: i { … }`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// The number after `Frame:`.
    pub number: i32,
    /// The objects.
    pub objects: Vec<Object>,
    /// Unknown tags.
    pub unknown: Vec<Unknown>,
}

/// `Obj: id name  Par: parent { … }`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Object {
    /// The number after `Obj:`, which `Par:` and `Body:` refer to.
    pub id: i32,
    /// The name.
    pub name: Text,
    /// `Par:`, the id of the parent, or -1.
    pub parent: i32,
    /// `Piv: Mir: TM:` (characters and avatars).
    pub node: Option<NodeTransform>,
    /// `MatID:`, a position in [`super::Document::materials`], or -1.
    pub material: i32,
    /// `UserProp:`.
    pub user_properties: Option<Text>,
    /// `TF: BI: SC:` (an extension of this project).
    pub displacement: Option<Displacement>,
    /// `V_List:`, positions in the object's coordinates.
    pub vertices: Vec<[f32; 3]>,
    /// `SKIN:`.
    pub skin: Flagged<Skin>,
    /// `C_List:`, vertex colours.
    pub colors: Option<Vec<Rgb>>,
    /// `TV_List:`, `N_List:` and `I_List:`; absent in later frames of a `Full` animation.
    pub faces: Option<Faces>,
    /// `N_List:` of a later `Full` frame, which has no faces (an extension of this project).
    pub frame_normals: Option<Vec<[f32; 3]>>,
    /// `Anim_Ctrl:`.
    pub keys: Flagged<Vec<Track>>,
    /// Unknown tags.
    pub unknown: Vec<Unknown>,
}

/// A character object's place relative to its parent.
///
/// A point goes from object to parent as `p_parent = (p ⊙ scale)·R + position`, with row vectors and the rows of `R`
/// as written. `Piv:` moves nothing. [`crate::meaning::local_transform`] says the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeTransform {
    /// `Piv:`, position.
    pub pivot_position: [f32; 3],
    /// `Piv:`, orientation, a quaternion x y z w. All zero means identity.
    pub pivot_orientation: [f32; 4],
    /// `Mir:`.
    pub mirrored: bool,
    /// `TM:`, the three rows of the rotation.
    pub rotation: [[f32; 3]; 3],
    /// `TM:`, position.
    pub position: [f32; 3],
    /// `TM:`, scale.
    pub scale: [f32; 3],
}

impl Default for NodeTransform {
    fn default() -> Self {
        Self {
            pivot_position: [0.0; 3],
            pivot_orientation: [0.0; 4],
            mirrored: false,
            rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            position: [0.0; 3],
            scale: [1.0; 3],
        }
    }
}

/// Displacement mapping of an object: `P' = P + n·(bias + scale·h)`, `h` in `[0, 1]`, in object units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement {
    /// `TF:`, parts that each edge is cut into; at least 1.
    pub tessellation: u32,
    /// `BI:`.
    pub bias: f32,
    /// `SC:`.
    pub scale: f32,
}

/// Bone weights, vertex by vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// One entry for each row: the vertex and how many weights it has.
    pub rows: Vec<(u32, u32)>,
    /// Bone (object id) and weight, row after row.
    pub weights: Vec<(i32, f32)>,
}

/// Texture vertices, explicit normals and triangles of an object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faces {
    /// `TV_List:`, one pool of texture coordinates for all layers; v is 0 at the bottom.
    pub tex_coords: Vec<[f32; 2]>,
    /// `N_List:` (an extension of this project).
    pub normals: Option<Vec<[f32; 3]>>,
    /// `I:`, group after group.
    pub triangles: Vec<Triangle>,
    /// `NI:`, one for each triangle where [`Faces::normals`] is given, else empty.
    pub normal_indices: Vec<[u32; 3]>,
    /// `TI:`, triangle after triangle; [`Faces::tex_counts`] says how many each triangle has.
    pub tex_indices: Vec<[u32; 3]>,
    /// How many `TI:` lines a triangle has.
    pub tex_counts: TexCounts,
    /// `NEWGROUP:`; together they cover `triangles` in order. Empty means `I_List: 0` without a group count.
    pub groups: Vec<Group>,
}

impl Faces {
    /// The texture indices of every triangle, in order: up to four triples each.
    pub fn tex_indices_of_triangles(&self) -> impl Iterator<Item = &[[u32; 3]]> {
        let mut start = 0;
        (0..self.triangles.len()).map(move |triangle| {
            let count = self.tex_counts.of(triangle);
            let slice = self.tex_indices.get(start..start + count).unwrap_or(&[]);
            start += count;
            slice
        })
    }
}

/// One triangle: three positions in the object's vertex list and its smoothing number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// Indices of the vertices, counter-clockwise seen from outside.
    pub vertices: [u32; 3],
    /// The smoothing mask (3ds Max) or number (Blender), printed signed.
    pub smoothing: i32,
}

/// How many `TI:` lines follow each triangle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TexCounts {
    /// Every triangle has this many (0 to 4).
    Uniform(u8),
    /// One count for each triangle.
    Each(Vec<u8>),
}

impl TexCounts {
    /// The count of a triangle.
    pub fn of(&self, triangle: usize) -> usize {
        match self {
            Self::Uniform(count) => usize::from(*count),
            Self::Each(counts) => counts.get(triangle).copied().map_or(0, usize::from),
        }
    }
}

impl Default for TexCounts {
    fn default() -> Self {
        Self::Uniform(0)
    }
}

/// A run of triangles: `NEWGROUP: id … ENDGROUP`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Group {
    /// The sub-material when the object's material is Multi, else meaningless.
    pub id: i32,
    /// How many triangles.
    pub triangles: usize,
}
