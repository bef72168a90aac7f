//! Texture files: finding them without leaving the asset's folder, and decoding them within limits.

use std::fs;
use std::io::Cursor;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use aam::{Limit, Limits};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use crate::{Image, Pixels};

/// Where the textures of a document come from.
pub trait TextureSource {
    /// Finds the file that a material names (`FN:`).
    ///
    /// # Errors
    /// Why there is no such texture, or why it may not be read, in words for people.
    fn find(&self, name: &str) -> Result<FoundTexture, String>;

    /// The limits that decoding keeps.
    fn limits(&self) -> Limits {
        Limits::default()
    }
}

/// A texture file that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundTexture {
    /// Equal for two names of the same file (a canonical path, or a name of its own), which is then loaded once. Its
    /// extension says the format of an image that does not say so itself (TGA).
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

/// No textures at all.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoTextures;

impl TextureSource for NoTextures {
    fn find(&self, _name: &str) -> Result<FoundTexture, String> {
        Err("textures were not asked for".into())
    }
}

/// Textures in a document's folder.
///
/// A name may use `/` or `\`, and letters of either case. It is looked for as it stands, then without regard to case,
/// then by its bare file name in the folder itself: real files say `Meshes/desert80.png` or `C:\maps\wood.jpg` while the
/// file lies beside them. Unless [`FolderTextures::allow_outside`] is set, names never lead out of the folder, be they
/// absolute, with `..`, on another machine, or through a symbolic link.
#[derive(Clone, Debug)]
pub struct FolderTextures {
    folder: PathBuf,
    /// Whether names may lead out of the folder.
    pub allow_outside: bool,
    /// What each texture may cost.
    pub limits: Limits,
}

impl FolderTextures {
    /// The textures in a folder, not outside of it, with the default limits.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        let folder: PathBuf = folder.into();
        let folder = if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder };
        Self { folder, allow_outside: false, limits: Limits::default() }
    }

    /// The textures beside a document.
    pub fn beside(document: &Path) -> Self {
        Self::new(document.parent().unwrap_or(Path::new("")))
    }

    /// The file, if it exists, is a file, and may be read.
    fn admit(&self, path: &Path) -> Admission {
        let Ok(real) = fs::canonicalize(path) else {
            return Admission::Absent;
        };
        let inside = || fs::canonicalize(&self.folder).is_ok_and(|folder| real.starts_with(folder));
        if !self.allow_outside && !inside() {
            return Admission::Outside;
        }
        // Not a folder, and not a pipe or device, which could block for ever.
        match fs::metadata(&real) {
            Ok(meta) if meta.is_file() => Admission::File(real),
            _ => Admission::Absent,
        }
    }

    /// A path inside the folder, each part as it stands or, where there is none, in other case.
    fn inside(&self, parts: &[&str]) -> Admission {
        let exact = parts.iter().fold(self.folder.clone(), |path, part| path.join(part));
        match self.admit(&exact) {
            Admission::Absent => {}
            found => return found,
        }
        let mut path = self.folder.clone();
        for part in parts {
            match in_any_case(&path, part) {
                Some(found) => path = found,
                None => return Admission::Absent,
            }
        }
        self.admit(&path)
    }
}

enum Admission {
    File(PathBuf),
    Outside,
    Absent,
}

/// The entry of a folder with this name; without one, the first in alphabetical order that differs only in case.
fn in_any_case(folder: &Path, name: &str) -> Option<PathBuf> {
    let exact = folder.join(name);
    if exact.exists() {
        return Some(exact);
    }
    let wanted = name.to_lowercase();
    let entries = fs::read_dir(folder).ok()?.flatten().map(|entry| entry.file_name());
    let same = |entry: &std::ffi::OsString| entry.to_str().is_some_and(|entry| entry.to_lowercase() == wanted);
    entries.filter(same).min().map(|entry| folder.join(entry))
}

/// Whether a name, `/` between its parts, says a place of its own: a root, a drive or another machine.
fn is_absolute(name: &str) -> bool {
    let drive = matches!(name.as_bytes(), [letter, b':', ..] if letter.is_ascii_alphabetic());
    name.starts_with('/') || drive || Path::new(name).is_absolute()
}

impl TextureSource for FolderTextures {
    fn find(&self, name: &str) -> Result<FoundTexture, String> {
        let slashed = name.trim().replace('\\', "/");
        if slashed.chars().any(char::is_control) {
            return Err("the name holds control characters".into());
        }
        let parts: Vec<&str> = slashed.split('/').filter(|part| !part.is_empty() && *part != ".").collect();
        let Some(&bare) = parts.last().filter(|&&bare| bare != "..") else {
            return Err("the name is empty".into());
        };
        let found = |path: PathBuf| {
            let key = path.to_str().map_or_else(|| format!("{path:?}"), str::to_owned);
            Ok(FoundTexture { key, data: TextureData::OnDisk(path) })
        };
        let leaves = is_absolute(&slashed) || parts.contains(&"..");
        let first = if !leaves {
            self.inside(&parts)
        } else if self.allow_outside {
            self.admit(&self.folder.join(&slashed))
        } else {
            Admission::Outside
        };
        let outside = match first {
            Admission::File(path) => return found(path),
            Admission::Outside => true,
            Admission::Absent => false,
        };
        // The bare name must be one plain component on every system.
        let plain = matches!(Path::new(bare).components().collect::<Vec<_>>()[..], [Component::Normal(_)]);
        match if plain && parts.len() > 1 { self.inside(&[bare]) } else { Admission::Absent } {
            Admission::File(path) => found(path),
            Admission::Outside => Err(self.refusal()),
            Admission::Absent if outside => Err(self.refusal()),
            Admission::Absent => Err(format!("there is no such file in {}", self.folder.display())),
        }
    }

    fn limits(&self) -> Limits {
        self.limits
    }
}

impl FolderTextures {
    fn refusal(&self) -> String {
        format!(
            "the name leads out of {}; it is read only when files outside are allowed (--allow-outside)",
            self.folder.display()
        )
    }
}

/// Decodes a texture that was found.
///
/// # Errors
/// Why it cannot be read or decoded, or which limit it breaks, in words for people.
pub fn load_texture(found: &FoundTexture, limits: &Limits) -> Result<Image, String> {
    let mut image = decode_found(found, limits)?;
    if let Pixels::RgbF32(values) = &mut image.pixels {
        values.iter_mut().for_each(|value| *value = finite(*value));
    }
    Ok(image)
}

/// [`load_texture`] with floats as they stand in the file.
pub(crate) fn decode_found(found: &FoundTexture, limits: &Limits) -> Result<Image, String> {
    let read;
    let bytes: &[u8] = match &found.data {
        TextureData::OnDisk(path) => {
            read = aam::read_bytes(path, limits).map_err(|error| error.to_string())?;
            &read
        }
        TextureData::InMemory(bytes) => {
            limits.check(Limit::FileSize, bytes.len() as u64).map_err(|error| error.to_string())?;
            bytes
        }
    };
    decode(bytes, Path::new(&found.key), limits)
}

/// Decodes an image: 8 or 16 bits for each channel, grey, palette or colour, with alpha or without, or floating point.
fn decode(bytes: &[u8], name: &Path, limits: &Limits) -> Result<Image, String> {
    let explain = |error: image::ImageError| format!("cannot be decoded: {error}");
    let mut reader = ImageReader::new(Cursor::new(bytes));
    if let Ok(format) = ImageFormat::from_path(name) {
        reader.set_format(format);
    }
    let mut reader = reader.with_guessed_format().map_err(|error| format!("cannot be read: {error}"))?;
    if reader.format().is_none() {
        return Err("it is in no known image format".into());
    }
    let mut memory = image::Limits::default();
    // Four channels of 32 bits, and as much again while rows are converted.
    memory.max_alloc = Some(limits.texture_pixels.saturating_mul(32).saturating_add(1 << 24));
    reader.limits(memory);
    let decoder = reader.into_decoder().map_err(explain)?;
    let (width, height) = decoder.dimensions();
    let count = u64::from(width) * u64::from(height);
    if count == 0 {
        return Err("it has no pixels".into());
    }
    limits.check(Limit::TexturePixels, count).map_err(|error| format!("{width} × {height} = {error}"))?;
    let decoded = DynamicImage::from_decoder(decoder).map_err(explain)?;
    let pixels = match decoded {
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => Pixels::Rgba16(decoded.into_rgba16().into_raw()),
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            Pixels::RgbF32(decoded.into_rgb32f().into_raw())
        }
        _ => Pixels::Rgba8(decoded.into_rgba8().into_raw()),
    };
    Ok(Image { width, height, pixels })
}

/// Radiance is neither negative nor NaN, and not more than a GPU's half floats hold.
fn finite(value: f32) -> f32 {
    if value > 0.0 { value.min(65504.0) } else { 0.0 }
}

#[cfg(test)]
#[path = "texture_tests.rs"]
mod tests;
