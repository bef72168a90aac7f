//! The bar of the shadow-mapping demo: its scene, the steps of the method, the map's resolution, the motion.

use super::theme;
use crate::model::{Model, Step};

/// Sides of the map to choose from; the demo compares the first three.
const RESOLUTIONS: [u32; 5] = [128, 256, 512, 1024, 2048];

pub(super) fn show(ui: &mut egui::Ui, model: &mut Model) {
    let Some(demo) = &model.demo else { return };
    let (scene, scenes) = demo.place();
    let motion = if demo.paused {
        "paused (U resumes)".to_owned()
    } else {
        format!("{}° a second (arrows, P pauses, R resets)", demo.speed)
    };
    ui.horizontal(|ui| {
        ui.strong(format!("Scene {scene} of {scenes}"));
        ui.label(theme::weak("Space for the next"));
        ui.separator();
        let shown = model.step();
        for (number, (step, name, hint)) in Step::ALL.into_iter().enumerate() {
            let chosen = ui.selectable_label(shown == Some(step), format!("{} {name}", number + 1));
            if chosen.on_hover_text(hint).clicked() {
                model.show_step(step);
            }
        }
        ui.separator();
        ui.label("Map");
        for side in RESOLUTIONS {
            let sources = model.shadows().map_or(&[][..], |shadows| &shadows.sources);
            let current = !sources.is_empty() && sources.iter().all(|source| source.settings.resolution == side);
            if ui.selectable_label(current, side.to_string()).clicked()
                && let Some(mut shadows) = model.shadows().cloned()
            {
                shadows.sources.iter_mut().for_each(|source| source.settings.resolution = side);
                model.set_shadows(Some(shadows));
            }
        }
        ui.separator();
        ui.label(theme::weak(motion));
    });
}
