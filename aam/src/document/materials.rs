//! Materials and their texture layers.

use super::{Flagged, Rgb, Unknown};
use crate::Text;

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
