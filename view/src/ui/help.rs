//! The list of keys.

use super::theme;

/// A heading, and keys with what they do.
type Group = (&'static str, &'static [(&'static str, &'static str)]);

/// Two groups for each of two columns.
const KEYS: [Group; 4] = [
    (
        "Look",
        &[
            ("Drag", "turn around the object"),
            ("Middle drag, Shift drag", "move sideways"),
            ("Right drag", "turn your head"),
            ("Wheel", "come closer"),
            ("W A S D, E C", "fly; E up, C down; Shift is faster"),
            ("F, Home", "see everything, or the selected object"),
            ("1 … 7", "front, back, left, right, top, bottom, corner"),
            ("O", "perspective or orthographic"),
        ],
    ),
    (
        "Time",
        &[
            ("Space", "play or pause the animation, or the simulation"),
            (",  .", "one frame back or on"),
            ("G", "simulate the bodies, or pause"),
            ("J", "one step of the simulation"),
            ("Backspace", "everything back to where it was"),
            ("Ctrl drag", "pull a body"),
        ],
    ),
    (
        "Show",
        &[
            ("L", "lit, then each texture layer alone"),
            ("X", "wireframe"),
            ("N", "normals"),
            ("B", "bounds"),
            ("K", "collision hulls"),
            ("M", "shadows on or off"),
            ("V", "the view of each shadow source"),
            ("Y", "collision hulls, apart"),
            ("U", "contacts of the simulation"),
            ("Z", "which bodies sleep"),
            ("T", "panels"),
        ],
    ),
    (
        "File",
        &[
            ("Ctrl S", "save lights, shadows, background, visibility, view"),
            ("P, F12", "picture as PNG into this folder"),
            ("R", "read the file again"),
            ("Drop a file", "open it"),
            ("H, F1", "this list"),
            ("Q, Esc", "close"),
        ],
    ),
];

/// The overlay; closes itself.
pub(crate) fn show(context: &egui::Context, open: &mut bool) {
    egui::Window::new("Keys")
        .open(open)
        .collapsible(false)
        .resizable(false)
        .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
        .show(context, |ui| {
            ui.set_max_width(ui.ctx().content_rect().width() - 60.0);
            egui::ScrollArea::both().max_height(ui.ctx().content_rect().height() - 90.0).show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    for (side, groups) in KEYS.chunks(2).enumerate() {
                        ui.vertical(|ui| column(ui, side, groups));
                        ui.add_space(18.0);
                    }
                });
            });
        });
}

fn column(ui: &mut egui::Ui, side: usize, groups: &[Group]) {
    egui::Grid::new(("keys", side)).num_columns(2).spacing([16.0, 4.0]).show(ui, |ui| {
        for (index, (group, keys)) in groups.iter().enumerate() {
            if index > 0 {
                ui.end_row();
            }
            ui.label(egui::RichText::new(*group).heading().color(theme::ACCENT));
            ui.end_row();
            for (key, meaning) in *keys {
                ui.monospace(*key);
                ui.label(*meaning);
                ui.end_row();
            }
        }
    });
}
