//! `PHYSICS … ENDPHYSICS`. Always text, also in a BINARY file.

use nom::Parser;
use nom::combinator::{cut, opt};

use super::context::{Block, Context};
use super::fault::{Fault, Parsed, Rest};
use super::materials::counted;
use super::number::{count, index, integer, real, skip_space};
use super::tags::{block_tag, field, fits, line_end, not_finite, peek_word, reals, required, scalar, text, word};
use crate::Limit;
use crate::document::{Body, BodyMode, Convex, Physics, Primitive};

/// `physics = "PHYSICS" "NBody:" n n*body "ENDPHYSICS"`, and the offset of each `Body:`.
pub(crate) fn physics<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, (Physics, Vec<usize>)> {
    cx.binary.set(false);
    let block = Block::new(&["PHYSICS", "NBody:", "Body:", "ENDPHYSICS"]);
    let b = &block;
    let (rest, _) = cut(word("PHYSICS")).parse(rest)?;
    let (at, n) = counted(cx, b, "NBody:", rest)?;
    fits(rest, at, n, "Body:0 {Mode:Static SF:0 DF:0 Re:0}".len(), "bodies")?;
    let mut rest = at;
    let mut physics = Physics::default();
    let mut places = Vec::new();
    for _ in 0..n {
        let (tail, _) = required(b, "Body:", block_tag(cx, b, "Body:")).parse(rest)?;
        places.push(cx.offset(tail) - "Body:".len());
        let (tail, body) = body(cx, tail)?;
        physics.bodies.push(body);
        rest = tail;
    }
    let (rest, _) = required(b, "ENDPHYSICS", block_tag(cx, b, "ENDPHYSICS")).parse(rest)?;
    physics.unknown = block.into_unknown();
    Ok((rest, (physics, places)))
}

/// `body = "Body:" id name "{" "Mode:" mode "SF:" f "DF:" f "Re:" f [ "Ma:" f ] [ "NPrim:" p … ] [ "NConvex:" k … ]
/// "}"`, after its tag.
fn body<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, Body> {
    let (rest, object) = cut(integer).parse(rest)?;
    let (rest, name) = text(rest)?;
    let (rest, _) = cut(word("{")).parse(rest)?;
    let block = Block::new(&[
        "Mode:", "SF:", "DF:", "Re:", "Ma:", "NPrim:", "Box:", "Sphere:", "Capsule:", "NConvex:", "Convex:", "}",
    ]);
    let b = &block;
    let (rest, (mode, static_friction, dynamic_friction, restitution)) = (
        required(b, "Mode:", field(cx, b, "Mode:", mode)),
        required(b, "SF:", field(cx, b, "SF:", scalar(cx))),
        required(b, "DF:", field(cx, b, "DF:", scalar(cx))),
        required(b, "Re:", field(cx, b, "Re:", scalar(cx))),
    )
        .parse(rest)?;
    let (rest, mass) = opt(field(cx, b, "Ma:", scalar(cx))).parse(rest)?;
    let (rest, primitives) = opt(|r| primitives(cx, b, r)).parse(rest)?;
    let (rest, pieces) = opt(|r| pieces(cx, b, r)).parse(rest)?;
    let (rest, _) = required(b, "}", block_tag(cx, b, "}")).parse(rest)?;
    let body = Body {
        object,
        name,
        mode,
        static_friction,
        dynamic_friction,
        restitution,
        mass,
        primitives,
        pieces,
        unknown: block.into_unknown(),
    };
    Ok((rest, body))
}

fn mode(rest: Rest<'_>) -> Parsed<'_, BodyMode> {
    let start = skip_space(rest);
    let word = peek_word(start);
    let mode = match word {
        b"Static" => BodyMode::Static,
        b"Kinematic" => BodyMode::Kinematic,
        b"Dynamic" => BodyMode::Dynamic,
        _ => return Fault::expected(start, "`Static`, `Kinematic` or `Dynamic`"),
    };
    Ok((&start[word.len()..], mode))
}

/// `"NPrim:" p p*( "Box:" 10f | "Sphere:" 4f | "Capsule:" 7f )`
fn primitives<'a>(cx: &Context<'a>, b: &Block, rest: Rest<'a>) -> Parsed<'a, Vec<Primitive>> {
    let (at, n) = field(cx, b, "NPrim:", count).parse(rest)?;
    fits(rest, at, n, "Sphere:0 0 0 0".len(), "primitives")?;
    let mut rest = at;
    let mut primitives = Vec::new();
    for _ in 0..n {
        let shape = |tag| block_tag(cx, b, tag);
        let cuboid = (shape("Box:"), cut((reals(cx), reals(cx), reals(cx))))
            .map(|(_, (center, orientation, half))| Primitive::Box { center, orientation, half });
        let sphere = (shape("Sphere:"), cut((reals(cx), reals(cx))))
            .map(|(_, (center, [radius]))| Primitive::Sphere { center, radius });
        let capsule = (shape("Capsule:"), cut((reals(cx), reals(cx), reals(cx))))
            .map(|(_, (a, b, [radius]))| Primitive::Capsule { a, b, radius });
        let (tail, primitive) = match nom::branch::alt((cuboid, sphere, capsule)).parse(rest) {
            Err(nom::Err::Error(_)) => Fault::expected(skip_space(rest), "`Box:`, `Sphere:` or `Capsule:`").map_err(
                |fault: nom::Err<Fault>| match fault {
                    nom::Err::Error(fault) => nom::Err::Failure(fault),
                    other => other,
                },
            )?,
            other => other?,
        };
        let (tail, ()) = line_end(cx, tail)?;
        primitives.push(primitive);
        rest = tail;
    }
    Ok((rest, primitives))
}

/// `"NConvex:" k k*( "Convex:" i "{" "V_List:" … "I_List:" … "}" )`
fn pieces<'a>(cx: &Context<'a>, b: &Block, rest: Rest<'a>) -> Parsed<'a, Vec<Convex>> {
    let (at, n) = field(cx, b, "NConvex:", count).parse(rest)?;
    fits(rest, at, n, "Convex:0{V_List:0 I_List:0}".len(), "convex pieces")?;
    let mut rest = at;
    let mut pieces = Vec::new();
    for _ in 0..n {
        let (tail, _) = required(b, "Convex:", block_tag(cx, b, "Convex:")).parse(rest)?;
        let (tail, piece) = cut(|r| convex(cx, r)).parse(tail)?;
        pieces.push(piece);
        rest = tail;
    }
    Ok((rest, pieces))
}

fn convex<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, Convex> {
    let (rest, number) = integer(rest)?;
    let (rest, _) = word("{").parse(rest)?;
    let (at, _) = word("V_List:").parse(rest)?;
    let (mut rest, n) = count(at)?;
    fits(at, rest, n, "0 0 0 ".len(), "vertices")?;
    cx.grow(at, Limit::Vertices, "limit/vertices", n)?;
    let mut vertices = Vec::with_capacity(n);
    for _ in 0..n {
        let mut vertex = [0.0; 3];
        for value in &mut vertex {
            let (tail, number) = real(rest)?;
            if !number.is_finite() {
                not_finite(cx, skip_space(rest), number)?;
            }
            *value = number;
            rest = tail;
        }
        vertices.push(vertex);
    }
    let (at, _) = word("I_List:").parse(rest)?;
    let (mut rest, n) = count(at)?;
    fits(at, rest, n, "I:0 0 0".len(), "triangles")?;
    cx.grow(at, Limit::Triangles, "limit/triangles", n)?;
    let mut triangles = Vec::with_capacity(n);
    for _ in 0..n {
        let (mut tail, _) = word("I:").parse(rest)?;
        let mut corners = [0; 3];
        for corner in &mut corners {
            (tail, *corner) = index(tail, vertices.len(), "vertices (V_List) of the piece")?;
        }
        (rest, ()) = line_end(cx, tail)?;
        triangles.push(corners);
    }
    let (rest, _) = word("}").parse(rest)?;
    Ok((rest, Convex { number, vertices, triangles }))
}
