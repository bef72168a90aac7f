//! The techniques, one module each.

mod antialiasing;
pub mod displacement;
mod environment;
mod shadows;

use aam_scene::ShadowTechnique;

pub use antialiasing::Antialiasing;
pub use environment::Environment;
pub use shadows::{Effort, ShadowMapping};

use crate::Technique;

/// All techniques, by name; those of shadows have the names that [`ShadowTechnique`] has as text.
pub fn techniques() -> Vec<Box<dyn Technique>> {
    let mut all: Vec<Box<dyn Technique>> = vec![Box::new(Antialiasing), Box::new(Environment)];
    all.extend(ShadowTechnique::all().into_iter().map(|technique| {
        let shadow: Box<dyn Technique> = Box::new(ShadowMapping::new(technique, Effort::Normal));
        shadow
    }));
    all
}

/// A technique by its name.
pub fn technique(name: &str) -> Option<Box<dyn Technique>> {
    techniques().into_iter().find(|technique| technique.name() == name)
}
