//! Validity: of what is made in code, and of every real file.

use std::collections::BTreeMap;
use std::path::PathBuf;

use aam::document::{Layer, NormalSpace};
use aam_convert::{Asset, ImportOptions, Silent, TextureFile, import};
use aam_scene::{Camera, Falloff, Light, LightKind, Projection};
use glam::Vec3;

use crate::documents::*;
use crate::validator::{Verdict, validate};
use crate::{asset, export_to, png};

/// Prints what the validator says and fails on any error. Warnings must be of the kinds in `allowed`.
fn judge(verdicts: &[Verdict], allowed: &[&str]) {
    let mut counts: BTreeMap<(u8, &str), usize> = BTreeMap::new();
    let mut faults = Vec::new();
    for verdict in verdicts {
        for message in &verdict.messages {
            *counts.entry((message.severity, &message.code)).or_default() += 1;
            if message.severity == 0 || message.severity == 1 && !allowed.contains(&message.code.as_str()) {
                faults.push(format!(
                    "{}: {} {} {}",
                    verdict.file.display(),
                    message.code,
                    message.pointer,
                    message.message
                ));
            }
        }
    }
    let sum = |of: fn(&Verdict) -> usize| verdicts.iter().map(of).sum::<usize>();
    println!("{} files: {} errors, {} warnings", verdicts.len(), sum(|v| v.errors), sum(|v| v.warnings));
    for ((severity, code), count) in counts {
        println!("  {} {code}: {count}", ["error", "warning", "information", "hint"][usize::from(severity)]);
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn what_is_made_in_code_is_valid() {
    let light_mapped = || {
        let material = single("room", |single| {
            texture(single, Layer::Diffuse, "d.png", |texture| texture.tiling = [3.0, 2.0]);
            texture(single, Layer::LightMap, "l.png", |_| {});
            texture(single, Layer::Displacement, "h.png", |_| {});
        });
        document(vec![material], vec![block(0, "room", [0.0; 3], [2.0; 3], 3)])
    };
    let normal_mapped = |space: NormalSpace| {
        let material = single("bumpy", |single| {
            texture(single, Layer::Diffuse, "d.png", |texture| texture.rotation = [0.0, 0.0, 0.5]);
            texture(single, Layer::Normal, "n.png", |texture| texture.normal_space = Some(space));
        });
        document(vec![material], vec![block(0, "box", [0.0; 3], [1.0; 3], 2)])
    };
    let unlit = document(
        vec![single("sign", |single| {
            (single.ambient, single.diffuse, single.specular) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            single.emission = Some([1.0, 0.9, 0.2]);
        })],
        vec![ball(0, "sign", 1.0)],
    );
    let textures = [
        ("d.png", png(8, 8, |x, y| [(30 * x) as u8, (30 * y) as u8, 90, if x == 0 { 0 } else { 255 }])),
        ("l.png", png(8, 8, |x, _| [(30 * x) as u8; 4])),
        ("n.png", png(8, 8, |_, _| [128, 128, 255, 255])),
        ("h.png", png(4, 4, |_, _| [128; 4])),
    ];
    let mut lit = asset(hierarchy(), &[]);
    lit.lights = vec![
        Light {
            name: "sun".into(),
            kind: LightKind::Directional { direction: Vec3::new(1.0, 1.0, -1.0) },
            ambient: Vec3::splat(0.2),
            diffuse: Vec3::ONE,
            specular: Vec3::ONE,
            shape: None,
        },
        Light {
            name: "lamp".into(),
            kind: LightKind::Spot {
                position: Vec3::Z,
                direction: Vec3::NEG_Z,
                inner: 1.0,
                outer: 1.0,
                falloff: Falloff::None,
            },
            ambient: Vec3::ZERO,
            diffuse: Vec3::new(2.0, 1.0, 0.0),
            specular: Vec3::ONE,
            shape: None,
        },
    ];
    let camera = |projection| Camera {
        name: "view".into(),
        position: Vec3::new(1.0, 2.0, 3.0),
        target: Vec3::ZERO,
        up: Vec3::Z,
        projection,
        near: 0.1,
        far: 10.0,
    };
    lit.cameras =
        vec![camera(Projection::Perspective { fov_y: 0.7 }), camera(Projection::Orthographic { height: 4.0 })];
    let cases = [
        ("empty", asset(aam::Document::default(), &[])),
        ("hierarchy", lit),
        ("character", asset(character(), &[])),
        ("multiframe", asset(multiframe(), &[])),
        ("materials", asset(several_materials(), &[])),
        ("physics", asset(physics(), &[])),
        ("light-map", asset(light_mapped(), &textures)),
        ("object-normals", asset(normal_mapped(NormalSpace::Object), &textures)),
        ("tangent-normals", asset(normal_mapped(NormalSpace::Tangent), &textures)),
        ("unlit", asset(unlit, &[])),
    ];
    let folder = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    for (name, asset) in &cases {
        for extension in ["glb", "gltf"] {
            let subfolder = folder.path().join(format!("{name}-{extension}"));
            std::fs::create_dir(&subfolder).unwrap();
            files.push(export_to(&subfolder, &format!("{name}.{extension}"), asset).unwrap().0);
        }
    }
    if let Some(verdicts) = validate(&files) {
        assert_eq!(verdicts.len(), files.len());
        judge(&verdicts, &[]);
    }
}

/// The files of a folder of the corpus that have one of these extensions; `None`, said aloud, without a corpus.
pub(crate) fn corpus(folder: &str, extensions: &[&str]) -> Option<Vec<PathBuf>> {
    let Some(corpus) = std::env::var_os("AAM_CORPUS") else {
        println!("skipped: AAM_CORPUS is not set");
        return None;
    };
    let mut folders = vec![PathBuf::from(corpus).join(folder)];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
            if path.is_dir() {
                folders.push(path);
            } else if extension.is_some_and(|extension| extensions.contains(&&*extension)) {
                files.push(path);
            }
        }
    }
    files.sort();
    Some(files)
}

fn export_all(assets: impl Iterator<Item = (PathBuf, Asset)>, allowed: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    for (source, asset) in assets {
        let name = format!("{}.glb", source.file_stem().unwrap().to_string_lossy());
        files.push(export_to(folder.path(), &name, &asset).unwrap().0);
    }
    if let Some(verdicts) = validate(&files) {
        assert_eq!(verdicts.len(), files.len());
        judge(&verdicts, allowed);
    }
}

#[test]
fn every_real_file_is_valid() {
    let Some(sources) = corpus("aam", &["aam"]) else { return };
    assert!(sources.len() > 40);
    export_all(
        sources.into_iter().map(|source| {
            let asset = import(&source, &ImportOptions::default(), &Silent).unwrap();
            (source, asset)
        }),
        &[],
    );
}

/// Real files come without their textures, so here they get some: light maps then meet real coordinates.
#[test]
fn every_real_file_with_textures_is_valid() {
    let Some(sources) = corpus("aam", &["aam"]) else { return };
    let picture = png(64, 64, |x, y| [(4 * x) as u8, (4 * y) as u8, 128, 255]);
    export_all(
        sources.into_iter().map(|source| {
            let mut asset = import(&source, &ImportOptions::default(), &Silent).unwrap();
            for leaf in aam::meaning::Materials::of(&asset.document).leaves() {
                for layer in leaf.layers.iter().flatten() {
                    asset.textures.insert(layer.file.clone(), TextureFile::InMemory(picture.clone().into()));
                }
            }
            (source, asset)
        }),
        &[],
    );
}

#[test]
fn every_real_gltf_is_valid_after_a_visit_to_aam() {
    let Some(sources) = corpus("gltf", &["gltf", "glb"]) else { return };
    let import_as = |source: PathBuf, hierarchy: bool| {
        let options = ImportOptions { hierarchy, ..ImportOptions::default() };
        let asset = import(&source, &options, &Silent).unwrap();
        (source, asset)
    };
    // Some of their pictures have colour profiles; pictures are copied as they are.
    let allowed = ["IMAGE_FEATURES_UNSUPPORTED"];
    export_all(sources.iter().map(|source| import_as(source.clone(), false)), &allowed);
    export_all(sources.iter().map(|source| import_as(source.clone(), true)), &allowed);
}
