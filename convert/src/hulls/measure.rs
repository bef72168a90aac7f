//! How far convex pieces are from a surface.

use glam::{DVec3, Vec3};
use parry3d::query::PointQuery;
use parry3d::shape::TriMesh;
use parry3d::transformation::voxelization::VoxelSet;

use super::quickhull::Polyhedron;

/// A surface to measure distances to.
pub(super) struct Surface {
    mesh: TriMesh,
    /// Points spread over it.
    samples: Vec<DVec3>,
    diagonal: f64,
    inside: Inside,
}

/// Points on the surface, and on all pieces together.
const SAMPLES: usize = 10_000;
/// A point within this part of the diagonal of another piece is on the cut between the two, not on the outside.
const CUT: f64 = 2e-3;

impl Surface {
    /// `None` if there is no triangle with an area.
    pub(super) fn new(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Option<Self> {
        let low = vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let corners = |triangle: &[u32; 3]| triangle.map(|index| vertices[index as usize]);
        let mut samples = spread(triangles.iter().map(corners), SAMPLES);
        samples.extend(vertices.iter().step_by(vertices.len().div_ceil(SAMPLES).max(1)));
        let mesh = TriMesh::new(vertices.iter().map(|vertex| vertex.as_vec3()).collect(), triangles.to_vec()).ok()?;
        Some(Self { mesh, samples, diagonal: (high - low).length(), inside: Inside::default() })
    }

    /// What is inside, so that faces of pieces there (cuts, and hollows that no surface point reaches) count as no error.
    pub(super) fn fill(&mut self, voxels: &VoxelSet) {
        self.inside = Inside::new(voxels);
    }

    fn distance(&self, point: DVec3) -> f64 {
        let point: Vec3 = point.as_vec3();
        f64::from(self.mesh.project_local_point(point, false).point.distance(point))
    }

    /// The largest distance from the outside of pieces to the surface, and from the surface to the pieces, as parts of
    /// the diagonal.
    pub(super) fn error(&self, pieces: &[Polyhedron]) -> Error {
        let planes: Vec<Planes> = pieces.iter().map(Planes::new).collect();
        let cut = CUT * self.diagonal;
        let all = pieces.iter().map(area).sum::<f64>();
        let mut outside = 0.0_f64;
        for (index, piece) in pieces.iter().enumerate() {
            let share = (SAMPLES as f64 * area(piece) / all).ceil().min(SAMPLES as f64) as usize;
            let corners = |triangle: &[u32; 3]| piece.corners(*triangle);
            let samples = spread(piece.triangles.iter().map(corners), share.max(64));
            for sample in samples.iter().chain(&piece.vertices) {
                let others = planes.iter().enumerate().filter(|(other, _)| *other != index);
                let mut others = others.map(|(_, planes)| planes);
                if !self.inside.contains(*sample) && !others.any(|planes| planes.within(*sample, cut)) {
                    outside = outside.max(self.distance(*sample));
                }
            }
        }
        let uncovered =
            |sample: &DVec3| planes.iter().map(|planes| planes.height(*sample)).fold(f64::INFINITY, f64::min);
        let uncovered = self.samples.iter().map(uncovered).fold(0.0, f64::max);
        Error { outside: outside / self.diagonal, uncovered: uncovered / self.diagonal }
    }
}

/// The voxels that are full and not on the surface.
#[derive(Default)]
struct Inside {
    origin: DVec3,
    scale: f64,
    size: [usize; 3],
    full: Vec<bool>,
}

impl Inside {
    fn new(voxels: &VoxelSet) -> Self {
        let inner = || voxels.voxels().iter().filter(|voxel| !voxel.is_on_surface);
        let coordinates = |coords: glam::IVec3| coords.to_array().map(|value| usize::try_from(value).unwrap_or(0));
        let mut size = [0; 3];
        for voxel in inner() {
            let at = coordinates(voxel.coords);
            (0..3).for_each(|i| size[i] = size[i].max(at[i] + 1));
        }
        let mut found = Self {
            origin: voxels.origin.as_dvec3(),
            scale: f64::from(voxels.scale),
            size,
            full: vec![false; size.iter().product()],
        };
        for voxel in inner() {
            let at = found.place(coordinates(voxel.coords));
            found.full[at] = true;
        }
        found
    }

    fn place(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.size[1] + y) * self.size[2] + z
    }

    fn contains(&self, point: DVec3) -> bool {
        // Voxels are centred on their coordinates.
        let at = ((point - self.origin) / self.scale).round().to_array();
        let inside = (0..3).all(|i| at[i] >= 0.0 && at[i] < self.size[i] as f64);
        inside && self.full[self.place(at.map(|value| value as usize))]
    }
}

/// Distances as parts of the surface's diagonal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Error {
    /// From the outside of the pieces to the surface.
    pub(super) outside: f64,
    /// From the surface to the pieces.
    pub(super) uncovered: f64,
}

impl Error {
    pub(super) fn worst(self) -> f64 {
        self.outside.max(self.uncovered)
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
        Self {
            low: piece.vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min),
            high: piece.vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max),
            planes: piece.planes(),
        }
    }

    /// How far a point is above the highest of the planes: a lower bound of its distance, negative inside.
    fn height(&self, point: DVec3) -> f64 {
        self.planes.iter().map(|(normal, offset)| normal.dot(point) - offset).fold(f64::NEG_INFINITY, f64::max)
    }

    fn within(&self, point: DVec3, margin: f64) -> bool {
        point.cmpge(self.low - margin).all() && point.cmple(self.high + margin).all() && self.height(point) <= margin
    }
}

fn area(piece: &Polyhedron) -> f64 {
    piece.triangles.iter().map(|triangle| triangle_area(piece.corners(*triangle))).sum()
}

fn triangle_area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// About `count` points, evenly over triangles: the R2 sequence (M. Roberts, 2018) in each.
fn spread(triangles: impl Iterator<Item = [DVec3; 3]> + Clone, count: usize) -> Vec<DVec3> {
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
