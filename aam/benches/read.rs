//! Reading and writing against peers in the same run: the same grid as AAM (text and binary) and as OBJ (`tobj`), a bare
//! scan for line ends, and a copy of the bytes. Ratios are what counts; they are printed at the end.

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::{Duration, Instant};

use aam::document::{Encoding, Faces, Frame, Geometry, Group, Object, TexCounts, Triangle};
use aam::{Document, ReadOptions, WriteOptions, read, write};

/// Vertices along each side of the grid: 1 M vertices, 2 M triangles.
const SIDE: usize = 1000;
const RUNS: usize = 5;

/// A height field with one texture coordinate for each vertex; decimals as exporters write them.
fn grid() -> Document {
    let rounded = |value: f64, digits: f64| ((value * digits).round() / digits) as f32;
    let at = |i: usize| i as f64 / (SIDE - 1) as f64;
    let mut object = Object { name: "grid".into(), parent: -1, material: -1, ..Object::default() };
    let mut faces = Faces { tex_counts: TexCounts::Uniform(1), ..Faces::default() };
    for y in 0..SIDE {
        for x in 0..SIDE {
            let (u, v) = (at(x), at(y));
            let height = (u * 17.0).sin() * (v * 13.0).cos();
            object.vertices.push([rounded(u * 100.0, 1e4), rounded(v * 100.0, 1e4), rounded(height, 1e4)]);
            faces.tex_coords.push([rounded(u, 1e4), rounded(v, 1e4)]);
        }
    }
    for y in 0..SIDE - 1 {
        for x in 0..SIDE - 1 {
            let a = (y * SIDE + x) as u32;
            let (b, c, d) = (a + 1, a + SIDE as u32, a + SIDE as u32 + 1);
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

/// The same as an OBJ.
fn obj(document: &Document) -> String {
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
fn unindented(bytes: &[u8]) -> Vec<u8> {
    bytes.split_inclusive(|&byte| byte == b'\n').flat_map(|line| line.trim_ascii_start()).copied().collect()
}

/// The median of several runs after one to warm up.
fn median(mut run: impl FnMut()) -> Duration {
    run();
    let mut times: Vec<Duration> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed()
        })
        .collect();
    times.sort();
    times[RUNS / 2]
}

fn main() {
    let document = grid();
    let options = WriteOptions { digits: Some(4), ..WriteOptions::default() };
    let text = unindented(&write(&document, &options).expect("writable"));
    let binary_options = WriteOptions { encoding: Some(Encoding::Binary), ..WriteOptions::default() };
    let binary = write(&document, &binary_options).expect("writable");
    let obj = obj(&document);
    let read_options = ReadOptions::default();

    let read_text = median(|| drop(black_box(read(black_box(&text), &read_options).expect("readable"))));
    let read_binary = median(|| drop(black_box(read(black_box(&binary), &read_options).expect("readable"))));
    let write_text =
        median(|| drop(black_box(write(black_box(&document), &WriteOptions::default()).expect("writable"))));
    let write_binary = median(|| drop(black_box(write(black_box(&document), &binary_options).expect("writable"))));
    let shortest = write(&document, &WriteOptions::default()).expect("writable").len();
    let scan = median(|| {
        black_box(memchr::memchr_iter(b'\n', black_box(&text)).count());
    });
    let copy = median(|| drop(black_box(black_box(&binary).to_vec())));
    let read_obj = median(|| {
        let loaded = tobj::load_obj_buf(
            &mut black_box(obj.as_bytes()),
            &tobj::LoadOptions { triangulate: true, single_index: false, ..tobj::LoadOptions::default() },
            |_| Ok((Vec::new(), Default::default())),
        );
        drop(black_box(loaded.expect("readable")));
    });

    let row = |name: &str, time: Duration, bytes: usize| {
        let seconds = time.as_secs_f64();
        println!("{name:<28} {:>8.1} ms {:>8.0} MB/s", seconds * 1e3, bytes as f64 / 1e6 / seconds);
    };
    println!("{} vertices, {} triangles, median of {RUNS}", SIDE * SIDE, 2 * (SIDE - 1) * (SIDE - 1));
    row("read AAM text", read_text, text.len());
    row("read AAM binary", read_binary, binary.len());
    row("write AAM text", write_text, shortest);
    row("write AAM binary", write_binary, binary.len());
    row("read OBJ (tobj)", read_obj, obj.len());
    row("line scan (memchr)", scan, text.len());
    row("copy of the binary", copy, binary.len());
    let ratio = |a: Duration, b: Duration| a.as_secs_f64() / b.as_secs_f64();
    println!("tobj / read text:        {:.1}", ratio(read_obj, read_text));
    println!("read text / line scan:   {:.1}", ratio(read_text, scan));
    println!("copy / read binary:      {:.2}", ratio(copy, read_binary));
    println!("read text / write text:  {:.2}", ratio(read_text, write_text));
}
