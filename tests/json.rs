//! What the command writes as JSON is what the schemas in `docs/` say, no more and no less.

mod common;

use std::fs;

use common::schema::Schema;
use common::{Folder, SQUARE, fixture};
use serde_json::{Value, json};

/// Every fixture that is one asset.
fn assets() -> Vec<String> {
    let folder = fixture("");
    let names = fs::read_dir(folder).expect("fixtures").map(|entry| entry.expect("an entry").file_name());
    let names = names.map(|name| name.into_string().expect("a name"));
    let mut names: Vec<String> =
        names.filter(|name| [".aam", ".gltf", ".glb", ".obj"].iter().any(|end| name.ends_with(end))).collect();
    names.sort();
    assert!(names.len() > 10, "{names:?}");
    names
}

/// The square with numbers that are none, and parts that do not fit.
fn hostile() -> String {
    let texture =
        "Tx: Y\n{\nFN: nothing.png\nFi: A\nIn: nan\nUA: nan\nVA: inf\nWA: nan\nUO: 0\nVO: 0\nUT: nan\nVT: 1\n}";
    SQUARE
        .replace("Tr: 0.0", "Tr: nan")
        .replace("Sh: 0.0", "Sh: inf")
        .replace("Sp: 0.0 0.0 0.0", "Sp: nan 1e39 -1")
        .replace("Animation_mode: None", "Animation_mode: None\nFPS: nan")
        .replace("1.0 0.0 1.0", "nan inf -inf")
        .replace("Par: -1", "Par: 7")
        .replace("Tx: N", texture)
}

#[test]
fn findings_are_as_their_schema_says() {
    let folder = Folder::new();
    folder.write("clean.aam", SQUARE);
    folder.write("hostile.aam", &hostile());
    folder.write("broken.aam", "MATERIALS\nMatCount: x\n");
    folder.write("multiframe.aam", &SQUARE.replace("Frame: 0", "Frame: 4"));
    let mut schema = Schema::of_docs("checks.schema.json");
    let files = ["clean.aam", "hostile.aam", "broken.aam", "multiframe.aam"];
    let output = folder.aam(&[&["check", "--json"], &files[..]].concat()).json();
    schema.accepts(&output);
    schema.is_used_up();
    assert_eq!(output.as_array().map(Vec::len), Some(4));
    assert_eq!((&output[1]["readable"], &output[2]["readable"]), (&json!(true), &json!(false)));
    let counts = ["errors", "warnings", "infos"].map(|name| output[1][name].as_u64().expect("a count"));
    assert_eq!(counts.iter().sum::<u64>() as usize, output[1]["findings"].as_array().expect("a list").len());
    for name in assets().iter().filter(|name| name.ends_with(".aam")) {
        schema.accepts(&folder.aam(&["check", "--json", &folder.fixture(name)]).json());
    }
    schema.accepts(&folder.aam(&["check", "--json", "nothing.aam"]).fails(2).json());
}

#[test]
fn info_is_as_its_schema_says() {
    let folder = Folder::new();
    folder.write("hostile.aam", &hostile());
    let mut schema = Schema::of_docs("info.schema.json");
    schema.accepts(&folder.aam(&["info", "--json", "hostile.aam"]).succeeds().json());
    for name in assets() {
        schema.accepts(&folder.aam(&["info", "--json", &folder.fixture(&name)]).succeeds().json());
    }
    schema.is_used_up();
}

#[test]
fn reports_are_as_their_schema_says() {
    let folder = Folder::new();
    let mut schema = Schema::of_docs("report.schema.json");
    let mut report = |arguments: &[&str]| {
        folder.aam(&[&["convert", "--report", "report.json", "--force"], arguments].concat()).succeeds();
        let report: Value = serde_json::from_slice(&folder.read("report.json")).expect("JSON");
        schema.accepts(&report);
        report
    };
    for name in assets().iter().filter(|name| !name.ends_with(".aam")) {
        report(&[&folder.fixture(name), "out.aam"]);
    }
    for name in ["materials.aam", "physics.aam", "displaced.aam"] {
        for output in ["out.glb", "out.obj"] {
            report(&[&folder.fixture(name), output]);
        }
    }
    let several = report(&[&folder.fixture("crate.glb"), &folder.fixture("room.aam"), "-o", "out"]);
    assert_eq!(several.as_array().map(Vec::len), Some(2));
    schema.is_used_up();
}

#[test]
fn schemas_refuse_what_is_not_so() {
    let folder = Folder::new();
    folder.write("odd.aam", &hostile());
    let mut schema = Schema::of_docs("checks.schema.json");
    let output = folder.aam(&["check", "--json", "odd.aam"]).json();
    schema.accepts(&output);
    for (pointer, value) in [
        ("/0/errors", json!(-1)),
        ("/0/errors", json!("none")),
        ("/0/readable", json!(null)),
        ("/0/findings/0/severity", json!("fatal")),
        ("/0/findings/0/position", json!({ "line": 0, "column": 1 })),
        ("/0/findings/0/position", json!({ "line": 1 })),
        ("/0/findings/0", json!({})),
        ("/0", json!([])),
    ] {
        let mut wrong = output.clone();
        *wrong.pointer_mut(pointer).expect("a place") = value;
        assert!(schema.refuses(&wrong), "{pointer}");
    }
    let mut more = output;
    more[0]["surprise"] = json!(1);
    assert!(schema.refuses(&more));
}
