//! From a document to a scene.

use aam::{Document, Finding};

use crate::{Scene, TextureSource};

/// How to build. The default is what `aam view` uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// The most frames that an animation is sampled at; the rest is cut off with a warning. Default 10 000.
    pub max_frames: usize,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { max_frames: 10_000 }
    }
}

/// A scene, and what was odd on the way to it.
#[derive(Clone, Debug, Default)]
pub struct Built {
    /// The scene.
    pub scene: Scene,
    /// What was left out or replaced, in document order.
    pub warnings: Vec<Finding>,
}

/// Builds the scene of a document: one node for each object of frame 0.
pub fn build(document: &Document, textures: &dyn TextureSource, options: &BuildOptions) -> Built {
    let _ = (document, textures, options);
    Built::default()
}
