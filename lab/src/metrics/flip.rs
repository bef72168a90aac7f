//! FLIP: the difference that a person sees when flipping between two pictures.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference Evaluator for Alternating
//! Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020; the low-dynamic-range form. Section numbers are the
//! paper's. The results agree with the authors' `flip-evaluator` (see `lab/tests/flip.rs`).

use aam_scene::{Image, Pixels};
use rayon::prelude::*;

use super::{CompareError, magma, rgba};

/// Pixels per degree of visual angle on a 0.7 m wide display of 3840 pixels seen from 0.7 m, the paper's default.
pub const PIXELS_PER_DEGREE: f32 = 67.0206;

/// A difference for each pixel, 0 (none) to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMap {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Row after row from the top.
    pub values: Vec<f32>,
}

impl ErrorMap {
    /// Mean over all pixels.
    pub fn mean(&self) -> f64 {
        self.values.iter().map(|value| f64::from(*value)).sum::<f64>() / self.values.len().max(1) as f64
    }

    /// Largest value.
    pub fn max(&self) -> f32 {
        self.values.iter().copied().fold(0.0, f32::max)
    }

    /// The value that a share (0 to 1) of all pixels does not exceed.
    pub fn percentile(&self, share: f64) -> f32 {
        let mut sorted = self.values.clone();
        sorted.sort_by(f32::total_cmp);
        let index = (share * sorted.len() as f64).ceil() as usize;
        sorted.get(index.clamp(1, sorted.len().max(1)) - 1).copied().unwrap_or(0.0)
    }

    /// The value below which pixels make up half of the sum of all values: half of the error is in larger values.
    pub fn weighted_median(&self) -> f32 {
        let mut sorted = self.values.clone();
        sorted.sort_by(f32::total_cmp);
        let half = 0.5 * sorted.iter().map(|value| f64::from(*value)).sum::<f64>();
        let mut sum = 0.0;
        let passed = sorted.into_iter().find(|value| {
            sum += f64::from(*value);
            sum > half
        });
        passed.unwrap_or(0.0)
    }

    /// The map in colours from black (0) through magenta to pale yellow (1).
    pub fn to_image(&self) -> Image {
        let bytes = self.values.iter().flat_map(|value| {
            let [r, g, b] = magma(*value);
            [r, g, b, u8::MAX]
        });
        Image { width: self.width, height: self.height, pixels: Pixels::Rgba8(bytes.collect()) }
    }
}

/// The FLIP difference of two sRGB pictures. Transparent pixels are laid over mid grey first.
///
/// # Errors
/// The pictures differ in size, lack pixels, or are not 8 bits a channel; `pixels_per_degree` is not in (0, 1000].
pub fn flip(reference: &Image, test: &Image, pixels_per_degree: f32) -> Result<ErrorMap, CompareError> {
    if !(pixels_per_degree > 0.0 && pixels_per_degree <= 1000.0) {
        return Err(CompareError::Resolution);
    }
    let (reference_bytes, test_bytes) = rgba(reference, test)?;
    let size = (reference.width as usize, reference.height as usize);
    let [reference_opponent, test_opponent] = [reference_bytes, test_bytes].map(opponent);
    let [reference_seen, test_seen] =
        [&reference_opponent, &test_opponent].map(|image| seen_colors(image, size, pixels_per_degree));
    let [reference_features, test_features] =
        [&reference_opponent[0], &test_opponent[0]].map(|luma| features(luma, size, pixels_per_degree));
    let largest = largest_distance();
    let values = (0..size.0 * size.1).into_par_iter().map(|pixel| {
        let color = color_error(hyab(reference_seen[pixel], test_seen[pixel]), largest);
        let (a, b) = (reference_features[pixel], test_features[pixel]);
        // §4.2: the larger of the edge and point differences, with exponent q_f = 0.5.
        let feature = ((a[0] - b[0]).abs().max((a[1] - b[1]).abs()) * std::f32::consts::FRAC_1_SQRT_2).sqrt();
        // §4.3
        color.powf(1.0 - feature.min(1.0))
    });
    Ok(ErrorMap { width: reference.width, height: reference.height, values: values.collect() })
}

/// One channel of an image.
type Plane = Vec<f32>;

/// D65, as the white of linear RGB (1, 1, 1).
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];

/// Linear RGB to XYZ, divided by the white.
fn xyz([r, g, b]: [f32; 3]) -> [f32; 3] {
    const X: f32 = 24_577_794.0 * WHITE[0];
    const Y: f32 = 12_288_897.0;
    const Z: f32 = 73_733_382.0 * WHITE[2];
    [
        (10_135_552.0 * r + 8_788_810.0 * g + 4_435_075.0 * b) / X,
        (2_613_072.0 * r + 8_788_810.0 * g + 887_015.0 * b) / Y,
        (1_425_312.0 * r + 8_788_810.0 * g + 70_074_185.0 * b) / Z,
    ]
}

/// The inverse of [`xyz`].
fn linear_rgb(xyz: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = [xyz[0] * WHITE[0], xyz[1], xyz[2] * WHITE[2]];
    [
        3.241_003_3 * x - 1.537_399 * y - 0.498_615_86 * z,
        -0.969_224_34 * x + 1.875_93 * y + 0.041_554_224 * z,
        0.055_639_423 * x - 0.204_011_2 * y + 1.057_149 * z,
    ]
}

/// Bytes to the opponent space YCxCz, a linear relative of L*a*b* (§4.1.1).
fn opponent(rgba: &[u8]) -> [Plane; 3] {
    let decode: Vec<f32> = (0..=255)
        .map(|byte| {
            let value = byte as f32 / 255.0;
            if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        })
        .collect();
    let mut planes = [const { Vec::new() }; 3];
    for texel in rgba.chunks_exact(4) {
        let rgb = [0, 1, 2].map(|channel| {
            let over = u32::from(texel[channel]) * u32::from(texel[3]) + 128 * u32::from(255 - texel[3]);
            decode[((over + 127) / 255) as usize]
        });
        let [x, y, z] = xyz(rgb);
        for (plane, value) in planes.iter_mut().zip([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]) {
            plane.push(value);
        }
    }
    planes
}

/// Filters with the eye's contrast sensitivity, and gives Hunt-adjusted L*a*b* (§4.1.1, §4.1.2).
fn seen_colors(image: &[Plane; 3], size: (usize, usize), pixels_per_degree: f32) -> Vec<[f32; 3]> {
    let luma = Gaussian { scale: 1.0, width: 0.0047 };
    let red_green = Gaussian { scale: 1.0, width: 0.0053 };
    let blue_yellow = [Gaussian { scale: 34.1, width: 0.04 }, Gaussian { scale: 13.5, width: 0.025 }];
    // All filters reach as far as the widest.
    let radius = (3.0 * (0.04 / (2.0 * std::f32::consts::PI.powi(2))).sqrt() * pixels_per_degree).ceil() as usize;
    let filter = |plane: &Plane, gaussians: &[Gaussian]| {
        let kernels: Vec<_> = gaussians.iter().map(|gaussian| gaussian.kernel(radius, pixels_per_degree)).collect();
        let total: f32 = kernels.iter().map(|(scale, kernel)| scale * kernel.iter().sum::<f32>().powi(2)).sum();
        let mut sum = vec![0.0; plane.len()];
        for (scale, kernel) in kernels {
            let blurred = vertical(&horizontal(plane, size, &kernel), size, &kernel);
            sum.iter_mut().zip(blurred).for_each(|(sum, value)| *sum += value * (scale / total));
        }
        sum
    };
    let (y, (cx, cz)) = rayon::join(
        || filter(&image[0], &[luma]),
        || rayon::join(|| filter(&image[1], &[red_green]), || filter(&image[2], &blue_yellow)),
    );
    let seen = y.par_iter().zip(&cx).zip(&cz).map(|((y, cx), cz)| {
        let y = (y + 16.0) / 116.0;
        let rgb = linear_rgb([y + cx / 500.0, y, y - cz / 200.0]).map(|channel| channel.clamp(0.0, 1.0));
        hunt_lab(rgb)
    });
    seen.collect()
}

/// One term `a √(π/b) exp(−π²x²/b)` of a contrast sensitivity function, x in degrees (table 1).
struct Gaussian {
    scale: f32,
    width: f32,
}

impl Gaussian {
    /// The factor and the one-dimensional kernel.
    fn kernel(&self, radius: usize, pixels_per_degree: f32) -> (f32, Vec<f32>) {
        let pi = std::f32::consts::PI;
        let at = |offset: usize| {
            let degrees = (offset as f32 - radius as f32) / pixels_per_degree;
            (-(pi * degrees).powi(2) / self.width).exp()
        };
        (self.scale * (pi / self.width).sqrt(), (0..=2 * radius).map(at).collect())
    }
}

/// L*a*b* with chroma that weakens with lightness: Hunt's effect.
fn hunt_lab(rgb: [f32; 3]) -> [f32; 3] {
    let delta: f32 = 6.0 / 29.0;
    let root = |t: f32| if t > delta.powi(3) { t.cbrt() } else { t / (3.0 * delta * delta) + 4.0 / 29.0 };
    let [x, y, z] = xyz(rgb).map(root);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// City block in lightness, Euclidean in chroma (§4.1.3), with exponent q_c = 0.7.
fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    ((a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])).powf(0.7)
}

/// The largest distance within sRGB: that of pure green and pure blue.
fn largest_distance() -> f32 {
    hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0]))
}

/// Spreads distances so that those up to p_c = 0.4 of the largest fill the range up to p_t = 0.95 (§4.1.3).
fn color_error(distance: f32, largest: f32) -> f32 {
    let knee = 0.4 * largest;
    if distance < knee { 0.95 / knee * distance } else { 0.95 + (distance - knee) / (largest - knee) * 0.05 }
}

/// Strength of edges and of points in the luma of each pixel (§4.2.1).
fn features(luma: &Plane, size: (usize, usize), pixels_per_degree: f32) -> Vec<[f32; 2]> {
    let deviation = 0.5 * 0.082 * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as usize;
    let kernel = |weight: fn(f32, f32) -> f32| -> Vec<f32> {
        let at = |index: usize| {
            let x = index as f32 - radius as f32;
            weight(x, deviation) * (-x * x / (2.0 * deviation * deviation)).exp()
        };
        (0..=2 * radius).map(at).collect()
    };
    let blur = normalized(kernel(|_, _| 1.0));
    let edge = normalized(kernel(|x, _| -x));
    let point = normalized(kernel(|x, deviation| x * x / (deviation * deviation) - 1.0));
    let normal_luma: Plane = luma.iter().map(|y| (y + 16.0) / 116.0).collect();
    let across = |kernel: &[f32]| vertical(&horizontal(&normal_luma, size, kernel), size, &blur);
    let down = |kernel: &[f32]| vertical(&horizontal(&normal_luma, size, &blur), size, kernel);
    let ((edge_x, edge_y), (point_x, point_y)) = rayon::join(
        || rayon::join(|| across(&edge), || down(&edge)),
        || rayon::join(|| across(&point), || down(&point)),
    );
    let norms = (0..luma.len()).map(|pixel| [edge_x[pixel].hypot(edge_y[pixel]), point_x[pixel].hypot(point_y[pixel])]);
    norms.collect()
}

/// Makes the positive weights sum to 1 and the negative ones to −1.
fn normalized(mut kernel: Vec<f32>) -> Vec<f32> {
    let sum = |sign: f32| kernel.iter().map(|weight| (sign * weight).max(0.0)).sum::<f32>();
    let (positive, negative) = (sum(1.0), sum(-1.0));
    kernel
        .iter_mut()
        .for_each(|weight| *weight /= if *weight > 0.0 { positive } else { negative.max(f32::MIN_POSITIVE) });
    kernel
}

/// Convolves rows; beyond the border the nearest pixel counts.
fn horizontal(plane: &[f32], (width, _): (usize, usize), kernel: &[f32]) -> Plane {
    let radius = kernel.len() / 2;
    let mut result = vec![0.0; plane.len()];
    result.par_chunks_mut(width).zip(plane.par_chunks(width)).for_each(|(target, source)| {
        let before = std::iter::repeat_n(source[0], radius);
        let after = std::iter::repeat_n(source[width - 1], radius);
        let padded: Vec<f32> = before.chain(source.iter().copied()).chain(after).collect();
        for (x, value) in target.iter_mut().enumerate() {
            *value = padded[x..x + kernel.len()].iter().zip(kernel).map(|(value, weight)| value * weight).sum();
        }
    });
    result
}

/// Convolves columns likewise.
fn vertical(plane: &[f32], (width, height): (usize, usize), kernel: &[f32]) -> Plane {
    let radius = kernel.len() / 2;
    let mut result = vec![0.0; plane.len()];
    result.par_chunks_mut(width).enumerate().for_each(|(y, target)| {
        for (offset, weight) in kernel.iter().enumerate() {
            let row = (y + offset).saturating_sub(radius).min(height - 1);
            let source = &plane[row * width..(row + 1) * width];
            target.iter_mut().zip(source).for_each(|(sum, value)| *sum += weight * value);
        }
    });
    result
}
