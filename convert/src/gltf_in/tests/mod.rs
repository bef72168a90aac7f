//! Tests on small files that are built here, and on real ones.

mod accessors;
mod animation;
mod bones;
mod broken;
mod builder;
mod corpus;
mod geometry;
mod materials;
mod nodes;
mod outfits;
mod places;
mod textures;

use std::path::PathBuf;

use aam::Limits;
use aam::document::{MaterialBody, Object, SingleMaterial};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::{Asset, ConvertError, ImportOptions, Outcome, Silent};

pub(super) use builder::{Builder, png};

/// Default options but for the limits.
pub(super) fn limited(limits: Limits) -> ImportOptions {
    ImportOptions { limits, ..ImportOptions::default() }
}

impl Builder {
    /// What the importer makes of it.
    pub(super) fn try_import(&self, options: &ImportOptions) -> Result<Asset, ConvertError> {
        import_bytes(&self.glb(), "model.glb", options)
    }

    /// What the importer makes of it; it must be in order.
    pub(super) fn import(&self) -> Asset {
        self.import_with(&ImportOptions::default())
    }

    pub(super) fn import_with(&self, options: &ImportOptions) -> Asset {
        self.try_import(options).unwrap_or_else(|error| panic!("{error}"))
    }
}

/// Imports bytes as a file of that name in an empty folder.
pub(super) fn import_bytes(bytes: &[u8], name: &str, options: &ImportOptions) -> Result<Asset, ConvertError> {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("written");
    let asset = crate::import(&path, options, &Silent)?;
    // What is imported can be written, and read back to the same.
    let bytes = aam::write(&asset.document, &aam::WriteOptions::default()).expect("a document that can be written");
    let read = aam::read(&bytes, &aam::ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(read.document, asset.document, "what is written reads back");
    assert!(read.findings.is_empty(), "{:?}", read.findings);
    Ok(asset)
}

/// Decodes a texture of an asset to RGBA.
pub(super) fn decoded(asset: &Asset, name: &str) -> image::RgbaImage {
    let file = asset.textures.get(name).unwrap_or_else(|| panic!("{name} among {:?}", asset.textures.keys()));
    let bytes = match file {
        crate::TextureFile::InMemory(bytes) => bytes.to_vec(),
        crate::TextureFile::OnDisk(path) => std::fs::read(path).expect("a file"),
    };
    image::load_from_memory(&bytes).expect("a picture").into_rgba8()
}

/// The object of that name.
pub(super) fn object<'a>(asset: &'a Asset, name: &str) -> &'a Object {
    let objects = asset.document.objects();
    let found = objects.iter().find(|object| object.name == *name);
    found.unwrap_or_else(|| panic!("{name} among {:?}", objects.iter().map(|o| &o.name).collect::<Vec<_>>()))
}

/// The single material at a position.
pub(super) fn single(asset: &Asset, at: usize) -> &SingleMaterial {
    match &asset.document.materials[at].body {
        MaterialBody::Single(single) => single,
        MaterialBody::Multi(_) => panic!("material {at} is Multi"),
    }
}

/// Whether the report has a line of this outcome about a property.
pub(super) fn reported(asset: &Asset, outcome: Outcome, property: &str) -> bool {
    asset.report.changes.iter().any(|change| change.outcome == outcome && change.property == property)
}

/// The notes and sizes of the report's lines about a property.
pub(super) fn notes(asset: &Asset, property: &str) -> String {
    let lines = asset.report.changes.iter().filter(|change| change.property == property);
    lines.map(|change| format!("{} {}\n", change.note, change.size.as_deref().unwrap_or(""))).collect()
}

/// Triangles as positions.
pub(super) fn corners(object: &Object) -> Vec<[[f32; 3]; 3]> {
    let faces = object.faces.as_ref().expect("faces");
    let at = |vertex: u32| object.vertices[vertex as usize];
    faces.triangles.iter().map(|triangle| triangle.vertices.map(at)).collect()
}

/// Asserts that numbers are equal within a bound.
#[track_caller]
pub(super) fn assert_near<const N: usize>(found: [f32; N], wanted: [f32; N], bound: f32) {
    let near = found.iter().zip(wanted).all(|(a, b)| (a - b).abs() <= bound);
    assert!(near, "{found:?} is not {wanted:?} within {bound}");
}

/// The corpus folder, if there is one.
pub(super) fn corpus(file: &str) -> Option<PathBuf> {
    match std::env::var_os("AAM_CORPUS") {
        Some(folder) => Some(PathBuf::from(folder).join("gltf").join(file)),
        None => {
            println!("skipped: AAM_CORPUS is not set");
            None
        }
    }
}
