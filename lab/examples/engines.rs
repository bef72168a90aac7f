//! Draws files with the renderer and with the reference, and says how far apart the pictures are:
//! `cargo run -p aam-lab --example engines -- SAMPLES OUTPUT_FOLDER FILE…`
//!
//! With 1 sample both sample the middle of each pixel; otherwise the renderer takes 4 and the reference so many.

use std::path::{Path, PathBuf};

use aam_lab::metrics::{PIXELS_PER_DEGREE, difference, difference_picture, flip};
use aam_lab::{LabError, load, save_png};
use aam_reference::Options;
use aam_renderer::{Gpu, Msaa, RenderOptions, Renderer};
use aam_scene::View;

fn main() -> Result<(), LabError> {
    let mut arguments = std::env::args_os().skip(1);
    let samples = arguments.next().and_then(|text| text.to_str()?.parse().ok());
    let (Some(samples), Some(folder)) = (samples, arguments.next()) else {
        eprintln!("usage: engines SAMPLES OUTPUT_FOLDER FILE…");
        return Ok(());
    };
    let msaa = if samples == 1 { Msaa::X1 } else { Msaa::X4 };
    let mut renderer = Renderer::new(Gpu::headless()?);
    println!("{:32} {:>8} {:>8} {:>8} {:>9} {:>4}", "file", "FLIP", "p95", "p99", "over 24", "max");
    for path in arguments.map(PathBuf::from) {
        let (mut scene, camera) = load(&path)?;
        scene.shadows = None;
        let view = View {
            camera: camera.unwrap_or_else(|| scene.fitting_camera(4.0 / 3.0)),
            width: 640,
            height: 480,
            frame: 0.0,
        };
        let (drawn, _) =
            renderer.render_to_image(&scene, &view, &RenderOptions { msaa, ..RenderOptions::default() })?;
        let (reference, _) =
            aam_reference::render(&scene, &view, &Options { samples_per_pixel: samples, ..Options::default() })?;
        let map = flip(&reference, &drawn, PIXELS_PER_DEGREE)?;
        let apart = difference(&reference, &drawn)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        println!(
            "{name:32} {:8.4} {:8.4} {:8.4} {:8.3}% {:4}",
            map.mean(),
            map.percentile(0.95),
            map.percentile(0.99),
            100.0 * apart.outliers(24),
            apart.max
        );
        let save = |what: &str, image| save_png(image, &Path::new(&folder).join(format!("{name}.{what}.png")));
        save("gpu", &drawn)?;
        save("reference", &reference)?;
        save("difference", &difference_picture(&reference, &drawn, 48)?)?;
    }
    Ok(())
}
