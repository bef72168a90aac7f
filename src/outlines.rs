//! The edges of collision shapes, for the window.

use aam::Document;
use aam::document::{Body, Primitive};
use glam::Vec3;

/// The edges of a document's collision shapes: object (as position in frame 0) and lines in its coordinates.
pub(crate) fn of(document: &Document) -> Vec<(usize, Vec<[Vec3; 2]>)> {
    let bodies = document.physics.iter().flat_map(|physics| &physics.bodies);
    bodies
        .filter_map(|body| {
            let object = document.objects().iter().position(|object| object.id == body.object)?;
            Some(body_outlines(body).map(move |segments| (object, segments)))
        })
        .flatten()
        .collect()
}

fn body_outlines(body: &Body) -> impl Iterator<Item = Vec<[Vec3; 2]>> {
    let pieces = body.pieces.iter().flatten().map(|piece| {
        let point = |index: u32| piece.vertices.get(index as usize).copied().map(Vec3::from_array);
        let mut edges: Vec<[u32; 2]> = piece
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        edges.into_iter().filter_map(|[a, b]| Some([point(a)?, point(b)?])).collect()
    });
    pieces.chain(body.primitives.iter().flatten().map(primitive_outline))
}

fn primitive_outline(primitive: &Primitive) -> Vec<[Vec3; 2]> {
    match *primitive {
        Primitive::Box { center, orientation, half } => {
            let turn = glam::Quat::from_array(orientation);
            let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { glam::Quat::IDENTITY };
            let corner = |bits: u8| {
                let sign = |bit: u8| if bits & bit == 0 { -1.0 } else { 1.0 };
                Vec3::from_array(center) + turn * (Vec3::from_array(half) * Vec3::new(sign(1), sign(2), sign(4)))
            };
            let edges = (0..8_u8).flat_map(|bits| [1, 2, 4].map(|bit| (bits, bit)));
            edges.filter(|(bits, bit)| bits & bit == 0).map(|(bits, bit)| [corner(bits), corner(bits | bit)]).collect()
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
        assert!(cube.iter().flatten().all(|p| p.abs() == Vec3::new(1.0, 2.0, 3.0)));
        let (a, b) = (Vec3::ZERO, Vec3::new(0.0, 0.0, 2.0));
        let pill = outline(Primitive::Capsule { a: a.into(), b: b.into(), radius: 0.5 });
        let distance = |p: &Vec3| p.distance(Vec3::new(0.0, 0.0, p.z.clamp(0.0, 2.0)));
        assert!(pill.iter().flatten().all(|p| (distance(p) - 0.5).abs() < 1e-5));
    }
}
