// The mean of `width` texels along rows, at a cost that does not depend on the width. A running sum that
// subtracts what leaves would keep the rounding errors of moments e⁴⁰ times as large; this one only adds. The line is
// cut into blocks of `width`: a window is the end of one block and the start of the next, whose sums are at hand (van
// Herk 1992 and Gil, Werman 1993, there for maxima).

struct Running {
    width: f32,
    layer: u32,
}

#if ESM
@group(0) @binding(2) var blurred: texture_storage_2d<r32float, write>;
#elif VSM || EVSM2
@group(0) @binding(2) var blurred: texture_storage_2d<rg32float, write>;
#else
@group(0) @binding(2) var blurred: texture_storage_2d<rgba32float, write>;
#endif
@group(0) @binding(0) var moments: texture_2d_array<f32>;
@group(0) @binding(1) var<uniform> running: Running;

// Of two means of even width one reaches farther ahead, the other farther back. The second also turns rows into columns,
// since reading along columns would meet the same part of a cache over and over.
override SECOND: bool = false;

const WIDEST: u32 = 64u;

@compute @workgroup_size(16)
fn blur(@builtin(global_invocation_id) id: vec3u) {
    let size = i32(textureDimensions(moments).x);
    let line = i32(id.x);
    if (line >= size) {
        return;
    }
    let width = clamp(i32(running.width), 1, i32(WIDEST));
    let share = 1.0 / f32(width);
    let back = select(width / 2, (width - 1) / 2, SECOND);
    var ends: array<vec4f, WIDEST>;
    // `start` is the first texel of a window; the window's middle is `back` further.
    for (var start = -back; start < size - back; start += width) {
        var sum = vec4f(0.0);
        for (var i = width - 1; i >= 0; i--) {
            sum += share * textureLoad(moments, vec2i(clamp(start + i, 0, size - 1), line), running.layer, 0);
            ends[i] = sum;
        }
        var ahead = vec4f(0.0);
        for (var i = 0; i < width && start + i < size - back; i++) {
            textureStore(blurred, select(vec2i(start + i + back, line), vec2i(line, start + i + back), SECOND), ends[i] + ahead);
            ahead += share * textureLoad(moments, vec2i(clamp(start + width + i, 0, size - 1), line), running.layer, 0);
        }
    }
}
