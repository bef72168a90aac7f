//! Charts of cost against error as SVG, self-contained.

use std::fmt::Write;

use crate::shadows::pareto;
use crate::study::{Row, Study};

/// A panel's plotting area in pixels, and what surrounds it.
const WIDTH: f64 = 300.0;
const HEIGHT: f64 = 240.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 22.0;
const TOP: f64 = 94.0;
const BOTTOM: f64 = 74.0;
/// A row of the legend.
const LEGEND: f64 = 18.0;

const INK: &str = "#222";
const FAINT: &str = "#ddd";
const DOT: &str = "#2a6fb0";
const FRONT: &str = "#d1495b";

/// Dots that show cost and error.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// What it shows.
    pub title: String,
    /// What is to the right, on a logarithmic scale.
    pub x_label: String,
    /// What is upwards.
    pub y_label: String,
    /// The dots.
    pub dots: Vec<Dot>,
}

/// A cost and an error.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dot {
    /// What it stands for.
    pub label: String,
    /// Dots of a group have one colour; where all are of one, there is no legend.
    pub group: String,
    /// The cost.
    pub x: f64,
    /// First and third quartile of the cost.
    pub x_quartiles: [f64; 2],
    /// The error.
    pub y: f64,
}

/// One panel for each scene: GPU time to the right, mean FLIP difference upwards, one dot for each variant, and a line
/// through the variants that no other beats in both.
pub fn cost_and_error(study: &Study) -> String {
    let panels = study.scenes().into_iter().map(|scene| {
        let rows = study.rows.iter().filter(|row| row.scene == scene);
        Panel {
            title: scene.into(),
            x_label: "GPU time of a frame, ms (logarithmic)".into(),
            y_label: "mean FLIP difference".into(),
            dots: rows.map(dot).collect(),
        }
    });
    sheet(&study.title, &[study.machine.clone(), study.method.clone()], &panels.collect::<Vec<_>>())
}

fn dot(row: &Row) -> Dot {
    Dot {
        label: row.variant.clone(),
        group: String::new(),
        x: row.gpu_ms,
        x_quartiles: row.gpu_quartiles,
        y: row.flip_mean,
    }
}

/// A sheet with a title, lines that say how it was measured, and panels beside each other.
pub fn sheet(title: &str, notes: &[String; 2], panels: &[Panel]) -> String {
    let mut groups: Vec<&str> = panels.iter().flat_map(|panel| &panel.dots).map(|dot| dot.group.as_str()).collect();
    groups.sort_unstable();
    groups.dedup();
    let width = (LEFT + WIDTH + RIGHT) * panels.len().max(1) as f64;
    let each_row = ((width - 2.0 * RIGHT) / 92.0).max(1.0) as usize;
    let legend = if groups.len() > 1 { groups.len().div_ceil(each_row) as f64 * LEGEND } else { 0.0 };
    let height = TOP + HEIGHT + BOTTOM + legend;
    let mut svg = String::new();
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"11\" fill=\"{INK}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
    );
    text(&mut svg, (LEFT, 22.0), "start", "font-size=\"15\" font-weight=\"bold\"", title);
    text(&mut svg, (LEFT, 40.0), "start", "fill=\"#666\"", &notes[0]);
    text(&mut svg, (LEFT, 55.0), "start", "fill=\"#666\"", &notes[1]);
    for (index, panel) in panels.iter().enumerate() {
        let _ = writeln!(svg, "<g transform=\"translate({},{TOP})\">", LEFT + (LEFT + WIDTH + RIGHT) * index as f64);
        draw(&mut svg, panel, &groups);
        svg.push_str("</g>\n");
    }
    if groups.len() > 1 {
        for (index, group) in groups.iter().enumerate() {
            let (x, y) = (RIGHT + 92.0 * (index % each_row) as f64, (index / each_row) as f64 * LEGEND);
            let y = TOP + HEIGHT + BOTTOM - 26.0 + y;
            let _ = writeln!(
                svg,
                "<rect x=\"{x}\" y=\"{}\" width=\"9\" height=\"9\" fill=\"{}\"/>",
                y - 9.0,
                color(group, &groups)
            );
            text(&mut svg, (x + 13.0, y), "start", "", group);
        }
    }
    let foot = if groups.len() > 1 {
        "Down and to the left is better. Whiskers: half of the frames lie between. Ringed: beaten by no other in both."
    } else {
        "Down and to the left is better. Whiskers: half of the frames lie between. Red: beaten by no other in both."
    };
    text(&mut svg, (LEFT, height - 12.0), "start", "fill=\"#666\"", foot);
    svg.push_str("</svg>\n");
    svg
}

/// Points that belong together, such as a technique over its parameter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// What they are.
    pub name: String,
    /// Label, cost and error of each, in the order that a line joins them.
    pub points: Vec<(String, f64, f64)>,
}

/// Colours of series.
const SERIES: [&str; 4] = [DOT, FRONT, "#3a9a5b", "#8a5cb8"];

/// One panel for each named set of series, logarithmic on both axes: cost to the right, error upwards. Points whose cost or
/// error is not above 0 are left out.
pub fn series(title: &str, notes: [&str; 2], panels: &[(&str, [&str; 2], Vec<Series>)]) -> String {
    let width = (LEFT + WIDTH + RIGHT) * panels.len().max(1) as f64;
    let height = TOP + HEIGHT + BOTTOM;
    let mut svg = String::new();
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"11\" fill=\"{INK}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
    );
    text(&mut svg, (LEFT, 22.0), "start", "font-size=\"15\" font-weight=\"bold\"", title);
    text(&mut svg, (LEFT, 40.0), "start", "fill=\"#666\"", notes[0]);
    text(&mut svg, (LEFT, 55.0), "start", "fill=\"#666\"", notes[1]);
    for (index, (name, axes, lines)) in panels.iter().enumerate() {
        let _ = writeln!(svg, "<g transform=\"translate({},{TOP})\">", LEFT + (LEFT + WIDTH + RIGHT) * index as f64);
        series_panel(&mut svg, name, axes, lines);
        svg.push_str("</g>\n");
    }
    text(&mut svg, (LEFT, height - 12.0), "start", "fill=\"#666\"", "Down and to the left is better.");
    svg.push_str("</svg>\n");
    svg
}

fn series_panel(svg: &mut String, title: &str, [across, up]: &[&str; 2], lines: &[Series]) {
    let shown = |series: &Series| {
        let points = series.points.iter().filter(|(_, cost, error)| *cost > 0.0 && *error > 0.0);
        points.cloned().collect::<Vec<(String, f64, f64)>>()
    };
    let all: Vec<(String, f64, f64)> = lines.iter().flat_map(shown).collect();
    let x = Axis::logarithmic(all.iter().map(|(_, cost, _)| *cost), WIDTH);
    let y = Axis::logarithmic(all.iter().map(|(_, _, error)| *error), HEIGHT);
    text(svg, (0.0, -10.0), "start", "font-size=\"13\" font-weight=\"bold\"", title);
    for (value, label) in x.ticks().into_iter().filter(|(value, _)| is_sparse(*value, &x)) {
        let at = x.place(value);
        line(svg, [(at, 0.0), (at, HEIGHT)], FAINT);
        text(svg, (at, HEIGHT + 15.0), "middle", "", &label);
    }
    for (value, label) in y.ticks().into_iter().filter(|(value, _)| is_sparse(*value, &y)) {
        let at = HEIGHT - y.place(value);
        line(svg, [(0.0, at), (WIDTH, at)], FAINT);
        text(svg, (-6.0, at + 4.0), "end", "", &label);
    }
    line(svg, [(0.0, 0.0), (0.0, HEIGHT)], INK);
    line(svg, [(0.0, HEIGHT), (WIDTH, HEIGHT)], INK);
    text(svg, (0.5 * WIDTH, HEIGHT + 32.0), "middle", "", across);
    text(svg, (-50.0, 0.5 * HEIGHT), "middle", &format!("transform=\"rotate(-90 -50 {})\"", 0.5 * HEIGHT), up);
    let dots: Vec<(f64, f64)> = all.iter().map(|(_, cost, error)| (x.place(*cost), HEIGHT - y.place(*error))).collect();
    let mut labels: Vec<(f64, f64, f64)> = Vec::new();
    for (index, series) in lines.iter().enumerate() {
        let color = SERIES[index % SERIES.len()];
        let points = shown(series);
        let places: Vec<(f64, f64)> =
            points.iter().map(|(_, cost, error)| (x.place(*cost), HEIGHT - y.place(*error))).collect();
        let path: Vec<String> = places.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let _ = writeln!(svg, "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\"/>", path.join(" "));
        for ((label, ..), (cx, cy)) in points.iter().zip(&places) {
            let _ = writeln!(svg, "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"3.5\" fill=\"{color}\"/>");
            let place = label_place(label, (*cx, *cy), &dots, &labels);
            text(svg, (place.0, place.1 + 4.0), "start", &format!("font-size=\"10\" fill=\"{color}\""), label);
            labels.push(place);
        }
        let at = (WIDTH - 4.0, 12.0 + 14.0 * index as f64);
        text(svg, at, "end", &format!("fill=\"{color}\" font-weight=\"bold\""), &series.name);
    }
}

/// Whether a tick is worth its room: over several powers of ten only the powers are.
fn is_sparse(value: f64, axis: &Axis) -> bool {
    axis.end / axis.begin < 150.0 || (value.log10() - value.log10().round()).abs() < 1e-6
}

/// A group's colour: hues far apart for neighbours in the list.
fn color(group: &str, groups: &[&str]) -> String {
    let Some(index) = groups.iter().position(|known| *known == group).filter(|_| groups.len() > 1) else {
        return DOT.into();
    };
    let hue = (index as f64 * 137.508) % 360.0;
    format!("hsl({hue:.0},65%,{}%)", 38 + 12 * (index % 2))
}

fn draw(svg: &mut String, panel: &Panel, groups: &[&str]) {
    let Panel { dots, .. } = panel;
    let times = dots.iter().flat_map(|dot| [dot.x_quartiles[0], dot.x, dot.x_quartiles[1]]);
    let x = Axis::logarithmic(times, WIDTH);
    let y = Axis::linear(dots.iter().map(|dot| dot.y), HEIGHT);
    let place = |dot: &Dot| (x.place(dot.x), HEIGHT - y.place(dot.y));
    text(svg, (0.0, -10.0), "start", "font-size=\"13\" font-weight=\"bold\"", &panel.title);
    for (value, label) in x.ticks() {
        let at = x.place(value);
        line(svg, [(at, 0.0), (at, HEIGHT)], FAINT);
        text(svg, (at, HEIGHT + 15.0), "middle", "", &label);
    }
    for (value, label) in y.ticks() {
        let at = HEIGHT - y.place(value);
        line(svg, [(0.0, at), (WIDTH, at)], FAINT);
        text(svg, (-6.0, at + 4.0), "end", "", &label);
    }
    line(svg, [(0.0, 0.0), (0.0, HEIGHT)], INK);
    line(svg, [(0.0, HEIGHT), (WIDTH, HEIGHT)], INK);
    text(svg, (0.5 * WIDTH, HEIGHT + 32.0), "middle", "", &panel.x_label);
    let turned = format!("transform=\"rotate(-90 -46 {})\"", 0.5 * HEIGHT);
    text(svg, (-46.0, 0.5 * HEIGHT), "middle", &turned, &panel.y_label);

    let front = pareto(dots.iter().map(|dot| (dot.x, dot.y)));
    let points: Vec<String> =
        front.iter().map(|index| place(&dots[*index])).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{FRONT}\" stroke-width=\"1.5\"/>",
        points.join(" ")
    );
    let several = groups.len() > 1;
    let places: Vec<(f64, f64)> = dots.iter().map(place).collect();
    let mut labels: Vec<(f64, f64, f64)> = Vec::new();
    for (index, (dot, (cx, cy))) in dots.iter().zip(&places).enumerate() {
        let [low, high] = dot.x_quartiles.map(|ms| x.place(ms));
        let best = front.contains(&index);
        let color = if best && !several { FRONT.into() } else { color(&dot.group, groups) };
        if best || !several {
            line(svg, [(low, *cy), (high, *cy)], &color);
        }
        let radius = if several { 3 } else { 4 };
        let ring = if best && several { format!(" stroke=\"{FRONT}\" stroke-width=\"1.5\"") } else { String::new() };
        let _ = writeln!(
            svg,
            "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"{radius}\" fill=\"{color}\"{ring}><title>{}: {:.2} ms, {:.4}</title></circle>",
            escaped(&dot.label),
            dot.x,
            dot.y
        );
        if !several {
            let label = label_place(&dot.label, (*cx, *cy), &places, &labels);
            text(svg, (label.0, label.1 + 4.0), "start", "", &dot.label);
            labels.push(label);
        }
    }
}

/// Where a label is free of dots and of other labels: left end, middle height and width.
fn label_place(label: &str, (x, y): (f64, f64), dots: &[(f64, f64)], labels: &[(f64, f64, f64)]) -> (f64, f64, f64) {
    let width = 6.2 * label.chars().count() as f64;
    let around =
        [(-0.5 * width, -13.0), (8.0, 0.0), (-8.0 - width, 0.0), (-0.5 * width, 13.0), (8.0, -12.0), (8.0, 12.0)];
    let places = around.map(|(dx, dy)| (x + dx, y + dy, width));
    let is_free = |(left, middle, width): &(f64, f64, f64)| {
        let inside = *left >= -40.0 && left + width <= WIDTH + RIGHT && (4.0..HEIGHT - 4.0).contains(middle);
        let dot = dots.iter().any(|(x, y)| x + 5.0 > *left && x - 5.0 < left + width && (y - middle).abs() < 9.0);
        let other = labels.iter().any(|(l, m, w)| l + w > *left && *l < left + width && (m - middle).abs() < 11.0);
        inside && !dot && !other
    };
    places.into_iter().find(is_free).unwrap_or(places[0])
}

/// A scale from values to pixels.
struct Axis {
    begin: f64,
    end: f64,
    length: f64,
    logarithmic: bool,
}

impl Axis {
    /// Linear from 0, for errors.
    fn linear(values: impl Iterator<Item = f64>, length: f64) -> Self {
        let largest = values.filter(|value| value.is_finite()).fold(0.0, f64::max);
        let largest = if largest > 0.0 { largest } else { 1.0 };
        Self { begin: 0.0, end: 1.08 * largest, length, logarithmic: false }
    }

    /// Logarithmic with room on both sides, for times: variants may be a hundred times apart.
    fn logarithmic(values: impl Iterator<Item = f64>, length: f64) -> Self {
        let (low, high) = values
            .filter(|value| value.is_finite() && *value > 0.0)
            .fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if low <= high { (low, high) } else { (1.0, 1.0) };
        let room = 1.2 * (high / low).powf(0.08);
        Self { begin: low / room, end: high * room, length, logarithmic: true }
    }

    fn place(&self, value: f64) -> f64 {
        let share = if self.logarithmic {
            (value.max(self.begin) / self.begin).ln() / (self.end / self.begin).ln()
        } else {
            (value - self.begin) / (self.end - self.begin)
        };
        share * self.length
    }

    /// Round values with their labels.
    fn ticks(&self) -> Vec<(f64, String)> {
        if self.logarithmic {
            let powers = self.begin.log10().floor() as i32..=self.end.log10().ceil() as i32;
            let round = powers.flat_map(|power| [1.0, 2.0, 5.0].map(|factor| factor * 10_f64.powi(power)));
            return round.filter(|v| (self.begin..=self.end).contains(v)).map(|v| (v, label(v, v))).collect();
        }
        // Some five, at 1, 2 or 5 times a power of ten.
        let raw = self.end / 1.08 / 5.0;
        let power = 10_f64.powf(raw.log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
        let step = steps.into_iter().find(|step| *step >= raw).unwrap_or(raw);
        let count = (self.end / step) as usize;
        (0..=count).map(|index| index as f64 * step).map(|value| (value, label(value, step))).collect()
    }
}

/// A number with the digits that a step of this size needs.
fn label(value: f64, step: f64) -> String {
    let digits = (-step.log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}

fn line(svg: &mut String, [(x1, y1), (x2, y2)]: [(f64, f64); 2], color: &str) {
    let _ = writeln!(svg, "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{color}\"/>");
}

fn text(svg: &mut String, (x, y): (f64, f64), anchor: &str, attributes: &str, content: &str) {
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" {attributes}>{}</text>",
        escaped(content)
    );
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::study;

    #[test]
    fn the_front_leaves_out_what_another_beats() {
        let study = study();
        let rows: Vec<&Row> = study.rows.iter().filter(|row| row.scene == "one").collect();
        let front = pareto(rows.iter().map(|row| (row.gpu_ms, row.flip_mean)));
        let front: Vec<&str> = front.into_iter().map(|index| rows[index].variant.as_str()).collect();
        assert_eq!(front, ["a, cheap", "b"]);
    }

    #[test]
    fn ticks_are_round_and_cover_the_values() {
        let text = |axis: Axis| axis.ticks().into_iter().map(|tick| tick.1).collect::<Vec<_>>().join(" ");
        let labels = |values: &[f64]| text(Axis::linear(values.iter().copied(), 100.0));
        let times = |values: &[f64]| text(Axis::logarithmic(values.iter().copied(), 100.0));
        assert_eq!(labels(&[9.5, 3.0]), "0 2 4 6 8 10");
        assert_eq!(labels(&[0.012]), "0.000 0.005 0.010");
        assert_eq!(labels(&[f64::NAN]), "0.0 0.2 0.4 0.6 0.8 1.0");
        assert_eq!(times(&[9.0, 120.0]), "10 20 50 100");
        assert_eq!(times(&[0.0, f64::NAN]), "1");
    }

    #[test]
    fn the_chart_has_a_panel_for_each_scene_and_a_dot_for_each_row() {
        let mut study = study();
        study.rows[0].variant = "<&>".into();
        let svg = cost_and_error(&study);
        assert_eq!((svg.matches("<g ").count(), svg.matches("<circle ").count()), (2, 4));
        assert!(svg.contains("&lt;&amp;&gt;") && !svg.contains("<&>") && !svg.contains("NaN"));
    }
}
