//! Tests of bounds, world transforms and cameras.

use glam::{Quat, Vec4Swizzles};

use super::*;

fn node(parent: Option<u32>, local: Affine3A, mesh: Option<u32>) -> Node {
    Node { name: String::new(), parent: parent.map(NodeId), local, mesh: mesh.map(MeshId), visible: true }
}

fn boxed(min: Vec3, max: Vec3) -> Arc<Mesh> {
    Arc::new(Mesh { bounds: Aabb { min, max }, ..Mesh::default() })
}

fn shifted(x: f32) -> Affine3A {
    Affine3A::from_translation(Vec3::X * x)
}

#[test]
fn boxes_hold_their_points() {
    let bounds = Aabb::of([Vec3::new(1.0, -2.0, 3.0), Vec3::new(-1.0, 2.0, 0.0), Vec3::NAN, Vec3::INFINITY]);
    assert_eq!(bounds, Aabb { min: Vec3::new(-1.0, -2.0, 0.0), max: Vec3::new(1.0, 2.0, 3.0) });
    assert_eq!(bounds.center(), Vec3::new(0.0, 0.0, 1.5));
    assert!((bounds.diagonal() - 29.0_f32.sqrt()).abs() < 1e-6);
    assert_eq!(bounds.union(&Aabb::EMPTY), bounds);
    assert!(Aabb::of([]).is_empty() && !Aabb::of([Vec3::ONE]).is_empty());
    assert!(Aabb::EMPTY.transformed(&shifted(1.0)).is_empty());
    let huge = Aabb { min: Vec3::splat(-1e30), max: Vec3::splat(1e30) };
    assert!(huge.diagonal().is_finite());
}

#[test]
fn a_turned_box_is_the_box_around_its_corners() {
    let bounds = Aabb { min: Vec3::ZERO, max: Vec3::new(1.0, 2.0, 3.0) };
    let turned = bounds.transformed(&Affine3A::from_quat(Quat::from_rotation_z(std::f32::consts::FRAC_PI_2)));
    assert!(turned.min.abs_diff_eq(Vec3::new(-2.0, 0.0, 0.0), 1e-6));
    assert!(turned.max.abs_diff_eq(Vec3::new(0.0, 1.0, 3.0), 1e-6));
}

#[test]
fn parents_carry_and_hide_their_children() {
    let mut scene = Scene {
        nodes: vec![
            node(None, shifted(10.0) * Affine3A::from_scale(Vec3::splat(2.0)), None),
            node(Some(0), shifted(1.0), Some(0)),
            node(None, shifted(-5.0), Some(0)),
            // A parent that does not stand before its child counts as none.
            node(Some(9), shifted(3.0), None),
        ],
        meshes: vec![boxed(Vec3::ZERO, Vec3::ONE)],
        ..Scene::default()
    };
    let x: Vec<f32> = scene.world_transforms().iter().map(|world| world.translation.x).collect();
    assert_eq!(x, [10.0, 12.0, -5.0, 3.0]);
    assert_eq!(scene.bounds(), Aabb { min: Vec3::new(-5.0, 0.0, 0.0), max: Vec3::new(14.0, 2.0, 2.0) });
    scene.nodes[0].visible = false;
    assert_eq!(scene.visibility(), [false, false, true, true]);
    assert_eq!(scene.bounds(), Aabb { min: Vec3::new(-5.0, 0.0, 0.0), max: Vec3::new(-4.0, 1.0, 1.0) });
}

fn corners(bounds: &Aabb) -> impl Iterator<Item = Vec3> {
    let (min, max) = (bounds.min, bounds.max);
    (0..8).map(move |corner| {
        let pick = |bit: usize| if corner >> bit & 1 == 0 { min[bit] } else { max[bit] };
        Vec3::new(pick(0), pick(1), pick(2))
    })
}

#[test]
fn the_fitting_camera_sees_everything_and_fills_the_picture() {
    let shapes = [
        (Vec3::ZERO, Vec3::ONE),
        (Vec3::new(-100.0, 5.0, 0.0), Vec3::new(100.0, 6.0, 0.1)),
        (Vec3::splat(1e-4), Vec3::splat(2e-4)),
        (Vec3::new(-1e6, -1e6, -1.0), Vec3::new(1e6, 1e6, 1e3)),
        (Vec3::splat(3.0), Vec3::splat(3.0)),
    ];
    let sides = [None, Some(Vec3::X), Some(Vec3::NEG_Y), Some(Vec3::Z), Some(Vec3::NEG_Z), Some(Vec3::ZERO)];
    for up in [Up::Z, Up::Y] {
        for (min, max) in shapes {
            for aspect in [0.2, 0.5, 1.0, 1.5, 5.0] {
                for side in sides {
                    let nodes = vec![node(None, Affine3A::IDENTITY, Some(0))];
                    let scene = Scene { up, nodes, meshes: vec![boxed(min, max)], ..Scene::default() };
                    let camera = match side {
                        None => scene.fitting_camera(aspect),
                        Some(direction) => scene.fitting_camera_from(direction, aspect),
                    };
                    let clip = camera.projection_matrix(aspect) * camera.view();
                    let mut reach = 0.0_f32;
                    for corner in corners(&scene.bounds()) {
                        let at = clip * corner.extend(1.0);
                        let ndc = at.xyz() / at.w;
                        assert!(at.w > 0.0 && ndc.is_finite(), "{camera:?}");
                        assert!(ndc.x.abs() <= 1.0001 && ndc.y.abs() <= 1.0001, "{ndc} aspect {aspect} {camera:?}");
                        assert!((0.0..=1.0).contains(&ndc.z), "{ndc} {camera:?}");
                        reach = reach.max(ndc.x.abs()).max(ndc.y.abs());
                    }
                    assert!(min == max || reach > 0.9, "only {reach} of the picture, aspect {aspect}");
                }
            }
        }
    }
}

#[test]
fn nothing_can_be_looked_at_too() {
    for aspect in [1.0, 0.0, f32::NAN, -1.0] {
        let camera = Scene::default().fitting_camera(aspect);
        assert!(camera.position.is_finite() && camera.near > 0.0 && camera.far > camera.near, "{camera:?}");
    }
}

#[test]
fn a_scene_without_lights_gets_one_at_the_camera() {
    let camera = Scene::default().fitting_camera(1.0);
    let (lights, made) = Scene::default().effective_lights(&camera);
    assert!(made && lights.len() == 1);
    assert_eq!(lights[0].kind, LightKind::Point { position: camera.position, falloff: Falloff::None });
    let scene = Scene { lights: vec![lights[0].clone(), lights[0].clone()], ..Scene::default() };
    assert_eq!(scene.effective_lights(&camera), (scene.lights.clone(), false));
}

#[test]
fn a_posed_scene_stands_where_it_is_told() {
    let mut nodes =
        vec![node(None, shifted(1.0), None), node(Some(0), shifted(2.0), None), node(Some(1), shifted(3.0), None)];
    nodes[1].visible = false;
    let motion = NodeMotion { node: NodeId(0), locals: vec![shifted(9.0)] };
    let animation = Some(Animation { frames_per_second: 1.0, frame_count: 1, nodes: vec![motion] });
    let scene = Scene { nodes, animation, ..Scene::default() };
    let world = [shifted(5.0), shifted(6.0), shifted(7.0)];
    let posed = scene.posed(&world);
    assert_eq!(posed.world_transforms(), world);
    assert_eq!(posed.visibility(), scene.visibility(), "what a parent hides stays hidden");
    assert!(posed.animation.is_some_and(|animation| animation.nodes.is_empty()));
}
