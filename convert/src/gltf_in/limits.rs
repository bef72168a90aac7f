//! How large a document may grow, and how much work it may be. A glTF file repeats a mesh at the cost of a few bytes, an AAM file cannot, and a
//! clip of a million seconds is one number; so the product is checked before any of it is made.

use aam::{Limit, Limits};

use super::fault::{Checked, Fault};

/// Elements of an accessor that no bytes stand behind, in a small file.
pub(super) const ZERO_FILLED: usize = 1 << 16;

/// Vertices times morph targets times frames: about a minute of work.
const MORPHS: u64 = 1 << 34;

/// Vertices read from the file, each morph target counted.
const DECODED: u64 = 1 << 27;

/// Nodes, joints and animation channels, over all frames: about a minute of work.
const POSES: u64 = 1 << 28;

/// Times and values that the channels of a clip name together.
const KEYS: u64 = 1 << 30;

/// Pixels of all pictures that are decoded, those that did not stay in memory counted again.
const DECODED_PIXELS: u64 = 1 << 35;

/// Pixels of all textures that are baked.
const BAKED: u64 = 1 << 32;

/// What a document would hold.
#[derive(Debug, Default)]
pub(super) struct Size {
    pub vertices: u64,
    pub triangles: u64,
    pub morphs: u64,
    pub poses: u64,
    pub decoded: u64,
    pub objects: u64,
}

impl Size {
    /// Refuses a document that would be too large, before it is made.
    pub(super) fn check(&self, limits: &Limits) -> Checked<()> {
        let reduce = "export fewer instances or a shorter clip, or lower --fps";
        let within =
            |limit, count| limits.check(limit, count).map_err(|exceeded| Fault::Limit { exceeded, way_out: reduce });
        within(Limit::Objects, self.objects)?;
        within(Limit::Vertices, self.vertices)?;
        within(Limit::Triangles, self.triangles)?;
        let check = |count: u64, limit: u64, what: &str| {
            if count <= limit {
                return Ok(());
            }
            Err(Fault::unsupported(format!("a document of {count} {what} (more than {limit})"), reduce))
        };
        check(self.morphs, MORPHS, "morphed vertices over all frames and targets")?;
        check(self.decoded, DECODED, "vertices with all morph targets")?;
        check(self.poses, POSES, "moving nodes, joints and channels over all frames")
    }
}

/// Refuses an animation whose channels together look through too many keys.
pub(super) fn check_keys(keys: u64) -> Checked<()> {
    if keys <= KEYS {
        return Ok(());
    }
    Err(Fault::unsupported(format!("an animation of {keys} keys (more than {KEYS})"), "cut or resample the animation"))
}

/// Refuses more decoding than fits a patient wait.
pub(super) fn check_decoded(pixels: u64) -> Checked<()> {
    if pixels <= DECODED_PIXELS {
        return Ok(());
    }
    Err(Fault::unsupported(
        format!("decoding pictures of {pixels} pixels together (more than {DECODED_PIXELS})"),
        "scale the textures down",
    ))
}

/// Refuses more baking than fits a patient wait.
pub(super) fn check_baked(pixels: u64) -> Checked<()> {
    if pixels <= BAKED {
        return Ok(());
    }
    Err(Fault::unsupported(
        format!("baking textures of {pixels} pixels together (more than {BAKED})"),
        "scale the textures down, or bake occlusion and alpha in the program that made them",
    ))
}
