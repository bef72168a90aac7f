//! Pulling bodies, and where they touch.

mod common;

use aam_physics::{PhysicsError, Settings};
use aam_scene::NodeId;
use common::{Dynamic, Kinematic, Stage, ball, body, cube, every, position, rough, run};
use glam::Vec3;

#[test]
fn a_held_body_follows_the_hand_whatever_it_weighs_and_however_long_a_step_is() {
    for mass in [1e-3, 1.0, 1e4] {
        for step in [1.0 / 1000.0, 1.0 / 60.0, 1.0 / 10.0] {
            let mut stage = Stage::default();
            stage.floor(rough(0.5));
            let mesh = aam_physics::PhysicsMesh { mass: Some(mass), ..cube(Dynamic) };
            let node = stage.add(mesh, Vec3::Z * 0.5);
            let mut simulator = stage.started(every(step));
            simulator.grab(node, Vec3::new(0.0, 0.0, 1.0)).expect("dynamic");
            let hand = Vec3::new(1.0, 0.5, 2.0);
            simulator.pull_to(hand).expect("held");
            run(&mut simulator, 6.0);
            let (held, [point, there]) = simulator.grabbed().expect("held");
            assert_eq!((held, there), (node, hand));
            // It hangs as deep as gravity stretches the spring: g / omega^2.
            let sag = 9.81 / (std::f32::consts::TAU * 6.0).powi(2);
            let below = hand - point;
            // In steps of a tenth of a second it still swings a little.
            let tolerance = if step > 0.05 { 1e-2 } else { 2e-3 };
            assert!((below - Vec3::Z * sag).length() < tolerance, "{mass} kg, {step} s: {below} m below the hand");
            simulator.release();
            assert_eq!(simulator.grabbed(), None);
            run(&mut simulator, 5.0);
            assert!((position(&simulator, node).z - 0.5).abs() < 0.03, "{mass} kg, {step} s: it falls again");
        }
    }
}

#[test]
fn a_hand_throws_but_pulls_through_no_floor() {
    let mut stage = Stage::default();
    stage.floor(rough(0.5));
    let node = stage.add(body("ball", Dynamic, ball(0.2), rough(0.5)), Vec3::Z * 0.2);
    let mut simulator = stage.started(Settings::default());
    simulator.grab(node, Vec3::Z * 0.2).expect("dynamic");
    simulator.pull_to(Vec3::Z * -50.0).expect("held");
    run(&mut simulator, 2.0);
    assert!(position(&simulator, node).z > 0.0, "{}", position(&simulator, node));
    for frame in 0..30 {
        simulator.pull_to(Vec3::new(0.1 * frame as f32, 0.0, 1.0)).expect("held");
        simulator.step().expect("a step");
    }
    simulator.release();
    let speed = simulator.state(node).expect("simulated").velocity.x;
    assert!((5.5..6.5).contains(&speed), "thrown at {speed} m/s by a hand at 6 m/s");
    assert_eq!(simulator.pull_to(Vec3::ZERO), Err(PhysicsError::Move("nothing is held; grab a body first")));
}

#[test]
fn kinematic_bodies_follow_exactly_and_static_ones_are_refused() {
    let mut stage = Stage::default();
    let floor = stage.floor(rough(0.5));
    let node = stage.add(cube(Kinematic), Vec3::Z * 3.0);
    let other = stage.add(cube(Dynamic), Vec3::Z * 9.0);
    let mut simulator = stage.started(Settings::default());
    assert!(matches!(simulator.grab(floor, Vec3::ZERO), Err(PhysicsError::Mode { .. })));
    assert!(matches!(simulator.grab(NodeId(9), Vec3::ZERO), Err(PhysicsError::NotSimulated(_))));
    assert!(matches!(simulator.grab(other, Vec3::NAN), Err(PhysicsError::Value(_))));
    simulator.grab(node, Vec3::new(0.5, 0.0, 3.0)).expect("kinematic");
    simulator.pull_to(Vec3::new(1.5, 1.0, 4.0)).expect("held");
    run(&mut simulator, 0.1);
    assert!(position(&simulator, node).distance(Vec3::new(1.0, 1.0, 4.0)) < 1e-5);
    // Another takes its place, and nothing is left of it at the end.
    simulator.grab(other, position(&simulator, other)).expect("dynamic");
    simulator.release();
    simulator.begin_move(node).expect("no move has begun");
    simulator.end();
    assert_eq!(simulator.grabbed(), None);
}

#[test]
fn a_grab_changes_nothing_once_it_is_let_go_of_before_a_step() {
    let hash = |grab: bool| {
        let mut stage = Stage::default();
        stage.floor(rough(0.5));
        let node = stage.add(cube(Dynamic), Vec3::Z * 2.0);
        let mut simulator = stage.started(Settings::default());
        if grab {
            simulator.grab(node, Vec3::Z * 2.0).expect("dynamic");
            simulator.release();
        }
        run(&mut simulator, 1.0);
        simulator.hash()
    };
    assert_eq!(hash(true), hash(false));
}

#[test]
fn contacts_bear_what_lies_on_them() {
    let mut stage = Stage::default();
    let floor = stage.floor(rough(0.5));
    let low = stage.add(cube(Dynamic), Vec3::Z * 0.5);
    let high = stage.add(cube(Dynamic), Vec3::Z * 1.5);
    let mut simulator = stage.started(Settings { sleeping: false, ..Settings::default() });
    run(&mut simulator, 3.0);
    let contacts = simulator.contacts();
    let force = |a: NodeId, b: NodeId| {
        let between = contacts.iter().filter(|contact| contact.bodies.contains(&a) && contact.bodies.contains(&b));
        between.map(|contact| contact.force).sum::<f32>()
    };
    // Each weighs a kilogram.
    assert!((force(floor, low) - 2.0 * 9.81).abs() < 0.4, "{} N", force(floor, low));
    assert!((force(low, high) - 9.81).abs() < 0.2, "{} N", force(low, high));
    for contact in &contacts {
        let height = if contact.bodies.contains(&floor) { 0.0 } else { 1.0 };
        assert!((contact.point.z - height).abs() < 0.02 && contact.normal.z.abs() > 0.999, "{contact:?}");
        assert!(contact.point.truncate().abs().max_element() < 0.51, "{contact:?}");
        let upwards = contact.normal.z > 0.0;
        let [first, second] = contact.bodies.map(|node| if node == floor { 0.0 } else { position(&simulator, node).z });
        assert_eq!(upwards, second > first, "from the first to the second");
    }
}
