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

/// The tokens of a BINARY file: those of its text, and the words of 32 bits of its lists, in order.
fn binary_tokens(bytes: &[u8]) -> Vec<Result<u32, &[u8]>> {
    /// What ends the text before data, and the words of data for each of the rows that it announces.
    const LISTS: [(&[u8], usize); 4] = [(b"\tV_List: ", 3), (b"C_List: ", 3), (b"N_List: ", 3), (b"TV_List: ", 2)];
    const ROWS: [(&[u8], usize); 3] = [(b"\nTI: ", 3), (b"\nNI: ", 3), (b"I: ", 4)];
    let (mut found, mut text, mut at) = (Vec::new(), 0, 0);
    while at < bytes.len() {
        let rest = &bytes[at..];
        let list = LISTS.iter().find(|(tag, _)| rest.starts_with(tag)).map(|(tag, words)| {
            let line = rest.iter().position(|&byte| byte == b'\n').expect("a line end") + 1;
            let count = std::str::from_utf8(&rest[tag.len()..line]).expect("text").trim();
            (line, words * count.parse::<usize>().expect("a count"))
        });
        // `SI: ` of a material is none: a row follows the line of its group, or data.
        let starts = at == text || bytes[at] == b'\n' || bytes[at - 1] == b'\n';
        let row = || {
            let row = ROWS.iter().find(|(tag, _)| starts && rest.starts_with(tag));
            row.map(|(tag, words)| (tag.len(), *words))
        };
        match list.or_else(row) {
            Some((skipped, words)) => {
                let (start, end) = (at + skipped, at + skipped + 4 * words);
                found.extend(tokens(&bytes[text..start]));
                let word = |word: &[u8]| Ok(u32::from_le_bytes(word.try_into().expect("four bytes")));
                found.extend(bytes[start..end].chunks(4).map(word));
                (text, at) = (end, end);
            }
            None => at += 1,
        }
    }
    found.extend(tokens(&bytes[text..]));
    found
}

/// Equal tokens, apart from so many `}` that only the first has.
fn assert_same_but_braces(name: &str, before: &[Result<u32, &[u8]>], after: &[Result<u32, &[u8]>], braces: usize) {
    assert!(after.len() > 100, "{name}: {} tokens", after.len());
    let (mut given, mut skipped) = (before.iter(), 0);
    for (number, wanted) in after.iter().enumerate() {
        while given.next().expect("as many tokens") != wanted {
            skipped += 1;
            let place = number + skipped - 1;
            assert!(before[place] == Err(b"}") && skipped <= braces, "{name}: token {place}: {:?}", before[place]);
        }
    }
    skipped += given.map(|token| assert_eq!(*token, Err(&b"}"[..]), "{name}: tokens are missing")).count();
    assert_eq!(skipped, braces, "{name}: stray braces");
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
        let (before, after) = match first.document.encoding {
            Encoding::Ascii => (tokens(&bytes), tokens(&written)),
            Encoding::Binary => (binary_tokens(&bytes), binary_tokens(&written)),
        };
        assert_same_but_braces(&name, &before, &after, stray);
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
