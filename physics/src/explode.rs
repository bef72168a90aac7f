//! A look at collision shapes: the hulls of bodies moved apart, each in its own colour.

use std::f32::consts::{PI, TAU};

use aam::Document;
use aam::document::{Body, Faces, Frame, Material, MaterialBody, Object, Primitive, Rgb, SingleMaterial, Triangle};
use aam::meaning::{Hierarchy, world_transforms};
use glam::{Affine3A, Quat, Vec3};

/// Positions and triangles.
type Shape = (Vec<Vec3>, Vec<[u32; 3]>);

/// The hulls and simple shapes of a document's bodies as objects of their own, in world coordinates at the first frame.
/// Each is moved away from the centre of its body's shapes, by `amount` times its distance from there: 0 leaves all in
/// place. `None` if no body has any.
pub fn exploded(document: &Document, amount: f32) -> Option<Document> {
    let hierarchy = Hierarchy::of(document.objects());
    let poses = world_transforms(document, &hierarchy, 0.0);
    let mut found = Document::default();
    let mut frame = Frame::default();
    for body in document.physics.iter().flat_map(|physics| &physics.bodies) {
        let Some(place) = document.objects().iter().position(|object| object.id == body.object) else { continue };
        let mut shapes = shapes(body, &poses[place]);
        let all = shapes.iter().flat_map(|shape| &shape.0);
        let (low, high) =
            all.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), at| (low.min(*at), high.max(*at)));
        for (vertices, triangles) in shapes.drain(..) {
            let middle = vertices.iter().sum::<Vec3>() / vertices.len() as f32;
            let aside = amount * (middle - 0.5 * (low + high));
            let number = frame.objects.len();
            found.materials.push(material(number));
            frame.objects.push(Object {
                id: number as i32,
                name: format!("{} {number}", body.name.decoded()).into(),
                parent: -1,
                material: number as i32,
                vertices: vertices.iter().map(|vertex| (*vertex + aside).to_array()).collect(),
                faces: Some(Faces {
                    triangles: triangles.into_iter().map(|vertices| Triangle { vertices, smoothing: 0 }).collect(),
                    ..Faces::default()
                }),
                ..Object::default()
            });
        }
    }
    if frame.objects.is_empty() {
        return None;
    }
    found.geometry.frames = vec![frame];
    Some(found)
}

/// Turns of the hue by the golden ratio keep neighbours apart, however many there are.
fn material(number: usize) -> Material {
    let hue = (number as f32 * 0.618_034).fract();
    let value = if number.is_multiple_of(2) { 0.9 } else { 0.65 };
    let channel = |turn: f32| value * (0.3 + 0.7 * (((hue + turn).fract() * 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0));
    let color: Rgb = [channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0)];
    let body = SingleMaterial { class: "Standard".into(), ambient: color, diffuse: color, ..SingleMaterial::default() };
    Material {
        number: number as i32,
        name: format!("hull {number}").into(),
        body: MaterialBody::Single(Box::new(body)),
        unknown: Vec::new(),
    }
}

fn shapes(body: &Body, pose: &Affine3A) -> Vec<Shape> {
    let placed = |(vertices, triangles): Shape| -> Shape {
        (vertices.into_iter().map(|vertex| pose.transform_point3(vertex)).collect(), triangles)
    };
    let simple = body.primitives.iter().flatten().map(primitive);
    let pieces = body.pieces.iter().flatten().map(|piece| {
        let count = piece.vertices.len();
        let whole = |triangle: &&[u32; 3]| triangle.iter().all(|index| (*index as usize) < count);
        let triangles = piece.triangles.iter().filter(whole).copied().collect();
        (piece.vertices.iter().map(|vertex| Vec3::from(*vertex)).collect(), triangles)
    });
    let finite =
        |(vertices, triangles): &Shape| !triangles.is_empty() && vertices.iter().all(|vertex| vertex.is_finite());
    simple.chain(pieces).filter(finite).map(placed).collect()
}

/// A simple shape as triangles.
fn primitive(primitive: &Primitive) -> Shape {
    match *primitive {
        Primitive::Box { center, orientation, half } => {
            let turn = Quat::from_array(orientation);
            // As for `Piv`, all zero means identity.
            let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { Quat::IDENTITY };
            let sign = |at: usize, bit: usize| if at & bit == 0 { -1.0 } else { 1.0 };
            let corner = |at: usize| Vec3::new(sign(at, 1), sign(at, 2), sign(at, 4)) * Vec3::from(half);
            let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
            let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
            ((0..8).map(|at| Vec3::from(center) + turn * corner(at)).collect(), triangles)
        }
        Primitive::Sphere { center, radius } => capsule(center.into(), center.into(), radius),
        Primitive::Capsule { a, b, radius } => capsule(a.into(), b.into(), radius),
    }
}

/// A sphere whose halves are at two points.
fn capsule(a: Vec3, b: Vec3, radius: f32) -> Shape {
    const AROUND: u32 = 32;
    const ROWS: u32 = 8;
    let axis = (b - a).normalize_or(Vec3::Z);
    let (right, up) = axis.any_orthonormal_pair();
    let mut vertices = Vec::new();
    // From the pole beyond a to the one beyond b; the equator belongs to both halves.
    for row in 0..2 * (ROWS + 1) {
        let (middle, turn) = if row <= ROWS { (a, row) } else { (b, row - 1) };
        let (ring, height) = (0.5 * PI * turn as f32 / ROWS as f32).sin_cos();
        vertices.extend((0..AROUND).map(|at| {
            let (sin, cos) = (TAU * at as f32 / AROUND as f32).sin_cos();
            middle + radius * (ring * (cos * right + sin * up) - height * axis)
        }));
    }
    let mut triangles = Vec::new();
    for row in 0..2 * ROWS + 1 {
        for at in 0..AROUND {
            let (below, next) = (row * AROUND, (at + 1) % AROUND);
            let above = below + AROUND;
            triangles.extend([[below + at, below + next, above + next], [below + at, above + next, above + at]]);
        }
    }
    (vertices, triangles)
}

#[cfg(test)]
mod tests {
    use aam::document::{BodyMode, Convex, Physics};

    use super::*;

    fn document(primitives: Option<Vec<Primitive>>, pieces: Option<Vec<Convex>>) -> Document {
        let mut document = Document::default();
        document.geometry.frames =
            vec![Frame { objects: vec![Object { id: 7, parent: -1, ..Object::default() }], ..Frame::default() }];
        let body = Body {
            object: 7,
            name: "body".into(),
            mode: BodyMode::Dynamic,
            static_friction: 0.5,
            dynamic_friction: 0.5,
            restitution: 0.0,
            mass: None,
            primitives,
            pieces,
            unknown: Vec::new(),
        };
        document.physics = Some(Physics { bodies: vec![body], unknown: Vec::new() });
        document
    }

    fn tetrahedron(x: f32) -> Convex {
        let vertices = vec![[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.0]];
        Convex { number: 0, vertices, triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]] }
    }

    #[test]
    fn hulls_move_apart_and_keep_their_shape() {
        let document = document(None, Some(vec![tetrahedron(0.0), tetrahedron(3.0)]));
        let still = exploded(&document, 0.0).unwrap();
        let apart = exploded(&document, 1.0).unwrap();
        assert_eq!((still.objects().len(), still.materials.len()), (2, 2));
        assert_eq!(still.objects()[1].vertices[0], [3.0, 0.0, 0.0]);
        let step = |document: &Document| document.objects()[1].vertices[0][0] - document.objects()[0].vertices[0][0];
        assert!((step(&apart) - 6.0).abs() < 1e-5, "{}", step(&apart));
        assert_ne!(still.materials[0], still.materials[1]);
        assert_eq!(exploded(&Document::default(), 1.0), None);
    }

    #[test]
    fn simple_shapes_are_closed_and_look_outwards() {
        let shapes = [
            Primitive::Box { center: [1.0, 2.0, 3.0], orientation: [0.0; 4], half: [0.5, 1.0, 1.5] },
            Primitive::Sphere { center: [0.0; 3], radius: 1.0 },
            Primitive::Capsule { a: [0.0; 3], b: [0.0, 0.0, 2.0], radius: 1.0 },
        ];
        for (shape, volume) in shapes.iter().zip([6.0, 4.0 / 3.0 * PI, (4.0 / 3.0 + 2.0) * PI]) {
            let (vertices, triangles) = primitive(shape);
            let corners = |triangle: &[u32; 3]| triangle.map(|index| vertices[index as usize]);
            let found: f32 = triangles.iter().map(corners).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
            assert!((found / volume - 1.0).abs() < 0.03, "{shape:?}: {found}");
        }
        let document = document(Some(shapes.to_vec()), None);
        assert_eq!(exploded(&document, 0.5).unwrap().objects().len(), 3);
    }
}
