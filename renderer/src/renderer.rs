//! Drawing frames.

use aam_scene::{Image, Scene, View};

use crate::{FrameStats, Gpu, RenderError, RenderOptions, Resources, Target};

/// Draws scenes. Keeps what it uploaded for as long as the scene's meshes and images live.
#[derive(Debug)]
pub struct Renderer {
    gpu: Gpu,
}

impl Renderer {
    /// A renderer that has uploaded and compiled nothing yet.
    pub fn new(gpu: Gpu) -> Self {
        Self { gpu }
    }

    /// The device that it draws with.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Draws one frame and submits it, without waiting for the GPU.
    ///
    /// # Errors
    /// [`RenderError`] says what the scene, the view or the device does not allow; nothing is drawn then.
    pub fn render(
        &mut self,
        scene: &Scene,
        view: &View,
        options: &RenderOptions,
        target: &Target<'_>,
    ) -> Result<FrameStats, RenderError> {
        let _ = (scene, options, target);
        Err(RenderError::EmptyPicture { width: view.width, height: view.height })
    }

    /// Draws one frame and reads it back, as straight-alpha RGBA8, top row first.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_to_image(
        &mut self,
        scene: &Scene,
        view: &View,
        options: &RenderOptions,
    ) -> Result<(Image, FrameStats), RenderError> {
        let _ = (scene, options);
        Err(RenderError::EmptyPicture { width: view.width, height: view.height })
    }

    /// What it holds on the GPU at the moment.
    pub fn resources(&self) -> Resources {
        Resources::default()
    }
}
