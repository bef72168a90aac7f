//! Broken and hostile files: each is refused with its place, without a panic and without much memory.

use super::*;

#[test]
fn every_truncation_of_a_glb_is_refused() {
    let whole = Builder::rich().glb();
    for length in (0..100).chain((100..whole.len()).step_by(7)) {
        let error = import_bytes(&whole[..length], "cut.glb", &ImportOptions::default()).expect_err("truncated");
        assert!(matches!(error, ConvertError::Broken { .. }), "{length}: {error}");
    }
}

#[test]
fn no_changed_byte_does_harm() {
    let whole = Builder::rich().glb();
    let mut state = 12345_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize
    };
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("changed.glb");
    for _ in 0..1000 {
        let mut bytes = whole.clone();
        for _ in 0..1 + next() % 4 {
            let at = next() % bytes.len();
            bytes[at] = next() as u8;
        }
        std::fs::write(&path, &bytes).expect("written");
        let _ = crate::import(&path, &ImportOptions::default(), &Silent);
    }
}

#[test]
fn what_is_not_supported_names_the_way_out() {
    let required = |name: &str| {
        let mut file = Builder::triangle();
        file.set("/extensionsRequired", json!([name]));
        file
    };
    let version = |version: &str| {
        let mut file = Builder::triangle();
        file.set("/asset/version", json!(version));
        file
    };
    let mut draco = Builder::triangle();
    draco
        .set("/meshes/0/primitives/0", json!({ "attributes": {}, "extensions": { "KHR_draco_mesh_compression": {} } }));
    let mut meshopt = Builder::triangle();
    let fallback = json!({ "byteLength": 36, "extensions": { "EXT_meshopt_compression": { "fallback": true } } });
    meshopt.set("/buffers", json!([{ "byteLength": 36 }, fallback])).set("/bufferViews/0/buffer", json!(1));
    let textured = |texture: Value, picture: &[u8]| {
        let mut file = Builder::triangle();
        file.texture(picture, "x");
        file.set("/textures/0", texture);
        file.push("materials", json!({ "normalTexture": { "index": 0 } }));
        file
    };
    let basisu = json!({ "extensions": { "KHR_texture_basisu": { "source": 0 } } });
    let cases = [
        (required("KHR_draco_mesh_compression"), "KHR_draco_mesh_compression", "gltf-transform"),
        (required("EXT_meshopt_compression"), "EXT_meshopt_compression", "gltf-transform"),
        (required("VENDOR_whatever"), "VENDOR_whatever", "/extensionsRequired/0"),
        (version("1.0"), "version 1.0", "gltf-pipeline"),
        (version("3.0"), "version 3.0", "2.0"),
        (draco, "KHR_draco_mesh_compression", "gltf-transform"),
        (meshopt, "EXT_meshopt_compression", "gltf-transform"),
        (textured(basisu, b"x"), "KHR_texture_basisu", "PNG"),
        (textured(json!({ "source": 0 }), b"\xABKTX 20\xBB\r\n\x1A\n"), "KTX2", "PNG"),
        (textured(json!({ "source": 0 }), b"DDS |"), "DDS", "PNG"),
    ];
    for (file, feature, way_out) in cases {
        let error = file.try_import(&ImportOptions::default()).expect_err(feature);
        assert!(matches!(error, ConvertError::Unsupported { .. }), "{error}");
        let error = error.to_string();
        assert!(error.contains(feature) && error.contains(way_out), "{error}");
    }
}

#[track_caller]
fn refused(file: &Builder, options: &ImportOptions, says: &str) {
    let error = file.try_import(options).expect_err(says).to_string();
    assert!(error.contains(says), "{error}");
}

#[test]
fn few_bytes_do_not_ask_for_much_memory() {
    let default = ImportOptions::default();
    // An accessor that no bytes stand behind.
    let mut zeros = Builder::triangle();
    zeros.set("/accessors/0", json!({ "componentType": 5126, "type": "VEC3", "count": 1_000_000 }));
    refused(&zeros, &default, "more than the file has bytes");
    // Sixty thousand nodes that show sixty thousand vertices each.
    let mut instances = Builder::triangle();
    instances.set("/accessors/0", json!({ "componentType": 5126, "type": "VEC3", "count": 60_000 }));
    instances.set("/nodes", json!(vec![json!({ "mesh": 0 }); 60_000]));
    refused(&instances, &default, "vertices");
    // One primitive a thousand times over.
    let mut primitives = Builder::triangle();
    primitives.set("/accessors/0", json!({ "componentType": 5126, "type": "VEC3", "count": 65_000 }));
    primitives.set("/meshes/0/primitives", json!(vec![json!({ "attributes": { "POSITION": 0 } }); 10_000]));
    refused(&primitives, &default, "vertices");
    // Morph targets that are all the same accessor.
    let mut targets = Builder::triangle();
    targets.set("/accessors/0", json!({ "componentType": 5126, "type": "VEC3", "count": 65_000 }));
    targets.set("/meshes/0/primitives/0/targets", json!(vec![json!({ "POSITION": 0 }); 10_000]));
    refused(&targets, &default, "targets");
    // A clip of thirty years.
    let mut long = Builder::triangle();
    let input = long.scalars(&[0.0, 1e9]);
    let output = long.vec3(&[[0.0; 3], [1.0; 3]]);
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "translation" } });
    long.push("animations", json!({ "samplers": [{ "input": input, "output": output }], "channels": [channel] }));
    refused(&long, &default, "frames");
    // A sparse list that ten thousand primitives pick three vertices from.
    let mut sparse = Builder::triangle();
    let replaced =
        json!({ "count": 0, "indices": { "bufferView": 0, "componentType": 5121 }, "values": { "bufferView": 0 } });
    sparse.set("/accessors/0", json!({ "componentType": 5126, "type": "VEC3", "count": 60_000, "sparse": replaced }));
    let indices = sparse.indices(&[0, 1, 2]);
    let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": indices });
    sparse.set("/meshes/0/primitives", json!(vec![primitive; 10_000]));
    refused(&sparse, &default, "vertices");
    for rate in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        refused(&Builder::triangle(), &ImportOptions { frames_per_second: rate, ..ImportOptions::default() }, "--fps");
    }
    // More bytes than the options allow.
    refused(&Builder::triangle(), &limited(Limits { file_size: 100, ..Limits::DEFAULT }), "limit");
}

#[test]
fn limits_are_those_of_the_user() {
    let mut file = Builder::triangle();
    file.push("nodes", json!({ "mesh": 0 }));
    let exact = Limits { objects: 2, vertices: 6, triangles: 2, frames: 1, ..Limits::DEFAULT };
    assert_eq!(file.import_with(&limited(exact)).document.objects().len(), 2);
    for (limits, option) in [
        (
            Limits { objects: 1, ..exact },
            "2 objects over all frames are more than the limit of 1; raise it with --max-objects",
        ),
        (
            Limits { vertices: 5, ..exact },
            "6 vertices over all frames are more than the limit of 5; raise it with --max-vertices",
        ),
        (Limits { triangles: 1, ..exact }, "2 triangles are more than the limit of 1; raise it with --max-triangles"),
    ] {
        refused(&file, &limited(limits), option);
    }
}

#[test]
fn long_reports_stay_short() {
    let mut file = Builder::triangle();
    file.set("/meshes", json!(vec![json!({ "primitives": [{ "attributes": { "POSITION": 0 }, "mode": 0 }] }); 5000]));
    file.set("/nodes", json!((0..5000).map(|mesh| json!({ "mesh": mesh })).collect::<Vec<_>>()));
    let asset = file.import();
    assert!(asset.report.changes.len() < 60);
    assert!(notes(&asset, "points").contains("4960 more"), "{}", notes(&asset, "points"));
}
