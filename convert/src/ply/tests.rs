use aam::meaning::{SmoothingRule, object_normals};
use glam::Vec3;

use crate::{Asset, ImportOptions, Silent, import};

fn read(bytes: &[u8]) -> Result<Asset, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.ply");
    std::fs::write(&path, bytes).unwrap();
    image::RgbImage::new(1, 1).save(folder.path().join("t.png")).unwrap();
    import(&path, &ImportOptions::default(), &Silent)
        .map_err(|error| error.to_string().lines().next().unwrap().replace(&path.display().to_string(), "m.ply"))
}

const HEADER: &str = "element vertex 5\nproperty float x\nproperty double y\nproperty short z\nproperty uchar red\n\
    property uchar green\nproperty uchar blue\nproperty uchar alpha\nelement face 2\n\
    property list uchar int vertex_indices\nelement edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n";
const VERTICES: [[i32; 7]; 5] = [
    [0, 0, 0, 255, 0, 0, 9],
    [4, 0, 0, 0, 255, 0, 9],
    [4, 4, 0, 0, 0, 255, 9],
    [0, 4, 0, 255, 255, 255, 9],
    [2, 2, 3, 0, 0, 0, 9],
];
const FACES: [&[u32]; 2] = [&[3, 2, 1, 0], &[0, 1, 4]];

fn file(format: &str) -> Vec<u8> {
    let mut bytes = format!("ply\nformat {format} 1.0\ncomment made by hand\n{HEADER}").into_bytes();
    let mut push = |kind: char, value: i64| match (format, kind) {
        ("ascii", _) => bytes.extend(format!("{value} ").bytes()),
        ("binary_little_endian", 'f') => bytes.extend((value as f32).to_le_bytes()),
        ("binary_little_endian", 'd') => bytes.extend((value as f64).to_le_bytes()),
        ("binary_little_endian", 's') => bytes.extend((value as i16).to_le_bytes()),
        ("binary_little_endian", 'i') => bytes.extend((value as i32).to_le_bytes()),
        (_, 'f') => bytes.extend((value as f32).to_be_bytes()),
        (_, 'd') => bytes.extend((value as f64).to_be_bytes()),
        (_, 's') => bytes.extend((value as i16).to_be_bytes()),
        (_, 'i') => bytes.extend((value as i32).to_be_bytes()),
        _ => bytes.push(value as u8),
    };
    for vertex in VERTICES {
        for (value, kind) in vertex.into_iter().zip("fdscccc".chars()) {
            push(kind, value.into());
        }
    }
    for face in FACES {
        push('c', face.len() as i64);
        face.iter().for_each(|index| push('i', (*index).into()));
    }
    push('i', 0);
    push('i', 1);
    bytes
}

#[test]
fn text_and_both_byte_orders_say_the_same() {
    let assets = ["ascii", "binary_little_endian", "binary_big_endian"].map(|format| read(&file(format)).unwrap());
    assert_eq!(assets[0].document, assets[1].document);
    assert_eq!(assets[0].document, assets[2].document);
    let object = &assets[0].document.objects()[0];
    assert_eq!(object.faces.as_ref().unwrap().triangles.len(), 3);
    // In order of first use.
    assert_eq!(object.vertices[..2], [[0., 4., 0.], [4., 4., 0.]]);
    assert_eq!(object.colors.as_ref().unwrap()[..2], [[1., 1., 1.], [0., 0., 1.]]);
    let lost = assets[0].report.changes.iter().find(|change| change.property == "elements and properties").unwrap();
    assert_eq!(lost.note, "not used: alpha, 1 × edge");
}

#[test]
fn normals_texture_and_strips() {
    let text = "ply\nformat ascii 1.0\ncomment TextureFile t.png\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n\
        element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
        0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n0 1 0 0 0 1 0 1\n1 1 0 0 0 1 1 1\n8 0 1 2 3 -1 3 2 0\n";
    let asset = read(text.as_bytes()).unwrap();
    let object = &asset.document.objects()[0];
    let faces = object.faces.as_ref().unwrap();
    let triangles: Vec<[u32; 3]> = faces.triangles.iter().map(|triangle| triangle.vertices).collect();
    assert_eq!(triangles, [[0, 1, 2], [2, 1, 3], [3, 2, 0]]);
    assert!(object_normals(object, SmoothingRule::Masks)[..2].iter().flatten().all(|normal| *normal == Vec3::Z));
    assert_eq!(faces.tex_coords, [[0., 0.], [1., 0.], [0., 1.], [1., 1.]]);
    assert_eq!(faces.tex_indices.len(), 3);
    assert_eq!(asset.textures.keys().collect::<Vec<_>>(), ["t.png"]);
}

#[test]
fn texture_coordinates_of_corners() {
    let text = "ply\nformat ascii 1.0\ncomment TextureFile t.png\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar int vertex_index\nproperty list uchar float texcoord\n\
        end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 0.5 1\n";
    let asset = read(text.as_bytes()).unwrap();
    let faces = asset.document.objects()[0].faces.as_ref().unwrap();
    assert_eq!(
        (&faces.tex_coords[..], &faces.tex_indices[..]),
        (&[[0., 0.], [1., 0.], [0.5, 1.]][..], &[[0, 1, 2]][..])
    );
}

#[test]
fn broken_files() {
    let ascii = String::from_utf8(file("ascii")).unwrap();
    let binary = file("binary_little_endian");
    for (bytes, message) in [
        (b"plx\n".to_vec(), "m.ply: 1:1: expected `ply` on the first line"),
        (b"ply\nformat ascii 1.0\n".to_vec(), "3:1: the header does not end (`end_header`)"),
        (ascii.replace("double", "real").into_bytes(), "6:10: expected a type, found `real`"),
        (ascii.replace("ascii", "ebcdic").into_bytes(), "2:8: expected `ascii`, `binary_little_endian`"),
        (ascii.replace("vertex 5", "vertex 4000000000").into_bytes(), "4:1: 4000000000 × vertex cannot be in the"),
        (ascii.replace("property short z\n", "").into_bytes(), "4:1: the vertices have no x, y and z"),
        (ascii.replace("4 3 2 1 0", "4 3 2 7 0").into_bytes(), "a face names vertex 7, but there are 5"),
        (ascii.replace("4 3 2 1 0", "4 3 2 -1 0").into_bytes(), "a face names vertex -1"),
        (ascii.replace("4 3 2 1 0", "999 3 2 1 0").into_bytes(), "has 999 entries, but there are bytes for"),
        (ascii.replace("0 4 0 255", "0 x 0 255").into_bytes(), "expected a number, found `x`"),
        (ascii.replace("0 4 0 255", "0 nan 0 255").into_bytes(), "a coordinate that is no finite number"),
        (binary[..binary.len() - 9].to_vec(), "the file ends in the middle of its data"),
        (ascii.replace("face 2", "face 0").replace("edge 1", "edge 0").into_bytes(), "a model without faces"),
        (ascii.replace("vertex_indices", "points").into_bytes(), "the faces have no list `vertex_indices`"),
    ] {
        let error = read(&bytes).unwrap_err();
        assert!(error.contains(message), "{error} does not say: {message}");
    }
    // An element without properties takes no room, and no time.
    let endless = ascii
        .replace("element edge 1\nproperty int vertex1\nproperty int vertex2\n", "element void 18446744073709551615\n");
    assert!(read(endless.as_bytes()).is_ok());
}
