//! Where everything is at one frame, which object a click hits, and the outlines drawn there.

use std::sync::Arc;

use aam_renderer::{Shape, ShapeKind, ShapeVertex};
use aam_scene::{Aabb, NodeId, Scene};
use glam::{Affine3A, Vec3};

const SELECTION: [f32; 4] = [0.36, 0.63, 0.92, 1.0];

/// Node to world at a frame of the animation.
pub(crate) fn world_at(scene: &Scene, frame: usize) -> Vec<Affine3A> {
    let mut locals: Vec<Affine3A> = scene.nodes.iter().map(|node| node.local).collect();
    for motion in scene.animation.iter().flat_map(|animation| &animation.nodes) {
        if let (Some(slot), Some(local)) = (locals.get_mut(motion.node.index()), motion.locals.get(frame)) {
            *slot = *local;
        }
    }
    let mut world: Vec<Affine3A> = Vec::with_capacity(locals.len());
    for (node, local) in scene.nodes.iter().zip(locals) {
        let parent = node.parent.and_then(|id| world.get(id.index()));
        world.push(parent.map_or(local, |parent| *parent * local));
    }
    world
}

/// The box around a node's mesh and everything below it.
pub(crate) fn bounds_below(scene: &Scene, world: &[Affine3A], root: NodeId) -> Aabb {
    let mut inside = vec![false; scene.nodes.len()];
    let mut bounds = Aabb::EMPTY;
    for (index, node) in scene.nodes.iter().enumerate() {
        let below = node.parent.is_some_and(|parent| inside.get(parent.index()).copied().unwrap_or(false));
        inside[index] = below || index == root.index();
        if let (true, Some(mesh)) = (inside[index], node.mesh.and_then(|id| scene.meshes.get(id.index()))) {
            bounds = bounds.union(&mesh.bounds.transformed(&world[index]));
        }
    }
    bounds
}

/// The nearest visible object that a ray hits, and where.
pub(crate) fn pick(scene: &Scene, world: &[Affine3A], origin: Vec3, direction: Vec3) -> Option<(NodeId, Vec3)> {
    let visible = scene.visibility();
    let mut nearest: Option<(f32, NodeId)> = None;
    for (index, node) in scene.nodes.iter().enumerate() {
        let Some(mesh) = node.mesh.and_then(|id| scene.meshes.get(id.index())).filter(|_| visible[index]) else {
            continue;
        };
        let to_object = world[index].inverse();
        let (from, along) = (to_object.transform_point3(origin), to_object.transform_vector3(direction));
        if !from.is_finite() || !along.is_finite() || !hits_box(&mesh.bounds, from, along) {
            continue;
        }
        for triangle in mesh.indices.chunks_exact(3) {
            let corner = |at: usize| mesh.positions.get(triangle[at] as usize).copied();
            let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else { continue };
            if let Some(distance) = hits_triangle(from, along, [a, b, c])
                && nearest.is_none_or(|(best, _)| distance < best)
            {
                nearest = Some((distance, NodeId(index as u32)));
            }
        }
    }
    nearest.map(|(distance, id)| (id, origin + direction * distance))
}

/// Slab test.
fn hits_box(bounds: &Aabb, origin: Vec3, direction: Vec3) -> bool {
    let inverse = direction.recip();
    let (a, b) = ((bounds.min - origin) * inverse, (bounds.max - origin) * inverse);
    let enter = a.min(b).max_element();
    let leave = a.max(b).min_element();
    // NaN, from a ray within a face, counts as a hit: the triangles decide.
    !(enter > leave * 1.000_01 + 1e-6 || leave < 0.0)
}

/// Distance along the ray, in lengths of `direction` (Möller and Trumbore 1997); both sides count.
fn hits_triangle(origin: Vec3, direction: Vec3, [a, b, c]: [Vec3; 3]) -> Option<f32> {
    let (ab, ac) = (b - a, c - a);
    let normal = direction.cross(ac);
    let determinant = ab.dot(normal);
    if determinant == 0.0 || !determinant.is_finite() {
        return None;
    }
    let to_origin = origin - a;
    let u = to_origin.dot(normal) / determinant;
    let across = to_origin.cross(ab);
    let v = direction.dot(across) / determinant;
    let distance = ac.dot(across) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some(distance)
}

/// The box around the selected object.
pub(crate) fn selection_shape(bounds: &Aabb) -> Option<Arc<Shape>> {
    if bounds.is_empty() {
        return None;
    }
    let corner = |bits: usize| {
        let pick = |bit: usize, axis: usize| if bits & bit == 0 { bounds.min[axis] } else { bounds.max[axis] };
        Vec3::new(pick(1, 0), pick(2, 1), pick(4, 2))
    };
    let mut vertices = Vec::with_capacity(24);
    for bits in 0..8 {
        for bit in [1, 2, 4] {
            if bits & bit == 0 {
                vertices
                    .extend([bits, bits | bit].map(|bits| ShapeVertex { position: corner(bits), color: SELECTION }));
            }
        }
    }
    lines(vertices)
}

pub(crate) fn lines(vertices: Vec<ShapeVertex>) -> Option<Arc<Shape>> {
    (!vertices.is_empty()).then(|| Arc::new(Shape { vertices, kind: ShapeKind::Lines, depth_test: true }))
}

#[cfg(test)]
mod tests {
    use aam_scene::{Animation, Mesh, MeshId, Node, NodeMotion};

    use super::*;

    /// Two unit squares facing Z, a child one above its parent.
    fn stack() -> Scene {
        let square = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            indices: vec![0, 1, 2, 0, 2, 3],
            bounds: Aabb { min: Vec3::ZERO, max: Vec3::new(1.0, 1.0, 0.0) },
            ..Mesh::default()
        };
        let node =
            |name: &str, parent, local| Node { name: name.into(), parent, local, mesh: Some(MeshId(0)), visible: true };
        Scene {
            nodes: vec![
                node("low", None, Affine3A::from_translation(Vec3::new(5.0, 0.0, 0.0))),
                node("high", Some(NodeId(0)), Affine3A::from_translation(Vec3::Z)),
            ],
            meshes: vec![Arc::new(square)],
            ..Scene::default()
        }
    }

    #[test]
    fn a_click_finds_the_nearest_visible_object() {
        let mut scene = stack();
        let world = world_at(&scene, 0);
        let (above, down) = (Vec3::new(5.5, 0.5, 9.0), Vec3::NEG_Z);
        let pick = |scene: &Scene, from, along| pick(scene, &world, from, along);
        assert_eq!(pick(&scene, above, down), Some((NodeId(1), Vec3::new(5.5, 0.5, 1.0))));
        assert_eq!(pick(&scene, above, Vec3::Z), None);
        assert_eq!(pick(&scene, Vec3::new(0.5, 0.5, 9.0), down), None);
        scene.nodes[1].visible = false;
        assert_eq!(pick(&scene, above, down), Some((NodeId(0), Vec3::new(5.5, 0.5, 0.0))));
        scene.nodes[0].visible = false;
        assert_eq!(pick(&scene, above, down), None);
    }

    #[test]
    fn poses_follow_the_animation() {
        let mut scene = stack();
        scene.animation = Some(Animation {
            frames_per_second: 1.0,
            frame_count: 2,
            nodes: vec![NodeMotion {
                node: NodeId(0),
                locals: vec![Affine3A::IDENTITY, Affine3A::from_translation(Vec3::Y)],
            }],
        });
        assert_eq!(world_at(&scene, 0)[1].translation, Vec3::Z.into());
        assert_eq!(world_at(&scene, 1)[1].translation, Vec3::new(0.0, 1.0, 1.0).into());
    }

    #[test]
    fn bounds_cover_what_hangs_below() {
        let scene = stack();
        let world = world_at(&scene, 0);
        assert_eq!(bounds_below(&scene, &world, NodeId(0)).max, Vec3::new(6.0, 1.0, 1.0));
        assert_eq!(bounds_below(&scene, &world, NodeId(1)).min, Vec3::new(5.0, 0.0, 1.0));
    }
}
