// The lights of a view.

struct Light {
    diffuse: vec3f,
    // 1 if it weakens with the inverse square of the distance, else 0.
    inverse_square: f32,
    specular: vec3f,
    // Cosine of a spot's outer half angle.
    cone_outer: f32,
    // Eye-relative position; for a directional light the unit vector towards it.
    place: vec3f,
    // 1 / (cos inner − cos outer) of a spot.
    cone_scale: f32,
    // A spot's unit direction, away from it.
    direction: vec3f,
    padding: f32,
}

// Ordered by kind: point lights, then directional ones, then spots.
@group(0) @binding(1) var<uniform> lights: array<Light, MAX_LIGHTS>;

// The ends of each kind. They are constants of the pipeline, so that loops can be unrolled: a frame on a software
// rasteriser takes up to half longer otherwise.
override POINT_END: u32 = 0u;
override DIRECTIONAL_END: u32 = 0u;
override SPOT_END: u32 = 0u;
