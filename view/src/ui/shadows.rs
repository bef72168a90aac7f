//! The editor of shadows: sources, techniques, parameters, what they cost, and where they fail.

use aam_renderer::ShadowLimit;
use aam_scene::{
    Camera, Light, Members, NodeId, ParameterRange, Projection, Scene, ShadowFilter, ShadowLayout, ShadowParameter,
    ShadowSettings, ShadowSource, ShadowTechnique, Shadows,
};
use egui::{ComboBox, DragValue, RichText, Slider};

use super::lights::vector_row;
use super::{inspector, theme};
use crate::model::Model;

/// Sides of maps to choose from.
const RESOLUTIONS: [u32; 8] = [64, 128, 256, 512, 1024, 2048, 4096, 8192];

/// Draws the editor.
pub(super) fn show(ui: &mut egui::Ui, model: &mut Model) {
    let Some(opened) = &model.opened else { return };
    let scene = &opened.scene;
    let before = scene.shadows.clone().unwrap_or_default();
    let mut shadows = before.clone();
    let mut asked = Asked::default();
    if shadows.sources.is_empty() {
        ui.label(theme::weak("None."));
    } else {
        let mut on = !model.display.no_shadows;
        if ui.checkbox(&mut on, "Shown").on_hover_text("With or without shadows (M); not saved").changed() {
            asked.shown = Some(on);
        }
    }
    let size = scene.bounds().diagonal();
    for index in 0..shadows.sources.len() {
        let notes = model.shadow_notes.get(index).map_or(&[][..], Vec::as_slice);
        let editor = Editor { index, scene, notes, size, seen: model.light_view == Some(index) };
        editor.source(ui, &mut shadows.sources[index], &mut asked);
    }
    if let Some(removed) = asked.removed {
        shadows.sources.remove(removed);
    }
    if let Some(duplicate) = asked.own_volume {
        match model.source_camera(duplicate) {
            Ok(camera) => shadows.sources[duplicate].volume = Some(Camera { name: String::new(), ..camera }),
            Err(reason) => asked.reason = Some(reason),
        }
    }
    add(ui, scene, &mut shadows);
    if !shadows.sources.is_empty() {
        members(ui, scene, model.selected, &mut shadows);
        options(ui, &mut shadows);
        cost(ui, model);
    }
    if shadows != before {
        model.set_shadows(Some(shadows));
    }
    if let Some(shown) = asked.shown {
        model.display.no_shadows = !shown;
        model.stale = true;
    }
    if let Some(view) = asked.view {
        model.look_from_source(view);
    }
    if let Some(reason) = asked.reason {
        model.complain(reason);
    }
}

/// What the user did beside changing values.
#[derive(Default)]
struct Asked {
    removed: Option<usize>,
    shown: Option<bool>,
    view: Option<Option<usize>>,
    own_volume: Option<usize>,
    reason: Option<String>,
}

struct Editor<'a> {
    index: usize,
    scene: &'a Scene,
    /// Where the source fails.
    notes: &'a [ShadowLimit],
    /// Diagonal of the scene.
    size: f32,
    /// The picture is seen from here.
    seen: bool,
}

impl Editor<'_> {
    fn source(&self, ui: &mut egui::Ui, source: &mut ShadowSource, asked: &mut Asked) {
        let index = self.index;
        let name = if source.name.is_empty() { format!("shadow {}", index + 1) } else { source.name.clone() };
        let title = format!("{name}: {}", source.settings.technique);
        let refused = self.notes.iter().any(|note| matches!(note, ShadowLimit::Refuses(_)));
        let color = match (source.enabled, refused) {
            (false, _) => theme::WEAK,
            (true, true) => theme::ERROR,
            (true, false) => ui.visuals().text_color(),
        };
        let header = egui::CollapsingHeader::new(RichText::new(title).color(color));
        header.id_salt(("shadow", index)).default_open(index == 0).show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.checkbox(&mut source.enabled, "On");
                let mut seen = self.seen;
                if ui.toggle_value(&mut seen, "Look from here").on_hover_text("The view of the source (V)").changed() {
                    asked.view = Some(seen.then_some(index));
                }
                if ui.button("Remove").clicked() {
                    asked.removed = Some(index);
                }
            });
            for note in self.notes {
                let (color, text) = match note {
                    ShadowLimit::Refuses(reason) => (theme::ERROR, format!("Not drawn: {reason}.")),
                    ShadowLimit::Degrades(reason) => (theme::WARNING, format!("Degrades: {reason}.")),
                };
                ui.add(egui::Label::new(RichText::new(text).small().color(color)).wrap());
            }
            egui::Grid::new(("shadow", index)).num_columns(2).spacing([10.0, 5.0]).show(ui, |ui| {
                ui.label("Name");
                ui.add(egui::TextEdit::singleline(&mut source.name).desired_width(150.0));
                ui.end_row();
                ui.label("Light");
                self.light(ui, source);
                ui.end_row();
                self.technique(ui, &mut source.settings);
                for parameter in source.settings.parameters().collect::<Vec<_>>() {
                    self.parameter(ui, parameter, &mut source.settings, asked);
                }
                self.volume(ui, source, asked);
            });
            if ui.button("Usual values").on_hover_text("Every parameter as the technique usually has it").clicked() {
                source.settings = ShadowSettings::new(source.settings.technique);
            }
        });
    }

    fn light(&self, ui: &mut egui::Ui, source: &mut ShadowSource) {
        let lights = &self.scene.lights;
        let shown = source.light.map_or_else(|| "every light".into(), |light| light_name(lights, light));
        ComboBox::from_id_salt(("shadow light", self.index)).selected_text(shown).show_ui(ui, |ui| {
            for light in 0..lights.len() {
                ui.selectable_value(&mut source.light, Some(light), light_name(lights, light));
            }
            // What no light fits has to have a volume.
            if source.volume.is_some() {
                ui.selectable_value(&mut source.light, None, "every light").on_hover_text("As VR3Lib's sources");
            }
        });
    }

    fn technique(&self, ui: &mut egui::Ui, settings: &mut ShadowSettings) {
        let mut technique = settings.technique;
        ui.label("Technique");
        let filters = ComboBox::from_id_salt(("shadow filter", self.index)).selected_text(technique.filter.word());
        filters.show_ui(ui, |ui| {
            for filter in ShadowFilter::ALL.iter().copied() {
                ui.selectable_value(&mut technique.filter, filter, filter.word()).on_hover_text(filter.meaning());
            }
        });
        ui.end_row();
        ui.label("Layout");
        let layouts =
            ComboBox::from_id_salt(("shadow layout", self.index)).selected_text(layout_name(technique.layout));
        layouts.show_ui(ui, |ui| {
            for layout in ShadowLayout::ALL.iter().copied() {
                if (ShadowTechnique { layout, ..technique }).exists() {
                    let choice = ui.selectable_value(&mut technique.layout, layout, layout_name(layout));
                    choice.on_hover_text(layout.meaning());
                }
            }
        });
        ui.end_row();
        if !technique.exists() {
            technique.layout = ShadowLayout::One;
        }
        if technique != settings.technique {
            *settings = settings.with_technique(technique);
        }
    }

    fn parameter(
        &self,
        ui: &mut egui::Ui,
        parameter: &ShadowParameter,
        settings: &mut ShadowSettings,
        asked: &mut Asked,
    ) {
        let before = parameter.get(settings);
        ui.label(parameter.key.replace('_', " ")).on_hover_text(format!(
            "{}; {}",
            parameter.meaning,
            parameter.range_in(settings)
        ));
        let after = match parameter.range_in(settings) {
            _ if parameter.key == "resolution" => {
                self.choice(ui, parameter, &before, &RESOLUTIONS.map(|side| side.to_string()))
            }
            ParameterRange::Words(words) => {
                self.choice(ui, parameter, &before, &words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>())
            }
            ParameterRange::Switch => {
                let mut on = before == "true";
                ui.checkbox(&mut on, "");
                on.to_string()
            }
            ParameterRange::Numbers { from, to, whole } => number(ui, &before, from, to, whole),
        };
        ui.end_row();
        if after != before {
            let mut changed = *settings;
            let set = parameter.set(&mut changed, &after).map_err(|error| error.to_string());
            match set.and_then(|()| changed.check()) {
                Ok(()) => *settings = changed,
                Err(reason) => asked.reason = Some(reason),
            }
        }
    }

    fn choice(&self, ui: &mut egui::Ui, parameter: &ShadowParameter, before: &str, words: &[String]) -> String {
        let mut chosen = before.to_owned();
        ComboBox::from_id_salt((parameter.key, self.index)).selected_text(before).show_ui(ui, |ui| {
            for word in words {
                ui.selectable_value(&mut chosen, word.clone(), word);
            }
        });
        chosen
    }

    fn volume(&self, ui: &mut egui::Ui, source: &mut ShadowSource, asked: &mut Asked) {
        if source.settings.technique.layout != ShadowLayout::One {
            return;
        }
        ui.label("Volume").on_hover_text("What the source sees; outside of it all is lit");
        let mut own = source.volume.is_some();
        ui.horizontal(|ui| {
            let fitted = ui.add_enabled(source.light.is_some(), egui::Button::selectable(!own, "fitted"));
            if fitted.on_hover_text("Around all that casts and receives; needs a light").clicked() {
                own = false;
            }
            if ui.selectable_label(own, "own").on_hover_text("A volume of its own, as it is now").clicked() {
                own = true;
            }
        });
        ui.end_row();
        match (&mut source.volume, own) {
            (None, true) => asked.own_volume = Some(self.index),
            (volume @ Some(_), false) => *volume = None,
            (Some(volume), true) => edit_volume(ui, volume, self.size),
            (None, false) => {}
        }
    }
}

fn edit_volume(ui: &mut egui::Ui, volume: &mut Camera, size: f32) {
    let before = volume.clone();
    let speed = f64::from(size) * 0.002;
    vector_row(ui, "Position", &mut volume.position, speed);
    vector_row(ui, "Target", &mut volume.target, speed);
    match &mut volume.projection {
        Projection::Perspective { fov_y } => {
            ui.label("Angle");
            let mut degrees = fov_y.to_degrees();
            if ui.add(DragValue::new(&mut degrees).speed(0.2).range(0.1..=175.0).suffix("°")).changed() {
                *fov_y = degrees.to_radians();
            }
        }
        Projection::Orthographic { height } => {
            ui.label("Width");
            ui.add(DragValue::new(height).speed(speed).range(1e-6..=1e9).suffix(" m"));
        }
    }
    ui.end_row();
    for (name, value) in [("Near", &mut volume.near), ("Far", &mut volume.far)] {
        ui.label(name);
        ui.add(DragValue::new(value).speed(speed).range(1e-6..=1e9).suffix(" m"));
        ui.end_row();
    }
    if volume.near >= volume.far || volume.position == volume.target {
        *volume = before;
    }
}

/// A number of a range: a slider where the range ends, else a value to drag.
fn number(ui: &mut egui::Ui, before: &str, from: f32, to: f32, whole: bool) -> String {
    let Ok(mut value) = before.parse::<f64>() else { return before.to_owned() };
    let (from, to) = (f64::from(from), f64::from(to));
    let same = value;
    if !to.is_finite() {
        let most = if value.is_finite() { f64::from(f32::MAX) } else { f64::INFINITY };
        if value.is_infinite() {
            if ui.button("no limit").on_hover_text("Click to set one").clicked() {
                return "1".into();
            }
            return before.to_owned();
        }
        ui.add(DragValue::new(&mut value).speed(0.0005).range(from..=most).max_decimals(5));
    } else {
        ui.spacing_mut().slider_width = 110.0;
        let wide = from > 0.0 && to / from > 1000.0;
        let mut slider = Slider::new(&mut value, from..=to).logarithmic(wide);
        if whole {
            slider = slider.integer();
        }
        if wide && !whole {
            slider = slider.custom_formatter(|value, _| format!("{value:.1e}"));
        }
        ui.add(slider);
    }
    if value == same { before.to_owned() } else { (value as f32).to_string() }
}

fn layout_name(layout: ShadowLayout) -> &'static str {
    match layout {
        ShadowLayout::One => "one map",
        ShadowLayout::Cascades => "cascades",
        ShadowLayout::Cube => "cube",
    }
}

fn light_name(lights: &[Light], index: usize) -> String {
    let name = lights.get(index).map_or("", |light| &light.name);
    if name.is_empty() { format!("light {}", index + 1) } else { name.to_owned() }
}

/// Buttons for lights that have no shadow yet.
fn add(ui: &mut egui::Ui, scene: &Scene, shadows: &mut Shadows) {
    let usual = Shadows::of_lights(scene, ShadowSettings::default()).sources;
    let has = |light: Option<usize>| shadows.sources.iter().any(|source| source.light == light);
    let missing: Vec<ShadowSource> = usual.into_iter().filter(|source| !has(source.light)).collect();
    if scene.lights.is_empty() {
        ui.label(theme::weak("A light at the camera sees no shadows: add another."));
    }
    if missing.is_empty() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label(theme::weak("Add for"));
        for source in missing {
            if ui.button(&source.name).clicked() {
                shadows.sources.push(source);
            }
        }
    });
}

/// Whether the selected object takes part.
fn members(ui: &mut egui::Ui, scene: &Scene, selected: Option<NodeId>, shadows: &mut Shadows) {
    let Some((id, node)) = selected.and_then(|id| Some((id, scene.nodes.get(id.index())?))) else {
        if (&shadows.casters, &shadows.receivers) != (&Members::All, &Members::All) {
            ui.label(theme::weak("Some objects take no part; select one to change that."));
        }
        return;
    };
    ui.horizontal(|ui| {
        let name = if node.name.is_empty() { "(no name)" } else { &node.name };
        ui.label(theme::weak(name));
        for (members, verb) in [(&mut shadows.casters, "casts"), (&mut shadows.receivers, "receives")] {
            let mut member = members.of(&scene.nodes).get(id.index()).copied().unwrap_or(false);
            let shown = ui.checkbox(&mut member, verb);
            if shown.on_hover_text("It and all below it; an object whose parts do not is left out with them").changed()
            {
                *members = members.with(&scene.nodes, id, member);
            }
        }
    });
}

fn options(ui: &mut egui::Ui, shadows: &mut Shadows) {
    egui::CollapsingHeader::new("Left out").id_salt("shadow culling").show(ui, |ui| {
        let culling = &mut shadows.culling;
        for (on, name, hint) in [
            (
                &mut culling.back_faces,
                "Back faces",
                "Triangles that face away from the source; open meshes lose their shadow",
            ),
            (&mut culling.casters, "Casters out of sight", "Objects wholly outside of a source's volume"),
            (&mut culling.sources, "Sources out of sight", "Sources whose volume the camera does not see"),
        ] {
            ui.checkbox(on, name).on_hover_text(hint);
        }
        let displaced = ui.checkbox(&mut shadows.displaced, "Displaced casters");
        displaced.on_hover_text("Displaced surfaces cast as they are drawn, not as the flat mesh");
    });
}

/// What the shadows of the last frame cost.
fn cost(ui: &mut egui::Ui, model: &Model) {
    let stats = &model.stats;
    egui::Grid::new("shadow cost").num_columns(2).spacing([14.0, 2.0]).show(ui, |ui| {
        let mut row = |name: &str, value: String| {
            ui.label(theme::weak(name));
            ui.label(RichText::new(value).small().monospace());
            ui.end_row();
        };
        match &stats.gpu {
            Some(passes) => {
                let own = passes.iter().filter(|pass| pass.name.starts_with("shadow"));
                own.for_each(|pass| row(&format!("GPU {}", pass.name), format!("{:.2} ms", pass.ms)));
                let picture = passes.iter().filter(|pass| !pass.name.starts_with("shadow")).map(|pass| pass.ms);
                row("GPU picture", format!("{:.2} ms", picture.sum::<f64>()));
            }
            None => row("GPU", "not measured here".into()),
        }
        row("Maps", format!("{} of {}", stats.shadow_maps, bytes(stats.shadow_bytes)));
        row("Casters drawn", inspector::count(stats.caster_draws as usize));
    });
}

fn bytes(bytes: u64) -> String {
    match bytes {
        0..1024 => format!("{bytes} B"),
        1024..1_048_576 => format!("{:.1} KiB", bytes as f64 / 1024.0),
        _ => format!("{:.1} MiB", bytes as f64 / 1_048_576.0),
    }
}
