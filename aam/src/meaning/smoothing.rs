//! Which faces are smooth with each other.

use crate::Document;
use crate::document::{Material, MaterialBody};

/// How the fourth number of an `I:` row is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SmoothingRule {
    /// No two faces are smooth with each other.
    Flat,
    /// The numbers are 3ds Max's 32-bit masks: two faces are smooth if their masks share a bit. This is pairwise: of
    /// three faces, the middle one can be smooth with both others while these are not with each other.
    Masks,
    /// The numbers are plain (Blender's exporter): two faces are smooth if their numbers are equal.
    Numbers,
}

impl SmoothingRule {
    /// The rule of a document.
    ///
    /// Numbers are plain where any material's `Class:` is `Blender Material`, else they are masks. `GEOMETRY` without
    /// `SmGEnabled` says that the numbers mean nothing; such a document is [`SmoothingRule::Flat`]: with the numbers
    /// gone, nothing in the file asks for smoothing, a flat face is right on every flat-sided model and only coarse on
    /// a round one, while smoothing everything would bend light over each hard edge.
    pub fn of(document: &Document) -> Self {
        if !document.geometry.smoothing_groups {
            return Self::Flat;
        }
        let mut pending: Vec<&Material> = document.materials.iter().collect();
        while let Some(material) = pending.pop() {
            match &material.body {
                MaterialBody::Single(single) if single.class == "Blender Material" => return Self::Numbers,
                MaterialBody::Single(_) => {}
                MaterialBody::Multi(subs) => pending.extend(subs),
            }
        }
        Self::Masks
    }

    /// Whether two different faces with these numbers are smooth with each other. 0 never is.
    pub const fn smooth(self, a: i32, b: i32) -> bool {
        match self {
            Self::Flat => false,
            Self::Masks => a & b != 0,
            Self::Numbers => a == b && a != 0,
        }
    }
}
