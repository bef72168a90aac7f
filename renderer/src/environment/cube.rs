//! Light on the six faces of a cube, on the CPU, and means of it over lobes.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};
use std::ops::Range;

use aam_scene::{CubeFace, EnvironmentMap, MapLayout, cube_direction};
use glam::{Vec2, Vec3};

/// Light on the six faces of a cube.
#[derive(Clone, Debug)]
pub(crate) struct Cube {
    pub side: usize,
    /// Face by face in the order of [`CubeFace::ALL`], the top row first.
    pub texels: Vec<Vec3>,
}

/// What a lobe weighs less than this share of its peak is left out.
const NEGLIGIBLE: f32 = 1e-5;

impl Cube {
    /// The light of a map; each texel is the mean over as many places as the map has texels there.
    pub(crate) fn new(map: &EnvironmentMap, decode: bool, side: usize) -> Self {
        let per_texel = match map.layout() {
            MapLayout::Panorama(image) => image.width as f32 / (PI * side as f32),
            MapLayout::Cube(faces) => faces[0].width as f32 / side as f32,
        };
        let across = per_texel.ceil().clamp(1.0, 64.0) as usize;
        Self::from_fn(side, |face, x, y| {
            let mut sum = Vec3::ZERO;
            for part in 0..across * across {
                let offset = (Vec2::new((part % across) as f32, (part / across) as f32) + 0.5) / across as f32;
                let at = (Vec2::new(x as f32, y as f32) + offset) / side as f32;
                sum += map.light(cube_direction(face, at), decode);
            }
            sum / (across * across) as f32
        })
    }

    /// Fills in all texels, on all cores.
    fn from_fn(side: usize, texel: impl Fn(CubeFace, usize, usize) -> Vec3 + Sync) -> Self {
        let mut texels = vec![Vec3::ZERO; 6 * side * side];
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let rows = (6 * side).div_ceil(threads).max(1);
        std::thread::scope(|scope| {
            for (block, texels) in texels.chunks_mut(rows * side).enumerate() {
                let texel = &texel;
                scope.spawn(move || {
                    for (index, out) in texels.iter_mut().enumerate() {
                        let row = block * rows + index / side;
                        *out = texel(CubeFace::ALL[row / side], index % side, row % side);
                    }
                });
            }
        });
        Self { side, texels }
    }

    /// Half as large; each texel is the mean of four.
    pub(crate) fn halved(&self) -> Self {
        let side = (self.side / 2).max(1);
        let at = |face: CubeFace, x: usize, y: usize| {
            self.texels[(face as usize * self.side + y.min(self.side - 1)) * self.side + x.min(self.side - 1)]
        };
        Self::from_fn(side, |face, x, y| {
            let (x, y) = (2 * x, 2 * y);
            0.25 * (at(face, x, y) + at(face, x + 1, y) + at(face, x, y + 1) + at(face, x + 1, y + 1))
        })
    }

    /// The unit direction of a texel's middle.
    pub(crate) fn direction(face: CubeFace, x: usize, y: usize, side: usize) -> Vec3 {
        cube_direction(face, (Vec2::new(x as f32, y as f32) + 0.5) / side as f32).normalize()
    }

    /// The mean of the light around each direction, weighted with the cosine to the power of the exponent; 1 is what a
    /// Lambertian surface reflects. The weights sum up to 1 exactly, and a direction's mean does not depend on the face that
    /// it lies on: nothing jumps at the edges.
    pub(crate) fn over_lobes(&self, exponent: f32, side: usize) -> Self {
        let lobe = Lobe::new(exponent);
        Self::from_fn(side, |face, x, y| self.over_lobe(Self::direction(face, x, y, side), &lobe))
    }

    fn over_lobe(&self, axis: Vec3, lobe: &Lobe) -> Vec3 {
        let (mut sum, mut weights) = (Vec3::ZERO, 0.0_f32);
        let step = 2.0 / self.side as f32;
        for face in CubeFace::ALL {
            // The face's directions are `middle + s right + t down`, with s and t from −1 to 1.
            let middle = cube_direction(face, Vec2::splat(0.5));
            let right = cube_direction(face, Vec2::new(1.0, 0.5)) - middle;
            let down = cube_direction(face, Vec2::new(0.5, 1.0)) - middle;
            let local = Vec3::new(axis.dot(right), axis.dot(down), axis.dot(middle));
            let Some(columns) = lobe.reach(local.x, local.z, self.side) else { continue };
            let Some(rows) = lobe.reach(local.y, local.z, self.side) else { continue };
            for row in rows {
                let t = (row as f32 + 0.5) * step - 1.0;
                let texels = &self.texels[(face as usize * self.side + row) * self.side..][..self.side];
                let (along, squared) = (local.z + t * local.y, 1.0 + t * t);
                for (column, texel) in columns.clone().zip(&texels[columns.clone()]) {
                    let s = (column as f32 + 0.5) * step - 1.0;
                    let inverse = 1.0 / (squared + s * s).sqrt();
                    // The solid angle of a texel falls with the third power of its distance.
                    let weight = lobe.weight((along + s * local.x) * inverse) * (inverse * inverse * inverse);
                    weights += weight;
                    sum += *texel * weight;
                }
            }
        }
        // A lobe between the middles of texels is as good as a mirror.
        if weights > 0.0 { sum / weights } else { self.nearest(axis) }
    }
}

impl Cube {
    /// The texel in a direction.
    fn nearest(&self, direction: Vec3) -> Vec3 {
        let mut best = (f32::NEG_INFINITY, 0);
        for face in CubeFace::ALL {
            let middle = cube_direction(face, Vec2::splat(0.5));
            let right = cube_direction(face, Vec2::new(1.0, 0.5)) - middle;
            let down = cube_direction(face, Vec2::new(0.5, 1.0)) - middle;
            let ahead = direction.dot(middle);
            if ahead > best.0 {
                let place = |aside: f32| {
                    let along = (0.5 * aside / ahead + 0.5) * self.side as f32;
                    (along.max(0.0) as usize).min(self.side - 1)
                };
                let (column, row) = (place(direction.dot(right)), place(direction.dot(down)));
                best = (ahead, (face as usize * self.side + row) * self.side + column);
            }
        }
        self.texels[best.1]
    }
}

/// The cosine to a power, as a table.
struct Lobe {
    /// Sine and cosine of the angle within which the lobe counts.
    reach: (f32, f32),
    scale: f32,
    table: Vec<f32>,
}

impl Lobe {
    const ENTRIES: usize = 2048;

    fn new(exponent: f32) -> Self {
        // For small exponents all of the half space in front counts.
        let cosine = if exponent >= 2.0 { NEGLIGIBLE.powf(1.0 / exponent) } else { 0.0 };
        let depth = 1.0 - cosine;
        let entry = |index: usize| (1.0 - depth * index as f32 / Self::ENTRIES as f32).max(0.0).powf(exponent);
        Self {
            reach: ((1.0 - cosine * cosine).max(0.0).sqrt(), cosine),
            scale: Self::ENTRIES as f32 / depth,
            table: (0..=Self::ENTRIES).map(entry).collect(),
        }
    }

    fn weight(&self, cosine: f32) -> f32 {
        let place = ((1.0 - cosine) * self.scale).max(0.0);
        let index = place as usize;
        match self.table.get(index..index + 2) {
            Some(pair) => pair[0] + (pair[1] - pair[0]) * (place - index as f32),
            None => 0.0,
        }
    }

    /// The texels of a face, along one of its axes, that can lie within the lobe: the angle of the lobe's axis as seen along
    /// the face's other axis, give or take that of the lobe's edge.
    fn reach(&self, aside: f32, ahead: f32, side: usize) -> Option<Range<usize>> {
        let length = aside.hypot(ahead);
        let (sine, _) = self.reach;
        if self.reach.1 <= 0.0 || sine >= length {
            return Some(0..side);
        }
        let (angle, spread) = (aside.atan2(ahead), (sine / length).asin());
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        // The face spans an eighth of a turn to both sides; the angle is known up to whole turns.
        for turn in [-TAU, 0.0, TAU] {
            let (from, to) = ((angle + turn - spread).max(-FRAC_PI_4), (angle + turn + spread).min(FRAC_PI_4));
            if from <= to {
                (low, high) = (low.min(from), high.max(to));
            }
        }
        if low > high || spread >= FRAC_PI_2 {
            return (spread >= FRAC_PI_2).then_some(0..side);
        }
        let place = |angle: f32| (0.5 * angle.tan() + 0.5) * side as f32;
        let first = (place(low) - 0.5).floor().max(0.0) as usize;
        let end = ((place(high) + 1.5).floor().max(0.0) as usize).min(side);
        (first < end).then_some(first..end)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use aam_scene::{Image, Pixels, panorama_direction};

    use super::*;

    pub(crate) fn panorama(width: u32, light: impl Fn(Vec3) -> Vec3) -> EnvironmentMap {
        let height = width / 2;
        let at = |x: u32, y: u32| {
            panorama_direction((Vec2::new(x as f32, y as f32) + 0.5) / Vec2::new(width as f32, height as f32))
        };
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let values = places.flat_map(|(x, y)| light(at(x, y)).to_array()).collect();
        EnvironmentMap::panorama(Image { width, height, pixels: Pixels::RgbF32(values) }).unwrap()
    }

    fn largest_difference(cube: &Cube, expected: impl Fn(Vec3) -> Vec3) -> f32 {
        let side = cube.side;
        let texels = cube.texels.iter().enumerate();
        texels
            .map(|(index, texel)| {
                let (face, place) = (CubeFace::ALL[index / (side * side)], index % (side * side));
                let direction = Cube::direction(face, place % side, place / side, side);
                (*texel - expected(direction)).abs().max_element()
            })
            .fold(0.0, f32::max)
    }

    #[test]
    fn constant_light_stays_what_it_is() {
        let cube = Cube::new(&panorama(64, |_| Vec3::new(0.25, 1.0, 3.0)), true, 32);
        for exponent in [0.0, 1.0, 7.0, 300.0, 1e5] {
            let error = largest_difference(&cube.over_lobes(exponent, 8), |_| Vec3::new(0.25, 1.0, 3.0));
            // Relative to the largest channel: sums of thousands of single floats.
            assert!(error < 3.0 * 1e-5, "{exponent}: {error}");
        }
    }

    #[test]
    fn lobes_of_polynomials_are_their_closed_forms() {
        let cube = Cube::new(&panorama(512, |d| Vec3::new(1.0 + d.y, 1.0 + d.x, d.z * d.z)), true, 64);
        for exponent in [1.0_f32, 5.0, 40.0, 300.0] {
            // The mean of d over a lobe is its axis times (n + 1)/(n + 2); that of d_z² follows from those of cos².
            let (first, second) = ((exponent + 1.0) / (exponent + 2.0), (exponent + 1.0) / (exponent + 3.0));
            let expected = |axis: Vec3| {
                let square = second * axis.z * axis.z + 0.5 * (1.0 - second) * (1.0 - axis.z * axis.z);
                Vec3::new(1.0 + first * axis.y, 1.0 + first * axis.x, square)
            };
            let error = largest_difference(&cube.over_lobes(exponent, 16), expected);
            assert!(error < 1e-3, "{exponent}: {error}");
        }
    }

    #[test]
    fn no_step_across_an_edge_is_larger_than_within_a_face() {
        // Requirement 27. A sun near a corner, where three faces meet.
        let sun = Vec3::new(0.9, 1.0, -1.1).normalize();
        let map = panorama(256, |d| Vec3::splat(if d.dot(sun) > 0.999 { 500.0 } else { 0.5 + 0.3 * d.y }));
        let source = Cube::new(&map, true, 64);
        for (exponent, side) in [(1.0, 16), (30.0, 32)] {
            let cube = source.over_lobes(exponent, side);
            let at = |face: CubeFace, x: usize, y: usize| cube.texels[(face as usize * side + y) * side + x].x;
            let (mut within, mut across) = (0.0_f32, 0.0_f32);
            for face in CubeFace::ALL {
                for y in 0..side {
                    for x in 0..side - 1 {
                        within = within.max((at(face, x, y) - at(face, x + 1, y)).abs());
                        within = within.max((at(face, y, x) - at(face, y, x + 1)).abs());
                    }
                }
            }
            for along in 0..side {
                let last = side - 1;
                across = across
                    .max((at(CubeFace::Front, last, along) - at(CubeFace::Right, 0, along)).abs())
                    .max((at(CubeFace::Right, last, along) - at(CubeFace::Back, 0, along)).abs())
                    .max((at(CubeFace::Up, along, last) - at(CubeFace::Front, along, 0)).abs())
                    .max((at(CubeFace::Up, last, last - along) - at(CubeFace::Right, along, 0)).abs())
                    .max((at(CubeFace::Down, along, 0) - at(CubeFace::Front, along, last)).abs());
            }
            assert!(across <= 1.5 * within && across > 0.0, "n = {exponent}: {across} across, {within} within");
        }
    }

    #[test]
    fn halving_and_resampling_keep_the_mean() {
        let light = |d: Vec3| Vec3::new(if d.x > 0.3 { 4.0 } else { 0.1 }, 1.0, d.y + 1.0);
        let map = panorama(256, light);
        let mean = |cube: &Cube| cube.texels.iter().sum::<Vec3>() / cube.texels.len() as f32;
        let cube = Cube::new(&map, true, 64);
        assert!((mean(&cube) - mean(&cube.halved())).abs().max_element() < 1e-4);
        assert!((mean(&cube) - mean(&Cube::new(&map, true, 16))).abs().max_element() < 0.02);
        assert_eq!(cube.halved().side, 32);
    }
}
