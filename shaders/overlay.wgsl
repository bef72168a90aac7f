// Lines and triangles in plain colour: the edges of a mesh, its normals, or a shape in world coordinates.

#import frame
#import color
#if NODE
#import node
#endif

struct VertexInput {
    @location(0) position: vec3f,
#if NODE_NORMALS
    // 0 at a line's foot.
    @location(1) normal: vec3f,
#endif
#if !NODE
    @location(2) color: vec4f,
#endif
}

struct Varyings {
    @builtin(position) clip: vec4f,
    @location(0) color: vec4f,
}

@vertex
#if NODE
fn vertex(in: VertexInput, node: NodeInput) -> Varyings {
    var position = node_position(node, in.position);
#if NODE_NORMALS
    position += frame.normal_length * unit(node_normal(node, in.normal));
    let color = vec4f(0.35, 0.65, 1.0, 1.0);
#else
    let color = vec4f(0.95, 0.75, 0.25, 1.0);
#endif
#else
fn vertex(in: VertexInput) -> Varyings {
    let position = in.position - frame.eye;
    let color = in.color;
#endif
    var out: Varyings;
    out.clip = frame.clip_from_relative * vec4f(position, 1.0);
#if NUDGE
    // A little nearer than the surface that it lies on.
    out.clip.z += 1e-6 * out.clip.w + 2e-4 * abs(out.clip.z);
#endif
    out.color = color;
    return out;
}

@fragment
fn fragment(in: Varyings) -> @location(0) vec4f {
    var color = saturate(in.color);
#if LINEAR
    color = vec4f(srgb_decode(color.rgb), color.a);
#endif
    return color;
}
