//! Where messages go: results to standard output, everything else to standard error.

use std::fmt::{Arguments, Display};
use std::io::{self, Write};

use anstyle::{AnsiColor, Style};

use crate::cli::Global;
use crate::failure::Failure;

/// Bold.
pub(crate) const BOLD: Style = Style::new().bold();
/// Less important.
pub(crate) const DIM: Style = AnsiColor::BrightBlack.on_default();
/// Errors, and what was lost.
pub(crate) const RED: Style = AnsiColor::Red.on_default().bold();
/// Warnings, and what was changed.
pub(crate) const YELLOW: Style = AnsiColor::Yellow.on_default().bold();
/// What is well.
pub(crate) const GREEN: Style = AnsiColor::Green.on_default().bold();

/// Text in a style; the stream strips it where colours are not wanted (`NO_COLOR`, no terminal).
pub(crate) fn styled(style: Style, text: impl Display) -> String {
    format!("{style}{text}{style:#}")
}

/// The user's side of the program.
pub(crate) struct Terminal {
    quiet: bool,
    verbose: u8,
}

impl Terminal {
    pub(crate) fn new(global: &Global) -> Self {
        Self { quiet: global.quiet, verbose: global.verbose }
    }

    /// `-v`: all details.
    pub(crate) fn verbose(&self) -> bool {
        self.verbose > 0
    }

    /// `-q`: only errors.
    pub(crate) fn quiet(&self) -> bool {
        self.quiet
    }

    /// What the user asked for; printed even with `-q`.
    pub(crate) fn result(&self, text: impl Display) -> io::Result<()> {
        write_stdout(format_args!("{text}\n"))
    }

    /// What was done; not with `-q`.
    pub(crate) fn summary(&self, text: impl Display) -> io::Result<()> {
        if self.quiet { Ok(()) } else { write_stdout(format_args!("{text}\n")) }
    }

    /// Beside the result, on standard error; also with `-q`.
    pub(crate) fn always(&self, text: impl Display) {
        write_stderr(format_args!("{text}\n"));
    }

    /// Something that the user should know, though the work goes on; not with `-q`.
    pub(crate) fn note(&self, text: impl Display) {
        if !self.quiet {
            write_stderr(format_args!("{}: {text}\n", styled(DIM, "note")));
        }
    }

    /// Something odd, though the work goes on; not with `-q`.
    pub(crate) fn warning(&self, text: impl Display) {
        if !self.quiet {
            write_stderr(format_args!("{}: {text}\n", styled(YELLOW, "warning")));
        }
    }

    /// Why the work could not be done.
    pub(crate) fn failure(&self, failure: &Failure) {
        write_stderr(format_args!("{}: {}\n", styled(RED, "error"), failure.message));
        if let Some(help) = &failure.help {
            write_stderr(format_args!("  {}: {help}\n", styled(BOLD, "help")));
        }
    }
}

fn write_stdout(text: Arguments<'_>) -> io::Result<()> {
    let mut stream = anstream::stdout().lock();
    stream.write_fmt(text)?;
    stream.flush()
}

fn write_stderr(text: Arguments<'_>) {
    // Nobody is left to tell when standard error is gone.
    let _ = anstream::stderr().lock().write_fmt(text);
}
