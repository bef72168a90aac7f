//! The same scene gives the same poses, on this thread and on another.

mod common;

use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use aam_physics::{Background, Collected, PhysicsError, Settings, Simulator};
use aam_scene::NodeId;
use common::{Dynamic, Stage, ball, body, bouncy, boxed, cube, every, position, rough, run, turned};
use glam::{Affine3A, Vec3};

/// Boxes and balls that fall on each other.
fn heap() -> Stage {
    let mut stage = Stage::default();
    stage.floor(rough(0.4));
    for i in 0..60_u32 {
        let spot = Vec3::new((i % 3) as f32 * 0.7, (i / 3 % 3) as f32 * 0.7, 1.0 + (i / 9) as f32 * 1.1);
        let mesh = match i % 3 {
            0 => cube(Dynamic),
            1 => body("ball", Dynamic, ball(0.4), bouncy(0.3)),
            _ => body("brick", Dynamic, boxed(Vec3::new(0.6, 0.3, 0.2)), rough(0.7)),
        };
        let turn = turned(Vec3::new(1.0, i as f32, 2.0).normalize(), i as f32);
        stage.place(&std::sync::Arc::new(mesh), None, Affine3A::from_translation(spot) * turn);
    }
    stage
}

#[test]
fn the_same_scene_has_the_same_hash_on_every_run() {
    let hash = |seconds: f64, settings: Settings| {
        let mut simulator = heap().started(settings);
        run(&mut simulator, seconds);
        simulator.hash()
    };
    let first = hash(4.0, Settings::default());
    for _ in 0..3 {
        assert_eq!(hash(4.0, Settings::default()), first);
    }
    // On another thread, and prepared again in the same simulator.
    let other = std::thread::spawn(move || hash(4.0, Settings::default())).join().expect("it ran");
    assert_eq!(other, first);
    let stage = heap();
    let mut simulator = stage.started(Settings::default());
    run(&mut simulator, 1.0);
    simulator.prepare(&stage.scene);
    simulator.start().expect("prepared");
    run(&mut simulator, 4.0);
    assert_eq!(simulator.hash(), first);
    // It tells a difference of one step, and of one setting.
    assert_ne!(hash(4.0 + 1.0 / 60.0, Settings::default()), first);
    assert_ne!(hash(4.0, Settings { iterations: 5, ..Settings::default() }), first);
}

#[test]
fn registration_in_another_order_changes_nothing() {
    let mut stage = heap();
    let mut first = stage.started(Settings::default());
    stage.meshes.reverse();
    let mut second = stage.started(Settings::default());
    run(&mut first, 1.0);
    run(&mut second, 1.0);
    assert_eq!(first.hash(), second.hash());
}

/// A cube in free fall.
fn falling() -> (Simulator, NodeId) {
    let mut stage = Stage::default();
    let node = stage.add(cube(Dynamic), Vec3::ZERO);
    (stage.started(every(0.01)), node)
}

fn frame(seconds: f64) -> Duration {
    Duration::from_secs_f64(seconds)
}

/// Waits until the steps that were asked for are done.
fn settle(background: &Background) {
    let (tell, told) = channel();
    background.act(move |_| tell.send(()).expect("somebody waits"));
    told.recv().expect("the thread works");
}

#[test]
fn r99_results_are_collected_without_waiting() {
    let (simulator, node) = falling();
    let mut background = Background::new(simulator).expect("started");
    assert_eq!(background.begin_frame(frame(0.05)), Collected::Ready);
    settle(&background);
    // The thread is kept busy: nobody waits for it, earlier poses are drawn, no step starts.
    let (open, gate) = channel::<()>();
    background.act(move |_| gate.recv().expect("it is opened"));
    assert_eq!(background.begin_frame(frame(0.05)), Collected::Ready);
    let before = background.time();
    assert!((before - 0.05).abs() < 1e-6);
    for _ in 0..10 {
        assert_eq!(background.begin_frame(frame(0.001)), Collected::NotReady);
        assert_eq!(background.time(), before);
    }
    open.send(()).expect("the thread waits");
    settle(&background);
    assert_eq!(background.begin_frame(frame(0.0)), Collected::Ready);
    assert!((background.time() - 0.10).abs() < 1e-6, "{}", background.time());
    let simulator = background.stop().expect("its thread lives");
    assert_eq!(simulator.steps(), 11, "the hundredth of a second that passed meanwhile was asked for last");
    assert!(position(&simulator, node).z < 0.0);
}

#[test]
fn r100_a_frame_collects_once_for_all_its_pictures() {
    let (simulator, _) = falling();
    let mut background = Background::new(simulator).expect("started");
    for _ in 0..5 {
        background.begin_frame(frame(0.02));
        let first = background.poses();
        settle(&background);
        // New results lie ready, and the second picture of the frame shows the same poses.
        assert_eq!(background.poses(), first);
    }
}

#[test]
fn r101_simulated_time_follows_real_time_within_a_step() {
    let (simulator, node) = falling();
    let mut background = Background::new(simulator).expect("started");
    let mut real = 0.0;
    let mut last = f32::INFINITY;
    // Frames of uneven length, shorter and longer than a step.
    for index in 0..200 {
        let elapsed = [0.004, 0.017, 0.033, 0.0, 0.0101][index % 5];
        background.begin_frame(frame(elapsed));
        real += elapsed;
        settle(&background);
        let asked = background.time();
        let poses = background.poses();
        // Results are those of the steps before; the poses are drawn one step before the frame that asked for them.
        assert!(asked <= real + 1e-9 && real - asked <= elapsed + 0.01 + 1e-9, "{asked} s at {real} s");
        let expected = real - elapsed - 0.01;
        assert!((poses.time - expected.max(0.0)).abs() < 1e-6, "{} s, not {expected} s", poses.time);
        let z = poses.poses[0].position.z;
        let fallen = -0.5 * 9.81 * poses.time * poses.time;
        assert!((f64::from(z) - fallen).abs() < 0.01 + 0.06 * poses.time, "{z} m, not {fallen} m");
        assert!(z <= last, "it moves on smoothly");
        last = z;
    }
    assert_eq!(background.left_out(), 0.0);
    // A frame of ten seconds does not ask for a thousand steps.
    background.begin_frame(frame(10.0));
    settle(&background);
    background.begin_frame(frame(0.0));
    assert!(background.left_out() > 8.9 && background.time() < real + 0.6);
    assert!(background.stop().expect("its thread lives").state(node).is_ok());
}

#[test]
fn a_simulation_in_the_background_is_the_same_and_says_when_it_breaks() {
    let mut background = Background::new(heap().started(Settings::default())).expect("started");
    for _ in 0..60 {
        background.begin_frame(frame(1.0 / 60.0));
        settle(&background);
    }
    let there = background.stop().expect("its thread lives");
    let mut here = heap().started(Settings::default());
    run(&mut here, there.time());
    assert_eq!((here.steps(), here.hash()), (there.steps(), there.hash()));

    let mut stage = Stage::default();
    let node = stage.add(cube(Dynamic), Vec3::ZERO);
    let simulator = stage.started(Settings { max_speed: 3.0, ..Settings::default() });
    let mut background = Background::new(simulator).expect("started");
    background.act(move |simulator| simulator.set_velocity(node, Vec3::X, Vec3::ZERO).expect("dynamic"));
    let stopped = (0..60).any(|_| {
        settle(&background);
        background.begin_frame(frame(0.02)) == Collected::Stopped
    });
    assert!(stopped && matches!(background.error(), Some(PhysicsError::Diverged(_))));
    assert!(background.poses().poses[0].position.is_finite());
    let unstarted = Simulator::new(Settings::default(), aam_physics::Registration::Manual).expect("settings");
    assert!(Background::new(unstarted).is_err());
}

#[test]
fn r98_steps_run_while_a_frame_is_drawn() {
    // Steps that rest, as many as a frame: beside one another they take one of both, not the sum.
    let (simulator, _) = falling();
    let mut background = Background::new(simulator).expect("started");
    let work = Duration::from_millis(40);
    let start = Instant::now();
    for _ in 0..10 {
        background.act(move |_| std::thread::sleep(work));
        let begun = Instant::now();
        background.begin_frame(frame(0.04));
        assert!(begun.elapsed() < work / 2, "nobody waits for the step");
        std::thread::sleep(work);
    }
    settle(&background);
    assert!(start.elapsed() < 17 * work, "{:?} for ten frames of {work:?}", start.elapsed());
}

#[test]
fn a_pause_stops_time_and_a_step_goes_on_by_one() {
    let (simulator, _) = falling();
    let mut background = Background::new(simulator).expect("started");
    background.begin_frame(frame(0.05));
    while background.is_moving() {
        background.begin_frame(Duration::ZERO);
    }
    let paused = (background.time(), background.poses());
    for _ in 0..20 {
        background.begin_frame(Duration::ZERO);
        settle(&background);
    }
    assert_eq!((background.time(), background.poses()), paused);
    background.begin_frame(frame(0.01));
    while background.is_moving() {
        background.begin_frame(Duration::ZERO);
    }
    assert!((background.time() - paused.0 - 0.01).abs() < 1e-6);
    assert!((background.poses().time - paused.1.time - 0.01).abs() < 1e-6);
    assert!(!background.is_moving());
}

#[test]
fn steps_that_are_slower_than_real_time_give_slow_motion() {
    let (simulator, _) = falling();
    let mut background = Background::new(simulator).expect("started");
    let mut last = 0.0;
    for _ in 0..100 {
        // Three frames pass before the results are there.
        let (open, gate) = channel::<()>();
        background.act(move |_| gate.recv().expect("it is opened"));
        background.begin_frame(frame(0.016));
        assert!(background.time() - last < 0.031, "{} s at once", background.time() - last);
        last = background.time();
        for _ in 0..2 {
            assert_eq!(background.begin_frame(frame(0.016)), Collected::NotReady);
        }
        open.send(()).expect("the thread waits");
        settle(&background);
    }
    assert!(background.left_out() > 0.5 && last > 2.5, "{} s left out, {last} s", background.left_out());
}

#[test]
fn what_the_window_shows_comes_with_the_results() {
    let mut stage = Stage::default();
    stage.floor(rough(0.5));
    let node = stage.add(cube(Dynamic), Vec3::Z * 0.5);
    let mut background = Background::new(stage.started(every(0.01))).expect("started");
    background.show_contacts(true);
    background.act(move |simulator| simulator.grab(node, Vec3::Z).expect("dynamic"));
    for _ in 0..40 {
        background.begin_frame(frame(0.05));
        settle(&background);
    }
    background.begin_frame(Duration::ZERO);
    assert!(!background.contacts().is_empty() && background.grabbed().is_some());
    assert_eq!(background.sleeping().len(), 2);
    let places = background.transforms(&stage.scene);
    assert!((places[1].translation.z - 0.5).abs() < 0.01);
    background.act(Simulator::release);
    background.show_contacts(false);
    for _ in 0..60 {
        background.begin_frame(frame(0.05));
        settle(&background);
    }
    background.begin_frame(Duration::ZERO);
    assert!(background.contacts().is_empty() && background.grabbed().is_none());
    assert!(background.sleeping()[1], "it came to rest");
}
