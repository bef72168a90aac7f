//! Draws each technique over its grid, and measures.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use aam_scene::{Image, Scene, ShadowSettings, ShadowTechnique};

use super::front::front_of;
use super::subject::Subject;
use super::truth::{Rays, Truth, TruthKind};
use super::{Cost, Flicker, Painter};
use crate::LabError;
use crate::metrics::{PenumbraError, VisibilityError};
use crate::technique::{Limits, Technique};
use crate::techniques::{Effort, ShadowMapping};

/// What is measured, and how long it may take.
#[derive(Clone, Debug)]
pub struct Plan {
    /// How dense the grids are.
    pub effort: Effort,
    /// Only these techniques.
    pub techniques: Vec<ShadowTechnique>,
    /// What the light is taken for.
    pub truths: Vec<TruthKind>,
    /// The time after which nothing new is begun; `None` is without limit.
    pub budget: Option<Duration>,
    /// The most timed frames of each setting.
    pub frames: usize,
    /// How the truth is traced.
    pub rays: Rays,
    /// Whether flicker is measured.
    pub flicker: bool,
}

impl Plan {
    /// The plan of an effort: two minutes, fifteen minutes, or no limit.
    pub fn new(effort: Effort) -> Self {
        let (budget, frames, light_samples, picture_samples) = match effort {
            Effort::Quick => (Some(120), 7, 64, 4),
            Effort::Normal => (Some(900), 15, 256, 16),
            Effort::Full => (None, 31, 1024, 64),
        };
        Self {
            effort,
            techniques: ShadowTechnique::all(),
            truths: TruthKind::ALL.to_vec(),
            budget: budget.map(Duration::from_secs),
            frames,
            rays: Rays { light_samples, picture_samples },
            flicker: true,
        }
    }
}

/// What each technique costs on a light of a scene, and how wrong it is.
#[derive(Clone, Debug)]
pub struct ShadowChart {
    /// The scene.
    pub scene: String,
    /// The light.
    pub light: String,
    /// Width and height of the pictures.
    pub size: [u32; 2],
    /// GPU and driver.
    pub adapter: String,
    /// Timed frames of each setting, at most.
    pub frames: usize,
    /// How the truths were traced.
    pub rays: Rays,
    /// What the runs are compared with.
    pub truths: Vec<Truth>,
    /// The exact shadow of a point against each truth, in their order: no technique that knows no penumbra does better.
    pub exact: Vec<(VisibilityError, PenumbraError)>,
    /// Flicker of the exact shadow of a point.
    pub exact_flicker: Option<Flicker>,
    /// Without any shadow, and then each setting.
    pub runs: Vec<Run>,
    /// What was not measured, and why.
    pub left: Vec<Left>,
    /// How long it took.
    pub elapsed: Duration,
}

/// A setting that was measured.
#[derive(Clone, Debug)]
pub struct Run {
    /// The setting; `None` is without shadow.
    pub settings: Option<ShadowSettings>,
    /// Time on the GPU.
    pub times: Times,
    /// Bytes of the maps.
    pub bytes: u64,
    /// How far it is from each truth, in their order.
    pub judged: Vec<Judged>,
    /// How restless it is; `None` where there was no time to measure it.
    pub flicker: Option<Flicker>,
    /// Where it can be trusted.
    pub limits: Limits,
    /// The picture.
    pub picture: Image,
    /// The visibility in each pixel.
    pub visibility: Vec<f32>,
}

/// Milliseconds on the GPU, medians over frames drawn in turn with those of all other settings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Times {
    /// The whole frame.
    pub gpu_ms: f64,
    /// First and third quartile of the whole frame.
    pub quartiles: [f64; 2],
    /// Drawing maps.
    pub map_ms: f64,
    /// Blurring maps.
    pub blur_ms: f64,
    /// What the picture took longer than without shadow, in the same turn. Noise can make it negative.
    pub lookup_ms: f64,
    /// How many frames.
    pub frames: usize,
}

impl Times {
    /// What the shadow costs: maps, blur and lookup.
    pub fn shadow_ms(&self) -> f64 {
        self.map_ms + self.blur_ms + self.lookup_ms
    }
}

/// How far a run is from a truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// Of the visibility in each pixel.
    pub visibility: VisibilityError,
    /// Of the penumbras' widths.
    pub penumbra: PenumbraError,
    /// Mean and 95th percentile of the picture's FLIP difference; `None` if the truth has no picture.
    pub flip: Option<(f64, f64)>,
}

/// A setting, or a whole technique, that was not measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Left {
    /// Its text.
    pub settings: String,
    /// Why, without a full stop.
    pub reason: String,
}

impl Run {
    /// Its text: the settings, or `none`.
    pub fn label(&self) -> String {
        self.settings.map_or_else(|| "none".into(), |settings| settings.to_string())
    }

    /// The technique's name, or `none`.
    pub fn technique(&self) -> String {
        self.settings.map_or_else(|| "none".into(), |settings| settings.technique.to_string())
    }
}

impl ShadowChart {
    /// The place of a truth in [`ShadowChart::truths`].
    pub fn truth(&self, kind: TruthKind) -> Option<usize> {
        self.truths.iter().position(|truth| truth.kind == kind)
    }
}

/// How much of the time that is left each part may take before it begins nothing new.
const DRAWING: f64 = 0.6;
const TIMING: f64 = 0.6;

/// Draws and measures. `progress` is told what happens and which share of the work is done, 0 to 1.
///
/// # Errors
/// The scene cannot be drawn, or the device cannot tell GPU time. A setting that alone cannot be drawn is left out.
pub fn measure(
    subject: &Subject,
    plan: &Plan,
    painter: &mut dyn Painter,
    progress: &(dyn Fn(&str, f32) + Sync),
) -> Result<ShadowChart, LabError> {
    let start = Instant::now();
    let deadline = Deadline { start, budget: plan.budget };
    let mut truths: Vec<Truth> = Vec::new();
    for (index, kind) in plan.truths.iter().enumerate() {
        let (from, share) = (0.1 * index as f32 / plan.truths.len() as f32, 0.1 / plan.truths.len() as f32);
        let doing = format!("tracing the truth ({kind})");
        progress(&doing, from);
        let told = |fraction: f32| progress(&doing, from + share * fraction);
        truths.push(Truth::trace(subject, *kind, plan.rays, Some(&told))?);
    }
    let width = subject.view.width;
    let point = match truths.iter().find(|truth| truth.kind == TruthKind::Point) {
        Some(truth) => truth.shares(),
        None => Truth::trace(subject, TruthKind::Point, Rays { picture_samples: 0, ..plan.rays }, None)?.shares(),
    };
    let exact = truths.iter().map(|truth| truth.judge(width, &point)).collect::<Result<Vec<_>, _>>()?;

    let (candidates, mut left) = candidates(subject, plan);
    let mut drawn = Drawn::new(subject, &truths);
    drawn.add(None, painter)?;
    let until = deadline.after(DRAWING);
    for (index, settings) in candidates.iter().enumerate() {
        progress(&settings.to_string(), 0.1 + 0.4 * index as f32 / candidates.len() as f32);
        if until.is_over() {
            left.extend(
                candidates[index..]
                    .iter()
                    .map(|settings| Left { settings: settings.to_string(), reason: "there was no time left".into() }),
            );
            break;
        }
        match drawn.add(Some(*settings), painter) {
            Ok(()) => {}
            Err(LeftOut::Refused(reason)) => left.push(Left { settings: settings.to_string(), reason }),
            Err(LeftOut::Failed(error)) => return Err(error),
        }
    }
    let Drawn { mut runs, scenes, costs, .. } = drawn;
    let times = time(&scenes, &costs, subject, plan, painter, &deadline.after(TIMING), progress)?;
    for (run, times) in runs.iter_mut().zip(times) {
        run.times = times;
    }
    let mut exact_flicker = None;
    if plan.flicker {
        let faces: Vec<bool> =
            truths.first().map_or_else(Vec::new, |truth| truth.seen.iter().map(Option::is_some).collect());
        progress("flicker", 0.75);
        exact_flicker = Some(Flicker::of_truth(subject, &point, &faces)?);
        // Those that may be chosen come first, for there may not be time for all.
        let mut order: Vec<usize> = (0..runs.len()).collect();
        let on_front = fronts_of_all(&runs, truths.len());
        order.sort_by_key(|index| !on_front.contains(index));
        let until = deadline.after(1.0);
        for (number, index) in order.into_iter().enumerate() {
            if until.is_over() {
                break;
            }
            progress("flicker", 0.75 + 0.25 * number as f32 / runs.len() as f32);
            let run = &mut runs[index];
            // Without a shadow nothing flickers.
            if run.settings.is_some() {
                run.flicker = Some(Flicker::of(painter, &scenes[index], subject, &run.visibility, &faces)?);
            }
        }
    }
    Ok(ShadowChart {
        scene: subject.name.clone(),
        light: subject.light_name(),
        size: [subject.view.width, subject.view.height],
        adapter: painter.adapter(),
        frames: plan.frames,
        rays: plan.rays,
        truths,
        exact,
        exact_flicker,
        runs,
        left,
        elapsed: start.elapsed(),
    })
}

/// The runs on the front of time and root mean squared error, for any truth.
fn fronts_of_all(runs: &[Run], truths: usize) -> Vec<usize> {
    let mut all = Vec::new();
    for truth in 0..truths {
        all.extend(front_of(runs.iter().map(|run| (run.times.gpu_ms, run.judged[truth].visibility.rmse))));
    }
    all
}

/// A time to stop at.
struct Deadline {
    start: Instant,
    budget: Option<Duration>,
}

impl Deadline {
    /// When a share of the time that is left is over.
    fn after(&self, share: f64) -> Self {
        let left = self.budget.map(|budget| budget.saturating_sub(self.start.elapsed()).mul_f64(share));
        Self { start: Instant::now(), budget: left }
    }

    fn is_over(&self) -> bool {
        self.budget.is_some_and(|budget| self.start.elapsed() >= budget)
    }
}

/// The settings to try, each technique's most usual first, and what is refused before it is drawn.
fn candidates(subject: &Subject, plan: &Plan) -> (Vec<ShadowSettings>, Vec<Left>) {
    let mut left = Vec::new();
    let mut by_rank: BTreeMap<usize, Vec<ShadowSettings>> = BTreeMap::new();
    for technique in &plan.techniques {
        let shadow = ShadowMapping::new(*technique, plan.effort);
        let Some(first) = shadow.variants().into_iter().next() else { continue };
        if let Limits::Refuses(reason) = shadow.limits(&first, &subject.scene, &subject.view) {
            left.push(Left { settings: technique.to_string(), reason });
            continue;
        }
        for (rank, settings) in shadow.settings().into_iter().enumerate() {
            by_rank.entry(rank).or_default().push(settings);
        }
    }
    (by_rank.into_values().flatten().collect(), left)
}

enum LeftOut {
    Refused(String),
    Failed(LabError),
}

impl From<LeftOut> for LabError {
    fn from(out: LeftOut) -> Self {
        match out {
            LeftOut::Failed(error) => error,
            LeftOut::Refused(reason) => Self::Refused(reason),
        }
    }
}

impl From<LabError> for LeftOut {
    fn from(error: LabError) -> Self {
        Self::Failed(error)
    }
}

/// What has been drawn so far.
struct Drawn<'a> {
    subject: &'a Subject,
    truths: &'a [Truth],
    runs: Vec<Run>,
    scenes: Vec<Scene>,
    costs: Vec<Cost>,
}

impl<'a> Drawn<'a> {
    fn new(subject: &'a Subject, truths: &'a [Truth]) -> Self {
        Self { subject, truths, runs: Vec::new(), scenes: Vec::new(), costs: Vec::new() }
    }

    /// Draws a setting and compares it with the truths.
    fn add(&mut self, settings: Option<ShadowSettings>, painter: &mut dyn Painter) -> Result<(), LeftOut> {
        let view = &self.subject.view;
        let scene = match settings {
            Some(settings) => with(&self.subject.scene, settings),
            None => self.subject.unshadowed(),
        };
        let limits = if settings.is_some() { painter.limits(&scene, view) } else { Limits::Holds };
        if let Limits::Refuses(reason) = limits {
            return Err(LeftOut::Refused(reason));
        }
        // The first picture compiles and uploads.
        painter.picture(&scene, view)?;
        let (picture, cost) = painter.picture(&scene, view)?;
        let visibility = match settings {
            Some(_) => painter.visibility(&scene, view)?,
            None => vec![1.0; picture.width as usize * picture.height as usize],
        };
        let judge = |truth: &Truth| -> Result<Judged, LabError> {
            let (error, penumbra) = truth.judge(view.width, &visibility)?;
            Ok(Judged { visibility: error, penumbra, flip: truth.flip(&picture)? })
        };
        let judged = self.truths.iter().map(judge).collect::<Result<Vec<_>, _>>()?;
        self.runs.push(Run {
            settings,
            times: Times::default(),
            bytes: cost.bytes,
            judged,
            flicker: None,
            limits,
            picture,
            visibility,
        });
        self.scenes.push(scene);
        self.costs.push(cost);
        Ok(())
    }
}

fn with(scene: &Scene, settings: ShadowSettings) -> Scene {
    let mut scene = scene.clone();
    for source in scene.shadows.iter_mut().flat_map(|shadows| &mut shadows.sources) {
        source.settings = settings;
    }
    scene
}

/// Times all scenes in turn, so that whatever else the machine does meets all alike. The first has no shadow.
fn time(
    scenes: &[Scene],
    first_costs: &[Cost],
    subject: &Subject,
    plan: &Plan,
    painter: &mut dyn Painter,
    until: &Deadline,
    progress: &(dyn Fn(&str, f32) + Sync),
) -> Result<Vec<Times>, LabError> {
    /// Frames that every setting gets, whatever the time.
    const LEAST: usize = 3;
    let mut costs: Vec<Vec<(Cost, f64)>> = vec![Vec::new(); scenes.len()];
    let rounds = plan.frames.max(LEAST);
    // Slow ones do not take the others' time: each gets as many frames as fit into an equal share.
    let share = until.budget.map_or(f64::INFINITY, |budget| 1e3 * budget.as_secs_f64() / scenes.len().max(1) as f64);
    let wanted: Vec<usize> =
        first_costs.iter().map(|cost| ((share / cost.total_ms().max(1e-3)) as usize).clamp(LEAST, rounds)).collect();
    for round in 0..rounds {
        if round >= LEAST && until.is_over() {
            break;
        }
        let mut plain = 0.0;
        for (index, scene) in scenes.iter().enumerate() {
            let done = (round as f32 + index as f32 / scenes.len() as f32) / rounds as f32;
            progress("timing", 0.5 + 0.25 * done);
            if index > 0 && round >= wanted[index] {
                continue;
            }
            let (_, cost) = painter.picture(scene, &subject.view)?;
            if index == 0 {
                plain = cost.rest_ms;
            }
            costs[index].push((cost, cost.rest_ms - plain));
        }
    }
    Ok(costs.iter().map(|costs| summary(costs)).collect())
}

fn summary(costs: &[(Cost, f64)]) -> Times {
    let quantile = |value: &dyn Fn(&(Cost, f64)) -> f64, share: f64| {
        let mut values: Vec<f64> = costs.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        let last = values.len().saturating_sub(1) as f64;
        values.get((last * share).round() as usize).copied().unwrap_or(0.0)
    };
    let total = |(cost, _): &(Cost, f64)| cost.total_ms();
    Times {
        gpu_ms: quantile(&total, 0.5),
        quartiles: [quantile(&total, 0.25), quantile(&total, 0.75)],
        map_ms: quantile(&|(cost, _)| cost.map_ms, 0.5),
        blur_ms: quantile(&|(cost, _)| cost.blur_ms, 0.5),
        lookup_ms: quantile(&|(_, lookup)| *lookup, 0.5),
        frames: costs.len(),
    }
}
