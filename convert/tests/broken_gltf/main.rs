//! Broken glTF, made from a valid file: each is refused with the place named, or read with a line in the report. That a
//! file is broken in the way its row says, the Khronos validator confirms.

mod animations;
mod containers;
mod contents;
mod data;
mod harmless;
mod images;
mod links;
mod structure;

#[path = "../../src/gltf_in/tests/builder.rs"]
#[allow(dead_code, reason = "the importer's own tests use the rest")]
mod builder;
#[path = "../gltf_out/validator.rs"]
#[allow(dead_code, reason = "the exporter's tests use the rest")]
mod validator;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use aam_convert::{ConvertError, ImportOptions, Silent, import_bytes};
use serde_json::{Value, json};

use builder::{Builder, png};

impl Builder {
    /// Overwrites bytes of an accessor's view.
    fn patch(&mut self, accessor: usize, at: usize, bytes: &[u8]) {
        let view = self.json["accessors"][accessor]["bufferView"].as_u64().expect("a view") as usize;
        let start = self.json["bufferViews"][view]["byteOffset"].as_u64().expect("an offset") as usize + at;
        self.bin[start..start + bytes.len()].copy_from_slice(bytes);
    }
}

/// A broken file.
struct Case {
    /// What the validator says of it; empty where it finds no fault.
    code: &'static str,
    /// What is wrong.
    name: &'static str,
    /// What the importer does.
    outcome: Outcome,
    bytes: Vec<u8>,
}

/// What the importer does with a broken file.
enum Outcome {
    /// Refuses it; the place starts with the first, and the message has the second in it.
    Refused(&'static str, &'static str),
    /// Reads it, since the fault does no harm; the report has a line with this in it, or says nothing where it is empty.
    Read(&'static str),
}

/// A file that is refused at a place, with words in the message, after edits of the JSON.
fn case(
    code: &'static str,
    name: &'static str,
    place: &'static str,
    says: &'static str,
    start: &Builder,
    edits: &[(&str, Value)],
) -> Case {
    let mut file = start.clone();
    for (pointer, value) in edits {
        file.set(pointer, value.clone());
    }
    Case { code, name, outcome: Outcome::Refused(place, says), bytes: file.glb() }
}

fn cases() -> Vec<Case> {
    let file = Builder::rich();
    [
        containers::cases(&file),
        structure::cases(&file),
        contents::cases(&file),
        animations::cases(&file),
        images::cases(&file),
        links::cases(&file),
        data::cases(&file),
        harmless::cases(&file),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Imports bytes from a folder where nothing is.
fn import(bytes: &[u8]) -> Result<aam_convert::Asset, ConvertError> {
    import_bytes(bytes.to_vec(), Path::new("/nonexistent/broken.gltf"), &ImportOptions::default(), &Silent)
}

#[test]
fn the_valid_file_is_read() {
    import(&Builder::rich().glb()).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn every_fault_names_its_place() {
    let cases = cases();
    let refused = cases.iter().filter(|case| matches!(case.outcome, Outcome::Refused(..))).count();
    let codes: BTreeSet<&str> = cases.iter().map(|case| case.code).filter(|code| !code.is_empty()).collect();
    println!("{} broken files of {} codes, {refused} of them refused", cases.len(), codes.len());
    assert!(refused >= 150 && codes.len() >= 110);
    let names: BTreeSet<&str> = cases.iter().map(|case| case.name).collect();
    assert_eq!(names.len(), cases.len(), "a name stands twice");
    let mut wrong = Vec::new();
    for Case { code, name, outcome, bytes } in cases {
        let found = import(&bytes);
        let right = match (&outcome, &found) {
            (Outcome::Refused(place, says), Err(ConvertError::Broken { place: found, message, .. })) => {
                found.starts_with(place) && message.contains(says)
            }
            (Outcome::Refused(place, says), Err(ConvertError::Unsupported { feature, .. })) => {
                place.is_empty() && feature.contains(says)
            }
            (Outcome::Read(""), Ok(_)) => true,
            (Outcome::Read(says), Ok(asset)) => {
                asset.report.changes.iter().any(|change| change.note.contains(says) || change.property.contains(says))
            }
            _ => false,
        };
        if !right {
            let found = match found {
                Ok(asset) => format!("read: {:?}", asset.report.changes),
                Err(error) => error.to_string(),
            };
            wrong.push(format!("{code} {name}: {found}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_validator_finds_the_same_faults() {
    let folder = tempfile::tempdir().unwrap();
    let cases = cases();
    let mut files = vec![folder.path().join("valid.glb")];
    std::fs::write(&files[0], Builder::rich().glb()).unwrap();
    for (number, case) in cases.iter().enumerate() {
        // The validator tells the container by the first byte, as the importer does.
        let file = folder.path().join(format!("{number}.glb"));
        std::fs::write(&file, &case.bytes).unwrap();
        files.push(file);
    }
    let Some(verdicts) = validator::validate(&files) else { return };
    assert_eq!(verdicts[0].errors, 0, "{:?}", verdicts[0].messages);
    let clean: BTreeSet<String> = verdicts[0].messages.iter().map(|message| message.code.clone()).collect();
    let mut wrong = Vec::new();
    for (case, verdict) in cases.iter().zip(&verdicts[1..]) {
        let mut found: BTreeMap<&str, u8> = BTreeMap::new();
        for message in verdict.messages.iter().filter(|message| !clean.contains(&message.code)) {
            found.insert(&message.code, message.severity);
        }
        let errors = found.values().any(|severity| *severity == 0);
        if if case.code.is_empty() { errors } else { !found.contains_key(case.code) } {
            wrong.push(format!("{:?} {}: {found:?}", case.code, case.name));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
