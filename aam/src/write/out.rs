//! Lines, numbers and unknown text on their way into a file.

use std::collections::BTreeMap;

use super::{WriteError, WriteOptions};
use crate::Text;
use crate::document::Unknown;
use crate::text::trim_blanks;

/// The bytes written so far.
pub(crate) struct Out {
    bytes: Vec<u8>,
    line_end: &'static [u8],
    digits: Option<usize>,
    pub(crate) binary: bool,
    error: Option<WriteError>,
    real: zmij::Buffer,
    integer: itoa::Buffer,
}

const TABS: &[u8] = &[b'\t'; 64];

impl Out {
    pub(crate) fn new(options: &WriteOptions, binary: bool, estimate: usize) -> Self {
        Self {
            bytes: Vec::with_capacity(estimate),
            line_end: if options.crlf { b"\r\n" } else { b"\n" },
            digits: options.digits.map(usize::from),
            binary,
            error: None,
            real: zmij::Buffer::new(),
            integer: itoa::Buffer::new(),
        }
    }

    /// The whole file.
    pub(crate) fn finish(self) -> Result<Vec<u8>, WriteError> {
        match self.error {
            Some(error) => Err(error),
            None => Ok(self.bytes),
        }
    }

    /// Remembers the first thing that cannot be written.
    pub(crate) fn refuse(&mut self, subject: &str, message: impl Into<String>) {
        if self.error.is_none() {
            self.error = Some(WriteError { subject: subject.into(), message: message.into() });
        }
    }

    pub(crate) fn indent(&mut self, depth: usize) {
        self.bytes.extend_from_slice(&TABS[..depth.min(TABS.len())]);
    }

    pub(crate) fn raw(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    pub(crate) fn end_line(&mut self) {
        self.bytes.extend_from_slice(self.line_end);
    }

    /// A line of fixed words.
    pub(crate) fn line(&mut self, depth: usize, words: &str) {
        self.indent(depth);
        self.raw(words.as_bytes());
        self.end_line();
    }

    /// A tag with text up to the line's end.
    pub(crate) fn text(&mut self, depth: usize, tag: &str, text: &Text) {
        self.indent(depth);
        self.raw(tag.as_bytes());
        self.raw(b" ");
        self.free_text(tag, text.bytes());
        self.end_line();
    }

    /// Text that must stay on its line.
    pub(crate) fn free_text(&mut self, subject: &str, bytes: &[u8]) {
        if memchr::memchr2(b'\n', b'\r', bytes).is_some() || trim_blanks(bytes).len() != bytes.len() {
            self.refuse(subject, format!("{:?} has line ends in it or blanks at its ends", Text::from(bytes)));
        }
        self.raw(bytes);
    }

    /// A tag with one word.
    pub(crate) fn word(&mut self, depth: usize, tag: &str, word: &Text) {
        if word.is_empty() || word.bytes().iter().any(|byte| b" \t\r\n".contains(byte)) {
            self.refuse(tag, format!("{word:?} is not one word"));
        }
        self.text(depth, tag, word);
    }

    /// A tag with a whole number.
    pub(crate) fn integer_field(&mut self, depth: usize, tag: &str, value: i64) {
        self.indent(depth);
        self.raw(tag.as_bytes());
        self.raw(b" ");
        self.integer(value);
        self.end_line();
    }

    /// A tag with real numbers.
    pub(crate) fn real_field(&mut self, depth: usize, tag: &str, values: &[f32]) {
        self.indent(depth);
        self.raw(tag.as_bytes());
        for &value in values {
            self.raw(b" ");
            self.real(value);
        }
        self.end_line();
    }

    /// A list's tag and count.
    pub(crate) fn count(&mut self, depth: usize, tag: &str, count: usize) {
        self.integer_field(depth, tag, i64::try_from(count).unwrap_or(i64::MAX));
    }

    #[inline]
    pub(crate) fn integer(&mut self, value: impl itoa::Integer) {
        let text = self.integer.format(value);
        self.bytes.extend_from_slice(text.as_bytes());
    }

    /// The shortest decimal that reads back to the same value, or a fixed number of digits.
    #[inline]
    pub(crate) fn real(&mut self, value: f32) {
        if !value.is_finite() {
            self.bytes.extend_from_slice(match value {
                f32::INFINITY => b"1.#INF",
                f32::NEG_INFINITY => b"-1.#INF",
                _ => b"-1.#IND",
            });
        } else if let Some(digits) = self.digits {
            self.bytes.extend_from_slice(format!("{value:.digits$}").as_bytes());
        } else {
            let text = self.real.format_finite(value);
            self.bytes.extend_from_slice(text.as_bytes());
        }
    }

    /// A frame number, whole if it can be.
    pub(crate) fn frame(&mut self, value: f32) {
        if value.fract() == 0.0 && value.abs() < 1e9 && (value != 0.0 || value.is_sign_positive()) {
            self.integer(value as i64);
        } else {
            self.real(value);
        }
    }

    /// Rows of reals: text, or little-endian binary without a line end.
    pub(crate) fn rows<const N: usize>(&mut self, depth: usize, rows: &[[f32; N]]) {
        if self.binary {
            for row in rows {
                for value in row {
                    self.bytes.extend_from_slice(&value.to_le_bytes());
                }
            }
            return;
        }
        for row in rows {
            self.indent(depth);
            for (place, &value) in row.iter().enumerate() {
                if place > 0 {
                    self.bytes.push(b' ');
                }
                self.real(value);
            }
            self.end_line();
        }
    }

    /// Unknown lines, as they were but for the indentation.
    pub(crate) fn unknown_lines(&mut self, depth: usize, unknown: &Unknown) {
        let tag = unknown.text.bytes().split(|byte| b" \t\n".contains(byte)).next();
        if let Some(tag) = tag.filter(|tag| self.binary && tag.ends_with(b"_List:")) {
            let message =
                format!("{:?} cannot stand in a BINARY file: readers take it for binary data", Text::from(tag));
            self.refuse("unknown text", message);
        }
        for line in unknown.lines() {
            self.indent(depth);
            self.free_text("unknown text", line);
            self.end_line();
        }
    }
}

/// Puts a block's unknown text back in its place while the block's tags are written.
pub(crate) struct InPlace<'a> {
    unknown: &'a [Unknown],
    /// Positions in the list by what they stand before.
    places: BTreeMap<(&'static str, u32), Vec<usize>>,
    written: Vec<bool>,
    met: Vec<(&'static str, u32)>,
}

impl<'a> InPlace<'a> {
    pub(crate) fn new(unknown: &'a [Unknown]) -> Self {
        let mut places: BTreeMap<_, Vec<usize>> = BTreeMap::new();
        for (at, unknown) in unknown.iter().enumerate() {
            if let Some(before) = unknown.before {
                places.entry(before).or_default().push(at);
            }
        }
        Self { unknown, places, written: vec![false; unknown.len()], met: Vec::new() }
    }

    /// To be called before each tag of the block is written.
    pub(crate) fn before(&mut self, out: &mut Out, depth: usize, tag: &'static str) {
        if self.unknown.is_empty() {
            return;
        }
        let nth = match self.met.iter_mut().find(|(known, _)| *known == tag) {
            Some((_, nth)) => {
                *nth += 1;
                *nth
            }
            None => {
                self.met.push((tag, 0));
                0
            }
        };
        for at in self.places.remove(&(tag, nth)).unwrap_or_default() {
            self.written[at] = true;
            out.unknown_lines(depth, &self.unknown[at]);
        }
    }

    /// To be called at the block's end: what had no place left.
    pub(crate) fn end(self, out: &mut Out, depth: usize) {
        for (unknown, written) in self.unknown.iter().zip(self.written) {
            if !written {
                out.unknown_lines(depth, unknown);
            }
        }
    }
}
