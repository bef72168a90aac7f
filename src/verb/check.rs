//! `aam check`: what is wrong in AAM files.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use aam::check::code_info;
use aam::meaning::Summary;
use aam::{Document, Finding, ReadOptions, Severity};
use aam_convert::Format;
use aam_scene::{FolderTextures, TextureSource};
use serde::Serialize;

use crate::cli::CheckArgs;
use crate::failure::Failure;
use crate::human;
use crate::terminal::{BOLD, DIM, GREEN, RED, Terminal, YELLOW, styled};

/// More findings of one file than this are counted, not shown, unless `-v` asks for them.
const SHOWN: usize = 50;

/// What was found in one file, as `--json` prints it.
#[derive(Serialize)]
struct Checked {
    file: PathBuf,
    errors: usize,
    warnings: usize,
    infos: usize,
    findings: Vec<Finding>,
    /// The line that could not be read, and a marker below it.
    #[serde(skip)]
    excerpt: Option<String>,
}

impl Checked {
    fn new(file: &Path, (findings, excerpt): (Vec<Finding>, Option<String>)) -> Self {
        let count = |severity| findings.iter().filter(|finding| finding.severity == severity).count();
        Self {
            file: file.to_owned(),
            errors: count(Severity::Error),
            warnings: count(Severity::Warning),
            infos: count(Severity::Info),
            findings,
            excerpt,
        }
    }
}

pub(crate) fn run(args: &CheckArgs, terminal: &Terminal) -> Result<ExitCode, Failure> {
    for code in &args.ignore {
        if code_info(code).is_none() {
            return Err(Failure::new(format_args!("{code}: there is no such finding"))
                .help("docs/checks.md lists all codes; `aam check` prints them in brackets"));
        }
    }
    let mut unreadable = false;
    let mut checked = Vec::new();
    for path in &args.files {
        match check(path, args) {
            Ok(findings) => {
                let result = Checked::new(path, findings);
                if !args.json {
                    print(&result, terminal)?;
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

/// All findings of a file, in file order. `--strict` makes errors of warnings after the fact, so that one does not
/// hide the next.
fn check(path: &Path, args: &CheckArgs) -> Result<(Vec<Finding>, Option<String>), Failure> {
    if Format::of(path).is_some_and(|format| format != Format::Aam) && path.exists() {
        return Err(Failure::new(format_args!("{}: only AAM files can be checked", path.display()))
            .help("`aam convert` reports what it cannot take over from other formats"));
    }
    let bytes = aam::read_bytes(path, args.max_file_size)?;
    let options = ReadOptions { max_file_size: args.max_file_size, ..ReadOptions::default() };
    let mut excerpt = None;
    let mut findings = match aam::read(&bytes, &options) {
        Ok(outcome) => {
            let mut findings = outcome.findings;
            findings.extend(aam::check(&outcome.document, Some((&bytes, &outcome.places))));
            findings.extend(missing_textures(path, &outcome.document));
            findings
        }
        Err(error) => {
            excerpt = Some(format!("    | {}\n    | {:marker$}^", error.line, "", marker = error.marker));
            vec![Finding {
                code: error.code,
                severity: Severity::Error,
                position: Some(error.position),
                subject: String::new(),
                message: error.message,
            }]
        }
    };
    findings.retain(|finding| !args.ignore.iter().any(|code| code == finding.code));
    if args.strict {
        for finding in findings.iter_mut().filter(|finding| finding.severity == Severity::Warning) {
            finding.severity = Severity::Error;
        }
    }
    findings.sort_by_key(|finding| finding.position);
    Ok((findings, excerpt))
}

/// The document knows names only; whether the files are there is known here.
fn missing_textures(path: &Path, document: &Document) -> Vec<Finding> {
    const CODE: &str = "texture/missing";
    let folder = FolderTextures::beside(path);
    let textures = Summary::of(document).textures;
    let missing = textures.iter().filter_map(|texture| {
        let reason = folder.find(&texture.file).err()?;
        Some(Finding {
            code: CODE,
            severity: code_info(CODE).map_or(Severity::Warning, |info| info.severity),
            position: None,
            subject: format!("texture {:?}", texture.file),
            message: reason,
        })
    });
    missing.collect()
}

fn print(checked: &Checked, terminal: &Terminal) -> Result<(), Failure> {
    let file = checked.file.display();
    let shown = if terminal.verbose() { checked.findings.len() } else { SHOWN };
    let mut text = String::new();
    for finding in checked.findings.iter().take(shown) {
        let style = match finding.severity {
            Severity::Error => RED,
            Severity::Warning => YELLOW,
            Severity::Info => DIM,
        };
        let place = finding.position.map_or_else(String::new, |position| format!("{position}:"));
        let subject = if finding.subject.is_empty() { String::new() } else { format!("{}: ", finding.subject) };
        let severity = styled(style, format_args!("{}[{}]", finding.severity, finding.code));
        let _ = writeln!(text, "{BOLD}{file}:{place}{BOLD:#} {severity}: {subject}{}", finding.message);
        if let Some(excerpt) = &checked.excerpt {
            let _ = writeln!(text, "{excerpt}");
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
    terminal.summary(format_args!("{file}: {verdict}"))?;
    Ok(())
}
