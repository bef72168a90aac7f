//! The scene made ready, and the picture shared out over threads.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use aam_scene::{Background, Scene, Shading, View};
use rayon::prelude::*;

use crate::geometry::Geometry;
use crate::light::Lamp;
use crate::options::{Error, Options, Stats};
use crate::shade::{Counts, Shader};
use crate::sky::Sky;
use crate::surface::Surfaces;
use crate::texture::Texture;
use crate::{MAX_LIGHTS, MAX_SIDE, frame};

/// Rows of the picture that are one piece of work, and the side of the blocks that a piece is drawn in.
const BLOCK: usize = 8;

/// Runs on the threads that the options ask for.
pub(crate) fn with_threads<T: Send>(
    options: &Options<'_>,
    work: impl FnOnce() -> Result<T, Error> + Send,
) -> Result<T, Error> {
    let Some(threads) = options.threads else { return work() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build();
    let pool = pool.map_err(|error| Error::Threads { threads: threads.get(), reason: error.to_string() })?;
    pool.install(work)
}

/// A scene at a frame, ready to be traced.
pub(crate) struct World<'a> {
    geometry: Geometry<'a>,
    textures: Vec<Texture>,
    lamps: Vec<Lamp>,
    camera_light: bool,
    /// The environment, if it lights or is seen.
    pub(crate) sky: Option<Sky>,
    pub(crate) shading: Shading,
}

impl<'a> World<'a> {
    pub(crate) fn new(scene: &'a Scene, view: &View, options: &Options<'_>) -> Result<Self, Error> {
        let (width, height) = (view.width, view.height);
        if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
            return Err(Error::Size { width, height });
        }
        options.check()?;
        let shading = options.shading.unwrap_or(scene.shading);
        let (lights, camera_light) = scene.effective_lights(&view.camera);
        if lights.len() > MAX_LIGHTS {
            return Err(Error::Lights(lights.len()));
        }
        let (middle, up) = (scene.bounds().center(), scene.up.axis());
        let lamps = lights.iter().map(|light| Lamp::new(light, middle, up)).collect();
        let mut surfaces = Surfaces::new(scene, shading);
        let geometry = Geometry::new(scene, frame::index(view.frame), &mut surfaces)?;
        let seen = *options.background.as_ref().unwrap_or(&scene.background) == Background::Environment;
        let environment = scene.environment.as_ref().filter(|environment| seen || environment.is_lit_by());
        let sky = environment.map(|environment| Sky::new(environment, scene.up, shading));
        let camera_light = camera_light && scene.lighting_environment().is_none();
        Ok(Self { geometry, textures: surfaces.into_textures(), lamps, camera_light, sky, shading })
    }

    pub(crate) fn shader(&self, options: &Options<'_>) -> Shader<'_> {
        Shader {
            geometry: &self.geometry,
            textures: &self.textures,
            lamps: &self.lamps,
            sky: self.sky.as_ref(),
            environment_samples: options.environment_samples,
            shading: self.shading,
            shadows: options.shadows,
            light_samples: options.light_samples,
            bounces: options.bounces,
            environment: options.environment,
        }
    }

    /// What is known before tracing.
    pub(crate) fn stats(&self, build: Duration) -> Stats {
        Stats {
            triangles: self.geometry.faces.len(),
            skipped_triangles: self.geometry.skipped,
            build,
            camera_light: self.camera_light,
            ..Stats::default()
        }
    }
}

/// Works out every pixel, the top row first, and counts shadow rays and bounce rays.
pub(crate) fn each_pixel<T: Copy + Default + Send>(
    view: &View,
    progress: Option<&(dyn Fn(f32) + Sync)>,
    pixel: impl Fn(usize, usize, &Counts) -> T + Sync,
) -> (Vec<T>, (u64, u64)) {
    let (width, height) = (view.width as usize, view.height as usize);
    let mut pixels = vec![T::default(); width * height];
    let (finished, shadow_rays, bounce_rays) = (AtomicU64::new(0), AtomicU64::new(0), AtomicU64::new(0));
    pixels.par_chunks_mut(width * BLOCK).enumerate().for_each(|(band, pixels)| {
        let counts = Counts::default();
        let rows = pixels.len() / width;
        // In blocks, so that neighbouring rays meet the same part of the hierarchy.
        for left in (0..width).step_by(BLOCK) {
            for row in 0..rows {
                for x in left..(left + BLOCK).min(width) {
                    pixels[row * width + x] = pixel(x, band * BLOCK + row, &counts);
                }
            }
        }
        shadow_rays.fetch_add(counts.shadow_rays.get(), Ordering::Relaxed);
        bounce_rays.fetch_add(counts.bounce_rays.get(), Ordering::Relaxed);
        let rows = finished.fetch_add(rows as u64, Ordering::Relaxed) + rows as u64;
        if let Some(progress) = progress {
            progress(rows as f32 / height as f32);
        }
    });
    (pixels, (shadow_rays.into_inner(), bounce_rays.into_inner()))
}
