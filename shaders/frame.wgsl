// What is the same for everything in a view. Positions are relative to the eye, in world axes, so that a camera far
// from the origin loses no precision.

struct Frame {
    // From eye-relative world coordinates to clip space. Depth is reversed: 1 near, 0 far.
    clip_from_relative: mat4x4f,
    // World position of the eye.
    eye: vec3f,
    // Length of overlay normals in metres.
    normal_length: f32,
    // The opposite of the viewing direction.
    backwards: vec3f,
    // Factor for the light of surfaces.
    exposure: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// The camera is orthographic.
override PARALLEL: bool = false;

// The unit vector of v; 0 for 0.
fn unit(v: vec3f) -> vec3f {
    return v * inverseSqrt(max(dot(v, v), 1e-30));
}

// The unit vector from an eye-relative position towards the eye, which is never reached.
fn towards_eye(position: vec3f) -> vec3f {
    if (PARALLEL) {
        return frame.backwards;
    }
    return normalize(-position);
}
