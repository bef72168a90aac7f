//! Shadows against closed forms and small sums on the CPU.

mod bias;
mod blur;
mod common;
mod controller;
mod filtered;
mod hard;
mod layouts;
mod moments;
mod percentage;

use std::ops::Range;

use aam_renderer::{FrameStats, RenderOptions, Renderer};
use aam_scene::*;
use glam::{Affine3A, Mat3A, Vec3};

use crate::common::{node, options, quad, scene_of};

/// Wide enough to cover the source's volume everywhere.
const ALL: Range<f32> = -3.0..3.0;

fn settings(text: &str) -> ShadowSettings {
    text.parse().unwrap()
}

/// Sees [−1, 1]² from above, heights from 1 (depth 0) down to 0 (depth 1).
fn above() -> Camera {
    Camera {
        name: "above".into(),
        position: Vec3::Z,
        target: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::Orthographic { height: 2.0 },
        near: 0.0,
        far: 1.0,
    }
}

fn source(settings: ShadowSettings) -> ShadowSource {
    ShadowSource { name: String::new(), enabled: true, light: None, volume: Some(above()), settings }
}

/// Horizontal sheets under a source above. The lowest sheet is what a picture from below shows.
fn stage(text: &str) -> Scene {
    let mut scene = scene_of(quad(), Material::default(), vec![crate::common::dark()]);
    scene.nodes.clear();
    scene.shadows = Some(Shadows { sources: vec![source(settings(text))], ..Shadows::default() });
    scene
}

/// Adds a rectangle at a depth under the source above.
fn sheet(scene: &mut Scene, depth: f32, x: Range<f32>, y: Range<f32>) -> NodeId {
    let center = Vec3::new(0.5 * (x.start + x.end), 0.5 * (y.start + y.end), 1.0 - depth);
    let size = Vec3::new(0.5 * (x.end - x.start), 0.5 * (y.end - y.start), 1.0);
    placed(scene, Affine3A { matrix3: Mat3A::from_diagonal(size), translation: center.into() })
}

/// Adds the square [−1, 1]², transformed.
fn placed(scene: &mut Scene, local: Affine3A) -> NodeId {
    scene.nodes.push(node(0, local));
    NodeId(scene.nodes.len() as u32 - 1)
}

fn shadows(scene: &mut Scene) -> &mut Shadows {
    scene.shadows.as_mut().unwrap()
}

fn set(scene: &mut Scene, text: &str) {
    shadows(scene).sources[0].settings = settings(text);
}

/// What is left of the light at points of the lowest surface.
struct Seen {
    width: u32,
    /// From low to high y, in each row from low to high x.
    lit: Vec<f32>,
    stats: FrameStats,
}

impl Seen {
    fn row(&self, y: u32) -> &[f32] {
        &self.lit[(y * self.width) as usize..][..self.width as usize]
    }

    fn at(&self, x: u32, y: u32) -> f32 {
        self.row(y)[x as usize]
    }

    fn min(&self) -> f32 {
        self.lit.iter().copied().fold(f32::INFINITY, f32::min)
    }

    fn all(&self, value: f32) -> bool {
        self.lit.iter().all(|lit| *lit == value)
    }
}

/// Looks up from below at a rectangle around a point.
fn from_below(center: (f32, f32), height: f32) -> Camera {
    Camera {
        name: "below".into(),
        position: Vec3::new(center.0, center.1, -5.0),
        target: Vec3::new(center.0, center.1, 0.0),
        up: Vec3::Y,
        projection: Projection::Orthographic { height },
        near: 0.1,
        far: 100.0,
    }
}

fn see(renderer: &mut Renderer, scene: &Scene, camera: Camera, width: u32, height: u32) -> Seen {
    see_with(renderer, scene, camera, width, height, &options())
}

fn see_with(
    renderer: &mut Renderer,
    scene: &Scene,
    camera: Camera,
    width: u32,
    height: u32,
    options: &RenderOptions,
) -> Seen {
    let upwards = camera.target.z > camera.position.z;
    let view = View { camera, width, height, frame: 0.0 };
    let (mut lit, stats) = renderer.visibility(scene, &view, 0, options).unwrap();
    // Rows come from the top, and from below x runs to the left.
    if upwards {
        lit.reverse();
    } else {
        lit = lit.chunks(width as usize).rev().flatten().copied().collect();
    }
    Seen { width, lit, stats }
}

/// A pixel for each texel of a map of this size.
fn texels(renderer: &mut Renderer, scene: &Scene, size: u32) -> Seen {
    see(renderer, scene, from_below((0.0, 0.0), 2.0), size, size)
}

/// A row of pixels over [−1, 1] at a height y.
fn profile(renderer: &mut Renderer, scene: &Scene, y: f32, width: u32) -> Vec<f32> {
    see(renderer, scene, from_below((0.0, y), 2.0 / width as f32), width, 1).lit
}

/// Gaussian weights at −r … r, with a standard deviation of a third of the radius.
fn gaussian(radius: i32) -> Vec<f64> {
    let weight = |i: i32| (-4.5 * f64::from(i * i) / f64::from(radius * radius)).exp();
    let sum: f64 = (-radius..=radius).map(weight).sum();
    (-radius..=radius).map(|i| weight(i) / sum).collect()
}

/// Where a row that falls or rises crosses a level, in pixels from its start; linear between pixels.
fn crossing(row: &[f32], level: f32) -> Option<f32> {
    row.windows(2).enumerate().find_map(|(i, pair)| {
        let [a, b] = [pair[0] - level, pair[1] - level];
        ((a < 0.0) != (b < 0.0)).then(|| i as f32 + 0.5 + a / (a - b))
    })
}

/// Width from 10 % to 90 %, in pixels.
fn penumbra(row: &[f32]) -> f32 {
    (crossing(row, 0.9).unwrap() - crossing(row, 0.1).unwrap()).abs()
}

#[track_caller]
fn assert_close(found: f32, expected: f64, tolerance: f64) {
    assert!((f64::from(found) - expected).abs() <= tolerance, "{found}, not {expected} ± {tolerance}");
}

/// Techniques with one map.
fn single() -> Vec<ShadowTechnique> {
    let all = ShadowTechnique::all().into_iter();
    all.filter(|technique| technique.layout == ShadowLayout::One && technique.filter != ShadowFilter::Volume).collect()
}

const MOMENTS: [&str; 5] = ["vsm", "esm", "evsm2", "evsm4", "msm"];
