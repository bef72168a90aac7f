// Relief (parallax) mapping: docs/techniques/displacement.md. The surface of a displacement map is looked for along the
// ray of sight, as if it stood on the plane of the triangle.

#import heights

@group(1) @binding(4) var<uniform> relief: Displacement;
@group(1) @binding(5) var relief_map: texture_2d<u32>;

// Steps along the ray, and halvings of the step that met the surface.
const RELIEF_STEPS: u32 = 32u;
const RELIEF_HALVINGS: u32 = 5u;
// The flattest ray is followed as if it rose by this much of its length: others would cross many texels a step.
const FLATTEST: f32 = 0.1;

struct Relief {
    // How far the point that is seen is from the one on the triangle, in pixels to the right and down: attributes there
    // differ by as much as this times their derivatives.
    shift: vec2f,
    // The same in the world.
    offset: vec3f,
    // What is added to the unit normal on the triangle's outer side, because the surface slopes.
    tilt: vec3f,
}

fn relief_height(uv: vec2f) -> f32 {
    return height(relief_map, relief.texel, uv);
}

// `position` is relative to the eye, `uv` the map's coordinates, `scale` metres for a length of one in the object.
fn find_relief(position: vec3f, uv: vec2f, scale: f32, front: bool) -> Relief {
    let right = dpdx(position);
    let down = dpdy(position);
    let uv_right = dpdx(uv);
    let uv_down = dpdy(uv);
    let across = cross(right, down);
    let area = max(dot(across, across), 1e-37);
    let view = towards_eye(position);
    let towards = unit(across) * select(-1.0, 1.0, dot(across, view) > 0.0);
    let outside = select(-towards, towards, front);

    // Along the ray the height over the triangle changes by `rise` a metre.
    let ray = -view;
    let fall = dot(ray, outside);
    let rise = select(min(fall, -FLATTEST), max(fall, FLATTEST), fall > 0.0);
    let along = ray - outside * fall;
    let pixels = vec2f(dot(cross(along, down), across), dot(cross(right, along), across)) / area;
    let step_uv = uv_right * pixels.x + uv_down * pixels.y;

    let ends = vec2f(relief.bias, relief.bias + relief.scale) * (scale / rise);
    let first = min(ends.x, ends.y);
    let length = max(ends.x, ends.y) - first;
    var low = 0.0;
    var high = 1.0;
    // Above the surface on the side of the eye.
    let side = select(1.0, -1.0, rise > 0.0);
    for (var i = 1u; i <= RELIEF_STEPS; i++) {
        let t = f32(i) / f32(RELIEF_STEPS);
        let at = first + t * length;
        let over = rise * at - scale * (relief.bias + relief.scale * relief_height(uv + step_uv * at));
        if (side * over <= 0.0) {
            high = t;
            break;
        }
        low = t;
    }
    for (var i = 0u; i < RELIEF_HALVINGS; i++) {
        let t = 0.5 * (low + high);
        let at = first + t * length;
        let over = rise * at - scale * (relief.bias + relief.scale * relief_height(uv + step_uv * at));
        if (side * over <= 0.0) {
            high = t;
        } else {
            low = t;
        }
    }
    let at = first + high * length;

    var found: Relief;
    found.shift = pixels * at;
    found.offset = along * at + outside * (rise * at);
    let there = uv + step_uv * at;
    let size = vec2f(textureDimensions(relief_map));
    let du = vec2f(1.0 / size.x, 0.0);
    let dv = vec2f(0.0, 1.0 / size.y);
    let slope = vec2f(relief_height(there + du) - relief_height(there - du), relief_height(there + dv) - relief_height(there - dv))
        * (0.5 * size * scale * relief.scale);
    // The gradient of the height on the triangle's plane.
    let gradient = (cross(down, across) * dot(slope, uv_right) + cross(across, right) * dot(slope, uv_down)) / area;
    found.tilt = -gradient;
    return found;
}
