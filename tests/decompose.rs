//! `aam decompose`: outputs, report, limits and messages.

mod common;

use common::Folder;
use common::schema::Schema;
use serde_json::Value;

/// A beam and a post on it, as one object: two hulls hold it exactly.
const T: &str = "\
o T
v 0 0 0\nv 4 0 0\nv 4 1 0\nv 0 1 0\nv 0 0 1\nv 4 0 1\nv 4 1 1\nv 0 1 1
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8
v 1.5 0 1\nv 2.5 0 1\nv 2.5 1 1\nv 1.5 1 1\nv 1.5 0 3\nv 2.5 0 3\nv 2.5 1 3\nv 1.5 1 3
f 9 12 11 10\nf 13 14 15 16\nf 9 10 14 13\nf 10 11 15 14\nf 11 12 16 15\nf 12 9 13 16
";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("t.obj", T);
    folder
}

#[test]
fn hulls_go_to_each_format() {
    let folder = folder();
    folder.aam(&["decompose", "t.obj", "-o", "t.aam"]).succeeds().says("2 hulls");
    folder.aam(&["check", "t.aam", "--strict"]).succeeds();
    assert_eq!(folder.aam(&["info", "t.aam", "--json"]).succeeds().json()["bodies"], serde_json::json!([0, 0, 1]));
    folder.aam(&["decompose", "t.obj", "-o", "t.obj.obj"]).succeeds();
    let text = String::from_utf8_lossy(&folder.read("t.obj.obj")).into_owned();
    let names: Vec<&str> = text.lines().filter(|line| line.starts_with("o ")).collect();
    assert_eq!(names, ["o T_hull_0", "o T_hull_1"]);
    assert_eq!(text.lines().filter(|line| line.starts_with("v ")).count(), 16);
    folder.aam(&["decompose", "t.obj", "-o", "t.glb"]).succeeds();
    let text = String::from_utf8_lossy(&folder.read("t.glb")).into_owned();
    assert!(text.contains("KHR_physics_rigid_bodies") && text.contains("\"convexHull\":true"));
    folder.aam(&["decompose", "t.obj", "-o", "t.json"]).succeeds();
    let json: Value = serde_json::from_slice(&folder.read("t.json")).expect("JSON");
    assert_eq!(json["objects"][0]["hulls"][0]["vertices"].as_array().expect("vertices").len(), 8);
    assert_eq!(json["objects"][0]["hulls"][0]["volume"], 4.0);
}

#[test]
fn the_report_is_as_its_schema_says() {
    let folder = folder();
    let mut schema = Schema::of_docs("decompose.schema.json");
    let report = |more: &[&str]| -> Value {
        let words = [&["decompose", "t.obj", "-o", "t.aam", "--report", "r.json"], more].concat();
        folder.aam(&words).succeeds();
        serde_json::from_slice(&folder.read("r.json")).expect("JSON")
    };
    let exact = report(&[]);
    schema.accepts(&exact);
    let object = &exact["objects"][0];
    assert_eq!((object["hulls"].as_array().expect("hulls").len(), object["vertices"].as_u64()), (2, Some(16)));
    assert!((object["volume_ratio"].as_f64().expect("closed") - 1.0).abs() < 1e-6);
    assert!(exact["hausdorff_percent"].as_f64().expect("a number") < 1e-3);
    let one = report(&["--hulls", "1", "--max-verts-per-hull", "8"]);
    schema.accepts(&one);
    let hull = &one["objects"][0]["hulls"][0];
    // The hull of a T is far from its inner corners.
    assert!(hull["vertices"] == 8 && hull["outside"]["max_percent"].as_f64().expect("a number") > 10.0, "{one:#}");
    let simple = report(&["--primitives"]);
    schema.accepts(&simple);
    assert_eq!(simple["objects"][0]["hulls"][0]["primitive"], "box");
    schema.is_used_up();
}

#[test]
fn simple_shapes_are_in_the_files() {
    let folder = folder();
    folder.aam(&["decompose", "t.obj", "-o", "t.aam", "--primitives"]).succeeds().says("2 simple shapes");
    folder.aam(&["check", "t.aam", "--strict"]).succeeds();
    let text = String::from_utf8_lossy(&folder.read("t.aam")).into_owned();
    assert!(text.contains("NPrim: 2") && !text.contains("NConvex"), "{text}");
    folder.aam(&["simulate", "t.aam", "--steps", "3", "--hash"]).succeeds();
    folder.aam(&["decompose", "t.obj", "-o", "t.glb", "--primitives"]).succeeds();
    assert!(String::from_utf8_lossy(&folder.read("t.glb")).contains("KHR_implicit_shapes"));
    folder.aam(&["decompose", "t.obj", "-o", "h.obj", "--primitives"]).succeeds().says("OBJ has no simple shapes");
}

#[test]
fn convert_takes_the_same_limits() {
    let folder = folder();
    let convert = |more: &[&str]| {
        folder.aam(&[&["convert", "t.obj", "c.aam", "--physics", "dynamic"], more].concat()).succeeds();
        folder.read("c.aam")
    };
    for limits in [&["--max-error", "2"][..], &["--max-error", "2%"], &["--hulls", "1"], &["--primitives"]] {
        folder.aam(&[&["decompose", "t.obj", "-o", "d.aam"], limits].concat()).succeeds();
        assert!(convert(limits) == folder.read("d.aam"), "{limits:?}");
    }
    folder.aam(&["convert", "t.obj", "c.aam", "--hulls", "3"]).fails(2).says("--physics dynamic");
}

#[test]
fn what_cannot_be_decomposed_is_said() {
    let folder = folder();
    folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
    folder.write("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    folder.aam(&["decompose", "flat.obj", "-o", "a.aam"]).fails(2).says("it is flat");
    folder.aam(&["decompose", "line.obj", "-o", "a.aam"]).fails(2).says("no triangle with an area");
    folder.aam(&["decompose", "nothing.obj", "-o", "a.aam"]).fails(2).says("nothing.obj");
    folder.aam(&["decompose", "t.obj", "-o", "a.stl"]).fails(2).says(".aam .glb .gltf .obj .json");
    folder.aam(&["decompose", "t.obj", "-o", "t.obj"]).fails(2).says("replace its input");
    folder.aam(&["decompose", "t.obj", "-o", "no/t.aam"]).fails(2).says("mkdir -p");
    folder.aam(&["decompose", "t.obj", "-o", "r.json", "--report", "r.json"]).fails(2).says("replace the output");
    folder.aam(&["decompose", "t.obj", "-o", "a.aam", "--mode", "static"]).fails(2).says("--mode dynamic");
    for (option, value) in [
        ("--hulls", "0"),
        ("--max-error", "0"),
        ("--max-error", "101"),
        ("--max-verts-per-hull", "3"),
        ("--max-verts-per-hull", "256"),
    ] {
        folder.aam(&["decompose", "t.obj", "-o", "a.aam", option, value]).fails(2).says(option);
    }
    assert!(!folder.has("a.aam"));
    let missed = ["decompose", "t.obj", "-o", "a.aam", "--hulls", "1", "--max-error", "1"];
    folder.aam(&missed).succeeds().says("1.00 % is not reached");
}
