//! Hulls with fewer vertices than their points ask for, laid so that they are as far outside as inside.

use glam::{DMat3, DVec3};

use super::quickhull::{Polyhedron, solid};

/// How far a hull is moved out, as a part of what stands out of it: between outside and inside.
const SHARE: f64 = 0.5;
/// Rounds that may each make it better.
const ROUNDS: usize = 3;

/// The hull of points with at most so many vertices. Where these are too few to hold all points, faces move outwards by
/// half of what stands out of them, so that the largest distance is about halved: the best approximation from both sides
/// instead of from within.
pub(super) fn fitted(points: &[DVec3], most_vertices: usize) -> Option<Polyhedron> {
    let mut best = solid(points, most_vertices)?;
    if best.vertices.len() < most_vertices {
        return Some(best);
    }
    let within = standing_out(&best, points);
    let mut least = within.iter().copied().fold(0.0, f64::max);
    let mut lifts: Vec<f64> = within.iter().map(|height| SHARE * height).collect();
    let inner = best.clone();
    for _ in 0..ROUNDS {
        let moved = moved(&inner, &lifts);
        let Some(found) = solid(&moved, most_vertices) else { break };
        let out = standing_out(&found, points).into_iter().fold(0.0, f64::max);
        // What it covers too much is as bad as what it covers too little.
        let over = moved.iter().zip(&inner.vertices).map(|(to, from)| to.distance(*from)).fold(0.0, f64::max);
        let error = out.max(over);
        if error < least {
            (least, best) = (error, found);
        }
        lifts.iter_mut().for_each(|lift| *lift *= 0.75);
    }
    Some(best)
}

/// For each face, how far the farthest of the points that it is nearest to stands out of it.
fn standing_out(piece: &Polyhedron, points: &[DVec3]) -> Vec<f64> {
    let planes: Vec<Option<(DVec3, f64)>> = piece
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = piece.corners(*triangle);
            let normal = (b - a).cross(c - a).try_normalize()?;
            Some((normal, normal.dot(a)))
        })
        .collect();
    let mut heights = vec![0.0; planes.len()];
    for point in points {
        let mut highest = (0.0, None);
        for (face, plane) in planes.iter().enumerate() {
            if let Some((normal, offset)) = plane
                && normal.dot(*point) - offset > highest.0
            {
                highest = (normal.dot(*point) - offset, Some(face));
            }
        }
        if let (height, Some(face)) = highest
            && height > heights[face]
        {
            heights[face] = height;
        }
    }
    heights
}

/// The vertices, each moved so that its faces rise by what is asked, as nearly as one vertex can (least squares).
fn moved(piece: &Polyhedron, lifts: &[f64]) -> Vec<DVec3> {
    let mut sums = vec![(DMat3::ZERO, DVec3::ZERO, 0.0_f64); piece.vertices.len()];
    for (triangle, lift) in piece.triangles.iter().zip(lifts) {
        let [a, b, c] = piece.corners(*triangle);
        let double = (b - a).cross(c - a);
        let (area, Some(normal)) = (double.length(), double.try_normalize()) else { continue };
        let outer = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
        for corner in triangle {
            let (matrix, right, most) = &mut sums[*corner as usize];
            *matrix += outer * area;
            *right += normal * (area * lift);
            *most = most.max(*lift);
        }
    }
    let each = piece.vertices.iter().zip(sums);
    each.map(|(vertex, (matrix, right, most))| {
        let weight = matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
        if most == 0.0 || weight <= 0.0 {
            return *vertex;
        }
        // A little of the identity, for corners of nearly flat faces.
        let matrix = matrix + DMat3::IDENTITY * (0.01 * weight);
        *vertex + (matrix.inverse() * right).clamp_length_max(2.0 * most)
    })
    .collect()
}
