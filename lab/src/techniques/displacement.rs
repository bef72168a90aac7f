//! Displacement: triangles and GPU time against the distance from the limit surface, and against the picture of it.
//!
//! It is measured apart from the other techniques: its parameters are partly the scene's (tessellation factors), and its
//! error is a length as well as a difference of pictures.

use std::fmt::Write;
use std::sync::Arc;

use aam_renderer::{RenderOptions, Renderer};
use aam_scene::displacement::{Base, Detail, HeightMap, Plan, Surface, Viewer, classes, of_subset};
use aam_scene::{DisplacementMode, Scene};
use glam::Affine3A;

use crate::chart::{self, Series};
use crate::metrics::{PIXELS_PER_DEGREE, SurfaceError, flip, surface_error};
use crate::{LabError, Subject};

/// Tessellation factors to try.
pub const FACTORS: [u32; 10] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16];

/// Pixel errors of adaptive tessellation to try.
pub const PIXEL_ERRORS: [f32; 7] = [32.0, 16.0, 8.0, 4.0, 2.0, 1.0, 0.5];

/// The factor that stands for infinitely fine where pictures are compared.
const LIMIT: u32 = 64;

/// Parts of the lattice that distances are measured at, along each edge of the base mesh: a multiple of no factor, so that
/// the lattice is not where a tessellation is exact.
const LATTICE: u16 = 149;

/// Frames that times are the median of.
const FRAMES: usize = 11;

/// What one choice costs and gives on one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The scene.
    pub scene: String,
    /// `off`, `uniform` or `adaptive`.
    pub mode: &'static str,
    /// Tessellation factor or pixel error; 0 where there is none.
    pub parameter: f32,
    /// Triangles drawn.
    pub triangles: u64,
    /// GPU time of a frame in which nothing changes, in milliseconds.
    pub frame_ms: f64,
    /// GPU time of the pass that displaces all points, which a frame needs only after a change.
    pub displace_ms: f64,
    /// CPU time of preparing a frame after a change: tessellation and upload.
    pub prepare_ms: f64,
    /// Distance of the limit surface.
    pub distance: SurfaceError,
    /// Mean FLIP difference from the reference's picture of a tessellation by 64.
    pub flip: f64,
}

fn with_factor(scene: &Scene, factor: u32) -> Scene {
    let mut scene = scene.clone();
    for mesh in &mut scene.meshes {
        if mesh.displacement.is_some()
            && let Some(displacement) = &mut Arc::make_mut(mesh).displacement
        {
            displacement.tessellation = factor;
        }
    }
    scene
}

/// Measures all choices on a scene.
///
/// # Errors
/// A picture cannot be drawn, or the device cannot tell GPU time.
pub fn measure(
    subject: &Subject,
    renderer: &mut Renderer,
    progress: &mut dyn FnMut(&str),
) -> Result<Vec<Measured>, LabError> {
    progress(&format!("{}: reference", subject.name));
    let fine = with_factor(&subject.scene, LIMIT);
    let (truth, _) = aam_reference::render(&fine, &subject.view, &aam_reference::Options::default())?;
    let off = [("off", 0.0, 1, DisplacementMode::Off)];
    let uniform = FACTORS.map(|factor| ("uniform", factor as f32, factor, DisplacementMode::Uniform));
    let adaptive =
        PIXEL_ERRORS.map(|pixel_error| ("adaptive", pixel_error, 1, DisplacementMode::Adaptive { pixel_error }));
    let mut rows = Vec::new();
    for (mode, parameter, factor, displacement) in off.into_iter().chain(uniform).chain(adaptive) {
        progress(&format!("{}: {mode} {parameter}", subject.name));
        let scene = with_factor(&subject.scene, factor);
        let options = RenderOptions { displacement, ..RenderOptions::default() };
        let plain = RenderOptions { displacement: DisplacementMode::Off, ..RenderOptions::default() };
        let (mut frames, mut passes, mut prepared) = (Vec::new(), Vec::new(), Vec::new());
        let mut picture = None;
        for _ in 0..FRAMES {
            // Another mesh of the same contents: everything is made anew.
            let again = with_factor(&scene, factor);
            renderer.render_to_image(&again, &subject.view, &plain)?;
            let (_, first) = renderer.render_to_image(&again, &subject.view, &options)?;
            let (image, second) = renderer.render_to_image(&again, &subject.view, &options)?;
            let pass = first.gpu.iter().flatten().find(|pass| pass.name == "displacement").map_or(0.0, |pass| pass.ms);
            passes.push(pass);
            prepared.push(first.cpu.upload_ms);
            frames.push(second.gpu_ms().ok_or(LabError::NoTimestamps)?);
            picture = Some((image, second.triangles));
        }
        let Some((image, triangles)) = picture else { continue };
        rows.push(Measured {
            scene: subject.name.clone(),
            mode,
            parameter,
            triangles,
            frame_ms: median(frames),
            displace_ms: median(passes),
            prepare_ms: median(prepared),
            distance: distance(&scene, subject, displacement)?,
            flip: flip(&truth, &image, PIXELS_PER_DEGREE)?.mean(),
        });
    }
    Ok(rows)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}

/// The distance of the limit surface from all displaced surfaces of a scene.
fn distance(scene: &Scene, subject: &Subject, mode: DisplacementMode) -> Result<SurfaceError, LabError> {
    let world = scene.world_transforms_at(0);
    let mut total = SurfaceError::default();
    for (index, mesh) in scene.meshes.iter().enumerate() {
        let nodes = scene.nodes.iter().zip(&world);
        let placed: Vec<Affine3A> = nodes
            .filter(|(node, _)| node.mesh.is_some_and(|id| id.index() == index))
            .map(|(_, world)| *world)
            .collect();
        for subset in &mesh.subsets {
            let Some(displaced) = of_subset(scene, mesh, subset) else { continue };
            let Some(heights) = HeightMap::new(displaced.image) else { continue };
            let base = Base::new(mesh, subset, &classes(mesh));
            let surface = Surface {
                positions: &mesh.positions,
                normals: &mesh.normals_at(0),
                uvs: displaced.uvs,
                heights: &heights,
                transform: displaced.transform,
                bias: displaced.parameters.bias,
                scale: displaced.parameters.scale,
            };
            // The base mesh is the surface that nothing moved.
            let still = Surface { bias: 0.0, scale: 0.0, ..surface };
            let limit = displaced.parameters.tessellation;
            let plan = match mode {
                DisplacementMode::Adaptive { pixel_error } => {
                    let viewer = Viewer::new(&subject.view, &placed, pixel_error);
                    Plan::adaptive(&base, &surface, &Detail::new(&heights), &viewer, &mesh.name, u64::MAX)?.0
                }
                _ => Plan::uniform(&base, limit, &mesh.name, u64::MAX)?,
            };
            let drawn = if mode == DisplacementMode::Off { &still } else { &surface };
            total = total.with(&surface_error(&base, &surface, drawn, &plan, LATTICE));
        }
    }
    Ok(total)
}

/// The rows as comma-separated values, after a line that says on what they were measured.
pub fn to_csv(machine: &str, rows: &[Measured]) -> String {
    let mut csv = format!(
        "# {machine}\nscene,mode,parameter,triangles,frame GPU ms,displace GPU ms,prepare CPU ms,RMS distance,largest distance,FLIP mean\n"
    );
    for row in rows {
        let _ = writeln!(
            csv,
            "{},{},{},{},{:.3},{:.3},{:.3},{:.3e},{:.3e},{:.5}",
            row.scene,
            row.mode,
            row.parameter,
            row.triangles,
            row.frame_ms,
            row.displace_ms,
            row.prepare_ms,
            row.distance.rms,
            row.distance.max,
            row.flip
        );
    }
    csv
}

/// For each scene three panels: distance against triangles, distance against GPU time, and the picture's difference against
/// GPU time.
pub fn to_svg(machine: &str, rows: &[Measured]) -> String {
    let mut scenes: Vec<&str> = rows.iter().map(|row| row.scene.as_str()).collect();
    scenes.dedup();
    type Cost = fn(&Measured) -> (f64, f64);
    let kinds: [(&str, [&str; 2], Cost); 3] = [
        ("distance, triangles", ["triangles", "RMS distance, m"], |row| (row.triangles as f64, row.distance.rms)),
        ("distance, time", ["GPU time of a frame, ms", "RMS distance, m"], |row| (row.frame_ms, row.distance.rms)),
        ("picture, time", ["GPU time of a frame, ms", "mean FLIP difference"], |row| (row.frame_ms, row.flip)),
    ];
    let titles: Vec<String> =
        scenes.iter().flat_map(|scene| kinds.map(|(kind, ..)| format!("{scene}: {kind}"))).collect();
    let mut panels = Vec::new();
    for (title, (scene, (_, axes, cost))) in
        titles.iter().zip(scenes.iter().flat_map(|scene| kinds.map(|kind| (*scene, kind))))
    {
        let series = ["uniform", "adaptive", "parallax", "off"].map(|mode| Series {
            name: mode.into(),
            points: rows
                .iter()
                .filter(|row| row.scene == scene && row.mode == mode)
                .map(|row| {
                    let (across, up) = cost(row);
                    let label = match mode {
                        "uniform" => format!("{}", row.parameter),
                        "adaptive" => format!("{} px", row.parameter),
                        _ => mode.to_owned(),
                    };
                    (label, across, up)
                })
                .collect(),
        });
        let series = series.into_iter().filter(|series| !series.points.is_empty()).collect();
        panels.push((title.as_str(), axes, series));
    }
    let method = "uniform: tessellation factor; adaptive: pixel error. Median of 11 frames in which nothing changes";
    chart::series(
        "Displacement: triangles and GPU time against distance from the limit surface",
        [machine, method],
        &panels,
    )
}
