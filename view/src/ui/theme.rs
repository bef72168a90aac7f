//! How the panels look: dark, quiet, one accent colour.

use egui::{Color32, CornerRadius, FontFamily, FontId, Margin, Stroke, TextStyle, Visuals, vec2};

pub(crate) const PANEL: Color32 = Color32::from_rgb(27, 30, 35);
pub(crate) const ACCENT: Color32 = Color32::from_rgb(92, 160, 235);
pub(crate) const ERROR: Color32 = Color32::from_rgb(240, 110, 100);
pub(crate) const WARNING: Color32 = Color32::from_rgb(230, 180, 90);
pub(crate) const WEAK: Color32 = Color32::from_rgb(138, 146, 158);

/// Sets the style of all panels.
pub(crate) fn apply(context: &egui::Context) {
    context.set_theme(egui::Theme::Dark);
    context.global_style_mut(|style| {
        let mut visuals = Visuals::dark();
        visuals.panel_fill = PANEL;
        visuals.window_fill = PANEL;
        visuals.extreme_bg_color = Color32::from_rgb(19, 21, 25);
        visuals.faint_bg_color = Color32::from_rgb(33, 37, 43);
        visuals.selection.bg_fill = Color32::from_rgb(42, 82, 130);
        visuals.selection.stroke = Stroke::new(1.0, Color32::from_rgb(225, 236, 250));
        visuals.hyperlink_color = ACCENT;
        visuals.slider_trailing_fill = true;
        visuals.indent_has_left_vline = false;
        visuals.window_corner_radius = CornerRadius::same(8);
        visuals.menu_corner_radius = CornerRadius::same(6);
        let widgets = &mut visuals.widgets;
        widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_rgb(44, 49, 56));
        widgets.noninteractive.fg_stroke = Stroke::new(1.0, Color32::from_rgb(200, 206, 214));
        widgets.inactive.fg_stroke = Stroke::new(1.0, Color32::from_rgb(210, 215, 222));
        widgets.inactive.weak_bg_fill = Color32::from_rgb(46, 51, 59);
        widgets.inactive.bg_fill = Color32::from_rgb(52, 58, 67);
        for state in [&mut widgets.inactive, &mut widgets.hovered, &mut widgets.active, &mut widgets.open] {
            state.corner_radius = CornerRadius::same(4);
        }
        style.visuals = visuals;
        style.spacing.item_spacing = vec2(6.0, 5.0);
        style.spacing.button_padding = vec2(7.0, 3.0);
        style.spacing.window_margin = Margin::same(12);
        style.spacing.indent = 14.0;
        style.text_styles = [
            (TextStyle::Heading, FontId::new(15.0, FontFamily::Proportional)),
            (TextStyle::Body, FontId::new(13.0, FontFamily::Proportional)),
            (TextStyle::Button, FontId::new(13.0, FontFamily::Proportional)),
            (TextStyle::Small, FontId::new(11.0, FontFamily::Proportional)),
            (TextStyle::Monospace, FontId::new(12.0, FontFamily::Monospace)),
        ]
        .into();
    });
}

/// Less important text.
pub(crate) fn weak(text: impl Into<String>) -> egui::RichText {
    egui::RichText::new(text).color(WEAK)
}
