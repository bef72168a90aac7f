//! Findings: what is wrong with a file, where, and what to do about it.

use std::fmt;

use serde::Serialize;

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Worth knowing, nothing to mend.
    Info,
    /// The file is read, but something in it is odd or will not be honoured.
    Warning,
    /// The file, or a part of it, cannot mean anything.
    Error,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Info => "info",
            Self::Warning => "warning",
            Self::Error => "error",
        })
    }
}

/// A place in a file, for people: both counted from 1, the column in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Position {
    /// Line, from 1.
    pub line: usize,
    /// Column in bytes, from 1.
    pub column: usize,
}

impl Position {
    /// The position of a byte offset. LF, CRLF and a lone CR each end a line.
    pub fn of(bytes: &[u8], offset: usize) -> Self {
        Self::walk(bytes).at(offset)
    }

    /// Finds the positions of ascending offsets in one pass.
    pub fn walk(bytes: &[u8]) -> PositionWalk<'_> {
        PositionWalk { bytes, line: 1, start: 0 }
    }
}

/// Turns ascending byte offsets into positions, reading the file once.
#[derive(Clone, Debug)]
pub struct PositionWalk<'a> {
    bytes: &'a [u8],
    line: usize,
    start: usize,
}

impl PositionWalk<'_> {
    /// The position of an offset, which must not lie before one asked for earlier.
    pub fn at(&mut self, offset: usize) -> Position {
        let offset = offset.min(self.bytes.len());
        while self.next_line(offset) {}
        Position { line: self.line, column: offset.saturating_sub(self.start) + 1 }
    }

    /// The offset of a position, which must not lie on a line before one asked for earlier.
    pub fn offset(&mut self, position: Position) -> usize {
        while self.line < position.line && self.next_line(self.bytes.len()) {}
        self.start.saturating_add(position.column.saturating_sub(1)).min(self.bytes.len())
    }

    /// Goes to the next line if it starts at an offset or before it.
    fn next_line(&mut self, offset: usize) -> bool {
        let Some(found) = memchr::memchr2(b'\n', b'\r', &self.bytes[self.start..offset.max(self.start)]) else {
            return false;
        };
        let mut next = self.start + found + 1;
        if self.bytes[next - 1] == b'\r' && self.bytes.get(next) == Some(&b'\n') {
            next += 1;
        }
        if next > offset {
            return false;
        }
        self.start = next;
        self.line += 1;
        true
    }
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.line, self.column)
    }
}

/// One thing found in a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Stable code, `group/what` in lower case (`syntax/unknown-tag`).
    pub code: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// Where in the file, if it came from one.
    pub position: Option<Position>,
    /// Which part of the document (`object 3 "Lamp"`), empty for the whole.
    pub subject: String,
    /// What is wrong and what to do, one sentence.
    pub message: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(position) = self.position {
            write!(f, "{position}: ")?;
        }
        write!(f, "{}[{}]: ", self.severity, self.code)?;
        if !self.subject.is_empty() {
            write!(f, "{}: ", self.subject)?;
        }
        f.write_str(&self.message)
    }
}

/// A line of a file, cut around a place and made printable. Its `Display` is the line, and a marker below the place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excerpt {
    /// The line, or what is near the place if it is long.
    pub line: String,
    /// Where in the line the marker goes, in characters.
    pub marker: usize,
}

impl Excerpt {
    /// The line at a byte offset.
    pub fn at(bytes: &[u8], offset: usize) -> Self {
        const BEFORE: usize = 60;
        const AFTER: usize = 40;
        let is_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
        let offset = offset.min(bytes.len());
        let inside_line_end = bytes[..offset].ends_with(b"\r") && bytes[offset..].starts_with(b"\n");
        let before = &bytes[..offset - usize::from(inside_line_end)];
        let line_start = before.iter().rev().take(BEFORE + 1).position(is_end).map(|back| before.len() - back);
        let start = line_start.unwrap_or(0).max(offset.saturating_sub(BEFORE));
        let cut = if line_start.is_none() && start > 0 { "…" } else { "" };
        let end = bytes[offset..].iter().take(AFTER).position(is_end).unwrap_or(AFTER.min(bytes.len() - offset));
        let (before, after) = printable(&bytes[start..offset], &bytes[offset..offset + end]);
        Self { marker: cut.chars().count() + before.chars().count(), line: format!("{cut}{before}{after}") }
    }
}

/// Two parts of a line for people: UTF-8 if both are, up to characters that are cut in two at the ends; else Latin-1.
fn printable(before: &[u8], after: &[u8]) -> (String, String) {
    let dotted = |c: char| match c {
        '\t' => ' ',
        // Characters without a width, and those that turn the direction of a terminal's line.
        '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}' => '·',
        _ if c.is_control() => '·',
        _ => c,
    };
    let cut = before.iter().take(3).take_while(|byte| matches!(byte, 0x80..=0xbf)).count();
    let head = std::str::from_utf8(&before[cut..]).ok();
    let tail = match std::str::from_utf8(after) {
        Ok(text) => Some(text),
        Err(error) if error.error_len().is_none() => std::str::from_utf8(&after[..error.valid_up_to()]).ok(),
        Err(_) => None,
    };
    match (head, tail) {
        (Some(head), Some(tail)) => (head.chars().map(dotted).collect(), tail.chars().map(dotted).collect()),
        _ => {
            let latin = |bytes: &[u8]| bytes.iter().map(|&byte| dotted(char::from(byte))).collect();
            (latin(before), latin(after))
        }
    }
}

impl fmt::Display for Excerpt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "    | {}", self.line)?;
        write!(f, "    | {:marker$}^", "", marker = self.marker)
    }
}

/// Why a document could not be read. Its `Display` is `line:column: expected …, found …`, then the line with a marker.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadError {
    /// Stable code, as in [`Finding::code`].
    pub code: &'static str,
    /// Byte offset in the file.
    pub offset: usize,
    /// The same place in lines and columns.
    pub position: Position,
    /// What is wrong: `expected …, found …`.
    pub message: String,
    /// The line.
    pub excerpt: Excerpt,
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: error[{}]: {}", self.position, self.code, self.message)?;
        self.excerpt.fmt(f)
    }
}

impl std::error::Error for ReadError {}

impl ReadError {
    /// Builds the error for a place in a file's bytes.
    pub fn at(bytes: &[u8], offset: usize, code: &'static str, message: impl Into<String>) -> Self {
        let offset = offset.min(bytes.len());
        Self {
            code,
            offset,
            position: Position::of(bytes, offset),
            message: message.into(),
            excerpt: Excerpt::at(bytes, offset),
        }
    }
}

impl From<ReadError> for Finding {
    fn from(error: ReadError) -> Self {
        Self {
            code: error.code,
            severity: Severity::Error,
            position: Some(error.position),
            subject: String::new(),
            message: error.message,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_line_end_counts_once() {
        let bytes = b"a\nb\r\nc\rd\n\re";
        let at = |offset| {
            let position = Position::of(bytes, offset);
            (position.line, position.column)
        };
        let expected = [(1, 1), (1, 2), (2, 1), (2, 2), (2, 3), (3, 1), (3, 2), (4, 1), (4, 2), (5, 1), (6, 1), (6, 2)];
        for (offset, expected) in expected.into_iter().enumerate() {
            assert_eq!(at(offset), expected, "offset {offset}");
        }
        assert_eq!(at(1000), (6, 2));
        let mut walk = Position::walk(bytes);
        for offset in 0..=bytes.len() {
            assert_eq!(walk.offset(Position::of(bytes, offset)), offset);
        }
    }

    #[test]
    fn an_excerpt_is_the_line_around_the_place() {
        let bytes = b"ab\r\ncd\re\n";
        let at = |offset| {
            let excerpt = Excerpt::at(bytes, offset);
            (excerpt.line, excerpt.marker)
        };
        for (offset, line, marker) in [
            (0, "ab", 0),
            (2, "ab", 2),
            (3, "ab·", 3),
            (4, "cd", 0),
            (6, "cd", 2),
            (7, "e", 0),
            (9, "", 0),
            (99, "", 0),
        ] {
            assert_eq!(at(offset), (line.to_owned(), marker), "offset {offset}");
        }
        let long = Excerpt::at(&[b'x'; 1000], 500);
        assert_eq!((long.line.chars().count(), long.marker), (101, 61));
        assert!(long.line.starts_with("…x"));
        assert_eq!(Excerpt::at(&[b'x'; 1000], 60), Excerpt { line: "x".repeat(100), marker: 60 });
        for (bytes, line, marker) in [
            ("Größe ✓ x".as_bytes(), "Größe ✓ x", 8),
            (b"Gr\xf6\xdfe \x9f\x01 x", "Größe ·· x", 9),
            ("\u{feff}a\u{202e} x".as_bytes(), "·a· x", 4),
        ] {
            let excerpt = Excerpt::at(bytes, bytes.len() - 1);
            assert_eq!((excerpt.line.as_str(), excerpt.marker), (line, marker));
        }
        let cut = Excerpt::at(format!("{0}x{0}", "✓".repeat(100)).as_bytes(), 301);
        let whole = format!("…{}x{}", "✓".repeat(19), "✓".repeat(13));
        assert_eq!((cut.line, cut.marker), (whole, 21), "no halves of characters at the ends");
    }

    #[test]
    fn an_error_shows_the_line_with_a_marker() {
        let error = ReadError::at(b"Tr: 0\n\tSh: x1\n", 11, "syntax/expected", "expected a number, found `x1`");
        assert_eq!(
            error.to_string(),
            "2:6: error[syntax/expected]: expected a number, found `x1`\n    |  Sh: x1\n    |      ^"
        );
    }
}
