//! Rigid motion: every kind of interpolation, against formulas worked out here.

use aam::document::{AnimationMode, Header};
use aam::meaning::{Hierarchy, world_transforms};
use glam::{Quat, Vec3};

use super::*;

/// A triangle whose node moves by one channel.
fn moving(path: &str, times: &[f32], outputs: usize, interpolation: &str, mut file: Builder) -> Builder {
    let input = file.scalars(times);
    let sampler = json!({ "input": input, "output": outputs, "interpolation": interpolation });
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": path } });
    file.push("animations", json!({ "name": "move", "samplers": [sampler], "channels": [channel] }));
    file
}

fn at_rate(rate: f32) -> ImportOptions {
    ImportOptions { frames_per_second: rate, ..ImportOptions::default() }
}

/// Where the node's point (1, 0, 0) is at a frame, in glTF's axes.
fn point(asset: &Asset, frame: f32) -> [f32; 3] {
    let document = &asset.document;
    let world = world_transforms(document, &Hierarchy::of(document.objects()), frame)[0];
    let point = world.transform_point3(Vec3::X);
    [point.x, point.z, -point.y]
}

#[test]
fn linear_translation() {
    let mut file = Builder::triangle();
    let output = file.vec3(&[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 8.0, 0.0]]);
    let asset = moving("translation", &[0.5, 1.0, 2.0], output, "LINEAR", file).import_with(&at_rate(10.0));
    assert_eq!(asset.document.header, Some(Header::Character));
    assert_eq!(asset.document.geometry.animation, AnimationMode::Keyframe);
    assert_eq!(asset.document.geometry.animation_frames, 21);
    assert_eq!(asset.document.geometry.frames_per_second, Some(10.0));
    for (frame, wanted) in [
        (0.0, [1.0, 0.0, 0.0]),
        (5.0, [1.0, 0.0, 0.0]),
        (6.0, [1.8, 0.0, 0.0]),
        (10.0, [5.0, 0.0, 0.0]),
        (15.0, [5.0, 4.0, 0.0]),
        (20.0, [5.0, 8.0, 0.0]),
        (99.0, [5.0, 8.0, 0.0]),
    ] {
        assert_near(point(&asset, frame), wanted, 1e-5);
    }
}

#[test]
fn a_clip_that_ends_between_frames_gets_one_more() {
    let mut file = Builder::triangle();
    let output = file.vec3(&[[0.0; 3], [1.0, 0.0, 0.0]]);
    let asset = moving("translation", &[0.0, 0.25], output, "LINEAR", file).import_with(&at_rate(10.0));
    assert_eq!(asset.document.geometry.animation_frames, 4);
    assert_near(point(&asset, 2.0), [1.8, 0.0, 0.0], 1e-6);
    assert_near(point(&asset, 3.0), [2.0, 0.0, 0.0], 1e-6);
}

#[test]
fn steps_hold_until_the_next_key() {
    let mut file = Builder::triangle();
    let output = file.vec3(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    let asset = moving("translation", &[0.0, 0.5, 1.0], output, "STEP", file).import_with(&at_rate(10.0));
    for (frame, wanted) in [(0.0, 1.0), (4.0, 1.0), (5.0, 2.0), (9.0, 2.0), (10.0, 3.0)] {
        assert_near(point(&asset, frame), [wanted, 0.0, 0.0], 1e-6);
    }
}

#[test]
fn cubic_splines_scale_their_tangents_by_the_interval() {
    // One interval of two seconds; value 0 with outgoing tangent 3, value 1 with incoming tangent -1.
    let mut file = Builder::triangle();
    let x = |value: f32| [value, 0.0, 0.0];
    let output = file.vec3(&[x(9.0), x(0.0), x(3.0), x(-1.0), x(1.0), x(9.0)]);
    let asset = moving("translation", &[0.0, 2.0], output, "CUBICSPLINE", file).import_with(&at_rate(8.0));
    for frame in [0_u16, 3, 8, 13, 16] {
        let s = f32::from(frame) / 16.0;
        let (ss, sss) = (s * s, s * s * s);
        let wanted = 2.0 * (sss - 2.0 * ss + s) * 3.0 + (3.0 * ss - 2.0 * sss) - 2.0 * (sss - ss);
        assert_near(point(&asset, f32::from(frame)), [1.0 + wanted, 0.0, 0.0], 1e-5);
    }
}

#[test]
fn rotations_take_the_shorter_way_at_even_speed() {
    let axis = Vec3::new(1.0, 1.0, 0.5).normalize();
    let (from, to) = (Quat::from_axis_angle(axis, 0.2), Quat::from_axis_angle(axis, 2.2));
    let mut file = Builder::triangle();
    let output = file.vec4(&[from.to_array(), (-to).to_array()]);
    let asset = moving("rotation", &[0.0, 1.0], output, "LINEAR", file).import_with(&at_rate(10.0));
    for frame in 0..=10_u16 {
        let wanted = Quat::from_axis_angle(axis, 0.2 + 0.2 * f32::from(frame)) * Vec3::X;
        assert_near(point(&asset, f32::from(frame)), wanted.to_array(), 1e-5);
    }
}

#[test]
fn quantised_rotations() {
    let half = (0.5_f32.sqrt() * 32767.0).round() as i16;
    let mut file = Builder::triangle();
    let values = [[0, 0, 0, 32767], [0, 0, half, half]];
    let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
    let output = file.accessor(&bytes, 5122, "VEC4", 2);
    file.set(&format!("/accessors/{output}/normalized"), json!(true));
    let asset = moving("rotation", &[0.0, 1.0], output, "LINEAR", file).import_with(&at_rate(2.0));
    let half = 0.5_f32.sqrt();
    assert_near(point(&asset, 1.0), [half, half, 0.0], 1e-4);
    assert_near(point(&asset, 2.0), [0.0, 1.0, 0.0], 1e-4);
}

#[test]
fn spline_rotations_are_normalised() {
    let mut file = Builder::triangle();
    let (none, id) = ([0.0; 4], [0.0, 0.0, 0.0, 1.0]);
    let turned = Quat::from_rotation_z(1.0);
    let output = file.vec4(&[none, id, none, none, turned.to_array(), none]);
    let asset = moving("rotation", &[0.0, 1.0], output, "CUBICSPLINE", file).import_with(&at_rate(4.0));
    // Between flat tangents the weights are 3s² - 2s³, at a quarter 0.15625.
    let mixed = (Quat::from_array(id) * (1.0 - 0.156_25) + turned * 0.156_25).normalize();
    assert_near(point(&asset, 1.0), (mixed * Vec3::X).to_array(), 1e-5);
}

#[test]
fn scales_and_rests() {
    let mut file = Builder::triangle();
    file.set("/nodes/0/translation", json!([0.0, 0.0, 7.0]));
    let output = file.vec3(&[[1.0, 1.0, 1.0], [3.0, 1.0, -1.0]]);
    let asset = moving("scale", &[0.0, 1.0], output, "LINEAR", file).import_with(&at_rate(30.0));
    assert_eq!(asset.document.geometry.frames_per_second, None, "30 is what a file without FPS means");
    assert_near(point(&asset, 15.0), [2.0, 0.0, 7.0], 1e-5);
    let tracks = object(&asset, "node 0").keys.as_ref().expect("keys");
    assert_eq!(tracks.len(), 1, "what does not move has no keys");
}

#[test]
fn children_follow_and_do_not_repeat_keys() {
    let mut file = Builder::triangle();
    file.set("/nodes/0/children", json!([1]));
    file.push("nodes", json!({ "mesh": 0, "translation": [0.0, 1.0, 0.0], "name": "child" }));
    let output = file.vec3(&[[0.0; 3], [1.0, 0.0, 0.0]]);
    let asset = moving("translation", &[0.0, 1.0], output, "LINEAR", file).import_with(&at_rate(10.0));
    assert!(object(&asset, "child").keys.as_ref().is_none());
    let document = &asset.document;
    let world = world_transforms(document, &Hierarchy::of(document.objects()), 5.0)[1];
    assert_near(world.transform_point3(Vec3::ZERO).to_array(), [0.5, 0.0, 1.0], 1e-6);
}

#[test]
fn a_clip_is_chosen_by_name_or_number() {
    let mut file = Builder::triangle();
    let output = file.vec3(&[[0.0; 3], [1.0, 0.0, 0.0]]);
    let mut file = moving("translation", &[0.0, 1.0], output, "LINEAR", file);
    let up = file.vec3(&[[0.0; 3], [0.0, 1.0, 0.0]]);
    let mut second = file.json["animations"][0].clone();
    second["name"] = json!("rise");
    second["samplers"][0]["output"] = json!(up);
    file.push("animations", second);
    let chosen = |name: Option<&str>| ImportOptions { animation: name.map(str::to_owned), ..ImportOptions::default() };
    for (name, end) in [(None, [2.0, 0.0, 0.0]), (Some("rise"), [1.0, 1.0, 0.0]), (Some("1"), [1.0, 1.0, 0.0])] {
        let asset = file.import_with(&chosen(name));
        assert_near(point(&asset, 30.0), end, 1e-6);
        assert!(reported(&asset, Outcome::Lost, "animation"), "the other clip is reported");
    }
    let still = file.import_with(&chosen(Some("none")));
    assert_eq!(still.document.header, Some(Header::Mesh));
    let error = file.try_import(&chosen(Some("jump"))).expect_err("no such clip").to_string();
    assert!(error.contains("move") && error.contains("rise"), "{error}");
    let error = Builder::triangle().try_import(&chosen(Some("jump"))).expect_err("no clips").to_string();
    assert!(error.contains("none"), "{error}");
}

#[test]
fn a_clip_that_moves_nothing_visible_leaves_a_static_document() {
    let mut file = Builder::triangle();
    file.push("nodes", json!({ "name": "dust" }));
    let output = file.vec3(&[[0.0; 3], [1.0, 0.0, 0.0]]);
    let mut file = moving("translation", &[0.0, 1.0], output, "LINEAR", file);
    file.set("/animations/0/channels/0/target/node", json!(1));
    let asset = file.import();
    assert_eq!(asset.document.header, Some(Header::Mesh));
    assert_eq!(asset.document.geometry.animation, AnimationMode::None);
    assert!(notes(&asset, "animation").contains("nothing that is drawn"));
}

#[test]
fn motion_below_a_shear_is_written_frame_by_frame() {
    let mut file = Builder::triangle();
    let shear = [1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    file.push("nodes", json!({ "matrix": shear, "children": [0] }));
    let output = file.vec4(&[[0.0, 0.0, 0.0, 1.0], Quat::from_rotation_z(1.0).to_array()]);
    let asset = moving("rotation", &[0.0, 1.0], output, "LINEAR", file).import_with(&at_rate(1.0));
    assert_eq!(asset.document.geometry.animation, AnimationMode::Full);
    let [x, y, z] = asset.document.geometry.frames[1].objects[1].vertices[1];
    let (s, c) = 1.0_f32.sin_cos();
    assert_near([x, z, -y], [c + s, s, 0.0], 1e-6);
}

#[test]
fn channels_of_unknown_kind_are_reported() {
    let mut file = Builder::triangle();
    let output = file.vec3(&[[0.0; 3], [1.0, 0.0, 0.0]]);
    let mut file = moving("translation", &[0.0, 1.0], output, "LINEAR", file);
    let pointer = json!({ "sampler": 0, "target": { "path": "pointer" } });
    file.json["animations"][0]["channels"].as_array_mut().expect("channels").push(pointer);
    assert!(notes(&file.import(), "animation channel").contains("pointer"));
}
