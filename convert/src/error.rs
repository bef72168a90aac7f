//! Why a conversion failed.

use std::path::PathBuf;

use aam::LimitExceeded;

/// Why a conversion failed. Each message says what, where, why, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum ConvertError {
    /// Reading or writing a file failed.
    #[error(transparent)]
    File(#[from] aam::FileError),
    /// The extension names no known format.
    #[error("{}: unknown format; known extensions are {known}", path.display())]
    UnknownFormat {
        /// The path.
        path: PathBuf,
        /// What would have been accepted.
        known: &'static str,
    },
    /// The input is broken. `place` is a line and column, a JSON pointer or a byte offset.
    #[error("{}: {place}: {message}", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// Where in the file.
        place: String,
        /// What is wrong.
        message: String,
    },
    /// The input needs something that this program does not have.
    #[error("{}: {feature} is not supported; {way_out}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The extension or feature.
        feature: String,
        /// What to do instead.
        way_out: String,
    },
    /// The input holds more than a limit allows.
    #[error("{}: {exceeded}{}", path.display(), way_out.map(|way_out| format!(", or {way_out}")).unwrap_or_default())]
    Limit {
        /// The file.
        path: PathBuf,
        /// What is too much, and the limit.
        exceeded: LimitExceeded,
        /// What to do instead of raising the limit.
        way_out: Option<&'static str>,
    },
    /// An option does not fit the input.
    #[error("{0}")]
    Option(String),
}
