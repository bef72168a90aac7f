//! Charts: a panel for each mesh, the error to the right of the number of hulls or of the time.

use std::fmt::Write;

use crate::table::{Row, meshes};

const WIDTH: f64 = 230.0;
const HEIGHT: f64 = 170.0;
const LEFT: f64 = 44.0;
const TOP: f64 = 70.0;
/// From the left of a panel to the left of the next, and likewise down.
const ACROSS: f64 = 300.0;
const DOWN: f64 = 240.0;
const COLUMNS: usize = 4;

/// Programs by the first letters of their names, their colours and names.
const PROGRAMS: [(&str, &str, &str); 4] = [
    ("aam", "#d1495b", "aam"),
    ("coacd", "#2a6fb0", "CoACD"),
    ("vhacd", "#7a8b3c", "V-HACD"),
    ("parry", "#8d5a9e", "parry3d"),
];

/// File names and contents.
pub(crate) fn charts(rows: &[Row]) -> [(&'static str, String); 2] {
    [
        ("decomposition-hulls.svg", chart(rows, "hulls", |row| row.hulls as f64)),
        ("decomposition-time.svg", chart(rows, "processor time, s", |row| row.seconds.max(0.01))),
    ]
}

fn chart(rows: &[Row], label: &str, cost: fn(&Row) -> f64) -> String {
    let names = meshes(rows);
    let lines = names.len().div_ceil(COLUMNS) as f64;
    let (width, height) = (ACROSS * COLUMNS as f64, TOP + DOWN * lines);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"11\" fill=\"#222\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
    );
    let title =
        format!("Convex decomposition: Hausdorff distance, % of the diagonal, against {label} (both logarithmic)");
    text(&mut svg, LEFT, 24.0, "start", &format!("<tspan font-size=\"15\" font-weight=\"bold\">{title}</tspan>"));
    for (index, (_, color, name)) in PROGRAMS.iter().enumerate() {
        let x = LEFT + 90.0 * index as f64;
        let _ = writeln!(svg, "<circle cx=\"{x}\" cy=\"42\" r=\"4\" fill=\"{color}\"/>");
        text(&mut svg, x + 9.0, 46.0, "start", name);
    }
    for (index, name) in names.iter().enumerate() {
        let (x, y) = (LEFT + ACROSS * (index % COLUMNS) as f64, TOP + DOWN * (index / COLUMNS) as f64);
        let _ = writeln!(svg, "<g transform=\"translate({x},{y})\">");
        let of: Vec<&Row> = rows.iter().filter(|row| row.mesh == *name).collect();
        panel(&mut svg, name, &of, label, cost);
        svg.push_str("</g>\n");
    }
    svg.push_str("</svg>\n");
    svg
}

/// An error that is drawn for none.
const NONE: f64 = 0.02;

fn panel(svg: &mut String, title: &str, rows: &[&Row], label: &str, cost: fn(&Row) -> f64) {
    text(svg, 0.0, -6.0, "start", &format!("<tspan font-weight=\"bold\">{title}</tspan>"));
    let error = |row: &Row| row.hausdorff().max(NONE);
    let x = Scale::of(rows.iter().map(|row| cost(row)), WIDTH);
    let y = Scale::of(rows.iter().map(|row| error(row)), HEIGHT);
    for value in x.ticks() {
        let at = x.place(value);
        let _ = writeln!(svg, "<line x1=\"{at:.1}\" y1=\"0\" x2=\"{at:.1}\" y2=\"{HEIGHT}\" stroke=\"#ddd\"/>");
        text(svg, at, HEIGHT + 14.0, "middle", &value.to_string());
    }
    for value in y.ticks() {
        let at = HEIGHT - y.place(value);
        let _ = writeln!(svg, "<line x1=\"0\" y1=\"{at:.1}\" x2=\"{WIDTH}\" y2=\"{at:.1}\" stroke=\"#ddd\"/>");
        text(svg, -5.0, at + 4.0, "end", &if value <= NONE { "0".into() } else { value.to_string() });
    }
    let _ = writeln!(svg, "<path d=\"M0,0 V{HEIGHT} H{WIDTH}\" fill=\"none\" stroke=\"#222\"/>");
    text(svg, 0.5 * WIDTH, HEIGHT + 29.0, "middle", label);
    for (program, color, name) in PROGRAMS {
        let mut points: Vec<(f64, f64, &Row)> = rows
            .iter()
            .filter(|row| row.program.starts_with(program))
            .map(|row| (x.place(cost(row)), HEIGHT - y.place(error(row)), *row))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
        let line: Vec<String> = points.iter().map(|(x, y, _)| format!("{x:.1},{y:.1}")).collect();
        let _ =
            writeln!(svg, "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" opacity=\"0.5\"/>", line.join(" "));
        for (x, y, row) in points {
            let _ = writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{color}\"><title>{name}, {}: {} hulls, {:.2} %, {:.2} s</title></circle>",
                row.program,
                row.hulls,
                row.hausdorff(),
                row.seconds
            );
        }
    }
}

fn text(svg: &mut String, x: f64, y: f64, anchor: &str, content: &str) {
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{content}</text>");
}

/// A logarithmic scale.
struct Scale {
    begin: f64,
    end: f64,
    length: f64,
}

impl Scale {
    fn of(values: impl Iterator<Item = f64>, length: f64) -> Self {
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        Self { begin: low / 1.2, end: high * 1.2, length }
    }

    fn place(&self, value: f64) -> f64 {
        (value / self.begin).ln() / (self.end / self.begin).ln() * self.length
    }

    fn ticks(&self) -> Vec<f64> {
        let factors: &[f64] = if self.end / self.begin > 200.0 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let powers = -3..5;
        let all = powers.flat_map(|power| factors.iter().map(move |factor| factor * 10_f64.powi(power)));
        // 10⁻² as it is written, not as it is computed.
        let all = all.map(|value| (value * 1000.0).round() / 1000.0);
        all.filter(|value| (self.begin..=self.end).contains(value)).collect()
    }
}
