// One triangle that covers the viewport.

struct Fullscreen {
    @builtin(position) clip: vec4f,
    // (0, 0) at the top left, (1, 1) at the bottom right.
    @location(0) uv: vec2f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Fullscreen {
    let uv = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return Fullscreen(vec4f(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0, 0.0, 1.0), uv);
}
