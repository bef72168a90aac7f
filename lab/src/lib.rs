//! Runs techniques over parameters, measures time and error, and draws the charts.

mod error;
mod load;
pub mod metrics;
mod picture;

pub use error::LabError;
pub use load::load;
pub use picture::save_png;
