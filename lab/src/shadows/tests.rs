//! With a stand-in for the renderer: the reference's own visibility, made worse in known ways.

use std::path::Path;

use aam_reference::{LightSize, Options};
use aam_scene::{Image, Scene, ShadowFilter, View};

use super::*;
use crate::technique::Limits;
use crate::techniques::Effort;
use crate::{LabError, load};

/// Exact shadows of points, with the light as large as it is for `pcss`, that leak more the smaller the resolution, and
/// cost as much as it is large.
struct StandIn {
    pictures: usize,
}

impl Painter for StandIn {
    fn adapter(&self) -> String {
        "stand-in".into()
    }

    fn picture(&mut self, scene: &Scene, view: &View) -> Result<(Image, Cost), LabError> {
        self.pictures += 1;
        let options = Options { samples_per_pixel: 1, shadows: Some(LightSize::Point), ..Options::default() };
        let (image, _) = aam_reference::render(scene, view, &options)?;
        let source = scene.shadows.as_ref().and_then(|shadows| shadows.sources.first());
        let cost = source.map_or(Cost { rest_ms: 1.0, ..Cost::default() }, |source| {
            let texels = f64::from(source.settings.resolution).powi(2);
            let map_ms = texels * 1e-6;
            Cost { map_ms, blur_ms: 0.5, rest_ms: 1.25, bytes: 4 * texels as u64 }
        });
        Ok((image, cost))
    }

    fn visibility(&mut self, scene: &Scene, view: &View) -> Result<Vec<f32>, LabError> {
        let settings = scene.shadows.as_ref().unwrap().sources[0].settings;
        let size = if settings.technique.filter == ShadowFilter::Pcss { LightSize::Area } else { LightSize::Point };
        let (mut seen, _) = aam_reference::visibility(scene, view, size, &Options::default())?;
        let leak = 16.0 / settings.resolution as f32;
        Ok(seen.lights.swap_remove(0).iter().map(|seen| seen.map_or(1.0, |seen| seen.share.max(leak))).collect())
    }

    fn limits(&mut self, scene: &Scene, _view: &View) -> Limits {
        match scene.shadows.as_ref().unwrap().sources[0].settings.technique.filter {
            ShadowFilter::Volume => Limits::Refuses("the mesh is open".into()),
            ShadowFilter::Hard => Limits::Degrades("it has steps".into()),
            _ => Limits::Holds,
        }
    }
}

fn subject() -> Subject {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/assets/sheets.scene.toml");
    let (scene, camera) = load(&path).unwrap();
    let view = View { camera: camera.unwrap(), width: 48, height: 36, frame: 0.0 };
    Subject::new("sheets".into(), &scene, view, None).unwrap()
}

fn chart() -> ShadowChart {
    let plan = Plan {
        techniques: ["hard", "pcss", "volume", "cube-pcf"].map(|name| name.parse().unwrap()).to_vec(),
        rays: Rays { light_samples: 64, picture_samples: 4 },
        frames: 3,
        ..Plan::new(Effort::Quick)
    };
    measure(&subject(), &plan, &mut StandIn { pictures: 0 }, &|_, _| {}).unwrap()
}

#[test]
fn a_chart_measures_every_setting_against_both_truths() {
    let chart = chart();
    let labels: Vec<String> = chart.runs.iter().map(Run::label).collect();
    assert_eq!(labels, ["none", "hard", "pcss", "hard:resolution=512", "pcss:resolution=512", "hard:resolution=2048"]);
    assert_eq!(chart.left.len(), 2, "{:?}", chart.left);
    assert!(chart.left.iter().any(|left| left.settings == "volume" && left.reason == "the mesh is open"));
    assert!(chart.left.iter().any(|left| left.settings == "cube-pcf" && left.reason.contains("not six")));
    let (point, area) = (chart.truth(TruthKind::Point).unwrap(), chart.truth(TruthKind::Area).unwrap());
    let run = |label: &str| chart.runs.iter().find(|run| run.label() == label).unwrap();
    // Hard shadows are right about a point but for what leaks, and grow better with the resolution.
    let hard = |label: &str, truth: usize| run(label).judged[truth].visibility;
    assert!((hard("hard", point).leaked - 16.0 / 1024.0).abs() < 1e-6, "{:?}", hard("hard", point));
    assert!(hard("hard:resolution=2048", point).rmse < hard("hard", point).rmse);
    assert!(hard("hard", area).rmse > 3.0 * run("pcss").judged[area].visibility.rmse);
    assert!(run("none").judged[area].visibility.signed_mean > 0.0);
    // Times come apart, and what is left of a frame without shadow is the lookup.
    let times = run("hard:resolution=512").times;
    let parts = [times.map_ms, times.blur_ms, times.lookup_ms, times.gpu_ms];
    for (found, expected) in parts.into_iter().zip([0.262_144, 0.5, 0.25, 2.012_144]) {
        assert!((found - expected).abs() < 1e-9, "{parts:?}");
    }
    assert_eq!(run("hard").limits.text(), "degrades because it has steps");
    assert!(run("hard").flicker.unwrap().most().unwrap() > 0.0);
    assert!(chart.exact_flicker.unwrap().camera.unwrap() > 0.0);
    assert!(chart.exact[point].0.rmse == 0.0 && chart.exact[area].0.rmse > 0.0);
}

#[test]
fn tables_have_a_row_for_each_setting_and_truth() {
    let chart = chart();
    let text = csv(&chart);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 1 + 2 * chart.runs.len());
    let count = |line: &str| crate::report::fields(line).len();
    assert!(lines.iter().all(|line| count(line) == columns().len()), "{text}");
    let value = json(&chart);
    let rows = value["runs"].as_array().unwrap();
    assert_eq!(rows.len(), 2 * chart.runs.len());
    let hard = rows.iter().find(|row| row["settings"] == "hard:resolution=512").unwrap();
    assert_eq!(
        (&hard["resolution"], &hard["max_bias"], &hard["receiver_plane"]),
        (&512.into(), &"inf".into(), &serde_json::Value::Null)
    );
    assert_eq!(hard["bytes"], 4 * 512 * 512);
}

#[test]
fn the_page_is_whole_by_itself() {
    let mut chart = chart();
    chart.scene = "</script><b>".into();
    let page = page(&chart, "aam chart shadows x").unwrap();
    assert!(!page.contains("</script><b>") && page.contains("&lt;/script&gt;"));
    assert_eq!(page.matches("</script>").count(), 2);
    for outside in ["src=\"", "href=", "url(", "@import", "http://", "https://"] {
        let expected = usize::from(outside == "http://");
        assert_eq!(page.matches(outside).count(), expected, "{outside} (the name of the SVG name space is no address)");
    }
    assert!(page.contains("data:image/png;base64,") && page.contains("data:image/jpeg;base64,"));
    let svg = fronts(&chart);
    assert_eq!(svg.matches("<circle ").count(), 2 * chart.runs.len());
}

#[test]
fn the_cheapest_that_is_accurate_enough_is_chosen() {
    let chart = chart();
    let label = |truth, goal| {
        let choice = choose(&chart, truth, goal).unwrap();
        (chart.runs[choice.run].label(), choice.reached)
    };
    let error = |label: &str, kind| {
        let run = chart.runs.iter().find(|run| run.label() == label).unwrap();
        run.judged[chart.truth(kind).unwrap()].visibility.rmse
    };
    let middle = 0.5 * (error("hard", TruthKind::Point) + error("hard:resolution=512", TruthKind::Point));
    assert_eq!(label(TruthKind::Point, Goal::MaxError(middle)), ("hard".into(), true));
    assert_eq!(label(TruthKind::Point, Goal::MaxError(1.0)), ("none".into(), true));
    assert_eq!(label(TruthKind::Point, Goal::MaxError(0.0)), ("hard:resolution=2048".into(), false));
    // In 2.5 ms a map of 512 can be had, and for a light with a size it is the soft one that is right.
    assert_eq!(label(TruthKind::Area, Goal::Budget(2.5)), ("pcss:resolution=512".into(), true));
    assert_eq!(label(TruthKind::Area, Goal::Budget(0.1)), ("none".into(), false));
    let because = choose(&chart, TruthKind::Point, Goal::MaxError(middle)).unwrap().because.join("\n");
    assert!(because.contains("next is") && because.contains("resolution 2048 would lower the error"), "{because}");
}

#[test]
fn pareto_keeps_what_no_other_beats() {
    let points = [(1.0, 5.0), (2.0, 5.0), (3.0, 1.0), (2.0, 3.0), (f64::NAN, 0.0), (4.0, 1.0)];
    assert_eq!(pareto(points.into_iter()), [0, 3, 2]);
    assert!(pareto(std::iter::empty()).is_empty());
}

#[test]
fn lights_are_found_by_name_or_number_and_refused_with_a_sentence() {
    let subject = subject();
    let new = |scene: &Scene, light| Subject::new("s".into(), scene, subject.view.clone(), light);
    assert_eq!(new(&subject.scene, Some("lamp")).unwrap().light, 0);
    assert_eq!(new(&subject.scene, Some("1")).unwrap().light_name(), "lamp");
    let message = |scene: &Scene, light| new(scene, light).unwrap_err().to_string();
    assert_eq!(message(&subject.scene, Some("sun")), "there is no light \"sun\"; there are \"lamp\"");
    let dark = Scene { lights: Vec::new(), ..subject.scene.clone() };
    assert!(message(&dark, None).starts_with("the scene has no light"));
    let mut black = subject.scene.clone();
    black.lights[0].diffuse = glam::Vec3::ZERO;
    black.lights[0].specular = glam::Vec3::ZERO;
    assert!(message(&black, None).contains("is black"));
    // The first with a shape is taken, and others keep their ambient colour alone.
    let mut two = subject.scene.clone();
    let plain = aam_scene::Light { shape: None, ..two.lights[0].clone() };
    two.lights.insert(0, plain);
    let chosen = new(&two, None).unwrap();
    assert_eq!(chosen.light, 1);
    assert!(chosen.scene.lights[0].diffuse == glam::Vec3::ZERO && chosen.scene.lights[0].ambient != glam::Vec3::ZERO);
}

#[test]
fn needs_name_what_casts_into_view() {
    let mut subject = subject();
    let name = |id: &aam_scene::NodeId, scene: &Scene| scene.nodes[id.index()].name.clone();
    let needs = Needs::of(&subject.scene, &[subject.view.clone()]).unwrap();
    assert!(needs.lights[0].darkened > 20 && needs.lights[0].faces > needs.lights[0].darkened, "{needs:?}");
    let all: Vec<String> = needs.casters().iter().map(|id| name(id, &subject.scene)).collect();
    assert!(!all.is_empty());
    // A copy of a caster far behind the light casts nothing into view; and a camera that looks away sees no shadow.
    let mut scene = subject.scene.clone();
    let mut far = scene.nodes[needs.casters()[0].index()].clone();
    (far.name, far.parent) = ("far".into(), None);
    far.local = glam::Affine3A::from_translation(glam::Vec3::new(0.0, -500.0, 500.0));
    scene.nodes.push(far);
    let again = Needs::of(&scene, &[subject.view.clone()]).unwrap();
    assert_eq!(again.lights[0].casters, needs.lights[0].casters);
    let camera = &mut subject.view.camera;
    camera.target = camera.position + glam::Vec3::Z;
    let away = Needs::of(&scene, &[subject.view.clone()]).unwrap();
    assert_eq!((away.lights[0].faces, away.lights[0].darkened), (0, 0));
}
