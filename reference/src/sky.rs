//! Light from all around: `docs/techniques/shading.md`, section 11.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use aam_scene::{Environment, EnvironmentMap, Shading, SpecularFilter, Up, panorama_direction, panorama_point};
use glam::{Mat3, Vec2, Vec3};

use crate::extent::lobe_direction;

/// Columns and rows of the table that directions are chosen by.
const COLUMNS: usize = 512;
const ROWS: usize = 256;

/// The share of directions that are chosen without regard to the light, so that none is left out.
const ANYWHERE: f64 = 0.02;

/// An environment with what is needed to look into any direction and to choose directions by their light.
#[derive(Debug)]
pub(crate) struct Sky {
    map: Arc<EnvironmentMap>,
    map_from_world: Mat3,
    factor: f32,
    decode: bool,
    /// It lights diffuse terms, specular terms.
    pub(crate) diffuse: bool,
    pub(crate) specular: bool,
    pub(crate) filter: SpecularFilter,
    choice: Choice,
}

impl Sky {
    pub(crate) fn new(environment: &Environment, up: Up, shading: Shading) -> Self {
        let map_from_world = environment.map_from_world(up);
        let mut sky = Self {
            map: Arc::clone(&environment.map),
            map_from_world,
            factor: environment.factor(),
            decode: shading == Shading::Linear,
            diffuse: environment.diffuse,
            specular: environment.specular,
            filter: environment.filter_for(shading),
            choice: Choice::default(),
        };
        sky.choice = Choice::new(|direction| sky.at(direction));
        sky
    }

    /// True where it takes the place of lights.
    pub(crate) fn is_lighting(&self) -> bool {
        self.diffuse || self.specular
    }

    /// The light from a direction of the world, of any length but 0.
    pub(crate) fn radiance(&self, direction: Vec3) -> Vec3 {
        self.at(self.map_from_world * direction) * self.factor
    }

    /// The mean of the light, weighted with the cosine to a unit axis to the power of the exponent. An exponent of 1 gives
    /// what a Lambertian surface reflects. Half of the directions are chosen by the weight and half by the light, and
    /// both count by the balance heuristic (Veach and Guibas, 1995). `point` gives point i of the unit square for the
    /// first and the second half.
    pub(crate) fn mean(&self, axis: Vec3, exponent: f32, many: u32, point: impl Fn(bool, u32) -> Vec2) -> Vec3 {
        let axis = self.map_from_world * axis;
        let half = (many / 2).max(1);
        let density = |direction: Vec3| {
            let cosine = axis.dot(direction).clamp(0.0, 1.0);
            if cosine > 0.0 { (exponent + 1.0) / TAU * cosine.powf(exponent) } else { 0.0 }
        };
        let mut sum = Vec3::ZERO;
        for index in 0..half {
            for by_light in [false, true] {
                let at = point(by_light, index);
                let direction = if by_light { self.choice.direction(at) } else { lobe_direction(axis, exponent, at) };
                let weight = density(direction);
                if weight > 0.0 {
                    sum += self.at(direction) * (weight / (weight + self.choice.density(direction)));
                }
            }
        }
        sum * (self.factor / half as f32)
    }

    /// A direction of the world chosen by its light.
    #[cfg(test)]
    fn chosen(&self, at: Vec2) -> Vec3 {
        self.map_from_world.transpose() * self.choice.direction(at)
    }

    /// The light from a direction of the map.
    fn at(&self, direction: Vec3) -> Vec3 {
        self.map.light(direction, self.decode)
    }
}

/// Chooses directions by their light, from a table of its brightness over longitude and latitude.
#[derive(Debug, Default)]
struct Choice {
    /// Chance of the rows up to each, and for each row that of its cells up to each.
    rows: Vec<f64>,
    cells: Vec<f64>,
}

impl Choice {
    fn new(light: impl Fn(Vec3) -> Vec3) -> Self {
        const ACROSS: usize = 4;
        let mut brightness = vec![0.0_f64; COLUMNS * ROWS];
        for (index, sum) in brightness.iter_mut().enumerate() {
            let (column, row) = (index % COLUMNS, index / COLUMNS);
            for part in 0..ACROSS * ACROSS {
                let offset = Vec2::new((part % ACROSS) as f32 + 0.5, (part / ACROSS) as f32 + 0.5) / ACROSS as f32;
                let at = (Vec2::new(column as f32, row as f32) + offset) / Vec2::new(COLUMNS as f32, ROWS as f32);
                *sum += f64::from(light(panorama_direction(at)).element_sum() * (PI * at.y).sin());
            }
        }
        let mean = brightness.iter().sum::<f64>() / brightness.len() as f64;
        // In the dark every direction is as good as another.
        let floor = if mean > 0.0 { ANYWHERE * mean } else { 1.0 };
        let (mut rows, mut cells) = (Vec::with_capacity(ROWS), Vec::with_capacity(COLUMNS * ROWS));
        let mut total = 0.0;
        for (row, cells_of_row) in brightness.chunks(COLUMNS).enumerate() {
            let floor = floor * (std::f64::consts::PI * (row as f64 + 0.5) / ROWS as f64).sin();
            let mut sum = 0.0;
            cells.extend(cells_of_row.iter().map(|value| {
                sum += value + floor;
                sum
            }));
            total += sum;
            rows.push(total);
        }
        for row in 0..ROWS {
            let of_row = &mut cells[row * COLUMNS..(row + 1) * COLUMNS];
            let sum = of_row[COLUMNS - 1];
            of_row.iter_mut().for_each(|cell| *cell /= sum);
        }
        rows.iter_mut().for_each(|row| *row /= total);
        Self { rows, cells }
    }

    /// A direction of the map from a point of the unit square.
    fn direction(&self, at: Vec2) -> Vec3 {
        let (row, y) = pick(&self.rows, at.y);
        let (column, x) = pick(&self.cells[row * COLUMNS..(row + 1) * COLUMNS], at.x);
        panorama_direction(Vec2::new((column as f32 + x) / COLUMNS as f32, (row as f32 + y) / ROWS as f32))
    }

    /// The density of such directions over the sphere.
    fn density(&self, direction: Vec3) -> f32 {
        let at = panorama_point(direction);
        let column = ((at.x * COLUMNS as f32) as usize).min(COLUMNS - 1);
        let row = ((at.y * ROWS as f32) as usize).min(ROWS - 1);
        let chance = |sums: &[f64], index: usize| sums[index] - if index > 0 { sums[index - 1] } else { 0.0 };
        let cell = chance(&self.rows, row) * chance(&self.cells[row * COLUMNS..(row + 1) * COLUMNS], column);
        let area = 2.0 * PI * PI * (PI * at.y).sin().max(1e-6);
        (cell * (COLUMNS * ROWS) as f64) as f32 / area
    }
}

/// The entry of a list of sums up to 1 that a number from 0 to 1 falls on, and where on it.
fn pick(sums: &[f64], number: f32) -> (usize, f32) {
    let number = f64::from(number);
    let index = sums.partition_point(|sum| *sum <= number).min(sums.len() - 1);
    let before = if index > 0 { sums[index - 1] } else { 0.0 };
    let width = sums[index] - before;
    (index, if width > 0.0 { ((number - before) / width).clamp(0.0, 1.0) as f32 } else { 0.5 })
}

#[cfg(test)]
mod tests {
    use aam_scene::{Image, Pixels};

    use super::*;
    use crate::sampling::Points;

    fn image(width: u32, height: u32, light: impl Fn(u32, u32) -> Vec3) -> Image {
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let values = places.flat_map(|(x, y)| light(x, y).to_array()).collect();
        Image { width, height, pixels: Pixels::RgbF32(values) }
    }

    fn sky(map: EnvironmentMap) -> Sky {
        Sky::new(&Environment::new(Arc::new(map)), Up::Y, Shading::Linear)
    }

    fn panorama(width: u32, light: impl Fn(Vec3) -> Vec3) -> EnvironmentMap {
        let height = width / 2;
        let size = Vec2::new(width as f32, height as f32);
        let at = |x: u32, y: u32| panorama_direction((Vec2::new(x as f32, y as f32) + 0.5) / size);
        EnvironmentMap::panorama(image(width, height, |x, y| light(at(x, y)))).unwrap()
    }

    fn mean(sky: &Sky, axis: Vec3, exponent: f32, many: u32) -> Vec3 {
        let points = Points::new(7);
        sky.mean(axis, exponent, many, |by_light, index| points.point(index, u32::from(by_light)))
    }

    #[test]
    fn means_of_polynomials_are_their_closed_forms() {
        // Light 1 + y: over a lobe of exponent n about the axis its mean is 1 + axis.y (n + 1)/(n + 2).
        let sky = sky(panorama(512, |d| Vec3::new(1.0 + d.y, 1.0, 0.0)));
        for exponent in [1.0, 5.0, 40.0, 1000.0] {
            for axis in [Vec3::Y, Vec3::NEG_Y, Vec3::new(0.6, 0.64, -0.48)] {
                let found = mean(&sky, axis, exponent, 4096);
                let expected = 1.0 + axis.y * (exponent + 1.0) / (exponent + 2.0);
                assert!(
                    (found - Vec3::new(expected, 1.0, 0.0)).abs().max_element() < 2e-3,
                    "{exponent} {axis} {found}"
                );
            }
        }
    }

    #[test]
    fn a_small_sun_is_found_from_anywhere() {
        // One texel of 1024 × 512; its irradiance over π is light × solid angle × cosine / π.
        let map = image(1024, 512, |x, y| if (x, y) == (700, 200) { Vec3::splat(5e4) } else { Vec3::ZERO });
        let sky = sky(EnvironmentMap::panorama(map).unwrap());
        let sun = panorama_direction(Vec2::new(700.5 / 1024.0, 200.5 / 512.0));
        let solid_angle = TAU / 1024.0 * PI / 512.0 * (PI * 200.5 / 512.0).sin();
        for axis in [sun, (sun + 2.0 * sun.any_orthonormal_vector()).normalize()] {
            let expected = 5e4 * solid_angle * axis.dot(sun) / PI;
            let found = mean(&sky, axis, 1.0, 1024).x;
            assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
        }
        assert!(mean(&sky, -sun, 1.0, 1024).x < 1e-3);
    }

    #[test]
    fn the_density_of_choices_is_that_of_the_directions() {
        let sky = sky(panorama(64, |d| Vec3::splat(if d.x > 0.6 { 20.0 } else { 0.5 + d.y.max(0.0) })));
        // The mean of 1/density over the choices is the sphere's area, for each half of it.
        let points = Points::new(1);
        let count = 1 << 14;
        for side in [Vec3::X, Vec3::Y, Vec3::Z] {
            let mut halves = [0.0_f64; 2];
            for index in 0..count {
                let direction = sky.chosen(points.point(index, 0));
                halves[usize::from(direction.dot(side) > 0.0)] += 1.0 / f64::from(sky.choice.density(direction));
            }
            for half in halves {
                assert!((half / f64::from(count) - 2.0 * std::f64::consts::PI).abs() < 0.1, "{side} {halves:?}");
            }
        }
    }

    #[test]
    fn darkness_and_hostile_directions_are_survived() {
        let dark = sky(panorama(4, |_| Vec3::ZERO));
        assert_eq!(mean(&dark, Vec3::X, 1.0, 64), Vec3::ZERO);
        let bright = sky(panorama(4, |_| Vec3::splat(1e9)));
        for direction in [Vec3::ZERO, Vec3::NAN, Vec3::splat(1e-38), Vec3::splat(1e19)] {
            assert!(bright.radiance(direction).is_finite(), "{direction}");
        }
        for exponent in [1e-6, 1e6] {
            assert!((mean(&bright, Vec3::X, exponent, 64).x / 1e9 - 1.0).abs() < 0.2);
        }
    }
}
