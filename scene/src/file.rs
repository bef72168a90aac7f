//! The scene file (`*.scene.toml`): which assets stand where, lights, shadows, cameras, background, and what is hidden.

mod assemble;
mod environment;
mod form;
mod shadow;
mod shadow_form;

use std::path::{Path, PathBuf};

use aam::{FileError, Limits, Position};
use glam::{Affine3A, EulerRot, Quat, Vec3};

use crate::{Camera, EnvironmentPictures, Light, Shading, SpecularFilter, ToneMap, Up};

pub use shadow::{LightEntry, MemberEntry, ShadowEntry, ShadowsEntry};

/// The ending of a scene file's name.
pub const SCENE_EXTENSION: &str = ".scene.toml";

/// The largest scene file in bytes.
const MAX_SIZE: u64 = 16 << 20;

/// A scene file: which assets stand where, lights, shadows, cameras, background, and what is hidden. The default is an
/// empty one.
///
/// As text it is TOML. Every key is optional but an asset's `path`, a light's `kind` and place, a camera's `position`,
/// `target` and projection; a key that is not known is an error.
///
/// ```toml
/// up = "z"                     # or "y"
/// shading = "source"           # or "linear"
/// exposure = 0                 # stops
/// tone_map = "clamp"           # or "reinhard", "aces", "neutral"
/// active_camera = "front"
///
/// [background]                 # one of the four
/// color = [0.18, 0.2, 0.23]    # sRGB
/// # picture = "sky.png"
/// # transparent = true
/// # environment = true         # the sky box; without a background it is there if there is an environment
///
/// [environment]                # light from all around, instead of lights
/// picture = "sky.hdr"          # a panorama, or the cross of a cube; relative to this file, in its folder or below
/// # faces = { right = "px.hdr", left = "nx.hdr", up = "py.hdr", down = "ny.hdr", front = "pz.hdr", back = "nz.hdr" }
/// diffuse = true               # it lights the diffuse terms of materials
/// specular = true              # surfaces reflect it
/// filter = "phong"             # or "mirror"; without it as the shading asks: mirror for source, phong for linear
/// rotation = 30                # degrees about up, counter-clockwise seen from above
/// intensity = 1
///
/// [[asset]]
/// path = "helmet.gltf"         # relative to this file
/// name = "helmet"
/// position = [0, 0, 1.5]       # metres
/// rotation = [0, 0, 90]        # degrees about x, then y, then z
/// scale = [1, 1, 1]
/// [[asset.node]]
/// name = "visor"               # of several nodes with this name the first, or the one that `occurrence` says
/// visible = false
///
/// [[light]]                    # replaces the lights that assets bring along
/// name = "key"
/// kind = "spot"                # or "point", "directional"
/// position = [2, -3, 4]
/// direction = [-0.4, 0.6, -0.7]
/// inner = 20                   # half angles in degrees
/// outer = 30
/// falloff = "inverse-square"   # or "none"
/// diffuse = [4, 4, 4]
/// shape = { form = "disc", radius = 0.2 }  # or "sphere"; { form = "rectangle", width = 1, height = 0.5 }
///
/// [shadows]                    # who takes part; without it all objects
/// casters = ["helmet"]         # names of assets or nodes, all of that name and what is below them
/// receivers = ["helmet", { name = "floor", occurrence = 2 }]
/// cull_back_faces = false      # what may be left out of maps: triangles that face away from the source,
/// cull_casters = true          # objects outside of its volume,
/// cull_sources = true          # sources whose volume the camera does not see
/// displaced = false            # true: displaced surfaces cast as they are drawn (kept, without effect yet)
///
/// [[shadow]]
/// name = "key"
/// light = "key"                # or its number, from 1; without it every light is darkened
/// technique = "evsm4:resolution=512,radius=5"
/// enabled = true
/// # what the source sees through a square window, outside of which all is lit; without it what fits (needs a `light`)
/// volume = { position = [2, -3, 4], target = [0, 0, 1], fov_y = 45, near = 2, far = 8 }  # or `height`, and `up`
///
/// [[camera]]
/// name = "front"
/// position = [0, -4, 1.5]
/// target = [0, 0, 1.5]
/// fov_y = 40                   # degrees; or `height` in metres for an orthographic one
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneFile {
    /// Which way is up; `None` means Z. Assets are turned where theirs differs.
    pub up: Option<Up>,
    /// The values that lighting computes on; `None` leaves it to the assets: linear if one of them asks for it.
    pub shading: Option<Shading>,
    /// Exposure in stops; `None` means 0.
    pub exposure: Option<f32>,
    /// How light beyond white is shown; `None` means cut.
    pub tone_map: Option<ToneMap>,
    /// What is behind everything; `None` means the environment, or the default colour.
    pub background: Option<BackgroundEntry>,
    /// Light from all around.
    pub environment: Option<EnvironmentEntry>,
    /// The name of the camera to look through first.
    pub active_camera: Option<String>,
    /// The assets.
    pub assets: Vec<AssetEntry>,
    /// The lights; `None` means those that the assets bring along.
    pub lights: Option<Vec<Light>>,
    /// Shadows; `None` means that there are none.
    pub shadows: Option<ShadowsEntry>,
    /// Named views. They stand before the cameras that assets bring along, and replace those of the same name.
    pub cameras: Vec<Camera>,
}

/// What is behind everything.
#[derive(Clone, Debug, PartialEq)]
pub enum BackgroundEntry {
    /// Nothing.
    Transparent,
    /// One colour, sRGB-encoded.
    Color(Vec3),
    /// A picture, relative to the scene file, in its folder or below.
    Picture(PathBuf),
    /// The environment.
    Environment,
}

/// Light from all around: what [`crate::Environment`] is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentEntry {
    /// The pictures, relative to the scene file, in its folder or below.
    pub pictures: EnvironmentPictures<PathBuf>,
    /// It lights the diffuse terms of materials.
    pub diffuse: bool,
    /// Surfaces with a specular term reflect it.
    pub specular: bool,
    /// How sharply; `None` leaves it to the shading.
    pub filter: Option<SpecularFilter>,
    /// Degrees about the up axis, counter-clockwise seen from above.
    pub rotation: f32,
    /// Factor for all of it.
    pub intensity: f32,
}

/// An asset and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct AssetEntry {
    /// The file, relative to the scene file's folder, or absolute.
    pub path: PathBuf,
    /// A name for people; `None` means the file's.
    pub name: Option<String>,
    /// Where its origin stands, in metres.
    pub position: Vec3,
    /// Degrees about x, then y, then z.
    pub rotation: Vec3,
    /// Scale along its own axes.
    pub scale: Vec3,
    /// False hides all of it.
    pub visible: bool,
    /// What differs for single nodes.
    pub nodes: Vec<NodeEntry>,
}

/// What differs for a node of an asset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeEntry {
    /// The node's name.
    pub name: String,
    /// Which of several nodes with this name, from 1, in the order of the asset's node list.
    pub occurrence: usize,
    /// False hides it and its children.
    pub visible: bool,
}

/// Why a scene file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneFileError {
    /// It cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// Its text is not a scene file.
    #[error("{}:{source}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        source: SceneSyntaxError,
    },
    /// It holds a value that a scene file cannot hold.
    #[error("{}: {message}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Which value, and why.
        message: String,
    },
}

/// What is wrong with the text of a scene file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{position}: error[scene/syntax]: {message}")]
pub struct SceneSyntaxError {
    /// Where.
    pub position: Position,
    /// What is wrong: it names the key.
    pub message: String,
}

impl SceneFile {
    /// Whether a path is that of a scene file, by its ending in any letter case.
    pub fn is_one(path: &Path) -> bool {
        let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase());
        name.is_some_and(|name| name.ends_with(SCENE_EXTENSION))
    }

    /// A scene file for one asset, both as paths from the same place: to be written at `scene_file`.
    pub fn of_asset(scene_file: &Path, asset: &Path) -> Self {
        Self { assets: vec![AssetEntry::new(relative(scene_file, asset))], ..Self::default() }
    }

    /// The scene file that goes with an asset: beside it, with another ending.
    pub fn path_beside(asset: &Path) -> PathBuf {
        let stem = asset.file_stem().unwrap_or(asset.as_os_str());
        let mut name = stem.to_os_string();
        name.push(SCENE_EXTENSION);
        asset.with_file_name(name)
    }

    /// Reads a scene file.
    ///
    /// # Errors
    /// When it cannot be read, or is not one; the message then names line, column and key.
    pub fn read(path: &Path) -> Result<Self, SceneFileError> {
        let bytes = match aam::read_bytes(path, &Limits { file_size: MAX_SIZE, ..Limits::DEFAULT }) {
            // No option raises this limit.
            Err(FileError::TooLarge { path, exceeded }) => {
                let reason = format!("{} bytes are more than a scene file may have ({MAX_SIZE})", exceeded.found);
                return Err(FileError::Open { path, source: std::io::Error::other(reason) }.into());
            }
            other => other?,
        };
        let syntax = |source| SceneFileError::Syntax { path: path.to_owned(), source };
        let text = std::str::from_utf8(&bytes).map_err(|error| {
            syntax(SceneSyntaxError {
                position: Position::of(&bytes, error.valid_up_to()),
                message: "the file is not UTF-8 text".to_owned(),
            })
        })?;
        Self::parse(text).map_err(syntax)
    }

    /// Reads a scene file from its text.
    ///
    /// # Errors
    /// What is wrong, and where.
    pub fn parse(text: &str) -> Result<Self, SceneSyntaxError> {
        form::parse(text)
    }

    /// The text of the scene file. Reading it gives an equal one.
    ///
    /// # Errors
    /// Which value a scene file cannot hold: a number that is not finite, a path that is not Unicode.
    pub fn to_text(&self) -> Result<String, String> {
        form::to_text(self)
    }

    /// Writes the scene file, whole or not at all.
    ///
    /// # Errors
    /// When a value cannot be written, or the file; an earlier file of that name is then untouched.
    pub fn write(&self, path: &Path) -> Result<(), SceneFileError> {
        let unwritable = |message| SceneFileError::Unwritable { path: path.to_owned(), message };
        let text = self.to_text().map_err(unwritable)?;
        Ok(aam::write_bytes(path, text.as_bytes())?)
    }

    /// The paths of the assets, for a scene file that lies at `scene_file`. They may lead anywhere.
    pub fn asset_paths(&self, scene_file: &Path) -> Vec<PathBuf> {
        let folder = scene_file.parent().unwrap_or(Path::new(""));
        self.assets.iter().map(|asset| folder.join(&asset.path)).collect()
    }
}

impl AssetEntry {
    /// An asset as it is.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self {
            path: path.into(),
            name: None,
            position: Vec3::ZERO,
            rotation: Vec3::ZERO,
            scale: Vec3::ONE,
            visible: true,
            nodes: Vec::new(),
        }
    }

    /// The transform from the asset to the scene.
    pub fn placement(&self) -> Affine3A {
        let [x, y, z] = self.rotation.to_array().map(f32::to_radians);
        // Intrinsic Z, Y, X is about the fixed axes x, then y, then z.
        let rotation = Quat::from_euler(EulerRot::ZYX, z, y, x);
        Affine3A::from_scale_rotation_translation(self.scale, rotation, self.position)
    }

    /// The name for people.
    pub fn display_name(&self) -> String {
        self.name
            .clone()
            .unwrap_or_else(|| self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned())
    }
}

/// The path of an asset as a scene file should name it: relative where the asset lies in its folder or below.
fn relative(scene_file: &Path, asset: &Path) -> PathBuf {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let (scene_file, asset) = (absolute(scene_file), absolute(asset));
    let folder = scene_file.parent().unwrap_or(Path::new(""));
    asset.strip_prefix(folder).map_or_else(|_| asset.clone(), Path::to_owned)
}

#[cfg(test)]
#[path = "file/tests.rs"]
mod tests;
