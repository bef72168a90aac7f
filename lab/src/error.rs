//! What can go wrong in an experiment.

use std::path::PathBuf;

use thiserror::Error;

/// Why an experiment has no result.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LabError {
    /// An asset cannot be read.
    #[error(transparent)]
    Import(#[from] aam_convert::ConvertError),
    /// A scene file cannot be read.
    #[error(transparent)]
    SceneFile(#[from] aam_scene::SceneFileError),
    /// There is no GPU, or it cannot be used.
    #[error(transparent)]
    Gpu(#[from] aam_renderer::GpuError),
    /// The renderer could not draw.
    #[error(transparent)]
    Render(#[from] aam_renderer::RenderError),
    /// The reference could not draw.
    #[error(transparent)]
    Reference(#[from] aam_reference::Error),
    /// A surface could not be displaced.
    #[error(transparent)]
    Displacement(#[from] aam_scene::DisplacementError),
    /// Two pictures could not be compared.
    #[error(transparent)]
    Compare(#[from] crate::metrics::CompareError),
    /// The device has no timestamp queries.
    #[error("the GPU driver cannot tell how long a frame takes (no timestamp queries); nothing can be timed")]
    NoTimestamps,
    /// A setting cannot be drawn.
    #[error("it cannot be drawn: {0}")]
    Refused(String),
    /// There is nothing to measure.
    #[error(transparent)]
    Subject(#[from] crate::shadows::SubjectError),
    /// A report cannot be read.
    #[error(transparent)]
    Report(#[from] crate::report::ReportError),
    /// A result cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A picture cannot be put into a page.
    #[error("a picture cannot be put into the page: {0}")]
    Embed(String),
    /// A picture cannot be encoded.
    #[error("{}: cannot write the picture: {reason}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What the encoder says.
        reason: String,
    },
}
