// Displacement maps: one channel, read texel by texel and filtered in 32 bits.

struct Displacement {
    // Rows of the texture matrix, applied to (u, v, 1), v = 0 at the bottom.
    row_u: vec3f,
    bias: f32,
    row_v: vec3f,
    scale: f32,
    // What a texel is: 0 a byte, 1 two bytes, 2 the bits of a float.
    texel: u32,
    point_count: u32,
    padding: vec2u,
}

fn texel(map: texture_2d<u32>, kind: u32, x: u32, y: u32) -> f32 {
    let value = textureLoad(map, vec2u(x, y), 0).x;
    switch kind {
        case 0u: { return f32(value) / 255.0; }
        case 1u: { return f32(value) / 65535.0; }
        default: { return bitcast<f32>(value); }
    }
}

// The two texels around a coordinate.
struct Between {
    first: u32,
    second: u32,
    // How far it is towards the second.
    fraction: f32,
}

fn between(coordinate: f32, size: u32) -> Between {
    let part = coordinate - floor(coordinate);
    let inside = select(0.0, part, part >= 0.0 && part < 1.0);
    let position = inside * f32(size) - 0.5;
    let whole = floor(position);
    let first = select(min(u32(max(whole, 0.0)), size - 1u), size - 1u, whole < 0.0);
    return Between(first, select(first + 1u, 0u, first + 1u == size), position - whole);
}

fn height(map: texture_2d<u32>, kind: u32, uv: vec2f) -> f32 {
    let size = textureDimensions(map);
    let x = between(uv.x, size.x);
    let y = between(1.0 - uv.y, size.y);
    let left = vec2f(texel(map, kind, x.first, y.first), texel(map, kind, x.first, y.second));
    let right = vec2f(texel(map, kind, x.second, y.first), texel(map, kind, x.second, y.second));
    let rows = left + (right - left) * x.fraction;
    return rows.x + (rows.y - rows.x) * y.fraction;
}
