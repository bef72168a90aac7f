//! `MATERIALS … ENDMATERIALS`.

use nom::Parser;
use nom::combinator::{cut, opt};

use super::context::{Block, Context};
use super::fault::{Fault, Parsed, Rest};
use super::number::{count, integer, skip_space};
use super::tags::{
    block_tag, field, fits, line_end, one_word, peek_word, reals, required, scalar, text, word, yes_or_no,
};
use crate::Limit;
use crate::document::{Flagged, Layer, Material, MaterialBody, NormalSpace, Shading, SingleMaterial, Texture, Unknown};

/// What the section holds: materials, unknown text at its end, and the offset of each `Mat#`.
pub(crate) struct Materials {
    pub(crate) materials: Vec<Material>,
    pub(crate) unknown: Vec<Unknown>,
    pub(crate) places: Vec<usize>,
}

/// `materials = "MATERIALS" "MatCount:" n  n*( "Mat#" i "{" body "}" ) "ENDMATERIALS"`
pub(crate) fn materials<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, Materials> {
    let block = Block::new(&["MATERIALS", "MatCount:", "Mat#", "}", "ENDMATERIALS"]);
    let (rest, _) = cut(word("MATERIALS")).parse(rest)?;
    let (after_count, n) = counted(cx, &block, "MatCount:", rest)?;
    fits(rest, after_count, n, "Mat#0{}".len(), "materials")?;
    let mut rest = after_count;
    let mut materials = Vec::new();
    let mut places = Vec::new();
    for _ in 0..n {
        let mat = required(&block, "Mat#", block_tag(cx, &block, "Mat#")).parse(rest)?;
        places.push(cx.offset(mat.0) - "Mat#".len());
        let (tail, material) = numbered_material(cx, mat.0, 0)?;
        materials.push(material);
        rest = tail;
    }
    while peek_word(rest) == b"}" {
        cx.warn(skip_space(rest), "syntax/stray-brace", "a `}` without its `{` before ENDMATERIALS is skipped")?;
        rest = &skip_space(rest)[1..];
    }
    if peek_word(rest) == b"Mat#" {
        let text = format!("MatCount says {n}, but another material follows");
        return Fault::fatal(skip_space(rest), "count/mismatch", text);
    }
    let (rest, _) = required(&block, "ENDMATERIALS", block_tag(cx, &block, "ENDMATERIALS")).parse(rest)?;
    let unknown = block.into_unknown();
    Ok((rest, Materials { materials, unknown, places }))
}

/// A tag with a count.
pub(crate) fn counted<'a>(cx: &Context<'a>, block: &Block, tag: &'static str, rest: Rest<'a>) -> Parsed<'a, usize> {
    required(block, tag, field(cx, block, tag, count)).parse(rest)
}

/// The number after `Mat#` or `Sub`, and the block.
fn numbered_material<'a>(cx: &Context<'a>, at: Rest<'a>, depth: u64) -> Parsed<'a, Material> {
    let (rest, number) = cut(integer).parse(at)?;
    let (rest, ()) = line_end(cx, rest)?;
    cx.limit(at, Limit::Nesting, "limit/nesting", depth)?;
    let (rest, _) = cut(word("{")).parse(rest)?;
    let block = Block::new(&[
        "Name:", "Class:", "NSubs:", "Sub", "Am:", "Di:", "Sp:", "Tr:", "Sh:", "SI:", "WS:", "Tx:", "TS:", "TN:",
        "TD:", "AC:", "}",
    ]);
    let b = &block;
    let (rest, name) = required(b, "Name:", field(cx, b, "Name:", text)).parse(rest)?;
    let (rest, class) = required(b, "Class:", field(cx, b, "Class:", text)).parse(rest)?;
    let (rest, body) = if class == "Multi" {
        let (after, n) = counted(cx, b, "NSubs:", rest)?;
        fits(rest, after, n, "Sub0{}".len(), "sub-materials")?;
        let mut rest = after;
        let mut subs = Vec::new();
        for _ in 0..n {
            let (tail, _) = required(b, "Sub", block_tag(cx, b, "Sub")).parse(rest)?;
            let (tail, sub) = numbered_material(cx, tail, depth + 1)?;
            subs.push(sub);
            rest = tail;
        }
        (rest, MaterialBody::Multi(subs))
    } else {
        let (rest, single) = single(cx, b, rest)?;
        (rest, MaterialBody::Single(Box::new(SingleMaterial { class, ..single })))
    };
    let (rest, _) = required(b, "}", block_tag(cx, b, "}")).parse(rest)?;
    Ok((rest, Material { number, name, body, unknown: block.into_unknown() }))
}

/// `single = … "Am:" rgb "Di:" rgb "Sp:" rgb "Tr:" f "Sh:" f [ "SI:" rgb ] [ "WS:" f "Sh:" word ] "Tx:" … "TS:" …`,
/// and of this project `[ "TN:" … ] [ "TD:" … ] [ "AC:" f ]`.
fn single<'a>(cx: &Context<'a>, b: &Block, rest: Rest<'a>) -> Parsed<'a, SingleMaterial> {
    let (rest, (ambient, diffuse, specular, transparency, shininess)) = (
        required(b, "Am:", field(cx, b, "Am:", reals(cx))),
        required(b, "Di:", field(cx, b, "Di:", reals(cx))),
        required(b, "Sp:", field(cx, b, "Sp:", reals(cx))),
        required(b, "Tr:", field(cx, b, "Tr:", scalar(cx))),
        required(b, "Sh:", field(cx, b, "Sh:", scalar(cx))),
    )
        .parse(rest)?;
    let (rest, emission) = opt(field(cx, b, "SI:", reals(cx))).parse(rest)?;
    let shading = (field(cx, b, "WS:", scalar(cx)), required(b, "Sh:", field(cx, b, "Sh:", one_word)));
    let (rest, shading) = opt(shading.map(|(wire_size, word)| Shading { wire_size, word })).parse(rest)?;
    let mut layers = [const { Flagged::Omitted }; 4];
    let mut rest = rest;
    for layer in Layer::ALL {
        let tag = layer.tag();
        let (mut tail, mut read) = match layer {
            Layer::Diffuse | Layer::LightMap => {
                required(b, tag, |r| texture_layer(cx, b, tag, r)).map(Some).parse(rest)?
            }
            Layer::Normal | Layer::Displacement => opt(|r| texture_layer(cx, b, tag, r)).parse(rest)?,
        };
        while let (true, Some(_)) = (peek_word(tail) == tag.as_bytes(), &read) {
            cx.warn(skip_space(tail), "syntax/repeated-tag", format!("`{tag}` stands twice; the last one counts"))?;
            (tail, read) = texture_layer(cx, b, tag, tail).map(|(tail, again)| (tail, Some(again)))?;
        }
        layers[layer as usize] = read.unwrap_or_default();
        rest = tail;
    }
    let (rest, alpha_cutoff) = opt(field(cx, b, "AC:", scalar(cx))).parse(rest)?;
    let material = SingleMaterial {
        class: Default::default(),
        ambient,
        diffuse,
        specular,
        transparency,
        shininess,
        emission,
        shading,
        layers,
        alpha_cutoff,
    };
    Ok((rest, material))
}

/// `"Tx:" ( "N" | "Y" tex )`
fn texture_layer<'a>(
    cx: &Context<'a>,
    block: &Block,
    tag: &'static str,
    rest: Rest<'a>,
) -> Parsed<'a, Flagged<Box<Texture>>> {
    let (rest, yes) = field(cx, block, tag, yes_or_no).parse(rest)?;
    if !yes {
        return Ok((rest, Flagged::No));
    }
    let (rest, texture) = texture(cx, tag, rest)?;
    Ok((rest, Flagged::Yes(Box::new(texture))))
}

/// `tex = "{" "FN:" file "Fi:" word [ "Ch:" int ] "In:" f "UA:" f … "VT:" f [ "NS:" space ] "}"`
fn texture<'a>(cx: &Context<'a>, layer: &'static str, rest: Rest<'a>) -> Parsed<'a, Texture> {
    let (rest, _) = cut(word("{")).parse(rest)?;
    let block = Block::new(&["FN:", "Fi:", "Ch:", "In:", "UA:", "VA:", "WA:", "UO:", "VO:", "UT:", "VT:", "NS:", "}"]);
    let b = &block;
    let number = |tag| required(b, tag, field(cx, b, tag, scalar(cx)));
    let (rest, (file, filter, channel, intensity)) = (
        required(b, "FN:", field(cx, b, "FN:", text)),
        required(b, "Fi:", field(cx, b, "Fi:", one_word)),
        opt(field(cx, b, "Ch:", integer)),
        number("In:"),
    )
        .parse(rest)?;
    let (rest, (ua, va, wa, uo, vo, ut, vt)) =
        (number("UA:"), number("VA:"), number("WA:"), number("UO:"), number("VO:"), number("UT:"), number("VT:"))
            .parse(rest)?;
    let (rest, normal_space) =
        if layer == Layer::Normal.tag() { opt(field(cx, b, "NS:", normal_space)).parse(rest)? } else { (rest, None) };
    let (rest, _) = required(b, "}", block_tag(cx, b, "}")).parse(rest)?;
    let texture = Texture {
        file,
        filter,
        channel,
        intensity,
        rotation: [ua, va, wa],
        offset: [uo, vo],
        tiling: [ut, vt],
        normal_space,
        unknown: block.into_unknown(),
    };
    Ok((rest, texture))
}

fn normal_space(rest: Rest<'_>) -> Parsed<'_, NormalSpace> {
    let start = skip_space(rest);
    let word = peek_word(start);
    let space = match word {
        b"OBJECT" => NormalSpace::Object,
        b"TANGENT" => NormalSpace::Tangent,
        _ => return Fault::expected(start, "`OBJECT` or `TANGENT`"),
    };
    Ok((&start[word.len()..], space))
}
