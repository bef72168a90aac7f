//! Measures displacement and draws its charts:
//! `cargo run --release -p aam-lab --example displacement -- docs/techniques FILE…`
//! writes `displacement.csv` and `displacement.svg`.

use std::path::{Path, PathBuf};

use aam_lab::{Subject, displacement, load};
use aam_renderer::{Gpu, Renderer};
use aam_scene::View;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let folder = arguments.next().ok_or("usage: displacement FOLDER FILE…")?;
    let files: Vec<PathBuf> = arguments.map(PathBuf::from).collect();
    let mut renderer = Renderer::new(Gpu::headless()?);
    let machine = renderer.gpu().summary().to_string();
    let mut rows = Vec::new();
    for path in &files {
        let (scene, camera) = load(path)?;
        let camera = camera.unwrap_or_else(|| scene.fitting_camera(4.0 / 3.0));
        let name = path.file_stem().unwrap_or_default().to_string_lossy().trim_end_matches(".scene").to_owned();
        let subject = Subject { name, scene, view: View { camera, width: 1024, height: 768, frame: 0.0 } };
        rows.extend(displacement::measure(&subject, &mut renderer, &mut |what| eprintln!("{what}"))?);
    }
    let folder = Path::new(&folder);
    std::fs::write(folder.join("displacement.csv"), displacement::to_csv(&machine, &rows))?;
    std::fs::write(folder.join("displacement.svg"), displacement::to_svg(&machine, &rows))?;
    Ok(())
}
