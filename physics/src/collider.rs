//! From collision shapes to those of the engine.

use std::collections::BTreeMap;

use aam::document::{BodyMode, Primitive};
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use rapier3d::math::Pose as EnginePose;
use rapier3d::parry::shape::{ConvexPolyhedron, TriMesh, TriMeshFlags};
use rapier3d::prelude::SharedShape;

use crate::mesh::Shape;
use crate::moments::Moments;

/// A shape after its object's stretch, around its own centre of mass.
#[derive(Clone)]
pub(crate) struct Collider {
    pub(crate) shape: SharedShape,
    /// Where the shape stands in the body's frame.
    pub(crate) place: EnginePose,
    /// The centre of mass (for triangles: of their box) in stretched coordinates: the body's origin.
    pub(crate) center: DVec3,
    /// Around the body's origin.
    pub(crate) moments: Moments,
    /// From the body's origin to the farthest point, about.
    pub(crate) radius: f32,
    /// Half of its smallest extent along the body's axes.
    pub(crate) thickness: f32,
}

/// How far axes may be from square, or lengths from equal, for a primitive to stay one.
const SQUARE: f64 = 1e-5;
/// Points that stand for a ball or for each half of a capsule once a stretch has made it another shape.
const SAMPLES: usize = 96;

/// The engine's shape of a collision shape that was stretched.
pub(crate) fn collider(shape: &Shape, mode: BodyMode, stretch: &DMat3) -> Result<Collider, &'static str> {
    match shape {
        Shape::Triangles { vertices, triangles } if mode == BodyMode::Static => surface(vertices, triangles, stretch),
        Shape::Triangles { vertices, triangles } => closed_surface(vertices, triangles, stretch),
        Shape::Compound { primitives, pieces } => {
            let mut parts = Vec::with_capacity(primitives.len() + pieces.len());
            for primitive in primitives {
                parts.push(solid(primitive, stretch)?);
            }
            for piece in pieces {
                let points: Vec<DVec3> = piece.iter().map(|point| *stretch * point.as_dvec3()).collect();
                parts.push(hull(&points)?);
            }
            compound(parts)
        }
    }
}

/// A part of a compound, where it stands in stretched coordinates.
struct Part {
    shape: SharedShape,
    place: DAffine3,
    moments: Moments,
}

fn compound(mut parts: Vec<Part>) -> Result<Collider, &'static str> {
    let whole = parts.iter().fold(Moments::ZERO, |all, part| all.plus(&part.moments));
    let center = whole.center();
    let moments = whole.transformed(&DAffine3::from_translation(-center));
    if !(moments.volume > 0.0 && moments.volume.is_finite() && center.is_finite()) {
        return Err("its shape has no volume");
    }
    let place = |part: &Part| {
        let rotation = DQuat::from_mat3(&part.place.matrix3).as_quat().normalize();
        EnginePose::from_parts((part.place.translation - center).as_vec3(), rotation)
    };
    let (shape, place) = if parts.len() == 1 {
        let part = parts.remove(0);
        let place = place(&part);
        (part.shape, place)
    } else {
        let parts = parts.iter().map(|part| (place(part), part.shape.clone())).collect();
        (SharedShape::compound(parts), EnginePose::default())
    };
    finished(Collider { shape, place, center, moments, radius: 0.0, thickness: 0.0 })
}

fn finished(collider: Collider) -> Result<Collider, &'static str> {
    let around = collider.shape.compute_aabb(&collider.place);
    let radius = around.mins.abs().max(around.maxs.abs()).length();
    if !(radius.is_finite() && radius > 0.0) {
        return Err("its shape leaves the range of numbers");
    }
    let thickness = 0.5 * (around.maxs - around.mins).min_element();
    Ok(Collider { radius, thickness, ..collider })
}

fn surface(vertices: &[Vec3], triangles: &[[u32; 3]], stretch: &DMat3) -> Result<Collider, &'static str> {
    let stretched: Vec<DVec3> = vertices.iter().map(|vertex| *stretch * vertex.as_dvec3()).collect();
    let used = || triangles.as_flattened().iter().map(|index| stretched[*index as usize]);
    let (low, high) = used().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let center = 0.5 * (low + high);
    let vertices: Vec<Vec3> = stretched.iter().map(|vertex| (*vertex - center).as_vec3()).collect();
    // A body that slides over a flat floor is not to stumble over the edges between its triangles.
    let smooth = TriMeshFlags::FIX_INTERNAL_EDGES_TWO_SIDED | TriMeshFlags::DELETE_DEGENERATE_TRIANGLES;
    let mesh = TriMesh::with_flags(vertices, triangles.to_vec(), smooth)
        .ok()
        .filter(|mesh| !mesh.indices().is_empty())
        .ok_or("all triangles of its object are degenerate")?;
    finished(Collider {
        shape: SharedShape::new(mesh),
        place: EnginePose::default(),
        center,
        moments: Moments::ZERO,
        radius: 0.0,
        thickness: 0.0,
    })
}

/// A closed surface, solid inside.
fn closed_surface(vertices: &[Vec3], triangles: &[[u32; 3]], stretch: &DMat3) -> Result<Collider, &'static str> {
    let stretched: Vec<DVec3> = vertices.iter().map(|vertex| *stretch * vertex.as_dvec3()).collect();
    let mut triangles = triangles.to_vec();
    if stretch.determinant() < 0.0 {
        triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    if !is_closed(vertices, &triangles) {
        return Err("its surface is open");
    }
    let whole = Moments::of_surface(&stretched, &triangles);
    let center = whole.center();
    if !(whole.volume > 0.0 && whole.volume.is_finite() && center.is_finite()) {
        return Err("its surface encloses no volume");
    }
    let vertices: Vec<Vec3> = stretched.iter().map(|vertex| (*vertex - center).as_vec3()).collect();
    let solid = TriMeshFlags::FIX_INTERNAL_EDGES | TriMeshFlags::DELETE_DEGENERATE_TRIANGLES;
    let mesh = TriMesh::with_flags(vertices, triangles, solid).map_err(|_| "its surface is no mesh")?;
    finished(Collider {
        shape: SharedShape::new(mesh),
        place: EnginePose::default(),
        center,
        moments: whole.transformed(&DAffine3::from_translation(-center)),
        radius: 0.0,
        thickness: 0.0,
    })
}

/// Whether every edge is passed as often one way as the other. Vertices at one place are one.
fn is_closed(vertices: &[Vec3], triangles: &[[u32; 3]]) -> bool {
    let mut numbers: BTreeMap<[u32; 3], u32> = BTreeMap::new();
    let mut edges: BTreeMap<(u32, u32), i64> = BTreeMap::new();
    for triangle in triangles {
        let corners = triangle.map(|index| {
            let next = numbers.len() as u32;
            let place =
                vertices.get(index as usize).map_or([u32::MAX; 3], |v| v.to_array().map(|x| (x + 0.0).to_bits()));
            *numbers.entry(place).or_insert(next)
        });
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (from, to) = (corners[from], corners[to]);
            *edges.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
        }
    }
    edges.iter().all(|((from, to), balance)| from == to || *balance == 0)
}

/// The convex hull of points.
fn hull(points: &[DVec3]) -> Result<Part, &'static str> {
    const FLAT: &str = "a convex piece has no volume";
    let origin = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let size = points.iter().fold(0.0, |size: f64, point| size.max(point.distance(origin)));
    if !(size > 0.0 && size.is_finite() && has_volume(points, size)) {
        return Err(FLAT);
    }
    let local: Vec<Vec3> = points.iter().map(|point| (*point - origin).as_vec3()).collect();
    let polyhedron = ConvexPolyhedron::from_convex_hull(&local).ok_or(FLAT)?;
    let (vertices, triangles) = polyhedron.to_trimesh();
    let vertices: Vec<DVec3> = vertices.iter().map(|vertex| vertex.as_dvec3()).collect();
    let place = DAffine3::from_translation(origin);
    let moments = Moments::of_surface(&vertices, &triangles).transformed(&place);
    if !(moments.volume > 0.0) {
        return Err(FLAT);
    }
    Ok(Part { shape: SharedShape::new(polyhedron), place, moments })
}

/// Whether points span a tetrahedron that is not flat. The engine's hull is not asked about those that do not.
fn has_volume(points: &[DVec3], size: f64) -> bool {
    let farthest = |measure: &dyn Fn(DVec3) -> f64| {
        points.iter().copied().max_by(|a, b| measure(*a).total_cmp(&measure(*b))).unwrap_or_default()
    };
    let Some(&a) = points.first() else { return false };
    let b = farthest(&|point| point.distance_squared(a));
    let Some(along) = (b - a).try_normalize() else { return false };
    let c = farthest(&|point| (point - a).reject_from(along).length_squared());
    let Some(across) = (c - a).reject_from(along).try_normalize() else { return false };
    let normal = along.cross(across);
    let height = |point: DVec3| (point - a).dot(normal).abs();
    height(farthest(&height)) > 1e-6 * size
}

/// A primitive after a stretch: itself where that leaves it one, else a hull.
fn solid(primitive: &Primitive, stretch: &DMat3) -> Result<Part, &'static str> {
    const BROKEN: &str = "a primitive has a size that is not above 0, or a number that is none";
    let point = |values: [f32; 3]| DVec3::from(values.map(f64::from));
    let positive = |value: f32| value > 0.0 && value.is_finite();
    let (moments, place) = match *primitive {
        Primitive::Box { center, orientation, half } => {
            let turn = DQuat::from_array(orientation.map(f64::from));
            // As for `Piv`, all zero means identity.
            let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { DQuat::IDENTITY };
            if !(half.into_iter().all(positive) && turn.is_finite()) {
                return Err(BROKEN);
            }
            (Moments::of_box(point(half)), DAffine3::from_rotation_translation(turn, point(center)))
        }
        Primitive::Sphere { center, radius } if positive(radius) => {
            (Moments::of_ball(radius.into()), DAffine3::from_translation(point(center)))
        }
        Primitive::Capsule { a, b, radius } if positive(radius) => {
            let (a, b) = (point(a), point(b));
            let turn = (b - a).try_normalize().map_or(DQuat::IDENTITY, |axis| DQuat::from_rotation_arc(DVec3::Y, axis));
            let moments = Moments::of_capsule(0.5 * a.distance(b), radius.into());
            (moments, DAffine3::from_rotation_translation(turn, 0.5 * (a + b)))
        }
        Primitive::Sphere { .. } | Primitive::Capsule { .. } => return Err(BROKEN),
    };
    if !place.is_finite() {
        return Err(BROKEN);
    }
    let map = DAffine3::from_mat3(*stretch) * place;
    let moments = moments.transformed(&map);
    let columns = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis];
    let lengths = columns.map(DVec3::length);
    let [x, y, z] = [0, 1, 2].map(|axis| columns[axis] / lengths[axis]);
    let square = [x.dot(y), y.dot(z), z.dot(x)].iter().all(|cosine| cosine.abs() < SQUARE);
    let similar = square && lengths.iter().all(|length| (length / lengths[0] - 1.0).abs() < SQUARE);
    // These shapes are their own mirror images, so that a reflected axis may be turned round.
    let frame = DMat3::from_cols(x, y, if x.cross(y).dot(z) < 0.0 { -z } else { z });
    let place = DAffine3 { matrix3: frame, translation: map.translation };
    let scale = lengths[0];
    let shape = match *primitive {
        Primitive::Box { half, .. } if square => {
            let [x, y, z] = [0, 1, 2].map(|axis| (f64::from(half[axis]) * lengths[axis]) as f32);
            SharedShape::cuboid(x, y, z)
        }
        Primitive::Sphere { radius, .. } if similar => SharedShape::ball((f64::from(radius) * scale) as f32),
        Primitive::Capsule { a, b, radius } if similar => SharedShape::capsule_y(
            (0.5 * point(a).distance(point(b)) * scale) as f32,
            (f64::from(radius) * scale) as f32,
        ),
        _ => {
            let points: Vec<DVec3> = surface_points(primitive).map(|point| map.transform_point3(point)).collect();
            // Its mass is that of the exact shape.
            return Ok(Part { moments, ..hull(&points)? });
        }
    };
    Ok(Part { shape, place, moments })
}

/// Points on a primitive, around its centre.
fn surface_points(primitive: &Primitive) -> impl Iterator<Item = DVec3> {
    let sphere = |radius: f32, shift: f64| {
        // A spiral of equal areas.
        (0..SAMPLES).map(move |index| {
            let y = 1.0 - 2.0 * (index as f64 + 0.5) / SAMPLES as f64;
            let angle = 2.399_963_229_728_653 * index as f64;
            let (sin, cos) = angle.sin_cos();
            let across = (1.0 - y * y).sqrt();
            DVec3::new(across * cos, y, across * sin) * f64::from(radius) + DVec3::Y * shift.copysign(y)
        })
    };
    let points: Vec<DVec3> = match *primitive {
        Primitive::Box { half, .. } => (0..8)
            .map(|corner| {
                let sign = |axis: usize| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
                DVec3::new(sign(0), sign(1), sign(2)) * DVec3::from(half.map(f64::from))
            })
            .collect(),
        Primitive::Sphere { radius, .. } => sphere(radius, 0.0).collect(),
        Primitive::Capsule { a, b, radius } => {
            sphere(radius, 0.5 * f64::from(Vec3::from(a).distance(Vec3::from(b)))).collect()
        }
    };
    points.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rapier3d::prelude::ShapeType;

    fn compound_of(primitives: Vec<Primitive>, pieces: Vec<Vec<Vec3>>) -> Shape {
        Shape::Compound { primitives, pieces }
    }

    fn cube(center: Vec3) -> Vec<Vec3> {
        (0..8).map(|i| center + Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)).collect()
    }

    #[test]
    fn primitives_stay_primitives_where_a_stretch_allows() {
        let ball = compound_of(vec![Primitive::Sphere { center: [1.0, 0.0, 0.0], radius: 0.5 }], vec![]);
        let capsule = compound_of(vec![Primitive::Capsule { a: [0.0; 3], b: [2.0, 0.0, 0.0], radius: 0.5 }], vec![]);
        let turned = [0.0, 0.0, (0.25_f32).sin(), (0.25_f32).cos()];
        let boxed = |orientation| {
            compound_of(vec![Primitive::Box { center: [0.0; 3], orientation, half: [1.0, 2.0, 3.0] }], vec![])
        };
        let uniform = DMat3::from_diagonal(DVec3::splat(-2.0));
        let uneven = DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0));
        for (shape, stretch, expected) in [
            (&ball, uniform, ShapeType::Ball),
            (&ball, uneven, ShapeType::ConvexPolyhedron),
            (&capsule, uniform, ShapeType::Capsule),
            (&capsule, uneven, ShapeType::ConvexPolyhedron),
            (&boxed([0.0; 4]), uneven, ShapeType::Cuboid),
            (&boxed(turned), uniform, ShapeType::Cuboid),
            (&boxed(turned), uneven, ShapeType::ConvexPolyhedron),
        ] {
            let made = collider(shape, BodyMode::Dynamic, &stretch).expect("a collider");
            assert_eq!(made.shape.shape_type(), expected);
            let size = stretch.determinant().abs();
            let unscaled = collider(shape, BodyMode::Dynamic, &DMat3::IDENTITY).expect("a collider").moments.volume;
            assert!((made.moments.volume / unscaled - size).abs() < 1e-9 * size, "mass scales with the volume");
        }
        let center = collider(&ball, BodyMode::Dynamic, &uneven).expect("a collider").center;
        assert!(center.distance(DVec3::X) < 1e-12);
    }

    #[test]
    fn pieces_make_one_compound_around_the_centre_of_mass() {
        let shape = compound_of(vec![], vec![cube(Vec3::ZERO), cube(Vec3::new(1.0, 0.0, 0.0))]);
        let made = collider(&shape, BodyMode::Dynamic, &DMat3::IDENTITY).expect("a collider");
        assert_eq!(made.shape.shape_type(), ShapeType::Compound);
        assert!(made.center.distance(DVec3::new(1.0, 0.5, 0.5)) < 1e-6);
        assert!((made.moments.volume - 2.0).abs() < 1e-6);
        let around = made.shape.compute_aabb(&made.place);
        assert!(around.mins.abs_diff_eq(Vec3::new(-1.0, -0.5, -0.5), 1e-5), "{around:?}");
        // Far from the origin nothing changes but the centre.
        let far = Vec3::new(1e4, 0.0, -1e4);
        let far_shape = compound_of(vec![], vec![cube(far), cube(far + Vec3::X)]);
        let moved = collider(&far_shape, BodyMode::Dynamic, &DMat3::IDENTITY).expect("a collider");
        assert!((moved.moments.volume - 2.0).abs() < 1e-3);
    }

    #[test]
    fn what_has_no_volume_is_refused() {
        let flat: Vec<Vec3> = cube(Vec3::ZERO).into_iter().map(|v| v * Vec3::new(1.0, 1.0, 0.0)).collect();
        let line: Vec<Vec3> = (0..5).map(|i| Vec3::X * i as f32).collect();
        for points in [flat, line, vec![Vec3::ONE; 8], vec![], vec![Vec3::ZERO]] {
            let shape = compound_of(vec![], vec![points]);
            assert!(collider(&shape, BodyMode::Dynamic, &DMat3::IDENTITY).is_err());
        }
        let nothing = compound_of(vec![Primitive::Sphere { center: [0.0; 3], radius: 0.0 }], vec![]);
        assert!(collider(&nothing, BodyMode::Dynamic, &DMat3::IDENTITY).is_err());
        let huge = compound_of(vec![], vec![cube(Vec3::ZERO).into_iter().map(|v| v * 1e38).collect()]);
        assert!(collider(&huge, BodyMode::Dynamic, &DMat3::from_diagonal(DVec3::splat(1e30))).is_err());
        let sliver = Shape::Triangles { vertices: vec![Vec3::ZERO; 3], triangles: vec![[0, 1, 2]] };
        assert!(collider(&sliver, BodyMode::Static, &DMat3::IDENTITY).is_err());
        assert!(collider(&sliver, BodyMode::Dynamic, &DMat3::IDENTITY).is_err());
    }

    #[test]
    fn hulls_of_hard_points_do_not_panic() {
        // Grids, doubles, near-planes: what convex pieces look like after a conversion.
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut made = 0;
        for case in 0..400 {
            let count = 4 + case % 61;
            let thickness = [1.0, 1e-3, 1e-5, 1e-7][case % 4];
            let grid = [0.0, 4.0, 16.0][case % 3];
            let points: Vec<Vec3> = (0..count)
                .map(|_| {
                    let point = Vec3::new(random(), random(), random());
                    let point = if grid > 0.0 { (point * grid).round() / grid } else { point };
                    point * Vec3::new(1.0, 1.0, thickness)
                })
                .collect();
            made +=
                usize::from(collider(&compound_of(vec![], vec![points]), BodyMode::Dynamic, &DMat3::IDENTITY).is_ok());
        }
        assert!(made > 200, "only {made} of 400 became hulls");
    }
}
