//! glTF, OBJ, STL and PLY to and from AAM documents; convex decomposition.
//!
//! Every importer gives an [`Asset`]: a document, the texture files it names, the lights and cameras that only a
//! scene file can hold, and a [`Report`] of what was kept, changed and lost. Every exporter takes a document back.

mod error;
pub mod phong;
mod report;
pub mod smoothing;

pub use error::ConvertError;
pub use report::{Change, Outcome, Report};

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use aam::Document;
use aam_scene::{Camera, Light, Up};

/// An asset in memory: what every importer gives and every exporter takes.
#[derive(Clone, Debug, Default)]
pub struct Asset {
    /// The asset as an AAM document, in AAM's axes (Z up).
    pub document: Document,
    /// Texture files that the document's materials name, by their `FN:` name, as encoded files (PNG, JPEG …).
    pub textures: BTreeMap<String, TextureFile>,
    /// Lights, in AAM's axes, for the scene file.
    pub lights: Vec<Light>,
    /// Cameras, in AAM's axes, for the scene file.
    pub cameras: Vec<Camera>,
    /// What became of everything.
    pub report: Report,
}

/// A texture that belongs to an imported asset.
#[derive(Clone, Debug)]
pub enum TextureFile {
    /// A file that is used as it is.
    OnDisk(PathBuf),
    /// An encoded image (embedded or baked).
    InMemory(Arc<[u8]>),
}

/// How to import. Defaults are those of `aam convert`.
#[derive(Clone, Debug)]
pub struct ImportOptions {
    /// Write local transforms (`AAM_CHARACTER`) instead of world coordinates.
    pub hierarchy: bool,
    /// The animation clip to take; `None` takes the first.
    pub animation: Option<String>,
    /// Frames a second when an animation is sampled. Default 30.
    pub frames_per_second: f32,
    /// Largest angle in degrees between an authored normal and the one that smoothing groups give before explicit
    /// normals are written. Default 0.5.
    pub normal_tolerance: f32,
    /// Read textures outside the asset's folder.
    pub allow_outside: bool,
    /// Which axis points up in formats that do not say: `None` takes +Y for OBJ, and +Z for STL and PLY.
    pub up: Option<Up>,
    /// Largest size in bytes of any one file read. Default 4 GiB.
    pub max_file_size: u64,
    /// Largest number of pixels in one texture. Default 2²⁸ (16384 × 16384).
    pub max_texture_pixels: u64,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self {
            hierarchy: false,
            animation: None,
            frames_per_second: 30.0,
            normal_tolerance: 0.5,
            allow_outside: false,
            up: None,
            max_file_size: 4 << 30,
            max_texture_pixels: 1 << 28,
        }
    }
}

/// How to export. Defaults are those of `aam convert`.
#[derive(Clone, Debug, Default)]
pub struct ExportOptions {
    /// How an AAM file is written.
    pub write: aam::WriteOptions,
    /// Write the original AAM format alone, without this project's extensions, and report what was dropped.
    pub original: bool,
    /// Which axis points up in an OBJ file: `None` is +Y.
    pub up: Option<Up>,
    /// Replace files that exist with other content, also those that were not named.
    pub overwrite: bool,
}

/// Told how far a long piece of work has come.
pub trait Progress {
    /// A new stage starts; `total` steps are known or 0.
    fn stage(&self, name: &str, total: u64);
    /// Steps done in this stage.
    fn step(&self, done: u64);
}

/// Progress that nobody watches.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn stage(&self, _name: &str, _total: u64) {}
    fn step(&self, _done: u64) {}
}

/// File formats by extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.aam`
    Aam,
    /// `.gltf` (JSON with external or embedded buffers)
    Gltf,
    /// `.glb` (binary glTF)
    Glb,
    /// `.obj` with `.mtl`
    Obj,
    /// `.stl`
    Stl,
    /// `.ply`
    Ply,
}

impl Format {
    /// The format of a path by its extension, in any letter case.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        Some(match extension.as_str() {
            "aam" => Self::Aam,
            "gltf" => Self::Gltf,
            "glb" => Self::Glb,
            "obj" => Self::Obj,
            "stl" => Self::Stl,
            "ply" => Self::Ply,
            _ => return None,
        })
    }
}
