//! `aam simulate` as a user meets it.

mod common;

use std::path::Path;

use common::{Folder, SQUARE};

#[test]
fn the_fixture_comes_to_rest_and_has_one_hash() {
    let folder = Folder::new();
    let file = folder.fixture("physics.aam");
    let said = folder.aam(&["simulate", &file, "--time", "2"]).succeeds();
    said.says("dynamic").says("kinematic").says("120 steps").says("Domino 1").says("asleep");
    // Each run is a process of its own.
    let hash = |more: &[&str]| {
        let run = folder.aam(&[&["-q", "simulate", &file, "--time", "2", "--hash"], more].concat()).succeeds();
        assert_eq!(run.out.trim().len(), 16, "{}", run.out);
        run.out
    };
    let first = hash(&[]);
    assert_eq!(hash(&[]), first);
    assert_eq!(hash(&["-o", "a.csv", "--fps", "13"]), first, "an output changes nothing");
    assert_ne!(hash(&["--dt", "1/120"]), first);
    assert_ne!(hash(&["--gravity", "0,0,-1.62"]), first);
    assert_ne!(hash(&["--iterations", "8"]), first);
}

#[test]
fn poses_are_written_as_json_and_csv() {
    let folder = Folder::new();
    let file = folder.fixture("physics.aam");
    let run = |output: &str| folder.aam(&["simulate", &file, "-o", output, "--time", "1", "--fps", "10"]).succeeds();
    run("a.json").says("a.json").says("11 frames");
    let json: serde_json::Value = serde_json::from_slice(&folder.read("a.json")).expect("JSON");
    let (bodies, frames) = (json["bodies"].as_array().expect("bodies"), json["frames"].as_array().expect("frames"));
    assert_eq!((frames.len(), json["steps"].as_u64()), (11, Some(60)));
    assert!((frames[3]["time"].as_f64().expect("a time") - 0.3).abs() < 1e-6);
    assert!(frames.iter().all(|frame| frame["poses"].as_array().map(Vec::len) == Some(bodies.len())));
    let ball = bodies.iter().position(|body| body["name"] == "Steel Ball").expect("the ball");
    let height = |frame: usize| frames[frame]["poses"][ball]["position"][2].as_f64().expect("a height");
    assert!(height(10) < height(0) - 0.02, "it rolls off the seesaw: {} to {}", height(0), height(10));
    assert_eq!(json["stopped"], serde_json::Value::Null);
    run("a.csv");
    let csv = String::from_utf8(folder.read("a.csv")).expect("text");
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("time,node,name,x,y,z,qx,qy,qz,qw"));
    assert_eq!(lines.count(), 11 * bodies.len());
}

#[test]
fn what_was_simulated_plays_as_aam_and_glb() {
    let folder = Folder::new();
    let file = folder.fixture("physics.aam");
    for output in ["fall.aam", "fall.glb"] {
        folder.aam(&["simulate", &file, "-o", output, "--time", "1", "--fps", "10"]).succeeds().says("11 frames");
    }
    folder.aam(&["check", "fall.aam", "--strict", "--ignore", "texture/missing"]).succeeds();
    // Both show the same motion, and it is that of the poses.
    folder.aam(&["convert", "fall.glb", "back.aam", "--hierarchy", "--fps", "10"]).succeeds();
    let (before, after) =
        (folder.aam(&["info", &file, "--json"]).json(), folder.aam(&["info", "fall.aam", "--json"]).json());
    assert_eq!(before["triangles"], after["triangles"]);
    assert_eq!(folder.aam(&["info", "fall.glb", "--json"]).json()["triangles"], after["triangles"]);
    let picture = |file: &str, frame: &str| {
        // `file` is a path into the fixtures, where nothing is written.
        let name = format!("at-{}-{frame}.png", Path::new(file).file_stem().expect("a name").to_string_lossy());
        let view =
            ["--engine", "reference", "--samples", "1", "--size", "160x120", "--camera-position", "0.8,-2.6,1.5"];
        let place = ["render", file, "-o", &name, "--frame", frame, "--camera-target", "0,0,0"];
        folder.aam(&[&place[..], &view].concat()).succeeds();
        folder.picture(&name).to_rgba8().into_raw()
    };
    let differ = |a: &[u8], b: &[u8]| {
        let far = a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 24).count();
        far as f64 / a.len() as f64
    };
    let start = picture(&file, "0");
    let (first, last) = (picture("fall.aam", "0"), picture("fall.aam", "10"));
    assert!(differ(&start, &first) < 0.002, "it begins as the file is drawn: {}", differ(&start, &first));
    assert!(differ(&first, &last) > 0.005, "things have moved: {}", differ(&first, &last));
    let glb = picture("back.aam", "10");
    assert!(differ(&last, &glb) < 0.02, "as GLB it ends the same way: {}", differ(&last, &glb));
}

#[test]
fn what_was_simulated_is_drawn() {
    let folder = Folder::new();
    let file = folder.fixture("physics.aam");
    let pictures = ["simulate", &file, "-o", "fall.png", "--time", "1", "--fps", "2", "--size", "160x120"];
    folder.aam(&pictures).succeeds().says("fall.png").says("3 frames");
    let pixels = |name: &str| folder.picture(name).to_rgba8().into_raw();
    let (first, last) = (pixels("fall_00.png"), pixels("fall_02.png"));
    assert_eq!(first.len(), 160 * 120 * 4);
    let changed = first.iter().zip(&last).filter(|(a, b)| a.abs_diff(**b) > 24).count();
    assert!(changed > 100, "things have moved: {changed} values");
    assert!(!folder.has("fall_03.png"));
}

#[test]
fn a_scene_has_the_bodies_of_all_its_assets() {
    let folder = Folder::new();
    let file = folder.fixture("physics.aam");
    folder.write(
        "two.scene.toml",
        &format!("[[asset]]\npath = {file:?}\n[[asset]]\npath = {file:?}\nposition = [9, 0, 1]\nscale = [2, 2, 2]\n"),
    );
    let count = |file: &str| {
        folder.aam(&["simulate", file, "-o", "a.json", "--time", "0.5", "--fps", "2"]).succeeds();
        let json: serde_json::Value = serde_json::from_slice(&folder.read("a.json")).expect("JSON");
        let masses = json["bodies"].as_array().expect("bodies").iter().map(|body| body["mass"].as_f64().expect("kg"));
        (json["bodies"].as_array().map_or(0, Vec::len), masses.sum::<f64>())
    };
    let (one, two) = (count(&file), count("two.scene.toml"));
    assert_eq!(two.0, 2 * one.0);
    assert!((two.1 / one.1 - 9.0).abs() < 1e-3, "the second weighs eight times as much: {} of {}", two.1, one.1);
    folder.aam(&["simulate", "two.scene.toml", "-o", "a.glb"]).fails(2).says("several assets").says(".json");
}

#[test]
fn a_body_that_is_lost_stops_it_with_exit_code_1() {
    let folder = Folder::new();
    let file = folder.fixture("physics.aam");
    let lost = ["simulate", &file, "--gravity", "0,0,9.81", "--time", "10", "--max-distance", "20", "-o", "a.csv"];
    folder.aam(&lost).fails(1).says("stopped at step").says("is lost");
    assert!(folder.has("a.csv"), "what was simulated until then is written");
}

#[test]
fn what_cannot_be_simulated_is_said() {
    let folder = Folder::new();
    folder.write("a.aam", SQUARE);
    folder.aam(&["simulate", "a.aam"]).fails(2).says("no bodies").says("--physics");
    folder.aam(&["simulate", "nothing.aam"]).fails(2).says("nothing.aam");
    let file = folder.fixture("physics.aam");
    folder.aam(&["simulate", &file, "-o", "a.jpg"]).fails(2).says("a.jpg").says(".csv");
    folder.aam(&["simulate", &file, "-o", "nowhere/a.csv"]).fails(2).says("nowhere");
    folder.aam(&["simulate", &file, "-o", "a.csv", "--fps", "1000", "--time", "1e7"]).fails(2).says("--fps");
    for (option, value) in
        [("--dt", "0"), ("--dt", "1/0"), ("--time", "0"), ("--steps", "0"), ("--gravity", "1,2"), ("--iterations", "0")]
    {
        folder.aam(&["simulate", &file, option, value]).fails(2).says(option);
    }
}
