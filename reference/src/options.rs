//! What the caller chooses, what comes back beside the picture, and what can go wrong.

use std::fmt;
use std::num::NonZeroUsize;
use std::time::Duration;

use aam_scene::{Background, DisplacementError, DisplacementMode, Shading};
use glam::Vec3;
use thiserror::Error;

/// How large lights are taken to be where shadows are cast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSize {
    /// All are points: hard shadows.
    Point,
    /// As large as [`aam_scene::Light::shape`] says.
    Area,
}

/// How to draw. [`Options::default`] is 16 samples a pixel without shadows and bounces, on all cores.
#[derive(Clone)]
pub struct Options<'a> {
    /// Camera rays a pixel, rounded up to the next square `n²` (an `n` × `n` stratified pattern); 1 to 4096.
    pub samples_per_pixel: u32,
    /// Shadows: a light's diffuse and specular terms reach only points that see it, or in part those that see a part of
    /// it. Emission, ambient and light maps stay. Transparent surfaces in between let `1 − α` through.
    pub shadows: Option<LightSize>,
    /// Shadow rays to each light that has a size, for each camera ray; 1 to 65,536, best a power of two.
    pub light_samples: u32,
    /// Directions in which the scene's environment is looked at for each camera ray, diffuse and specular each; 1 to 65,536.
    pub environment_samples: u32,
    /// How often light may be reflected between surfaces on its way from one that is lit or shines to the one seen: 0 to
    /// 1024. Above 0 the shading must be linear, and bounced light takes the place of the lights' ambient colours.
    pub bounces: u32,
    /// Radiance that reaches surfaces from where there is no other surface, if light bounces and the scene has no
    /// environment of its own. The camera sees the background there all the same.
    pub environment: Vec3,
    /// Chooses among equally good random numbers for lights with a size and for bounces.
    pub seed: u32,
    /// How displacement maps are drawn: as geometry, which casts shadows too.
    pub displacement: DisplacementMode,
    /// Replaces [`aam_scene::Scene::shading`].
    pub shading: Option<Shading>,
    /// Replaces [`aam_scene::Scene::background`].
    pub background: Option<Background>,
    /// Threads to use; `None` takes rayon's global pool. The picture does not depend on it.
    pub threads: Option<NonZeroUsize>,
    /// Called with the finished fraction, 0 to 1, from any thread, as rows finish.
    pub progress: Option<&'a (dyn Fn(f32) + Sync)>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            samples_per_pixel: 16,
            shadows: None,
            light_samples: 16,
            environment_samples: 64,
            bounces: 0,
            environment: Vec3::ZERO,
            seed: 0,
            displacement: DisplacementMode::default(),
            shading: None,
            background: None,
            threads: None,
            progress: None,
        }
    }
}

impl Options<'_> {
    /// Refuses what is out of range.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if !(1..=crate::MAX_SAMPLES).contains(&self.samples_per_pixel) {
            return Err(Error::Samples(self.samples_per_pixel));
        }
        if !(1..=crate::MAX_LIGHT_SAMPLES).contains(&self.light_samples) {
            return Err(Error::LightSamples(self.light_samples));
        }
        if !(1..=crate::MAX_ENVIRONMENT_SAMPLES).contains(&self.environment_samples) {
            return Err(Error::EnvironmentSamples(self.environment_samples));
        }
        if self.bounces > crate::MAX_BOUNCES {
            return Err(Error::Bounces(self.bounces));
        }
        Ok(())
    }
}

impl fmt::Debug for Options<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Options")
            .field("samples_per_pixel", &self.samples_per_pixel)
            .field("shadows", &self.shadows)
            .field("light_samples", &self.light_samples)
            .field("environment_samples", &self.environment_samples)
            .field("bounces", &self.bounces)
            .field("environment", &self.environment)
            .field("seed", &self.seed)
            .field("displacement", &self.displacement)
            .field("shading", &self.shading)
            .field("background", &self.background)
            .field("threads", &self.threads)
            .field("progress", &self.progress.is_some())
            .finish()
    }
}

/// What a picture cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
    /// Triangles in the world, each instance counted.
    pub triangles: usize,
    /// Triangles left out because a position is not finite or a vertex index has no vertex; both are not drawn.
    pub skipped_triangles: usize,
    /// Rays from the camera.
    pub camera_rays: u64,
    /// Rays to lights.
    pub shadow_rays: u64,
    /// Rays from surface to surface.
    pub bounce_rays: u64,
    /// Time to flatten the scene and to build the bounding volume hierarchy and the mipmaps.
    pub build: Duration,
    /// Time to trace and shade all rays.
    pub trace: Duration,
    /// True when the scene has no light, so that one white light at the camera was used.
    pub camera_light: bool,
}

impl Stats {
    /// Rays of all kinds a second of tracing; 0 when nothing was traced.
    pub fn rays_per_second(&self) -> f64 {
        let seconds = self.trace.as_secs_f64();
        let rays = self.camera_rays + self.shadow_rays + self.bounce_rays;
        if seconds > 0.0 { rays as f64 / seconds } else { 0.0 }
    }
}

/// Why there is no picture.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum Error {
    /// The picture has no pixels, or more than can be held.
    #[error("a picture of {width} × {height} pixels cannot be drawn: both sides must be from 1 to {limit}", limit = crate::MAX_SIDE)]
    Size {
        /// Requested width.
        width: u32,
        /// Requested height.
        height: u32,
    },
    /// The number of samples is out of range.
    #[error("{0} samples per pixel cannot be drawn: use 1 to {limit}", limit = crate::MAX_SAMPLES)]
    Samples(u32),
    /// The number of shadow rays is out of range.
    #[error("{0} shadow rays to a light cannot be drawn: use 1 to {limit}", limit = crate::MAX_LIGHT_SAMPLES)]
    LightSamples(u32),
    /// The number of directions into the environment is out of range.
    #[error("{0} directions into the environment cannot be drawn: use 1 to {limit}", limit = crate::MAX_ENVIRONMENT_SAMPLES)]
    EnvironmentSamples(u32),
    /// The number of bounces is out of range.
    #[error("{0} bounces cannot be drawn: use 0 to {limit}", limit = crate::MAX_BOUNCES)]
    Bounces(u32),
    /// Bounced light was asked for where colours are not decoded.
    #[error("light that bounces can be computed in linear shading only")]
    BouncesInSource,
    /// The camera cannot see.
    #[error("the camera cannot be used: {0}")]
    Camera(String),
    /// More triangles than can be numbered.
    #[error("the scene has {0} triangles, counting every instance; at most {limit} can be drawn", limit = crate::MAX_TRIANGLES)]
    Triangles(usize),
    /// A displaced mesh cannot be drawn.
    #[error(transparent)]
    Displacement(#[from] DisplacementError),
    /// More lights than the renderer takes.
    #[error("the scene has {0} lights; at most {limit} can be drawn", limit = crate::MAX_LIGHTS)]
    Lights(usize),
    /// The worker threads could not be started.
    #[error("cannot start {threads} worker threads: {reason}")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// What the system said.
        reason: String,
    },
}
