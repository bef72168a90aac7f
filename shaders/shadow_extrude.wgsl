// The volume that a caster shades, as it counts pixels: no colour is written.

#import frame
#import node

struct Source {
    // From eye-relative world coordinates to clip space, with a far plane that nothing reaches.
    clip: mat4x4f,
    unused: vec4f,
    // Eye-relative position of the source; of a box the unit vector towards it.
    origin: vec3f,
    // 1 for a position.
    perspective: f32,
    // Where a parallel camera sees volumes end: points at infinity have no depth there. 0 for infinity.
    reach: f32,
}

@group(2) @binding(0) var<uniform> source: Source;

// w is 1 for corners that are moved away from the source without end.
@vertex
fn vertex(@location(0) corner: vec4f, node: NodeInput) -> @invariant @builtin(position) vec4f {
    let position = node_position(node, corner.xyz);
    if (corner.w == 0.0) {
        return source.clip * vec4f(position, 1.0);
    }
    var away = -source.origin;
    if (source.perspective > 0.0) {
        away = unit(position - source.origin);
    }
    if (source.reach > 0.0) {
        return source.clip * vec4f(position + away * source.reach, 1.0);
    }
    return source.clip * vec4f(away, 0.0);
}
