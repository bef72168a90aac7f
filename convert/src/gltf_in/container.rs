//! The two containers of glTF: a JSON text, or a GLB file with a JSON chunk and a binary chunk.

use std::ops::Range;

use super::fault::{Checked, Fault};

const JSON_CHUNK: u32 = 0x4E4F_534A;
const BINARY_CHUNK: u32 = 0x004E_4942;
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// Where a file's parts are.
#[derive(Debug)]
pub(super) struct Container {
    /// The JSON text.
    pub(super) json: Range<usize>,
    /// The binary chunk of a GLB file.
    pub(super) binary: Option<Range<usize>>,
    /// What is odd about the container.
    pub(super) oddities: Vec<String>,
}

/// Finds the parts of a file. What it is, its first bytes say, not its name.
pub(super) fn open(bytes: &[u8]) -> Checked<Container> {
    if bytes.starts_with(b"glTF") {
        return open_glb(bytes);
    }
    let start = if bytes.starts_with(b"\xEF\xBB\xBF") { 3 } else { 0 };
    Ok(Container { json: start..bytes.len(), binary: None, oddities: Vec::new() })
}

fn open_glb(bytes: &[u8]) -> Checked<Container> {
    let word =
        |at: usize| -> Checked<u32> {
            bytes.get(at..at + 4).and_then(|four| four.try_into().ok()).map(u32::from_le_bytes).ok_or_else(|| {
                Fault::broken(format!("byte {at}"), "the GLB file ends inside a header; it is truncated")
            })
        };
    let version = word(4)?;
    if version != 2 {
        return Err(Fault::unsupported(
            format!("GLB version {version}"),
            "convert the file to glTF 2.0 first (`gltf-pipeline -i old.glb -o new.glb` does it for version 1)",
        ));
    }
    let length = word(8)? as usize;
    if length < HEADER {
        let message = format!("the header says {length} bytes, but it has {HEADER} itself");
        return Err(Fault::broken("byte 8", message));
    }
    if length > bytes.len() {
        let message = format!("the header says {length} bytes, but the file has {}; it is truncated", bytes.len());
        return Err(Fault::broken("byte 8", message));
    }
    let mut container = Container { json: 0..0, binary: None, oddities: Vec::new() };
    if length < bytes.len() {
        container.oddities.push(format!("{} bytes after the end of the GLB data are ignored", bytes.len() - length));
    }
    let mut at = HEADER;
    let mut number = 0;
    while at < length {
        let size = word(at)? as usize;
        let kind = word(at + 4)?;
        let start = at + CHUNK_HEADER;
        if start > length || size > length - start {
            let message = format!(
                "chunk {number} has {size} bytes, but only {} are left in the file",
                length.saturating_sub(start)
            );
            return Err(Fault::broken(format!("byte {at}"), message));
        }
        let chunk = start..start + size;
        match (number, kind) {
            (0, JSON_CHUNK) => container.json = chunk,
            (0, other) => {
                let message = format!("the first chunk must be JSON (0x{JSON_CHUNK:08X}), found 0x{other:08X}");
                return Err(Fault::broken(format!("byte {}", at + 4), message));
            }
            (1, BINARY_CHUNK) => container.binary = Some(chunk),
            (_, other) => container.oddities.push(format!("chunk {number} of type 0x{other:08X} is ignored")),
        }
        if !size.is_multiple_of(4) {
            container.oddities.push(format!("chunk {number} is not padded to 4 bytes"));
        }
        at = start + size;
        number += 1;
    }
    if number == 0 {
        return Err(Fault::broken(format!("byte {HEADER}"), "the GLB file has no JSON chunk"));
    }
    Ok(container)
}
