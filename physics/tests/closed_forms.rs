//! Against what can be computed by hand. Each tolerance is stated where it is asserted.

mod common;

use aam_physics::{Continuous, Joint, JointKind, Material, Settings};
use common::{Dynamic, Stage, Static, ball, body, bouncy, boxed, cube, every, position, rough, run, turned};
use glam::{Affine3A, Vec3};

const G: f32 = 9.81;

/// Two seconds of free fall: g·t²/2 within 0.5 % at 60 steps a second, and the error goes down with the step.
#[test]
fn r80_a_body_falls_as_in_a_vacuum() {
    let error = |rate: f32| {
        let mut stage = Stage::default();
        let node = stage.add(cube(Dynamic), Vec3::ZERO);
        let mut simulator = stage.started(every(1.0 / rate));
        run(&mut simulator, 2.0);
        let state = simulator.state(node).expect("simulated");
        assert!((state.velocity.z + 2.0 * G).abs() < 1e-3, "speed is g·t: {}", state.velocity);
        (state.pose.position.z + 0.5 * G * 4.0).abs() / (0.5 * G * 4.0)
    };
    let (coarse, fine) = (error(60.0), error(480.0));
    assert!(coarse < 5e-3, "{coarse}");
    assert!(fine < 0.2 * coarse, "{fine} against {coarse}");
}

/// A ball that falls from h rises to e²·h: within 3 % of h at 240 steps a second.
#[test]
fn a_ball_bounces_to_the_square_of_its_restitution() {
    for restitution in [0.3, 0.5, 0.8, 1.0] {
        let mut stage = Stage::default();
        stage.floor(bouncy(restitution));
        let node = stage.add(body("ball", Dynamic, ball(0.1), bouncy(restitution)), Vec3::new(0.3, 0.1, 1.1));
        let mut simulator = stage.started(every(1.0 / 240.0));
        run(&mut simulator, (2.0 / G as f64).sqrt() + 0.02);
        let mut top = 0.0_f32;
        for _ in 0..200 {
            simulator.step().expect("a good step");
            top = top.max(position(&simulator, node).z - 0.1);
        }
        assert!((top - restitution * restitution).abs() < 0.03, "restitution {restitution}: {top}");
    }
}

/// A box that slides with v comes to rest after v²/(2·μ·g), whichever way it slides: within 2 %.
#[test]
fn a_box_slides_as_far_as_friction_lets_it() {
    for (friction, heading) in [(0.1, 0.0_f32), (0.3, 0.6), (0.3, 2.4), (0.6, 0.0)] {
        let mut stage = Stage::default();
        stage.floor(rough(friction));
        let flat = boxed(Vec3::new(0.5, 0.5, 0.1));
        let node = stage.add(body("box", Dynamic, flat, rough(friction)), Vec3::new(0.0, 0.0, 0.1));
        let mut simulator = stage.started(every(1.0 / 240.0));
        run(&mut simulator, 0.2);
        let start = position(&simulator, node);
        let heading = turned(Vec3::Z, heading).transform_vector3(Vec3::X);
        simulator.set_velocity(node, heading * 3.0, Vec3::ZERO).expect("dynamic");
        run(&mut simulator, 4.0);
        let distance = (position(&simulator, node) - start).dot(heading);
        let expected = 9.0 / (2.0 * friction * G);
        assert!((distance / expected - 1.0).abs() < 0.02, "friction {friction}: {distance} m, not {expected} m");
    }
}

/// On a slope a box holds below the angle atan μ and slides above it: within 1 degree.
#[test]
fn a_slope_holds_up_to_the_angle_of_friction() {
    for friction in [0.2_f32, 0.5, 0.9] {
        for (offset, slides) in [(-1.0_f32, false), (1.0, true)] {
            let angle = friction.atan() + offset.to_radians();
            let mut simulator_and_node = slope(angle, rough(friction));
            let (simulator, node) = &mut simulator_and_node;
            run(simulator, 0.5);
            let start = position(simulator, *node);
            run(simulator, 2.0);
            let moved = position(simulator, *node).distance(start);
            let free = 0.5 * G * 4.0 * (angle.sin() - friction * angle.cos()).max(0.0);
            assert_eq!(moved > 0.25 * free.max(0.02), slides, "friction {friction}, {offset} degrees: {moved} m");
        }
    }
}

/// A wide box on a slope that is turned about y.
fn slope(angle: f32, material: Material) -> (aam_physics::Simulator, aam_scene::NodeId) {
    let mut stage = Stage::default();
    let plane = body("slope", Static, boxed(Vec3::ONE), material);
    let vertices = [(-50, -50), (50, -50), (50, 50), (-50, 50)].map(|(x, y)| Vec3::new(x as f32, y as f32, 0.0));
    let shape = aam_physics::Shape::Triangles { vertices: vertices.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]] };
    let turn = turned(Vec3::Y, angle);
    stage.place(&std::sync::Arc::new(aam_physics::PhysicsMesh { shape, ..plane }), None, turn);
    let flat = body("box", Dynamic, boxed(Vec3::new(0.5, 0.5, 0.05)), material);
    let node =
        stage.place(&std::sync::Arc::new(flat), None, turn * Affine3A::from_translation(Vec3::new(-30.0, 3.0, 0.05)));
    (stage.started(every(1.0 / 240.0)), node)
}

/// Between the two angles of friction a box at rest stays, and one that was pushed keeps sliding, faster and faster.
#[test]
fn static_and_dynamic_friction_differ() {
    let material = Material { static_friction: 0.8, dynamic_friction: 0.2, restitution: 0.0 };
    let angle = 0.5_f32.atan();
    let (mut simulator, node) = slope(angle, material);
    run(&mut simulator, 0.5);
    let start = position(&simulator, node);
    run(&mut simulator, 2.0);
    let crept = position(&simulator, node).distance(start);
    assert!(crept < 0.02, "it crept {crept} m");
    let down = turned(Vec3::Y, angle).transform_vector3(Vec3::X);
    simulator.set_velocity(node, 0.5 * down, Vec3::ZERO).expect("dynamic");
    run(&mut simulator, 1.0);
    let speed = simulator.state(node).expect("simulated").velocity.dot(down);
    let expected = 0.5 + G * (angle.sin() - 0.2 * angle.cos());
    assert!((speed / expected - 1.0).abs() < 0.05, "{speed} m/s, not {expected} m/s");
}

/// A pendulum swings with the period of a physical pendulum (within 1 %) and keeps its energy (drift over ten periods
/// below 2 %).
#[test]
fn a_pendulum_keeps_its_period_and_energy() {
    let (length, radius, amplitude) = (1.0_f32, 0.1_f32, 0.2_f32);
    let mut stage = Stage::default();
    let hang = turned(Vec3::Y, amplitude).transform_vector3(Vec3::NEG_Z * length);
    let node = stage.add(body("bob", Dynamic, ball(radius), rough(0.0)), hang);
    let mut simulator = stage.started(Settings { sleeping: false, ..every(1.0 / 480.0) });
    let hinge =
        Joint { kind: JointKind::Hinge { axis: Vec3::Y }, body: node, other: None, anchor: Vec3::ZERO, collide: false };
    simulator.add_joint(&hinge).expect("a joint");
    let arm = length * length + 0.4 * radius * radius;
    let small = std::f32::consts::TAU * (arm / (G * length)).sqrt();
    // The first terms of the series for a finite swing.
    let expected = small * (1.0 + amplitude.powi(2) / 16.0 + 11.0 * amplitude.powi(4) / 3072.0);
    let energy = |simulator: &aam_physics::Simulator| {
        let state = simulator.state(node).expect("simulated");
        let spin = 0.4 * radius * radius * state.angular_velocity.length_squared();
        0.5 * (state.velocity.length_squared() + spin) + G * (state.pose.position.z + length)
    };
    let first = energy(&simulator);
    let (mut crossings, mut before) = (Vec::new(), position(&simulator, node).x);
    while crossings.len() < 11 {
        simulator.step().expect("a good step");
        let x = position(&simulator, node).x;
        assert!((position(&simulator, node).length() - length).abs() < 2e-3, "the arm keeps its length");
        if before.signum() != x.signum() && x > 0.0 {
            crossings.push(simulator.time() as f32 - x / (x - before) / 480.0);
        }
        before = x;
        assert!(simulator.time() < 60.0, "it swings");
    }
    let period = (crossings[10] - crossings[0]) / 10.0;
    assert!((period / expected - 1.0).abs() < 0.01, "{period} s, not {expected} s");
    let drift = (energy(&simulator) / first - 1.0).abs();
    assert!(drift < 0.02, "energy drifts by {drift}");
}

/// A body that spins about its middle axis turns over again and again (Dzhanibekov), and its angular momentum stays what
/// it was: within 3 % in size and 3 degrees in direction over twenty seconds.
#[test]
fn a_tumbling_body_keeps_its_angular_momentum() {
    let half = Vec3::new(0.1, 0.3, 0.2);
    let mut stage = Stage::default();
    let node = stage.add(body("handle", Dynamic, boxed(half), rough(0.0)), Vec3::ZERO);
    let settings = Settings { gravity: Some(Vec3::ZERO), sleeping: false, ..every(1.0 / 480.0) };
    let mut simulator = stage.started(settings);
    let square = half * half;
    let inertia = Vec3::new(square.y + square.z, square.x + square.z, square.x + square.y) / 3.0;
    // The middle moment of inertia is that about z.
    assert!(inertia.y < inertia.z && inertia.z < inertia.x);
    simulator.set_velocity(node, Vec3::ZERO, Vec3::new(0.01, 0.0, 6.0)).expect("dynamic");
    let momentum = |simulator: &aam_physics::Simulator| {
        let state = simulator.state(node).expect("simulated");
        let turn = state.pose.rotation;
        turn * (inertia * (turn.inverse() * state.angular_velocity))
    };
    let first = momentum(&simulator);
    let (mut flips, mut up) = (0, true);
    for _ in 0..20 * 480 {
        simulator.step().expect("a good step");
        let upright = (simulator.state(node).expect("simulated").pose.rotation * Vec3::Z).z > 0.0;
        flips += usize::from(upright != up);
        up = upright;
    }
    let last = momentum(&simulator);
    assert!(flips >= 4, "it turned over {flips} times");
    assert!((last.length() / first.length() - 1.0).abs() < 0.03, "{first} became {last}");
    assert!(last.angle_between(first).to_degrees() < 3.0, "{first} became {last}");
}

/// A thin plate that can move stops a bullet where all bodies are swept, and else does not.
#[test]
fn bullets_hit_moving_plates_where_all_bodies_are_swept() {
    let passes = |continuous: Continuous| {
        let mut stage = Stage::default();
        let plate = body("plate", Dynamic, boxed(Vec3::new(0.005, 1.0, 1.0)), rough(0.5));
        stage.add(aam_physics::PhysicsMesh { mass: Some(100.0), ..plate }, Vec3::ZERO);
        let node = stage.add(body("bullet", Dynamic, ball(0.01), rough(0.5)), Vec3::new(-2.3, 0.1, 0.2));
        let settings = Settings { gravity: Some(Vec3::ZERO), continuous, ..every(1.0 / 60.0) };
        let mut simulator = stage.started(settings);
        simulator.set_velocity(node, Vec3::X * 300.0, Vec3::ZERO).expect("dynamic");
        run(&mut simulator, 0.2);
        position(&simulator, node).x > 10.0
    };
    assert!(passes(Continuous::Off) && passes(Continuous::Static) && !passes(Continuous::All));
}

/// A thin plate stops a bullet with continuous collision detection, and does not without.
#[test]
fn continuous_collision_stops_bullets() {
    let passes = |continuous: Continuous| {
        let mut stage = Stage::default();
        stage.add(body("plate", Static, boxed(Vec3::ONE), rough(0.5)), Vec3::ZERO);
        let vertices = [(-1, -1), (1, -1), (1, 1), (-1, 1)].map(|(y, z)| Vec3::new(0.0, y as f32, z as f32));
        stage.meshes[0].1 = std::sync::Arc::new(aam_physics::PhysicsMesh {
            shape: aam_physics::Shape::Triangles { vertices: vertices.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]] },
            ..(*stage.meshes[0].1).clone()
        });
        let node = stage.add(body("bullet", Dynamic, ball(0.01), rough(0.5)), Vec3::new(-2.3, 0.1, 0.2));
        let settings = Settings { gravity: Some(Vec3::ZERO), continuous, ..every(1.0 / 60.0) };
        let mut simulator = stage.started(settings);
        simulator.set_velocity(node, Vec3::X * 300.0, Vec3::ZERO).expect("dynamic");
        run(&mut simulator, 0.2);
        position(&simulator, node).x > 0.1
    };
    assert!(passes(Continuous::Off) && !passes(Continuous::Static) && !passes(Continuous::All));
}
