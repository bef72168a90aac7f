//! The files of an export, from memory to disk: all of them written before any of them appears.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::{Component, Path, PathBuf};

use aam::{FileError, Limits, StagedFile, read_bytes};

use crate::{ConvertError, Report, TextureFile};

/// What an exporter made; nothing is on disk yet.
#[derive(Debug, Default)]
pub(crate) struct Files {
    /// The content of the main file.
    pub(crate) main: Vec<u8>,
    /// Further files, by their path relative to the main file's folder, with `/` between its parts.
    pub(crate) beside: BTreeMap<String, TextureFile>,
    /// What became of everything.
    pub(crate) report: Report,
}

/// The path under a folder that a relative name means, with either kind of slash; `None` if it would lead out of it.
pub(crate) fn within(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(name.replace('\\', "/"));
    let inside = path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    // A drive letter is an ordinary part of a name where there are no drives.
    let drive = name.as_bytes().get(1) == Some(&b':');
    (inside && !drive && path.file_name().is_some()).then_some(path)
}

/// A file's name as it can stand in a document, whose lines have no blanks at their ends.
pub(crate) fn nameable(name: &str) -> String {
    let name = name.trim_matches([' ', '\t']);
    if name.is_empty() { "texture".into() } else { name.into() }
}

/// What stands in the way of files that exist.
#[derive(Clone, Copy)]
pub(crate) struct Replace<'a> {
    /// Never written to.
    pub(crate) input: Option<&'a Path>,
    /// The main file may replace another.
    pub(crate) main: bool,
    /// Files beside it may replace others.
    pub(crate) beside: bool,
}

/// Writes all files, the main one last, and gives the paths of those that changed.
///
/// A file that exists with the same content, or that is the texture itself, is left. One with other content is an error
/// unless `replace` allows it. Everything is written under temporary names first, so that an error leaves nothing changed
/// (but new folders).
pub(crate) fn save(path: &Path, files: &Files, replace: Replace) -> Result<Vec<PathBuf>, ConvertError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let input = replace.input.map(identity);
    let mut targets: Vec<(PathBuf, Source)> = Vec::new();
    for (name, file) in &files.beside {
        let Some(relative) = within(name) else {
            return Err(ConvertError::Option(format!(
                "the file \"{name}\" would be written outside {}",
                folder.display()
            )));
        };
        let source = match file {
            TextureFile::OnDisk(source) => Source::Disk(source),
            TextureFile::InMemory(bytes) => Source::Memory(bytes),
        };
        targets.push((folder.join(relative), source));
    }
    targets.push((path.to_owned(), Source::Memory(&files.main)));

    let mut occupied = Vec::new();
    let mut changed = Vec::new();
    for (index, (target, source)) in targets.iter().enumerate() {
        if source.is_already(target)? {
            continue;
        }
        if target.exists() {
            if input.is_some() && input == Some(identity(target)) {
                let message = format!("{}: this is the input; give the output another name", target.display());
                return Err(ConvertError::Option(message));
            }
            let may = if index + 1 == targets.len() { replace.main } else { replace.beside };
            if !may || target.is_dir() {
                occupied.push(target.display().to_string());
            }
        }
        changed.push((target, source));
    }
    if !occupied.is_empty() {
        return Err(ConvertError::Option(format!(
            "{}: {} with other content; write to another place, or replace with --force",
            occupied.join(", "),
            if occupied.len() == 1 { "exists" } else { "exist" },
        )));
    }

    let mut staged = Vec::new();
    for (target, source) in &changed {
        if let Some(parent) = target.parent().filter(|parent| !parent.as_os_str().is_empty()) {
            let failed = |source| FileError::Save { path: parent.to_owned(), source };
            std::fs::create_dir_all(parent).map_err(failed)?;
        }
        staged.push(match source {
            Source::Memory(bytes) => StagedFile::new(target, bytes)?,
            Source::Disk(path) => {
                StagedFile::new(target, &read_bytes(path, &Limits { file_size: u64::MAX, ..Limits::DEFAULT })?)?
            }
        });
    }
    for file in staged {
        file.commit()?;
    }
    Ok(changed.into_iter().map(|(target, _)| target.clone()).collect())
}

enum Source<'a> {
    Disk(&'a Path),
    Memory(&'a [u8]),
}

impl Source<'_> {
    /// Whether a file has this content already.
    fn is_already(&self, target: &Path) -> Result<bool, ConvertError> {
        let Ok(existing) = File::open(target) else { return Ok(false) };
        let failed = |path: &Path, source| FileError::Open { path: path.to_owned(), source };
        let size = existing.metadata().map_err(|error| failed(target, error))?;
        if !size.is_file() {
            return Ok(false);
        }
        match self {
            Self::Disk(path) if identity(path) == identity(target) => Ok(true),
            Self::Disk(path) => {
                let new = File::open(path).map_err(|error| failed(path, error))?;
                let length = new.metadata().map_err(|error| failed(path, error))?.len();
                Ok(length == size.len() && same(existing, new).map_err(|error| failed(path, error))?)
            }
            Self::Memory(bytes) => {
                Ok(bytes.len() as u64 == size.len() && same(existing, *bytes).map_err(|error| failed(target, error))?)
            }
        }
    }
}

fn same(a: impl io::Read, b: impl io::Read) -> io::Result<bool> {
    let (mut a, mut b) = (BufReader::new(a), BufReader::new(b));
    loop {
        let (x, y) = (a.fill_buf()?, b.fill_buf()?);
        let length = x.len().min(y.len());
        if length == 0 {
            return Ok(x.is_empty() && y.is_empty());
        }
        if x[..length] != y[..length] {
            return Ok(false);
        }
        a.consume(length);
        b.consume(length);
    }
}

/// One path for one file, however it is written.
fn identity(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(main: &[u8], beside: &[(&str, &[u8])]) -> Files {
        let file = |(name, bytes): &(&str, &[u8])| ((*name).to_owned(), TextureFile::InMemory((*bytes).into()));
        Files { main: main.into(), beside: beside.iter().map(file).collect(), report: Report::default() }
    }

    const CAREFUL: Replace<'_> = Replace { input: None, main: false, beside: false };

    #[test]
    fn names_that_lead_out_of_the_folder() {
        assert_eq!(within("a/b.png"), Some("a/b.png".into()));
        assert_eq!(within("a\\b c.png"), Some("a/b c.png".into()));
        for name in ["../a.png", "a/../../b.png", "/etc/passwd", "C:\\a.png", "\\\\host\\a.png", "", ".", ".."] {
            assert_eq!(within(name), None, "{name}");
        }
        let folder = tempfile::tempdir().unwrap();
        let escape = files(b"x", &[("../a.png", b"y")]);
        assert!(save(&folder.path().join("deep/x.aam"), &escape, CAREFUL).is_err());
    }

    #[test]
    fn writes_all_or_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.aam");
        let first = files(b"one", &[("t/a.png", b"A"), ("b.png", b"B")]);
        assert_eq!(save(&path, &first, CAREFUL).unwrap().len(), 3);
        assert_eq!(std::fs::read(folder.path().join("t/a.png")).unwrap(), b"A");
        // The same again touches nothing.
        assert_eq!(save(&path, &first, CAREFUL).unwrap(), Vec::<PathBuf>::new());

        let second = files(b"two", &[("t/a.png", b"A"), ("b.png", b"C"), ("new.png", b"N")]);
        let error = save(&path, &second, Replace { main: true, ..CAREFUL }).unwrap_err().to_string();
        assert!(error.contains("b.png: exists with other content") && !error.contains("a.png"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), b"one");
        assert!(!folder.path().join("new.png").exists());

        let written = save(&path, &second, Replace { main: true, beside: true, input: None }).unwrap();
        assert_eq!(written.last(), Some(&path));
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(names.len(), 4, "temporary files remain: {names:?}");
    }

    #[test]
    fn the_input_is_never_replaced_and_a_texture_in_place_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.aam");
        std::fs::write(&path, b"input").unwrap();
        let all = Replace { input: Some(&path), main: true, beside: true };
        let error = save(&folder.path().join("./m.aam"), &files(b"output", &[]), all).unwrap_err().to_string();
        assert!(error.contains("this is the input"), "{error}");

        let texture = folder.path().join("a.png");
        std::fs::write(&texture, b"pixels").unwrap();
        let mut output = files(b"x", &[]);
        output.beside.insert("a.png".into(), TextureFile::OnDisk(texture.clone()));
        let other = folder.path().join("n.aam");
        assert_eq!(save(&other, &output, CAREFUL).unwrap(), std::slice::from_ref(&other));
        let elsewhere = folder.path().join("sub/n.aam");
        assert_eq!(save(&elsewhere, &output, CAREFUL).unwrap().len(), 2);
        assert_eq!(std::fs::read(folder.path().join("sub/a.png")).unwrap(), b"pixels");
    }
}
