//! What an AAM file holds, as plain data.
//!
//! A [`Document`] mirrors the file: one field for one tag, values as written, optional tags as options, so that writing
//! it gives the file back. What the values *mean* (resolved materials, normals, poses) is in [`crate::meaning`].

mod animation;
mod geometry;
mod materials;
mod physics;

pub use animation::*;
pub use geometry::*;
pub use materials::*;
pub use physics::*;

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
    /// The lines, each without blanks at its ends, with a line feed between two of them.
    pub text: Text,
}

impl Unknown {
    /// The lines.
    pub fn lines(&self) -> impl Iterator<Item = &[u8]> {
        self.text.bytes().split(|&byte| byte == b'\n')
    }
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
