//! Measuring a technique: cost and error of each variant on each scene.

use aam_renderer::{RenderOptions, Renderer};
use aam_scene::{Image, Scene, View};

use crate::LabError;
use crate::metrics::{PIXELS_PER_DEGREE, difference, flip};
use crate::technique::{Limits, Technique, Variant};

/// Frames drawn before any is timed: shaders compile and caches fill.
const WARM_UP: usize = 3;

/// A scene to measure on.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Name for the report.
    pub name: String,
    /// The scene.
    pub scene: Scene,
    /// How it is looked at.
    pub view: View,
}

/// Everything that was measured of a technique.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// The technique's name.
    pub technique: String,
    /// What the chart shows.
    pub title: String,
    /// GPU and driver.
    pub machine: String,
    /// What was drawn and how often.
    pub method: String,
    /// The results, scene by scene.
    pub rows: Vec<Row>,
}

/// Cost and error of one variant on one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The scene.
    pub scene: String,
    /// The variant's label.
    pub variant: String,
    /// Median GPU time of a frame in milliseconds.
    pub gpu_ms: f64,
    /// First and third quartile of the GPU time.
    pub gpu_quartiles: [f64; 2],
    /// Mean FLIP difference from the reference.
    pub flip_mean: f64,
    /// FLIP difference that 95 % of the pixels do not exceed.
    pub flip_p95: f64,
    /// FLIP difference that 99 % of the pixels do not exceed.
    pub flip_p99: f64,
    /// Root mean squared difference, 0 to 1.
    pub rmse: f64,
    /// Share of pixels that differ by more than 24 of 255 in some channel.
    pub over_24: f64,
    /// [`Limits::text`] of the variant on the scene.
    pub limits: String,
}

impl Study {
    /// Measures all variants of a technique on all subjects, each for a number of timed frames. `progress` is told what
    /// happens next.
    ///
    /// # Errors
    /// A picture cannot be drawn, or the device cannot tell GPU time.
    pub fn run(
        technique: &dyn Technique,
        subjects: &[Subject],
        renderer: &mut Renderer,
        frames: usize,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Self, LabError> {
        let mut rows = Vec::new();
        for subject in subjects {
            progress(&format!("{}: reference", subject.name));
            let (truth, _) = aam_reference::render(&subject.scene, &subject.view, &technique.truth())?;
            progress(&format!("{}: {frames} frames of each variant", subject.name));
            rows.extend(measure(technique, subject, &truth, renderer, frames)?);
        }
        let summary = renderer.gpu().summary();
        let sizes = subjects
            .first()
            .map_or_else(String::new, |subject| format!("{} × {} pixels, ", subject.view.width, subject.view.height));
        Ok(Self {
            technique: technique.name().into(),
            title: technique.title().into(),
            machine: summary.to_string(),
            method: format!(
                "{sizes}median of {frames} frames in turn with the other variants; error against the reference at {} samples a pixel",
                technique.truth().samples_per_pixel
            ),
            rows,
        })
    }

    /// The names of the scenes, in order.
    pub fn scenes(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for row in &self.rows {
            if !names.contains(&row.scene.as_str()) {
                names.push(&row.scene);
            }
        }
        names
    }
}

fn measure(
    technique: &dyn Technique,
    subject: &Subject,
    truth: &Image,
    renderer: &mut Renderer,
    frames: usize,
) -> Result<Vec<Row>, LabError> {
    let variants: Vec<(Variant, Limits)> = technique
        .variants()
        .into_iter()
        .map(|variant| {
            let limits = technique.limits(&variant, &subject.scene, &subject.view);
            (variant, limits)
        })
        .filter(|(_, limits)| !matches!(limits, Limits::Refuses(_)))
        .collect();
    let scene = |variant: &Variant| {
        let mut scene = subject.scene.clone();
        technique.apply(variant, &mut scene);
        scene
    };
    let scenes: Vec<Scene> = variants.iter().map(|(variant, _)| scene(variant)).collect();
    let mut pictures = Vec::new();
    for ((variant, _), scene) in variants.iter().zip(&scenes) {
        for _ in 1..WARM_UP {
            renderer.render_to_image(scene, &subject.view, &variant.options)?;
        }
        pictures.push(renderer.render_to_image(scene, &subject.view, &variant.options)?.0);
    }
    // In turn, so that whatever else the machine does meets all variants alike.
    let mut times = vec![Vec::new(); variants.len()];
    for _ in 0..frames.max(1) {
        for (((variant, _), scene), times) in variants.iter().zip(&scenes).zip(&mut times) {
            let options = RenderOptions { gpu_timing: true, ..variant.options.clone() };
            let (_, stats) = renderer.render_to_image(scene, &subject.view, &options)?;
            times.push(stats.gpu_ms().ok_or(LabError::NoTimestamps)?);
        }
    }
    let mut rows = Vec::new();
    for (((variant, limits), picture), mut times) in variants.into_iter().zip(pictures).zip(times) {
        let map = flip(truth, &picture, PIXELS_PER_DEGREE)?;
        let apart = difference(truth, &picture)?;
        times.sort_by(f64::total_cmp);
        let quantile = |share: f64| times[((times.len() - 1) as f64 * share).round() as usize];
        rows.push(Row {
            scene: subject.name.clone(),
            variant: variant.label,
            gpu_ms: quantile(0.5),
            gpu_quartiles: [quantile(0.25), quantile(0.75)],
            flip_mean: map.mean(),
            flip_p95: map.percentile(0.95).into(),
            flip_p99: map.percentile(0.99).into(),
            rmse: apart.rmse,
            over_24: apart.outliers(24),
            limits: limits.text(),
        });
    }
    Ok(rows)
}
