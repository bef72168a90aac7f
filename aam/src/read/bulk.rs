//! Lists of numbers: text rows or little-endian binary. Here is where a reader's time goes.

use super::context::Context;
use super::fault::{Fault, Parsed, Rest};
use super::number::{index, integer, is_space, real, short_indices, short_row, short_triangle, skip_space, text_start};
use super::tags::{fits, not_finite};
use crate::document::{Group, TexCounts, Triangle};

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
    mut rest: Rest<'a>,
    n: usize,
    what: &str,
) -> Parsed<'a, Vec<[f32; N]>> {
    // A number takes a byte and the blank before it another.
    fits(at, rest, n, 2 * N, what)?;
    let mut rows = Vec::with_capacity(n);
    for _ in 0..n {
        if let Some((row, end)) = short_row(rest, 0) {
            rows.push(row);
            rest = &rest[end..];
            continue;
        }
        let mut row = [0.0; N];
        for value in &mut row {
            let (tail, number) = real(rest)?;
            if !number.is_finite() {
                not_finite(cx, skip_space(rest), number)?;
            }
            *value = number;
            rest = tail;
        }
        rows.push(row);
    }
    Ok((rest, rows))
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
    let mut rows = Vec::with_capacity(n);
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

/// What is known of an object before its triangles are read.
#[derive(Clone, Copy)]
pub(crate) struct Limits {
    pub(crate) vertices: usize,
    pub(crate) tex_coords: usize,
    /// Present when the object has an `N_List`.
    pub(crate) normals: Option<usize>,
}

/// The triangles of an object, filled group after group.
#[derive(Default)]
pub(crate) struct TriangleLists {
    pub(crate) triangles: Vec<Triangle>,
    pub(crate) normal_indices: Vec<[u32; 3]>,
    pub(crate) tex_indices: Vec<[u32; 3]>,
    counts: Option<TexCounts>,
    pub(crate) groups: Vec<Group>,
}

impl TriangleLists {
    /// Reserves for a count that has been checked against the bytes left.
    pub(crate) fn reserve(&mut self, triangles: usize, normals: bool) {
        self.triangles.reserve_exact(triangles);
        if normals {
            self.normal_indices.reserve_exact(triangles);
        }
    }

    pub(crate) fn counts(&mut self) -> TexCounts {
        self.counts.take().unwrap_or_default()
    }

    fn note_count(&mut self, count: u8, total: usize) {
        let before = self.triangles.len() - 1;
        match &mut self.counts {
            None => {
                self.tex_indices.reserve_exact((total * usize::from(count)).saturating_sub(self.tex_indices.len()));
                self.counts = Some(TexCounts::Uniform(count));
            }
            Some(TexCounts::Uniform(uniform)) if *uniform == count => {}
            Some(TexCounts::Uniform(uniform)) => {
                let mut each = vec![*uniform; before];
                each.push(count);
                self.counts = Some(TexCounts::Each(each));
            }
            Some(TexCounts::Each(each)) => each.push(count),
        }
    }
}

/// The kinds of rows in a group, told by their first letters.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Row {
    Triangle,
    Normals,
    Textures,
    Other,
}

#[inline(always)]
fn row_kind(rest: Rest<'_>) -> (Row, Rest<'_>) {
    match rest {
        [b'I', b':', tail @ ..] => (Row::Triangle, tail),
        [b'T', b'I', b':', tail @ ..] => (Row::Textures, tail),
        [b'N', b'I', b':', tail @ ..] => (Row::Normals, tail),
        _ => (Row::Other, rest),
    }
}

/// Reads `tri*` up to what is no triangle. `total` is the object's count, which must not be passed.
pub(crate) fn triangles<'a>(
    cx: &Context<'a>,
    mut rest: Rest<'a>,
    limits: Limits,
    total: usize,
    lists: &mut TriangleLists,
) -> Parsed<'a, ()> {
    let binary = cx.binary.get();
    loop {
        if !binary && limits.normals.is_none() {
            rest = &rest[short_triangles(rest, limits, total, lists)..];
        }
        let start = skip_space(rest);
        let (kind, tail) = row_kind(start);
        if kind != Row::Triangle {
            return match kind {
                Row::Other => Ok((start, ())),
                _ => Fault::fatal(start, "syntax/tag-order", "expected `I:` before `TI:` and `NI:`"),
            };
        }
        if lists.triangles.len() == total {
            return Fault::fatal(
                start,
                "count/mismatch",
                format!("I_List says {total} triangles, but another one follows"),
            );
        }
        let (tail, corners) = corners(binary, tail, limits.vertices, "vertices (V_List)")?;
        let (tail, smoothing) = if binary { binary_integer(tail)? } else { integer(tail)? };
        lists.triangles.push(Triangle { vertices: corners, smoothing });
        rest = tail;
        if let Some(normals) = limits.normals {
            let start = skip_space(rest);
            let (kind, tail) = row_kind(start);
            if kind != Row::Normals {
                return Fault::fatal(
                    start,
                    "syntax/expected",
                    "expected `NI:`: an object with an N_List has one for every triangle",
                );
            }
            let (tail, indices) = self::corners(binary, tail, normals, "normals (N_List)")?;
            lists.normal_indices.push(indices);
            rest = tail;
        }
        let mut count = 0u8;
        loop {
            let start = skip_space(rest);
            let (kind, tail) = row_kind(start);
            if kind != Row::Textures {
                if kind == Row::Normals {
                    return Fault::fatal(
                        start,
                        "syntax/tag-order",
                        "`NI:` needs an N_List, and stands before any `TI:`",
                    );
                }
                break;
            }
            if count == 4 {
                return Fault::fatal(start, "geometry/layers", "a triangle has at most four `TI:`");
            }
            let (tail, indices) = self::corners(binary, tail, limits.tex_coords, "texture vertices (TV_List)")?;
            lists.tex_indices.push(indices);
            count += 1;
            rest = tail;
        }
        lists.note_count(count, total);
    }
}

/// Reads triangles without normals while they have the usual short form; gives where it stopped, always behind a whole
/// triangle. Whatever is left is read, or refused, by the general way.
fn short_triangles(bytes: &[u8], limits: Limits, total: usize, lists: &mut TriangleLists) -> usize {
    let mut at = 0;
    while lists.triangles.len() < total {
        let Some((vertices, smoothing, [first, last, end])) = short_triangle(bytes, at, limits.vertices) else {
            break;
        };
        let mut next = end;
        let mut count = 0;
        let before = lists.tex_indices.len();
        let complete = loop {
            let start = text_start(bytes, next);
            match bytes.get(start..start + 3) {
                Some(b"TI:") if count < 4 => {}
                Some(b"TI:" | b"NI:") => break false,
                _ => break true,
            }
            // Texture vertices often have the numbers of the vertices; then so have their texts.
            let same = start + 3 + (last - first);
            let indices = if bytes.get(start + 3..same) == bytes.get(first..last)
                && bytes.get(same).is_some_and(|&byte| is_space(byte))
                && vertices.iter().all(|&index| (index as usize) < limits.tex_coords)
            {
                Some((vertices, same))
            } else {
                short_indices(bytes, start + 3, limits.tex_coords)
            };
            let Some((indices, end)) = indices else {
                break false;
            };
            lists.tex_indices.push(indices);
            count += 1;
            next = end;
        };
        if !complete {
            lists.tex_indices.truncate(before);
            break;
        }
        lists.triangles.push(Triangle { vertices, smoothing });
        lists.note_count(count, total);
        at = next;
    }
    at
}

#[inline(always)]
fn corners<'a>(binary: bool, rest: Rest<'a>, limit: usize, what: &str) -> Parsed<'a, [u32; 3]> {
    if !binary && let Some((indices, end)) = short_indices(rest, 0, limit) {
        return Ok((&rest[end..], indices));
    }
    let mut indices = [0; 3];
    let mut rest = rest;
    if binary {
        rest = match rest {
            [b' ', tail @ ..] => tail,
            _ => return Fault::expected(rest, "a blank before binary indices"),
        };
    }
    for value in &mut indices {
        if binary {
            let (tail, number) = binary_integer(rest)?;
            *value = match u32::try_from(number) {
                Ok(number) if (number as usize) < limit => number,
                _ => {
                    return Fault::fatal(
                        rest,
                        "geometry/index",
                        format!("index {number} is outside the {limit} {what}"),
                    );
                }
            };
            rest = tail;
        } else {
            let (tail, number) = index(rest, limit, what)?;
            *value = number;
            rest = tail;
        }
    }
    Ok((rest, indices))
}

fn binary_integer(rest: Rest<'_>) -> Parsed<'_, i32> {
    match rest.split_first_chunk::<4>() {
        Some((bytes, tail)) => Ok((tail, i32::from_le_bytes(*bytes))),
        None => Fault::fatal(rest, "count/too-large", "the file ends inside a triangle"),
    }
}
