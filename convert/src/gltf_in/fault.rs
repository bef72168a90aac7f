//! What stops an import, before the name of the file is put in front of it.

use std::path::Path;

use aam::LimitExceeded;

use crate::ConvertError;

/// Why the file cannot be imported.
#[derive(Debug)]
pub(super) enum Fault {
    /// The file contradicts itself or the specification. `place` is a JSON pointer or a byte offset.
    Broken { place: String, message: String },
    /// The file needs something that this importer does not have.
    Unsupported { feature: String, way_out: String },
    /// The document would be over a limit that the user can raise.
    Limit { exceeded: LimitExceeded, way_out: &'static str },
    /// Anything that already knows its file.
    Other(ConvertError),
}

/// The result of everything that reads a part of the file.
pub(super) type Checked<T> = Result<T, Fault>;

impl Fault {
    pub(super) fn broken(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Broken { place: place.into(), message: message.into() }
    }

    pub(super) fn unsupported(feature: impl Into<String>, way_out: impl Into<String>) -> Self {
        Self::Unsupported { feature: feature.into(), way_out: way_out.into() }
    }

    /// The error for the user, with the file that it is about.
    pub(super) fn into_error(self, path: &Path) -> ConvertError {
        match self {
            Self::Broken { place, message } => ConvertError::Broken { path: path.to_owned(), place, message },
            Self::Unsupported { feature, way_out } => {
                ConvertError::Unsupported { path: path.to_owned(), feature, way_out }
            }
            Self::Limit { exceeded, way_out } => {
                ConvertError::Limit { path: path.to_owned(), exceeded, way_out: Some(way_out) }
            }
            Self::Other(error) => error,
        }
    }
}

impl From<ConvertError> for Fault {
    fn from(error: ConvertError) -> Self {
        Self::Other(error)
    }
}

impl From<aam::FileError> for Fault {
    fn from(error: aam::FileError) -> Self {
        Self::Other(error.into())
    }
}
