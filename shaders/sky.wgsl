// The sky box: the environment behind everything.

#import fullscreen
#import tone_map

struct Sky {
    // The direction through the middle of the picture, as it addresses the cube.
    middle: vec3f,
    // Intensity times exposure.
    factor: f32,
    // From there to the right edge and to the upper one.
    right: vec3f,
    up: vec3f,
}

@group(0) @binding(0) var<uniform> sky: Sky;
@group(0) @binding(1) var sky_sampler: sampler;
@group(0) @binding(2) var sky_cube: texture_cube<f32>;

@fragment
fn fragment(in: Fullscreen) -> @location(0) vec4f {
    let at = 2.0 * in.uv - 1.0;
    let direction = sky.middle + at.x * sky.right - at.y * sky.up;
    return vec4f(tone_mapped(sky.factor * textureSample(sky_cube, sky_sampler, direction).rgb), 1.0);
}
