//! Faults of the GLB container and of the JSON text.

use super::*;

const JSON: &[u8; 4] = b"JSON";
const BINARY: &[u8; 4] = b"BIN\0";

/// A GLB file of chunks, with the length that it has.
fn glb(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut bytes = [b"glTF".as_slice(), &word(2), &word(0)].concat();
    for (kind, data) in chunks {
        bytes.extend([&word(data.len()), kind.as_slice(), data].concat());
    }
    let length = bytes.len();
    with_length(bytes, length)
}

fn with_length(mut bytes: Vec<u8>, length: usize) -> Vec<u8> {
    bytes[8..12].copy_from_slice(&word(length));
    bytes
}

fn word(value: usize) -> [u8; 4] {
    (value as u32).to_le_bytes()
}

pub(super) fn cases(file: &Builder) -> Vec<Case> {
    let whole = file.glb();
    let json_length = u32::from_le_bytes([whole[12], whole[13], whole[14], whole[15]]) as usize;
    let json = &whole[20..20 + json_length];
    let binary = &whole[28 + json_length..];
    let header = |length: usize, rest: &[u8]| [b"glTF".as_slice(), &word(2), &word(length), rest].concat();
    let refused = |code, name, place, says, bytes| Case { code, name, outcome: Outcome::Refused(place, says), bytes };
    let read = |code, name, says, bytes| Case { code, name, outcome: Outcome::Read(says), bytes };
    vec![
        refused("VALIDATION_FAILED", "an empty file", "line 1", "no JSON", Vec::new()),
        refused("VALIDATION_FAILED", "words", "line 1", "no JSON", b"hello".to_vec()),
        refused("INVALID_JSON", "half a JSON text", "line 2", "no JSON", b"{\"asset\": {\n".to_vec()),
        refused("VALIDATION_FAILED", "lists in lists without end", "line 1", "no JSON", b"[".repeat(100_000)),
        refused("INVALID_JSON", "a JSON chunk that is no JSON", "line 1", "no JSON", glb(&[(JSON, b"{\"a\":}  ")])),
        refused("TYPE_MISMATCH", "a list instead of an object", "/", "object", glb(&[(JSON, b"[]  ")])),
        refused("GLB_INVALID_MAGIC", "other letters", "line 1", "no JSON", [b"glTX".as_slice(), &whole[4..]].concat()),
        refused(
            "GLB_INVALID_VERSION",
            "container version 1",
            "",
            "GLB version 1",
            [b"glTF".as_slice(), &word(1), &whole[8..]].concat(),
        ),
        refused("GLB_UNEXPECTED_END_OF_HEADER", "half a header", "byte 8", "truncated", whole[..10].to_vec()),
        refused("GLB_LENGTH_TOO_SMALL", "a length of eight", "byte 8", "8 bytes", header(8, &[])),
        refused("GLB_LENGTH_MISMATCH", "a length beyond the file", "byte 8", "truncated", header(1000, &[])),
        refused("GLB_LENGTH_TOO_SMALL", "no chunk", "byte 12", "no JSON chunk", header(12, &[])),
        refused(
            "GLB_UNEXPECTED_END_OF_CHUNK_HEADER",
            "half a chunk header",
            "byte 16",
            "truncated",
            header(16, &word(4)),
        ),
        refused(
            "GLB_UNEXPECTED_END_OF_CHUNK_DATA",
            "a file that ends in its binary chunk",
            "byte 8",
            "truncated",
            whole[..whole.len() - 4].to_vec(),
        ),
        refused(
            "GLB_CHUNK_TOO_BIG",
            "a chunk beyond the end",
            "byte 12",
            "are left",
            header(20, &[&word(0xffff_ffff), JSON.as_slice()].concat()),
        ),
        refused("GLB_UNEXPECTED_FIRST_CHUNK", "binary first", "byte 16", "must be JSON", glb(&[(BINARY, b"")])),
        refused("GLB_EMPTY_CHUNK", "an empty JSON chunk", "line 1", "no JSON", glb(&[(JSON, b"")])),
        read(
            "GLB_DUPLICATE_CHUNK",
            "a second JSON chunk",
            "chunk 2",
            glb(&[(JSON, json), (BINARY, binary), (JSON, json)]),
        ),
        read(
            "GLB_DUPLICATE_CHUNK",
            "a second binary chunk",
            "chunk 2",
            glb(&[(JSON, json), (BINARY, binary), (BINARY, binary)]),
        ),
        refused(
            "GLB_UNEXPECTED_BIN_CHUNK",
            "binary behind another chunk",
            "/buffers/0/uri",
            "missing",
            glb(&[(JSON, json), (b"XTRA", b"data"), (BINARY, binary)]),
        ),
        read(
            "GLB_UNKNOWN_CHUNK_TYPE",
            "an unknown chunk",
            "chunk 2",
            glb(&[(JSON, json), (BINARY, binary), (b"XTRA", b"data")]),
        ),
        read("GLB_EXTRA_DATA", "bytes behind the end", "8 bytes", [&whole, b"trailing".as_slice()].concat()),
        read(
            "GLB_CHUNK_LENGTH_UNALIGNED",
            "a chunk of odd length",
            "not padded",
            glb(&[(JSON, json), (BINARY, &[binary, &[0]].concat())]),
        ),
    ]
}
