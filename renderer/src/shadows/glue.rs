//! The part of the shader that names a frame's shadow sources: their bindings, and what each does.

use std::fmt::Write as _;

use aam_scene::{PcfKernel, ShadowFilter, ShadowLayout};

use super::set::{ShadowSet, SourceKind};

/// The binding of a source's map in bind group 2.
pub(crate) const fn map_binding(source: usize) -> u32 {
    2 + source as u32
}

/// Declarations that `shadow.wgsl` imports: uniforms, sampler, maps.
pub(crate) fn bindings(set: &ShadowSet) -> String {
    let count = set.iter().count().max(1);
    let mut text = format!(
        "@group(2) @binding(0) var<uniform> shadow_sources: array<ShadowSource, {count}>;\n\
         @group(2) @binding(1) var shadow_sampler: sampler;\n"
    );
    for (number, kernel) in PcfKernel::ALL.iter().enumerate() {
        let _ = writeln!(text, "const KERNEL_{}: u32 = {number}u;", kernel.word().to_uppercase());
    }
    for (index, source) in set.iter().enumerate() {
        let kind = match source.filter {
            ShadowFilter::Volume => "texture_2d<f32>",
            filter if filter.has_moments() => "texture_2d_array<f32>",
            _ => "texture_depth_2d_array",
        };
        let _ = writeln!(text, "@group(2) @binding({}) var shadow_map_{index}: {kind};", map_binding(index));
    }
    text
}

/// One function for each source, and what the lights ask them.
pub(crate) fn sources(set: &ShadowSet) -> String {
    let mut text = String::new();
    if set.iter().any(|source| source.filter.compares()) {
        text.push_str("#import shadow_compare\n");
    }
    if set.iter().any(|source| source.filter.has_moments()) {
        text.push_str("#import shadow_moments\n");
    }
    if set.iter().any(|source| source.filter == ShadowFilter::Volume) {
        text.push_str("#import shadow_volume\n");
    }
    for (index, source) in set.iter().enumerate() {
        source_functions(&mut text, index, &source);
    }
    text.push_str("fn find_shadows(r: Receiver) {\n");
    for index in 0..set.iter().count() {
        let _ = writeln!(text, "    shadow_factor_{index} = shadow_{index}(r);");
    }
    text.push_str("}\n\n// What is left of a light, by its position in the list.\nfn unshadowed(light: u32) -> f32 {\n    var left = 1.0;\n");
    for (index, source) in set.iter().enumerate() {
        let _ = match source.light {
            None => writeln!(text, "    left *= shadow_factor_{index};"),
            Some(light) => {
                writeln!(text, "    if (light == {light}u) {{\n        left *= shadow_factor_{index};\n    }}")
            }
        };
    }
    text.push_str("    return left;\n}\n\n// The factor of one source.\nfn shadow_of(source: u32) -> f32 {\n");
    for index in 0..set.iter().count() {
        let _ = writeln!(text, "    if (source == {index}u) {{\n        return shadow_factor_{index};\n    }}");
    }
    text.push_str("    return 1.0;\n}\n");
    text
}

fn source_functions(text: &mut String, index: usize, source: &SourceKind) {
    let filter = source.filter;
    if filter == ShadowFilter::Volume {
        let _ = writeln!(
            text,
            "\nvar<private> shadow_factor_{index}: f32 = 1.0;\n\n\
             fn shadow_{index}(r: Receiver) -> f32 {{\n    \
             let s = u32(shadow_sources[{index}].number);\n    \
             return darkened(s, shadow_volume(shadow_map_{index}, s, r));\n}}\n"
        );
        return;
    }
    let kernel = match filter {
        ShadowFilter::Pcf => format!(", KERNEL_{}", source.kernel.word().to_uppercase()),
        _ => String::new(),
    };
    let _ = writeln!(
        text,
        "\nvar<private> shadow_factor_{index}: f32 = 1.0;\n\n\
         fn shadow_in_view_{index}(s: u32, v: u32, r: Receiver) -> f32 {{\n    \
         return shadow_{filter}(shadow_map_{index}, s, v, r{kernel});\n}}\n\n\
         fn shadow_{index}(r: Receiver) -> f32 {{\n    \
         let s = u32(shadow_sources[{index}].number);"
    );
    let body = match source.layout {
        ShadowLayout::One => format!("    return darkened(s, shadow_in_view_{index}(s, 0u, r));"),
        ShadowLayout::Cube => {
            format!("    return darkened(s, shadow_in_view_{index}(s, cube_face(s, r.position), r));")
        }
        ShadowLayout::Cascades => format!(
            "    let cascade = cascade_at(s, r.position);\n    \
             if (cascade.index >= u32(shadow_sources[s].view_count)) {{\n        return 1.0;\n    }}\n    \
             var lit = shadow_in_view_{index}(s, cascade.index, r);\n    \
             if (cascade.next > 0.0) {{\n        \
             lit = mix(lit, shadow_in_view_{index}(s, cascade.index + 1u, r), cascade.next);\n    }}\n    \
             return darkened(s, lit);"
        ),
    };
    let _ = writeln!(text, "{body}\n}}\n");
}
