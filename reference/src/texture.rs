//! Textures as filtered functions of a texture coordinate.

use std::sync::Arc;

use aam_scene::{Image, Pixels};
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

use crate::colour;

/// What a texture's channels are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Encoding {
    /// Values used as stored.
    Stored,
    /// sRGB-encoded colour, decoded before any filtering; alpha is used as stored.
    Srgb,
    /// Unit vectors as `(n + 1) / 2`: means are made unit again.
    Normal,
}

/// What lies beyond an image's edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wrap {
    /// The image again.
    Repeat,
    /// The edge's colour.
    Clamp,
}

/// A texture with its mip chain.
#[derive(Debug)]
pub(crate) struct Texture {
    image: Arc<Image>,
    encoding: Encoding,
    wrap: Wrap,
    /// [`colour::decode`] of each byte, or the byte's fraction.
    bytes: Box<[f32; 256]>,
    /// Level 1 and on, decoded.
    levels: Vec<Level>,
}

#[derive(Debug)]
struct Level {
    width: usize,
    height: usize,
    texels: Vec<Vec4>,
}

impl Texture {
    /// Builds the mip chain of an image that [`Texture::is_whole`].
    pub(crate) fn new(image: &Arc<Image>, encoding: Encoding, wrap: Wrap) -> Self {
        let (width, height) = (image.width as usize, image.height as usize);
        let mut bytes = Box::new([0.0; 256]);
        for (byte, value) in bytes.iter_mut().enumerate() {
            let stored = byte as f32 / 255.0;
            *value = if encoding == Encoding::Srgb { colour::decode(stored) } else { stored };
        }
        let mut texture = Self { image: Arc::clone(image), encoding, wrap, bytes, levels: Vec::new() };
        let (mut w, mut h) = (width, height);
        while w > 1 || h > 1 {
            let next = texture.reduced(texture.levels.len(), w, h);
            (w, h) = (next.width, next.height);
            texture.levels.push(next);
        }
        texture
    }

    /// True where the pixels fill width × height, and there are any.
    pub(crate) fn is_whole(image: &Image) -> bool {
        let texels = match &image.pixels {
            Pixels::Rgba8(values) => values.len() / 4,
            Pixels::Rgba16(values) => values.len() / 4,
            Pixels::RgbF32(values) => values.len() / 3,
        };
        (image.width as usize).checked_mul(image.height as usize).is_some_and(|count| (1..=texels).contains(&count))
    }

    /// True where some texel has an alpha below 1.
    pub(crate) fn has_alpha(image: &Image) -> bool {
        match &image.pixels {
            Pixels::Rgba8(values) => values.chunks_exact(4).any(|texel| texel[3] != u8::MAX),
            Pixels::Rgba16(values) => values.chunks_exact(4).any(|texel| texel[3] != u16::MAX),
            Pixels::RgbF32(_) => false,
        }
    }

    /// The next level: each texel is the mean over the part of this level that it covers, which for odd sizes is not
    /// a whole number of texels.
    fn reduced(&self, level: usize, width: usize, height: usize) -> Level {
        let (w, h) = ((width / 2).max(1), (height / 2).max(1));
        let columns: Vec<Vec<(usize, f32)>> = (0..w).map(|x| weights(x, width, w)).collect();
        let row = |y: usize| {
            let rows = weights(y, height, h);
            let columns = &columns;
            (0..w).map(move |x| {
                let mut sum = Vec4::ZERO;
                for (source_y, row_weight) in &rows {
                    for (source_x, weight) in &columns[x] {
                        sum += self.texel(level, width, *source_x, *source_y) * (row_weight * weight);
                    }
                }
                if self.encoding == Encoding::Normal { unit(sum) } else { sum }
            })
        };
        Level { width: w, height: h, texels: (0..h).into_par_iter().flat_map_iter(row).collect() }
    }

    /// A texel, row 0 at the top.
    fn texel(&self, level: usize, width: usize, x: usize, y: usize) -> Vec4 {
        let index = y * width + x;
        if let Some(level) = level.checked_sub(1) {
            return self.levels[level].texels[index];
        }
        match &self.image.pixels {
            Pixels::Rgba8(values) => {
                let texel = &values[4 * index..4 * index + 4];
                let rgb = [0, 1, 2].map(|channel| self.bytes[usize::from(texel[channel])]);
                Vec4::new(rgb[0], rgb[1], rgb[2], f32::from(texel[3]) / 255.0)
            }
            Pixels::Rgba16(values) => {
                let stored = [0, 1, 2, 3].map(|channel| f32::from(values[4 * index + channel]) / 65535.0);
                let decode = |value: f32| if self.encoding == Encoding::Srgb { colour::decode(value) } else { value };
                Vec4::new(decode(stored[0]), decode(stored[1]), decode(stored[2]), stored[3])
            }
            Pixels::RgbF32(values) => {
                // Linear radiance already.
                Vec4::new(values[3 * index], values[3 * index + 1], values[3 * index + 2], 1.0)
            }
        }
    }

    /// The filtered value at a coordinate with v = 0 at the bottom, repeated in both directions. `change` says how the
    /// coordinate moves over the two sides of the area that the value stands for.
    ///
    /// The level comes from the longer side, as a GPU computes it, but from exact derivatives; between levels it is
    /// interpolated.
    pub(crate) fn sample(&self, uv: Vec2, change: [Vec2; 2]) -> Vec4 {
        let size = Vec2::new(self.image.width as f32, self.image.height as f32);
        let side = change.map(|side| (side * size).length_squared());
        let squared = side[0].max(side[1]);
        let last = self.levels.len() as f32;
        let level = if squared.is_finite() { (0.5 * squared.log2()).max(0.0).min(last) } else { last };
        let (lower, fraction) = (level.floor(), level.fract());
        let first = self.bilinear(lower as usize, uv);
        if fraction == 0.0 {
            return first;
        }
        first + (self.bilinear(lower as usize + 1, uv) - first) * fraction
    }

    fn bilinear(&self, level: usize, uv: Vec2) -> Vec4 {
        let (width, height) = match level.checked_sub(1) {
            Some(index) => (self.levels[index].width, self.levels[index].height),
            None => (self.image.width as usize, self.image.height as usize),
        };
        let (x, fx) = self.wrap.place(uv.x, width);
        let (y, fy) = self.wrap.place(1.0 - uv.y, height);
        let row = |y: usize| {
            let left = self.texel(level, width, x[0], y);
            left + (self.texel(level, width, x[1], y) - left) * fx
        };
        let top = row(y[0]);
        top + (row(y[1]) - top) * fy
    }
}

/// A stored vector made unit again; +Z where it is zero.
fn unit(texel: Vec4) -> Vec4 {
    let normal = (2.0 * texel.truncate() - 1.0).normalize_or(Vec3::Z);
    (0.5 * normal + 0.5).extend(texel.w)
}

impl Wrap {
    /// The two texels around a coordinate, and how far it is towards the second.
    fn place(self, coordinate: f32, size: usize) -> ([usize; 2], f32) {
        if !coordinate.is_finite() {
            return ([0, 0], 0.0);
        }
        let inside = match self {
            Self::Repeat => coordinate - coordinate.floor(),
            Self::Clamp => coordinate.clamp(0.0, 1.0),
        };
        let position = inside * size as f32 - 0.5;
        let whole = position.floor();
        let (first, last) = (whole as i64, size as i64 - 1);
        let texel = |index: i64| match self {
            Self::Repeat => index.rem_euclid(size as i64) as usize,
            Self::Clamp => index.clamp(0, last) as usize,
        };
        ([texel(first), texel(first + 1)], position - whole)
    }
}

/// The source texels that target texel `index` covers, with weights of sum 1.
fn weights(index: usize, source: usize, target: usize) -> Vec<(usize, f32)> {
    let scale = source as f64 / target as f64;
    let (begin, end) = (index as f64 * scale, (index + 1) as f64 * scale);
    (begin as usize..source)
        .map(|texel| (texel, ((texel + 1) as f64).min(end) - (texel as f64).max(begin)))
        .take_while(|(_, covered)| *covered > 1e-9)
        .map(|(texel, covered)| (texel, (covered / scale) as f32))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Arc<Image> {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(|(x, y)| texel(x, y));
        Arc::new(Image { width, height, pixels: Pixels::Rgba8(pixels.collect()) })
    }

    const NO_CHANGE: [Vec2; 2] = [Vec2::ZERO; 2];

    #[test]
    fn v_zero_is_the_bottom_row_and_texel_centres_are_exact() {
        let image = image(4, 2, |x, y| [(10 * x) as u8, (100 * y) as u8, 0, 255]);
        let texture = Texture::new(&image, Encoding::Stored, Wrap::Repeat);
        for (x, y) in [(0, 0), (3, 0), (0, 1), (2, 1)] {
            let uv = Vec2::new((x as f32 + 0.5) / 4.0, 1.0 - (y as f32 + 0.5) / 2.0);
            let texel = texture.sample(uv, NO_CHANGE) * 255.0;
            assert!((texel - Vec4::new(10.0 * x as f32, 100.0 * y as f32, 0.0, 255.0)).length() < 1e-3);
        }
    }

    #[test]
    fn coordinates_repeat_and_bad_ones_are_survived() {
        let image = image(2, 2, |x, _| [if x == 0 { 0 } else { 200 }, 0, 0, 255]);
        let texture = Texture::new(&image, Encoding::Stored, Wrap::Repeat);
        let at = |u: f32| texture.sample(Vec2::new(u, 0.5), NO_CHANGE).x * 255.0;
        assert!((at(0.0) - 100.0).abs() < 1e-3, "the left edge blends with the right column");
        assert!((at(-0.75) - at(0.25)).abs() < 1e-3 && (at(7.25) - at(0.25)).abs() < 1e-3);
        for bad in [f32::NAN, f32::INFINITY, 3e38, -3e38, -1e-30] {
            assert!(at(bad).is_finite());
            assert!(texture.sample(Vec2::ZERO, [Vec2::splat(bad); 2]).is_finite());
        }
    }

    #[test]
    fn every_level_keeps_the_mean_also_at_odd_sizes() {
        for (width, height) in [(8, 8), (7, 5), (13, 1), (1, 9), (33, 20)] {
            let image = image(width, height, |x, y| [(x * 37 + y * 91) as u8, 0, 0, 255]);
            let Pixels::Rgba8(bytes) = &image.pixels else { unreachable!() };
            let mean = bytes.chunks(4).map(|texel| f64::from(texel[0])).sum::<f64>() / f64::from(width * height);
            let texture = Texture::new(&image, Encoding::Stored, Wrap::Repeat);
            for level in &texture.levels {
                let sum: f64 = level.texels.iter().map(|texel| f64::from(texel.x) * 255.0).sum();
                assert!((sum / level.texels.len() as f64 - mean).abs() < 1e-3, "{width}×{height}");
            }
            assert_eq!(texture.levels.last().map(|level| (level.width, level.height)), Some((1, 1)));
        }
    }

    #[test]
    fn colours_are_decoded_before_they_are_averaged() {
        let image = image(2, 1, |x, _| if x == 0 { [0, 0, 0, 255] } else { [255, 255, 255, 127] });
        let far = [Vec2::splat(10.0); 2];
        for (encoding, grey) in [(Encoding::Stored, 0.5), (Encoding::Srgb, 0.5)] {
            let texture = Texture::new(&image, encoding, Wrap::Repeat);
            let mean = texture.sample(Vec2::ZERO, far);
            assert!((mean.x - grey).abs() < 1e-6 && (mean.w - (255.0 + 127.0) / 510.0).abs() < 1e-6);
        }
        let middle = Texture::new(&self::image(1, 1, |_, _| [188, 0, 0, 255]), Encoding::Srgb, Wrap::Repeat);
        assert!((middle.sample(Vec2::ZERO, NO_CHANGE).x - 0.502_886).abs() < 1e-5);
    }

    #[test]
    fn the_mean_of_normals_is_a_unit_normal() {
        let image = image(2, 1, |x, _| if x == 0 { [255, 128, 128, 255] } else { [128, 255, 128, 255] });
        let texture = Texture::new(&image, Encoding::Normal, Wrap::Repeat);
        let normal = 2.0 * texture.sample(Vec2::ZERO, [Vec2::splat(10.0); 2]).truncate() - 1.0;
        assert!((normal - Vec3::new(1.0, 1.0, 0.0).normalize()).length() < 0.01);
        assert_eq!(unit(Vec4::splat(0.5)), Vec4::new(0.5, 0.5, 1.0, 0.5), "opposite vectors cancel: straight up");
    }

    #[test]
    fn the_level_follows_the_longer_side() {
        // 64 columns of alternating black and white: level 0 shows them, a change of two texels their mean.
        let image = image(64, 64, |x, _| [if x % 2 == 0 { 0 } else { 255 }, 0, 0, 255]);
        let texture = Texture::new(&image, Encoding::Stored, Wrap::Repeat);
        let centre = Vec2::new(0.5 / 64.0, 0.5);
        let value = |texels: f32| texture.sample(centre, [Vec2::new(0.0, texels / 64.0), Vec2::ZERO]).x;
        assert_eq!(value(1.0), 0.0);
        assert!((value(2.0) - 0.5).abs() < 1e-6);
        let between = value(2.0_f32.sqrt());
        assert!((between - 0.25).abs() < 1e-6, "half way between levels: {between}");
    }

    #[test]
    fn images_without_enough_pixels_are_refused() {
        for (width, height) in [(0, 4), (4, 0), (2, 2), (u32::MAX, u32::MAX)] {
            let image = Image { width, height, pixels: Pixels::Rgba8(vec![0; 15]) };
            assert!(!Texture::is_whole(&image));
        }
    }
}
