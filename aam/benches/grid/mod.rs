//! The same grid in several forms, for everything that is measured on a large mesh.

#![allow(dead_code, reason = "each benchmark uses some of these")]

use std::fmt::Write as _;

use aam::Document;
use aam::document::{Faces, Frame, Geometry, Group, Object, TexCounts, Triangle};

/// A smooth height field of `side` times `side` vertices with one texture coordinate for each. With `digits` its decimals are those
/// that exporters write, so many behind the point, else any `f32`.
pub(crate) fn grid(side: usize, digits: Option<i32>) -> Document {
    let rounded = |value: f64| match digits {
        Some(digits) => ((value * 10f64.powi(digits)).round() / 10f64.powi(digits)) as f32,
        None => value as f32,
    };
    let at = |i: usize| i as f64 / (side - 1) as f64;
    let mut object = Object { name: "grid".into(), parent: -1, material: -1, ..Object::default() };
    let mut faces = Faces { tex_counts: TexCounts::Uniform(1), ..Faces::default() };
    for y in 0..side {
        for x in 0..side {
            let (u, v) = (at(x), at(y));
            let height = (u * 17.0).sin() * (v * 13.0).cos();
            object.vertices.push([rounded(u * 100.0), rounded(v * 100.0), rounded(height)]);
            faces.tex_coords.push([rounded(u), rounded(v)]);
        }
    }
    for y in 0..side - 1 {
        for x in 0..side - 1 {
            let a = (y * side + x) as u32;
            let (b, c, d) = (a + 1, a + side as u32, a + side as u32 + 1);
            for vertices in [[a, b, d], [a, d, c]] {
                faces.triangles.push(Triangle { vertices, smoothing: 1 });
                faces.tex_indices.push(vertices);
            }
        }
    }
    faces.groups.push(Group { id: 0, triangles: faces.triangles.len() });
    object.faces = Some(faces);
    let frames = vec![Frame { objects: vec![object], ..Frame::default() }];
    Document {
        geometry: Geometry { smoothing_groups: true, animation_frames: 1, frames, ..Geometry::default() },
        ..Document::default()
    }
}

/// Its OBJ, with four digits behind each point.
pub(crate) fn obj(document: &Document) -> String {
    let object = &document.objects()[0];
    let faces = object.faces.as_ref().expect("the grid has faces");
    let mut text = String::from("o grid\n");
    for [x, y, z] in &object.vertices {
        writeln!(text, "v {x:.4} {y:.4} {z:.4}").expect("memory");
    }
    for [u, v] in &faces.tex_coords {
        writeln!(text, "vt {u:.4} {v:.4}").expect("memory");
    }
    text.push_str("s 1\n");
    for triangle in &faces.triangles {
        let [a, b, c] = triangle.vertices.map(|index| index + 1);
        writeln!(text, "f {a}/{a} {b}/{b} {c}/{c}").expect("memory");
    }
    text
}

/// Text without the blanks at the starts of lines, as the OBJ has none.
pub(crate) fn unindented(bytes: &[u8]) -> Vec<u8> {
    bytes.split_inclusive(|&byte| byte == b'\n').flat_map(|line| line.trim_ascii_start()).copied().collect()
}
