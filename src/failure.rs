//! Why a verb could not do its work, as sentences for the user.

use std::fmt::Display;
use std::io;
use std::path::Path;

use aam::FileError;
use aam::check::code_info;
use aam_convert::ConvertError;
use aam_scene::SceneFileError;

/// An error as the command line shows it: what is wrong, and what to do about it.
#[derive(Debug)]
pub(crate) struct Failure {
    /// What is wrong, where, and why.
    pub(crate) message: String,
    /// What to do.
    pub(crate) help: Option<String>,
    broken_pipe: bool,
}

impl Failure {
    pub(crate) fn new(message: impl Display) -> Self {
        Self { message: message.to_string(), help: None, broken_pipe: false }
    }

    pub(crate) fn help(mut self, help: impl Display) -> Self {
        self.help = Some(help.to_string());
        self
    }

    /// Message and help in one.
    pub(crate) fn text(&self) -> String {
        match &self.help {
            Some(help) => format!("{}\n{help}", self.message),
            None => self.message.clone(),
        }
    }

    /// True when the reader of our output went away (`aam info … | head`), which is no error.
    pub(crate) fn is_broken_pipe(&self) -> bool {
        self.broken_pipe
    }

    /// An error of the system about a path; `doing` continues "cannot …".
    pub(crate) fn io(path: &Path, doing: &str, error: &io::Error) -> Self {
        let mut failure = Self::new(format_args!("{}: cannot {doing}: {}", path.display(), reason(error)));
        failure.help = advice(path, error);
        failure
    }
}

/// The system's reason without its number.
fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file or folder".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        io::ErrorKind::IsADirectory => "it is a folder".into(),
        io::ErrorKind::StorageFull => "the disk is full".into(),
        io::ErrorKind::ReadOnlyFilesystem => "the file system is read-only".into(),
        _ => {
            let text = error.to_string();
            text.split(" (os error").next().unwrap_or(&text).to_owned()
        }
    }
}

/// What a user can do about an error of the system.
fn advice(path: &Path, error: &io::Error) -> Option<String> {
    match error.kind() {
        io::ErrorKind::NotFound => {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
            match folder {
                Some(folder) if !folder.is_dir() => Some(format!("the folder {} does not exist", folder.display())),
                _ => neighbour(path).map(|name| format!("did you mean {name}?")),
            }
        }
        io::ErrorKind::PermissionDenied => Some("check who owns the file or folder, and its mode (ls -l)".into()),
        _ => None,
    }
}

/// A file in the same folder whose name differs only in letter case or extension.
fn neighbour(path: &Path) -> Option<String> {
    let parent = path.parent().unwrap_or(Path::new(""));
    let folder = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
    let stem = path.file_stem()?.to_string_lossy().to_lowercase();
    let mut names: Vec<_> = std::fs::read_dir(folder)
        .ok()?
        .take(10_000)
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|candidate| candidate.file_stem().is_some_and(|name| name.to_string_lossy().to_lowercase() == stem))
        .filter(|candidate| aam_convert::Format::of(candidate).is_some())
        .collect();
    names.sort();
    names.first().and_then(|name| Some(parent.join(name.file_name()?).display().to_string()))
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        match &error {
            FileError::Open { path, source } => Self::io(path, "read", source),
            FileError::Save { path, source } => Self::io(path, "write", source),
            FileError::Syntax { source, .. } => {
                let failure = Self::new(&error);
                // A limit's message says what to do already.
                match code_info(source.code).filter(|info| !info.code.starts_with("limit/")) {
                    Some(info) => failure.help(info.remedy),
                    None => failure,
                }
            }
            FileError::TooLarge { .. } | FileError::Unwritable { .. } => Self::new(error),
        }
    }
}

impl From<ConvertError> for Failure {
    fn from(error: ConvertError) -> Self {
        match error {
            ConvertError::File(error) => error.into(),
            other => Self::new(other),
        }
    }
}

impl From<SceneFileError> for Failure {
    fn from(error: SceneFileError) -> Self {
        match error {
            SceneFileError::File(error) => error.into(),
            other => Self::new(other),
        }
    }
}

/// Errors of writing to standard output.
impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        let mut failure = Self::new(format_args!("cannot write to standard output: {}", reason(&error)));
        failure.broken_pipe = error.kind() == io::ErrorKind::BrokenPipe;
        failure
    }
}
