//! The command `aam`: arguments, messages and exit codes. One file for each verb; the work is done by the libraries.

mod args;
mod camera;
mod cli;
mod demo;
mod environment;
mod failure;
mod human;
mod logger;
mod open;
mod outlines;
mod panic;
mod picture;
mod progress;
mod shadows;
mod terminal;
mod verb;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::Parser;

use crate::cli::{Cli, Verb};
use crate::terminal::Terminal;

/// `tune --physics FILE` and `tune SCENE` with the subcommand that they mean.
fn spelled_out(mut args: Vec<OsString>) -> Vec<OsString> {
    if args.get(1).is_none_or(|verb| verb != "tune") {
        return args;
    }
    if let Some(at) = args.iter().position(|arg| arg == "--physics") {
        args.remove(at);
        args.insert(2, "physics".into());
    }
    let named = ["shadows", "physics", "help", "-h", "--help"];
    if args.get(2).is_some_and(|word| named.iter().all(|name| word != name)) {
        args.insert(2, "shadows".into());
    }
    args
}

fn main() -> ExitCode {
    quiet_drivers();
    panic::install();
    let cli = Cli::try_parse_from(spelled_out(std::env::args_os().collect())).unwrap_or_else(|error| {
        match error.to_string().strip_prefix("error: ") {
            // Help on a value, which clap takes for an error's text.
            Some(text) if error.kind() == clap::error::ErrorKind::DisplayHelp => help(text),
            _ => error.exit(),
        }
    });
    logger::install(cli.global.verbose);
    let terminal = Terminal::new(&cli.global);
    let outcome = match &cli.verb {
        Verb::Convert(args) => verb::convert::run(args, &terminal),
        Verb::Decompose(args) => verb::decompose::run(args, &terminal),
        Verb::Render(args) => verb::render::run(args, &terminal),
        Verb::View(args) => verb::view::run(args, &terminal),
        Verb::Simulate(args) => verb::simulate::run(args, &terminal),
        Verb::Chart(args) => verb::chart::run(args, &terminal),
        Verb::Tune(args) => verb::tune::run(args, &terminal),
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

/// Prints a text that was asked for, and ends.
fn help(text: &str) -> ! {
    use std::io::Write;
    // Nobody reads on where this fails.
    let _ = anstream::stdout().write_all(text.as_bytes());
    std::process::exit(0)
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
