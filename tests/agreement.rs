//! The renderer and the reference tracer draw the same picture of every fixture.
//!
//! Each case has a bound on the mean FLIP difference with its reason; over all cases, under 1 % of the pixels may differ
//! by more than 24 of 255 in any channel: those on edges and thin lines, which the renderer samples 4 times and the
//! reference 16 times. Pictures of a case that fails are in `target/tmp/agreement/`; those of all cases if
//! `AAM_KEEP_PICTURES` is set.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use aam_lab::metrics::{PIXELS_PER_DEGREE, difference, difference_picture, flip};
use aam_lab::{load, save_png};
use aam_reference::Options;
use aam_renderer::{Gpu, RenderOptions, Renderer};
use aam_scene::{Image, Layer, NormalSpace, Scene, Shading, View};
use glam::{Mat3, Vec2};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/assets")
}

/// A picture to draw with both engines.
struct Case {
    /// A fixture.
    file: &'static str,
    /// Frame of its animation.
    frame: f32,
    /// Instead of the file's.
    shading: Option<Shading>,
    /// The largest mean FLIP difference.
    flip: f64,
}

const fn case(file: &'static str, flip: f64) -> Case {
    Case { file, frame: 0.0, shading: None, flip }
}

const CASES: &[Case] = &[
    case("binary.scene.toml", 0.02),
    case("character.scene.toml", 0.02),
    case("demo-spheres.scene.toml", 0.02),
    case("demo-teapot.scene.toml", 0.02),
    case("demo-torus.scene.toml", 0.02),
    case("displaced.scene.toml", 0.02),
    case("materials.scene.toml", 0.02),
    case("multiframe.scene.toml", 0.02),
    case("original.scene.toml", 0.02),
    case("physics.scene.toml", 0.02),
    case("room.scene.toml", 0.02),
    case("smoothing-blender.scene.toml", 0.02),
    case("smoothing.scene.toml", 0.02),
    case("crate.gltf", 0.02),
    case("crate.obj", 0.02),
    Case { frame: 25.0, ..case("character.scene.toml", 0.02) },
    Case { frame: 10.0, ..case("multiframe.scene.toml", 0.02) },
    Case { shading: Some(Shading::Linear), ..case("materials.scene.toml", 0.02) },
    Case { shading: Some(Shading::Source), ..case("crate.gltf", 0.02) },
];

/// The largest share of pixels that differ by more than [`STEP`] in any channel.
const OUTLIERS: f64 = 0.01;
const STEP: u8 = 24;

impl Case {
    fn name(&self) -> String {
        let stem = self.file.trim_end_matches(".scene.toml");
        let shading = self.shading.map_or("", |shading| if shading == Shading::Linear { " linear" } else { " source" });
        if self.frame > 0.0 { format!("{stem}{shading} frame {}", self.frame) } else { format!("{stem}{shading}") }
    }

    fn open(&self) -> Result<(Scene, View)> {
        let (mut scene, camera) = load(&fixtures().join(self.file))?;
        scene.shading = self.shading.unwrap_or(scene.shading);
        let (width, height) = (512, 384);
        let camera = camera.unwrap_or_else(|| scene.fitting_camera(width as f32 / height as f32));
        Ok((scene, View { camera, width, height, frame: self.frame }))
    }
}

/// How two pictures differ.
struct Verdict {
    flip: f64,
    outliers: f64,
}

impl Verdict {
    fn of(reference: &Image, drawn: &Image) -> Result<Self> {
        let flip = flip(reference, drawn, PIXELS_PER_DEGREE)?.mean();
        Ok(Self { flip, outliers: difference(reference, drawn)?.outliers(STEP) })
    }

    fn agrees(&self, case: &Case) -> bool {
        self.flip < case.flip && self.outliers < OUTLIERS
    }
}

/// A renderer, or `None` (said aloud) where there is no adapter; on CI that is an error.
fn renderer() -> Result<Option<Renderer>> {
    match Gpu::headless() {
        Ok(gpu) => Ok(Some(Renderer::new(gpu))),
        Err(error) if std::env::var("CI").is_ok_and(|value| value == "true") => Err(error.into()),
        Err(error) => {
            println!("skipped: no GPU adapter ({error})");
            Ok(None)
        }
    }
}

fn traced(scene: &Scene, view: &View) -> Result<Image> {
    Ok(aam_reference::render(scene, view, &Options::default())?.0)
}

fn drawn(renderer: &mut Renderer, scene: &Scene, view: &View) -> Result<Image> {
    Ok(renderer.render_to_image(scene, view, &RenderOptions::default())?.0)
}

fn keep(name: &str, reference: &Image, drawn: &Image) -> Result<()> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("agreement");
    save_png(drawn, &folder.join(format!("{name}.renderer.png")))?;
    save_png(reference, &folder.join(format!("{name}.reference.png")))?;
    Ok(save_png(&difference_picture(reference, drawn, 2 * STEP)?, &folder.join(format!("{name}.difference.png")))?)
}

#[test]
fn the_engines_agree_on_every_fixture() -> Result<()> {
    let Some(mut renderer) = renderer()? else { return Ok(()) };
    let mut failed = Vec::new();
    for case in CASES {
        let start = Instant::now();
        let (scene, view) = case.open()?;
        let (reference, drawn) = (traced(&scene, &view)?, drawn(&mut renderer, &scene, &view)?);
        let verdict = Verdict::of(&reference, &drawn)?;
        let line = format!(
            "{:28} FLIP {:.4} of {:.4}, {:.3} % of pixels over {STEP}",
            case.name(),
            verdict.flip,
            case.flip,
            100.0 * verdict.outliers
        );
        println!("{line}, {:.1} s", start.elapsed().as_secs_f64());
        let agrees = verdict.agrees(case);
        if !agrees || std::env::var_os("AAM_KEEP_PICTURES").is_some() {
            keep(&case.name(), &reference, &drawn)?;
        }
        if !agrees {
            failed.push(line);
        }
    }
    assert!(failed.is_empty(), "see {}/agreement:\n{}", env!("CARGO_TARGET_TMPDIR"), failed.join("\n"));
    Ok(())
}

#[test]
fn every_fixture_with_a_view_is_a_case() -> Result<()> {
    let mut missing = Vec::new();
    for entry in std::fs::read_dir(fixtures())? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if name.ends_with(".scene.toml") && !CASES.iter().any(|case| case.file == name) {
            missing.push(name);
        }
    }
    assert!(missing.is_empty(), "add these to CASES: {missing:?}");
    Ok(())
}

/// A fault in what one engine draws, and the fixture that shows it.
struct Fault {
    name: &'static str,
    file: &'static str,
    put: fn(&mut Scene),
}

const FAULTS: &[Fault] = &[
    Fault { name: "diffuse texture and light map swapped", file: "room.scene.toml", put: swap_layers },
    Fault { name: "diffuse texture and light map swapped", file: "materials.scene.toml", put: swap_layers },
    Fault { name: "normal maps in the wrong space", file: "materials.scene.toml", put: swap_normal_spaces },
    Fault { name: "normal maps in the wrong space", file: "displaced.scene.toml", put: swap_normal_spaces },
    Fault { name: "normal maps in the wrong space", file: "crate.gltf", put: swap_normal_spaces },
    Fault { name: "v not flipped", file: "multiframe.scene.toml", put: flip_v },
    Fault { name: "v not flipped", file: "room.scene.toml", put: flip_v },
    Fault { name: "v not flipped", file: "crate.gltf", put: flip_v },
    Fault { name: "light maps ignored", file: "room.scene.toml", put: |scene| drop_layer(scene, Layer::LightMap) },
    Fault { name: "light maps ignored", file: "materials.scene.toml", put: |scene| drop_layer(scene, Layer::LightMap) },
    Fault { name: "normal maps ignored", file: "crate.gltf", put: |scene| drop_layer(scene, Layer::Normal) },
    Fault { name: "green of normal maps flipped", file: "crate.gltf", put: flip_green },
    Fault { name: "vertex colours ignored", file: "binary.scene.toml", put: drop_colors },
    Fault { name: "alpha cutoff ignored", file: "materials.scene.toml", put: drop_cutoff },
    Fault { name: "highlights ignored", file: "demo-torus.scene.toml", put: drop_highlights },
    Fault { name: "one light fewer", file: "character.scene.toml", put: drop_light },
    Fault { name: "colours decoded twice", file: "crate.gltf", put: |scene| scene.shading = Shading::Source },
];

#[test]
fn faults_break_the_agreement() -> Result<()> {
    let Some(mut renderer) = renderer()? else { return Ok(()) };
    let mut unseen = Vec::new();
    for fault in FAULTS {
        let case = CASES.iter().find(|case| case.file == fault.file).ok_or("a fault's file is a case")?;
        let (scene, view) = case.open()?;
        let mut faulty = scene.clone();
        (fault.put)(&mut faulty);
        let verdict = Verdict::of(&traced(&scene, &view)?, &drawn(&mut renderer, &faulty, &view)?)?;
        println!(
            "{:28} {}: FLIP {:.4} of {:.4}, {:.2} % of pixels over {STEP}",
            case.name(),
            fault.name,
            verdict.flip,
            case.flip,
            100.0 * verdict.outliers
        );
        if verdict.agrees(case) {
            unseen.push(format!("{} in {}", fault.name, case.name()));
        }
    }
    assert!(unseen.is_empty(), "not noticed: {unseen:?}");
    Ok(())
}

fn swap_layers(scene: &mut Scene) {
    for material in &mut scene.materials {
        material.layers.swap(Layer::Diffuse as usize, Layer::LightMap as usize);
    }
}

fn swap_normal_spaces(scene: &mut Scene) {
    for layer in scene.materials.iter_mut().filter_map(|material| material.layers[Layer::Normal as usize].as_mut()) {
        layer.normal_space = match layer.normal_space {
            NormalSpace::Object => NormalSpace::Tangent,
            NormalSpace::Tangent => NormalSpace::Object,
        };
    }
}

fn flip_v(scene: &mut Scene) {
    let flip = Mat3::from_translation(Vec2::Y) * Mat3::from_scale(Vec2::new(1.0, -1.0));
    for layer in scene.materials.iter_mut().flat_map(|material| material.layers.iter_mut().flatten()) {
        layer.transform = flip * layer.transform;
    }
}

fn drop_layer(scene: &mut Scene, layer: Layer) {
    scene.materials.iter_mut().for_each(|material| material.layers[layer as usize] = None);
}

fn drop_cutoff(scene: &mut Scene) {
    scene.materials.iter_mut().for_each(|material| material.alpha_cutoff = None);
}

fn drop_highlights(scene: &mut Scene) {
    scene.materials.iter_mut().for_each(|material| material.exponent = 0.0);
}

fn drop_colors(scene: &mut Scene) {
    scene.meshes.iter_mut().for_each(|mesh| Arc::make_mut(mesh).colors = None);
}

fn flip_green(scene: &mut Scene) {
    scene.meshes.iter_mut().for_each(|mesh| {
        Arc::make_mut(mesh).tangents.iter_mut().flatten().for_each(|tangent| tangent.w = -tangent.w);
    });
}

fn drop_light(scene: &mut Scene) {
    scene.lights.pop();
}
