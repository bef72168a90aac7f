//! Measures shadow techniques on one light of a scene: time, memory and error against two truths, and chooses.
//!
//! A [`Subject`] is the scene with one light's shadow; [`Truth`] is what the reference sees of that light, as a point
//! and as large as it is. [`measure()`] draws each technique over its grid with a [`Painter`] and gives a [`ShadowChart`],
//! which [`csv`], [`json`], [`page`] and [`fronts`] write down. [`choose`] picks the cheapest that is accurate enough, and
//! [`Needs`] says what of a scene's shadows no camera sees.

mod choose;
mod flicker;
mod front;
mod measure;
mod needs;
mod page;
mod painter;
mod rows;
mod subject;
mod truth;

pub use choose::{Choice, Goal, choose};
pub use flicker::Flicker;
pub use front::{fronts, pareto};
pub use measure::{Judged, Left, Plan, Run, ShadowChart, Times, measure};
pub use needs::{Needs, SourceNeeds};
pub use page::page;
pub use painter::{Cost, Painter};
pub use rows::{columns, csv, json};
pub use subject::{Subject, SubjectError};
pub use truth::{Rays, Truth, TruthKind};

#[cfg(test)]
mod tests;
