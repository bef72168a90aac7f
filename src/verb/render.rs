//! `aam render`: pictures without a window.

use std::process::ExitCode;
use std::time::{Duration, Instant};

use aam_convert::Progress;
use aam_renderer::{Gpu, GpuError, Msaa, RenderOptions, Renderer, Show};
use aam_scene::{Background, Camera, DisplacementMode, Image, Scene, Shading, View, displacement};

use crate::args::{ShowArg, Size};
use crate::cli::{Displacement, Engine, RenderArgs, Shading as ShadingArg};
use crate::failure::Failure;
use crate::open::{self, OpenedScene};
use crate::picture::{self, Destination};
use crate::progress::Bar;
use crate::terminal::Terminal;
use crate::{args, camera, environment, human, shadows};

/// Warnings about a file that are shown without `-v`.
const SHOWN: usize = 5;

/// Steps of one picture's progress.
const PERCENT: u64 = 100;

/// How long each step took.
#[derive(Default)]
struct Times(Vec<(&'static str, Duration)>);

impl Times {
    fn add(&mut self, name: &'static str, time: Duration) {
        match self.0.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += time,
            None => self.0.push((name, time)),
        }
    }
}

pub(crate) fn run(args: &RenderArgs, terminal: &Terminal) -> Result<ExitCode, Failure> {
    let start = Instant::now();
    let destination = Destination::new(&args.output, args.turntable)?;
    if same_file(&args.output, &args.file) {
        return Err(Failure::new(format_args!("{}: the picture would replace its input", args.output.display())));
    }
    let progress = Bar::new(terminal);
    let mut times = Times::default();
    let (opened, device) = load(args, &progress, &mut times)?;
    tell(&opened, terminal);
    let mut scene = opened.scene;
    apply(args, &mut scene, terminal)?;
    if args.pixel_error.is_some() && args.displacement != Displacement::Adaptive {
        return Err(Failure::new("--pixel-error is for adaptive tessellation").help("add --displacement adaptive"));
    }
    if args.displacement != Displacement::Off {
        let warnings = scene.meshes.iter().flat_map(|mesh| displacement::warnings(mesh));
        warnings.for_each(|warning| terminal.warning(warning));
    }
    let mut engine = choose_engine(args, device, terminal)?;
    match &mut engine {
        Drawer::Gpu { show, .. } => {
            shadows::on_gpu(args.shadows, &mut scene)?;
            *show = shadows::show(&args.show, &scene)?;
        }
        Drawer::Reference { shadows, .. } => {
            if args.show != ShowArg::Lit {
                return Err(Failure::new("the reference engine draws lit pictures only").help("leave --show out"));
            }
            *shadows = shadows::traced(args.shadows, &scene, args.bounces > 0)?;
        }
    }
    let base = camera::choose(args, &scene, opened.camera.as_ref())?;
    if let Drawer::Gpu { .. } = engine {
        let Size { width, height } = args.size;
        let view = View { camera: base.clone(), width, height, frame: args.frame };
        shadows::limits(&scene, &view, terminal.verbose()).into_iter().for_each(|limit| terminal.note(limit));
    }
    let pictures = args.turntable.unwrap_or(1);
    let mut bytes = 0;
    for number in 0..pictures {
        tell_progress(&progress, number, args, &engine);
        let camera = match args.turntable {
            Some(count) => camera::turned(&base, scene.up, number as f32 / count as f32),
            None => base.clone(),
        };
        let image = engine.draw(args, &scene, camera, &mut times, &progress)?;
        if number == 0 && engine.lit_by_camera() {
            let no_shadows = if args.shadows.is_some() { ", which sees no shadows" } else { "" };
            terminal.note(format_args!("the scene has no lights; it is lit by one at the camera{no_shadows}"));
        }
        engine.warnings().for_each(|warning| terminal.warning(warning));
        let encoding = Instant::now();
        let png = picture::encode(&image)?;
        times.add("encode", encoding.elapsed());
        let writing = Instant::now();
        picture::write(&destination, number as usize, &png)?;
        times.add("write", writing.elapsed());
        bytes += png.len() as u64;
    }
    drop(progress);
    if args.time {
        terminal.always(table(&times, start.elapsed()));
    }
    if let Destination::Files(files) = &destination {
        let names = match &files[..] {
            [] => String::new(),
            [only] => only.display().to_string(),
            [first, .., last] => format!("{} … {}", first.display(), last.display()),
        };
        let size = args.size;
        terminal.summary(format_args!(
            "{names} ({} × {}, {}), {}, {}",
            size.width,
            size.height,
            human::bytes(bytes),
            engine.name(),
            human::duration(start.elapsed())
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn same_file(a: &std::path::Path, b: &std::path::Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

/// The scene; meanwhile the device, which takes as long as a small file.
fn load(
    args: &RenderArgs,
    progress: &Bar,
    times: &mut Times,
) -> Result<(OpenedScene, Option<Result<Gpu, GpuError>>), Failure> {
    let (opened, device) = std::thread::scope(|scope| {
        let device = (args.engine != Some(Engine::Reference)).then(|| {
            scope.spawn(|| {
                let start = Instant::now();
                (Gpu::headless(), start.elapsed())
            })
        });
        let start = Instant::now();
        let opened = match args.explode {
            Some(amount) => open::exploded(&args.file, &args.read, amount, progress),
            None => open::scene(&args.file, &args.read, progress),
        };
        times.add("load", start.elapsed());
        (opened, device.map(std::thread::ScopedJoinHandle::join))
    });
    let device = match device {
        Some(Ok((device, time))) => {
            times.add("device (while loading)", time);
            Some(device)
        }
        Some(Err(panic)) => std::panic::resume_unwind(panic),
        None => None,
    };
    Ok((opened?, device))
}

fn tell(opened: &OpenedScene, terminal: &Terminal) {
    let shown = if terminal.verbose() { opened.warnings.len() } else { SHOWN };
    for warning in opened.warnings.iter().take(shown) {
        terminal.warning(warning_text(warning));
    }
    if let Some(more) = opened.warnings.len().checked_sub(shown).filter(|more| *more > 0) {
        terminal.warning(format_args!("{} more; -v shows all", human::count(more)));
    }
}

/// A finding without its severity.
pub(crate) fn warning_text(finding: &aam::Finding) -> String {
    match finding.subject.is_empty() {
        true => finding.message.clone(),
        false => format!("{}: {}", finding.subject, finding.message),
    }
}

fn apply(args: &RenderArgs, scene: &mut Scene, terminal: &Terminal) -> Result<(), Failure> {
    environment::apply(&args.environment, scene, &args.read.limits.limits(), terminal)?;
    match args.background {
        Some(args::Background::Transparent) => scene.background = Background::Transparent,
        Some(args::Background::Color(color)) => scene.background = Background::Color(color),
        None => {}
    }
    match args.shading {
        Some(ShadingArg::Source) => scene.shading = Shading::Source,
        Some(ShadingArg::Linear) => scene.shading = Shading::Linear,
        None => {}
    }
    if args.bounces > 0 && scene.shading == Shading::Source {
        if args.shading.is_some() {
            let message = "--bounces cannot be drawn with --shading source: light adds up in linear light only";
            return Err(Failure::new(message).help("leave --shading out, or use --shading linear"));
        }
        terminal.note("shaded in linear light, for --bounces needs that");
        scene.shading = Shading::Linear;
    }
    environment::tell(&args.environment, scene, terminal);
    Ok(())
}

/// Pictures of a turntable, or parts of one picture where the engine tells them.
fn tell_progress(progress: &Bar, number: u32, args: &RenderArgs, engine: &Drawer) {
    match (args.turntable, engine) {
        (Some(count), _) if number == 0 => progress.stage("drawing", u64::from(count)),
        (Some(_), _) => progress.step(u64::from(number)),
        (None, Drawer::Reference { .. }) => progress.stage("drawing", PERCENT),
        (None, Drawer::Gpu { .. }) => progress.stage("drawing", 0),
    }
}

fn displacement_mode(args: &RenderArgs) -> DisplacementMode {
    match args.displacement {
        Displacement::Off => DisplacementMode::Off,
        Displacement::Parallax => DisplacementMode::Parallax,
        Displacement::Uniform => DisplacementMode::Uniform,
        Displacement::Adaptive => DisplacementMode::Adaptive { pixel_error: args.pixel_error.unwrap_or(1.0) },
    }
}

/// One of the two that draw.
enum Drawer {
    Gpu { renderer: Box<Renderer>, msaa: Msaa, show: Show, camera_light: bool, warnings: Vec<String> },
    Reference { camera_light: bool, shadows: Option<aam_reference::LightSize> },
}

fn choose_engine(
    args: &RenderArgs,
    device: Option<Result<Gpu, GpuError>>,
    terminal: &Terminal,
) -> Result<Drawer, Failure> {
    let reference = Drawer::Reference { camera_light: false, shadows: None };
    match device {
        None => Ok(reference),
        Some(Ok(_)) if args.bounces > 0 => {
            Err(Failure::new("the GPU engine does not draw light that bounces").help("add --engine reference"))
        }
        Some(Ok(gpu)) => {
            let samples = args.msaa.parse::<u32>().unwrap_or_default();
            let msaa = Msaa::try_from(samples).map_err(Failure::new)?;
            let renderer = Box::new(Renderer::new(gpu));
            Ok(Drawer::Gpu { renderer, msaa, show: Show::Lit, camera_light: false, warnings: Vec::new() })
        }
        Some(Err(error)) if args.engine == Some(Engine::Gpu) => {
            Err(Failure::new(error).help("--engine reference draws on the CPU"))
        }
        Some(Err(error)) => {
            terminal.note(format_args!("drawn on the CPU by the reference engine, for {error}"));
            Ok(reference)
        }
    }
}

impl Drawer {
    fn draw(
        &mut self,
        args: &RenderArgs,
        scene: &Scene,
        camera: Camera,
        times: &mut Times,
        progress: &Bar,
    ) -> Result<Image, Failure> {
        let view = View { camera, width: args.size.width, height: args.size.height, frame: args.frame };
        match self {
            Self::Gpu { renderer, msaa, show, camera_light, warnings } => {
                let displacement = displacement_mode(args);
                let options = RenderOptions { msaa: *msaa, show: *show, displacement, ..RenderOptions::default() };
                let (image, stats) = renderer
                    .render_to_image(scene, &view, &options)
                    .map_err(|error| Failure::new(error).help("--engine reference draws on the CPU"))?;
                let milliseconds = |ms: f64| Duration::from_secs_f64((ms * 1e-3).max(0.0));
                times.add("upload", milliseconds(stats.cpu.upload_ms));
                times.add("pipelines", milliseconds(stats.cpu.pipelines_ms));
                times.add("draw", milliseconds(stats.cpu.sort_ms + stats.cpu.encode_ms + stats.cpu.read_back_ms));
                *camera_light = stats.camera_light;
                *warnings = stats.warnings;
                Ok(image)
            }
            Self::Reference { camera_light, shadows } => {
                let told = |fraction: f32| progress.step((fraction * PERCENT as f32) as u64);
                let options = aam_reference::Options {
                    samples_per_pixel: args.samples,
                    shadows: *shadows,
                    light_samples: args.light_samples,
                    environment_samples: args.environment_samples,
                    bounces: args.bounces,
                    displacement: displacement_mode(args),
                    progress: args.turntable.is_none().then_some(&told),
                    ..aam_reference::Options::default()
                };
                let (image, stats) = aam_reference::render(scene, &view, &options).map_err(Failure::new)?;
                times.add("build", stats.build);
                times.add("trace", stats.trace);
                *camera_light = stats.camera_light;
                Ok(image)
            }
        }
    }

    fn lit_by_camera(&self) -> bool {
        match self {
            Self::Gpu { camera_light, .. } | Self::Reference { camera_light, .. } => *camera_light,
        }
    }

    /// What the last picture had to leave out or do otherwise.
    fn warnings(&self) -> impl Iterator<Item = &String> {
        match self {
            Self::Gpu { warnings, .. } => warnings.iter(),
            Self::Reference { .. } => [].iter(),
        }
    }

    fn name(&self) -> String {
        match self {
            Self::Gpu { renderer, .. } => renderer.gpu().summary().name.clone(),
            Self::Reference { .. } => "reference engine".into(),
        }
    }
}

fn table(times: &Times, total: Duration) -> String {
    let rows = times.0.iter().map(|(name, time)| (*name, *time)).chain([("total", total)]);
    let lines: Vec<String> = rows.map(|(name, time)| format!("{name:<24}{:>9}", human::duration(time))).collect();
    lines.join("\n")
}
