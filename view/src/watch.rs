//! Following a file and what it refers to on disk.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use notify::{EventKind, RecommendedWatcher, RecursiveMode, Watcher};

/// Editors and exporters write in several steps: a change counts once there was none for this long.
const QUIET: Duration = Duration::from_millis(200);

/// Watches until it is dropped.
pub(crate) struct Watch {
    _watcher: RecommendedWatcher,
}

impl Watch {
    /// Calls `changed` after any of the files was written, replaced, removed or made.
    ///
    /// Folders are watched rather than files, because a file that is replaced as a whole is another file.
    pub(crate) fn new(files: &[PathBuf], changed: impl Fn() + Send + 'static) -> Result<Self, String> {
        let watched: BTreeSet<PathBuf> = files.iter().map(|file| absolute(file)).collect();
        let folders: BTreeSet<PathBuf> = watched.iter().filter_map(|file| file.parent().map(Path::to_owned)).collect();
        let (sender, receiver) = mpsc::channel::<()>();
        let mut watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
            let Ok(event) = event else { return };
            if matches!(event.kind, EventKind::Access(_)) {
                return;
            }
            if event.paths.iter().any(|path| watched.contains(&absolute(path))) {
                // The receiver goes away only with the watcher.
                let _ = sender.send(());
            }
        })
        .map_err(|error| error.to_string())?;
        let mut failures = Vec::new();
        for folder in folders {
            if let Err(error) = watcher.watch(&folder, RecursiveMode::NonRecursive) {
                failures.push(format!("{}: {error}", folder.display()));
            }
        }
        if let Some(failure) = failures.first() {
            return Err(failure.clone());
        }
        std::thread::spawn(move || {
            while receiver.recv().is_ok() {
                loop {
                    match receiver.recv_timeout(QUIET) {
                        Ok(()) => {}
                        Err(RecvTimeoutError::Timeout) => break,
                        Err(RecvTimeoutError::Disconnected) => return,
                    }
                }
                changed();
            }
        });
        Ok(Self { _watcher: watcher })
    }
}

/// The path with its folder resolved; the file itself need not exist.
fn absolute(path: &Path) -> PathBuf {
    let name: OsString = path.file_name().map(OsString::from).unwrap_or_default();
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    folder.canonicalize().unwrap_or_else(|_| folder.to_owned()).join(name)
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::Instant;

    use super::*;

    fn wait_for(count: &AtomicUsize, wanted: usize) {
        let start = Instant::now();
        while count.load(Ordering::SeqCst) < wanted && start.elapsed() < Duration::from_secs(10) {
            std::thread::sleep(Duration::from_millis(20));
        }
        assert_eq!(count.load(Ordering::SeqCst), wanted);
    }

    #[test]
    fn a_change_is_told_once_and_others_not_at_all() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join("model.aam");
        let texture = folder.path().join("missing.png");
        fs::write(&file, "one").expect("write");
        let count = Arc::new(AtomicUsize::new(0));
        let told = Arc::clone(&count);
        let _watch = Watch::new(&[file.clone(), texture.clone()], move || {
            told.fetch_add(1, Ordering::SeqCst);
        })
        .expect("a watch");
        for _ in 0..5 {
            fs::write(&file, "two").expect("write");
        }
        wait_for(&count, 1);
        fs::write(folder.path().join("other.txt"), "x").expect("write");
        fs::read(&file).expect("read");
        std::thread::sleep(3 * QUIET);
        wait_for(&count, 1);
        let temporary = folder.path().join("tmp");
        fs::write(&temporary, "three").expect("write");
        fs::rename(&temporary, &file).expect("rename");
        wait_for(&count, 2);
        fs::write(&texture, "png").expect("write");
        wait_for(&count, 3);
    }
}
