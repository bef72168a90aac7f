// How much of its light each shadow source lets through: docs/techniques/shadows.md. The maps, `shadow_sources` and what
// each source needs are written by renderer/src/shadows/glue.rs.

// A map, or a layer of one, and what it sees.
struct ShadowView {
    // From eye-relative world coordinates to the map's clip space, depth 0 near, 1 far.
    clip: mat4x4f,
    // Depth along the view's axis is dot(axis.xyz, p) + axis.w.
    axis: vec4f,
    // Width of a texel in metres, of a perspective view at depth 1.
    texel: f32,
    near: f32,
    far: f32,
    // Texels from the middle of the kernel to its edge.
    radius: f32,
}

struct ShadowSource {
    views: array<ShadowView, 6>,
    // Eye-relative position; of a box the unit vector towards the source.
    origin: vec3f,
    // 1 if views are pyramids, 0 if they are boxes.
    perspective: f32,
    intensity: f32,
    bias: f32,
    slope_bias: f32,
    max_bias: f32,
    normal_offset: f32,
    receiver_plane: f32,
    // Values of a stored depth, less one; 0 if it is a float.
    levels: f32,
    // Texels along each side.
    texels: f32,
    exponent: f32,
    // Subtracted from depth before it is warped.
    shift: f32,
    min_variance: f32,
    bleed_reduction: f32,
    light_size: f32,
    samples: f32,
    // 1 if moments are of distance, 0 if of depth along the axis.
    radial: f32,
    view_count: f32,
    // Depth from the camera at which each cascade ends.
    ends: vec4f,
    // Share of a cascade in which it fades into the next.
    blend: f32,
    // Its place in the list. Functions find it by this number instead of a constant: Mesa's lavapipe (22.3) writes
    // beyond an array while it looks for branches on uniforms at constant places.
    number: f32,
}

#import shadow_bindings

// A point that is looked at.
struct Receiver {
    // Relative to the eye.
    position: vec3f,
    // Unit normal of its triangle, towards the eye.
    normal: vec3f,
    pixel: vec2f,
}

// Needs uniform control flow.
fn receiver_at(position: vec3f, pixel: vec2f) -> Receiver {
    let across = cross(dpdx(position), dpdy(position));
    let normal = across * inverseSqrt(max(dot(across, across), 1e-36));
    return Receiver(position, select(-normal, normal, dot(normal, position) <= 0.0), pixel);
}

fn towards_source(s: u32, position: vec3f) -> vec3f {
    if (shadow_sources[s].perspective > 0.0) {
        return unit(shadow_sources[s].origin - position);
    }
    return shadow_sources[s].origin;
}

fn axial_depth(s: u32, v: u32, position: vec3f) -> f32 {
    let axis = shadow_sources[s].views[v].axis;
    return dot(axis.xyz, position) + axis.w;
}

// Width of a texel at a depth.
fn texel_width(s: u32, v: u32, depth: f32) -> f32 {
    let texel = shadow_sources[s].views[v].texel;
    return select(texel, texel * depth, shadow_sources[s].perspective > 0.0);
}

struct Projected {
    // Texture coordinates and depth.
    uvz: vec3f,
    inside: bool,
}

fn projected(s: u32, v: u32, position: vec3f) -> Projected {
    let clip = shadow_sources[s].views[v].clip * vec4f(position, 1.0);
    if (clip.w <= 0.0) {
        return Projected(vec3f(0.0), false);
    }
    let ndc = clip.xyz / clip.w;
    let uvz = vec3f(0.5 * ndc.x + 0.5, 0.5 - 0.5 * ndc.y, ndc.z);
    let inside = all(uvz >= vec3f(0.0)) && all(uvz <= vec3f(1.0));
    return Projected(uvz, inside);
}

// The cascade at a depth from the camera, and how much of the next is in it.
struct Cascade {
    index: u32,
    next: f32,
}

fn cascade_at(s: u32, position: vec3f) -> Cascade {
    let depth = -dot(position, frame.backwards);
    let count = u32(shadow_sources[s].view_count);
    var begin = 0.0;
    for (var i = 0u; i < count; i++) {
        let end = shadow_sources[s].ends[i];
        if (depth <= end) {
            let fade = shadow_sources[s].blend * (end - begin);
            let next = select(saturate((depth - (end - fade)) / max(fade, 1e-20)), 0.0, fade <= 0.0 || i + 1u == count);
            return Cascade(i, next);
        }
        begin = end;
    }
    return Cascade(count, 0.0);
}

// The face of a cube that looks at a point.
fn cube_face(s: u32, position: vec3f) -> u32 {
    let d = position - shadow_sources[s].origin;
    let a = abs(d);
    if (a.x >= a.y && a.x >= a.z) {
        return select(1u, 0u, d.x > 0.0);
    }
    if (a.y >= a.z) {
        return select(3u, 2u, d.y > 0.0);
    }
    return select(5u, 4u, d.z > 0.0);
}

fn darkened(s: u32, lit: f32) -> f32 {
    let intensity = shadow_sources[s].intensity;
    return intensity * saturate(lit) + (1.0 - intensity);
}
