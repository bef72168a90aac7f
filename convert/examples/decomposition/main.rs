//! Convex decomposition beside other programs: what each leaves of error, and what it takes.
//!
//! 1. `… --example decomposition -- solids MESHES` writes the project's own solids as OBJ files; add others.
//! 2. `python convert/examples/decomposition/peers.py MESHES PEERS` runs CoACD and V-HACD on each.
//! 3. `… -- measure MESHES PEERS table.csv [NAME…]` runs ours and parry3d, and measures all alike.
//! 4. `… -- report table.csv FOLDER` prints the table and draws the charts.
//!
//! `…` is `cargo run --release -p aam-convert --example decomposition`.

mod chart;
mod programs;
mod table;

use std::path::Path;

use aam_fixtures::solids::SOLIDS;

type Error = Box<dyn std::error::Error>;

const USAGE: &str = "usage: decomposition solids MESHES
       decomposition measure MESHES PEERS table.csv [NAME…]
       decomposition report table.csv FOLDER";

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["solids", folder] => solids(Path::new(folder)),
        ["measure", meshes, peers, csv, ref names @ ..] => {
            let rows = programs::measure(Path::new(meshes), Path::new(peers), names)?;
            std::fs::write(csv, table::to_csv(&rows))?;
            Ok(())
        }
        ["report", csv, folder] => {
            let rows = table::from_csv(&std::fs::read_to_string(csv)?)?;
            print!("{}", table::to_markdown(&rows));
            for (name, svg) in chart::charts(&rows) {
                std::fs::write(Path::new(folder).join(name), svg)?;
            }
            Ok(())
        }
        _ => Err(USAGE.into()),
    }
}

fn solids(folder: &Path) -> Result<(), Error> {
    for solid in SOLIDS {
        let (vertices, triangles) = solid.triangles();
        let mut text = format!("# {}: {}\n", solid.name, solid.about);
        text.extend(vertices.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")));
        text.extend(triangles.iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)));
        std::fs::write(folder.join(format!("{}.obj", solid.name)), text)?;
    }
    Ok(())
}
