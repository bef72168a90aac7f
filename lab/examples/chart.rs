//! Measures a technique and draws its chart:
//! `cargo run --release -p aam-lab --example chart -- antialiasing docs/techniques FILE…`
//! writes `antialiasing.csv` and `antialiasing.svg`. Without files, only the chart is drawn again from the numbers.

use std::path::{Path, PathBuf};

use aam_lab::{LabError, Study, Subject, chart, load, report, technique, techniques};
use aam_renderer::{Gpu, Renderer};
use aam_scene::View;

/// Timed frames of each variant.
const FRAMES: usize = 31;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let (Some(name), Some(folder)) = (arguments.next(), arguments.next()) else {
        let names: Vec<&str> = techniques().iter().map(|technique| technique.name()).collect();
        return Err(format!("usage: chart TECHNIQUE FOLDER [FILE…]; techniques: {}", names.join(", ")).into());
    };
    let name = name.to_string_lossy();
    let technique = technique(&name).ok_or_else(|| format!("there is no technique {name:?}"))?;
    let files: Vec<PathBuf> = arguments.map(PathBuf::from).collect();
    let (table, picture) =
        (Path::new(&folder).join(format!("{name}.csv")), Path::new(&folder).join(format!("{name}.svg")));
    if !files.is_empty() {
        let subjects = files.iter().map(|path| subject(path)).collect::<Result<Vec<_>, _>>()?;
        let mut renderer = Renderer::new(Gpu::headless()?);
        let mut progress = |what: &str| eprintln!("{what}");
        let study = Study::run(technique.as_ref(), &subjects, &mut renderer, FRAMES, &mut progress)?;
        std::fs::write(&table, report::to_csv(&study))?;
    }
    let study = report::from_csv(&std::fs::read_to_string(&table)?)?;
    std::fs::write(&picture, chart::cost_and_error(&study))?;
    println!("{} {}", table.display(), picture.display());
    Ok(())
}

fn subject(path: &Path) -> Result<Subject, LabError> {
    let (mut scene, camera) = load(path)?;
    scene.shadows = None;
    let camera = camera.unwrap_or_else(|| scene.fitting_camera(4.0 / 3.0));
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name = stem.trim_end_matches(".scene").to_owned();
    Ok(Subject { name, scene, view: View { camera, width: 1024, height: 768, frame: 0.0 } })
}
