//! What the fuzz targets of the importers and of the convex hulls do with their bytes, and what must hold of it.

#![allow(dead_code, reason = "each target uses one of these")]

use std::path::Path;

use aam::{Document, Limits};
use aam_convert::hulls::{HullError, HullOptions, decompose};
use aam_convert::{Asset, ImportOptions, Silent, import_bytes};

/// No folder: nothing that the bytes name is found.
const NOWHERE: &str = "/nonexistent";

/// An importer neither panics nor makes what cannot be written and read again.
fn import(data: &[u8], path: &Path) {
    let limits = Limits { texture_pixels: 1 << 16, ..Limits::default() };
    let options = ImportOptions { limits, ..ImportOptions::default() };
    let Ok(asset) = import_bytes(data.to_vec(), path, &options, &Silent) else { return };
    let Asset { document, .. } = asset;
    let bytes = aam::write(&document, &aam::WriteOptions::default()).expect("what is imported can be written");
    let back = aam::read(&bytes, &aam::ReadOptions::default()).expect("what was written can be read");
    assert!(back.findings.is_empty(), "{:?}", back.findings);
    assert!(back.document == document, "what is written reads back: {:?}", difference(&document, &back.document));
}

/// The first lines that differ.
fn difference(a: &Document, b: &Document) -> Option<(String, String)> {
    let (a, b) = (format!("{a:#?}"), format!("{b:#?}"));
    let differ = a.lines().zip(b.lines()).find(|(a, b)| a != b);
    differ.map(|(a, b)| (a.to_owned(), b.to_owned()))
}

/// Reads the bytes as glTF or GLB, whose data must be embedded.
pub(crate) fn gltf_import(data: &[u8]) {
    import(data, &Path::new(NOWHERE).join("a.gltf"));
}

/// Reads the bytes as STL.
pub(crate) fn stl_import(data: &[u8]) {
    import(data, &Path::new(NOWHERE).join("a.stl"));
}

/// Reads the bytes as PLY.
pub(crate) fn ply_import(data: &[u8]) {
    import(data, &Path::new(NOWHERE).join("a.ply"));
}

/// Puts a picture `t.png` into the folder for [`obj_import`].
pub(crate) fn prepare(folder: &Path) {
    let picture = image::RgbaImage::from_fn(4, 4, |x, y| image::Rgba([60 * x as u8, 60 * y as u8, 128, 60 * x as u8]));
    picture.save(folder.join("t.png")).expect("a picture that can be written");
}

/// Reads the bytes before the first NUL as OBJ and those behind it as its library `m.mtl`.
pub(crate) fn obj_import(folder: &Path, data: &[u8]) {
    let (obj, mtl) = match data.iter().position(|&byte| byte == 0) {
        Some(at) => (&data[..at], &data[at + 1..]),
        None => (data, &[][..]),
    };
    std::fs::write(folder.join("m.mtl"), mtl).expect("a library that can be written");
    import(obj, &folder.join("a.obj"));
}

/// The convex hull of points.
pub(crate) fn hulls(data: &[u8]) {
    pieces_of(data, 1);
}

/// Up to four convex pieces of a mesh, which is slow.
pub(crate) fn pieces(data: &[u8]) {
    pieces_of(data, 4);
}

/// Makes points and triangles of the bytes and cuts them into convex pieces. Of the first byte, bit 0 says that
/// coordinates are 32-bit floats (else single bytes), bit 1 that triangles are a strip (else a list). The second byte
/// limits the vertices of a piece.
fn pieces_of(data: &[u8], max_hulls: usize) {
    let [kind, limit, data @ ..] = data else { return };
    let vertices: Vec<[f32; 3]> = if kind & 1 == 1 {
        let (values, _) = data.as_chunks::<4>();
        values.as_chunks::<3>().0.iter().map(|row| row.map(f32::from_le_bytes)).collect()
    } else {
        data.as_chunks::<3>().0.iter().map(|row| row.map(|value| f32::from(value as i8))).collect()
    };
    let count = vertices.len() as u32;
    let triangles: Vec<[u32; 3]> = if kind & 2 == 2 {
        (2..count).map(|last| [last - 2, last - 1, last]).collect()
    } else {
        (0..count / 3).map(|row| [3 * row, 3 * row + 1, 3 * row + 2]).collect()
    };
    let max_vertices = 4 + usize::from(limit % 252);
    let options = HullOptions { max_hulls, max_error: None, max_vertices, primitives: max_hulls == 1 };
    let pieces = match decompose(&vertices, &triangles, &options) {
        Ok(pieces) => pieces,
        Err(HullError::Option(reason)) => panic!("{reason}"),
        Err(_) => return,
    };
    assert!(!pieces.hulls.is_empty() && pieces.hulls.len() <= options.max_hulls);
    assert!(pieces.quality.hausdorff().is_finite() && pieces.quality.mean().is_finite());
    for hull in &pieces.hulls {
        assert!(hull.vertices.len() <= options.max_vertices);
        assert!(hull.vertices.as_flattened().iter().all(|value| value.is_finite()));
        // A closed surface without handles.
        assert_eq!(hull.triangles.len() + 4, 2 * hull.vertices.len());
        let mut edges: Vec<[u32; 2]> = hull.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        edges.sort_unstable();
        assert!(edges.windows(2).all(|pair| pair[0] != pair[1]), "an edge stands twice");
        assert!(edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok()), "an edge is open");
        assert!(hull.volume.is_finite() && hull.volume >= 0.0);
    }
}
