//! Differences of the stored numbers.

use aam_scene::{Image, Pixels};

use super::{CompareError, magma, rgba};

/// Differences of the stored bytes, over all four channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Root of the mean squared difference, in units of the full range: 0 to 1.
    pub rmse: f64,
    /// Largest difference of any channel, 0 to 255.
    pub max: u8,
    /// How many pixels differ by 0, 1 … 255 in the channel where they differ most.
    pub histogram: [u64; 256],
}

impl Difference {
    /// Peak signal-to-noise ratio in decibels; infinite for equal pictures.
    pub fn psnr(&self) -> f64 {
        -20.0 * self.rmse.log10()
    }

    /// Share of pixels that differ by more than `threshold` in any channel.
    pub fn outliers(&self, threshold: u8) -> f64 {
        let all: u64 = self.histogram.iter().sum();
        let beyond: u64 = self.histogram[usize::from(threshold) + 1..].iter().sum();
        beyond as f64 / all.max(1) as f64
    }
}

/// Compares the bytes of two pictures.
///
/// # Errors
/// The pictures differ in size, lack pixels, or are not 8 bits a channel.
pub fn difference(reference: &Image, test: &Image) -> Result<Difference, CompareError> {
    let (a, b) = rgba(reference, test)?;
    let mut histogram = [0; 256];
    let mut squares = 0;
    for (a, b) in a.chunks_exact(4).zip(b.chunks_exact(4)) {
        let apart = [0, 1, 2, 3].map(|channel| a[channel].abs_diff(b[channel]));
        histogram[usize::from(apart.into_iter().fold(0, u8::max))] += 1;
        squares += apart.map(|value| u64::from(value) * u64::from(value)).iter().sum::<u64>();
    }
    let rmse = (squares as f64 / a.len() as f64).sqrt() / 255.0;
    let max = histogram.iter().rposition(|count| *count > 0).unwrap_or(0) as u8;
    Ok(Difference { rmse, max, histogram })
}

/// A picture of the difference: each pixel's largest channel difference, `full` of which is the brightest colour.
///
/// # Errors
/// As for [`difference`].
pub fn difference_picture(reference: &Image, test: &Image, full: u8) -> Result<Image, CompareError> {
    let (a, b) = rgba(reference, test)?;
    let pairs = a.chunks_exact(4).zip(b.chunks_exact(4));
    let apart = pairs.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).fold(0, u8::max));
    let bytes = apart.flat_map(|apart| {
        let [r, g, b] = magma(f32::from(apart) / f32::from(full.max(1)));
        [r, g, b, u8::MAX]
    });
    Ok(Image { width: reference.width, height: reference.height, pixels: Pixels::Rgba8(bytes.collect()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(bytes: &[u8]) -> Image {
        Image { width: bytes.len() as u32 / 4, height: 1, pixels: Pixels::Rgba8(bytes.to_vec()) }
    }

    #[test]
    fn differences_are_counted_by_pixel_and_averaged_by_channel() {
        let a = image(&[0, 0, 0, 255, 10, 20, 30, 255, 0, 0, 0, 0, 9, 9, 9, 9]);
        let b = image(&[0, 0, 0, 255, 10, 50, 29, 255, 0, 0, 0, 30, 9, 9, 9, 9]);
        let found = difference(&a, &b).unwrap();
        assert!((found.rmse - (1801.0_f64 / 16.0).sqrt() / 255.0).abs() < 1e-12);
        assert_eq!((found.max, found.outliers(30), found.outliers(29), found.outliers(0)), (30, 0.0, 0.5, 0.5));
        assert_eq!(difference(&a, &a).unwrap().psnr(), f64::INFINITY);
        assert!((Difference { rmse: 0.1, ..found }.psnr() - 20.0).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_compared_is_refused() {
        let (one, two) = (image(&[0; 4]), image(&[0; 8]));
        assert_eq!(difference(&one, &two), Err(CompareError::Size([1, 1], [2, 1])));
        let short = Image { width: 3, ..two.clone() };
        assert_eq!(difference(&short, &short), Err(CompareError::Missing(3, 1)));
        let float = Image { width: 1, height: 1, pixels: Pixels::RgbF32(vec![0.0; 3]) };
        assert_eq!(difference(&float, &float), Err(CompareError::Format));
    }
}
