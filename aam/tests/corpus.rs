//! Every real file reads, and comes back from the writer the same: an equal document and the same tokens.

use std::path::PathBuf;

use aam::document::Encoding;
use aam::{ReadOptions, WriteOptions, read, write};

fn corpus() -> Option<Vec<PathBuf>> {
    let Some(folder) = std::env::var_os("AAM_CORPUS") else {
        println!("skipped: AAM_CORPUS is not set");
        return None;
    };
    let folder = PathBuf::from(folder).join("aam");
    let mut files: Vec<PathBuf> = std::fs::read_dir(&folder)
        .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
        .map(|entry| entry.expect("an entry").path())
        .collect();
    files.sort();
    assert!(!files.is_empty(), "{} is empty", folder.display());
    Some(files)
}

/// White-space separated tokens; numbers by their `f32` bits.
fn tokens(bytes: &[u8]) -> Vec<Result<u32, &[u8]>> {
    bytes
        .split(u8::is_ascii_whitespace)
        .filter(|token| !token.is_empty())
        .map(|token| {
            std::str::from_utf8(token).ok().and_then(|text| text.parse::<f32>().ok()).map(f32::to_bits).ok_or(token)
        })
        .collect()
}

#[test]
fn real_files_round_trip() {
    let Some(files) = corpus() else { return };
    for path in files {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let bytes = std::fs::read(&path).expect("a readable file");
        let first = read(&bytes, &ReadOptions::default()).unwrap_or_else(|error| panic!("{name}:{error}"));
        let written =
            write(&first.document, &WriteOptions::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
        let second = read(&written, &ReadOptions { strict: true, ..ReadOptions::default() })
            .unwrap_or_else(|error| panic!("{name} written again:{error}"));
        assert!(first.document == second.document, "{name}: the document changed");

        let stray = first.findings.iter().filter(|finding| finding.code == "syntax/stray-brace").count();
        let clean = first.findings.is_empty();
        let strict = read(&bytes, &ReadOptions { strict: true, ..ReadOptions::default() });
        assert_eq!(strict.is_ok(), clean, "{name}: strict mode refuses what the default warns of: {strict:?}");
        if name.contains("lamborghini3") {
            assert_eq!((stray, first.findings.len()), (4, 4), "{name}: {:?}", first.findings);
        } else {
            assert!(clean, "{name}: {:?}", first.findings);
        }
        if first.document.encoding == Encoding::Ascii {
            let (before, after) = (tokens(&bytes), tokens(&written));
            assert_eq!(before.len(), after.len() + stray, "{name}: number of tokens");
            if stray == 0 {
                assert!(before == after, "{name}: tokens differ");
            }
        }
        // The other encoding holds the same document.
        let other = match first.document.encoding {
            Encoding::Ascii => Encoding::Binary,
            Encoding::Binary => Encoding::Ascii,
        };
        let options = WriteOptions { encoding: Some(other), crlf: true, digits: None };
        let turned = write(&first.document, &options).expect("writable");
        let mut back = read(&turned, &ReadOptions { strict: true, ..ReadOptions::default() })
            .unwrap_or_else(|error| panic!("{name} as {other:?}:{error}"))
            .document;
        assert_eq!(back.encoding, other);
        back.encoding = first.document.encoding;
        assert!(back == first.document, "{name}: the document changed as {other:?}");
    }
}

/// A BINARY file's bulk bytes are the same bytes, and its text the same tokens.
#[test]
fn the_binary_file_keeps_its_bytes() {
    let Some(files) = corpus() else { return };
    let path = files.into_iter().find(|path| path.to_string_lossy().ends_with("lamborghini.aam")).expect("the file");
    let bytes = std::fs::read(path).expect("a readable file");
    let document = read(&bytes, &ReadOptions::default()).expect("a readable document").document;
    let written = write(&document, &WriteOptions::default()).expect("writable");
    // Text parts differ only in decimals (`1.0000`) and blanks; counted in bytes of data both are the same.
    let lists = |bytes: &[u8]| bytes.windows(4).filter(|window| matches!(*window, b"I: \0" | b"TI: ")).count();
    assert_eq!(lists(&bytes), lists(&written));
    let again = write(&read(&written, &ReadOptions::default()).expect("readable").document, &WriteOptions::default());
    assert_eq!(again.expect("writable"), written, "writing is a fixed point");
}
