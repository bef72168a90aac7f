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
        let kind = if source.filter.has_moments() { "texture_2d_array<f32>" } else { "texture_depth_2d_array" };
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
    let kernel = match filter {
        ShadowFilter::Pcf => format!(", KERNEL_{}", source.kernel.word().to_uppercase()),
        _ => String::new(),
    };
    let _ = writeln!(
        text,
        "\nvar<private> shadow_factor_{index}: f32 = 1.0;\n\n\
         fn shadow_in_view_{index}(v: u32, r: Receiver) -> f32 {{\n    \
         return shadow_{filter}(shadow_map_{index}, {index}u, v, r{kernel});\n}}\n\n\
         fn shadow_{index}(r: Receiver) -> f32 {{"
    );
    let body = match source.layout {
        // Mesa's lavapipe (22.3) crashes while it compiles some filters with a constant for the view.
        ShadowLayout::One => format!(
            "    return darkened({index}u, shadow_in_view_{index}(u32(shadow_sources[{index}].view_count) - 1u, r));"
        ),
        ShadowLayout::Cube => {
            format!("    return darkened({index}u, shadow_in_view_{index}(cube_face({index}u, r.position), r));")
        }
        ShadowLayout::Cascades => format!(
            "    let cascade = cascade_at({index}u, r.position);\n    \
             if (cascade.index >= u32(shadow_sources[{index}].view_count)) {{\n        return 1.0;\n    }}\n    \
             var lit = shadow_in_view_{index}(cascade.index, r);\n    \
             if (cascade.next > 0.0) {{\n        \
             lit = mix(lit, shadow_in_view_{index}(cascade.index + 1u, r), cascade.next);\n    }}\n    \
             return darkened({index}u, lit);"
        ),
    };
    let _ = writeln!(text, "{body}\n}}\n");
}
