//! The command `aam`: arguments, messages and exit codes. One file for each verb; the work is done by the libraries.

mod args;
mod camera;
mod cli;
mod failure;
mod human;
mod logger;
mod open;
mod outlines;
mod panic;
mod picture;
mod progress;
mod terminal;
mod verb;

use std::process::ExitCode;

use clap::Parser;

use crate::cli::{Cli, Verb};
use crate::terminal::Terminal;

fn main() -> ExitCode {
    quiet_drivers();
    panic::install();
    let cli = Cli::parse();
    logger::install(cli.global.verbose);
    let terminal = Terminal::new(&cli.global);
    let outcome = match &cli.verb {
        Verb::Convert(args) => verb::convert::run(args, &terminal),
        Verb::Decompose(args) => verb::decompose::run(args, &terminal),
        Verb::Render(args) => verb::render::run(args, &terminal),
        Verb::View(args) => verb::view::run(args, &terminal),
        Verb::Simulate(args) => verb::simulate::run(args, &terminal),
        Verb::Info(args) => verb::info::run(args, &terminal),
        Verb::Check(args) => verb::check::run(args, &terminal),
        Verb::Fmt(args) => verb::fmt::run(args, &terminal),
        Verb::Completions(args) => verb::completions::run(args, &terminal),
    };
    match outcome {
        Ok(code) => code,
        Err(failure) if failure.is_broken_pipe() => ExitCode::SUCCESS,
        Err(failure) => {
            terminal.failure(&failure);
            ExitCode::from(2)
        }
    }
}

/// Keeps Mesa's layer for choosing among GPUs from asking Wayland where no session runs: it would print an `error:` that is
/// neither ours nor one.
fn quiet_drivers() {
    let unset = |name| std::env::var_os(name).is_none();
    if cfg!(target_os = "linux") && unset("XDG_RUNTIME_DIR") && unset("NODEVICE_SELECT") {
        #[allow(unsafe_code, reason = "the layer listens to nothing but the environment")]
        // SAFETY: this is the first thing that the program does, so no other thread reads the environment.
        unsafe {
            std::env::set_var("NODEVICE_SELECT", "1");
        }
    }
}
