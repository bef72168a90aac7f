//! Simulations against closed forms, each over what its law depends on.

use aam_physics::{Settings, Simulator};
use glam::{Affine3A, Quat, Vec3};

use crate::scenes::{Add, G, STEPS, every, percent, run};
use crate::stage::{Dynamic, Stage, ball, body, bouncy, boxed, position, rough};

const COEFFICIENTS: [f32; 10] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];

/// Steps that are compared, with their names.
const NAMED: [(&str, f32); 3] = [("1/60 s", 1.0 / 60.0), ("1/240 s", 1.0 / 240.0), ("1/1000 s", 1e-3)];

/// The height of the first bounce against e² h.
pub(crate) fn restitution(add: &mut Add<'_>) {
    for (name, step) in NAMED {
        for e in COEFFICIENTS {
            add("restitution", name, e.into(), 100.0 * f64::from((bounce(step, e) - e * e).abs()));
        }
    }
}

/// How high a ball that fell a metre rises again, in metres.
pub(crate) fn bounce(step: f32, e: f32) -> f32 {
    let mut stage = Stage::default();
    stage.floor(bouncy(e));
    let node = stage.add(body("ball", Dynamic, ball(0.1), bouncy(e)), Vec3::new(0.3, 0.1, 1.1));
    let mut simulator = stage.started(every(step));
    let (mut top, mut risen) = (0.0_f32, false);
    while simulator.time() < 1.4 && simulator.step().is_ok() {
        let state = simulator.state(node).expect("simulated");
        risen |= state.velocity.z > 0.0;
        top = if risen { top.max(state.pose.position.z - 0.1) } else { top };
    }
    top
}

/// The way that a box slides at 3 m/s against v² / 2 μ g, and the slope on which one starts to slide against atan μ.
pub(crate) fn friction(add: &mut Add<'_>) {
    for (name, step) in NAMED {
        for friction in COEFFICIENTS {
            let x = friction.into();
            add("friction", name, x, percent(slid(step, friction), 9.0 / (2.0 * friction * G)));
            let slope = critical_slope(step, friction).to_degrees() - friction.atan().to_degrees();
            add("slope", name, x, f64::from(slope.abs()));
        }
    }
}

/// How far a box slides that starts at 3 m/s.
pub(crate) fn slid(step: f32, friction: f32) -> f32 {
    let mut stage = Stage::default();
    stage.floor(rough(friction));
    let node = stage.add(body("box", Dynamic, boxed(Vec3::new(0.5, 0.5, 0.1)), rough(friction)), Vec3::Z * 0.1);
    let mut simulator = stage.started(every(step));
    run(&mut simulator, 0.5);
    let start = position(&simulator, node).x;
    simulator.set_velocity(node, Vec3::X * 3.0, Vec3::ZERO).expect("dynamic");
    run(&mut simulator, f64::from(3.0 / (friction * G)) + 1.0);
    position(&simulator, node).x - start
}

/// The steepest slope, in radians, on which a flat box stays within a centimetre for two seconds.
fn critical_slope(step: f32, friction: f32) -> f32 {
    let (mut holds, mut slides) = (0.0_f32, 1.4_f32);
    while slides - holds > 5e-4 {
        let angle = 0.5 * (holds + slides);
        let mut stage = Stage::default();
        stage.floor(rough(friction));
        let flat = boxed(Vec3::new(0.5, 0.5, 0.05));
        let node = stage.add(body("box", Dynamic, flat, rough(friction)), Vec3::Z * 0.05);
        // Gravity is tilted in place of the floor.
        let gravity = Some(G * Vec3::new(angle.sin(), 0.0, -angle.cos()));
        let mut simulator = stage.started(Settings { gravity, ..every(step) });
        run(&mut simulator, 2.0);
        if position(&simulator, node).x < 0.01 { holds = angle } else { slides = angle }
    }
    0.5 * (holds + slides)
}

/// What a body that turns over about its middle axis (Dzhanibekov) loses of its momentum and energy in 20 s.
pub(crate) fn spin(add: &mut Add<'_>) {
    let half = Vec3::new(0.1, 0.5, 0.3);
    let square = half * half;
    let inertia = Vec3::new(square.y + square.z, square.x + square.z, square.x + square.y) / 3.0;
    for step in STEPS {
        let mut stage = Stage::default();
        let mesh = std::sync::Arc::new(body("body", Dynamic, boxed(half), rough(0.5)));
        let node = stage.place(&mesh, None, Affine3A::from_quat(Quat::from_rotation_x(0.3)));
        let mut simulator = stage.started(Settings { gravity: Some(Vec3::ZERO), sleeping: false, ..every(step) });
        // The middle moment of inertia is that about z.
        let spin = Quat::from_rotation_x(0.3) * Vec3::new(0.01, 0.01, 5.0);
        simulator.set_velocity(node, Vec3::ZERO, spin).expect("dynamic");
        let state = |simulator: &Simulator| {
            let state = simulator.state(node).expect("simulated");
            let turn = state.pose.rotation;
            let local = turn.inverse() * state.angular_velocity;
            (turn * (inertia * local), 0.5 * local.dot(inertia * local))
        };
        let (momentum, energy) = state(&simulator);
        run(&mut simulator, 20.0);
        let (after, left) = state(&simulator);
        let x = step.into();
        add("spin", "momentum, %", x, percent(after.length(), momentum.length()));
        add("spin", "its direction, degrees", x, f64::from(after.angle_between(momentum).to_degrees()));
        add("spin", "energy, %", x, percent(left, energy));
    }
}
