// A caster as a shadow map sees it: its depth, or the moments of it.

#import frame
#import node
#if CUT
#import material
#endif

struct CasterView {
    // From eye-relative world coordinates to the map's clip space.
    clip: mat4x4f,
    axis: vec4f,
    // Eye-relative position of the source.
    origin: vec3f,
    // 1 if moments are of distance, 0 if of depth along the axis.
    radial: f32,
    near: f32,
    far: f32,
    exponent: f32,
    shift: f32,
}

@group(2) @binding(0) var<uniform> caster: CasterView;

struct VertexInput {
    @location(0) position: vec3f,
#if VERTEX_COLORS
    @location(3) color: vec4f,
#endif
#if BASE_UV
    @location(4) base_uv: vec2f,
#endif
}

struct Varyings {
    // Shadow volumes start at the same depth.
    @invariant @builtin(position) clip: vec4f,
#if MOMENTS
    @location(0) position: vec3f,
#endif
#if VERTEX_COLORS
    @location(3) alpha: f32,
#endif
#if BASE_UV
    @location(4) base_uv: vec2f,
#endif
}

@vertex
fn vertex(in: VertexInput, node: NodeInput) -> Varyings {
    var out: Varyings;
    let position = node_position(node, in.position);
    out.clip = caster.clip * vec4f(position, 1.0);
#if MOMENTS
    out.position = position;
#endif
#if VERTEX_COLORS
    out.alpha = in.color.a;
#endif
#if BASE_UV
    out.base_uv = vec2f(dot(material.base_u, vec3f(in.base_uv, 1.0)), dot(material.base_v, vec3f(in.base_uv, 1.0)));
#endif
    return out;
}

#if CUT
// Cut off by the material; what blends casts where it covers more than it lets through.
fn cut(in: Varyings) {
    var alpha = material.opacity;
#if BASE_MAP
    alpha *= textureSample(base_map, layer_sampler, in.base_uv).a;
#endif
#if VERTEX_COLORS
    alpha *= in.alpha;
#endif
#if BLEND
    if (alpha < max(material.alpha_cutoff, 0.5)) {
        discard;
    }
#else
    if (alpha < material.alpha_cutoff) {
        discard;
    }
#endif
}
#endif

#if MOMENTS
#import shadow_warp

@fragment
fn fragment(in: Varyings) -> @location(0) vec4f {
#if CUT
    cut(in);
#endif
    var depth = dot(caster.axis.xyz, in.position) + caster.axis.w;
    if (caster.radial > 0.0) {
        depth = distance(in.position, caster.origin);
    }
    return moments_of(saturate((depth - caster.near) / (caster.far - caster.near)), caster.exponent, caster.shift);
}
#elif CUT
@fragment
fn fragment(in: Varyings) {
    cut(in);
}
#endif
