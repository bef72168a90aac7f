//! The header: which elements follow, and of what they are made.

use crate::ConvertError;
use crate::source::{Source, Words, shown};

pub(super) struct Header {
    pub(super) format: Format,
    pub(super) elements: Vec<Element>,
    /// `comment TextureFile`.
    pub(super) texture: Option<String>,
    /// Where the data begins.
    pub(super) end: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Text,
    LittleEndian,
    BigEndian,
}

pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    /// Where the `element` line stands.
    pub(super) offset: usize,
}

pub(super) struct Property {
    pub(super) name: String,
    /// The type of a list's length.
    pub(super) length: Option<Type>,
    pub(super) kind: Type,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn of(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// What full intensity of a colour is.
    pub(super) const fn white(self) -> f64 {
        match self {
            Self::I8 | Self::U8 => 255.0,
            Self::I16 | Self::U16 => 65535.0,
            Self::I32 | Self::U32 => 4_294_967_295.0,
            Self::F32 | Self::F64 => 1.0,
        }
    }
}

impl Element {
    /// The least bytes that one of them takes.
    pub(super) fn least_size(&self, format: Format) -> u64 {
        let least = |property: &Property| match (format, property.length) {
            // A digit and a blank.
            (Format::Text, _) => 2,
            (_, Some(length)) => length.size(),
            (_, None) => property.kind.size(),
        };
        self.properties.iter().map(least).sum::<usize>() as u64
    }
}

/// A header longer than this is none.
const MOST_BYTES: usize = 1 << 20;

/// The next word of a header line that begins at `start`.
fn next<'a>(
    source: Source,
    start: usize,
    words: &mut Words<'a>,
    what: &str,
) -> Result<(usize, &'a [u8]), ConvertError> {
    let missing = || format!("expected {what}, found the end of the line");
    words.next().ok_or_else(|| source.broken(start + words.at, missing()))
}

pub(super) fn parse(source: Source) -> Result<Header, ConvertError> {
    let mut lines = Words::new(source.bytes, 0);
    if lines.line().trim_ascii() != b"ply" {
        return Err(source.broken(0, "expected `ply` on the first line"));
    }
    let mut format = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut texture = None;
    loop {
        let start = lines.at;
        if start >= source.bytes.len().min(MOST_BYTES) {
            return Err(source.broken(start.min(source.bytes.len()), "the header does not end (`end_header`)"));
        }
        let line = lines.line();
        let mut words = Words::new(line, 0);
        let unknown = |(at, word): (usize, &[u8]), what: &str| source.expected(what, Some((start + at, word)), 0);
        let Some(keyword) = words.next() else { continue };
        match keyword.1 {
            b"format" => {
                let word = next(source, start, &mut words, "a format")?;
                format = Some(match word.1 {
                    b"ascii" => Format::Text,
                    b"binary_little_endian" => Format::LittleEndian,
                    b"binary_big_endian" => Format::BigEndian,
                    _ => return Err(unknown(word, "`ascii`, `binary_little_endian` or `binary_big_endian`")),
                });
            }
            b"comment" => {
                if words.next().is_some_and(|(_, word)| word == b"TextureFile") {
                    texture = Some(aam::Text::from(line[words.at..].trim_ascii()).decoded());
                }
            }
            b"obj_info" => {}
            b"element" => {
                let (_, name) = next(source, start, &mut words, "an element's name")?;
                let word = next(source, start, &mut words, "a count")?;
                let count = std::str::from_utf8(word.1).ok().and_then(|digits| digits.parse::<u64>().ok());
                let count = count.ok_or_else(|| unknown(word, "a count"))?;
                elements.push(Element { name: shown(name), count, properties: Vec::new(), offset: start });
            }
            b"property" => {
                let Some(element) = elements.last_mut() else {
                    return Err(source.broken(start, "`property` stands before the first `element`"));
                };
                let kind = |word: (usize, &[u8])| Type::of(word.1).ok_or_else(|| unknown(word, "a type"));
                let first = next(source, start, &mut words, "a type")?;
                let (length, kind) = if first.1 == b"list" {
                    (
                        Some(kind(next(source, start, &mut words, "a type")?)?),
                        kind(next(source, start, &mut words, "a type")?)?,
                    )
                } else {
                    (None, kind(first)?)
                };
                let (_, name) = next(source, start, &mut words, "a property's name")?;
                element.properties.push(Property { name: shown(name), length, kind });
            }
            b"end_header" => break,
            _ => return Err(unknown((keyword.0, keyword.1), "`element`, `property`, `comment` or `end_header`")),
        }
    }
    let format = format.ok_or_else(|| source.broken(0, "the header has no `format` line"))?;
    Ok(Header { format, elements, texture, end: lines.at })
}
