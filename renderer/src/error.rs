//! Why a frame was not drawn.

use crate::lights::MAX_LIGHTS;

/// Why a frame was not drawn.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The picture has no pixels.
    #[error("the picture is {width}×{height} pixels; both sides must be at least 1")]
    EmptyPicture {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
    },
    /// The view's size is not the target's.
    #[error("the view is {view_width}×{view_height} pixels but the target is {target_width}×{target_height}")]
    TargetSize {
        /// The view's width.
        view_width: u32,
        /// The view's height.
        view_height: u32,
        /// The target's width.
        target_width: u32,
        /// The target's height.
        target_height: u32,
    },
    /// The target's format is none that a picture can be drawn to.
    #[error(
        "a picture cannot be drawn to a texture of format {format}; use rgba8unorm, bgra8unorm, their -srgb variants or rgba16float"
    )]
    TargetFormat {
        /// Its name.
        format: String,
    },
    /// The camera has no picture: a value is not finite, or near and far are not in order.
    #[error("the camera {name:?} cannot be used: {reason}")]
    Camera {
        /// Its name.
        name: String,
        /// What is wrong.
        reason: String,
    },
    /// Something is larger than the device allows.
    #[error("{what} needs {needed}, but this GPU's limit {limit} is {allowed}")]
    Limit {
        /// What is too large.
        what: String,
        /// How much it needs, in the limit's unit (pixels or bytes).
        needed: u64,
        /// The limit's name in WebGPU.
        limit: &'static str,
        /// Its value.
        allowed: u64,
    },
    /// The scene has too many lights.
    #[error(
        "the scene has {count} lights; at most {MAX_LIGHTS} can be drawn: remove some, or merge those in one place"
    )]
    TooManyLights {
        /// How many it has.
        count: usize,
    },
    /// The scene contradicts itself.
    #[error("the scene cannot be drawn: {reason}")]
    Scene {
        /// What is wrong.
        reason: String,
    },
    /// A mesh contradicts itself.
    #[error("mesh {mesh:?} cannot be drawn: {reason}")]
    Mesh {
        /// Its name.
        mesh: String,
        /// What is wrong.
        reason: String,
    },
    /// An image contradicts itself.
    #[error("image {image:?} cannot be drawn: {reason}")]
    Image {
        /// Its name.
        image: String,
        /// What is wrong.
        reason: String,
    },
    /// A displaced mesh would be too large.
    #[error(transparent)]
    Displacement(#[from] aam_scene::DisplacementError),
    /// A shader does not assemble: a fault of this program.
    #[error("shader: {0}")]
    Shader(#[from] crate::shader::ShaderError),
    /// The device has no memory left.
    #[error(
        "the GPU is out of memory while it {during}; draw a smaller picture, without MSAA or with smaller textures"
    )]
    OutOfMemory {
        /// What was being done.
        during: &'static str,
    },
    /// The device is gone.
    #[error("the GPU device was lost ({reason}); start the program anew")]
    DeviceLost {
        /// What it said.
        reason: String,
    },
    /// The device refused something.
    #[error("the GPU reported an error while it {during}: {message}")]
    Gpu {
        /// What was being done.
        during: &'static str,
        /// What it said.
        message: String,
    },
}
