//! `aam simulate`: rigid bodies, without a window.

use std::collections::{BTreeMap, HashMap};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use aam::document::BodyMode;
use aam::{Document, Finding};
use aam_convert::{Asset, ExportOptions, Progress};
use aam_physics::{
    Continuous, Divergence, PhysicsError, PhysicsMesh, Poses, Registration, Settings, Simulator, physics_meshes,
};
use aam_renderer::{Gpu, RenderOptions, Renderer};
use aam_scene::{BuildOptions, Camera, NoTextures, NodeId, Scene, SceneFile, View, build, object_nodes};
use serde_json::json;

use crate::cli::{Continuous as ContinuousArg, SimulateArgs};
use crate::failure::Failure;
use crate::picture::{self, Destination};
use crate::progress::Bar;
use crate::terminal::{BOLD, Terminal};
use crate::{human, open};

/// Simulated seconds where neither time nor steps are said.
const DEFAULT_TIME: f32 = 5.0;
/// The most poses that are kept for an output, 28 bytes each.
const MOST_POSES: u64 = 1 << 25;
/// Bodies that are listed without `-v`.
const LISTED: usize = 20;

pub(crate) fn run(args: &SimulateArgs, terminal: &Terminal) -> Result<ExitCode, Failure> {
    let start = Instant::now();
    let output = args.output.as_deref().map(|path| Output::new(path, &args.file)).transpose()?;
    let progress = Bar::new(terminal);
    let drawn = matches!(output, Some(Output::Pictures(_)));
    let loaded = if drawn { load_drawn(args, &progress)? } else { load(args, &progress)? };
    if let (Some(Output::Animation(path)), None) = (&output, &loaded.asset) {
        return Err(Failure::new(format_args!(
            "{}: a scene of several assets cannot be one animation",
            path.display()
        ))
        .help("write .json or .csv, or simulate one of its assets"));
    }
    let (mut simulator, findings) = prepare(args, &loaded)?;
    for finding in &findings {
        terminal.warning(finding);
    }
    let bodies: Vec<NodeId> = simulator.bodies().collect();
    if bodies.is_empty() {
        return Err(Failure::new(format_args!("{}: there are no bodies to simulate", args.file.display()))
            .help("`aam convert model.glb model.aam --physics dynamic` makes some"));
    }
    let steps = steps(args);
    let frames_per_second = f64::from(args.read.fps);
    if output.is_some() {
        let frames = steps as f64 * f64::from(args.dt) * frames_per_second;
        if frames * bodies.len() as f64 > MOST_POSES as f64 {
            return Err(Failure::new(format_args!(
                "{} poses in all are more than can be kept",
                frames.ceil() * bodies.len() as f64
            ))
            .help("lower --fps or --time"));
        }
    }
    let stepping = Instant::now();
    let (frames, divergence) =
        simulate(&mut simulator, steps, output.is_some().then_some(frames_per_second), &progress)?;
    let elapsed = stepping.elapsed();
    drop(progress);
    if let Some(output) = &output {
        write(output, args, &loaded, &simulator, &frames, terminal)?;
    }
    if args.hash {
        terminal.result(format_args!("{:016x}", simulator.hash()))?;
    } else {
        summary(args, &simulator, &bodies, elapsed.as_secs_f64(), terminal)?;
    }
    if let Some(output) = &output {
        terminal.summary(format_args!(
            "{BOLD}{}{BOLD:#}: {}, {}",
            output.path().display(),
            human::plural(frames.len(), "frame"),
            human::duration(start.elapsed())
        ))?;
    }
    let Some(divergence) = divergence else { return Ok(ExitCode::SUCCESS) };
    let failure =
        Failure::new(&divergence).help("shorter steps (--dt 1/240) or more --iterations may hold it together");
    terminal.failure(&failure);
    Ok(ExitCode::from(1))
}

/// Where poses go.
enum Output {
    Json(PathBuf),
    Csv(PathBuf),
    Animation(PathBuf),
    /// One PNG for each frame, numbered.
    Pictures(PathBuf),
}

impl Output {
    fn new(path: &Path, input: &Path) -> Result<Self, Failure> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        let output = match extension.as_deref() {
            Some("json") => Self::Json(path.to_owned()),
            Some("csv") => Self::Csv(path.to_owned()),
            Some("aam" | "glb" | "gltf") => Self::Animation(path.to_owned()),
            Some("png") => Self::Pictures(path.to_owned()),
            _ => {
                return Err(Failure::new(format_args!("{}: poses cannot be written as this", path.display()))
                    .help("the output's extension decides: .json .csv .aam .glb .gltf .png"));
            }
        };
        if let (Ok(a), Ok(b)) = (path.canonicalize(), input.canonicalize())
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
        Ok(output)
    }

    fn path(&self) -> &Path {
        match self {
            Self::Json(path) | Self::Csv(path) | Self::Animation(path) | Self::Pictures(path) => path,
        }
    }
}

/// What is simulated.
struct Loaded {
    scene: Scene,
    /// Each document, and the node of its first object.
    documents: Vec<(Arc<Document>, usize)>,
    /// The asset, where there is but one.
    asset: Option<Asset>,
    /// The camera that the file names.
    camera: Option<Camera>,
}

fn load(args: &SimulateArgs, progress: &dyn Progress) -> Result<Loaded, Failure> {
    let options = open::import_options(&args.read);
    // What textures show does not matter here.
    let scene_of = |document: &Document| build(document, &NoTextures, &BuildOptions::default()).scene;
    if !SceneFile::is_one(&args.file) {
        let asset = open::asset(&args.file, &options, progress)?;
        let document = Arc::new(asset.document.clone());
        return Ok(Loaded {
            scene: scene_of(&document),
            documents: vec![(document, 0)],
            asset: Some(asset),
            camera: None,
        });
    }
    let file = SceneFile::read(&args.file)?;
    let mut read: BTreeMap<PathBuf, (Arc<Document>, Scene)> = BTreeMap::new();
    let (mut scenes, mut documents, mut first) = (Vec::new(), Vec::new(), 0);
    for source in file.asset_paths(&args.file) {
        if !read.contains_key(&source) {
            let document = Arc::new(open::asset(&source, &options, progress)?.document);
            let scene = scene_of(&document);
            read.insert(source.clone(), (document, scene));
        }
        let (document, scene) = &read[&source];
        // Each asset hangs below a node of its own.
        documents.push((Arc::clone(document), first + 1));
        first += 1 + scene.nodes.len();
        scenes.push(scene.clone());
    }
    Ok(Loaded { scene: file.assemble(scenes, &args.file).scene, documents, asset: None, camera: None })
}

/// With textures and lights, to be drawn.
fn load_drawn(args: &SimulateArgs, progress: &dyn Progress) -> Result<Loaded, Failure> {
    let opened = open::scene(&args.file, &args.read, progress)?;
    Ok(Loaded { scene: opened.scene, documents: opened.documents, asset: None, camera: opened.camera })
}

fn prepare(args: &SimulateArgs, loaded: &Loaded) -> Result<(Simulator, Vec<Finding>), Failure> {
    let settings = Settings {
        time_step: args.dt,
        gravity: args.gravity,
        iterations: args.iterations as usize,
        continuous: match args.continuous {
            ContinuousArg::Off => Continuous::Off,
            ContinuousArg::Static => Continuous::Static,
            ContinuousArg::All => Continuous::All,
        },
        max_distance: args.max_distance,
        ..Settings::default()
    };
    let mut simulator = Simulator::new(settings, Registration::Automatic).map_err(Failure::new)?;
    let mut findings = Vec::new();
    // A document that stands in several places has its bodies once.
    let mut known: HashMap<*const Document, BTreeMap<usize, Arc<PhysicsMesh>>> = HashMap::new();
    for (document, first) in &loaded.documents {
        let meshes = known.entry(Arc::as_ptr(document)).or_insert_with(|| {
            let (meshes, odd) = physics_meshes(document);
            findings.extend(odd);
            meshes
        });
        let nodes = object_nodes(document);
        for (object, mesh) in meshes {
            simulator.object_created(NodeId((first + nodes[*object].index()) as u32), mesh);
        }
    }
    findings.extend(simulator.prepare(&loaded.scene));
    simulator.start().map_err(Failure::new)?;
    Ok((simulator, findings))
}

fn steps(args: &SimulateArgs) -> u64 {
    let time = f64::from(args.time.unwrap_or(DEFAULT_TIME));
    args.steps.unwrap_or_else(|| (time / f64::from(args.dt)).round().max(1.0) as u64)
}

/// Steps, and gives the poses at each frame if there is a rate, and where it broke.
fn simulate(
    simulator: &mut Simulator,
    steps: u64,
    frames_per_second: Option<f64>,
    progress: &dyn Progress,
) -> Result<(Vec<Poses>, Option<Divergence>), Failure> {
    progress.stage("simulating", steps);
    let mut frames: Vec<Poses> = frames_per_second.iter().map(|_| simulator.poses()).collect();
    let mut before = simulator.poses();
    for step in 0..steps {
        match simulator.step() {
            Ok(()) => {}
            Err(PhysicsError::Diverged(divergence)) => return Ok((frames, Some(divergence))),
            Err(error) => return Err(Failure::new(error)),
        }
        if let Some(rate) = frames_per_second {
            let after = simulator.poses();
            while frames.len() as f64 / rate <= after.time + 1e-9 {
                frames.push(Poses::between(&before, &after, frames.len() as f64 / rate));
            }
            before = after;
        }
        progress.step(step + 1);
    }
    Ok((frames, None))
}

fn write(
    output: &Output,
    args: &SimulateArgs,
    loaded: &Loaded,
    simulator: &Simulator,
    frames: &[Poses],
    terminal: &Terminal,
) -> Result<(), Failure> {
    match (output, &loaded.asset) {
        (Output::Json(path), _) => Ok(aam::write_bytes(path, json(args, loaded, simulator, frames).as_bytes())?),
        (Output::Csv(path), _) => Ok(aam::write_bytes(path, csv(loaded, simulator, frames).as_bytes())?),
        (Output::Animation(path), Some(asset)) => {
            let nodes = object_nodes(&asset.document);
            let film = simulator.film(&asset.document, &nodes, &loaded.scene, frames, args.read.fps);
            for sentence in &film.left_out {
                terminal.note(sentence);
            }
            let asset = Asset { document: film.document, ..asset.clone() };
            let report = aam_convert::export(&asset, path, &ExportOptions::default())?;
            for change in report.changes.iter().filter(|change| change.outcome == aam_convert::Outcome::Lost) {
                terminal.warning(super::convert::sentence(change));
            }
            Ok(())
        }
        (Output::Animation(_), None) => Ok(()),
        (Output::Pictures(path), _) => pictures(path, args, loaded, simulator, frames, terminal),
    }
}

/// A picture of each frame, from the file's camera or from where everything is seen at first.
fn pictures(
    path: &Path,
    args: &SimulateArgs,
    loaded: &Loaded,
    simulator: &Simulator,
    frames: &[Poses],
    terminal: &Terminal,
) -> Result<(), Failure> {
    let destination = Destination::new(path, u32::try_from(frames.len()).ok())?;
    let (width, height) = (args.size.width, args.size.height);
    let fitting = || loaded.scene.fitting_camera(width as f32 / height as f32);
    let camera = loaded.camera.clone().unwrap_or_else(fitting);
    let mut renderer = match Gpu::headless() {
        Ok(gpu) => Some(Renderer::new(gpu)),
        Err(error) => {
            terminal.note(format_args!("drawn on the CPU by the reference engine, for {error}"));
            None
        }
    };
    let progress = Bar::new(terminal);
    progress.stage("drawing", frames.len() as u64);
    for (number, frame) in frames.iter().enumerate() {
        progress.step(number as u64);
        let scene = loaded.scene.posed(&simulator.transforms_at(&loaded.scene, frame));
        let view = View { camera: camera.clone(), width, height, frame: 0.0 };
        let image = match &mut renderer {
            Some(renderer) => {
                renderer.render_to_image(&scene, &view, &RenderOptions::default()).map_err(Failure::new)?.0
            }
            None => aam_reference::render(&scene, &view, &aam_reference::Options::default()).map_err(Failure::new)?.0,
        };
        picture::write(&destination, number, &picture::encode(&image)?)?;
    }
    Ok(())
}

fn node_name(loaded: &Loaded, node: NodeId) -> &str {
    loaded.scene.nodes.get(node.index()).map_or("", |node| &node.name)
}

fn json(args: &SimulateArgs, loaded: &Loaded, simulator: &Simulator, frames: &[Poses]) -> String {
    let bodies: Vec<_> = simulator
        .bodies()
        .filter_map(|node| Some((node, simulator.state(node).ok()?)))
        .map(|(node, state)| {
            json!({
                "node": node.index(),
                "name": node_name(loaded, node),
                "mode": state.mode.word(),
                "mass": state.mass,
                "sleeping": state.sleeping,
            })
        })
        .collect();
    let frames: Vec<_> = frames
        .iter()
        .map(|frame| {
            let poses: Vec<_> = frame
                .poses
                .iter()
                .map(|pose| json!({ "position": pose.position.to_array(), "rotation": pose.rotation.to_array() }))
                .collect();
            json!({ "time": frame.time, "poses": poses })
        })
        .collect();
    let report = json!({
        "file": args.file,
        "time_step": args.dt,
        "steps": simulator.steps(),
        "time": simulator.time(),
        "hash": format!("{:016x}", simulator.hash()),
        "stopped": simulator.divergence().map(ToString::to_string),
        "bodies": bodies,
        "frames": frames,
    });
    format!("{report:#}\n")
}

fn csv(loaded: &Loaded, simulator: &Simulator, frames: &[Poses]) -> String {
    let mut text = String::from("time,node,name,x,y,z,qx,qy,qz,qw\n");
    let names: Vec<(NodeId, String)> = simulator
        .bodies()
        .map(|node| {
            let name = node_name(loaded, node);
            let plain = !name.contains(['"', ',', '\n', '\r']);
            (node, if plain { name.to_owned() } else { format!("\"{}\"", name.replace('"', "\"\"")) })
        })
        .collect();
    for frame in frames {
        for ((node, name), pose) in names.iter().zip(&frame.poses) {
            let [x, y, z] = pose.position.to_array();
            let [qx, qy, qz, qw] = pose.rotation.to_array();
            // Writing to a string does not fail.
            let _ = writeln!(text, "{:.6},{},{name},{x},{y},{z},{qx},{qy},{qz},{qw}", frame.time, node.index());
        }
    }
    text
}

fn summary(
    args: &SimulateArgs,
    simulator: &Simulator,
    bodies: &[NodeId],
    elapsed: f64,
    terminal: &Terminal,
) -> Result<(), Failure> {
    let states: Vec<_> = bodies.iter().filter_map(|node| Some((*node, simulator.state(*node).ok()?))).collect();
    let count = |mode: BodyMode| states.iter().filter(|(_, state)| state.mode == mode).count();
    let [still, kinematic, dynamic] = [BodyMode::Static, BodyMode::Kinematic, BodyMode::Dynamic].map(count);
    let asleep = states.iter().filter(|(_, state)| state.mode == BodyMode::Dynamic && state.sleeping).count();
    let speed = if elapsed > 0.0 { simulator.time() / elapsed } else { f64::INFINITY };
    terminal.summary(format_args!(
        "{}: {dynamic} dynamic, {kinematic} kinematic, {still} static; {} of {:.4} s, {:.2} s simulated, {speed:.1} × real time; \
         {asleep} of {dynamic} asleep",
        args.file.display(),
        human::plural(simulator.steps() as usize, "step"),
        args.dt,
        simulator.time(),
    ))?;
    let listed = if terminal.verbose() { usize::MAX } else { LISTED };
    let moving = || states.iter().filter(|(_, state)| state.mode != BodyMode::Static);
    for (node, state) in moving().take(listed) {
        let [x, y, z] = state.pose.position.to_array();
        let how = if state.sleeping { "asleep".to_owned() } else { format!("{:.3} m/s", state.velocity.length()) };
        let name = simulator.name(*node).unwrap_or_default();
        terminal.summary(format_args!("  {name:<24} {x:>10.4} {y:>10.4} {z:>10.4}   {how}"))?;
    }
    let more = moving().count().saturating_sub(listed);
    if more > 0 {
        terminal.summary(format_args!("  and {more} more (-v lists all)"))?;
    }
    Ok(())
}
