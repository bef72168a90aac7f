//! `Anim_Ctrl:` and its keys.

use nom::Parser;
use nom::combinator::cut;

use super::context::{Block, Context};
use super::fault::{Fault, Parsed, Rest};
use super::number::{count, integer, skip_space};
use super::tags::{field, fits, peek_word, reals, yes_or_no};
use crate::document::{
    Flagged, PositionBezier, PositionSample, RotationBezier, RotationEuler, RotationSample, RotationTcb, ScaleBezier,
    ScaleSample, Track,
};

/// The tag of each kind of track.
pub(crate) const TRACK_TAGS: &[&str] =
    &["PsSam:", "RtSam:", "ScSam:", "PsBez:", "RtBez:", "ScBez:", "RtTcb:", "RtIPA:"];

/// `"Anim_Ctrl:" ( "N" | "Y" keys )`, keys being tracks of any kinds in any order.
pub(crate) fn tracks<'a>(cx: &Context<'a>, block: &Block, rest: Rest<'a>) -> Parsed<'a, Flagged<Vec<Track>>> {
    let (mut rest, yes) = field(cx, block, "Anim_Ctrl:", yes_or_no).parse(rest)?;
    if !yes {
        return Ok((rest, Flagged::No));
    }
    let mut tracks = Vec::new();
    while let Some((tail, track)) = track(cx, rest)? {
        tracks.push(track);
        rest = tail;
    }
    Ok((rest, Flagged::Yes(tracks)))
}

/// One track, if one starts here.
fn track<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Result<Option<(Rest<'a>, Track)>, nom::Err<Fault>> {
    let start = skip_space(rest);
    let tag = peek_word(start);
    let tail = &start[tag.len()..];
    let parsed = match tag {
        b"PsSam:" => keys(cx, tail, position_sample).map(|(rest, keys)| (rest, Track::PositionSampled(keys))),
        b"RtSam:" => keys(cx, tail, rotation_sample).map(|(rest, keys)| (rest, Track::RotationSampled(keys))),
        b"ScSam:" => keys(cx, tail, scale_sample).map(|(rest, keys)| (rest, Track::ScaleSampled(keys))),
        b"PsBez:" => keys(cx, tail, position_bezier).map(|(rest, keys)| (rest, Track::PositionBezier(keys))),
        b"RtBez:" => keys(cx, tail, rotation_bezier).map(|(rest, keys)| (rest, Track::RotationBezier(keys))),
        b"ScBez:" => keys(cx, tail, scale_bezier).map(|(rest, keys)| (rest, Track::ScaleBezier(keys))),
        b"RtTcb:" => keys(cx, tail, rotation_tcb).map(|(rest, keys)| (rest, Track::RotationTcb(keys))),
        b"RtIPA:" => keys(cx, tail, rotation_euler).map(|(rest, keys)| (rest, Track::RotationEuler(keys))),
        _ => return Ok(None),
    };
    parsed.map(Some)
}

/// A count and that many keys.
fn keys<'a, K>(
    cx: &Context<'a>,
    at: Rest<'a>,
    key: impl Fn(&Context<'a>, Rest<'a>) -> Parsed<'a, K>,
) -> Parsed<'a, Vec<K>> {
    let (mut rest, n) = cut(count).parse(at)?;
    fits(at, rest, n, "0 0 0 0 ".len(), "keys")?;
    let mut keys = Vec::new();
    for _ in 0..n {
        let (tail, key) = cut(|r| key(cx, r)).parse(rest)?;
        keys.push(key);
        rest = tail;
    }
    Ok((rest, keys))
}

fn position_sample<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, PositionSample> {
    (reals(cx), reals(cx)).map(|([frame], position)| PositionSample { frame, position }).parse(rest)
}

fn rotation_sample<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, RotationSample> {
    (reals(cx), reals(cx), reals(cx)).map(|([frame], axis, [angle])| RotationSample { frame, axis, angle }).parse(rest)
}

fn scale_sample<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, ScaleSample> {
    (reals(cx), reals(cx), reals(cx)).map(|([frame], axes, scale)| ScaleSample { frame, axes, scale }).parse(rest)
}

fn position_bezier<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, PositionBezier> {
    (reals(cx), reals(cx), reals(cx), reals(cx), integer)
        .map(|([frame], position, tangent_in, tangent_out, flag)| PositionBezier {
            frame,
            position,
            tangent_in,
            tangent_out,
            flag,
        })
        .parse(rest)
}

fn rotation_bezier<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, RotationBezier> {
    (reals(cx), reals(cx), reals(cx), reals(cx), integer)
        .map(|([frame], euler, tangent_in, tangent_out, flag)| RotationBezier {
            frame,
            euler,
            tangent_in,
            tangent_out,
            flag,
        })
        .parse(rest)
}

fn scale_bezier<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, ScaleBezier> {
    (reals(cx), reals(cx), reals(cx), reals(cx), reals(cx), integer)
        .map(|([frame], scale, axes, tangent_in, tangent_out, flag)| ScaleBezier {
            frame,
            scale,
            axes,
            tangent_in,
            tangent_out,
            flag,
        })
        .parse(rest)
}

fn rotation_tcb<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, RotationTcb> {
    (reals(cx), reals(cx), reals(cx), reals(cx))
        .map(|([frame], axis, [angle], [tension, continuity, bias, ease_in, ease_out])| RotationTcb {
            frame,
            axis,
            angle,
            tension,
            continuity,
            bias,
            ease_in,
            ease_out,
        })
        .parse(rest)
}

fn rotation_euler<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, RotationEuler> {
    (reals(cx), reals(cx)).map(|([frame], euler)| RotationEuler { frame, euler }).parse(rest)
}
