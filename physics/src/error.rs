//! What can go wrong.

use aam_scene::NodeId;

/// Why the simulator refuses.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PhysicsError {
    /// A setting is outside its range.
    #[error("{name} is {value}; it has to be {range}")]
    Setting {
        /// Which.
        name: &'static str,
        /// What it is.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// A call that needs a prepared or a started simulation.
    #[error("{call} needs a simulation that is {state}")]
    State {
        /// The call.
        call: &'static str,
        /// What it needs.
        state: &'static str,
    },
    /// The node is not simulated.
    #[error("node {} is not simulated", .0.0)]
    NotSimulated(NodeId),
    /// The call is not for bodies of this mode.
    #[error("{name} is {mode}: {call} is {only}")]
    Mode {
        /// The body's name.
        name: String,
        /// Its mode.
        mode: &'static str,
        /// The call.
        call: &'static str,
        /// For which bodies the call is.
        only: &'static str,
    },
    /// Moves are bracketed by a begin and an end, one object at a time.
    #[error("{0}")]
    Move(&'static str),
    /// A joint cannot be made.
    #[error("a joint cannot be made: {0}")]
    Joint(&'static str),
    /// A value is not a finite number, or out of its range.
    #[error("{0} has to be finite and in its range")]
    Value(&'static str),
    /// The simulation broke, and was stopped.
    #[error(transparent)]
    Diverged(#[from] Divergence),
}

/// Where a simulation broke. It is stopped there: its last good poses stay.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the simulation was stopped at step {step} ({time:.4} s): body \"{name}\" {what}")]
pub struct Divergence {
    /// The step, from 1.
    pub step: u64,
    /// Simulated time in seconds.
    pub time: f64,
    /// The body's node.
    pub node: NodeId,
    /// The body's name.
    pub name: String,
    /// What became of it.
    pub what: What,
}

/// What became of a body that broke a simulation.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum What {
    /// Its place or speed is no finite number any more.
    #[error("has a place or speed that is no number")]
    NotFinite,
    /// It is faster than [`crate::Settings::max_speed`].
    #[error("moves at {0:.0} m/s, faster than allowed")]
    TooFast(f32),
    /// It is farther from the scene than [`crate::Settings::max_distance`].
    #[error("is lost: {0:.0} m away from where the bodies started")]
    Lost(f32),
}
