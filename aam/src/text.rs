//! Text of a file kept byte for byte.

use std::fmt;

use serde::{Serialize, Serializer};

/// A name, a file name or free text, exactly as its bytes stand in the file.
///
/// AAM says nothing about encodings, and real files hold ASCII, Latin-1 and UTF-8. The bytes are kept; only showing
/// them decodes: as UTF-8 where they are valid UTF-8, else as Latin-1 (each byte one character).
#[derive(Clone, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Text(Box<[u8]>);

impl Text {
    /// The bytes as they stand in the file.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// True when there is no text.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The text decoded for people: UTF-8, else Latin-1.
    pub fn decoded(&self) -> String {
        match std::str::from_utf8(&self.0) {
            Ok(text) => text.to_owned(),
            Err(_) => self.0.iter().map(|&byte| char::from(byte)).collect(),
        }
    }

    /// The text as one line that an AAM file can hold: control characters become blanks, ends are trimmed.
    pub fn one_line(text: &str) -> Self {
        let cleaned: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        Self::from(cleaned.trim())
    }
}

/// Bytes without the blanks and tabs at their ends. A form feed is text here, though white space to most.
pub(crate) fn trim_blanks(mut bytes: &[u8]) -> &[u8] {
    while let [b' ' | b'\t', inner @ ..] | [inner @ .., b' ' | b'\t'] = bytes {
        bytes = inner;
    }
    bytes
}

impl From<&str> for Text {
    fn from(text: &str) -> Self {
        Self(text.as_bytes().into())
    }
}

impl From<String> for Text {
    fn from(text: String) -> Self {
        Self(text.into_bytes().into())
    }
}

impl From<&[u8]> for Text {
    fn from(bytes: &[u8]) -> Self {
        Self(bytes.into())
    }
}

impl PartialEq<str> for Text {
    fn eq(&self, other: &str) -> bool {
        self.bytes() == other.as_bytes()
    }
}

impl PartialEq<&str> for Text {
    fn eq(&self, other: &&str) -> bool {
        self.bytes() == other.as_bytes()
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.decoded())
    }
}

impl fmt::Debug for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.decoded(), f)
    }
}

impl Serialize for Text {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.decoded())
    }
}
