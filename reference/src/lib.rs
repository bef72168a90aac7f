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
//! - Shadows are rays, without a map's resolution or bias: to the light as a point, or to many points of its extent.
//! - An environment is integrated over directions chosen anew for each point, not prefiltered.
//! - Light may bounce between surfaces any number of times.
//!
//! [`render`] gives a picture, [`radiance`] the same in floats that are not cut at white, and [`visibility`] the share of
//! each light that each pixel's surface sees, with its standard error. [`Tracer`] answers single rays.

mod bvh;
mod camera;
mod colour;
mod display;
mod extent;
mod frame;
mod geometry;
mod light;
mod options;
mod path;
mod picture;
mod sampling;
mod shade;
mod sky;
mod surface;
mod texture;
mod tracer;
mod visibility;
mod work;

use std::time::Instant;

use aam_scene::{Image, Pixels, Scene, Shading, View, displacement};
use glam::{Vec2, Vec4};

use crate::bvh::Ray;
use crate::camera::RayMaker;
use crate::display::Display;
use crate::geometry::Hits;
use crate::picture::Backdrop;
use crate::sampling::Points;
use crate::shade::{Counts, Sample, Shader};
use crate::work::{World, each_pixel};

pub use options::{Error, LightSize, Options, Stats};
pub use tracer::Tracer;
pub use visibility::{Seen, Visibility, visibility};

/// The longest side of a picture, in pixels.
pub const MAX_SIDE: u32 = 32_768;

/// The most samples a pixel.
pub const MAX_SAMPLES: u32 = 4096;

/// The most shadow rays from one point to one light.
pub const MAX_LIGHT_SAMPLES: u32 = 1 << 16;

/// The most directions in which an environment is looked at from one point.
pub const MAX_ENVIRONMENT_SAMPLES: u32 = 1 << 16;

/// The most reflections between surfaces.
pub const MAX_BOUNCES: u32 = 1024;

/// The most triangles in a scene, counting every instance; they take about 150 bytes each.
pub const MAX_TRIANGLES: usize = 1 << 26;

/// The most lights in a scene, as for the renderer.
pub const MAX_LIGHTS: usize = 64;

/// The largest coordinate in the world, in metres; triangles beyond it are left out.
pub const MAX_COORDINATE: f32 = 1e12;

/// A picture in floats.
#[derive(Clone, Debug, PartialEq)]
pub struct Radiance {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Colour and alpha of each pixel, the top row first, in the values that lighting computes on: linear light in linear
    /// shading. The colour is multiplied with its alpha and may exceed it.
    pub pixels: Vec<Vec4>,
    /// Standard error of each pixel's mean over the three channels, from how much its samples differ. An upper estimate,
    /// since stratified samples differ more than their means do; 0 with one sample.
    pub standard_error: Vec<f32>,
}

/// Draws one view of a scene as 8-bit RGBA with straight alpha.
///
/// The same scene, view and options give the same bytes on any number of threads.
///
/// # Errors
/// The size, an option or the camera cannot be used, or the scene is too large.
pub fn render(scene: &Scene, view: &View, options: &Options<'_>) -> Result<(Image, Stats), Error> {
    // Samples of bounced light vary, and cutting each at white would darken their mean.
    let shown = if options.bounces == 0 { Shown::Samples } else { Shown::Means };
    let (bytes, stats) = draw(scene, view, options, shown, |(color, _), shading| picture::to_bytes(color, shading))?;
    let pixels = Pixels::Rgba8(bytes.into_flattened());
    Ok((Image { width: view.width, height: view.height, pixels }, stats))
}

/// Draws one view of a scene in floats. Surfaces and sky box are not exposed, tone mapped and clamped to `[0, 1]`,
/// otherwise it is the picture of [`render`].
///
/// # Errors
/// As for [`render`].
pub fn radiance(scene: &Scene, view: &View, options: &Options<'_>) -> Result<(Radiance, Stats), Error> {
    let (pairs, stats) = draw(scene, view, options, Shown::Nothing, |pixel, _| pixel)?;
    let (pixels, standard_error) = pairs.into_iter().unzip();
    Ok((Radiance { width: view.width, height: view.height, pixels, standard_error }, stats))
}

/// What is exposed and tone mapped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shown {
    /// Nothing: light stays light.
    Nothing,
    /// Each surface that a camera ray meets.
    Samples,
    /// The mean of a pixel's surfaces.
    Means,
}

fn draw<T: Copy + Default + Send>(
    scene: &Scene,
    view: &View,
    options: &Options<'_>,
    shown: Shown,
    convert: impl Fn((Vec4, f32), Shading) -> T + Sync,
) -> Result<(Vec<T>, Stats), Error> {
    work::with_threads(options, || {
        let rays = RayMaker::new(view)?;
        let start = Instant::now();
        let (scene, _) = displacement::displaced(scene, view, options.displacement)?;
        let world = World::new(&scene, view, options)?;
        if options.bounces > 0 && world.shading == Shading::Source {
            return Err(Error::BouncesInSource);
        }
        let shader = world.shader(options);
        let background = options.background.as_ref().unwrap_or(&scene.background);
        let display = Display::new(&scene);
        let sky_display = (shown != Shown::Nothing).then_some(display);
        let backdrop = Backdrop::new(background, world.shading, world.sky.as_ref(), sky_display);
        let mut stats = world.stats(start.elapsed());
        let start = Instant::now();
        let pattern = camera::sample_pattern(options.samples_per_pixel);
        let points = Points::new(options.seed);
        let (pixels, counts) = each_pixel(view, options.progress, |x, y, counts| {
            let points = points.of(y as u32 * view.width + x as u32);
            let pixel =
                Pixel { rays: &rays, shader: &shader, backdrop: &backdrop, pattern: &pattern, points, display, shown };
            convert(pixel.color(x, y, counts), world.shading)
        });
        stats.camera_rays = pattern.len() as u64 * u64::from(view.width) * u64::from(view.height);
        (stats.shadow_rays, stats.bounce_rays) = counts;
        stats.trace = start.elapsed();
        Ok((pixels, stats))
    })
}

/// What a pixel's colour is made with.
struct Pixel<'a> {
    rays: &'a RayMaker,
    shader: &'a Shader<'a>,
    backdrop: &'a Backdrop<'a>,
    pattern: &'a [Vec2],
    points: Points,
    display: Display,
    shown: Shown,
}

impl Pixel<'_> {
    /// The mean over the pixel, multiplied with its alpha, in the values that lighting computes on; and its standard
    /// error.
    fn color(&self, x: usize, y: usize, counts: &Counts) -> (Vec4, f32) {
        let corner = Vec2::new(x as f32, y as f32);
        let (mut surfaces, mut behind, mut greys, mut squares) = (Vec4::ZERO, Vec4::ZERO, 0.0, 0.0);
        for (index, offset) in (0..).zip(self.pattern) {
            let (color, back) = self.sample(corner + offset, &Sample { points: self.points, index, counts });
            let grey = f64::from((color + back).truncate().element_sum()) / 3.0;
            surfaces += color;
            behind += back;
            greys += grey;
            squares += grey * grey;
        }
        let count = self.pattern.len() as f64;
        let variance = (squares - greys * greys / count).max(0.0) / (count * (count - 1.0).max(1.0));
        let mut mean = surfaces / count as f32;
        if self.shown == Shown::Means && mean.w > 0.0 {
            mean = (self.display.apply(mean.truncate() / mean.w) * mean.w).extend(mean.w);
        }
        (mean + behind / count as f32, variance.sqrt() as f32)
    }

    /// What one ray sees: surfaces front to back, and the background.
    fn sample(&self, at: Vec2, sample: &Sample<'_>) -> (Vec4, Vec4) {
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
                let Some(vertex) = self.shader.seen(&camera_ray, hit, footprint) else { continue };
                let color = self.shader.outgoing(&vertex, sample, 0) + self.shader.bounced(&vertex, sample);
                let color = if self.shown == Shown::Samples { self.display.apply(color) } else { color };
                sum += color.extend(1.0) * (vertex.alpha * through);
                through *= 1.0 - vertex.alpha;
                // Beyond this nothing changes a byte.
                if through < 1e-4 {
                    return (sum, Vec4::ZERO);
                }
            }
            last = hits.as_slice().last().copied();
            if !hits.may_go_on() {
                return (sum, self.backdrop.at(at, self.rays, footprint) * through);
            }
        }
    }
}
