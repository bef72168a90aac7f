//! How large a document may grow, and how much work it may be. A glTF file repeats a mesh at the cost of a few bytes, an
//! AAM file cannot, and a clip of a million seconds is one number; so the product is checked before any of it is made. What
//! a document may hold grows with the bytes of the file, from a floor that costs about 100 MB up to a ceiling: a few bytes
//! do not ask for much memory or time, and a real file is not near.

use aam::{Limit, Limits};

use super::fault::{Checked, Fault};

/// Elements of an accessor that no bytes stand behind, in a small file.
pub(super) const ZERO_FILLED: usize = 1 << 16;

/// How many of something a document may hold.
struct Allowance {
    floor: u64,
    for_each_byte: u64,
    ceiling: u64,
}

impl Allowance {
    fn of(&self, bytes: u64) -> u64 {
        self.floor.saturating_add(self.for_each_byte.saturating_mul(bytes)).min(self.ceiling)
    }
}

/// Vertices of a document, over all frames (12 bytes each). The ceilings of this and the next two are the user's.
const VERTICES: Allowance = Allowance { floor: 1 << 22, for_each_byte: 64, ceiling: u64::MAX };

/// Triangles of a document.
const TRIANGLES: Allowance = Allowance { floor: 1 << 21, for_each_byte: 64, ceiling: u64::MAX };

/// Vertices times morph targets times frames: about a minute of work.
const MORPHS: Allowance = Allowance { floor: 1 << 24, for_each_byte: 1 << 12, ceiling: 1 << 34 };

/// Vertices read from the file, each morph target counted.
const DECODED: Allowance = Allowance { floor: 1 << 22, for_each_byte: 64, ceiling: 1 << 27 };

/// Objects of a document, over all frames.
const OBJECTS: Allowance = Allowance { floor: 1 << 17, for_each_byte: 4, ceiling: u64::MAX };

/// Nodes, joints and animation channels, over all frames: about a minute of work.
const POSES: Allowance = Allowance { floor: 1 << 21, for_each_byte: 64, ceiling: 1 << 28 };

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
    /// Refuses a document that would be too large, or larger than a file of so many bytes accounts for, before it is made.
    pub(super) fn check(&self, limits: &Limits, bytes: u64) -> Checked<()> {
        let reduce = "export fewer instances or a shorter clip, or lower --fps";
        let within =
            |limit, count| limits.check(limit, count).map_err(|exceeded| Fault::Limit { exceeded, way_out: reduce });
        within(Limit::Objects, self.objects)?;
        within(Limit::Vertices, self.vertices)?;
        within(Limit::Triangles, self.triangles)?;
        let check = |count: u64, limit: Allowance, what: &str| {
            let limit = limit.of(bytes);
            if count <= limit {
                return Ok(());
            }
            let feature = format!("a document of {count} {what} (more than {limit}, from a file of {bytes} bytes)");
            Err(Fault::unsupported(feature, reduce))
        };
        check(self.objects, OBJECTS, "objects over all frames")?;
        check(self.vertices, VERTICES, "vertices over all frames")?;
        check(self.triangles, TRIANGLES, "triangles")?;
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
