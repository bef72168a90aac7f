//! Draws a scene with wgpu, to a window or off screen.
//!
//! [`Gpu`] is a device, [`Renderer`] draws a [`Scene`](aam_scene::Scene) as a [`View`](aam_scene::View) sees it, into a
//! texture ([`Renderer::render`]) or an image ([`Renderer::render_to_image`]). What a picture means is written in
//! `docs/techniques/shading.md`.

mod backdrop;
mod camera;
mod displacement;
mod draws;
mod encode;
mod environment;
mod error;
mod frame;
mod gpu;
mod lights;
mod materials;
mod meshes;
mod mips;
mod options;
mod overlay;
mod pipelines;
mod read_back;
mod renderer;
mod scopes;
mod shader;
mod shadows;
mod sort;
mod stats;
mod target;
mod targets;
mod textures;
mod timing;
mod upload;

pub use environment::{DiffuseLight, EnvironmentDetail};
pub use error::RenderError;
pub use gpu::{AdapterSummary, Gpu, GpuError};
pub use lights::MAX_LIGHTS;
pub use options::{Msaa, Overlays, RenderOptions, Shape, ShapeKind, ShapeVertex, Show};
pub use renderer::Renderer;
pub use shader::{ShaderError, shader_sources};
pub use shadows::{MAX_SHADOW_SOURCES, ShadowLimit, shadow_camera, shadow_limits};
pub use stats::{CpuTimes, FrameStats, PassTime, Resources};
pub use target::{Alpha, Target};
