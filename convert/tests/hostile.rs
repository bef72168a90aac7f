//! OBJ, MTL, STL and PLY from an enemy: neither panics, nor long times, nor much memory.

use std::path::Path;

use aam_convert::{ImportOptions, Silent, import};
use proptest::prelude::*;

const OBJ: &str = "mtllib m.mtl\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 .2 1e-3\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n\
    vn 0 1 0\no a\ng b c\ns 1\nusemtl m\nf 1/1/1 2/2/1 3/3/1 5/1/2 4/1/1\ns 2\nf -1 -2 \\\n -3\nl 1 2\np 1\no d\nusemtl n\n\
    s off\nf 1//1 2//1 3//2\nf 3/1 2/2 1/3\n";
const MTL: &str = "newmtl m\nKa 1 1 1\nKd .5 .5 .5\nKs 1 1 1\nNs 20\nd .5\nillum 2\nmap_Kd -s 2 2 2 -o .1 .2 c.png\n\
    map_d a.png\nbump -bm 2 h.png\nnewmtl n\nPr .3\nPm 1\nmap_Pr h.png\ndisp -mm 0 1 h.png\nnorm c.png\n";
const PLY: &str = "ply\nformat ascii 1.0\ncomment TextureFile c.png\nelement vertex 4\nproperty float x\nproperty float y\n\
    property double z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\n\
    property uchar blue\nproperty float s\nproperty float t\nelement face 2\nproperty list uchar int vertex_indices\n\
    property list uchar float texcoord\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n\
    0 0 0 0 0 1 255 0 0 0 0\n1 0 0 0 0 1 0 255 0 1 0\n1 1 0 0 0 1 0 0 255 1 1\n0 1 0.5 0 0 1 9 9 9 0 1\n\
    4 0 1 2 3 8 0 0 1 0 1 1 0 1\n3 0 1 2 6 0 0 1 0 1 1\n6 0 1 2 -1 2 3\n";

fn stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(4_u32.to_le_bytes());
    for facet in 0..4_u8 {
        for value in 0..12_u8 {
            bytes.extend(f32::from((facet * 7 + value * 5) % 11).to_le_bytes());
        }
        bytes.extend([0, 0]);
    }
    bytes
}

/// PLY with a binary body of the same vertices.
fn binary_ply() -> Vec<u8> {
    let mut bytes = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        .to_vec();
    bytes.extend([0.0_f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|value| value.to_le_bytes()));
    bytes.push(3);
    bytes.extend([0_i32, 1, 2].iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["c.png", "a.png", "h.png"] {
        image::RgbaImage::from_fn(4, 4, |x, y| image::Rgba([60 * x as u8, 60 * y as u8, 128, 60 * x as u8]))
            .save(folder.path().join(name))
            .unwrap();
    }
    folder
}

/// Whatever comes of it; only that something does.
fn read(folder: &Path, name: &str, bytes: &[u8]) {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    if let Ok(asset) = import(&path, &ImportOptions::default(), &Silent) {
        // What was read can be written.
        aam::write(&asset.document, &aam::WriteOptions::default()).unwrap();
    }
}

/// Damage: where, how much is taken out, and what is put in its place.
fn damage() -> impl Strategy<Value = Vec<(prop::sample::Index, usize, Vec<u8>)>> {
    let token = prop_oneof![
        prop::collection::vec(any::<u8>(), 0..4),
        prop::sample::select(vec![
            "-1",
            "0",
            "99999999999",
            "1e38",
            "nan",
            "-inf",
            "\n",
            "\\\n",
            "\r",
            "/",
            "//",
            "#",
            "\"",
            " ",
            "4294967295",
            "-",
        ])
        .prop_map(|word| word.as_bytes().to_vec()),
    ];
    prop::collection::vec((any::<prop::sample::Index>(), 0_usize..6, token), 1..6)
}

fn damaged(bytes: &[u8], damage: &[(prop::sample::Index, usize, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for (at, length, put) in damage {
        let at = at.index(bytes.len() + 1);
        let end = (at + length).min(bytes.len());
        bytes.splice(at..end, put.iter().copied());
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_do_not_panic(damage in damage()) {
        let folder = folder();
        std::fs::write(folder.path().join("m.mtl"), MTL).unwrap();
        read(folder.path(), "a.obj", &damaged(OBJ.as_bytes(), &damage));
        read(folder.path(), "a.stl", &damaged(&stl(), &damage));
        read(folder.path(), "a.ply", &damaged(PLY.as_bytes(), &damage));
        read(folder.path(), "b.ply", &damaged(&binary_ply(), &damage));
        std::fs::write(folder.path().join("m.mtl"), damaged(MTL.as_bytes(), &damage)).unwrap();
        read(folder.path(), "a.obj", OBJ.as_bytes());
    }

    #[test]
    fn noise_does_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let folder = folder();
        for name in ["a.obj", "a.stl", "a.ply"] {
            read(folder.path(), name, &bytes);
        }
        read(folder.path(), "b.stl", &[b"solid a\nfacet ".as_slice(), &bytes].concat());
        read(folder.path(), "b.ply", &[b"ply\nformat ascii 1.0\n".as_slice(), &bytes].concat());
    }
}

/// What is quadratic in any of these would seem to hang.
#[test]
fn many_of_everything_takes_linear_time() {
    let folder = folder();
    const MANY: usize = 150_000;
    let many = |line: &dyn Fn(usize) -> String| (0..MANY).map(line).collect::<String>();
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    for (what, text) in [
        ("materials", many(&|at| format!("usemtl m{at}\nf 1 2 3\n"))),
        ("objects", many(&|at| format!("o o{at}\nf 1 2 3\n"))),
        ("groups", many(&|at| format!("g o{at}\nvt 0 0\nf 1/1 2/1 3/1\n"))),
        ("smoothing groups", many(&|at| format!("s {at}\nf {} 2 3\n", 1 + 3 * (at % 2)))),
        ("statements", many(&|at| format!("x{at} 1 2 3\n")) + "f 1 2 3\n"),
        ("libraries", many(&|at| format!("mtllib l{}.mtl\n", at % 2000)) + "f 1 2 3\n"),
        ("corners", format!("f{}\n", many(&|at| format!(" {}", 1 + at % 4)))),
        (
            "faces around a vertex",
            many(&|at| format!("v {} {at} 0\nvn 0 {} 1\nf 1//-1 2//-1 -1//-1\n", at % 7, at % 11)),
        ),
        ("continued lines", format!("f{}\n", many(&|at| format!(" {}\\\n", 1 + at % 3)))),
    ] {
        println!("{what}");
        read(folder.path(), "a.obj", format!("{vertices}{text}").as_bytes());
    }
    let properties: String = (0..40_000).map(|at| format!("property uchar p{at}\n")).collect();
    read(
        folder.path(),
        "a.ply",
        format!("ply\nformat ascii 1.0\nelement vertex 1\n{properties}end_header\n").as_bytes(),
    );
}

/// A line of an AAM file has no blanks at its ends, so a name loses them.
#[test]
fn names_with_blanks_at_their_ends_can_be_written() {
    let folder = folder();
    std::fs::write(folder.path().join("m.mtl"), "newmtl m\nmap_Kd / c.png\nbump x/ .png\n").unwrap();
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
    let uri = r#"{"asset":{"version":"2.0"},"images":[{"uri":"%20c.png"},{"uri":"missing.png%20"},{"uri":"%20"}],
        "textures":[{"source":0},{"source":1},{"source":2}],"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}},
        {"normalTexture":{"index":1}},{"pbrMetallicRoughness":{"baseColorTexture":{"index":2}}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0},{"attributes":{"POSITION":0},"material":1},
        {"attributes":{"POSITION":0},"material":2}]}],"nodes":[{"mesh":0}],
        "accessors":[{"componentType":5126,"type":"VEC3","count":3}]}"#;
    let ply = PLY.replace("TextureFile c.png", "TextureFile x/ c.png");
    std::fs::write(folder.path().join(" c.png"), std::fs::read(folder.path().join("c.png")).unwrap()).unwrap();
    for (name, text) in [("a.obj", obj), ("a.gltf", uri), ("a.ply", &ply)] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let asset = import(&path, &ImportOptions::default(), &Silent).unwrap_or_else(|error| panic!("{error}"));
        aam::write(&asset.document, &aam::WriteOptions::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}
