//! From a document to GLB and back.

use std::collections::BTreeMap;

use aam::Document;
use aam::document::{AnimationMode, Layer, NormalSpace};
use aam::meaning::{Hierarchy, LeafMaterial, Materials, ObjectMesh, SmoothingRule, frame_normals, world_transforms};
use aam_convert::{ImportOptions, Silent, import};
use glam::Vec3;

use crate::corpus::corpus;
use crate::documents::*;
use crate::{asset, export_to, png};

/// Exports to GLB and imports that.
fn there_and_back(asset: &aam_convert::Asset, options: &ImportOptions) -> Document {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = export_to(folder.path(), "m.glb", asset).unwrap();
    import(&path, options, &Silent).unwrap().document
}

/// Position, normal, and the texture coordinates of each layer.
type Corner = (Vec3, Vec3, [Option<[f32; 2]>; 4]);

/// What a triangle looks like, corner by corner, and the name of its material.
#[derive(Clone, Debug)]
struct Face {
    corners: [Corner; 3],
    material: Option<String>,
}

fn faces(document: &Document, object: usize) -> Vec<Face> {
    let materials = Materials::of(document);
    let mesh = ObjectMesh::of(&document.objects()[object], &materials, SmoothingRule::of(document));
    let vertices = &document.objects()[object].vertices;
    let mut faces = Vec::new();
    for subset in &mesh.subsets {
        let leaf = subset.material.map(|leaf| &materials.leaves()[leaf]);
        for triangle in subset.first..subset.first + subset.count {
            let corners = [0, 1, 2].map(|corner| {
                let at = 3 * triangle + corner;
                let uvs = Layer::ALL.map(|layer| {
                    let uvs = mesh.uvs[layer as usize].as_ref().filter(|_| subset.uv_layers[layer as usize])?;
                    Some(uvs[at].to_array())
                });
                (Vec3::from(vertices[mesh.corners[at] as usize]), mesh.normals[at], uvs)
            });
            // The importer welds positions, and drops what then has a corner twice.
            let [a, b, c] = corners.map(|corner| corner.0);
            if a == b || b == c || c == a {
                continue;
            }
            faces.push(Face { corners, material: leaf.map(|leaf| leaf.name.clone()) });
        }
    }
    faces
}

/// Positions by name. Names that stand twice are numbered by the importer and left out here.
fn by_name(document: &Document) -> BTreeMap<String, usize> {
    let mut names = BTreeMap::new();
    let mut twice = Vec::new();
    for (index, object) in document.objects().iter().enumerate() {
        let name = object.name.decoded().trim().to_owned();
        if names.insert(name.to_lowercase(), index).is_some() {
            twice.push(name.to_lowercase());
        }
    }
    names.retain(|name, _| !twice.contains(name));
    names
}

/// Largest differences found.
#[derive(Clone, Copy, Debug, Default)]
struct Worst {
    position: f32,
    degrees: f32,
    uv: f32,
    faces: usize,
    objects: usize,
}

/// Compares the objects of two documents that have one name each: parents, faces in order, materials by name.
fn compare(before: &Document, after: &Document, layers: &[Layer]) -> Worst {
    let (old, new) = (by_name(before), by_name(after));
    let mut worst = Worst::default();
    let scale =
        before.objects().iter().flat_map(|object| object.vertices.as_flattened()).fold(1.0, |a: f32, b| a.max(b.abs()));
    let parents = [before, after].map(|document| Hierarchy::of(document.objects()).parents);
    for (name, &index) in &old {
        let Some(&found) = new.get(name) else {
            // The importer has no use for a node that shows nothing and bears nothing.
            let is_parent = parents[0].contains(&Some(index));
            assert!(!is_parent && faces(before, index).is_empty(), "object \"{name}\" is gone: {:?}", new.keys());
            continue;
        };
        worst.objects += 1;
        let parent = |document: &Document, parents: &[Option<usize>], object: usize| {
            parents[object].map(|parent| document.objects()[parent].name.decoded().trim().to_owned())
        };
        let (a, b) = (parent(before, &parents[0], index), parent(after, &parents[1], found));
        let unique = a.as_ref().is_none_or(|name| old.contains_key(&name.to_lowercase()));
        assert!(a == b || !unique, "the parent of \"{name}\": {a:?}, then {b:?}");
        let (a, b) = (faces(before, index), faces(after, found));
        assert_eq!(a.len(), b.len(), "faces of \"{name}\"");
        for (a, b) in a.iter().zip(&b) {
            worst.faces += 1;
            // The light on what cannot be seen may be any.
            let [p, q, r] = a.corners.map(|corner| corner.0);
            let has_area = aam::meaning::face_normal(p, q, r).is_some();
            for (a, b) in a.corners.iter().zip(&b.corners) {
                worst.position = worst.position.max((a.0 - b.0).length() / scale);
                if has_area {
                    worst.degrees = worst.degrees.max(a.1.angle_between(b.1).to_degrees());
                }
                for &layer in layers {
                    if let (Some(a), Some(b)) = (a.2[layer as usize], b.2[layer as usize]) {
                        worst.uv = worst.uv.max((a[0] - b[0]).abs().max((a[1] - b[1]).abs()));
                    }
                }
            }
            if let Some(name) = &a.material {
                let back = b.material.as_deref().unwrap_or("");
                assert!(back == name || back.starts_with(&format!("{name}.")), "material {name}, then {back}");
            }
        }
    }
    worst
}

fn assert_same_form(before: &Document, after: &Document) {
    let worst = compare(before, after, &Layer::ALL);
    println!("{worst:?}");
    assert!(worst.objects > 0 && worst.faces > 0);
    assert!(worst.position < 1e-6 && worst.degrees < 0.05 && worst.uv < 1e-6, "{worst:?}");
}

/// With explicit normals wherever smoothing groups are off by anything that shows.
fn exact() -> ImportOptions {
    ImportOptions { normal_tolerance: 0.01, ..ImportOptions::default() }
}

#[test]
fn a_hierarchy_comes_back() {
    let before = hierarchy();
    let after = there_and_back(&asset(before.clone(), &[]), &exact());
    assert_same_form(&before, &after);
}

fn leaf(document: &Document, name: &str) -> LeafMaterial {
    Materials::of(document).leaves().iter().find(|leaf| leaf.name == name).unwrap().clone()
}

#[test]
fn materials_come_back_within_the_bounds_of_the_mapping() {
    let before = several_materials();
    let after = there_and_back(&asset(before.clone(), &[]), &exact());
    assert_same_form(&before, &after);
    for name in ["glass", "lamp"] {
        let (a, b) = (leaf(&before, name), leaf(&after, name));
        assert!((a.specular - b.specular).abs().max_element() < 0.005, "{a:?} {b:?}");
        assert!((b.exponent / a.exponent - 1.0).abs() < 0.01, "{a:?} {b:?}");
        assert!((a.diffuse - b.diffuse).abs().max_element() < 0.004, "{a:?} {b:?}");
        assert!((a.emission - b.emission).abs().max_element() < 1e-4, "{a:?} {b:?}");
        assert!((a.opacity - b.opacity).abs() < 1e-6, "{a:?} {b:?}");
    }
}

#[test]
fn layers_and_their_transforms_come_back() {
    let material = single("wall", |single| {
        single.specular = [0.0; 3];
        single.shininess = 0.0;
        texture(single, Layer::Diffuse, "bricks.png", |texture| {
            texture.rotation = [0.0, 0.0, 0.4];
            texture.tiling = [3.0, 2.0];
            texture.offset = [0.1, -0.2];
        });
        texture(single, Layer::Normal, "bumps.png", |texture| {
            texture.normal_space = Some(NormalSpace::Tangent);
            texture.intensity = 0.5;
        });
    });
    let before = document(vec![material], vec![block(0, "wall", [0.0; 3], [1.0; 3], 2)]);
    let textures =
        [("bricks.png", png(4, 4, |_, _| [200, 100, 80, 255])), ("bumps.png", png(4, 4, |_, _| [128, 128, 255, 255]))];
    let after = there_and_back(&asset(before.clone(), &textures), &exact());
    assert_same_form(&before, &after);
    let (a, b) = (leaf(&before, "wall"), leaf(&after, "wall"));
    for layer in [Layer::Diffuse, Layer::Normal] {
        let (a, b) = (a.layers[layer as usize].as_ref().unwrap(), b.layers[layer as usize].as_ref().unwrap());
        for uv in [glam::Vec2::ZERO, glam::Vec2::X, glam::Vec2::Y] {
            let apart = a.transform.transform_point2(uv) - b.transform.transform_point2(uv);
            assert!(apart.length() < 1e-5, "{layer:?}: {a:?} {b:?}");
        }
        assert_eq!(a.normal_space == NormalSpace::Tangent, b.normal_space == NormalSpace::Tangent);
        assert!(b.file.ends_with(&a.file), "{} then {}", a.file, b.file);
    }
    assert_eq!(b.layers[Layer::Normal as usize].as_ref().unwrap().intensity, 0.5);
}

#[test]
fn a_character_comes_back() {
    let before = character();
    let options = ImportOptions { frames_per_second: 25.0, ..exact() };
    let after = there_and_back(&asset(before.clone(), &[]), &options);
    assert_eq!(after.geometry.animation, AnimationMode::Keyframe);
    assert_same_form(&before, &after);
    let (old, new) = (by_name(&before), by_name(&after));
    for frame in 0..=10_u8 {
        let worlds = [&before, &after]
            .map(|document| world_transforms(document, &Hierarchy::of(document.objects()), f32::from(frame)));
        for (name, &index) in &old {
            for point in [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z] {
                let a = worlds[0][index].transform_point3(point);
                let b = worlds[1][new[name]].transform_point3(point);
                assert!((a - b).length() < 1e-4, "{name} at {frame}: {a}, then {b}");
            }
        }
    }
    assert_eq!(aam::meaning::frame_range(&after), Some((0.0, 10.0)));
}

#[test]
fn a_multiframe_comes_back() {
    let before = multiframe();
    let options = ImportOptions { frames_per_second: 10.0, ..exact() };
    let after = there_and_back(&asset(before.clone(), &[]), &options);
    assert_eq!(after.geometry.animation, AnimationMode::Full);
    assert_eq!(after.geometry.frames.len(), 4);
    assert_same_form(&before, &after);
    let (old, new) = (by_name(&before), by_name(&after));
    let rules = [&before, &after].map(SmoothingRule::of);
    for frame in 1..4 {
        for (name, &index) in &old {
            let pairs = [(&before, index, rules[0]), (&after, new[name], rules[1])].map(|(document, index, rule)| {
                let (first, later) = (&document.objects()[index], &document.geometry.frames[frame].objects[index]);
                let triangles = first.faces.as_ref().unwrap().triangles.iter();
                let positions: Vec<[Vec3; 3]> =
                    triangles.map(|t| t.vertices.map(|vertex| Vec3::from(later.vertices[vertex as usize]))).collect();
                (positions, frame_normals(first, later, rule))
            });
            for (a, b) in pairs[0].0.as_flattened().iter().zip(pairs[1].0.as_flattened()) {
                assert!((*a - *b).length() < 1e-5, "{name} in frame {frame}: {a}, then {b}");
            }
            for (a, b) in pairs[0].1.as_flattened().iter().zip(pairs[1].1.as_flattened()) {
                assert!(a.angle_between(*b).to_degrees() < 0.05, "{name} in frame {frame}: {a}, then {b}");
            }
        }
    }
}

#[test]
fn every_real_file_comes_back() {
    let Some(sources) = corpus("aam", &["aam"]) else { return };
    let mut all = Worst::default();
    for source in &sources {
        let asset = import(source, &ImportOptions::default(), &Silent).unwrap();
        let after = there_and_back(
            &asset,
            &ImportOptions { hierarchy: aam::meaning::has_local_coordinates(&asset.document), ..exact() },
        );
        let worst = compare(&asset.document, &after, &[]);
        println!("{}: {worst:?}", source.display());
        assert!(worst.position < 1e-6 && worst.degrees < 0.05, "{}: {worst:?}", source.display());
        all.faces += worst.faces;
        all.objects += worst.objects;
        all.position = all.position.max(worst.position);
        all.degrees = all.degrees.max(worst.degrees);
    }
    println!("{} files: {all:?}", sources.len());
}

/// What was mapped from metallic-roughness once stays as it is on every further trip.
#[test]
fn materials_of_real_gltf_files_do_not_drift() {
    let Some(sources) = corpus("gltf", &["gltf", "glb"]) else { return };
    let mut worst = [0.0_f32; 5];
    for source in &sources {
        let first = import(source, &ImportOptions::default(), &Silent).unwrap();
        let second = there_and_back(&first, &ImportOptions::default());
        let (old, new) = (Materials::of(&first.document), Materials::of(&second));
        for a in old.leaves() {
            let b = new.leaves().iter().find(|b| b.name == a.name).expect("a material of that name");
            let apart = |a: Vec3, b: Vec3| (a - b).abs().max_element();
            let exponent = (a.exponent - b.exponent).abs() / a.exponent.max(1.0);
            let here = [
                apart(a.ambient, b.ambient),
                apart(a.diffuse, b.diffuse),
                apart(a.specular, b.specular),
                exponent,
                apart(a.emission, b.emission),
            ];
            println!("{} {}: {here:?}", source.file_name().unwrap().display(), a.name);
            worst.iter_mut().zip(here).for_each(|(worst, here)| *worst = worst.max(here));
            assert_eq!((a.opacity, a.alpha_cutoff), (b.opacity, b.alpha_cutoff), "{}", a.name);
        }
    }
    println!("Am, Di, Sp, n, SI: {worst:?}");
    assert!(
        worst[0] < 0.005 && worst[1] < 0.005 && worst[2] < 0.005 && worst[3] < 0.01 && worst[4] < 1e-3,
        "{worst:?}"
    );
}
