//! Numbers of the usual short form, read many bytes at once: nearly every row of a file consists of nothing else. What is
//! of another form gives nothing here and is left to [`super::number`].
//!
//! One comparison marks all bytes of a row that are no digits. Where the next number starts then hangs on nothing but these
//! marks, so that the processor can start on it while the values of this one are still being made.

use wide::{f64x2, i8x16, i16x8, i32x4, u16x8, u64x2};

use super::number::is_space;

/// How many bytes stand before the first number of a [`Row`], so that the eight bytes that end with a number can be loaded.
const LEAD: usize = 8;

/// What is kept of eight digits.
const DIGITS: u64 = 0x0f0f_0f0f_0f0f_0f0f;

/// Keeps the last 1 to 8 digits of a word.
const LAST: [u64; 8] = {
    let mut masks = [0; 8];
    let mut place = 0;
    while place < 8 {
        masks[place] = DIGITS << (56 - 8 * place);
        place += 1;
    }
    masks
};

/// Where the text behind white space starts: nearly always at once, or just behind one line end.
#[inline(always)]
pub(crate) fn text_start(bytes: &[u8], mut at: usize) -> usize {
    while let Some(&byte) = bytes.get(at)
        && is_space(byte)
    {
        at += 1;
    }
    at
}

#[inline(always)]
fn part<const N: usize, const ALL: usize>(bytes: &[u8; ALL], at: usize) -> &[u8; N] {
    bytes[at..].first_chunk().expect("the places are within the bytes")
}

#[inline(always)]
fn load(bytes: &[u8; 16]) -> i8x16 {
    bytemuck::cast(*bytes)
}

/// One bit for each byte that is no digit; the first byte has the lowest bit.
#[inline(always)]
fn other_than_digits(bytes: &[u8; 16]) -> u32 {
    const ZERO: i8 = i8::MIN.wrapping_sub(b'0' as i8);
    (load(bytes) + i8x16::splat(ZERO)).simd_gt(i8x16::splat(i8::MIN + 9)).to_bitmask()
}

/// The place of the lowest bit of several, and the bits without it; 31 where there is none.
#[inline(always)]
fn take_lowest(bits: u32) -> (usize, u32) {
    ((bits | 1 << 31).trailing_zeros() as usize, bits & bits.wrapping_sub(1))
}

/// Two numbers of at most eight digits, each digit as 0 to 9, as two groups of four digits each (after Lemire, "Quickly
/// parsing eight digits", 2018).
#[inline(always)]
fn join_fours(words: [u64; 2]) -> i32x4 {
    let digits: u16x8 = bytemuck::cast(u64x2::new(words));
    let pairs = (digits * u16x8::splat(10 << 8 | 1)) >> 8u32;
    pairs.cast_signed().dot(i16x8::new([100, 1, 100, 1, 100, 1, 100, 1]))
}

/// Four numbers of at most eight digits of their groups of four.
#[inline(always)]
fn join_eights(first: i32x4, second: i32x4) -> i32x4 {
    let fours = i16x8::from_i32x8_saturate(bytemuck::cast([first, second]));
    fours.dot(i16x8::new([10_000, 1, 10_000, 1, 10_000, 1, 10_000, 1]))
}

/// The text of a row of whole numbers behind its tag.
#[derive(Clone, Copy)]
pub(crate) struct Row<'a> {
    bytes: &'a [u8; LEAD + 40],
    start: usize,
}

impl<'a> Row<'a> {
    /// The row that starts at a place with a tag and a blank.
    #[inline(always)]
    pub(crate) fn open<const N: usize>(bytes: &'a [u8], at: usize, tag: &[u8; N]) -> Option<Self> {
        let bytes = bytes.get((at + N).checked_sub(LEAD)?..)?.first_chunk()?;
        (part(bytes, LEAD - N) == tag).then_some(Self { bytes, start: at + N })
    }

    /// Where something at an offset behind the tag stands.
    #[inline(always)]
    pub(crate) fn place(self, offset: usize) -> usize {
        self.start + offset
    }

    /// Up to four whole numbers of one to eight digits, one blank behind each: the numbers, and the offset where each ends. Of
    /// the four lanes the first `N` hold numbers.
    #[inline(always)]
    pub(crate) fn whole_numbers<const N: usize>(self) -> Option<(i32x4, [usize; N])> {
        let bytes = self.bytes;
        let mut others = other_than_digits(part(bytes, LEAD)) | other_than_digits(part(bytes, LEAD + 16)) << 16;
        let mut ends = [0; N];
        let mut words = [0; 4];
        let mut blanks = true;
        let mut lengths = 0;
        let mut start = 0;
        for (end, word) in ends.iter_mut().zip(&mut words) {
            (*end, others) = take_lowest(others);
            blanks &= is_space(bytes[LEAD + *end]);
            let further = end.wrapping_sub(start + 1);
            lengths |= further;
            *word = u64::from_le_bytes(*part(bytes, *end)) & LAST[further & 7];
            start = *end + 1;
        }
        if lengths > 7 || !blanks {
            return None;
        }
        let [a, b, c, d] = words;
        Some((join_eights(join_fours([a, b]), join_fours([c, d])), ends))
    }

    /// True when another row has the same text up to an offset of at most 31, and a blank there.
    #[inline(always)]
    pub(crate) fn repeats(self, other: Self, end: usize) -> bool {
        let same = |at: usize| load(part(self.bytes, at)).simd_eq(load(part(other.bytes, at))).to_bitmask();
        let same = same(LEAD) | same(LEAD + 16) << 16;
        let wanted = (1u32 << (end & 31)) - 1;
        same & wanted == wanted && is_space(self.bytes[LEAD + (end & 31)])
    }
}

/// True when the first three numbers are below a limit.
#[inline(always)]
pub(crate) fn below(numbers: i32x4, limit: usize) -> bool {
    let last = i32::try_from(limit).unwrap_or(i32::MAX) - 1;
    numbers.simd_gt(i32x4::splat(last)).to_bitmask() & 0b111 == 0
}

/// A decimal that starts right here, of at most 15 characters: its value, and where it ends.
#[inline(always)]
pub(crate) fn real(bytes: &[u8], at: usize) -> Option<(f32, usize)> {
    let window: &[u8; 32] = bytes.get(at..)?.first_chunk()?;
    let negative = usize::from(window[0] == b'-');
    // The sign is no digit either, but ends nothing.
    let others = other_than_digits(part(window, 0)) & !(negative as u32);
    let (point, others) = take_lowest(others);
    let (end, _) = take_lowest(others);
    let (point, end) = (point & 15, end & 15);
    let whole_digits = point.wrapping_sub(negative);
    if whole_digits.wrapping_sub(1) > 6 {
        return None;
    }
    let whole = u64::from_le_bytes(*part(window, negative)) << (64 - 8 * whole_digits);
    if window[point] != b'.' {
        let fours = join_fours([whole & DIGITS, 0]);
        let [value, ..] = join_eights(fours, fours).to_array();
        return is_space(window[point]).then_some((with_sign(value as f32, negative), at + point));
    }
    let decimals = end.wrapping_sub(point + 1);
    if decimals.wrapping_sub(1) > 12 || !is_space(window[end]) {
        return None;
    }
    let first = &|at: usize, digits: usize| u64::from_le_bytes(*part(window, at)) & (!0 >> (64 - 8 * digits)) & DIGITS;
    // Digits that are not there count as zeros: the part behind the point is always made of eight.
    let fours = join_fours([whole & DIGITS, first(point + 1, decimals.min(8))]);
    let parts = f64x2::from_i32x4_lower2(join_eights(fours, fours)) * f64x2::new([1.0, 1e-8]);
    let [whole, part] = parts.to_array();
    let mut value = whole + part;
    if decimals > 8 {
        let fours = join_fours([first(point + 9, decimals - 8), 0]);
        let [further, ..] = join_eights(fours, fours).to_array();
        value += f64::from(further) * 1e-16;
    }
    Some((with_sign(nearest(value)?, negative), at + end))
}

/// The `f32` next to a decimal, given an `f64` less than three ulps away from it. Nothing where a middle between two `f32`
/// may lie between them.
///
/// So near is what `real` makes: the factor 1e-8, the product and the two sums are each off by 2⁻⁵³ of their value at most. Without
/// digits before the point the first sum is exact; with them, factor and product are at most half of the value.
#[inline(always)]
fn nearest(value: f64) -> Option<f32> {
    const MIDDLE: u64 = 1 << 28;
    // The 29 bits that f32 drops. No f32 here is subnormal: the smallest value but 0 is 1e-14.
    let dropped = value.to_bits() & (2 * MIDDLE - 1);
    (dropped.wrapping_sub(MIDDLE - 4) > 8).then_some(value as f32)
}

#[inline(always)]
fn with_sign(value: f32, negative: usize) -> f32 {
    f32::from_bits(value.to_bits() | (negative as u32) << 31)
}
