//! What draws the shadows that are measured.

use aam_renderer::{FrameStats, RenderOptions, Renderer, ShadowLimit, shadow_limits};
use aam_scene::{Image, Scene, View};

use crate::LabError;
use crate::technique::Limits;

/// What a frame cost on the GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Milliseconds of the passes that draw maps.
    pub map_ms: f64,
    /// Milliseconds of the passes that blur them.
    pub blur_ms: f64,
    /// Milliseconds of everything else: the picture, with the lookups in the maps.
    pub rest_ms: f64,
    /// Bytes of the maps.
    pub bytes: u64,
}

/// Draws a scene whose only shadow source is the first: the renderer, or a stand-in in tests.
pub trait Painter {
    /// What it draws on, for reports.
    fn adapter(&self) -> String;

    /// The picture, and what it cost.
    ///
    /// # Errors
    /// It cannot be drawn, or the device cannot tell GPU time.
    fn picture(&mut self, scene: &Scene, view: &View) -> Result<(Image, Cost), LabError>;

    /// The factor that the first source leaves of its light in the middle of each pixel, top row first.
    ///
    /// # Errors
    /// It cannot be drawn.
    fn visibility(&mut self, scene: &Scene, view: &View) -> Result<Vec<f32>, LabError>;

    /// Where the first source's settings can be trusted.
    fn limits(&mut self, scene: &Scene, view: &View) -> Limits;
}

impl Cost {
    /// All of it.
    pub fn total_ms(&self) -> f64 {
        self.map_ms + self.blur_ms + self.rest_ms
    }

    fn of(stats: &FrameStats) -> Result<Self, LabError> {
        let passes = stats.gpu.as_ref().ok_or(LabError::NoTimestamps)?;
        let mut cost = Self { bytes: stats.shadow_bytes, ..Self::default() };
        for pass in passes {
            match pass.name {
                "shadow maps" | "shadow volumes" => cost.map_ms += pass.ms,
                name if name.starts_with("shadow blur") => cost.blur_ms += pass.ms,
                _ => cost.rest_ms += pass.ms,
            }
        }
        Ok(cost)
    }
}

impl Painter for Renderer {
    fn adapter(&self) -> String {
        self.gpu().summary().to_string()
    }

    fn picture(&mut self, scene: &Scene, view: &View) -> Result<(Image, Cost), LabError> {
        let (image, stats) = self.render_to_image(scene, view, &RenderOptions::default())?;
        Ok((image, Cost::of(&stats)?))
    }

    fn visibility(&mut self, scene: &Scene, view: &View) -> Result<Vec<f32>, LabError> {
        let options = RenderOptions { gpu_timing: false, ..RenderOptions::default() };
        Ok(Renderer::visibility(self, scene, view, 0, &options)?.0)
    }

    fn limits(&mut self, scene: &Scene, view: &View) -> Limits {
        let known = shadow_limits(scene, view, 0);
        if let Some(ShadowLimit::Refuses(reason)) = known.iter().find(|limit| matches!(limit, ShadowLimit::Refuses(_)))
        {
            return Limits::Refuses(reason.clone());
        }
        // What this device cannot draw is said when it is tried; that needs few pixels.
        let small = View { width: 8, height: 8, ..view.clone() };
        let options = RenderOptions { gpu_timing: false, ..RenderOptions::default() };
        match Renderer::visibility(self, scene, &small, 0, &options) {
            Err(error) => return Limits::Refuses(error.to_string()),
            Ok((_, stats)) => {
                if let Some(warning) = stats.warnings.iter().find(|warning| warning.contains("is not drawn")) {
                    let reason = warning.split_once(": ").map_or(warning.as_str(), |(_, reason)| reason);
                    return Limits::Refuses(reason.to_owned());
                }
            }
        }
        let reasons: Vec<&str> = known.iter().map(ShadowLimit::reason).collect();
        if reasons.is_empty() { Limits::Holds } else { Limits::Degrades(reasons.join("; ")) }
    }
}
