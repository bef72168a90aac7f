//! Real files.

use std::path::{Path, PathBuf};

use aam_renderer::{Msaa, RenderOptions};
use aam_scene::*;

use crate::common::*;

/// The corpus's AAM files in order, or nothing where there is no corpus.
fn files() -> Vec<PathBuf> {
    let Some(corpus) = std::env::var_os("AAM_CORPUS") else {
        println!("skipped: AAM_CORPUS is not set");
        return Vec::new();
    };
    let folder = std::fs::read_dir(Path::new(&corpus).join("aam")).expect("a folder aam in AAM_CORPUS");
    let mut files: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("aam")));
    files.sort();
    assert!(!files.is_empty());
    files
}

#[test]
fn every_file_gives_a_picture() {
    let Some(mut renderer) = renderer() else { return };
    for path in files() {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let read = aam::read_file(&path, &aam::ReadOptions::default()).unwrap();
        let built = build(&read.document, &FolderTextures::beside(&path), &BuildOptions::default());
        let options = RenderOptions { msaa: Msaa::X4, background: None, ..options() };
        let camera = built.scene.fitting_camera(4.0 / 3.0);
        let triangles: usize = built.scene.meshes.iter().map(|mesh| mesh.indices.len() / 3).sum();
        let picture = draw_sized(&mut renderer, &built.scene, &camera, &options, 256, 192);
        let background = picture.at(0, 0);
        let covered = picture.bytes.chunks(4).filter(|pixel| *pixel != background).count();
        println!(
            "{name}: {triangles} triangles, {} draws, {} pixels, {:.0} ms up, {:.1} ms sort, {:.1} ms draw, {} pipelines",
            picture.stats.draws,
            covered,
            picture.stats.cpu.upload_ms,
            picture.stats.cpu.sort_ms,
            picture.stats.gpu_ms().unwrap_or_default(),
            picture.stats.pipelines_built,
        );
        // A fitting camera fills a good part of the picture, unless what it sees is invisible.
        let visible = built.scene.materials.iter().any(|material| material.opacity > 0.0);
        assert!(covered > 500 || !visible, "{name}: {covered} pixels");
        picture.save(&name);
    }
}
