//! How uneven a displacement map is, where: a pyramid of bounds, so that the error of a coarse tessellation is known before
//! it is made.

use glam::Vec2;

use super::height::HeightMap;

/// The most blocks of the finest level.
const MAX_BLOCKS: usize = 1 << 20;

/// Bounds over a part of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    low: f32,
    high: f32,
    /// The largest second difference along rows and columns: the map has a kink at every texel.
    bend: f32,
    /// The largest mixed difference: between texels the map is curved by it.
    twist: f32,
}

impl Bounds {
    const NONE: Self = Self { low: f32::INFINITY, high: f32::NEG_INFINITY, bend: 0.0, twist: 0.0 };

    fn with(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            bend: self.bend.max(other.bend),
            twist: self.twist.max(other.twist),
        }
    }

    /// Between the lowest and the highest.
    pub(crate) fn range(&self) -> f32 {
        (self.high - self.low).max(0.0)
    }

    /// How far the map can be from a plane through three of its points, at most `length` texels apart: a function whose
    /// second derivative is m is at most `m·length²/6` away on a triangle with such sides, and never farther than its range.
    /// A kink is as a curve of the same turn over a texel, hence the lower limit of its second factor.
    pub(crate) fn deviation(&self, length: f32) -> f32 {
        self.range().min((self.bend * length.max(1.5) + self.twist * length) * length / 6.0)
    }
}

/// The pyramid of a map.
#[derive(Debug)]
pub struct Detail {
    size: [usize; 2],
    /// Texels a block's side at each level, with columns and the blocks, row by row.
    levels: Vec<(usize, usize, Vec<Bounds>)>,
}

impl Detail {
    /// Looks at every texel once.
    pub fn new(heights: &HeightMap) -> Self {
        let (width, height) = heights.size();
        let mut side = 1;
        while width.div_ceil(side) * height.div_ceil(side) > MAX_BLOCKS {
            side *= 2;
        }
        let columns = width.div_ceil(side);
        let mut blocks = vec![Bounds::NONE; columns * height.div_ceil(side)];
        let row = |y: usize| (0..width).map(|x| heights.texel(x, y % height)).collect::<Vec<f32>>();
        let mut rows = [row(height - 1), row(0), row(1)];
        for y in 0..height {
            let [above, here, below] = &rows;
            for x in 0..width {
                let (left, right) = (if x == 0 { width - 1 } else { x - 1 }, if x + 1 == width { 0 } else { x + 1 });
                let h = here[x];
                let across = (here[left] + here[right] - 2.0 * h).abs();
                let down = (above[x] + below[x] - 2.0 * h).abs();
                let twist = |row: &[f32], side: usize| (row[side] - row[x] - here[side] + h).abs();
                let twists = [twist(above, left), twist(above, right), twist(below, left), twist(below, right)];
                let twist = twists.into_iter().fold(0.0, f32::max);
                // Between texels the map is a mixture of those around.
                let mut bounds = Bounds { low: h, high: h, bend: across.max(down), twist };
                for row in [above, here, below] {
                    for value in [row[left], row[x], row[right]] {
                        (bounds.low, bounds.high) = (bounds.low.min(value), bounds.high.max(value));
                    }
                }
                let block = &mut blocks[y / side * columns + x / side];
                *block = block.with(bounds);
            }
            rows.rotate_left(1);
            rows[2] = row(y + 2);
        }
        let mut levels = vec![(side, columns, blocks)];
        while let Some((side, columns, blocks)) = levels.last().filter(|(_, _, blocks)| blocks.len() > 1) {
            let rows = blocks.len() / columns;
            let (wide, high) = (columns.div_ceil(2), rows.div_ceil(2));
            let mut next = vec![Bounds::NONE; wide * high];
            for (index, bounds) in blocks.iter().enumerate() {
                let place = index / columns / 2 * wide + index % columns / 2;
                next[place] = next[place].with(*bounds);
            }
            let level = (2 * side, wide, next);
            levels.push(level);
        }
        Self { size: [width, height], levels }
    }

    /// Bounds over a square around a point, both in texels, v = 0 at the bottom.
    pub(crate) fn around(&self, middle: Vec2, reach: f32) -> Bounds {
        let whole = self.levels.last().map_or(Bounds::NONE, |(_, _, blocks)| blocks[0]);
        let size = Vec2::new(self.size[0] as f32, self.size[1] as f32);
        if !(reach >= 0.0 && 2.0 * reach + 2.0 < size.min_element() && middle.is_finite()) {
            return whole;
        }
        let level = self.levels.iter().find(|(side, _, _)| *side as f32 >= 2.0 * reach);
        let Some((side, columns, blocks)) = level else { return whole };
        let down = Vec2::new(middle.x, size.y - middle.y);
        let spans = [0, 1].map(|axis: usize| spans(down[axis], reach, self.size[axis], *side));
        let mut bounds = Bounds::NONE;
        for y in spans[1].iter().flat_map(|(first, last)| *first..=*last) {
            for x in spans[0].iter().flat_map(|(first, last)| *first..=*last) {
                bounds = bounds.with(blocks[y * columns + x]);
            }
        }
        // Kinks are at the middles of texels.
        let cell = |at: f32| (at - 0.5).floor();
        if [0, 1].into_iter().all(|axis: usize| cell(down[axis] - reach) == cell(down[axis] + reach)) {
            bounds.bend = 0.0;
        }
        bounds
    }
}

/// Blocks that an interval of texels lies in: two runs where it goes past the map's edge.
fn spans(middle: f32, reach: f32, size: usize, side: usize) -> [(usize, usize); 2] {
    let length = size as f32;
    let start = (middle - reach) - ((middle - reach) / length).floor() * length;
    let first = (start.max(0.0) as usize).min(size - 1);
    let last = first + (2.0 * reach).ceil() as usize + 1;
    let block = |texel: usize| texel / side;
    if last < size {
        [(block(first), block(last)), (1, 0)]
    } else {
        [(block(first), block(size - 1)), (0, block((last - size).min(size - 1)))]
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::{Image, Pixels};

    fn map(width: u32, height: u32, value: impl Fn(u32, u32) -> f32) -> HeightMap {
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let pixels = texels.flat_map(|(x, y)| [value(x, y), 0.0, 0.0]).collect();
        HeightMap::new(&Arc::new(Image { width, height, pixels: Pixels::RgbF32(pixels) })).unwrap()
    }

    #[test]
    fn a_ramp_has_a_range_but_does_not_bend() {
        let detail = Detail::new(&map(64, 64, |x, _| x as f32 / 64.0));
        let bounds = detail.around(Vec2::new(32.0, 32.0), 4.0);
        assert!(bounds.range() > 0.1 && bounds.bend < 1e-6 && bounds.twist < 1e-6, "{bounds:?}");
        assert!(bounds.deviation(8.0) < 1e-4);
        // Where the map begins again it falls from 1 to 0.
        assert!(detail.around(Vec2::new(0.5, 32.0), 4.0).deviation(8.0) > 0.9);
    }

    #[test]
    fn bounds_hold_what_is_there_and_not_what_is_far_away() {
        let spot = |x: u32, y: u32| if (x, y) == (13, 40) { 1.0 } else { 0.25 };
        let detail = Detail::new(&map(100, 70, spot));
        let at = |x: f32, y: f32| Vec2::new(x + 0.5, 70.0 - (y + 0.5));
        for reach in [0.0, 1.0, 5.0, 17.0, 40.0] {
            assert_eq!(detail.around(at(13.0, 40.0), reach).range(), 0.75, "{reach}");
            assert_eq!(detail.around(at(13.0 + 300.0, 40.0 - 140.0), reach).range(), 0.75, "repeated, {reach}");
        }
        assert_eq!(detail.around(at(70.0, 10.0), 5.0).range(), 0.0);
        assert_eq!(detail.around(at(16.0, 40.0), 2.0).range(), 0.75);
        assert_eq!(detail.around(Vec2::NAN, 1.0).range(), 0.75);
        assert_eq!(detail.around(Vec2::ZERO, f32::INFINITY).range(), 0.75);
    }

    #[test]
    fn no_triangle_is_farther_from_the_map_than_the_bound_says() {
        let heights = map(64, 64, |x, y| 0.5 + 0.3 * (0.21 * x as f32).sin() * (0.17 * y as f32).cos());
        let detail = Detail::new(&heights);
        let size = 64.0;
        for step in 0..400 {
            let turn = step as f32 * 2.4;
            let length = 1.0 + (step % 13) as f32;
            let middle = Vec2::new(32.0 + 20.0 * (0.7 * step as f32).sin(), 32.0 + 20.0 * (1.1 * step as f32).cos());
            let half = 0.5 * length * Vec2::from_angle(turn);
            let third = middle + 0.8 * length * Vec2::from_angle(turn + 1.5);
            let corners = [middle - half, middle + half, third];
            let longest = [0, 1, 2].map(|k| corners[k].distance(corners[(k + 1) % 3])).into_iter().fold(0.0, f32::max);
            let centre = [0, 1, 2].into_iter().max_by(|&a, &b| {
                let side = |k: usize| corners[k].distance(corners[(k + 1) % 3]);
                side(a).total_cmp(&side(b))
            });
            let centre = centre.map(|k| 0.5 * (corners[k] + corners[(k + 1) % 3])).unwrap();
            let bound = detail.around(centre, 0.87 * longest).deviation(longest);
            let h = corners.map(|corner| heights.at(corner / size));
            for i in 0..=8 {
                for j in 0..=8 - i {
                    let w = [i as f32 / 8.0, j as f32 / 8.0, (8 - i - j) as f32 / 8.0];
                    let at = corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2];
                    let flat = h[0] * w[0] + h[1] * w[1] + h[2] * w[2];
                    let apart = (heights.at(at / size) - flat).abs();
                    assert!(apart <= bound + 1e-5, "{apart} of {bound} at {at}, {longest}");
                }
            }
        }
    }
}
