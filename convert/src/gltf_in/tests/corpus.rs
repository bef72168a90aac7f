//! Real files, against trimesh 4.11 (instances, triangles, bounds) and three.js r180 (animated positions).

use aam::document::{AnimationMode, Header};
use aam::meaning::{Hierarchy, world_transforms};
use glam::Vec3;

use super::*;

fn load(file: &str, animation: Option<&str>) -> Option<Asset> {
    let path = corpus(file)?;
    let options = ImportOptions { animation: animation.map(str::to_owned), ..ImportOptions::default() };
    Some(crate::import(&path, &options, &Silent).unwrap_or_else(|error| panic!("{error}")))
}

/// Corners of all triangles in the world at a frame, object after object.
fn world_corners(asset: &Asset, frame: usize) -> Vec<Vec<Vec3>> {
    let document = &asset.document;
    let transforms = world_transforms(document, &Hierarchy::of(document.objects()), frame as f32);
    let shown = document.geometry.frames.get(frame).unwrap_or(&document.geometry.frames[0]);
    let objects = document.objects().iter().zip(&shown.objects).zip(transforms);
    objects
        .map(|((first, object), world)| {
            let triangles = &first.faces.as_ref().expect("faces").triangles;
            let vertices = triangles.iter().flat_map(|triangle| triangle.vertices);
            vertices.map(|vertex| world.transform_point3(Vec3::from(object.vertices[vertex as usize]))).collect()
        })
        .collect()
}

#[track_caller]
fn assert_bounds(asset: &Asset, frame: usize, low: [f32; 3], high: [f32; 3]) {
    let corners = world_corners(asset, frame);
    let (mut least, mut most) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for corner in corners.iter().flatten() {
        least = least.min(*corner);
        most = most.max(*corner);
    }
    let bound = 2e-5 * (Vec3::from(high) - Vec3::from(low)).length();
    assert_near(least.to_array(), low, bound);
    assert_near(most.to_array(), high, bound);
}

/// Bounds in glTF's axes as trimesh gives them.
#[track_caller]
fn assert_shape(file: &str, shown: usize, triangles: usize, low: [f32; 3], high: [f32; 3]) {
    let Some(asset) = load(file, Some("none")) else { return };
    let objects = asset.document.objects();
    let with_faces = objects.iter().filter(|object| !object.vertices.is_empty()).count();
    assert_eq!(with_faces, shown, "objects with geometry");
    let count: usize = objects.iter().filter_map(|object| object.faces.as_ref()).map(|f| f.triangles.len()).sum();
    assert_eq!(count, triangles, "triangles");
    assert_eq!(asset.document.header, Some(Header::Mesh));
    assert_bounds(&asset, 0, [low[0], -high[2], low[1]], [high[0], -low[2], high[1]]);
}

#[test]
fn duck() {
    assert_shape("Duck.glb", 1, 4212, [-0.692_985, 0.099_293_7, -0.613_282], [0.961_799, 1.639_7, 0.539_252]);
}

#[test]
fn box_textured() {
    assert_shape("BoxTextured.glb", 1, 12, [-0.5; 3], [0.5; 3]);
    let Some(asset) = load("BoxTextured.glb", None) else { return };
    let mesh = object(&asset, "Mesh");
    assert_eq!(mesh.vertices.len(), 8, "the cube's 24 corners are welded");
    assert!(mesh.faces.as_ref().expect("faces").normals.is_none(), "smoothing groups say it all");
}

#[test]
fn alpha_blend_mode_test() {
    let file = "AlphaBlendModeTest.glb";
    assert_shape(file, 9, 61, [-4.3, -0.1, -0.75], [4.3, 2.299_533_4, 0.55]);
    let Some(asset) = load(file, None) else { return };
    let cutoffs: Vec<Option<f32>> = (0..6).map(|at| single(&asset, at).alpha_cutoff).collect();
    assert_eq!(cutoffs, [Some(0.25), Some(0.75), None, None, None, Some(0.5)]);
    let opaque = single(&asset, 4).layers[0].as_ref().expect("a layer").file.decoded();
    assert!(decoded(&asset, &opaque).pixels().all(|pixel| pixel[3] == 255), "an opaque material's alpha is gone");
    let blend = single(&asset, 3).layers[0].as_ref().expect("a layer").file.decoded();
    assert!(decoded(&asset, &blend).pixels().any(|pixel| pixel[3] == 0), "a blended one's stays");
}

#[test]
fn cornell_box() {
    // trimesh counts primitives: three of them are one object with three materials here.
    assert_shape("CornellBox.glb", 4, 36, [-556.0, 0.0, -559.2], [0.0, 548.8, 0.000_122]);
}

#[test]
fn flight_helmet() {
    let file = "FlightHelmet/FlightHelmet.gltf";
    assert_shape(
        file,
        6,
        94_722,
        [-0.203_642_7, -0.000_021_424, -0.171_545_8],
        [0.162_940_64, 0.716_000_44, 0.200_029_16],
    );
    let Some(asset) = load(file, None) else { return };
    for at in 0..6 {
        let normal = single(&asset, at).layers[2].as_ref().expect("a normal map");
        assert_eq!(normal.normal_space, Some(aam::document::NormalSpace::Tangent));
        assert_eq!(normal.intensity, 1.0);
    }
    assert!(reported(&asset, Outcome::Changed, "normals"));
}

#[test]
fn fox_at_rest() {
    assert_shape("Fox.glb", 1, 576, [-12.592_718, -0.121_744_77, -88.095], [12.592_718, 78.907_19, 66.624_86]);
}

#[test]
fn fox_bends_as_in_three_js() {
    let Some(asset) = load("Fox.glb", Some("Survey")) else { return };
    assert_eq!(asset.document.geometry.animation, AnimationMode::Full);
    assert_eq!(asset.document.geometry.frames.len(), 104, "3.41667 s at 30 frames a second, and the end");
    let expected = [
        (0, [-29.899_78, -56.652_84, -0.130_67], [11.595_34, 84.3404, 74.642_07], [-29.264_14, -53.653_39, 48.310_09]),
        (
            10,
            [-24.159_64, -61.713_87, -0.130_69],
            [11.595_22, 85.675_89, 75.129_61],
            [-21.289_09, -60.898_34, 49.648_04],
        ),
        (37, [-11.595_91, -57.696_81, -0.130_91], [26.347_76, 82.761_64, 75.8726], [25.588_57, -55.399_73, 50.376_72]),
        (
            80,
            [-20.984_63, -68.741_34, -0.130_67],
            [12.592_68, 83.642_25, 79.320_26],
            [-0.000_05, -68.627_46, 57.249_83],
        ),
        (
            103,
            [-29.899_78, -56.652_84, -0.130_67],
            [11.595_34, 84.3404, 74.642_07],
            [-29.264_14, -53.653_39, 48.310_09],
        ),
    ];
    for (frame, low, high, last) in expected {
        assert_bounds(&asset, frame, low, high);
        let corners = &world_corners(&asset, frame)[0];
        assert_near(corners[1727].to_array(), last, 2e-3);
    }
}

#[test]
fn fox_has_other_clips() {
    let Some(asset) = load("Fox.glb", Some("2")) else { return };
    assert!(notes(&asset, "animation").contains("Run"));
    assert_bounds(&asset, 7, [-13.694_35, -74.169_75, -2.689_04], [13.280_89, 92.123_75, 74.084_11]);
    assert_bounds(&asset, 20, [-13.482_22, -67.062_63, -0.975_01], [13.516_59, 95.084_55, 77.126_24]);
    let Some(path) = corpus("Fox.glb") else { return };
    let options = ImportOptions { animation: Some("Sleep".into()), ..ImportOptions::default() };
    let error = crate::import(&path, &options, &Silent).expect_err("there is no such clip").to_string();
    assert!(error.contains("Survey") && error.contains("Walk") && error.contains("Run"), "{error}");
}

#[test]
fn truck_rolls_as_in_three_js() {
    let Some(asset) = load("CesiumMilkTruck.glb", None) else { return };
    assert_eq!(asset.document.header, Some(Header::Character));
    assert_eq!(asset.document.geometry.animation, AnimationMode::Keyframe);
    assert_eq!(asset.document.geometry.animation_frames, 39);
    let names: Vec<String> = asset.document.objects().iter().map(|object| object.name.decoded()).collect();
    let front = names.iter().position(|name| name == "Wheels").expect("wheels");
    let rear = names.iter().position(|name| name == "Wheels.001").expect("wheels");
    assert_bounds(&asset, 0, [-2.430_91, -1.396, 0.001_45], [2.438, 1.396, 2.584_37]);
    let expected = [
        (0, [1.594_17, -1.04, 0.771_65], [-1.131_04, 1.018, 0.388_09]),
        (11, [1.733, -1.04, 0.194_97], [-1.439_36, 1.018, 0.220_44]),
        (38, [1.531_01, -1.04, 0.794_74], [-1.127_52, 1.018, 0.427_72]),
    ];
    for (frame, first, last) in expected {
        let corners = world_corners(&asset, frame);
        assert_near(corners[front][500].to_array(), first, 2e-5);
        assert_near(corners[rear][2303].to_array(), last, 2e-5);
    }
}
