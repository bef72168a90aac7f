//! What glTF has no word for, kept in `extras` under the key `AAM`, so that nothing of the document is gone.
//!
//! | where | members of `AAM` |
//! |---|---|
//! | the file | `header` (`AAM_MESH` …), `encoding` (`BINARY`), `MATERIALS`: that section's text as an AAM file has it, `SmGEnabled`, `unknown`: lines by section |
//! | a material | `material`: the way to it, the position in `MATERIALS` and then in each Multi; `textures`: for each layer that glTF shows otherwise or not at all (`Tx TS TN TD`) its picture in `textures` and its `texCoord` set; or `default: true` for an object's missing material |
//! | a node of an object | `id`, `MatID`, `UserProp`, `TF BI SC`, `Piv`, `unknown` |
//! | a node of a body's shape | `body`: the object's id |
//! | a light | `ambient`, `specular`, `falloff`, `shape` |
//! | a camera | `target`: the distance of the point looked at |
//!
//! `unknown` lists lines that this program did not know, each with the tag that it stands `before` (its first `occurrence`
//! unless another is given).

use aam::document::{Encoding, Object, Unknown};
use aam::{Document, WriteOptions, write};
use serde_json::{Map, Value, json};

/// The key.
const KEY: &str = "AAM";

/// `{"AAM": members}`, or `None` without members.
pub(super) fn wrap(members: Map<String, Value>) -> Option<Value> {
    (!members.is_empty()).then(|| json!({ KEY: members }))
}

/// Unknown lines; `None` where there are none.
pub(super) fn unknown(lines: &[Unknown]) -> Option<Value> {
    let one = |unknown: &Unknown| {
        let lines: Vec<String> = unknown.lines().map(|line| aam::Text::from(line).decoded()).collect();
        match unknown.before {
            Some((tag, 0)) => json!({ "before": tag, "lines": lines }),
            Some((tag, occurrence)) => json!({ "before": tag, "occurrence": occurrence, "lines": lines }),
            None => json!({ "lines": lines }),
        }
    };
    (!lines.is_empty()).then(|| lines.iter().map(one).collect())
}

/// Of the document as a whole.
pub(super) fn of_document(document: &Document) -> Option<Value> {
    let mut members = Map::new();
    if let Some(header) = document.header {
        members.insert("header".into(), header.word().into());
    }
    if document.encoding == Encoding::Binary {
        members.insert("encoding".into(), "BINARY".into());
    }
    if let Some(text) = materials_text(document) {
        members.insert("MATERIALS".into(), text.into());
    }
    if document.geometry.smoothing_groups {
        members.insert("SmGEnabled".into(), true.into());
    }
    let mut rest = Map::new();
    let frames = document.geometry.frames.iter();
    let mut sections = vec![
        ("preamble".to_owned(), unknown(&document.preamble)),
        ("GEOMETRY".to_owned(), unknown(&document.geometry.unknown)),
        ("PHYSICS".to_owned(), document.physics.as_ref().and_then(|physics| unknown(&physics.unknown))),
    ];
    sections.extend(frames.map(|frame| (format!("Frame: {}", frame.number), unknown(&frame.unknown))));
    rest.extend(sections.into_iter().filter_map(|(name, lines)| Some((name, lines?))));
    if !rest.is_empty() {
        members.insert("unknown".into(), rest.into());
    }
    wrap(members)
}

/// The `MATERIALS` section as an AAM file has it.
fn materials_text(document: &Document) -> Option<String> {
    if document.materials.is_empty() {
        return None;
    }
    let alone = Document {
        materials: document.materials.clone(),
        materials_unknown: document.materials_unknown.clone(),
        ..Document::default()
    };
    let bytes = write(&alone, &WriteOptions::default()).ok()?;
    let text = aam::Text::from(bytes.as_slice()).decoded();
    let end = text.find("ENDMATERIALS")? + "ENDMATERIALS\n".len();
    text.get(..end).map(str::to_owned)
}

/// Of an object. `position` is where it stands in frame 0.
pub(super) fn of_object(object: &Object, position: usize) -> Option<Value> {
    let mut members = Map::new();
    if usize::try_from(object.id) != Ok(position) {
        members.insert("id".into(), object.id.into());
    }
    if object.material != -1 {
        members.insert("MatID".into(), object.material.into());
    }
    if let Some(text) = &object.user_properties {
        members.insert("UserProp".into(), text.decoded().into());
    }
    if let Some(displacement) = &object.displacement {
        members.insert("TF".into(), displacement.tessellation.into());
        members.insert("BI".into(), number(displacement.bias));
        members.insert("SC".into(), number(displacement.scale));
    }
    if let Some(node) = &object.node {
        let pivot: Vec<f32> = node.pivot_position.into_iter().chain(node.pivot_orientation).collect();
        if pivot.iter().any(|value| *value != 0.0) {
            members.insert("Piv".into(), numbers(&pivot));
        }
    }
    if let Some(lines) = unknown(&object.unknown) {
        members.insert("unknown".into(), lines);
    }
    wrap(members)
}

/// A number as JSON; null where it is none. By way of its decimal: as 64 bits, the 0.1 of 32 bits is 0.10000000149011612.
pub(super) fn number(value: f32) -> Value {
    value.to_string().parse::<f64>().ok().filter(|value| value.is_finite()).map_or(Value::Null, Value::from)
}

/// Numbers as a JSON list.
pub(super) fn numbers(values: &[f32]) -> Value {
    values.iter().map(|&value| number(value)).collect()
}
