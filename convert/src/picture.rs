//! Pictures made of other pictures.

use std::sync::Arc;

use aam_scene::{Image, Pixels};
use glam::{Vec3, Vec4};
use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};

/// An encoded PNG.
pub(crate) type Encoded = Arc<[u8]>;

fn texel(image: &Image, x: u32, y: u32) -> Vec4 {
    let at = y as usize * image.width as usize + x as usize;
    match &image.pixels {
        Pixels::Rgba8(values) => Vec4::from_array(std::array::from_fn(|i| f32::from(values[4 * at + i]) / 255.0)),
        Pixels::Rgba16(values) => Vec4::from_array(std::array::from_fn(|i| f32::from(values[4 * at + i]) / 65535.0)),
        Pixels::RgbF32(values) => Vec3::from_slice(&values[3 * at..3 * at + 3]).extend(1.0),
    }
}

fn luminance(texel: Vec4) -> f32 {
    texel.truncate().dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

fn byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}

fn encode(width: u32, height: u32, bytes: &[u8], color: image::ExtendedColorType) -> Result<Encoded, String> {
    let mut encoded = Vec::new();
    PngEncoder::new_with_quality(&mut encoded, CompressionType::Default, FilterType::Adaptive)
        .write_image(bytes, width, height, color)
        .map_err(|error| format!("the picture cannot be encoded: {error}"))?;
    Ok(encoded.into())
}

/// A tangent-space normal map of a height map: N ∝ (−s·∂h/∂u, −s·∂h/∂v, 1) with derivatives for one pixel by Sobel's
/// operator, so that a slope of one height unit in one pixel is 45° at strength 1. The picture repeats at its edges.
pub(crate) fn heights_to_normals(heights: &Image, strength: f32) -> Result<Encoded, String> {
    let (width, height) = (heights.width, heights.height);
    let row = |y: u32| -> Vec<f32> { (0..width).map(|x| luminance(texel(heights, x, y))).collect() };
    let mut bytes = Vec::with_capacity(3 * width as usize * height as usize);
    // Three rows at a time; row −1 is above the first.
    let (mut above, mut here) = (row(height - 1), row(0));
    for y in 0..height {
        let below = row((y + 1) % height);
        for x in 0..width as usize {
            let (left, right) = ((x + width as usize - 1) % width as usize, (x + 1) % width as usize);
            let across = |row: &[f32]| row[right] - row[left];
            let along = |x: usize| above[x] - below[x];
            let du = (across(&above) + 2.0 * across(&here) + across(&below)) / 8.0;
            let dv = (along(left) + 2.0 * along(x) + along(right)) / 8.0;
            let normal = Vec3::new(-strength * du, -strength * dv, 1.0).normalize_or(Vec3::Z);
            bytes.extend((0.5 * normal + 0.5).to_array().map(byte));
        }
        above = std::mem::replace(&mut here, below);
    }
    encode(width, height, &bytes, image::ExtendedColorType::Rgb8)
}

/// Whether a picture holds a tangent-space normal map: most pixels are unit vectors that point out of the surface, and
/// it is not grey.
pub(crate) fn looks_like_normals(image: &Image) -> bool {
    /// Enough pixels to tell, evenly spread.
    const SAMPLES: u64 = 4096;
    let count = u64::from(image.width) * u64::from(image.height);
    let step = (count / SAMPLES).max(1);
    let (mut total, mut unit, mut sum) = (0_u32, 0_u32, Vec3::ZERO);
    for at in (0..count).step_by(step as usize) {
        let (x, y) = ((at % u64::from(image.width)) as u32, (at / u64::from(image.width)) as u32);
        let vector = 2.0 * texel(image, x, y).truncate() - 1.0;
        total += 1;
        unit += u32::from((vector.length() - 1.0).abs() < 0.15 && vector.z > 0.0);
        sum += vector;
    }
    let mean = sum / total.max(1) as f32;
    // A grey picture of the right brightness has unit vectors too, but their mean leans to (1, 1, 1).
    unit * 10 > total * 9 && mean.z > 0.5 && mean.truncate().length() < 0.35
}

/// The colours of one picture with the alpha of another, at the size of the first.
///
/// `channel` is what `-imfchan` says: `r g b m l z`. Without one, the matte channel is taken if it is used at all, else
/// the luminance.
pub(crate) fn combined_alpha(color: &Image, alpha: &Image, channel: Option<u8>) -> Result<Encoded, String> {
    let has_matte = match &alpha.pixels {
        Pixels::Rgba8(values) => values.chunks_exact(4).any(|texel| texel[3] != u8::MAX),
        Pixels::Rgba16(values) => values.chunks_exact(4).any(|texel| texel[3] != u16::MAX),
        Pixels::RgbF32(_) => false,
    };
    let value = |texel: Vec4| match channel {
        Some(b'r') => texel.x,
        Some(b'g') => texel.y,
        Some(b'b') => texel.z,
        Some(b'm') => texel.w,
        Some(_) => luminance(texel),
        None if has_matte => texel.w,
        None => luminance(texel),
    };
    let mut bytes = Vec::with_capacity(4 * color.width as usize * color.height as usize);
    for y in 0..color.height {
        for x in 0..color.width {
            let opacity = bilinear(alpha, x, y, color.width, color.height, value);
            bytes.extend(texel(color, x, y).truncate().extend(opacity).to_array().map(byte));
        }
    }
    encode(color.width, color.height, &bytes, image::ExtendedColorType::Rgba8)
}

/// The value at the place of pixel (x, y) of a picture of another size.
fn bilinear(image: &Image, x: u32, y: u32, width: u32, height: u32, value: impl Fn(Vec4) -> f32) -> f32 {
    let place = |at: u32, from: u32, to: u32| {
        let exact = ((at as f32 + 0.5) * to as f32 / from as f32 - 0.5).clamp(0.0, (to - 1) as f32);
        (exact as u32, (exact as u32 + 1).min(to - 1), exact.fract())
    };
    let (left, right, across) = place(x, width, image.width);
    let (top, bottom, down) = place(y, height, image.height);
    let row = |y: u32| {
        let (a, b) = (value(texel(image, left, y)), value(texel(image, right, y)));
        a + (b - a) * across
    };
    let (a, b) = (row(top), row(bottom));
    a + (b - a) * down
}

/// The mean of the red channel.
pub(crate) fn mean(image: &Image) -> f32 {
    let rows = (0..image.height).map(|y| (0..image.width).map(|x| f64::from(texel(image, x, y).x)).sum::<f64>());
    (rows.sum::<f64>() / (f64::from(image.width) * f64::from(image.height))) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32, value: impl Fn(u32, u32) -> u8) -> Image {
        let pixels = (0..width * height).flat_map(|at| {
            let value = value(at % width, at / width);
            [value, value, value, 255]
        });
        Image { width, height, pixels: Pixels::Rgba8(pixels.collect()) }
    }

    fn decode(bytes: &[u8]) -> image::DynamicImage {
        image::load_from_memory(bytes).unwrap()
    }

    #[test]
    fn slopes_become_normals() {
        // Rises by 16/255 for each pixel to the right, and by 32/255 for each pixel upwards.
        let ramp = |x: u32, y: u32| (16 * (x % 5) + 32 * (4 - y.min(4))) as u8;
        let bytes = heights_to_normals(&grey(5, 5, ramp), 4.0).unwrap();
        let image::Rgb(pixel) = *decode(&bytes).to_rgb8().get_pixel(2, 2);
        let normal = Vec3::from(pixel.map(|value| f32::from(value) / 127.5 - 1.0));
        let expected = Vec3::new(-4.0 * 16.0 / 255.0, -4.0 * 32.0 / 255.0, 1.0).normalize();
        assert!(normal.distance(expected) < 0.01, "{normal} {expected}");

        let flat = heights_to_normals(&grey(1, 1, |_, _| 77), 4.0).unwrap();
        assert_eq!(decode(&flat).to_rgb8().get_pixel(0, 0).0, [128, 128, 255]);
    }

    #[test]
    fn normal_maps_are_told_from_height_maps() {
        let heights = grey(64, 64, |x, y| ((x * 37 + y * 11) % 256) as u8);
        let made = decode(&heights_to_normals(&heights, 0.5).unwrap()).to_rgba8();
        let normals = Image { width: 64, height: 64, pixels: Pixels::Rgba8(made.into_raw()) };
        assert!(looks_like_normals(&normals));
        for image in [heights, grey(64, 64, |_, _| 200), grey(8, 8, |_, _| 255), grey(8, 8, |_, _| 128)] {
            assert!(!looks_like_normals(&image));
        }
    }

    #[test]
    fn alpha_from_another_picture() {
        let color = Image { width: 2, height: 1, pixels: Pixels::Rgba8(vec![10, 20, 30, 255, 40, 50, 60, 255]) };
        let mask = grey(2, 1, |x, _| if x == 0 { 0 } else { 200 });
        let bytes = combined_alpha(&color, &mask, None).unwrap();
        assert_eq!(decode(&bytes).to_rgba8().into_raw(), [10, 20, 30, 0, 40, 50, 60, 200]);
        // A picture with a matte channel uses that, scaled to size.
        let matte = Image { width: 1, height: 1, pixels: Pixels::Rgba8(vec![255, 0, 0, 100]) };
        let bytes = combined_alpha(&color, &matte, None).unwrap();
        assert_eq!(decode(&bytes).to_rgba8().into_raw(), [10, 20, 30, 100, 40, 50, 60, 100]);
        let bytes = combined_alpha(&color, &matte, Some(b'g')).unwrap();
        assert_eq!(decode(&bytes).to_rgba8().into_raw(), [10, 20, 30, 0, 40, 50, 60, 0]);
    }

    #[test]
    fn the_mean() {
        assert!((mean(&grey(2, 2, |x, y| (x + 2 * y) as u8 * 50)) - 75.0 / 255.0).abs() < 1e-6);
    }
}
