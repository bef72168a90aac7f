// Prefiltered maps: one sample of the blurred moments bounds the light.

#import shadow

// Linear between texels.
fn moments_at(map: texture_2d_array<f32>, s: u32, v: u32, uv: vec2f) -> vec4f {
#if FILTERABLE
    return textureSampleLevel(map, shadow_sampler, uv, v, 0.0);
#else
    let size = shadow_sources[s].texels;
    let at = uv * size - 0.5;
    let base = vec2i(floor(at));
    let part = at - floor(at);
    let last = vec2i(i32(size) - 1);
    let low = clamp(base, vec2i(0), last);
    let high = clamp(base + 1, vec2i(0), last);
    let top = mix(textureLoad(map, low, v, 0), textureLoad(map, vec2i(high.x, low.y), v, 0), part.x);
    let bottom = mix(textureLoad(map, vec2i(low.x, high.y), v, 0), textureLoad(map, high, v, 0), part.x);
    return mix(top, bottom, part.y);
#endif
}

struct MomentReceiver {
    uv: vec2f,
    // In [0, 1] of the map's metric.
    depth: f32,
    inside: bool,
}

fn moment_receiver(s: u32, v: u32, r: Receiver) -> MomentReceiver {
    let at = projected(s, v, r.position);
    let near = shadow_sources[s].views[v].near;
    let far = shadow_sources[s].views[v].far;
    var depth = axial_depth(s, v, r.position);
    if (shadow_sources[s].radial > 0.0) {
        depth = distance(r.position, shadow_sources[s].origin);
    }
    return MomentReceiver(at.uvz.xy, (depth - near) / (far - near), at.inside && depth <= far);
}

// One-sided inequality of Chebyshev (Cantelli): at most this share of a distribution lies at or beyond `value`.
fn chebyshev(mean: f32, square: f32, value: f32, least: f32) -> f32 {
    let variance = max(square - mean * mean, least);
    let apart = value - mean;
    return select(variance / (variance + apart * apart), 1.0, value <= mean);
}

fn unbled(s: u32, lit: f32) -> f32 {
    let beta = shadow_sources[s].bleed_reduction;
    return saturate((lit - beta) / (1.0 - beta));
}

fn shadow_vsm(map: texture_2d_array<f32>, s: u32, v: u32, r: Receiver) -> f32 {
    let at = moment_receiver(s, v, r);
    if (!at.inside) {
        return 1.0;
    }
    let m = moments_at(map, s, v, at.uv);
    return unbled(s, chebyshev(m.x, m.y, at.depth, shadow_sources[s].min_variance));
}

fn shadow_esm(map: texture_2d_array<f32>, s: u32, v: u32, r: Receiver) -> f32 {
    let at = moment_receiver(s, v, r);
    if (!at.inside) {
        return 1.0;
    }
    let m = moments_at(map, s, v, at.uv).x;
    let warp = exp(-shadow_sources[s].exponent * (at.depth - shadow_sources[s].shift));
    return unbled(s, min(1.0, m * warp));
}

// The smallest variance of depth, as one of a warp with this value.
fn warped_variance(s: u32, warp: f32) -> f32 {
    let slope = shadow_sources[s].exponent * warp;
    return max(shadow_sources[s].min_variance * slope * slope, 1.2e-38);
}

fn shadow_evsm2(map: texture_2d_array<f32>, s: u32, v: u32, r: Receiver) -> f32 {
    let at = moment_receiver(s, v, r);
    if (!at.inside) {
        return 1.0;
    }
    let m = moments_at(map, s, v, at.uv);
    let positive = exp(shadow_sources[s].exponent * (at.depth - shadow_sources[s].shift));
    return unbled(s, chebyshev(m.x, m.y, positive, warped_variance(s, positive)));
}

fn shadow_evsm4(map: texture_2d_array<f32>, s: u32, v: u32, r: Receiver) -> f32 {
    let at = moment_receiver(s, v, r);
    if (!at.inside) {
        return 1.0;
    }
    let m = moments_at(map, s, v, at.uv);
    let k = shadow_sources[s].exponent * (at.depth - shadow_sources[s].shift);
    let positive = exp(k);
    let negative = -exp(-k);
    let by_positive = chebyshev(m.z, m.w, positive, warped_variance(s, positive));
    let by_negative = chebyshev(m.x, m.y, negative, warped_variance(s, negative));
    return unbled(s, min(by_positive, by_negative));
}

// Four moments bound the light sharply (Peters and Klein 2015, algorithm 3): the bound is met by a distribution on the
// receiver's depth and two more points, the roots of a quadratic.
fn shadow_msm(map: texture_2d_array<f32>, s: u32, v: u32, r: Receiver) -> f32 {
    let at = moment_receiver(s, v, r);
    if (!at.inside) {
        return 1.0;
    }
    // Mixed with a distribution that is half at 0 and half at 1, of variance 1/4, so that rounding leaves it one.
    let b = mix(moments_at(map, s, v, at.uv), vec4f(0.5), 4.0 * shadow_sources[s].min_variance);
    // Next to 1, where that distribution has a point, the roots fall together; a smaller depth is only lighter.
    let z = clamp(at.depth, 0.0, 0.9995);
    // Cholesky factors of the Hankel matrix of 1, b: rows (1), (b.x, d2), (b.y, l32, d3).
    let d2 = max(b.y - b.x * b.x, 1e-12);
    let l32d2 = b.z - b.x * b.y;
    let l32 = l32d2 / d2;
    let d3 = max(b.w - b.y * b.y - l32d2 * l32, 1e-14);
    var c1 = z - b.x;
    var c2 = z * z - b.y - l32 * c1;
    c1 /= d2;
    c2 /= d3;
    c1 -= l32 * c2;
    let c0 = 1.0 - c1 * b.x - c2 * b.y;
    // Roots of c2 x² + c1 x + c0; without curvature there is one, and the bound is Chebyshev's. No branches: Mesa's
    // lavapipe (22.3) crashes while it compiles them below the choice of a cube's face.
    let curved = abs(c2) >= 1e-9;
    let p = c1 / select(1.0, c2, curved);
    let q = c0 / select(1.0, c2, curved);
    let root = sqrt(max(0.25 * p * p - q, 0.0));
    let low = -0.5 * p - root;
    let high = -0.5 * p + root;
    let beyond = 1.0 - (low * high - b.x * (low + high) + b.y) / ((z - low) * (z - high));
    let between = (z * high - b.x * (z + high) + b.y) / ((high - low) * (z - low));
    let shadow = select(select(0.0, between, z > low), beyond, z > high);
    let lit = select(chebyshev(b.x, b.y, z, shadow_sources[s].min_variance), 1.0 - saturate(shadow), curved);
    return unbled(s, lit);
}
