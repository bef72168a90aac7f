//! What an AAM file holds, as plain data.
//!
//! A [`Document`] mirrors the file: one field for one tag, values as written, optional tags as options, so that writing
//! it gives the file back. What the values *mean* (resolved materials, normals, poses) is in [`crate::meaning`].

use crate::Text;

/// An RGB triple as written in the file, sRGB-encoded, nominally in `[0, 1]`.
pub type Rgb = [f32; 3];

/// A whole AAM file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Document {
    /// Whether bulk data is text or little-endian binary.
    pub encoding: Encoding,
    /// The header word, if the file has one.
    pub header: Option<Header>,
    /// Text before `MATERIALS` that this version does not know (a `SHADERS` section, for instance).
    pub preamble: Vec<Unknown>,
    /// `MATERIALS`, in file order. The position here is what `MatID` refers to.
    pub materials: Vec<Material>,
    /// Unknown text between the last material and `ENDMATERIALS`.
    pub materials_unknown: Vec<Unknown>,
    /// `GEOMETRY`.
    pub geometry: Geometry,
    /// `PHYSICS`, if present (an extension of this project).
    pub physics: Option<Physics>,
}

impl Document {
    /// The objects of frame 0, which carry the mesh data; empty when there is no frame.
    pub fn objects(&self) -> &[Object] {
        self.geometry.frames.first().map_or(&[], |frame| &frame.objects)
    }
}

/// How bulk data is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// Everything is text.
    #[default]
    Ascii,
    /// The first line is `BINARY`; lists are little-endian 32-bit values.
    Binary,
}

/// The optional header word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Header {
    /// `AAM_MESH`: one static frame.
    Mesh,
    /// `AAM_MESH_MULTIFRAME`: vertices change from frame to frame.
    MeshMultiframe,
    /// `AAM_CHARACTER`: objects have local transforms and keys.
    Character,
    /// `AAM_AVATAR`: as a character, for the avatar system.
    Avatar,
}

impl Header {
    /// The word in the file.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Mesh => "AAM_MESH",
            Self::MeshMultiframe => "AAM_MESH_MULTIFRAME",
            Self::Character => "AAM_CHARACTER",
            Self::Avatar => "AAM_AVATAR",
        }
    }
}

/// Text that the reader does not know, kept in its place: the line, and the `{ }` block and number rows right after it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// The tag of the same block that it stands before, and which occurrence of that tag counted from 0; `None` at the
    /// block's end.
    pub before: Option<(&'static str, u32)>,
    /// The lines, without indentation, without line ends.
    pub lines: Vec<Text>,
}

/// A flag-guarded part: `Tag: N`, or `Tag: Y` and a body, or the tag is not there at all.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Flagged<T> {
    /// The tag is not in the file.
    #[default]
    Omitted,
    /// `N`.
    No,
    /// `Y`, and what follows.
    Yes(T),
}

impl<T> Flagged<T> {
    /// The body of a `Y`.
    pub fn as_ref(&self) -> Option<&T> {
        match self {
            Self::Yes(value) => Some(value),
            _ => None,
        }
    }
}

// ---- materials --------------------------------------------------------------------------------------------------

/// `Mat# n { … }` or `Sub n { … }`.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The number after `Mat#` or `Sub`.
    pub number: i32,
    /// `Name:`.
    pub name: Text,
    /// The rest of the block.
    pub body: MaterialBody,
    /// Unknown tags.
    pub unknown: Vec<Unknown>,
}

/// The two forms of a material.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialBody {
    /// An ordinary material.
    Single(Box<SingleMaterial>),
    /// `Class: Multi`: a list of materials, chosen by a group's id. It may nest.
    Multi(Vec<Material>),
}

/// An ordinary material, all values as written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SingleMaterial {
    /// `Class:`, free text (`Standard`, `Blender Material`, `Shell Material` …).
    pub class: Text,
    /// `Am:`, ambient reflectance.
    pub ambient: Rgb,
    /// `Di:`, diffuse reflectance.
    pub diffuse: Rgb,
    /// `Sp:`, specular reflectance.
    pub specular: Rgb,
    /// `Tr:`, 0 opaque … 1 transparent.
    pub transparency: f32,
    /// `Sh:`, shininess: in `[0, 1]` a fraction of 128, above 1 the exponent itself.
    pub shininess: f32,
    /// `SI:`, emission, any non-negative colour.
    pub emission: Option<Rgb>,
    /// `WS:` and the second `Sh:`, written by newer exporters.
    pub shading: Option<Shading>,
    /// The four texture layers, in the order of [`Layer::ALL`].
    pub layers: [Flagged<Box<Texture>>; 4],
    /// `AC:`, alpha cutoff: fragments with alpha below it are discarded (an extension of this project).
    pub alpha_cutoff: Option<f32>,
}

/// `WS:` wire size and `Sh:` shading word.
#[derive(Clone, Debug, PartialEq)]
pub struct Shading {
    /// `WS:`, the wire size of 3ds Max.
    pub wire_size: f32,
    /// The second `Sh:`: `BLINN`, `PHONG`, `METAL` or `NONE` in known files.
    pub word: Text,
}

/// The texture layers of a material, in the order in which a triangle's `TI:` lines follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Layer {
    /// `Tx:`, the diffuse texture.
    Diffuse = 0,
    /// `TS:`, the light map.
    LightMap = 1,
    /// `TN:`, the normal map (an extension of this project).
    Normal = 2,
    /// `TD:`, the displacement map (an extension of this project).
    Displacement = 3,
}

impl Layer {
    /// All layers in file order.
    pub const ALL: [Self; 4] = [Self::Diffuse, Self::LightMap, Self::Normal, Self::Displacement];

    /// The tag with its colon.
    pub const fn tag(self) -> &'static str {
        match self {
            Self::Diffuse => "Tx:",
            Self::LightMap => "TS:",
            Self::Normal => "TN:",
            Self::Displacement => "TD:",
        }
    }

    /// The name for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Diffuse => "diffuse",
            Self::LightMap => "light map",
            Self::Normal => "normal map",
            Self::Displacement => "displacement map",
        }
    }
}

/// A texture block.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// `FN:`, the file, relative to the document's folder.
    pub file: Text,
    /// `Fi:`, the filter word; `PYRAMIDAL` in every known file, ignored.
    pub filter: Text,
    /// `Ch:`, the slot of 3ds Max.
    pub channel: Option<i32>,
    /// `In:`, intensity. Scales xy of a tangent-space normal map; kept and not applied elsewhere.
    pub intensity: f32,
    /// `UA: VA: WA:`, rotation in radians; only the third turns a 2D texture.
    pub rotation: [f32; 3],
    /// `UO: VO:`, offset.
    pub offset: [f32; 2],
    /// `UT: VT:`, tiling.
    pub tiling: [f32; 2],
    /// `NS:`, the space of a normal map; absent means object space.
    pub normal_space: Option<NormalSpace>,
    /// Unknown tags.
    pub unknown: Vec<Unknown>,
}

impl Texture {
    /// A texture with an identity coordinate transform.
    pub fn new(file: impl Into<Text>) -> Self {
        Self {
            file: file.into(),
            filter: "PYRAMIDAL".into(),
            channel: None,
            intensity: 1.0,
            rotation: [0.0; 3],
            offset: [0.0; 2],
            tiling: [1.0; 2],
            normal_space: None,
            unknown: Vec::new(),
        }
    }
}

/// The frame in which a normal map's vectors are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NormalSpace {
    /// `OBJECT`: the object's own axes.
    Object,
    /// `TANGENT`: the MikkTSpace tangent frame of the surface.
    Tangent,
}

// ---- geometry ---------------------------------------------------------------------------------------------------

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
    /// `MatID:`, a position in [`Document::materials`], or -1.
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

// ---- animation --------------------------------------------------------------------------------------------------

/// The keys of one kind, from `Anim_Ctrl: Y`. Frames are numbers of frames; values are absolute and local to the parent.
#[derive(Clone, Debug, PartialEq)]
pub enum Track {
    /// `PsSam`: position.
    PositionSampled(Vec<PositionSample>),
    /// `RtSam`: axis and angle in radians.
    RotationSampled(Vec<RotationSample>),
    /// `ScSam`: scale axes as a quaternion, and scale.
    ScaleSampled(Vec<ScaleSample>),
    /// `PsBez`: position with tangents.
    PositionBezier(Vec<PositionBezier>),
    /// `RtBez`: Euler angles X, Y, Z in radians, with tangents.
    RotationBezier(Vec<RotationBezier>),
    /// `ScBez`: scale with tangents.
    ScaleBezier(Vec<ScaleBezier>),
    /// `RtTcb`: axis and angle with tension, continuity, bias and ease.
    RotationTcb(Vec<RotationTcb>),
    /// `RtIPA`: Euler angles X, Y, Z in radians.
    RotationEuler(Vec<RotationEuler>),
}

impl Track {
    /// How many rows it has.
    pub const fn key_count(&self) -> usize {
        match self {
            Self::PositionSampled(rows) => rows.len(),
            Self::RotationSampled(rows) => rows.len(),
            Self::ScaleSampled(rows) => rows.len(),
            Self::PositionBezier(rows) => rows.len(),
            Self::RotationBezier(rows) => rows.len(),
            Self::ScaleBezier(rows) => rows.len(),
            Self::RotationTcb(rows) => rows.len(),
            Self::RotationEuler(rows) => rows.len(),
        }
    }
}

/// A `PsSam` row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionSample {
    /// Frame.
    pub frame: f32,
    /// Position.
    pub position: [f32; 3],
}

/// A `RtSam` row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationSample {
    /// Frame.
    pub frame: f32,
    /// Axis.
    pub axis: [f32; 3],
    /// Angle in radians.
    pub angle: f32,
}

/// A `ScSam` row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleSample {
    /// Frame.
    pub frame: f32,
    /// Orientation of the scale axes, x y z w.
    pub axes: [f32; 4],
    /// Scale.
    pub scale: [f32; 3],
}

/// A `PsBez` row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionBezier {
    /// Frame.
    pub frame: f32,
    /// Position.
    pub position: [f32; 3],
    /// Tangent before the key.
    pub tangent_in: [f32; 3],
    /// Tangent after the key.
    pub tangent_out: [f32; 3],
    /// The flag of 3ds Max, ignored.
    pub flag: i32,
}

/// A `RtBez` row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationBezier {
    /// Frame.
    pub frame: f32,
    /// Euler angles in radians, applied X, Y, Z.
    pub euler: [f32; 3],
    /// Tangent before the key.
    pub tangent_in: [f32; 3],
    /// Tangent after the key.
    pub tangent_out: [f32; 3],
    /// The flag of 3ds Max, ignored.
    pub flag: i32,
}

/// A `ScBez` row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleBezier {
    /// Frame.
    pub frame: f32,
    /// Scale.
    pub scale: [f32; 3],
    /// Orientation of the scale axes, x y z w.
    pub axes: [f32; 4],
    /// Tangent before the key.
    pub tangent_in: [f32; 3],
    /// Tangent after the key.
    pub tangent_out: [f32; 3],
    /// The flag of 3ds Max, ignored.
    pub flag: i32,
}

/// A `RtTcb` row (Kochanek–Bartels).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationTcb {
    /// Frame.
    pub frame: f32,
    /// Axis.
    pub axis: [f32; 3],
    /// Angle in radians.
    pub angle: f32,
    /// Tension.
    pub tension: f32,
    /// Continuity.
    pub continuity: f32,
    /// Bias.
    pub bias: f32,
    /// Ease in.
    pub ease_in: f32,
    /// Ease out.
    pub ease_out: f32,
}

/// A `RtIPA` row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationEuler {
    /// Frame.
    pub frame: f32,
    /// Euler angles in radians, applied X, Y, Z.
    pub euler: [f32; 3],
}

// ---- physics ----------------------------------------------------------------------------------------------------

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
