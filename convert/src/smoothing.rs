//! Smoothing masks that give authored normals back, or explicit normals where no masks do.
//!
//! A mask says with which faces a face is smooth, and the format's rule makes normals of that: at a corner, the
//! unweighted mean of the unit normals of the faces at that vertex *index* whose masks overlap the corner's own, its own
//! face always included; mask 0 overlaps nothing. This module goes the other way: `relation` finds which faces must be
//! smooth with which, `coloring` gives them bits so that exactly those overlap, and the result is verified by the rule.

mod coloring;
mod relation;
mod surface;

use std::collections::HashMap;
use std::fmt::Write as _;

use aam::document::Triangle;
use aam::meaning::{SmoothingRule, corner_normals as corner_normals_of};
use glam::DVec3;

use surface::{Surface, angle};

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
/// The caller welds vertices of equal position first, for nothing is smooth across different indices.
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
    let tolerance = f64::from(tolerance_degrees.max(0.0)).to_radians().max(MEASURABLE);
    let surface = Surface::new(vertices, triangles);
    let authored: Vec<DVec3> = corner_normals.iter().flatten().map(unit_or_zero).collect();

    let relation = relation::find(&surface, triangles, &authored, tolerance);
    let masks = coloring::color(&surface, triangles, &relation);
    let masks: Vec<i32> = masks.into_iter().map(u32::cast_signed).collect();
    let masked: Vec<Triangle> =
        triangles.iter().zip(&masks).map(|(&vertices, &smoothing)| Triangle { vertices, smoothing }).collect();
    let by_masks: Vec<DVec3> = corner_normals_of(vertices, &masked, SmoothingRule::Masks)
        .iter()
        .flatten()
        .map(|normal| normal.as_dvec3())
        .collect();

    let mut found = Recovered { masks, ..Recovered::default() };
    let mut worst = 0.0_f64;
    for (corner, (wanted, given)) in authored.iter().zip(&by_masks).enumerate() {
        if *wanted != DVec3::ZERO && surface.normals[corner / 3] != DVec3::ZERO {
            let off = angle(*wanted, *given);
            worst = worst.max(off);
            found.corners += 1;
            found.corners_off += usize::from(off > tolerance);
        }
    }
    found.worst_degrees = worst.to_degrees() as f32;
    if found.corners_off > 0 {
        let explicit = explicit(&authored, &by_masks);
        found.explicit_bytes = text_bytes(&explicit);
        found.explicit = Some(explicit);
    }
    found
}

/// Angles in radians below this are rounding of `f32` positions and normals.
const MEASURABLE: f64 = 2e-6;

/// A unit normal is kept to the bit, so that recovering twice gives the same file.
fn unit_or_zero(normal: &[f32; 3]) -> DVec3 {
    let normal = DVec3::from(normal.map(f64::from));
    if (normal.length_squared() - 1.0).abs() < 1e-6 {
        return normal;
    }
    normal.try_normalize().unwrap_or(DVec3::ZERO)
}

/// The authored normals, or those of the masks at corners that have none; equal ones once, in order of first use.
fn explicit(authored: &[DVec3], by_masks: &[DVec3]) -> ExplicitNormals {
    let mut explicit = ExplicitNormals::default();
    let mut known: HashMap<[u32; 3], u32> = HashMap::new();
    for (authored, by_masks) in authored.chunks_exact(3).zip(by_masks.chunks_exact(3)) {
        explicit.indices.push([0, 1, 2].map(|at| {
            let chosen = if authored[at] == DVec3::ZERO { by_masks[at] } else { authored[at] };
            // Adding zero turns -0 into 0, so that equal normals are one.
            let normal = chosen.as_vec3().to_array().map(|value| value + 0.0);
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

#[cfg(test)]
mod tests;
