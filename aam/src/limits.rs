//! How much is accepted of a file before it costs memory or time.

use std::fmt;

use crate::Document;
use crate::document::{Material, MaterialBody};

/// What can be limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Limit {
    /// [`Limits::file_size`]
    FileSize,
    /// [`Limits::objects`]
    Objects,
    /// [`Limits::vertices`]
    Vertices,
    /// [`Limits::triangles`]
    Triangles,
    /// [`Limits::frames`]
    Frames,
    /// [`Limits::texture_pixels`]
    TexturePixels,
    /// [`Limits::nesting`]
    Nesting,
}

impl Limit {
    /// Every limit.
    pub const ALL: [Self; 7] = [
        Self::FileSize,
        Self::Objects,
        Self::Vertices,
        Self::Triangles,
        Self::Frames,
        Self::TexturePixels,
        Self::Nesting,
    ];

    /// The option of the `aam` command that sets it.
    pub const fn option(self) -> &'static str {
        match self {
            Self::FileSize => "--max-file-size",
            Self::Objects => "--max-objects",
            Self::Vertices => "--max-vertices",
            Self::Triangles => "--max-triangles",
            Self::Frames => "--max-frames",
            Self::TexturePixels => "--max-texture-pixels",
            Self::Nesting => "--max-nesting",
        }
    }

    /// What is counted, in the plural.
    const fn counted(self) -> &'static str {
        match self {
            Self::FileSize => "bytes",
            Self::Objects => "objects over all frames",
            Self::Vertices => "vertices over all frames",
            Self::Triangles => "triangles",
            Self::Frames => "frames",
            Self::TexturePixels => "pixels",
            Self::Nesting => "levels of Multi materials",
        }
    }
}

/// How large a file and what it holds may be. Whatever is over a limit is refused before memory is taken for it.
///
/// The defaults are far above real assets and let a usual machine live.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of any one file. Default 4 GiB.
    pub file_size: u64,
    /// Objects of a document, counted again in each frame. Default 2²³ (8 388 608).
    pub objects: u64,
    /// Vertices of a document, counted again in each frame, those of convex pieces included. Default 2²⁸ (268 435 456).
    pub vertices: u64,
    /// Triangles of a document, those of convex pieces included. Default 2²⁶ (67 108 864).
    pub triangles: u64,
    /// Frames that a document spells out, and frames that a clip is sampled at. Default 2²⁰ (1 048 576).
    pub frames: u64,
    /// Pixels of any one texture. Default 2²⁸ (16384 × 16384).
    pub texture_pixels: u64,
    /// Multi materials within each other. Default 32, and never more than [`Limits::DEEPEST_NESTING`].
    pub nesting: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Limits {
    /// The default limits.
    pub const DEFAULT: Self = Self {
        file_size: 4 << 30,
        objects: 1 << 23,
        vertices: 1 << 28,
        triangles: 1 << 26,
        frames: 1 << 20,
        texture_pixels: 1 << 28,
        nesting: 32,
    };

    /// The deepest nesting that any limit allows, since nested materials are read by recursion.
    pub const DEEPEST_NESTING: u64 = 256;

    /// The value of one limit.
    pub fn of(&self, limit: Limit) -> u64 {
        match limit {
            Limit::FileSize => self.file_size,
            Limit::Objects => self.objects,
            Limit::Vertices => self.vertices,
            Limit::Triangles => self.triangles,
            Limit::Frames => self.frames,
            Limit::TexturePixels => self.texture_pixels,
            Limit::Nesting => self.nesting.min(Self::DEEPEST_NESTING),
        }
    }

    /// Refuses what is over a limit.
    ///
    /// # Errors
    /// [`LimitExceeded`] if `found` is more than the limit.
    pub fn check(&self, limit: Limit, found: u64) -> Result<(), LimitExceeded> {
        let allowed = self.of(limit);
        if found <= allowed { Ok(()) } else { Err(LimitExceeded { limit, found, allowed }) }
    }

    /// Refuses a document that is over a limit, for documents that were not read from AAM text: [`crate::read()`] checks
    /// on the way.
    ///
    /// # Errors
    /// [`LimitExceeded`] of the first limit that is broken.
    pub fn check_document(&self, document: &Document) -> Result<(), LimitExceeded> {
        let frames = &document.geometry.frames;
        let objects = || frames.iter().flat_map(|frame| &frame.objects);
        let pieces = || {
            let bodies = document.physics.iter().flat_map(|physics| &physics.bodies);
            bodies.flat_map(|body| body.pieces.iter().flatten())
        };
        let sum = |counts: &mut dyn Iterator<Item = usize>| counts.map(|count| count as u64).sum::<u64>();
        self.check(Limit::Frames, frames.len() as u64)?;
        self.check(Limit::Objects, sum(&mut frames.iter().map(|frame| frame.objects.len())))?;
        let vertices = sum(&mut objects().map(|object| object.vertices.len()))
            + sum(&mut pieces().map(|piece| piece.vertices.len()));
        self.check(Limit::Vertices, vertices)?;
        let faces = objects().filter_map(|object| object.faces.as_ref());
        let triangles =
            sum(&mut faces.map(|faces| faces.triangles.len())) + sum(&mut pieces().map(|piece| piece.triangles.len()));
        self.check(Limit::Triangles, triangles)?;
        self.check(Limit::Nesting, nesting(&document.materials))
    }
}

/// How many Multi materials stand within each other.
fn nesting(materials: &[Material]) -> u64 {
    let mut deepest = 0;
    let mut open: Vec<(&Material, u64)> = materials.iter().map(|material| (material, 0)).collect();
    while let Some((material, depth)) = open.pop() {
        deepest = deepest.max(depth);
        if let MaterialBody::Multi(subs) = &material.body {
            open.extend(subs.iter().map(|sub| (sub, depth + 1)));
        }
    }
    deepest
}

/// Something is over a limit. Its `Display` says what was found, the limit, and the option that raises it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimitExceeded {
    /// Which limit.
    pub limit: Limit,
    /// What was found; there may be more.
    pub found: u64,
    /// What is allowed.
    pub allowed: u64,
}

impl fmt::Display for LimitExceeded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { limit, found, allowed } = self;
        write!(f, "{found} {} are more than the limit of {allowed}; ", limit.counted())?;
        match limit {
            Limit::Nesting if *allowed >= Limits::DEEPEST_NESTING => {
                f.write_str("nothing raises it: flatten the material")
            }
            _ => write!(f, "raise it with {}", limit.option()),
        }
    }
}

impl std::error::Error for LimitExceeded {}
