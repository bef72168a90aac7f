//! A progress bar on work that lasts more than half a second.

use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::time::Duration;

use aam_convert::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::terminal::Terminal;

const DELAY: Duration = Duration::from_millis(500);
const TICK: Duration = Duration::from_millis(100);

/// Shows nothing for half a second, then a bar on standard error if that is a terminal; goes away when dropped.
pub(crate) struct Bar {
    bar: ProgressBar,
    _shown_unless_dropped: Option<Sender<()>>,
}

impl Bar {
    pub(crate) fn new(terminal: &Terminal) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden()).with_style(spinner());
        if terminal.quiet() || !console_is_terminal() {
            return Self { bar, _shown_unless_dropped: None };
        }
        let (sender, receiver) = mpsc::channel::<()>();
        let late = bar.clone();
        std::thread::spawn(move || {
            if receiver.recv_timeout(DELAY) == Err(RecvTimeoutError::Timeout) {
                late.set_draw_target(ProgressDrawTarget::stderr());
                late.enable_steady_tick(TICK);
            }
        });
        Self { bar, _shown_unless_dropped: Some(sender) }
    }

    /// Says what is done now, without another stage.
    pub(crate) fn name(&self, doing: &str) {
        self.bar.set_message(doing.to_owned());
    }
}

fn console_is_terminal() -> bool {
    use std::io::IsTerminal;
    std::io::stderr().is_terminal()
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn stage(&self, name: &str, total: u64) {
        if total == 0 {
            self.bar.set_style(spinner());
            self.bar.unset_length();
        } else {
            self.bar.set_style(steps());
            self.bar.set_length(total);
        }
        self.bar.set_position(0);
        self.bar.set_message(name.to_owned());
    }

    fn step(&self, done: u64) {
        self.bar.set_position(done);
    }
}

fn spinner() -> ProgressStyle {
    ProgressStyle::with_template("{spinner} {msg} {elapsed:.dim}").unwrap_or_else(|_| ProgressStyle::default_spinner())
}

fn steps() -> ProgressStyle {
    ProgressStyle::with_template("{spinner} {msg} [{bar:30}] {percent}% {eta:.dim}")
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ")
}
