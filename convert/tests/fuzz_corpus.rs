//! What the fuzz targets of the importers and of the hulls have collected, run again: no panic, and the same promises.

#[path = "../../fuzz/bodies/convert.rs"]
mod bodies;

use std::path::Path;

/// Runs a target over its folder.
fn replay(target: &str, run: impl Fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus").join(target);
    let mut files: Vec<_> = std::fs::read_dir(&folder)
        .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    assert!(!files.is_empty(), "{} is empty", folder.display());
    for file in files {
        println!("{}", file.display());
        run(&std::fs::read(&file).unwrap());
    }
}

#[test]
fn gltf_import() {
    replay("gltf_import", bodies::gltf_import);
}

#[test]
fn obj_import() {
    let folder = tempfile::tempdir().unwrap();
    bodies::prepare(folder.path());
    replay("obj_import", |data| bodies::obj_import(folder.path(), data));
}

#[test]
fn stl_import() {
    replay("stl_import", bodies::stl_import);
}

#[test]
fn ply_import() {
    replay("ply_import", bodies::ply_import);
}

#[test]
fn hulls() {
    replay("hulls", bodies::hulls);
}

#[test]
fn pieces() {
    replay("pieces", bodies::pieces);
}
