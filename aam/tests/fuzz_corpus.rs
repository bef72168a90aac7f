//! What the fuzz targets of this crate have collected, run again: no panic, and the same promises.

#[path = "../../fuzz/bodies/format.rs"]
mod bodies;

use std::path::Path;

/// Runs a target over folders.
fn replay(folders: &[&str], run: impl Fn(&[u8])) {
    folders.iter().for_each(|folder| replay_folder(folder, &run));
}

fn replay_folder(target: &str, run: impl Fn(&[u8])) {
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
fn read_ascii() {
    replay(&["read_ascii"], bodies::read_ascii);
}

#[test]
fn read_binary() {
    replay(&["read_binary"], bodies::read_binary);
}

#[test]
fn read_write_read() {
    replay(&["read_ascii", "read_write_read"], bodies::read_write_read);
}

#[test]
fn check() {
    replay(&["read_ascii", "check"], bodies::check);
}
