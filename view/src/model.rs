//! What the window shows and what the user changed in it.

mod draw;
mod shadows;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use aam_renderer::{FrameStats, Msaa, ShadowLimit, Shape, Show};
use aam_scene::{Aabb, Background, DisplacementMode, Layer, Light, NodeId, Scene};
use glam::Affine3A;

use crate::demo::{Demo, DemoAction};
use crate::eye::{Eye, Side};
use crate::load::Loader;
use crate::playback::Playback;
use crate::simulation::Simulation;
use crate::watch::Watch;
use crate::{Opened, Options, Saver, pose};

pub(crate) use shadows::Step;

/// How long a message stays.
const NOTICE: Duration = Duration::from_secs(6);

/// What a key, button or menu asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    Fit,
    LookFrom(Side),
    LookThrough(usize),
    Orthographic,
    NextLayer,
    Wireframe,
    Normals,
    Bounds,
    Hulls,
    /// Shadows on or off.
    Shadows,
    /// The view of the next shadow source.
    LightView,
    Demo(DemoAction),
    Explode,
    Contacts,
    Sleeping,
    Simulate,
    SimulateStep,
    SimulateReset,
    PlayPause,
    Step(isize),
    Save,
    Screenshot,
    Reload,
    Panels,
    Help,
    Quit,
}

/// What outlines were made for: the file, its frame, the simulation's poses, and how far parts stand apart.
type OutlineKey = (u64, usize, u64, u32);

/// What is drawn beside the scene itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Display {
    pub(crate) show: Show,
    pub(crate) wireframe: bool,
    pub(crate) normals: bool,
    pub(crate) bounds: bool,
    pub(crate) hulls: bool,
    pub(crate) displacement: DisplacementMode,
    pub(crate) no_shadows: bool,
    /// How far the parts of collision shapes stand apart, from 0; above, they are drawn in place of the objects.
    pub(crate) explode: f32,
    pub(crate) contacts: bool,
    pub(crate) sleeping: bool,
}

/// What is kept over a reload because the user changed it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Edited {
    lights: bool,
    shadows: bool,
    background: bool,
    shading: bool,
    environment: bool,
    display: bool,
    visibility: bool,
}

/// A message at the bottom.
pub(crate) struct Notice {
    pub(crate) text: String,
    pub(crate) bad: bool,
    until: Instant,
}

/// All that the window shows.
pub(crate) struct Model {
    loader: Loader,
    saver: Saver,
    msaa: Msaa,
    pub(crate) formats: String,
    wake_changed: Arc<dyn Fn() + Send + Sync>,
    watch: Option<Watch>,
    /// The file that is shown, or that could not be.
    pub(crate) path: Option<PathBuf>,
    /// The last that could be read.
    pub(crate) opened: Option<Opened>,
    /// The scene of `opened` before the user changed it.
    original: Scene,
    /// Counts what was opened, for caches.
    pub(crate) generation: u64,
    /// Why the file on disk is not what is shown.
    pub(crate) problem: Option<String>,
    notice: Option<Notice>,
    pub(crate) eye: Eye,
    pub(crate) display: Display,
    pub(crate) playback: Playback,
    pub(crate) demo: Option<Demo>,
    /// The shadow source that the picture is seen from.
    pub(crate) light_view: Option<usize>,
    /// Where the setting of each shadow source does not hold.
    pub(crate) shadow_notes: Vec<Vec<ShadowLimit>>,
    /// When they were found out.
    noted: Option<Instant>,
    pub(crate) simulation: Simulation,
    pub(crate) selected: Option<NodeId>,
    edited: Edited,
    pub(crate) unsaved: bool,
    asked_to_quit: Option<Instant>,
    /// The picture is not what it should be.
    pub(crate) stale: bool,
    pub(crate) stats: FrameStats,
    /// Width over height of the picture.
    pub(crate) aspect: f32,
    outlines: Option<(OutlineKey, Vec<Arc<Shape>>)>,
    /// Frames still to be drawn until timings of the GPU are there: they come late.
    settling: u8,
}

impl Model {
    pub(crate) fn new(
        options: &Options,
        wake: Arc<dyn Fn() + Send + Sync>,
        wake_changed: Arc<dyn Fn() + Send + Sync>,
    ) -> Self {
        let scene = Scene::default();
        let mut model = Self {
            loader: Loader::new(Arc::clone(&options.opener), wake),
            saver: Arc::clone(&options.saver),
            msaa: options.msaa,
            formats: options.formats.clone(),
            wake_changed,
            watch: None,
            path: None,
            opened: None,
            original: Scene::default(),
            generation: 0,
            problem: None,
            notice: None,
            eye: Eye::new(scene.up, Aabb::EMPTY, 1.5),
            display: Display::default(),
            playback: Playback::default(),
            demo: Demo::new(&options.files),
            light_view: None,
            shadow_notes: Vec::new(),
            noted: None,
            simulation: Simulation::default(),
            selected: None,
            edited: Edited::default(),
            unsaved: false,
            asked_to_quit: None,
            stale: true,
            stats: FrameStats::default(),
            aspect: 1.5,
            outlines: None,
            settling: 0,
        };
        if let Some(file) = options.files.first() {
            model.open(file);
        }
        model
    }

    /// Starts to open another file.
    pub(crate) fn open(&mut self, path: &Path) {
        self.loader.start(path, false);
    }

    /// Starts to read the file again.
    pub(crate) fn reload(&mut self) {
        if let Some(path) = self.path.clone() {
            self.loader.start(&path, true);
        }
    }

    /// The file being opened, and the step.
    pub(crate) fn loading(&self) -> Option<(&Path, String)> {
        self.loader.stage()
    }

    /// Takes over what was opened meanwhile.
    pub(crate) fn take_finished(&mut self) {
        let Some(finished) = self.loader.finished() else { return };
        let follow_anyway = finished.result.is_err();
        match finished.result {
            Ok(mut opened) => {
                self.problem = None;
                self.simulation.reset();
                self.original = opened.scene.clone();
                if finished.reload {
                    self.carry_over(&mut opened);
                } else {
                    self.edited = Edited::default();
                    self.unsaved = false;
                    self.selected = None;
                    self.light_view = None;
                    self.playback = Playback { playing: opened.scene.animation.is_some(), frame: 0.0 };
                }
                let bounds = opened.scene.bounds();
                if finished.reload && self.opened.is_some() {
                    self.eye.set_bounds(opened.scene.up, bounds);
                    self.say("Read again, as the file changed.");
                } else {
                    self.eye = Eye::new(opened.scene.up, bounds, self.aspect);
                    if let Some(camera) = &opened.camera {
                        self.eye.look_through(camera);
                    }
                }
                self.follow(&finished.path, &opened);
                if let Some(demo) = &mut self.demo {
                    demo.adopt(&opened.scene);
                    demo.pose(&mut opened.scene);
                }
                self.opened = Some(opened);
                self.generation += 1;
                self.noted = None;
                self.settling = 3;
                self.stale = true;
            }
            Err(reason) => self.problem = Some(reason),
        }
        let changed_file = self.path.as_ref() != Some(&finished.path);
        self.path = Some(finished.path);
        if follow_anyway && (changed_file || self.watch.is_none()) {
            // So that mending the file shows it.
            if let Some(path) = self.path.clone() {
                self.follow(&path, &Opened::default());
            }
        }
    }

    /// Lights, shadows, background and visibility that the user set outlive a reload.
    fn carry_over(&mut self, opened: &mut Opened) {
        let Some(before) = &self.opened else { return };
        if self.edited.lights {
            opened.scene.lights.clone_from(&before.scene.lights);
        }
        if self.edited.shadows {
            opened.scene.shadows = shadows::carried(&before.scene, &opened.scene);
        }
        if self.edited.background {
            opened.scene.background = before.scene.background.clone();
        }
        if self.edited.shading {
            opened.scene.shading = before.scene.shading;
        }
        if self.edited.display {
            (opened.scene.exposure, opened.scene.tone_map) = (before.scene.exposure, before.scene.tone_map);
        }
        if let (true, Some(new), Some(edited)) =
            (self.edited.environment, &mut opened.scene.environment, &before.scene.environment)
        {
            // The picture may be another one.
            *new = aam_scene::Environment { map: Arc::clone(&new.map), ..edited.clone() };
        }
        let same_name = |scene: &Scene, name: &str| scene.nodes.iter().position(|node| node.name == name);
        if self.edited.visibility {
            for node in before.scene.nodes.iter().filter(|node| !node.visible) {
                if let Some(index) = same_name(&opened.scene, &node.name) {
                    opened.scene.nodes[index].visible = false;
                }
            }
        }
        self.selected = self
            .selected
            .and_then(|id| before.scene.nodes.get(id.index()))
            .and_then(|node| same_name(&opened.scene, &node.name))
            .map(|index| NodeId(index as u32));
    }

    fn follow(&mut self, path: &Path, opened: &Opened) {
        let mut files = vec![path.to_owned()];
        files.extend(opened.sources.iter().cloned());
        files.extend(opened.scene.textures.iter().filter_map(|texture| texture.path.clone()));
        let wake = Arc::clone(&self.wake_changed);
        match Watch::new(&files, move || wake()) {
            Ok(watch) => self.watch = Some(watch),
            Err(reason) => {
                self.watch = None;
                self.complain(format!("changes of the file will not be seen: {reason}"));
            }
        }
    }

    /// Shows a message for a while.
    pub(crate) fn say(&mut self, text: impl Into<String>) {
        self.notice = Some(Notice { text: text.into(), bad: false, until: Instant::now() + NOTICE });
    }

    /// Shows what went wrong for a while.
    pub(crate) fn complain(&mut self, text: impl Into<String>) {
        self.notice = Some(Notice { text: text.into(), bad: true, until: Instant::now() + NOTICE });
    }

    /// The message, and for how long it stays.
    pub(crate) fn notice(&self) -> Option<(&Notice, Duration)> {
        let notice = self.notice.as_ref()?;
        let left = notice.until.checked_duration_since(Instant::now())?;
        Some((notice, left))
    }

    /// The frame of the animation that is shown.
    pub(crate) fn frame(&self) -> usize {
        let animation = self.opened.as_ref().and_then(|opened| opened.scene.animation.as_ref());
        animation.map_or(0, |animation| self.playback.index(animation))
    }

    /// Node to world at the shown frame.
    pub(crate) fn world(&self) -> Vec<Affine3A> {
        let Some(opened) = &self.opened else { return Vec::new() };
        let simulated = self.simulation.transforms(&opened.scene);
        simulated.unwrap_or_else(|| pose::world_at(&opened.scene, self.frame()))
    }

    /// Does what was asked for, except [`Action::Screenshot`], [`Action::Panels`], [`Action::Help`] and
    /// [`Action::Quit`], which are the window's.
    pub(crate) fn act(&mut self, action: Action) {
        match action {
            Action::Fit => self.fit(),
            Action::LookFrom(side) => {
                self.eye.look_from(side);
                self.look_from_source(None);
            }
            Action::LookThrough(index) => {
                if let Some(camera) = self.opened.as_ref().and_then(|opened| opened.scene.cameras.get(index)) {
                    self.eye.look_through(camera);
                    self.look_from_source(None);
                }
            }
            Action::Orthographic => {
                self.eye.toggle_orthographic();
                self.stale = true;
            }
            Action::NextLayer => {
                self.display.show = self.next_layer();
                self.stale = true;
            }
            Action::Wireframe => self.toggle(|display| &mut display.wireframe),
            Action::Normals => self.toggle(|display| &mut display.normals),
            Action::Bounds => self.toggle(|display| &mut display.bounds),
            Action::Hulls => {
                self.toggle(|display| &mut display.hulls);
                if self.display.hulls && self.opened.as_ref().is_some_and(|opened| opened.outlines.is_empty()) {
                    self.say("This file has no collision shapes.");
                }
            }
            Action::Shadows => self.toggle_shadows(),
            Action::LightView => self.next_light_view(),
            Action::Demo(action) => self.act_demo(action),
            Action::Explode => {
                self.display.explode = if self.display.explode > 0.0 { 0.0 } else { 1.0 };
                self.display.hulls = self.display.explode > 0.0;
                self.stale = true;
            }
            Action::Contacts => self.toggle(|display| &mut display.contacts),
            Action::Sleeping => self.toggle(|display| &mut display.sleeping),
            Action::Simulate => self.simulate(|simulation, opened| simulation.toggle(&opened.bodies, &opened.scene)),
            Action::SimulateStep => self.simulate(|simulation, opened| simulation.step(&opened.bodies, &opened.scene)),
            Action::SimulateReset => {
                self.simulation.reset();
                self.stale = true;
            }
            // Where nothing is animated, the keys of the time line are those of the simulation.
            Action::PlayPause if !self.is_animated() && self.has_bodies() => self.act(Action::Simulate),
            Action::Step(1) if !self.is_animated() && self.has_bodies() => self.act(Action::SimulateStep),
            Action::PlayPause => {
                self.simulation.reset();
                self.stale = true;
                self.playback.playing = !self.playback.playing;
            }
            Action::Step(by) => {
                if let Some(animation) = self.opened.as_ref().and_then(|opened| opened.scene.animation.as_ref()) {
                    self.playback.step(animation, by);
                    self.stale = true;
                }
            }
            Action::Save => self.save(),
            Action::Reload => self.reload(),
            Action::Screenshot | Action::Panels | Action::Help | Action::Quit => {}
        }
    }

    /// The next layer that some material has, or the lit picture after the last.
    fn next_layer(&self) -> Show {
        let materials = self.opened.as_ref().map_or(&[][..], |opened| &opened.scene.materials);
        let first = match self.display.show {
            Show::Layer(shown) => shown as usize + 1,
            _ => 0,
        };
        let used = |layer: &&Layer| materials.iter().any(|material| material.layers[**layer as usize].is_some());
        Layer::ALL.iter().skip(first).find(used).map_or(Show::Lit, |layer| Show::Layer(*layer))
    }

    fn toggle(&mut self, which: impl FnOnce(&mut Display) -> &mut bool) {
        let value = which(&mut self.display);
        *value = !*value;
        self.stale = true;
    }

    /// Shows all of the selected object, or of everything.
    fn fit(&mut self) {
        let Some(opened) = &self.opened else { return };
        let selected = self.selected.map(|id| pose::bounds_below(&opened.scene, &self.world(), id));
        let bounds = selected.filter(|bounds| !bounds.is_empty()).unwrap_or_else(|| opened.scene.bounds());
        self.eye.fit(bounds, self.aspect);
        self.look_from_source(None);
    }

    fn act_demo(&mut self, action: DemoAction) {
        let Some(demo) = &mut self.demo else { return };
        if let Some(next) = demo.act(action).map(Path::to_owned) {
            self.open(&next);
        } else if let Some(opened) = &mut self.opened {
            demo.pose(&mut opened.scene);
            self.stale = true;
        }
    }

    fn simulate(&mut self, act: impl FnOnce(&mut Simulation, &Opened) -> Result<Option<String>, String>) {
        let Some(opened) = &self.opened else { return };
        self.playback = Playback::default();
        match act(&mut self.simulation, opened) {
            Ok(Some(said)) | Err(said) => self.complain(said),
            Ok(None) => {}
        }
        self.stale = true;
    }

    /// Whether the file has a time line.
    pub(crate) fn is_animated(&self) -> bool {
        let animation = self.opened.as_ref().and_then(|opened| opened.scene.animation.as_ref());
        animation.is_some_and(|animation| animation.frame_count > 1)
    }

    /// Whether the file has something to simulate.
    pub(crate) fn has_bodies(&self) -> bool {
        self.opened.as_ref().is_some_and(|opened| !opened.bodies.is_empty())
    }

    /// Lets time pass for the simulation and the animation; true while one of them plays.
    pub(crate) fn advance(&mut self, time: Duration) -> bool {
        if let (Some(demo), Some(opened)) = (&mut self.demo, &mut self.opened)
            && demo.advance(time)
        {
            demo.pose(&mut opened.scene);
            self.stale = true;
            return true;
        }
        let advanced = self.simulation.advance(time, self.display.contacts);
        self.stale |= advanced.moved;
        if let Some(reason) = advanced.stopped {
            self.complain(reason);
        }
        self.advance_animation(time) || advanced.again
    }

    fn advance_animation(&mut self, time: Duration) -> bool {
        let Some(animation) = self.opened.as_ref().and_then(|opened| opened.scene.animation.as_ref()) else {
            return false;
        };
        self.stale |= self.playback.advance(animation, time);
        self.playback.playing && animation.frame_count > 1
    }

    /// The user changed the lights.
    pub(crate) fn set_lights(&mut self, lights: Vec<Light>) {
        if let Some(opened) = &mut self.opened {
            opened.scene.lights = lights;
            self.edited.lights = true;
            self.touched();
        }
    }

    /// The user changed the background.
    pub(crate) fn set_background(&mut self, background: Background) {
        if let Some(opened) = &mut self.opened {
            opened.scene.background = background;
            self.edited.background = true;
            self.touched();
        }
    }

    /// The user changed on which values lighting computes.
    pub(crate) fn set_shading(&mut self, shading: aam_scene::Shading) {
        if let Some(opened) = &mut self.opened {
            opened.scene.shading = shading;
            self.edited.shading = true;
            self.touched();
        }
    }

    /// The user changed the light from all around.
    pub(crate) fn set_environment(&mut self, environment: aam_scene::Environment) {
        if let Some(opened) = &mut self.opened {
            opened.scene.environment = Some(environment);
            self.edited.environment = true;
            self.touched();
        }
    }

    /// The user changed how light is shown.
    pub(crate) fn set_display(&mut self, exposure: f32, tone_map: aam_scene::ToneMap) {
        if let Some(opened) = &mut self.opened {
            (opened.scene.exposure, opened.scene.tone_map) = (exposure, tone_map);
            self.edited.display = true;
            self.touched();
        }
    }

    /// The user showed or hid an object.
    pub(crate) fn visibility_changed(&mut self) {
        self.edited.visibility = true;
        self.touched();
    }

    fn touched(&mut self) {
        self.unsaved = true;
        self.stale = true;
    }

    fn save(&mut self) {
        let (Some(path), Some(opened)) = (&self.path, &self.opened) else { return };
        match (self.saver)(path, &self.original, &opened.scene, &self.eye.camera()) {
            Ok(saved) => {
                if saved == *path {
                    // From now on the file itself says so.
                    self.edited = Edited::default();
                }
                self.unsaved = false;
                self.say(format!("Saved {}", saved.display()));
            }
            Err(reason) => self.complain(reason),
        }
    }

    /// True if the window may close; unsaved changes ask once.
    pub(crate) fn may_quit(&mut self) -> bool {
        let asked = self.asked_to_quit.is_some_and(|when| when.elapsed() < NOTICE);
        if !self.unsaved || asked {
            return true;
        }
        self.asked_to_quit = Some(Instant::now());
        self.complain("Not saved: Ctrl S saves, the same key again closes without saving.");
        false
    }

    /// The window's title.
    pub(crate) fn title(&self) -> String {
        let mark = if self.unsaved { "* " } else { "" };
        match (&self.path, self.loading()) {
            (_, Some((path, _))) => format!("{} ... - aam", file_name(path)),
            (Some(path), None) => format!("{mark}{} - aam", file_name(path)),
            (None, None) => "aam".into(),
        }
    }
}

/// The last part of a path, for people.
pub(crate) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
