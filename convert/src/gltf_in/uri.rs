//! Where buffers and images come from: data URIs, and files beside the asset that may not leave its folder.

use std::io;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::fault::{Checked, Fault};

/// What a URI names.
#[derive(Debug, PartialEq)]
pub(super) enum Source {
    /// The data itself.
    Data(Vec<u8>),
    /// A file: its name relative to the asset's folder with forward slashes, and its path.
    File { name: String, path: PathBuf },
    /// A file that is not there.
    Missing { name: String },
}

/// Follows a URI from an asset in `folder`. `place` is where the URI stands.
pub(super) fn follow(uri: &str, folder: &Path, allow_outside: bool, place: &str) -> Checked<Source> {
    if let Some(rest) = uri.strip_prefix("data:") {
        return data(rest).map(Source::Data).map_err(|message| Fault::broken(place, message));
    }
    if let Some(scheme) = scheme(uri) {
        return Err(Fault::unsupported(
            format!("the {scheme}: address at {place}"),
            "download the file, put it beside the asset and name it there",
        ));
    }
    let decoded = String::from_utf8(percent_decoded(uri))
        .map_err(|_| Fault::broken(place, format!("{uri:?} is not UTF-8 after percent-decoding")))?;
    // Some exporters do not encode a percent sign that stands for itself.
    match locate(&decoded, folder, allow_outside, place)? {
        Source::Missing { name } if decoded != uri => match locate(uri, folder, allow_outside, place)? {
            Source::Missing { .. } => Ok(Source::Missing { name }),
            found => Ok(found),
        },
        found => Ok(found),
    }
}

/// The scheme of an absolute URI; a single letter is a Windows drive.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let mut letters = scheme.chars();
    let valid = letters.next()?.is_ascii_alphabetic()
        && letters.all(|letter| letter.is_ascii_alphanumeric() || "+.-".contains(letter));
    (valid && scheme.len() > 1).then_some(scheme)
}

fn locate(name: &str, folder: &Path, allow_outside: bool, place: &str) -> Checked<Source> {
    if name.is_empty() || name.contains(|letter: char| letter.is_control()) {
        return Err(Fault::broken(place, format!("{name:?} is no file name")));
    }
    let outside = || {
        Fault::broken(
            place,
            format!("{name:?} leaves the folder of the asset; --allow-outside permits it if you trust the file"),
        )
    };
    let slashed = name.replace('\\', "/");
    let drive = slashed.as_bytes().get(1) == Some(&b':');
    let absolute = slashed.starts_with('/') || drive;
    let mut parts: Vec<&str> = Vec::new();
    let mut up = PathBuf::new();
    for part in slashed.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                if parts.pop().is_none() {
                    up.push("..");
                }
            }
            other => parts.push(other),
        }
    }
    let escapes = absolute || up != Path::new("");
    if escapes && !allow_outside {
        return Err(outside());
    }
    let relative = parts.join("/");
    let path = if absolute { PathBuf::from(&slashed) } else { folder.join(up).join(&relative) };
    // Outside the folder only the last part makes a name that can stand beside the document.
    let name = if escapes { parts.last().map_or_else(String::new, |&last| last.to_owned()) } else { relative };
    let unreadable = |source: io::Error| -> Fault { aam::FileError::Open { path: path.clone(), source }.into() };
    let canonical = match path.canonicalize() {
        Ok(canonical) => canonical,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Source::Missing { name }),
        Err(error) => return Err(unreadable(error)),
    };
    if !allow_outside {
        let root = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let root = root.canonicalize().map_err(unreadable)?;
        if !canonical.starts_with(&root) {
            return Err(outside());
        }
    }
    if !canonical.is_file() {
        return Err(Fault::broken(place, format!("{name:?} is not a file")));
    }
    Ok(Source::File { name, path })
}

/// Bytes with each `%XX` decoded; a percent sign that starts no such triple stands for itself.
fn percent_decoded(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let digit = |at: usize| bytes.get(at).and_then(|&byte| char::from(byte).to_digit(16));
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        match (bytes[at], digit(at + 1), digit(at + 2)) {
            (b'%', Some(high), Some(low)) => {
                decoded.push((high * 16 + low) as u8);
                at += 3;
            }
            (byte, ..) => {
                decoded.push(byte);
                at += 1;
            }
        }
    }
    decoded
}

/// The bytes of a data URI without its `data:` (RFC 2397).
fn data(rest: &str) -> Result<Vec<u8>, String> {
    const LENIENT: GeneralPurpose = GeneralPurpose::new(
        &STANDARD,
        GeneralPurposeConfig::new()
            .with_decode_padding_mode(DecodePaddingMode::Indifferent)
            .with_decode_allow_trailing_bits(true),
    );
    let (header, body) = rest.split_once(',').ok_or("the data URI has no comma before its data")?;
    if !header.to_ascii_lowercase().ends_with(";base64") {
        return Ok(percent_decoded(body));
    }
    let decoded;
    let body = if body.contains('%') {
        decoded = percent_decoded(body);
        decoded.as_slice()
    } else {
        body.as_bytes()
    };
    LENIENT.decode(body).map_err(|error| format!("the data URI is not base64: {error}"))
}
