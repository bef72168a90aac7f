//! The picture of the model.

use std::path::Path;

use std::borrow::Cow;

use aam_renderer::{Overlays, RenderOptions, Renderer, Target};
use aam_scene::{Scene, Shadows, View};

use super::{Model, file_name};
use crate::{marks, pose, screenshot};

impl Model {
    fn options(&mut self) -> RenderOptions {
        let mut shapes = Vec::new();
        let world = self.world();
        if let (Some(opened), Some(id)) = (&self.opened, self.selected) {
            shapes.extend(pose::selection_shape(&pose::bounds_below(&opened.scene, &world, id)));
        }
        let mut normals = None;
        if let Some(opened) = &self.opened {
            if self.display.hulls {
                let explode = self.display.explode;
                let key = (self.generation, self.frame(), self.simulation.revision, explode.to_bits());
                if self.outlines.as_ref().is_none_or(|(made, _)| *made != key) {
                    self.outlines = Some((key, marks::outlines(&opened.outlines, &world, explode)));
                }
                shapes.extend(self.outlines.iter().flat_map(|(_, shapes)| shapes.iter().cloned()));
            }
            let size = opened.scene.bounds().diagonal();
            if self.display.contacts {
                shapes.extend(marks::contacts(self.simulation.contacts(), size));
            }
            if self.display.sleeping {
                shapes.extend(marks::sleeping(&opened.scene, &world, self.simulation.dynamic()));
            }
            shapes.extend(self.simulation.grabbed().and_then(|ends| marks::hand(ends, size)));
            if self.display.normals {
                normals = Some(0.02 * opened.scene.bounds().diagonal());
            }
        }
        RenderOptions {
            msaa: self.msaa,
            displacement: self.display.displacement,
            show: self.display.show,
            overlays: Overlays { wireframe: self.display.wireframe, normals, bounds: self.display.bounds, shapes },
            ..RenderOptions::default()
        }
    }

    /// The scene as it is drawn: bodies where they are simulated, and without objects whose parts stand apart.
    fn shown(&self) -> Option<Cow<'_, Scene>> {
        let opened = self.opened.as_ref()?;
        let mut scene = match self.simulation.transforms(&opened.scene) {
            Some(world) => Cow::Owned(opened.scene.posed(&world)),
            None => Cow::Borrowed(&opened.scene),
        };
        if self.display.hulls && self.display.explode > 0.0 {
            let scene = scene.to_mut();
            for outline in &opened.outlines {
                if let Some(node) = scene.nodes.get_mut(outline.node.index()) {
                    node.mesh = None;
                }
            }
        }
        Some(scene)
    }

    fn view(&self, width: u32, height: u32) -> View {
        View { camera: self.camera(), width, height, frame: self.frame() as f32 }
    }

    /// The eye's view, of which only the shape of the picture matters.
    pub(super) fn eye_view(&self) -> View {
        let height = 1000;
        let width = (self.aspect * height as f32) as u32;
        View { camera: self.eye.camera(), width, height, frame: self.frame() as f32 }
    }

    /// Takes the shadows out of the scene while it is drawn without.
    fn hide_shadows(&mut self) -> Option<Shadows> {
        if !self.display.no_shadows {
            return None;
        }
        self.opened.as_mut().and_then(|opened| opened.scene.shadows.take())
    }

    fn restore_shadows(&mut self, hidden: Option<Shadows>) {
        if let (Some(opened), Some(hidden)) = (&mut self.opened, hidden) {
            opened.scene.shadows = Some(hidden);
        }
    }

    /// Draws the picture.
    pub(crate) fn draw(&mut self, renderer: &mut Renderer, target: &Target<'_>, width: u32, height: u32) {
        self.stale = self.settling > 0;
        self.settling = self.settling.saturating_sub(1);
        let options = self.options();
        let view = self.view(width, height);
        self.update_shadow_notes();
        let hidden = self.hide_shadows();
        let drawn = self.shown().map(|scene| renderer.render(&scene, &view, &options, target));
        self.restore_shadows(hidden);
        let Some(drawn) = drawn else { return };
        match drawn {
            Ok(stats) => {
                if let Some(warning) = stats.warnings.first() {
                    let warning = warning.clone();
                    self.complain(warning);
                }
                self.stats = stats;
            }
            Err(error) => self.problem = Some(error.to_string()),
        }
    }

    /// Writes a picture of the view to the current folder.
    pub(crate) fn screenshot(&mut self, renderer: &mut Renderer, width: u32, height: u32) {
        let options = self.options();
        let view = self.view(width, height);
        let hidden = self.hide_shadows();
        let drawn = self.shown().map(|scene| renderer.render_to_image(&scene, &view, &options));
        self.restore_shadows(hidden);
        let Some(drawn) = drawn else { return };
        let name = self.path.as_deref().map_or_else(|| "view".into(), file_name);
        let stem = name.split('.').next().filter(|stem| !stem.is_empty()).unwrap_or("view");
        let saved = drawn
            .map_err(|error| error.to_string())
            .and_then(|(picture, _)| screenshot::save(Path::new("."), stem, &picture));
        match saved {
            Ok(path) => self.say(format!("Picture saved as {}", file_name(&path))),
            Err(reason) => self.complain(format!("no picture: {reason}")),
        }
    }
}
