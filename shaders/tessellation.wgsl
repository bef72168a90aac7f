// Points on base triangles: `Place` and `Point` of `scene/src/displacement/plan.rs`.

struct Place {
    corner_0: u32,
    corner_1: u32,
    corner_2: u32,
    // Numerators of the corners' weights and their denominator, 16 bits each.
    weights_01: u32,
    weights_2d: u32,
}

struct Point {
    place: Place,
    first_sample: u32,
    // 0: the point's own place is its only sample.
    sample_count: u32,
}

const WORKGROUP: u32 = 128u;

fn weights(place: Place) -> vec3f {
    let numerators = vec3f(vec3u(place.weights_01 & 0xffffu, place.weights_01 >> 16u, place.weights_2d & 0xffffu));
    return numerators / f32(place.weights_2d >> 16u);
}

// Number of the invocation in a dispatch of one or two dimensions.
fn invocation(group: vec3u, groups: vec3u, local: u32) -> u32 {
    return (group.y * groups.x + group.x) * WORKGROUP + local;
}
