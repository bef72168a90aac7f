//! The reader.

use crate::{Document, Finding, ReadError};

/// How to read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadOptions {
    /// Report as an error each irregularity that is otherwise accepted with a warning.
    pub strict: bool,
    /// The largest file in bytes that [`crate::read_file`] opens. Default 4 GiB.
    pub max_file_size: u64,
    /// How deep Multi materials may nest. Default 32.
    pub max_nesting: usize,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self { strict: false, max_file_size: 4 << 30, max_nesting: 32 }
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
    let _ = options;
    Err(ReadError::at(bytes, 0, "internal/unfinished", "the reader is not finished"))
}
