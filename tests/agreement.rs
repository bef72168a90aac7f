//! The renderer and the reference tracer draw the same picture of every fixture.
//!
//! Two comparisons. *Exact*: both sample the middle of each pixel once, and nearly all pixels must be equal to 2 of 255.
//! *Smooth*: the renderer samples edges 4 times, the reference everything 16 times; each fixture has a bound on the mean
//! FLIP difference with its reason, and under 1 % of the pixels may differ by more than 24 of 255.
//!
//! Pictures of a case that fails are in `target/tmp/agreement/`; those of all cases if `AAM_KEEP_PICTURES` is set.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use aam_lab::metrics::{PIXELS_PER_DEGREE, difference, difference_picture, flip};
use aam_lab::{load, save_png};
use aam_reference::Options;
use aam_renderer::{Gpu, Msaa, RenderOptions, Renderer};
use aam_scene::{
    DisplacementMode, Environment, Image, Layer, NormalSpace, Scene, Shading, SpecularFilter, ToneMap, View,
};
use glam::{Mat3, Vec2};

type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

/// A picture to draw with both engines.
#[derive(Clone, Copy)]
struct Case {
    /// A fixture.
    file: &'static str,
    /// Frame of its animation.
    frame: f32,
    /// Instead of the file's.
    shading: Option<Shading>,
    displacement: DisplacementMode,
    /// The largest mean FLIP difference; `None` compares exactly only.
    flip: Option<f64>,
}

const fn case(file: &'static str, flip: f64) -> Case {
    Case { file, frame: 0.0, shading: None, displacement: DisplacementMode::Uniform, flip: Some(flip) }
}

/// Bounds are some 1.3 times what lavapipe (Mesa 22.3.6) gives.
const CASES: &[Case] = &[
    // Plain surfaces: edges differ by the number of samples.
    case("demo-spheres.scene.toml", 0.004),
    case("demo-teapot.scene.toml", 0.003),
    case("demo-torus.scene.toml", 0.005),
    case("blade.scene.toml", 0.002),
    case("boxroom.scene.toml", 0.0045),
    case("sheets.scene.toml", 0.0025),
    case("smoothing.scene.toml", 0.005),
    case("smoothing-blender.scene.toml", 0.005),
    // The same, thin or far away: more of the picture is edges.
    case("fence.scene.toml", 0.0095),
    case("landscape.scene.toml", 0.02),
    // Textures: a GPU chooses the mip level by the longer side of a pixel's footprint, which blurs what is seen at a slant.
    case("binary.scene.toml", 0.006),
    case("character.scene.toml", 0.014),
    case("displaced.scene.toml", 0.013),
    case("medallion.scene.toml", 0.006),
    case("multiframe.scene.toml", 0.005),
    case("original.scene.toml", 0.011),
    case("physics.scene.toml", 0.013),
    // The same with fine joints of high contrast all over the picture.
    case("materials.scene.toml", 0.026),
    case("room.scene.toml", 0.039),
    // Light from all around: the renderer's is prefiltered, the reference's is integrated for each point.
    case("environment.scene.toml", 0.019),
    case("crate.gltf", 0.013),
    case("crate.obj", 0.013),
    // Later frames, and the other mode.
    Case { frame: 25.0, flip: None, ..case("character.scene.toml", 0.0) },
    Case { frame: 10.0, flip: None, ..case("multiframe.scene.toml", 0.0) },
    Case { shading: Some(Shading::Linear), flip: None, ..case("materials.scene.toml", 0.0) },
    // Displacement otherwise than by the tessellation factor.
    Case { displacement: DisplacementMode::Off, flip: None, ..case("displaced.scene.toml", 0.0) },
    Case { displacement: DisplacementMode::ADAPTIVE, flip: None, ..case("displaced.scene.toml", 0.0) },
    Case { displacement: DisplacementMode::ADAPTIVE, flip: None, ..case("medallion.scene.toml", 0.0) },
    Case { shading: Some(Shading::Linear), flip: None, ..case("room.scene.toml", 0.0) },
    Case { shading: Some(Shading::Source), flip: None, ..case("crate.gltf", 0.0) },
    Case { shading: Some(Shading::Source), flip: None, ..case("environment.scene.toml", 0.0) },
];

/// Exact: the largest share of pixels that differ by more than 2. These are at edges and at alpha cutoffs, where the last
/// bit decides, and where a texture unit's weights of 8 bits meet texels of high contrast.
const EXACT: (u8, f64) = (2, 0.002);

/// The same where an environment lights: the renderer's is filtered before, in texels, so the rims of mirrors, where a
/// pixel sees much of it, and the edge of the sun in them differ. Some 1.3 times what lavapipe gives.
const PREFILTERED: (u8, f64) = (2, 0.045);

/// Smooth: the largest share of pixels that differ by more than 24. These are on edges and thin lines, most of them in the
/// joints of displaced bricks.
const SMOOTH: (u8, f64) = (24, 0.014);

/// A case with the reference's pictures.
struct Prepared {
    case: Case,
    scene: Scene,
    view: View,
    exact: Image,
    smooth: Option<Image>,
}

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/assets")
}

impl Case {
    fn name(&self) -> String {
        let stem = self.file.trim_end_matches(".scene.toml");
        let shading = self.shading.map_or("", |shading| if shading == Shading::Linear { " linear" } else { " source" });
        let displacement = match self.displacement {
            DisplacementMode::Uniform => String::new(),
            other => format!(" {other:?}"),
        };
        let frame = if self.frame > 0.0 { format!(" frame {}", self.frame) } else { String::new() };
        format!("{stem}{shading}{displacement}{frame}")
    }

    fn prepare(self) -> Result<Prepared> {
        let (mut scene, camera) = load(&fixtures().join(self.file))?;
        scene.shading = self.shading.unwrap_or(scene.shading);
        // What the reference traces exactly the renderer approaches: shadows have tests of their own.
        scene.shadows = None;
        let (width, height) = (512, 384);
        let camera = camera.unwrap_or_else(|| scene.fitting_camera(width as f32 / height as f32));
        let view = View { camera, width, height, frame: self.frame };
        let trace = |samples_per_pixel| -> Result<Image> {
            // About as many directions for each pixel.
            let environment_samples = 1024 / samples_per_pixel;
            let displacement = self.displacement;
            let options = Options { samples_per_pixel, displacement, environment_samples, ..Options::default() };
            Ok(aam_reference::render(&scene, &view, &options)?.0)
        };
        let smooth = self.flip.map(|_| trace(16)).transpose()?;
        Ok(Prepared { case: self, exact: trace(1)?, smooth, scene, view })
    }
}

/// All cases, prepared once for all tests.
fn prepared() -> Result<&'static [Prepared]> {
    static ALL: OnceLock<std::result::Result<Vec<Prepared>, String>> = OnceLock::new();
    let all = ALL.get_or_init(|| {
        let prepare = |case: &Case| case.prepare().map_err(|error| format!("{}: {error}", case.file));
        CASES.iter().map(prepare).collect()
    });
    Ok(all.as_deref().map_err(String::clone)?)
}

impl Prepared {
    /// What is wrong with the renderer's pictures of a scene as pictures of this case; nothing if they agree.
    fn judge(&self, renderer: &mut Renderer, scene: &Scene) -> Result<Vec<Fault>> {
        let mut draw = |msaa| -> Result<Image> {
            let options = RenderOptions { msaa, displacement: self.case.displacement, ..RenderOptions::default() };
            Ok(renderer.render_to_image(scene, &self.view, &options)?.0)
        };
        let mut faults = Vec::new();
        let mut check =
            |kind: &'static str, reference: &Image, drawn: Image, (step, share): (u8, f64), bound: Option<f64>| {
                let outliers = difference(reference, &drawn)?.outliers(step);
                let flip = flip(reference, &drawn, PIXELS_PER_DEGREE)?.mean();
                let line = format!(
                    "{:28} {kind:6} FLIP {flip:.4}{}, {:.3} % of pixels over {step} of {:.1} %",
                    self.case.name(),
                    bound.map(|bound| format!(" of {bound:.4}")).unwrap_or_default(),
                    100.0 * outliers,
                    100.0 * share
                );
                if outliers >= share || bound.is_some_and(|bound| flip >= bound) {
                    faults.push(Fault { kind, line, reference: reference.clone(), drawn });
                } else {
                    println!("{line}");
                    if std::env::var_os("AAM_KEEP_PICTURES").is_some() {
                        keep(&format!("{} {kind}", self.case.name()), reference, &drawn)?;
                    }
                }
                Result::Ok(())
            };
        let exact = if self.scene.environment.is_some() { PREFILTERED } else { EXACT };
        check("exact", &self.exact, draw(Msaa::X1)?, exact, None)?;
        if let Some(smooth) = &self.smooth {
            check("smooth", smooth, draw(Msaa::X4)?, SMOOTH, self.case.flip)?;
        }
        Ok(faults)
    }
}

/// A comparison that failed.
struct Fault {
    kind: &'static str,
    line: String,
    reference: Image,
    drawn: Image,
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

fn keep(name: &str, reference: &Image, drawn: &Image) -> Result<()> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("agreement");
    save_png(drawn, &folder.join(format!("{name} renderer.png")))?;
    save_png(reference, &folder.join(format!("{name} reference.png")))?;
    Ok(save_png(&difference_picture(reference, drawn, 48)?, &folder.join(format!("{name} difference.png")))?)
}

#[test]
fn the_engines_agree_on_every_fixture() -> Result<()> {
    let Some(mut renderer) = renderer()? else { return Ok(()) };
    let mut failed = Vec::new();
    for case in prepared()? {
        for fault in case.judge(&mut renderer, &case.scene)? {
            keep(&format!("{} {}", case.case.name(), fault.kind), &fault.reference, &fault.drawn)?;
            failed.push(fault.line);
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

/// A deliberate mistake in what the renderer draws, and the fixture that shows it.
struct Mistake {
    name: &'static str,
    file: &'static str,
    /// Which comparisons must fail.
    noticed: Noticed,
    make: fn(&mut Scene),
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Noticed {
    /// Both.
    Twice,
    /// The exact one at least: the mistake changes less than textures and edges differ in the smooth one.
    Exactly,
}

const MISTAKES: &[Mistake] = &[
    Mistake {
        name: "diffuse texture and light map swapped",
        file: "room.scene.toml",
        noticed: Noticed::Twice,
        make: swap_layers,
    },
    Mistake {
        name: "diffuse texture and light map swapped",
        file: "materials.scene.toml",
        noticed: Noticed::Twice,
        make: swap_layers,
    },
    Mistake {
        name: "normal maps in the wrong space",
        file: "materials.scene.toml",
        noticed: Noticed::Twice,
        make: swap_normal_spaces,
    },
    Mistake {
        name: "normal maps in the wrong space",
        file: "displaced.scene.toml",
        noticed: Noticed::Twice,
        make: swap_normal_spaces,
    },
    Mistake {
        name: "normal maps in the wrong space",
        file: "crate.gltf",
        noticed: Noticed::Twice,
        make: swap_normal_spaces,
    },
    Mistake {
        name: "displacement twice as high",
        file: "displaced.scene.toml",
        noticed: Noticed::Twice,
        make: |scene| displace_by(scene, 2.0),
    },
    Mistake {
        name: "displacement ignored",
        file: "medallion.scene.toml",
        noticed: Noticed::Twice,
        make: |scene| displace_by(scene, 0.0),
    },
    Mistake { name: "v not flipped", file: "multiframe.scene.toml", noticed: Noticed::Twice, make: flip_v },
    Mistake { name: "v not flipped", file: "room.scene.toml", noticed: Noticed::Twice, make: flip_v },
    Mistake { name: "v not flipped", file: "crate.gltf", noticed: Noticed::Twice, make: flip_v },
    Mistake {
        name: "light maps ignored",
        file: "room.scene.toml",
        noticed: Noticed::Twice,
        make: |scene| drop_layer(scene, Layer::LightMap),
    },
    Mistake {
        name: "light maps ignored",
        file: "materials.scene.toml",
        noticed: Noticed::Twice,
        make: |scene| drop_layer(scene, Layer::LightMap),
    },
    Mistake {
        name: "normal maps ignored",
        file: "crate.gltf",
        noticed: Noticed::Exactly,
        make: |scene| drop_layer(scene, Layer::Normal),
    },
    Mistake { name: "green of normal maps flipped", file: "crate.gltf", noticed: Noticed::Exactly, make: flip_green },
    Mistake { name: "vertex colours ignored", file: "binary.scene.toml", noticed: Noticed::Twice, make: drop_colors },
    Mistake {
        name: "alpha cutoff ignored",
        file: "materials.scene.toml",
        noticed: Noticed::Exactly,
        make: drop_cutoff,
    },
    Mistake {
        name: "highlights ignored",
        file: "demo-torus.scene.toml",
        noticed: Noticed::Twice,
        make: drop_highlights,
    },
    Mistake {
        name: "environment turned by 10 degrees",
        file: "environment.scene.toml",
        noticed: Noticed::Twice,
        make: |scene| with_environment(scene, |environment| environment.rotation += 0.17),
    },
    Mistake {
        name: "environment reflected by mirrors",
        file: "environment.scene.toml",
        noticed: Noticed::Twice,
        make: |scene| with_environment(scene, |environment| environment.filter = Some(SpecularFilter::Mirror)),
    },
    Mistake {
        name: "environment without diffuse light",
        file: "environment.scene.toml",
        noticed: Noticed::Twice,
        make: |scene| with_environment(scene, |environment| environment.diffuse = false),
    },
    Mistake {
        name: "no tone mapping",
        file: "environment.scene.toml",
        noticed: Noticed::Twice,
        make: |scene| scene.tone_map = ToneMap::Clamp,
    },
    Mistake { name: "one light fewer", file: "character.scene.toml", noticed: Noticed::Twice, make: drop_light },
    Mistake {
        name: "colours decoded twice",
        file: "crate.gltf",
        noticed: Noticed::Twice,
        make: |scene| scene.shading = Shading::Source,
    },
];

#[test]
fn mistakes_break_the_agreement() -> Result<()> {
    let Some(mut renderer) = renderer()? else { return Ok(()) };
    let mut unseen = Vec::new();
    for mistake in MISTAKES {
        let case =
            prepared()?.iter().find(|case| case.case.file == mistake.file).ok_or("a mistake's file is a case")?;
        let mut scene = case.scene.clone();
        (mistake.make)(&mut scene);
        let faults = case.judge(&mut renderer, &scene)?;
        for fault in &faults {
            println!("{}: {}", mistake.name, fault.line);
        }
        let kinds: Vec<&str> = faults.iter().map(|fault| fault.kind).collect();
        if !kinds.contains(&"exact") || mistake.noticed == Noticed::Twice && !kinds.contains(&"smooth") {
            unseen.push(format!("{} in {}", mistake.name, case.case.name()));
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

fn displace_by(scene: &mut Scene, factor: f32) {
    for displacement in scene.meshes.iter_mut().filter_map(|mesh| Arc::make_mut(mesh).displacement.as_mut()) {
        displacement.bias *= factor;
        displacement.scale *= factor;
    }
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

fn with_environment(scene: &mut Scene, change: impl FnOnce(&mut Environment)) {
    if let Some(environment) = &mut scene.environment {
        change(environment);
    }
}

fn drop_light(scene: &mut Scene) {
    scene.lights.pop();
}
