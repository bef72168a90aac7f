//! glTF export: what is in the files, that they are valid, and that they come back.

mod content;
mod corpus;
mod documents;
mod pictures;
mod roundtrip;
mod validator;

use std::path::{Path, PathBuf};

use aam::Document;
use aam_convert::{Asset, ConvertError, ExportOptions, Report, TextureFile, export};

/// An asset of a document and textures in memory.
fn asset(document: Document, textures: &[(&str, Vec<u8>)]) -> Asset {
    let file = |(name, bytes): &(&str, Vec<u8>)| ((*name).to_owned(), TextureFile::InMemory(bytes.clone().into()));
    Asset { document, textures: textures.iter().map(file).collect(), ..Asset::default() }
}

/// Exports into a folder, and checks that the same asset gives the same bytes again.
fn export_to(folder: &Path, name: &str, asset: &Asset) -> Result<(PathBuf, Report), ConvertError> {
    let path = folder.join(name);
    let report = export(asset, &path, &ExportOptions::default())?;
    let first = std::fs::read(&path).expect("the file was written");
    export(asset, &path, &ExportOptions::default())?;
    assert_eq!(first, std::fs::read(&path).expect("the file was written again"), "{name} differs from run to run");
    Ok((path, report))
}

/// A PNG of given size, texel by texel from the top left.
fn png(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Vec<u8> {
    let picture = image::RgbaImage::from_fn(width, height, |x, y| image::Rgba(texel(x, y)));
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).expect("a PNG is written to memory");
    bytes.into_inner()
}
