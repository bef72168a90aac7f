//! Tests on small files that are built here, and on real ones.

mod accessors;
mod animation;
mod bones;
mod broken;
mod corpus;
mod geometry;
mod materials;
mod nodes;
mod outfits;
mod places;
mod textures;

use std::path::PathBuf;

use aam::Limits;
use aam::document::{MaterialBody, Object, SingleMaterial};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::{Asset, ConvertError, ImportOptions, Outcome, Silent};

/// Default options but for the limits.
pub(super) fn limited(limits: Limits) -> ImportOptions {
    ImportOptions { limits, ..ImportOptions::default() }
}

/// A glTF file in the making: JSON and one binary buffer.
#[derive(Clone, Debug)]
pub(super) struct Builder {
    pub(super) json: Value,
    pub(super) bin: Vec<u8>,
}

impl Builder {
    /// A file with nothing but its version.
    pub(super) fn new() -> Self {
        Self { json: json!({ "asset": { "version": "2.0" } }), bin: Vec::new() }
    }

    /// A file with one triangle, (0,0,0) (1,0,0) (0,1,0), shown by one node.
    pub(super) fn triangle() -> Self {
        let mut file = Self::new();
        let positions = file.vec3(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        file.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": positions } }] }));
        file.push("nodes", json!({ "mesh": 0 }));
        file
    }

    /// Adds an element to a list of the file.
    pub(super) fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.list(list);
        list.push(value);
        list.len() - 1
    }

    fn list(&mut self, list: &str) -> &mut Vec<Value> {
        let object = self.json.as_object_mut().expect("an object");
        object.entry(list).or_insert_with(|| json!([])).as_array_mut().expect("a list")
    }

    /// Sets what a JSON pointer names.
    pub(super) fn set(&mut self, pointer: &str, value: Value) -> &mut Self {
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        let mut at = &mut self.json;
        for part in parent.split('/').skip(1) {
            at = match at {
                Value::Array(items) => &mut items[part.parse::<usize>().expect("an index")],
                other => other.as_object_mut().expect("an object").entry(part).or_insert_with(|| json!({})),
            };
        }
        match at {
            Value::Array(items) => items[key.parse::<usize>().expect("an index")] = value,
            other => {
                other.as_object_mut().expect("an object").insert(key.into(), value);
            }
        }
        self
    }

    /// Adds bytes as a buffer view, aligned to four.
    pub(super) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    /// Adds an accessor over bytes of its own.
    pub(super) fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }))
    }

    fn floats<const N: usize>(&mut self, rows: &[[f32; N]], kind: &str) -> usize {
        let bytes: Vec<u8> = rows.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, kind, rows.len())
    }

    pub(super) fn scalars(&mut self, values: &[f32]) -> usize {
        let rows: Vec<[f32; 1]> = values.iter().map(|value| [*value]).collect();
        self.floats(&rows, "SCALAR")
    }

    pub(super) fn vec2(&mut self, rows: &[[f32; 2]]) -> usize {
        self.floats(rows, "VEC2")
    }

    pub(super) fn vec3(&mut self, rows: &[[f32; 3]]) -> usize {
        self.floats(rows, "VEC3")
    }

    pub(super) fn vec4(&mut self, rows: &[[f32; 4]]) -> usize {
        self.floats(rows, "VEC4")
    }

    pub(super) fn mat4(&mut self, rows: &[[f32; 16]]) -> usize {
        self.floats(rows, "MAT4")
    }

    pub(super) fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        self.accessor(&bytes, 5123, "SCALAR", indices.len())
    }

    /// Adds a picture in a buffer view, and a texture that shows it.
    pub(super) fn texture(&mut self, png: &[u8], name: &str) -> usize {
        let view = self.view(png);
        let image = self.push("images", json!({ "bufferView": view, "mimeType": "image/png", "name": name }));
        self.push("textures", json!({ "source": image }))
    }

    /// The JSON with its buffer's length.
    fn finished(&self) -> Value {
        let mut json = self.json.clone();
        if !self.bin.is_empty() && json.get("buffers").is_none() {
            json["buffers"] = json!([{ "byteLength": self.bin.len() }]);
        }
        json
    }

    /// The file as GLB.
    pub(super) fn glb(&self) -> Vec<u8> {
        let mut text = self.finished().to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let length = 12 + 8 + text.len() + if bin.is_empty() { 0 } else { 8 + bin.len() };
        let mut glb = Vec::new();
        glb.extend_from_slice(b"glTF");
        glb.extend_from_slice(&2_u32.to_le_bytes());
        glb.extend_from_slice(&(length as u32).to_le_bytes());
        glb.extend_from_slice(&(text.len() as u32).to_le_bytes());
        glb.extend_from_slice(b"JSON");
        glb.extend_from_slice(&text);
        if !bin.is_empty() {
            glb.extend_from_slice(&(bin.len() as u32).to_le_bytes());
            glb.extend_from_slice(b"BIN\0");
            glb.extend_from_slice(&bin);
        }
        glb
    }

    /// What the importer makes of it.
    pub(super) fn try_import(&self, options: &ImportOptions) -> Result<Asset, ConvertError> {
        import_bytes(&self.glb(), "model.glb", options)
    }

    /// What the importer makes of it; it must be in order.
    pub(super) fn import(&self) -> Asset {
        self.import_with(&ImportOptions::default())
    }

    pub(super) fn import_with(&self, options: &ImportOptions) -> Asset {
        self.try_import(options).unwrap_or_else(|error| panic!("{error}"))
    }
}

/// Imports bytes as a file of that name in an empty folder.
pub(super) fn import_bytes(bytes: &[u8], name: &str, options: &ImportOptions) -> Result<Asset, ConvertError> {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("written");
    let asset = super::import(&path, options, &Silent)?;
    // What is imported can be written, and read back to the same.
    let bytes = aam::write(&asset.document, &aam::WriteOptions::default()).expect("a document that can be written");
    let read = aam::read(&bytes, &aam::ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(read.document, asset.document, "what is written reads back");
    assert!(read.findings.is_empty(), "{:?}", read.findings);
    Ok(asset)
}

/// A picture of one byte quadruple for each pixel, as PNG.
pub(super) fn png(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [u8; 4]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().expect("a header");
    let pixels: Vec<u8> =
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(|(x, y)| pixel(x, y)).collect();
    writer.write_image_data(&pixels).expect("data");
    writer.finish().expect("an end");
    bytes
}

/// Decodes a texture of an asset to RGBA.
pub(super) fn decoded(asset: &Asset, name: &str) -> image::RgbaImage {
    let file = asset.textures.get(name).unwrap_or_else(|| panic!("{name} among {:?}", asset.textures.keys()));
    let bytes = match file {
        crate::TextureFile::InMemory(bytes) => bytes.to_vec(),
        crate::TextureFile::OnDisk(path) => std::fs::read(path).expect("a file"),
    };
    image::load_from_memory(&bytes).expect("a picture").into_rgba8()
}

/// The object of that name.
pub(super) fn object<'a>(asset: &'a Asset, name: &str) -> &'a Object {
    let objects = asset.document.objects();
    let found = objects.iter().find(|object| object.name == *name);
    found.unwrap_or_else(|| panic!("{name} among {:?}", objects.iter().map(|o| &o.name).collect::<Vec<_>>()))
}

/// The single material at a position.
pub(super) fn single(asset: &Asset, at: usize) -> &SingleMaterial {
    match &asset.document.materials[at].body {
        MaterialBody::Single(single) => single,
        MaterialBody::Multi(_) => panic!("material {at} is Multi"),
    }
}

/// Whether the report has a line of this outcome about a property.
pub(super) fn reported(asset: &Asset, outcome: Outcome, property: &str) -> bool {
    asset.report.changes.iter().any(|change| change.outcome == outcome && change.property == property)
}

/// The notes and sizes of the report's lines about a property.
pub(super) fn notes(asset: &Asset, property: &str) -> String {
    let lines = asset.report.changes.iter().filter(|change| change.property == property);
    lines.map(|change| format!("{} {}\n", change.note, change.size.as_deref().unwrap_or(""))).collect()
}

/// Triangles as positions.
pub(super) fn corners(object: &Object) -> Vec<[[f32; 3]; 3]> {
    let faces = object.faces.as_ref().expect("faces");
    let at = |vertex: u32| object.vertices[vertex as usize];
    faces.triangles.iter().map(|triangle| triangle.vertices.map(at)).collect()
}

/// Asserts that numbers are equal within a bound.
#[track_caller]
pub(super) fn assert_near<const N: usize>(found: [f32; N], wanted: [f32; N], bound: f32) {
    let near = found.iter().zip(wanted).all(|(a, b)| (a - b).abs() <= bound);
    assert!(near, "{found:?} is not {wanted:?} within {bound}");
}

/// The corpus folder, if there is one.
pub(super) fn corpus(file: &str) -> Option<PathBuf> {
    match std::env::var_os("AAM_CORPUS") {
        Some(folder) => Some(PathBuf::from(folder).join("gltf").join(file)),
        None => {
            println!("skipped: AAM_CORPUS is not set");
            None
        }
    }
}
