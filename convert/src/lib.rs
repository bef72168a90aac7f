//! glTF, OBJ, STL and PLY to and from AAM documents; convex decomposition.
//!
//! Every importer gives an [`Asset`]: a document, the texture files it names, the lights and cameras that only a
//! scene file can hold, and a [`Report`] of what was kept, changed and lost. Every exporter takes a document back.

mod aam_file;
pub mod authoring;
mod error;
mod files;
mod gltf_in;
mod gltf_out;
pub mod hulls;
mod mesh;
mod obj;
mod original;
pub mod phong;
pub mod physics;
mod picture;
mod ply;
mod polygon;
mod report;
pub mod smoothing;
mod source;
mod stl;
mod uv_lines;

pub use error::ConvertError;
pub use report::{Change, Outcome, Report};

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use aam::{Document, Limits};
use aam_scene::{Camera, FoundTexture, Light, Shading, TextureData, TextureSource, Up};

use authoring::AddedLayer;
use files::{Replace, save};
use physics::PhysicsOptions;

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
    /// On which values the source means lighting to compute; `None` where it does not say.
    pub shading: Option<Shading>,
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

/// So that an asset can be drawn without being written first.
impl TextureSource for Asset {
    fn find(&self, name: &str) -> Result<FoundTexture, String> {
        match self.textures.get(name) {
            Some(TextureFile::OnDisk(path)) => {
                Ok(FoundTexture { key: path.display().to_string(), data: TextureData::OnDisk(path.clone()) })
            }
            Some(TextureFile::InMemory(bytes)) => {
                Ok(FoundTexture { key: format!("memory:{name}"), data: TextureData::InMemory(bytes.clone()) })
            }
            None => Err(format!("{name}: not found when the asset was read")),
        }
    }
}

/// How to import. Defaults are those of `aam convert`.
#[derive(Clone, Debug)]
pub struct ImportOptions {
    /// Write local transforms (`AAM_CHARACTER`) instead of world coordinates.
    pub hierarchy: bool,
    /// The animation clip to take, by name or by number from 0; `none` takes none, `None` takes the first.
    pub animation: Option<String>,
    /// Frames a second when an animation is sampled. Default 30.
    pub frames_per_second: f32,
    /// Largest angle in degrees between an authored normal and the one that smoothing groups give before explicit
    /// normals are written. Default 0.5.
    pub normal_tolerance: f32,
    /// Give triangles texture coordinates even where their material has no texture, for a layer to be added later.
    pub keep_uvs: bool,
    /// Read textures outside the asset's folder.
    pub allow_outside: bool,
    /// Which axis points up in formats that do not say: `None` takes +Y for OBJ, and +Z for STL and PLY.
    pub up: Option<Up>,
    /// How large files, textures and the document may be.
    pub limits: Limits,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self {
            hierarchy: false,
            animation: None,
            frames_per_second: 30.0,
            normal_tolerance: 0.5,
            keep_uvs: false,
            allow_outside: false,
            up: None,
            limits: Limits::default(),
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
    /// How large texture files may be that are read to be written in another form.
    pub limits: Limits,
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

const READABLE: &str = ".aam .gltf .glb .obj .stl .ply";
const WRITABLE: &str = ".aam .gltf .glb .obj";

/// Reads a file, by its extension.
///
/// # Errors
/// When the extension is unknown, a file cannot be read, or its content is broken or not supported.
pub fn import(path: &Path, options: &ImportOptions, progress: &dyn Progress) -> Result<Asset, ConvertError> {
    let format = readable(path)?;
    progress.stage("reading", 0);
    let bytes = aam::read_bytes(path, &options.limits)?;
    import_as(format, bytes, path, options, progress)
}

/// As [`import`], with the bytes of the file in memory. `path` says the format, by its extension, and where the files are
/// that the bytes name; the file itself is not opened and need not exist.
///
/// # Errors
/// Those of [`import`], but for a file that cannot be opened.
pub fn import_bytes(
    bytes: Vec<u8>,
    path: &Path,
    options: &ImportOptions,
    progress: &dyn Progress,
) -> Result<Asset, ConvertError> {
    import_as(readable(path)?, bytes, path, options, progress)
}

fn readable(path: &Path) -> Result<Format, ConvertError> {
    Format::of(path).ok_or_else(|| ConvertError::UnknownFormat { path: path.to_owned(), known: READABLE })
}

fn import_as(
    format: Format,
    bytes: Vec<u8>,
    path: &Path,
    options: &ImportOptions,
    progress: &dyn Progress,
) -> Result<Asset, ConvertError> {
    let asset = match format {
        Format::Aam => return aam_file::import(&bytes, path, options),
        Format::Gltf | Format::Glb => {
            let asset = gltf_in::import(bytes, path, options, progress)?;
            return Ok(Asset { shading: Some(Shading::Linear), ..asset });
        }
        Format::Obj => obj::import(bytes, path, options, progress)?,
        Format::Stl => stl::import(&bytes, path, options)?,
        Format::Ply => ply::import(&bytes, path, options)?,
    };
    // These formats cannot repeat a part, so a document is never more than a small multiple of the file.
    let over = |exceeded| ConvertError::Limit { path: path.to_owned(), exceeded, way_out: None };
    options.limits.check_document(&asset.document).map_err(over)?;
    Ok(asset)
}

/// Writes an asset to a file, by its extension, and the files that belong to it (textures, `.mtl`, `.bin`, scene file)
/// beside it. Gives what the format could not keep.
///
/// Everything is written under temporary names first and renamed last, the main file after the others. A file beside it
/// that exists with other content is an error unless [`ExportOptions::overwrite`] is set; the named file is replaced.
///
/// # Errors
/// When the extension is not writable, the asset cannot be expressed, or a file cannot be written.
pub fn export(asset: &Asset, path: &Path, options: &ExportOptions) -> Result<Report, ConvertError> {
    let files = files_of(asset, path, options)?;
    save(path, &files, Replace { input: None, main: true, beside: options.overwrite })?;
    Ok(files.report)
}

fn files_of(asset: &Asset, path: &Path, options: &ExportOptions) -> Result<files::Files, ConvertError> {
    let unknown = || ConvertError::UnknownFormat { path: path.to_owned(), known: WRITABLE };
    let stem = path.file_stem().ok_or_else(unknown)?.to_string_lossy();
    match Format::of(path).ok_or_else(unknown)? {
        Format::Aam => aam_file::export(asset, path, options),
        Format::Gltf => gltf_out::export(asset, &stem, gltf_out::Container::Gltf, &options.limits),
        Format::Glb => gltf_out::export(asset, &stem, gltf_out::Container::Glb, &options.limits),
        Format::Obj => obj::export(asset, &stem, options),
        Format::Stl | Format::Ply => Err(unknown()),
    }
}

/// Everything about one conversion.
#[derive(Clone, Debug, Default)]
pub struct ConvertOptions {
    /// How to read.
    pub import: ImportOptions,
    /// Layers that the input lacks.
    pub layers: Vec<AddedLayer>,
    /// Bodies for the objects; `None` leaves those that the input has.
    pub physics: Option<PhysicsOptions>,
    /// How to write.
    pub export: ExportOptions,
}

/// What [`convert`] did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Converted {
    /// The main file.
    pub output: PathBuf,
    /// All files whose content changed, the main one last; those that held the same already are not listed.
    pub written: Vec<PathBuf>,
    /// What was kept, changed and lost, reading and writing.
    pub report: Report,
}

/// Converts a file. Without an output, `model.gltf` becomes `model.aam` beside it, with its textures and, where it has
/// lights or cameras, `model.scene.toml`.
///
/// The input is never replaced, nor is a file that exists with other content, unless it is the `output` that was named
/// or [`ExportOptions::overwrite`] is set.
///
/// # Errors
/// Those of [`import`] and [`export`], and options that do not fit the input.
pub fn convert(
    input: &Path,
    output: Option<&Path>,
    options: &ConvertOptions,
    progress: &dyn Progress,
) -> Result<Converted, ConvertError> {
    let named = output.is_some();
    let output = output.map_or_else(|| input.with_extension("aam"), Path::to_owned);
    if !named && Format::of(input) == Some(Format::Aam) {
        return Err(ConvertError::Option(format!(
            "{}: say what to convert it to: a name that ends in {WRITABLE}",
            input.display()
        )));
    }
    let adding = !options.layers.is_empty();
    let reading = ImportOptions { keep_uvs: options.import.keep_uvs || adding, ..options.import.clone() };
    let mut asset = import(input, &reading, progress)?;
    for layer in &options.layers {
        authoring::add_layer(&mut asset, layer)?;
    }
    if adding && !options.import.keep_uvs {
        authoring::drop_spare_lines(&mut asset.document);
    }
    if let Some(physics) = &options.physics {
        physics::add_bodies(&mut asset, physics, progress)?;
    }
    progress.stage("writing", 0);
    let files = files_of(&asset, &output, &options.export)?;
    let overwrite = options.export.overwrite;
    let written = save(&output, &files, Replace { input: Some(input), main: named || overwrite, beside: overwrite })?;
    let mut report = asset.report;
    report.append(files.report);
    Ok(Converted { output, written, report })
}
