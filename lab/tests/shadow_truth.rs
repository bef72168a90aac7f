//! Shadow techniques against exact visibility, on the fixtures.

use std::path::Path;

use aam_lab::metrics::{VisibilityError, visibility_error};
use aam_reference::{LightSize, Options};
use aam_renderer::{Gpu, RenderOptions, Renderer};
use aam_scene::{Scene, ShadowSource, Shadows, View};

fn renderer() -> Option<Renderer> {
    match Gpu::headless() {
        Ok(gpu) => Some(Renderer::new(gpu)),
        Err(reason) => {
            assert!(std::env::var("CI").as_deref() != Ok("true"), "CI needs a GPU adapter: {reason}");
            println!("skipped: no GPU adapter ({reason})");
            None
        }
    }
}

fn fixture(name: &str) -> (Scene, View) {
    let path = format!("{}/../fixtures/assets/{name}.scene.toml", env!("CARGO_MANIFEST_DIR"));
    let (scene, camera) = aam_lab::load(Path::new(&path)).unwrap();
    (scene, View { camera: camera.unwrap(), width: 160, height: 120, frame: 0.0 })
}

/// Error of the first light's shadow.
fn error(renderer: &mut Renderer, scene: &Scene, view: &View, settings: &str, size: LightSize) -> VisibilityError {
    let options = Options { light_samples: 32, ..Options::default() };
    let (truth, _) = aam_reference::visibility(scene, view, size, &options).unwrap();
    let mut scene = scene.clone();
    let source = ShadowSource::of_light(0, settings.parse().unwrap());
    scene.shadows = Some(Shadows { sources: vec![source], ..Shadows::default() });
    let (seen, stats) = renderer.visibility(&scene, view, 0, &RenderOptions::default()).unwrap();
    assert_eq!(stats.warnings, Vec::<String>::new(), "{settings}");
    assert!(seen.iter().all(|share| (0.0..=1.0).contains(share)), "{settings}");
    visibility_error(&truth.lights[0], &seen).unwrap()
}

#[test]
fn shadow_volumes_are_exact() {
    let Some(mut renderer) = renderer() else { return };
    for name in
        ["demo-torus", "demo-spheres", "demo-teapot", "room", "fence", "sheets", "blade", "landscape", "boxroom"]
    {
        let (scene, view) = fixture(name);
        let found = error(&mut renderer, &scene, &view, "volume", LightSize::Point);
        // A pixel on an edge here and there, where a ray and a sample round differently.
        assert!(found.rmse < 0.03, "{name}: {found:?}");
    }
}

#[test]
fn finer_maps_are_nearer_to_the_truth() {
    let Some(mut renderer) = renderer() else { return };
    for (name, technique) in
        [("demo-torus", "hard"), ("boxroom", "cube-hard"), ("landscape", "csm-hard"), ("sheets", "evsm4")]
    {
        let (scene, view) = fixture(name);
        let mut at = |resolution: u32| {
            let settings = format!("{technique}:resolution={resolution}");
            error(&mut renderer, &scene, &view, &settings, LightSize::Point).rmse
        };
        let (coarse, fine) = (at(256), at(1024));
        assert!(fine < 0.75 * coarse && fine < 0.15, "{name}: {coarse} and {fine}");
    }
}

#[test]
fn penumbras_that_grow_are_nearer_to_a_large_light_than_those_that_do_not() {
    let Some(mut renderer) = renderer() else { return };
    let (scene, view) = fixture("sheets");
    let mut area = |settings: &str| error(&mut renderer, &scene, &view, settings, LightSize::Area).rmse;
    let (growing, fixed) = (area("pcss"), area("pcf:radius=4"));
    assert!(growing < 0.6 * fixed, "{growing} and {fixed}");
}
