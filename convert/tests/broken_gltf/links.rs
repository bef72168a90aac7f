//! Faults in how the parts of a file refer to each other and share data.

use super::*;
use Outcome::{Read, Refused};

pub(super) fn cases(file: &Builder) -> Vec<Case> {
    let edited = |code, name, outcome, edits: &[(&str, Value)]| {
        let mut file = file.clone();
        edits.iter().for_each(|(pointer, value)| {
            file.set(pointer, value.clone());
        });
        Case { code, name, outcome, bytes: file.glb() }
    };
    let one = |code, name, outcome, pointer: &str, value: Value| edited(code, name, outcome, &[(pointer, value)]);
    let changed = |code, name, outcome, change: &dyn Fn(&mut Builder)| {
        let mut file = file.clone();
        change(&mut file);
        Case { code, name, outcome, bytes: file.glb() }
    };
    let attributes = "/meshes/0/primitives/0/attributes";
    let second_root = |file: &mut Builder| {
        file.push("nodes", json!({ "name": "aside" }));
        file.set("/scenes/0/nodes", json!([0, 3]));
    };
    let plain = |file: &mut Builder| {
        file.set("/nodes/0", json!({ "mesh": 0, "children": [1] }));
        file.set("/skins", json!([{ "joints": [2] }]));
    };
    vec![
        // Versions and extensions.
        one("UNKNOWN_ASSET_MAJOR_VERSION", "version 3", Refused("", "version 3.0"), "/asset/version", json!("3.0")),
        one("UNKNOWN_ASSET_MINOR_VERSION", "version 2.7", Read(""), "/asset/version", json!("2.7")),
        one(
            "ASSET_MIN_VERSION_GREATER_THAN_VERSION",
            "a least version above the version",
            Refused("", "version 2.1"),
            "/asset/minVersion",
            json!("2.1"),
        ),
        one(
            "UNUSED_EXTENSION_REQUIRED",
            "an unknown extension that is required",
            Refused("", "VENDOR_whatever"),
            "/extensionsRequired",
            json!(["VENDOR_whatever"]),
        ),
        one("TYPE_MISMATCH", "extensions that are no object", Read(""), "/nodes/2/extensions", json!(1)),
        // Nodes, skins and scenes.
        changed("SCENE_NON_ROOT_NODE", "a scene of a child", Read("have parents"), &|file| {
            plain(file);
            file.set("/scenes/0/nodes", json!([1]));
        }),
        changed("SKIN_NO_COMMON_ROOT", "joints without a common root", Read(""), &|file| {
            file.push("nodes", json!({ "name": "aside" }));
            file.set("/skins/0/joints", json!([2, 3]));
            file.set("/skins/0/inverseBindMatrices", Value::Null);
        }),
        changed("NODE_SKIN_NO_SCENE", "joints outside the scene", Read(""), &|file| {
            file.push("nodes", json!({ "name": "aside" }));
            file.set("/skins/0", json!({ "joints": [3] }));
        }),
        changed("SKIN_SKELETON_INVALID", "a skeleton beside the joints", Read(""), &|file| {
            second_root(file);
            file.set("/skins/0/skeleton", json!(3));
        }),
        one(
            "UNRESOLVED_REFERENCE",
            "a skeleton that is not there",
            Refused("/skins/0/skeleton", "node 50"),
            "/skins/0/skeleton",
            json!(50),
        ),
        one(
            "NODE_MATRIX_NON_TRS",
            "a matrix that shears",
            Read(""),
            "/nodes/2/matrix",
            json!([1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
        ),
        one("EMPTY_ENTITY", "an empty list of children", Read(""), "/nodes/2/children", json!([])),
        // Meshes.
        one("MESH_PRIMITIVE_NO_POSITION", "no positions", Read("POSITION"), attributes, json!({ "NORMAL": 1 })),
        one(
            "MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH",
            "joints alone",
            Refused(attributes, "WEIGHTS_n"),
            attributes,
            json!({ "POSITION": 0, "TEXCOORD_0": 2, "JOINTS_0": 3 }),
        ),
        one(
            "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS",
            "a texture without coordinates",
            Read(""),
            "/materials/0/pbrMetallicRoughness/baseColorTexture/texCoord",
            json!(1),
        ),
        one(
            "MESH_PRIMITIVE_INCOMPATIBLE_MODE",
            "three ends of lines",
            Read("line"),
            "/meshes/0/primitives/0/mode",
            json!(1),
        ),
        one(
            "MESH_PRIMITIVE_MORPH_TARGET_NO_BASE_ACCESSOR",
            "a target of an attribute that is not there",
            Read(""),
            "/meshes/0/primitives/0/targets/0/TANGENT",
            json!(9),
        ),
        one(
            "MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT",
            "a target of another length",
            Refused("/accessors/9/count", "2 elements"),
            "/accessors/9/count",
            json!(2),
        ),
        changed("MESH_PRIMITIVE_INDICES_ACCESSOR_WITH_BYTESTRIDE", "indices in strides", Read(""), &|file| {
            let mut bytes = [0; 12];
            (bytes[4], bytes[8]) = (1, 2);
            let view = file.view(&bytes);
            file.set(&format!("/bufferViews/{view}/byteStride"), json!(4));
            file.set("/accessors/5/bufferView", json!(view));
        }),
        changed("MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", "colours of 32-bit integers", Read(""), &|file| {
            let colors = file.accessor(&[0xff; 48], 5125, "VEC4", 3);
            file.set(&format!("{attributes}/COLOR_0"), json!(colors));
        }),
        changed(
            "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT",
            "scalars as colours",
            Refused("/accessors/11/type", "VEC3 or VEC4"),
            &|file| {
                let colors = file.scalars(&[0.0; 3]);
                assert_eq!(colors, 10);
                let colors = file.scalars(&[0.0; 3]);
                file.set(&format!("{attributes}/COLOR_0"), json!(colors));
            },
        ),
        changed("VALUE_MULTIPLE_OF", "joints in a stride of 6", Read(""), &|file| {
            let view = file.view(&[0; 18]);
            file.set(&format!("/bufferViews/{view}/byteStride"), json!(6));
            file.set("/accessors/3/bufferView", json!(view));
        }),
        changed(
            "MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE",
            "two attributes in a view without a stride",
            Read(""),
            &|file| {
                file.set("/accessors/1/bufferView", json!(0));
                file.patch(0, 8, &1.0_f32.to_le_bytes());
            },
        ),
        // Views and accessors.
        one(
            "VALUE_MULTIPLE_OF",
            "a stride of 13",
            Refused("/accessors/0/count", "go beyond"),
            "/bufferViews/0/byteStride",
            json!(13),
        ),
        changed("VALUE_MULTIPLE_OF", "a stride of 14", Read(""), &|file| {
            let view = file.view(&[0; 42]);
            file.set(&format!("/bufferViews/{view}/byteStride"), json!(14));
            file.set("/accessors/0/bufferView", json!(view));
        }),
        edited(
            "ACCESSOR_OFFSET_ALIGNMENT",
            "an offset of one byte",
            Read(""),
            &[("/bufferViews/2/byteLength", json!(28)), ("/accessors/2/byteOffset", json!(1))],
        ),
        edited(
            "ACCESSOR_TOTAL_OFFSET_ALIGNMENT",
            "a view that starts between numbers",
            Read(""),
            &[("/bufferViews/2/byteOffset", json!(73))],
        ),
        one(
            "ACCESSOR_NORMALIZED_INVALID",
            "floats that are normalised",
            Read(""),
            "/accessors/0/normalized",
            json!(true),
        ),
        changed("ANIMATION_SAMPLER_ACCESSOR_WITH_BYTESTRIDE", "times in strides", Read(""), &|file| {
            file.set("/bufferViews/7/byteStride", json!(4));
        }),
        changed("SKIN_IBM_ACCESSOR_WITH_BYTESTRIDE", "bind matrices in strides", Read(""), &|file| {
            file.set("/bufferViews/6/byteStride", json!(64));
        }),
        one(
            "IMAGE_BUFFER_VIEW_WITH_BYTESTRIDE",
            "a picture in strides",
            Read(""),
            "/bufferViews/10/byteStride",
            json!(4),
        ),
        one(
            "UNRESOLVED_REFERENCE",
            "no buffers at all",
            Refused("/bufferViews/0/buffer", "buffer 0"),
            "/buffers",
            json!([]),
        ),
        changed("BUFFER_DATA_URI_MIME_TYPE_INVALID", "a buffer that is called a picture", Read(""), &|file| {
            use base64::Engine;
            let text = base64::engine::general_purpose::STANDARD.encode(&file.bin);
            let uri = format!("data:image/png;base64,{text}");
            file.set("/buffers", json!([{ "byteLength": file.bin.len(), "uri": uri }]));
            file.bin.clear();
        }),
        changed(
            "BUFFER_BYTE_LENGTH_MISMATCH",
            "an embedded buffer shorter than said",
            Refused("/buffers/0/byteLength", "promised"),
            &|file| {
                file.set(
                    "/buffers",
                    json!([{ "byteLength": file.bin.len(), "uri": "data:application/octet-stream;base64,AAAA" }]),
                );
                file.bin.clear();
            },
        ),
        changed("IO_ERROR", "a buffer outside the folder", Refused("/buffers/0/uri", "--allow-outside"), &|file| {
            file.set("/buffers", json!([{ "byteLength": file.bin.len(), "uri": "../a.bin" }]));
        }),
        changed("IO_ERROR", "a buffer that is not there", Refused("/buffers/0/uri", "does not exist"), &|file| {
            file.set("/buffers", json!([{ "byteLength": file.bin.len(), "uri": "a.bin" }]));
        }),
        // Animations.
        changed("ANIMATION_DUPLICATE_TARGETS", "two channels of one target", Read("second channel"), &|file| {
            let channel = file.json["animations"][0]["channels"][0].clone();
            file.set("/animations/0/channels", json!([channel, channel]));
        }),
        one(
            "ANIMATION_CHANNEL_TARGET_NODE_MATRIX",
            "a moving node with a matrix",
            Read("matrix"),
            "/nodes/2",
            json!({ "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1] }),
        ),
        changed(
            "ACCESSOR_ANIMATION_SAMPLER_OUTPUT_NON_NORMALIZED_QUATERNION",
            "rotations of length 2",
            Read(""),
            &|file| {
                let values = file.vec4(&[[0.0, 0.0, 0.0, 2.0]; 2]);
                file.set("/animations/0/samplers/0/output", json!(values));
                file.set("/animations/0/channels/0/target/path", json!("rotation"));
            },
        ),
        // Values.
        changed(
            "ACCESSOR_INDEX_PRIMITIVE_RESTART",
            "an index of all ones",
            Refused("/accessors/5", "vertex 65535"),
            &|file| {
                file.patch(5, 4, &[0xff, 0xff]);
            },
        ),
        changed("ACCESSOR_INVALID_IBM", "a bind matrix that projects", Read(""), &|file| {
            file.patch(6, 12, &1.0_f32.to_le_bytes());
        }),
        changed("ACCESSOR_WEIGHTS_NEGATIVE", "a weight of -1", Read(""), &|file| {
            file.patch(4, 0, &(-1.0_f32).to_le_bytes());
        }),
        changed("ACCESSOR_JOINTS_INDEX_DUPLICATE", "a joint twice for one vertex", Read(""), &|file| {
            file.patch(4, 0, &[0.5_f32, 0.5].map(f32::to_le_bytes).concat());
        }),
        changed("ACCESSOR_NON_CLAMPED", "a colour above 1", Read(""), &|file| {
            let colors = file.vec4(&[[2.0, 0.0, 0.0, 1.0]; 3]);
            file.set(&format!("{attributes}/COLOR_0"), json!(colors));
        }),
        changed("ACCESSOR_INVALID_SIGN", "a tangent without a sign", Read(""), &|file| {
            let tangents = file.vec4(&[[1.0, 0.0, 0.0, 0.5]; 3]);
            file.set(&format!("{attributes}/TANGENT"), json!(tangents));
        }),
        changed("ACCESSOR_SPARSE_INDICES_NON_INCREASING", "replacements that run back", Read(""), &|file| {
            let indices = file.view(&[1, 0]);
            let values = file.view(&[0; 24]);
            let sparse = json!({ "count": 2, "indices": { "bufferView": indices, "componentType": 5121 }, "values": { "bufferView": values } });
            file.set("/accessors/0/sparse", sparse);
        }),
    ]
}
