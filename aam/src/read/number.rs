//! Numbers of every form.
//!
//! Decimals give the nearest `f32` (ties to even) for every input, as the standard library does. Short decimals, which
//! is nearly all there are, take the short cut in [`super::short`], all others `fast-float2`.

use super::fault::{Fault, Parsed, Rest};
use super::short;

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

/// A real number, after any white space. Non-finite values in the spellings of C and of Microsoft's C are accepted.
#[inline]
pub(crate) fn real(rest: Rest<'_>) -> Parsed<'_, f32> {
    let start = skip_space(rest);
    match short::real(start, 0) {
        Some((value, end)) => Ok((&start[end..], value)),
        None => real_slow(start),
    }
}

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

    /// Read at the end of a file and amid its rows, where the short forms are read in another way.
    fn same(text: &str) {
        let expected: f32 = text.parse().expect(text);
        let amid = format!("{text}\n-99999999 99999999 99999999 99999999");
        for (bytes, left) in [(text.as_bytes(), 0), (amid.as_bytes(), amid.len() - text.len())] {
            let (rest, value) = real(bytes).expect(text);
            assert_eq!(rest.len(), left, "{text}");
            assert_eq!(value.to_bits(), expected.to_bits(), "{text}: {value} for {expected}");
        }
    }

    /// Numbers without end; the same at every run (Marsaglia, "Xorshift RNGs", 2003).
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> u64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            self.0
        }

        fn below(&mut self, limit: u64) -> u64 {
            self.next() % limit
        }

        fn digits(&mut self, count: u64) -> String {
            (0..count).map(|_| char::from(b'0' + self.below(10) as u8)).collect()
        }
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
            "9999999",
            "99999999",
            "16777217",
            "16777219",
            "8388608.5",
            "9007199254740993",
            "0.1",
            "0.30000001192092896",
            "9999999.9999999",
            "0.0000000000001",
            "-0.0000000000001",
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
            "1e99999999999999999999",
            "1e-99999999999999999999",
            "0e99999999999999999999",
        ] {
            same(text);
        }
    }

    #[test]
    fn random_decimals_are_the_nearest_f32() {
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        for _ in 0..400_000 {
            let sign = if random.below(2) == 0 { "" } else { "-" };
            let (whole, decimals) = (random.below(9), random.below(15));
            let text = format!("{sign}{}.{}", random.digits(whole), random.digits(decimals));
            if whole + decimals > 0 {
                same(&text);
            }
            if whole > 0 {
                same(text.trim_end_matches('0'));
            }
            let count = 1 + random.below(9);
            same(&random.digits(count));
            let (count, exponent) = (1 + random.below(20), random.below(100) as i64 - 60);
            same(&format!("{sign}{}e{exponent}", random.digits(count)));
            // Any f32, subnormals among them, in the shortest form, as 17 digits and rounded.
            let value = f32::from_bits(random.next() as u32);
            if value.is_finite() {
                same(&format!("{value}"));
                same(&format!("{value:e}"));
                same(&format!("{value:.16e}"));
                same(&format!("{value:.6}"));
            }
        }
    }

    /// The middles between neighbouring `f32`, and the decimals closest to them on both sides.
    #[test]
    fn ties_are_the_nearest_f32() {
        let mut random = Random(0xd1b5_4a32_d192_ed03);
        for _ in 0..400_000 {
            let low = f32::from_bits(random.next() as u32 & 0x0fff_ffff | 0x3800_0000);
            let tie = (f64::from(low) + f64::from(low.next_up())) / 2.0;
            same(&format!("{tie}"));
            same(&format!("{tie:.12}"));
            same(&format!("{low:.4}"));
            same(&format!("{low:.10}"));
            same(&format!("{low}"));
        }
        // These middles have at most 14 characters, so that the short form meets them exactly.
        for _ in 0..400_000 {
            let exponent = 127 + 16 + random.below(7) as u32;
            let low = f32::from_bits(exponent << 23 | random.next() as u32 & 0x007f_ffff);
            let tie = (f64::from(low) + f64::from(low.next_up())) / 2.0;
            let text = format!("{tie}");
            assert!(text.len() <= 15 && (text.parse::<f64>() == Ok(tie)), "{text}");
            same(&text);
            same(&format!("-{text}"));
            same(&format!("{}", tie.next_up()));
            same(&format!("{}", tie.next_down()));
            same(&format!("{text}1"));
            let decimals = text.len() - text.find('.').expect(".5 and less") - 1;
            let below = tie - 10f64.powi(-(decimals as i32) - 1);
            same(&format!("{below:.*}", decimals + 1));
        }
    }

    #[test]
    fn four_hundred_digits_are_read_exactly() {
        let long = format!("{}.{}", "1".repeat(30), "7".repeat(370));
        same(&long);
        same(&format!("0.{}1", "0".repeat(399)));
        let mut random = Random(0xa076_1d64_78bd_642f);
        for _ in 0..20_000 {
            // The exact middle takes up to 150 digits; what decides comes behind them.
            let low = f32::from_bits(random.next() as u32 & 0x007f_ffff | (random.below(254) as u32 + 1) << 23);
            let tie = (f64::from(low) + f64::from(low.next_up())) / 2.0;
            let exact = format!("{tie:.200}");
            same(&exact);
            same(&format!("{exact}{}1", "0".repeat(150)));
        }
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
