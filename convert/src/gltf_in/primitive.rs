//! Primitives decoded: positions and attributes by vertex, and triangles whatever the mode.

use super::accessor::{Reader, Rows};
use super::fault::{Checked, Fault};
use super::log::Log;
use super::model::{self, Mode};

/// The decoded data of a primitive that has triangles.
#[derive(Clone, Debug, Default)]
pub(super) struct Primitive {
    pub material: Option<usize>,
    pub positions: Vec<[f32; 3]>,
    /// Authored normals; a zero normal asks for nothing.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Linear vertex colours with alpha.
    pub colors: Option<Vec<[f32; 4]>>,
    /// Texture coordinates in glTF's space (v down), by set.
    pub uvs: Vec<(u32, Vec<[f32; 2]>)>,
    pub triangles: Vec<[u32; 3]>,
    /// Bones of each vertex, the same number for each.
    pub influences: Vec<Influence>,
    pub influences_per_vertex: usize,
    pub targets: Vec<MorphTarget>,
}

/// A joint of the skin and its weight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Influence {
    pub joint: u32,
    pub weight: f32,
}

/// What a morph target adds.
#[derive(Clone, Debug, Default)]
pub(super) struct MorphTarget {
    pub positions: Option<Vec<[f32; 3]>>,
    pub normals: Option<Vec<[f32; 3]>>,
}

impl Primitive {
    /// The coordinates of a set.
    pub(super) fn uv(&self, set: u32) -> Option<&[[f32; 2]]> {
        self.uvs.iter().find(|(number, _)| *number == set).map(|(_, uvs)| uvs.as_slice())
    }
}

/// Decodes a primitive; `None` if it has no triangles, which the report says where it is a loss. `sets` are the
/// `TEXCOORD` sets that its material uses.
pub(super) fn decode(
    reader: Reader<'_>,
    primitive: &model::Primitive,
    sets: &[u32],
    subject: &str,
    log: &mut Log,
) -> Checked<Option<Primitive>> {
    let attributes = &primitive.attributes;
    let Some(position) = attributes.position else {
        log.lost(subject, "primitive", "it has no POSITION, so there is nothing to draw");
        return Ok(None);
    };
    match primitive.mode {
        Mode::Points => {
            log.lost(subject, "points", "AAM holds triangles only");
            return Ok(None);
        }
        Mode::Lines => {
            log.lost(subject, "lines", "AAM holds triangles only");
            return Ok(None);
        }
        Mode::Triangles | Mode::Strip | Mode::Fan => {}
    }
    let count = reader.position_count(position)?;
    let indices = match primitive.indices {
        Some(accessor) => reader.indices(accessor, count)?,
        None => (0..u32::try_from(count).unwrap_or(u32::MAX)).collect(),
    };
    let (used, triangles) = compact(triangles(primitive.mode, &indices), count);
    let rows = if used.len() == count { Rows::All } else { Rows::Some(&used) };
    let counted = |accessor: usize, usage: &str| -> Checked<usize> {
        let found = &reader.model.accessors[accessor];
        if found.count == count {
            return Ok(accessor);
        }
        let message = format!("{usage} has {} elements, but POSITION has {count}", found.count);
        Err(Fault::broken(format!("{}/count", found.place), message))
    };
    let mut decoded = Primitive {
        material: primitive.material,
        positions: reader.finite(position, rows, "POSITION")?,
        triangles,
        ..Primitive::default()
    };
    if let Some(normal) = attributes.normal {
        let mut normals = reader.floats(counted(normal, "NORMAL")?, rows, "NORMAL")?;
        zero_unusable(&mut normals, "normals", subject, log);
        decoded.normals = Some(normals);
    }
    if let Some(color) = attributes.color {
        let mut colors = reader.colors(counted(color, "COLOR_0")?, rows)?;
        zero_unusable(&mut colors, "vertex colours", subject, log);
        decoded.colors = Some(colors);
    }
    for &set in sets {
        let usage = format!("TEXCOORD_{set}");
        if let Some((_, accessor)) = attributes.tex_coords.iter().find(|(number, _)| *number == set) {
            let mut uvs = reader.floats(counted(*accessor, &usage)?, rows, &usage)?;
            zero_unusable(&mut uvs, "texture coordinates", subject, log);
            decoded.uvs.push((set, uvs));
        }
    }
    decoded.influences_per_vertex = 4 * attributes.joints.len();
    decoded.influences = influences(reader, attributes, rows, decoded.positions.len(), &counted)?;
    for (positions, normals) in &primitive.targets {
        let deltas = |accessor: &Option<usize>, usage: &str| -> Checked<Option<Vec<[f32; 3]>>> {
            accessor.map(|accessor| reader.finite(counted(accessor, usage)?, rows, usage)).transpose()
        };
        let target = MorphTarget {
            positions: deltas(positions, "POSITION of a morph target")?,
            normals: deltas(normals, "NORMAL of a morph target")?,
        };
        decoded.targets.push(target);
    }
    if primitive.mode == Mode::Triangles && indices.len() % 3 != 0 {
        let left = indices.len() % 3;
        log.changed(subject, "triangles", format!("{left} indices at the end make no triangle; dropped"), None);
    }
    if attributes.tangent.is_some() {
        log.changed(subject, "tangents", "dropped; they are computed anew (MikkTSpace) where they are needed", None);
    }
    for name in &attributes.ignored {
        log.lost(subject, "vertex attribute", format!("{name} has no counterpart in AAM"));
    }
    Ok(Some(decoded).filter(|decoded| !decoded.triangles.is_empty()))
}

/// Replaces rows that are not finite by zeros.
fn zero_unusable<const N: usize>(rows: &mut [[f32; N]], what: &'static str, subject: &str, log: &mut Log) {
    let mut count = 0_usize;
    for row in rows {
        if row.iter().any(|value| !value.is_finite()) {
            *row = [0.0; N];
            count += 1;
        }
    }
    if count > 0 {
        log.changed(subject, what, format!("{count} that are not finite became zero"), None);
    }
}

fn influences(
    reader: Reader<'_>,
    attributes: &model::Attributes,
    rows: Rows<'_>,
    count: usize,
    counted: &impl Fn(usize, &str) -> Checked<usize>,
) -> Checked<Vec<Influence>> {
    let sets = attributes.joints.len();
    let mut influences = vec![Influence::default(); count * 4 * sets];
    for (set, (&joints, &weights)) in attributes.joints.iter().zip(&attributes.weights).enumerate() {
        let joints = reader.joints(counted(joints, "JOINTS")?, rows)?;
        let weights = reader.weights(counted(weights, "WEIGHTS")?, rows)?;
        for (vertex, (joints, weights)) in joints.iter().zip(&weights).enumerate() {
            for at in 0..4 {
                let weight = weights[at];
                // A weight that is no number, or negative, binds to nothing; so does its joint then.
                let weight = if weight.is_finite() && weight > 0.0 { weight } else { 0.0 };
                let joint = if weight > 0.0 { joints[at] } else { 0 };
                influences[(vertex * sets + set) * 4 + at] = Influence { joint, weight };
            }
        }
    }
    // Weights must sum to 1 (glTF 2.0 §3.7.3.3); quantised ones miss it by their rounding.
    if sets > 0 {
        for vertex in influences.chunks_exact_mut(4 * sets) {
            let sum: f64 = vertex.iter().map(|influence| f64::from(influence.weight)).sum();
            if sum > 0.0 {
                vertex.iter_mut().for_each(|influence| influence.weight = (f64::from(influence.weight) / sum) as f32);
            } else {
                vertex[0].weight = 1.0;
            }
        }
    }
    Ok(influences)
}

/// The vertices that triangles use, in ascending order, and the triangles with these numbered from 0. (Files share one
/// long vertex list between many primitives.)
fn compact(mut triangles: Vec<[u32; 3]>, count: usize) -> (Vec<u32>, Vec<[u32; 3]>) {
    let corners = triangles.as_flattened();
    let used: Vec<u32> = if corners.len() < count / 16 {
        let mut used = corners.to_vec();
        used.sort_unstable();
        used.dedup();
        for corner in triangles.as_flattened_mut() {
            *corner = used.binary_search(corner).unwrap_or(0) as u32;
        }
        return (used, triangles);
    } else {
        let mut seen = vec![false; count];
        corners.iter().for_each(|&corner| seen[corner as usize] = true);
        seen.iter().enumerate().filter(|(_, seen)| **seen).map(|(vertex, _)| vertex as u32).collect()
    };
    if used.len() < count {
        let mut numbers = vec![0; count];
        used.iter().enumerate().for_each(|(number, &vertex)| numbers[vertex as usize] = number as u32);
        triangles.as_flattened_mut().iter_mut().for_each(|corner| *corner = numbers[*corner as usize]);
    }
    (used, triangles)
}

/// Triangles of a list, strip or fan (glTF 2.0 §3.7.2.1). Strips are sewn together by triangles without area, which
/// are left out.
fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    let has_area = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    match mode {
        Mode::Points | Mode::Lines => Vec::new(),
        Mode::Triangles => indices.chunks_exact(3).map(|three| [three[0], three[1], three[2]]).collect(),
        Mode::Strip => indices
            .windows(3)
            .enumerate()
            .map(
                |(at, three)| if at % 2 == 0 { [three[0], three[1], three[2]] } else { [three[0], three[2], three[1]] },
            )
            .filter(has_area)
            .collect(),
        Mode::Fan => match indices.split_first() {
            Some((&hub, rim)) => rim.windows(2).map(|two| [two[0], two[1], hub]).filter(has_area).collect(),
            None => Vec::new(),
        },
    }
}
