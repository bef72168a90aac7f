#![no_main]

#[path = "../bodies/convert.rs"]
mod convert;

use std::path::PathBuf;
use std::sync::LazyLock;

static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder for temporary files").keep();
    convert::prepare(&folder);
    folder
});

libfuzzer_sys::fuzz_target!(|data: &[u8]| convert::obj_import(&FOLDER, data));
