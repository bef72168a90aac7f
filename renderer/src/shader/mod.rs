//! Shaders: their text is assembled from the files of `shaders/`, which are part of the binary.
//!
//! [`assemble`] resolves imports and conditions; [`Variant`] says which conditions hold for a mesh
//! subset, and enumerates all that are legal.

mod assemble;
mod library;
mod variant;

pub use assemble::ShaderError;
pub use library::shader_sources;
pub(crate) use library::{Program, source};
pub(crate) use variant::{AlphaMode, ColorSource, NormalSource, Surface, Variant};
