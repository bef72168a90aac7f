//! Numbers: the leaf parsers on which the speed of reading rests.
//!
//! Decimals give the nearest `f32` (ties to even) for every input, as the standard library does. Short decimals, which
//! is nearly all there are, take Clinger's path (1990): digits as an integer and a power of ten are both exact in
//! `f64`, so their quotient is rounded once, and rounding that again to `f32` is right unless it lies within an ulp of
//! a tie; those and all longer ones go to `fast-float2`.

use super::fault::{Fault, Parsed, Rest};

const POWERS: [f64; 8] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7];

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

/// The leading decimal digits of eight bytes: their value, and how many there are.
///
/// The bytes are looked at as one word (after Lemire, "Quickly parsing eight digits", 2018): a byte is a digit if adding
/// 0x76 to its distance from `0` does not reach the top bit, and neighbours are then joined in three steps.
#[inline(always)]
fn digits8(word: u64) -> (u64, u32) {
    let word = word ^ 0x3030_3030_3030_3030;
    let others = (word.wrapping_add(0x7676_7676_7676_7676) | word) & 0x8080_8080_8080_8080;
    let count = others.trailing_zeros() / 8;
    // Fewer than eight digits move up, which puts zeros before them; in two steps, since no digits move by 64 bits.
    let word = (word << (32 - 4 * count)) << (32 - 4 * count);
    let pairs = (word.wrapping_mul(10).wrapping_add(word >> 8)) & 0x00ff_00ff_00ff_00ff;
    let fours = (pairs.wrapping_mul(100).wrapping_add(pairs >> 16)) & 0x0000_ffff_0000_ffff;
    (fours.wrapping_mul(10_000).wrapping_add(fours >> 32) & 0xffff_ffff, count)
}

/// The first eight bytes as a little-endian word.
#[inline(always)]
fn word8(rest: Rest<'_>) -> Option<u64> {
    rest.first_chunk::<8>().map(|chunk| u64::from_le_bytes(*chunk))
}

/// A whole number of one to seven digits with white space after it, after any white space: its value and the bytes
/// taken, or no bytes where the number is anything else.
#[inline(always)]
fn short_integer(rest: Rest<'_>) -> (u32, usize) {
    let start = skip_space(rest);
    let Some(word) = word8(start) else { return (0, 0) };
    let (value, count) = digits8(word);
    if count.wrapping_sub(1) < 7 && is_space((word >> (8 * count)) as u8) {
        (value as u32, rest.len() - start.len() + count as usize)
    } else {
        (0, 0)
    }
}

/// A decimal of at most seven digits before the point and seven after it, after any white space: its value and the
/// bytes taken, or no bytes where the number is anything else.
#[inline(always)]
fn short_real(rest: Rest<'_>) -> (f32, usize) {
    let start = skip_space(rest);
    let negative = start.first() == Some(&b'-');
    let from = usize::from(negative);
    let Some(word) = start.get(from..).and_then(word8) else { return (0.0, 0) };
    let (whole, whole_count) = digits8(word);
    if whole_count >= 8 {
        return (0.0, 0);
    }
    let mut taken = from + whole_count as usize;
    let mut end = (word >> (8 * whole_count)) as u8;
    let (mut mantissa, mut scale) = (whole, 0);
    if end == b'.' {
        taken += 1;
        let Some(word) = start.get(taken..).and_then(word8) else { return (0.0, 0) };
        let (fraction, count) = digits8(word);
        if count >= 8 {
            return (0.0, 0);
        }
        mantissa = whole * INTEGER_POWERS[count as usize] + fraction;
        scale = count;
        taken += count as usize;
        end = (word >> (8 * count)) as u8;
    }
    let value = mantissa as f64 / POWERS[scale as usize];
    // The 29 bits that f32 drops: a tie, give or take one ulp of f64, cannot be decided here. The smallest value but 0
    // is 1e-7, so no f32 is subnormal.
    let dropped = value.to_bits() & 0x1fff_ffff;
    if !is_space(end) || whole_count + scale == 0 || dropped.wrapping_sub(0x0fff_ffff) <= 2 {
        return (0.0, 0);
    }
    let single = value as f32;
    (if negative { -single } else { single }, rest.len() - start.len() + taken)
}

const INTEGER_POWERS: [u64; 8] = [1, 10, 100, 1000, 10_000, 100_000, 1_000_000, 10_000_000];

/// A real number, after any white space. Non-finite values in the spellings of C and of Microsoft's C are accepted.
#[inline]
pub(crate) fn real(rest: Rest<'_>) -> Parsed<'_, f32> {
    match short_real(rest) {
        (value, taken @ 1..) => Ok((&rest[taken..], value)),
        _ => real_slow(skip_space(rest)),
    }
}

/// Fills a row with reals of the usual short form; gives the rest, or nothing where a number is of another form.
#[inline(always)]
pub(crate) fn short_row<'a, const N: usize>(mut rest: Rest<'a>, row: &mut [f32; N]) -> Option<Rest<'a>> {
    for slot in row {
        let (value, taken) = short_real(rest);
        if taken == 0 {
            return None;
        }
        *slot = value;
        rest = rest.get(taken..)?;
    }
    Some(rest)
}

/// Fills a triple with short indices below a limit; gives the rest, or nothing where one is of another form.
#[inline(always)]
pub(crate) fn short_indices<'a>(mut rest: Rest<'a>, limit: usize, row: &mut [u32; 3]) -> Option<Rest<'a>> {
    for slot in row {
        let (value, taken) = short_integer(rest);
        if taken == 0 || value as usize >= limit {
            return None;
        }
        *slot = value;
        rest = rest.get(taken..)?;
    }
    Some(rest)
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
    match short_integer(rest) {
        (value, taken @ 1..) => Ok((&rest[taken..], value as i32)),
        _ => integer_slow(skip_space(rest)),
    }
}

#[cold]
fn integer_slow(start: Rest<'_>) -> Parsed<'_, i32> {
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
    match short_integer(rest) {
        (value, taken @ 1..) if (value as usize) < limit => Ok((&rest[taken..], value)),
        _ => index_slow(skip_space(rest), limit, what),
    }
}

#[cold]
fn index_slow<'a>(start: Rest<'a>, limit: usize, what: &str) -> Parsed<'a, u32> {
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
