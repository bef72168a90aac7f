//! AAM files as assets.

use std::collections::BTreeSet;
use std::path::Path;

use aam::document::{Flagged, MaterialBody, SingleMaterial};
use aam::{Document, FileError, ReadOptions, Severity};
use aam_scene::{AssetEntry, FolderTextures, SceneFile, TextureData, TextureSource, Up};

use crate::files::{Files, within};
use crate::{Asset, ConvertError, ExportOptions, ImportOptions, TextureFile, original};

/// Reads the bytes of an AAM file; its textures are those in the folder of `path`.
pub(crate) fn import(bytes: &[u8], path: &Path, options: &ImportOptions) -> Result<Asset, ConvertError> {
    let read = ReadOptions { limits: options.limits, ..ReadOptions::default() };
    let outcome = aam::read(bytes, &read)
        .map_err(|source| FileError::Syntax { path: path.to_owned(), source: Box::new(source) })?;
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
            Err(reason) => asset.report.lost("", "texture", format!("{name}: {reason}")),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Silent, export as export_file, import as import_file};
    use aam_scene::{Camera, Falloff, Light, LightKind, Projection, Shading};
    use glam::Vec3;

    #[test]
    fn lights_and_cameras_go_to_a_scene_file() {
        let light = Light {
            name: "lamp".into(),
            kind: LightKind::Point { position: Vec3::new(1.0, 2.0, 3.0), falloff: Falloff::InverseSquare },
            ambient: Vec3::ZERO,
            diffuse: Vec3::new(4.0, 3.0, 2.0),
            specular: Vec3::ONE,
            shape: None,
        };
        let camera = Camera {
            name: "front".into(),
            position: Vec3::NEG_Y,
            target: Vec3::ZERO,
            up: Vec3::Z,
            projection: Projection::Perspective { fov_y: 0.5 },
            near: 0.1,
            far: 10.0,
        };
        let document = Document {
            geometry: aam::document::Geometry { frames: vec![aam::document::Frame::default()], ..Default::default() },
            ..Document::default()
        };
        let asset = Asset {
            document,
            lights: vec![light.clone()],
            cameras: vec![camera],
            shading: Some(Shading::Linear),
            ..Asset::default()
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("my model.aam");
        export_file(&asset, &path, &ExportOptions::default()).unwrap();
        let scene = SceneFile::read(&folder.path().join("my model.scene.toml")).unwrap();
        assert_eq!(scene.lights, Some(vec![light]));
        assert_eq!(scene.cameras.len(), 1);
        assert_eq!(scene.shading, Some(Shading::Linear));
        assert_eq!(scene.asset_paths(&folder.path().join("my model.scene.toml")), std::slice::from_ref(&path));
        // One that was edited since is not replaced without being asked.
        std::fs::write(folder.path().join("my model.scene.toml"), "# mine\n").unwrap();
        let error = export_file(&asset, &path, &ExportOptions::default()).unwrap_err().to_string();
        assert!(error.contains("my model.scene.toml: exists with other content"), "{error}");
        let force = ExportOptions { overwrite: true, ..ExportOptions::default() };
        export_file(&asset, &path, &force).unwrap();

        // Nothing of that without lights and cameras.
        let plain = Asset { document: asset.document, ..Asset::default() };
        let report = export_file(&plain, &folder.path().join("plain.aam"), &ExportOptions::default()).unwrap();
        assert_eq!(report.changes, []);
        assert!(!folder.path().join("plain.scene.toml").exists());
    }

    #[test]
    fn textures_are_found_beside_and_missing_ones_reported() {
        let folder = tempfile::tempdir().unwrap();
        let mut document = Document::default();
        for (number, file) in [(0, "maps\\Wood.PNG"), (1, "../up.png"), (2, "none.png")] {
            let mut single = SingleMaterial { class: "Standard".into(), ..SingleMaterial::default() };
            single.layers[0] = Flagged::Yes(Box::new(aam::document::Texture::new(file)));
            document.materials.push(aam::document::Material {
                number,
                name: "m".into(),
                body: MaterialBody::Single(Box::new(single)),
                unknown: Vec::new(),
            });
        }
        document.geometry.frames.push(aam::document::Frame::default());
        let inner = folder.path().join("in");
        std::fs::create_dir_all(inner.join("maps")).unwrap();
        std::fs::write(inner.join("maps/wood.png"), "w").unwrap();
        std::fs::write(folder.path().join("up.png"), "u").unwrap();
        aam::write_file(&inner.join("m.aam"), &document, &aam::WriteOptions::default()).unwrap();

        let asset = import_file(&inner.join("m.aam"), &ImportOptions::default(), &Silent).unwrap();
        assert_eq!(asset.textures.keys().collect::<Vec<_>>(), ["maps\\Wood.PNG"]);
        let lost: Vec<&str> = asset.report.changes.iter().map(|change| change.note.as_str()).collect();
        assert!(lost.len() == 2 && lost[0].starts_with("../up.png: ") && lost[1].starts_with("none.png: "), "{lost:?}");
        // On the way out the name leads to the same place on every system.
        export_file(&asset, &folder.path().join("out/m.aam"), &ExportOptions::default()).unwrap();
        assert_eq!(std::fs::read(folder.path().join("out/maps/Wood.PNG")).unwrap(), b"w");

        let outside = ImportOptions { allow_outside: true, ..ImportOptions::default() };
        let asset = import_file(&inner.join("m.aam"), &outside, &Silent).unwrap();
        assert_eq!(asset.textures.len(), 2);
        let report = export_file(&asset, &folder.path().join("far/m.aam"), &ExportOptions::default()).unwrap();
        assert!(report.changes.iter().any(|change| change.note.contains("\"../up.png\" is not copied")));
    }
}
