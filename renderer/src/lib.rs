//! Draws a scene with wgpu, to a window or off screen.
//!
//! [`Gpu`] is a device, [`Renderer`] draws a [`Scene`](aam_scene::Scene) as a [`View`](aam_scene::View) sees it, into a
//! texture ([`Renderer::render`]) or an image ([`Renderer::render_to_image`]). What a picture means is written in
//! `docs/techniques/shading.md`.

mod error;
mod gpu;
mod lights;
mod options;
mod renderer;
mod shader;
mod stats;
mod target;

pub use error::RenderError;
pub use gpu::{AdapterSummary, Gpu, GpuError};
pub use lights::MAX_LIGHTS;
pub use options::{Msaa, Overlays, RenderOptions, Shape, ShapeKind, ShapeVertex, Show};
pub use renderer::Renderer;
pub use shader::ShaderError;
pub use stats::{CpuTimes, FrameStats, PassTime, Resources};
pub use target::{Alpha, Target};
