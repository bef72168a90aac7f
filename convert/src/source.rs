//! A file that is being read, for its errors.

use std::path::Path;

use aam::ReadError;

use crate::ConvertError;

#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) path: &'a Path,
    pub(crate) bytes: &'a [u8],
}

impl Source<'_> {
    /// The error for a place in a text: `line:column: message`, and the line with a marker.
    pub(crate) fn broken(&self, offset: usize, message: impl Into<String>) -> ConvertError {
        let error = ReadError::at(self.bytes, offset, "", message);
        ConvertError::Broken {
            path: self.path.to_owned(),
            place: error.position.to_string(),
            message: format!("{}\n{}", error.message, error.excerpt),
        }
    }

    /// The error for a word that is not what it should be, or for the end of what there is at `end`.
    pub(crate) fn expected(&self, what: &str, found: Option<(usize, &[u8])>, end: usize) -> ConvertError {
        match found {
            Some((offset, word)) => self.broken(offset, format!("expected {what}, found `{}`", shown(word))),
            None if end >= self.bytes.len() => self.broken(end, format!("expected {what}, found the end of the file")),
            None => self.broken(end, format!("expected {what}, found the end of the line")),
        }
    }

    /// The error for a place among bytes that are no text.
    pub(crate) fn broken_byte(&self, offset: usize, message: impl Into<String>) -> ConvertError {
        let place = format!("byte {offset}");
        ConvertError::Broken { path: self.path.to_owned(), place, message: message.into() }
    }

    /// The error for a model without faces.
    pub(crate) fn no_faces(&self) -> ConvertError {
        ConvertError::Unsupported {
            path: self.path.to_owned(),
            feature: "a model without faces".into(),
            way_out: "AAM holds triangles only; make a surface of points or lines first (MeshLab can)".into(),
        }
    }
}

/// A word for an error message, not longer than a line.
pub(crate) fn shown(word: &[u8]) -> String {
    let cut = &word[..word.len().min(40)];
    let text: String = String::from_utf8_lossy(cut).chars().map(|c| if c.is_control() { '·' } else { c }).collect();
    if cut.len() < word.len() { format!("{text}…") } else { text }
}

/// The words of a text, separated by white space.
#[derive(Clone)]
pub(crate) struct Words<'a> {
    bytes: &'a [u8],
    pub(crate) at: usize,
}

impl<'a> Words<'a> {
    pub(crate) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at }
    }

    /// The next word and its offset.
    pub(crate) fn next(&mut self) -> Option<(usize, &'a [u8])> {
        while self.at < self.bytes.len() && self.bytes[self.at].is_ascii_whitespace() {
            self.at += 1;
        }
        let start = self.at;
        while self.at < self.bytes.len() && !self.bytes[self.at].is_ascii_whitespace() {
            self.at += 1;
        }
        (self.at > start).then(|| (start, &self.bytes[start..self.at]))
    }

    /// The rest of the line, and on to the next one.
    pub(crate) fn line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let end = memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
        let crlf = rest[end..].starts_with(b"\r\n");
        self.at = (self.at + end + 1 + usize::from(crlf)).min(self.bytes.len());
        &rest[..end]
    }
}
