//! Pictures as PNG.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use aam_scene::{Image, Pixels};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use crate::failure::Failure;

/// Where pictures go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Destination {
    Stdout,
    /// One file for each picture, in order.
    Files(Vec<PathBuf>),
}

impl Destination {
    /// Names for `turntable` pictures, or for one.
    pub(crate) fn new(output: &Path, turntable: Option<u32>) -> Result<Self, Failure> {
        if output.as_os_str() == "-" {
            if turntable.is_some() {
                return Err(Failure::new("a turntable is several files, which standard output cannot hold")
                    .help("name them with -o turn.png"));
            }
            if std::io::stdout().is_terminal() {
                return Err(
                    Failure::new("a picture on a terminal is of no use").help("redirect it: -o - > picture.png")
                );
            }
            return Ok(Self::Stdout);
        }
        let shown = output.display();
        if output.is_dir() {
            return Err(Failure::new(format_args!("{shown} is a folder"))
                .help(format_args!("name the picture: -o {}", output.join("picture.png").display())));
        }
        if !output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
            return Err(Failure::new(format_args!("{shown}: pictures are written as PNG only"))
                .help(format_args!("-o {}", output.with_extension("png").display())));
        }
        let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            return Err(Failure::new(format_args!("{shown}: the folder {} does not exist", folder.display()))
                .help(format_args!("mkdir -p {}", folder.display())));
        }
        Ok(Self::Files(match turntable {
            None => vec![output.to_owned()],
            Some(count) => (0..count).map(|number| numbered(output, number, count)).collect(),
        }))
    }
}

/// `{n}` in the file's name, or a number before its extension; as many digits as the last one needs, at least 2.
fn numbered(output: &Path, number: u32, count: u32) -> PathBuf {
    let digits = count.saturating_sub(1).max(10).ilog10() as usize + 1;
    let number = format!("{number:0digits$}");
    let name = output.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let name = if name.contains("{n}") {
        name.replace("{n}", &number)
    } else {
        let stem = output.file_stem().unwrap_or_default().to_string_lossy();
        let extension = output.extension().unwrap_or_default().to_string_lossy();
        format!("{stem}_{number}.{extension}")
    };
    output.with_file_name(name)
}

/// The bytes of a PNG. An alpha channel is written only where something shows through.
pub(crate) fn encode(picture: &Image) -> Result<Vec<u8>, Failure> {
    let Pixels::Rgba8(bytes) = &picture.pixels else {
        return Err(Failure::new("the picture that was drawn is not 8 bit"));
    };
    let opaque = bytes.chunks_exact(4).all(|pixel| pixel[3] == u8::MAX);
    let mut png = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut png, CompressionType::Fast, FilterType::Adaptive);
    let (width, height) = (picture.width, picture.height);
    let written = if opaque {
        let colors: Vec<u8> = bytes.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        encoder.write_image(&colors, width, height, ExtendedColorType::Rgb8)
    } else {
        encoder.write_image(bytes, width, height, ExtendedColorType::Rgba8)
    };
    written.map_err(|error| Failure::new(format_args!("the picture cannot be encoded: {error}")))?;
    Ok(png)
}

/// Writes a PNG to standard output, or to a file as a whole.
pub(crate) fn write(destination: &Destination, index: usize, png: &[u8]) -> Result<(), Failure> {
    match destination {
        Destination::Stdout => std::io::stdout().lock().write_all(png)?,
        Destination::Files(files) => {
            if let Some(file) = files.get(index) {
                aam::write_bytes(file, png)?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turntables_are_numbered() {
        let names = |output: &str, count| {
            let destination = Destination::new(Path::new(output), Some(count)).expect("names");
            let Destination::Files(files) = destination else { unreachable!("files were asked for") };
            let last = files.last().expect("a name").display().to_string();
            (files[0].display().to_string(), last)
        };
        assert_eq!(names("turn.png", 36), ("turn_00.png".into(), "turn_35.png".into()));
        assert_eq!(names("a{n}b.png", 101), ("a000b.png".into(), "a100b.png".into()));
        assert_eq!(names("turn.png", 1), ("turn_00.png".into(), "turn_00.png".into()));
    }

    #[test]
    fn wrong_outputs_are_refused_before_any_work() {
        for (output, turntable) in [("x.jpg", None), ("/nonexistent/x.png", None), ("/", None), ("-", Some(3))] {
            assert!(Destination::new(Path::new(output), turntable).is_err(), "{output}");
        }
    }

    #[test]
    fn alpha_is_written_where_it_matters() {
        let mut picture = Image { width: 1, height: 2, pixels: Pixels::Rgba8(vec![1, 2, 3, 255, 4, 5, 6, 255]) };
        let read = image::load_from_memory(&encode(&picture).expect("a PNG")).expect("readable");
        assert_eq!((read.color().has_alpha(), read.into_rgb8().into_raw()), (false, vec![1, 2, 3, 4, 5, 6]));
        picture.pixels = Pixels::Rgba8(vec![1, 2, 3, 255, 4, 5, 6, 0]);
        let read = image::load_from_memory(&encode(&picture).expect("a PNG")).expect("readable");
        assert_eq!((read.color().has_alpha(), read.into_rgba8().into_raw()), (true, vec![1, 2, 3, 255, 4, 5, 6, 0]));
    }
}
