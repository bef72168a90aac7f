//! A simulation on a thread of its own, beside drawing.

use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::pose::Poses;
use crate::{PhysicsError, Simulator};

/// The most steps that are done at once to catch up with real time; what is beyond is left out.
const MOST_STEPS: u64 = 8;

/// A started simulator that runs on its own thread, following real time.
///
/// A frame begins with [`Background::begin_frame`], which takes the results of the steps that the frame before had
/// asked for, if they are there, and asks for the next. It never waits. What is drawn, [`Background::poses`], is one
/// step old and interpolated to the time of the frame.
pub struct Background {
    jobs: Option<Sender<Job>>,
    results: Receiver<Done>,
    thread: Option<JoinHandle<Simulator>>,
    time_step: f64,
    busy: bool,
    /// Real time, without what was left out, and as it was at the frame before.
    real: f64,
    real_before: f64,
    /// Simulated time once everything that was asked for is done.
    asked: f64,
    left_out: f64,
    before: Poses,
    after: Poses,
    stopped: Option<PhysicsError>,
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
    Steps(u64),
    Act(Box<dyn FnOnce(&mut Simulator) + Send>),
}

struct Done {
    before: Poses,
    after: Poses,
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
        let time_step = f64::from(simulator.settings().time_step);
        let thread = std::thread::Builder::new()
            .name("physics".into())
            .spawn(move || work(simulator, &inbox, &outbox))
            .map_err(|_| PhysicsError::State { call: "running in the background", state: "given a thread" })?;
        Ok(Self {
            jobs: Some(jobs),
            results,
            thread: Some(thread),
            time_step,
            busy: false,
            real: poses.time,
            real_before: poses.time,
            asked: poses.time,
            left_out: 0.0,
            before: poses.clone(),
            after: poses,
            stopped: None,
        })
    }

    /// Begins a frame that comes this long after the one before: collects, and asks for the next steps. A frame that
    /// draws several times calls it once, so that all of its pictures show the same poses.
    pub fn begin_frame(&mut self, elapsed: Duration) -> Collected {
        self.real_before = self.real;
        self.real += elapsed.as_secs_f64();
        if self.stopped.is_some() {
            return Collected::Stopped;
        }
        if self.busy {
            match self.results.try_recv() {
                Ok(done) => {
                    self.busy = false;
                    (self.before, self.after, self.stopped) = (done.before, done.after, done.error);
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
        let due = ((self.real - self.asked) / self.time_step + 1e-9).floor().max(0.0) as u64;
        let steps = due.min(MOST_STEPS);
        if due > steps {
            let late = (due - steps) as f64 * self.time_step;
            self.real -= late;
            self.real_before -= late;
            self.left_out += late;
        }
        if steps > 0 {
            self.send(Job::Steps(steps));
            self.asked += steps as f64 * self.time_step;
            self.busy = true;
        }
        Collected::Ready
    }

    /// The poses to draw, interpolated to one step before the frame's time.
    pub fn poses(&self) -> Poses {
        Poses::between(&self.before, &self.after, self.real_before - self.time_step)
    }

    /// Simulated time of the newest results, in seconds.
    pub fn time(&self) -> f64 {
        self.after.time
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
            Job::Steps(steps) => {
                let mut before = simulator.poses();
                let mut error = None;
                for _ in 0..steps {
                    before = simulator.poses();
                    if let Err(stopped) = simulator.step() {
                        error = Some(stopped);
                        break;
                    }
                }
                if outbox.send(Done { before, after: simulator.poses(), error }).is_err() {
                    break;
                }
            }
        }
    }
    simulator
}
