//! What the source says of bodies and simulators, rule by rule.

mod common;

use std::sync::Arc;

use aam_physics::{
    Joint, JointKind, Material, PhysicsError, PhysicsMesh, Registration, Settings, Shape, Simulator, What,
};
use aam_scene::NodeId;
use common::{Dynamic, Kinematic, Stage, Static, ball, body, bouncy, boxed, cube, every, position, rough, run, turned};
use glam::{Affine3A, Mat3, Quat, Vec3};

fn settings() -> Settings {
    Settings::default()
}

fn weightless() -> Settings {
    Settings { gravity: Some(Vec3::ZERO), ..settings() }
}

/// A cube as drawn triangles, which is what static bodies have.
fn solid_cube() -> PhysicsMesh {
    let vertices: Vec<Vec3> =
        (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    PhysicsMesh { shape: Shape::Triangles { vertices, triangles }, ..cube(Static) }
}

#[test]
fn r79_only_dynamic_bodies_collide_with_others() {
    for (first, second, collide) in [
        (Dynamic, Dynamic, true),
        (Dynamic, Static, true),
        (Dynamic, Kinematic, true),
        (Static, Static, false),
        (Static, Kinematic, false),
        (Kinematic, Kinematic, false),
    ] {
        let mesh = |mode| if mode == Static { solid_cube() } else { cube(mode) };
        let mut stage = Stage::default();
        // They overlap by a fifth, and part if they collide.
        let nodes = [stage.add(mesh(first), Vec3::ZERO), stage.add(mesh(second), Vec3::X * 0.8)];
        let mut simulator = stage.started(weightless());
        run(&mut simulator, 2.0);
        let gap = position(&simulator, nodes[0]).distance(position(&simulator, nodes[1]));
        assert_eq!(gap > 0.95, collide, "{first:?} and {second:?}: {gap}");
        assert!(collide || gap == 0.8);
    }
}

#[test]
fn r81_a_static_body_never_moves() {
    let mut stage = Stage::default();
    let wall = stage.add(solid_cube(), Vec3::ZERO);
    let hammer = stage.add(PhysicsMesh { mass: Some(1e4), ..cube(Dynamic) }, Vec3::X * -3.0);
    let mut simulator = stage.started(settings());
    simulator.set_velocity(hammer, Vec3::X * 20.0, Vec3::ZERO).expect("dynamic");
    let before = simulator.state(wall).expect("simulated").pose;
    run(&mut simulator, 1.0);
    assert_eq!(simulator.state(wall).expect("simulated").pose, before);
    assert!(simulator.begin_move(wall).is_err());
    assert!(simulator.apply_force(wall, Vec3::X, None).is_err());
    assert!(simulator.set_velocity(wall, Vec3::X, Vec3::ZERO).is_err());
}

#[test]
fn r82_a_kinematic_body_moves_by_hand_only_and_pushes() {
    let mut stage = Stage::default();
    stage.floor(rough(0.5));
    let plough = stage.add(cube(Kinematic), Vec3::new(0.0, 0.0, 0.6));
    let load = stage.add(cube(Dynamic), Vec3::new(1.2, 0.0, 0.5));
    let mut simulator = stage.started(settings());
    simulator.set_velocity(load, Vec3::X * -5.0, Vec3::ZERO).expect("dynamic");
    run(&mut simulator, 1.0);
    assert_eq!(position(&simulator, plough), Vec3::new(0.0, 0.0, 0.6), "neither gravity nor hits move it");
    assert_eq!(simulator.move_to(&Affine3A::IDENTITY), Err(PhysicsError::Move("no move has begun; begin one first")));
    simulator.begin_move(plough).expect("kinematic");
    assert!(simulator.begin_move(load).is_err(), "one at a time");
    for step in 1..=120 {
        let place = Vec3::new(step as f32 / 60.0, 0.0, 0.6);
        simulator.move_to(&Affine3A::from_translation(place)).expect("a move has begun");
        simulator.step().expect("a good step");
    }
    simulator.end_move().expect("a move has begun");
    assert!(position(&simulator, plough).abs_diff_eq(Vec3::new(2.0, 0.0, 0.6), 1e-5));
    assert!(position(&simulator, load).x > 2.9, "it was pushed to {}", position(&simulator, load));
    run(&mut simulator, 0.5);
    assert!(position(&simulator, plough).abs_diff_eq(Vec3::new(2.0, 0.0, 0.6), 1e-5), "it stays where it was put");
}

#[test]
fn a_dynamic_body_is_held_while_it_is_moved() {
    let mut stage = Stage::default();
    let node = stage.add(cube(Dynamic), Vec3::Z * 5.0);
    let mut simulator = stage.started(settings());
    run(&mut simulator, 0.5);
    simulator.begin_move(node).expect("dynamic");
    let held = position(&simulator, node);
    run(&mut simulator, 0.5);
    assert_eq!(position(&simulator, node), held, "held bodies do not fall");
    simulator.move_to(&Affine3A::from_translation(Vec3::X * 7.0)).expect("a move has begun");
    simulator.end_move().expect("a move has begun");
    let state = simulator.state(node).expect("simulated");
    assert_eq!((state.pose.position, state.velocity), (Vec3::X * 7.0, Vec3::ZERO), "put there at rest");
    run(&mut simulator, 0.5);
    assert!(position(&simulator, node).z < -1.0, "and falls again");
}

#[test]
fn r83_static_bodies_are_drawn_triangles_and_others_compounds() {
    // A bowl without a lid, as a static body, holds a ball; its convex hull would not.
    let corner = |i: i32| Vec3::new([-1.0, 1.0, 1.0, -1.0][i as usize], [-1.0, -1.0, 1.0, 1.0][i as usize], 1.0);
    let vertices = vec![Vec3::ZERO, corner(0), corner(1), corner(2), corner(3)];
    let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];
    let bowl = PhysicsMesh { shape: Shape::Triangles { vertices, triangles }, ..solid_cube() };
    let mut stage = Stage::default();
    stage.add(bowl, Vec3::ZERO);
    let marble = stage.add(body("marble", Dynamic, ball(0.2), rough(0.3)), Vec3::new(0.3, 0.2, 1.5));
    // A dynamic angle of two pieces: a peg in its notch touches nothing.
    let piece = |low: Vec3, high: Vec3| -> Vec<Vec3> {
        (0..8)
            .map(|i| {
                let pick = |bit: i32, a: f32, b: f32| if i & bit == 0 { a } else { b };
                Vec3::new(pick(1, low.x, high.x), pick(2, low.y, high.y), pick(4, low.z, high.z))
            })
            .collect()
    };
    let pieces = vec![piece(Vec3::ZERO, Vec3::new(2.0, 1.0, 1.0)), piece(Vec3::Z, Vec3::new(1.0, 1.0, 2.0))];
    let angle = PhysicsMesh { shape: Shape::Compound { primitives: vec![], pieces }, ..cube(Dynamic) };
    let far = Vec3::new(20.0, 0.0, 0.0);
    let angle = stage.add(angle, far);
    let peg = stage.add(body("peg", Dynamic, ball(0.3), rough(0.3)), far + Vec3::new(1.5, 0.5, 1.5));
    let mut simulator = stage.started(weightless());
    run(&mut simulator, 1.0);
    let still = |node: NodeId, at: Vec3| position(&simulator, node).abs_diff_eq(at, 1e-5);
    assert!(still(peg, far + Vec3::new(1.5, 0.5, 1.5)), "the notch is free");
    // Two cubes below and one on the left: a third of the mass is left of the middle.
    assert!(still(angle, far + Vec3::new(2.5 / 3.0, 0.5, 2.5 / 3.0)), "{}", position(&simulator, angle));
    let mut simulator = stage.started(settings());
    run(&mut simulator, 3.0);
    let rest = position(&simulator, marble);
    assert!(rest.truncate().length() < 0.1 && rest.z > 0.0 && rest.z < 1.0, "the marble lies in the bowl: {rest}");
}

#[test]
fn r84_where_two_bodies_touch_each_coefficient_is_the_mean() {
    let mut stage = Stage::default();
    stage.floor(rough(0.2));
    let node = stage.add(body("box", Dynamic, boxed(Vec3::new(0.5, 0.5, 0.1)), rough(0.6)), Vec3::Z * 0.1);
    let two = Material { static_friction: 0.9, dynamic_friction: 0.6, restitution: 0.0 };
    let other = stage.add(body("other", Dynamic, boxed(Vec3::new(0.5, 0.5, 0.1)), two), Vec3::new(0.0, 9.0, 0.1));
    let drop = stage.add(body("ball", Dynamic, ball(0.1), bouncy(1.0)), Vec3::new(0.0, 20.0, 1.1));
    let mut simulator = stage.started(every(1.0 / 240.0));
    for node in [node, other] {
        simulator.set_velocity(node, Vec3::X * 3.0, Vec3::ZERO).expect("dynamic");
    }
    let mut top = 0.0_f32;
    for step in 0..720 {
        simulator.step().expect("a good step");
        top = if step > 120 { top.max(position(&simulator, drop).z - 0.1) } else { top };
    }
    let expected = 9.0 / (2.0 * 0.4 * 9.81);
    for node in [node, other] {
        let distance = position(&simulator, node).x;
        assert!((distance / expected - 1.0).abs() < 0.03, "{distance} m, not {expected} m");
    }
    // The floor's restitution is 0, so that the mean is a half and the height a quarter.
    assert!((top - 0.25).abs() < 0.03, "{top}");
}

#[test]
fn r85_automatic_registration_registers_what_is_created() {
    let mesh = Arc::new(cube(Dynamic));
    for (registration, count) in [(Registration::Automatic, 1), (Registration::Manual, 0)] {
        let mut simulator = Simulator::new(settings(), registration).expect("settings");
        simulator.object_created(NodeId(0), &mesh);
        assert_eq!(simulator.registered().count(), count);
        simulator.register(NodeId(1), &mesh);
        assert_eq!(simulator.registered().count(), count + 1);
        assert!(simulator.unregister(NodeId(1)) && !simulator.unregister(NodeId(1)));
    }
}

#[test]
fn r86_registration_does_not_touch_the_running_simulation() {
    let mut stage = Stage::default();
    let node = stage.add(cube(Dynamic), Vec3::ZERO);
    let late = stage.node("late", None, Affine3A::from_translation(Vec3::X * 5.0));
    let mut simulator = stage.started(settings());
    simulator.register(late, &stage.meshes[0].1);
    assert!(simulator.unregister(node));
    run(&mut simulator, 0.5);
    assert_eq!(simulator.bodies().collect::<Vec<_>>(), [node]);
    assert_eq!(simulator.state(late), Err(PhysicsError::NotSimulated(late)));
    assert_eq!(simulator.prepare(&stage.scene), []);
    assert_eq!(simulator.bodies().collect::<Vec<_>>(), [late]);
}

#[test]
fn r87_a_new_simulation_begins_from_the_start() {
    let mut stage = Stage::default();
    stage.floor(rough(0.5));
    let node = stage.add(cube(Dynamic), Vec3::Z * 2.0);
    let mut simulator = stage.started(settings());
    let first = simulator.state(node).expect("simulated");
    simulator.set_mass(node, 70.0).expect("dynamic");
    simulator.set_material(node, bouncy(0.9)).expect("a material");
    run(&mut simulator, 1.0);
    assert_ne!(simulator.state(node).expect("simulated").pose, first.pose);
    simulator.end();
    assert_eq!((simulator.bodies().count(), simulator.time(), simulator.is_prepared()), (0, 0.0, false));
    assert!(simulator.step().is_err(), "nothing is started");
    assert_eq!(simulator.prepare(&stage.scene), []);
    assert!(simulator.step().is_err(), "prepared is not started");
    simulator.start().expect("prepared");
    assert_eq!(simulator.state(node).expect("simulated"), first);
}

#[test]
fn r88_setters_on_objects_change_nothing_while_they_are_simulated() {
    let mut stage = Stage::default();
    let node = stage.add(cube(Dynamic), Vec3::ZERO);
    let mut simulator = stage.started(weightless());
    stage.scene.nodes[node.index()].local = Affine3A::from_translation(Vec3::splat(50.0));
    run(&mut simulator, 0.1);
    let transforms = simulator.world_transforms(&stage.scene);
    assert_eq!(transforms[node.index()].translation, glam::Vec3A::ZERO);
    simulator.end();
    assert_eq!(simulator.world_transforms(&stage.scene), stage.scene.world_transforms());
}

/// A parent that is turned, scaled and shifted, a simulated child, its own child that is not simulated, and a second
/// simulated one below that.
fn family() -> (Stage, [NodeId; 4]) {
    let mut stage = Stage::default();
    let place = Affine3A::from_scale_rotation_translation(
        Vec3::new(2.0, 1.0, 0.5),
        Quat::from_rotation_z(0.5),
        Vec3::new(1.0, 2.0, 3.0),
    );
    let mesh = Arc::new(cube(Dynamic));
    let parent = stage.node("parent", None, place);
    let local = Affine3A::from_rotation_translation(Quat::from_rotation_x(0.3), Vec3::X);
    let child = stage.place(&mesh, Some(parent), local);
    let lamp = stage.node("lamp", Some(child), Affine3A::from_translation(Vec3::Z * 2.0));
    let other = stage.place(&mesh, Some(lamp), Affine3A::from_translation(Vec3::Z * 9.0));
    (stage, [parent, child, lamp, other])
}

#[test]
fn r89_r90_simulated_children_ignore_parents_and_others_follow() {
    let (mut stage, [parent, child, lamp, other]) = family();
    let mut simulator = stage.started(settings());
    simulator.set_velocity(child, Vec3::X * 3.0, Vec3::Z).expect("dynamic");
    run(&mut simulator, 0.5);
    let before = simulator.world_transforms(&stage.scene);
    stage.scene.nodes[parent.index()].local = Affine3A::from_translation(Vec3::splat(99.0));
    let after = simulator.world_transforms(&stage.scene);
    assert_eq!(after[parent.index()], Affine3A::from_translation(Vec3::splat(99.0)));
    assert_eq!(after[child.index()], before[child.index()], "a simulated child ignores its parent");
    assert_eq!(after[lamp.index()], after[child.index()] * stage.scene.nodes[lamp.index()].local, "it follows");
    assert_eq!(after[other.index()], before[other.index()], "simulated again below one that is not");
    assert_ne!(after[lamp.index()], stage.scene.world_transforms()[lamp.index()]);
}

#[test]
fn r91_r92_bodies_start_where_and_as_large_as_they_are_drawn() {
    let (stage, [_, child, lamp, other]) = family();
    let simulator = stage.started(settings());
    let (drawn, simulated) = (stage.scene.world_transforms(), simulator.world_transforms(&stage.scene));
    for node in [child, lamp, other] {
        assert!(
            drawn[node.index()].abs_diff_eq(simulated[node.index()], 1e-5),
            "with scale and shear: {:?} against {:?}",
            drawn[node.index()],
            simulated[node.index()]
        );
    }
    let matrix = Mat3::from(drawn[child.index()].matrix3);
    assert!(matrix.x_axis.dot(matrix.y_axis).abs() + matrix.y_axis.dot(matrix.z_axis).abs() > 0.1, "there is shear");
}

#[test]
fn r92_a_scaled_body_collides_as_it_is_drawn() {
    let mut stage = Stage::default();
    stage.floor(rough(0.5));
    let tall = Affine3A::from_scale_rotation_translation(Vec3::new(1.0, 1.0, 3.0), Quat::IDENTITY, Vec3::Z * 1.6);
    let node = stage.place(&Arc::new(cube(Dynamic)), None, tall);
    let mirrored =
        Affine3A::from_scale_rotation_translation(Vec3::new(-2.0, 1.0, 1.0), Quat::IDENTITY, Vec3::new(9.0, 0.0, 0.6));
    let other = stage.place(&Arc::new(cube(Dynamic)), None, mirrored);
    let mut simulator = stage.started(settings());
    run(&mut simulator, 2.0);
    assert!((position(&simulator, node).z - 1.5).abs() < 0.01, "{}", position(&simulator, node));
    assert!((position(&simulator, other).z - 0.5).abs() < 0.01);
    let drawn = simulator.world_transforms(&stage.scene)[other.index()];
    assert!(drawn.matrix3.determinant() < 0.0, "it is still a mirror image");
}

#[test]
fn r93_mass_goes_with_the_product_of_the_scales() {
    let mut stage = Stage::default();
    let mesh = Arc::new(PhysicsMesh { mass: Some(10.0), ..cube(Dynamic) });
    let outer = stage.node("outer", None, Affine3A::from_scale(Vec3::new(2.0, 1.0, 1.0)));
    let node = stage.place(&mesh, Some(outer), Affine3A::from_scale(Vec3::new(1.0, -3.0, 0.5)));
    let plain = stage.place(&mesh, None, Affine3A::from_translation(Vec3::X * 9.0));
    let mut simulator = stage.started(weightless());
    let mass = |node| simulator.state(node).expect("simulated").mass;
    assert!((mass(node) - 30.0).abs() < 1e-4 && (mass(plain) - 10.0).abs() < 1e-6);
    for node in [node, plain] {
        simulator.apply_impulse(node, Vec3::X * 30.0, None).expect("dynamic");
    }
    simulator.step().expect("a good step");
    let speed = |node| simulator.state(node).expect("simulated").velocity.x;
    assert!((speed(node) - 1.0).abs() < 1e-4 && (speed(plain) - 3.0).abs() < 1e-4);
}

#[test]
fn r94_forces_and_moves_are_gone_after_the_end() {
    let mut stage = Stage::default();
    let dynamic = stage.add(cube(Dynamic), Vec3::ZERO);
    let kinematic = stage.add(cube(Kinematic), Vec3::X * 9.0);
    let before = stage.scene.world_transforms();
    let mut simulator = stage.started(settings());
    simulator.begin_move(kinematic).expect("kinematic");
    simulator.move_by(Vec3::Y * 2.0, Quat::from_rotation_z(1.0)).expect("a move has begun");
    simulator.end_move().expect("a move has begun");
    simulator.apply_force(dynamic, Vec3::X * 600.0, Some(Vec3::Y)).expect("dynamic");
    simulator.apply_torque(dynamic, Vec3::Z).expect("dynamic");
    simulator.step().expect("a good step");
    let state = simulator.state(dynamic).expect("simulated");
    assert!((state.velocity.x - 10.0).abs() < 1e-3 && state.angular_velocity.z < -1.0, "{state:?}");
    simulator.step().expect("a good step");
    assert!((simulator.state(dynamic).expect("simulated").velocity.x - 10.0).abs() < 1e-3, "a force is for one step");
    assert!(position(&simulator, kinematic).y > 1.99);
    simulator.end();
    assert_eq!(simulator.world_transforms(&stage.scene), before);
    simulator.prepare(&stage.scene);
    assert_eq!(simulator.state(dynamic).expect("simulated").velocity, Vec3::ZERO);
    assert_eq!(position(&simulator, kinematic), Vec3::X * 9.0);
}

#[test]
fn r95_parameters_of_one_simulation_are_not_those_of_another() {
    let mut stage = Stage::default();
    let node = stage.add(cube(Dynamic), Vec3::ZERO);
    let (mut first, second) = (stage.started(settings()), stage.started(settings()));
    first.set_mass(node, 5.0).expect("dynamic");
    first.set_material(node, bouncy(1.0)).expect("a material");
    let state = |simulator: &Simulator| simulator.state(node).expect("simulated");
    assert_eq!((state(&first).mass, state(&first).material), (5.0, bouncy(1.0)));
    assert_eq!((state(&second).mass, state(&second).material), (1.0, Material::default()));
    assert_eq!(*stage.meshes[0].1, cube(Dynamic));
    assert!(first.set_material(node, bouncy(2.0)).is_err() && first.set_mass(node, f64::NAN).is_err());
}

/// Two cubes that fall three metres as one. Largest change of their relative place in metres: while they fall and once
/// they lie, and while they strike the floor with 7 m/s.
fn joint_error(iterations: usize) -> [f32; 2] {
    let mut stage = Stage::default();
    stage.floor(rough(0.5));
    let first = stage.add(cube(Dynamic), Vec3::Z * 3.0);
    let second = Affine3A::from_translation(Vec3::new(1.2, 0.0, 3.4)) * turned(Vec3::Y, 0.3);
    let second = stage.place(&Arc::new(cube(Dynamic)), None, second);
    let mut simulator = stage.started(Settings { iterations, ..settings() });
    let anchor = Vec3::Z * 3.0;
    let joint = Joint { kind: JointKind::Fixed, body: first, other: Some(second), anchor, collide: false };
    simulator.add_joint(&joint).expect("a joint");
    let relative = |simulator: &Simulator| {
        let transforms = simulator.world_transforms(&stage.scene);
        transforms[first.index()].inverse() * transforms[second.index()]
    };
    let before = relative(&simulator);
    let mut errors = [0.0_f32; 2];
    for _ in 0..300 {
        simulator.step().expect("a good step");
        let after = relative(&simulator);
        let corner = Vec3::splat(0.5);
        let error = before.transform_point3(corner).distance(after.transform_point3(corner));
        let striking = (0.5..3.0).contains(&simulator.time());
        errors[usize::from(striking)] = errors[usize::from(striking)].max(error);
    }
    assert!(position(&simulator, first).z < 1.5, "it fell");
    errors
}

#[test]
fn r96_a_fixed_joint_holds_two_bodies_together() {
    let [calm, striking] = joint_error(4);
    assert!(calm < 1e-2 && striking < 0.05, "a corner moves {calm} m, at the impact {striking} m");
    let [calm, accurate] = joint_error(32);
    assert!(calm < 1e-3 && accurate < 0.5 * striking, "{calm} m, {accurate} m with more iterations");
}

#[test]
fn r97_joints_to_the_world_hold_and_those_of_static_bodies_are_refused() {
    let mut stage = Stage::default();
    let nodes: Vec<NodeId> = (0..4).map(|i| stage.add(cube(Dynamic), Vec3::new(0.0, 9.0 * i as f32, 0.0))).collect();
    let wall = stage.add(solid_cube(), Vec3::X * 50.0);
    let mut simulator = stage.started(settings());
    let joint = |node: NodeId, kind| Joint {
        kind,
        body: node,
        other: None,
        anchor: Vec3::new(0.0, 9.0 * node.0 as f32, 1.0),
        collide: false,
    };
    let slide = Vec3::new(1.0, 0.0, -1.0);
    let kinds =
        [JointKind::Fixed, JointKind::Hinge { axis: Vec3::Y }, JointKind::Ball, JointKind::Slider { axis: slide }];
    for (node, kind) in nodes.iter().zip(kinds) {
        simulator.add_joint(&joint(*node, kind)).expect("a joint");
        simulator.apply_impulse(*node, Vec3::new(1.0, 1.0, 0.0), None).expect("dynamic");
    }
    let refused =
        |simulator: &mut Simulator, wrong: Joint| simulator.add_joint(&wrong).expect_err("refused").to_string();
    let to_wall = Joint { other: Some(wall), ..joint(nodes[0], JointKind::Ball) };
    assert!(refused(&mut simulator, to_wall).contains("static"));
    assert!(refused(&mut simulator, Joint { body: wall, ..joint(nodes[0], JointKind::Ball) }).contains("static"));
    assert!(
        refused(&mut simulator, Joint { other: Some(nodes[0]), ..joint(nodes[0], JointKind::Ball) }).contains("same")
    );
    assert!(refused(&mut simulator, joint(nodes[0], JointKind::Hinge { axis: Vec3::ZERO })).contains("axis"));
    let mut swung = 0.0_f32;
    for _ in 0..120 {
        simulator.step().expect("a good step");
        swung = swung.max((position(&simulator, nodes[2]).y - 18.0).abs());
    }
    let moved = |index: usize| position(&simulator, nodes[index]) - Vec3::new(0.0, 9.0 * index as f32, 0.0);
    let turn = |index: usize| simulator.state(nodes[index]).expect("simulated").pose.rotation;
    assert!(moved(0).length() < 0.02 && turn(0).angle_between(Quat::IDENTITY) < 0.02, "fixed: {}", moved(0));
    let arm = |index: usize| moved(index) - Vec3::Z;
    assert!((arm(1).length() - 1.0).abs() < 0.02 && moved(1).y.abs() < 0.02, "a hinge keeps its plane: {}", moved(1));
    assert!((arm(2).length() - 1.0).abs() < 0.02 && swung > 0.05, "a ball joint swings anywhere: {}", moved(2));
    let along = moved(3).project_onto(slide);
    assert!(along.z < -4.0 && moved(3).distance(along) < 0.05, "a slider slides down: {}", moved(3));
    assert!(turn(3).angle_between(Quat::IDENTITY) < 0.02);
}

#[test]
fn r103_physics_meshes_are_let_go() {
    let mut stage = Stage::default();
    let node = stage.add(cube(Dynamic), Vec3::ZERO);
    let simulator = stage.started(settings());
    let mesh = Arc::clone(&stage.meshes[0].1);
    drop(stage);
    assert!(Arc::strong_count(&mesh) > 1 && simulator.state(node).is_ok());
    drop(simulator);
    assert_eq!(Arc::strong_count(&mesh), 1);
}

#[test]
fn bodies_at_rest_sleep_until_something_acts_on_them() {
    let mut stage = Stage::default();
    stage.floor(rough(0.5));
    let node = stage.add(cube(Dynamic), Vec3::Z * 0.5);
    let mut simulator = stage.started(settings());
    run(&mut simulator, 3.0);
    let asleep = |simulator: &Simulator| simulator.state(node).expect("simulated").sleeping;
    assert!(asleep(&simulator));
    simulator.apply_impulse(node, Vec3::Z * 3.0, None).expect("dynamic");
    simulator.step().expect("a good step");
    assert!(!asleep(&simulator) && position(&simulator, node).z > 0.52);
    let mut restless = stage.started(Settings { sleeping: false, ..settings() });
    run(&mut restless, 3.0);
    assert!(!asleep(&restless));
}

#[test]
fn a_body_that_breaks_or_is_lost_stops_the_simulation() {
    let mut stage = Stage::default();
    let node = stage.add(cube(Dynamic), Vec3::ZERO);
    let run_out = |settings: Settings, velocity: Vec3| {
        let mut simulator = stage.started(settings);
        simulator.set_velocity(node, velocity, Vec3::ZERO).expect("dynamic");
        let error = (0..600).find_map(|_| simulator.step().err()).expect("it stops");
        let PhysicsError::Diverged(divergence) = error else { panic!("{error}") };
        assert_eq!((divergence.node, divergence.name.as_str()), (node, "cube"));
        assert_eq!(simulator.divergence(), Some(&divergence));
        let (steps, hash) = (simulator.steps(), simulator.hash());
        assert!(simulator.step().is_err(), "it stays stopped");
        assert_eq!((simulator.steps(), simulator.hash()), (steps, hash));
        assert!(position(&simulator, node).is_finite(), "the last good pose stays");
        divergence
    };
    let lost = run_out(Settings { max_distance: 50.0, ..settings() }, Vec3::ZERO);
    assert!(matches!(lost.what, What::Lost(_)) && lost.to_string().contains("\"cube\" is lost"), "{lost}");
    let fast = run_out(Settings { max_speed: 10.0, ..settings() }, Vec3::ZERO);
    assert!(matches!(fast.what, What::TooFast(_)) && fast.step > 50, "{fast}");
    let broken = run_out(Settings { max_speed: f32::MAX, max_distance: f32::MAX, ..settings() }, Vec3::splat(1e38));
    assert!(matches!(broken.what, What::NotFinite | What::TooFast(_) | What::Lost(_)), "{broken}");
}

#[test]
fn what_cannot_be_simulated_is_said() {
    let mut stage = Stage::default();
    let good = stage.add(cube(Dynamic), Vec3::ZERO);
    let mesh = Arc::clone(&stage.meshes[0].1);
    stage.place(&mesh, None, Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0)));
    let flat = Shape::Compound { primitives: vec![], pieces: vec![vec![Vec3::ZERO, Vec3::X, Vec3::Y]] };
    stage.add(PhysicsMesh { shape: flat, ..cube(Dynamic) }, Vec3::ZERO);
    stage.meshes.push((NodeId(77), mesh));
    let mut simulator = stage.registered(settings());
    let findings = simulator.prepare(&stage.scene);
    let messages: Vec<&str> = findings.iter().map(|finding| finding.message.as_str()).collect();
    assert_eq!(messages.len(), 3);
    assert!(messages[0].contains("flattens") && messages[1].contains("volume") && messages[2].contains("no such node"));
    assert_eq!(simulator.bodies().collect::<Vec<_>>(), [good]);
    for wrong in [
        Settings { time_step: 0.0, ..settings() },
        Settings { time_step: f32::NAN, ..settings() },
        Settings { iterations: 0, ..settings() },
        Settings { length_unit: Some(-1.0), ..settings() },
        Settings { gravity: Some(Vec3::NAN), ..settings() },
        Settings { max_speed: 0.0, ..settings() },
    ] {
        assert!(Simulator::new(wrong, Registration::Manual).is_err(), "{wrong:?}");
    }
}
