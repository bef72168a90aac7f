//! AAM files as assets.

use std::collections::BTreeSet;
use std::path::Path;

use aam::document::{Flagged, MaterialBody, SingleMaterial};
use aam::{Document, ReadOptions, Severity};
use aam_scene::{AssetEntry, FolderTextures, SceneFile, TextureData, TextureSource, Up};

use crate::files::{Files, within};
use crate::{Asset, ConvertError, ExportOptions, ImportOptions, TextureFile, original};

/// Reads an AAM file; its textures are those in its folder.
pub(crate) fn import(path: &Path, options: &ImportOptions) -> Result<Asset, ConvertError> {
    let read = ReadOptions { max_file_size: options.max_file_size, ..ReadOptions::default() };
    let outcome = aam::read_file(path, &read)?;
    let mut asset = Asset { document: outcome.document, ..Asset::default() };
    for finding in outcome.findings.iter().filter(|finding| finding.severity >= Severity::Warning) {
        asset.report.changed(&finding.subject, "syntax", finding.to_string(), None);
    }
    let mut folder = FolderTextures::beside(path);
    folder.allow_outside = options.allow_outside;
    for name in texture_names(&asset.document) {
        match folder.find(&name) {
            Ok(found) => {
                let file = match found.data {
                    TextureData::OnDisk(path) => TextureFile::OnDisk(path),
                    TextureData::InMemory(bytes) => TextureFile::InMemory(bytes),
                };
                asset.textures.insert(name, file);
            }
            Err(reason) => asset.report.lost("", "texture", reason),
        }
    }
    Ok(asset)
}

/// The AAM file of an asset, with its textures and, where it has lights or cameras, a scene file.
pub(crate) fn export(asset: &Asset, path: &Path, options: &ExportOptions) -> Result<Files, ConvertError> {
    let mut files = Files::default();
    let mut document = asset.document.clone();
    if options.original {
        original::strip(&mut document, &mut files.report);
    }
    files.main = aam::write(&document, &options.write)
        .map_err(|error| ConvertError::Option(format!("{} cannot be written: {error}", path.display())))?;
    add_textures(&document, asset, &mut files);
    add_scene_file(asset, path, &mut files)?;
    Ok(files)
}

/// Lights and cameras have no place in an AAM file.
fn add_scene_file(asset: &Asset, path: &Path, files: &mut Files) -> Result<(), ConvertError> {
    let target = SceneFile::path_beside(path);
    let (Some(main), Some(name)) = (path.file_name(), target.file_name()) else { return Ok(()) };
    if asset.lights.is_empty() && asset.cameras.is_empty() {
        return Ok(());
    }
    let name = name.to_string_lossy().into_owned();
    let scene = SceneFile {
        up: Some(Up::Z),
        shading: asset.shading,
        assets: vec![AssetEntry::new(main)],
        lights: (!asset.lights.is_empty()).then(|| asset.lights.clone()),
        cameras: asset.cameras.clone(),
        ..SceneFile::default()
    };
    let text = scene.to_text().map_err(|reason| ConvertError::Option(format!("{name} cannot be written: {reason}")))?;
    let what = format!("{} lights and {} cameras are in {name}", asset.lights.len(), asset.cameras.len());
    files.report.kept("", "lights and cameras", what);
    files.beside.insert(name, TextureFile::InMemory(text.into_bytes().into()));
    Ok(())
}

/// The textures that a document names go beside it under these names.
fn add_textures(document: &Document, asset: &Asset, files: &mut Files) {
    for name in texture_names(document) {
        let Some(file) = asset.textures.get(&name) else { continue };
        if within(&name).is_some() {
            files.beside.insert(name, file.clone());
        } else {
            files.report.changed("", "texture", format!("\"{name}\" is not copied: it leads out of the folder"), None);
        }
    }
}

/// The files that a document's materials name, each once, in order of first use.
pub(crate) fn texture_names(document: &Document) -> Vec<String> {
    let mut names = Vec::new();
    let mut known = BTreeSet::new();
    for_each_single(document, |_, single| {
        for texture in single.layers.iter().filter_map(Flagged::as_ref) {
            let name = texture.file.decoded();
            if known.insert(name.clone()) {
                names.push(name);
            }
        }
    });
    names
}

/// Calls for each single material, its name first, Multi ones flattened in file order.
pub(crate) fn for_each_single<'a>(document: &'a Document, mut call: impl FnMut(&'a aam::Text, &'a SingleMaterial)) {
    let mut pending: Vec<_> = document.materials.iter().rev().collect();
    while let Some(material) = pending.pop() {
        match &material.body {
            MaterialBody::Multi(subs) => pending.extend(subs.iter().rev()),
            MaterialBody::Single(single) => call(&material.name, single),
        }
    }
}
