// A source's shadow map as grey: near the source is light, far is dark. Maps of several layers stand side by side.

#import fullscreen

struct ShownMap {
    // Of the picture, in pixels.
    size: vec2f,
    // Columns and rows of layers.
    grid: vec2f,
    layers: f32,
    near: f32,
    far: f32,
    // 1 if the map's views are pyramids, 0 if they are boxes.
    perspective: f32,
    exponent: f32,
    // Subtracted from depth before it was warped.
    shift: f32,
}

@group(0) @binding(0) var<uniform> shown: ShownMap;
#if MOMENTS
@group(0) @binding(1) var map: texture_2d_array<f32>;
#else
@group(0) @binding(1) var map: texture_depth_2d_array;
#endif

// From 0, near, to 1, far, even in metres.
fn depth_at(texel: vec2i, layer: i32) -> f32 {
    let stored = textureLoad(map, texel, layer, 0);
#if MOMENTS
#if EXPONENTIAL
#if NEGATIVE_FIRST
    return log(max(stored.b, 1e-37)) / shown.exponent + shown.shift;
#else
    return log(max(stored.r, 1e-37)) / shown.exponent + shown.shift;
#endif
#else
    return stored.r;
#endif
#else
    if (shown.perspective == 0.0) {
        return stored;
    }
    let range = shown.far - shown.near;
    return (shown.near * shown.far / (shown.far - stored * range) - shown.near) / range;
#endif
}

@fragment
fn fragment(in: Fullscreen) -> @location(0) vec4f {
    let sides = shown.size / shown.grid;
    let side = min(sides.x, sides.y);
    let place = (in.clip.xy - 0.5 * (shown.size - side * shown.grid)) / side;
    let cell = floor(place);
    let layer = cell.y * shown.grid.x + cell.x;
    if (any(place < vec2f(0.0)) || any(place >= shown.grid) || layer >= shown.layers) {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
    let texels = vec2f(textureDimensions(map));
    let texel = vec2i(min((place - cell) * texels, texels - 1.0));
    return vec4f(vec3f(1.0 - saturate(depth_at(texel, i32(layer)))), 1.0);
}
