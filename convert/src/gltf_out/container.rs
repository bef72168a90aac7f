//! The two forms of a glTF file.

use crate::ConvertError;

use super::json::Root;

/// A GLB file: header, JSON chunk, binary chunk (glTF 2.0 §4.4).
pub(super) fn glb(root: &Root, binary: &[u8]) -> Result<Vec<u8>, ConvertError> {
    const JSON: u32 = 0x4E4F_534A;
    const BIN: u32 = 0x004E_4942;
    let mut json = text(root, false)?;
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunks =
        8 + json.len() as u64 + if binary.is_empty() { 0 } else { 8 + binary.len().next_multiple_of(4) as u64 };
    let total = u32::try_from(12 + chunks).map_err(|_| too_large())?;
    let mut bytes = Vec::with_capacity(total as usize);
    bytes.extend_from_slice(b"glTF");
    bytes.extend_from_slice(&2_u32.to_le_bytes());
    bytes.extend_from_slice(&total.to_le_bytes());
    bytes.extend_from_slice(&(json.len() as u32).to_le_bytes());
    bytes.extend_from_slice(&JSON.to_le_bytes());
    bytes.extend_from_slice(&json);
    if !binary.is_empty() {
        bytes.extend_from_slice(&(binary.len().next_multiple_of(4) as u32).to_le_bytes());
        bytes.extend_from_slice(&BIN.to_le_bytes());
        bytes.extend_from_slice(binary);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    Ok(bytes)
}

fn too_large() -> ConvertError {
    ConvertError::Option("a .glb file holds at most 4 GiB; write .gltf, whose data is a file of its own".into())
}

/// The JSON, for people to read or as short as it gets.
pub(super) fn text(root: &Root, readable: bool) -> Result<Vec<u8>, ConvertError> {
    let written = if readable { serde_json::to_vec_pretty(root) } else { serde_json::to_vec(root) };
    written.map_err(|error| ConvertError::Option(format!("the glTF document cannot be written as JSON: {error}")))
}

/// A path with `/` between its parts as a URI reference (RFC 3986): all but unreserved characters are percent-encoded.
pub(super) fn uri_of(path: &str) -> String {
    let mut uri = String::new();
    for byte in path.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte) {
            uri.push(char::from(byte));
        } else {
            uri += &format!("%{byte:02X}");
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_become_uris() {
        assert_eq!(uri_of("maps/TEXTURE PARQUET.jpg"), "maps/TEXTURE%20PARQUET.jpg");
        assert_eq!(uri_of("a:b%c/ü.png"), "a%3Ab%25c/%C3%BC.png");
    }

    #[test]
    fn chunks_are_multiples_of_four() {
        let root = Root::default();
        for length in 0..6 {
            let bytes = glb(&root, &vec![7; length]).unwrap();
            let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
            assert_eq!(word(8), bytes.len());
            assert_eq!(bytes.len() % 4, 0);
            let json = word(12);
            assert_eq!(json % 4, 0);
            let rest = bytes.len() - 20 - json;
            assert_eq!(rest, if length == 0 { 0 } else { 8 + length.next_multiple_of(4) });
            let padded = &bytes[20..20 + json];
            assert!(serde_json::from_slice::<serde_json::Value>(padded).is_ok());
        }
    }
}
