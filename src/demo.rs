//! The scenes of the shadow-mapping demo, which `aam view --demo` brings along.

use std::path::PathBuf;

use tempfile::TempDir;

use crate::failure::Failure;

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/assets/", $name)).as_slice())),*]
    };
}

const FILES: [(&str, &[u8]); 8] = files![
    "demo-torus.scene.toml",
    "demo-torus.aam",
    "demo-spheres.scene.toml",
    "demo-spheres-base.aam",
    "demo-spheres-green.aam",
    "demo-spheres-red.aam",
    "demo-teapot.scene.toml",
    "demo-teapot.aam",
];

/// The demo's scenes in a folder that goes away with the value.
pub(crate) struct Demo {
    folder: TempDir,
}

impl Demo {
    pub(crate) fn unpack() -> Result<Self, Failure> {
        let folder = tempfile::Builder::new()
            .prefix("aam-demo-")
            .tempdir()
            .map_err(|error| Failure::io(&std::env::temp_dir(), "make a folder in", &error))?;
        for (name, bytes) in FILES {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).map_err(|error| Failure::io(&path, "write", &error))?;
        }
        Ok(Self { folder })
    }

    /// The scenes in their order.
    pub(crate) fn scenes(&self) -> Vec<PathBuf> {
        let scenes = FILES.iter().filter(|(name, _)| name.ends_with(aam_scene::SCENE_EXTENSION));
        scenes.map(|(name, _)| self.folder.path().join(name)).collect()
    }
}
