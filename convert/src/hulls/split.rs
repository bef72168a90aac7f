//! Cuts a mesh into parts, the worst one first, by the planes that leave the least error.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::field::Field;
use super::measure::spread;
use super::mesh::{Mesh, Plane};
use super::quickhull::{Polyhedron, solid};

/// Planes across each axis of the space, and of the part itself.
const ACROSS: usize = 9;
/// Planes along the faces of a part.
const FACES: usize = 16;
/// Planes around the worst point.
const AROUND: usize = 8;
/// What a cut into one large and one small side costs, where it gains nothing else.
const UNEVEN: f64 = 0.1;
/// No side may be thinner than this part of the mesh's longest side, unless it is a face.
const THIN: f64 = 0.015;
/// As thin as a face.
const FLAT: f64 = 2e-5;
/// A wall without thickness is cut off so far behind its face.
const BEHIND: f64 = 1e-5;
/// Triangles that cuts are looked for in.
const SKETCHED: usize = 6_000;
/// Planes that are looked at closely.
const CLOSELY: usize = 6;

/// How closely a hull is looked at.
#[derive(Clone, Copy)]
pub(super) struct Care {
    /// The most vertices of the hull.
    vertices: usize,
    /// Distance between samples as a part of the hull's diagonal.
    spacing: f64,
}

/// To choose among many planes.
const ROUGH: Care = Care { vertices: 24, spacing: 0.1 };
/// To tell how good a hull is.
pub(super) const FINE: Care = Care { vertices: 64, spacing: 0.05 };
/// Samples are no farther apart than this part of the mesh's longest side.
const SPACING: f64 = 0.03;

/// How far a hull is outside of the solid.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Excess {
    /// At most.
    pub(super) most: f64,
    /// Over the hull's faces, as an integral.
    pub(super) sum: f64,
    /// Where it is most, and the normal of the face there.
    pub(super) place: DVec3,
    normal: DVec3,
}

impl Excess {
    pub(super) fn of(piece: &Polyhedron, field: &Field, care: Care) -> Self {
        let spacing = (care.spacing * piece.diagonal()).min(SPACING * care.spacing / FINE.spacing);
        let mut found = Self::default();
        for triangle in &piece.triangles {
            let corners = piece.corners(*triangle);
            let [a, b, c] = corners;
            let double = (b - a).cross(c - a);
            let area = 0.5 * double.length();
            let Some(normal) = double.try_normalize() else { continue };
            let count = (area / (spacing * spacing)).ceil().max(1.0) as usize;
            let samples = spread(std::iter::once(corners), count);
            let mut sum = 0.0;
            for sample in &samples {
                let outside = field.outside(*sample);
                sum += outside;
                if outside > found.most {
                    (found.most, found.place, found.normal) = (outside, *sample, normal);
                }
            }
            found.sum += sum * area / samples.len().max(1) as f64;
        }
        found.climb(piece, field, spacing);
        found
    }

    /// Looks for a worse place beside the worst.
    fn climb(&mut self, piece: &Polyhedron, field: &Field, spacing: f64) {
        if self.most == 0.0 {
            return;
        }
        let planes = piece.planes();
        let (right, up) = self.normal.any_orthonormal_pair();
        let mut step = 0.5 * spacing;
        while step > 0.02 * spacing {
            let mut better = None;
            for to in [right, -right, up, -up] {
                let place = self.place + step * to;
                // Still on the hull.
                if planes.iter().all(|(normal, offset)| normal.dot(place) <= offset + 1e-9) {
                    let outside = field.outside(place);
                    if outside > self.most {
                        (self.most, better) = (outside, Some(place));
                    }
                }
            }
            match better {
                Some(place) => self.place = place,
                None => step *= 0.5,
            }
        }
    }
}

/// The hull of points, and how good it is.
pub(super) fn look(points: &[DVec3], field: &Field, care: Care) -> (Option<Polyhedron>, Excess) {
    let hull = solid(points, care.vertices);
    let excess = hull.as_ref().map(|hull| Excess::of(hull, field, care)).unwrap_or_default();
    (hull, excess)
}

/// A part of the solid.
pub(super) struct Part {
    pub(super) mesh: Mesh,
    /// A simpler mesh to look for cuts in, if this one is large.
    sketch: Option<Mesh>,
    /// `None` for one on a line.
    pub(super) hull: Option<Polyhedron>,
    pub(super) excess: Excess,
}

impl Part {
    pub(super) fn new(mesh: Mesh, field: &Field) -> Self {
        let (hull, excess) = look(&mesh.vertices, field, FINE);
        let sketch = (mesh.triangles.len() > SKETCHED).then(|| mesh.simplified(SKETCHED));
        Self { mesh, sketch, hull, excess }
    }

    /// The two sides of the best plane; `None` if no plane parts it.
    pub(super) fn halves(&self, field: &Field) -> Option<[Self; 2]> {
        let plane = best_plane(self, field)?;
        Some(self.mesh.cut(&plane).map(|mesh| Self::new(mesh, field)))
    }

    fn sketch(&self) -> &Mesh {
        self.sketch.as_ref().unwrap_or(&self.mesh)
    }
}

/// The parts of a mesh.
pub(super) struct Parts(pub(super) Vec<Part>);

impl Parts {
    pub(super) fn new(starts: Vec<Mesh>, field: &Field) -> Self {
        Self(starts.into_iter().map(|mesh| Part::new(mesh, field)).collect())
    }

    /// Cuts the worst part until none is worse than `limit`, there are `most` parts, or nothing helps.
    pub(super) fn cut(&mut self, field: &Field, limit: f64, most: usize) {
        let parts = &mut self.0;
        let mut stuck = vec![false; parts.len()];
        while parts.len() < most {
            let candidates = (0..parts.len()).filter(|part| !stuck[*part] && parts[*part].excess.most > limit);
            let worse = |a: &usize, b: &usize| parts[*a].excess.most.total_cmp(&parts[*b].excess.most).then(b.cmp(a));
            let Some(worst) = candidates.max_by(worse) else { return };
            let Some([behind, front]) = parts[worst].halves(field) else {
                stuck[worst] = true;
                continue;
            };
            parts[worst] = behind;
            parts.push(front);
            stuck.push(false);
        }
    }
}

/// What a cut leaves, by which planes are compared.
fn cost(part: &Part, plane: &Plane, field: &Field, care: Care) -> Option<f64> {
    let points = part.sketch().points_beside(plane);
    if points.iter().any(|side| side.len() < 3) {
        return None;
    }
    let thin = |side: &Vec<DVec3>| {
        let far = side.iter().map(|point| (plane.normal.dot(*point) - plane.offset).abs()).fold(0.0, f64::max);
        far > FLAT && far < THIN
    };
    if points.iter().any(thin) {
        return None;
    }
    let [a, b] = points.map(|side| {
        let (hull, excess) = look(&side, field, care);
        (excess.most, hull.map_or(0.0, |hull| hull.volume()))
    });
    let (whole, volume) = (part.excess.most, part.hull.as_ref()?.volume());
    let most = a.0.max(b.0) / whole;
    let mean = (a.0 * a.1 + b.0 * b.1) / (whole * volume);
    let uneven = (a.1 - b.1).abs() / volume;
    Some(most + mean + UNEVEN * uneven)
}

/// The plane to cut a part by; `None` if no plane parts it.
fn best_plane(part: &Part, field: &Field) -> Option<Plane> {
    let (planes, step) = candidates(part, field);
    let ranked = |planes: &[Plane], care: Care| -> Vec<(f64, Plane)> {
        let costs: Vec<Option<f64>> = planes.par_iter().map(|plane| cost(part, plane, field, care)).collect();
        let mut each: Vec<(f64, Plane)> =
            planes.iter().zip(costs).filter_map(|(plane, cost)| Some((cost?, *plane))).collect();
        each.sort_by(|a, b| a.0.total_cmp(&b.0));
        each
    };
    let promising: Vec<Plane> = ranked(&planes, ROUGH).into_iter().take(CLOSELY).map(|(_, plane)| plane).collect();
    let (mut least, mut best) = *ranked(&promising, FINE).first()?;
    for step in [0.5, 0.25].map(|share| share * step) {
        let moved = [-step, step].map(|by| Plane { offset: best.offset + by, ..best });
        if let Some((cost, plane)) = ranked(&moved, FINE).first()
            && *cost < least
        {
            (least, best) = (*cost, *plane);
        }
    }
    Some(best)
}

/// Planes that may part it well, and how far those across an axis are apart.
fn candidates(part: &Part, field: &Field) -> (Vec<Plane>, f64) {
    let mut planes = Vec::new();
    let mut widest = 0.0_f64;
    let own = principal_axes(part.sketch());
    let same = |axis: &DVec3| DVec3::AXES.iter().any(|other| other.dot(*axis).abs() > 0.995);
    for axis in DVec3::AXES.into_iter().chain(own.into_iter().filter(|axis| !same(axis))) {
        let along = part.sketch().vertices.iter().map(|vertex| axis.dot(*vertex));
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        let step = (high - low) / (ACROSS + 1) as f64;
        widest = widest.max(step);
        planes.extend((1..=ACROSS).map(|at| Plane { normal: axis, offset: low + at as f64 * step }));
    }
    planes.extend(face_planes(part.sketch(), field));
    let nearest = field.nearest(part.excess.place);
    let (right, up) = part.excess.normal.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_pair();
    for at in 0..AROUND {
        let (sin, cos) = (PI * at as f64 / AROUND as f64).sin_cos();
        planes.extend(Plane::through(nearest, cos * right + sin * up));
    }
    (planes, widest)
}

/// The planes of the largest faces that others are on both sides of, or that are walls without a solid behind them.
fn face_planes(mesh: &Mesh, field: &Field) -> Vec<Plane> {
    let mut areas: BTreeMap<[i32; 4], (f64, Plane, DVec3)> = BTreeMap::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = mesh.corners(*triangle);
        let double = (b - a).cross(c - a);
        let Some(normal) = double.try_normalize() else { continue };
        // Either way round it is the same plane.
        let first = normal.to_array().into_iter().find(|value| value.abs() > 1e-3).unwrap_or(1.0);
        let normal = normal * first.signum();
        let plane = Plane { normal, offset: normal.dot(a) };
        let [x, y, z] = (normal * 40.0).round().to_array().map(|value| value as i32);
        let entry =
            areas.entry([x, y, z, (plane.offset * 400.0).round() as i32]).or_insert((0.0, plane, (a + b + c) / 3.0));
        entry.0 += double.length();
    }
    let mut planes: Vec<(f64, Plane, DVec3)> = areas.into_values().collect();
    planes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let useful = |(_, plane, middle): (f64, Plane, DVec3)| {
        let beside =
            |side: f64| mesh.vertices.iter().any(|vertex| (plane.normal.dot(*vertex) - plane.offset) * side > 1e-3);
        match [beside(-1.0), beside(1.0)] {
            [true, true] => Some(plane),
            [false, false] => None,
            [_, front] => {
                let inwards = if front { 1.0 } else { -1.0 };
                let behind = middle + inwards * field.clear_of_surface() * plane.normal;
                let wall = !field.is_inside(behind);
                wall.then_some(Plane { offset: plane.offset + inwards * BEHIND, ..plane })
            }
        }
    };
    planes.into_iter().take(4 * FACES).filter_map(useful).take(FACES).collect()
}

/// The principal axes of a surface.
fn principal_axes(mesh: &Mesh) -> [DVec3; 3] {
    let (mut area, mut center, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    for triangle in &mesh.triangles {
        let [a, b, c] = mesh.corners(*triangle);
        let (weight, middle) = ((b - a).cross(c - a).length(), (a + b + c) / 3.0);
        area += weight;
        center += weight * middle;
        let outer = |v: DVec3| DMat3::from_cols(v * v.x, v * v.y, v * v.z);
        second += (outer(middle) * 9.0 + outer(a) + outer(b) + outer(c)) * (weight / 12.0);
    }
    let center = center / area.max(1e-30);
    let outer = DMat3::from_cols(center * center.x, center * center.y, center * center.z);
    eigenvectors(second * (1.0 / area.max(1e-30)) + outer * -1.0)
}

/// Of a symmetric matrix, by Jacobi rotations.
fn eigenvectors(mut matrix: DMat3) -> [DVec3; 3] {
    let mut vectors = DMat3::IDENTITY;
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = matrix.col(q)[p];
            if off.abs() < 1e-15 {
                continue;
            }
            let angle = 0.5 * (2.0 * off).atan2(matrix.col(q)[q] - matrix.col(p)[p]);
            let (sin, cos) = angle.sin_cos();
            let mut turn = DMat3::IDENTITY;
            turn.col_mut(p)[p] = cos;
            turn.col_mut(q)[q] = cos;
            turn.col_mut(q)[p] = sin;
            turn.col_mut(p)[q] = -sin;
            matrix = turn.transpose() * matrix * turn;
            vectors *= turn;
        }
    }
    [vectors.x_axis, vectors.y_axis, vectors.z_axis]
}
