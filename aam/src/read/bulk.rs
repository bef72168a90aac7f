//! Lists of reals: text rows or little-endian binary.

use super::ahead::{self, Target};
use super::context::Context;
use super::fault::{Fault, Parsed, Rest};
use super::number::{real, skip_space};
use super::short::{self, text_start};
use super::tags::{fits, not_finite};
use crate::large_pages::in_large_pages;

/// Rows of `N` reals after a list's tag and count.
pub(crate) fn rows<'a, const N: usize>(
    cx: &Context<'a>,
    at: Rest<'a>,
    rest: Rest<'a>,
    n: usize,
    what: &str,
) -> Parsed<'a, Vec<[f32; N]>> {
    if cx.binary.get() { binary_rows(cx, at, rest, n, what) } else { text_rows(cx, at, rest, n, what) }
}

fn text_rows<'a, const N: usize>(
    cx: &Context<'a>,
    at: Rest<'a>,
    rest: Rest<'a>,
    n: usize,
    what: &str,
) -> Parsed<'a, Vec<[f32; N]>> {
    // A number takes a byte and the blank before it another.
    fits(at, rest, n, 2 * N, what)?;
    let mut rows = in_large_pages(vec![[0.0; N]; n]);
    let mut left = rows.as_mut_slice();
    let mut end = cx.offset(rest);
    while !left.is_empty() {
        let (read, behind) = ahead::fill(cx, end, TextRows(&mut *left), 1);
        left = &mut left[read..];
        end = behind;
        let Some((row, others)) = left.split_first_mut() else { break };
        let mut rest = &cx.bytes[end..];
        for value in row {
            let (tail, number) = real(rest)?;
            if !number.is_finite() {
                not_finite(cx, skip_space(rest), number)?;
            }
            *value = number;
            rest = tail;
        }
        left = others;
        end = cx.offset(rest);
    }
    Ok((&cx.bytes[end..], rows))
}

/// Rows of finite reals.
struct TextRows<'a, const N: usize>(&'a mut [[f32; N]]);

impl<const N: usize> Target for TextRows<'_, N> {
    fn room(&self) -> usize {
        self.0.len()
    }

    fn split(self, items: usize) -> (Self, Self) {
        let (first, second) = self.0.split_at_mut(items);
        (Self(first), Self(second))
    }

    fn fill(self, bytes: &[u8], mut at: usize) -> (usize, usize) {
        for (place, row) in self.0.iter_mut().enumerate() {
            match row_of_reals(bytes, at) {
                Some((values, end)) => (*row, at) = (values, end),
                None => return (place, at),
            }
        }
        (self.0.len(), at)
    }
}

#[inline(always)]
fn row_of_reals<const N: usize>(bytes: &[u8], mut at: usize) -> Option<([f32; N], usize)> {
    let mut values = [0.0; N];
    for value in &mut values {
        let start = text_start(bytes, at);
        (*value, at) = match short::real(bytes, start) {
            Some(found) => found,
            None => other_real(bytes, start)?,
        };
    }
    Some((values, at))
}

#[inline(never)]
fn other_real(bytes: &[u8], at: usize) -> Option<(f32, usize)> {
    let (tail, value) = real(&bytes[at..]).ok()?;
    value.is_finite().then_some((value, bytes.len() - tail.len()))
}

fn binary_rows<'a, const N: usize>(
    cx: &Context<'a>,
    at: Rest<'a>,
    rest: Rest<'a>,
    n: usize,
    what: &str,
) -> Parsed<'a, Vec<[f32; N]>> {
    fits(at, rest, n, 4 * N, what)?;
    let Some((data, tail)) = rest.split_at_checked(4 * N * n) else {
        return Fault::fatal(rest, "count/too-large", format!("the file ends inside the {what}"));
    };
    let mut rows = in_large_pages(Vec::with_capacity(n));
    let mut finite = true;
    rows.extend(data.chunks_exact(4 * N).map(|row| {
        let mut values = [0.0; N];
        for (value, bytes) in values.iter_mut().zip(row.chunks_exact(4)) {
            *value = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            finite &= value.is_finite();
        }
        values
    }));
    if !finite {
        cx.warn(at, "value/not-finite", format!("the {what} hold values that are not finite"))?;
    }
    Ok((tail, rows))
}
