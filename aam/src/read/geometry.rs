//! `GEOMETRY … ENDGEOMETRY`.

use nom::Parser;
use nom::combinator::{cut, opt};

use super::animation::{TRACK_TAGS, tracks};
use super::bulk::rows;
use super::context::{Block, Context, found};
use super::fault::{Fault, Parsed, Rest};
use super::materials::counted;
use super::number::{count, index, integer, real, skip_space};
use super::tags::{
    block_tag, field, fits, line_end, peek_word, reals, required, scalar, text, word, yes_or_no, zero_or_one,
};
use super::triangles::{Limits, TriangleLists, triangles};
use crate::Limit;
use crate::document::{AnimationMode, Displacement, Flagged, Frame, Geometry, Group, NodeTransform, Object, Skin};

/// `geometry = "GEOMETRY" [ "SmGEnabled" ] "NObj:" n "NFrames:" m "Animation_mode:" mode [ "FPS:" f ] frame+
/// "ENDGEOMETRY"`, and the offset of each `Obj:`.
pub(crate) fn geometry<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, (Geometry, Vec<Vec<usize>>)> {
    let block = Block::new(&[
        "GEOMETRY",
        "SmGEnabled",
        "NObj:",
        "NFrames:",
        "Animation_mode:",
        "FPS:",
        "Frame:",
        "ENDGEOMETRY",
    ]);
    let b = &block;
    let (rest, _) = cut(word("GEOMETRY")).parse(rest)?;
    let (rest, smoothing) = opt(word("SmGEnabled")).parse(rest)?;
    let objects_at = rest;
    let (rest, objects) = counted(cx, b, "NObj:", rest)?;
    let frames_at = rest;
    let (rest, frame_count) = counted(cx, b, "NFrames:", rest)?;
    let (rest, animation) =
        required(b, "Animation_mode:", field(cx, b, "Animation_mode:", animation_mode)).parse(rest)?;
    let (rest, frames_per_second) = opt(field(cx, b, "FPS:", scalar(cx))).parse(rest)?;
    let Ok(animation_frames) = u32::try_from(frame_count) else {
        return Fault::fatal(frames_at, "count/too-large", format!("{frame_count} frames are more than {}", u32::MAX));
    };
    // The single frame block of a character says nothing about how many frames its keys span.
    let blocks = match animation {
        AnimationMode::Keyframe => 1.min(frame_count),
        _ => frame_count,
    };
    fits(frames_at, rest, blocks, "Frame:0{}".len(), "frames")?;
    cx.limit(frames_at, Limit::Frames, "limit/frames", blocks as u64)?;
    let mut rest = rest;
    let mut frames: Vec<Frame> = Vec::new();
    let mut places = Vec::new();
    for _ in 0..blocks {
        let (tail, _) = required(b, "Frame:", block_tag(cx, b, "Frame:")).parse(rest)?;
        let (tail, (frame, offsets)) = frame(cx, tail, (objects, objects_at), frames.first())?;
        frames.push(frame);
        places.push(offsets);
        rest = tail;
    }
    let (tail, ()) = missing_or_extra(cx, b, rest, frame_count)?;
    let geometry = Geometry {
        smoothing_groups: smoothing.is_some(),
        animation,
        frames_per_second,
        animation_frames,
        frames,
        unknown: block.into_unknown(),
    };
    Ok((tail, (geometry, places)))
}

fn missing_or_extra<'a>(cx: &Context<'a>, block: &Block, rest: Rest<'a>, frames: usize) -> Parsed<'a, ()> {
    match required(block, "ENDGEOMETRY", block_tag(cx, block, "ENDGEOMETRY")).parse(rest) {
        Err(_) if peek_word(rest) == b"Frame:" => Fault::fatal(
            skip_space(rest),
            "count/mismatch",
            format!("NFrames says {frames}, but another frame follows"),
        ),
        other => other.map(|(rest, _)| (rest, ())),
    }
}

fn animation_mode(rest: Rest<'_>) -> Parsed<'_, AnimationMode> {
    let start = skip_space(rest);
    let word = peek_word(start);
    let mode = match word {
        b"None" => AnimationMode::None,
        b"Full" => AnimationMode::Full,
        b"Keyframe" => AnimationMode::Keyframe,
        _ => return Fault::expected(start, "`None`, `Full` or `Keyframe`"),
    };
    Ok((&start[word.len()..], mode))
}

/// `frame = "Frame:" i "{" n*object "}"`, after its tag.
fn frame<'a>(
    cx: &Context<'a>,
    rest: Rest<'a>,
    (objects, objects_at): (usize, Rest<'a>),
    first: Option<&Frame>,
) -> Parsed<'a, (Frame, Vec<usize>)> {
    let block = Block::new(&["Obj:", "Par:", "{", "}"]);
    let b = &block;
    let (rest, number) = cut(integer).parse(rest)?;
    let (at, _) = cut(word("{")).parse(rest)?;
    fits(objects_at, at, objects, "Obj:0 Par:0{MatID:0}".len(), "objects")?;
    cx.grow(objects_at, Limit::Objects, "limit/objects", objects)?;
    let mut rest = at;
    let mut frame = Frame { number, ..Frame::default() };
    let mut places = Vec::new();
    for index in 0..objects {
        let (tail, _) = required(b, "Obj:", block_tag(cx, b, "Obj:")).parse(rest)?;
        places.push(cx.offset(tail) - "Obj:".len());
        let original = first.and_then(|first| first.objects.get(index));
        let (tail, object) = object(cx, b, tail, first.is_some().then_some(original).flatten())?;
        frame.objects.push(object);
        rest = tail;
    }
    let (rest, _) = match required(b, "}", block_tag(cx, b, "}")).parse(rest) {
        Err(_) if peek_word(rest) == b"Obj:" => Fault::fatal(
            skip_space(rest),
            "count/mismatch",
            format!("NObj says {objects}, but another object follows"),
        )?,
        other => other?,
    };
    frame.unknown = block.into_unknown();
    Ok((rest, (frame, places)))
}

/// `object = "Obj:" id name "Par:" parent "{" … "}"`, after its first tag. `original` is the same object in frame 0.
fn object<'a>(cx: &Context<'a>, frame_block: &Block, rest: Rest<'a>, original: Option<&Object>) -> Parsed<'a, Object> {
    let id_at = rest;
    let (rest, id) = cut(integer).parse(rest)?;
    let (rest, name) = text(rest)?;
    let (rest, parent) = required(frame_block, "Par:", field(cx, frame_block, "Par:", integer)).parse(rest)?;
    let (rest, _) = cut(word("{")).parse(rest)?;
    let tags = &[
        "Piv:",
        "Mir:",
        "TM:",
        "MatID:",
        "UserProp:",
        "TF:",
        "BI:",
        "SC:",
        "V_List:",
        "SKIN:",
        "C_List:",
        "TV_List:",
        "N_List:",
        "I_List:",
        "Anim_Ctrl:",
        "}",
    ];
    let block = Block::with_hints(tags, TRACK_TAGS);
    let b = &block;
    let (rest, node) = opt(|r| node_transform(cx, b, r)).parse(rest)?;
    let (rest, material) = required(b, "MatID:", field(cx, b, "MatID:", integer)).parse(rest)?;
    let (rest, user_properties) = opt(field(cx, b, "UserProp:", text)).parse(rest)?;
    let (rest, displacement) = opt(|r| displacement(cx, b, r)).parse(rest)?;
    let vertices_at = rest;
    let (rest, vertices) = required(b, "V_List:", |r| list(cx, b, "V_List:", "vertices", r)).parse(rest)?;
    let (rest, skin) = opt(|r| skin(cx, b, vertices.len(), r)).parse(rest)?;
    let colors_at = rest;
    let (rest, colors) = opt(|r| list(cx, b, "C_List:", "vertex colours", r)).parse(rest)?;
    let (rest, tex_coords) = opt(|r| list(cx, b, "TV_List:", "texture vertices", r)).parse(rest)?;
    let normals_at = rest;
    let (normals_end, normals) = opt(|r| list(cx, b, "N_List:", "normals", r)).parse(rest)?;
    if let Some(colors) = &colors
        && colors.len() != vertices.len()
    {
        return Fault::fatal(
            skip_space(colors_at),
            "count/mismatch",
            format!("C_List has {} colours for {} vertices", colors.len(), vertices.len()),
        );
    }
    let limits = Limits {
        vertices: vertices.len(),
        tex_coords: tex_coords.as_ref().map_or(0, Vec::len),
        normals: normals.as_ref().map(Vec::len),
    };
    let (rest, lists) = opt(|r| triangle_list(cx, b, limits, r)).parse(normals_end)?;
    let mut object = Object {
        id,
        name,
        parent,
        node,
        material,
        user_properties,
        displacement,
        vertices,
        skin: skin.unwrap_or_default(),
        colors,
        ..Object::default()
    };
    match lists {
        Some(lists) => {
            if tex_coords.is_none() {
                cx.warn(skip_space(normals_end), "syntax/missing-tag", "`TV_List:` is missing before `I_List:`")?;
            }
            object.faces = Some(lists.into_faces(tex_coords.unwrap_or_default(), normals));
        }
        None if tex_coords.is_some() => {
            let (rest, _) = required(b, "I_List:", word("I_List:")).parse(rest)?;
            return Fault::expected(rest, "`I_List:`");
        }
        None => object.frame_normals = normals,
    }
    if let Some(original) = original {
        matches_original(cx, [id_at, vertices_at, normals_at].map(skip_space), &object, original)?;
    }
    let rest = if peek_word(rest) == b"}" && peek_word(&skip_space(rest)[1..]) == b"Anim_Ctrl:" {
        cx.warn(skip_space(rest), "syntax/stray-brace", "a `}` without its `{` before Anim_Ctrl is skipped")?;
        &skip_space(rest)[1..]
    } else {
        rest
    };
    let (rest, keys) = opt(|r| tracks(cx, b, r)).parse(rest)?;
    object.keys = keys.unwrap_or_default();
    let (rest, _) = required(b, "}", block_tag(cx, b, "}")).parse(rest)?;
    object.unknown = block.into_unknown();
    Ok((rest, object))
}

/// A later frame must move the vertices of frame 0, no more and no fewer. The places are those of the id, the vertices
/// and the normals.
fn matches_original(
    cx: &Context<'_>,
    [id_at, vertices_at, normals_at]: [Rest<'_>; 3],
    object: &Object,
    original: &Object,
) -> Result<(), nom::Err<Fault>> {
    let same = |at, list, here, first| match here == first {
        true => Ok(()),
        false => Fault::fatal(
            at,
            "count/mismatch",
            format!("{list} of object {} says {here} here and {first} in the first frame", object.id),
        ),
    };
    same(vertices_at, "V_List", object.vertices.len(), original.vertices.len())?;
    if let Some(normals) = &object.frame_normals {
        let first = original.faces.as_ref().and_then(|faces| faces.normals.as_ref()).map_or(0, Vec::len);
        same(normals_at, "N_List", normals.len(), first)?;
    }
    if object.id != original.id {
        cx.warn(
            id_at,
            "animation/object-order",
            format!("object {} stands where the first frame has object {}", object.id, original.id),
        )?;
    }
    Ok(())
}

/// `"Piv:" 7f "Mir:" 0|1 "TM:" 15f`
fn node_transform<'a>(cx: &Context<'a>, b: &Block, rest: Rest<'a>) -> Parsed<'a, NodeTransform> {
    let (rest, pivot) = field(cx, b, "Piv:", reals::<7>(cx)).parse(rest)?;
    let (rest, mirrored) = required(b, "Mir:", field(cx, b, "Mir:", zero_or_one)).parse(rest)?;
    let (rest, tm) = required(b, "TM:", field(cx, b, "TM:", reals::<15>(cx))).parse(rest)?;
    let node = NodeTransform {
        pivot_position: [pivot[0], pivot[1], pivot[2]],
        pivot_orientation: [pivot[3], pivot[4], pivot[5], pivot[6]],
        mirrored,
        rotation: [[tm[0], tm[1], tm[2]], [tm[3], tm[4], tm[5]], [tm[6], tm[7], tm[8]]],
        position: [tm[9], tm[10], tm[11]],
        scale: [tm[12], tm[13], tm[14]],
    };
    Ok((rest, node))
}

/// `"TF:" int "BI:" f "SC:" f`
fn displacement<'a>(cx: &Context<'a>, b: &Block, rest: Rest<'a>) -> Parsed<'a, Displacement> {
    let (after, factor) = field(cx, b, "TF:", count).parse(rest)?;
    let (tail, (bias, scale)) =
        (required(b, "BI:", field(cx, b, "BI:", scalar(cx))), required(b, "SC:", field(cx, b, "SC:", scalar(cx))))
            .parse(after)?;
    match u32::try_from(factor) {
        Ok(tessellation) if tessellation >= 1 => Ok((tail, Displacement { tessellation, bias, scale })),
        _ => Fault::fatal(
            skip_space(rest),
            "geometry/tessellation",
            format!("the tessellation factor {factor} is not a whole number from 1 to {}", u32::MAX),
        ),
    }
}

/// A list's tag, count and rows.
fn list<'a, const N: usize>(
    cx: &Context<'a>,
    b: &Block,
    tag: &'static str,
    what: &str,
    rest: Rest<'a>,
) -> Parsed<'a, Vec<[f32; N]>> {
    let (at, _) = block_tag(cx, b, tag).parse(rest)?;
    let (rest, n) = cut(count).parse(at)?;
    // A count that the file cannot hold is refused as such.
    if tag == "V_List:" && n <= rest.len() {
        cx.grow(at, Limit::Vertices, "limit/vertices", n)?;
    }
    let rest = bulk_start(cx, rest, n)?;
    let (rest, rows) = cut(|rest| rows(cx, at, rest, n, what)).parse(rest)?;
    if !cx.binary.get() && real(rest).is_ok() {
        let message = format!("{} says {n} {what}, but more numbers follow", tag.trim_end_matches(':'));
        return Fault::fatal(skip_space(rest), "count/mismatch", message);
    }
    Ok((rest, rows))
}

/// Goes past the line end behind a list's count, after which binary data starts at once. Text rows may stand anywhere.
fn bulk_start<'a>(cx: &Context<'a>, rest: Rest<'a>, n: usize) -> Result<Rest<'a>, nom::Err<Fault>> {
    if !cx.binary.get() || n == 0 {
        return Ok(rest);
    }
    let mut at = rest;
    while let [b' ' | b'\t', tail @ ..] = at {
        at = tail;
    }
    match at {
        [b'\r', b'\n', tail @ ..] | [b'\n', tail @ ..] => Ok(tail),
        _ => Fault::fatal(at, "syntax/expected", "expected a line end (LF or CRLF) before binary data"),
    }
}

/// `"SKIN:" ( "N" | "Y" nv*( vertex count (bone weight)* ) )`
fn skin<'a>(cx: &Context<'a>, b: &Block, vertices: usize, rest: Rest<'a>) -> Parsed<'a, Flagged<Skin>> {
    let (at, yes) = field(cx, b, "SKIN:", yes_or_no).parse(rest)?;
    if !yes {
        return Ok((at, Flagged::No));
    }
    fits(rest, at, vertices, "0 0 ".len(), "skin rows")?;
    let mut rest = at;
    let mut skin = Skin { rows: Vec::with_capacity(vertices), weights: Vec::new() };
    for _ in 0..vertices {
        let (tail, vertex) = cut(|rest| index(rest, vertices, "vertices (V_List)")).parse(rest)?;
        let (tail, weights) = cut(count).parse(tail)?;
        fits(tail, tail, weights, "0 0 ".len(), "bone weights")?;
        rest = tail;
        for _ in 0..weights {
            let (tail, bone) = cut(integer).parse(rest)?;
            let (tail, weight) = cut(scalar(cx)).parse(tail)?;
            skin.weights.push((bone, weight));
            rest = tail;
        }
        skin.rows.push((vertex, u32::try_from(weights).unwrap_or(u32::MAX)));
    }
    Ok((rest, Flagged::Yes(skin)))
}

/// `"I_List:" triangles [ groups ]  groups*( "NEWGROUP:" id tri* "ENDGROUP" )`
fn triangle_list<'a>(cx: &Context<'a>, b: &Block, limits: Limits, rest: Rest<'a>) -> Parsed<'a, TriangleLists> {
    let (at, _) = block_tag(cx, b, "I_List:").parse(rest)?;
    let (rest, total) = cut(count).parse(at)?;
    let (line, groups_on_line) = {
        let (_, on_line) = super::tags::line(rest);
        if on_line.is_empty() { (rest, None) } else { cut(count).map(Some).parse(rest)? }
    };
    let (rest, ()) = line_end(cx, line)?;
    fits(at, rest, total, if cx.binary.get() { 19 } else { "I:0 0 0 0".len() }, "triangles")?;
    cx.grow(at, Limit::Triangles, "limit/triangles", total)?;
    let mut lists = TriangleLists::new(total, limits.normals.is_some());
    let declared = match groups_on_line {
        Some(groups) => {
            fits(at, rest, groups, "NEWGROUP:0 ENDGROUP".len(), "groups")?;
            Some(groups)
        }
        None if total == 0 => Some(0),
        None => {
            cx.warn(at, "syntax/missing-count", "I_List has no count of groups")?;
            None
        }
    };
    let mut rest = rest;
    let more = |lists: &TriangleLists| match declared {
        Some(groups) => lists.groups.len() < groups,
        None => lists.len() < total,
    };
    while more(&lists) {
        let (tail, _) = cut(word("NEWGROUP:")).parse(rest)?;
        let (tail, id) = cut(integer).parse(tail)?;
        let (tail, ()) = line_end(cx, tail)?;
        let before = lists.len();
        let (tail, ()) = cut(|r| triangles(cx, r, limits, &mut lists)).parse(tail)?;
        let (tail, _) = cut(word("ENDGROUP")).parse(tail)?;
        lists.groups.push(Group { id, triangles: lists.len() - before });
        rest = tail;
    }
    if lists.len() != total {
        return Fault::fatal(
            skip_space(rest),
            "count/mismatch",
            format!("I_List says {total} triangles, and {} follow before {}", lists.len(), found(rest)),
        );
    }
    Ok((rest, lists))
}
