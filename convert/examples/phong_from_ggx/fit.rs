//! The best that any lobe of this form can do, point by point.

use crate::lobe::{Incidence, Lobe, Surface, error};

/// The smallest RMS that a free specular colour, exponent and diffuse share reach.
pub(crate) fn optimum(incidences: &[Incidence], surface: &Surface, alpha: f64, start: Lobe) -> (Lobe, f64) {
    let lobe_of = |p: [f64; 3]| Lobe { exponent: p[0].exp(), specular: p[1].clamp(0.0, 1.0), share: p[2].max(0.0) };
    let cost = |p: [f64; 3]| {
        let outside = (p[1] - p[1].clamp(0.0, 1.0)).abs() + (-p[2]).max(0.0);
        error(incidences, surface, alpha, lobe_of(p)).rms + 0.1 * outside
    };
    let first = [start.exponent.max(0.3).ln(), start.specular, start.share];
    let best = nelder_mead(first, [0.4, -0.1, 0.3 * start.share + 0.002], 150, cost);
    (lobe_of(best), cost(best))
}

/// Nelder and Mead's simplex search.
fn nelder_mead(start: [f64; 3], step: [f64; 3], rounds: usize, cost: impl Fn([f64; 3]) -> f64) -> [f64; 3] {
    let mut simplex: Vec<([f64; 3], f64)> = (0..4)
        .map(|corner| {
            let mut point = start;
            if corner > 0 {
                point[corner - 1] += step[corner - 1];
            }
            (point, cost(point))
        })
        .collect();
    for _ in 0..rounds {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        let center: [f64; 3] = std::array::from_fn(|i| simplex[..3].iter().map(|(p, _)| p[i]).sum::<f64>() / 3.0);
        let worst = simplex[3];
        let at = |t: f64| {
            let point: [f64; 3] = std::array::from_fn(|i| center[i] + t * (worst.0[i] - center[i]));
            (point, cost(point))
        };
        let reflected = at(-1.0);
        let next = if reflected.1 < simplex[0].1 {
            let further = at(-2.0);
            if further.1 < reflected.1 { further } else { reflected }
        } else if reflected.1 < simplex[2].1 {
            reflected
        } else {
            at(if reflected.1 < worst.1 { -0.5 } else { 0.5 })
        };
        if next.1 < worst.1 {
            simplex[3] = next;
        } else {
            let best = simplex[0].0;
            for (point, value) in &mut simplex[1..] {
                *point = std::array::from_fn(|i| 0.5 * (point[i] + best[i]));
                *value = cost(*point);
            }
        }
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    simplex[0].0
}
