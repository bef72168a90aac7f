//! How far convex pieces are from a surface, both ways.

use glam::DVec3;

use super::field::Field;
use super::mesh::Mesh;
use super::quickhull::Polyhedron;

/// Samples are this far apart, as a part of the surface's diagonal: where a distance is largest, it is underestimated by
/// no more than about half of it.
pub(super) const SPACING: f64 = 5e-3;
/// The most samples of the surface, and of all pieces; more are spread wider.
const MOST_SAMPLES: f64 = 2e5;
/// A point within this part of the diagonal of another piece is on the cut between the two, not on the outside.
const CUT: f64 = 2e-3;

/// Distances as parts of the surface's diagonal.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Error {
    /// The largest from the outside of the pieces to the surface.
    pub(super) outside: f64,
    /// The mean of these.
    pub(super) mean: f64,
    /// The largest from the surface to the pieces.
    pub(super) uncovered: f64,
}

impl Error {
    /// Of pieces, which should cover a mesh.
    pub(super) fn of(pieces: &[Polyhedron], mesh: &Mesh, field: &Field) -> Self {
        let low = mesh.vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = mesh.vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let diagonal = (high - low).length();
        let planes: Vec<Planes> = pieces.iter().map(Planes::new).collect();
        let cut = CUT * diagonal;
        let count = |area: f64| (area / (SPACING * diagonal).powi(2)).min(MOST_SAMPLES);

        let all = pieces.iter().map(area).sum::<f64>();
        let (mut most, mut sum, mut weights) = (0.0_f64, 0.0, 0.0);
        for (index, piece) in pieces.iter().enumerate() {
            let own = area(piece);
            let samples = spread(
                piece.triangles.iter().map(|triangle| piece.corners(*triangle)),
                (count(all) * own / all).ceil().max(64.0) as usize,
            );
            let weight = own / samples.len().max(1) as f64;
            // Vertices can be the worst, but have no area.
            let vertices = piece.vertices.iter().map(|vertex| (*vertex, 0.0));
            for (sample, weight) in samples.into_iter().map(|sample| (sample, weight)).chain(vertices) {
                let mut others = planes.iter().enumerate().filter(|(other, _)| *other != index);
                if !field.is_inside(sample) && !others.any(|(_, planes)| planes.within(sample, cut)) {
                    let distance = field.to_surface(sample);
                    most = most.max(distance);
                    sum += weight * distance;
                    weights += weight;
                }
            }
        }

        let surface = || mesh.triangles.iter().map(|triangle| mesh.corners(*triangle));
        let mut samples = spread(surface(), count(surface().map(triangle_area).sum()) as usize);
        samples.extend(mesh.vertices.iter().step_by(mesh.vertices.len().div_ceil(MOST_SAMPLES as usize).max(1)));
        let uncovered = |sample: &DVec3| {
            let mut least = f64::INFINITY;
            for planes in &planes {
                if planes.box_distance(*sample) < least {
                    least = least.min(planes.height(*sample).max(0.0));
                }
                if least == 0.0 {
                    break;
                }
            }
            least
        };
        let uncovered = samples.iter().map(uncovered).fold(0.0, f64::max);
        let mean = if weights > 0.0 { sum / weights } else { 0.0 };
        Self { outside: most / diagonal, mean: mean / diagonal, uncovered: uncovered / diagonal }
    }
}

/// A piece as half-spaces.
struct Planes {
    low: DVec3,
    high: DVec3,
    planes: Vec<(DVec3, f64)>,
}

impl Planes {
    fn new(piece: &Polyhedron) -> Self {
        let (low, high) = piece.bounds();
        Self { low, high, planes: piece.planes() }
    }

    /// How far a point is above the highest of the planes: a lower bound of its distance, negative inside.
    fn height(&self, point: DVec3) -> f64 {
        self.planes.iter().map(|(normal, offset)| normal.dot(point) - offset).fold(f64::NEG_INFINITY, f64::max)
    }

    /// How far a point is from the box around the piece, a lower bound of its distance too.
    fn box_distance(&self, point: DVec3) -> f64 {
        (point - point.clamp(self.low, self.high)).length()
    }

    fn within(&self, point: DVec3, margin: f64) -> bool {
        point.cmpge(self.low - margin).all() && point.cmple(self.high + margin).all() && self.height(point) <= margin
    }
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
