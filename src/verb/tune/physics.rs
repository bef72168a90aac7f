//! How many convex hulls bodies need.

use std::process::ExitCode;

use aam::Document;
use aam::document::{BodyMode, Convex, Object};
use aam_convert::hulls::{Decomposition, HullOptions, decompose};
use aam_convert::physics::{PhysicsOptions, add_bodies};
use aam_convert::{Asset, ExportOptions, Progress};
use aam_physics::{DropErrors, DropTest, Shape};
use glam::Vec3;
use serde_json::json;

use super::TunePhysicsArgs;
use crate::failure::Failure;
use crate::open;
use crate::progress::Bar;
use crate::terminal::{BOLD, Terminal};

/// Where the surface is open, so many hulls stand for it.
const FINE: usize = 256;

/// What was found for one object.
struct Tuned {
    /// Its position in frame 0.
    object: usize,
    name: String,
    /// What it was compared with.
    exact: &'static str,
    control: DropErrors,
    tried: Vec<Tried>,
    /// The fewest that are good enough, or else the best: a position in `tried`.
    chosen: usize,
    enough: bool,
}

struct Tried {
    decomposition: Decomposition,
    errors: DropErrors,
}

pub(super) fn run(args: &TunePhysicsArgs, terminal: &Terminal) -> Result<ExitCode, Failure> {
    if let (Some(output), Ok(input)) = (&args.output, args.file.canonicalize())
        && output.canonicalize().is_ok_and(|output| output == input)
    {
        return Err(Failure::new(format_args!("{}: the output would replace its input", output.display())));
    }
    let progress = Bar::new(terminal);
    let mut asset = open::asset(&args.file, &open::import_options(&args.read), &progress)?;
    let objects = moving_objects(&asset.document);
    let mut found = Vec::new();
    for (number, object) in objects.iter().enumerate() {
        progress.stage("dropping", objects.len() as u64);
        progress.step(number as u64);
        match tune(args, &asset.document, *object) {
            Ok(tuned) => found.push(tuned),
            Err((name, reason)) => terminal.warning(format_args!("{name}: it is no solid body: {reason}")),
        }
    }
    drop(progress);
    if found.is_empty() {
        return Err(Failure::new(format_args!("{}: it has no object that could move", args.file.display()))
            .help("an object needs triangles that enclose a volume"));
    }
    if args.json {
        terminal.result(format_args!("{:#}", report(args, &found)))?;
    } else {
        for tuned in &found {
            table(tuned, terminal)?;
        }
    }
    let enough = found.iter().all(|tuned| tuned.enough);
    for tuned in found.iter().filter(|tuned| !tuned.enough) {
        let least = tuned.tried[tuned.chosen].errors.largest();
        terminal.warning(format_args!(
            "{}: {} hulls are not enough for {:.2} %: the least error is {:.2} %",
            tuned.name,
            args.hulls,
            100.0 * args.max_error,
            100.0 * least
        ));
    }
    if let Some(output) = &args.output {
        put_bodies(&mut asset, found)?;
        aam_convert::export(&asset, output, &ExportOptions::default())?;
        terminal.summary(format_args!("{BOLD}{}{BOLD:#} has these bodies", output.display()))?;
    }
    Ok(ExitCode::from(u8::from(!enough)))
}

/// The objects whose bodies are made of hulls: all with triangles, or those that the file's `PHYSICS` moves.
fn moving_objects(document: &Document) -> Vec<usize> {
    let moves = |object: &Object| match &document.physics {
        None => true,
        Some(physics) => physics.bodies.iter().any(|body| body.object == object.id && body.mode != BodyMode::Static),
    };
    let solid = |object: &Object| object.faces.as_ref().is_some_and(|faces| !faces.triangles.is_empty());
    let objects = document.objects().iter().enumerate();
    objects.filter(|(_, object)| solid(object) && moves(object)).map(|(index, _)| index).collect()
}

/// The name, and why it cannot be tuned.
type Refused = (String, String);

fn tune(args: &TunePhysicsArgs, document: &Document, index: usize) -> Result<Tuned, Refused> {
    let object = &document.objects()[index];
    let name = object.name.decoded();
    let refused = |reason: String| (name.clone(), reason);
    let triangles: Vec<[u32; 3]> =
        object.faces.iter().flat_map(|faces| &faces.triangles).map(|triangle| triangle.vertices).collect();
    let cut = |max_hulls: usize| {
        // As accurate as the number allows.
        let options = HullOptions { max_hulls, max_error: None, ..HullOptions::default() };
        decompose(&object.vertices, &triangles, &options).map_err(|error| refused(error.to_string()))
    };
    let surface = Shape::Triangles {
        vertices: object.vertices.iter().copied().map(Vec3::from).collect(),
        triangles: triangles.clone(),
    };
    let (test, exact) = match DropTest::new(&surface, args.drops) {
        Ok(test) => (test, "its closed surface"),
        // Open, or inside out.
        Err(_) => {
            let fine = DropTest::new(&compound(&cut(FINE)?), args.drops);
            (fine.map_err(|error| refused(error.to_string()))?, "256 hulls, for its surface is open")
        }
    };
    let control = *test.control();
    // What two equal drops do not tell apart is no error of the hulls.
    let wanted = args.max_error.max(control.largest());
    let most = args.hulls as usize;
    let mut tried: Vec<Tried> = Vec::new();
    for count in std::iter::successors(Some(1), |count| Some(2 * count)).take_while(|count| *count < most).chain([most])
    {
        let decomposition = cut(count)?;
        // A convex object has one hull however many are allowed.
        if tried.last().is_some_and(|last| last.decomposition.hulls.len() == decomposition.hulls.len()) {
            break;
        }
        let errors = test.compare(&compound(&decomposition)).map_err(|error| refused(error.to_string()))?;
        tried.push(Tried { decomposition, errors });
        if errors.largest() <= wanted {
            break;
        }
    }
    let best = (0..tried.len()).min_by(|a, b| tried[*a].errors.largest().total_cmp(&tried[*b].errors.largest()));
    let chosen = best.ok_or_else(|| refused("it has no hull".into()))?;
    let enough = tried[chosen].errors.largest() <= wanted;
    Ok(Tuned { object: index, name, exact, control, tried, chosen, enough })
}

fn compound(decomposition: &Decomposition) -> Shape {
    let pieces = decomposition.hulls.iter().map(|hull| hull.vertices.iter().copied().map(Vec3::from).collect());
    Shape::Compound { primitives: Vec::new(), pieces: pieces.collect() }
}

fn table(tuned: &Tuned, terminal: &Terminal) -> Result<(), Failure> {
    let percent = |value: f32| 100.0 * value;
    terminal.result(format_args!("{BOLD}{}{BOLD:#}: compared with {}", tuned.name, tuned.exact))?;
    terminal.result("   hulls  surface, %   path, %   worst   rest, %   worst   jitter, %/s   step, µs")?;
    let row = |label: &str, surface: Option<f32>, errors: &DropErrors| {
        let surface = surface.map_or_else(|| "-".into(), |surface| format!("{:.2}", percent(surface)));
        terminal.result(format_args!(
            "{label:>8}  {surface:>10}  {:>8.2}  {:>6.2}  {:>8.2}  {:>6.2}  {:>12.3}  {:>9.1}",
            percent(errors.path),
            percent(errors.worst_path),
            percent(errors.rest),
            percent(errors.worst_rest),
            percent(errors.jitter),
            1e6 * errors.step_time.as_secs_f64()
        ))
    };
    for tried in &tuned.tried {
        let surface = tried.decomposition.quality.hausdorff();
        row(&tried.decomposition.hulls.len().to_string(), Some(surface), &tried.errors)?;
    }
    row("exact", None, &tuned.control)?;
    let count = tuned.tried[tuned.chosen].decomposition.hulls.len();
    let verdict = if tuned.enough { "enough" } else { "the best of these" };
    terminal.result(format_args!(
        "   {BOLD}{count}{BOLD:#} {} {verdict}",
        if count == 1 { "hull is" } else { "hulls are" }
    ))?;
    Ok(())
}

fn report(args: &TunePhysicsArgs, found: &[Tuned]) -> serde_json::Value {
    let errors = |errors: &DropErrors| {
        json!({
            "path": errors.path, "worst_path": errors.worst_path,
            "rest": errors.rest, "worst_rest": errors.worst_rest,
            "jitter": errors.jitter, "step_seconds": errors.step_time.as_secs_f64(),
        })
    };
    let objects: Vec<_> = found
        .iter()
        .map(|tuned| {
            let tried: Vec<_> = tuned
                .tried
                .iter()
                .map(|tried| {
                    json!({
                        "hulls": tried.decomposition.hulls.len(),
                        "surface": tried.decomposition.quality.hausdorff(),
                        "errors": errors(&tried.errors),
                    })
                })
                .collect();
            json!({
                "name": tuned.name, "compared_with": tuned.exact, "control": errors(&tuned.control), "tried": tried,
                "hulls": tuned.tried[tuned.chosen].decomposition.hulls.len(), "enough": tuned.enough,
            })
        })
        .collect();
    json!({ "file": args.file, "max_error": args.max_error, "drops": args.drops, "objects": objects })
}

/// Gives the objects the hulls that were chosen; bodies that the file had stay as they are otherwise.
fn put_bodies(asset: &mut Asset, found: Vec<Tuned>) -> Result<(), Failure> {
    if asset.document.physics.is_none() {
        let most = found.iter().map(|tuned| tuned.tried[tuned.chosen].decomposition.hulls.len()).max().unwrap_or(1);
        let hulls = HullOptions { max_hulls: most, max_error: None, ..HullOptions::default() };
        add_bodies(asset, &PhysicsOptions { hulls, ..PhysicsOptions::new(BodyMode::Dynamic) }, &aam_convert::Silent)?;
    }
    for mut tuned in found {
        let id = asset.document.objects()[tuned.object].id;
        let hulls = tuned.tried.swap_remove(tuned.chosen).decomposition.hulls;
        let bodies = asset.document.physics.iter_mut().flat_map(|physics| &mut physics.bodies);
        for body in bodies.filter(|body| body.object == id && body.mode != BodyMode::Static) {
            body.primitives = None;
            let pieces = (0..).zip(&hulls).map(|(number, hull)| Convex {
                number,
                vertices: hull.vertices.clone(),
                triangles: hull.triangles.clone(),
            });
            body.pieces = Some(pieces.collect());
        }
    }
    Ok(())
}
