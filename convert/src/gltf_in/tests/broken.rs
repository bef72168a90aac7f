//! Broken and hostile files: each is refused with its place, without a panic and without much memory.

use super::*;

/// What is wrong, where the message must point, and what it must say.
struct Case {
    name: &'static str,
    place: &'static str,
    says: &'static str,
    file: Builder,
}

fn case(name: &'static str, place: &'static str, says: &'static str, start: &Builder, edits: &[(&str, Value)]) -> Case {
    let mut file = start.clone();
    for (pointer, value) in edits {
        file.set(pointer, value.clone());
    }
    Case { name, place, says, file }
}

/// A file with something of everything.
fn rich() -> Builder {
    let mut file = Builder::triangle();
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
    let attributes = json!({ "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "JOINTS_0": 3, "WEIGHTS_0": 4 });
    let primitive = json!({ "attributes": attributes, "indices": 5, "material": 0, "targets": [{ "POSITION": 9 }] });
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
    file.set("/extensions", json!({ "KHR_lights_punctual": { "lights": [{ "type": "spot" }] } }));
    file.push("scenes", json!({ "nodes": [0] }));
    let channel = json!({ "sampler": 0, "target": { "node": 2, "path": "translation" } });
    file.push("animations", json!({ "samplers": [{ "input": 7, "output": 8 }], "channels": [channel] }));
    file
}

fn structure(file: &Builder) -> Vec<Case> {
    let one = |name, place, says, pointer: &str, value| case(name, place, says, file, &[(pointer, value)]);
    vec![
        one("no asset", "/asset", "missing", "/asset", Value::Null),
        one("no version", "/asset/version", "missing", "/asset", json!({})),
        one("version is a number", "/asset/version", "string", "/asset/version", json!(2.0)),
        one("version is a word", "/asset/version", "expected a version", "/asset/version", json!("two")),
        one("nodes is no list", "/nodes", "array", "/nodes", json!({ "mesh": 0 })),
        one("a node is no object", "/nodes/1", "object", "/nodes/1", json!(7)),
        one("accessor without count", "/accessors/0/count", "missing", "/accessors/0/count", Value::Null),
        one("negative count", "/accessors/0/count", "-3", "/accessors/0/count", json!(-3)),
        one("fractional count", "/accessors/0/count", "2.5", "/accessors/0/count", json!(2.5)),
        one("huge count", "/accessors/0/count", "go beyond", "/accessors/0/count", json!(4_000_000_000_u64)),
        one("count that overflows", "/accessors/0/count", "go beyond", "/accessors/0/count", json!(u64::MAX)),
        one("accessor view", "/accessors/0/bufferView", "99", "/accessors/0/bufferView", json!(99)),
        one(
            "index beyond 32 bits",
            "/accessors/0/bufferView",
            "4294967296",
            "/accessors/0/bufferView",
            json!(1_u64 << 32),
        ),
        one("accessor offset", "/accessors/0/count", "go beyond", "/accessors/0/byteOffset", json!(8)),
        one("offset that overflows", "/accessors/0/count", "go beyond", "/accessors/0/byteOffset", json!(u64::MAX)),
        one("component type", "/accessors/0/componentType", "5124", "/accessors/0/componentType", json!(5124)),
        one(
            "component type beyond 32 bits",
            "/accessors/0/componentType",
            "4294972422",
            "/accessors/0/componentType",
            json!((1_u64 << 32) + 5126),
        ),
        one("accessor type", "/accessors/0/type", "VEC5", "/accessors/0/type", json!("VEC5")),
        one("view buffer", "/bufferViews/0/buffer", "buffer 3", "/bufferViews/0/buffer", json!(3)),
        one("view length", "/bufferViews/0/byteLength", "go beyond", "/bufferViews/0/byteLength", json!(1 << 30)),
        one(
            "view range that overflows",
            "/bufferViews/0/byteLength",
            "go beyond",
            "/bufferViews/0/byteOffset",
            json!(u64::MAX),
        ),
        one(
            "stride below the element",
            "/bufferViews/0/byteStride",
            "less than",
            "/bufferViews/0/byteStride",
            json!(8),
        ),
        one("stride of zero", "/bufferViews/0/byteStride", "found 0", "/bufferViews/0/byteStride", json!(0)),
        one("stride beyond the end", "/accessors/0/count", "go beyond", "/bufferViews/0/byteStride", json!(252)),
        one("buffer too short", "/buffers/0/byteLength", "promised", "/buffers", json!([{ "byteLength": 1 << 20 }])),
        case(
            "a buffer without uri that is needed",
            "/buffers/1/uri",
            "missing",
            file,
            &[
                ("/buffers", json!([{ "byteLength": file.bin.len() }, { "byteLength": 36 }])),
                ("/bufferViews/0/buffer", json!(1)),
            ],
        ),
        one(
            "material of a primitive",
            "/meshes/0/primitives/0/material",
            "material 5",
            "/meshes/0/primitives/0/material",
            json!(5),
        ),
        one("mode", "/meshes/0/primitives/0/mode", "7", "/meshes/0/primitives/0/mode", json!(7)),
        one(
            "attribute index",
            "/meshes/0/primitives/0/attributes/NORMAL",
            "accessor 77",
            "/meshes/0/primitives/0/attributes/NORMAL",
            json!(77),
        ),
        one(
            "no attributes",
            "/meshes/0/primitives/0/attributes",
            "missing",
            "/meshes/0/primitives/0/attributes",
            Value::Null,
        ),
        one(
            "indices index",
            "/meshes/0/primitives/0/indices",
            "accessor 88",
            "/meshes/0/primitives/0/indices",
            json!(88),
        ),
        one("mesh without primitives", "/meshes/0/primitives", "missing", "/meshes/0", json!({})),
        one(
            "target index",
            "/meshes/0/primitives/0/targets/0/POSITION",
            "accessor 66",
            "/meshes/0/primitives/0/targets/0/POSITION",
            json!(66),
        ),
        one("weights of a mesh", "/meshes/0/weights", "2 weights", "/meshes/0/weights", json!([0, 1])),
        one("weights of a node", "/nodes/0/weights", "3 weights", "/nodes/0/weights", json!([0, 1, 2])),
        one(
            "joints without weights",
            "/meshes/0/primitives/0/attributes",
            "WEIGHTS_n",
            "/meshes/0/primitives/0/attributes/WEIGHTS_0",
            Value::Null,
        ),
    ]
}

fn contents(file: &Builder) -> Vec<Case> {
    let one = |name, place, says, pointer: &str, value| case(name, place, says, file, &[(pointer, value)]);
    let attribute = |name: &str| format!("/meshes/0/primitives/0/attributes/{name}");
    vec![
        one("POSITION of VEC2", "/accessors/2/type", "VEC3", &attribute("POSITION"), json!(2)),
        one("NORMAL of another length", "/accessors/8/count", "2 elements", &attribute("NORMAL"), json!(8)),
        one("TEXCOORD of VEC3", "/accessors/1/type", "VEC2", &attribute("TEXCOORD_0"), json!(1)),
        one("JOINTS of floats", "/accessors/4/componentType", "JOINTS", &attribute("JOINTS_0"), json!(4)),
        one("a gap in JOINTS", "/meshes/0/primitives/0/attributes", "gap", &attribute("JOINTS_2"), json!(3)),
        one("indices of floats", "/accessors/7/componentType", "unsigned", "/meshes/0/primitives/0/indices", json!(7)),
        one("node mesh", "/nodes/0/mesh", "mesh 4", "/nodes/0/mesh", json!(4)),
        one("node skin", "/nodes/0/skin", "skin 4", "/nodes/0/skin", json!(4)),
        one("node camera", "/nodes/1/camera", "camera 4", "/nodes/1/camera", json!(4)),
        one("node child", "/nodes/0/children/0", "node 9", "/nodes/0/children", json!([9])),
        one("negative child", "/nodes/0/children/0", "-1", "/nodes/0/children", json!([-1])),
        one("a node that is its own child", "/nodes/0/children/0", "own ancestor", "/nodes/0/children", json!([0])),
        one("a ring of nodes", "/nodes/1/children/0", "ancestor", "/nodes/1/children", json!([0])),
        one("two parents", "/nodes/1/children", "second parent", "/nodes/0/children", json!([1, 2])),
        one("a child named twice", "/nodes/0/children/1", "second parent", "/nodes/0/children", json!([1, 1])),
        one("scene root", "/scenes/0/nodes/0", "node 12", "/scenes/0/nodes", json!([12])),
        one("scene root twice", "/scenes/0/nodes/1", "twice", "/scenes/0/nodes", json!([0, 0])),
        one("default scene", "/scene", "scene 3", "/scene", json!(3)),
        one("matrix of 15", "/nodes/0/matrix", "16 numbers", "/nodes/0/matrix", json!(vec![0; 15])),
        one("matrix with a word", "/nodes/0/matrix/0", "a number", "/nodes/0/matrix", json!(vec!["x"; 16])),
        one("projective matrix", "/nodes/0/matrix", "projection", "/nodes/0/matrix", json!(vec![1; 16])),
        one("number beyond 32 bits", "/nodes/0/translation/0", "32 bits", "/nodes/0/translation", json!([1e300, 0, 0])),
        one("rotation of zeros", "/nodes/0/rotation", "no rotation", "/nodes/0/rotation", json!([0, 0, 0, 0])),
        one("scales that multiply beyond all", "/nodes/1", "32-bit", "/nodes/1/scale", json!([3e38, 1, 1])),
        one("skin joint", "/skins/0/joints/0", "node 31", "/skins/0/joints", json!([31])),
        one("skin without joints", "/skins/0/joints", "at least one", "/skins/0/joints", json!([])),
        one(
            "too few bind matrices",
            "/skins/0/inverseBindMatrices",
            "1 matrices for 2",
            "/skins/0/joints",
            json!([2, 1]),
        ),
        one("bind matrices of vectors", "/accessors/0/type", "MAT4", "/skins/0/inverseBindMatrices", json!(0)),
        one("bind accessor", "/skins/0/inverseBindMatrices", "accessor 40", "/skins/0/inverseBindMatrices", json!(40)),
        one("texture source", "/textures/0/source", "image 2", "/textures/0/source", json!(2)),
        one("texture sampler", "/textures/0/sampler", "sampler 2", "/textures/0/sampler", json!(2)),
        one("wrap mode", "/samplers/0/wrapS", "1234", "/samplers/0/wrapS", json!(1234)),
        one("image view", "/images/0/bufferView", "99", "/images/0/bufferView", json!(99)),
        one("image of nothing", "/images/0", "neither", "/images/0", json!({})),
        one("image of floats", "/images/0", "no picture format", "/images/0/bufferView", json!(0)),
        one(
            "texture of a material",
            "/materials/0/pbrMetallicRoughness/baseColorTexture/index",
            "texture 7",
            "/materials/0/pbrMetallicRoughness/baseColorTexture/index",
            json!(7),
        ),
        one(
            "texture without index",
            "/materials/0/normalTexture/index",
            "missing",
            "/materials/0/normalTexture",
            json!({}),
        ),
        one("alpha mode", "/materials/0/alphaMode", "OPAK", "/materials/0/alphaMode", json!("OPAK")),
        one(
            "metallic of 2",
            "/materials/0/pbrMetallicRoughness/metallicFactor",
            "from 0 to 1",
            "/materials/0/pbrMetallicRoughness/metallicFactor",
            json!(2),
        ),
        one("negative emission", "/materials/0/emissiveFactor", "-1", "/materials/0/emissiveFactor", json!([0, -1, 0])),
        one(
            "colour of two",
            "/materials/0/pbrMetallicRoughness/baseColorFactor",
            "4 numbers",
            "/materials/0/pbrMetallicRoughness/baseColorFactor",
            json!([1, 1]),
        ),
        one("camera type", "/cameras/0/type", "fisheye", "/cameras/0/type", json!("fisheye")),
        one("camera without lens", "/cameras/0/perspective", "missing", "/cameras/0/perspective", Value::Null),
        one("near plane", "/cameras/0/perspective/znear", "found 0", "/cameras/0/perspective/znear", json!(0)),
        one("far before near", "/cameras/0", "zfar", "/cameras/0/perspective/zfar", json!(0.05)),
        one(
            "light type",
            "/extensions/KHR_lights_punctual/lights/0/type",
            "sun",
            "/extensions/KHR_lights_punctual/lights/0/type",
            json!("sun"),
        ),
        one(
            "light index",
            "/nodes/1/extensions/KHR_lights_punctual/light",
            "light 8",
            "/nodes/1/extensions/KHR_lights_punctual/light",
            json!(8),
        ),
        one(
            "spot angles",
            "/extensions/KHR_lights_punctual/lights/0/spot",
            "more than",
            "/extensions/KHR_lights_punctual/lights/0/spot",
            json!({ "innerConeAngle": 1.0, "outerConeAngle": 0.5 }),
        ),
    ]
}

fn animations(file: &Builder) -> Vec<Case> {
    let one = |name, place, says, pointer: &str, value| case(name, place, says, file, &[(pointer, value)]);
    let sampler = |key: &str| format!("/animations/0/samplers/0/{key}");
    vec![
        one(
            "sampler of a channel",
            "/animations/0/channels/0/sampler",
            "sampler of this",
            "/animations/0/channels/0/sampler",
            json!(3),
        ),
        one(
            "node of a channel",
            "/animations/0/channels/0/target/node",
            "node 44",
            "/animations/0/channels/0/target/node",
            json!(44),
        ),
        one(
            "channel without target",
            "/animations/0/channels/0/target",
            "missing",
            "/animations/0/channels/0/target",
            Value::Null,
        ),
        one(
            "interpolation",
            "/animations/0/samplers/0/interpolation",
            "BEZIER",
            &sampler("interpolation"),
            json!("BEZIER"),
        ),
        one("input", "/animations/0/samplers/0/input", "accessor 50", &sampler("input"), json!(50)),
        one("output", "/animations/0/samplers/0/output", "accessor 50", &sampler("output"), json!(50)),
        one("values of another shape", "/accessors/4/type", "4 numbers each", &sampler("output"), json!(4)),
        one("more values than times", "/accessors/0/count", "9 numbers for 2", &sampler("output"), json!(0)),
        one(
            "spline without tangents",
            "/accessors/8/count",
            "9 a time",
            &sampler("interpolation"),
            json!("CUBICSPLINE"),
        ),
        one(
            "weights without targets",
            "/animations/0/channels/0",
            "no morph targets",
            "/animations/0/channels/0/target/path",
            json!("weights"),
        ),
        one("times that are matrices", "/accessors/6/type", "MAT4", &sampler("input"), json!(6)),
    ]
}

/// Cases whose fault is in the binary data.
fn data() -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |name, place, says, edit: &dyn Fn(&mut Builder)| {
        let mut file = rich();
        edit(&mut file);
        cases.push(Case { name, place, says, file });
    };
    let patch = |file: &mut Builder, accessor: usize, at: usize, bytes: &[u8]| {
        let view = file.json["accessors"][accessor]["bufferView"].as_u64().expect("a view") as usize;
        let start = file.json["bufferViews"][view]["byteOffset"].as_u64().expect("an offset") as usize + at;
        file.bin[start..start + bytes.len()].copy_from_slice(bytes);
    };
    let nan = f32::NAN.to_le_bytes();
    add("POSITION that is no number", "/accessors/0", "element 1", &|file| patch(file, 0, 12, &nan));
    add("index beyond the vertices", "/accessors/5", "vertex 3", &|file| patch(file, 5, 2, &[3, 0]));
    add("bind matrix that is no number", "/accessors/6", "matrix 0", &|file| patch(file, 6, 4, &nan));
    add("morph delta that is no number", "/accessors/9", "element 0", &|file| patch(file, 9, 0, &nan));
    add("time that is no number", "/accessors/7", "not finite", &|file| patch(file, 7, 0, &nan));
    add("times that run back", "/accessors/7", "must increase", &|file| patch(file, 7, 0, &2.0_f32.to_le_bytes()));
    add("negative time", "/accessors/7", "negative", &|file| patch(file, 7, 0, &(-1.0_f32).to_le_bytes()));
    add("joint beyond the skin", "/nodes/0/skin", "joint 7", &|file| patch(file, 3, 0, &[7]));
    add("skin without bones", "/nodes/0/skin", "JOINTS_0", &|file| {
        let attributes = json!({ "POSITION": 0 });
        file.set("/meshes/0/primitives/0/attributes", attributes);
    });
    add("primitives with other targets", "/meshes/0/primitives/1/targets", "0 morph targets", &|file| {
        let second = json!({ "attributes": { "POSITION": 0 } });
        file.json["meshes"][0]["primitives"].as_array_mut().expect("primitives").push(second);
    });
    add("vertices beyond all numbers", "/nodes/0", "32 bits", &|file| {
        patch(file, 0, 12, &f32::MAX.to_le_bytes());
        file.set("/nodes/2/scale", json!([100, 1, 1]));
    });
    add("no times", "/accessors/7", "at least one time", &|file| {
        file.set("/accessors/7/count", json!(0));
    });
    let sparse =
        |indices: Value, values: Value, count: u64| json!({ "count": count, "indices": indices, "values": values });
    let view = |view: u64, component: u64| json!({ "bufferView": view, "componentType": component });
    let mut with_sparse = |name, place, says, sparse: Value| {
        add(name, place, says, &|file| {
            file.set("/accessors/0/sparse", sparse.clone());
        });
    };
    with_sparse(
        "more replacements than elements",
        "/accessors/0/sparse/count",
        "4 replacements",
        sparse(view(0, 5121), view(0, 0), 4),
    );
    with_sparse(
        "sparse index view",
        "/accessors/0/sparse/indices/bufferView",
        "99",
        sparse(view(99, 5121), view(0, 0), 1),
    );
    with_sparse(
        "sparse value view",
        "/accessors/0/sparse/values/bufferView",
        "98",
        sparse(view(0, 5121), view(98, 0), 1),
    );
    with_sparse(
        "sparse index type",
        "/accessors/0/sparse/indices/componentType",
        "unsigned",
        sparse(view(0, 5126), view(0, 0), 1),
    );
    with_sparse(
        "sparse indices out of range",
        "/accessors/0/sparse/indices",
        "go beyond",
        sparse(json!({ "bufferView": 0, "componentType": 5125, "byteOffset": 30 }), view(0, 0), 3),
    );
    with_sparse(
        "sparse values out of range",
        "/accessors/0/sparse/values",
        "go beyond",
        sparse(view(0, 5121), json!({ "bufferView": 0, "byteOffset": 30 }), 1),
    );
    // The first number of the weights is 1.0, which as an index is far beyond.
    with_sparse(
        "sparse index beyond the elements",
        "/accessors/0/sparse/indices",
        "is replaced",
        sparse(view(4, 5125), view(0, 0), 1),
    );
    cases
}

#[test]
fn every_fault_names_its_place() {
    let file = rich();
    file.try_import(&ImportOptions::default()).expect("the whole file is in order");
    let cases: Vec<Case> =
        [structure(&file), contents(&file), animations(&file), data()].into_iter().flatten().collect();
    println!("{} broken files", cases.len());
    assert!(cases.len() > 100);
    let mut wrong = Vec::new();
    for Case { name, place, says, file } in cases {
        match file.try_import(&ImportOptions::default()) {
            Err(ConvertError::Broken { place: found, message, .. })
                if found.starts_with(place) && message.contains(says) => {}
            other => wrong.push(format!("{name}: {:?}", other.map(|_| "imported").map_err(|error| error.to_string()))),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_truncation_of_a_glb_is_refused() {
    let whole = rich().glb();
    for length in (0..100).chain((100..whole.len()).step_by(7)) {
        let error = import_bytes(&whole[..length], "cut.glb", &ImportOptions::default()).expect_err("truncated");
        assert!(matches!(error, ConvertError::Broken { .. }), "{length}: {error}");
    }
}

#[test]
fn no_changed_byte_does_harm() {
    let whole = rich().glb();
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
        let _ = super::super::import(&path, &ImportOptions::default(), &Silent);
    }
}

#[test]
fn containers() {
    let word = |value: u32| value.to_le_bytes();
    let glb = |parts: &[&[u8]]| parts.concat();
    let cases: [(&str, Vec<u8>, &str); 9] = [
        ("empty", Vec::new(), "line 1"),
        ("no JSON", b"hello".to_vec(), "line 1"),
        ("half JSON", b"{\"asset\": {\n".to_vec(), "line 2"),
        ("deep JSON", b"[".repeat(100_000), "line 1"),
        ("header alone", glb(&[b"glTF", &word(2), &word(12)]), "byte 12"),
        ("length beyond the file", glb(&[b"glTF", &word(2), &word(1000)]), "byte 8"),
        ("chunk beyond the end", glb(&[b"glTF", &word(2), &word(20), &word(4_294_967_295), b"JSON"]), "byte 12"),
        ("half a chunk header", glb(&[b"glTF", &word(2), &word(16), &word(4)]), "byte 16"),
        ("binary first", glb(&[b"glTF", &word(2), &word(20), &word(0), b"BIN\0"]), "byte 16"),
    ];
    for (name, bytes, place) in cases {
        match import_bytes(&bytes, "x.glb", &ImportOptions::default()) {
            Err(ConvertError::Broken { place: found, message, .. }) => {
                assert!(found.starts_with(place), "{name}: {found}: {message}");
            }
            other => panic!("{name}: {:?}", other.map(|_| ())),
        }
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
    let start = std::time::Instant::now();
    let error = file.try_import(options).expect_err(says).to_string();
    assert!(error.contains(says), "{error}");
    assert!(start.elapsed().as_secs() < 5, "{says}: {:?}", start.elapsed());
}

#[test]
fn few_bytes_do_not_ask_for_much_memory() {
    let default = ImportOptions::default();
    // An accessor that no bytes stand behind.
    let mut zeros = Builder::triangle();
    zeros.set("/accessors/0", json!({ "componentType": 5126, "type": "VEC3", "count": 100_000_000 }));
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
    refused(&targets, &default, "morph targets");
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
