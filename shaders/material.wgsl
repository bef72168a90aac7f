// A material's parameters (decoded already in linear mode) and texture layers.

struct TextureMatrix {
    // Rows applied to (u, v, 1); they give coordinates with v = 0 at the top.
    u: vec4f,
    v: vec4f,
}

struct Material {
    emission: vec3f,
    opacity: f32,
    ambient: vec3f,
    alpha_cutoff: f32,
    diffuse: vec3f,
    exponent: f32,
    specular: vec3f,
    normal_intensity: f32,
    base_matrix: TextureMatrix,
    second_matrix: TextureMatrix,
}

@group(1) @binding(0) var<uniform> material: Material;

#if BASE_MAP || SECOND_MAP
@group(1) @binding(1) var layer_sampler: sampler;
#endif
#if BASE_MAP
// The diffuse texture, or the layer that is shown alone.
@group(1) @binding(2) var base_map: texture_2d<f32>;
#endif
#if SECOND_MAP
// The light map or the normal map: a surface has one of them at most.
@group(1) @binding(3) var second_map: texture_2d<f32>;
#endif

fn texture_coordinates(m: TextureMatrix, uv: vec2f) -> vec2f {
    let p = vec3f(uv, 1.0);
    return vec2f(dot(m.u.xyz, p), dot(m.v.xyz, p));
}
