//! Pictures on disk.

use std::path::Path;

use aam_scene::{Image, Pixels};

use crate::LabError;
use crate::metrics::CompareError;

/// Writes an 8-bit picture as PNG, and makes the folder it lies in.
///
/// # Errors
/// The picture is not 8 bits a channel or lacks pixels, or the file cannot be written.
pub fn save_png(picture: &Image, path: &Path) -> Result<(), LabError> {
    let Pixels::Rgba8(bytes) = &picture.pixels else { return Err(CompareError::Format.into()) };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|source| LabError::File { path: folder.to_owned(), source })?;
    }
    image::save_buffer(path, bytes, picture.width, picture.height, image::ColorType::Rgba8)
        .map_err(|error| LabError::Encode { path: path.to_owned(), reason: error.to_string() })
}
