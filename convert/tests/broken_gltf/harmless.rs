//! Faults that do no harm: the file is read.

use super::*;

pub(super) fn cases(file: &Builder) -> Vec<Case> {
    let one = |code, name, says, pointer: &str, value: Value| {
        let mut file = file.clone();
        file.set(pointer, value);
        Case { code, name, outcome: Outcome::Read(says), bytes: file.glb() }
    };
    let patched = |code, name, says, accessor: usize, at: usize, values: &[u8]| {
        let mut file = file.clone();
        file.patch(accessor, at, values);
        Case { code, name, outcome: Outcome::Read(says), bytes: file.glb() }
    };
    let attribute = |name: &str| format!("/meshes/0/primitives/0/attributes/{name}");
    let float = |value: f32| value.to_le_bytes();
    vec![
        // Bounds are not trusted, so nothing hangs on them.
        one("ACCESSOR_MIN_MISMATCH", "a wrong minimum", "", "/accessors/0/min", json!([-5, 0, 0])),
        one("ACCESSOR_MAX_MISMATCH", "a wrong maximum", "", "/accessors/0/max", json!([9, 1, 0])),
        one("ACCESSOR_ELEMENT_OUT_OF_MAX_BOUND", "a maximum too small", "", "/accessors/0/max", json!([0.5, 1, 0])),
        one("ACCESSOR_ELEMENT_OUT_OF_MIN_BOUND", "a minimum too large", "", "/accessors/0/min", json!([0.5, 0, 0])),
        one("ARRAY_LENGTH_NOT_IN_LIST", "bounds of two numbers", "", "/accessors/0/max", json!([1, 1])),
        one(
            "MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS",
            "positions without bounds",
            "",
            "/accessors/0/min",
            Value::Null,
        ),
        one(
            "ANIMATION_SAMPLER_INPUT_ACCESSOR_WITHOUT_BOUNDS",
            "times without bounds",
            "",
            "/accessors/7/max",
            Value::Null,
        ),
        // Any place can be read from.
        one(
            "BUFFER_VIEW_TARGET_OVERRIDE",
            "a view of indices and positions",
            "",
            "/bufferViews/0/target",
            json!(34963),
        ),
        one("VALUE_NOT_IN_LIST", "a target that does not exist", "", "/bufferViews/0/target", json!(7)),
        // Values that can be mended.
        one("ROTATION_NON_UNIT", "a rotation of length 0.7", "", "/nodes/2/rotation", json!([0.5, 0, 0, 0.5])),
        patched("ACCESSOR_VECTOR3_NON_UNIT", "a normal of length 2", "", 1, 8, &float(2.0)),
        patched("ACCESSOR_WEIGHTS_NON_NORMALIZED", "weights of sum 2", "", 4, 0, &float(2.0)),
        one(
            "NODE_MATRIX_TRS",
            "a matrix and a translation",
            "",
            "/nodes/2",
            json!({
                "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], "translation": [1, 0, 0]
            }),
        ),
        // What is unknown means nothing.
        one("UNEXPECTED_PROPERTY", "an unknown property", "", "/meshes/0/colour", json!("red")),
        one("UNDECLARED_EXTENSION", "an extension that is not declared", "", "/extensionsUsed", Value::Null),
        one(
            "MESH_PRIMITIVE_INVALID_ATTRIBUTE",
            "an unknown attribute",
            "TEMPERATURE",
            &attribute("TEMPERATURE"),
            json!(1),
        ),
        one(
            "MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY",
            "TEXCOORD_2 without TEXCOORD_1",
            "",
            &attribute("TEXCOORD_2"),
            json!(2),
        ),
        one(
            "DUPLICATE_ELEMENTS",
            "an extension named twice",
            "",
            "/extensionsUsed",
            json!(["KHR_lights_punctual", "KHR_lights_punctual"]),
        ),
    ]
}
