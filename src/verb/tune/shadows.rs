//! `aam tune shadows`: the cheapest technique that is accurate enough for a scene.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use aam_convert::Progress;
use aam_lab::shadows::{Choice, Goal, Needs, ShadowChart, Subject, TruthKind, choose};
use aam_scene::{
    BackgroundEntry, Members, NodeId, Scene, SceneFile, ShadowSettings, ShadowSource, Shadows, ShadowsEntry, View,
};

use crate::cli::{LightSize, TuneShadowsArgs};
use crate::failure::Failure;
use crate::human;
use crate::open::{self, OpenedScene};
use crate::progress::Bar;
use crate::terminal::{BOLD, Terminal};
use crate::verb::chart;

/// Width of the pictures in which shadows are looked for.
const LOOK: u32 = 256;

pub(super) fn run(args: &TuneShadowsArgs, terminal: &Terminal) -> Result<ExitCode, Failure> {
    let target = target(args)?;
    let progress = Bar::new(terminal);
    let opened = open::scene(&args.file, &args.read, &progress)?;
    let goal = goal(args);
    let truth = match args.truth {
        LightSize::Point => TruthKind::Point,
        LightSize::Area => TruthKind::Area,
    };
    let view = chart::view(&args.measure, &opened.scene, opened.camera.as_ref())?;
    // Refused before anything is measured.
    let first = subject(args, &opened.scene, &view, args.measure.light.as_deref())?;
    progress.stage("looking through the cameras", 0);
    let needs = Needs::of(&opened.scene, &views(args, &opened.scene, &view)).map_err(Failure::new)?;
    let mut renderer = chart::renderer()?;
    let lights: Vec<usize> = match &args.measure.light {
        Some(_) => vec![first.light],
        None => (0..opened.scene.lights.len())
            .filter(|&light| subject(args, &opened.scene, &view, Some(&(light + 1).to_string())).is_ok())
            .collect(),
    };
    let (mut sources, mut sentences, mut reached) = (Vec::new(), Vec::new(), true);
    for light in lights {
        let subject = subject(args, &opened.scene, &view, Some(&(light + 1).to_string()))?;
        let name = subject.light_name();
        let seen = &needs.lights[light];
        if seen.darkened == 0 {
            sentences.push(format!(
                "{name}: no shadow. Of {} that face it in {}, not one is darkened",
                human::plural(seen.faces, "pixel"),
                human::plural(needs.views, "view")
            ));
            continue;
        }
        let mut plan = chart::plan(&args.measure);
        (plan.truths, plan.flicker, plan.rays.picture_samples) = (vec![truth], false, 0);
        let measured = chart::measured_by(&plan, &subject, &mut renderer, &progress)?;
        let Some(choice) = choose(&measured, truth, goal) else { continue };
        reached &= choice.reached;
        sentences.extend(told(&name, &measured, &choice));
        if let Some(settings) = measured.runs[choice.run].settings {
            let old = opened.scene.shadows.iter().flat_map(|shadows| &shadows.sources);
            let old = old.into_iter().find(|source| source.light == Some(light)).cloned();
            sources.push(source(light, &name, settings, old));
        } else {
            sentences.push(format!("{name}: no shadow is the cheapest that is within the goal"));
        }
    }
    let casters = casters(&opened.scene, &needs);
    drop(progress);
    for sentence in &sentences {
        terminal.summary(sentence)?;
    }
    let all = opened.scene.nodes.iter().filter(|node| node.mesh.is_some()).count();
    if let Members::Only(ids) = &casters {
        terminal.summary(format_args!(
            "casters: {} of {}; the others cast nothing into {}",
            ids.len(),
            human::plural(all, "object"),
            human::plural(needs.views, "view")
        ))?;
    }
    match &target {
        None => terminal.summary("nothing was written (--dry-run)")?,
        Some(target) => {
            write(args, &opened, target, sources, casters)?;
            terminal.summary(format_args!("{BOLD}{}{BOLD:#} has the shadows", target.display()))?;
        }
    }
    Ok(if reached { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

fn goal(args: &TuneShadowsArgs) -> Goal {
    match (args.max_error, args.budget_ms) {
        (Some(most), _) => Goal::MaxError(most.into()),
        (None, most) => Goal::Budget(most.unwrap_or_default().into()),
    }
}

fn subject(args: &TuneShadowsArgs, scene: &Scene, view: &View, light: Option<&str>) -> Result<Subject, Failure> {
    Subject::new(chart::scene_name(&args.file), scene, view.clone(), light)
        .map_err(|error| Failure::new(format_args!("{}: {error}", args.file.display())))
}

/// Small pictures through every camera of the scene, and the one that is measured with.
fn views(args: &TuneShadowsArgs, scene: &Scene, view: &View) -> Vec<View> {
    let size = args.measure.size;
    let height =
        (u64::from(LOOK) * u64::from(size.height) / u64::from(size.width)).clamp(1, 4 * u64::from(LOOK)) as u32;
    let mut cameras = vec![view.camera.clone()];
    cameras.extend(scene.cameras.iter().filter(|camera| **camera != view.camera).cloned());
    cameras.into_iter().map(|camera| View { camera, width: LOOK, height, frame: view.frame }).collect()
}

/// Everything, or those that cast into view. Moving objects stay: they may come into the way later.
fn casters(scene: &Scene, needs: &Needs) -> Members {
    if scene.animation.is_some() {
        return scene.shadows.as_ref().map_or(Members::All, |shadows| shadows.casters.clone());
    }
    let ids = needs.casters();
    let drawn: Vec<NodeId> =
        (0..).map(NodeId).zip(&scene.nodes).filter(|(_, node)| node.mesh.is_some()).map(|(id, _)| id).collect();
    if ids.is_empty() || ids == drawn { Members::All } else { Members::Only(ids) }
}

/// The source with the chosen settings, else as it was.
fn source(light: usize, name: &str, settings: ShadowSettings, old: Option<ShadowSource>) -> ShadowSource {
    let fresh = || ShadowSource { name: name.to_owned(), ..ShadowSource::of_light(light, settings) };
    let old = old.unwrap_or_else(fresh);
    let settings = ShadowSettings { intensity: old.settings.intensity, ..settings };
    ShadowSource { enabled: true, settings, ..old }
}

fn told(name: &str, chart: &ShadowChart, choice: &Choice) -> Vec<String> {
    let measured = human::plural(chart.runs.len().saturating_sub(1), "setting");
    let mut sentences = vec![format!("{name}: of {measured} on {}", chart.adapter)];
    sentences.extend(choice.because.iter().map(|sentence| format!("  {sentence}")));
    let late = chart.left.iter().filter(|left| left.reason.contains("no time")).count();
    if late > 0 {
        sentences.push(format!("  {} not measured for want of time", human::plural(late, "setting")));
    }
    sentences
}

/// Where the choice goes; `None` for nowhere.
fn target(args: &TuneShadowsArgs) -> Result<Option<PathBuf>, Failure> {
    if args.dry_run {
        return Ok(None);
    }
    let target = match &args.output {
        Some(output) if !SceneFile::is_one(output) => {
            return Err(Failure::new(format_args!("{}: shadows are written to scene files only", output.display()))
                .help("name one that ends in .scene.toml"));
        }
        Some(output) => output.clone(),
        None if SceneFile::is_one(&args.file) => args.file.clone(),
        None => SceneFile::path_beside(&args.file),
    };
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        return Err(Failure::new(format_args!("{}: the folder {} does not exist", target.display(), folder.display()))
            .help(format_args!("mkdir -p {}", folder.display())));
    }
    if !SceneFile::is_one(&args.file) && args.output.is_none() && target.exists() {
        return Err(Failure::new(format_args!("{} is there already", target.display()))
            .help("tune that file, or name another with --output"));
    }
    Ok(Some(target))
}

/// Writes the file with other shadows and the rest as it was; paths stay right where the new file lies elsewhere.
fn write(
    args: &TuneShadowsArgs,
    opened: &OpenedScene,
    target: &Path,
    sources: Vec<ShadowSource>,
    casters: Members,
) -> Result<(), Failure> {
    let tuned: Vec<usize> = match &args.measure.light {
        Some(_) => sources.iter().filter_map(|source| source.light).collect(),
        None => (0..opened.scene.lights.len()).collect(),
    };
    let old = opened.scene.shadows.clone().unwrap_or_default();
    let kept = old.sources.iter().filter(|source| source.light.is_none_or(|light| !tuned.contains(&light)));
    let sources = kept.cloned().chain(sources).collect();
    // With one light alone, others may need more.
    let casters = if args.measure.light.is_some() { old.casters.clone() } else { casters };
    let shadows = Shadows { sources, casters, ..old };
    if SceneFile::is_one(&args.file) {
        let mut file = SceneFile::read(&args.file)?;
        if target.parent() != args.file.parent() {
            let absolute = |path: PathBuf| std::path::absolute(&path).unwrap_or(path);
            let paths = file.asset_paths(&args.file);
            for (entry, path) in file.assets.iter_mut().zip(paths) {
                entry.path = absolute(path);
            }
            if let Some(BackgroundEntry::Picture(path)) = &mut file.background {
                *path = absolute(args.file.parent().unwrap_or(Path::new("")).join(&path));
            }
        }
        file.shadows = ShadowsEntry::of(&Scene { shadows: Some(shadows), ..opened.scene.clone() });
        return Ok(file.write(target)?);
    }
    // As the scene file sees an asset: below a node of its own.
    let mut file = SceneFile::of_asset(target, &args.file);
    let mut scene = file.assemble(vec![opened.scene.clone()], target).scene;
    let below = |members: Members| match members {
        Members::All => Members::All,
        Members::Only(ids) => Members::Only(ids.into_iter().map(|id| NodeId(id.0 + 1)).collect()),
    };
    scene.shadows = Some(Shadows { casters: below(shadows.casters), receivers: below(shadows.receivers), ..shadows });
    file.shadows = ShadowsEntry::of(&scene);
    Ok(file.write(target)?)
}
