//! How far a shadow technique's visibility of a light is from the truth.

use std::ops::Range;

use aam_reference::Seen;

use super::CompareError;

/// What counts as the ends of a penumbra.
const DARK: f32 = 0.1;
const LIGHT: f32 = 0.9;

/// The least distance in pixels within which two penumbras count as the same one.
const NEAR: f64 = 4.0;

/// Differences of a visibility from the truth, over the pixels whose surface faces the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibilityError {
    /// How many pixels face the light.
    pub pixels: usize,
    /// Root of the mean squared difference, 0 to 1. The truth's own noise is in it.
    pub rmse: f64,
    /// Mean difference, −1 to 1: above 0 there is too much light, below 0 too much shadow.
    pub signed_mean: f64,
    /// Mean light where there should be none: leaks. 0 where no pixel is in full shadow.
    pub leaked: f64,
    /// Mean shadow where there should be none: acne. 0 where no pixel is fully lit.
    pub lost: f64,
    /// The truth's standard error, as the root of its mean square. An `rmse` that is not well above it says nothing.
    pub noise: f64,
}

/// Compares a light's visibility in each pixel with [`aam_reference::visibility`]'s. Pixels that face away from the light
/// do not count, whatever they hold.
///
/// # Errors
/// There are fewer or more pixels than in the truth, or a pixel that counts is no number.
pub fn visibility_error(truth: &[Option<Seen>], test: &[f32]) -> Result<VisibilityError, CompareError> {
    if truth.len() != test.len() {
        return Err(CompareError::Pixels(truth.len(), test.len()));
    }
    let (mut squares, mut sum, mut noise, mut pixels) = (0.0, 0.0, 0.0, 0);
    let (mut leaked, mut lost) = (Mean::default(), Mean::default());
    for (truth, test) in truth.iter().zip(test) {
        let Some(truth) = truth else { continue };
        if !test.is_finite() {
            return Err(CompareError::NotANumber);
        }
        let apart = f64::from(*test) - f64::from(truth.share);
        squares += apart * apart;
        sum += apart;
        noise += f64::from(truth.standard_error).powi(2);
        pixels += 1;
        if truth.share == 0.0 {
            leaked.add(apart);
        } else if truth.share == 1.0 {
            lost.add(-apart);
        }
    }
    let count = f64::from(u32::try_from(pixels).unwrap_or(u32::MAX)).max(1.0);
    Ok(VisibilityError {
        pixels,
        rmse: (squares / count).sqrt(),
        signed_mean: sum / count,
        leaked: leaked.get(),
        lost: lost.get(),
        noise: (noise / count).sqrt(),
    })
}

#[derive(Default)]
struct Mean {
    sum: f64,
    count: u32,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn get(&self) -> f64 {
        self.sum / f64::from(self.count.max(1))
    }
}

/// Differences of the widths of penumbras, from 10 % to 90 % of the light, along rows and columns of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PenumbraError {
    /// Penumbras of the truth.
    pub count: usize,
    /// Those of them that have none beside them that runs the same way.
    pub missed: usize,
    /// Mean width of the truth's that were not missed, in pixels.
    pub width: f64,
    /// Mean difference from it, in pixels: above 0 the technique's are wider.
    pub signed_mean: f64,
    /// Mean of the differences without sign, in pixels.
    pub absolute_mean: f64,
}

/// Compares the widths of the penumbras along all rows and columns of pictures that are `width` pixels wide.
///
/// # Errors
/// As for [`visibility_error`], or the pixels do not fill whole rows.
pub fn penumbra_error(width: usize, truth: &[Option<Seen>], test: &[f32]) -> Result<PenumbraError, CompareError> {
    if truth.len() != test.len() || width == 0 || !truth.len().is_multiple_of(width) {
        return Err(CompareError::Pixels(truth.len(), test.len()));
    }
    let height = truth.len() / width;
    let rows = (0..height).map(|row| (row * width, 1, width));
    let columns = (0..width).map(|column| (column, width, height));
    let (mut found, mut sum, mut absolute, mut widths) = (PenumbraError::default(), 0.0, 0.0, 0.0);
    for (start, step, length) in rows.chain(columns) {
        let at = |index: usize| start + index * step;
        let faces = |index: usize| truth[at(index)];
        for run in runs(length, |index| faces(index).is_some()) {
            let of_truth = ramps(run.clone(), |index| faces(index).map_or(0.0, |seen| seen.share));
            let of_test = ramps(run, |index| test[at(index)]);
            for ramp in of_truth {
                found.count += 1;
                let reach = ramp.width().max(NEAR);
                let beside = of_test.iter().filter(|test| test.rises == ramp.rises && test.distance(&ramp) <= reach);
                let Some(test) = beside.min_by(|a, b| a.distance(&ramp).total_cmp(&b.distance(&ramp))) else {
                    found.missed += 1;
                    continue;
                };
                let apart = test.width() - ramp.width();
                sum += apart;
                absolute += apart.abs();
                widths += ramp.width();
            }
        }
    }
    let matched = (found.count - found.missed).max(1) as f64;
    Ok(PenumbraError {
        width: widths / matched,
        signed_mean: sum / matched,
        absolute_mean: absolute / matched,
        ..found
    })
}

/// The longest stretches of positions for which something holds.
fn runs(length: usize, holds: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for index in (0..length).filter(|index| holds(*index)) {
        match runs.last_mut() {
            Some(run) if run.end == index => run.end += 1,
            _ => runs.push(index..index + 1),
        }
    }
    runs
}

/// A way from shadow to light or back.
#[derive(Clone, Copy, Debug)]
struct Ramp {
    /// Positions between pixels.
    start: f64,
    end: f64,
    rises: bool,
}

impl Ramp {
    fn width(&self) -> f64 {
        self.end - self.start
    }

    fn distance(&self, other: &Self) -> f64 {
        0.5 * (self.start + self.end - other.start - other.end).abs()
    }
}

/// Each way from the last pixel that is dark to the first that is light, and from light to dark.
fn ramps(run: Range<usize>, value: impl Fn(usize) -> f32) -> Vec<Ramp> {
    let mut ramps = Vec::new();
    // The last pixel at an end, and whether that is the light one.
    let mut left: Option<(usize, bool)> = None;
    // Where the line between two pixels has a value.
    let crossing = |index: usize, at: f32| {
        let (a, b) = (value(index), value(index + 1));
        index as f64 + f64::from(((at - a) / (b - a)).clamp(0.0, 1.0))
    };
    for index in run {
        let light = match value(index) {
            value if value >= LIGHT => true,
            value if value <= DARK => false,
            _ => continue,
        };
        if let Some((last, was_light)) = left
            && was_light != light
        {
            let (from, to) = if light { (DARK, LIGHT) } else { (LIGHT, DARK) };
            ramps.push(Ramp { start: crossing(last, from), end: crossing(index - 1, to), rises: light });
        }
        left = Some((index, light));
    }
    ramps
}

#[cfg(test)]
mod tests {
    use super::*;

    fn truth(values: &[f32]) -> Vec<Option<Seen>> {
        let seen = |share: &f32| (*share >= 0.0).then_some(Seen { share: *share, standard_error: 0.01 });
        values.iter().map(seen).collect()
    }

    #[test]
    fn errors_are_taken_over_the_pixels_that_face_the_light() {
        let truth = truth(&[0.0, 0.0, 1.0, 0.5, -1.0]);
        let found = visibility_error(&truth, &[0.2, 0.0, 0.9, 0.5, f32::NAN]).unwrap();
        assert_eq!(found.pixels, 4);
        assert!((found.rmse - (0.05_f64 / 4.0).sqrt()).abs() < 1e-7, "{found:?}");
        assert!((found.signed_mean - 0.025).abs() < 1e-7 && (found.noise - 0.01).abs() < 1e-7, "{found:?}");
        assert!((found.leaked - 0.1).abs() < 1e-7 && (found.lost - 0.1).abs() < 1e-7, "{found:?}");
        assert_eq!(visibility_error(&truth, &[0.0; 4]), Err(CompareError::Pixels(5, 4)));
        assert_eq!(visibility_error(&truth, &[f32::NAN; 5]), Err(CompareError::NotANumber));
        assert_eq!(visibility_error(&[None], &[0.0]).unwrap().rmse, 0.0);
    }

    /// A row that climbs from shadow to light over `width` pixels around a place, from 0 to 1.
    fn edge(place: f32, width: f32) -> Vec<f32> {
        (0..64).map(|x| ((x as f32 - place) / width + 0.5).clamp(0.0, 1.0)).collect()
    }

    #[test]
    fn widths_of_penumbras_are_compared() {
        let exact = edge(30.0, 20.0);
        for (width, apart) in [(20.0, 0.0), (10.0, -8.0), (30.0, 8.0)] {
            let found = penumbra_error(64, &truth(&exact), &edge(30.0, width)).unwrap();
            assert_eq!((found.count, found.missed), (1, 0));
            assert!((found.width - 16.0).abs() < 1e-3, "80 % of 20 pixels: {found:?}");
            assert!((found.signed_mean - apart).abs() < 1e-3, "{found:?}");
            assert!((found.absolute_mean - apart.abs()).abs() < 1e-3, "{found:?}");
        }
        // Turned round, and as a column.
        let back: Vec<f32> = exact.iter().rev().copied().collect();
        let found = penumbra_error(1, &truth(&back), &back).unwrap();
        assert_eq!((found.count, found.missed, found.signed_mean), (1, 0, 0.0));
        // A hard edge is at most a pixel wide.
        let found = penumbra_error(64, &truth(&exact), &edge(30.3, 0.001)).unwrap();
        assert!((-16.0..-15.0).contains(&found.signed_mean), "{found:?}");
    }

    #[test]
    fn a_penumbra_that_is_not_there_is_missed() {
        let exact = edge(30.0, 6.0);
        for other in [vec![1.0; 64], edge(50.0, 6.0), exact.iter().map(|value| 1.0 - value).collect()] {
            let found = penumbra_error(64, &truth(&exact), &other).unwrap();
            assert_eq!((found.count, found.missed), (1, 1));
        }
        // A gap between surfaces is no penumbra.
        let mut gap = exact.clone();
        gap[30] = -1.0;
        assert_eq!(penumbra_error(64, &truth(&gap), &exact).unwrap().count, 0);
        assert!(penumbra_error(7, &truth(&exact), &exact).is_err());
    }
}
