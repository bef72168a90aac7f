//! `aam fmt`: rewrites AAM files in their canonical layout.

use std::io::{Read, Write};
use std::path::Path;
use std::process::ExitCode;

use aam::{FileError, Limit, ReadOptions, ReadOutcome, WriteOptions};
use aam_convert::Format;

use crate::cli::FmtArgs;
use crate::failure::Failure;
use crate::human;
use crate::terminal::Terminal;

pub(crate) fn run(args: &FmtArgs, terminal: &Terminal) -> Result<ExitCode, Failure> {
    let mut failed = false;
    let mut not_canonical = false;
    for path in &args.files {
        let done = if path.as_os_str() == "-" { stream(args, terminal) } else { file(path, args, terminal) };
        match done {
            Ok(canonical) => not_canonical |= !canonical,
            Err(failure) if failure.is_broken_pipe() => return Err(failure),
            Err(failure) => {
                terminal.failure(&failure);
                failed = true;
            }
        }
    }
    Ok(match (failed, args.check && not_canonical) {
        (true, _) => ExitCode::from(2),
        (false, true) => ExitCode::from(1),
        (false, false) => ExitCode::SUCCESS,
    })
}

/// Rewrites one file unless it is canonical already; gives whether it was.
fn file(path: &Path, args: &FmtArgs, terminal: &Terminal) -> Result<bool, Failure> {
    if Format::of(path).is_some_and(|format| format != Format::Aam) && path.exists() {
        return Err(Failure::new(format_args!("{}: only AAM files have a canonical layout", path.display()))
            .help("`aam convert` makes an AAM file of it"));
    }
    let before = aam::read_bytes(path, &args.limits.limits())?;
    let (after, outcome) = canonical(path, &before, args)?;
    let same = before == after;
    if same {
        if terminal.verbose() {
            terminal.summary(format_args!("{}: canonical", path.display()))?;
        }
    } else if args.check {
        terminal.summary(format_args!("{}: not canonical", path.display()))?;
    } else {
        aam::write_bytes(path, &after)?;
        let mended = match outcome.findings.len() {
            0 => String::new(),
            warnings => format!(", {}: see `aam check`", human::plural(warnings, "warning")),
        };
        terminal.summary(format_args!(
            "{}: rewritten ({} → {}{mended})",
            path.display(),
            human::bytes(before.len() as u64),
            human::bytes(after.len() as u64)
        ))?;
    }
    Ok(same)
}

/// Standard input to standard output.
fn stream(args: &FmtArgs, terminal: &Terminal) -> Result<bool, Failure> {
    let name = Path::new("standard input");
    let limits = args.limits.limits();
    let mut before = Vec::new();
    std::io::stdin()
        .lock()
        .take(limits.file_size.saturating_add(1))
        .read_to_end(&mut before)
        .map_err(|error| Failure::io(name, "read", &error))?;
    limits
        .check(Limit::FileSize, before.len() as u64)
        .map_err(|exceeded| FileError::TooLarge { path: name.into(), exceeded })?;
    let (after, _) = canonical(name, &before, args)?;
    let same = before == after;
    if !args.check {
        std::io::stdout().lock().write_all(&after)?;
    } else if !same {
        terminal.summary("standard input: not canonical")?;
    }
    Ok(same)
}

fn canonical(path: &Path, bytes: &[u8], args: &FmtArgs) -> Result<(Vec<u8>, ReadOutcome), Failure> {
    let options = ReadOptions { limits: args.limits.limits(), ..ReadOptions::default() };
    let outcome = aam::read(bytes, &options)
        .map_err(|source| FileError::Syntax { path: path.to_owned(), source: Box::new(source) })?;
    let written = aam::write(&outcome.document, &WriteOptions::default())
        .map_err(|source| FileError::Unwritable { path: path.to_owned(), source })?;
    Ok((written, outcome))
}
