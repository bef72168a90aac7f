//! Line charts side by side, as one self-contained SVG.

use std::fmt::Write;

use crate::Row;

/// What one chart shows.
pub(crate) struct Panel {
    pub(crate) sweep: &'static str,
    pub(crate) title: &'static str,
    pub(crate) x: &'static str,
    pub(crate) y: &'static str,
    pub(crate) scales: [Scale; 2],
    /// Smaller values are drawn here.
    pub(crate) floor: f64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scale {
    Linear,
    Logarithmic,
}

const WIDTH: f64 = 300.0;
const HEIGHT: f64 = 200.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 40.0;
/// Room for a legend below.
const BOTTOM: f64 = 100.0;
const HEAD: f64 = 40.0;
const COLUMNS: usize = 3;
const COLORS: [&str; 6] = ["#2a6fb0", "#d1495b", "#3a9d5d", "#b07a2a", "#7a4fb0", "#555555"];

/// All panels. Values that are not finite are crosses on the upper edge: there it broke.
pub(crate) fn draw(title: &str, panels: &[Panel], rows: &[Row]) -> String {
    let lines = panels.len().div_ceil(COLUMNS);
    let (cell_width, cell_height) = (LEFT + WIDTH + RIGHT, TOP + HEIGHT + BOTTOM);
    let (width, height) = (cell_width * COLUMNS as f64, HEAD + cell_height * lines as f64);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"11\" fill=\"#222\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
    );
    label(&mut svg, 14.0, 25.0, "start", "font-size=\"15\" font-weight=\"bold\"", title);
    for (index, panel) in panels.iter().enumerate() {
        let (x, y) =
            (cell_width * (index % COLUMNS) as f64 + LEFT, HEAD + cell_height * (index / COLUMNS) as f64 + TOP);
        let _ = writeln!(svg, "<g transform=\"translate({x:.1},{y:.1})\">");
        draw_panel(&mut svg, panel, rows);
        svg.push_str("</g>\n");
    }
    svg.push_str("</svg>\n");
    svg
}

fn draw_panel(svg: &mut String, panel: &Panel, rows: &[Row]) {
    let rows: Vec<&Row> = rows.iter().filter(|row| row.sweep == panel.sweep).collect();
    let clamped = |row: &Row| row.y.max(panel.floor);
    let x = Axis::new(panel.scales[0], rows.iter().map(|row| row.x), WIDTH);
    let y = Axis::new(panel.scales[1], rows.iter().map(|row| clamped(row)).filter(|y| y.is_finite()), HEIGHT);
    label(svg, 0.0, -12.0, "start", "font-size=\"13\" font-weight=\"bold\"", panel.title);
    for (value, name) in x.ticks() {
        let at = x.place(value);
        line(svg, at, 0.0, at, HEIGHT, "#ddd");
        label(svg, at, HEIGHT + 15.0, "middle", "", &name);
    }
    for (value, name) in y.ticks() {
        let at = HEIGHT - y.place(value);
        line(svg, 0.0, at, WIDTH, at, "#ddd");
        label(svg, -6.0, at + 4.0, "end", "", &name);
    }
    line(svg, 0.0, 0.0, 0.0, HEIGHT, "#222");
    line(svg, 0.0, HEIGHT, WIDTH, HEIGHT, "#222");
    label(svg, 0.5 * WIDTH, HEIGHT + 31.0, "middle", "", panel.x);
    label(svg, -52.0, 0.5 * HEIGHT, "middle", &format!("transform=\"rotate(-90 -52 {})\"", 0.5 * HEIGHT), panel.y);
    let mut variants: Vec<&str> = Vec::new();
    for row in &rows {
        if !variants.contains(&row.variant.as_str()) {
            variants.push(&row.variant);
        }
    }
    for (index, variant) in variants.iter().enumerate() {
        let color = COLORS[index % COLORS.len()];
        let mut points = String::new();
        for row in rows.iter().filter(|row| row.variant == *variant) {
            let at = x.place(row.x);
            if row.y.is_finite() {
                let height = HEIGHT - y.place(clamped(row));
                let _ = write!(points, "{at:.1},{height:.1} ");
                let _ = writeln!(svg, "<circle cx=\"{at:.1}\" cy=\"{height:.1}\" r=\"2.5\" fill=\"{color}\"/>");
            } else {
                let shift = 3.0 * index as f64;
                label(svg, at, 5.0 + shift, "middle", &format!("fill=\"{color}\" font-weight=\"bold\""), "×");
            }
        }
        let _ = writeln!(svg, "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\"/>", points.trim_end());
        let (column, row) = (index % 2, index / 2);
        let (left, top) = (150.0 * column as f64, HEIGHT + 49.0 + 14.0 * row as f64);
        line(svg, left, top - 4.0, left + 14.0, top - 4.0, color);
        label(svg, left + 18.0, top, "start", "", variant);
    }
}

struct Axis {
    scale: Scale,
    begin: f64,
    end: f64,
    length: f64,
}

impl Axis {
    fn new(scale: Scale, values: impl Iterator<Item = f64>, length: f64) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (1.0, 10.0) };
        let (begin, end) = match scale {
            Scale::Linear => (0.0, 1.08 * high.max(1e-9)),
            Scale::Logarithmic => (low / 1.3, high * 1.3),
        };
        Self { scale, begin, end, length }
    }

    fn place(&self, value: f64) -> f64 {
        self.length
            * match self.scale {
                Scale::Linear => value / self.end,
                Scale::Logarithmic => (value.max(self.begin) / self.begin).ln() / (self.end / self.begin).ln(),
            }
    }

    fn ticks(&self) -> Vec<(f64, String)> {
        match self.scale {
            Scale::Linear => {
                // Four or five, of round numbers.
                let step = 10_f64.powf((0.3 * self.end).log10().floor()) * if self.end > 50.0 { 2.5 } else { 2.0 };
                let digits = (-step.log10().floor()).max(0.0) as usize;
                (0..=5)
                    .map(|i| step * f64::from(i))
                    .filter(|v| *v <= self.end)
                    .map(|v| (v, format!("{v:.digits$}")))
                    .collect()
            }
            Scale::Logarithmic => {
                let powers = self.begin.log10().floor() as i32..=self.end.log10().ceil() as i32;
                let decades = (self.end / self.begin).log10();
                let factors: &[f64] = if decades < 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
                let every = if decades > 7.0 { 2 } else { 1 };
                powers
                    .filter(|power| power % every == 0)
                    .flat_map(|power| factors.iter().map(move |factor| factor * 10_f64.powi(power)))
                    .filter(|value| (self.begin..=self.end).contains(value))
                    .map(|value| {
                        let digits = (-value.log10().floor()).max(0.0) as usize;
                        (value, format!("{value:.digits$}"))
                    })
                    .collect()
            }
        }
    }
}

fn line(svg: &mut String, x1: f64, y1: f64, x2: f64, y2: f64, color: &str) {
    let _ = writeln!(svg, "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{color}\"/>");
}

fn label(svg: &mut String, x: f64, y: f64, anchor: &str, attributes: &str, text: &str) {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" {attributes}>{text}</text>");
}
