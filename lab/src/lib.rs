//! Runs techniques over parameters, measures time and error, and draws the charts.
//!
//! A [`Technique`] lists its variants and its limits; [`Study::run`] draws each variant on each [`Subject`], times it on
//! the GPU and compares it with the reference; [`report`] keeps the numbers and [`chart`] draws them.

pub mod chart;
mod error;
mod load;
pub mod metrics;
mod picture;
pub mod report;
pub mod shadows;
mod study;
mod technique;
mod techniques;

pub use error::LabError;
pub use load::load;
pub use picture::save_png;
pub use study::{Row, Study, Subject};
pub use technique::{Limits, Parameter, Technique, Variant};
pub use techniques::{Antialiasing, Effort, Environment, ShadowMapping, displacement, technique, techniques};
