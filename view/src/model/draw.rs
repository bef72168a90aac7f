//! The picture of the model.

use std::path::Path;

use aam_renderer::{Overlays, RenderOptions, Renderer, Target};
use aam_scene::{Shadows, View};

use super::{Model, file_name};
use crate::{pose, screenshot};

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
                let key = (self.generation, self.frame());
                if self.outlines.as_ref().is_none_or(|(generation, frame, _)| (*generation, *frame) != key) {
                    self.outlines = Some((key.0, key.1, pose::outline_shape(&opened.outlines, &world)));
                }
                shapes.extend(self.outlines.as_ref().and_then(|(_, _, shape)| shape.clone()));
            }
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

    /// Draws the picture.
    pub(crate) fn draw(&mut self, renderer: &mut Renderer, target: &Target<'_>, width: u32, height: u32) {
        self.stale = self.settling > 0;
        self.settling = self.settling.saturating_sub(1);
        let options = self.options();
        let view = self.view(width, height);
        self.update_shadow_notes();
        let hidden = self.hide_shadows();
        let Some(opened) = &mut self.opened else { return };
        let drawn = renderer.render(&opened.scene, &view, &options, target);
        if hidden.is_some() {
            opened.scene.shadows = hidden;
        }
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
        let Some(opened) = &mut self.opened else { return };
        let name = self.path.as_deref().map_or_else(|| "view".into(), file_name);
        let stem = name.split('.').next().filter(|stem| !stem.is_empty()).unwrap_or("view");
        let saved = renderer
            .render_to_image(&opened.scene, &view, &options)
            .map_err(|error| error.to_string())
            .and_then(|(picture, _)| screenshot::save(Path::new("."), stem, &picture));
        if hidden.is_some() {
            opened.scene.shadows = hidden;
        }
        match saved {
            Ok(path) => self.say(format!("Picture saved as {}", file_name(&path))),
            Err(reason) => self.complain(format!("no picture: {reason}")),
        }
    }
}
