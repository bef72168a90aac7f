//! Scenes from files, as the command opens them.

use std::path::Path;

use aam_convert::{Asset, Format, ImportOptions, Silent};
use aam_scene::{BuildOptions, Camera, FolderTextures, FoundTexture, Scene, SceneFile, Shading, TextureSource};

use crate::LabError;

/// A scene from an asset or a scene file, and the camera that the file looks through first.
///
/// # Errors
/// A file cannot be read, or is not what its extension says.
pub fn load(path: &Path) -> Result<(Scene, Option<Camera>), LabError> {
    if !SceneFile::is_one(path) {
        return Ok((asset(path)?, None));
    }
    let file = SceneFile::read(path)?;
    let parts = file.asset_paths(path).iter().map(|path| asset(path)).collect::<Result<_, _>>()?;
    let scene = file.assemble(parts, path).scene;
    let camera = file.active(&scene).cloned();
    Ok((scene, camera))
}

fn asset(path: &Path) -> Result<Scene, LabError> {
    let asset = aam_convert::import(path, &ImportOptions::default(), &Silent)?;
    let textures = Textures { asset: &asset, folder: FolderTextures::beside(path) };
    let mut scene = aam_scene::build(&asset.document, &textures, &BuildOptions::default()).scene;
    scene.lights.extend(asset.lights.iter().cloned());
    scene.cameras.extend(asset.cameras.iter().cloned());
    if matches!(Format::of(path), Some(Format::Gltf | Format::Glb)) {
        scene.shading = Shading::Linear;
    }
    Ok(scene)
}

/// What the importer brought along, else what lies beside the file.
struct Textures<'a> {
    asset: &'a Asset,
    folder: FolderTextures,
}

impl TextureSource for Textures<'_> {
    fn find(&self, name: &str) -> Result<FoundTexture, String> {
        self.asset.find(name).or_else(|_| self.folder.find(name))
    }

    fn limits(&self) -> aam::Limits {
        self.folder.limits()
    }
}
