// What is the same for everything in a view. Positions are relative to the eye, in world axes, so that a camera far
// from the origin loses no precision.

struct Frame {
    // From eye-relative world coordinates to clip space. Depth is reversed: 1 near, 0 far.
    clip_from_relative: mat4x4f,
    // World position of the eye.
    eye: vec3f,
    // 1 for a perspective camera, 0 for an orthographic one.
    perspective: f32,
    // The opposite of the viewing direction for an orthographic camera, 0 for a perspective one.
    parallel_view: vec3f,
    // Length of overlay normals in metres.
    normal_length: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// The unit vector of v; 0 for 0.
fn unit(v: vec3f) -> vec3f {
    return v * inverseSqrt(max(dot(v, v), 1e-30));
}

// The unit vector from an eye-relative position towards the eye.
fn towards_eye(position: vec3f) -> vec3f {
    return unit(frame.parallel_view - frame.perspective * position);
}
