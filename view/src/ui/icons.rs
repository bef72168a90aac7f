//! Icons, painted: the fonts have none.

use egui::{Button, Color32, Pos2, Rect, Response, Shape, Stroke, Ui, Vec2, pos2, vec2};

use super::theme;

/// What an icon shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Icon {
    Shown,
    Hidden,
    Play,
    Pause,
    Back,
    On,
}

/// A button with an icon, framed or bare.
pub(super) fn button(ui: &mut Ui, icon: Icon, framed: bool) -> Response {
    let size = if framed { vec2(26.0, 20.0) } else { vec2(20.0, 18.0) };
    let response = ui.add(Button::new("").frame(framed).min_size(size));
    if ui.is_rect_visible(response.rect) {
        let color = match (icon, response.hovered()) {
            (_, true) => Color32::WHITE,
            (Icon::Shown | Icon::Hidden, false) => theme::WEAK,
            (_, false) => ui.visuals().widgets.inactive.fg_stroke.color,
        };
        ui.painter().extend(shapes(icon, response.rect, color));
    }
    response
}

fn shapes(icon: Icon, rect: Rect, color: Color32) -> Vec<Shape> {
    let center = rect.center();
    let stroke = Stroke::new(1.3, color);
    let at = |x: f32, y: f32| center + vec2(x, y);
    let triangle = |points: [Pos2; 3]| Shape::convex_polygon(points.to_vec(), color, Stroke::NONE);
    let bar =
        |x: f32, width: f32| Shape::rect_filled(Rect::from_center_size(at(x, 0.0), vec2(width, 10.0)), 0.0, color);
    match icon {
        Icon::Shown => {
            vec![Shape::ellipse_stroke(center, vec2(6.5, 4.2), stroke), Shape::circle_filled(center, 2.0, color)]
        }
        Icon::Hidden => vec![
            Shape::ellipse_stroke(center, vec2(6.5, 4.2), Stroke::new(1.0, color.gamma_multiply(0.5))),
            Shape::line_segment([at(-6.0, 5.0), at(6.0, -5.0)], stroke),
        ],
        Icon::Play => vec![triangle([at(-4.0, -5.5), at(5.5, 0.0), at(-4.0, 5.5)])],
        Icon::Pause => vec![bar(-2.8, 3.0), bar(2.8, 3.0)],
        Icon::Back => vec![bar(-5.0, 1.8), triangle([at(5.0, -5.0), at(5.0, 5.0), at(-3.5, 0.0)])],
        Icon::On => vec![bar(5.0, 1.8), triangle([at(-5.0, -5.0), at(3.5, 0.0), at(-5.0, 5.0)])],
    }
}

/// The arrow before a row with others below it: right when closed, down when open.
pub(super) fn arrow(ui: &mut Ui, open: bool) -> Response {
    let response = ui.add(Button::new("").frame(false).min_size(vec2(16.0, 18.0)));
    let center = response.rect.center();
    let points = if open {
        [vec2(-4.0, -2.0), vec2(4.0, -2.0), vec2(0.0, 3.5)]
    } else {
        [vec2(-2.0, -4.0), vec2(3.5, 0.0), vec2(-2.0, 4.0)]
    };
    let color = if response.hovered() { Color32::WHITE } else { theme::WEAK };
    let points = points.map(|offset: Vec2| pos2(center.x + offset.x, center.y + offset.y));
    ui.painter().add(Shape::convex_polygon(points.to_vec(), color, Stroke::NONE));
    response
}
