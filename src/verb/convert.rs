//! `aam convert`: between formats, with a report of what became of everything.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use aam::WriteOptions;
use aam::document::{self, Encoding, Layer};
use aam_convert::authoring::AddedLayer;
use aam_convert::physics::PhysicsOptions;
use aam_convert::{Change, ConvertOptions, Converted, ExportOptions, Format, ImportOptions, Outcome, Report};
use aam_scene::Up;
use serde::Serialize;

use crate::cli::{Axis, BodyMode, ConvertArgs};
use crate::failure::Failure;
use crate::human::json_path;
use crate::progress::Bar;
use crate::terminal::{BOLD, DIM, GREEN, RED, Terminal, YELLOW, styled};
use crate::{human, open};

/// Formats that can be written.
const WRITABLE: [&str; 4] = ["aam", "glb", "gltf", "obj"];

/// One conversion as `--report` writes it.
#[derive(Serialize)]
struct Reported<'a> {
    #[serde(serialize_with = "json_path")]
    input: &'a Path,
    #[serde(serialize_with = "json_path")]
    output: &'a Path,
    written: Vec<String>,
    kept: usize,
    changed: usize,
    lost: usize,
    #[serde(flatten)]
    report: &'a Report,
}

impl<'a> Reported<'a> {
    fn new(input: &'a Path, converted: &'a Converted) -> Self {
        Self {
            input,
            output: &converted.output,
            written: converted.written.iter().map(|path| path.display().to_string()).collect(),
            kept: converted.report.count(Outcome::Kept),
            changed: converted.report.count(Outcome::Changed),
            lost: converted.report.count(Outcome::Lost),
            report: &converted.report,
        }
    }
}

pub(crate) fn run(args: &ConvertArgs, terminal: &Terminal) -> Result<ExitCode, Failure> {
    let jobs = jobs(args)?;
    if args.physics.physics.is_none()
        && let Some(option) = args.physics.hulls.given()
    {
        return Err(
            Failure::new(format_args!("{option} is for bodies")).help("add --physics dynamic, or use `aam decompose`")
        );
    }
    let options = options(args);
    let mut done = Vec::new();
    let mut failed = 0;
    for (input, output) in &jobs {
        match one(input, output.as_deref(), &options, args, terminal) {
            Ok(converted) => done.push((input, converted)),
            Err(failure) if failure.is_broken_pipe() || jobs.len() == 1 => return Err(failure),
            Err(failure) => {
                terminal.failure(&failure);
                failed += 1;
            }
        }
    }
    if let Some(path) = &args.report {
        let reports: Vec<_> = done.iter().map(|(input, converted)| Reported::new(input, converted)).collect();
        let json = match &reports[..] {
            [only] if jobs.len() == 1 => serde_json::to_string_pretty(only),
            all => serde_json::to_string_pretty(all),
        };
        let json = json.map_err(Failure::new)?;
        aam::write_bytes(path, format!("{json}\n").as_bytes())?;
    }
    if jobs.len() > 1 {
        let failures = if failed == 0 { String::new() } else { styled(RED, format_args!(", {failed} failed")) };
        terminal.summary(format_args!("{} converted{failures}", human::plural(done.len(), "file")))?;
    }
    Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::from(2) })
}

/// Inputs and outputs.
fn jobs(args: &ConvertArgs) -> Result<Vec<(PathBuf, Option<PathBuf>)>, Failure> {
    for (option, path) in [("--report", &args.report), ("--output", &args.output)] {
        if path.as_ref().is_some_and(|path| path.as_os_str() == "-") {
            return Err(Failure::new(format_args!("{option} - is not possible: name a file")));
        }
    }
    if let Some(report) = &args.report
        && args.files.iter().any(|file| file == report)
    {
        return Err(Failure::new(format_args!("{}: the report would replace an input", report.display())));
    }
    match (&args.files[..], &args.output) {
        ([input], None) => Ok(vec![(input.clone(), None)]),
        ([input, output], None) => {
            two_names(input, output, args.force)?;
            Ok(vec![(input.clone(), Some(output.clone()))])
        }
        ([input], Some(output)) if !is_folder(output) => Ok(vec![(input.clone(), Some(output.clone()))]),
        (inputs, Some(folder)) if is_folder(folder) => batch(inputs, folder),
        (_, Some(file)) => {
            Err(Failure::new(format_args!("{} is a file, but there are several inputs", file.display()))
                .help("name a folder: -o out/"))
        }
        (_, None) => Err(Failure::new("three names or more: which are inputs?")
            .help("to convert several files, name a folder for them: -o out/")),
    }
}

/// A folder that exists, or a name that no format claims.
fn is_folder(path: &Path) -> bool {
    path.is_dir() || Format::of(path).is_none()
}

/// `aam convert *.glb` with two files must not replace the second one.
fn two_names(input: &Path, output: &Path, force: bool) -> Result<(), Failure> {
    let shown = output.display();
    if output.is_dir() {
        return Err(
            Failure::new(format_args!("{shown} is a folder")).help(format_args!("-o {shown} puts the output there"))
        );
    }
    if output.exists() && Format::of(input) == Format::of(output) && !force {
        return Err(Failure::new(format_args!("{shown} exists and has the same format as the input"))
            .help("to convert both, name a folder: -o out/; to replace it, add --force"));
    }
    Ok(())
}

/// Each input goes to `FOLDER/NAME.aam`.
fn batch(inputs: &[PathBuf], folder: &Path) -> Result<Vec<(PathBuf, Option<PathBuf>)>, Failure> {
    let mut jobs: Vec<(PathBuf, Option<PathBuf>)> = Vec::new();
    for input in inputs {
        let name = input.file_name().ok_or_else(|| Failure::new(format_args!("{}: not a file", input.display())))?;
        let output = folder.join(name).with_extension("aam");
        if let Some((other, _)) = jobs.iter().find(|(_, taken)| taken.as_ref() == Some(&output)) {
            return Err(Failure::new(format_args!(
                "{} and {} would both become {}",
                other.display(),
                input.display(),
                output.display()
            ))
            .help("convert them into different folders"));
        }
        jobs.push((input.clone(), Some(output)));
    }
    std::fs::create_dir_all(folder).map_err(|error| Failure::io(folder, "make the folder", &error))?;
    Ok(jobs)
}

fn options(args: &ConvertArgs) -> ConvertOptions {
    let import = ImportOptions {
        hierarchy: args.hierarchy,
        normal_tolerance: args.normal_tolerance,
        ..open::import_options(&args.read)
    };
    let write = WriteOptions {
        digits: args.write.digits,
        encoding: args.write.binary.then_some(Encoding::Binary),
        crlf: args.write.crlf,
    };
    let up = args.read.up.map(|axis| match axis {
        Axis::Y => Up::Y,
        Axis::Z => Up::Z,
    });
    let export =
        ExportOptions { write, original: args.write.original, up, overwrite: args.force, limits: import.limits };
    ConvertOptions { import, layers: layers(args), physics: physics(args), export }
}

/// Bodies for the objects.
fn physics(args: &ConvertArgs) -> Option<PhysicsOptions> {
    let given = &args.physics;
    let mut options = PhysicsOptions::new(match given.physics? {
        BodyMode::Static => document::BodyMode::Static,
        BodyMode::Kinematic => document::BodyMode::Kinematic,
        BodyMode::Dynamic => document::BodyMode::Dynamic,
    });
    options.mass = given.mass;
    options.density = given.density;
    options.static_friction = given.static_friction.unwrap_or(options.static_friction);
    options.dynamic_friction = given.dynamic_friction.unwrap_or(options.dynamic_friction);
    options.restitution = given.restitution.unwrap_or(options.restitution);
    options.hulls = given.hulls.options();
    Some(options)
}

/// Layers that the input lacks.
fn layers(args: &ConvertArgs) -> Vec<AddedLayer> {
    let given = &args.textures;
    let kinds = [
        (Layer::LightMap, &given.light_map),
        (Layer::Normal, &given.normal_map),
        (Layer::Displacement, &given.displacement),
    ];
    let mut layers = Vec::new();
    for (layer, texture) in kinds.into_iter().flat_map(|(layer, textures)| textures.iter().map(move |t| (layer, t))) {
        let mut added = AddedLayer::new(layer, &texture.file);
        added.materials.extend(texture.material.clone());
        let parameters = &mut added.displacement;
        parameters.tessellation = given.tf.unwrap_or(parameters.tessellation);
        parameters.bias = given.bias.unwrap_or(parameters.bias);
        parameters.scale = given.scale.unwrap_or(parameters.scale);
        layers.push(added);
    }
    layers
}

fn one(
    input: &Path,
    output: Option<&Path>,
    options: &ConvertOptions,
    args: &ConvertArgs,
    terminal: &Terminal,
) -> Result<Converted, Failure> {
    let start = Instant::now();
    let meta = std::fs::metadata(input).map_err(|error| Failure::io(input, "read", &error))?;
    if meta.is_dir() {
        return Err(Failure::new(format_args!("{}: cannot read: it is a folder", input.display()))
            .help("name its files: aam convert FOLDER/*.glb -o out/"));
    }
    let size = meta.len();
    if let Some(output) = output {
        writable(output)?;
    }
    let converted = {
        let progress = Bar::new(terminal);
        aam_convert::convert(input, output, options, &progress)?
    };
    print(&converted.report, args, terminal)?;
    let written = |path: &Path| std::fs::metadata(path).map_or(0, |meta| meta.len());
    let beside: Vec<_> = converted.written.iter().filter(|path| **path != converted.output).collect();
    let more = match beside.len() {
        0 => String::new(),
        count => {
            let bytes = beside.iter().map(|path| written(path)).sum();
            format!(" + {} ({})", human::plural(count, "file"), human::bytes(bytes))
        }
    };
    terminal.summary(format_args!(
        "{} ({}) → {BOLD}{}{BOLD:#} ({}){more}, {}",
        input.display(),
        human::bytes(size),
        converted.output.display(),
        human::bytes(written(&converted.output)),
        human::duration(start.elapsed())
    ))?;
    Ok(converted)
}

/// Said before a long conversion rather than after it.
fn writable(output: &Path) -> Result<(), Failure> {
    let shown = output.display();
    let extension = output.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    if !extension.as_deref().is_some_and(|extension| WRITABLE.contains(&extension)) {
        let known = WRITABLE.map(|extension| format!(".{extension}")).join(" ");
        return Err(Failure::new(format_args!("{shown}: this format cannot be written"))
            .help(format_args!("the output's extension decides: {known}")));
    }
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        return Err(Failure::new(format_args!("{shown}: the folder {} does not exist", folder.display()))
            .help(format_args!("mkdir -p {}", folder.display())));
    }
    Ok(())
}

/// One line of a report.
pub(crate) fn sentence(change: &Change) -> String {
    let subject = if change.subject.is_empty() { String::new() } else { format!("{}: ", change.subject) };
    let size = change.size.as_ref().map_or_else(String::new, |size| format!(" ({size})"));
    format!("{subject}{}: {}{size}", change.property, change.note)
}

/// Lines of the same kind that differ only in their subject become one.
fn folded(changes: &[&Change]) -> Vec<String> {
    const NAMED: usize = 3;
    let mut groups: Vec<(&Change, Vec<&str>)> = Vec::new();
    for change in changes {
        let same = |(first, _): &&mut (&Change, Vec<&str>)| {
            first.property == change.property && first.note == change.note && first.size == change.size
        };
        match groups.iter_mut().find(same) {
            Some((_, subjects)) => subjects.push(&change.subject),
            None => groups.push((change, vec![&change.subject])),
        }
    }
    groups
        .into_iter()
        .map(|(first, subjects)| {
            if subjects.len() <= 1 {
                return sentence(first);
            }
            let more = match subjects.len().saturating_sub(NAMED) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            let subject = format!("{}{more}", subjects[..subjects.len().min(NAMED)].join(", "));
            sentence(&Change { subject, ..first.clone() })
        })
        .collect()
}

fn print(report: &Report, args: &ConvertArgs, terminal: &Terminal) -> Result<(), Failure> {
    let of = |outcome| report.changes.iter().filter(|change| change.outcome == outcome).collect::<Vec<_>>();
    let kinds = [
        (Outcome::Kept, "kept", GREEN, false),
        (Outcome::Changed, "changed", YELLOW, false),
        (Outcome::Lost, "lost", RED, true),
    ];
    for (outcome, word, style, always) in kinds {
        if !always && !terminal.verbose() {
            continue;
        }
        let changes = of(outcome);
        let lines =
            if terminal.verbose() { changes.iter().map(|change| sentence(change)).collect() } else { folded(&changes) };
        for line in lines {
            terminal.summary(format_args!("  {} {line}", styled(style, format_args!("{word:<8}"))))?;
        }
    }
    let [kept, changed, lost] = [Outcome::Kept, Outcome::Changed, Outcome::Lost].map(|outcome| report.count(outcome));
    let hint = match (kept + changed, terminal.verbose(), &args.report) {
        (1.., false, None) => styled(DIM, "  (-v lists all)"),
        _ => String::new(),
    };
    terminal.summary(format_args!("  {kept} kept, {changed} changed, {lost} lost{hint}"))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::cli::{Cli, Verb};

    fn jobs_of(words: &[&str]) -> Result<Vec<(PathBuf, Option<PathBuf>)>, Failure> {
        match Cli::try_parse_from(["aam", "convert"].iter().chain(words)).expect("arguments").verb {
            Verb::Convert(args) => jobs(&args),
            _ => unreachable!("convert was asked for"),
        }
    }

    #[test]
    fn names_are_inputs_and_outputs() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let name = |name: &str| folder.path().join(name).display().to_string();
        let (a, b, out) = (name("a.glb"), name("b.glb"), name("out"));
        assert_eq!(jobs_of(&[&a]).expect("one"), [(a.clone().into(), None)]);
        assert_eq!(jobs_of(&[&a, &b]).expect("a pair"), [(a.clone().into(), Some(b.clone().into()))]);
        assert_eq!(jobs_of(&[&a, "-o", &b]).expect("a pair"), [(a.clone().into(), Some(b.clone().into()))]);
        let both = jobs_of(&[&a, &b, "-o", &out]).expect("a batch");
        assert_eq!(both[1].1, Some(Path::new(&out).join("b.aam")));
        assert!(jobs_of(&[&a, &b, &out]).is_err() && jobs_of(&[&a, &b, "-o", &name("c.aam")]).is_err());
        assert!(jobs_of(&[&name("x/a.glb"), &name("y/a.obj"), "-o", &out]).is_err(), "both become a.aam");
    }

    #[test]
    fn a_glob_of_two_does_not_replace_the_second() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (a, b) = (folder.path().join("a.glb"), folder.path().join("b.glb"));
        std::fs::write(&b, "precious").expect("written");
        let words = [a.to_str().expect("a name"), b.to_str().expect("a name")];
        assert!(jobs_of(&words).is_err_and(|failure| failure.help.is_some_and(|help| help.contains("-o out/"))));
        assert!(jobs_of(&[words[0], words[1], "--force"]).is_ok());
    }

    #[test]
    fn like_losses_are_told_once() {
        let change = |subject: &str, note: &str| Change {
            outcome: Outcome::Lost,
            subject: subject.into(),
            property: "occlusion".into(),
            note: note.into(),
            size: None,
        };
        let changes = ["a", "b", "c", "d", "e"].map(|subject| change(subject, "no such layer"));
        let other = change("a", "another reason");
        let all: Vec<&Change> = changes.iter().chain([&other]).collect();
        assert_eq!(folded(&all), ["a, b, c and 2 more: occlusion: no such layer", "a: occlusion: another reason"]);
    }
}
