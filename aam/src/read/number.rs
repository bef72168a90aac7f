//! Numbers: the leaf parsers on which the speed of reading rests.
//!
//! Decimals give the nearest `f32` (ties to even) for every input, as the standard library does. Short decimals, which
//! is nearly all there are, take a short cut after Clinger (1990): the digits as an integer are exact in `f64`, their product
//! with a power of ten is off by an ulp or so, and rounding that to `f32` is right unless it lies next to a tie; those
//! and all longer decimals go to `fast-float2`.

use super::fault::{Fault, Parsed, Rest};

const PARTS: [f64; 8] = [1e0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7];

/// White space of any kind.
#[inline]
pub(crate) fn is_space(byte: u8) -> bool {
    const SPACES: u64 = 1 << b' ' | 1 << b'\t' | 1 << b'\n' | 1 << b'\r';
    byte <= b' ' && (SPACES >> byte) & 1 == 1
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

// The short forms below look at eight bytes as one little-endian word. Where the next number starts hangs on nothing but
// where this one ends, so that the processor can start on it while this one's value is still being made.

const EACH: u64 = 0x0101_0101_0101_0101;

/// How many of the bytes stand before the first that is a blank or another control character; at most eight.
#[inline(always)]
fn token_length(word: u64) -> u32 {
    (word.wrapping_sub(EACH * 0x21) & !word & (EACH * 0x80)).trailing_zeros() / 8
}

/// Marks with its top bit each byte of a word of distances from `0` that is no digit: adding 0x76 to a digit's distance
/// does not reach the top bit. Right up to the first mark, which is all that is used.
#[inline(always)]
fn other_than_digits(distances: u64) -> u64 {
    (distances.wrapping_add(EACH * 0x76) | distances) & (EACH * 0x80)
}

/// The number that eight digits make, given as distances from `0` (after Lemire, "Quickly parsing eight digits", 2018).
#[inline(always)]
fn join_digits(distances: u64) -> u64 {
    let pairs = (distances.wrapping_mul(10).wrapping_add(distances >> 8)) & 0x00ff_00ff_00ff_00ff;
    let fours = (pairs.wrapping_mul(100).wrapping_add(pairs >> 16)) & 0x0000_ffff_0000_ffff;
    fours.wrapping_mul(10_000).wrapping_add(fours >> 32) & 0xffff_ffff
}

/// The first `length` bytes moved up to the end of the word, zeros before them; `length` is 1 to 8.
#[inline(always)]
fn move_up(word: u64, length: u32) -> u64 {
    word << ((64 - 8 * length) & 63)
}

/// Where the text behind white space starts: nearly always just behind one blank or line end.
#[inline(always)]
pub(crate) fn text_start(bytes: &[u8], at: usize) -> usize {
    if let Some([blank, first]) = bytes.get(at..).and_then(|tail| tail.first_chunk::<2>())
        && is_space(*blank)
        && *first > b' '
    {
        return at + 1;
    }
    bytes.len() - skip_space(bytes.get(at..).unwrap_or_default()).len()
}

/// A whole number of one to seven digits with white space after it, after any white space: its value and where it ends,
/// or 0 where the number is anything else.
#[inline(always)]
fn short_integer(bytes: &[u8], at: usize) -> (u32, usize) {
    let start = text_start(bytes, at);
    let Some(chunk) = bytes.get(start..).and_then(|tail| tail.first_chunk::<8>()) else {
        return (0, 0);
    };
    let word = u64::from_le_bytes(*chunk);
    let length = token_length(word);
    if length.wrapping_sub(1) >= 7 {
        return (0, 0);
    }
    let digits = move_up(word ^ (EACH * u64::from(b'0')), length);
    if other_than_digits(digits) != 0 || !is_space((word >> (8 * length)) as u8) {
        return (0, 0);
    }
    (join_digits(digits) as u32, start + length as usize)
}

/// A decimal of at most eight characters, its sign aside, after any white space: its value and where it ends, or 0 where
/// the number is anything else.
#[inline(always)]
fn short_real(bytes: &[u8], at: usize) -> (f32, usize) {
    let start = text_start(bytes, at);
    let negative = bytes.get(start) == Some(&b'-');
    let from = start + usize::from(negative);
    let Some(window) = bytes.get(from..).and_then(|tail| tail.first_chunk::<9>()) else {
        return (0.0, 0);
    };
    let [low @ .., last] = window;
    let word = u64::from_le_bytes(*low);
    let length = token_length(word);
    let end = if length == 8 { *last } else { (word >> (8 * length)) as u8 };
    if length == 0 || !is_space(end) {
        return (0.0, 0);
    }
    // Blank what follows the token, then let the digits on both sides of the point close ranks.
    let mut digits = move_up(word ^ (EACH * u64::from(b'0')), length);
    let other = other_than_digits(digits);
    let mut scale = 0;
    if other != 0 {
        let point = other.trailing_zeros() / 8;
        let before = (1u64 << (8 * point)) - 1;
        let joined = (digits & before) << 8 | (digits & !before & !(0xff << (8 * point)));
        if (digits >> (8 * point)) as u8 != b'.' ^ b'0' || other_than_digits(joined) != 0 || length == 1 {
            return (0.0, 0);
        }
        scale = 7 - point;
        digits = joined;
    }
    // Off by at most an ulp and a half of f64: by half of one in the power of ten and in the product each.
    let value = join_digits(digits) as i64 as f64 * PARTS[(scale & 7) as usize];
    // The 29 bits that f32 drops. What lies within two ulps of a tie cannot be decided here. The smallest value but 0 is
    // 1e-7, so no f32 is subnormal.
    let dropped = value.to_bits() & 0x1fff_ffff;
    if dropped.wrapping_sub(0x0fff_fffe) <= 4 {
        return (0.0, 0);
    }
    let single = value as f32;
    (if negative { -single } else { single }, from + length as usize)
}

/// A real number, after any white space. Non-finite values in the spellings of C and of Microsoft's C are accepted.
#[inline]
pub(crate) fn real(rest: Rest<'_>) -> Parsed<'_, f32> {
    match short_real(rest, 0) {
        (value, end @ 1..) => Ok((&rest[end..], value)),
        _ => real_slow(skip_space(rest)),
    }
}

/// A row of reals of the usual short form, and where it ends; nothing where a number is of another form.
#[inline(always)]
pub(crate) fn short_row<const N: usize>(bytes: &[u8], mut at: usize) -> Option<([f32; N], usize)> {
    let mut row = [0.0; N];
    for slot in &mut row {
        (*slot, at) = short_real(bytes, at);
        if at == 0 {
            return None;
        }
    }
    Some((row, at))
}

/// Three short indices below a limit, and where they end; nothing where one is of another form.
#[inline(always)]
pub(crate) fn short_indices(bytes: &[u8], mut at: usize, limit: usize) -> Option<([u32; 3], usize)> {
    let mut row = [0; 3];
    for slot in &mut row {
        (*slot, at) = short_integer(bytes, at);
        if at == 0 || *slot as usize >= limit {
            return None;
        }
    }
    Some((row, at))
}

/// `I:` with three short indices below a limit and a short smoothing number, after any white space: the indices, the
/// number, where the indices start and end, and where the row ends; nothing where the row is of another form.
#[inline(always)]
pub(crate) fn short_triangle(bytes: &[u8], at: usize, limit: usize) -> Option<([u32; 3], i32, [usize; 3])> {
    let start = text_start(bytes, at);
    if bytes.get(start..start + 2) != Some(b"I:") {
        return None;
    }
    let (vertices, end) = short_indices(bytes, start + 2, limit)?;
    let (smoothing, row_end) = short_integer(bytes, end);
    (row_end > 0).then_some((vertices, smoothing as i32, [start + 2, end, row_end]))
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
    match short_integer(rest, 0) {
        (value, end @ 1..) => Ok((&rest[end..], value as i32)),
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
    match short_integer(rest, 0) {
        (value, end @ 1..) if (value as usize) < limit => Ok((&rest[end..], value)),
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
