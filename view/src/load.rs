//! Opening files on a thread of its own, so that the window stays alive.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::sync::{Arc, Mutex, PoisonError};

use crate::{Opened, Opener};

/// Opens one file at a time.
pub(crate) struct Loader {
    opener: Opener,
    /// Wakes the window's thread.
    wake: Arc<dyn Fn() + Send + Sync>,
    job: Option<Job>,
}

struct Job {
    path: PathBuf,
    reload: bool,
    /// The file changed again while it was read.
    again: bool,
    stage: Arc<Mutex<String>>,
    receiver: Receiver<Result<Opened, String>>,
}

/// A file that was opened, or why not.
pub(crate) struct Finished {
    pub(crate) path: PathBuf,
    /// The same file as before.
    pub(crate) reload: bool,
    pub(crate) result: Result<Opened, String>,
}

impl Loader {
    pub(crate) fn new(opener: Opener, wake: Arc<dyn Fn() + Send + Sync>) -> Self {
        Self { opener, wake, job: None }
    }

    /// Starts to open a file; what is being opened is forgotten, unless it is the same file, which is then read again
    /// when it is done: a file that changes all the time does not pile up threads.
    pub(crate) fn start(&mut self, path: &Path, reload: bool) {
        if let Some(job) = &mut self.job
            && job.path == path
        {
            job.again = true;
            return;
        }
        let (sender, receiver) = mpsc::channel();
        let stage = Arc::new(Mutex::new(String::new()));
        let (opener, wake, told, file) =
            (Arc::clone(&self.opener), Arc::clone(&self.wake), Arc::clone(&stage), path.to_owned());
        std::thread::spawn(move || {
            let _wakes_even_after_a_panic = Wake(&*wake);
            let result = opener(&file, &|stage: &str| {
                *told.lock().unwrap_or_else(PoisonError::into_inner) = stage.to_owned();
                wake();
            });
            // Nobody waits for it any more when another file was opened meanwhile.
            let _ = sender.send(result);
        });
        self.job = Some(Job { path: path.to_owned(), reload, again: false, stage, receiver });
    }

    /// The file being opened, and what is being done with it.
    pub(crate) fn stage(&self) -> Option<(&Path, String)> {
        let job = self.job.as_ref()?;
        Some((&job.path, job.stage.lock().unwrap_or_else(PoisonError::into_inner).clone()))
    }

    /// What has been opened since the last call.
    pub(crate) fn finished(&mut self) -> Option<Finished> {
        let job = self.job.as_ref()?;
        let result = match job.receiver.try_recv() {
            Ok(result) => result,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err("reading stopped because of a mistake in this program".into()),
        };
        let job = self.job.take()?;
        if job.again {
            self.start(&job.path, job.reload);
            return None;
        }
        Some(Finished { path: job.path, reload: job.reload, result })
    }
}

struct Wake<'a>(&'a (dyn Fn() + Send + Sync));

impl Drop for Wake<'_> {
    fn drop(&mut self) {
        (self.0)();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::{Duration, Instant};

    use super::*;

    fn loader(opener: impl Fn(&Path) -> Result<Opened, String> + Send + Sync + 'static) -> Loader {
        Loader::new(Arc::new(move |path: &Path, _: &dyn Fn(&str)| opener(path)), Arc::new(|| {}))
    }

    fn wait(loader: &mut Loader) -> Finished {
        let start = Instant::now();
        loop {
            if let Some(finished) = loader.finished() {
                return finished;
            }
            assert!(start.elapsed() < Duration::from_secs(10), "nothing was opened");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn the_last_file_asked_for_comes() {
        let mut loader = loader(|path| Err(path.display().to_string()));
        loader.start(Path::new("one"), false);
        loader.start(Path::new("two"), false);
        let finished = wait(&mut loader);
        assert_eq!(finished.result.err().as_deref(), Some("two"));
        assert!(loader.finished().is_none() && loader.stage().is_none());
    }

    #[test]
    fn changes_while_reading_lead_to_one_more_reading() {
        let count = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&count);
        let mut loader = loader(move |_| {
            counted.fetch_add(1, Ordering::SeqCst);
            std::thread::sleep(Duration::from_millis(50));
            Err("done".into())
        });
        for _ in 0..10 {
            loader.start(Path::new("one"), true);
        }
        assert!(wait(&mut loader).reload);
        assert_eq!(count.load(Ordering::SeqCst), 2);
    }

    #[test]
    fn a_mistake_while_reading_is_told() {
        let mut loader = loader(|_| panic!("on purpose"));
        loader.start(Path::new("one"), false);
        assert!(wait(&mut loader).result.is_err_and(|reason| reason.contains("mistake")));
    }
}
