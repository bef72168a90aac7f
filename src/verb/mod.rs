//! The verbs.

pub(crate) mod chart;
pub(crate) mod check;
pub(crate) mod completions;
pub(crate) mod convert;
pub(crate) mod decompose;
pub(crate) mod fmt;
pub(crate) mod info;
pub(crate) mod render;
pub(crate) mod simulate;
pub(crate) mod tune;
pub(crate) mod view;
