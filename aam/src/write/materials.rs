//! `MATERIALS … ENDMATERIALS`.

use super::WriteError;
use super::out::{InPlace, Out};
use crate::Document;
use crate::document::{Flagged, Layer, Material, MaterialBody, NormalSpace, SingleMaterial, Texture};

pub(crate) fn materials(out: &mut Out, document: &Document) -> Result<(), WriteError> {
    out.line(0, "MATERIALS");
    let mut place = InPlace::new(&document.materials_unknown);
    place.before(out, 0, "MatCount:");
    out.count(0, "MatCount:", document.materials.len());
    for each in &document.materials {
        place.before(out, 0, "Mat#");
        material(out, 0, "Mat#", each);
    }
    place.end(out, 0);
    out.line(0, "ENDMATERIALS");
    Ok(())
}

fn material(out: &mut Out, depth: usize, tag: &str, material: &Material) {
    out.integer_field(depth, tag, i64::from(material.number));
    out.line(depth, "{");
    let mut place = InPlace::new(&material.unknown);
    let inner = depth + 1;
    place.before(out, inner, "Name:");
    out.text(inner, "Name:", &material.name);
    place.before(out, inner, "Class:");
    match &material.body {
        MaterialBody::Single(body) => single(out, inner, &mut place, body),
        MaterialBody::Multi(subs) => {
            out.line(inner, "Class: Multi");
            place.before(out, inner, "NSubs:");
            out.count(inner, "NSubs:", subs.len());
            for sub in subs {
                place.before(out, inner, "Sub");
                self::material(out, inner, "Sub", sub);
            }
        }
    }
    place.end(out, inner);
    out.line(depth, "}");
}

fn single(out: &mut Out, depth: usize, place: &mut InPlace<'_>, body: &SingleMaterial) {
    if body.class == "Multi" {
        out.refuse("material", "the class `Multi` belongs to materials with sub-materials");
    }
    out.text(depth, "Class:", &body.class);
    for (tag, rgb) in [("Am:", &body.ambient), ("Di:", &body.diffuse), ("Sp:", &body.specular)] {
        place.before(out, depth, tag);
        out.real_field(depth, tag, rgb);
    }
    for (tag, value) in [("Tr:", body.transparency), ("Sh:", body.shininess)] {
        place.before(out, depth, tag);
        out.real_field(depth, tag, &[value]);
    }
    if let Some(emission) = &body.emission {
        place.before(out, depth, "SI:");
        out.real_field(depth, "SI:", emission);
    }
    if let Some(shading) = &body.shading {
        place.before(out, depth, "WS:");
        out.real_field(depth, "WS:", &[shading.wire_size]);
        place.before(out, depth, "Sh:");
        out.word(depth, "Sh:", &shading.word);
    }
    for layer in Layer::ALL {
        let tag = layer.tag();
        match &body.layers[layer as usize] {
            Flagged::Omitted => {
                // `Tx:` and `TS:` stand in every file.
                if matches!(layer, Layer::Diffuse | Layer::LightMap) {
                    place.before(out, depth, tag);
                    out.indent(depth);
                    out.raw(tag.as_bytes());
                    out.raw(b" N");
                    out.end_line();
                }
            }
            Flagged::No => {
                place.before(out, depth, tag);
                out.indent(depth);
                out.raw(tag.as_bytes());
                out.raw(b" N");
                out.end_line();
            }
            Flagged::Yes(each) => {
                place.before(out, depth, tag);
                out.indent(depth);
                out.raw(tag.as_bytes());
                out.raw(b" Y");
                out.end_line();
                texture(out, depth, layer, each);
            }
        }
    }
    if let Some(cutoff) = body.alpha_cutoff {
        place.before(out, depth, "AC:");
        out.real_field(depth, "AC:", &[cutoff]);
    }
}

fn texture(out: &mut Out, depth: usize, layer: Layer, texture: &Texture) {
    out.line(depth, "{");
    let mut place = InPlace::new(&texture.unknown);
    let inner = depth + 1;
    place.before(out, inner, "FN:");
    out.text(inner, "FN:", &texture.file);
    place.before(out, inner, "Fi:");
    out.word(inner, "Fi:", &texture.filter);
    if let Some(channel) = texture.channel {
        place.before(out, inner, "Ch:");
        out.integer_field(inner, "Ch:", i64::from(channel));
    }
    let values = [
        ("In:", texture.intensity),
        ("UA:", texture.rotation[0]),
        ("VA:", texture.rotation[1]),
        ("WA:", texture.rotation[2]),
        ("UO:", texture.offset[0]),
        ("VO:", texture.offset[1]),
        ("UT:", texture.tiling[0]),
        ("VT:", texture.tiling[1]),
    ];
    for (tag, value) in values {
        place.before(out, inner, tag);
        out.real_field(inner, tag, &[value]);
    }
    if let Some(space) = texture.normal_space {
        if layer != Layer::Normal {
            out.refuse("texture", "only a normal map has a space (`NS:`)");
        }
        place.before(out, inner, "NS:");
        out.line(
            inner,
            match space {
                NormalSpace::Object => "NS: OBJECT",
                NormalSpace::Tangent => "NS: TANGENT",
            },
        );
    }
    place.end(out, inner);
    out.line(depth, "}");
}
