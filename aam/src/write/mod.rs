//! The writer.

use crate::Document;

/// How to write.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// Digits after the point; `None` writes the shortest decimal that reads back to the same `f32`.
    pub digits: Option<u8>,
    /// Text or binary; `None` keeps the document's own encoding.
    pub encoding: Option<crate::document::Encoding>,
    /// End lines with CR LF.
    pub crlf: bool,
}

/// Why a document cannot be written.
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
/// # Errors
/// When the document breaks the format's own rules: counts that do not agree, text with line ends.
pub fn write(document: &Document, options: &WriteOptions) -> Result<Vec<u8>, WriteError> {
    let _ = (document, options);
    Err(WriteError { subject: "document".into(), message: "the writer is not finished".into() })
}
