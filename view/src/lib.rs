//! The window: a camera to move, panels to inspect and change what is drawn, and a file that is followed.
//!
//! [`run`] opens it. What a file is and how it is read is the caller's affair ([`Opener`]), and so is how changes are
//! written ([`Saver`]); this crate knows scenes only.

mod app;
mod demo;
mod error;
mod eye;
mod graphics;
mod keys;
mod load;
mod marks;
mod model;
mod playback;
mod pose;
mod screenshot;
mod simulation;
mod ui;
mod watch;

pub use app::run;
pub use error::ViewError;

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use aam_physics::PhysicsMesh;
use aam_renderer::Msaa;
use aam_scene::{Camera, NodeId, Scene};
use glam::Vec3;

/// Reads a file, on a thread of its own. The second argument is told what is being done; the error is a sentence.
pub type Opener = Arc<dyn Fn(&Path, &dyn Fn(&str)) -> Result<Opened, String> + Send + Sync>;

/// Writes what the user changed: the file, its scene as it was read, the scene now, and the camera as it stands. Gives the
/// file written. The error is a sentence.
pub type Saver = Arc<dyn Fn(&Path, &Scene, &Scene, &Camera) -> Result<PathBuf, String> + Send + Sync>;

/// What the window shows, and how.
#[derive(Clone)]
pub struct Options {
    /// The file to open first; several are shown as the shadow-mapping demo, with its keys.
    pub files: Vec<PathBuf>,
    /// Width and height of the window in pixels.
    pub size: [u32; 2],
    /// Samples a pixel.
    pub msaa: Msaa,
    /// Reads files.
    pub opener: Opener,
    /// Writes changes.
    pub saver: Saver,
    /// Extensions that can be opened, for people (`.aam .gltf …`).
    pub formats: String,
}

impl fmt::Debug for Options {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Options")
            .field("files", &self.files)
            .field("size", &self.size)
            .field("msaa", &self.msaa)
            .field("formats", &self.formats)
            .finish_non_exhaustive()
    }
}

/// A file that was read.
#[derive(Clone, Debug, Default)]
pub struct Opened {
    /// What it shows.
    pub scene: Scene,
    /// The camera to look through first; `None` sees everything.
    pub camera: Option<Camera>,
    /// Outlines of collision shapes.
    pub outlines: Vec<Outline>,
    /// What can be simulated.
    pub bodies: Vec<(NodeId, Arc<PhysicsMesh>)>,
    /// Files that it came from; when one changes, it is read again. The file itself need not be among them.
    pub sources: Vec<PathBuf>,
    /// What was odd in it, one sentence each.
    pub warnings: Vec<String>,
}

/// The edges and faces of one part of a collision shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// The object that it belongs to.
    pub node: NodeId,
    /// Lines in the object's coordinates.
    pub segments: Vec<[Vec3; 2]>,
    /// Triangles likewise, counter-clockwise seen from outside; none for what is round.
    pub triangles: Vec<[Vec3; 3]>,
}
