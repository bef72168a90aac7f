//! Mip chains, made on the CPU: equal on every device, exact for odd sizes, and right for what the texels mean
//! (`docs/techniques/shading.md` §4).

use std::sync::LazyLock;

/// What an image's numbers mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Meaning {
    /// Numbers to compute on as they are stored.
    Stored,
    /// sRGB-encoded colours to compute on in linear light.
    Srgb,
    /// Unit vectors, each component c stored as (c + 1) / 2.
    Vectors,
}

/// One value each for red, green, blue, alpha.
pub(crate) type Texel = [f32; 4];

/// Values of one level, row by row from the top: decoded if they mean sRGB colours.
#[derive(Debug)]
pub(crate) struct Level {
    pub width: u32,
    pub height: u32,
    pub texels: Vec<Texel>,
}

/// How many levels an image of this size has, down to 1 × 1.
pub(crate) fn level_count(width: u32, height: u32) -> u32 {
    width.max(height).max(1).ilog2() + 1
}

/// Size of the level after one of this size.
pub(crate) fn next_size(width: u32, height: u32) -> (u32, u32) {
    ((width / 2).max(1), (height / 2).max(1))
}

/// The level after one whose rows `row(y, out)` fills in.
pub(crate) fn next_level(width: u32, height: u32, meaning: Meaning, row: impl Fn(u32, &mut [Texel])) -> Level {
    let (next_width, next_height) = next_size(width, height);
    let columns: Vec<Taps> = (0..next_width).map(|x| Taps::new(x, width, next_width)).collect();
    let mut texels = Vec::with_capacity(next_width as usize * next_height as usize);
    let mut source = vec![[0.0; 4]; width as usize];
    let mut sum = vec![[0.0; 4]; width as usize];
    for y in 0..next_height {
        sum.fill([0.0; 4]);
        let rows = Taps::new(y, height, next_height);
        for (offset, &weight) in rows.weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            row(rows.first + offset as u32, &mut source);
            for (sum, texel) in sum.iter_mut().zip(&source) {
                for channel in 0..4 {
                    sum[channel] += weight * texel[channel];
                }
            }
        }
        for column in &columns {
            let mut texel = [0.0; 4];
            for (offset, &weight) in column.weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
                for channel in 0..4 {
                    texel[channel] += weight * sum[column.first as usize + offset][channel];
                }
            }
            if meaning == Meaning::Vectors {
                texel = make_unit(texel);
            }
            texels.push(texel);
        }
    }
    Level { width: next_width, height: next_height, texels }
}

/// The texels of a finer level that one of the next covers, with the share of each: two of equal share if the
/// size is even, parts of three if it is odd.
struct Taps {
    first: u32,
    weights: [f32; 3],
}

impl Taps {
    fn new(index: u32, size: u32, next: u32) -> Self {
        let (start, end) = (u64::from(index) * u64::from(size), (u64::from(index) + 1) * u64::from(size));
        let first = start / u64::from(next);
        let weights = [0, 1, 2].map(|offset| {
            let (left, right) = ((first + offset) * u64::from(next), (first + offset + 1) * u64::from(next));
            let covered = right.min(end).saturating_sub(left.max(start));
            (covered as f64 / size as f64) as f32
        });
        Self { first: first as u32, weights }
    }
}

fn make_unit([x, y, z, alpha]: Texel) -> Texel {
    let v = glam::Vec3::new(x, y, z) * 2.0 - 1.0;
    let unit = v.try_normalize().unwrap_or(glam::Vec3::Z) * 0.5 + 0.5;
    [unit.x, unit.y, unit.z, alpha]
}

/// sRGB to linear (IEC 61966-2-1), continued beyond 1.
pub(crate) fn srgb_decode(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Linear values of the 256 codes of 8-bit sRGB.
pub(crate) static SRGB8: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| srgb_decode(code as f32 / 255.0)));

/// For each 4096th of linear light, the 8-bit sRGB code of its lower end.
static SRGB8_GUESS: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut code = 0u8;
    (0..4096)
        .map(|step| {
            while code < 255 && SRGB8_UPPER[usize::from(code)] <= step as f32 / 4096.0 {
                code += 1;
            }
            code
        })
        .collect()
});

/// The linear value from which on the next code is nearer (in encoded values).
static SRGB8_UPPER: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| srgb_decode((code as f32 + 0.5) / 255.0)));

/// The 8-bit sRGB code nearest to a linear value.
pub(crate) fn srgb8_encode(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let mut code = SRGB8_GUESS[((linear * 4096.0) as usize).min(4095)];
    while code < 255 && SRGB8_UPPER[usize::from(code)] <= linear {
        code += 1;
    }
    code
}

/// The 8-bit code nearest to a value.
pub(crate) fn unorm8_encode(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// The half float nearest to a value, at most ±65504; NaN becomes 0.
pub(crate) fn half_encode(value: f32) -> u16 {
    if value.is_nan() { 0 } else { half::f16::from_f32(value.clamp(-65504.0, 65504.0)).to_bits() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(width: u32, height: u32, texels: &[Texel], meaning: Meaning) -> Level {
        next_level(width, height, meaning, |y, out| {
            out.copy_from_slice(&texels[(y * width) as usize..((y + 1) * width) as usize]);
        })
    }

    #[test]
    fn means_are_weighted_by_area() {
        let row: Vec<Texel> = [0.0, 0.3, 0.9].iter().map(|&v| [v, 0.0, 0.0, 1.0]).collect();
        let next = level(3, 1, &row, Meaning::Stored);
        assert_eq!((next.width, next.height), (1, 1));
        assert!((next.texels[0][0] - 0.4).abs() < 1e-6 && next.texels[0][3] == 1.0, "{:?}", next.texels);
        // 5 → 2: each new texel covers 2.5 old ones.
        let row: Vec<Texel> = [1.0, 0.0, 1.0, 0.0, 0.0].iter().map(|&v| [v; 4]).collect();
        let next = level(5, 1, &row, Meaning::Stored);
        assert!((next.texels[0][0] - 1.5 / 2.5).abs() < 1e-6 && (next.texels[1][0] - 0.5 / 2.5).abs() < 1e-6);
    }

    #[test]
    fn the_mean_of_any_chain_is_kept() {
        let (width, height) = (37, 11);
        let texels: Vec<Texel> = (0..width * height).map(|i| [((i * 7919) % 256) as f32 / 255.0; 4]).collect();
        let mean = texels.iter().map(|t| f64::from(t[0])).sum::<f64>() / texels.len() as f64;
        let mut current = Level { width, height, texels };
        for _ in 1..level_count(width, height) {
            current = level(current.width, current.height, &current.texels, Meaning::Stored);
        }
        assert_eq!(current.texels.len(), 1);
        assert!((f64::from(current.texels[0][0]) - mean).abs() < 1e-5);
    }

    #[test]
    fn vectors_stay_unit_and_opposite_ones_give_plus_z() {
        let texels = [[1.0, 0.5, 0.5, 1.0], [0.5, 1.0, 0.5, 1.0]];
        let [x, y, z, _] = level(2, 1, &texels, Meaning::Vectors).texels[0];
        let v = glam::Vec3::new(x, y, z) * 2.0 - 1.0;
        assert!((v - glam::Vec3::new(0.5f32.sqrt(), 0.5f32.sqrt(), 0.0)).length() < 1e-6);
        let texels = [[1.0, 0.5, 0.5, 1.0], [0.0, 0.5, 0.5, 1.0]];
        assert_eq!(level(2, 1, &texels, Meaning::Vectors).texels[0], [0.5, 0.5, 1.0, 1.0]);
    }

    #[test]
    fn srgb_codes_go_there_and_back() {
        for code in 0..=255u8 {
            assert_eq!(srgb8_encode(SRGB8[usize::from(code)]), code);
        }
        // The linear mean of black and white is 188, not 128.
        assert_eq!(srgb8_encode(0.5), 188);
    }

    #[test]
    fn halves_stay_finite() {
        assert_eq!(half_encode(f32::NAN), 0);
        assert_eq!(half::f16::from_bits(half_encode(f32::INFINITY)).to_f32(), 65504.0);
        assert_eq!(half::f16::from_bits(half_encode(0.333)).to_f32(), 0.333_007_8);
    }
}
