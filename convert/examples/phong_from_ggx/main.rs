//! Measures how well a Phong lobe stands in for GGX, and redraws `docs/techniques/phong-from-ggx.{csv,svg}`
//! and the table of the page.
//!
//! `cargo run -p aam-convert --example phong_from_ggx [FOLDER]`

mod chart;
mod fit;
mod lobe;

use std::fmt::Write as _;
use std::path::PathBuf;

use lobe::{CANDIDATES, Incidence, SURFACES};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args_os()
        .nth(1)
        .map_or_else(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/techniques")), PathBuf::from);
    let incidences = Incidence::all();
    let mut rows = Vec::new();
    for surface in &SURFACES {
        for step in 1..=20_u32 {
            let roughness = 0.05 * f64::from(step);
            let alpha = roughness * roughness;
            let truth_width = lobe::half_width_of_ggx(alpha, surface.f0);
            let mut push = |name: &'static str, lobe: lobe::Lobe| {
                let error = lobe::error(&incidences, surface, alpha, lobe);
                rows.push(Row {
                    surface: surface.name,
                    roughness,
                    candidate: name,
                    lobe,
                    error,
                    width: lobe::half_width_of(lobe) - truth_width,
                });
            };
            for (name, candidate) in CANDIDATES {
                push(name, candidate(alpha, surface.f0));
            }
            push("best possible", fit::optimum(&incidences, surface, alpha, lobe::chosen(alpha, surface.f0)).0);
        }
    }
    let mut csv = String::from(
        "surface,roughness,candidate,exponent,specular,diffuse_share,rms,rms_without_highlight,energy_error,half_width_error_deg\n",
    );
    for row in &rows {
        writeln!(
            csv,
            "{},{:.2},{},{:.3},{:.4},{:.4},{:.4},{:.4},{:.3},{:.2}",
            row.surface,
            row.roughness,
            row.candidate,
            row.lobe.exponent,
            row.lobe.specular,
            row.lobe.share,
            row.error.rms,
            row.error.without,
            row.error.energy,
            row.width
        )?;
    }
    std::fs::write(folder.join("phong-from-ggx.csv"), csv)?;
    std::fs::write(folder.join("phong-from-ggx.svg"), chart::draw(&rows))?;
    let page = folder.join("phong-from-ggx.md");
    let table = summary(&rows);
    match std::fs::read_to_string(&page) {
        Ok(text) => std::fs::write(&page, with_table(&text, &table).ok_or("the page has no place for the table")?)?,
        Err(_) => print!("{table}"),
    }
    print!("{}", choices(&incidences));
    Ok(())
}

/// The page with its table replaced.
fn with_table(page: &str, table: &str) -> Option<String> {
    let (before, rest) = page.split_once("<!-- table -->\n")?;
    let (_, after) = rest.split_once("<!-- end of table -->")?;
    Some(format!("{before}<!-- table -->\n{table}<!-- end of table -->{after}"))
}

/// One measured point.
struct Row {
    surface: &'static str,
    roughness: f64,
    candidate: &'static str,
    lobe: lobe::Lobe,
    error: lobe::Error,
    width: f64,
}

/// RMS over roughness, as the page's table.
fn summary(rows: &[Row]) -> String {
    let mut names: Vec<&str> = CANDIDATES.iter().map(|(name, _)| *name).collect();
    names.push("best possible");
    let mut table = String::from("| surface | no highlight |");
    names.iter().for_each(|name| table += &format!(" {name} |"));
    table += "\n|---|---|";
    names.iter().for_each(|_| table += "---|");
    table.push('\n');
    let rms = |of: &dyn Fn(&&Row) -> bool, value: fn(&Row) -> f64| {
        let chosen: Vec<f64> = rows.iter().filter(of).map(value).collect();
        (chosen.iter().map(|value| value * value).sum::<f64>() / chosen.len() as f64).sqrt()
    };
    let mut line = |title: &str, surface: &dyn Fn(&Row) -> bool| {
        let none = rms(&|row| surface(row), |row| row.error.without);
        table += &format!("| {title} | {none:.3} |");
        for name in &names {
            let of = |row: &&Row| surface(row) && row.candidate == *name;
            table += &format!(
                " {:.3} · {:.0} % · {:.0}° |",
                rms(&of, |row| row.error.rms),
                100.0 * rms(&of, |row| row.error.energy),
                rms(&of, |row| row.width)
            );
        }
        table.push('\n');
    };
    for surface in &SURFACES {
        line(surface.name, &|row| row.surface == surface.name);
    }
    line("all", &|_| true);
    table
}

/// The figures behind the smaller choices.
fn choices(incidences: &[Incidence]) -> String {
    let roughnesses = || (1..=20_u32).map(|step| 0.05 * f64::from(step));
    let rms = |values: Vec<f64>| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
    let mut text = String::from("\nmetals (all three), RMS over roughness:\n");
    for (name, keep) in [("with the diffuse share", true), ("without", false)] {
        let values = roughnesses()
            .flat_map(|roughness| SURFACES[1..].iter().map(move |surface| (roughness, surface)))
            .map(|(roughness, surface)| {
                let alpha = roughness * roughness;
                let mut lobe = lobe::chosen(alpha, surface.f0);
                if !keep {
                    lobe.share = 0.0;
                }
                lobe::error(incidences, surface, alpha, lobe).rms
            })
            .collect();
        text += &format!("  {name}: {:.3}\n", rms(values));
    }
    text += "\ngold (1.00 0.77 0.34), RMS over channels and roughness:\n";
    let gold = [1.0, 0.77, 0.34];
    for (name, hue) in [("hue kept", true), ("each channel clipped", false)] {
        let values = roughnesses()
            .flat_map(|roughness| gold.map(|f0| (roughness, f0)))
            .map(|(roughness, f0)| {
                let alpha = roughness * roughness;
                let strongest = lobe::chosen(alpha, 1.0);
                let specular = if hue {
                    lobe::encode(f0 * lobe::decode(strongest.specular))
                } else {
                    lobe::chosen(alpha, f0).specular
                };
                let lobe = lobe::Lobe { specular, exponent: strongest.exponent, share: f0 * strongest.share };
                let surface = lobe::Surface { name: "gold", f0, bases: &[0.0] };
                lobe::error(incidences, &surface, alpha, lobe).rms
            })
            .collect();
        text += &format!("  {name}: {:.3}\n", rms(values));
    }
    text += "\nambient against GGX's albedo under uniform light, mean over incidences and roughness, linear:\n";
    for surface in &SURFACES {
        let (mut mean, mut count) = (0.0, 0.0);
        for roughness in roughnesses() {
            for incidence in incidences {
                mean += incidence.albedo(roughness * roughness, surface.f0);
                count += 1.0;
            }
        }
        text += &format!("  {}: GGX {:.3}, mapped {:.3}\n", surface.name, mean / count, surface.f0);
    }
    text
}
