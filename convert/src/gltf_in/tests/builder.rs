//! Makes small glTF files.

use serde_json::{Value, json};

/// A glTF file in the making: JSON and one binary buffer.
#[derive(Clone, Debug)]
pub(crate) struct Builder {
    pub(crate) json: Value,
    pub(crate) bin: Vec<u8>,
}

impl Builder {
    /// A file with nothing but its version.
    pub(crate) fn new() -> Self {
        Self { json: json!({ "asset": { "version": "2.0" } }), bin: Vec::new() }
    }

    /// A file with one triangle, (0,0,0) (1,0,0) (0,1,0), shown by one node.
    pub(crate) fn triangle() -> Self {
        let mut file = Self::new();
        let positions = file.vec3(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        file.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": positions } }] }));
        file.push("nodes", json!({ "mesh": 0 }));
        file
    }

    /// A valid file with something of everything.
    pub(crate) fn rich() -> Self {
        let mut file = Self::triangle();
        let normal = file.vec3(&[[0.0, 0.0, 1.0]; 3]);
        let uvs = file.vec2(&[[0.0; 2]; 3]);
        let joints = file.accessor(&[0; 12], 5121, "VEC4", 3);
        let weights = file.vec4(&[[1.0, 0.0, 0.0, 0.0]; 3]);
        let indices = file.indices(&[0, 1, 2]);
        let binds = file.mat4(&[glam::Mat4::IDENTITY.to_cols_array()]);
        let times = file.scalars(&[0.0, 1.0]);
        let moves = file.vec3(&[[0.0; 3], [1.0; 3]]);
        let delta = file.vec3(&[[0.0; 3]; 3]);
        assert_eq!([normal, uvs, joints, weights, indices, binds, times, moves, delta], [1, 2, 3, 4, 5, 6, 7, 8, 9]);
        for (accessor, low, high) in [
            (0, json!([0, 0, 0]), json!([1, 1, 0])),
            (7, json!([0]), json!([1])),
            (9, json!([0, 0, 0]), json!([0, 0, 0])),
        ] {
            file.set(&format!("/accessors/{accessor}/min"), low).set(&format!("/accessors/{accessor}/max"), high);
        }
        let attributes = json!({ "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "JOINTS_0": 3, "WEIGHTS_0": 4 });
        let primitive =
            json!({ "attributes": attributes, "indices": 5, "material": 0, "targets": [{ "POSITION": 9 }] });
        file.set("/meshes/0", json!({ "primitives": [primitive], "weights": [0.0] }));
        file.texture(&png(1, 1, |_, _| [255; 4]), "white");
        file.push("samplers", json!({ "wrapS": 10497 }));
        file.set("/textures/0/sampler", json!(0));
        file.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }));
        file.set("/nodes/0", json!({ "mesh": 0, "skin": 0, "children": [1] }));
        file.push(
            "nodes",
            json!({ "camera": 0, "children": [2], "extensions": { "KHR_lights_punctual": { "light": 0 } } }),
        );
        file.push("nodes", json!({}));
        file.push("skins", json!({ "joints": [2], "inverseBindMatrices": 6 }));
        file.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 } }));
        file.set("/extensions", json!({ "KHR_lights_punctual": { "lights": [{ "type": "spot", "spot": {} }] } }));
        file.set("/extensionsUsed", json!(["KHR_lights_punctual"]));
        file.push("scenes", json!({ "nodes": [0] }));
        let channel = json!({ "sampler": 0, "target": { "node": 2, "path": "translation" } });
        file.push("animations", json!({ "samplers": [{ "input": 7, "output": 8 }], "channels": [channel] }));
        file
    }

    /// Adds an element to a list of the file.
    pub(crate) fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.list(list);
        list.push(value);
        list.len() - 1
    }

    fn list(&mut self, list: &str) -> &mut Vec<Value> {
        let object = self.json.as_object_mut().expect("an object");
        object.entry(list).or_insert_with(|| json!([])).as_array_mut().expect("a list")
    }

    /// Sets what a JSON pointer names.
    pub(crate) fn set(&mut self, pointer: &str, value: Value) -> &mut Self {
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
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    /// Adds an accessor over bytes of its own.
    pub(crate) fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }))
    }

    fn floats<const N: usize>(&mut self, rows: &[[f32; N]], kind: &str) -> usize {
        let bytes: Vec<u8> = rows.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, kind, rows.len())
    }

    pub(crate) fn scalars(&mut self, values: &[f32]) -> usize {
        let rows: Vec<[f32; 1]> = values.iter().map(|value| [*value]).collect();
        self.floats(&rows, "SCALAR")
    }

    pub(crate) fn vec2(&mut self, rows: &[[f32; 2]]) -> usize {
        self.floats(rows, "VEC2")
    }

    pub(crate) fn vec3(&mut self, rows: &[[f32; 3]]) -> usize {
        self.floats(rows, "VEC3")
    }

    pub(crate) fn vec4(&mut self, rows: &[[f32; 4]]) -> usize {
        self.floats(rows, "VEC4")
    }

    pub(crate) fn mat4(&mut self, rows: &[[f32; 16]]) -> usize {
        self.floats(rows, "MAT4")
    }

    pub(crate) fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        self.accessor(&bytes, 5123, "SCALAR", indices.len())
    }

    /// Adds a picture in a buffer view, and a texture that shows it.
    pub(crate) fn texture(&mut self, png: &[u8], name: &str) -> usize {
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
    pub(crate) fn glb(&self) -> Vec<u8> {
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
}

/// A picture of one byte quadruple for each pixel, as PNG.
pub(crate) fn png(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [u8; 4]) -> Vec<u8> {
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
