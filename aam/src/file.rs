//! Files on disk: reading with a size limit, and writing that never leaves half a file.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use memmap2::{Mmap, MmapOptions};

use crate::large_pages::in_large_pages;
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
    let (file, size) = open(path, limits)?;
    copied(file, size, path, limits)
}

/// Reads a document from a file.
///
/// The file is mapped into memory, so that nothing of it is copied. Another program should not write to it meanwhile: what it
/// changes may be read or not, and where it makes the file shorter, the system may end this process. Programs that put a new file in
/// the place of the old one, as [`write_file`] does, are no trouble. Where files change under a program that must go on, give
/// [`read`] the copy that [`read_bytes`] makes. What cannot be mapped (pipes, devices, files of no stated size) is copied.
///
/// # Errors
/// Any [`FileError`] of reading.
pub fn read_file(path: &Path, options: &ReadOptions) -> Result<ReadOutcome, FileError> {
    let (file, size) = open(path, &options.limits)?;
    let outcome = match mapped(&file, size) {
        Some(map) => read(&map, options),
        None => read(&copied(file, size, path, &options.limits)?, options),
    };
    outcome.map_err(|source| FileError::Syntax { path: path.to_owned(), source: Box::new(source) })
}

/// Opens what is no folder, and gives its size, which is within the limit.
fn open(path: &Path, limits: &Limits) -> Result<(File, u64), FileError> {
    let open = |source| FileError::Open { path: path.to_owned(), source };
    let file = File::open(path).map_err(open)?;
    let meta = file.metadata().map_err(open)?;
    if meta.is_dir() {
        return Err(open(io::Error::other("it is a folder")));
    }
    check_size(path, meta.len(), limits)?;
    Ok((file, meta.len()))
}

fn check_size(path: &Path, size: u64, limits: &Limits) -> Result<(), FileError> {
    let too_large = |exceeded| FileError::TooLarge { path: path.to_owned(), exceeded };
    limits.check(Limit::FileSize, size).map_err(too_large)
}

/// All bytes to the end, which for a pipe may be beyond its size.
fn copied(file: File, size: u64, path: &Path, limits: &Limits) -> Result<Vec<u8>, FileError> {
    let open = |source| FileError::Open { path: path.to_owned(), source };
    let mut bytes = Vec::new();
    let no_memory = |_| open(io::Error::other(format!("there is no memory for its {size} bytes")));
    bytes.try_reserve_exact(usize::try_from(size).unwrap_or(0)).map_err(no_memory)?;
    let mut bytes = in_large_pages(bytes);
    file.take(limits.file_size.saturating_add(1)).read_to_end(&mut bytes).map_err(open)?;
    check_size(path, bytes.len() as u64, limits)?;
    Ok(bytes)
}

/// A map of the file, where it has a size and the system can map it.
fn mapped(file: &File, size: u64) -> Option<Mmap> {
    let length = usize::try_from(size).ok().filter(|length| *length > 0)?;
    #[expect(unsafe_code, reason = "copying a large file takes as long as reading what is in it")]
    // SAFETY: the map is only read, and lives no longer than the call of `read`, whose accesses are all within it whatever the bytes
    // are. Nobody can promise that no other program changes them; `read_file` says what then happens.
    unsafe { MmapOptions::new().len(length).populate().map(file) }.ok()
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
