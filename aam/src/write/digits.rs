//! The texts of usual numbers, made without a loop over their digits.

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
    (0..100_000_000).contains(&value).then(|| integer_text(value as u64))
}

/// A whole number below 100,000,000.
#[inline(always)]
fn integer_text(value: u64) -> ShortText {
    // Most smoothing numbers, and most of what stands before a point.
    if value < 10 {
        return (u64::from(b'0') + value, 1);
    }
    let digits = eight_digits(value);
    let dropped = digits.trailing_zeros() & !7;
    ((digits | ZEROS) >> dropped, 8 - dropped as usize / 8)
}

/// The text of a decimal in pieces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Decimal {
    /// What stands before the point.
    pub(crate) whole: ShortText,
    /// The point and two digits.
    pub(crate) first: u32,
    /// The eight digits behind them.
    pub(crate) others: u64,
    /// How many bytes the point and what stands behind it take, at most 11.
    pub(crate) length: usize,
}

/// What is needed to write the `f32` of one exponent: they are whole multiples of a step, a power of two.
#[derive(Clone, Copy)]
struct Scale {
    /// The power of ten that makes the step 1 to 10.
    power: f64,
    /// Half the step, times this power.
    half: f64,
    /// What makes ten digits of those that the power makes whole.
    to_ten: u64,
}

/// Added to a value that is not negative it leaves no bit for anything behind the point, and rounds ties to even.
const WHOLE: f64 = (1u64 << 52) as f64;

/// The exponent of 2⁻¹⁰.
const FIRST: u32 = 127 - 10;
const SCALES: [Scale; 33] = {
    let mut scales = [Scale { power: 0.0, half: 0.0, to_ten: 0 }; 33];
    let mut place = 0;
    while place < scales.len() {
        // 2⁻³³ and up.
        let mut step = 1.0 / (1u64 << (33 - place)) as f64;
        let half = step / 2.0;
        let (mut power, mut to_ten) = (1.0, 10_000_000_000);
        while step < 1.0 {
            step *= 10.0;
            power *= 10.0;
            to_ten /= 10;
        }
        scales[place] = Scale { power, half: half * power, to_ten };
        place += 1;
    }
    scales
};

/// The shortest decimal that reads back to this `f32`, and of these the nearest to it, for 0 and for values from 0.001 to 2²³.
///
/// Scaled so that the step between neighbours is 1 to 10, what reads back to a value lies less than 5 from it: there is at most one
/// multiple of ten among it, which is then the shortest, with its zeros dropped; else it is the nearest whole number (after
/// Giulietti, "The Schubfach way to render doubles", 2020). A significand of 24 bits times at most 5¹⁰ fits an `f64`, so nothing
/// is rounded on the way. A power of two, whose neighbour below is nearer than that above, is in this range a multiple of ten itself.
/// What stands before the point is the same for all that reads back to a value, unless it is whole, since whole numbers are `f32`
/// here.
#[inline(always)]
pub(crate) fn decimal(value: f32) -> Option<Decimal> {
    const SMALLEST: u32 = 0.001f32.to_bits();
    const POINT: u32 = u32::from_le_bytes(*b".000");
    let bits = value.to_bits();
    if bits == 0 {
        return Some(Decimal { whole: (u64::from(b'0'), 1), first: POINT, others: ZEROS, length: 2 });
    }
    let scale = SCALES.get((bits >> 23).wrapping_sub(FIRST) as usize).filter(|_| bits >= SMALLEST)?;
    let whole = value as u32;
    let scaled = (f64::from(value) - f64::from(whole)) * scale.power;
    let [nearest, tens] = [scaled, scaled * 0.1].map(|value| value + WHOLE);
    // The product with 0.1 is rounded, but never so that the multiple of ten is not the nearest where any is near enough.
    let off = ((tens - WHOLE) * 10.0 - scaled).abs();
    // Of two decimals exactly between neighbours the one with the even significand is read: there, half the step is near enough.
    let near = f64::from_bits(scale.half.to_bits() + u64::from(!bits & 1));
    let [nearest, tens] = [nearest, tens].map(|value| value.to_bits() - WHOLE.to_bits());
    let digits = nearest ^ ((nearest ^ (10 * tens)) & u64::from(off < near).wrapping_neg());
    let part = digits * scale.to_ten;
    let (first, others) = ((part / 100_000_000) as u32, eight_digits(part % 100_000_000));
    let ten = (first * 103) >> 10;
    let second = first - 10 * ten;
    // One digit stays behind the point.
    let zeros_at_end =
        if others == 0 { 8 + usize::from(second == 0) } else { (others | 1).leading_zeros() as usize / 8 };
    Some(Decimal {
        whole: integer_text(u64::from(whole)),
        first: ten << 8 | second << 16 | POINT,
        others: others | ZEROS,
        length: 11 - zeros_at_end,
    })
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

    /// The text of a decimal.
    fn text(value: f32) -> Option<([u8; 24], usize)> {
        let Decimal { whole: (whole, whole_length), first, others, length } = decimal(value)?;
        let mut text = [0; 24];
        text[..8].copy_from_slice(&whole.to_le_bytes());
        text[whole_length..][..4].copy_from_slice(&first.to_le_bytes());
        text[whole_length + 3..][..8].copy_from_slice(&others.to_le_bytes());
        Some((text, whole_length + length))
    }

    fn check_decimal(value: f32) {
        let (text, length) = text(value).expect("in range");
        let text = std::str::from_utf8(&text[..length]).expect("digits");
        assert_eq!(text.parse(), Ok(value), "{text}");
        // The standard library's is the shortest too, but has no `.0`, and of two that are as near it takes the upper.
        let shortest = format!("{value}");
        assert_eq!(text.strip_suffix(".0").unwrap_or(text).len(), shortest.len(), "{text} for {shortest}");
        assert_eq!(text, zmij::Buffer::new().format_finite(value));
    }

    #[test]
    fn decimals_are_those_of_the_standard_library() {
        let (smallest, end) = (0.001f32.to_bits(), 8_388_608f32.to_bits());
        (smallest..end).step_by(307).map(f32::from_bits).for_each(check_decimal);
        for value in [smallest, end - 1].into_iter().chain((-9..23).map(|power| 2f32.powi(power).to_bits())) {
            let around = value.saturating_sub(300).max(smallest)..(value + 300).min(end);
            around.map(f32::from_bits).for_each(check_decimal);
        }
        for decimals in 0..=6 {
            let power = 10f64.powi(decimals);
            for digits in (0..1_000_000).step_by(7) {
                let value = (f64::from(digits) / power) as f32;
                if value >= 0.001 || value == 0.0 {
                    check_decimal(value);
                }
            }
        }
    }

    /// All of them against `zmij`, which writes the others.
    #[test]
    #[ignore = "takes ten seconds in a release build"]
    fn every_decimal_is_the_shortest() {
        for bits in 0.001f32.to_bits()..8_388_608f32.to_bits() {
            let value = f32::from_bits(bits);
            let (text, length) = text(value).expect("in range");
            assert_eq!(&text[..length], zmij::Buffer::new().format_finite(value).as_bytes(), "{value}");
        }
    }

    #[test]
    fn other_values_are_left_to_others() {
        for value in [8_388_608.0, 1e30, 1e-3f32.next_down(), 1e-30, f32::MIN_POSITIVE, 1e-45, -1.0, -0.0, f32::NAN] {
            assert_eq!(decimal(value), None, "{value}");
        }
        assert_eq!(decimal(f32::INFINITY), None);
    }
}
