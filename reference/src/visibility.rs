//! How much of each light each pixel sees.

use std::time::Instant;

use aam_scene::{Scene, View, displacement};
use glam::Vec2;

use crate::bvh::Ray;
use crate::camera::RayMaker;
use crate::geometry::Hits;
use crate::light::Lamp;
use crate::options::{Error, LightSize, Options, Stats};
use crate::sampling::Points;
use crate::shade::{Counts, Shader, Spot};
use crate::work::{World, each_pixel, with_threads};

/// Independent scrambles of the points on a light: how much their means differ is the standard error.
const SCRAMBLES: u32 = 8;

/// The share of a light that a surface sees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// From 0, in full shadow, to 1, in full light: of a flat light the share of its area, of a sphere the share of the
    /// solid angle that it fills. Transparent surfaces in between let `1 − α` through.
    pub share: f32,
    /// Standard error of the share; 0 where the light is a point. It is estimated from eight independent means, so that
    /// at a single pixel it is itself uncertain by a quarter.
    pub standard_error: f32,
}

/// How much of each light each pixel sees.
#[derive(Clone, Debug, PartialEq)]
pub struct Visibility {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// For each of [`Scene::effective_lights`] each pixel, the top row first. `None` where the pixel's middle shows no
    /// surface that faces the middle of the light (N·L > 0 with the shading normal), or one that the light's cone misses.
    pub lights: Vec<Vec<Option<Seen>>>,
}

/// The visibility of every light from the nearest surface in the middle of each pixel, without shading. Surfaces that
/// blend are looked through; those with an alpha cutoff count where they are not cut off.
///
/// Of the options [`Options::light_samples`], rounded up to a multiple of eight, [`Options::seed`],
/// [`Options::displacement`], [`Options::threads`] and [`Options::progress`] matter.
///
/// # Errors
/// As for [`render`](crate::render).
pub fn visibility(
    scene: &Scene,
    view: &View,
    size: LightSize,
    options: &Options<'_>,
) -> Result<(Visibility, Stats), Error> {
    with_threads(options, || {
        let rays = RayMaker::new(view)?;
        let start = Instant::now();
        let (scene, _) = displacement::displaced(scene, view, options.displacement)?;
        let world = World::new(&scene, view, options)?;
        let shader = world.shader(options);
        let mut stats = world.stats(start.elapsed());
        let start = Instant::now();
        let pixels = u64::from(view.width) * u64::from(view.height);
        let mut lights = Vec::with_capacity(shader.lamps.len());
        for (number, lamp) in shader.lamps.iter().enumerate() {
            let points = Points::new(options.seed).of(number as u32);
            let samples = (size == LightSize::Area && lamp.is_extended()).then_some(options.light_samples);
            let told = |fraction: f32| {
                if let Some(progress) = options.progress {
                    progress((number as f32 + fraction) / shader.lamps.len() as f32);
                }
            };
            let (seen, counts) = each_pixel(view, Some(&told), |x, y, counts| {
                let spot = spot(&shader, &rays, Vec2::new(x as f32 + 0.5, y as f32 + 0.5))?;
                let points = points.of(y as u32 * view.width + x as u32);
                seen(&shader, lamp, &spot, samples, points, counts)
            });
            lights.push(seen);
            stats.camera_rays += pixels;
            stats.shadow_rays += counts.0;
        }
        stats.trace = start.elapsed();
        Ok((Visibility { width: view.width, height: view.height, lights }, stats))
    })
}

/// The nearest surface that does not blend.
fn spot(shader: &Shader<'_>, rays: &RayMaker, at: Vec2) -> Option<Spot> {
    let camera_ray = rays.ray(at);
    let ray = Ray::new(camera_ray.origin, camera_ray.direction);
    let mut hits = Hits::new();
    let mut last = None;
    loop {
        shader.geometry.collect(&ray, (rays.near, rays.far), last, &mut hits);
        for hit in hits.as_slice() {
            let Some(vertex) = shader.seen(&camera_ray, hit, 1.0) else { continue };
            if !vertex.surface.blends {
                return Some(vertex.spot);
            }
        }
        last = hits.as_slice().last().copied();
        if !hits.may_go_on() {
            return None;
        }
    }
}

/// What a spot sees of a light, with a number of rays where the light has a size.
fn seen(
    shader: &Shader<'_>,
    lamp: &Lamp,
    spot: &Spot,
    samples: Option<u32>,
    points: Points,
    counts: &Counts,
) -> Option<Seen> {
    let middle = shader.facing(lamp, spot)?;
    let Some(samples) = samples else {
        return Some(Seen { share: shader.unshadowed(spot, &middle, counts), standard_error: 0.0 });
    };
    let each = samples.div_ceil(SCRAMBLES);
    let (mut sum, mut squares) = (0.0, 0.0);
    for scramble in 0..SCRAMBLES {
        let visible = (0..each).map(|index| shader.visible(lamp, spot, points.point(index, scramble), counts));
        let mean = visible.map(f64::from).sum::<f64>() / f64::from(each);
        sum += mean;
        squares += mean * mean;
    }
    let count = f64::from(SCRAMBLES);
    let variance = (squares - sum * sum / count).max(0.0) / (count * (count - 1.0));
    Some(Seen { share: (sum / count) as f32, standard_error: variance.sqrt() as f32 })
}
