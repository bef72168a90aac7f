//! Draws a scene on the CPU by ray tracing: the truth that techniques are measured against, and the picture where there
//! is no GPU.
//!
//! It follows the same shading equation as the renderer (`docs/techniques/shading.md`) and is the better answer where a
//! rasteriser approximates:
//!
//! - Every sample of a pixel is shaded, not one fragment for all samples of a triangle, so that highlights, textures and
//!   alpha cutoffs are anti-aliased as well as edges.
//! - Textures are filtered over the area that a *sample* covers, from exact derivatives: with many samples this tends to
//!   the mean over the pixel's true, stretched footprint, which a GPU's mip-mapping blurs where it is seen at a slant.
//! - Transparency composites all surfaces along each ray in depth order, also where triangles intersect.
//! - Hard shadows are rays, without a map's resolution or bias.

mod bvh;
mod camera;
mod colour;
mod frame;
mod geometry;
mod light;
mod options;
mod picture;
mod shade;
mod surface;
mod texture;

use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use aam_scene::{Image, Pixels, Scene, View};
use glam::{Vec2, Vec4};
use rayon::prelude::*;

use crate::bvh::Ray;
use crate::camera::RayMaker;
use crate::geometry::{Geometry, Hits};
use crate::light::Lamp;
use crate::picture::Backdrop;
use crate::shade::Shader;
use crate::surface::Surfaces;

pub use options::{Error, Options, Stats};

/// The longest side of a picture, in pixels.
pub const MAX_SIDE: u32 = 32_768;

/// The most samples a pixel.
pub const MAX_SAMPLES: u32 = 4096;

/// The most triangles in a scene, counting every instance; they take about 150 bytes each.
pub const MAX_TRIANGLES: usize = 1 << 26;

/// The most lights in a scene, as for the renderer.
pub const MAX_LIGHTS: usize = 64;

/// The largest coordinate in the world, in metres; triangles beyond it are left out.
pub const MAX_COORDINATE: f32 = 1e12;

/// Rows of the picture that are one piece of work, and the side of the blocks that a piece is drawn in.
const BLOCK: usize = 8;

/// Draws one view of a scene as 8-bit RGBA with straight alpha.
///
/// The same scene, view and options give the same bytes on any number of threads.
///
/// # Errors
/// The size, the number of samples or the camera cannot be used, or the scene is too large.
pub fn render(scene: &Scene, view: &View, options: &Options<'_>) -> Result<(Image, Stats), Error> {
    let (width, height) = (view.width, view.height);
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(Error::Size { width, height });
    }
    if !(1..=MAX_SAMPLES).contains(&options.samples_per_pixel) {
        return Err(Error::Samples(options.samples_per_pixel));
    }
    let rays = RayMaker::new(view)?;
    let Some(threads) = options.threads else { return draw(scene, view, &rays, options) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build();
    let pool = pool.map_err(|error| Error::Threads { threads: threads.get(), reason: error.to_string() })?;
    pool.install(|| draw(scene, view, &rays, options))
}

fn draw(scene: &Scene, view: &View, rays: &RayMaker, options: &Options<'_>) -> Result<(Image, Stats), Error> {
    let start = Instant::now();
    let shading = options.shading.unwrap_or(scene.shading);
    let (lights, camera_light) = scene.effective_lights(&view.camera);
    if lights.len() > MAX_LIGHTS {
        return Err(Error::Lights(lights.len()));
    }
    let mut surfaces = Surfaces::new(scene, shading);
    let geometry = Geometry::new(scene, frame::index(view.frame), &mut surfaces)?;
    let textures = surfaces.into_textures();
    let lamps = lights.iter().map(Lamp::new).collect();
    let shader = Shader { geometry: &geometry, textures: &textures, lamps, shading, shadows: options.shadows };
    let backdrop = Backdrop::new(options.background.as_ref().unwrap_or(&scene.background), shading);
    let build = start.elapsed();

    let start = Instant::now();
    let (width, height) = (view.width as usize, view.height as usize);
    let mut bytes = vec![0; 4 * width * height];
    let pattern = camera::sample_pattern(options.samples_per_pixel);
    let (finished, shadow_rays) = (AtomicU64::new(0), AtomicU64::new(0));
    bytes.par_chunks_mut(4 * width * BLOCK).enumerate().for_each(|(band, bytes)| {
        let counter = Cell::new(0);
        let pixel = Pixel { rays, shader: &shader, backdrop: &backdrop, pattern: &pattern, shadow_rays: &counter };
        let rows = bytes.len() / (4 * width);
        // In blocks, so that neighbouring rays meet the same part of the hierarchy.
        for left in (0..width).step_by(BLOCK) {
            for row in 0..rows {
                for x in left..(left + BLOCK).min(width) {
                    let color = pixel.color(x, band * BLOCK + row);
                    let place = 4 * (row * width + x);
                    bytes[place..place + 4].copy_from_slice(&picture::to_bytes(color, shading));
                }
            }
        }
        shadow_rays.fetch_add(counter.get(), Ordering::Relaxed);
        let rows = finished.fetch_add(rows as u64, Ordering::Relaxed) + rows as u64;
        if let Some(progress) = options.progress {
            progress(rows as f32 / height as f32);
        }
    });
    let stats = Stats {
        triangles: geometry.faces.len(),
        skipped_triangles: geometry.skipped,
        camera_rays: pattern.len() as u64 * width as u64 * height as u64,
        shadow_rays: shadow_rays.into_inner(),
        build,
        trace: start.elapsed(),
        camera_light,
    };
    Ok((Image { width: view.width, height: view.height, pixels: Pixels::Rgba8(bytes) }, stats))
}

/// What a pixel's colour is made with.
struct Pixel<'a> {
    rays: &'a RayMaker,
    shader: &'a Shader<'a>,
    backdrop: &'a Backdrop,
    pattern: &'a [Vec2],
    shadow_rays: &'a Cell<u64>,
}

impl Pixel<'_> {
    /// The mean over the pixel, multiplied with its alpha, in the values that lighting computes on.
    fn color(&self, x: usize, y: usize) -> Vec4 {
        let corner = Vec2::new(x as f32, y as f32);
        let sum: Vec4 = self.pattern.iter().map(|offset| self.sample(corner + offset)).sum();
        sum / self.pattern.len() as f32
    }

    /// What one ray sees: surfaces front to back, then the background.
    fn sample(&self, at: Vec2) -> Vec4 {
        let footprint = 1.0 / (self.pattern.len() as f32).sqrt();
        let camera_ray = self.rays.ray(at);
        let ray = Ray::new(camera_ray.origin, camera_ray.direction);
        let mut hits = Hits::new();
        let mut sum = Vec4::ZERO;
        let mut through = 1.0;
        let mut last = None;
        loop {
            self.shader.geometry.collect(&ray, (self.rays.near, self.rays.far), last, &mut hits);
            for hit in hits.as_slice() {
                let Some((color, alpha)) = self.shader.shade(&camera_ray, hit, footprint, self.shadow_rays) else {
                    continue;
                };
                sum += color.extend(1.0) * (alpha * through);
                through *= 1.0 - alpha;
                // Beyond this nothing changes a byte.
                if through < 1e-4 {
                    return sum;
                }
            }
            last = hits.as_slice().last().copied();
            if !hits.may_go_on() {
                return sum + self.backdrop.at(at, self.rays, footprint) * through;
            }
        }
    }
}
