//! Hierarchy, transforms, names, instances, mirrors.

use aam::document::Header;
use aam::meaning::{Hierarchy, world_transforms};
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};

use super::*;

const HIERARCHY: ImportOptions = ImportOptions {
    hierarchy: true,
    animation: None,
    frames_per_second: 30.0,
    normal_tolerance: 0.5,
    keep_uvs: false,
    allow_outside: false,
    up: None,
    limits: Limits::DEFAULT,
};

/// The first triangle of an object in the world, in glTF's axes, whatever the form of the document.
fn world(asset: &Asset, name: &str) -> [[f32; 3]; 3] {
    let document = &asset.document;
    let at = document.objects().iter().position(|object| object.name == *name).expect("the object");
    let transform = world_transforms(document, &Hierarchy::of(document.objects()), 0.0)[at];
    corners(&document.objects()[at])[0].map(|corner| {
        let point = transform.transform_point3(Vec3::from(corner));
        [point.x, point.z, -point.y]
    })
}

#[track_caller]
fn assert_world(asset: &Asset, name: &str, wanted: DAffine3) {
    let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|point| wanted.transform_point3(point).as_vec3().to_array());
    let mut found = world(asset, name);
    if wanted.matrix3.determinant() < 0.0 && asset.document.header == Some(Header::Mesh) {
        found.swap(1, 2);
    }
    for (found, wanted) in found.into_iter().zip(triangle) {
        assert_near(found, wanted, 2e-5);
    }
}

fn parts(t: [f64; 3], r: DQuat, s: [f64; 3]) -> DAffine3 {
    DAffine3::from_scale_rotation_translation(DVec3::from(s), r, DVec3::from(t))
}

fn node(place: &DAffine3, mesh: bool) -> Value {
    let (scale, rotation, translation) = place.to_scale_rotation_translation();
    let mut node = json!({
        "translation": translation.to_array(), "rotation": rotation.to_array(), "scale": scale.to_array(),
    });
    if mesh {
        node["mesh"] = json!(0);
    }
    node
}

#[test]
fn chains_of_transforms_both_ways() {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.8);
    let steps = [
        parts([1.0, 2.0, 3.0], turn, [2.0, 2.0, 2.0]),
        parts([-1.0, 0.5, 0.0], turn * turn, [1.0, 3.0, 0.5]),
        parts([0.0, 0.0, 4.0], turn.inverse(), [-1.0, 2.0, 1.0]),
    ];
    let mut file = Builder::triangle();
    file.set("/nodes/0", node(&steps[2], true));
    file.set("/nodes/0/name", json!("leaf"));
    for (at, step) in [(1, 1), (2, 0)] {
        file.push("nodes", node(&steps[step], true));
        file.set(&format!("/nodes/{at}/children"), json!([at - 1]));
        file.set(&format!("/nodes/{at}/name"), json!(["", "middle", "root"][at]));
    }
    let worlds = [steps[0], steps[0] * steps[1], steps[0] * steps[1] * steps[2]];
    for options in [ImportOptions::default(), HIERARCHY] {
        let asset = file.import_with(&options);
        for (name, world) in ["root", "middle", "leaf"].iter().zip(worlds) {
            assert_world(&asset, name, world);
        }
        let parents: Vec<i32> = asset.document.objects().iter().map(|object| object.parent).collect();
        assert_eq!(parents, [-1, 0, 1]);
        let header = if options.hierarchy { Header::Character } else { Header::Mesh };
        assert_eq!(asset.document.header, Some(header));
        assert_eq!(asset.document.objects()[0].node.is_some(), options.hierarchy);
    }
}

#[test]
fn matrices_and_shear() {
    let shear = DAffine3::from_mat3_translation(
        DMat3::from_cols(DVec3::new(1.0, 0.2, 0.0), DVec3::new(0.7, 1.0, 0.0), DVec3::new(0.0, 0.3, 2.0)),
        DVec3::new(1.0, -2.0, 0.5),
    );
    let child = parts([0.3, 0.2, 0.1], DQuat::from_rotation_y(0.5), [1.0, 2.0, 1.0]);
    let mut file = Builder::triangle();
    let columns = glam::DMat4::from(shear).to_cols_array();
    file.set("/nodes/0", json!({ "mesh": 0, "matrix": columns, "name": "sheared", "children": [1] }));
    file.push("nodes", node(&child, true));
    file.set("/nodes/1/name", json!("below"));
    for options in [ImportOptions::default(), HIERARCHY] {
        let asset = file.import_with(&options);
        assert_world(&asset, "sheared", shear);
        assert_world(&asset, "below", shear * child);
        assert_eq!(reported(&asset, Outcome::Changed, "node transforms"), options.hierarchy);
    }
    // A matrix without shear needs nothing of that.
    let columns = glam::DMat4::from(child).to_cols_array();
    file.set("/nodes/0/matrix", json!(columns));
    let asset = file.import_with(&HIERARCHY);
    assert_world(&asset, "sheared", child);
    assert!(!reported(&asset, Outcome::Changed, "node transforms"));
}

#[test]
fn flat_scales_do_not_break_anything() {
    let mut file = Builder::triangle();
    file.set("/nodes/0/scale", json!([1.0, 0.0, 1.0]));
    let normals = file.vec3(&[[0.0, 0.0, 1.0]; 3]);
    file.set("/meshes/0/primitives/0/attributes/NORMAL", json!(normals));
    for options in [ImportOptions::default(), HIERARCHY] {
        assert_world(&file.import_with(&options), "node 0", parts([0.0; 3], DQuat::IDENTITY, [1.0, 0.0, 1.0]));
    }
    let zero = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 1.0];
    file.set("/nodes/0", json!({ "mesh": 0, "matrix": zero }));
    for options in [ImportOptions::default(), HIERARCHY] {
        assert_world(&file.import_with(&options), "node 0", parts([1.0, 2.0, 3.0], DQuat::IDENTITY, [0.0; 3]));
    }
}

#[test]
fn mirrored_nodes_are_wound_the_other_way() {
    let mut file = Builder::triangle();
    let normals = file.vec3(&[[0.0, 0.0, 1.0]; 3]);
    let uvs = file.vec2(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    file.set("/meshes/0/primitives/0/attributes/NORMAL", json!(normals));
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(uvs));
    let texture = file.texture(&png(1, 1, |_, _| [255; 4]), "white");
    file.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }));
    file.set("/meshes/0/primitives/0/material", json!(0));
    file.set("/nodes/0/scale", json!([-1.0, 1.0, 1.0]));
    let asset = file.import();
    let mirrored = object(&asset, "node 0");
    let [a, b, c] = corners(mirrored)[0].map(Vec3::from);
    let normal = (b - a).cross(c - a).normalize();
    assert_near(normal.to_array(), [0.0, -1.0, 0.0], 1e-6);
    let faces = mirrored.faces.as_ref().expect("faces");
    for (corner, uv) in corners(mirrored)[0].iter().zip(faces.tex_indices[0]) {
        let [u, v] = faces.tex_coords[uv as usize];
        assert_near([-corner[0], corner[2]], [u, 1.0 - v], 1e-6);
    }
    // In local coordinates the winding is the mesh's own, and the transform reflects.
    let asset = file.import_with(&HIERARCHY);
    assert_eq!(corners(object(&asset, "node 0"))[0][1], [1.0, 0.0, 0.0]);
    assert_world(&asset, "node 0", parts([0.0; 3], DQuat::IDENTITY, [-1.0, 1.0, 1.0]));
}

#[test]
fn normals_of_uneven_scales_stay_upright() {
    // A smooth roof whose normals no group gives, scaled unevenly.
    let mut file = Builder::triangle();
    let n = Vec3::new(0.3, 0.2, 1.0).normalize();
    let normals = file.vec3(&[n.to_array(); 3]);
    file.set("/meshes/0/primitives/0/attributes/NORMAL", json!(normals));
    file.set("/nodes/0/scale", json!([2.0, 1.0, 0.5]));
    let asset = file.import();
    let faces = object(&asset, "node 0").faces.as_ref().expect("faces");
    let wanted = Vec3::new(n.x / 2.0, n.y, n.z / 0.5).normalize();
    let normals = faces.normals.as_ref().expect("explicit normals");
    assert_near(normals[0], [wanted.x, -wanted.z, wanted.y], 1e-6);
}

#[test]
fn instances_are_repeated_and_names_made_unique() {
    let mut file = Builder::triangle();
    let normals = file.vec3(&[[0.6, 0.0, 0.8]; 3]);
    file.set("/meshes/0/primitives/0/attributes/NORMAL", json!(normals));
    file.set("/nodes/0/name", json!("wheel"));
    let turn = DQuat::from_rotation_x(1.0);
    for (at, name) in ["wheel", "Wheel", "wheel.001", " "].iter().enumerate() {
        let mut node = node(&parts([at as f64, 0.0, 0.0], turn, [2.0; 3]), true);
        node["name"] = json!(name);
        file.push("nodes", node);
    }
    file.set("/meshes/0/name", json!("disc"));
    let asset = file.import();
    let names: Vec<String> = asset.document.objects().iter().map(|object| object.name.decoded()).collect();
    assert_eq!(names, ["wheel", "wheel.001", "Wheel.002", "wheel.001.001", "disc"]);
    for at in 1..5 {
        let normals = asset.document.objects()[at].faces.as_ref().and_then(|f| f.normals.clone()).expect("normals");
        let turned = turn * DVec3::new(0.6, 0.0, 0.8);
        assert_near(normals[0], [turned.x as f32, -turned.z as f32, turned.y as f32], 1e-6);
    }
}

#[test]
fn names_stay_on_their_line() {
    let mut file = Builder::triangle();
    file.set("/nodes/0/name", json!("two\nlines\tand a { brace"));
    assert_eq!(file.import().document.objects()[0].name, *"two lines and a { brace");
}

#[test]
fn extras_become_user_properties() {
    let mut file = Builder::triangle();
    file.set("/nodes/0/extras", json!({ "mass": 3, "tags": ["a", "b\nc"] }));
    let properties = file.import().document.objects()[0].user_properties.clone().expect("properties");
    assert_eq!(properties, *r#"{"mass":3,"tags":["a","b\nc"]}"#);
}

#[test]
fn empty_nodes_stay_where_something_hangs_on_them() {
    let mut file = Builder::triangle();
    file.push("nodes", json!({ "name": "group", "children": [0, 2] }));
    file.push("nodes", json!({ "name": "locator" }));
    let asset = file.import();
    assert_eq!(asset.document.objects().len(), 2);
    assert_eq!(object(&asset, "group").material, -1);
    assert!(notes(&asset, "nodes").contains("locator"));
    assert_eq!(file.import_with(&HIERARCHY).document.objects().len(), 3);
}

#[test]
fn the_default_scene_is_taken() {
    let mut file = Builder::triangle();
    file.push("nodes", json!({ "mesh": 0, "name": "second" }));
    file.push("scenes", json!({ "nodes": [0], "name": "first" }));
    file.push("scenes", json!({ "nodes": [1], "name": "other" }));
    assert_eq!(file.import().document.objects()[0].name, *"node 0");
    file.set("/scene", json!(1));
    let asset = file.import();
    assert_eq!(asset.document.objects()[0].name, *"second");
    assert_eq!(asset.document.objects().len(), 1);
    assert!(asset.report.changes.iter().any(|change| change.subject.contains("first") && change.property == "scene"));
}

#[test]
fn a_scene_may_list_nodes_that_have_parents() {
    let mut file = Builder::triangle();
    file.set("/nodes/0/children", json!([1]));
    file.push("nodes", json!({ "mesh": 0, "name": "inner" }));
    file.push("nodes", json!({ "children": [0], "translation": [5.0, 0.0, 0.0] }));
    // The parent is not in the scene, and the child comes with node 0.
    file.push("scenes", json!({ "nodes": [1, 0] }));
    let asset = file.import();
    let parents: Vec<i32> = asset.document.objects().iter().map(|object| object.parent).collect();
    assert_eq!(parents, [-1, 0]);
    assert_world(&asset, "inner", DAffine3::IDENTITY);
    assert!(notes(&asset, "scene").contains("2 nodes"));
}

#[test]
fn hidden_nodes_are_left_out() {
    let mut file = Builder::triangle();
    file.set("/nodes/0/extensions", json!({ "KHR_node_visibility": { "visible": false } }));
    let asset = file.import();
    assert!(asset.document.objects().is_empty() && reported(&asset, Outcome::Lost, "hidden nodes"));
    file.set("/nodes/0/extensions", json!({ "KHR_node_visibility": { "visible": true } }));
    assert_eq!(file.import().document.objects().len(), 1);
}

#[test]
fn deep_chains_need_no_stack() {
    let mut file = Builder::triangle();
    let depth = 50_000;
    let mut nodes: Vec<Value> = vec![json!({ "mesh": 0 })];
    nodes.extend((1..depth).map(|at| json!({ "children": [at - 1], "translation": [0.001, 0.0, 0.0] })));
    file.set("/nodes", json!(nodes));
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("deep.glb");
    std::fs::write(&path, file.glb()).expect("written");
    for hierarchy in [false, true] {
        let options = ImportOptions { hierarchy, ..ImportOptions::default() };
        let asset = crate::import(&path, &options, &Silent).expect("imported");
        assert_eq!(asset.document.objects().len(), depth);
    }
}
