//! Why there is no window.

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// No display can be reached.
    #[error("no window can be opened: {reason}")]
    NoDisplay {
        /// What the system said.
        reason: String,
    },
    /// There is a display but no device that draws to it.
    #[error(transparent)]
    Gpu(#[from] aam_renderer::GpuError),
    /// The window stopped working while it was open.
    #[error("the window had to be closed: {0}")]
    Lost(String),
}
