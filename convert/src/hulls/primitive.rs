//! Boxes, spheres and capsules in place of hulls that they are as near to.

use std::f64::consts::{PI, TAU};

use aam::document::Primitive;
use glam::{DMat3, DQuat, DVec3};

use super::quickhull::{Polyhedron, hull};

/// A simple shape is as near as its hull if neither misses the surface by more than this part of the diagonal.
pub(super) const NEGLIGIBLE: f64 = 1e-3;
/// A simple shape is tried if it misses its hull by no more than this many times what the hull misses the surface.
const NEARLY: f64 = 1.5;
/// A capsule or sphere is compared as a polyhedron of so many points around and half as many along.
const AROUND: usize = 24;

/// A simple shape, of a mesh scaled to a unit box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Simple(Primitive);

impl Simple {
    /// A simple shape that misses a hull by about `allowed` both ways, the cheapest first: sphere, capsule, box. Whether it
    /// is as near to the surface as the hull is for a measurement to say, since the surface may lie between the two.
    pub(super) fn fitting(piece: &Polyhedron, allowed: f64) -> Option<Self> {
        let allowed = NEARLY * allowed.max(NEGLIGIBLE);
        let [through_corners, between] = spheres(piece);
        [through_corners, between, capsule(piece), cuboid(piece)].into_iter().flatten().map(Self).find(|simple| {
            let Some(shape) = simple.polyhedron() else { return false };
            excess(&shape, piece) <= allowed && excess(piece, &shape) <= allowed
        })
    }

    /// The shape as a polyhedron, finer than hulls are.
    pub(super) fn polyhedron(self) -> Option<Polyhedron> {
        hull(&surface(&self.0), usize::MAX / 8)
    }

    /// The shape in the mesh's own scale and place.
    pub(super) fn placed(self, scale: f64, center: DVec3) -> Primitive {
        let point = |value: [f32; 3]| (DVec3::from(value.map(f64::from)) * scale + center).as_vec3().to_array();
        let length = |value: f32| (f64::from(value) * scale) as f32;
        match self.0 {
            Primitive::Box { center, orientation, half } => {
                Primitive::Box { center: point(center), orientation, half: half.map(length) }
            }
            Primitive::Sphere { center, radius } => Primitive::Sphere { center: point(center), radius: length(radius) },
            Primitive::Capsule { a, b, radius } => {
                Primitive::Capsule { a: point(a), b: point(b), radius: length(radius) }
            }
        }
    }
}

/// How far one convex shape is outside of another: its farthest vertex, which is the farthest point as a distance to a
/// convex shape is convex. Heights above planes stand for distances, which they equal but beside edges.
fn excess(of: &Polyhedron, from: &Polyhedron) -> f64 {
    let planes = from.planes();
    let height = |point: &DVec3| planes.iter().map(|(normal, offset)| normal.dot(*point) - offset).fold(0.0, f64::max);
    of.vertices.iter().map(height).fold(0.0, f64::max)
}

/// Around the middle of the bounds: through the farthest corner, as a ball of few faces asks for, and halfway to the
/// nearest face.
fn spheres(piece: &Polyhedron) -> [Option<Primitive>; 2] {
    let (low, high) = piece.bounds();
    let center = 0.5 * (low + high);
    let far = piece.vertices.iter().map(|vertex| vertex.distance(center)).fold(0.0, f64::max);
    let near = piece.planes().iter().map(|(normal, offset)| offset - normal.dot(center)).fold(f64::INFINITY, f64::min);
    [far, 0.5 * (far + near)].map(|radius| round(center, center, radius))
}

/// Along the longest axis of the best box, with the mean of the other two as its thickness.
fn capsule(piece: &Polyhedron) -> Option<Primitive> {
    let (frame, half, center) = smallest_box(piece)?;
    let longest = (0..3).max_by(|a, b| half[*a].total_cmp(&half[*b]))?;
    let [first, second] = [(longest + 1) % 3, (longest + 2) % 3];
    let radius = 0.5 * (half[first] + half[second]);
    let reach = (half[longest] - radius).max(0.0);
    let along = frame.col(longest) * reach;
    round(center - along, center + along, radius)
}

fn round(a: DVec3, b: DVec3, radius: f64) -> Option<Primitive> {
    let single = |point: DVec3| point.as_vec3().to_array();
    let radius = radius as f32;
    if !(radius.is_finite() && radius > 0.0) {
        return None;
    }
    Some(match a == b {
        true => Primitive::Sphere { center: single(a), radius },
        false => Primitive::Capsule { a: single(a), b: single(b), radius },
    })
}

fn cuboid(piece: &Polyhedron) -> Option<Primitive> {
    let (frame, half, center) = smallest_box(piece)?;
    Some(Primitive::Box {
        center: center.as_vec3().to_array(),
        orientation: DQuat::from_mat3(&frame).normalize().as_quat().to_array(),
        half: half.as_vec3().to_array(),
    })
}

/// Axes, half extents and centre of the smallest box with a side along a face and another along an edge of it.
fn smallest_box(piece: &Polyhedron) -> Option<(DMat3, DVec3, DVec3)> {
    let mut best: Option<(f64, (DMat3, DVec3, DVec3))> = None;
    for triangle in &piece.triangles {
        let [a, b, c] = piece.corners(*triangle);
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
        for edge in [b - a, c - b, a - c] {
            let Some(along) = edge.reject_from_normalized(normal).try_normalize() else { continue };
            let frame = DMat3::from_cols(along, normal.cross(along), normal);
            let turned = piece.vertices.iter().map(|vertex| frame.transpose() * *vertex);
            let (low, high) =
                turned.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
            let volume = (high - low).element_product();
            if best.as_ref().is_none_or(|(least, _)| volume < *least) {
                best = Some((volume, (frame, 0.5 * (high - low), frame * (0.5 * (low + high)))));
            }
        }
    }
    best.map(|(_, found)| found)
}

/// Points whose hull is a simple shape, about.
fn surface(primitive: &Primitive) -> Vec<DVec3> {
    let point = |value: [f32; 3]| DVec3::from(value.map(f64::from));
    match *primitive {
        Primitive::Box { center, orientation, half } => {
            let turn = DQuat::from_array(orientation.map(f64::from));
            let corner = |at: usize| DVec3::from(std::array::from_fn(|i| if at >> i & 1 == 0 { -1.0 } else { 1.0 }));
            (0..8).map(|at| point(center) + turn * (corner(at) * point(half))).collect()
        }
        Primitive::Sphere { center, radius } => ball(point(center), DVec3::Z, f64::from(radius), 0.0),
        Primitive::Capsule { a, b, radius } => {
            let (a, b) = (point(a), point(b));
            let along = (b - a).normalize_or(DVec3::Z);
            ball(0.5 * (a + b), along, f64::from(radius), 0.5 * a.distance(b))
        }
    }
}

/// A sphere whose halves are moved apart along an axis.
fn ball(center: DVec3, axis: DVec3, radius: f64, apart: f64) -> Vec<DVec3> {
    let (right, up) = axis.any_orthonormal_pair();
    let rows = AROUND / 2;
    let mut points = vec![center + axis * (radius + apart), center - axis * (radius + apart)];
    for row in 1..rows {
        let (ring, height) = (PI * row as f64 / rows as f64).sin_cos();
        // The equator belongs to both halves.
        let halves: &[f64] = if 2 * row == rows { &[-1.0, 1.0] } else { &[1.0] };
        for half in halves {
            let side = if height.abs() < 1e-9 { *half } else { height.signum() };
            let middle = center + axis * (radius * height + side * apart);
            points.extend((0..AROUND).map(|at| {
                let (sin, cos) = (TAU * at as f64 / AROUND as f64).sin_cos();
                middle + radius * ring * (cos * right + sin * up)
            }));
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(primitive: Primitive, allowed: f64) -> Option<Primitive> {
        Simple::fitting(&hull(&surface(&primitive), 255)?, allowed).map(|simple| simple.placed(1.0, DVec3::ZERO))
    }

    #[test]
    fn each_shape_finds_itself() {
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 0.5, 0.7);
        let orientation = turn.as_quat().to_array();
        let Some(Primitive::Box { half, center, .. }) =
            of(Primitive::Box { center: [1.0, 2.0, 3.0], orientation, half: [0.5, 1.0, 2.0] }, 1e-3)
        else {
            panic!("no box")
        };
        let mut half = half;
        half.sort_by(f32::total_cmp);
        assert!(glam::Vec3::from(half).abs_diff_eq(glam::Vec3::new(0.5, 1.0, 2.0), 1e-5), "{half:?}");
        assert!(glam::Vec3::from(center).abs_diff_eq(glam::Vec3::new(1.0, 2.0, 3.0), 1e-5));
        let ball = Primitive::Sphere { center: [1.0, 0.0, 0.0], radius: 0.5 };
        assert!(matches!(of(ball, 0.02), Some(Primitive::Sphere { radius, .. }) if (radius - 0.5).abs() < 0.02));
        let pill = Primitive::Capsule { a: [0.0; 3], b: [0.0, 2.0, 1.0], radius: 0.4 };
        let Some(Primitive::Capsule { a, b, radius }) = of(pill, 0.02) else { panic!("no capsule") };
        let length = glam::Vec3::from(a).distance(b.into());
        assert!((radius - 0.4).abs() < 0.02 && (length - 5.0_f32.sqrt()).abs() < 0.05, "{radius} {length}");
    }

    #[test]
    fn what_is_none_of_them_stays_a_hull() {
        let wedge =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
        assert_eq!(Simple::fitting(&hull(&wedge.map(DVec3::from), 64).unwrap(), 0.05), None);
        let brick = Primitive::Box { center: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0], half: [1.0, 1.0, 1.2] };
        assert!(matches!(of(brick, 0.02), Some(Primitive::Box { .. })));
    }
}
