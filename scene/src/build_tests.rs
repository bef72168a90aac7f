//! Tests of building scenes.

use std::collections::BTreeMap;
use std::sync::Mutex;

use aam::ReadOptions;
use glam::{Affine3A, Vec3};

use super::*;
use crate::{FoundTexture, NoTextures, NormalSpace, Pixels, TextureData};

/// Textures in memory; `same` names are one file. Counts how often each name is asked for.
#[derive(Default)]
struct Memory {
    files: BTreeMap<&'static str, (&'static str, Vec<u8>)>,
    asked: Mutex<Vec<String>>,
}

impl Memory {
    fn with(names: &[(&'static str, &'static str)]) -> Self {
        let mut file = Vec::new();
        let pixels = image::RgbaImage::from_pixel(1, 1, image::Rgba([10, 20, 30, 40]));
        pixels.write_to(&mut std::io::Cursor::new(&mut file), image::ImageFormat::Png).unwrap();
        let files = names.iter().map(|&(name, key)| (name, (key, file.clone()))).collect();
        Self { files, asked: Mutex::default() }
    }
}

impl TextureSource for Memory {
    fn find(&self, name: &str) -> Result<FoundTexture, String> {
        self.asked.lock().unwrap().push(name.to_owned());
        let (key, bytes) = self.files.get(name).ok_or("not there")?;
        Ok(FoundTexture { key: (*key).to_owned(), data: TextureData::InMemory(bytes.clone().into()) })
    }
}

fn read(text: &str) -> Document {
    aam::read(text.as_bytes(), &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}")).document
}

fn texture(name: &str, more: &str) -> String {
    format!("Y {{ FN: {name}\nFi: PYRAMIDAL\nIn: 1.0\nUA: 0\nVA: 0\nWA: 0\nUO: 0\nVO: 0\nUT: 1\nVT: 1\n{more}}}\n")
        .replace("{ ", "\n{\n")
}

/// A material with its layers as they stand in the file.
fn material(number: usize, name: &str, layers: &str) -> String {
    format!(
        "Mat# {number}\n{{\nName: {name}\nClass: Standard\nAm: 0.1 0.2 0.3\nDi: 0.5 0.5 0.5\nSp: 0 0 0\nTr: 0\nSh: 0.5\n\
         {layers}}}\n"
    )
}

fn file(materials: &[String], animation: &str, frames: &[String]) -> String {
    format!(
        "MATERIALS\nMatCount: {}\n{}ENDMATERIALS\nGEOMETRY SmGEnabled\nNObj: {}\nNFrames: {}\nAnimation_mode: {animation}\n\
         {}ENDGEOMETRY\n",
        materials.len(),
        materials.concat(),
        frames.first().map_or(0, |frame| frame.matches("Obj:").count()),
        frames.len(),
        frames.iter().enumerate().map(|(i, frame)| format!("Frame: {i}\n{{\n{frame}}}\n")).collect::<String>(),
    )
}

/// A square of two triangles in the XY plane with texture coordinates, `layers` of them.
fn square(id: i32, parent: i32, material: i32, layers: usize) -> String {
    let lines = |indices: &str| format!("TI: {indices}\n").repeat(layers);
    format!(
        "Obj: {id} square{id}\nPar: {parent}\n{{\nMatID: {material}\nV_List: 4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n\
         TV_List: 4\n0 0\n1 0\n1 1\n0 1\nI_List: 2 1\nNEWGROUP: 0\nI: 0 1 2 1\n{}I: 0 2 3 1\n{}ENDGROUP\n}}\n",
        lines("0 1 2"),
        lines("0 2 3"),
    )
}

fn built(text: &str, textures: &dyn TextureSource) -> Built {
    build(&read(text), textures, &BuildOptions::default())
}

fn codes(built: &Built) -> Vec<&'static str> {
    built.warnings.iter().map(|finding| finding.code).collect()
}

#[test]
fn a_square_is_four_vertices_with_what_its_material_uses() {
    let layers = format!("Tx: {}TS: N\n", texture("a.png", ""));
    let text = file(&[material(0, "m", &layers)], "None", &[square(0, -1, 0, 1)]);
    let Built { scene, warnings } = built(&text, &Memory::with(&[("a.png", "a")]));
    assert_eq!(warnings, []);
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
    assert_eq!(mesh.indices, [0, 1, 2, 0, 2, 3]);
    assert_eq!(mesh.normals, [Vec3::Z; 4]);
    assert!(mesh.uvs[0].is_some() && mesh.uvs[1..].iter().all(Option::is_none));
    assert!(mesh.tangents.is_none() && mesh.colors.is_none() && mesh.frames.is_empty());
    assert_eq!(mesh.bounds, crate::Aabb { min: Vec3::ZERO, max: Vec3::new(1.0, 1.0, 0.0) });
    assert_eq!(mesh.subsets.len(), 1);
    assert_eq!((mesh.subsets[0].first_index, mesh.subsets[0].index_count), (0, 6));
    let material = &scene.materials[0];
    assert_eq!((material.name.as_str(), material.exponent, material.ambient), ("m", 64.0, Vec3::new(0.1, 0.2, 0.3)));
    let image = scene.textures[0].image.as_ref().unwrap();
    assert_eq!(image.pixels, Pixels::Rgba8(vec![10, 20, 30, 40]));
    assert_eq!((scene.up, scene.nodes[0].name.as_str()), (Up::Z, "square0"));
    assert!(scene.animation.is_none());
}

#[test]
fn a_texture_that_cannot_be_had_is_warned_of_once() {
    let layers = format!("Tx: {}TS: N\n", texture("gone.png", ""));
    let materials = [material(0, "m", &layers), material(1, "n", &layers)];
    let text = file(&materials, "None", &[square(0, -1, 0, 1) + &square(1, -1, 1, 1)]);
    let source = Memory::default();
    let built = built(&text, &source);
    assert_eq!(codes(&built), ["texture/missing"]);
    assert_eq!(built.scene.textures[0].image, Err("not there".to_owned()));
    assert!(built.scene.materials[0].layers[0].is_some(), "the layer is kept");
    assert!(built.scene.meshes[0].uvs[0].is_none(), "what is not drawn needs no coordinates");
    assert_eq!(*source.asked.lock().unwrap(), ["gone.png"]);
}

#[test]
fn what_is_the_same_is_there_once() {
    let spelled = |name: &str| format!("Tx: {}TS: N\n", texture(name, ""));
    let materials = [
        material(0, "m", &spelled("a.png")),
        material(1, "m", &spelled("maps\\A.PNG")),
        material(2, "other", &spelled("a.png")),
        material(3, "unused", &spelled("unused.png")),
    ];
    let squares: String = (0..3).map(|id| square(id, -1, id, 1)).collect();
    let text = file(&materials, "None", &[squares + &square(3, -1, 0, 1)]);
    let source = Memory::with(&[("a.png", "a"), ("maps\\A.PNG", "a"), ("unused.png", "u")]);
    let Built { scene, warnings } = built(&text, &source);
    assert_eq!(warnings, []);
    assert_eq!(scene.textures.len(), 1, "one file under two names, and the unused one left out");
    let names: Vec<_> = scene.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["m", "other"]);
    let meshes: Vec<_> = scene.nodes.iter().map(|node| node.mesh.unwrap().index()).collect();
    assert_eq!(meshes, [0, 0, 1, 0]);
    assert_eq!(scene.meshes.len(), 2);
}

#[test]
fn tangents_only_where_a_tangent_space_map_is_drawn() {
    let layers = |space: &str| format!("Tx: N\nTS: N\nTN: {}", texture("n.png", &format!("NS: {space}\n")));
    let source = Memory::with(&[("n.png", "n"), ("l.png", "l")]);
    let text = |layers: String, count| file(&[material(0, "m", &layers)], "None", &[square(0, -1, 0, count)]);
    let scene = built(&text(layers("TANGENT"), 1), &source).scene;
    let tangents = scene.meshes[0].tangents.as_ref().unwrap();
    assert!(tangents.iter().all(|tangent| tangent.abs_diff_eq(Vec3::X.extend(1.0), 1e-6)));
    assert_eq!(scene.materials[0].layers[2].unwrap().normal_space, NormalSpace::Tangent);
    let scene = built(&text(layers("OBJECT"), 1), &source).scene;
    assert!(scene.meshes[0].tangents.is_none() && scene.meshes[0].uvs[2].is_some());
    assert!(built(&text(layers("TANGENT"), 1), &NoTextures).scene.meshes[0].tangents.is_none());
    let both = layers("TANGENT").replace("TS: N\n", &format!("TS: {}", texture("l.png", "")));
    let scene = built(&text(both.clone(), 2), &source).scene;
    assert!(scene.meshes[0].tangents.is_none(), "the light map wins");
    let only = Memory::with(&[("n.png", "n")]);
    assert!(built(&text(both, 2), &only).scene.meshes[0].tangents.is_some(), "a light map without image does not");
}

#[test]
fn parents_stand_before_children_and_empty_nodes_stay() {
    let objects = square(5, 9, -1, 0) + "Obj: 9 empty\nPar: -1\n{\nMatID: -1\nV_List: 0\nTV_List: 0\nI_List: 0\n}\n";
    let text = file(&[], "None", &[objects]);
    let Built { scene, .. } = built(&text, &NoTextures);
    assert_eq!(object_nodes(&read(&text)), [NodeId(1), NodeId(0)]);
    let nodes: Vec<_> = scene.nodes.iter().map(|node| (node.name.as_str(), node.parent, node.mesh.is_some())).collect();
    assert_eq!(nodes, [("empty", None, false), ("square5", Some(NodeId(0)), true)]);
    assert!(scene.nodes.iter().all(|node| node.local == Affine3A::IDENTITY));
    assert_eq!(scene.materials[0].name, "(default)");
}

#[test]
fn triangles_without_coordinates_lose_the_layer_only() {
    let layers = format!("Tx: {}TS: N\n", texture("a.png", ""));
    let bare = square(0, -1, 0, 1).replace("TI: 0 2 3\n", "");
    let built = built(&file(&[material(0, "m", &layers)], "None", &[bare]), &Memory::with(&[("a.png", "a")]));
    assert_eq!(codes(&built), ["mesh/uv-missing"]);
    let mesh = &built.scene.meshes[0];
    let layered: Vec<_> =
        mesh.subsets.iter().map(|subset| built.scene.materials[subset.material.index()].layers[0].is_some()).collect();
    assert_eq!(layered, [true, false]);
}

#[test]
fn vertex_colours_keep_vertices_apart() {
    let mut document = read(&file(&[], "None", &[square(0, -1, -1, 0)]));
    let object = &mut document.geometry.frames[0].objects[0];
    // The second triangle on vertices of its own in the same places.
    object.vertices.extend_from_within(0..3);
    object.faces.as_mut().unwrap().triangles[1].vertices = [4, 6, 3];
    let build = |document: &Document| build(document, &NoTextures, &BuildOptions::default()).scene.meshes[0].clone();
    assert_eq!(build(&document).positions.len(), 4, "equal corners are one vertex");
    let mut colors = vec![[1.0, 0.0, 0.0]; 7];
    document.geometry.frames[0].objects[0].colors = Some(colors.clone());
    let mesh = build(&document);
    assert_eq!(mesh.positions.len(), 4);
    assert_eq!(mesh.colors.as_ref().unwrap()[0], glam::Vec4::new(1.0, 0.0, 0.0, 1.0));
    colors[4] = [0.0, 1.0, 0.0];
    document.geometry.frames[0].objects[0].colors = Some(colors);
    assert_eq!(build(&document).positions.len(), 5);
}

fn moved(id: i32, heights: [f32; 4]) -> String {
    let [a, b, c, d] = heights;
    format!("Obj: {id} square{id}\nPar: -1\n{{\nMatID: -1\nV_List: 4\n0 0 {a}\n1 0 {b}\n1 1 {c}\n0 1 {d}\n}}\n")
}

#[test]
fn full_frames_move_the_same_vertices() {
    let frames = [
        square(0, -1, -1, 0) + &square(1, -1, -1, 0),
        moved(0, [0.0; 4]) + &moved(1, [0.0; 4]),
        moved(1, [0.0; 4]) + &moved(0, [0.0, 1.0, 1.0, 0.0]),
    ];
    let Built { scene, warnings } = built(&file(&[], "Full", &frames), &NoTextures);
    assert_eq!(warnings, []);
    let animation = scene.animation.as_ref().unwrap();
    assert_eq!((animation.frame_count, animation.frames_per_second, animation.nodes.len()), (3, 30.0, 0));
    let mesh = &scene.meshes[scene.nodes[0].mesh.unwrap().index()];
    assert_eq!(mesh.frames.len(), 2);
    assert_eq!(mesh.frames[0].positions, mesh.positions);
    let tilted = Vec3::new(-1.0, 0.0, 1.0).normalize();
    assert!(mesh.frames[1].normals.iter().all(|normal| normal.abs_diff_eq(tilted, 1e-6)), "found by id, not place");
    assert_eq!(mesh.frames[1].positions[1], Vec3::new(1.0, 0.0, 1.0));
    assert_eq!(mesh.bounds.max, Vec3::ONE);
    let still = &scene.meshes[scene.nodes[1].mesh.unwrap().index()];
    assert!(still.frames.is_empty(), "what never changes has no frames");
}

#[test]
fn vertices_that_part_later_are_not_welded() {
    // Two flat triangles that share an edge in frame 0 and fold in frame 1.
    let flat = square(0, -1, -1, 0).replace("2 1\nI:", "2 0\nI:").replace("3 1\n", "3 0\n");
    let flat = flat.replace("I: 0 1 2 1", "I: 0 1 2 0").replace("I: 0 2 3 1", "I: 0 2 3 0");
    let still = built(&file(&[], "None", std::slice::from_ref(&flat)), &NoTextures).scene;
    assert_eq!(still.meshes[0].positions.len(), 4, "coplanar: the same normals");
    let frames = [flat, moved(0, [0.0, 1.0, 0.0, 0.0])];
    let scene = built(&file(&[], "Full", &frames), &NoTextures).scene;
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.positions.len(), 6);
    let folded = &mesh.frames[0].normals;
    assert!(folded[mesh.indices[0] as usize].dot(folded[mesh.indices[3] as usize]) < 0.9);
}

#[test]
fn an_object_that_goes_missing_stays_where_it_was() {
    let frames =
        [square(0, -1, -1, 0), moved(0, [1.0; 4]), String::new(), moved(0, [2.0; 4])].map(|frame| frame.to_owned());
    let mut document = read(&file(&[], "Full", &frames[..2]));
    document.geometry.frames.push(aam::document::Frame::default());
    document.geometry.frames.push(document.geometry.frames[1].clone());
    document.geometry.frames[3].objects[0].vertices[0][2] = f32::NAN;
    let built = build(&document, &NoTextures, &BuildOptions::default());
    assert_eq!(codes(&built), ["animation/object-missing"]);
    assert_eq!(built.scene.meshes[0].frames.len(), 1);
    assert_eq!(built.scene.animation.as_ref().unwrap().frame_count, 4);
    document.geometry.frames.remove(2);
    let built = build(&document, &NoTextures, &BuildOptions::default());
    assert_eq!(built.scene.meshes[0].frames[1].positions[0].z, 1.0, "a position that is no number stays");
    let built = build(&document, &NoTextures, &BuildOptions { max_frames: 2 });
    assert_eq!(codes(&built), ["animation/cut"]);
    assert_eq!(built.scene.meshes[0].frames.len(), 1);
}

#[test]
fn keys_are_sampled_once_a_frame() {
    let object = "Obj: 0 box\nPar: -1\n{\nPiv: 0 0 0 0 0 0 0\nMir: 0\nTM: 1 0 0 0 1 0 0 0 1 5 0 0 1 1 1\nMatID: -1\nV_List: 0\n\
                  SKIN: N\nTV_List: 0\nI_List: 0\nAnim_Ctrl: Y\nPsSam: 2\n10 0 0 0\n14 8 0 0\n}\n\
                  Obj: 1 child\nPar: 0\n{\nPiv: 1 0 0 0 0 0 0\nMir: 0\nTM: 1 0 0 0 1 0 0 0 1 0 7 0 1 1 1\nMatID: -1\nV_List: 0\n\
                  SKIN: N\nTV_List: 0\nI_List: 0\nAnim_Ctrl: N\n}\n";
    let text = format!("AAM_CHARACTER\n{}", file(&[], "Keyframe", &[object.to_owned()]));
    let built = built(&text, &NoTextures);
    assert_eq!(codes(&built), ["pose/pivot"]);
    let scene = built.scene;
    let animation = scene.animation.unwrap();
    assert_eq!((animation.frame_count, animation.nodes.len()), (5, 1));
    let x: Vec<f32> = animation.nodes[0].locals.iter().map(|local| local.translation.x).collect();
    assert_eq!(x, [0.0, 2.0, 4.0, 6.0, 8.0]);
    assert_eq!(scene.nodes[0].local.translation.x, 0.0, "the first frame, not TM");
    assert_eq!(scene.nodes[1].local.translation.y, 7.0);
}

#[test]
fn an_endless_animation_is_cut() {
    let mut document = read(&file(&[], "Keyframe", &[square(0, -1, -1, 0)]));
    let row = |frame, x| aam::document::PositionSample { frame, position: [x, 0.0, 0.0] };
    let track = aam::document::Track::PositionSampled(vec![row(-1e38, 0.0), row(3e38, 1.0)]);
    document.geometry.frames[0].objects[0].keys = aam::document::Flagged::Yes(vec![track]);
    let built = build(&document, &NoTextures, &BuildOptions { max_frames: 100 });
    assert_eq!(codes(&built), ["animation/cut"]);
    assert_eq!(built.scene.animation.unwrap().frame_count, 100);
}

#[test]
fn nothing_builds_nothing() {
    let Built { scene, warnings } = build(&Document::default(), &NoTextures, &BuildOptions::default());
    assert!(scene.nodes.is_empty() && scene.bounds().is_empty() && warnings.is_empty());
}

#[test]
fn the_same_document_gives_the_same_scene() {
    let layers = format!("Tx: {}TS: {}", texture("a.png", ""), texture("gone.png", ""));
    let squares: String = (0..20).map(|id| square(id, id / 2 - 1, id % 3 - 1, 2)).collect();
    let text = file(&[material(0, "m", &layers), material(1, "n", "Tx: N\nTS: N\n")], "None", &[squares]);
    let source = Memory::with(&[("a.png", "a")]);
    let (a, b) = (built(&text, &source), built(&text, &source));
    assert_eq!(format!("{a:?}"), format!("{b:?}"));
}

/// A document with everything that a build looks at: layers, a Multi, smoothing, colours, keys of every kind, frames.
fn everything(animation: &str) -> String {
    let layers = format!("Tx: {}TS: N\nTN: {}", texture("a.png", ""), texture("n.png", "NS: TANGENT\n"));
    let materials = [material(0, "m", &layers), material(1, "n", "Tx: N\nTS: N\nAC: 0.5\n")];
    let keys = "PsSam: 2\n0 1 2 3\n9 4 5 6\nRtSam: 2\n0 1 0 0 1\n9 0 1 0 2\nScSam: 2\n0 0 0 0 1 1 2 3\n9 0 0 1 1 3 2 1\n\
                PsBez: 2\n0 1 2 3 1 1 1 2 2 2 0\n9 3 2 1 1 1 1 2 2 2 0\nRtBez: 2\n0 1 2 3 1 1 1 2 2 2 0\n9 3 2 1 1 1 1 2 2 2 0\n\
                ScBez: 2\n0 1 1 1 0 0 0 1 0 0 0 0 0 0 0\n9 2 2 2 0 0 0 1 0 0 0 0 0 0 0\nRtIPA: 2\n0 1 2 3\n9 2 3 4\n\
                RtTcb: 3\n0 1 0 0 1 0.1 0.2 0.3 0.4 0.5\n4 0 1 0 1 0 0 0 0 0\n9 0 0 1 1 0.5 0.4 0.3 0.2 0.1\n";
    let node = "Piv: 0 0 0 0 0 0 0\nMir: 1\nTM: 1 0 0 0 1 0 0 0 1 5 6 7 1 2 3\n";
    let objects: String = (0..3)
        .map(|id| {
            let object = square(id, id - 1, id % 2, 2);
            if animation == "Keyframe" {
                let object = object.replace("MatID", &format!("{node}MatID")).replace("TV_List", "SKIN: N\nTV_List");
                object.replace("ENDGROUP\n", &format!("ENDGROUP\nAnim_Ctrl: Y\n{keys}"))
            } else {
                object
            }
        })
        .collect();
    let later: String = (0..3).map(|id| moved(id, [0.0, 1.0, 2.0, 0.5])).collect();
    let frames = if animation == "Full" { vec![objects, later.clone(), later] } else { vec![objects] };
    let header = if animation == "Keyframe" { "AAM_CHARACTER\n" } else { "" };
    format!("{header}{}", file(&materials, animation, &frames))
}

#[test]
fn whatever_numbers_a_document_holds_the_scene_is_sound() {
    const ODD: [&str; 14] = [
        "0",
        "-1",
        "1",
        "7",
        "-0.0",
        "1e38",
        "-3e38",
        "1e-38",
        "nan",
        "-1.#IND",
        "inf",
        "2147483647",
        "-2147483648",
        "0.5",
    ];
    let source = Memory::with(&[("a.png", "a"), ("n.png", "n")]);
    let options = BuildOptions { max_frames: 50 };
    let mut seed = 1_u64;
    let mut random = |below: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % below
    };
    let (mut read, mut built) = (0, 0);
    for animation in ["None", "Full", "Keyframe"] {
        let text = everything(animation);
        let words: Vec<&str> = text.split_inclusive([' ', '\n']).collect();
        let numbers: Vec<usize> = (0..words.len()).filter(|&i| words[i].trim().parse::<f32>().is_ok()).collect();
        for _ in 0..1500 {
            let mut words = words.clone();
            let mut changed: Vec<String> = Vec::new();
            let places: Vec<usize> = (0..1 + random(3)).map(|_| numbers[random(numbers.len())]).collect();
            for &place in &places {
                let end = &words[place][words[place].trim_end().len()..];
                changed.push(format!("{}{end}", ODD[random(ODD.len())]));
            }
            for (&place, changed) in places.iter().zip(&changed) {
                words[place] = changed;
            }
            read += 1;
            let Ok(outcome) = aam::read(words.concat().as_bytes(), &ReadOptions::default()) else { continue };
            built += 1;
            check_sound(&build(&outcome.document, &source, &options).scene);
        }
    }
    assert!(built * 2 > read, "only {built} of {read} could be read");
}

fn check_sound(scene: &Scene) {
    for node in &scene.nodes {
        assert!(node.local.is_finite());
    }
    for motion in scene.animation.iter().flat_map(|animation| &animation.nodes) {
        assert!(motion.locals.iter().all(|local| local.is_finite()));
    }
    for mesh in &scene.meshes {
        let count = mesh.positions.len();
        let frames = mesh.frames.iter().map(|frame| (&frame.positions, &frame.normals));
        for (positions, normals) in [(&mesh.positions, &mesh.normals)].into_iter().chain(frames) {
            assert_eq!((positions.len(), normals.len()), (count, count));
            assert!(positions.iter().all(|position| position.is_finite()));
            assert!(normals.iter().all(|normal| normal.is_normalized()), "{normals:?}");
        }
        assert!(mesh.uvs.iter().flatten().all(|uvs| uvs.len() == count && uvs.iter().all(|uv| uv.is_finite())));
        for (tangent, normal) in mesh.tangents.iter().flatten().zip(&mesh.normals) {
            assert!(tangent.truncate().is_normalized() && tangent.truncate().dot(*normal).abs() < 1e-4);
        }
        assert!(mesh.indices.iter().all(|&index| (index as usize) < count));
        assert!(mesh.subsets.iter().all(|subset| subset.material.index() < scene.materials.len()));
    }
    for material in &scene.materials {
        assert!(material.exponent.is_finite() && material.ambient.is_finite() && material.opacity.is_finite());
        for layer in material.layers.iter().flatten() {
            assert!(layer.transform.is_finite() && layer.texture.index() < scene.textures.len());
        }
    }
}
