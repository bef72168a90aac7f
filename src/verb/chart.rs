//! `aam chart`: what techniques cost on a scene, and how wrong they are.

use std::path::Path;
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::Instant;

use aam_convert::Progress;
use aam_lab::shadows::{Plan, Run, ShadowChart, Subject, TruthKind, csv, fronts, json, measure, page, pareto};
use aam_lab::{Effort, LabError};
use aam_renderer::{Gpu, Renderer};
use aam_scene::{Camera, Scene, View};

use crate::cli::{ChartArgs, ChartShadowsArgs, ChartWhat, MeasureArgs};
use crate::failure::Failure;
use crate::progress::Bar;
use crate::terminal::{BOLD, Terminal};
use crate::{human, open};

/// Steps of the progress.
const STEPS: u64 = 1000;

/// Settings of the front that are listed without `-v`.
const LISTED: usize = 12;

pub(crate) fn run(args: &ChartArgs, terminal: &Terminal) -> Result<ExitCode, Failure> {
    match &args.what {
        ChartWhat::Shadows(args) => shadows(args, terminal),
    }
}

fn shadows(args: &ChartShadowsArgs, terminal: &Terminal) -> Result<ExitCode, Failure> {
    let start = Instant::now();
    folder(&args.output)?;
    let progress = Bar::new(terminal);
    let opened = open::scene(&args.file, &args.read, &progress)?;
    let view = view(&args.measure, &opened.scene, opened.camera.as_ref())?;
    let subject = Subject::new(scene_name(&args.file), &opened.scene, view, args.measure.light.as_deref())
        .map_err(|error| Failure::new(format_args!("{}: {error}", args.file.display())))?;
    let chart = measured(&args.measure, &subject, &mut renderer()?, &progress)?;
    drop(progress);
    let write = |name: &str, text: &str| -> Result<(), Failure> {
        Ok(aam::write_bytes(&args.output.join(name), text.as_bytes())?)
    };
    write("data.csv", &csv(&chart))?;
    write("data.json", &format!("{:#}\n", json(&chart)))?;
    write("fronts.svg", &fronts(&chart))?;
    write("index.html", &page(&chart, &command(args)).map_err(Failure::new)?)?;
    tell(&chart, terminal)?;
    terminal.summary(format_args!(
        "{BOLD}{}{BOLD:#}: {} of {} on {}, {}",
        args.output.join("index.html").display(),
        human::plural(chart.runs.len().saturating_sub(1), "setting"),
        chart.light,
        chart.adapter,
        human::duration(start.elapsed())
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// Makes the folder before anything is measured.
fn folder(path: &Path) -> Result<(), Failure> {
    if path.exists() && !path.is_dir() {
        return Err(Failure::new(format_args!("{} is a file", path.display())).help("name a folder: -o chart"));
    }
    std::fs::create_dir_all(path).map_err(|error| Failure::io(path, "make the folder", &error))
}

/// A device that can measure.
pub(super) fn renderer() -> Result<Renderer, Failure> {
    let gpu = Gpu::headless()
        .map_err(|error| Failure::new(format_args!("techniques of the GPU cannot be measured without one: {error}")))?;
    Ok(Renderer::new(gpu))
}

/// The file's name without its endings.
pub(super) fn scene_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    stem.strip_suffix(".scene").unwrap_or(&stem).to_owned()
}

/// Which camera the arguments ask for.
pub(super) fn view(args: &MeasureArgs, scene: &Scene, active: Option<&Camera>) -> Result<View, Failure> {
    let (width, height) = (args.size.width, args.size.height);
    let camera = match &args.view {
        None => active.cloned().unwrap_or_else(|| scene.fitting_camera(width as f32 / height as f32)),
        Some(name) => scene.cameras.iter().find(|camera| camera.name == *name).cloned().ok_or_else(|| {
            let names: Vec<String> = scene.cameras.iter().map(|camera| format!("\"{}\"", camera.name)).collect();
            let known =
                if names.is_empty() { "the file has none".into() } else { format!("there are {}", names.join(", ")) };
            Failure::new(format_args!("there is no camera \"{name}\"; {known}"))
        })?,
    };
    Ok(View { camera, width, height, frame: args.frame })
}

pub(super) fn plan(args: &MeasureArgs) -> Plan {
    let mut plan = Plan::new(match (args.quick, args.full) {
        (true, _) => Effort::Quick,
        (_, true) => Effort::Full,
        _ => Effort::Normal,
    });
    if !args.techniques.is_empty() {
        plan.techniques.clone_from(&args.techniques);
    }
    plan
}

fn measured(
    args: &MeasureArgs,
    subject: &Subject,
    renderer: &mut Renderer,
    progress: &Bar,
) -> Result<ShadowChart, Failure> {
    measured_by(&plan(args), subject, renderer, progress)
}

/// Measures, and shows how far it is.
pub(super) fn measured_by(
    plan: &Plan,
    subject: &Subject,
    renderer: &mut Renderer,
    progress: &Bar,
) -> Result<ShadowChart, Failure> {
    progress.stage("measuring", STEPS);
    let last = Mutex::new(String::new());
    let told = |doing: &str, share: f32| {
        if let Ok(mut last) = last.lock()
            && *last != doing
        {
            doing.clone_into(&mut last);
            progress.name(doing);
        }
        progress.step((share * STEPS as f32) as u64);
    };
    measure(subject, plan, renderer, &told).map_err(|error| match error {
        LabError::NoTimestamps => {
            Failure::new(error).help("another driver may; WGPU_BACKEND and WGPU_ADAPTER_NAME choose")
        }
        error => Failure::new(error),
    })
}

/// The fronts, and what was left out.
fn tell(chart: &ShadowChart, terminal: &Terminal) -> Result<(), Failure> {
    let listed = if terminal.verbose() { usize::MAX } else { LISTED };
    for (index, truth) in chart.truths.iter().enumerate() {
        let error = |run: &Run| run.judged[index].visibility.rmse;
        let front = pareto(chart.runs.iter().map(|run| (run.times.gpu_ms, error(run))));
        let what = match truth.kind {
            TruthKind::Point => "the light as a point",
            TruthKind::Area => "the light at its size",
        };
        terminal.summary(format_args!("On the front against {what}, RMSE of its visibility:"))?;
        for run in front.iter().take(listed).map(|index| &chart.runs[*index]) {
            terminal.summary(format_args!("  {:>9.2} ms  {:.4}  {}", run.times.gpu_ms, error(run), run.label()))?;
        }
        if front.len() > listed {
            terminal.summary(format_args!("  and {} more (-v lists all)", front.len() - listed))?;
        }
    }
    let late = chart.left.iter().filter(|left| left.reason.contains("no time")).count();
    if late > 0 {
        terminal.note(format_args!(
            "{} not measured for want of time; --full takes all it needs",
            human::plural(late, "setting")
        ));
    }
    for left in chart.left.iter().filter(|left| terminal.verbose() && !left.reason.contains("no time")) {
        terminal.note(format_args!("{}: {}", left.settings, left.reason));
    }
    Ok(())
}

/// The command as it could be given again.
fn command(args: &ChartShadowsArgs) -> String {
    let MeasureArgs { quick, full, techniques, size, light, view, frame } = &args.measure;
    let mut words = vec![format!("aam chart shadows {} -o {}", args.file.display(), args.output.display())];
    words.extend(quick.then(|| "--quick".into()));
    words.extend(full.then(|| "--full".into()));
    if !techniques.is_empty() {
        let names: Vec<String> = techniques.iter().map(ToString::to_string).collect();
        words.push(format!("--techniques {}", names.join(",")));
    }
    words.push(format!("--size {}x{}", size.width, size.height));
    words.extend(light.as_ref().map(|light| format!("--light {light:?}")));
    words.extend(view.as_ref().map(|view| format!("--view {view:?}")));
    words.extend((*frame != 0.0).then(|| format!("--frame {frame}")));
    words.join(" ")
}
