//! The writer: canonical layout, one line for each tag and row, tabs for indentation.

mod digits;
mod geometry;
mod materials;
mod out;
mod physics;

use crate::Document;
use crate::document::Encoding;

use out::Out;

/// How to write.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// Digits after the point; `None` writes the shortest decimal that reads back to the same `f32`.
    pub digits: Option<u8>,
    /// Text or binary; `None` keeps the document's own encoding.
    pub encoding: Option<Encoding>,
    /// End lines with CR LF.
    pub crlf: bool,
}

/// Why a document cannot be written: it breaks the format's own rules.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{subject}: {message}")]
pub struct WriteError {
    /// Which part of the document.
    pub subject: String,
    /// What stands in the way.
    pub message: String,
}

/// The bytes of a file that holds this document, in canonical layout.
///
/// Reading them back gives an equal document, except that fixed [`WriteOptions::digits`] round.
///
/// # Errors
/// When the document breaks the format's own rules: lists whose lengths do not agree, text with line ends in it,
/// indices outside their lists.
pub fn write(document: &Document, options: &WriteOptions) -> Result<Vec<u8>, WriteError> {
    let binary = options.encoding.unwrap_or(document.encoding) == Encoding::Binary;
    let mut out = Out::new(options, binary, estimate(document, binary));
    if binary {
        out.line(0, "BINARY");
    }
    if let Some(header) = document.header {
        out.line(0, header.word());
    }
    for unknown in &document.preamble {
        out.unknown_lines(0, unknown);
    }
    materials::materials(&mut out, document)?;
    geometry::geometry(&mut out, &document.geometry)?;
    if let Some(physics) = &document.physics {
        physics::physics(&mut out, physics)?;
    }
    out.finish()
}

/// Roughly how many bytes the file takes, rather more than less: of memory that stays untouched there may be too much.
fn estimate(document: &Document, binary: bool) -> usize {
    let objects = document.geometry.frames.iter().flat_map(|frame| &frame.objects);
    let bulk: usize = objects
        .map(|object| {
            let (triangles, coords, indices) = object
                .faces
                .as_ref()
                .map_or((0, 0, 0), |faces| (faces.triangles.len(), faces.tex_coords.len(), faces.tex_indices.len()));
            let vertices = object.vertices.len();
            if binary {
                12 * vertices + 8 * coords + 19 * triangles + 17 * indices
            } else {
                let digits = 1 + vertices.max(coords).max(1).ilog10() as usize;
                42 * vertices + 26 * coords + (20 + 3 * digits) * triangles + (9 + 3 * digits) * indices
            }
        })
        .sum();
    bulk + 1024 * (1 + document.materials.len())
}
