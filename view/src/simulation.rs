//! The bodies of the file, simulated beside drawing.

use std::sync::Arc;
use std::time::Duration;

use aam_physics::{Background, Collected, Contact, PhysicsMesh, Poses, Registration, Settings, Simulator};
use aam_scene::{NodeId, Scene};
use glam::{Affine3A, Vec3};

/// A simulation that may run. Nothing of it exists before it is first started.
#[derive(Default)]
pub(crate) struct Simulation {
    running: Option<Running>,
    pub(crate) playing: bool,
    /// Counts the poses that were shown, for caches.
    pub(crate) revision: u64,
}

struct Running {
    background: Background,
    /// The simulated nodes, in the order of poses, and whether each is dynamic.
    bodies: Vec<(NodeId, bool)>,
    time_step: Duration,
    shown: Poses,
    /// Single steps that were asked for.
    owed: u32,
    /// The time before this frame was not simulated.
    fresh: bool,
    hold: Option<Hold>,
    told: bool,
}

/// What the pointer holds.
#[derive(Clone, Copy)]
struct Hold {
    point: Vec3,
    /// Across the view: the hand moves in this plane.
    normal: Vec3,
}

/// What a frame of the simulation changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Advanced {
    /// Bodies are drawn elsewhere than before.
    pub(crate) moved: bool,
    /// Another frame is needed.
    pub(crate) again: bool,
    /// It was stopped, and why: said once.
    pub(crate) stopped: Option<String>,
}

impl Simulation {
    /// Plays or pauses, starting it first where that is needed; gives what is to be said.
    ///
    /// # Errors
    /// No body can be simulated, as a sentence.
    pub(crate) fn toggle(
        &mut self,
        bodies: &[(NodeId, Arc<PhysicsMesh>)],
        scene: &Scene,
    ) -> Result<Option<String>, String> {
        let said = self.start(bodies, scene)?;
        self.playing = !self.playing;
        if let Some(running) = &mut self.running {
            running.fresh = true;
        }
        Ok(said)
    }

    /// Pauses and goes on by one step.
    ///
    /// # Errors
    /// No body can be simulated, as a sentence.
    pub(crate) fn step(
        &mut self,
        bodies: &[(NodeId, Arc<PhysicsMesh>)],
        scene: &Scene,
    ) -> Result<Option<String>, String> {
        let said = self.start(bodies, scene)?;
        self.playing = false;
        if let Some(running) = &mut self.running {
            running.owed += 1;
        }
        Ok(said)
    }

    /// Everything is where it was before.
    pub(crate) fn reset(&mut self) {
        self.running = None;
        self.playing = false;
        self.revision += 1;
    }

    fn start(&mut self, bodies: &[(NodeId, Arc<PhysicsMesh>)], scene: &Scene) -> Result<Option<String>, String> {
        if self.running.is_some() {
            return Ok(None);
        }
        if bodies.is_empty() {
            return Err("This file has no bodies; aam convert --physics makes some.".into());
        }
        let text = |error: aam_physics::PhysicsError| error.to_string();
        let mut simulator = Simulator::new(Settings::default(), Registration::Automatic).map_err(text)?;
        for (node, mesh) in bodies {
            simulator.object_created(*node, mesh);
        }
        let findings = simulator.prepare(scene);
        simulator.start().map_err(text)?;
        let said = findings.first().map(|finding| format!("{}: {}", finding.subject, finding.message));
        let modes = simulator.bodies().map(|node| {
            let dynamic = |state: aam_physics::BodyState| state.mode == aam_physics::BodyMode::Dynamic;
            (node, simulator.state(node).is_ok_and(dynamic))
        });
        let bodies: Vec<(NodeId, bool)> = modes.collect();
        if bodies.is_empty() {
            return Err(said.unwrap_or_else(|| "No body of this file can be simulated.".into()));
        }
        let time_step = Duration::from_secs_f32(simulator.settings().time_step);
        let shown = simulator.poses();
        let background = Background::new(simulator).map_err(text)?;
        let running = Running { background, bodies, time_step, shown, owed: 0, fresh: true, hold: None, told: false };
        self.running = Some(running);
        Ok(said)
    }

    /// Whether it was started, playing or not.
    pub(crate) fn is_started(&self) -> bool {
        self.running.is_some()
    }

    /// Lets time pass.
    pub(crate) fn advance(&mut self, time: Duration, contacts: bool) -> Advanced {
        let Some(running) = &mut self.running else { return Advanced::default() };
        running.background.show_contacts(contacts);
        let fresh = std::mem::take(&mut running.fresh);
        let resting = running.is_at_rest();
        let elapsed = match (self.playing, running.owed) {
            (true, _) if !fresh && !resting => time,
            (false, 1..) => {
                running.owed -= 1;
                running.time_step
            }
            _ => Duration::ZERO,
        };
        let collected = running.background.begin_frame(elapsed);
        let poses = running.background.poses();
        let mut advanced = Advanced {
            moved: poses.poses != running.shown.poses,
            again: running.owed > 0 || running.background.is_moving() || self.playing && !resting,
            stopped: None,
        };
        running.shown = poses;
        if collected == Collected::Stopped {
            self.playing = false;
            advanced.again = false;
            if !std::mem::replace(&mut running.told, true) {
                advanced.stopped = running.background.error().map(ToString::to_string);
            }
        }
        self.revision += u64::from(advanced.moved);
        advanced
    }

    /// Node to world for every node, if it was started.
    pub(crate) fn transforms(&self, scene: &Scene) -> Option<Vec<Affine3A>> {
        self.running.as_ref().map(|running| running.background.transforms(scene))
    }

    /// Takes hold of the body that a node is or hangs from, at a point; false if there is none that moves.
    pub(crate) fn grab(&mut self, scene: &Scene, node: NodeId, point: Vec3, normal: Vec3) -> bool {
        let Some(running) = &mut self.running else { return false };
        let mut here = Some(node);
        let body = loop {
            let Some(node) = here else { return false };
            if running.bodies.iter().any(|(body, _)| *body == node) {
                break node;
            }
            // A parent stands before its child, so that this ends.
            here = scene.nodes.get(node.index()).and_then(|found| found.parent).filter(|parent| *parent < node);
        };
        running.hold = Some(Hold { point, normal });
        // A static body refuses, and then nothing is held.
        running.background.act(move |simulator| drop(simulator.grab(body, point)));
        true
    }

    /// Pulls what is held to where a ray of the pointer meets the plane of the hand.
    pub(crate) fn pull(&mut self, origin: Vec3, direction: Vec3) {
        let Some(running) = &mut self.running else { return };
        let Some(hold) = running.hold else { return };
        let share = (hold.point - origin).dot(hold.normal) / direction.dot(hold.normal);
        let hand = origin + direction * share;
        if share > 0.0 && hand.is_finite() {
            running.background.act(move |simulator| drop(simulator.pull_to(hand)));
        }
    }

    /// Lets go.
    pub(crate) fn release(&mut self) {
        if let Some(running) = self.running.as_mut().filter(|running| running.hold.is_some()) {
            running.hold = None;
            running.background.act(Simulator::release);
        }
    }

    /// Whether something is held.
    pub(crate) fn is_holding(&self) -> bool {
        self.running.as_ref().is_some_and(|running| running.hold.is_some())
    }

    /// Where bodies press on each other, if that was asked for.
    pub(crate) fn contacts(&self) -> &[Contact] {
        self.running.as_ref().map_or(&[], |running| running.background.contacts())
    }

    /// The held point and the hand.
    pub(crate) fn grabbed(&self) -> Option<[Vec3; 2]> {
        self.running.as_ref().filter(|running| running.hold.is_some())?.background.grabbed()
    }

    /// Each dynamic body, and whether it sleeps.
    pub(crate) fn dynamic(&self) -> impl Iterator<Item = (NodeId, bool)> {
        let bodies = self.running.iter().flat_map(|running| running.bodies.iter().zip(running.background.sleeping()));
        bodies.filter(|((_, dynamic), _)| *dynamic).map(|((node, _), asleep)| (*node, *asleep))
    }

    /// What it does now, for people.
    pub(crate) fn status(&self) -> String {
        let Some(running) = &self.running else { return String::new() };
        let (all, asleep) =
            self.dynamic().fold((0, 0), |(all, asleep), (_, sleeps)| (all + 1, asleep + usize::from(sleeps)));
        let background = &running.background;
        let mut text = format!("{:.2} s   {asleep} of {all} asleep", background.time());
        let step = background.step_time();
        if !step.is_zero() {
            text += &format!("   {:.2} ms a step", 1e3 * step.as_secs_f64());
        }
        if background.error().is_some() {
            text += "   stopped";
        } else if step > running.time_step {
            text += "   slower than real time";
        }
        text
    }
}

impl Running {
    /// Nothing will move unless somebody acts.
    fn is_at_rest(&self) -> bool {
        let asleep = |((_, dynamic), asleep): (&(NodeId, bool), &bool)| !dynamic || *asleep;
        self.hold.is_none() && self.bodies.iter().zip(self.background.sleeping()).all(asleep)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use aam_physics::{BodyMode, Material, Shape};
    use aam_scene::{Node, Up};

    use super::*;

    /// A ball above a kinematic box, each with a child.
    fn ball_over_box() -> (Scene, Vec<(NodeId, Arc<PhysicsMesh>)>) {
        let primitive = |round: bool| match round {
            true => aam_physics::Primitive::Sphere { center: [0.0; 3], radius: 0.5 },
            false => aam_physics::Primitive::Box { center: [0.0; 3], orientation: [0.0; 4], half: [2.0, 2.0, 0.5] },
        };
        let mesh = |name: &str, mode, round| {
            let shape = Shape::Compound { primitives: vec![primitive(round)], pieces: vec![] };
            let mass = (mode == BodyMode::Dynamic).then_some(1.0);
            Arc::new(PhysicsMesh { name: name.into(), mode, material: Material::default(), mass, shape })
        };
        let node = |parent, z| Node {
            name: "node".into(),
            parent,
            local: Affine3A::from_translation(Vec3::Z * z),
            mesh: None,
            visible: true,
        };
        let nodes = vec![node(None, -0.5), node(None, 1.0), node(Some(NodeId(1)), 0.1)];
        let scene = Scene { up: Up::Z, nodes, ..Scene::default() };
        let bodies = vec![
            (NodeId(0), mesh("box", BodyMode::Kinematic, false)),
            (NodeId(1), mesh("ball", BodyMode::Dynamic, true)),
        ];
        (scene, bodies)
    }

    fn height(simulation: &Simulation, scene: &Scene, node: usize) -> f32 {
        simulation.transforms(scene).expect("it was started")[node].translation.z
    }

    /// Frames of 10 ms until a condition holds.
    fn run_until(simulation: &mut Simulation, what: &str, mut condition: impl FnMut(&Simulation, &Advanced) -> bool) {
        let start = Instant::now();
        loop {
            let advanced = simulation.advance(Duration::from_millis(10), true);
            if condition(simulation, &advanced) {
                return;
            }
            assert!(start.elapsed() < Duration::from_secs(20), "waited in vain for {what}");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn it_plays_rests_and_starts_again() {
        let (scene, bodies) = ball_over_box();
        let mut simulation = Simulation::default();
        assert!(simulation.transforms(&scene).is_none(), "nothing exists before it is started");
        assert_eq!(simulation.toggle(&bodies, &scene), Ok(None));
        run_until(&mut simulation, "rest", |simulation, advanced| {
            !advanced.again && simulation.dynamic().all(|(_, asleep)| asleep)
        });
        assert!((height(&simulation, &scene, 1) - 0.5).abs() < 0.02);
        assert!((height(&simulation, &scene, 2) - 0.6).abs() < 0.02, "what hangs on a body follows it");
        assert!(simulation.status().contains("1 of 1 asleep"), "{}", simulation.status());
        simulation.reset();
        assert!(simulation.transforms(&scene).is_none() && !simulation.playing);
    }

    #[test]
    fn a_pause_holds_and_steps_go_one_by_one() {
        let (scene, bodies) = ball_over_box();
        let mut simulation = Simulation::default();
        for _ in 0..6 {
            simulation.step(&bodies, &scene).expect("bodies");
        }
        run_until(&mut simulation, "six steps", |_, advanced| !advanced.again);
        // What is shown is one step behind.
        let fallen = 1.0 - height(&simulation, &scene, 1);
        let expected = 0.5 * 9.81 * (5.0_f32 / 60.0).powi(2);
        assert!((fallen - expected).abs() < 0.01, "{fallen} m after five steps, not {expected} m");
        let before = simulation.revision;
        assert_eq!(simulation.advance(Duration::from_secs(1), false), Advanced::default());
        assert_eq!(simulation.revision, before);
    }

    #[test]
    fn the_pointer_lifts_a_body_by_its_child_and_lets_it_fall() {
        let (scene, bodies) = ball_over_box();
        let mut simulation = Simulation::default();
        simulation.toggle(&bodies, &scene).expect("bodies");
        assert!(simulation.grab(&scene, NodeId(2), Vec3::new(0.0, 0.0, 1.5), Vec3::Y));
        assert!(!simulation.grab(&scene, NodeId(7), Vec3::ZERO, Vec3::Y), "there is no such node");
        // From the front, to a height of 3 m in the plane of the hand.
        simulation.pull(Vec3::new(0.0, -10.0, 3.0), Vec3::Y);
        run_until(&mut simulation, "the lift", |simulation, _| height(simulation, &scene, 1) > 2.3);
        assert!(simulation.is_holding() && simulation.grabbed().is_some());
        simulation.release();
        run_until(&mut simulation, "the fall", |simulation, _| height(simulation, &scene, 1) < 0.6);
        run_until(&mut simulation, "contacts", |simulation, _| !simulation.contacts().is_empty());
        assert!(simulation.grabbed().is_none());
    }

    #[test]
    fn what_cannot_run_says_why() {
        let (mut scene, bodies) = ball_over_box();
        let mut simulation = Simulation::default();
        assert!(simulation.toggle(&[], &scene).is_err_and(|reason| reason.contains("--physics")));
        scene.nodes[1].local = Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0));
        let said = simulation.toggle(&bodies, &scene).expect("the box still can");
        assert!(said.is_some_and(|said| said.contains("not simulated")));
        assert!(!simulation.is_holding() && simulation.is_started());
    }
}
