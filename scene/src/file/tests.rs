//! Tests of the scene file.

use std::sync::Arc;

use aam::Finding;

use super::*;
use crate::{
    Animation, Background, Falloff, Image, LightKind, LightShape, Material, MaterialId, Members, Mesh, MeshId, Node,
    NodeId, NodeMotion, Pixels, Projection, Scene, ShadowCulling, ShadowSettings, ShadowSource, Shadows, Subset,
    Texture, TextureId, TextureLayer,
};

fn everything() -> SceneFile {
    let light = |name: &str, kind, shape| Light {
        name: name.into(),
        kind,
        ambient: Vec3::splat(0.1),
        diffuse: Vec3::new(4.0, 0.3, 1.0 / 3.0),
        specular: Vec3::ONE,
        shape,
    };
    let camera = |name: &str, projection| Camera {
        name: name.into(),
        position: Vec3::new(0.1, -4.0, 1.5),
        target: Vec3::Z,
        up: Vec3::Z,
        projection,
        near: 0.01,
        far: 1000.0,
    };
    let (position, direction) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.0, -0.6, -0.8));
    SceneFile {
        up: Some(Up::Y),
        shading: Some(Shading::Linear),
        exposure: Some(-1.5),
        tone_map: Some(ToneMap::Aces),
        background: Some(BackgroundEntry::Picture("maps/sky \"1\".png".into())),
        environment: Some(EnvironmentEntry {
            diffuse: false,
            filter: Some(SpecularFilter::Mirror),
            rotation: -33.3,
            intensity: 0.25,
            ..EnvironmentEntry::new(EnvironmentPictures::One("maps/sky.hdr".into()))
        }),
        active_camera: Some("front".into()),
        assets: vec![
            AssetEntry {
                name: Some("Hélmet\n2".into()),
                position: Vec3::new(0.1, 1e-7, -3e8),
                rotation: Vec3::new(90.0, 0.0, 33.3),
                scale: Vec3::new(1.0, -1.0, 0.5),
                visible: false,
                nodes: vec![
                    NodeEntry { name: "visor".into(), occurrence: 1, visible: false },
                    NodeEntry { name: "visor".into(), occurrence: 3, visible: true },
                ],
                ..AssetEntry::new("../assets/helmet.gltf")
            },
            AssetEntry::new("room.aam"),
        ],
        lights: Some(vec![
            light("a", LightKind::Point { position, falloff: Falloff::None }, Some(LightShape::Sphere { radius: 0.2 })),
            light("", LightKind::Directional { direction }, None),
            light(
                "c",
                LightKind::Spot { position, direction, inner: 0.3, outer: 0.7, falloff: Falloff::InverseSquare },
                Some(LightShape::Rectangle { width: 2.0, height: 0.5 }),
            ),
            light("d", LightKind::Point { position, falloff: Falloff::None }, Some(LightShape::Disc { radius: 0.1 })),
        ]),
        shadows: Some(ShadowsEntry {
            sources: vec![
                ShadowEntry {
                    name: "key".into(),
                    enabled: false,
                    light: Some(LightEntry::Named("a".into())),
                    settings: "evsm4:resolution=512,radius=5".parse().unwrap(),
                    volume: Some(camera("", Projection::Perspective { fov_y: 0.7 })),
                },
                shadow("", Some(LightEntry::Numbered(2)), None),
                shadow("plan", None, Some(camera("", Projection::Orthographic { height: 12.5 }))),
            ],
            casters: Some(vec![
                MemberEntry { name: "visor \"1\"".into(), occurrence: None },
                MemberEntry { name: "part".into(), occurrence: Some(2) },
            ]),
            receivers: Some(Vec::new()),
            culling: ShadowCulling { back_faces: true, casters: false, sources: false },
            displaced: true,
        }),
        cameras: vec![
            camera("front", Projection::Perspective { fov_y: 0.7 }),
            camera("plan", Projection::Orthographic { height: 12.5 }),
        ],
    }
}

fn shadow(name: &str, light: Option<LightEntry>, volume: Option<Camera>) -> ShadowEntry {
    ShadowEntry { name: name.into(), enabled: true, light, settings: ShadowSettings::default(), volume }
}

#[test]
fn what_is_written_reads_back_the_same() {
    let bare = SceneFile::default();
    let dark = SceneFile { lights: Some(Vec::new()), ..everything() };
    let sky = SceneFile { background: Some(BackgroundEntry::Transparent), ..everything() };
    let faces = ["px", "nx", "py", "ny", "pz", "nz"].map(|name| PathBuf::from(format!("{name}.hdr")));
    let sky_box = SceneFile {
        background: Some(BackgroundEntry::Environment),
        environment: Some(EnvironmentEntry::new(EnvironmentPictures::Faces(Box::new(faces)))),
        ..everything()
    };
    let grey = SceneFile { background: Some(BackgroundEntry::Color(Vec3::new(0.18, 0.2, 0.23))), ..everything() };
    let only = |shadows| SceneFile { shadows: Some(shadows), ..SceneFile::default() };
    let empty = only(ShadowsEntry::default());
    let sources = only(ShadowsEntry {
        sources: vec![shadow("", Some(LightEntry::Numbered(1)), None)],
        ..ShadowsEntry::default()
    });
    assert!(!sources.to_text().unwrap().contains("[shadows]"), "what is usual is not written");
    for file in [everything(), bare, dark, sky, sky_box, grey, empty, sources] {
        let text = file.to_text().unwrap();
        assert_eq!(SceneFile::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}")), file, "{text}");
        assert_eq!(SceneFile::parse(&text).unwrap().to_text().unwrap(), text, "stable");
    }
}

#[test]
fn angles_are_written_as_people_would() {
    let mut file = everything();
    file.cameras[0].projection = Projection::Perspective { fov_y: 40.0_f32.to_radians() };
    let text = file.to_text().unwrap();
    assert!(text.contains("fov_y = 40.0\n"), "{text}");
    assert!(text.contains("color") || text.contains("picture = "), "{text}");
    assert!(text.contains("diffuse = [4.0, 0.3, 0.33333334]"), "{text}");
    for step in 1..3000 {
        let radians = step as f32 * 0.001;
        file.cameras[0].projection = Projection::Perspective { fov_y: radians };
        assert_eq!(SceneFile::parse(&file.to_text().unwrap()).unwrap(), file, "{radians}");
    }
}

#[test]
fn the_documented_example_reads() {
    let source = include_str!("../file.rs");
    let example: String = source
        .lines()
        .skip_while(|line| !line.contains("```toml"))
        .skip(1)
        .take_while(|line| !line.contains("```"))
        .map(|line| line.trim_start_matches("///").trim_start().to_owned() + "\n")
        .collect();
    let file = SceneFile::parse(&example).unwrap_or_else(|error| panic!("{error}\n{example}"));
    assert_eq!((file.assets.len(), file.cameras.len()), (1, 1));
    assert_eq!(file.lights.as_ref().map(Vec::len), Some(1));
    let shadows = file.shadows.unwrap();
    assert_eq!(shadows.sources[0].settings.to_string(), "evsm4:resolution=512,radius=5");
    assert_eq!(shadows.receivers.unwrap()[1].occurrence, Some(2));
    assert_eq!(shadows.culling, ShadowCulling::default());
    assert_eq!(file.cameras[0].up, Vec3::Z, "the scene's");
    assert_eq!((file.cameras[0].near, file.cameras[0].far), (0.04, 400.0));
    assert_eq!(file.assets[0].position, Vec3::new(0.0, 0.0, 1.5), "whole numbers are numbers");
}

#[test]
fn errors_name_the_place_and_the_key() {
    let camera = "[[camera]]\nposition = [1,0,0]\ntarget = [0,0,0]\n";
    for (text, line, key) in [
        ("up = \"z\"\ncolour = 1\n", 2, "colour"),
        ("up = \"x\"\n", 1, "x"),
        ("up = \"z\"\nexposure = 100\n", 2, "exposure"),
        ("tone_map = \"filmic\"\n", 1, "filmic"),
        ("[environment]\ndiffuse = true\n", 1, "picture"),
        ("[environment]\npicture = \"a\"\nfaces = { right = \"b\" }\n", 3, "left"),
        ("[environment]\npicture = \"a\"\nfilter = \"ggx\"\n", 3, "ggx"),
        ("[environment]\npicture = \"a\"\nintensity = -1\n", 1, "intensity"),
        ("[environment]\npicture = \"a\"\nrotation = inf\n", 1, "rotation"),
        ("[environment]\npicture = \"\"\n", 1, "picture"),
        ("[background]\ncolor = [0, 0, 0]\nenvironment = true\n", 1, "environment"),
        ("[[asset]]\npath = \"a\"\nposiiton = [0,0,0]\n", 3, "posiiton"),
        ("[[asset]]\nname = \"a\"\n", 1, "path"),
        ("[[asset]]\npath = \" \"\n", 1, "path"),
        ("[[asset]]\npath = \"a\"\nscale = [1, nan, 1]\n", 1, "scale"),
        ("[[asset]]\npath = \"a\"\nposition = [1, 1]\n", 3, ""),
        ("[[asset]]\npath = \"a\"\n[[asset.node]]\nname = \"n\"\nvisible = true\nhidden = 1\n", 6, "hidden"),
        ("[[asset]]\npath = \"a\"\n[[asset.node]]\nname = \"n\"\noccurrence = 0\nvisible = true\n", 3, "occurrence"),
        ("\n[[light]]\nkind = \"point\"\nposition = [0,0,0]\nrange = 3\n", 5, "range"),
        ("\n[[light]]\nkind = \"area\"\n", 3, "area"),
        ("\n[[light]]\nkind = \"point\"\n", 2, "position"),
        ("[[light]]\nkind = \"point\"\nposition = [0,0,0]\n\n[[light]]\nkind = \"spot\"\n", 5, "outer"),
        ("[[light]]\nkind = \"point\"\nposition = [0,0,0]\nouter = 3\n", 1, "outer"),
        ("[[light]]\nkind = \"directional\"\ndirection = [0,0,0]\n", 1, "direction"),
        ("[[light]]\nkind = \"directional\"\ndirection = [1,0,0]\ndiffuse = [-1,0,0]\n", 1, "diffuse"),
        (
            "[[light]]\nkind = \"directional\"\ndirection = [1,0,0]\nshape = { form = \"disc\", width = 1 }\n",
            1,
            "radius",
        ),
        ("[[light]]\nkind = \"directional\"\ndirection = [1,0,0]\nshape = { form = \"disc\", size = 1 }\n", 4, "size"),
        ("[background]\ncolor = [0,0,0]\npicture = \"a.png\"\n", 1, "picture"),
        (&format!("{camera}fov_y = 40\nheight = 2\n"), 1, "fov_y"),
        (&format!("{camera}fov_y = 180\n"), 1, "fov_y"),
        (&format!("{camera}fov_y = 40\nfovy = 40\n"), 5, "fovy"),
        (&format!("{camera}fov_y = 40\nnear = 2\nfar = 1\n"), 1, "near"),
        ("[[camera]]\nposition = [0,0,0]\ntarget = [0,0,0]\nfov_y = 40\n", 1, "target"),
        ("[shadows]\ncaster = [\"a\"]\n", 2, "caster"),
        ("[shadows]\ncasters = [1]\n", 2, "an object's name"),
        ("\n[shadows]\ncasters = [{ name = \"a\", occurrence = 0 }]\n", 2, "occurrence"),
        ("[[shadow]]\nname = \"a\"\n", 1, "`light` or a `volume`"),
        ("[[shadow]]\nlight = 0\n", 1, "number"),
        ("[[shadow]]\nlight = true\n", 2, "a light's name"),
        ("[[shadow]]\nlight = \"a\"\ntechnique = \"soft\"\n", 3, "is no shadow technique; there are hard, pcf"),
        ("[[shadow]]\nlight = \"a\"\n\ntechnique = \"hard:radius=3\"\n", 4, "has no parameter `radius`"),
        ("[[shadow]]\nlight = \"a\"\ntechnique = \"pcf:radius=11\"\n", 3, "from 1 to 10"),
        (
            "[[shadow]]\n[shadow.volume]\nposition = [1,0,0]\ntarget = [0,0,0]\nfov_y = 45\nnear = 1\n",
            2,
            "`near` and `far` are needed",
        ),
        (
            "[[shadow]]\nvolume = { position = [1,0,0], target = [0,0,0], near = 1, far = 2 }\n",
            2,
            "`fov_y` or `height`",
        ),
        ("[[shadow]]\nsource = 1\n", 2, "source"),
        ("up = \"z\"\nup = \"y\"\n", 2, "duplicate"),
        ("up = \"z\n", 1, ""),
    ] {
        let error = SceneFile::parse(text).expect_err(text);
        assert_eq!(error.position.line, line, "{error}\n{text}");
        assert!(error.message.contains(key), "{error} does not name {key}");
    }
}

#[test]
fn what_cannot_be_read_back_is_not_written() {
    let mut file = everything();
    file.assets[0].position.x = f32::NAN;
    assert!(file.to_text().unwrap_err().contains("position"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.scene.toml");
    assert!(file.write(&path).unwrap_err().to_string().contains("a.scene.toml"));
    assert!(!path.exists());
}

#[test]
fn files_are_written_whole_and_read_with_their_name_in_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.scene.toml");
    everything().write(&path).unwrap();
    assert_eq!(SceneFile::read(&path).unwrap(), everything());
    std::fs::write(&path, "up = \"z\"\nlihgt = 1\n").unwrap();
    let error = SceneFile::read(&path).unwrap_err().to_string();
    assert!(error.contains("a.scene.toml:2:1: error[scene/syntax]") && error.contains("lihgt"), "{error}");
    std::fs::write(&path, b"up = \"z\"\n# \xff\n").unwrap();
    let error = SceneFile::read(&path).unwrap_err().to_string();
    assert!(error.contains(":2:3:") && error.contains("UTF-8"), "{error}");
    assert!(SceneFile::read(&folder.path().join("none.scene.toml")).is_err());
}

#[test]
fn paths_are_relative_to_the_scene_file() {
    assert!(SceneFile::is_one(Path::new("a/b.Scene.TOML")) && !SceneFile::is_one(Path::new("b.toml")));
    assert_eq!(SceneFile::path_beside(Path::new("a/b.aam")), Path::new("a/b.scene.toml"));
    let file = SceneFile::of_asset(Path::new("a/b.scene.toml"), Path::new("a/c/d.aam"));
    assert_eq!(file.assets[0].path, Path::new("c/d.aam"));
    assert_eq!(file.asset_paths(Path::new("/x/b.scene.toml")), [Path::new("/x/c/d.aam")]);
    let file = SceneFile::of_asset(Path::new("/a/b.scene.toml"), Path::new("/c/d.aam"));
    assert_eq!(file.asset_paths(Path::new("/a/b.scene.toml")), [Path::new("/c/d.aam")]);
}

/// A scene with one node "part" in another "part", a mesh with a textured material, a light, a camera.
fn asset(color: f32) -> Scene {
    let image = Image { width: 1, height: 1, pixels: Pixels::Rgba8(vec![1, 2, 3, 4]) };
    let layer = TextureLayer {
        texture: TextureId(0),
        transform: glam::Mat3::IDENTITY,
        normal_space: crate::NormalSpace::Object,
        intensity: 1.0,
    };
    let material = Material { layers: [Some(layer), None, None, None], ..Material::default() };
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: vec![Vec3::Z; 3],
        indices: vec![0, 1, 2],
        subsets: vec![Subset { first_index: 0, index_count: 3, material: MaterialId(1) }],
        bounds: crate::Aabb { min: Vec3::ZERO, max: Vec3::new(1.0, 1.0, 0.0) },
        ..Mesh::default()
    };
    let node = |parent: Option<u32>| Node {
        name: "part".into(),
        parent: parent.map(NodeId),
        local: Affine3A::from_translation(Vec3::X),
        mesh: Some(MeshId(0)),
        visible: true,
    };
    Scene {
        nodes: vec![node(None), node(Some(0))],
        meshes: vec![Arc::new(mesh)],
        materials: vec![Material { diffuse: Vec3::splat(color), ..Material::default() }, material],
        textures: vec![Texture { name: "a.png".into(), path: Some("/a.png".into()), image: Ok(Arc::new(image)) }],
        lights: vec![Light {
            name: "lamp".into(),
            kind: LightKind::Spot {
                position: Vec3::X,
                direction: Vec3::X,
                inner: 0.1,
                outer: 0.2,
                falloff: Falloff::None,
            },
            ambient: Vec3::ZERO,
            diffuse: Vec3::ONE,
            specular: Vec3::ONE,
            shape: Some(LightShape::Disc { radius: 1.0 }),
        }],
        cameras: vec![Camera {
            name: "own".into(),
            position: Vec3::X,
            target: Vec3::ZERO,
            up: Vec3::Z,
            projection: Projection::Orthographic { height: 1.0 },
            near: 0.1,
            far: 10.0,
        }],
        ..Scene::default()
    }
}

fn at(x: f32) -> AssetEntry {
    AssetEntry { position: Vec3::X * x, ..AssetEntry::new("dir/a.aam") }
}

#[test]
fn assets_are_placed_and_share_what_is_the_same() {
    let turned = AssetEntry { rotation: Vec3::new(0.0, 0.0, 90.0), scale: Vec3::splat(2.0), ..at(5.0) };
    let file = SceneFile { assets: vec![at(0.0), turned, at(9.0)], ..SceneFile::default() };
    let built = file.assemble(vec![asset(0.5), asset(0.5), asset(0.7)], Path::new("s.scene.toml"));
    assert_eq!(built.warnings, []);
    let scene = built.scene;
    let parents: Vec<_> = scene.nodes.iter().map(|node| node.parent.map(NodeId::index)).collect();
    assert_eq!(parents, [None, Some(0), Some(1), None, Some(3), Some(4), None, Some(6), Some(7)]);
    assert_eq!(scene.nodes[3].name, "a.aam");
    let world = scene.world_transforms();
    assert!(world[5].transform_point3(Vec3::ZERO).abs_diff_eq(Vec3::new(5.0, 4.0, 0.0), 1e-5));
    assert_eq!(scene.textures.len(), 1);
    let colors: Vec<f32> = scene.materials.iter().map(|material| material.diffuse.x).collect();
    assert_eq!(colors, [0.5, 0.8, 0.7], "the textured one is the same in all");
    let meshes: Vec<_> = scene.nodes.iter().filter_map(|node| node.mesh).map(MeshId::index).collect();
    assert_eq!(meshes, [0; 6]);
    assert_eq!(scene.meshes[0].subsets[0].material, MaterialId(1));

    let LightKind::Spot { position, direction, .. } = scene.lights[1].kind else { panic!("a spot stays one") };
    assert!(position.abs_diff_eq(Vec3::new(5.0, 2.0, 0.0), 1e-5));
    assert!(direction.normalize().abs_diff_eq(Vec3::Y, 1e-6));
    let Some(LightShape::Disc { radius }) = scene.lights[1].shape else { panic!("a disc stays one") };
    assert!((radius - 2.0).abs() < 1e-5);
    assert_eq!(scene.cameras.len(), 3);
    assert!(scene.cameras[1].target.abs_diff_eq(Vec3::new(5.0, 0.0, 0.0), 1e-5));
}

#[test]
fn the_size_of_a_light_at_infinity_is_an_angle_and_does_not_grow() {
    let mut sunny = asset(0.5);
    sunny.lights[0].kind = LightKind::Directional { direction: Vec3::NEG_Z };
    let larger = AssetEntry { scale: Vec3::splat(3.0), ..at(0.0) };
    let file = SceneFile { assets: vec![larger], ..SceneFile::default() };
    let scene = file.assemble(vec![sunny], Path::new("s.scene.toml")).scene;
    assert_eq!(scene.lights[0].shape, Some(LightShape::Disc { radius: 1.0 }));
}

#[test]
fn rotations_are_about_x_then_y_then_z() {
    let entry = AssetEntry { rotation: Vec3::new(90.0, 0.0, 90.0), ..at(0.0) };
    // Y goes to Z under the first turn and stays there under the last.
    assert!(entry.placement().transform_vector3(Vec3::Y).abs_diff_eq(Vec3::Z, 1e-6));
    assert!(entry.placement().transform_vector3(Vec3::X).abs_diff_eq(Vec3::Y, 1e-6));
}

#[test]
fn up_axes_are_turned_to_the_scenes() {
    let file = SceneFile { up: Some(Up::Y), assets: vec![at(0.0), at(0.0)], ..SceneFile::default() };
    let other = Scene { up: Up::Y, shading: Shading::Linear, ..asset(0.5) };
    let scene = file.assemble(vec![asset(0.5), other], Path::new("s.scene.toml")).scene;
    assert_eq!((scene.up, scene.shading), (Up::Y, Shading::Linear));
    assert!(scene.nodes[0].local.transform_vector3(Vec3::Z).abs_diff_eq(Vec3::Y, 1e-6));
    assert!(scene.nodes[3].local.transform_vector3(Vec3::Z).abs_diff_eq(Vec3::Z, 1e-6));
}

#[test]
fn the_file_decides_over_lights_cameras_and_visibility() {
    let file = SceneFile {
        lights: Some(Vec::new()),
        cameras: vec![Camera { name: "own".into(), far: 77.0, ..asset(0.0).cameras[0].clone() }],
        active_camera: Some("own".into()),
        assets: vec![AssetEntry {
            nodes: vec![
                NodeEntry { name: "part".into(), occurrence: 2, visible: false },
                NodeEntry { name: "part".into(), occurrence: 3, visible: false },
            ],
            ..at(0.0)
        }],
        background: Some(BackgroundEntry::Picture("../sky.png".into())),
        ..SceneFile::default()
    };
    let built = file.assemble(vec![asset(0.5)], Path::new("s.scene.toml"));
    let codes: Vec<_> = built.warnings.iter().map(|finding| finding.code).collect();
    assert_eq!(codes, ["scene/node", "scene/background"]);
    let scene = built.scene;
    assert!(scene.lights.is_empty());
    assert_eq!(scene.cameras.len(), 1);
    assert_eq!(file.active(&scene).unwrap().far, 77.0);
    assert_eq!(scene.nodes.iter().map(|node| node.visible).collect::<Vec<_>>(), [true, true, false]);
    assert_eq!(scene.background, Background::default());
    let file = SceneFile { active_camera: Some("none".into()), ..SceneFile::default() };
    assert_eq!(file.assemble(Vec::new(), Path::new("s.scene.toml")).warnings[0].code, "scene/camera");
}

#[test]
fn a_background_picture_lies_in_the_scene_files_folder() {
    let folder = tempfile::tempdir().unwrap();
    image::RgbaImage::from_pixel(2, 1, image::Rgba([9, 9, 9, 255])).save(folder.path().join("sky.png")).unwrap();
    let file = SceneFile { background: Some(BackgroundEntry::Picture("sky.png".into())), ..SceneFile::default() };
    let scene = file.assemble(Vec::new(), &folder.path().join("a.scene.toml")).scene;
    let Background::Picture(image) = scene.background else { panic!("a picture") };
    assert_eq!((image.width, image.height), (2, 1));
}

#[test]
fn animations_run_together() {
    let moving = |fps, count: usize| {
        let locals = (0..count).map(|frame| Affine3A::from_translation(Vec3::Y * frame as f32)).collect();
        let nodes = vec![NodeMotion { node: NodeId(1), locals }];
        Scene { animation: Some(Animation { frames_per_second: fps, frame_count: count, nodes }), ..asset(0.5) }
    };
    let file = SceneFile { assets: vec![at(0.0), at(1.0), at(2.0)], ..SceneFile::default() };
    let built = file.assemble(vec![asset(0.5), moving(25.0, 3), moving(30.0, 5)], Path::new("s.scene.toml"));
    assert_eq!(built.warnings.iter().map(|finding| finding.code).collect::<Vec<_>>(), ["scene/frame-rate"]);
    let animation = built.scene.animation.unwrap();
    assert_eq!((animation.frames_per_second, animation.frame_count), (25.0, 5));
    let nodes: Vec<_> = animation.nodes.iter().map(|motion| (motion.node.index(), motion.locals.len())).collect();
    assert_eq!(nodes, [(5, 5), (8, 5)]);
    assert_eq!(animation.nodes[0].locals[4].translation.y, 2.0, "the shorter one stands still at its end");
}

#[test]
fn changes_are_recorded_and_come_back() {
    let mut file = SceneFile { assets: vec![at(0.0), at(5.0)], ..SceneFile::default() };
    let assets = || vec![asset(0.5), asset(0.7)];
    let before = file.assemble(assets(), Path::new("s.scene.toml")).scene;
    let mut after = before.clone();
    after.nodes[2].visible = false;
    after.nodes[3].visible = false;
    after.shading = Shading::Linear;
    after.background = Background::Color(Vec3::ONE);
    let camera = before.fitting_camera(1.0);
    file.record(&before, &after, &camera);
    assert_eq!(file.lights, None, "what did not change stays as it was");
    assert_eq!(file.assets[0].nodes, [NodeEntry { name: "part".into(), occurrence: 2, visible: false }]);
    let again = SceneFile::parse(&file.to_text().unwrap()).unwrap();
    let scene = again.assemble(assets(), Path::new("s.scene.toml")).scene;
    let hidden = |scene: &Scene| scene.nodes.iter().map(|node| node.visible).collect::<Vec<_>>();
    assert_eq!(hidden(&scene), hidden(&after));
    assert_eq!((scene.shading, &scene.background), (after.shading, &after.background));
    let view = again.active(&scene).unwrap();
    assert_eq!((view.name.as_str(), view.position, view.projection), ("view", camera.position, camera.projection));
    after.lights.clear();
    file.record(&before, &after, &camera);
    assert_eq!((file.lights.as_deref(), file.cameras.len()), (Some(&[][..]), 1));
}

/// A folder with a panorama of two pixels.
fn folder_with_sky() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let pixels = [[2.0, 0.5, 0.25], [1.0, 8.0, 0.0]].map(image::Rgb);
    let file = std::fs::File::create(folder.path().join("sky.hdr")).unwrap();
    image::codecs::hdr::HdrEncoder::new(file).encode(&pixels, 2, 1).unwrap();
    folder
}

#[test]
fn an_environment_lights_the_scene_and_is_behind_it() {
    let folder = folder_with_sky();
    let path = folder.path().join("a.scene.toml");
    let assembled = |text: &str| SceneFile::parse(text).unwrap().assemble(Vec::new(), &path);
    let built = assembled(
        "exposure = 1\ntone_map = \"neutral\"\n[environment]\npicture = \"sky.hdr\"\nspecular = false\nrotation = 90\n",
    );
    assert!(built.warnings.is_empty(), "{:?}", built.warnings);
    let environment = built.scene.environment.clone().unwrap();
    assert!(environment.diffuse && !environment.specular && environment.map.is_linear());
    assert!((environment.rotation - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    assert_eq!((built.scene.exposure, built.scene.tone_map), (1.0, ToneMap::Neutral));
    assert_eq!(built.scene.background, Background::Environment);

    let painted = assembled("[background]\ncolor = [0, 0, 0]\n[environment]\npicture = \"sky.hdr\"\n");
    assert_eq!(painted.scene.background, Background::Color(Vec3::ZERO));
    for (text, reason) in [
        ("[environment]\npicture = \"none.hdr\"\n", "there is no such file"),
        ("[environment]\npicture = \"../other.hdr\"\n", "leads out of"),
        (
            "[environment.faces]\nright = \"sky.hdr\"\nleft = \"sky.hdr\"\nup = \"sky.hdr\"\ndown = \"sky.hdr\"\n\
             front = \"sky.hdr\"\nback = \"sky.hdr\"\n",
            "face right is 2 × 1 pixels",
        ),
    ] {
        let built = assembled(text);
        let Finding { code, message, .. } = &built.warnings[0];
        assert_eq!(*code, "scene/environment");
        assert!(message.contains(reason) && message.ends_with("lit by its lights"), "{message}");
        assert_eq!((built.scene.environment, built.scene.background), (None, Background::default()));
    }
}

#[test]
fn changes_of_an_environment_are_recorded() {
    let folder = folder_with_sky();
    let path = folder.path().join("a.scene.toml");
    let mut file = SceneFile::parse("[environment]\npicture = \"sky.hdr\"\nrotation = 12.3\n").unwrap();
    let before = file.assemble(Vec::new(), &path).scene;
    let mut after = before.clone();
    (after.exposure, after.tone_map) = (2.0, ToneMap::Reinhard);
    let environment = after.environment.as_mut().unwrap();
    (environment.diffuse, environment.filter, environment.intensity) = (false, Some(SpecularFilter::Phong), 3.0);
    file.record(&before, &after, &before.fitting_camera(1.0));
    let entry = file.environment.clone().unwrap();
    assert_eq!((entry.diffuse, entry.filter, entry.intensity), (false, Some(SpecularFilter::Phong), 3.0));
    assert_eq!((entry.rotation, file.exposure, file.tone_map), (12.3, Some(2.0), Some(ToneMap::Reinhard)));
    assert_eq!(file.background, None, "what is the same stays as it is");
}

#[test]
fn shadows_find_their_objects_and_lights_by_name() {
    let text = "\
[[asset]]\npath = \"a.aam\"\n[[asset]]\npath = \"b.aam\"\n
[shadows]\ncasters = [\"a.aam\", { name = \"part\", occurrence = 3 }]\nreceivers = [\"part\", \"pert\", { name = \"part\", occurrence = 5 }]\n
[[shadow]]\nname = \"first\"\nlight = \"lamp\"\n[[shadow]]\nlight = 2\ntechnique = \"esm\"\n
[[shadow]]\nlight = \"lmap\"\n[[shadow]]\nname = \"x\"\nlight = 3\n";
    let file = SceneFile::parse(text).unwrap();
    let built = file.assemble(vec![asset(0.5), asset(0.7)], Path::new("s.scene.toml"));
    let shadows = built.scene.shadows.unwrap();
    assert_eq!(shadows.casters, Members::Only([0, 4].map(NodeId).into()));
    assert_eq!(shadows.receivers, Members::Only([1, 2, 4, 5].map(NodeId).into()));
    let sources: Vec<_> = shadows.sources.iter().map(|source| (source.name.as_str(), source.light)).collect();
    assert_eq!(sources, [("first", Some(0)), ("", Some(1))], "what belongs to no light that is there is left out");
    let messages: Vec<String> =
        built.warnings.iter().map(|finding| format!("{}: {}", finding.subject, finding.message)).collect();
    assert_eq!(
        messages,
        [
            "receivers of [shadows]: there is no object \"pert\"; there are \"a.aam\", \"b.aam\", \"part\" (did you mean \"part\"?)",
            "receivers of [shadows]: there are only 4 objects \"part\", no number 5",
            "shadow 3: there is no light \"lmap\"; there are \"lamp\", \"lamp\" (did you mean \"lamp\"?); the shadow is left out",
            "shadow \"x\": there is no light number 3; there are 2; the shadow is left out",
        ]
    );
}

#[test]
fn changed_shadows_are_recorded_and_come_back() {
    let mut file = SceneFile { assets: vec![at(0.0), at(5.0)], ..SceneFile::default() };
    let assets = || vec![asset(0.5), asset(0.7)];
    let before = file.assemble(assets(), Path::new("s.scene.toml")).scene;
    let camera = before.fitting_camera(1.0);
    let mut after = before.clone();
    file.record(&before, &after, &camera);
    assert_eq!(file.shadows, None);
    after.shadows = Some(Shadows {
        sources: vec![
            ShadowSource { name: "s".into(), ..ShadowSource::of_light(1, "vsm:radius=4".parse().unwrap()) },
            ShadowSource { light: None, volume: Some(camera.clone()), ..ShadowSource::of_light(0, Default::default()) },
        ],
        casters: Members::Only([0, 4].map(NodeId).into()),
        receivers: Members::Only([1, 2, 4, 5].map(NodeId).into()),
        ..Shadows::default()
    });
    file.record(&before, &after, &camera);
    let text = file.to_text().unwrap();
    assert!(text.contains("receivers = [\"part\"]") && text.contains("light = 2"), "the second \"lamp\": {text}");
    let scene = SceneFile::parse(&text).unwrap().assemble(assets(), Path::new("s.scene.toml")).scene;
    let unnamed = |shadows: Option<Shadows>| {
        let mut shadows = shadows.unwrap();
        shadows.sources[1].volume.as_mut().unwrap().name.clear();
        shadows
    };
    assert_eq!(unnamed(scene.shadows), unnamed(after.shadows.clone()));
    // A light that gets a name of its own is found by it.
    after.lights[1].name = "window".into();
    file.record(&before, &after, &camera);
    assert!(file.to_text().unwrap().contains("light = \"window\""));
}
