//! The lines of OBJ and MTL files, cut into words.
//!
//! A statement is a line; `\` at the end of one carries it on to the next. `#` starts a comment. Words are separated by
//! blanks and tabs. Everything is a slice of the file, so a place in it is an offset.

use crate::ConvertError;
use crate::source::Source;

/// A file's statements, one after the other.
pub(super) struct Statements<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// A line without its comment.
#[derive(Clone)]
pub(super) struct Statement<'a> {
    bytes: &'a [u8],
    at: usize,
    end: usize,
}

impl<'a> Statements<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let mark = b"\xef\xbb\xbf";
        Self { bytes, at: if bytes.starts_with(mark) { mark.len() } else { 0 } }
    }

    /// How far in the file the next statement is.
    pub(super) fn offset(&self) -> usize {
        self.at
    }
}

impl<'a> Iterator for Statements<'a> {
    type Item = Statement<'a>;

    fn next(&mut self) -> Option<Statement<'a>> {
        if self.at >= self.bytes.len() {
            return None;
        }
        let start = self.at;
        let mut end = start;
        loop {
            let rest = &self.bytes[end..];
            end += memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
            let crlf = self.bytes[end..].starts_with(b"\r\n");
            self.at = (end + 1 + usize::from(crlf)).min(self.bytes.len());
            let line = self.bytes[start..end].trim_ascii_end();
            // Only a `\` at the very end carries on: a Windows path may end in one before a blank.
            let carried = end > start && self.bytes[end - 1] == b'\\' && !line.contains(&b'#');
            if !carried || self.at >= self.bytes.len() {
                let comment = memchr::memchr_iter(b'#', line).find(|at| starts_comment(line, *at));
                let length = comment.unwrap_or(line.len());
                return Some(Statement { bytes: self.bytes, at: start, end: start + length });
            }
            end = self.at;
        }
    }
}

/// A `#` inside a word is part of it (file and material names have it).
fn starts_comment(line: &[u8], at: usize) -> bool {
    at == 0 || line[at - 1].is_ascii_whitespace()
}

/// Between words, `\` with a line end after it counts as a blank.
fn is_blank(bytes: &[u8], at: usize) -> bool {
    match bytes[at] {
        b' ' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c => true,
        b'\\' => matches!(bytes.get(at + 1), Some(b'\n' | b'\r')),
        _ => false,
    }
}

impl<'a> Statement<'a> {
    /// The next word and its offset.
    pub(super) fn word(&mut self) -> Option<(usize, &'a [u8])> {
        self.skip_blanks();
        let start = self.at;
        while self.at < self.end && !is_blank(self.bytes, self.at) {
            self.at += 1;
        }
        (self.at > start).then(|| (start, &self.bytes[start..self.at]))
    }

    /// The next word without taking it.
    pub(super) fn peek(&self) -> Option<&'a [u8]> {
        self.clone().word().map(|(_, word)| word)
    }

    /// Everything that is left, blanks at the ends and quotes around it taken off.
    pub(super) fn rest(&mut self) -> String {
        self.skip_blanks();
        let rest = std::mem::replace(&mut self.at, self.end);
        let mut text = Vec::with_capacity(self.end - rest);
        let mut joined = false;
        for at in rest..self.end {
            let byte = self.bytes[at];
            if !is_blank(self.bytes, at) {
                joined = false;
                text.push(byte);
            } else if matches!(byte, b'\\' | b'\n' | b'\r') {
                // Where lines are joined, all the blanks around count as one.
                joined = true;
            } else if !joined {
                text.push(b' ');
            }
            if joined && text.last() != Some(&b' ') {
                text.push(b' ');
            }
        }
        let text = text.trim_ascii();
        let text = text.strip_prefix(b"\"").and_then(|text| text.strip_suffix(b"\"")).unwrap_or(text);
        aam::Text::from(text).decoded()
    }

    /// Where the next word would start.
    pub(super) fn offset(&self) -> usize {
        self.at.min(self.end)
    }

    fn skip_blanks(&mut self) {
        while self.at < self.end && is_blank(self.bytes, self.at) {
            self.at += 1;
        }
    }
}

impl Source<'_> {
    /// The error for a word of a statement that is not what it should be.
    pub(super) fn unexpected(&self, what: &str, found: Option<(usize, &[u8])>, statement: &Statement) -> ConvertError {
        match found {
            Some(_) => self.expected(what, found, 0),
            None => self.broken(statement.offset(), format!("expected {what}, found the end of the line")),
        }
    }

    /// The next word as a finite number.
    pub(super) fn number(&self, statement: &mut Statement, what: &str) -> Result<f32, ConvertError> {
        let word = statement.word();
        let number = word.and_then(|(_, word)| fast_float2::parse::<f32, _>(word).ok()).filter(|x| x.is_finite());
        number.ok_or_else(|| self.unexpected(what, word, statement))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn words(text: &str) -> Vec<Vec<String>> {
        Statements::new(text.as_bytes())
            .map(|mut statement| {
                std::iter::from_fn(|| statement.word().map(|(_, word)| String::from_utf8_lossy(word).into_owned()))
                    .collect()
            })
            .collect()
    }

    #[test]
    fn lines_and_words() {
        let text = "\u{feff}v 1\t2  3 # point\r\nf 1 \\\n2\\\r\n 3\rg a#b # c\n\n# all\nlast";
        assert_eq!(
            words(text),
            [vec!["v", "1", "2", "3"], vec!["f", "1", "2", "3"], vec!["g", "a#b"], vec![], vec![], vec!["last"]]
        );
        assert_eq!(words("f 1\\"), [vec!["f", "1\\"]]);
        assert_eq!(words("# comment \\\nv"), [vec![], vec!["v"]]);
    }

    #[test]
    fn the_rest_of_a_line() {
        for (text, rest) in [
            ("map_Kd  my wood.png  # note", "my wood.png"),
            ("map_Kd \"my wood.png\"", "my wood.png"),
            ("map_Kd C:\\maps\\wood#1.png", "C:\\maps\\wood#1.png"),
            ("map_Kd my\\\n  wood.png", "my wood.png"),
            ("map_Kd caf\u{e9}.png", "caf\u{e9}.png"),
            ("map_Kd", ""),
        ] {
            let mut statement = Statements::new(text.as_bytes()).next().unwrap();
            statement.word();
            assert_eq!(statement.rest(), rest, "{text}");
        }
        let mut latin = Statements::new(b"usemtl caf\xe9").next().unwrap();
        latin.word();
        assert_eq!(latin.rest(), "café");
    }

    #[test]
    fn errors_say_where() {
        let source = Source { path: Path::new("a.obj"), bytes: b"v 1 2 3\nv 1 x 3\n" };
        let mut statement = Statements::new(source.bytes).nth(1).unwrap();
        statement.word();
        assert_eq!(source.number(&mut statement, "x").unwrap(), 1.0);
        let error = source.number(&mut statement, "a coordinate").unwrap_err().to_string();
        assert_eq!(error, "a.obj: 2:5: expected a coordinate, found `x`\n    | v 1 x 3\n    |     ^");
        let mut empty = Statements::new(b"v").next().unwrap();
        empty.word();
        assert!(source.number(&mut empty, "a coordinate").unwrap_err().to_string().contains("the end of the line"));
    }
}
