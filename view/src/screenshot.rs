//! Pictures of the view as PNG files.

use std::fs::OpenOptions;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use aam_scene::{Image, Pixels};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

/// Writes the picture to the first free `NAME-001.png` in a folder.
pub(crate) fn save(folder: &Path, name: &str, picture: &Image) -> Result<PathBuf, String> {
    let Pixels::Rgba8(bytes) = &picture.pixels else { return Err("the picture is not 8 bit".into()) };
    for number in 1..=9999 {
        let path = folder.join(format!("{name}-{number:03}.png"));
        // `create_new` so that no picture is ever replaced.
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(file) => {
                let mut file = BufWriter::new(file);
                let encoder = PngEncoder::new_with_quality(&mut file, CompressionType::Fast, FilterType::Adaptive);
                let failed = |reason: String| format!("{}: {reason}", path.display());
                encoder
                    .write_image(bytes, picture.width, picture.height, ExtendedColorType::Rgba8)
                    .map_err(|error| failed(error.to_string()))?;
                file.flush().map_err(|error| failed(error.to_string()))?;
                return Ok(path);
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(format!("{}: {error}", path.display())),
        }
    }
    Err(format!("{}: there are 9999 pictures already", folder.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_numbered_and_never_replaced() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let picture = Image { width: 2, height: 1, pixels: Pixels::Rgba8(vec![255, 0, 0, 255, 0, 255, 0, 128]) };
        let first = save(folder.path(), "duck", &picture).expect("saved");
        let second = save(folder.path(), "duck", &picture).expect("saved");
        assert!(first.ends_with("duck-001.png") && second.ends_with("duck-002.png"));
        let read = image::open(&first).expect("a PNG").into_rgba8();
        assert_eq!(read.into_raw(), vec![255, 0, 0, 255, 0, 255, 0, 128]);
    }
}
