//! Faults in the binary data.

use super::*;

pub(super) fn cases(valid: &Builder) -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |code, name, place, says, edit: &dyn Fn(&mut Builder)| {
        let mut file = valid.clone();
        edit(&mut file);
        cases.push(Case { code, name, outcome: Outcome::Refused(place, says), bytes: file.glb() });
    };
    let nan = f32::NAN.to_le_bytes();
    add("ACCESSOR_INVALID_FLOAT", "POSITION that is no number", "/accessors/0", "element 1", &|file| {
        file.patch(0, 12, &nan)
    });
    add("ACCESSOR_INDEX_OOB", "index beyond the vertices", "/accessors/5", "vertex 3", &|file| {
        file.patch(5, 2, &[3, 0])
    });
    add("ACCESSOR_INVALID_FLOAT", "bind matrix that is no number", "/accessors/6", "matrix 0", &|file| {
        file.patch(6, 4, &nan)
    });
    add("ACCESSOR_INVALID_FLOAT", "morph delta that is no number", "/accessors/9", "element 0", &|file| {
        file.patch(9, 0, &nan)
    });
    add("ACCESSOR_INVALID_FLOAT", "time that is no number", "/accessors/7", "not finite", &|file| {
        file.patch(7, 0, &nan)
    });
    add("ACCESSOR_ANIMATION_INPUT_NON_INCREASING", "times that run back", "/accessors/7", "must increase", &|file| {
        file.patch(7, 0, &2.0_f32.to_le_bytes())
    });
    add("ACCESSOR_ANIMATION_INPUT_NEGATIVE", "negative time", "/accessors/7", "negative", &|file| {
        file.patch(7, 0, &(-1.0_f32).to_le_bytes())
    });
    add("ACCESSOR_JOINTS_INDEX_OOB", "joint beyond the skin", "/nodes/0/skin", "joint 7", &|file| {
        file.patch(3, 0, &[7])
    });
    add("NODE_SKIN_WITH_NON_SKINNED_MESH", "skin without bones", "/nodes/0/skin", "JOINTS_0", &|file| {
        let attributes = json!({ "POSITION": 0 });
        file.set("/meshes/0/primitives/0/attributes", attributes);
    });
    add(
        "MESH_PRIMITIVES_UNEQUAL_TARGETS_COUNT",
        "primitives with other targets",
        "/meshes/0/primitives/1/targets",
        "0 morph targets",
        &|file| {
            let second = json!({ "attributes": { "POSITION": 0 } });
            file.json["meshes"][0]["primitives"].as_array_mut().expect("primitives").push(second);
        },
    );
    add("ACCESSOR_MAX_MISMATCH", "vertices beyond all numbers", "/nodes/0", "32 bits", &|file| {
        file.patch(0, 12, &f32::MAX.to_le_bytes());
        file.set("/nodes/2/scale", json!([100, 1, 1]));
    });
    add("VALUE_NOT_IN_RANGE", "no times", "/accessors/7", "at least one time", &|file| {
        file.set("/accessors/7/count", json!(0));
    });
    let sparse =
        |indices: Value, values: Value, count: u64| json!({ "count": count, "indices": indices, "values": values });
    let view = |view: u64, component: u64| json!({ "bufferView": view, "componentType": component });
    let mut with_sparse = |code, name, place, says, sparse: Value| {
        add(code, name, place, says, &|file| {
            file.set("/accessors/0/sparse", sparse.clone());
        });
    };
    with_sparse(
        "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE",
        "more replacements than elements",
        "/accessors/0/sparse/count",
        "4 replacements",
        sparse(view(0, 5121), view(0, 0), 4),
    );
    with_sparse(
        "UNRESOLVED_REFERENCE",
        "sparse index view",
        "/accessors/0/sparse/indices/bufferView",
        "99",
        sparse(view(99, 5121), view(0, 0), 1),
    );
    with_sparse(
        "UNRESOLVED_REFERENCE",
        "sparse value view",
        "/accessors/0/sparse/values/bufferView",
        "98",
        sparse(view(0, 5121), view(98, 0), 1),
    );
    with_sparse(
        "BUFFER_VIEW_TARGET_OVERRIDE",
        "sparse index type",
        "/accessors/0/sparse/indices/componentType",
        "unsigned",
        sparse(view(0, 5126), view(0, 0), 1),
    );
    with_sparse(
        "VALIDATION_FAILED",
        "sparse indices out of range",
        "/accessors/0/sparse/indices",
        "go beyond",
        sparse(json!({ "bufferView": 0, "componentType": 5125, "byteOffset": 30 }), view(0, 0), 3),
    );
    with_sparse(
        "ACCESSOR_TOO_LONG",
        "sparse values out of range",
        "/accessors/0/sparse/values",
        "go beyond",
        sparse(view(0, 5121), json!({ "bufferView": 0, "byteOffset": 30 }), 1),
    );
    // The first number of the weights is 1.0, which as an index is far beyond.
    with_sparse(
        "ACCESSOR_SPARSE_INDEX_OOB",
        "sparse index beyond the elements",
        "/accessors/0/sparse/indices",
        "is replaced",
        sparse(view(4, 5125), view(0, 0), 1),
    );
    cases
}
