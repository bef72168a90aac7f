//! The chart.

use crate::Row;

const WIDTH: f64 = 300.0;
const HEIGHT: f64 = 220.0;
const GAP: f64 = 70.0;
const COLORS: [(&str, &str); 5] = [
    ("half-vector 2/α²−2", "#b0413e"),
    ("quarter of it", "#d98c2b"),
    ("displayed half width", "#7b6fb0"),
    ("chosen", "#1b6ca8"),
    ("best possible", "#777777"),
];

/// Three panels over roughness: error of dielectrics, error of metals, exponents.
pub(crate) fn draw(rows: &[Row]) -> String {
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0} {:.0}\" font-family=\"sans-serif\" \
         font-size=\"11\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        3.0 * (WIDTH + GAP) + 20.0,
        HEIGHT + 110.0
    );
    let of = |surface: &'static str| move |row: &&Row| row.surface == surface;
    let dielectric: Vec<&Row> = rows.iter().filter(of("dielectric 0.04")).collect();
    let metal: Vec<&Row> = rows.iter().filter(of("metal 0.95")).collect();
    panel(&mut svg, 0, "dielectric (F = 0.04): RMS error, display values", &dielectric, 0.1, |row| row.error.rms);
    panel(&mut svg, 1, "metal (F = 0.95): RMS error, display values", &metal, 0.6, |row| row.error.rms);
    // log₁₀ of the exponent, 0.1 … 10 000.
    panel(&mut svg, 2, "dielectric: exponent, log₁₀ + 1", &dielectric, 5.0, |row| {
        (row.lobe.exponent.max(0.1).log10() + 1.0).min(5.0)
    });
    for (index, (name, color)) in COLORS.iter().enumerate() {
        let x = 50.0 + 190.0 * index as f64;
        let y = HEIGHT + 92.0;
        svg += &format!(
            "<line x1=\"{x:.0}\" y1=\"{y:.0}\" x2=\"{:.0}\" y2=\"{y:.0}\" stroke=\"{color}\" stroke-width=\"2\"{}/>\
             <text x=\"{:.0}\" y=\"{:.0}\">{name}</text>\n",
            x + 24.0,
            dash(name),
            x + 30.0,
            y + 4.0
        );
    }
    svg += "</svg>\n";
    svg
}

fn dash(name: &str) -> &'static str {
    if name == "best possible" { " stroke-dasharray=\"4 3\"" } else { "" }
}

fn panel(svg: &mut String, index: usize, title: &str, rows: &[&Row], top: f64, value: impl Fn(&Row) -> f64) {
    let left = 50.0 + index as f64 * (WIDTH + GAP);
    let bottom = HEIGHT + 40.0;
    let at = |roughness: f64, value: f64| (left + WIDTH * roughness, bottom - HEIGHT * (value / top).min(1.0));
    *svg += &format!("<text x=\"{left:.0}\" y=\"25\" font-weight=\"bold\">{title}</text>\n");
    for step in 0..=5 {
        let part = f64::from(step) / 5.0;
        let y = bottom - HEIGHT * part;
        let x = left + WIDTH * part;
        *svg += &format!(
            "<line x1=\"{left:.0}\" y1=\"{y:.1}\" x2=\"{:.0}\" y2=\"{y:.1}\" stroke=\"#ddd\"/>\
             <text x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\
             <text x=\"{x:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{part:.1}</text>\n",
            left + WIDTH,
            left - 5.0,
            y + 4.0,
            (100.0 * top * part).round() / 100.0,
            bottom + 16.0
        );
    }
    *svg += &format!(
        "<text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">roughness</text>\n",
        left + 0.5 * WIDTH,
        bottom + 32.0
    );
    for (name, color) in COLORS {
        let points: Vec<String> = rows
            .iter()
            .filter(|row| row.candidate == name)
            .map(|row| {
                let (x, y) = at(row.roughness, value(row));
                format!("{x:.1},{y:.1}")
            })
            .collect();
        *svg += &format!(
            "<polyline fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"{} points=\"{}\"/>\n",
            dash(name),
            points.join(" ")
        );
    }
}
