//! Files on disk: reading with a size limit, and writing that never leaves half a file.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use crate::{
    Document, Limit, LimitExceeded, Limits, ReadError, ReadOptions, ReadOutcome, WriteError, WriteOptions, read, write,
};

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The file cannot be opened or read.
    #[error("{}: cannot read: {source}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The file is larger than the limit.
    #[error("{}: {exceeded}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size in bytes and the limit.
        exceeded: LimitExceeded,
    },
    /// The file is not a readable AAM document.
    #[error("{}:{source}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        source: Box<ReadError>,
    },
    /// The document cannot be written in this form.
    #[error("{}: {source}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What stands in the way.
        source: WriteError,
    },
    /// The file cannot be written.
    #[error("{}: cannot write: {source}", path.display())]
    Save {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

/// The bytes of a file no larger than [`Limits::file_size`].
///
/// # Errors
/// [`FileError::Open`] or [`FileError::TooLarge`].
pub fn read_bytes(path: &Path, limits: &Limits) -> Result<Vec<u8>, FileError> {
    let open = |source| FileError::Open { path: path.to_owned(), source };
    let file = File::open(path).map_err(open)?;
    let meta = file.metadata().map_err(open)?;
    if meta.is_dir() {
        return Err(open(io::Error::other("it is a folder")));
    }
    let check = |size| {
        let too_large = |exceeded| FileError::TooLarge { path: path.to_owned(), exceeded };
        limits.check(Limit::FileSize, size).map_err(too_large)
    };
    check(meta.len())?;
    let mut bytes = Vec::new();
    let no_memory = |_| open(io::Error::other(format!("there is no memory for its {} bytes", meta.len())));
    bytes.try_reserve_exact(usize::try_from(meta.len()).unwrap_or(0)).map_err(no_memory)?;
    file.take(limits.file_size.saturating_add(1)).read_to_end(&mut bytes).map_err(open)?;
    check(bytes.len() as u64)?;
    Ok(bytes)
}

/// Reads a document from a file.
///
/// # Errors
/// Any [`FileError`] of reading.
pub fn read_file(path: &Path, options: &ReadOptions) -> Result<ReadOutcome, FileError> {
    let bytes = read_bytes(path, &options.limits)?;
    read(&bytes, options).map_err(|source| FileError::Syntax { path: path.to_owned(), source: Box::new(source) })
}

/// Writes a document to a file, whole or not at all.
///
/// # Errors
/// [`FileError::Unwritable`] or [`FileError::Save`]; an earlier file of that name is then untouched.
pub fn write_file(path: &Path, document: &Document, options: &WriteOptions) -> Result<(), FileError> {
    let bytes = write(document, options).map_err(|source| FileError::Unwritable { path: path.to_owned(), source })?;
    write_bytes(path, &bytes)
}

/// Writes bytes to a temporary file beside `path` and renames it, so that `path` holds its old content or all the new.
///
/// # Errors
/// [`FileError::Save`]; an earlier file of that name is then untouched.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    StagedFile::new(path, bytes)?.commit()
}

/// A file's new content, on disk beside it under a temporary name, so that several files can be written first and
/// then appear together. Dropping it removes the temporary file.
#[derive(Debug)]
pub struct StagedFile {
    path: PathBuf,
    temporary: tempfile::NamedTempFile,
}

impl StagedFile {
    /// Writes the bytes to a temporary file in the folder of `path`. A link is followed, and an earlier file's
    /// permissions are kept.
    ///
    /// # Errors
    /// [`FileError::Save`], also where `path` is something else than a file (a folder, a device).
    pub fn new(path: &Path, bytes: &[u8]) -> Result<Self, FileError> {
        let save = |source| FileError::Save { path: path.to_owned(), source };
        let earlier = std::fs::metadata(path).ok();
        if earlier.as_ref().is_some_and(|earlier| !earlier.is_file()) {
            return Err(save(io::Error::other("it is not a regular file")));
        }
        let target = if path.is_symlink() { path.canonicalize().map_err(save)? } else { path.to_owned() };
        let path = &target;
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".aam-").suffix(".tmp");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // As a plain `File::create` would give; the process umask applies.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let mut temporary = builder.tempfile_in(folder).map_err(save)?;
        temporary.write_all(bytes).map_err(save)?;
        if let Some(earlier) = earlier {
            temporary.as_file().set_permissions(earlier.permissions()).map_err(save)?;
        }
        temporary.as_file().sync_all().map_err(save)?;
        Ok(Self { path: path.to_owned(), temporary })
    }

    /// Gives the file its name, in place of an earlier one.
    ///
    /// # Errors
    /// [`FileError::Save`]; an earlier file of that name is then untouched.
    pub fn commit(self) -> Result<(), FileError> {
        let Self { path, temporary } = self;
        temporary.persist(&path).map(drop).map_err(|error| FileError::Save { path, source: error.error })
    }
}
