// From light to a colour that can be shown: docs/techniques/shading.md, section 5.

// 0 clamp, 1 Reinhard, 2 ACES, 3 Neutral.
override TONE_MAP: u32 = 0u;

// S. Hill's fit of the reference rendering and output transforms of ACES.
fn aces(c: vec3f) -> vec3f {
    let from_srgb = mat3x3f(
        0.59719, 0.07600, 0.02840,
        0.35458, 0.90834, 0.13383,
        0.04823, 0.01566, 0.83777,
    );
    let to_srgb = mat3x3f(
        1.60475, -0.10208, -0.00327,
        -0.53108, 1.10813, -0.07276,
        -0.07367, -0.00605, 1.07602,
    );
    let v = from_srgb * c;
    return to_srgb * ((v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081));
}

// Khronos PBR Neutral.
fn neutral(light: vec3f) -> vec3f {
    let start = 0.76;
    let least = min(light.r, min(light.g, light.b));
    let c = light - select(0.04, least - 6.25 * least * least, least < 0.08);
    let peak = max(c.r, max(c.g, c.b));
    if (peak < start) {
        return c;
    }
    let room = 1.0 - start;
    let shown = 1.0 - room * room / (peak + room - start);
    let grey = 1.0 - 1.0 / (0.15 * (peak - shown) + 1.0);
    return mix(c * (shown / peak), vec3f(shown), grey);
}

// Light after exposure as a colour in [0, 1].
fn tone_mapped(light: vec3f) -> vec3f {
    // More than this is as bright as this.
    let c = clamp(light, vec3f(0.0), vec3f(65504.0));
    if (TONE_MAP == 1u) {
        return c / (1.0 + c);
    }
    if (TONE_MAP == 2u) {
        return saturate(aces(c));
    }
    if (TONE_MAP == 3u) {
        return saturate(neutral(c));
    }
    return saturate(c);
}
