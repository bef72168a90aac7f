//! The editor of lights.

use aam_scene::{Camera, Falloff, Light, LightKind};
use egui::{Align, DragValue, Layout};
use glam::Vec3;

use super::theme;

/// What the user did with the lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Edit {
    pub(crate) changed: bool,
    pub(crate) removed: Option<usize>,
}

/// Draws the editor.
pub(crate) fn show(ui: &mut egui::Ui, lights: &mut Vec<Light>, camera: &Camera, size: f32) -> Edit {
    let mut changed = false;
    if lights.is_empty() {
        ui.label(theme::weak("None: one white light at the camera."));
    }
    let mut removed = None;
    for (index, light) in lights.iter_mut().enumerate() {
        let title = if light.name.is_empty() { kind_name(&light.kind).to_owned() } else { light.name.clone() };
        egui::CollapsingHeader::new(title).id_salt(("light", index)).show(ui, |ui| {
            changed |= edit(ui, index, light, camera, size);
            if ui.button("Remove").clicked() {
                removed = Some(index);
            }
        });
    }
    if let Some(index) = removed {
        lights.remove(index);
        changed = true;
    }
    ui.horizontal(|ui| {
        ui.label(theme::weak("Add"));
        for kind in [point(camera), directional(camera), spot(camera)] {
            if ui.button(kind_name(&kind)).clicked() {
                lights.push(new_light(kind, lights.len()));
                changed = true;
            }
        }
    });
    Edit { changed, removed }
}

fn edit(ui: &mut egui::Ui, index: usize, light: &mut Light, camera: &Camera, size: f32) -> bool {
    let mut changed = false;
    let speed = f64::from(size) * 0.002;
    egui::Grid::new(("light", index)).num_columns(2).spacing([10.0, 5.0]).show(ui, |ui| {
        ui.label("Name");
        changed |= ui.add(egui::TextEdit::singleline(&mut light.name).desired_width(150.0)).changed();
        ui.end_row();
        ui.label("Kind");
        changed |= kind_choice(ui, index, &mut light.kind, camera);
        ui.end_row();
        match &mut light.kind {
            LightKind::Point { position, falloff } => {
                changed |= vector_row(ui, "Position", position, speed);
                changed |= falloff_row(ui, index, falloff);
            }
            LightKind::Directional { direction } => changed |= vector_row(ui, "Direction", direction, 0.01),
            LightKind::Spot { position, direction, inner, outer, falloff } => {
                changed |= vector_row(ui, "Position", position, speed);
                changed |= vector_row(ui, "Direction", direction, 0.01);
                changed |= angle_row(ui, "Inner", inner, 0.0, *outer);
                changed |= angle_row(ui, "Outer", outer, *inner, std::f32::consts::FRAC_PI_2);
                changed |= falloff_row(ui, index, falloff);
            }
        }
        changed |= color_row(ui, "Ambient", &mut light.ambient);
        changed |= color_row(ui, "Diffuse", &mut light.diffuse);
        changed |= color_row(ui, "Specular", &mut light.specular);
    });
    if ui.button("Move to the camera").on_hover_text("Put it where you stand, shining where you look").clicked() {
        let forward = (camera.target - camera.position).normalize_or(Vec3::NEG_Z);
        match &mut light.kind {
            LightKind::Point { position, .. } => *position = camera.position,
            LightKind::Directional { direction } => *direction = forward,
            LightKind::Spot { position, direction, .. } => (*position, *direction) = (camera.position, forward),
        }
        changed = true;
    }
    changed
}

fn kind_name(kind: &LightKind) -> &'static str {
    match kind {
        LightKind::Point { .. } => "Point",
        LightKind::Directional { .. } => "Directional",
        LightKind::Spot { .. } => "Spot",
    }
}

fn point(camera: &Camera) -> LightKind {
    LightKind::Point { position: camera.position, falloff: Falloff::None }
}

fn directional(camera: &Camera) -> LightKind {
    LightKind::Directional { direction: (camera.target - camera.position).normalize_or(Vec3::NEG_Z) }
}

fn spot(camera: &Camera) -> LightKind {
    let direction = (camera.target - camera.position).normalize_or(Vec3::NEG_Z);
    LightKind::Spot { position: camera.position, direction, inner: 0.25, outer: 0.35, falloff: Falloff::None }
}

fn new_light(kind: LightKind, index: usize) -> Light {
    Light {
        name: format!("{} {}", kind_name(&kind), index + 1),
        kind,
        ambient: if index == 0 { Vec3::splat(0.2) } else { Vec3::ZERO },
        diffuse: Vec3::ONE,
        specular: Vec3::ONE,
        shape: None,
    }
}

fn kind_choice(ui: &mut egui::Ui, index: usize, kind: &mut LightKind, camera: &Camera) -> bool {
    let mut chosen = None;
    egui::ComboBox::from_id_salt(("kind", index)).selected_text(kind_name(kind)).show_ui(ui, |ui| {
        for other in [point(camera), directional(camera), spot(camera)] {
            let same = kind_name(&other) == kind_name(kind);
            if ui.selectable_label(same, kind_name(&other)).clicked() && !same {
                chosen = Some(other);
            }
        }
    });
    let Some(mut other) = chosen else { return false };
    // What both kinds have is kept.
    let (position, direction) = match kind {
        LightKind::Point { position, .. } => (Some(*position), None),
        LightKind::Directional { direction } => (None, Some(*direction)),
        LightKind::Spot { position, direction, .. } => (Some(*position), Some(*direction)),
    };
    if let LightKind::Point { position: place, .. } | LightKind::Spot { position: place, .. } = &mut other {
        *place = position.unwrap_or(*place);
    }
    if let LightKind::Directional { direction: way } | LightKind::Spot { direction: way, .. } = &mut other {
        *way = direction.unwrap_or(*way);
    }
    *kind = other;
    true
}

pub(super) fn vector_row(ui: &mut egui::Ui, name: &str, vector: &mut Vec3, speed: f64) -> bool {
    ui.label(name);
    let changed = ui
        .horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            let mut changed = false;
            for value in vector.as_mut() {
                changed |= ui.add(DragValue::new(value).speed(speed).max_decimals(3)).changed();
            }
            changed
        })
        .inner;
    ui.end_row();
    changed
}

fn angle_row(ui: &mut egui::Ui, name: &str, radians: &mut f32, low: f32, high: f32) -> bool {
    ui.label(name);
    let mut degrees = radians.to_degrees();
    let range = low.to_degrees()..=high.to_degrees().max(low.to_degrees());
    let changed = ui.add(DragValue::new(&mut degrees).speed(0.2).range(range).suffix("°").max_decimals(1)).changed();
    if changed {
        *radians = degrees.to_radians();
    }
    ui.end_row();
    changed
}

fn falloff_row(ui: &mut egui::Ui, index: usize, falloff: &mut Falloff) -> bool {
    ui.label("Falloff");
    let name = |falloff| match falloff {
        Falloff::None => "none",
        Falloff::InverseSquare => "inverse square",
    };
    let before = *falloff;
    egui::ComboBox::from_id_salt(("falloff", index)).selected_text(name(*falloff)).show_ui(ui, |ui| {
        for other in [Falloff::None, Falloff::InverseSquare] {
            ui.selectable_value(falloff, other, name(other));
        }
    });
    ui.end_row();
    *falloff != before
}

/// A colour in `[0, 1]` and a factor, since lights may be brighter than white.
fn color_row(ui: &mut egui::Ui, name: &str, color: &mut Vec3) -> bool {
    ui.label(name);
    let mut factor = color.max_element().max(1.0);
    let mut bytes = (*color / factor).to_array().map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8);
    let changed = ui
        .with_layout(Layout::left_to_right(Align::Center), |ui| {
            let color_changed = ui.color_edit_button_srgb(&mut bytes).changed();
            let drag = DragValue::new(&mut factor).speed(0.02).range(1.0..=1e6).prefix("× ").max_decimals(2);
            let factor_changed = ui.add(drag).on_hover_text("Brighter than white").changed();
            if color_changed {
                *color = Vec3::from_array(bytes.map(|byte| f32::from(byte) / 255.0)) * factor;
            } else if factor_changed {
                let peak = color.max_element();
                *color *= if peak > 0.0 { factor / peak.max(1.0) } else { 1.0 };
            }
            color_changed || factor_changed
        })
        .inner;
    ui.end_row();
    changed
}
