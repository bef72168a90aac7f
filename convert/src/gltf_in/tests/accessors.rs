//! Every kind of accessor, against values worked out by hand.

use super::*;

/// The corners of the one triangle of the first object, in glTF's axes.
fn positions(asset: &Asset) -> [[f32; 3]; 3] {
    corners(object(asset, "node 0"))[0].map(|[x, y, z]| [x, z, -y])
}

/// A triangle whose POSITION is this accessor.
fn with_position(mut file: Builder, accessor: usize) -> Builder {
    file.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": accessor } }] }));
    file.push("nodes", json!({ "mesh": 0 }));
    file
}

/// A triangle whose positions are integers of one type: rows of 0 1 2 / 3 4 5 / 6 8 7 at the given stride.
fn integers(component: u32, size: usize, stride: usize, normalized: bool) -> Builder {
    let mut file = Builder::new();
    let mut bytes = vec![0xAA; 3 * stride];
    for (row, values) in [[0_u8, 1, 2], [3, 4, 5], [6, 8, 7]].iter().enumerate() {
        for (at, value) in values.iter().enumerate() {
            let start = row * stride + at * size;
            bytes[start..start + size].fill(0);
            bytes[start] = *value;
        }
    }
    let accessor = file.accessor(&bytes, component, "VEC3", 3);
    file.set("/bufferViews/0/byteStride", json!(stride));
    file.set("/accessors/0/normalized", json!(normalized));
    with_position(file, accessor)
}

#[test]
fn quantised_positions_of_every_type() {
    for (component, size, greatest) in [(5120, 1, 127.0), (5121, 1, 255.0), (5122, 2, 32767.0), (5123, 2, 65535.0)] {
        for stride in [4 * size, 12] {
            let plain = [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0], [6.0, 8.0, 7.0]];
            let asset = integers(component, size, stride.max(8), false).import();
            assert_eq!(positions(&asset), plain, "component {component} stride {stride}");
            let asset = integers(component, size, stride.max(8), true).import();
            let normalized = plain.map(|row| row.map(|value: f32| value / greatest));
            assert_eq!(positions(&asset), normalized, "component {component} normalised");
        }
    }
}

#[test]
fn signed_integers_reach_minus_one_twice() {
    let mut file = Builder::new();
    let bytes: Vec<u8> =
        [[-128_i8, -127, 127, 0], [0, 1, 2, 0], [64, 0, 0, 0]].as_flattened().iter().map(|v| *v as u8).collect();
    let accessor = file.accessor(&bytes, 5120, "VEC3", 3);
    file.set("/bufferViews/0/byteStride", json!(4));
    file.set("/accessors/0/normalized", json!(true));
    let asset = with_position(file, accessor).import();
    assert_eq!(positions(&asset)[0], [-1.0, -1.0, 1.0]);
    assert_eq!(positions(&asset)[2], [64.0 / 127.0, 0.0, 0.0]);
}

#[test]
fn interleaved_floats() {
    let mut file = Builder::new();
    let rows: [[f32; 8]; 3] = [
        [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.25, 0.5],
        [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.75, 0.5],
        [0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.25, 1.0],
    ];
    let bytes: Vec<u8> = rows.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
    let view = file.view(&bytes);
    file.set(&format!("/bufferViews/{view}/byteStride"), json!(32));
    for (offset, kind) in [(0, "VEC3"), (12, "VEC3"), (24, "VEC2")] {
        let accessor =
            json!({ "bufferView": view, "byteOffset": offset, "componentType": 5126, "type": kind, "count": 3 });
        file.push("accessors", accessor);
    }
    let attributes = json!({ "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 });
    let texture = file.texture(&png(1, 1, |_, _| [255; 4]), "white");
    file.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }));
    file.push("meshes", json!({ "primitives": [{ "attributes": attributes, "material": 0 }] }));
    file.push("nodes", json!({ "mesh": 0 }));
    let asset = file.import();
    assert_eq!(positions(&asset), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let faces = object(&asset, "node 0").faces.as_ref().expect("faces");
    let uvs = faces.tex_indices[0].map(|at| faces.tex_coords[at as usize]);
    assert_eq!(uvs, [[0.25, 0.5], [0.75, 0.5], [0.25, 0.0]], "v is 1 - v");
}

fn sparse(base: bool, index_type: u32, index_size: usize) -> [[f32; 3]; 3] {
    let mut file = Builder::new();
    let accessor = if base {
        file.vec3(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    } else {
        file.push("accessors", json!({ "componentType": 5126, "type": "VEC3", "count": 3 }))
    };
    let mut indices = vec![0; 2 * index_size];
    indices[0] = 1;
    indices[index_size] = 2;
    let index_view = file.view(&indices);
    let values: Vec<u8> = [5.0_f32, 6.0, 7.0, 8.0, 9.0, 10.0].iter().flat_map(|value| value.to_le_bytes()).collect();
    let value_view = file.view(&values);
    let replaced = json!({
        "count": 2,
        "indices": { "bufferView": index_view, "componentType": index_type },
        "values": { "bufferView": value_view },
    });
    file.set(&format!("/accessors/{accessor}/sparse"), replaced);
    positions(&with_position(file, accessor).import())
}

#[test]
fn sparse_accessors() {
    for (component, size) in [(5121, 1), (5123, 2), (5125, 4)] {
        assert_eq!(sparse(true, component, size), [[0.0, 0.0, 0.0], [5.0, 6.0, 7.0], [8.0, 9.0, 10.0]]);
        assert_eq!(sparse(false, component, size), [[0.0, 0.0, 0.0], [5.0, 6.0, 7.0], [8.0, 9.0, 10.0]]);
    }
}

#[test]
fn sparse_accessors_with_unused_vertices() {
    // Vertex 1 is not used, so the others are picked out of the list, after the replacement.
    let mut file = Builder::new();
    let accessor = file.vec3(&[[0.0; 3], [9.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let index_view = file.view(&[3]);
    let values: Vec<u8> = [4.0_f32, 5.0, 6.0].iter().flat_map(|value| value.to_le_bytes()).collect();
    let value_view = file.view(&values);
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": index_view, "componentType": 5121 },
        "values": { "bufferView": value_view },
    });
    file.set("/accessors/0/sparse", sparse);
    let indices = file.indices(&[0, 2, 3]);
    file.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": accessor }, "indices": indices }] }));
    file.push("nodes", json!({ "mesh": 0 }));
    let asset = file.import();
    assert_eq!(positions(&asset), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [4.0, 5.0, 6.0]]);
    assert_eq!(object(&asset, "node 0").vertices.len(), 3);
}

#[test]
fn accessors_without_data_are_zero() {
    let mut file = Builder::triangle();
    file.push("accessors", json!({ "componentType": 5126, "type": "VEC3", "count": 3 }));
    file.set("/meshes/0/primitives/0/targets", json!([{ "POSITION": 1 }]));
    file.set("/meshes/0/weights", json!([1.0]));
    assert_eq!(positions(&file.import()), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
}

#[test]
fn indices_of_every_type() {
    for (component, size) in [(5121, 1), (5123, 2), (5125, 4)] {
        let mut file = Builder::triangle();
        let mut bytes = vec![0; 3 * size];
        for (at, index) in [2_u8, 0, 1].into_iter().enumerate() {
            bytes[at * size] = index;
        }
        let indices = file.accessor(&bytes, component, "SCALAR", 3);
        file.set("/meshes/0/primitives/0/indices", json!(indices));
        assert_eq!(positions(&file.import()), [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    }
}

#[test]
fn sparse_indices_list() {
    let mut file = Builder::triangle();
    let indices = file.indices(&[0, 0, 0]);
    let index_view = file.view(&[1, 2]);
    let value_view = file.view(&[1, 0, 2, 0]);
    let sparse = json!({
        "count": 2,
        "indices": { "bufferView": index_view, "componentType": 5121 },
        "values": { "bufferView": value_view },
    });
    file.set(&format!("/accessors/{indices}/sparse"), sparse);
    file.set("/meshes/0/primitives/0/indices", json!(indices));
    assert_eq!(positions(&file.import()), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
}

/// The colours of a triangle's corners, decoded back to linear.
fn colors(bytes: &[u8], component: u32, kind: &str) -> Vec<[f32; 3]> {
    let mut file = Builder::triangle();
    let colors = file.accessor(bytes, component, kind, 3);
    let size = bytes.len() / 3;
    if size.is_multiple_of(4) {
        file.set("/bufferViews/1/byteStride", json!(size));
    }
    file.set("/meshes/0/primitives/0/attributes/COLOR_0", json!(colors));
    let asset = file.import();
    let colors = object(&asset, "node 0").colors.clone().expect("colours");
    colors.into_iter().map(|color| color.map(crate::phong::decode_srgb)).collect()
}

#[test]
fn colours_of_every_type() {
    let wanted = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.2]];
    let near = |found: Vec<[f32; 3]>| {
        for (found, wanted) in found.into_iter().zip(wanted) {
            assert_near(found, wanted, 1e-5);
        }
    };
    let floats = |alpha: bool| -> Vec<u8> {
        let rows = wanted.iter().flat_map(|row| row.iter().copied().chain(alpha.then_some(1.0)));
        rows.flat_map(f32::to_le_bytes).collect()
    };
    near(colors(&floats(false), 5126, "VEC3"));
    near(colors(&floats(true), 5126, "VEC4"));
    near(colors(&[255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 51, 255], 5121, "VEC4"));
    near(colors(&[255, 0, 0, 0, 255, 0, 0, 0, 51], 5121, "VEC3"));
    let shorts: Vec<u8> = [[65535, 0, 0, 65535], [0, 65535, 0, 65535], [0, 0, 13107_u16, 65535]]
        .as_flattened()
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    near(colors(&shorts, 5123, "VEC4"));
}

/// The texture coordinates of a triangle's corners, as glTF has them.
fn uvs(bytes: &[u8], component: u32, normalized: bool) -> [[f32; 2]; 3] {
    let mut file = Builder::triangle();
    let uvs = file.accessor(bytes, component, "VEC2", 3);
    file.set(&format!("/accessors/{uvs}/normalized"), json!(normalized));
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(uvs));
    let texture = file.texture(&png(1, 1, |_, _| [255; 4]), "white");
    file.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }));
    file.set("/meshes/0/primitives/0/material", json!(0));
    let asset = file.import();
    let faces = object(&asset, "node 0").faces.as_ref().expect("faces");
    faces.tex_indices[0].map(|at| faces.tex_coords[at as usize]).map(|[u, v]| [u, 1.0 - v])
}

#[test]
fn texture_coordinates_of_every_type() {
    let close = |found: [[f32; 2]; 3], wanted: [[f32; 2]; 3]| {
        for (found, wanted) in found.into_iter().zip(wanted) {
            assert_near(found, wanted, 1e-6);
        }
    };
    close(uvs(&[0, 0, 255, 0, 0, 255], 5121, true), [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    close(uvs(&[0, 0, 3, 0, 0, 2], 5121, false), [[0.0, 0.0], [3.0, 0.0], [0.0, 2.0]]);
    close(uvs(&[0, 0, 0x81, 0, 0, 127], 5120, true), [[0.0, 0.0], [-1.0, 0.0], [0.0, 1.0]]);
    let shorts = |rows: [u16; 6]| rows.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    close(uvs(&shorts([0, 0, 65535, 0, 0, 13107]), 5123, true), [[0.0, 0.0], [1.0, 0.0], [0.0, 0.2]]);
    close(uvs(&shorts([0, 0, 5, 0, 0, 0xFFFF]), 5122, false), [[0.0, 0.0], [5.0, 0.0], [0.0, -1.0]]);
}

#[test]
fn min_and_max_are_not_trusted() {
    let mut file = Builder::triangle();
    file.set("/accessors/0/min", json!([100.0, 100.0, 100.0]));
    file.set("/accessors/0/max", json!("nonsense"));
    assert_eq!(positions(&file.import())[1], [1.0, 0.0, 0.0]);
}

#[test]
fn whole_numbers_may_be_written_as_floats() {
    let mut file = Builder::triangle();
    file.set("/accessors/0/count", json!(3.0));
    assert_eq!(positions(&file.import())[1], [1.0, 0.0, 0.0]);
}
