//! Shadows as the user sets them, and the view from a source.

use std::time::{Duration, Instant};

use aam_renderer::Show;
use aam_scene::{Camera, Members, NodeId, Scene, ShadowSettings, Shadows};

use super::Model;

/// For how long what was found out about shadows holds while the camera moves; it takes a look at all meshes.
const NOTED: Duration = Duration::from_millis(300);

/// A step of shadow mapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    LightView,
    DepthMap,
    Unshadowed,
    Shadowed,
}

impl Step {
    pub(crate) const ALL: [(Self, &'static str, &'static str); 4] = [
        (Self::LightView, "Light view", "What the light sees (L)"),
        (Self::DepthMap, "Depth map", "The shadow map: near is light"),
        (Self::Unshadowed, "Unshadowed", "The picture without shadows"),
        (Self::Shadowed, "Shadowed", "The picture with shadows"),
    ];
}

impl Model {
    /// The scene's shadows.
    pub(crate) fn shadows(&self) -> Option<&Shadows> {
        self.opened.as_ref()?.scene.shadows.as_ref()
    }

    /// The step that the picture shows, if it is one.
    pub(crate) fn step(&self) -> Option<Step> {
        match (self.display.show, self.light_view, self.display.no_shadows) {
            (Show::ShadowMap(_), _, _) => Some(Step::DepthMap),
            (Show::Lit, Some(_), _) => Some(Step::LightView),
            (Show::Lit, None, true) => Some(Step::Unshadowed),
            (Show::Lit, None, false) => Some(Step::Shadowed),
            _ => None,
        }
    }

    /// Shows a step.
    pub(crate) fn show_step(&mut self, step: Step) {
        self.display.show = if step == Step::DepthMap { Show::ShadowMap(0) } else { Show::Lit };
        self.display.no_shadows = step == Step::Unshadowed;
        self.look_from_source((step == Step::LightView).then_some(0));
    }

    /// The user changed the shadows.
    pub(crate) fn set_shadows(&mut self, shadows: Option<Shadows>) {
        if let Some(opened) = &mut self.opened {
            opened.scene.shadows = shadows;
            self.noted = None;
            self.edited.shadows = true;
            self.light_view = self.light_view.filter(|source| *source < self.source_count());
            self.touched();
        }
    }

    /// The user removed a light: its shadows go with it.
    pub(crate) fn light_removed(&mut self, removed: usize) {
        let Some(shadows) = self.opened.as_ref().and_then(|opened| opened.scene.shadows.clone()) else { return };
        let mut left = shadows;
        left.sources.retain(|source| source.light != Some(removed));
        for source in &mut left.sources {
            source.light = source.light.map(|light| if light > removed { light - 1 } else { light });
        }
        self.set_shadows(Some(left));
    }

    pub(crate) fn source_count(&self) -> usize {
        self.shadows().map_or(0, |shadows| shadows.sources.len())
    }

    /// Shows the picture with or without shadows, which is not saved. A scene without any gets those of its lights.
    pub(super) fn toggle_shadows(&mut self) {
        let Some(opened) = &self.opened else { return };
        if self.source_count() > 0 {
            self.toggle(|display| &mut display.no_shadows);
        } else if opened.scene.lights.is_empty() {
            self.say("The only light is at the camera, which sees no shadows: add a light.");
        } else {
            let shadows = Shadows::of_lights(&opened.scene, ShadowSettings::default());
            self.display.no_shadows = false;
            self.set_shadows(Some(shadows));
        }
    }

    /// Looks from a source, or from the eye again.
    pub(crate) fn look_from_source(&mut self, source: Option<usize>) {
        self.light_view = source;
        self.stale = true;
        if let Some(Err(reason)) = source.map(|source| self.source_camera(source)) {
            self.light_view = None;
            self.complain(format!("no view from this source: {reason}"));
        }
    }

    /// From the eye to the first source, from there to the next, and back after the last.
    pub(super) fn next_light_view(&mut self) {
        let count = self.source_count();
        if count == 0 {
            self.say("There is no shadow source to look from.");
            return;
        }
        let next = self.light_view.map_or(0, |source| source + 1);
        self.look_from_source((next < count).then_some(next));
    }

    /// The camera of the picture: the eye's, or that of the source whose view is shown.
    pub(crate) fn camera(&self) -> Camera {
        let from_source = self.light_view.and_then(|source| self.source_camera(source).ok());
        from_source.unwrap_or_else(|| self.eye.camera())
    }

    /// What a source sees through its square window.
    pub(crate) fn source_camera(&self, source: usize) -> Result<Camera, String> {
        let Some(opened) = &self.opened else { return Err("nothing is open".into()) };
        aam_renderer::shadow_camera(&opened.scene, &self.eye_view(), source)
    }

    /// What is to be known about each source as it is set: where it fails, and why.
    pub(super) fn update_shadow_notes(&mut self) {
        let Some(opened) = &self.opened else { return };
        if self.noted.is_some_and(|noted| noted.elapsed() < NOTED) {
            return;
        }
        let view = self.eye_view();
        let limits = |source| aam_renderer::shadow_limits(&opened.scene, &view, source);
        let notes = (0..self.source_count()).map(limits).collect();
        self.shadow_notes = notes;
        self.noted = Some(Instant::now());
    }
}

/// The shadows of the scene before in the scene read again: what is gone takes no part.
pub(super) fn carried(before: &Scene, after: &Scene) -> Option<Shadows> {
    let mut shadows = before.shadows.clone()?;
    let member = |id: &NodeId| {
        let name = &before.nodes.get(id.index())?.name;
        after.nodes.iter().position(|node| node.name == *name).map(|index| NodeId(index as u32))
    };
    for members in [&mut shadows.casters, &mut shadows.receivers] {
        if let Members::Only(ids) = members {
            *ids = ids.iter().filter_map(member).collect();
        }
    }
    shadows.sources.retain(|source| source.light.is_none_or(|light| light < after.lights.len()));
    Some(shadows)
}
