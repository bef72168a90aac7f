//! The bar at the top, and the time line.

use aam_renderer::Show;
use aam_scene::Layer;
use egui::{Align, ComboBox, Layout, Slider};

use super::icons::{self, Icon};
use super::{inspector, theme};
use crate::eye::Side;
use crate::model::{Action, Model, file_name};

/// What is drawn, from where; help.
pub(super) fn show(ui: &mut egui::Ui, model: &mut Model, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let sources = model.source_count();
        let display = &mut model.display;
        let before = *display;
        ComboBox::from_id_salt("show").selected_text(show_name(display.show)).width(130.0).show_ui(ui, |ui| {
            let layers = Layer::ALL.into_iter();
            let shows = [Show::Lit].into_iter().chain(layers.clone().map(Show::Layer)).chain([Show::Normals]);
            let of_sources = (0..sources).flat_map(|source| [Show::Shadow(source), Show::ShadowMap(source)]);
            for show in shows.chain([Show::Uvs(Layer::Diffuse)]).chain(of_sources) {
                ui.selectable_value(&mut display.show, show, show_name(show));
            }
        });
        for (on, name, hint) in [
            (&mut display.wireframe, "Wireframe", "Edges of all triangles (X)"),
            (&mut display.normals, "Normals", "The normal of each vertex (N)"),
            (&mut display.bounds, "Bounds", "The box around each object (B)"),
            (&mut display.hulls, "Hulls", "Collision shapes (K)"),
        ] {
            ui.toggle_value(on, name).on_hover_text(hint);
        }
        if display.hulls {
            let slider = Slider::new(&mut display.explode, 0.0..=3.0).show_value(false);
            ui.spacing_mut().slider_width = 70.0;
            ui.add(slider).on_hover_text("How far hulls stand apart (Y)");
        }
        model.stale |= before != model.display;
        ui.separator();
        views(ui, model, actions);
        if ui.button("Fit").on_hover_text("See everything, or the selected object (F)").clicked() {
            actions.push(Action::Fit);
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui.button("?").on_hover_text("All keys (H)").clicked() {
                actions.push(Action::Help);
            }
            if ui.button("Picture").on_hover_text("Save a PNG into the current folder (P)").clicked() {
                actions.push(Action::Screenshot);
            }
            let save = egui::Button::new("Save").selected(model.unsaved);
            let hint = "Save lights, background and visibility to the scene file (Ctrl S)";
            if ui.add_enabled(model.opened.is_some(), save).on_hover_text(hint).clicked() {
                actions.push(Action::Save);
            }
            if let Some(path) = &model.path {
                ui.add(egui::Label::new(theme::weak(file_name(path))).truncate())
                    .on_hover_text(path.display().to_string());
            }
        });
    });
}

fn views(ui: &mut egui::Ui, model: &Model, actions: &mut Vec<Action>) {
    ui.menu_button("View", |ui| {
        for (index, (side, name)) in Side::ALL.into_iter().enumerate() {
            if ui.add(egui::Button::new(name).shortcut_text((index + 1).to_string())).clicked() {
                actions.push(Action::LookFrom(side));
            }
        }
        ui.separator();
        let other = if model.eye.orthographic() { "Perspective" } else { "Orthographic" };
        if ui.add(egui::Button::new(other).shortcut_text("O")).clicked() {
            actions.push(Action::Orthographic);
        }
        let cameras = model.opened.as_ref().map_or(&[][..], |opened| &opened.scene.cameras);
        if !cameras.is_empty() {
            ui.separator();
            ui.label(theme::weak("Cameras of the file"));
        }
        for (index, camera) in cameras.iter().enumerate() {
            let name = if camera.name.is_empty() { format!("camera {}", index + 1) } else { camera.name.clone() };
            if ui.button(name).clicked() {
                actions.push(Action::LookThrough(index));
            }
        }
    });
}

fn show_name(show: Show) -> String {
    match show {
        Show::Lit => "Lit".into(),
        Show::Layer(layer) => format!("Only {}", inspector::layer_name(layer)),
        Show::Normals => "Shading normals".into(),
        Show::Shadow(source) => format!("Shadow {}", source + 1),
        Show::ShadowMap(source) => format!("Shadow map {}", source + 1),
        Show::Uvs(_) => "Texture coordinates".into(),
    }
}

/// Play, pause, step and start again for the bodies, and what they do.
pub(super) fn simulation(ui: &mut egui::Ui, model: &mut Model, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        ui.label("Bodies");
        let play = if model.simulation.playing { Icon::Pause } else { Icon::Play };
        if icons::button(ui, play, true).on_hover_text("Simulate or pause (G)").clicked() {
            actions.push(Action::Simulate);
        }
        if icons::button(ui, Icon::On, true).on_hover_text("One step (J)").clicked() {
            actions.push(Action::SimulateStep);
        }
        let reset = ui.add_enabled(model.simulation.is_started(), egui::Button::new("Reset"));
        if reset.on_hover_text("Everything back to where it was (Backspace)").clicked() {
            actions.push(Action::SimulateReset);
        }
        let before = model.display;
        ui.toggle_value(&mut model.display.contacts, "Contacts").on_hover_text("Where bodies touch (U)");
        ui.toggle_value(&mut model.display.sleeping, "Sleep")
            .on_hover_text("The box of each dynamic body: orange awake, blue asleep (Z)");
        model.stale |= before != model.display;
        if model.simulation.is_started() {
            ui.monospace(model.simulation.status());
            if model.display.contacts {
                ui.monospace(format!("  {} contacts", inspector::count(model.simulation.contacts().len())));
            }
            ui.label(theme::weak("Ctrl drag pulls a body"));
        }
    });
}

/// Play, pause, step, and where the time stands.
pub(super) fn time(ui: &mut egui::Ui, model: &mut Model, actions: &mut Vec<Action>) {
    let Some(animation) = model.opened.as_ref().and_then(|opened| opened.scene.animation.as_ref()) else { return };
    ui.horizontal(|ui| {
        if icons::button(ui, Icon::Back, true).on_hover_text("One frame back (,)").clicked() {
            actions.push(Action::Step(-1));
        }
        let play = if model.playback.playing { Icon::Pause } else { Icon::Play };
        if icons::button(ui, play, true).on_hover_text("Play or pause (Space)").clicked() {
            actions.push(Action::PlayPause);
        }
        if icons::button(ui, Icon::On, true).on_hover_text("One frame on (.)").clicked() {
            actions.push(Action::Step(1));
        }
        let last = animation.frame_count.saturating_sub(1);
        let mut frame = model.playback.index(animation);
        ui.spacing_mut().slider_width = (ui.available_width() - 210.0).max(60.0);
        if ui.add(Slider::new(&mut frame, 0..=last).show_value(false)).changed() {
            model.playback.frame = frame as f32;
            model.playback.playing = false;
            model.stale = true;
        }
        let seconds = frame as f32 / animation.frames_per_second.max(1e-3);
        ui.monospace(format!("{frame} / {last}"));
        ui.label(theme::weak(format!("{seconds:.2} s at {} a second", animation.frames_per_second)));
    });
}
