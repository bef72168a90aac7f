//! A displacement map as a function of texture coordinates.

use std::sync::Arc;

use glam::{Mat3, Vec2};

use crate::{Image, Pixels};

/// The red channel of an image as heights in `[0, 1]`, linear between texels, repeated beyond its edges. Both engines read
/// heights with these formulas, in 32 bits.
#[derive(Clone, Debug)]
pub struct HeightMap {
    image: Arc<Image>,
}

impl HeightMap {
    /// The heights of an image; `None` where its pixels do not fill its width and height.
    pub fn new(image: &Arc<Image>) -> Option<Self> {
        let texels = match &image.pixels {
            Pixels::Rgba8(values) => values.len() / 4,
            Pixels::Rgba16(values) => values.len() / 4,
            Pixels::RgbF32(values) => values.len() / 3,
        };
        let needed = (image.width as usize).checked_mul(image.height as usize)?;
        (1..=texels).contains(&needed).then(|| Self { image: Arc::clone(image) })
    }

    /// Its image.
    pub fn image(&self) -> &Arc<Image> {
        &self.image
    }

    /// Width and height in texels.
    pub fn size(&self) -> (usize, usize) {
        (self.image.width as usize, self.image.height as usize)
    }

    /// The height of a texel, row 0 at the top. Floats are clamped to `[0, 1]`; one that is not a number is 0.
    pub fn texel(&self, x: usize, y: usize) -> f32 {
        let index = y * self.image.width as usize + x;
        match &self.image.pixels {
            Pixels::Rgba8(values) => f32::from(values[4 * index]) / 255.0,
            Pixels::Rgba16(values) => f32::from(values[4 * index]) / 65535.0,
            Pixels::RgbF32(values) => {
                let value = values[3 * index];
                if value > 0.0 { value.min(1.0) } else { 0.0 }
            }
        }
    }

    /// The height at a coordinate after the texture matrix, v = 0 at the bottom.
    pub fn at(&self, uv: Vec2) -> f32 {
        let (width, height) = self.size();
        let (x, fx) = place(uv.x, width);
        let (y, fy) = place(1.0 - uv.y, height);
        let row = |y: usize| {
            let left = self.texel(x[0], y);
            left + (self.texel(x[1], y) - left) * fx
        };
        let top = row(y[0]);
        top + (row(y[1]) - top) * fy
    }

    /// How the height changes with u and v, from the heights a texel to each side.
    pub fn slope(&self, uv: Vec2) -> Vec2 {
        let (width, height) = self.size();
        let size = Vec2::new(width as f32, height as f32);
        let (du, dv) = (Vec2::new(1.0 / size.x, 0.0), Vec2::new(0.0, 1.0 / size.y));
        let change = Vec2::new(self.at(uv + du) - self.at(uv - du), self.at(uv + dv) - self.at(uv - dv));
        change * (0.5 * size)
    }
}

/// The two texels around a coordinate, and how far it is towards the second.
fn place(coordinate: f32, size: usize) -> ([usize; 2], f32) {
    let fraction = coordinate - coordinate.floor();
    // Neither what is not a number nor what rounds up to 1.
    let inside = if (0.0..1.0).contains(&fraction) { fraction } else { 0.0 };
    let position = inside * size as f32 - 0.5;
    let whole = position.floor();
    let first = if whole < 0.0 { size - 1 } else { (whole as usize).min(size - 1) };
    ([first, if first + 1 == size { 0 } else { first + 1 }], position - whole)
}

/// A coordinate after the texture matrix.
pub(crate) fn transformed(matrix: &Mat3, uv: Vec2) -> Vec2 {
    let (x, y, z) = (matrix.x_axis, matrix.y_axis, matrix.z_axis);
    Vec2::new(x.x * uv.x + y.x * uv.y + z.x, x.y * uv.x + y.y * uv.y + z.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(width: u32, height: u32, value: impl Fn(u32, u32) -> f32) -> HeightMap {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let pixels = pixels.flat_map(|(x, y)| [value(x, y), 9.0, 9.0]).collect();
        HeightMap::new(&Arc::new(Image { width, height, pixels: Pixels::RgbF32(pixels) })).unwrap()
    }

    #[test]
    fn texel_centres_are_exact_and_v_is_0_at_the_bottom() {
        let map = map(4, 2, |x, y| 0.1 * x as f32 + 0.5 * y as f32);
        for (x, y) in [(0, 0), (3, 0), (0, 1), (2, 1)] {
            let uv = Vec2::new((x as f32 + 0.5) / 4.0, 1.0 - (y as f32 + 0.5) / 2.0);
            assert!((map.at(uv) - (0.1 * x as f32 + 0.5 * y as f32)).abs() < 1e-6);
        }
    }

    #[test]
    fn heights_repeat_and_stay_between_0_and_1_whatever_is_asked() {
        let map = map(3, 3, |x, _| [f32::NAN, 7.0, -3.0][x as usize]);
        assert_eq!([0, 1, 2].map(|x| map.texel(x, 0)), [0.0, 1.0, 0.0]);
        assert!((map.at(Vec2::new(0.3, 0.2)) - map.at(Vec2::new(-1.7, 5.2))).abs() < 1e-5);
        for bad in [f32::NAN, f32::INFINITY, -f32::INFINITY, 3e38, -1e-30, 1e-45] {
            assert!((0.0..=1.0).contains(&map.at(Vec2::splat(bad))), "{bad}");
            assert!(map.slope(Vec2::splat(bad)).is_finite());
        }
    }

    #[test]
    fn the_slope_of_a_ramp_is_its_slope() {
        let map = map(16, 16, |x, y| x as f32 / 32.0 + y as f32 / 64.0);
        let slope = map.slope(Vec2::splat(0.5));
        assert!((slope - Vec2::new(0.5, -0.25)).length() < 1e-5, "{slope}");
    }

    #[test]
    fn an_image_without_all_its_pixels_is_no_map() {
        for (width, height) in [(0, 1), (2, 2), (u32::MAX, u32::MAX)] {
            let image = Image { width, height, pixels: Pixels::Rgba8(vec![0; 8]) };
            assert!(HeightMap::new(&Arc::new(image)).is_none());
        }
    }
}
