//! The techniques, one module each.

mod antialiasing;
pub mod displacement;
mod environment;

pub use antialiasing::Antialiasing;
pub use environment::Environment;

use crate::Technique;

/// All techniques, by name.
pub fn techniques() -> Vec<Box<dyn Technique>> {
    vec![Box::new(Antialiasing), Box::new(Environment)]
}

/// A technique by its name.
pub fn technique(name: &str) -> Option<Box<dyn Technique>> {
    techniques().into_iter().find(|technique| technique.name() == name)
}
