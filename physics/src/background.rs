//! A simulation on a thread of its own, beside drawing.

use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use aam_scene::Scene;
use glam::{Affine3A, Vec3};

use crate::contact::Contact;
use crate::pose::{Places, Poses};
use crate::{PhysicsError, Simulator};

/// How far simulated time may lag behind real time before it stops to catch up, in seconds.
const MOST_LATE: f64 = 0.5;

/// A started simulator that runs on its own thread, following real time.
///
/// A frame begins with [`Background::begin_frame`], which takes the results of the steps that the frame before had
/// asked for, if they are there, and asks for the next. It never waits. What is drawn, [`Background::poses`], is one
/// step old and interpolated to the time of the frame.
pub struct Background {
    jobs: Option<Sender<Job>>,
    inbox: Receiver<Done>,
    thread: Option<JoinHandle<Simulator>>,
    time_step: f64,
    busy: bool,
    /// Real time, without what was left out, and as it was at the frame before.
    real: f64,
    real_before: f64,
    /// Simulated time once everything that was asked for is done.
    asked: f64,
    left_out: f64,
    show_contacts: bool,
    results: Results,
    places: Places,
    stopped: Option<PhysicsError>,
}

/// What the thread found.
#[derive(Clone, Debug, Default)]
struct Results {
    before: Poses,
    after: Poses,
    sleeping: Vec<bool>,
    contacts: Vec<Contact>,
    grabbed: Option<[Vec3; 2]>,
    step_time: Duration,
}

/// What [`Background::begin_frame`] found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Collected {
    /// Results had come, or nothing was being simulated; the next steps were asked for where time has come for them.
    Ready,
    /// The steps are not done yet: earlier poses are drawn, and no new step was asked for.
    NotReady,
    /// The simulation broke: [`Background::error`] says where.
    Stopped,
}

enum Job {
    Steps { count: u64, contacts: bool },
    Act(Box<dyn FnOnce(&mut Simulator) + Send>),
}

struct Done {
    results: Results,
    error: Option<PhysicsError>,
}

impl Background {
    /// Moves a started simulator to a thread of its own.
    ///
    /// # Errors
    /// It is not started, or the system gives no thread.
    pub fn new(simulator: Simulator) -> Result<Self, PhysicsError> {
        if !simulator.is_started() {
            return Err(PhysicsError::State { call: "running in the background", state: "started" });
        }
        let (jobs, inbox) = channel();
        let (outbox, results) = channel();
        let poses = simulator.poses();
        let places = simulator.places();
        let sleeping = simulator.sleeping();
        let time_step = f64::from(simulator.settings().time_step);
        let thread = std::thread::Builder::new()
            .name("physics".into())
            .spawn(move || work(simulator, &inbox, &outbox))
            .map_err(|_| PhysicsError::State { call: "running in the background", state: "given a thread" })?;
        Ok(Self {
            jobs: Some(jobs),
            inbox: results,
            thread: Some(thread),
            time_step,
            busy: false,
            real: poses.time,
            real_before: poses.time,
            asked: poses.time,
            left_out: 0.0,
            show_contacts: false,
            results: Results { before: poses.clone(), after: poses, sleeping, ..Results::default() },
            places,
            stopped: None,
        })
    }

    /// Begins a frame that comes this long after the one before: collects, and asks for the next steps. A frame that
    /// draws several times calls it once, so that all of its pictures show the same poses. With no time elapsed it only
    /// collects: a pause. With the time of one step it goes on by one.
    ///
    /// It asks for the steps that are due, but for no more at once than the frame's own time and one step more: where
    /// steps cost more time than they simulate, motion is slow rather than jumpy, and what real time is ahead by more than
    /// half a second is left out.
    pub fn begin_frame(&mut self, elapsed: Duration) -> Collected {
        let elapsed = elapsed.as_secs_f64();
        self.real_before = self.real;
        self.real += elapsed;
        if self.stopped.is_some() {
            return Collected::Stopped;
        }
        if self.busy {
            match self.inbox.try_recv() {
                Ok(done) => {
                    self.busy = false;
                    (self.results, self.stopped) = (done.results, done.error);
                }
                Err(TryRecvError::Empty) => return Collected::NotReady,
                Err(TryRecvError::Disconnected) => {
                    self.stopped = Some(PhysicsError::State { call: "the physics thread", state: "alive" });
                }
            }
            if self.stopped.is_some() {
                return Collected::Stopped;
            }
        }
        let whole = |seconds: f64| (seconds / self.time_step + 1e-9).floor().max(0.0) as u64;
        let due = whole(self.real - self.asked);
        let steps = due.min(whole(elapsed) + 2).min(whole(MOST_LATE).max(1));
        let late = (due - steps).saturating_sub(whole(MOST_LATE));
        if late > 0 {
            let late = late as f64 * self.time_step;
            self.real -= late;
            self.real_before -= late;
            self.left_out += late;
        }
        if steps > 0 {
            self.send(Job::Steps { count: steps, contacts: self.show_contacts });
            self.asked += steps as f64 * self.time_step;
            self.busy = true;
        }
        Collected::Ready
    }

    /// The poses to draw, interpolated to one step before the frame's time.
    pub fn poses(&self) -> Poses {
        Poses::between(&self.results.before, &self.results.after, self.real_before - self.time_step)
    }

    /// Node to world for every node of the scene at [`Background::poses`].
    pub fn transforms(&self, scene: &Scene) -> Vec<Affine3A> {
        self.places.transforms(scene, &self.poses())
    }

    /// Whether steps were asked for that are not collected yet, or poses would still change without new ones.
    pub fn is_moving(&self) -> bool {
        self.stopped.is_none() && (self.busy || self.real_before < self.real)
    }

    /// Whether each body slept after the newest step, in the order of [`Poses::poses`].
    pub fn sleeping(&self) -> &[bool] {
        &self.results.sleeping
    }

    /// Whether [`Background::contacts`] are collected, from the next steps on. Default false: they cost time.
    pub fn show_contacts(&mut self, show: bool) {
        self.show_contacts = show;
    }

    /// Where bodies pressed on each other in the newest step, if that is collected.
    pub fn contacts(&self) -> &[Contact] {
        &self.results.contacts
    }

    /// The point of the body that is held, and the hand, after the newest step.
    pub fn grabbed(&self) -> Option<[Vec3; 2]> {
        self.results.grabbed
    }

    /// What one of the newest steps took.
    pub fn step_time(&self) -> Duration {
        self.results.step_time
    }

    /// Simulated time of the newest results, in seconds.
    pub fn time(&self) -> f64 {
        self.results.after.time
    }

    /// Real time that was left out since the simulation was slower than it, in seconds.
    pub fn left_out(&self) -> f64 {
        self.left_out
    }

    /// Why it stopped.
    pub fn error(&self) -> Option<&PhysicsError> {
        self.stopped.as_ref()
    }

    /// Acts on the simulator, on its thread, before the next steps.
    pub fn act(&self, act: impl FnOnce(&mut Simulator) + Send + 'static) {
        self.send(Job::Act(Box::new(act)));
    }

    /// Ends the thread once its steps are done, and gives the simulator back; `None` if its thread died.
    pub fn stop(mut self) -> Option<Simulator> {
        self.jobs = None;
        self.thread.take()?.join().ok()
    }

    fn send(&self, job: Job) {
        if let Some(jobs) = &self.jobs {
            // A thread that died is noticed when its results are collected.
            let _ = jobs.send(job);
        }
    }
}

impl Drop for Background {
    fn drop(&mut self) {
        self.jobs = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn work(mut simulator: Simulator, inbox: &Receiver<Job>, outbox: &Sender<Done>) -> Simulator {
    for job in inbox {
        match job {
            Job::Act(act) => act(&mut simulator),
            Job::Steps { count, contacts } => {
                let start = Instant::now();
                let mut before = simulator.poses();
                let mut error = None;
                for _ in 0..count {
                    before = simulator.poses();
                    if let Err(stopped) = simulator.step() {
                        error = Some(stopped);
                        break;
                    }
                }
                let step_time = start.elapsed() / u32::try_from(count).unwrap_or(u32::MAX).max(1);
                let results = Results {
                    before,
                    after: simulator.poses(),
                    sleeping: simulator.sleeping(),
                    contacts: if contacts { simulator.contacts() } else { Vec::new() },
                    grabbed: simulator.grabbed().map(|(_, points)| points),
                    step_time,
                };
                if outbox.send(Done { results, error }).is_err() {
                    break;
                }
            }
        }
    }
    simulator
}
