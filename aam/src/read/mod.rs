//! The reader: the grammar in nom parsers, bulk numbers in leaf parsers of our own.
//!
//! A parser takes the rest of the file and gives what it read and the new rest, so a place is just how many bytes are
//! left. `Err::Error` means "not here", `Err::Failure` means "wrong here". Each function's comment is its production in
//! the grammar of `docs/format.md`.

mod ahead;
mod animation;
mod bulk;
mod context;
mod fault;
mod geometry;
mod materials;
mod number;
mod physics;
mod short;
mod tags;
mod triangles;

use nom::Parser;
use nom::combinator::opt;

use crate::document::{Encoding, Header, Unknown};
use crate::{Document, Finding, Limits, ReadError};

use context::{Block, Context, found, suggestion};
use fault::{Fault, Parsed, Rest};
use number::skip_space;
use tags::{peek_word, word};

/// How to read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadOptions {
    /// Report as an error each irregularity that is otherwise accepted with a warning.
    pub strict: bool,
    /// How large the document may be; [`Limits::file_size`] is what [`crate::read_file`] opens.
    pub limits: Limits,
    /// How many threads may read the rows of a large list at the same time; 0 counts as 1. What is read does not depend on
    /// it. Default: what the system has for this process.
    pub threads: usize,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            strict: false,
            limits: Limits::default(),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
        }
    }
}

/// A document that was read, and what was odd about it.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOutcome {
    /// The document.
    pub document: Document,
    /// Warnings, in file order.
    pub findings: Vec<Finding>,
    /// Where its parts stand in the file.
    pub places: Places,
}

/// Byte offsets of a document's parts, for findings that are made after reading.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Places {
    /// `Mat#` lines, by position in the document.
    pub materials: Vec<usize>,
    /// `Obj:` lines, frame by frame.
    pub objects: Vec<Vec<usize>>,
    /// `Body:` lines.
    pub bodies: Vec<usize>,
}

/// Reads a document from the bytes of a file.
///
/// # Errors
/// The first thing that cannot be accepted; in strict mode also everything that is otherwise a warning.
pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<ReadOutcome, ReadError> {
    let cx = Context::new(bytes, options);
    match file(&cx, bytes) {
        Ok((_, (document, places))) => Ok(ReadOutcome { document, findings: cx.findings(), places }),
        Err(fault) => Err(cx.error(fault)),
    }
}

/// `file = [ "BINARY" ] [ header ] [ SHADERS ] materials geometry [ physics ]`
fn file<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, (Document, Places)> {
    let rest = match rest.strip_prefix(b"\xef\xbb\xbf") {
        Some(tail) => {
            cx.warn(rest, "syntax/byte-order-mark", "the UTF-8 byte order mark is skipped")?;
            tail
        }
        None => rest,
    };
    let (rest, binary) = opt(word("BINARY")).parse(rest)?;
    cx.binary.set(binary.is_some());
    let (rest, header) = opt(header).parse(rest)?;
    let (rest, preamble) = preamble(cx, rest)?;
    let (rest, materials) = materials::materials(cx, rest)?;
    let (rest, (geometry, objects)) = geometry::geometry(cx, rest)?;
    let (rest, physics) = if peek_word(rest) == b"PHYSICS" {
        physics::physics(cx, rest).map(|(r, p)| (r, Some(p)))?
    } else {
        (rest, None)
    };
    let end = skip_space(rest);
    if !end.is_empty() {
        let hint = match suggestion(peek_word(end), ["PHYSICS"]) {
            Some(section) if physics.is_none() => format!("; did you mean {section}?"),
            _ => String::new(),
        };
        let message = format!("{} after the end of the document is ignored{hint}", found(end));
        cx.warn(end, "syntax/trailing-text", message)?;
    }
    let (physics, bodies) = physics.unzip();
    let document = Document {
        encoding: if binary.is_some() { Encoding::Binary } else { Encoding::Ascii },
        header,
        preamble,
        materials: materials.materials,
        materials_unknown: materials.unknown,
        geometry,
        physics,
    };
    let places = Places { materials: materials.places, objects, bodies: bodies.unwrap_or_default() };
    Ok((rest, (document, places)))
}

fn header(rest: Rest<'_>) -> Parsed<'_, Header> {
    let start = skip_space(rest);
    let found = peek_word(start);
    let headers = [Header::Mesh, Header::MeshMultiframe, Header::Character, Header::Avatar];
    match headers.into_iter().find(|header| header.word().as_bytes() == found) {
        Some(header) => Ok((&start[found.len()..], header)),
        None => Fault::expected(start, "a header word"),
    }
}

/// Text before `MATERIALS`.
fn preamble<'a>(cx: &Context<'a>, mut rest: Rest<'a>) -> Parsed<'a, Vec<Unknown>> {
    let mut kept = Vec::new();
    while peek_word(rest) == b"SHADERS" {
        let (tail, unknown) = tags::shaders(cx, rest)?;
        kept.push(unknown);
        rest = tail;
    }
    const HINTS: &[&str] = &[
        "SHADERS",
        Header::Mesh.word(),
        Header::MeshMultiframe.word(),
        Header::Character.word(),
        Header::Avatar.word(),
    ];
    // `BINARY` is known here, since kept as unknown text it would let binary lists be read as text.
    let block = Block::with_hints(&["BINARY", "MATERIALS", "ENDMATERIALS"], HINTS);
    let (tail, _) = match tags::block_tag(cx, &block, "MATERIALS").parse(rest) {
        Err(nom::Err::Error(fault)) => {
            let end = &rest[rest.len() - fault.left..];
            tags::misspelt(&block, rest, "MATERIALS")?;
            if peek_word(end) == b"BINARY" {
                let message = "expected `MATERIALS`, found `BINARY`, which belongs at the start of the file";
                return Fault::fatal(skip_space(end), "syntax/tag-order", message);
            }
            Fault::expected(skip_space(rest), "an AAM document, which starts with `MATERIALS`")?
        }
        other => other?,
    };
    kept.extend(block.into_unknown());
    // `MATERIALS` itself is read again by its section.
    Ok((&rest[rest.len() - tail.len() - "MATERIALS".len()..], kept))
}
