// A mesh subset: docs/techniques/shading.md. Which lines are in force depends on what the subset uses.

#import frame
#import node
#import color
#import material
#if SHADED
#import tone_map
#endif
#if LIT
#import phong
#endif
#if RELIEF
#import relief
#endif
#if ENVIRONMENT
#import environment
#endif
#if SHADOWS
#import shadow_functions
#endif
#if SHOW_SHADOW
// Position of the source in the shader's list.
override SHOWN_SOURCE: u32 = 0u;
#endif

struct VertexInput {
    @location(0) position: vec3f,
#if VERTEX_NORMALS
    @location(1) normal: vec3f,
#endif
#if TANGENTS
    @location(2) tangent: vec4f,
#endif
#if VERTEX_COLORS
    @location(3) color: vec4f,
#endif
#if BASE_UV
    @location(4) base_uv: vec2f,
#endif
#if SECOND_MAP
    @location(5) second_uv: vec2f,
#endif
#if RELIEF
    @location(6) relief_uv: vec2f,
#endif
}

struct Varyings {
    @builtin(position) clip: vec4f,
#if POSITION
    // Relative to the eye.
    @location(0) position: vec3f,
#endif
#if VERTEX_NORMALS
    // In the world; in the node's coordinates if a tangent-space map is added to it.
    @location(1) normal: vec3f,
#endif
#if TANGENTS
    @location(2) tangent: vec4f,
#endif
#if VERTEX_COLORS
    @location(3) color: vec4f,
#endif
#if BASE_UV
    @location(4) base_uv: vec2f,
#endif
#if SECOND_MAP
    @location(5) second_uv: vec2f,
#endif
#if NORMAL_MAP
    // The node's normal matrix by columns.
    @location(6) @interpolate(flat, either) normal_x: vec3f,
    @location(7) @interpolate(flat, either) normal_y: vec3f,
    @location(8) @interpolate(flat, either) normal_z: vec3f,
#endif
#if RECEIVERS
    @location(9) @interpolate(flat, either) receives: f32,
#endif
#if RELIEF
    // Coordinates of the displacement map, v = 0 at the bottom.
    @location(10) relief_uv: vec2f,
    // Metres for a length of one in the node's coordinates.
    @location(11) @interpolate(flat, either) relief_scale: f32,
#endif
}

@vertex
fn vertex(in: VertexInput, node: NodeInput) -> Varyings {
    var out: Varyings;
    let position = node_position(node, in.position);
    out.clip = frame.clip_from_relative * vec4f(position, 1.0);
#if POSITION
    out.position = position;
#endif
#if RELIEF
    out.relief_uv = vec2f(dot(relief.row_u, vec3f(in.relief_uv, 1.0)), dot(relief.row_v, vec3f(in.relief_uv, 1.0)));
    out.relief_scale = pow(abs(dot(node.row_x.xyz, cross(node.row_y.xyz, node.row_z.xyz))), 1.0 / 3.0);
#endif
#if RECEIVERS
    out.receives = node.receives;
#endif
#if VERTEX_NORMALS
#if TANGENTS
    out.normal = in.normal;
    out.tangent = in.tangent;
#else
    out.normal = node_normal(node, in.normal);
#endif
#endif
#if NORMAL_MAP
    out.normal_x = node.normal_x;
    out.normal_y = node.normal_y;
    out.normal_z = node.normal_z;
#endif
#if VERTEX_COLORS
#if DECODE_COLORS
    out.color = vec4f(srgb_decode(in.color.rgb), in.color.a);
#else
    out.color = in.color;
#endif
#endif
#if BASE_UV
    out.base_uv = vec2f(dot(material.base_u, vec3f(in.base_uv, 1.0)), dot(material.base_v, vec3f(in.base_uv, 1.0)));
#endif
#if SECOND_MAP
    out.second_uv = vec2f(dot(material.second_u, vec3f(in.second_uv, 1.0)), dot(material.second_v, vec3f(in.second_uv, 1.0)));
#endif
    return out;
}

#if RELIEF
// What the slope of the displacement map adds to the unit normal.
var<private> tilt: vec3f;
#endif

#if SHADING_NORMAL
// The unit shading normal, turned to the viewer's side.
fn shading_normal(in: Varyings, front: bool) -> vec3f {
#if NORMAL_MAP
    let texel = 2.0 * textureSample(second_map, layer_sampler, in.second_uv).xyz - 1.0;
#if TANGENTS
    let bitangent = in.tangent.w * cross(in.normal, in.tangent.xyz);
    let xy = material.normal_intensity * texel.xy;
    let n = xy.x * in.tangent.xyz + xy.y * bitangent + texel.z * in.normal;
#else
    let n = texel;
#endif
    let normal = n.x * in.normal_x + n.y * in.normal_y + n.z * in.normal_z;
#else
#if RELIEF
    let normal = unit(in.normal) + tilt;
#else
    let normal = in.normal;
#endif
#endif
    return normal * (inverseSqrt(max(dot(normal, normal), 1e-30)) * select(-1.0, 1.0, front));
}
#endif

@fragment
#if RELIEF
fn fragment(seen: Varyings, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    var in = seen;
    let found = find_relief(seen.position, seen.relief_uv, seen.relief_scale, front);
    tilt = found.tilt;
    in.position += found.offset;
#if BASE_UV
    in.base_uv += dpdx(seen.base_uv) * found.shift.x + dpdy(seen.base_uv) * found.shift.y;
#endif
#if SECOND_MAP
    in.second_uv += dpdx(seen.second_uv) * found.shift.x + dpdy(seen.second_uv) * found.shift.y;
#endif
#else
fn fragment(in: Varyings, @builtin(front_facing) front: bool) -> @location(0) vec4f {
#endif
    var t = vec4f(1.0);
#if BASE_MAP
    t = textureSample(base_map, layer_sampler, in.base_uv);
#endif
#if VERTEX_COLORS
    t *= in.color;
#endif

#if SHADOWS
    let receiver = receiver_at(in.position, in.clip.xy);
#if RECEIVERS
    if (in.receives > 0.0) {
        find_shadows(receiver);
    }
#else
    find_shadows(receiver);
#endif
#endif

    var color = vec3f(1.0);
#if LIT
    color = phong(in.position, shading_normal(in, front));
#endif
#if ENVIRONMENT
    color = lit_by_environment(in.position, shading_normal(in, front));
#endif
#if LIGHT_MAPPED
    color = material.constant + material.diffuse * textureSample(second_map, layer_sampler, in.second_uv).rgb;
#endif
#if FLAT
    color = material.constant;
#endif
#if SHOW_NORMAL
    color = 0.5 * shading_normal(in, front) + 0.5;
#endif
#if SHOW_UV
    // Back to v = 0 at the bottom.
    color = vec3f(fract(vec2f(in.base_uv.x, 1.0 - in.base_uv.y)), 0.0);
#endif
#if SHOW_SHADOW
#if SHADOWS
    color = vec3f(shadow_of(SHOWN_SOURCE));
#endif
    t = vec4f(vec3f(1.0), t.a);
#endif
#if SHOW_NOTHING
    color = vec3f(0.2);
#endif
#if SHADED
    color = tone_mapped(frame.exposure * t.rgb * color);
#else
    color = saturate(t.rgb * color);
#endif

    var alpha = 1.0;
#if ALPHA_TEST || BLEND
    let opacity = t.a * material.opacity;
#endif
#if ALPHA_TEST
    if (opacity < material.alpha_cutoff) {
        discard;
    }
#endif
#if BLEND
    alpha = opacity;
#endif
    return vec4f(color, alpha);
}
