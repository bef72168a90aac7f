//! Skins and morph targets, against positions worked out by hand.

use aam::document::{AnimationMode, Frame, Header};
use aam::meaning::{SmoothingRule, frame_normals, object_normals};
use glam::{Mat4, Quat, Vec3};

use super::*;

/// A strip of two squares along x from 0 to 2, bound to a joint at 0 and one at 1 (half and half at x = 1), which turns
/// by a right angle about z within a second.
fn arm() -> Builder {
    let mut file = Builder::new();
    let grid = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0]];
    let position = file.vec3(&grid.map(|[x, y]| [x, y, 0.0]));
    let normal = file.vec3(&[[0.0, 0.0, 1.0]; 6]);
    let joints: Vec<u8> = grid.iter().flat_map(|_| [0, 1, 0, 0]).collect();
    let joints = file.accessor(&joints, 5121, "VEC4", 6);
    let weights: Vec<[f32; 4]> = grid.iter().map(|[x, _]| [1.0 - 0.5 * x, 0.5 * x, 0.0, 0.0]).collect();
    let weights = file.vec4(&weights);
    let indices = file.indices(&[0, 1, 3, 1, 4, 3, 1, 2, 4, 2, 5, 4]);
    let attributes = json!({ "POSITION": position, "NORMAL": normal, "JOINTS_0": joints, "WEIGHTS_0": weights });
    file.push("meshes", json!({ "primitives": [{ "attributes": attributes, "indices": indices }] }));
    let inverse = |x: f32| Mat4::from_translation(Vec3::new(-x, 0.0, 0.0)).to_cols_array();
    let binds = file.mat4(&[inverse(0.0), inverse(1.0)]);
    // The place of the skinned node itself means nothing.
    file.push("nodes", json!({ "mesh": 0, "skin": 0, "name": "arm", "translation": [100.0, 0.0, 0.0] }));
    file.push("nodes", json!({ "name": "shoulder", "children": [2] }));
    file.push("nodes", json!({ "name": "elbow", "translation": [1.0, 0.0, 0.0] }));
    file.push("skins", json!({ "joints": [1, 2], "inverseBindMatrices": binds }));
    file
}

fn bending(mut file: Builder) -> Builder {
    let times = file.scalars(&[0.0, 1.0]);
    let turn = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    let output = file.vec4(&[[0.0, 0.0, 0.0, 1.0], turn.to_array()]);
    let channel = json!({ "sampler": 0, "target": { "node": 2, "path": "rotation" } });
    file.push("animations", json!({ "samplers": [{ "input": times, "output": output }], "channels": [channel] }));
    file
}

/// A vertex of the first object in a frame, in glTF's axes.
fn vertices(frame: &Frame) -> Vec<[f32; 3]> {
    frame.objects[0].vertices.iter().map(|[x, y, z]| [*x, *z, -y]).collect()
}

/// Where linear blend skinning puts a point of the arm when the elbow is turned by an angle.
fn bent(x: f32, y: f32, angle: f32) -> [f32; 3] {
    let weight = 0.5 * x;
    let turned = Quat::from_rotation_z(angle) * Vec3::new(x - 1.0, y, 0.0) + Vec3::X;
    (Vec3::new(x, y, 0.0) * (1.0 - weight) + turned * weight).to_array()
}

#[test]
fn an_arm_bends_at_its_elbow() {
    let options = ImportOptions { frames_per_second: 4.0, ..ImportOptions::default() };
    let asset = bending(arm()).import_with(&options);
    let geometry = &asset.document.geometry;
    assert_eq!(asset.document.header, Some(Header::MeshMultiframe));
    assert_eq!((geometry.animation, geometry.frames.len()), (AnimationMode::Full, 5));
    let flat = vertices(&geometry.frames[0]);
    assert_eq!(flat.len(), 6);
    for (number, frame) in (0_u16..).zip(&geometry.frames) {
        let angle = f32::from(number) / 4.0 * std::f32::consts::FRAC_PI_2;
        for ([x, y, _], found) in flat.iter().zip(vertices(frame)) {
            assert_near(found, bent(*x, *y, angle), 1e-5);
        }
    }
    assert_eq!(geometry.frames[3].number, 3);
    assert!(geometry.frames[3].objects[0].faces.is_none());
}

#[test]
fn without_animation_the_skin_stands_at_rest() {
    for hierarchy in [false, true] {
        let options = ImportOptions { hierarchy, ..ImportOptions::default() };
        let asset = arm().import_with(&options);
        let found: Vec<[f32; 3]> = object(&asset, "arm").vertices.iter().map(|[x, y, z]| [*x, *z, -y]).collect();
        assert_eq!(found[1], [1.0, 0.0, 0.0], "the node's own place is ignored");
        let world = aam::meaning::world_transforms(
            &asset.document,
            &aam::meaning::Hierarchy::of(asset.document.objects()),
            0.0,
        )[0];
        assert_eq!(world.transform_point3(Vec3::ONE), Vec3::ONE);
    }
}

#[test]
fn bones_without_inverse_bind_matrices_use_the_identity() {
    let mut file = arm();
    file.json["skins"][0].as_object_mut().expect("a skin").remove("inverseBindMatrices");
    let asset = file.import();
    // The elbow's own move by one then carries its share of every vertex along.
    let wanted: Vec<f32> = [0.0, 1.0, 2.0].iter().map(|x| x + 0.5 * x).collect();
    let found: Vec<f32> = object(&asset, "arm").vertices.iter().filter(|v| v[2] == 0.0).map(|v| v[0]).collect();
    assert_eq!(found, wanted);
}

#[test]
fn quantised_weights_are_normalised() {
    let mut file = arm();
    let bytes: Vec<u8> = (0..6).flat_map(|at| if at % 3 == 1 { [100, 100, 0, 0] } else { [254, 0, 0, 0] }).collect();
    let weights = file.accessor(&bytes, 5121, "VEC4", 6);
    file.set("/meshes/0/primitives/0/attributes/WEIGHTS_0", json!(weights));
    let asset = file.import();
    let at_rest: Vec<f32> = object(&asset, "arm").vertices.iter().map(|v| v[0]).collect();
    assert!(at_rest.iter().all(|x| (x - x.round()).abs() < 1e-6), "{at_rest:?}");
}

#[test]
fn eight_bones_a_vertex() {
    let mut file = bending(arm());
    // The second set says what the first says; the first says nothing.
    let attributes = file.json["meshes"][0]["primitives"][0]["attributes"].clone();
    file.set("/meshes/0/primitives/0/attributes/JOINTS_1", attributes["JOINTS_0"].clone());
    file.set("/meshes/0/primitives/0/attributes/WEIGHTS_1", attributes["WEIGHTS_0"].clone());
    let none = file.vec4(&[[0.0; 4]; 6]);
    file.set("/meshes/0/primitives/0/attributes/WEIGHTS_0", json!(none));
    let asset = file.import_with(&ImportOptions { frames_per_second: 1.0, ..ImportOptions::default() });
    let flat = vertices(&asset.document.geometry.frames[0]);
    for ([x, y, _], found) in flat.iter().zip(vertices(&asset.document.geometry.frames[1])) {
        assert_near(found, bent(*x, *y, std::f32::consts::FRAC_PI_2), 1e-5);
    }
}

#[test]
fn vertices_with_other_bones_are_not_welded() {
    let mut file = Builder::new();
    let position = file.vec3(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let joints = file.accessor(
        &[[0_u8, 0, 0, 0]; 3].into_iter().chain([[1, 0, 0, 0]; 3]).flatten().collect::<Vec<_>>(),
        5121,
        "VEC4",
        6,
    );
    let weights = file.vec4(&[[1.0, 0.0, 0.0, 0.0]; 6]);
    let attributes = json!({ "POSITION": position, "JOINTS_0": joints, "WEIGHTS_0": weights });
    file.push("meshes", json!({ "primitives": [{ "attributes": attributes }] }));
    file.push("nodes", json!({ "mesh": 0, "skin": 0 }));
    file.push("nodes", json!({}));
    file.push("nodes", json!({}));
    file.push("skins", json!({ "joints": [1, 2] }));
    assert_eq!(file.import().document.objects()[0].vertices.len(), 6);
}

/// A square with two morph targets: one lifts its right side, one moves all of it and tilts its normals.
fn morphing() -> Builder {
    let mut file = Builder::new();
    let position = file.vec3(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    let n = Vec3::new(0.6, 0.0, 0.8).to_array();
    let normal = file.vec3(&[n; 4]);
    let lift = file.vec3(&[[0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0; 3]]);
    let shift = file.vec3(&[[0.0, 2.0, 0.0]; 4]);
    let tilt = file.vec3(&[[-1.2, 0.0, 0.0]; 4]);
    let indices = file.indices(&[0, 1, 2, 0, 2, 3]);
    let primitive = json!({
        "attributes": { "POSITION": position, "NORMAL": normal },
        "indices": indices,
        "targets": [{ "POSITION": lift }, { "POSITION": shift, "NORMAL": tilt }],
    });
    file.push("meshes", json!({ "primitives": [primitive], "weights": [0.5, 0.0] }));
    file.push("nodes", json!({ "mesh": 0 }));
    file
}

#[test]
fn default_weights_shape_a_still_mesh() {
    let mut file = morphing();
    let [_, b, ..] = vertices(&file.import().document.geometry.frames[0])[..] else { panic!("four vertices") };
    assert_eq!(b, [1.0, 0.0, 0.5]);
    file.set("/nodes/0/weights", json!([1.0, 1.0]));
    let asset = file.import();
    let [_, b, ..] = vertices(&asset.document.geometry.frames[0])[..] else { panic!("four vertices") };
    assert_eq!(b, [1.0, 2.0, 1.0]);
}

#[test]
fn weights_move_vertices_and_normals() {
    let mut file = morphing();
    let times = file.scalars(&[0.0, 1.0]);
    let output = file.scalars(&[0.0, 0.0, 1.0, 1.0]);
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "weights" } });
    file.push("animations", json!({ "samplers": [{ "input": times, "output": output }], "channels": [channel] }));
    let asset = file.import_with(&ImportOptions { frames_per_second: 2.0, ..ImportOptions::default() });
    let geometry = &asset.document.geometry;
    assert_eq!((geometry.animation, geometry.frames.len()), (AnimationMode::Full, 3));
    for (number, frame) in (0_u16..).zip(&geometry.frames) {
        let weight = f32::from(number) / 2.0;
        let found = vertices(frame);
        assert_near(found[0], [0.0, 2.0 * weight, 0.0], 1e-6);
        assert_near(found[1], [1.0, 2.0 * weight, weight], 1e-6);
        // These normals are no face's mean, so they are explicit, and each frame has its own.
        let first = &geometry.frames[0].objects[0];
        let normals = match number {
            0 => object_normals(first, SmoothingRule::Masks),
            _ => frame_normals(first, &frame.objects[0], SmoothingRule::Masks),
        };
        let wanted = Vec3::new(0.6 - 1.2 * weight, 0.0, 0.8).normalize();
        assert_near(normals[0][0].to_array(), [wanted.x, -wanted.z, wanted.y], 1e-6);
    }
}

#[test]
fn spline_weights() {
    let mut file = morphing();
    let times = file.scalars(&[0.0, 1.0]);
    // Two weights: tangents in, values, tangents out, for two keys.
    let output = file.scalars(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let sampler = json!({ "input": times, "output": output, "interpolation": "CUBICSPLINE" });
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "weights" } });
    file.push("animations", json!({ "samplers": [sampler], "channels": [channel] }));
    let asset = file.import_with(&ImportOptions { frames_per_second: 4.0, ..ImportOptions::default() });
    assert_near(vertices(&asset.document.geometry.frames[1])[1], [1.0, 0.0, 0.156_25], 1e-6);
}

#[test]
fn rigid_objects_beside_a_skin_go_along_frame_by_frame() {
    let mut file = bending(arm());
    let position = file.vec3(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let normal = file.vec3(&[[0.6, 0.0, 0.8]; 3]);
    file.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": position, "NORMAL": normal } }] }));
    file.push("nodes", json!({ "mesh": 1, "name": "glove" }));
    file.set("/nodes/2/children", json!([3]));
    let asset = file.import_with(&ImportOptions { frames_per_second: 1.0, ..ImportOptions::default() });
    let names: Vec<String> = asset.document.objects().iter().map(|object| object.name.decoded()).collect();
    assert_eq!(names, ["arm", "shoulder", "elbow", "glove"], "what the glove hangs on stays");
    let last = &asset.document.geometry.frames[1].objects[3];
    assert_near(last.vertices[1], [1.0, 0.0, 1.0], 1e-6);
    // The normal (0.6, 0, 0.8) turned about z is (0, 0.6, 0.8).
    assert_near(last.frame_normals.as_ref().expect("explicit normals")[0], [0.0, -0.8, 0.6], 1e-6);
}
