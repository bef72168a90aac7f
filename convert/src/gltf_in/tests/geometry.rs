//! Primitive modes, welding, normals, groups, colours, texture coordinates.

use aam::document::{Group, TexCounts, Triangle};

use super::*;

/// A square of four corners in the plane z = 0, counter-clockwise seen from +z.
const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

fn with_mode(mode: u32, positions: &[[f32; 3]], indices: Option<&[u16]>) -> Asset {
    let mut file = Builder::new();
    let position = file.vec3(positions);
    let mut primitive = json!({ "attributes": { "POSITION": position }, "mode": mode });
    if let Some(indices) = indices {
        primitive["indices"] = json!(file.indices(indices));
    }
    file.push("meshes", json!({ "primitives": [primitive] }));
    file.push("nodes", json!({ "mesh": 0 }));
    file.import()
}

/// Each triangle's doubled signed area seen from glTF's +z, and all of them together.
fn areas(asset: &Asset) -> Vec<f32> {
    let triangles = corners(object(asset, "node 0"));
    // AAM's (x, z) is glTF's (x, y).
    let area = |[a, b, c]: [[f32; 3]; 3]| (b[0] - a[0]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[0] - a[0]);
    triangles.into_iter().map(area).collect()
}

#[test]
fn strips_and_fans_wind_as_the_specification_says() {
    let zigzag = [SQUARE[0], SQUARE[1], SQUARE[3], SQUARE[2]];
    assert_eq!(areas(&with_mode(5, &zigzag, None)), [1.0, 1.0]);
    assert_eq!(areas(&with_mode(6, &SQUARE, None)), [1.0, 1.0]);
    assert_eq!(areas(&with_mode(4, &SQUARE, Some(&[0, 1, 2, 0, 2, 3]))), [1.0, 1.0]);
    assert_eq!(areas(&with_mode(5, &SQUARE, Some(&[0, 1, 3, 2]))), [1.0, 1.0]);
}

#[test]
fn sewn_strips_lose_their_seams() {
    let asset = with_mode(5, &SQUARE, Some(&[0, 1, 3, 3, 3, 1, 2]));
    assert_eq!(areas(&asset).len(), 2);
    assert!(areas(&asset).iter().all(|area| area.abs() == 1.0));
}

#[test]
fn points_and_lines_are_reported() {
    for mode in [0, 1, 2, 3] {
        let asset = with_mode(mode, &SQUARE, None);
        assert!(asset.document.objects().iter().all(|object| object.vertices.is_empty()));
        assert!(reported(&asset, Outcome::Lost, if mode == 0 { "points" } else { "lines" }));
    }
}

#[test]
fn left_over_indices_are_dropped_and_reported() {
    let asset = with_mode(4, &SQUARE, Some(&[0, 1, 2, 3]));
    assert_eq!(areas(&asset), [1.0]);
    assert!(reported(&asset, Outcome::Changed, "triangles"));
}

#[test]
fn without_normals_faces_are_flat() {
    let asset = with_mode(4, &SQUARE, Some(&[0, 1, 2, 0, 2, 3]));
    let faces = object(&asset, "node 0").faces.as_ref().expect("faces");
    assert!(asset.document.geometry.smoothing_groups);
    assert_eq!(faces.triangles[0], Triangle { vertices: [0, 1, 2], smoothing: 0 });
    assert_eq!(faces.triangles[1], Triangle { vertices: [0, 2, 3], smoothing: 0 });
    assert!(faces.normals.is_none());
}

/// Two triangles folded along an edge, each with vertices of its own, with these normals.
fn folded(normals: [[f32; 3]; 6]) -> Asset {
    let mut file = Builder::new();
    let (a, b, c, d) = ([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let position = file.vec3(&[a, b, c, a, d, b]);
    let normal = file.vec3(&normals);
    let attributes = json!({ "POSITION": position, "NORMAL": normal });
    file.push("meshes", json!({ "primitives": [{ "attributes": attributes }] }));
    file.push("nodes", json!({ "mesh": 0 }));
    file.import()
}

#[test]
fn split_vertices_are_welded_and_smooth_normals_become_a_group() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    // The faces look along +y and +x; along the shared edge a-b the authored normal is their mean.
    let (up, side, mean) = ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [half, half, 0.0]);
    let asset = folded([mean, mean, up, mean, side, mean]);
    let smooth = object(&asset, "node 0");
    assert_eq!(smooth.vertices.len(), 4);
    let faces = smooth.faces.as_ref().expect("faces");
    assert!(faces.normals.is_none(), "{}", notes(&asset, "normals"));
    assert_ne!(faces.triangles[0].smoothing & faces.triangles[1].smoothing, 0);
    assert!(reported(&asset, Outcome::Kept, "normals"));

    let asset = folded([up, up, up, side, side, side]);
    let faces = object(&asset, "node 0").faces.as_ref().expect("faces");
    assert!(faces.normals.is_none());
    assert_eq!(faces.triangles[0].smoothing & faces.triangles[1].smoothing, 0);
}

#[test]
fn normals_that_no_group_gives_are_written() {
    let third = 1.0 / 3.0_f32.sqrt();
    let odd = [third; 3];
    let asset = folded([odd; 6]);
    let faces = object(&asset, "node 0").faces.as_ref().expect("faces");
    let normals = faces.normals.as_ref().expect("explicit normals");
    assert_eq!(faces.normal_indices.len(), 2);
    for corner in faces.normal_indices.as_flattened() {
        assert_near(normals[*corner as usize], [third, -third, third], 1e-6);
    }
    let line = notes(&asset, "normals");
    assert!(line.contains("6 of 6") && line.contains("bytes"), "{line}");
}

/// Two squares of two materials that share an edge, as two primitives of one mesh.
fn two_materials() -> Builder {
    let mut file = Builder::new();
    let left = file.vec3(&SQUARE);
    let right = file.vec3(&SQUARE.map(|[x, y, z]| [x + 1.0, y, z]));
    let indices = file.indices(&[0, 1, 2, 0, 2, 3]);
    file.push("materials", json!({ "name": "red" }));
    file.push("materials", json!({ "name": "blue" }));
    file.push("materials", json!({ "name": "spare" }));
    let primitive = |position: usize, material: usize| json!({ "attributes": { "POSITION": position }, "indices": indices, "material": material });
    let primitives = json!([primitive(left, 1), primitive(right, 0), primitive(left, 1)]);
    file.push("meshes", json!({ "name": "pair", "primitives": primitives }));
    file.push("nodes", json!({ "mesh": 0, "name": "both" }));
    file
}

#[test]
fn primitives_become_groups_of_a_multi_material() {
    let asset = two_materials().import();
    let both = object(&asset, "both");
    assert_eq!(both.vertices.len(), 6, "the shared edge is welded across primitives");
    let faces = both.faces.as_ref().expect("faces");
    assert_eq!(faces.groups, [Group { id: 0, triangles: 4 }, Group { id: 1, triangles: 2 }]);
    let names: Vec<String> = asset.document.materials.iter().map(|material| material.name.decoded()).collect();
    assert_eq!(names, ["spare", "pair"], "materials that stand in a Multi alone are listed there");
    assert_eq!(both.material, 1);
    match &asset.document.materials[1].body {
        MaterialBody::Multi(subs) => {
            assert_eq!(
                subs.iter().map(|sub| (sub.number, sub.name.decoded())).collect::<Vec<_>>(),
                [(0, "blue".to_owned()), (1, "red".to_owned())]
            );
        }
        MaterialBody::Single(_) => panic!("expected Multi"),
    }
}

#[test]
fn vertices_that_nothing_uses_are_left_out() {
    let mut file = Builder::new();
    let position = file.vec3(&[[9.0; 3], SQUARE[0], SQUARE[1], [8.0; 3], SQUARE[2]]);
    let indices = file.indices(&[1, 2, 4]);
    file.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": position }, "indices": indices }] }));
    file.push("nodes", json!({ "mesh": 0 }));
    assert_eq!(object(&file.import(), "node 0").vertices.len(), 3);
}

#[test]
fn vertex_colours_are_encoded_and_their_alpha_is_reported() {
    let mut file = Builder::triangle();
    let colors = file.vec4(&[[0.5, 0.0, 2.0, 1.0], [1.0, 1.0, 1.0, 0.25], [0.0, 0.0, 0.0, 1.0]]);
    file.set("/meshes/0/primitives/0/attributes/COLOR_0", json!(colors));
    let asset = file.import();
    let colors = object(&asset, "node 0").colors.as_ref().expect("colours");
    // sRGB encoding of one half is 0.735357.
    assert_near(colors[0], [0.735_357, 0.0, 1.0], 1e-5);
    assert_near(colors[1], [1.0; 3], 1e-6);
    assert!(notes(&asset, "vertex colour alpha").contains("0.250"));
    assert!(reported(&asset, Outcome::Changed, "vertex colours"));
}

#[test]
fn white_vertex_colours_say_nothing() {
    let mut file = Builder::triangle();
    let colors = file.vec3(&[[1.0; 3]; 3]);
    file.set("/meshes/0/primitives/0/attributes/COLOR_0", json!(colors));
    assert!(object(&file.import(), "node 0").colors.is_none());
}

#[test]
fn colours_part_vertices_that_stand_in_one_place() {
    let mut file = Builder::new();
    let position = file.vec3(&[SQUARE[0], SQUARE[1], SQUARE[2], SQUARE[0], SQUARE[2], SQUARE[3]]);
    let (red, blue) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let color = file.vec3(&[red, red, red, blue, blue, blue]);
    let attributes = json!({ "POSITION": position, "COLOR_0": color });
    file.push("meshes", json!({ "primitives": [{ "attributes": attributes }] }));
    file.push("nodes", json!({ "mesh": 0 }));
    let asset = file.import();
    let square = object(&asset, "node 0");
    assert_eq!(square.vertices.len(), 6);
    assert_eq!(square.colors.as_ref().map(Vec::len), Some(6));
}

/// A triangle with two sets of coordinates; the base colour uses the second, the normal map the first.
fn two_sets() -> Builder {
    let mut file = Builder::triangle();
    let first = file.vec2(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    let second = file.vec2(&[[0.5, 0.5], [0.75, 0.5], [0.5, 0.75]]);
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(first));
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_1", json!(second));
    let color = file.texture(&png(2, 2, |_, _| [255; 4]), "color");
    let normal = file.texture(&png(2, 2, |_, _| [128, 128, 255, 255]), "normal");
    file.push(
        "materials",
        json!({
            "pbrMetallicRoughness": { "baseColorTexture": { "index": color, "texCoord": 1 } },
            "normalTexture": { "index": normal, "scale": 0.5 },
        }),
    );
    file.set("/meshes/0/primitives/0/material", json!(0));
    file
}

#[test]
fn each_layer_has_its_own_coordinates() {
    let asset = two_sets().import();
    let faces = object(&asset, "node 0").faces.as_ref().expect("faces");
    assert_eq!(faces.tex_counts, TexCounts::Uniform(2));
    let coords = |line: usize| faces.tex_indices[line].map(|at| faces.tex_coords[at as usize]);
    assert_eq!(coords(0), [[0.5, 0.5], [0.75, 0.5], [0.5, 0.25]]);
    assert_eq!(coords(1), [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
}

#[test]
fn a_missing_set_is_one_texel() {
    let mut file = two_sets();
    let attributes = file.json.pointer_mut("/meshes/0/primitives/0/attributes").expect("attributes");
    attributes.as_object_mut().expect("an object").remove("TEXCOORD_1");
    let asset = file.import();
    let faces = object(&asset, "node 0").faces.as_ref().expect("faces");
    assert_eq!(faces.tex_counts, TexCounts::Uniform(2), "the lines still match the layers");
    let coords = |line: usize| faces.tex_indices[line].map(|at| faces.tex_coords[at as usize]);
    assert_eq!(coords(0), [[0.0, 1.0]; 3]);
    assert!(notes(&asset, "texture coordinates").contains("TEXCOORD_1"));
}

#[test]
fn unusable_numbers_become_zero_where_they_do_no_harm() {
    let mut file = two_sets();
    let normal = file.vec3(&[[f32::NAN; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]);
    file.set("/meshes/0/primitives/0/attributes/NORMAL", json!(normal));
    let broken = file.vec2(&[[0.5, f32::INFINITY], [0.75, 0.5], [0.5, 0.75]]);
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_1", json!(broken));
    let asset = file.import();
    assert!(reported(&asset, Outcome::Changed, "normals") && reported(&asset, Outcome::Changed, "texture coordinates"));
}

#[test]
fn coordinates_are_kept_for_a_later_layer_on_request() {
    let mut file = Builder::triangle();
    let uvs = file.vec2(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(uvs));
    let count = |keep_uvs: bool| {
        let asset = file.import_with(&ImportOptions { keep_uvs, ..ImportOptions::default() });
        object(&asset, "node 0").faces.as_ref().expect("faces").tex_counts.clone()
    };
    assert_eq!(count(false), TexCounts::Uniform(0));
    assert_eq!(count(true), TexCounts::Uniform(1));
}
