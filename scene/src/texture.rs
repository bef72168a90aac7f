//! Texture files: finding them, and decoding them within limits.

use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where the textures of a document come from.
pub trait TextureSource {
    /// Finds the file that a material names (`FN:`).
    ///
    /// # Errors
    /// Why there is no such texture, or why it may not be read, in words for people.
    fn find(&self, name: &str) -> Result<FoundTexture, String>;

    /// The limits that decoding keeps.
    fn limits(&self) -> TextureLimits {
        TextureLimits::default()
    }
}

/// A texture file that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundTexture {
    /// Equal for two names of the same file (a canonical path, or a name of its own), which is then loaded once.
    pub key: String,
    /// The encoded image.
    pub data: TextureData,
}

/// An encoded image (PNG, JPEG …).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TextureData {
    /// A file.
    OnDisk(PathBuf),
    /// Its bytes.
    InMemory(Arc<[u8]>),
}

/// What a texture may cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureLimits {
    /// Largest number of pixels in one texture. Default 2²⁸ (16384 × 16384).
    pub max_pixels: u64,
    /// Largest size in bytes of one file. Default 1 GiB.
    pub max_file_size: u64,
}

impl Default for TextureLimits {
    fn default() -> Self {
        Self { max_pixels: 1 << 28, max_file_size: 1 << 30 }
    }
}

/// Textures in a document's folder.
#[derive(Clone, Debug)]
pub struct FolderTextures {
    folder: PathBuf,
    /// Whether names may lead out of the folder.
    pub allow_outside: bool,
    /// What each texture may cost.
    pub limits: TextureLimits,
}

impl FolderTextures {
    /// The textures in a folder, not outside of it, with the default limit.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into(), allow_outside: false, limits: TextureLimits::default() }
    }

    /// The textures beside a document.
    pub fn beside(document: &Path) -> Self {
        Self::new(document.parent().unwrap_or(Path::new("")))
    }
}

impl TextureSource for FolderTextures {
    fn find(&self, name: &str) -> Result<FoundTexture, String> {
        Err(format!("{name}: not in {}", self.folder.display()))
    }

    fn limits(&self) -> TextureLimits {
        self.limits
    }
}

/// No textures at all.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoTextures;

impl TextureSource for NoTextures {
    fn find(&self, _name: &str) -> Result<FoundTexture, String> {
        Err("textures were not asked for".into())
    }
}
