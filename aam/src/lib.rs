//! AAM, the "Ascii Animated Mesh" format of the XVR system: reading, writing, checking, and what a document means.
//!
//! ```
//! let source = b"MATERIALS\nMatCount: 0\nENDMATERIALS\nGEOMETRY\nNObj: 0\nNFrames: 0\nAnimation_mode: None\nENDGEOMETRY\n";
//! let outcome = aam::read(source, &aam::ReadOptions::default())?;
//! assert!(outcome.findings.is_empty());
//! let bytes = aam::write(&outcome.document, &aam::WriteOptions::default())?;
//! assert_eq!(bytes, source);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod check;
mod diagnostics;
pub mod document;
mod file;
mod large_pages;
mod limits;
pub mod meaning;
mod nearest;
mod read;
mod text;
mod write;

pub use check::check;
pub use diagnostics::{Excerpt, Finding, Position, PositionWalk, ReadError, Severity};
pub use document::Document;
pub use file::{FileError, StagedFile, read_bytes, read_file, write_bytes, write_file};
pub use limits::{Limit, LimitExceeded, Limits};
pub use nearest::nearest;
pub use read::{Places, ReadOptions, ReadOutcome, read};
pub use text::Text;
pub use write::{WriteError, WriteOptions, write};
