//! Runs techniques over parameters, measures time and error, and draws the charts.

pub mod metrics;
