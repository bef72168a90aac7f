//! How far convex pieces are from a surface, both ways.

use glam::DVec3;
use rayon::prelude::*;

use super::field::Field;
use super::mesh::Mesh;
use super::quickhull::Polyhedron;
use super::{Distances, Quality};

/// Samples are this far apart, as a part of the surface's diagonal: where a distance is largest, it is underestimated by
/// no more than about half of it.
pub(super) const SPACING: f64 = 5e-3;
/// The most samples of the surface, and of all pieces; more are spread wider.
const MOST_SAMPLES: f64 = 1e6;
/// Distances (of a mesh whose longest side is 1) that are none.
const ROUNDING: f64 = 1e-6;
/// A point within this part of the diagonal of another piece is on the cut between the two, not on the outside.
const CUT: f64 = 2e-3;

impl Quality {
    /// Of pieces, which should cover a mesh, by samples so far apart (as a part of the diagonal).
    pub(super) fn of(pieces: &[Polyhedron], mesh: &Mesh, field: &Field, spacing: f64) -> Self {
        let (low, high) = mesh.bounds();
        let diagonal = (high - low).length();
        let solids: Vec<Solid> = pieces.iter().map(Solid::new).collect();
        let count = |area: f64| (area / (spacing * diagonal).powi(2)).min(MOST_SAMPLES);

        let all = pieces.iter().map(area).sum::<f64>();
        let outside = |(index, piece): (usize, &Polyhedron)| {
            let own = area(piece);
            let samples = spread(
                piece.triangles.iter().map(|triangle| piece.corners(*triangle)),
                (count(all) * own / all).ceil().max(64.0) as usize,
            );
            let weight = own / samples.len().max(1) as f64;
            let distances = samples
                .par_iter()
                .filter_map(|sample| distance_outside(*sample, index, &solids, field, CUT * diagonal));
            let distances: Vec<f64> = distances.collect();
            // Vertices can be the worst, but have no area.
            let vertices =
                piece.vertices.iter().filter_map(|at| distance_outside(*at, index, &solids, field, CUT * diagonal));
            let mut found = Sum::default();
            distances.into_iter().for_each(|distance| found.add(distance, weight));
            vertices.for_each(|distance| found.add(distance, 0.0));
            found
        };
        let outside: Vec<Sum> = pieces.iter().enumerate().map(outside).collect();

        let surface = || mesh.triangles.iter().map(|triangle| mesh.corners(*triangle));
        let mut samples = spread(surface(), count(surface().map(triangle_area).sum()) as usize);
        let sampled = samples.len();
        samples.extend(mesh.vertices.iter().step_by(mesh.vertices.len().div_ceil(MOST_SAMPLES as usize).max(1)));
        let nearest: Vec<(f64, usize)> = samples.par_iter().map(|sample| nearest(*sample, &solids)).collect();
        let mut uncovered = vec![Sum::default(); pieces.len()];
        for (at, (distance, index)) in nearest.into_iter().enumerate() {
            if let Some(sum) = uncovered.get_mut(index) {
                sum.add(distance, if at < sampled { 1.0 } else { 0.0 });
            }
        }
        Self {
            outside: Sum::total(&outside).distances(diagonal),
            uncovered: Sum::total(&uncovered).distances(diagonal),
            spacing: spacing as f32,
            pieces: outside
                .iter()
                .zip(&uncovered)
                .map(|pair| [pair.0.distances(diagonal), pair.1.distances(diagonal)])
                .collect(),
        }
    }
}

/// How far a point of a piece is from the surface; `None` if it is not on the outside of all pieces.
fn distance_outside(sample: DVec3, index: usize, solids: &[Solid], field: &Field, cut: f64) -> Option<f64> {
    let mut others = solids.iter().enumerate().filter(|(other, _)| *other != index);
    let hidden = field.is_inside(sample) || others.any(|(_, solid)| solid.within(sample, cut));
    (!hidden).then(|| field.to_surface(sample))
}

/// How far a point is from the nearest piece, and which that is.
fn nearest(sample: DVec3, solids: &[Solid]) -> (f64, usize) {
    let mut best = (f64::INFINITY, usize::MAX);
    for (index, solid) in solids.iter().enumerate() {
        if solid.box_distance(sample) < best.0 {
            let distance = solid.distance(sample, best.0);
            if distance < best.0 {
                best = (distance, index);
            }
        }
        if best.0 == 0.0 {
            break;
        }
    }
    best
}

/// Weighted distances, summed up.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    most: f64,
    sum: f64,
    weights: f64,
}

impl Sum {
    fn add(&mut self, distance: f64, weight: f64) {
        self.most = self.most.max(distance);
        self.sum += weight * distance;
        self.weights += weight;
    }

    fn total(each: &[Self]) -> Self {
        each.iter().fold(Self::default(), |all, one| Self {
            most: all.most.max(one.most),
            sum: all.sum + one.sum,
            weights: all.weights + one.weights,
        })
    }

    fn distances(&self, diagonal: f64) -> Distances {
        let mean = if self.weights > 0.0 { self.sum / self.weights } else { 0.0 };
        Distances { max: (self.most / diagonal) as f32, mean: (mean / diagonal) as f32 }
    }
}

/// A piece as half-spaces and triangles.
struct Solid {
    low: DVec3,
    high: DVec3,
    faces: Vec<(DVec3, f64, [DVec3; 3])>,
}

impl Solid {
    fn new(piece: &Polyhedron) -> Self {
        let (low, high) = piece.bounds();
        let face = |triangle: &[u32; 3]| {
            let corners = piece.corners(*triangle);
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a).try_normalize()?;
            Some((normal, normal.dot(a), corners))
        };
        Self { low, high, faces: piece.triangles.iter().filter_map(face).collect() }
    }

    /// How far a point is above the highest of the planes: a lower bound of its distance, negative inside.
    fn height(&self, point: DVec3) -> f64 {
        self.faces.iter().map(|(normal, offset, _)| normal.dot(point) - offset).fold(f64::NEG_INFINITY, f64::max)
    }

    /// How far a point is from the box around the piece, a lower bound of its distance too.
    fn box_distance(&self, point: DVec3) -> f64 {
        (point - point.clamp(self.low, self.high)).length()
    }

    /// How far a point is outside, as long as that is less than `most`.
    fn distance(&self, point: DVec3, most: f64) -> f64 {
        let height = self.height(point);
        if height <= ROUNDING {
            return 0.0;
        }
        if height >= most {
            return f64::INFINITY;
        }
        // The nearest face is one that the point sees.
        let seen = self.faces.iter().filter(|(normal, offset, _)| normal.dot(point) > *offset);
        seen.map(|(_, _, triangle)| distance_to_triangle(point, triangle)).fold(f64::INFINITY, f64::min)
    }

    fn within(&self, point: DVec3, margin: f64) -> bool {
        point.cmpge(self.low - margin).all() && point.cmple(self.high + margin).all() && self.height(point) <= margin
    }
}

/// The distance from a point to a triangle (C. Ericson, "Real-Time Collision Detection", 2005, sec. 5.1.5).
fn distance_to_triangle(point: DVec3, &[a, b, c]: &[DVec3; 3]) -> f64 {
    let (ab, ac) = (b - a, c - a);
    let to_edge = |from: DVec3, along: DVec3| {
        let share = ((point - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (point - from - share * along).length()
    };
    let normal = ab.cross(ac);
    let (p, square) = (point - a, normal.length_squared());
    if square > 0.0 {
        let v = p.cross(ac).dot(normal);
        let w = ab.cross(p).dot(normal);
        if v >= 0.0 && w >= 0.0 && v + w <= square {
            return (p.dot(normal) / square.sqrt()).abs();
        }
    }
    to_edge(a, ab).min(to_edge(a, ac)).min(to_edge(b, c - b))
}

pub(super) fn area(piece: &Polyhedron) -> f64 {
    piece.triangles.iter().map(|triangle| triangle_area(piece.corners(*triangle))).sum()
}

fn triangle_area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// About `count` points, evenly over triangles: the R2 sequence (M. Roberts, 2018) in each.
pub(super) fn spread(triangles: impl Iterator<Item = [DVec3; 3]> + Clone, count: usize) -> Vec<DVec3> {
    const STEP: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
    let all: f64 = triangles.clone().map(triangle_area).sum();
    let mut points = Vec::with_capacity(count);
    let mut owed = 0.0;
    let mut at = [0.5, 0.5];
    for corners in triangles {
        owed += count as f64 * triangle_area(corners) / all;
        while owed >= 1.0 {
            owed -= 1.0;
            at = [(at[0] + STEP[0]).fract(), (at[1] + STEP[1]).fract()];
            let [u, v] = if at[0] + at[1] > 1.0 { [1.0 - at[0], 1.0 - at[1]] } else { at };
            points.push(corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]));
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_a_triangle_are_exact() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        for (point, distance) in [
            (DVec3::new(0.2, 0.2, 0.5), 0.5),
            (DVec3::new(0.2, 0.2, -0.5), 0.5),
            (DVec3::new(-3.0, -4.0, 0.0), 5.0),
            (DVec3::new(0.5, -2.0, 0.0), 2.0),
            (DVec3::new(1.0, 1.0, 0.0), 0.5_f64.sqrt()),
            (DVec3::new(2.0, 0.0, 0.0), 1.0),
        ] {
            assert!((distance_to_triangle(point, &triangle) - distance).abs() < 1e-12, "{point}");
        }
        let line = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X];
        assert!((distance_to_triangle(DVec3::new(1.5, 2.0, 0.0), &line) - 2.0).abs() < 1e-12);
    }
}
