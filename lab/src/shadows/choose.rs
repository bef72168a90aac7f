//! The cheapest setting that is accurate enough, or the most accurate that is cheap enough.

use std::fmt;

use super::{Run, ShadowChart, TruthKind};

/// What is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// At most this root mean squared error of the visibility; of those the cheapest.
    MaxError(f64),
    /// At most so many milliseconds of GPU time a frame; of those the most accurate.
    Budget(f64),
}

/// A setting that reaches a goal, or comes closest.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Its position in [`ShadowChart::runs`].
    pub run: usize,
    /// Whether it reaches the goal.
    pub reached: bool,
    /// How sure that is, sentence by sentence.
    pub because: Vec<String>,
}

/// Errors that differ by less than this share count as the same: no eye tells them apart.
const SAME: f64 = 0.02;

/// Chooses among the runs of a chart; `none`, which has no shadow, is one of them. `None` if the truth was not traced.
pub fn choose(chart: &ShadowChart, truth: TruthKind, goal: Goal) -> Option<Choice> {
    let at = chart.truth(truth)?;
    let error = |run: &Run| run.judged[at].visibility.rmse;
    let noise = |run: &Run| run.judged[at].visibility.noise;
    let all: Vec<usize> = (0..chart.runs.len()).collect();
    let cost = |index: &usize| chart.runs[*index].times.gpu_ms;
    let cheapest = |of: &[usize]| {
        of.iter()
            .copied()
            .min_by(|a, b| cost(a).total_cmp(&cost(b)).then(chart.runs[*a].bytes.cmp(&chart.runs[*b].bytes)))
    };
    let most_accurate = |of: &[usize]| {
        let least = of.iter().map(|index| error(&chart.runs[*index])).fold(f64::INFINITY, f64::min);
        // Of those that are as good, the cheapest.
        let good: Vec<usize> = of
            .iter()
            .copied()
            .filter(|index| {
                let run = &chart.runs[*index];
                // The noise is in all alike; what is above it is the techniques' own.
                error(run) <= least * (1.0 + SAME)
            })
            .collect();
        cheapest(&good)
    };
    let within: Vec<usize> = all
        .iter()
        .copied()
        .filter(|index| match goal {
            Goal::MaxError(most) => error(&chart.runs[*index]) <= most,
            Goal::Budget(most) => cost(index) <= most,
        })
        .collect();
    let reached = !within.is_empty();
    let run = match (goal, reached) {
        (Goal::MaxError(_), true) => cheapest(&within),
        (Goal::MaxError(_), false) => most_accurate(&all),
        (Goal::Budget(_), true) => most_accurate(&within),
        (Goal::Budget(_), false) => cheapest(&all),
    }?;
    let chosen = &chart.runs[run];
    let mut because = vec![format!(
        "{}: {:.2} ms a frame (half of {} frames between {:.2} and {:.2}), of which the shadow {:.2}; error {:.4} against {}",
        chosen.label(),
        chosen.times.gpu_ms,
        chosen.times.frames,
        chosen.times.quartiles[0],
        chosen.times.quartiles[1],
        chosen.times.shadow_ms(),
        error(chosen),
        Named(truth),
    )];
    if !reached {
        because.push(match goal {
            Goal::MaxError(most) => {
                format!("nothing that was measured has an error of at most {most}; this comes closest")
            }
            Goal::Budget(most) => format!("nothing that was measured takes at most {most} ms; this takes the least"),
        });
    }
    if noise(chosen) > 0.0 {
        because.push(match goal {
            Goal::MaxError(most) if (error(chosen) - most).abs() < 0.5 * noise(chosen) * noise(chosen) / most.max(1e-6) => format!(
                "the noise of the truth ({:.4}) is as large as its distance from the limit: --full traces more rays",
                noise(chosen)
            ),
            _ => format!("the noise of the truth is {:.4}", noise(chosen)),
        });
    }
    because.extend(rival(chart, at, goal, run, &within).map(|rival| beside(&chart.runs, at, run, rival)));
    because.extend(coarser_and_finer(chart, at, run));
    Some(Choice { run, reached, because })
}

struct Named(TruthKind);

impl fmt::Display for Named {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.0 {
            TruthKind::Point => "the light as a point",
            TruthKind::Area => "the light at its size",
        })
    }
}

/// What would be chosen if the chosen were not there.
fn rival(chart: &ShadowChart, at: usize, goal: Goal, chosen: usize, within: &[usize]) -> Option<usize> {
    let others = within.iter().copied().filter(|index| *index != chosen);
    let key = |index: &usize| match goal {
        Goal::MaxError(_) => chart.runs[*index].times.gpu_ms,
        Goal::Budget(_) => chart.runs[*index].judged[at].visibility.rmse,
    };
    others.min_by(|a, b| key(a).total_cmp(&key(b)))
}

fn beside(runs: &[Run], at: usize, chosen: usize, rival: usize) -> String {
    let (a, b) = (&runs[chosen], &runs[rival]);
    let apart = b.times.gpu_ms - a.times.gpu_ms;
    let sure = if a.times.quartiles[1] < b.times.quartiles[0] {
        "their quartiles do not touch"
    } else {
        "their quartiles overlap, so on another day it may win"
    };
    format!(
        "next is {} with {:.2} ms ({apart:+.2}) and error {:.4} ({:+.4}); {sure}",
        b.label(),
        b.times.gpu_ms,
        b.judged[at].visibility.rmse,
        b.judged[at].visibility.rmse - a.judged[at].visibility.rmse,
    )
}

/// What the same technique does at half and at twice the resolution.
fn coarser_and_finer(chart: &ShadowChart, at: usize, chosen: usize) -> Vec<String> {
    let run = &chart.runs[chosen];
    let Some(settings) = run.settings else { return Vec::new() };
    let other = |resolution: u32| {
        let wanted = aam_scene::ShadowSettings { resolution, ..settings };
        chart.runs.iter().find(|run| run.settings == Some(wanted))
    };
    let rmse = |run: &Run| run.judged[at].visibility.rmse;
    let mut sentences = Vec::new();
    if let Some(finer) = other(2 * settings.resolution) {
        let gain = rmse(run) - rmse(finer);
        sentences.push(if gain <= SAME * rmse(run) {
            format!(
                "resolution {} would bring nothing: the pictures do not resolve more ({:.4} instead of {:.4}, for {} more bytes)",
                2 * settings.resolution,
                rmse(finer),
                rmse(run),
                finer.bytes.saturating_sub(run.bytes)
            )
        } else {
            format!(
                "resolution {} would lower the error by {gain:.4} for {:+.2} ms",
                2 * settings.resolution,
                finer.times.gpu_ms - run.times.gpu_ms
            )
        });
    }
    if let Some(coarser) = other(settings.resolution / 2) {
        sentences.push(format!(
            "resolution {} would raise the error by {:.4} and save {:.2} ms",
            settings.resolution / 2,
            rmse(coarser) - rmse(run),
            run.times.gpu_ms - coarser.times.gpu_ms
        ));
    }
    sentences
}
