//! `aam info`: what a file holds.

use std::fmt::Write;
use std::io::{BufReader, Cursor};
use std::path::PathBuf;
use std::process::ExitCode;

use aam::meaning::Summary;
use aam_convert::{Change, Outcome};
use aam_scene::{FoundTexture, TextureData, TextureSource};
use image::ImageReader;
use serde::Serialize;

use crate::cli::InfoArgs;
use crate::failure::Failure;
use crate::human::{self, json_path};
use crate::open::{self, Textures};
use crate::progress::Bar;
use crate::terminal::{BOLD, DIM, RED, Terminal, styled};
use crate::verb;

/// Objects and materials that are listed without `-v`.
const LISTED: usize = 40;

/// What `--json` prints.
#[derive(Serialize)]
struct Info {
    #[serde(serialize_with = "json_path")]
    file: PathBuf,
    format: &'static str,
    size: u64,
    #[serde(flatten)]
    summary: Summary,
    texture_files: Vec<TextureState>,
    lights: Vec<String>,
    cameras: Vec<String>,
    /// What an importer changed or lost, or a reader had to mend.
    changes: Vec<Change>,
}

/// Whether a texture can be read.
#[derive(Serialize)]
struct TextureState {
    file: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<String>,
    embedded: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    width: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    height: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bytes: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<String>,
}

pub(crate) fn run(args: &InfoArgs, terminal: &Terminal) -> Result<ExitCode, Failure> {
    let info = {
        let progress = Bar::new(terminal);
        gather(args, &progress)?
    };
    if args.json {
        terminal.result(serde_json::to_string_pretty(&info).map_err(Failure::new)?)?;
    } else {
        terminal.result(text(&info, terminal.verbose()).trim_end())?;
    }
    Ok(ExitCode::SUCCESS)
}

fn gather(args: &InfoArgs, progress: &Bar) -> Result<Info, Failure> {
    let asset = open::asset(&args.file, &open::import_options(&args.read), progress)?;
    let summary = Summary::of(&asset.document);
    let textures = Textures::new(&asset, &args.file, &args.read);
    let texture_files = summary.textures.iter().map(|texture| state(&texture.file, &textures)).collect();
    let size = std::fs::metadata(&args.file).map_err(|error| Failure::io(&args.file, "read", &error))?.len();
    let named = |names: &mut dyn Iterator<Item = &String>, what: &str| {
        names
            .enumerate()
            .map(|(index, name)| if name.is_empty() { format!("{what} {index}") } else { name.clone() })
            .collect()
    };
    Ok(Info {
        file: args.file.clone(),
        format: open::format_name(&args.file),
        size,
        texture_files,
        lights: named(&mut asset.lights.iter().map(|light| &light.name), "light"),
        cameras: named(&mut asset.cameras.iter().map(|camera| &camera.name), "camera"),
        changes: asset.report.changes.into_iter().filter(|change| change.outcome != Outcome::Kept).collect(),
        summary,
    })
}

/// Finds a texture and reads its header.
fn state(file: &str, textures: &dyn TextureSource) -> TextureState {
    let mut state = TextureState {
        file: file.to_owned(),
        path: None,
        embedded: false,
        width: None,
        height: None,
        bytes: None,
        problem: None,
    };
    match textures.find(file) {
        Err(problem) => state.problem = Some(problem),
        Ok(FoundTexture { data, .. }) => {
            let dimensions = match &data {
                TextureData::OnDisk(path) => {
                    state.bytes = std::fs::metadata(path).ok().map(|meta| meta.len());
                    std::fs::File::open(path)
                        .map_err(image::ImageError::IoError)
                        .and_then(|file| {
                            ImageReader::new(BufReader::new(file))
                                .with_guessed_format()
                                .map_err(image::ImageError::IoError)
                        })
                        .and_then(ImageReader::into_dimensions)
                }
                TextureData::InMemory(bytes) => {
                    state.bytes = Some(bytes.len() as u64);
                    state.embedded = true;
                    ImageReader::new(Cursor::new(bytes))
                        .with_guessed_format()
                        .map_err(image::ImageError::IoError)
                        .and_then(ImageReader::into_dimensions)
                }
            };
            match dimensions {
                Ok((width, height)) => (state.width, state.height) = (Some(width), Some(height)),
                Err(error) => state.problem = Some(error.to_string()),
            }
            if let TextureData::OnDisk(path) = data {
                state.path = Some(path.display().to_string());
            }
        }
    }
    state
}

fn text(info: &Info, all: bool) -> String {
    let listed = if all { usize::MAX } else { LISTED };
    let summary = &info.summary;
    let mut text = String::new();
    let out = &mut text;
    let _ = writeln!(out, "{}  {}, {}", styled(BOLD, info.file.display()), info.format, human::bytes(info.size));
    row(out, "header", &format!("{}, {}", summary.header.unwrap_or("none"), summary.encoding));
    row(
        out,
        "geometry",
        &format!(
            "{}, {}, {}",
            human::plural(summary.objects.len(), "object"),
            if summary.vertices == 1 {
                "1 vertex".into()
            } else {
                format!("{} vertices", human::count(summary.vertices))
            },
            human::plural(summary.triangles, "triangle")
        ),
    );
    if let Some(bounds) = summary.bounds {
        let (low, high) = (bounds.min, bounds.max);
        let size = high - low;
        row(out, "size", &format!("{} × {} × {} m", number(size.x), number(size.y), number(size.z)));
        let span = |low: f32, high: f32| format!("{} … {}", number(low), number(high));
        row(
            out,
            "bounds",
            &format!("x {}   y {}   z {}", span(low.x, high.x), span(low.y, high.y), span(low.z, high.z)),
        );
    }
    let animation = match summary.frames {
        0 | 1 => "none".to_owned(),
        frames => format!(
            "{}, {} at {} a second, {} s",
            summary.animation,
            human::plural(frames, "frame"),
            number(summary.frames_per_second),
            number(summary.duration)
        ),
    };
    row(out, "animation", &animation);
    if summary.bodies.iter().sum::<usize>() > 0 {
        let [fixed, kinematic, dynamic] = summary.bodies;
        row(
            out,
            "bodies",
            &format!(
                "{fixed} static, {kinematic} kinematic, {dynamic} dynamic; {}",
                human::plural(summary.collision_shapes, "collision shape")
            ),
        );
    }
    for (name, list) in [("lights", &info.lights), ("cameras", &info.cameras)] {
        if !list.is_empty() {
            row(out, name, &list.join(", "));
        }
    }
    objects(out, summary, listed);
    materials(out, summary, listed);
    if !info.texture_files.is_empty() {
        let _ = writeln!(out, "\n{}", styled(BOLD, "Textures"));
    }
    for (texture, used) in info.texture_files.iter().zip(&summary.textures).take(listed) {
        let state = match (&texture.problem, texture.width, texture.height) {
            (Some(problem), ..) => styled(RED, problem),
            (None, Some(width), Some(height)) => format!("{width} × {height}"),
            _ => String::new(),
        };
        let bytes = texture.bytes.map_or_else(String::new, |bytes| format!(", {}", human::bytes(bytes)));
        let place = if texture.embedded { ", embedded" } else { "" };
        let _ = writeln!(
            out,
            "  {:<32} {state}{bytes}{place}  {}",
            texture.file,
            styled(DIM, format_args!("used by {}", human::plural(used.uses, "layer")))
        );
    }
    more(out, info.texture_files.len(), listed);
    if !info.changes.is_empty() {
        let _ = writeln!(out, "\n{}", styled(BOLD, "Changed or lost in reading"));
        for change in info.changes.iter().take(listed) {
            let _ = writeln!(out, "  {}", verb::convert::sentence(change));
        }
        more(out, info.changes.len(), listed);
    }
    text
}

fn row(out: &mut String, name: &str, value: &str) {
    let _ = writeln!(out, "  {} {value}", styled(DIM, format_args!("{name:<10}")));
}

fn more(out: &mut String, count: usize, listed: usize) {
    if let Some(more) = count.checked_sub(listed).filter(|more| *more > 0) {
        let _ = writeln!(out, "  {} more; -v lists all", human::count(more));
    }
}

/// The objects as a tree, children below their parents.
fn objects(out: &mut String, summary: &Summary, listed: usize) {
    let objects = &summary.objects;
    if objects.is_empty() {
        return;
    }
    let _ = writeln!(out, "\n{}", styled(BOLD, "Objects"));
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); objects.len()];
    let mut stack = Vec::new();
    for (index, object) in objects.iter().enumerate() {
        match object.parent.and_then(|parent| children.get_mut(parent)) {
            Some(below) => below.push(index),
            None => stack.push((index, 0)),
        }
    }
    stack.reverse();
    let mut done = 0;
    while let Some((index, depth)) = stack.pop() {
        stack.extend(children[index].iter().rev().map(|child| (*child, depth + 1)));
        done += 1;
        if done > listed {
            continue;
        }
        let object = &objects[index];
        let mut has = Vec::new();
        if object.keys > 0 {
            has.push(human::plural(object.keys, "key"));
        }
        for (is, what) in [
            (object.explicit_normals, "explicit normals"),
            (object.vertex_colors, "vertex colours"),
            (object.displacement, "displacement"),
        ] {
            if is {
                has.push(what.into());
            }
        }
        let size = match object.triangles {
            0 => "no triangles".to_owned(),
            triangles => human::plural(triangles, "triangle"),
        };
        let name = format!("{:indent$}{}", "", object.name, indent = 2 * depth.min(20));
        let _ = writeln!(out, "  {name:<32} {size}  {}", styled(DIM, has.join(", ")));
    }
    more(out, objects.len(), listed);
}

fn materials(out: &mut String, summary: &Summary, listed: usize) {
    if summary.materials.is_empty() {
        return;
    }
    let _ = writeln!(out, "\n{}", styled(BOLD, "Materials"));
    for material in summary.materials.iter().take(listed) {
        let mut facts = vec![human::plural(material.triangles, "triangle")];
        if material.exponent != 0.0 {
            facts.push(format!("exponent {}", number(material.exponent)));
        }
        if material.opacity != 1.0 {
            facts.push(format!("opacity {}", number(material.opacity)));
        }
        for (layer, file) in aam::document::Layer::ALL.iter().zip(&material.layers) {
            if let Some(file) = file {
                facts.push(format!("{} {file}", layer.name()));
            }
        }
        let _ = writeln!(out, "  {:<32} {}", material.name, facts.join(", "));
    }
    more(out, summary.materials.len(), listed);
}

/// Four digits at most after the point.
fn number(value: f32) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.to_owned() }
}
