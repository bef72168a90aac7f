//! Numbers: the leaf parsers on which the speed of reading rests.
//!
//! Decimals give the nearest `f32` (ties to even) for every input, as the standard library does. Short decimals, which
//! is nearly all there are, take Clinger's path (1990): digits as an integer and a power of ten are both exact in
//! `f64`, so their quotient is rounded once, and rounding that again to `f32` is right unless it lies within an ulp of
//! a tie; those and all longer ones go to `fast-float2`.

use super::fault::{Fault, Parsed, Rest};

const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// White space of any kind.
#[inline]
pub(crate) fn is_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r')
}

/// Skips white space, line ends included.
#[inline]
pub(crate) fn skip_space(mut rest: Rest<'_>) -> Rest<'_> {
    while let [first, tail @ ..] = rest {
        if !is_space(*first) {
            break;
        }
        rest = tail;
    }
    rest
}

/// A real number, after any white space. Non-finite values in the spellings of C and of Microsoft's C are accepted.
#[inline]
pub(crate) fn real(rest: Rest<'_>) -> Parsed<'_, f32> {
    let start = skip_space(rest);
    let (negative, digits_start) = match start {
        [b'-', tail @ ..] => (true, tail),
        [b'+', tail @ ..] => (false, tail),
        _ => (false, start),
    };
    let mut at = digits_start;
    let mut mantissa: u64 = 0;
    let mut digits = 0u32;
    let mut scale = 0u32;
    while let [byte, tail @ ..] = at {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        digits += 1;
        at = tail;
    }
    if let [b'.', tail @ ..] = at {
        at = tail;
        let before = at.len();
        while let [byte, tail @ ..] = at {
            let digit = byte.wrapping_sub(b'0');
            if digit > 9 {
                break;
            }
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
            at = tail;
        }
        scale = u32::try_from(before - at.len()).unwrap_or(u32::MAX);
        digits = digits.saturating_add(scale);
    }
    let ends = at.first().is_none_or(|&byte| is_space(byte));
    if ends && digits > 0 && digits <= 19 && mantissa < (1 << 53) && scale <= 22 {
        let value = mantissa as f64 / POWERS[scale as usize];
        // The 29 bits that f32 drops: a tie, give or take one ulp of f64, cannot be decided here.
        let dropped = value.to_bits() & 0x1fff_ffff;
        let subnormal = value < f64::from(f32::MIN_POSITIVE) && mantissa != 0;
        if !subnormal && dropped.wrapping_sub(0x0fff_ffff) > 2 {
            let single = value as f32;
            return Ok((at, if negative { -single } else { single }));
        }
    }
    real_slow(start)
}

#[cold]
#[inline(never)]
fn real_slow(start: Rest<'_>) -> Parsed<'_, f32> {
    let length = start.iter().position(|&byte| is_space(byte)).unwrap_or(start.len());
    let (token, tail) = start.split_at(length);
    if let Ok(value) = fast_float2::parse::<f32, _>(token) {
        return Ok((tail, value));
    }
    let (negative, body) = match token {
        [b'-', body @ ..] => (true, body),
        [b'+', body @ ..] => (false, body),
        body => (false, body),
    };
    let magnitude = if body.starts_with(b"1.#INF") {
        f32::INFINITY
    } else if body.starts_with(b"1.#IND")
        || body.starts_with(b"1.#QNAN")
        || body.starts_with(b"1.#SNAN")
        || body.eq_ignore_ascii_case(b"nan(ind)")
        || body.eq_ignore_ascii_case(b"nan(snan)")
    {
        f32::NAN
    } else {
        return Fault::expected(start, "a number");
    };
    Ok((tail, if negative { -magnitude } else { magnitude }))
}

/// A whole number that fits `i32`, after any white space.
#[inline]
pub(crate) fn integer(rest: Rest<'_>) -> Parsed<'_, i32> {
    let start = skip_space(rest);
    let (negative, mut at) = match start {
        [b'-', tail @ ..] => (true, tail),
        [b'+', tail @ ..] => (false, tail),
        _ => (false, start),
    };
    let mut value: i64 = 0;
    let mut digits = 0;
    while let [byte, tail @ ..] = at {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        value = value * 10 + i64::from(digit);
        digits += 1;
        if value > 1 << 40 {
            break;
        }
        at = tail;
    }
    if digits == 0 || at.first().is_some_and(|&byte| !is_space(byte) && !byte.is_ascii_digit()) {
        return Fault::expected(start, "a whole number");
    }
    if negative {
        value = -value;
    }
    // 3ds Max prints its 32-bit masks signed; an unsigned print of the same bits is the same mask.
    match i32::try_from(value).or_else(|_| u32::try_from(value).map(|bits| bits as i32)) {
        Ok(value) => Ok((at, value)),
        Err(_) => Fault::fatal(start, "value/range", "the whole number does not fit 32 bits"),
    }
}

/// A count: a whole number that is not negative, after any white space.
#[inline]
pub(crate) fn count(rest: Rest<'_>) -> Parsed<'_, usize> {
    let start = skip_space(rest);
    let length = start.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(start.len());
    let (digits, tail) = start.split_at(length);
    if digits.is_empty() || tail.first().is_some_and(|&byte| !is_space(byte)) {
        return Fault::expected(start, "a count (a whole number of 0 or more)");
    }
    let value =
        digits.iter().try_fold(0usize, |value, digit| value.checked_mul(10)?.checked_add(usize::from(digit - b'0')));
    match value {
        Some(value) => Ok((tail, value)),
        None => Fault::fatal(start, "count/too-large", "the count is larger than any file could hold"),
    }
}

/// An index below `limit`, after any white space. `what` names the list for the message.
#[inline]
pub(crate) fn index<'a>(rest: Rest<'a>, limit: usize, what: &str) -> Parsed<'a, u32> {
    let start = skip_space(rest);
    let (tail, value) = integer(start)?;
    match u32::try_from(value) {
        Ok(index) if (index as usize) < limit => Ok((tail, index)),
        _ => Fault::fatal(
            start,
            "geometry/index",
            if limit == 0 {
                format!("index {value} into the {what}, which is empty")
            } else {
                format!("index {value} is outside the {what} (0 to {})", limit - 1)
            },
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn same(text: &str) {
        let (rest, value) = real(text.as_bytes()).expect(text);
        assert!(rest.is_empty(), "{text}");
        let expected: f32 = text.parse().expect(text);
        assert_eq!(value.to_bits(), expected.to_bits(), "{text}: {value} for {expected}");
    }

    #[test]
    fn decimals_are_the_nearest_f32() {
        for text in [
            "0",
            "-0",
            "-0.0000",
            "1",
            "+1.5",
            ".5",
            "5.",
            "1e10",
            "-1.25e-7",
            "16777217",
            "16777219",
            "8388608.5",
            "9007199254740993",
            "0.1",
            "0.30000001192092896",
            "3.4028235e38",
            "3.4028236e38",
            "1e39",
            "1e-45",
            "7e-46",
            "1.1754943e-38",
            "0.000000000000000000000000000000000000011754942",
            "123456789012345678901234567890",
            "1.00000005960464477539062",
            "1.000000059604644775390625",
            "1.000000059604644775390626",
        ] {
            same(text);
        }
        // Every tie between neighbouring f32 in reach of the fast path, and its closest decimals.
        let mut state = 0x9e37_79b9_7f4a_7c15u64;
        for _ in 0..200_000 {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            let low = f32::from_bits((state as u32 & 0x0fff_ffff) | 0x3800_0000);
            let high = f32::from_bits(low.to_bits() + 1);
            let tie = (f64::from(low) + f64::from(high)) / 2.0;
            same(&format!("{tie}"));
            same(&format!("{tie:.12}"));
            same(&format!("{low:.4}"));
            same(&format!("{low:.10}"));
            same(&format!("{low}"));
        }
    }

    #[test]
    fn four_hundred_digits_are_read_exactly() {
        let long = format!("{}.{}", "1".repeat(30), "7".repeat(370));
        same(&long);
        same(&format!("0.{}1", "0".repeat(399)));
    }

    #[test]
    fn spellings_of_what_is_not_a_number() {
        for text in ["-1.#IND", "1.#QNAN", "-1.#IND00", "nan", "-nan(ind)"] {
            assert!(real(text.as_bytes()).expect(text).1.is_nan(), "{text}");
        }
        assert_eq!(real(b"1.#INF").expect("inf").1, f32::INFINITY);
        assert_eq!(real(b"-inf").expect("inf").1, f32::NEG_INFINITY);
        for text in ["", "-", ".", "1.2.3", "1,5", "0x10", "1e", "12a", "#IND"] {
            assert!(real(text.as_bytes()).is_err(), "{text:?}");
        }
    }

    #[test]
    fn whole_numbers_and_their_limits() {
        assert_eq!(integer(b" -2147483648 ").expect("min").1, i32::MIN);
        assert_eq!(integer(b"4294967295").expect("mask").1, -1);
        assert!(integer(b"4294967296").is_err());
        assert!(integer(b"1.0").is_err());
        assert!(integer(b"99999999999999999999999999").is_err());
        assert_eq!(count(b"007\n").expect("count").1, 7);
        assert!(count(b"-1").is_err());
        assert!(count(b"99999999999999999999999999").is_err());
        assert!(index(b"3", 3, "vertices").is_err());
        assert!(index(b"-1", 3, "vertices").is_err());
    }
}
