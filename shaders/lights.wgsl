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

struct Lights {
    // Sum of all ambient colours.
    ambient: vec3f,
    // Lights are ordered by kind: point lights, then directional ones, then spots. These are the ends.
    point_end: u32,
    directional_end: u32,
    spot_end: u32,
    list: array<Light, MAX_LIGHTS>,
}

@group(0) @binding(1) var<uniform> lights: Lights;
