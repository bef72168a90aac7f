//! Which settings no other beats, and their chart as SVG.

use super::{ShadowChart, TruthKind};
use crate::chart::{Dot, Panel, sheet};

/// The positions of the points `(cost, error)` that no other beats or equals in both, by cost.
pub fn pareto(points: impl Iterator<Item = (f64, f64)>) -> Vec<usize> {
    let mut sorted: Vec<(usize, (f64, f64))> =
        points.enumerate().filter(|(_, (cost, error))| cost.is_finite() && error.is_finite()).collect();
    sorted.sort_by(|(_, a), (_, b)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut best = f64::INFINITY;
    sorted.retain(|(_, (_, error))| {
        let better = *error < best;
        best = best.min(*error);
        better
    });
    sorted.into_iter().map(|(index, _)| index).collect()
}

pub(super) use pareto as front_of;

/// One panel for each truth: GPU time of a frame to the right, root mean squared error of the visibility upwards, one dot
/// for each setting, and a line through those that no other beats in both.
pub fn fronts(chart: &ShadowChart) -> String {
    let panels: Vec<Panel> = chart
        .truths
        .iter()
        .enumerate()
        .map(|(index, truth)| {
            let dots = chart.runs.iter().map(|run| Dot {
                label: run.label(),
                group: run.technique(),
                x: run.times.gpu_ms,
                x_quartiles: run.times.quartiles,
                y: run.judged[index].visibility.rmse,
            });
            let title = match truth.kind {
                TruthKind::Point => "against a point",
                TruthKind::Area => "against the light at its size",
            };
            Panel {
                title: title.into(),
                x_label: "GPU time of a frame, ms (logarithmic)".into(),
                y_label: "RMSE of the visibility".into(),
                dots: dots.collect(),
            }
        })
        .collect();
    let [width, height] = chart.size;
    let notes = [
        chart.adapter.clone(),
        format!(
            "{width} × {height} pixels, medians of up to {} frames in turn; truth of {} shadow rays a pixel",
            chart.frames, chart.rays.light_samples
        ),
    ];
    sheet(&format!("Shadows of {} in {}", chart.light, chart.scene), &notes, &panels)
}
