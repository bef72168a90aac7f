//! How to simulate.

use glam::Vec3;

use crate::PhysicsError;

/// How to simulate. A value for one simulation; nothing of it is kept in files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Seconds of simulated time a step, from 1e-6 to 1. Default 1/60.
    pub time_step: f32,
    /// Acceleration of dynamic bodies in m/s²; `None` is 9.81 against the scene's up axis.
    pub gravity: Option<Vec3>,
    /// Solver iterations a step, from 1 to 1000: more are more accurate, and slower. Default 4.
    pub iterations: usize,
    /// Which bodies are kept from passing through others within one step.
    pub continuous: Continuous,
    /// Let bodies at rest sleep, so that they cost nothing until something acts on them. Default true.
    pub sleeping: bool,
    /// The size in metres of a typical body, above 0: what the engine's lengths (how far ahead contacts are looked for, how
    /// deep bodies sink, how slow is still) are taken relative to. `None` takes it from the bodies.
    pub length_unit: Option<f32>,
    /// The simulation is stopped when a body is faster than this, in m/s. Default 1e5.
    pub max_speed: f32,
    /// The simulation is stopped when a body is farther than this from where the bodies started, in metres. Default 1e5.
    pub max_distance: f32,
}

/// Continuous collision detection: sweeping a body along its path, so that it does not pass through in one step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Continuous {
    /// None: bodies are where they are at the end of each step.
    Off,
    /// Fast dynamic bodies against static ones.
    #[default]
    Static,
    /// Fast dynamic bodies against all bodies that are slower: those that go less far in a step than they are thick. Two
    /// fast ones may still miss each other.
    All,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            time_step: 1.0 / 60.0,
            gravity: None,
            iterations: 4,
            continuous: Continuous::default(),
            sleeping: true,
            length_unit: None,
            max_speed: 1e5,
            max_distance: 1e5,
        }
    }
}

impl Settings {
    /// Whether every value is in its range.
    ///
    /// # Errors
    /// [`PhysicsError::Setting`] names the first that is not.
    pub fn check(&self) -> Result<(), PhysicsError> {
        let check = |name, value: f64, ok: bool, range| {
            if ok { Ok(()) } else { Err(PhysicsError::Setting { name, value, range }) }
        };
        let positive = |value: f32| value > 0.0 && value.is_finite();
        let step = self.time_step;
        check("the time step", step.into(), (1e-6..=1.0).contains(&step), "from 0.000001 to 1 second")?;
        let gravity = self.gravity.unwrap_or(Vec3::ZERO);
        check("gravity", gravity.length().into(), gravity.is_finite(), "finite")?;
        let iterations = self.iterations;
        check("the number of iterations", iterations as f64, (1..=1000).contains(&iterations), "from 1 to 1000")?;
        let unit = self.length_unit.unwrap_or(1.0);
        check("the length unit", unit.into(), positive(unit), "above 0")?;
        check("the largest speed", self.max_speed.into(), positive(self.max_speed), "above 0")?;
        check("the largest distance", self.max_distance.into(), positive(self.max_distance), "above 0")
    }
}
