//! Cuts a mesh into convex pieces and says how near they are, beside those of other programs:
//! `cargo run --release -p aam-convert --example decompose -- [--hulls N] [--max-error E] MESH [HULLS.obj …]`
//!
//! A file of hulls has one object for each. All are measured alike; columns are in % of the bounding box's diagonal.

use std::path::Path;
use std::time::Instant;

use aam_convert::hulls::{Hull, HullOptions, decompose, measure};
use aam_convert::{ImportOptions, Silent, import};

type Error = Box<dyn std::error::Error>;

fn main() -> Result<(), Error> {
    const USAGE: &str = "usage: decompose [--hulls N] [--max-error E] MESH [HULLS.obj …]";
    let mut options = HullOptions::default();
    let (mut hulls, mut error, mut files) = (None, None, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--hulls" => hulls = Some(arguments.next().ok_or(USAGE)?.parse()?),
            "--max-error" => error = Some(arguments.next().ok_or(USAGE)?.parse()?),
            _ => files.push(argument),
        }
    }
    let (mesh, peers) = files.split_first().ok_or(USAGE)?;
    options.max_error = error.or(options.max_error.filter(|_| hulls.is_none()));
    options.max_hulls = hulls.unwrap_or(options.max_hulls);

    // One mesh of all objects.
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for part in parts(Path::new(mesh))? {
        let base = vertices.len() as u32;
        vertices.extend(part.vertices);
        triangles.extend(part.triangles.iter().map(|triangle| triangle.map(|index| index + base)));
    }
    println!("{:<32} {:>5} {:>5} {:>8} {:>7} {:>9} {:>7}", "", "hulls", "most", "outside", "mean", "uncovered", "s");
    let row = |name: &str, hulls: &[Hull], seconds: String| -> Result<(), Error> {
        let quality = measure(&vertices, &triangles, hulls)?;
        let most = hulls.iter().map(|hull| hull.vertices.len()).max().unwrap_or(0);
        let [outside, mean, uncovered] = [quality.outside, quality.mean, quality.uncovered].map(|each| 100.0 * each);
        println!("{name:<32} {:>5} {most:>5} {outside:8.2} {mean:7.3} {uncovered:9.3} {seconds:>7}", hulls.len());
        Ok(())
    };
    let start = Instant::now();
    let found = decompose(&vertices, &triangles, &options)?;
    row(mesh, &found.hulls, format!("{:.2}", start.elapsed().as_secs_f64()))?;
    for peer in peers {
        row(peer, &parts(Path::new(peer))?, "–".into())?;
    }
    Ok(())
}

/// Each object of a file.
fn parts(path: &Path) -> Result<Vec<Hull>, Error> {
    let asset = import(path, &ImportOptions::default(), &Silent)?;
    let parts = asset.document.objects().iter().map(|object| Hull {
        vertices: object.vertices.clone(),
        triangles: object.faces.iter().flat_map(|faces| &faces.triangles).map(|triangle| triangle.vertices).collect(),
        volume: 0.0,
    });
    Ok(parts.filter(|part| !part.triangles.is_empty()).collect())
}
