//! What is drawn over the picture of bodies: parts of collision shapes, contacts, sleep, the hand.

use std::collections::BTreeMap;
use std::sync::Arc;

use aam_physics::Contact;
use aam_renderer::{Shape, ShapeKind, ShapeVertex};
use aam_scene::{NodeId, Scene};
use glam::{Affine3A, Vec3};

use crate::Outline;
use crate::pose::lines;

/// Colours of parts, repeated: easy to tell from each other and from most surfaces.
const PALETTE: [[f32; 4]; 6] = [
    [0.98, 0.45, 0.35, 1.0],
    [0.45, 0.85, 0.45, 1.0],
    [0.98, 0.80, 0.30, 1.0],
    [0.45, 0.75, 0.98, 1.0],
    [0.85, 0.55, 0.95, 1.0],
    [0.35, 0.90, 0.85, 1.0],
];
const CONTACT: [f32; 4] = [1.0, 0.25, 0.85, 1.0];
const AWAKE: [f32; 4] = [1.0, 0.62, 0.15, 1.0];
const ASLEEP: [f32; 4] = [0.40, 0.62, 0.95, 1.0];
const HAND: [f32; 4] = [1.0, 1.0, 1.0, 1.0];
/// Marks are so large, as parts of the scene's diagonal.
const POINT: f32 = 0.006;
const NORMAL: f32 = 0.04;

/// Parts of collision shapes in the world, `explode` times as far from the middle of their object as they are, and more.
/// Where they stand apart they are solid, else only their edges.
pub(crate) fn outlines(outlines: &[Outline], world: &[Affine3A], explode: f32) -> Vec<Arc<Shape>> {
    let mut middles: BTreeMap<NodeId, (Vec3, f32)> = BTreeMap::new();
    for outline in outlines {
        let (sum, count) = middles.entry(outline.node).or_default();
        *sum += middle(outline);
        *count += 1.0;
    }
    let (mut edges, mut faces) = (Vec::new(), Vec::new());
    for (index, outline) in outlines.iter().enumerate() {
        let Some(transform) = world.get(outline.node.index()) else { continue };
        let (sum, count) = middles.get(&outline.node).copied().unwrap_or((Vec3::ZERO, 1.0));
        let apart = (middle(outline) - sum / count) * explode;
        let at = |point: &Vec3| transform.transform_point3(*point + apart);
        let color = PALETTE[index % PALETTE.len()];
        let solid = explode > 0.0 && !outline.triangles.is_empty();
        if solid {
            for triangle in &outline.triangles {
                let [a, b, c] = [0, 1, 2].map(|corner| at(&triangle[corner]));
                let normal = (b - a).cross(c - a).normalize_or_zero();
                // Lit from one side, for the shape to be seen.
                let light = 0.62 + 0.38 * normal.dot(Vec3::new(0.4, -0.6, 0.7).normalize());
                let color = [color[0] * light, color[1] * light, color[2] * light, 1.0];
                faces.extend([a, b, c].map(|position| ShapeVertex { position, color }));
            }
        }
        let dark = if solid { 0.35 } else { 1.0 };
        let color = [color[0] * dark, color[1] * dark, color[2] * dark, 1.0];
        edges.extend(outline.segments.iter().flatten().map(|point| ShapeVertex { position: at(point), color }));
    }
    let faces =
        (!faces.is_empty()).then(|| Arc::new(Shape { vertices: faces, kind: ShapeKind::Triangles, depth_test: true }));
    faces.into_iter().chain(lines(edges)).collect()
}

/// The mean of the ends of a part's edges, in the object's coordinates.
fn middle(outline: &Outline) -> Vec3 {
    let points = outline.segments.as_flattened();
    points.iter().sum::<Vec3>() / points.len().max(1) as f32
}

/// A point with its direction for each contact, seen through everything.
pub(crate) fn contacts(contacts: &[Contact], size: f32) -> Vec<Arc<Shape>> {
    let (mut points, mut normals) = (Vec::new(), Vec::new());
    for contact in contacts {
        let corner = |axis: usize, sign: f32| {
            let mut corner = contact.point;
            corner[axis] += sign * POINT * size;
            ShapeVertex { position: corner, color: CONTACT }
        };
        for signs in 0..8_u8 {
            let sign = |bit: u8| if signs & bit == 0 { -1.0 } else { 1.0 };
            points.extend([corner(0, sign(1)), corner(1, sign(2)), corner(2, sign(4))]);
        }
        let end = contact.point + contact.normal * NORMAL * size;
        normals.extend([contact.point, end].map(|position| ShapeVertex { position, color: CONTACT }));
    }
    let through = |vertices: Vec<ShapeVertex>, kind| {
        (!vertices.is_empty()).then(|| Arc::new(Shape { vertices, kind, depth_test: false }))
    };
    through(points, ShapeKind::Triangles).into_iter().chain(through(normals, ShapeKind::Lines)).collect()
}

/// The box of each dynamic body: orange awake, blue asleep.
pub(crate) fn sleeping(
    scene: &Scene,
    world: &[Affine3A],
    bodies: impl Iterator<Item = (NodeId, bool)>,
) -> Option<Arc<Shape>> {
    let mut vertices = Vec::new();
    for (id, asleep) in bodies {
        let mesh = scene.nodes.get(id.index()).and_then(|node| node.mesh);
        let Some(bounds) = mesh.and_then(|mesh| scene.meshes.get(mesh.index())).map(|mesh| mesh.bounds) else {
            continue;
        };
        let Some(transform) = world.get(id.index()) else { continue };
        let color = if asleep { ASLEEP } else { AWAKE };
        let corner = |bits: usize| {
            let pick = |axis: usize| if bits >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
            let position = transform.transform_point3(Vec3::new(pick(0), pick(1), pick(2)));
            ShapeVertex { position, color }
        };
        for bits in 0..8 {
            let free = [1, 2, 4].into_iter().filter(|bit| bits & bit == 0);
            vertices.extend(free.flat_map(|bit| [corner(bits), corner(bits | bit)]));
        }
    }
    lines(vertices)
}

/// From the held point to the hand.
pub(crate) fn hand([point, hand]: [Vec3; 2], size: f32) -> Option<Arc<Shape>> {
    let tick = Vec3::splat(POINT * size);
    let ends = [point, hand, hand - tick, hand + tick, hand - tick.with_x(-tick.x), hand + tick.with_x(-tick.x)];
    let vertices = ends.map(|position| ShapeVertex { position, color: HAND }).to_vec();
    Some(Arc::new(Shape { vertices, kind: ShapeKind::Lines, depth_test: false }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outlines_stand_where_their_object_does_and_apart() {
        let part = |x: f32| Outline {
            node: NodeId(1),
            segments: vec![[Vec3::X * x, Vec3::X * (x + 2.0)]],
            triangles: vec![[Vec3::X * x, Vec3::X * (x + 2.0), Vec3::new(x, 1.0, 0.0)]],
        };
        let parts = [part(-2.0), part(0.0)];
        let world = [Affine3A::IDENTITY, Affine3A::from_translation(Vec3::Z)];
        let together = outlines(&parts, &world, 0.0);
        assert_eq!(together.len(), 1, "only edges");
        assert_eq!(together[0].vertices[3].position, Vec3::new(2.0, 0.0, 1.0));
        let apart = outlines(&parts, &world, 1.0);
        assert_eq!(apart.iter().map(|shape| shape.kind).collect::<Vec<_>>(), [ShapeKind::Triangles, ShapeKind::Lines]);
        assert_eq!(apart[1].vertices[3].position, Vec3::new(3.0, 0.0, 1.0));
        assert_eq!(apart[1].vertices[0].position, Vec3::new(-3.0, 0.0, 1.0));
        assert!(outlines(&[], &[], 1.0).is_empty());
    }

    #[test]
    fn marks_are_made_for_what_there_is() {
        let contact = Contact { bodies: [NodeId(0), NodeId(1)], point: Vec3::X, normal: Vec3::Z, force: 1.0 };
        let shapes = contacts(&[contact], 10.0);
        assert_eq!(shapes[0].vertices.len(), 24);
        assert!(shapes[1].vertices[1].position.distance(Vec3::new(1.0, 0.0, 0.4)) < 1e-6);
        assert!(contacts(&[], 1.0).is_empty());
        assert!(sleeping(&Scene::default(), &[], [(NodeId(3), true)].into_iter()).is_none());
    }
}
