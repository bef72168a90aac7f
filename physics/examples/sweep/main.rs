//! Sweeps simulations until they break, and charts where: `cargo run --release -p aam-physics --example sweep -- FOLDER`
//! writes `rigid-bodies.csv` and `rigid-bodies.svg`. With `--draw` it only draws the numbers again. Arguments that end in
//! `.json` are reports of `aam tune --physics --json`, which take the place of those that were there.

mod chart;
mod hulls;
mod laws;
mod scenes;
#[path = "../../tests/common/mod.rs"]
mod stage;

use std::path::Path;

use chart::{Panel, Scale};

/// One measured value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Row {
    /// Which sweep.
    pub(crate) sweep: String,
    /// Which line of its chart.
    pub(crate) variant: String,
    /// The parameter.
    pub(crate) x: f64,
    /// What was measured; infinite where the simulation was stopped or came apart.
    pub(crate) y: f64,
}

const HEADER: &str = "sweep,variant,parameter,value";

const PANELS: &[Panel] = &[
    Panel {
        sweep: "step",
        title: "Error against step length",
        x: "step, s",
        y: "error, %",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1e-3,
    },
    Panel {
        sweep: "step-cost",
        title: "Cost against step length",
        x: "step, s",
        y: "ms a simulated second",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1e-3,
    },
    Panel {
        sweep: "iterations",
        title: "Error against solver iterations",
        x: "iterations a step",
        y: "error, % of a box",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1e-3,
    },
    Panel {
        sweep: "iterations-cost",
        title: "Cost against solver iterations",
        x: "iterations a step",
        y: "ms a simulated second",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1e-3,
    },
    Panel {
        sweep: "restitution",
        title: "Bounce against restitution e",
        x: "restitution e",
        y: "height off e² h, % of h",
        scales: [Scale::Linear, Scale::Logarithmic],
        floor: 1e-2,
    },
    Panel {
        sweep: "friction",
        title: "Sliding distance against friction μ",
        x: "friction μ",
        y: "off v² / 2 μ g, %",
        scales: [Scale::Linear, Scale::Logarithmic],
        floor: 1e-2,
    },
    Panel {
        sweep: "slope",
        title: "Critical slope against friction μ",
        x: "friction μ",
        y: "off atan μ, degrees",
        scales: [Scale::Linear, Scale::Logarithmic],
        floor: 1e-2,
    },
    Panel {
        sweep: "spin",
        title: "A body tumbling for 20 s (Dzhanibekov)",
        x: "step, s",
        y: "change, % or degrees",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1e-3,
    },
    Panel {
        sweep: "stack",
        title: "A stack of boxes after 10 s",
        x: "boxes",
        y: "top box off its place, % of a box",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1e-2,
    },
    Panel {
        sweep: "stack-step",
        title: "Ten boxes against step length",
        x: "step, s",
        y: "top box off its place, % of a box",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1e-2,
    },
    Panel {
        sweep: "mass",
        title: "A heavy box on a light one",
        x: "mass ratio",
        y: "heavy box off its place, % of a box",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1e-2,
    },
    Panel {
        sweep: "chain",
        title: "A heavy ball on a light chain",
        x: "mass ratio",
        y: "chain longer by, %",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1e-3,
    },
    Panel {
        sweep: "bullet",
        title: "Bullets against thin plates",
        x: "speed, m/s",
        y: "bullets that pass, %",
        scales: [Scale::Logarithmic, Scale::Linear],
        floor: 0.0,
    },
    Panel {
        sweep: "scale",
        title: "Five boxes at all sizes",
        x: "size of a box, m",
        y: "top box off its place, % of a box",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1e-2,
    },
    Panel {
        sweep: "many",
        title: "Many boxes falling in a heap",
        x: "boxes",
        y: "ms a step of 1/60 s",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1e-3,
    },
    Panel {
        sweep: "hulls-path",
        title: "Path of a dropped object, after its touch",
        x: "hulls",
        y: "off that of its surface, % of the diagonal",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1e-2,
    },
    Panel {
        sweep: "hulls-rest",
        title: "An object placed where its surface rests",
        x: "hulls",
        y: "moves within 1 s, % of the diagonal",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1e-2,
    },
    Panel {
        sweep: "hulls-jitter",
        title: "Jitter there, in the last half second",
        x: "hulls",
        y: "% of the diagonal a second",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1e-3,
    },
    Panel {
        sweep: "hulls-cost",
        title: "Cost of a step with one object",
        x: "hulls",
        y: "µs a step of 1/240 s",
        scales: [Scale::Logarithmic, Scale::Logarithmic],
        floor: 1.0,
    },
];

fn main() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (reports, others): (Vec<&String>, Vec<&String>) = arguments.iter().partition(|word| word.ends_with(".json"));
    let folder = others.iter().find(|word| !word.starts_with("--")).ok_or("say into which folder")?;
    let (csv, svg) = (Path::new(folder).join("rigid-bodies.csv"), Path::new(folder).join("rigid-bodies.svg"));
    let fail = |path: &Path, error: std::io::Error| format!("{}: {error}", path.display());
    let before = std::fs::read_to_string(&csv);
    let mut rows = if others.iter().any(|word| *word == "--draw") {
        read(&before.map_err(|error| fail(&csv, error))?)?
    } else {
        // Reports are not measured here, and stay.
        let reported = before.ok().map(|text| read(&text)).transpose()?.unwrap_or_default();
        let mut rows = measure();
        rows.extend(reported.into_iter().filter(|row| row.sweep.starts_with("hulls-")));
        rows
    };
    if !reports.is_empty() {
        rows.retain(|row| !row.sweep.starts_with("hulls-"));
        for report in reports {
            rows.extend(hulls::rows(Path::new(report))?);
        }
    }
    std::fs::write(&csv, text(&rows)).map_err(|error| fail(&csv, error))?;
    std::fs::write(&svg, chart::draw("Rigid bodies: error, cost, and where they break", PANELS, &rows))
        .map_err(|error| fail(&svg, error))
}

fn measure() -> Vec<Row> {
    let mut rows = Vec::new();
    let mut add = |sweep: &str, variant: &str, x: f64, y: f64| {
        println!("{sweep}, {variant}, {x}: {y:.5}");
        // A comma would end the column.
        rows.push(Row { sweep: sweep.into(), variant: variant.replace(", ", " · "), x, y });
    };
    scenes::steps(&mut add);
    laws::restitution(&mut add);
    laws::friction(&mut add);
    laws::spin(&mut add);
    scenes::iterations(&mut add);
    scenes::stacks(&mut add);
    scenes::masses(&mut add);
    scenes::bullets(&mut add);
    scenes::scales(&mut add);
    scenes::many(&mut add);
    rows
}

fn text(rows: &[Row]) -> String {
    let lines = rows.iter().map(|row| format!("{},{},{},{:.5}\n", row.sweep, row.variant, row.x as f32, row.y));
    format!("{HEADER}\n{}", lines.collect::<String>())
}

fn read(text: &str) -> Result<Vec<Row>, String> {
    let row = |(number, line): (usize, &str)| {
        let wrong = || format!("line {}: expected {HEADER}", number + 2);
        let [sweep, variant, x, y] = line.split(',').collect::<Vec<_>>().try_into().map_err(|_| wrong())?;
        let number = |word: &str| word.parse::<f64>().map_err(|_| wrong());
        Ok(Row { sweep: sweep.into(), variant: variant.into(), x: number(x)?, y: number(y)? })
    };
    text.lines().skip(1).enumerate().map(row).collect()
}
