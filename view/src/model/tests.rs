//! What outlives a reload, and what the user is asked.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use aam_scene::{LightKind, Material, Members, Node, ShadowSettings, ShadowSource, Shadows, TextureId, TextureLayer};
use glam::{Mat3, Vec3};

use super::*;

fn node(name: &str) -> Node {
    Node { name: name.into(), parent: None, local: Affine3A::IDENTITY, mesh: None, visible: true }
}

fn scene(names: &[&str]) -> Scene {
    Scene { nodes: names.iter().map(|name| node(name)).collect(), ..Scene::default() }
}

fn light(name: &str) -> Light {
    let kind = LightKind::Directional { direction: Vec3::NEG_Z };
    Light { name: name.into(), kind, ambient: Vec3::ZERO, diffuse: Vec3::ONE, specular: Vec3::ONE, shape: None }
}

/// A model of a file that reads as what is in `next`, and a flag that saving sets.
fn model(next: &Arc<Mutex<Result<Scene, String>>>) -> (Model, Arc<AtomicBool>) {
    let (next, saved) = (Arc::clone(next), Arc::new(AtomicBool::new(false)));
    let flag = Arc::clone(&saved);
    let options = Options {
        files: vec!["model.aam".into()],
        size: [100, 100],
        msaa: Msaa::X1,
        opener: Arc::new(move |_, _| {
            let scene = next.lock().expect("not poisoned").clone()?;
            Ok(Opened { scene, ..Opened::default() })
        }),
        saver: Arc::new(move |_, before, after, _| {
            assert_ne!(before.lights, after.lights);
            flag.store(true, Ordering::SeqCst);
            Ok("model.scene.toml".into())
        }),
        formats: String::new(),
    };
    let mut model = Model::new(&options, Arc::new(|| {}), Arc::new(|| {}));
    settle(&mut model);
    (model, saved)
}

fn settle(model: &mut Model) {
    let start = Instant::now();
    while model.loading().is_some() {
        model.take_finished();
        assert!(start.elapsed() < Duration::from_secs(10), "nothing was opened");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn opened(model: &Model) -> &Scene {
    &model.opened.as_ref().expect("a scene").scene
}

#[test]
fn what_the_user_changed_outlives_a_reload() {
    let next = Arc::new(Mutex::new(Ok(scene(&["a", "b"]))));
    let (mut model, _) = model(&next);
    model.opened.as_mut().expect("a scene").scene.nodes[1].visible = false;
    model.visibility_changed();
    model.set_lights(vec![light("key")]);
    model.selected = Some(NodeId(1));
    let eye = model.eye.camera();
    *next.lock().expect("not poisoned") = Ok(scene(&["b", "c", "a"]));
    model.reload();
    settle(&mut model);
    let visible: Vec<bool> = opened(&model).nodes.iter().map(|node| node.visible).collect();
    assert_eq!(visible, [false, true, true], "b stays hidden where it now stands");
    assert_eq!(opened(&model).lights, [light("key")]);
    assert_eq!(model.selected, Some(NodeId(0)));
    assert_eq!(model.eye.camera().position, eye.position, "the camera stays");
    model.open(Path::new("other.aam"));
    settle(&mut model);
    assert!(opened(&model).lights.is_empty() && model.selected.is_none(), "another file starts afresh");
}

#[test]
fn shadows_are_edited_shown_and_saved() {
    let lit = || Scene { lights: vec![light("a"), light("b"), light("c")], ..scene(&["a", "b"]) };
    let next = Arc::new(Mutex::new(Ok(lit())));
    let (mut model, saved) = model(&next);
    model.act(Action::Shadows);
    let names = |model: &Model| -> Vec<String> {
        let sources = model.shadows().map_or(&[][..], |shadows| &shadows.sources);
        sources.iter().map(|source| format!("{} {:?}", source.name, source.light)).collect()
    };
    assert_eq!(names(&model), ["a Some(0)", "b Some(1)", "c Some(2)"], "every light gets one");
    assert!(model.unsaved && !model.display.no_shadows);
    model.act(Action::Shadows);
    assert!(model.display.no_shadows && names(&model).len() == 3, "hidden, not gone");
    model.act(Action::Shadows);

    model.light_removed(1);
    model.set_lights(vec![light("a"), light("c")]);
    assert_eq!(names(&model), ["a Some(0)", "c Some(1)"], "the shadow goes with its light");
    let mut shadows = model.shadows().cloned().expect("shadows");
    shadows.casters = Members::Only(vec![NodeId(1)]);
    model.set_shadows(Some(shadows));
    *next.lock().expect("not poisoned") = Ok(Scene { nodes: scene(&["b", "c", "a"]).nodes, ..lit() });
    model.reload();
    settle(&mut model);
    assert_eq!(names(&model), ["a Some(0)", "c Some(1)"]);
    assert_eq!(
        model.shadows().expect("shadows").casters,
        Members::Only(vec![NodeId(0)]),
        "b casts where it now stands"
    );
    model.act(Action::Save);
    assert!(saved.load(Ordering::SeqCst));
}

#[test]
fn the_view_of_a_source_ends_with_the_next_move() {
    let next = Arc::new(Mutex::new(Ok(Scene { lights: vec![light("a")], ..scene(&["a"]) })));
    let (mut model, _) = model(&next);
    model.act(Action::LightView);
    assert!(model.light_view.is_none() && model.notice().is_some(), "there is no source");
    let volume = model.eye.camera();
    let source = ShadowSource { volume: Some(volume.clone()), ..ShadowSource::of_light(0, ShadowSettings::default()) };
    model.set_shadows(Some(Shadows { sources: vec![source], ..Shadows::default() }));
    model.act(Action::LightView);
    assert_eq!((model.light_view, model.step()), (Some(0), Some(Step::LightView)));
    assert_eq!(model.camera().position, volume.position);
    model.act(Action::LookFrom(Side::Top));
    assert_eq!((model.light_view, model.step()), (None, Some(Step::Shadowed)));
    for (step, _, _) in Step::ALL {
        model.show_step(step);
        assert_eq!(model.step(), Some(step));
    }
}

#[test]
fn a_broken_file_keeps_the_last_good_one() {
    let next = Arc::new(Mutex::new(Ok(scene(&["a"]))));
    let (mut model, _) = model(&next);
    *next.lock().expect("not poisoned") = Err("line 3".into());
    model.reload();
    settle(&mut model);
    assert_eq!(model.problem.as_deref(), Some("line 3"));
    assert_eq!(opened(&model).nodes.len(), 1);
    *next.lock().expect("not poisoned") = Ok(scene(&["a", "b"]));
    model.reload();
    settle(&mut model);
    assert!(model.problem.is_none() && opened(&model).nodes.len() == 2);
}

#[test]
fn unsaved_changes_ask_once() {
    let next = Arc::new(Mutex::new(Ok(scene(&["a"]))));
    let (mut model, saved) = model(&next);
    assert!(model.may_quit());
    model.set_lights(vec![light("key")]);
    assert!(model.title().starts_with('*') && !model.may_quit() && model.may_quit());
    model.act(Action::Save);
    assert!(saved.load(Ordering::SeqCst) && !model.unsaved);
}

#[test]
fn only_layers_that_are_there_are_cycled_through() {
    let mut made = scene(&["a"]);
    let texture = TextureLayer {
        texture: TextureId(0),
        transform: Mat3::IDENTITY,
        normal_space: Default::default(),
        intensity: 1.0,
    };
    made.materials.push(Material { layers: [Some(texture), None, Some(texture), None], ..Material::default() });
    let (mut model, _) = model(&Arc::new(Mutex::new(Ok(made))));
    let shown: Vec<Show> = (0..3)
        .map(|_| {
            model.act(Action::NextLayer);
            model.display.show
        })
        .collect();
    assert_eq!(shown, [Show::Layer(Layer::Diffuse), Show::Layer(Layer::Normal), Show::Lit]);
}
