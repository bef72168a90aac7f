//! The triangles of an object.

use wide::i32x4;

use super::ahead::{self, Target};
use super::context::Context;
use super::fault::{Fault, Parsed, Rest};
use super::number::{index, integer, skip_space};
use super::short::{Row as ShortRow, below, text_start};
use crate::document::{Faces, Group, TexCounts, Triangle};
use crate::large_pages::in_large_pages;

/// What is known of an object before its triangles are read.
#[derive(Clone, Copy)]
pub(crate) struct Limits {
    pub(crate) vertices: usize,
    pub(crate) tex_coords: usize,
    /// Present when the object has an `N_List`.
    pub(crate) normals: Option<usize>,
}

/// The triangles of an object, filled group after group.
pub(crate) struct TriangleLists {
    /// The three vertices and the smoothing number; as long as the object's count says, zeros behind what has been read.
    corners: Vec<[u32; 4]>,
    /// As long as `corners` where the object has normals, else empty.
    normal_indices: Vec<[u32; 3]>,
    /// Zeros behind what has been read.
    tex_indices: Vec<[u32; 3]>,
    counts: Option<TexCounts>,
    read: usize,
    tex_read: usize,
    pub(crate) groups: Vec<Group>,
}

impl TriangleLists {
    /// Lists for a count that has been checked against the bytes left. Their memory is not touched before it is filled.
    pub(crate) fn new(triangles: usize, normals: bool) -> Self {
        Self {
            corners: in_large_pages(vec![[0; 4]; triangles]),
            normal_indices: in_large_pages(vec![[0; 3]; if normals { triangles } else { 0 }]),
            tex_indices: Vec::new(),
            counts: None,
            read: 0,
            tex_read: 0,
            groups: Vec::new(),
        }
    }

    /// How many triangles have been read.
    pub(crate) fn len(&self) -> usize {
        self.read
    }

    /// The finished lists.
    pub(crate) fn into_faces(mut self, tex_coords: Vec<[f32; 2]>, normals: Option<Vec<[f32; 3]>>) -> Faces {
        self.tex_indices.truncate(self.tex_read);
        let triangle = |[a, b, c, smoothing]: [u32; 4]| Triangle { vertices: [a, b, c], smoothing: smoothing as i32 };
        Faces {
            tex_coords,
            normals,
            // Both have the same size and place, so that this neither allocates nor copies.
            triangles: self.corners.into_iter().map(triangle).collect(),
            normal_indices: self.normal_indices,
            tex_indices: self.tex_indices,
            tex_counts: self.counts.unwrap_or_default(),
            groups: self.groups,
        }
    }

    fn push_texture(&mut self, indices: [u32; 3]) {
        match self.tex_indices.get_mut(self.tex_read) {
            Some(slot) => *slot = indices,
            None => self.tex_indices.push(indices),
        }
        self.tex_read += 1;
    }

    /// Notes that triangles with a number of `TI:` each have been read.
    fn note(&mut self, triangles: usize, layers: u8) {
        match &mut self.counts {
            None => self.counts = Some(TexCounts::Uniform(layers)),
            Some(TexCounts::Uniform(uniform)) if *uniform == layers || triangles == 0 => {}
            Some(TexCounts::Uniform(uniform)) => {
                let mut each = vec![*uniform; self.read];
                each.resize(self.read + triangles, layers);
                self.counts = Some(TexCounts::Each(each));
            }
            Some(TexCounts::Each(each)) => each.resize(self.read + triangles, layers),
        }
        self.read += triangles;
    }

    /// Makes room for as many `TI:` as the triangles to come have if each has so many, and as the bytes left can hold.
    fn make_room(&mut self, layers: u8, bytes_left: usize) {
        let more = (self.corners.len() - self.read) * usize::from(layers);
        let length = self.tex_read + more.min(bytes_left / "TI:0 0 0".len());
        if self.tex_indices.len() < length {
            let mut longer = in_large_pages(vec![[0; 3]; length]);
            longer[..self.tex_read].copy_from_slice(&self.tex_indices[..self.tex_read]);
            self.tex_indices = longer;
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

/// Reads `tri*` up to what is no triangle.
pub(crate) fn triangles<'a>(
    cx: &Context<'a>,
    mut rest: Rest<'a>,
    limits: Limits,
    lists: &mut TriangleLists,
) -> Parsed<'a, ()> {
    let binary = cx.binary.get();
    // The number of `TI:` of the triangle before, once there is one in this group.
    let mut layers = None;
    loop {
        if let Some(layers) = layers
            && !binary
        {
            rest = like_the_last(cx, rest, limits, layers, lists);
        }
        let start = skip_space(rest);
        let (kind, tail) = row_kind(start);
        if kind != Row::Triangle {
            return match kind {
                Row::Other => Ok((start, ())),
                _ => Fault::fatal(start, "syntax/tag-order", "expected `I:` before `TI:` and `NI:`"),
            };
        }
        let total = lists.corners.len();
        if lists.read == total {
            return Fault::fatal(
                start,
                "count/mismatch",
                format!("I_List says {total} triangles, but another one follows"),
            );
        }
        let (tail, [a, b, c]) = corners(binary, tail, limits.vertices, "vertices (V_List)")?;
        let (tail, smoothing) = if binary { binary_integer(tail)? } else { integer(tail)? };
        lists.corners[lists.read] = [a, b, c, smoothing as u32];
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
            let (tail, indices) = corners(binary, tail, normals, "normals (N_List)")?;
            lists.normal_indices[lists.read] = indices;
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
            let (tail, indices) = corners(binary, tail, limits.tex_coords, "texture vertices (TV_List)")?;
            lists.push_texture(indices);
            count += 1;
            rest = tail;
        }
        lists.note(1, count);
        if layers != Some(count) {
            lists.make_room(count, rest.len());
            layers = Some(count);
        }
    }
}

/// Reads triangles with the rows of the one before while these have the usual short form.
fn like_the_last<'a>(
    cx: &Context<'a>,
    rest: Rest<'a>,
    limits: Limits,
    layers: u8,
    lists: &mut TriangleLists,
) -> Rest<'a> {
    let each = usize::from(layers);
    let room = (lists.corners.len() - lists.read)
        .min((lists.tex_indices.len() - lists.tex_read).checked_div(each).unwrap_or(usize::MAX));
    let normals = if limits.normals.is_some() { room } else { 0 };
    let target = TriangleRows {
        corners: &mut lists.corners[lists.read..][..room],
        normals: lists.normal_indices.get_mut(lists.read..).map_or(&mut [], |left| &mut left[..normals]),
        textures: &mut lists.tex_indices[lists.tex_read..][..room * each],
        layers: each,
        limits,
    };
    let (read, end) = ahead::fill(cx, cx.offset(rest), target, 1 + usize::from(limits.normals.is_some()) + each);
    lists.tex_read += read * each;
    lists.note(read, layers);
    &cx.bytes[end..]
}

/// Triangles that all have the same rows.
struct TriangleRows<'a> {
    corners: &'a mut [[u32; 4]],
    /// One for each triangle, or none at all.
    normals: &'a mut [[u32; 3]],
    /// So many for each triangle.
    textures: &'a mut [[u32; 3]],
    layers: usize,
    limits: Limits,
}

impl Target for TriangleRows<'_> {
    fn room(&self) -> usize {
        self.corners.len()
    }

    fn split(self, items: usize) -> (Self, Self) {
        let Self { corners, normals, textures, layers, limits } = self;
        let (corners, corners_behind) = corners.split_at_mut(items);
        let (normals, normals_behind) = normals.split_at_mut(if limits.normals.is_some() { items } else { 0 });
        let (textures, textures_behind) = textures.split_at_mut(items * layers);
        (
            Self { corners, normals, textures, layers, limits },
            Self { corners: corners_behind, normals: normals_behind, textures: textures_behind, layers, limits },
        )
    }

    fn fill(self, bytes: &[u8], at: usize) -> (usize, usize) {
        let Self { corners, normals, textures, layers, limits } = self;
        let mut end = at;
        let mut start = text_start(bytes, at);
        for (place, corners) in corners.iter_mut().enumerate() {
            let Some((row, triangle, mut behind)) = triangle_row(bytes, start, limits.vertices) else {
                return (place, end);
            };
            if let Some(limit) = limits.normals {
                let next = text_start(bytes, behind);
                let read =
                    ShortRow::open(bytes, next, b"NI: ").and_then(|other| index_row(other, row, triangle, limit));
                let (Some((indices, row_end)), Some(slot)) = (read, normals.get_mut(place)) else {
                    return (place, end);
                };
                *slot = indices;
                behind = row_end;
            }
            for layer in 0..layers {
                let next = text_start(bytes, behind);
                let read = ShortRow::open(bytes, next, b"TI: ")
                    .and_then(|other| index_row(other, row, triangle, limits.tex_coords));
                let (Some((indices, row_end)), Some(slot)) = (read, textures.get_mut(place * layers + layer)) else {
                    return (place, end);
                };
                *slot = indices;
                behind = row_end;
            }
            start = text_start(bytes, behind);
            // Another row of this triangle.
            if matches!(bytes.get(start), Some(b'N' | b'T')) {
                return (place, end);
            }
            *corners = bytemuck::cast(triangle.numbers);
            end = behind;
        }
        (corners.len(), end)
    }
}

/// The numbers of an `I:`, and where the third ends.
#[derive(Clone, Copy)]
struct ShortTriangle {
    numbers: i32x4,
    third_end: usize,
}

/// `I:` with its numbers, and where it ends.
#[inline(always)]
fn triangle_row(bytes: &[u8], at: usize, limit: usize) -> Option<(ShortRow<'_>, ShortTriangle, usize)> {
    let row = ShortRow::open(bytes, at, b"I: ")?;
    let (numbers, third_end, end) = match row.whole_numbers() {
        Some((numbers, [_, _, third, fourth])) => (numbers, third, row.place(fourth)),
        None => other_smoothing(bytes, row)?,
    };
    below(numbers, limit).then_some((row, ShortTriangle { numbers, third_end }, end))
}

/// The same where the smoothing number is negative or long.
#[inline(never)]
fn other_smoothing(bytes: &[u8], row: ShortRow<'_>) -> Option<(i32x4, usize, usize)> {
    let (numbers, [_, _, third]) = row.whole_numbers()?;
    let (tail, smoothing) = integer(&bytes[row.place(third)..]).ok()?;
    let [a, b, c, _] = numbers.to_array();
    Some((i32x4::new([a, b, c, smoothing]), third, bytes.len() - tail.len()))
}

/// `NI:` or `TI:` with its indices, and where it ends. Often it has the numbers of its `I:`; then so it has the text.
#[inline(always)]
fn index_row(
    row: ShortRow<'_>,
    first: ShortRow<'_>,
    triangle: ShortTriangle,
    limit: usize,
) -> Option<([u32; 3], usize)> {
    let (numbers, end) = if row.repeats(first, triangle.third_end) {
        (triangle.numbers, triangle.third_end)
    } else {
        let (numbers, [_, _, end]) = row.whole_numbers()?;
        (numbers, end)
    };
    let [a, b, c, _] = bytemuck::cast(numbers);
    below(numbers, limit).then_some(([a, b, c], row.place(end)))
}

fn corners<'a>(binary: bool, rest: Rest<'a>, limit: usize, what: &str) -> Parsed<'a, [u32; 3]> {
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
