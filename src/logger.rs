//! Messages of the libraries, wgpu's above all, on standard error.

use std::io::Write;

use log::{Level, LevelFilter, Log, Metadata, Record};

struct Stderr;

impl Log for Stderr {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() <= log::max_level()
    }

    fn log(&self, record: &Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let style = match record.level() {
            Level::Error => anstyle::AnsiColor::Red,
            Level::Warn => anstyle::AnsiColor::Yellow,
            _ => anstyle::AnsiColor::BrightBlack,
        }
        .on_default();
        // Nobody is left to tell when standard error is gone.
        let _ = writeln!(
            anstream::stderr(),
            "{style}{:<5}{style:#} {}: {}",
            record.level().as_str().to_lowercase(),
            record.target(),
            record.args()
        );
    }

    fn flush(&self) {}
}

/// `-vv` shows warnings of the libraries, `-vvv` all they say, `-vvvv` every detail.
pub(crate) fn install(verbose: u8) {
    static LOGGER: Stderr = Stderr;
    if log::set_logger(&LOGGER).is_ok() {
        log::set_max_level(match verbose {
            0 | 1 => LevelFilter::Off,
            2 => LevelFilter::Warn,
            3 => LevelFilter::Debug,
            _ => LevelFilter::Trace,
        });
    }
}
