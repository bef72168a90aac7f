//! The texts of short numbers, made without a loop over their digits.

use wide::f32x4;

/// A text of at most eight bytes, the first in the lowest byte, and how many they are.
pub(crate) type ShortText = (u64, usize);

const ZEROS: u64 = 0x3030_3030_3030_3030;

/// The eight decimal digits of a number below 100,000,000; the first in the lowest byte.
#[inline(always)]
fn eight_digits(value: u64) -> u64 {
    // Numbers beside each other in one word are divided at once, each by a product and a shift that are exact for its range.
    let fours = (value / 10_000) | (value % 10_000) << 32;
    let hundreds = ((fours * 10_486) >> 20) & 0x0000_007f_0000_007f;
    let pairs = hundreds | (fours - 100 * hundreds) << 16;
    let tens = ((pairs * 103) >> 10) & 0x000f_000f_000f_000f;
    tens | (pairs - 10 * tens) << 8
}

/// A whole number from 0 to 99,999,999.
#[inline(always)]
pub(crate) fn short_integer(value: i64) -> Option<ShortText> {
    if !(0..100_000_000).contains(&value) {
        return None;
    }
    // Most smoothing numbers.
    if value < 10 {
        return Some((u64::from(b'0') + value as u64, 1));
    }
    let digits = eight_digits(value as u64);
    let dropped = digits.trailing_zeros() & !7;
    Some(((digits | ZEROS) >> dropped, 8 - dropped as usize / 8))
}

/// A decimal from 0.001 to 999.999, or 0, that has at most six digits without the zero before the point: what exporters print.
/// It is also the shortest that reads back to this `f32`, since no two decimals of so few digits have the same.
#[inline(always)]
pub(crate) fn short_decimal(value: f32) -> Option<ShortText> {
    const DECIMALS: [(f64, f64); 4] = [(1e6, 1e-6), (1e5, 1e-5), (1e4, 1e-4), (1e3, 1e-3)];
    // Each comparison that holds adds a bit behind the last.
    let holds = f32x4::splat(value).simd_ge(f32x4::new([1.0, 10.0, 100.0, 1000.0])).to_bitmask();
    let whole_digits = holds.trailing_ones() as usize;
    let &(power, part) = DECIMALS.get(whole_digits)?;
    let scaled = (f64::from(value) * power + 0.5) as i32;
    // A decimal of six digits is never so near to the middle between two f32 that the errors of an f64 matter.
    if (f64::from(scaled) * part) as f32 != value || scaled >= 1_000_000 {
        return None;
    }
    let six = eight_digits(scaled as u64) >> 16;
    let zeros_at_end = (six << 16).leading_zeros() as usize / 8;
    let text = six | (ZEROS >> 16);
    let (text, length) = if whole_digits == 0 {
        // Below, the shortest form has an exponent.
        if scaled != 0 && scaled < 1000 {
            return None;
        }
        (text << 16 | u64::from(u16::from_le_bytes(*b"0.")), 8)
    } else {
        let before = (1u64 << (8 * whole_digits)) - 1;
        (text & before | (text & !before) << 8 | u64::from(b'.') << (8 * whole_digits), 7)
    };
    // One digit stays behind the point.
    Some((text, length - zeros_at_end.min(5 - whole_digits)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_integer(value: i64) {
        let (text, length) = short_integer(value).expect("in range");
        assert_eq!(&text.to_le_bytes()[..length], value.to_string().as_bytes());
    }

    #[test]
    fn integers_have_the_digits_of_the_standard_library() {
        (0..200_000).for_each(check_integer);
        (0..100_000_000).step_by(101).for_each(check_integer);
        for power in [1_000_000, 10_000_000, 100_000_000] {
            (power - 1_000..power).for_each(check_integer);
        }
        assert_eq!(short_integer(-1), None);
        assert_eq!(short_integer(100_000_000), None);
    }

    fn check_decimal(value: f32) -> bool {
        let Some((text, length)) = short_decimal(value) else { return false };
        let shortest = zmij::Buffer::new().format_finite(value).to_owned();
        assert_eq!(&text.to_le_bytes()[..length], shortest.as_bytes(), "{value}");
        true
    }

    #[test]
    fn decimals_are_the_shortest() {
        for decimals in 3..=6 {
            let power = 10f64.powi(decimals);
            for digits in 0..1_000_000 {
                let value = (f64::from(digits) / power) as f32;
                let written = check_decimal(value);
                assert!(written || (value < 0.001 && value > 0.0), "{value}");
            }
        }
        // Any others of these sizes, of which few are short.
        let short = (0x3980_0000..0x4480_0000).step_by(37).filter(|&bits| check_decimal(f32::from_bits(bits))).count();
        assert!(short > 1000, "{short}");
        for value in [1000.0, 1e30, 1e-3f32.next_down(), 1e-30, f32::MIN_POSITIVE, 1e-45, -1.0, f32::NAN, f32::INFINITY]
        {
            assert_eq!(short_decimal(value), None, "{value}");
        }
    }
}
