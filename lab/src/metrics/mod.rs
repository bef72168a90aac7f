//! How far two pictures are apart.
//!
//! [`flip`] says what a person would notice, [`Difference`] what the numbers are. A mean hides small spots of large
//! error, so both come with percentiles or counts. [`visibility_error`] and [`penumbra_error`] judge shadows by
//! themselves, without the colours they fall on.

mod difference;
mod flip;
mod magma;
mod surface;
mod visibility;

use aam_scene::{Image, Pixels};
use thiserror::Error;

pub use difference::{Difference, difference, difference_picture};
pub use flip::{ErrorMap, PIXELS_PER_DEGREE, flip};
pub use magma::magma;
pub use surface::{SurfaceError, surface_error};
pub use visibility::{PenumbraError, VisibilityError, penumbra_error, visibility_error};

/// Why two pictures cannot be compared.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum CompareError {
    /// The sizes differ.
    #[error("a picture of {}×{} pixels cannot be compared with one of {}×{}", .0[0], .0[1], .1[0], .1[1])]
    Size([u32; 2], [u32; 2]),
    /// A picture has no pixels, or fewer than its size says.
    #[error("a picture of {0}×{1} pixels lacks pixels")]
    Missing(u32, u32),
    /// The pixels are not 8 bits a channel.
    #[error("only pictures with 8 bits a channel can be compared")]
    Format,
    /// The numbers of pixels differ, or do not fill rows.
    #[error("{1} pixels cannot be compared with {0}")]
    Pixels(usize, usize),
    /// A pixel holds no number.
    #[error("a pixel that counts is not a number")]
    NotANumber,
    /// Pixels per degree must be positive.
    #[error("pixels per degree must be above 0 and at most 1000")]
    Resolution,
}

/// The bytes of two pictures of the same size.
fn rgba<'a>(a: &'a Image, b: &'a Image) -> Result<(&'a [u8], &'a [u8]), CompareError> {
    if (a.width, a.height) != (b.width, b.height) {
        return Err(CompareError::Size([a.width, a.height], [b.width, b.height]));
    }
    let bytes = |image: &'a Image| {
        let Pixels::Rgba8(bytes) = &image.pixels else { return Err(CompareError::Format) };
        let count = (image.width as usize).checked_mul(image.height as usize).and_then(|count| count.checked_mul(4));
        let missing = CompareError::Missing(image.width, image.height);
        count.filter(|count| *count > 0).and_then(|count| bytes.get(..count)).ok_or(missing)
    };
    Ok((bytes(a)?, bytes(b)?))
}
