//! `aam check`: what is wrong in AAM files.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use aam::check::{CODES, CodeInfo, Rules, code_info};
use aam::meaning::Summary;
use aam::{Document, Excerpt, Finding, Limits, Position, ReadOptions, Severity};
use aam_convert::Format;
use aam_scene::{FolderTextures, TextureSource, load_texture};
use anstyle::Style;
use serde::Serialize;

use crate::cli::CheckArgs;
use crate::failure::Failure;
use crate::human::{self, json_path};
use crate::terminal::{BOLD, DIM, GREEN, RED, Terminal, YELLOW, styled};

/// More findings of one file than this are counted, not shown, unless `-v` asks for them.
const SHOWN: usize = 50;

/// What was found in one file, as `--json` prints it.
#[derive(Serialize)]
struct Checked {
    #[serde(serialize_with = "json_path")]
    file: PathBuf,
    /// Whether the document could be read to its end, without which it was not checked.
    readable: bool,
    errors: usize,
    warnings: usize,
    infos: usize,
    findings: Vec<Finding>,
}

pub(crate) fn run(args: &CheckArgs, terminal: &Terminal) -> Result<ExitCode, Failure> {
    let rules = args.rules.rules();
    if let Some(twice) = rules.contradiction() {
        return Err(Failure::new(format_args!("{twice} is given two severities"))
            .help("name it after one of --error, --warning and --info"));
    }
    if args.list {
        terminal.result(list(&rules))?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut unreadable = false;
    let mut checked = Vec::new();
    for path in &args.files {
        match check(path, args, &rules) {
            Ok((result, bytes)) => {
                if !args.json {
                    print(&result, &bytes, terminal)?;
                }
                checked.push(result);
            }
            Err(failure) => {
                terminal.failure(&failure);
                unreadable = true;
            }
        }
    }
    if args.json {
        terminal.result(serde_json::to_string_pretty(&checked).map_err(Failure::new)?)?;
    } else if checked.len() > 1 {
        let errors: usize = checked.iter().map(|file| file.errors).sum();
        let warnings: usize = checked.iter().map(|file| file.warnings).sum();
        terminal.summary(format_args!(
            "{}: {}, {}",
            human::plural(checked.len(), "file"),
            human::plural(errors, "error"),
            human::plural(warnings, "warning")
        ))?;
    }
    Ok(if unreadable {
        ExitCode::from(2)
    } else if checked.iter().any(|file| file.errors > 0) {
        ExitCode::from(1)
    } else {
        ExitCode::SUCCESS
    })
}

/// All findings of a file that are wanted, in file order, and its bytes. The rules are applied after the fact, so that
/// with `--strict` one finding does not hide the next.
fn check(path: &Path, args: &CheckArgs, rules: &Rules) -> Result<(Checked, Vec<u8>), Failure> {
    if Format::of(path).is_some_and(|format| format != Format::Aam) && path.exists() {
        return Err(Failure::new(format_args!("{}: only AAM files can be checked", path.display()))
            .help("`aam convert` reports what it cannot take over from other formats"));
    }
    let limits = args.limits.limits();
    let bytes = aam::read_bytes(path, &limits)?;
    let (readable, mut findings) = match aam::read(&bytes, &ReadOptions { limits, ..ReadOptions::default() }) {
        Ok(outcome) => {
            let mut findings = outcome.findings;
            findings.extend(aam::check(&outcome.document, Some((&bytes, &outcome.places))));
            findings.extend(textures(path, &outcome.document, limits, rules));
            rules.apply(&mut findings);
            (true, findings)
        }
        // Whatever else is wanted, there is nothing else to say of this file.
        Err(error) => (false, vec![error.into()]),
    };
    findings.sort_by_key(|finding| finding.position);
    let count = |severity| findings.iter().filter(|finding| finding.severity == severity).count();
    let checked = Checked {
        file: path.to_owned(),
        readable,
        errors: count(Severity::Error),
        warnings: count(Severity::Warning),
        infos: count(Severity::Info),
        findings,
    };
    Ok((checked, bytes))
}

/// The document knows names only; whether the files are there and are pictures is known here.
fn textures(path: &Path, document: &Document, limits: Limits, rules: &Rules) -> Vec<Finding> {
    let (missing, unreadable) = ("texture/missing", "texture/unreadable");
    if !rules.wants(missing) && !rules.wants(unreadable) {
        return Vec::new();
    }
    let mut folder = FolderTextures::beside(path);
    folder.limits = limits;
    let problem = |file: &str| match folder.find(file) {
        Err(reason) => Some((missing, reason)),
        Ok(found) if rules.wants(unreadable) => Some((unreadable, load_texture(&found, &limits).err()?)),
        Ok(_) => None,
    };
    let textures = Summary::of(document).textures;
    let finding = |file: &str| {
        let (code, message) = problem(file)?;
        let severity = code_info(code).map_or(Severity::Warning, |info| info.severity);
        Some(Finding { code, severity, position: None, subject: format!("texture {file:?}"), message })
    };
    textures.iter().filter_map(|texture| finding(&texture.file)).collect()
}

/// The codes that are looked for under the rules.
fn list(rules: &Rules) -> String {
    let row = |info: &CodeInfo| {
        let severity = rules.severity(info.code, info.severity);
        let severity = styled(style(severity), format_args!("{severity:<8}"));
        format!("{severity} {BOLD}{:<40}{BOLD:#} {}", info.code, info.meaning)
    };
    CODES.iter().filter(|info| rules.wants(info.code)).map(row).collect::<Vec<_>>().join("\n")
}

fn style(severity: Severity) -> Style {
    match severity {
        Severity::Error => RED,
        Severity::Warning => YELLOW,
        Severity::Info => DIM,
    }
}

fn print(checked: &Checked, bytes: &[u8], terminal: &Terminal) -> Result<(), Failure> {
    let file = checked.file.display();
    let shown = if terminal.verbose() { checked.findings.len() } else { SHOWN };
    let mut lines = Position::walk(bytes);
    let mut text = String::new();
    for finding in checked.findings.iter().take(shown) {
        let place = finding.position.map_or_else(String::new, |position| format!("{position}:"));
        let subject = if finding.subject.is_empty() { String::new() } else { format!("{}: ", finding.subject) };
        let severity = styled(style(finding.severity), format_args!("{}[{}]", finding.severity, finding.code));
        let _ = writeln!(text, "{BOLD}{file}:{place}{BOLD:#} {severity}: {subject}{}", finding.message);
        if let Some(position) = finding.position {
            let _ = writeln!(text, "{}", Excerpt::at(bytes, lines.offset(position)));
        }
        if let Some(info) = code_info(finding.code).filter(|_| terminal.verbose()) {
            let _ = writeln!(text, "    {}", styled(DIM, info.remedy));
        }
    }
    if let Some(more) = checked.findings.len().checked_sub(shown).filter(|more| *more > 0) {
        let _ = writeln!(text, "{file}: {} more; -v shows all", human::count(more));
    }
    if !text.is_empty() {
        terminal.result(text.trim_end())?;
    }
    let verdict = match (checked.errors, checked.warnings) {
        (0, 0) => styled(GREEN, "no errors, no warnings"),
        (errors, warnings) => {
            let part = |count, noun, style| match count {
                0 => format!("no {noun}s"),
                _ => styled(style, human::plural(count, noun)),
            };
            format!("{}, {}", part(errors, "error", RED), part(warnings, "warning", YELLOW))
        }
    };
    let unchecked = if checked.readable { "" } else { "; nothing else could be checked" };
    terminal.summary(format_args!("{file}: {verdict}{unchecked}"))?;
    Ok(())
}
