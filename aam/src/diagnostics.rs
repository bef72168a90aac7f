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
        while let Some(found) = memchr::memchr2(b'\n', b'\r', &self.bytes[self.start..offset.max(self.start)]) {
            let mut next = self.start + found + 1;
            if self.bytes[next - 1] == b'\r' && self.bytes.get(next) == Some(&b'\n') {
                next += 1;
            }
            if next > offset {
                break;
            }
            self.start = next;
            self.line += 1;
        }
        Position { line: self.line, column: offset.saturating_sub(self.start) + 1 }
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
    /// The line, cut around the place and made printable.
    pub line: String,
    /// Where in [`ReadError::line`] the marker goes, in characters.
    pub marker: usize,
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: error[{}]: {}", self.position, self.code, self.message)?;
        writeln!(f, "    | {}", self.line)?;
        write!(f, "    | {:marker$}^", "", marker = self.marker)
    }
}

impl std::error::Error for ReadError {}

impl ReadError {
    /// Builds the error for a place in a file's bytes.
    pub fn at(bytes: &[u8], offset: usize, code: &'static str, message: impl Into<String>) -> Self {
        const BEFORE: usize = 60;
        const AFTER: usize = 40;
        let offset = offset.min(bytes.len());
        let position = Position::of(bytes, offset);
        let line_start = offset - (position.column - 1);
        let start = line_start.max(offset.saturating_sub(BEFORE));
        let end = bytes[offset..]
            .iter()
            .take(AFTER)
            .position(|&byte| byte == b'\n' || byte == b'\r')
            .map_or((offset + AFTER).min(bytes.len()), |n| offset + n);
        let printable = |byte: &u8| match byte {
            b'\t' => ' ',
            0x20..=0x7e => char::from(*byte),
            0xa0..=0xff => char::from(*byte),
            _ => '·',
        };
        let cut = if start > line_start { "…" } else { "" };
        let line: String = cut.chars().chain(bytes[start..end].iter().map(printable)).collect();
        Self {
            code,
            offset,
            position,
            message: message.into(),
            line,
            marker: offset - start + usize::from(!cut.is_empty()),
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
