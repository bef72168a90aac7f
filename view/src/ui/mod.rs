//! The panels around the picture, and what the pointer does on it.

mod demo;
mod environment;
mod help;
mod icons;
mod inspector;
mod lights;
mod shadows;
mod theme;
mod toolbar;
mod tree;

pub(crate) use theme::apply as apply_theme;

use aam_scene::{Background, DisplacementMode, Shading};
use egui::{Align2, CentralPanel, Color32, Frame, Margin, Panel, PointerButton, Rect, ScrollArea, Sense, pos2, vec2};
use glam::{Vec2, Vec3};

use crate::model::{Action, Model, file_name};
use crate::{keys, pose};
use inspector::Thumbnails;
use tree::{Tree, TreeEvent};

/// What the panels remember between frames.
#[derive(Default)]
pub(crate) struct Panels {
    tree: Tree,
    thumbnails: Thumbnails,
    generation: u64,
    hidden: bool,
    pub(crate) help: bool,
}

/// What one frame of the panels asks for.
#[derive(Default)]
pub(crate) struct Asked {
    pub(crate) actions: Vec<Action>,
    /// Where the picture is, in points.
    pub(crate) picture: Option<Rect>,
}

impl Panels {
    /// Shows or hides everything but the picture.
    pub(crate) fn toggle(&mut self) {
        self.hidden = !self.hidden;
    }

    /// Draws everything; the picture is the texture `picture`.
    pub(crate) fn show(&mut self, ui: &mut egui::Ui, model: &mut Model, picture: egui::TextureId) -> Asked {
        if self.generation != model.generation {
            self.generation = model.generation;
            self.thumbnails.clear();
        }
        let mut asked = Asked { actions: keys::actions(ui.ctx(), model.demo.is_some()), picture: None };
        let seconds = ui.input(|input| input.stable_dt).min(0.1);
        let flight = keys::flight(ui.ctx(), seconds);
        if flight != Vec3::ZERO {
            model.eye.fly(flight);
            model.look_from_source(None);
            ui.ctx().request_repaint();
        }
        if !self.hidden {
            let bar = Frame::new().fill(theme::PANEL).inner_margin(Margin::symmetric(10, 6));
            Panel::top("bar").frame(bar).show(ui, |ui| toolbar::show(ui, model, &mut asked.actions));
            Panel::bottom("status").frame(bar).show(ui, |ui| status(ui, model));
            if model.demo.is_some() {
                Panel::bottom("demo").frame(bar).show(ui, |ui| demo::show(ui, model));
            }
            if model.has_bodies() {
                Panel::bottom("bodies").frame(bar).show(ui, |ui| toolbar::simulation(ui, model, &mut asked.actions));
            }
            if model.is_animated() {
                Panel::bottom("time").frame(bar).show(ui, |ui| toolbar::time(ui, model, &mut asked.actions));
            }
            if model.opened.is_some() {
                let side = Frame::new().fill(theme::PANEL).inner_margin(Margin::symmetric(10, 8));
                Panel::left("objects").frame(side).default_size(230.0).size_range(140.0..=460.0).show(ui, |ui| {
                    self.objects(ui, model, &mut asked.actions);
                });
                Panel::right("details").frame(side).default_size(280.0).size_range(200.0..=520.0).show(ui, |ui| {
                    self.details(ui, model);
                });
            }
        }
        CentralPanel::no_frame().show(ui, |ui| {
            asked.picture = Some(self.picture(ui, model, picture));
        });
        let context = ui.ctx().clone();
        help::show(&context, &mut self.help);
        asked
    }

    fn objects(&mut self, ui: &mut egui::Ui, model: &mut Model, actions: &mut Vec<Action>) {
        let Some(opened) = &mut model.opened else { return };
        ui.horizontal(|ui| {
            ui.heading("Objects");
            ui.label(theme::weak(inspector::count(opened.scene.nodes.len())));
        });
        match self.tree.show(ui, &mut opened.scene, model.selected) {
            Some(TreeEvent::Selected(id)) => {
                model.selected = if model.selected == Some(id) { None } else { Some(id) };
                model.stale = true;
            }
            Some(TreeEvent::Focused(id)) => {
                model.selected = Some(id);
                actions.push(Action::Fit);
            }
            Some(TreeEvent::VisibilityChanged(_)) => model.visibility_changed(),
            None => {}
        }
    }

    fn details(&mut self, ui: &mut egui::Ui, model: &mut Model) {
        let size = model.opened.as_ref().map_or(1.0, |opened| opened.scene.bounds().diagonal());
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            if let Some(opened) = &model.opened {
                inspector::show(ui, &opened.scene, model.selected, &mut self.thumbnails);
            }
            separated_heading(ui, "Lights");
            let mut lights = model.opened.as_ref().map(|opened| opened.scene.lights.clone()).unwrap_or_default();
            let edit = lights::show(ui, &mut lights, &model.eye.camera(), size);
            if let Some(removed) = edit.removed {
                model.light_removed(removed);
            }
            if edit.changed {
                model.set_lights(lights);
            }
            if let Some(mut environment) = model.opened.as_ref().and_then(|opened| opened.scene.environment.clone()) {
                separated_heading(ui, "Environment");
                if environment::show(ui, &mut environment) {
                    model.set_environment(environment);
                }
            }
            separated_heading(ui, "Shadows");
            shadows::show(ui, model);
            separated_heading(ui, "Scene");
            scene_settings(ui, model);
            let warnings = model.opened.as_ref().map_or(&[][..], |opened| &opened.warnings);
            if !warnings.is_empty() {
                separated_heading(ui, "Warnings");
                for warning in warnings.iter().take(100) {
                    ui.add(egui::Label::new(egui::RichText::new(warning).small().color(theme::WARNING)).wrap());
                }
                if warnings.len() > 100 {
                    ui.label(theme::weak(format!("and {} more", warnings.len() - 100)));
                }
            }
        });
    }

    fn picture(&mut self, ui: &mut egui::Ui, model: &mut Model, picture: egui::TextureId) -> Rect {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        ui.painter().rect_filled(rect, 0.0, Color32::from_rgb(15, 17, 20));
        model.aspect = (rect.width() / rect.height().max(1.0)).clamp(0.05, 20.0);
        if model.opened.is_some() {
            ui.painter().image(picture, rect, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
            self.pointer(ui, model, &response, rect);
        } else if model.loading().is_none() && model.problem.is_none() {
            let text = format!("Drop a file here\n{}", model.formats);
            ui.painter().text(
                rect.center(),
                Align2::CENTER_CENTER,
                text,
                egui::FontId::proportional(16.0),
                theme::WEAK,
            );
        }
        if model.light_view.is_some() {
            // The window of the source is square and as high as the picture.
            let window = Rect::from_center_size(rect.center(), egui::Vec2::splat(rect.height()));
            let stroke = egui::Stroke::new(1.0, theme::ACCENT);
            ui.painter().with_clip_rect(rect).rect_stroke(window, 0.0, stroke, egui::StrokeKind::Inside);
        }
        overlay(ui, model, rect);
        rect
    }

    /// Ctrl drag takes hold of a simulated body and pulls it; true while it does.
    fn pulls(&mut self, ui: &egui::Ui, model: &mut Model, response: &egui::Response, rect: Rect) -> bool {
        let (command, start) = ui.input(|input| (input.modifiers.command, input.pointer.press_origin()));
        if command
            && response.drag_started_by(PointerButton::Primary)
            && let (Some(start), Some(opened)) = (start, &model.opened)
        {
            if !model.simulation.is_started() {
                model.say("G starts the simulation; then Ctrl drag pulls a body.");
                return true;
            }
            let (near, along) = ray(model, rect, start);
            if let Some((node, point)) = pose::pick(&opened.scene, &model.world(), near, along) {
                let camera = model.eye.camera();
                let across = (camera.target - camera.position).normalize_or(Vec3::Y);
                model.simulation.grab(&opened.scene, node, point, across);
            }
        }
        if !model.simulation.is_holding() {
            return false;
        }
        match response.interact_pointer_pos().filter(|_| response.dragged_by(PointerButton::Primary)) {
            Some(point) => {
                let (near, along) = ray(model, rect, point);
                model.simulation.pull(near, along);
            }
            None => model.simulation.release(),
        }
        ui.ctx().request_repaint();
        true
    }

    fn pointer(&mut self, ui: &egui::Ui, model: &mut Model, response: &egui::Response, rect: Rect) {
        let drag = response.drag_delta();
        let drag = Vec2::new(drag.x, drag.y);
        if self.pulls(ui, model, response, rect) {
            model.stale = true;
        } else if drag != Vec2::ZERO {
            let shift = ui.input(|input| input.modifiers.shift);
            if response.dragged_by(PointerButton::Middle) || shift && response.dragged_by(PointerButton::Primary) {
                model.eye.pan(drag, rect.height());
            } else if response.dragged_by(PointerButton::Secondary) {
                model.eye.look(drag);
            } else {
                model.eye.orbit(drag);
            }
            model.look_from_source(None);
        }
        if response.hovered() {
            let notches = ui.input(|input| input.smooth_scroll_delta.y / 40.0 + (input.zoom_delta() - 1.0) * 4.0);
            if notches != 0.0 {
                model.eye.zoom(notches);
                model.look_from_source(None);
            }
        }
        if response.clicked()
            && let (Some(point), Some(opened)) = (response.interact_pointer_pos(), &model.opened)
        {
            let (near, along) = ray(model, rect, point);
            model.selected = pose::pick(&opened.scene, &model.world(), near, along).map(|(node, _)| node);
            self.tree.reveal = model.selected.is_some();
            model.stale = true;
        }
    }
}

/// The ray of the pointer: a point of the near plane, and the way to the far one.
fn ray(model: &Model, rect: Rect, point: egui::Pos2) -> (Vec3, Vec3) {
    let x = 2.0 * (point.x - rect.left()) / rect.width() - 1.0;
    let y = 1.0 - 2.0 * (point.y - rect.top()) / rect.height();
    let camera = model.camera();
    let from_clip = (camera.projection_matrix(model.aspect) * camera.view()).inverse();
    let at = |depth: f32| from_clip.project_point3(Vec3::new(x, y, depth));
    (at(0.0), at(1.0) - at(0.0))
}

fn separated_heading(ui: &mut egui::Ui, text: &str) {
    ui.add_space(6.0);
    ui.separator();
    ui.heading(text);
}

/// Background and the values that lighting computes on.
fn scene_settings(ui: &mut egui::Ui, model: &mut Model) {
    let Some(opened) = &model.opened else { return };
    let mut background = opened.scene.background.clone();
    let mut shading = opened.scene.shading;
    let mut display = (opened.scene.exposure, opened.scene.tone_map);
    let (mut changed, mut display_changed) = (false, false);
    egui::Grid::new("scene").num_columns(2).spacing([14.0, 5.0]).show(ui, |ui| {
        ui.label("Background");
        ui.horizontal(|ui| {
            if let Background::Color(color) = &mut background {
                let mut bytes = color.to_array().map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8);
                if ui.color_edit_button_srgb(&mut bytes).changed() {
                    *color = Vec3::from_array(bytes.map(|byte| f32::from(byte) / 255.0));
                    changed = true;
                }
            } else if ui.button("Colour").clicked() {
                background = Background::default();
                changed = true;
            }
            let sky = background != Background::Environment && opened.scene.environment.is_some();
            if sky && ui.button("Environment").clicked() {
                background = Background::Environment;
                changed = true;
            }
        });
        ui.end_row();
        ui.label("Shading");
        ui.horizontal(|ui| {
            ui.selectable_value(&mut shading, Shading::Source, "source").on_hover_text("As VR3Lib and XVR did");
            ui.selectable_value(&mut shading, Shading::Linear, "linear").on_hover_text("In linear light");
        });
        ui.end_row();
        display_changed = environment::display_rows(ui, &mut display.0, &mut display.1);
    });
    if changed {
        model.set_background(background);
    }
    displacement_settings(ui, model);
    if model.opened.as_ref().is_some_and(|opened| opened.scene.shading != shading) {
        model.set_shading(shading);
    }
    if display_changed {
        model.set_display(display.0, display.1);
    }
}

/// How displacement maps are drawn, where there are any.
fn displacement_settings(ui: &mut egui::Ui, model: &mut Model) {
    let any = |opened: &crate::Opened| opened.scene.meshes.iter().any(|mesh| mesh.displacement.is_some());
    if !model.opened.as_ref().is_some_and(any) {
        return;
    }
    let mut mode = model.display.displacement;
    ui.horizontal(|ui| {
        ui.label("Displacement");
        ui.selectable_value(&mut mode, DisplacementMode::Off, "off").on_hover_text("The base meshes");
        let uniform = ui.selectable_value(&mut mode, DisplacementMode::Uniform, "uniform");
        uniform.on_hover_text("Each edge in as many parts as the file says");
        let adaptive = ui.selectable_label(matches!(mode, DisplacementMode::Adaptive { .. }), "adaptive");
        if adaptive.on_hover_text("As fine as the picture needs").clicked() {
            mode = DisplacementMode::ADAPTIVE;
        }
        let parallax = ui.selectable_value(&mut mode, DisplacementMode::Parallax, "parallax");
        parallax.on_hover_text("The base meshes, with the map looked up along the ray of sight");
        if let DisplacementMode::Adaptive { pixel_error } = &mut mode {
            let drag = egui::DragValue::new(pixel_error).range(0.05..=64.0).speed(0.05).suffix(" px");
            ui.add(drag).on_hover_text("The most that a point moves when the tessellation changes");
        }
    });
    if mode != model.display.displacement {
        model.display.displacement = mode;
        model.stale = true;
    }
}

/// The line at the bottom: messages on the left, cost on the right.
fn status(ui: &mut egui::Ui, model: &Model) {
    ui.horizontal(|ui| {
        match model.notice() {
            Some((notice, left)) => {
                let color = if notice.bad { theme::WARNING } else { ui.visuals().text_color() };
                ui.label(egui::RichText::new(&notice.text).color(color));
                ui.ctx().request_repaint_after(left);
            }
            None => {
                ui.label(theme::weak("Drag to turn, wheel to come closer, H for all keys"));
            }
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let stats = &model.stats;
            if model.opened.is_some() {
                let cpu = stats.cpu.total_ms();
                let gpu = stats.gpu_ms().map_or_else(|| "–".into(), |ms| format!("{ms:.1} ms"));
                let shown = ui.label(theme::weak(format!(
                    "{} triangles   CPU {cpu:.1} ms   GPU {gpu}",
                    inspector::count(stats.triangles as usize)
                )));
                shown.on_hover_ui(|ui| passes(ui, model));
            }
        });
    });
}

fn passes(ui: &mut egui::Ui, model: &Model) {
    egui::Grid::new("passes").num_columns(2).show(ui, |ui| {
        let stats = &model.stats;
        let cpu = [
            ("upload", stats.cpu.upload_ms),
            ("pipelines", stats.cpu.pipelines_ms),
            ("sort", stats.cpu.sort_ms),
            ("encode", stats.cpu.encode_ms),
        ];
        let gpu = stats.gpu.iter().flatten().map(|pass| (pass.name, pass.ms));
        for (side, name, ms) in
            cpu.into_iter().map(|(name, ms)| ("CPU", name, ms)).chain(gpu.map(|(name, ms)| ("GPU", name, ms)))
        {
            ui.label(format!("{side} {name}"));
            ui.label(format!("{ms:.2} ms"));
            ui.end_row();
        }
        ui.label("Draw calls");
        ui.label(stats.draws.to_string());
        ui.end_row();
    });
}

/// Spinner and problem, over the picture.
fn overlay(ui: &mut egui::Ui, model: &Model, rect: Rect) {
    if let Some((path, stage)) = model.loading() {
        let first = model.opened.is_none();
        let size = vec2(260.0_f32.min(rect.width()), 64.0);
        let center = if first { rect.center() } else { rect.center_bottom() - vec2(0.0, 50.0) };
        let mut place = ui.new_child(egui::UiBuilder::new().max_rect(Rect::from_center_size(center, size)));
        place.vertical_centered(|ui| {
            ui.add(egui::Spinner::new().size(24.0).color(theme::ACCENT));
            let doing = if stage.is_empty() { format!("Reading {}", file_name(path)) } else { stage };
            ui.label(doing);
        });
        ui.ctx().request_repaint_after(std::time::Duration::from_millis(50));
    }
    if let Some(problem) = &model.problem {
        let width = (rect.width() - 40.0).clamp(60.0, 760.0);
        let top = Rect::from_min_size(pos2(rect.center().x - 0.5 * width, rect.top() + 16.0), vec2(width, 10.0));
        let mut place = ui.new_child(egui::UiBuilder::new().max_rect(top));
        let frame = Frame::new()
            .fill(Color32::from_rgba_unmultiplied(60, 22, 22, 235))
            .stroke(egui::Stroke::new(1.0, theme::ERROR))
            .corner_radius(6)
            .inner_margin(Margin::symmetric(12, 8));
        frame.show(&mut place, |ui| {
            ui.set_width(width - 24.0);
            let title = if model.opened.is_some() {
                "The file cannot be shown as it is now; this is the last that could"
            } else {
                "The file cannot be shown"
            };
            ui.label(egui::RichText::new(title).strong());
            ui.add(egui::Label::new(egui::RichText::new(problem).monospace()).wrap());
        });
    }
}
