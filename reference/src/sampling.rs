//! Low-discrepancy points, scrambled so that means over them are unbiased.
//!
//! Sobol' points of two dimensions with Owen's nested uniform scrambling, done by hashing, and shuffled anew for each
//! further pair of dimensions: Burley, "Practical Hash-based Owen Scrambling", JCGT 2020. Any 2ᵏ points that begin at a
//! multiple of 2ᵏ are stratified in every way that 2ᵏ equal boxes can part the square.

use glam::Vec2;

/// A sequence for each pair of dimensions, all independent of each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Points {
    seed: u32,
}

impl Points {
    pub(crate) fn new(seed: u32) -> Self {
        Self { seed: hash(seed) }
    }

    /// Independent points for a part of the work, such as a pixel.
    pub(crate) fn of(self, part: u32) -> Self {
        Self { seed: mix(self.seed, part) }
    }

    /// Point `index` of the sequence for a pair of dimensions, in `[0, 1)²`.
    pub(crate) fn point(self, index: u32, pair: u32) -> Vec2 {
        let seed = mix(self.seed, pair);
        let index = scramble(index, seed);
        let (x, y) = (index.reverse_bits(), second_dimension(index));
        Vec2::new(unit(scramble(x, mix(seed, 1))), unit(scramble(y, mix(seed, 2))))
    }
}

/// Sobol's second dimension, whose direction numbers are the rows of Pascal's triangle modulo 2.
fn second_dimension(mut index: u32) -> u32 {
    let (mut direction, mut sum) = (1_u32 << 31, 0);
    while index != 0 {
        if index & 1 == 1 {
            sum ^= direction;
        }
        index >>= 1;
        direction ^= direction >> 1;
    }
    sum
}

/// A number in `[0, 1)` from its upper bits.
fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1 << 24) as f32
}

/// A hash without visible structure: C. Wellons, "Prospecting for Hash Functions", 2018.
fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

fn mix(seed: u32, part: u32) -> u32 {
    hash(seed ^ hash(part.wrapping_add(0x9e37_79b9)))
}

/// Turns each bit or leaves it, as the bits above it say: Laine and Karras's permutation on the reversed bits, with the
/// constants of N. Vegdahl, "Building a Better LK Hash", 2021.
fn scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul(seed >> 16 | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_block_of_a_power_of_two_fills_every_box_of_its_size_once() {
        let points = Points::new(5).of(77);
        for (log, block) in [(4, 0), (4, 3), (6, 1), (8, 0)] {
            let count = 1_u32 << log;
            for columns_log in 0..=log {
                let (columns, rows) = (1 << columns_log, 1 << (log - columns_log));
                let mut filled = vec![0; count as usize];
                for index in block * count..(block + 1) * count {
                    let point = points.point(index, 9) * Vec2::new(columns as f32, rows as f32);
                    filled[(point.y as u32 * columns + point.x as u32) as usize] += 1;
                }
                assert!(filled.iter().all(|count| *count == 1), "{count} points in {columns} × {rows} boxes");
            }
        }
    }

    #[test]
    fn pairs_of_dimensions_parts_and_seeds_are_independent() {
        let count = 4096;
        let correlation = |a: &dyn Fn(u32) -> f32, b: &dyn Fn(u32) -> f32| {
            let sum: f64 = (0..count).map(|i| f64::from(a(i) - 0.5) * f64::from(b(i) - 0.5)).sum();
            12.0 * sum / f64::from(count)
        };
        let points = Points::new(1);
        let base = |i| points.point(i, 0).x;
        assert!((correlation(&base, &base) - 1.0).abs() < 0.01);
        // The deviation of the correlation of independent numbers is 1/64.
        for other in [
            Box::new(|i| points.point(i, 0).y) as Box<dyn Fn(u32) -> f32>,
            Box::new(|i| points.point(i, 1).x),
            Box::new(|i| points.of(1).point(i, 0).x),
            Box::new(|i| Points::new(2).point(i, 0).x),
        ] {
            assert!(correlation(&base, &*other).abs() < 0.06, "{}", correlation(&base, &*other));
        }
    }

    #[test]
    fn the_mean_of_many_scrambles_is_the_integral() {
        // Without a bias that one scramble alone could hide: x² y over the square is 1/6.
        let means = (0..4000).map(|seed| {
            let points = Points::new(seed);
            (0..4).map(|i| points.point(i, 3)).map(|p| f64::from(p.x * p.x * p.y)).sum::<f64>() / 4.0
        });
        let mean = means.sum::<f64>() / 4000.0;
        assert!((mean - 1.0 / 6.0).abs() < 0.003, "{mean}");
    }
}
