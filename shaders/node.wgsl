// A node's matrices, one instance each.

struct NodeInput {
    // Rows of the matrix from the node's to world coordinates.
    @location(8) row_x: vec4f,
    @location(9) row_y: vec4f,
    @location(10) row_z: vec4f,
#if NODE_NORMALS
    // Columns of its inverse transpose, up to a positive factor.
    @location(11) normal_x: vec3f,
    @location(12) normal_y: vec3f,
    @location(13) normal_z: vec3f,
#endif
#if RECEIVERS
    // 1 if shadows fall on it.
    @location(14) receives: f32,
#endif
}

// A position in the node's coordinates, relative to the eye in world axes.
fn node_position(node: NodeInput, p: vec3f) -> vec3f {
    let linear = vec3f(dot(node.row_x.xyz, p), dot(node.row_y.xyz, p), dot(node.row_z.xyz, p));
    return linear + (vec3f(node.row_x.w, node.row_y.w, node.row_z.w) - frame.eye);
}

#if NODE_NORMALS
// A normal in the node's coordinates, in the world, not unit.
fn node_normal(node: NodeInput, n: vec3f) -> vec3f {
    return n.x * node.normal_x + n.y * node.normal_y + n.z * node.normal_z;
}
#endif
