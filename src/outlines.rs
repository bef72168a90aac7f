//! The edges and faces of collision shapes, for the window.

use aam::Document;
use aam::document::{Body, Convex, Primitive};
use glam::Vec3;

/// One part of a collision shape.
pub(crate) struct Part {
    /// The object, as its position in frame 0.
    pub(crate) object: usize,
    /// Edges in its coordinates.
    pub(crate) segments: Vec<[Vec3; 2]>,
    /// Faces likewise, counter-clockwise seen from outside; none of what is round.
    pub(crate) triangles: Vec<[Vec3; 3]>,
}

/// The parts of a document's collision shapes.
pub(crate) fn of(document: &Document) -> Vec<Part> {
    let bodies = document.physics.iter().flat_map(|physics| &physics.bodies);
    bodies
        .filter_map(|body| {
            let object = document.objects().iter().position(|object| object.id == body.object)?;
            Some(parts(body).map(move |(segments, triangles)| Part { object, segments, triangles }))
        })
        .flatten()
        .collect()
}

/// Edges and faces.
type Drawn = (Vec<[Vec3; 2]>, Vec<[Vec3; 3]>);

fn parts(body: &Body) -> impl Iterator<Item = Drawn> {
    let primitives = body.primitives.iter().flatten();
    let primitives = primitives.map(|primitive| (primitive_outline(primitive), primitive_faces(primitive)));
    body.pieces.iter().flatten().map(piece).chain(primitives)
}

fn piece(piece: &Convex) -> Drawn {
    let point = |index: u32| piece.vertices.get(index as usize).copied().map(Vec3::from_array);
    let mut edges: Vec<[u32; 2]> = piece
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let edges = edges.into_iter().filter_map(|[a, b]| Some([point(a)?, point(b)?])).collect();
    let faces = piece.triangles.iter().filter_map(|&[a, b, c]| Some([point(a)?, point(b)?, point(c)?])).collect();
    (edges, faces)
}

/// Twelve triangles for a box.
fn primitive_faces(primitive: &Primitive) -> Vec<[Vec3; 3]> {
    let Primitive::Box { .. } = primitive else { return Vec::new() };
    let corners = box_corners(primitive);
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|side| side.map(|at| corners[at])).collect()
}

/// The corners of a box: bit 0 of their number is its x axis, and so on.
fn box_corners(primitive: &Primitive) -> [Vec3; 8] {
    let Primitive::Box { center, orientation, half } = *primitive else { return [Vec3::ZERO; 8] };
    let turn = glam::Quat::from_array(orientation);
    let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { glam::Quat::IDENTITY };
    std::array::from_fn(|bits| {
        let sign = |axis: usize| if bits >> axis & 1 == 0 { -1.0 } else { 1.0 };
        Vec3::from_array(center) + turn * (Vec3::from_array(half) * Vec3::new(sign(0), sign(1), sign(2)))
    })
}

fn primitive_outline(primitive: &Primitive) -> Vec<[Vec3; 2]> {
    match *primitive {
        Primitive::Box { .. } => {
            let corners = box_corners(primitive);
            let edges = (0..8_usize).flat_map(|bits| [1, 2, 4].map(|bit| (bits, bit)));
            edges
                .filter(|(bits, bit)| bits & bit == 0)
                .map(|(bits, bit)| [corners[bits], corners[bits | bit]])
                .collect()
        }
        Primitive::Sphere { center, radius } => {
            let axes = [(Vec3::X, Vec3::Y), (Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::X)];
            axes.into_iter().flat_map(|(a, b)| arc(center.into(), radius * a, radius * b, 1.0)).collect()
        }
        Primitive::Capsule { a, b, radius } => {
            let (a, b) = (Vec3::from_array(a), Vec3::from_array(b));
            let along = (b - a).normalize_or(Vec3::Z);
            let (side, other) = along.any_orthonormal_pair();
            let (side, other, along) = (radius * side, radius * other, radius * along);
            let mut lines = Vec::new();
            for (end, out) in [(a, -along), (b, along)] {
                lines.extend(arc(end, side, other, 1.0));
                lines.extend(arc(end, side, out, 0.5));
                lines.extend(arc(end, other, out, 0.5));
            }
            lines.extend([side, -side, other, -other].map(|offset| [a + offset, b + offset]));
            lines
        }
    }
}

/// Part of a circle from `center + a` through `center + b`.
fn arc(center: Vec3, a: Vec3, b: Vec3, turns: f32) -> impl Iterator<Item = [Vec3; 2]> {
    const STEPS: u16 = 48;
    let steps = (f32::from(STEPS) * turns) as u16;
    let point = move |step: u16| {
        let (sin, cos) = (f32::from(step) / f32::from(STEPS) * std::f32::consts::TAU).sin_cos();
        center + a * cos + b * sin
    };
    (0..steps).map(move |step| [point(step), point(step + 1)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outline(primitive: Primitive) -> Vec<[Vec3; 2]> {
        primitive_outline(&primitive)
    }

    #[test]
    fn outlines_lie_on_the_shapes() {
        let ball = outline(Primitive::Sphere { center: [1.0, 2.0, 3.0], radius: 2.0 });
        assert_eq!(ball.len(), 3 * 48);
        assert!(ball.iter().flatten().all(|p| (p.distance(Vec3::new(1.0, 2.0, 3.0)) - 2.0).abs() < 1e-4));
        let cube =
            outline(Primitive::Box { center: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0], half: [1.0, 2.0, 3.0] });
        assert_eq!(cube.len(), 12);
        let faces = primitive_faces(&Primitive::Box {
            center: [5.0, 0.0, 0.0],
            orientation: [0.0, 0.0, 0.0, 1.0],
            half: [1.0, 2.0, 3.0],
        });
        let volume: f32 = faces.iter().map(|[a, b, c]| a.dot(b.cross(*c)) / 6.0).sum();
        assert!((volume - 48.0).abs() < 1e-3, "closed, and seen from outside: {volume}");
        assert!(cube.iter().flatten().all(|p| p.abs() == Vec3::new(1.0, 2.0, 3.0)));
        let (a, b) = (Vec3::ZERO, Vec3::new(0.0, 0.0, 2.0));
        let pill = outline(Primitive::Capsule { a: a.into(), b: b.into(), radius: 0.5 });
        let distance = |p: &Vec3| p.distance(Vec3::new(0.0, 0.0, p.z.clamp(0.0, 2.0)));
        assert!(pill.iter().flatten().all(|p| (distance(p) - 0.5).abs() < 1e-5));
    }
}
