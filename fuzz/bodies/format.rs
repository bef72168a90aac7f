//! What the fuzz targets of the format crate do with their bytes, and what must hold of it.

#![allow(dead_code, reason = "each target uses one of these")]

use aam::document::Encoding;
use aam::meaning::{Hierarchy, Materials, ObjectMesh, SmoothingRule, Summary, frame_range, world_transforms};
use aam::{Document, ReadOptions, WriteOptions, read, write};

#[path = "../../aam/tests/support/mod.rs"]
mod support;

/// Reads a file; where it is accepted, strict mode must refuse just what there is a warning of.
fn both(bytes: &[u8]) {
    match read(bytes, &ReadOptions::default()) {
        Ok(outcome) => {
            let strict = read(bytes, &ReadOptions { strict: true, ..ReadOptions::default() });
            match strict {
                Ok(strict) => assert!(strict == outcome && outcome.findings.is_empty()),
                Err(refused) => assert!(outcome.findings.iter().any(|finding| finding.code == refused.code)),
            }
        }
        Err(error) => {
            assert!(error.offset <= bytes.len());
            assert!(!error.to_string().is_empty());
        }
    }
}

/// Reads the bytes as they are.
pub(crate) fn read_ascii(data: &[u8]) {
    both(data);
}

/// Reads the bytes as what follows `BINARY`.
pub(crate) fn read_binary(data: &[u8]) {
    both(&[b"BINARY\n", data].concat());
}

/// What the bytes hold, or where they are no file a document made of them, is written and read back in both encodings.
pub(crate) fn read_write_read(data: &[u8]) {
    let (document, finite) = match read(data, &ReadOptions::default()) {
        Ok(outcome) => {
            let finite = outcome.findings.iter().all(|finding| finding.code != "value/not-finite");
            (outcome.document, finite)
        }
        Err(_) => (support::Choices(data).document(), true),
    };
    let written = |document: &Document, encoding| {
        write(document, &WriteOptions { encoding: Some(encoding), ..WriteOptions::default() })
    };
    let binary = match written(&document, Encoding::Binary) {
        Ok(bytes) => Some(bytes),
        Err(error) => {
            assert!(error.subject == "unknown text" && document.encoding == Encoding::Ascii, "{error}");
            None
        }
    };
    let ascii = written(&document, Encoding::Ascii).expect("what was read can be written");
    for (bytes, encoding) in [(binary.as_ref(), Encoding::Binary), (Some(&ascii), Encoding::Ascii)] {
        let Some(bytes) = bytes else { continue };
        let back = read(bytes, &ReadOptions::default()).expect("what was written can be read").document;
        assert_eq!(back.encoding, encoding);
        // The payload of a NaN has no decimal.
        match &binary {
            Some(binary) if finite => {
                assert!(written(&back, Encoding::Binary).as_ref() == Ok(binary), "every bit is kept");
            }
            _ => assert!(written(&back, encoding).as_ref() == Ok(bytes), "writing is a fixed point"),
        }
    }
}

/// Checks what the bytes hold and works out what it means.
pub(crate) fn check(data: &[u8]) {
    let Ok(outcome) = read(data, &ReadOptions::default()) else { return };
    let document = &outcome.document;
    for finding in aam::check(document, Some((data, &outcome.places))) {
        assert!(aam::check::code_info(finding.code).is_some(), "{} is in no table", finding.code);
    }
    let _ = Summary::of(document);
    let hierarchy = Hierarchy::of(document.objects());
    assert_eq!(hierarchy.order.len(), document.objects().len());
    let (first, last) = frame_range(document).unwrap_or((0.0, 0.0));
    for frame in [first, 0.5 * (first + last), last] {
        let _ = world_transforms(document, &hierarchy, frame);
    }
    let materials = Materials::of(document);
    for object in document.objects() {
        for rule in [SmoothingRule::Masks, SmoothingRule::Numbers] {
            let mesh = ObjectMesh::of(object, &materials, rule);
            let _ = mesh.tangents(object, &materials, |_| true);
        }
    }
}
