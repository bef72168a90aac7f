//! The editor of light from all around, and of how light is shown.

use aam_scene::{Environment, MAX_EXPOSURE, MapLayout, SpecularFilter, ToneMap};
use egui::{ComboBox, DragValue, Grid};

use super::theme;

/// Draws the editor of an environment; true if something changed.
pub(crate) fn show(ui: &mut egui::Ui, environment: &mut Environment) -> bool {
    let picture = match environment.map.layout() {
        MapLayout::Panorama(image) => format!("Panorama of {} × {}", image.width, image.height),
        MapLayout::Cube(faces) => format!("Cube of {} × {}", faces[0].width, faces[0].height),
    };
    let range = if environment.map.is_linear() { "high dynamic range" } else { "encoded colours" };
    ui.label(theme::weak(format!("{picture}, {range}")));
    let mut changed = false;
    Grid::new("environment").num_columns(2).spacing([10.0, 5.0]).show(ui, |ui| {
        ui.label("Lights");
        ui.horizontal(|ui| {
            changed |= ui.checkbox(&mut environment.diffuse, "diffuse").changed();
            changed |= ui.checkbox(&mut environment.specular, "specular").changed();
        });
        ui.end_row();
        ui.label("Reflections");
        let name = |filter| match filter {
            None => "as the shading asks",
            Some(SpecularFilter::Mirror) => "mirror",
            Some(SpecularFilter::Phong) => "by exponent",
        };
        let before = environment.filter;
        ComboBox::from_id_salt("environment filter").selected_text(name(before)).show_ui(ui, |ui| {
            for filter in [None, Some(SpecularFilter::Mirror), Some(SpecularFilter::Phong)] {
                ui.selectable_value(&mut environment.filter, filter, name(filter));
            }
        });
        changed |= environment.filter != before;
        ui.end_row();
        ui.label("Rotation");
        let mut degrees = environment.rotation.to_degrees();
        if ui.add(DragValue::new(&mut degrees).speed(0.5).suffix("°").max_decimals(1)).changed() {
            environment.rotation = degrees.to_radians();
            changed = true;
        }
        ui.end_row();
        ui.label("Intensity");
        let intensity = DragValue::new(&mut environment.intensity).speed(0.01).range(0.0..=1e4).max_decimals(3);
        changed |= ui.add(intensity).changed();
        ui.end_row();
    });
    changed
}

/// Two rows of a grid: exposure and tone mapping; true if something changed.
pub(crate) fn display_rows(ui: &mut egui::Ui, exposure: &mut f32, tone_map: &mut ToneMap) -> bool {
    ui.label("Exposure");
    let stops = DragValue::new(exposure).speed(0.02).range(-MAX_EXPOSURE..=MAX_EXPOSURE).max_decimals(2);
    let mut changed = ui.add(stops.suffix(" stops")).changed();
    ui.end_row();
    ui.label("Tone map");
    let name = |tone_map| match tone_map {
        ToneMap::Clamp => "clamp",
        ToneMap::Reinhard => "Reinhard",
        ToneMap::Aces => "ACES",
        ToneMap::Neutral => "Neutral",
    };
    let before = *tone_map;
    ComboBox::from_id_salt("tone map").selected_text(name(before)).show_ui(ui, |ui| {
        for other in [ToneMap::Clamp, ToneMap::Reinhard, ToneMap::Aces, ToneMap::Neutral] {
            ui.selectable_value(tone_map, other, name(other));
        }
    });
    changed |= *tone_map != before;
    ui.end_row();
    changed
}
