//! STL, binary and text. Facets are flat, so smoothing is 0; vertices of equal position become one.

use std::path::Path;

use aam::read_bytes;
use aam_scene::Up;
use glam::Vec3;

use crate::mesh::{Part, PartTriangle, document, to_z_up};
use crate::source::{Source, Words};
use crate::{Asset, ConvertError, ImportOptions, Report};

/// A binary file: 80 bytes of anything, the number of facets, and 50 bytes for each.
const HEADER: usize = 84;
const FACET: usize = 50;

/// Reads an STL file. Axes: +Z up unless told otherwise, as CAD programs write it.
pub(crate) fn import(path: &Path, options: &ImportOptions) -> Result<Asset, ConvertError> {
    let bytes = read_bytes(path, &options.limits)?;
    let source = Source { path, bytes: &bytes };
    let mut asset = Asset::default();
    let stem = path.file_stem().map_or_else(|| "object".into(), |stem| stem.to_string_lossy().into_owned());
    let mut solids = if is_binary(&bytes) { binary(source, stem, &mut asset.report)? } else { text(source, stem)? };
    solids.retain(|solid| !solid.facets.is_empty());
    if solids.is_empty() {
        return Err(source.no_faces());
    }
    let against = solids.iter().flat_map(|solid| &solid.facets).filter(|facet| facet.is_against()).count();
    if against > 0 {
        let note = format!("{against} facets have a normal against the order of their corners; the order counts");
        asset.report.changed("", "facet normals", note, None);
    }
    let up = options.up.unwrap_or(Up::Z);
    let parts = solids.into_iter().map(|solid| solid.part(up)).collect();
    asset.document = document(parts, &[], options.normal_tolerance, options.keep_uvs, &mut asset.report);
    Ok(asset)
}

/// The size decides where it fits exactly, since binary headers may begin with `solid` too; else the words do.
fn is_binary(bytes: &[u8]) -> bool {
    let Some(count) = binary_count(bytes) else { return false };
    if bytes.len() as u64 == HEADER as u64 + count * FACET as u64 {
        return true;
    }
    let mut words = Words::new(bytes, 0);
    let solid = words.next().is_some_and(|(_, word)| word.eq_ignore_ascii_case(b"solid"));
    words.line();
    let facet = words.next().is_some_and(|(_, word)| {
        word.eq_ignore_ascii_case(b"facet")
            || word.eq_ignore_ascii_case(b"endsolid")
            || word.eq_ignore_ascii_case(b"solid")
    });
    !(solid && facet)
}

fn binary_count(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    Some(u64::from(u32::from_le_bytes([count[0], count[1], count[2], count[3]])))
}

struct Facet {
    normal: [f32; 3],
    corners: [[f32; 3]; 3],
}

impl Facet {
    fn is_against(&self) -> bool {
        let [a, b, c] = self.corners.map(Vec3::from);
        (b - a).cross(c - a).dot(Vec3::from(self.normal)) < 0.0
    }
}

struct Solid {
    name: String,
    facets: Vec<Facet>,
}

impl Solid {
    fn part(self, up: Up) -> Part {
        let corners = self.facets.iter().flat_map(|facet| facet.corners);
        let triangles = (0..self.facets.len() as u32).map(|facet| PartTriangle {
            vertices: [3 * facet, 3 * facet + 1, 3 * facet + 2],
            tex_coords: None,
            material: None,
            smoothing: 0,
        });
        let mut part = Part {
            name: self.name,
            vertices: corners.map(|corner| to_z_up(up, corner)).collect(),
            triangles: triangles.collect(),
            ..Part::default()
        };
        part.weld();
        part
    }
}

fn binary(source: Source, name: String, report: &mut Report) -> Result<Vec<Solid>, ConvertError> {
    let bytes = source.bytes;
    let count = binary_count(bytes).unwrap_or(0);
    let room = (bytes.len().saturating_sub(HEADER) / FACET) as u64;
    if count > room {
        let message =
            format!("the header says {count} facets, but there are bytes for {room}; the file is cut off or no STL");
        return Err(source.broken_byte(HEADER - 4, message));
    }
    if count > u64::from(u32::MAX / 3) {
        return Err(source.broken_byte(HEADER - 4, format!("{count} facets are more than an object can have")));
    }
    let rows = bytes[HEADER..].chunks_exact(FACET).take(count as usize);
    let mut facets = Vec::with_capacity(count as usize);
    let mut colored = 0;
    for (index, row) in rows.enumerate() {
        let value = |at: usize| f32::from_le_bytes([row[4 * at], row[4 * at + 1], row[4 * at + 2], row[4 * at + 3]]);
        let point = |first: usize| [value(first), value(first + 1), value(first + 2)];
        let facet = Facet { normal: point(0), corners: [point(3), point(6), point(9)] };
        if !facet.corners.as_flattened().iter().all(|value| value.is_finite()) {
            let message = format!("facet {index} has a coordinate that is no finite number");
            return Err(source.broken_byte(HEADER + index * FACET, message));
        }
        colored += usize::from(row[48..] != [0, 0]);
        facets.push(facet);
    }
    if colored > 0 {
        report.lost(
            "",
            "facet attributes",
            format!("{colored} facets have attribute bytes (colours in some programs)"),
        );
    }
    let extra = bytes.len() - HEADER - count as usize * FACET;
    if extra > 0 {
        report.lost("", "trailing bytes", format!("{extra} bytes after the last facet"));
    }
    Ok(vec![Solid { name, facets }])
}

/// `solid name`, then facets, then `endsolid name`; a file may hold several.
fn text(source: Source, stem: String) -> Result<Vec<Solid>, ConvertError> {
    let mut words = Words::new(source.bytes, 0);
    let mut solids: Vec<Solid> = Vec::new();
    let mut facets = 0_u64;
    let keyword = |words: &mut Words, wanted: &str| {
        let found = words.next();
        match found {
            Some((_, word)) if word.eq_ignore_ascii_case(wanted.as_bytes()) => Ok(()),
            _ => Err(source.expected(&format!("`{wanted}`"), found, words.at)),
        }
    };
    let number = |words: &mut Words, what: &str, finite: bool| {
        let found = words.next();
        let value = found.and_then(|(_, word)| fast_float2::parse::<f32, _>(word).ok());
        value.filter(|value| value.is_finite() || !finite).ok_or_else(|| source.expected(what, found, words.at))
    };
    while let Some((offset, word)) = words.next() {
        if word.eq_ignore_ascii_case(b"solid") {
            let name = aam::Text::from(words.line().trim_ascii()).decoded();
            solids.push(Solid { name: if name.is_empty() { stem.clone() } else { name }, facets: Vec::new() });
        } else if word.eq_ignore_ascii_case(b"endsolid") {
            words.line();
        } else if let (Some(solid), true) = (solids.last_mut(), word.eq_ignore_ascii_case(b"facet")) {
            let mut facet = Facet { normal: [0.0; 3], corners: [[0.0; 3]; 3] };
            keyword(&mut words, "normal")?;
            for value in &mut facet.normal {
                // A degenerate facet's normal is `nan` in some files; it is not used.
                *value = number(&mut words, "a normal's coordinate", false)?;
            }
            keyword(&mut words, "outer")?;
            keyword(&mut words, "loop")?;
            for corner in &mut facet.corners {
                keyword(&mut words, "vertex")?;
                for value in corner {
                    *value = number(&mut words, "a coordinate", true)?;
                }
            }
            keyword(&mut words, "endloop")?;
            keyword(&mut words, "endfacet")?;
            facets += 1;
            if facets > u64::from(u32::MAX / 3) {
                return Err(source.broken(offset, "the file has more facets than an object can have"));
            }
            solid.facets.push(facet);
        } else {
            let what = if solids.is_empty() { "`solid`" } else { "`facet` or `endsolid`" };
            return Err(source.expected(what, Some((offset, word)), 0));
        }
    }
    Ok(solids)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Outcome, Silent, import};

    const TETRAHEDRON: [[[f32; 3]; 3]; 4] = [
        [[0., 0., 0.], [0., 1., 0.], [1., 0., 0.]],
        [[0., 0., 0.], [1., 0., 0.], [0., 0., 1.]],
        [[0., 0., 0.], [0., 0., 1.], [0., 1., 0.]],
        [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]],
    ];

    fn binary_file(header: &[u8], count: u32, facets: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        bytes.extend(count.to_le_bytes());
        for facet in facets {
            bytes.extend([0; 12]);
            bytes.extend(facet.as_flattened().iter().flat_map(|value| value.to_le_bytes()));
            bytes.extend([0, 0]);
        }
        bytes
    }

    fn text_file(facets: &[[[f32; 3]; 3]]) -> String {
        let mut text = "solid my part\r\n".to_owned();
        for facet in facets {
            text += "  facet normal nan 0 0\n outer loop\n";
            for [x, y, z] in facet {
                text += &format!("  vertex {x:e} {y:e}\t{z:e}\n");
            }
            text += " endloop\nendfacet\n";
        }
        text + "endsolid my part\n"
    }

    fn read(bytes: &[u8]) -> Result<Asset, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part.stl");
        std::fs::write(&path, bytes).unwrap();
        import(&path, &ImportOptions::default(), &Silent)
            .map_err(|error| error.to_string().replace(&path.display().to_string(), "part.stl"))
    }

    #[test]
    fn binary_and_text_say_the_same() {
        let binary = read(&binary_file(b"solid, but binary", 4, &TETRAHEDRON)).unwrap();
        let text = read(text_file(&TETRAHEDRON).as_bytes()).unwrap();
        assert_eq!(binary.document.objects()[0].name, "part");
        assert_eq!(text.document.objects()[0].name, "my part");
        for asset in [&binary, &text] {
            let object = &asset.document.objects()[0];
            let faces = object.faces.as_ref().unwrap();
            assert_eq!(object.vertices, [[0., 0., 0.], [0., 1., 0.], [1., 0., 0.], [0., 0., 1.]]);
            assert_eq!(faces.triangles.len(), 4);
            assert!(faces.triangles.iter().all(|triangle| triangle.smoothing == 0));
            assert_eq!(object.material, -1);
        }
        assert_eq!(binary.document.objects()[0].faces, text.document.objects()[0].faces);
    }

    #[test]
    fn several_solids_are_several_objects() {
        let both = text_file(&TETRAHEDRON) + &text_file(&TETRAHEDRON[..1]).replace("my part", "");
        let asset = read(both.as_bytes()).unwrap();
        let names: Vec<String> = asset.document.objects().iter().map(|object| object.name.decoded()).collect();
        assert_eq!(names, ["my part", "part"]);
    }

    #[test]
    fn what_is_odd_is_reported() {
        let mut bytes = binary_file(b"", 4, &TETRAHEDRON);
        bytes[HEADER..HEADER + 12].copy_from_slice(&[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 128, 63]);
        bytes[HEADER + 48] = 7;
        bytes.extend([1, 2, 3]);
        let asset = read(&bytes).unwrap();
        let lost: Vec<&str> = asset
            .report
            .changes
            .iter()
            .filter(|change| change.outcome != Outcome::Kept)
            .map(|change| change.property.as_str())
            .collect();
        assert_eq!(lost, ["facet attributes", "trailing bytes", "facet normals"]);
    }

    #[test]
    fn broken_files() {
        for (bytes, message) in [
            (
                binary_file(b"", 5, &TETRAHEDRON),
                "part.stl: byte 80: the header says 5 facets, but there are bytes for 4",
            ),
            (binary_file(b"", 0, &[]), "part.stl: a model without faces is not supported"),
            (binary_file(b"", u32::MAX, &TETRAHEDRON), "the header says 4294967295 facets"),
            (Vec::new(), "a model without faces"),
            (b"solid x\nfacet normal 0 0 1\nouter lop".to_vec(), "part.stl: 3:7: expected `loop`, found `lop`"),
            (b"solid x\nfacet normal 0 0".to_vec(), "2:17: expected a normal's coordinate, found the end of the file"),
            (b"facet normal 0 0 1".to_vec(), "1:1: expected `solid`, found `facet`"),
            (text_file(&TETRAHEDRON).replace("1e0", "1e99").into_bytes(), "expected a coordinate, found `1e99`"),
        ] {
            let error = read(&bytes).unwrap_err();
            assert!(error.contains(message), "{error}");
        }
        let mut bytes = binary_file(b"", 4, &TETRAHEDRON);
        bytes[HEADER + 50 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(read(&bytes).unwrap_err().contains("byte 134: facet 1 has a coordinate"));
    }
}
