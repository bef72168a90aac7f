//! Lines, numbers and unknown text on their way into a file.

use std::collections::BTreeMap;

use super::digits::{Decimal, ShortText, decimal};
use super::{WriteError, WriteOptions};
use crate::Text;
use crate::document::Unknown;
use crate::large_pages::in_large_pages;
use crate::text::trim_blanks;

/// The bytes written so far.
pub(crate) struct Out {
    /// Zeros behind what was written. To have them costs nothing where the memory is fresh, and a row is put in place without
    /// asking for room for each of its numbers.
    bytes: Vec<u8>,
    length: usize,
    crlf: bool,
    digits: Option<usize>,
    pub(crate) binary: bool,
    error: Option<WriteError>,
}

const TABS: &[u8] = &[b'\t'; 64];

impl Out {
    pub(crate) fn new(options: &WriteOptions, binary: bool, estimate: usize) -> Self {
        Self {
            bytes: in_large_pages(vec![0; estimate]),
            length: 0,
            crlf: options.crlf,
            digits: options.digits.map(usize::from),
            binary,
            error: None,
        }
    }

    /// The whole file.
    pub(crate) fn finish(mut self) -> Result<Vec<u8>, WriteError> {
        self.bytes.truncate(self.length);
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

    #[cold]
    #[inline(never)]
    fn make_room(&mut self, more: usize) {
        self.bytes.resize((self.length + more).max(2 * self.bytes.len()), 0);
    }

    /// Writes a row of at most [`ROW`] bytes.
    #[inline(always)]
    pub(crate) fn row<R>(&mut self, write: impl FnOnce(&mut Row<'_>) -> R) -> R {
        if self.bytes.len() - self.length < ROW {
            self.make_room(ROW);
        }
        let bytes = self.bytes[self.length..].first_chunk_mut().expect("there is room for a row");
        let mut row = Row { bytes, length: 0, crlf: self.crlf };
        let result = write(&mut row);
        self.length += row.length;
        result
    }

    #[inline]
    pub(crate) fn indent(&mut self, depth: usize) {
        self.raw(&TABS[..depth.min(TABS.len())]);
    }

    #[inline]
    pub(crate) fn raw(&mut self, bytes: &[u8]) {
        if self.bytes.len() - self.length < bytes.len() {
            self.make_room(bytes.len());
        }
        self.bytes[self.length..][..bytes.len()].copy_from_slice(bytes);
        self.length += bytes.len();
    }

    #[inline]
    pub(crate) fn end_line(&mut self) {
        self.raw(if self.crlf { b"\r\n" } else { b"\n" });
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
        self.raw(itoa::Buffer::new().format(value).as_bytes());
    }

    /// The shortest decimal that reads back to the same value, or a fixed number of digits.
    #[inline]
    pub(crate) fn real(&mut self, value: f32) {
        if !value.is_finite() {
            self.raw(match value {
                f32::INFINITY => b"1.#INF",
                f32::NEG_INFINITY => b"-1.#INF",
                _ => b"-1.#IND",
            });
        } else if let Some(digits) = self.digits {
            self.raw(format!("{value:.digits$}").as_bytes());
        } else {
            self.raw(zmij::Buffer::new().format_finite(value).as_bytes());
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
            for values in rows {
                self.row(|row| values.iter().for_each(|value| row.short(value.to_le_bytes(), 4)));
            }
            return;
        }
        for values in rows {
            if self.digits.is_none() && values.iter().all(|value| value.is_finite()) {
                self.row(|row| row.reals(depth, values));
                continue;
            }
            self.indent(depth);
            for (place, &value) in values.iter().enumerate() {
                if place > 0 {
                    self.raw(b" ");
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

/// The longest [`Row`]: three reals or four whole numbers take two thirds of it.
const ROW: usize = 128;

/// A row on its way into a file. Its length is kept apart so that it stays in a register.
pub(crate) struct Row<'a> {
    bytes: &'a mut [u8; ROW],
    length: usize,
    crlf: bool,
}

impl Row<'_> {
    /// The first so many of a few bytes. Copying all of them takes one instruction.
    #[inline(always)]
    pub(crate) fn short<const N: usize>(&mut self, bytes: [u8; N], length: usize) {
        self.bytes[self.length..][..N].copy_from_slice(&bytes);
        self.length += length;
    }

    /// A text of at most 32 bytes.
    #[inline(always)]
    fn text(&mut self, text: &[u8]) {
        match text.len() {
            8..=16 => self.ends::<8>(text),
            4..8 => self.ends::<4>(text),
            2..4 => self.ends::<2>(text),
            _ => self.bytes[self.length..][..text.len()].copy_from_slice(text),
        }
        self.length += text.len();
    }

    /// Copies a text of `N` to twice `N` bytes by two copies of fixed size, which overlap where it is shorter.
    #[inline(always)]
    fn ends<const N: usize>(&mut self, text: &[u8]) {
        if let (Some(first), Some(last)) = (text.first_chunk::<N>(), text.last_chunk::<N>()) {
            self.bytes[self.length..][..N].copy_from_slice(first);
            self.bytes[self.length + text.len() - N..][..N].copy_from_slice(last);
        }
    }

    /// At most eight tabs.
    #[inline(always)]
    pub(crate) fn indent(&mut self, depth: usize) {
        self.short([b'\t'; 8], depth.min(8));
    }

    /// An index or a smoothing number, and its text where it is short.
    #[inline(always)]
    pub(crate) fn integer(&mut self, value: i64, short: Option<ShortText>) {
        match short {
            Some((text, length)) => self.short(text.to_le_bytes(), length),
            None => self.text(itoa::Buffer::new().format(value).as_bytes()),
        }
    }

    /// Three indices with blanks between them, and their texts where they are short.
    #[inline(always)]
    pub(crate) fn indices(&mut self, indices: &[u32; 3], short: [Option<ShortText>; 3]) {
        for place in 0..3 {
            if place > 0 {
                self.short(*b" ", 1);
            }
            self.integer(i64::from(indices[place]), short[place]);
        }
    }

    /// A line of the shortest decimals of finite values.
    #[inline(always)]
    fn reals<const N: usize>(&mut self, depth: usize, values: &[f32; N]) {
        self.indent(depth);
        for (place, value) in values.iter().enumerate() {
            if place > 0 {
                self.short(*b" ", 1);
            }
            match decimal(value.abs()) {
                Some(text) => {
                    self.short(*b"-", usize::from(value.is_sign_negative()));
                    self.decimal(text);
                }
                None => self.other_real(*value),
            }
        }
        self.end_line();
    }

    #[inline(always)]
    fn decimal(&mut self, Decimal { whole: (whole, whole_length), first, others, length }: Decimal) {
        // The one check of the length is for all three pieces.
        let bytes: &mut [u8; 32] = self.bytes[self.length..].first_chunk_mut().expect("a row has room for its reals");
        let point = whole_length & 15;
        bytes[..8].copy_from_slice(&whole.to_le_bytes());
        bytes[point..][..4].copy_from_slice(&first.to_le_bytes());
        bytes[point + 3..][..8].copy_from_slice(&others.to_le_bytes());
        self.length += point + length;
    }

    /// Very small, very large.
    #[inline(never)]
    fn other_real(&mut self, value: f32) {
        self.text(zmij::Buffer::new().format_finite(value).as_bytes());
    }

    #[inline(always)]
    pub(crate) fn end_line(&mut self) {
        if self.crlf { self.short(*b"\r\n", 2) } else { self.short(*b"\n", 1) }
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
