// A material's parameters (decoded already in linear mode) and texture layers.

struct Material {
    // What does not depend on any light's direction: emission, and ambient light unless there is a light map.
    constant: vec3f,
    opacity: f32,
    diffuse: vec3f,
    exponent: f32,
    specular: vec3f,
    alpha_cutoff: f32,
    // Rows of texture matrices, applied to (u, v, 1). They give coordinates with v = 0 at the top.
    base_u: vec3f,
    base_v: vec3f,
    second_u: vec3f,
    normal_intensity: f32,
    second_v: vec3f,
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
