//! The list of keys.

use super::theme;

const KEYS: [(&str, &[(&str, &str)]); 4] = [
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
        "Show",
        &[
            ("L", "lit, then each texture layer alone"),
            ("X", "wireframe"),
            ("N", "normals"),
            ("B", "bounds"),
            ("K", "collision hulls"),
            ("T", "panels"),
        ],
    ),
    ("Time", &[("Space", "play or pause"), (",  .", "one frame back or on")]),
    (
        "File",
        &[
            ("Ctrl S", "save lights, background and visibility to the scene file"),
            ("P, F12", "picture as PNG into the current folder"),
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
            egui::Grid::new("keys").num_columns(2).spacing([24.0, 4.0]).show(ui, |ui| {
                for (index, (group, keys)) in KEYS.iter().enumerate() {
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
        });
}
