//! `aam decompose`: convex pieces of a model, and how near they are.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use aam::document::{self, Faces, NodeTransform, Object, Primitive, Triangle};
use aam_convert::hulls::{Distances, Hull, HullOptions};
use aam_convert::physics::{Decomposed, PhysicsOptions, add_bodies};
use aam_convert::{Asset, ExportOptions, Outcome};
use aam_scene::Up;
use serde::Serialize;
use serde_json::json;

use crate::cli::{Axis, BodyMode, DecomposeArgs, HullArgs};
use crate::failure::Failure;
use crate::human::json_path;
use crate::progress::Bar;
use crate::terminal::{BOLD, Terminal};
use crate::{human, open};

/// Formats that can be written.
const WRITABLE: &str = ".aam .glb .gltf .obj .json";

impl HullArgs {
    /// An option that was given.
    pub(crate) fn given(&self) -> Option<&'static str> {
        let all = [
            ("--hulls", self.hulls.is_some()),
            ("--max-error", self.max_error.is_some()),
            ("--max-verts-per-hull", usize::from(self.max_verts_per_hull) != HullOptions::default().max_vertices),
            ("--primitives", self.primitives),
        ];
        all.into_iter().find(|(_, given)| *given).map(|(option, _)| option)
    }

    /// What the arguments ask for. Who asks for a number of hulls wants the best that so many can do.
    pub(crate) fn options(&self) -> HullOptions {
        let default = HullOptions::default();
        HullOptions {
            max_hulls: self.hulls.map_or(default.max_hulls, |count| count as usize),
            max_error: self.max_error.or(default.max_error.filter(|_| self.hulls.is_none())),
            max_vertices: usize::from(self.max_verts_per_hull),
            primitives: self.primitives,
        }
    }
}

pub(crate) fn run(args: &DecomposeArgs, terminal: &Terminal) -> Result<ExitCode, Failure> {
    let start = Instant::now();
    check_names(args)?;
    let progress = Bar::new(terminal);
    let mut asset = open::asset(&args.file, &open::import_options(&args.read), &progress)?;
    let mode = match args.mode {
        BodyMode::Static => {
            return Err(Failure::new(
                "static bodies collide with their own triangles, so there is nothing to decompose",
            )
            .help("--mode dynamic or --mode kinematic; `aam convert --physics static` makes static ones"));
        }
        BodyMode::Kinematic => document::BodyMode::Kinematic,
        BodyMode::Dynamic => document::BodyMode::Dynamic,
    };
    let options = PhysicsOptions { hulls: args.hulls.options(), ..PhysicsOptions::new(mode) };
    let before = asset.report.changes.len();
    let made = add_bodies(&mut asset, &options, &progress)?;
    for change in &asset.report.changes[before..] {
        if change.outcome == Outcome::Lost {
            terminal.warning(super::convert::sentence(change));
        }
    }
    write(args, &asset, &made)?;
    drop(progress);
    if let Some(path) = &args.report {
        let report = Reported::new(args, &asset, &made, &options.hulls);
        let json = serde_json::to_string_pretty(&report).map_err(Failure::new)?;
        aam::write_bytes(path, format!("{json}\n").as_bytes())?;
    }
    summary(args, &asset, &made, &options.hulls, terminal)?;
    let hulls: usize = made.iter().map(|one| one.decomposition.hulls.len()).sum();
    terminal.summary(format_args!(
        "{BOLD}{}{BOLD:#}: {}, {}",
        args.output.display(),
        human::plural(hulls, "hull"),
        human::duration(start.elapsed())
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// What would go wrong after the work is said before it.
fn check_names(args: &DecomposeArgs) -> Result<(), Failure> {
    let output = &args.output;
    if extension(output).is_none_or(|ending| !WRITABLE.split(' ').any(|known| known[1..] == ending)) {
        return Err(Failure::new(format_args!("{}: hulls cannot be written as this", output.display()))
            .help(format_args!("the output's extension decides: {WRITABLE}")));
    }
    for path in [Some(output), args.report.as_ref()].into_iter().flatten() {
        if let (Ok(a), Ok(b)) = (path.canonicalize(), args.file.canonicalize())
            && a == b
        {
            return Err(Failure::new(format_args!("{}: the output would replace its input", path.display())));
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            return Err(Failure::new(format_args!(
                "{}: the folder {} does not exist",
                path.display(),
                folder.display()
            ))
            .help(format_args!("mkdir -p {}", folder.display())));
        }
    }
    if args.report.as_ref() == Some(output) {
        return Err(Failure::new(format_args!("{}: the report would replace the output", output.display())));
    }
    Ok(())
}

fn extension(path: &Path) -> Option<String> {
    path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase())
}

fn write(args: &DecomposeArgs, asset: &Asset, made: &[Decomposed]) -> Result<(), Failure> {
    let up = args.read.up.map(|axis| match axis {
        Axis::Y => Up::Y,
        Axis::Z => Up::Z,
    });
    let options = ExportOptions { up, limits: args.read.limits.limits(), ..ExportOptions::default() };
    match extension(&args.output).as_deref() {
        Some("json") => {
            let objects: Vec<_> = made
                .iter()
                .map(|one| {
                    let hulls: Vec<_> = one.decomposition.hulls.iter().map(hull).collect();
                    let object = &asset.document.objects()[one.object];
                    json!({ "id": object.id, "name": object.name.decoded(), "hulls": hulls })
                })
                .collect();
            let json = json!({ "input": args.file.display().to_string(), "objects": objects });
            Ok(aam::write_bytes(&args.output, format!("{json:#}\n").as_bytes())?)
        }
        Some("obj") => {
            aam_convert::export(&separate(asset, made), &args.output, &options)?;
            Ok(())
        }
        _ => {
            aam_convert::export(asset, &args.output, &options)?;
            Ok(())
        }
    }
}

fn hull(hull: &Hull) -> serde_json::Value {
    json!({
        "vertices": hull.vertices,
        "triangles": hull.triangles,
        "volume": hull.volume,
        "primitive": hull.primitive.as_ref().map(primitive),
    })
}

fn primitive(primitive: &Primitive) -> serde_json::Value {
    match primitive {
        Primitive::Box { center, orientation, half } => {
            json!({ "kind": "box", "center": center, "orientation": orientation, "half": half })
        }
        Primitive::Sphere { center, radius } => json!({ "kind": "sphere", "center": center, "radius": radius }),
        Primitive::Capsule { a, b, radius } => json!({ "kind": "capsule", "a": a, "b": b, "radius": radius }),
    }
}

/// An asset with an object for each hull, below its object, which loses its triangles.
fn separate(asset: &Asset, made: &[Decomposed]) -> Asset {
    let mut document = asset.document.clone();
    let mut objects = asset.document.objects().to_vec();
    for object in &mut objects {
        (object.vertices, object.faces, object.colors) = (Vec::new(), None, None);
    }
    let mut next = objects.iter().map(|object| object.id).max().unwrap_or(0);
    for one in made {
        let object = &asset.document.objects()[one.object];
        for (number, hull) in one.decomposition.hulls.iter().enumerate() {
            next = next.wrapping_add(1);
            let triangle = |vertices: &[u32; 3]| Triangle { vertices: *vertices, smoothing: 0 };
            objects.push(Object {
                id: next,
                name: format!("{}_hull_{number}", object.name.decoded()).into(),
                parent: object.id,
                node: object.node.map(|_| NodeTransform::default()),
                material: -1,
                vertices: hull.vertices.clone(),
                faces: Some(Faces { triangles: hull.triangles.iter().map(triangle).collect(), ..Faces::default() }),
                ..Object::default()
            });
        }
    }
    document.physics = None;
    document.geometry.frames.truncate(1);
    if let Some(frame) = document.geometry.frames.first_mut() {
        frame.objects = objects;
    }
    Asset { document, ..Asset::default() }
}

/// The report.
#[derive(Serialize)]
struct Reported<'a> {
    #[serde(serialize_with = "json_path")]
    input: &'a Path,
    #[serde(serialize_with = "json_path")]
    output: &'a Path,
    options: Options,
    hulls: usize,
    vertices: usize,
    hausdorff_percent: f32,
    seconds: f64,
    objects: Vec<ReportedObject>,
}

#[derive(Serialize)]
struct Options {
    hulls: usize,
    max_error_percent: Option<f32>,
    max_verts_per_hull: usize,
    primitives: bool,
}

#[derive(Serialize)]
struct ReportedObject {
    id: i32,
    name: String,
    triangles: usize,
    hulls: Vec<ReportedHull>,
    vertices: usize,
    outside: Percent,
    uncovered: Percent,
    hausdorff_percent: f32,
    mean_percent: f32,
    sample_spacing_percent: f32,
    volume: f64,
    volume_ratio: Option<f64>,
    dropped: usize,
    seconds: f64,
}

#[derive(Serialize)]
struct ReportedHull {
    vertices: usize,
    triangles: usize,
    volume: f64,
    primitive: Option<&'static str>,
    outside: Percent,
    uncovered: Percent,
    hausdorff_percent: f32,
}

#[derive(Serialize)]
struct Percent {
    max_percent: f32,
    mean_percent: f32,
}

impl From<Distances> for Percent {
    fn from(distances: Distances) -> Self {
        Self { max_percent: 100.0 * distances.max, mean_percent: 100.0 * distances.mean }
    }
}

impl<'a> Reported<'a> {
    fn new(args: &'a DecomposeArgs, asset: &Asset, made: &[Decomposed], options: &HullOptions) -> Self {
        let objects: Vec<ReportedObject> = made.iter().map(|one| ReportedObject::new(asset, one)).collect();
        Self {
            input: &args.file,
            output: &args.output,
            options: Options {
                hulls: options.max_hulls,
                max_error_percent: options.max_error.map(|error| 100.0 * error),
                max_verts_per_hull: options.max_vertices,
                primitives: options.primitives,
            },
            hulls: objects.iter().map(|object| object.hulls.len()).sum(),
            vertices: objects.iter().map(|object| object.vertices).sum(),
            hausdorff_percent: objects.iter().map(|object| object.hausdorff_percent).fold(0.0, f32::max),
            seconds: objects.iter().map(|object| object.seconds).sum(),
            objects,
        }
    }
}

impl ReportedObject {
    fn new(asset: &Asset, one: &Decomposed) -> Self {
        let object = &asset.document.objects()[one.object];
        let (found, quality) = (&one.decomposition, &one.decomposition.quality);
        let volume = found.hulls.iter().map(|hull| hull.volume).sum::<f64>();
        let hulls = found.hulls.iter().zip(&quality.pieces).map(|(hull, [outside, uncovered])| ReportedHull {
            vertices: hull.vertices.len(),
            triangles: hull.triangles.len(),
            volume: hull.volume,
            primitive: hull.primitive.as_ref().map(kind),
            outside: (*outside).into(),
            uncovered: (*uncovered).into(),
            hausdorff_percent: 100.0 * outside.max.max(uncovered.max),
        });
        Self {
            id: object.id,
            name: object.name.decoded(),
            triangles: object.faces.as_ref().map_or(0, |faces| faces.triangles.len()),
            hulls: hulls.collect(),
            vertices: found.hulls.iter().map(|hull| hull.vertices.len()).sum(),
            outside: quality.outside.into(),
            uncovered: quality.uncovered.into(),
            hausdorff_percent: 100.0 * quality.hausdorff(),
            mean_percent: 100.0 * quality.mean(),
            sample_spacing_percent: 100.0 * quality.spacing,
            volume,
            volume_ratio: one.closed_volume.map(|closed| volume / closed),
            dropped: found.dropped,
            seconds: one.time.as_secs_f64(),
        }
    }
}

fn kind(primitive: &Primitive) -> &'static str {
    match primitive {
        Primitive::Box { .. } => "box",
        Primitive::Sphere { .. } => "sphere",
        Primitive::Capsule { .. } => "capsule",
    }
}

fn summary(
    args: &DecomposeArgs,
    asset: &Asset,
    made: &[Decomposed],
    options: &HullOptions,
    terminal: &Terminal,
) -> Result<(), Failure> {
    const LISTED: usize = 20;
    let listed = if terminal.verbose() { usize::MAX } else { LISTED };
    for one in made.iter().take(listed) {
        let (found, quality) = (&one.decomposition, &one.decomposition.quality);
        let most = found.hulls.iter().map(|hull| hull.vertices.len()).max().unwrap_or(0);
        let simple = found.hulls.iter().filter(|hull| hull.primitive.is_some()).count();
        let simple = if simple > 0 { format!(" ({simple} simple shapes)") } else { String::new() };
        terminal.summary(format_args!(
            "  {}: {}{simple}, {most} vertices at most; Hausdorff {:.2} %, mean {:.3} % of the diagonal, {:.2} s",
            asset.document.objects()[one.object].name.decoded(),
            human::plural(found.hulls.len(), "hull"),
            100.0 * quality.hausdorff(),
            100.0 * quality.mean(),
            one.time.as_secs_f64(),
        ))?;
        if let Some(wanted) = options.max_error
            && quality.hausdorff() > wanted
        {
            terminal.note(format_args!("{:.2} % is not reached: allow more with --hulls", 100.0 * wanted));
        }
    }
    if made.len() > listed {
        terminal.summary(format_args!("  and {} more (-v lists all)", made.len() - listed))?;
    }
    if args.hulls.primitives && extension(&args.output).as_deref() == Some("obj") {
        terminal.note("OBJ has no simple shapes: all are written as hulls");
    }
    Ok(())
}
