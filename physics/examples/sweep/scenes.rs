//! The scenes that are swept. Each gives `add` the sweep, the variant, the parameter and what was measured.

use std::sync::{Arc, LazyLock};
use std::time::Instant;

use aam_physics::{Continuous, Joint, JointKind, PhysicsMesh, Settings, Shape, Simulator};
use aam_scene::NodeId;
use glam::{Affine3A, Vec3};

use crate::laws::{bounce, slid};
use crate::stage::{Dynamic, Stage, Static, ball, body, boxed, cube, position, rough};

pub(crate) type Add<'a> = dyn FnMut(&str, &str, f64, f64) + 'a;

pub(crate) const STEPS: [f32; 9] =
    [1e-3, 2e-3, 1.0 / 240.0, 1.0 / 120.0, 1.0 / 60.0, 1.0 / 40.0, 1.0 / 30.0, 1.0 / 20.0, 1.0 / 10.0];
pub(crate) const G: f32 = 9.81;
/// Farther off its place than this, a box counts as fallen: in per cent of a box.
const FALLEN: f64 = 50.0;

pub(crate) fn every(time_step: f32) -> Settings {
    Settings { time_step, ..Settings::default() }
}

/// Seconds that this thread has worked, which other work on the machine does not lengthen; where the system does not say,
/// seconds on the clock.
fn worked() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.elapsed().as_secs_f64(), |nanoseconds| 1e-9 * nanoseconds)
}

/// A simulation is repeated from its start until it has worked so many seconds: the system's count goes by ticks.
const MEASURED: f64 = 0.2;
const REPEATS: u32 = 400;
/// Less work than this is not measured well enough to be told.
const MEASURABLE: f64 = 0.02;

/// Adds the mean cost in milliseconds for each of `count` seconds or steps.
fn add_cost(add: &mut Add<'_>, sweep: &str, variant: &str, x: f64, count: f64, spent: impl Fn() -> f64) {
    let (mut all, mut runs) = (0.0, 0);
    while all < MEASURED && runs < REPEATS {
        all += spent();
        runs += 1;
    }
    if all > MEASURABLE {
        add(sweep, variant, x, 1e3 * all / (f64::from(runs) * count));
    }
}

/// Steps for a time; false if it was stopped. Gives the seconds of work that it took.
pub(crate) fn run(simulator: &mut Simulator, seconds: f64) -> (bool, f64) {
    let start = worked();
    let steps = (seconds / f64::from(simulator.settings().time_step)).round().max(1.0) as u64;
    let whole = (0..steps).all(|_| simulator.step().is_ok());
    (whole, worked() - start)
}

pub(crate) fn percent(value: f32, expected: f32) -> f64 {
    100.0 * f64::from((value / expected - 1.0).abs())
}

/// An error that is infinite where a simulation was stopped or fell apart.
fn or_broken(whole: bool, error: f64) -> f64 {
    if whole && error.is_finite() && error < FALLEN { error } else { f64::INFINITY }
}

pub(crate) fn steps(add: &mut Add<'_>) {
    for step in STEPS {
        let mut stage = Stage::default();
        let node = stage.add(cube(Dynamic), Vec3::ZERO);
        let mut simulator = stage.started(every(step));
        run(&mut simulator, 2.0);
        let time = simulator.time() as f32;
        add("step", "free fall, 2 s", step.into(), percent(position(&simulator, node).z, -0.5 * G * time * time));

        add("step", "sliding distance", step.into(), percent(slid(step, 0.3), 9.0 / (0.6 * G)));
        add("step", "bounce height", step.into(), percent(bounce(step, 0.8), 0.64));
        let (drift, period) = pendulum(step);
        add("step", "pendulum period", step.into(), period);
        add("step", "pendulum energy, 10 s", step.into(), drift);

        add_cost(add, "step-cost", "20 boxes, awake", step.into(), 2.0, || {
            run(&mut tower(20, 1.0).0.started(Settings { sleeping: false, ..every(step) }), 2.0).1
        });
    }
}

/// Change of energy over ten seconds, and error of the period, in per cent.
fn pendulum(step: f32) -> (f64, f64) {
    let (radius, amplitude) = (0.1_f32, 0.2_f32);
    let mut stage = Stage::default();
    let hang = Vec3::new(-amplitude.sin(), 0.0, -amplitude.cos());
    let node = stage.add(body("bob", Dynamic, ball(radius), rough(0.0)), hang);
    let mut simulator = stage.started(Settings { sleeping: false, ..every(step) });
    let hinge = JointKind::Hinge { axis: Vec3::Y };
    let joint = Joint { kind: hinge, body: node, other: None, anchor: Vec3::ZERO, collide: false };
    simulator.add_joint(&joint).expect("a joint");
    let energy = |simulator: &Simulator| {
        let state = simulator.state(node).expect("simulated");
        let spin = 0.4 * radius * radius * state.angular_velocity.length_squared();
        0.5 * (state.velocity.length_squared() + spin) + G * (state.pose.position.z + 1.0)
    };
    let first = energy(&simulator);
    let (mut crossings, mut before) = (Vec::new(), hang.x);
    while simulator.time() < 10.0 && simulator.step().is_ok() {
        let x = position(&simulator, node).x;
        if before < 0.0 && x >= 0.0 {
            crossings.push(simulator.time() as f32 - x / (x - before) * step);
        }
        before = x;
    }
    let arm = 1.0 + 0.4 * radius * radius;
    let expected = std::f32::consts::TAU * (arm / G).sqrt() * (1.0 + amplitude.powi(2) / 16.0);
    let period = match crossings[..] {
        [first, .., last] => percent((last - first) / (crossings.len() - 1) as f32, expected),
        _ => f64::INFINITY,
    };
    (percent(energy(&simulator), first), period)
}

/// Boxes of this size on each other.
fn tower(count: usize, size: f32) -> (Stage, NodeId) {
    let mut stage = Stage::default();
    stage.floor(rough(0.5));
    let mesh = Arc::new(body("box", Dynamic, boxed(Vec3::splat(0.5 * size)), rough(0.5)));
    let mut top = NodeId(0);
    for index in 0..count {
        top = stage.place(&mesh, None, Affine3A::from_translation(Vec3::Z * size * (index as f32 + 0.5)));
    }
    (stage, top)
}

/// How far the top box of a tower is off its place after a time, in per cent of a box.
fn tower_error(count: usize, size: f32, seconds: f64, settings: Settings) -> f64 {
    let (stage, top) = tower(count, size);
    let mut simulator = stage.started(settings);
    let (whole, _) = run(&mut simulator, seconds);
    let off = position(&simulator, top).distance(Vec3::Z * size * (count as f32 - 0.5));
    or_broken(whole, 100.0 * f64::from(off / size))
}

pub(crate) fn iterations(add: &mut Add<'_>) {
    for iterations in [1, 2, 4, 8, 16, 32, 64] {
        let settings = Settings { iterations, sleeping: false, ..Settings::default() };
        let x = iterations as f64;
        add("iterations", "20 boxes on each other", x, tower_error(20, 1.0, 5.0, settings));
        add("iterations", "mass 100 on a box", x, heavy(100.0, settings));
        add("iterations", "mass 100 on a chain", x, chain(100.0, settings));
        add_cost(add, "iterations-cost", "20 boxes, awake", x, 2.0, || {
            run(&mut tower(20, 1.0).0.started(settings), 2.0).1
        });
    }
}

pub(crate) fn stacks(add: &mut Add<'_>) {
    let settings = |step: f32, iterations| Settings { iterations, sleeping: false, ..every(step) };
    for count in [2, 3, 5, 10, 20, 30, 50, 70, 100] {
        for (variant, settings) in [
            ("1/60 s, 4 iterations", settings(1.0 / 60.0, 4)),
            ("1/60 s, 16 iterations", settings(1.0 / 60.0, 16)),
            ("1/240 s, 4 iterations", settings(1.0 / 240.0, 4)),
        ] {
            add("stack", variant, count as f64, tower_error(count, 1.0, 10.0, settings));
        }
    }
    for step in STEPS {
        for (variant, iterations) in [("4 iterations", 4), ("16 iterations", 16)] {
            add("stack-step", variant, step.into(), tower_error(10, 1.0, 5.0, settings(step, iterations)));
        }
    }
}

/// How far a heavy box sinks or moves on a light one, in per cent of a box.
fn heavy(ratio: f32, settings: Settings) -> f64 {
    let mut stage = Stage::default();
    stage.floor(rough(0.5));
    stage.add(cube(Dynamic), Vec3::Z * 0.5);
    let node = stage.add(PhysicsMesh { mass: Some(ratio), ..cube(Dynamic) }, Vec3::Z * 1.5);
    let mut simulator = stage.started(settings);
    let (whole, _) = run(&mut simulator, 5.0);
    or_broken(whole, 100.0 * f64::from(position(&simulator, node).distance(Vec3::Z * 1.5)))
}

/// How much longer a chain of ten links of a kilogram is that bears a heavy ball, in per cent.
fn chain(ratio: f32, settings: Settings) -> f64 {
    let mut stage = Stage::default();
    let link = Arc::new(body("link", Dynamic, boxed(Vec3::new(0.1, 0.1, 0.4)), rough(0.5)));
    let mut links: Vec<NodeId> = (0..10)
        .map(|index| stage.place(&link, None, Affine3A::from_translation(Vec3::Z * -(index as f32 + 0.5))))
        .collect();
    let weight = PhysicsMesh { mass: Some(ratio), ..body("weight", Dynamic, ball(0.5), rough(0.5)) };
    links.push(stage.add(weight, Vec3::Z * -10.5));
    let mut simulator = stage.started(settings);
    for (index, node) in links.iter().enumerate() {
        let other = index.checked_sub(1).map(|before| links[before]);
        let anchor = Vec3::Z * -(index as f32);
        let joint = Joint { kind: JointKind::Ball, body: *node, other, anchor, collide: false };
        simulator.add_joint(&joint).expect("a joint");
    }
    let (whole, _) = run(&mut simulator, 5.0);
    or_broken(whole, percent(position(&simulator, links[10]).length(), 10.5))
}

pub(crate) fn masses(add: &mut Add<'_>) {
    for ratio in [1.0_f32, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4] {
        for (variant, step, iterations) in [
            ("1/60 s, 4 iterations", 1.0 / 60.0, 4),
            ("1/60 s, 64 iterations", 1.0 / 60.0, 64),
            ("1/240 s, 16 iterations", 1.0 / 240.0, 16),
        ] {
            let settings = Settings { iterations, sleeping: false, ..every(step) };
            add("mass", variant, ratio.into(), heavy(ratio, settings));
            add("chain", variant, ratio.into(), chain(ratio, settings));
        }
    }
}

/// The share of bullets that pass a plate, in per cent. Their ways differ a little.
fn passing(speed: f32, thin: bool, continuous: Continuous) -> f64 {
    let mut stage = Stage::default();
    let plate = if thin {
        let vertices = [(-9, -9), (9, -9), (9, 9), (-9, 9)].map(|(y, z)| Vec3::new(0.0, y as f32, z as f32)).to_vec();
        let shape = Shape::Triangles { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] };
        PhysicsMesh { shape, ..cube(Static) }
    } else {
        PhysicsMesh { mass: Some(1e4), ..body("plate", Dynamic, boxed(Vec3::new(0.005, 9.0, 9.0)), rough(0.5)) }
    };
    stage.add(plate, Vec3::ZERO);
    let mesh = Arc::new(body("bullet", Dynamic, ball(0.01), rough(0.5)));
    let bullets: Vec<NodeId> = (0..40)
        .map(|index| {
            let place = Vec3::new(-1.0 - 0.173 * index as f32, (index % 8) as f32 - 3.5, (index / 8) as f32 - 2.5);
            stage.place(&mesh, None, Affine3A::from_translation(place))
        })
        .collect();
    let settings = Settings { gravity: Some(Vec3::ZERO), continuous, ..Settings::default() };
    let mut simulator = stage.started(settings);
    for bullet in &bullets {
        simulator.set_velocity(*bullet, Vec3::X * speed, Vec3::ZERO).expect("dynamic");
    }
    let (whole, _) = run(&mut simulator, f64::from(20.0 / speed) + 0.1);
    let passed = bullets.iter().filter(|bullet| position(&simulator, **bullet).x > 0.1).count();
    if whole { 100.0 * passed as f64 / bullets.len() as f64 } else { f64::INFINITY }
}

pub(crate) fn bullets(add: &mut Add<'_>) {
    for speed in [0.3_f32, 1.0, 2.0, 3.0, 5.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0] {
        for (word, thin) in [("static triangle", true), ("moving 1 cm", false)] {
            let kinds = [("off", Continuous::Off), ("static", Continuous::Static), ("all", Continuous::All)];
            for (name, continuous) in kinds {
                add("bullet", &format!("{word}: {name}"), speed.into(), passing(speed, thin, continuous));
            }
        }
    }
}

pub(crate) fn scales(add: &mut Add<'_>) {
    for power in -6..=6 {
        let size = 10_f32.powf(0.5 * power as f32);
        for (variant, length_unit, step) in [
            ("unit 1 m, 1/60 s", Some(1.0), 1.0 / 60.0),
            ("unit from the bodies, 1/60 s", None, 1.0 / 60.0),
            ("unit from the bodies, 1/1000 s", None, 1e-3),
        ] {
            // What is large takes longer to come to rest.
            let seconds = 5.0 * f64::from(size.sqrt()).max(1.0);
            let settings = Settings { length_unit, ..every(step) };
            add("scale", variant, size.into(), tower_error(5, size, seconds, settings));
        }
    }
}

pub(crate) fn many(add: &mut Add<'_>) {
    for count in [10_usize, 30, 100, 300, 1000, 3000, 10_000] {
        let mut stage = Stage::default();
        stage.floor(rough(0.5));
        let mesh = Arc::new(body("box", Dynamic, boxed(Vec3::splat(0.25)), rough(0.5)));
        let side = ((count as f32 / 4.0).cbrt().ceil() as usize).max(2) * 2;
        for index in 0..count {
            let (x, y, z) = (index % side, index / side % side, index / side / side);
            let shift = 0.05 * ((index * 7919) % 13) as f32 / 13.0;
            let place = Vec3::new(0.55 * x as f32 + shift, 0.55 * y as f32 - shift, 0.6 + 0.7 * z as f32);
            stage.place(&mesh, None, Affine3A::from_translation(place));
        }
        // The same heap again, once to look and then to measure.
        let (first, last) = (2.0, if count > 3000 { 2.0 } else { 8.0 });
        let fallen = |asleep: bool| {
            let mut simulator = stage.started(Settings::default());
            let (whole, spent) = run(&mut simulator, first);
            let (stays, later) = if asleep { run(&mut simulator, last) } else { (true, 0.0) };
            if whole && stays { if asleep { later } else { spent } } else { f64::INFINITY }
        };
        let resting = if count > 3000 { "next 2 s" } else { "next 8 s" };
        add_cost(add, "many", "falling, first 2 s", count as f64, 60.0 * first, || fallen(false));
        add_cost(add, "many", resting, count as f64, 60.0 * last, || fallen(true));
    }
}
