//! What is in the files, read by the `gltf` crate.

use aam::document::{Layer, NormalSpace, Unknown};
use aam_convert::{Outcome, Report};
use aam_scene::{Camera, Falloff, Light, LightKind, Projection};
use glam::{Mat4, Quat, Vec3};
use serde_json::Value;

use crate::documents::*;
use crate::{asset, export_to, png};

/// A GLB in memory.
pub(crate) struct Glb {
    pub document: gltf::Document,
    pub blob: Vec<u8>,
    pub json: Value,
}

impl Glb {
    pub(crate) fn of(bytes: &[u8]) -> Self {
        let json = gltf::binary::Glb::from_slice(bytes).expect("a GLB").json;
        let json = serde_json::from_slice(&json).expect("JSON");
        let mut file = gltf::Gltf::from_slice(bytes).expect("the gltf crate reads it");
        let blob = file.blob.take().unwrap_or_default();
        Self { document: file.document, blob, json }
    }

    pub(crate) fn node(&self, name: &str) -> gltf::Node<'_> {
        self.document.nodes().find(|node| node.name() == Some(name)).expect("a node of that name")
    }

    /// Triangles of a node's mesh: positions and normals, in glTF's axes, not transformed.
    pub(crate) fn triangles(&self, node: &str) -> Vec<[(Vec3, Vec3); 3]> {
        let mesh = self.node(node).mesh().expect("a mesh");
        mesh.primitives()
            .flat_map(|primitive| {
                let reader = primitive.reader(|_| Some(&self.blob));
                let positions: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from).collect();
                let normals: Vec<Vec3> = reader.read_normals().unwrap().map(Vec3::from).collect();
                let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
                indices
                    .chunks_exact(3)
                    .map(|corners| {
                        std::array::from_fn(|at| (positions[corners[at] as usize], normals[corners[at] as usize]))
                    })
                    .collect::<Vec<_>>()
            })
            .collect()
    }
}

/// Exports to a GLB in memory.
pub(crate) fn glb(asset: &aam_convert::Asset) -> (Glb, Report) {
    let folder = tempfile::tempdir().unwrap();
    let (path, report) = export_to(folder.path(), "m.glb", asset).unwrap();
    (Glb::of(&std::fs::read(path).unwrap()), report)
}

fn close(a: Vec3, b: Vec3) -> bool {
    (a - b).abs().max_element() < 1e-5
}

#[test]
fn axes_turn_and_faces_keep_their_outside() {
    let (file, _) = glb(&asset(hierarchy(), &[]));
    let accessor = file.node("root block").mesh().unwrap().primitives().next().unwrap().get(&gltf::Semantic::Positions);
    let accessor = accessor.unwrap();
    // AAM: x −1…1, y −1…3, z −1…5.
    assert_eq!(accessor.min().unwrap(), serde_json::json!([-1.0, -1.0, -3.0]));
    assert_eq!(accessor.max().unwrap(), serde_json::json!([1.0, 5.0, 1.0]));
    for [a, b, c] in file.triangles("root block") {
        let face = (b.0 - a.0).cross(c.0 - a.0).normalize();
        assert!(close(face, a.1) && close(face, b.1) && close(face, c.1), "flat sides, counter-clockwise");
        let middle = (a.0 + b.0 + c.0) / 3.0;
        assert!((middle - Vec3::new(0.0, 2.0, -1.0)).dot(face) > 0.0, "outwards");
    }
    // A flat box welds to four vertices a side, a smooth ball to one at each point.
    assert_eq!(accessor.count(), 24);
    let ball = file.node("Kugel").mesh().unwrap().primitives().next().unwrap();
    assert_eq!(ball.get(&gltf::Semantic::Positions).unwrap().count(), 42);
    assert!(
        file.triangles("Kugel").iter().flatten().all(|(position, normal)| position.normalize().dot(*normal) > 0.95)
    );
}

#[test]
fn hierarchy_and_names_are_kept() {
    let (file, _) = glb(&asset(hierarchy(), &[]));
    let children = |name: &str| -> Vec<String> {
        file.node(name).children().map(|child| child.name().unwrap_or("").to_owned()).collect()
    };
    assert_eq!(children("root block"), ["Kugel"]);
    assert_eq!(children("Kugel"), ["helper"]);
    let scene = file.document.default_scene().unwrap();
    let roots: Vec<_> = scene.nodes().map(|node| node.name().unwrap().to_owned()).collect();
    assert_eq!(roots, ["root block", "no material"]);
    assert!(file.document.nodes().all(|node| node.transform().matrix() == Mat4::IDENTITY.to_cols_array_2d()));
    let kept = &file.json["nodes"][1]["extras"]["AAM"];
    assert_eq!(kept["UserProp"], "weight = 3");
    assert_eq!(kept["id"], 7);
    let text = file.json["extras"]["AAM"]["MATERIALS"].as_str().unwrap();
    assert!(text.starts_with("MATERIALS\nMatCount: 2\n") && text.ends_with("ENDMATERIALS\n"), "{text}");
    assert!(file.json["asset"]["generator"].as_str().unwrap().starts_with("aam "));
}

#[test]
fn large_meshes_have_wide_indices() {
    let mut object = block(0, "many", [0.0; 3], [1.0; 3], 0);
    let faces = object.faces.as_mut().unwrap();
    let (vertices, triangles) = (object.vertices.clone(), faces.triangles.clone());
    for copy in 1..3000_u32 {
        object.vertices.extend(vertices.iter().map(|[x, y, z]| [x + 3.0 * copy as f32, *y, *z]));
        faces.triangles.extend(triangles.iter().map(|triangle| aam::document::Triangle {
            vertices: triangle.vertices.map(|vertex| vertex + 8 * copy),
            ..*triangle
        }));
    }
    faces.groups[0].triangles = faces.triangles.len();
    let (file, _) = glb(&asset(document(vec![single("m", |_| {})], vec![object]), &[]));
    let primitive = file.node("many").mesh().unwrap().primitives().next().unwrap();
    assert_eq!(primitive.indices().unwrap().data_type(), gltf::accessor::DataType::U32);
    assert_eq!(file.triangles("many").len(), 36_000);
}

#[test]
fn a_position_that_is_no_number_is_an_error_that_names_the_object() {
    let mut document = hierarchy();
    document.geometry.frames[0].objects[1].vertices[5][2] = f32::NAN;
    let folder = tempfile::tempdir().unwrap();
    let error = export_to(folder.path(), "m.glb", &asset(document, &[])).unwrap_err().to_string();
    assert!(error.contains("object 7 \"Kugel\"") && error.contains("vertex 5"), "{error}");
    assert!(!folder.path().join("m.glb").exists());
}

#[test]
fn an_empty_document_is_a_valid_file() {
    let (file, _) = glb(&asset(aam::Document::default(), &[]));
    assert_eq!(file.document.nodes().count(), 0);
    assert!(file.json.get("nodes").is_none() && file.json.get("buffers").is_none());
}

#[test]
fn vertex_colours_are_linear_and_materials_split_the_mesh() {
    let (file, report) = glb(&asset(several_materials(), &[]));
    let mesh = file.node("two").mesh().unwrap();
    let names: Vec<_> = mesh.primitives().map(|primitive| primitive.material().name().unwrap().to_owned()).collect();
    // Group 46 of two is 46 mod 2.
    assert_eq!(names, ["lamp", "glass"]);
    let glass = mesh.primitives().nth(1).unwrap();
    assert_eq!(glass.material().alpha_mode(), gltf::material::AlphaMode::Blend);
    assert!((glass.material().pbr_metallic_roughness().base_color_factor()[3] - 0.3).abs() < 1e-6);
    assert!(glass.material().double_sided());
    let lamp = mesh.primitives().next().unwrap().material();
    let strength = lamp.emissive_strength().unwrap();
    assert!((strength - aam_convert::phong::decode_srgb(1.5)).abs() < 1e-5);
    assert_eq!(lamp.emissive_factor()[0], 1.0);
    let reader = glass.reader(|_| Some(&file.blob));
    let colors: Vec<_> = reader.read_colors(0).unwrap().into_rgb_f32().collect();
    assert!(colors.iter().all(|color| (color[2] - aam_convert::phong::decode_srgb(0.25)).abs() < 1e-6));
    // Explicit normals, turned: (0, √½, √½) → (0, √½, −√½).
    let up = 0.5_f32.sqrt();
    let normals: Vec<_> = file.triangles("two").iter().flatten().map(|(_, normal)| *normal).collect();
    assert!(normals.iter().all(|n| close(*n, Vec3::X) || close(*n, Vec3::new(0.0, up, -up))));
    assert!(report.changes.iter().any(|change| change.subject.contains("glass") && change.property == "surface"));
}

/// The local matrix of a node at a time, from the channels of the file.
fn local_at(file: &Glb, node: &gltf::Node<'_>, time: f32) -> Mat4 {
    let (translation, rotation, scale) = node.transform().decomposed();
    let (mut t, mut r, mut s) = (Vec3::from(translation), Quat::from_array(rotation), Vec3::from(scale));
    for channel in file.document.animations().flat_map(|animation| animation.channels().collect::<Vec<_>>()) {
        if channel.target().node().index() != node.index() {
            continue;
        }
        let reader = channel.reader(|_| Some(&file.blob));
        let times: Vec<f32> = reader.read_inputs().unwrap().collect();
        let next = times.partition_point(|&key| key <= time).clamp(1, times.len() - 1);
        let part = ((time - times[next - 1]) / (times[next] - times[next - 1])).clamp(0.0, 1.0);
        match reader.read_outputs().unwrap() {
            gltf::animation::util::ReadOutputs::Translations(rows) => {
                let rows: Vec<Vec3> = rows.map(Vec3::from).collect();
                t = rows[next - 1].lerp(rows[next], part);
            }
            gltf::animation::util::ReadOutputs::Rotations(rows) => {
                let rows: Vec<Quat> = rows.into_f32().map(Quat::from_array).collect();
                r = rows[next - 1].slerp(rows[next], part);
            }
            gltf::animation::util::ReadOutputs::Scales(rows) => {
                let rows: Vec<Vec3> = rows.map(Vec3::from).collect();
                s = rows[next - 1].lerp(rows[next], part);
            }
            gltf::animation::util::ReadOutputs::MorphTargetWeights(_) => {}
        }
    }
    Mat4::from_scale_rotation_translation(s, r, t)
}

#[test]
fn characters_stand_and_move_as_in_the_document() {
    let document = character();
    let (file, _) = glb(&asset(document.clone(), &[]));
    let hierarchy = aam::meaning::Hierarchy::of(document.objects());
    for frame in [0.0, 1.0, 2.5, 5.0, 7.0, 10.0] {
        let expected = aam::meaning::world_transforms(&document, &hierarchy, frame);
        let names = ["upper", "lower", "hand"];
        let mut world = Mat4::IDENTITY;
        for (name, expected) in names.iter().zip(expected) {
            world *= local_at(&file, &file.node(name), frame / 25.0);
            for point in [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z] {
                let turned = |v: Vec3| Vec3::new(v.x, v.z, -v.y);
                let (got, wanted) = (world.transform_point3(turned(point)), turned(expected.transform_point3(point)));
                assert!((got - wanted).length() < 1e-4, "{name} at {frame}: {got} for {wanted}");
            }
        }
    }
    let scale = file.node("hand").transform().decomposed().2;
    assert!(scale.iter().product::<f32>() < 0.0, "mirrored: {scale:?}");
    let animation = file.document.animations().next().unwrap();
    let channels: Vec<_> = animation.channels().map(|channel| channel.target().property()).collect();
    assert_eq!(
        channels,
        [gltf::animation::Property::Rotation, gltf::animation::Property::Translation],
        "only what moves"
    );
}

#[test]
fn later_frames_are_morph_targets() {
    let document = multiframe();
    let (file, _) = glb(&asset(document.clone(), &[]));
    let rule = aam::meaning::SmoothingRule::of(&document);
    let mesh = file.node("ball").mesh().unwrap();
    let primitive = mesh.primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(&file.blob));
    let positions: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from).collect();
    let normals: Vec<Vec3> = reader.read_normals().unwrap().map(Vec3::from).collect();
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    let targets: Vec<_> = reader.read_morph_targets().collect();
    assert_eq!(targets.len(), 3);
    let first = &document.geometry.frames[0].objects[0];
    let faces = first.faces.as_ref().unwrap();
    for (frame, (moved, turned, _)) in targets.into_iter().enumerate() {
        let later = &document.geometry.frames[frame + 1].objects[0];
        let moved: Vec<Vec3> = moved.unwrap().map(Vec3::from).collect();
        let turned: Vec<Vec3> = turned.unwrap().map(Vec3::from).collect();
        let wanted_normals = aam::meaning::frame_normals(first, later, rule);
        let back = |v: Vec3| Vec3::new(v.x, -v.z, v.y);
        for (triangle, corners) in indices.chunks_exact(3).enumerate() {
            for corner in 0..3 {
                let vertex = corners[corner] as usize;
                let wanted = Vec3::from(later.vertices[faces.triangles[triangle].vertices[corner] as usize]);
                assert!((back(positions[vertex] + moved[vertex]) - wanted).length() < 1e-6);
                let normal = back(normals[vertex] + turned[vertex]);
                assert!((normal - wanted_normals[triangle][corner]).length() < 1e-6);
            }
        }
    }
    assert!(file.node("still").mesh().unwrap().primitives().next().unwrap().morph_targets().next().is_none());
    let channel = file.document.animations().next().unwrap().channels().next().unwrap();
    let reader = channel.reader(|_| Some(&file.blob));
    let times: Vec<f32> = reader.read_inputs().unwrap().collect();
    assert_eq!(times, [0.0, 0.1, 0.2, 0.3]);
    let Some(gltf::animation::util::ReadOutputs::MorphTargetWeights(weights)) = reader.read_outputs() else { panic!() };
    let weights: Vec<f32> = weights.into_f32().collect();
    assert_eq!(weights, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn bodies_have_motions_colliders_and_shapes() {
    let (file, _) = glb(&asset(physics(), &[]));
    let nodes = file.json["nodes"].as_array().unwrap();
    let named = |name: &str| nodes.iter().find(|node| node["name"] == name && node.get("mesh").is_none()).unwrap();
    let rigid = |node: &Value| node["extensions"]["KHR_physics_rigid_bodies"].clone();
    let top = &file.json["extensions"];
    let shape = |node: &Value| {
        let index = rigid(node)["collider"]["geometry"]["shape"].as_u64().unwrap() as usize;
        top["KHR_implicit_shapes"]["shapes"][index].clone()
    };
    let object = |name: &str| nodes.iter().find(|node| node["name"] == name).unwrap();
    assert_eq!(rigid(object("crate")), serde_json::json!({ "motion": { "mass": 4.5 } }));
    assert_eq!(rigid(object("ball")), serde_json::json!({ "motion": { "isKinematic": true } }));
    assert_eq!(rigid(object("floor")), Value::Null);

    let hull = rigid(named("crate hull 0"))["collider"].clone();
    assert_eq!(hull["geometry"]["convexHull"], true);
    let mesh_node = hull["geometry"]["node"].as_u64().unwrap() as usize;
    assert!(nodes[mesh_node].get("mesh").is_some());
    let in_scene = |index: usize| {
        let listed = |list: &Value| list.as_array().is_some_and(|list| list.iter().any(|at| at == index));
        listed(&file.json["scenes"][0]["nodes"]) || nodes.iter().any(|node| listed(&node["children"]))
    };
    assert!(!in_scene(mesh_node), "no viewer draws it");
    assert_eq!(rigid(named("floor collider"))["collider"]["geometry"]["convexHull"], Value::Null);

    assert_eq!(shape(named("ball sphere 0")), serde_json::json!({ "type": "sphere", "sphere": { "radius": 0.5 } }));
    assert_eq!(named("ball sphere 0")["translation"], serde_json::json!([0.0, 0.25, -0.0]));
    let size = shape(named("ball box 1"))["box"]["size"].clone();
    let size: Vec<f32> = serde_json::from_value(size).unwrap();
    assert!(close(Vec3::from_slice(&size), Vec3::new(0.2, 0.6, 0.4)), "AAM's x y z are glTF's x z y: {size:?}");
    let turn: Vec<f32> = serde_json::from_value(named("ball box 1")["rotation"].clone()).unwrap();
    let turned = Quat::from_slice(&turn) * Vec3::X;
    assert!(close(turned, Vec3::NEG_Z), "a right angle about up takes x to AAM's y, glTF's −z: {turned}");
    let capsule = shape(named("ball capsule 2"));
    assert_eq!(capsule["capsule"]["height"], 2.0);
    let materials = top["KHR_physics_rigid_bodies"]["physicsMaterials"].as_array().unwrap();
    assert_eq!(materials.len(), 2, "equal ones are shared");
    assert_eq!(materials[0]["staticFriction"].as_f64().unwrap() as f32, 0.6);
    let used: Vec<_> =
        file.json["extensionsUsed"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    assert!(used.contains(&"KHR_implicit_shapes") && used.contains(&"KHR_physics_rigid_bodies"), "{used:?}");
}

#[test]
fn lights_and_cameras_stand_where_they_stood() {
    let mut asset = asset(hierarchy(), &[]);
    let light = |kind: LightKind| Light {
        name: String::new(),
        kind,
        ambient: Vec3::ZERO,
        diffuse: Vec3::new(0.5, 1.0, 0.25),
        specular: Vec3::new(0.5, 1.0, 0.25),
        shape: None,
    };
    let position = Vec3::new(1.0, 2.0, 3.0);
    asset.lights = vec![
        light(LightKind::Directional { direction: Vec3::new(0.0, 0.0, -2.0) }),
        light(LightKind::Point { position, falloff: Falloff::InverseSquare }),
        light(LightKind::Spot {
            position,
            direction: Vec3::Y,
            inner: 0.2,
            outer: 0.4,
            falloff: Falloff::InverseSquare,
        }),
    ];
    asset.cameras = vec![Camera {
        name: "front".into(),
        position: Vec3::new(0.0, -10.0, 1.0),
        target: Vec3::new(0.0, 0.0, 1.0),
        up: Vec3::Z,
        projection: Projection::Perspective { fov_y: 0.7 },
        near: 0.1,
        far: 100.0,
    }];
    let (file, _) = glb(&asset);
    let lights: Vec<_> = file.document.lights().unwrap().collect();
    assert_eq!(lights[0].color(), [0.5, 1.0, 0.25]);
    assert!((lights[0].intensity() - std::f32::consts::PI).abs() < 1e-6, "lights a white surface to 1");
    let shines = |light: usize| {
        let node = file.document.nodes().find(|node| node.light().is_some_and(|own| own.index() == light)).unwrap();
        let matrix = Mat4::from_cols_array_2d(&node.transform().matrix());
        (matrix.transform_point3(Vec3::ZERO), matrix.transform_vector3(Vec3::NEG_Z))
    };
    assert!(close(shines(0).1, Vec3::NEG_Y), "down");
    assert!(close(shines(1).0, Vec3::new(1.0, 3.0, -2.0)));
    assert!(close(shines(2).1, Vec3::NEG_Z), "AAM's +y is glTF's −z");
    let camera = file.node("front");
    let matrix = Mat4::from_cols_array_2d(&camera.transform().matrix());
    assert!(close(matrix.transform_vector3(Vec3::NEG_Z), Vec3::NEG_Z));
    assert!(close(matrix.transform_vector3(Vec3::Y), Vec3::Y));
    assert!(close(matrix.transform_point3(Vec3::ZERO), Vec3::new(0.0, 1.0, 10.0)));
}

#[test]
fn unknown_tags_and_missing_textures_are_reported_and_kept() {
    let mut document = hierarchy();
    let with_texture = single("textured", |single| {
        texture(single, Layer::Diffuse, "wood.png", |_| {});
        texture(single, Layer::Normal, "bumps.png", |texture| texture.normal_space = Some(NormalSpace::Tangent));
    });
    document.materials[0] = with_texture;
    document.geometry.frames[0].objects[2] = block(3, "root block", [0.0; 3], [1.0; 3], 2);
    document.geometry.frames[0].objects[2].unknown =
        vec![Unknown { before: Some(("V_List:", 0)), text: "Glow: 3".into() }];
    let (file, report) = glb(&asset(document, &[("bumps.png", png(4, 4, |_, _| [128, 128, 255, 255]))]));
    let lost: Vec<_> = report.changes.iter().filter(|change| change.outcome == Outcome::Lost).collect();
    assert!(lost.iter().any(|change| change.subject.contains("wood.png")), "{lost:?}");
    assert!(!lost.iter().any(|change| change.subject.contains("bumps.png")), "{lost:?}");
    let kept = file.json["nodes"][2]["extras"]["AAM"]["unknown"].clone();
    assert_eq!(kept, serde_json::json!([{ "before": "V_List:", "lines": ["Glow: 3"] }]));
    let primitive = file.node("root block").mesh().unwrap().primitives().next().unwrap();
    assert!(primitive.get(&gltf::Semantic::Tangents).is_some(), "a normal map comes with tangents");
    assert!(primitive.get(&gltf::Semantic::TexCoords(0)).is_some());
    assert!(primitive.get(&gltf::Semantic::TexCoords(1)).is_none(), "both layers have the same coordinates");
}
