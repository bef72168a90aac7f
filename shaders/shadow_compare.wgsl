// Hard shadows, percentage-closer filtering and percentage-closer soft shadows: depths of single texels are compared.

#import shadow

// The steepest slope that is made up for: beyond, next to no light arrives, and nearby shadows would be lost.
const STEEPEST: f32 = 12.0;

// What the receiver's plane needs, in metres along the ray, so that no sample of a kernel lies in front of it: half the
// kernel's diagonal across the axis, times the plane's slope along the ray, and one step of depth.
fn acne_bound(s: u32, v: u32, r: Receiver, towards: vec3f, reach: f32) -> f32 {
    let depth = axial_depth(s, v, r.position);
    let axis = shadow_sources[s].views[v].axis.xyz;
    let across = length(r.normal - axis * dot(r.normal, axis));
    let slope = min(across / max(abs(dot(r.normal, towards)), 1e-3), STEEPEST);
    let near = shadow_sources[s].views[v].near;
    let far = shadow_sources[s].views[v].far;
    let step = select(6e-8, 1.0 / shadow_sources[s].levels, shadow_sources[s].levels > 0.0);
    let range = select(far - near, depth * depth * (far - near) / (far * near), shadow_sources[s].perspective > 0.0);
    // The depths of two roundings, and of coordinates.
    let quantum = step * range + 4e-7 * (abs(depth) + length(r.position));
    return reach * texel_width(s, v, depth) * slope + quantum;
}

// The receiver where it is compared. `reach` is half the diagonal of the kernel, in texels.
fn biased(s: u32, v: u32, r: Receiver, reach: f32) -> vec3f {
    let towards = towards_source(s, r.position);
    let cosine = clamp(abs(dot(r.normal, towards)), 0.0, 1.0);
    let facing = select(-r.normal, r.normal, dot(r.normal, towards) >= 0.0);
    let width = texel_width(s, v, axial_depth(s, v, r.position));
    var position = r.position + facing * (shadow_sources[s].normal_offset * width * sqrt(1.0 - cosine * cosine));
    var bias = shadow_sources[s].bias;
    if (shadow_sources[s].slope_bias > 0.0) {
        // The plane is known from differences between pixels, and so are its errors: in shares of its slope.
        let left = select(reach, 0.01 * reach, shadow_sources[s].receiver_plane > 0.0);
        bias += shadow_sources[s].slope_bias * acne_bound(s, v, r, towards, left);
    }
    bias = min(bias, shadow_sources[s].max_bias);
    if (shadow_sources[s].perspective > 0.0) {
        // Never past the source.
        bias = min(bias, 0.5 * distance(shadow_sources[s].origin, position));
    }
    return position + towards * bias;
}

// Change of the receiver's depth by texture coordinates, along its plane.
fn plane_gradient(s: u32, v: u32, r: Receiver, uvz: vec3f) -> vec2f {
    if (shadow_sources[s].receiver_plane <= 0.0) {
        return vec2f(0.0);
    }
    let across = unit(cross(r.normal, select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 0.0, 1.0), abs(r.normal.x) > 0.7)));
    let along = cross(r.normal, across);
    let clip = shadow_sources[s].views[v].clip;
    let w = (clip * vec4f(r.position, 1.0)).w;
    let ndc = vec3f(2.0 * uvz.x - 1.0, 1.0 - 2.0 * uvz.y, uvz.z);
    let a4 = clip * vec4f(across, 0.0);
    let b4 = clip * vec4f(along, 0.0);
    let half = vec3f(0.5, -0.5, 1.0);
    let a = half * (a4.xyz - ndc * a4.w) / w;
    let b = half * (b4.xyz - ndc * b4.w) / w;
    let determinant = a.x * b.y - a.y * b.x;
    // A plane that the source sees edge-on has no gradient.
    if (abs(determinant) < 1e-4 * (dot(a.xy, a.xy) + dot(b.xy, b.xy))) {
        return vec2f(0.0);
    }
    return vec2f(a.z * b.y - b.z * a.y, b.z * a.x - a.z * b.x) / determinant;
}

// Depth in a texel; the nearest one beyond the map's edge.
fn stored_depth(map: texture_depth_2d_array, s: u32, v: u32, texel: vec2i) -> f32 {
    let last = i32(shadow_sources[s].texels) - 1;
    let depth = textureLoad(map, clamp(texel, vec2i(0), vec2i(last)), v, 0);
    let levels = shadow_sources[s].levels;
    return select(depth, round(depth * levels) / levels, levels > 0.0);
}

fn shadow_hard(map: texture_depth_2d_array, s: u32, v: u32, r: Receiver) -> f32 {
    let at = projected(s, v, biased(s, v, r, 0.70711));
    if (!projected(s, v, r.position).inside || !at.inside) {
        return 1.0;
    }
    let texel = vec2i(floor(at.uvz.xy * shadow_sources[s].texels));
    return select(0.0, 1.0, at.uvz.z <= stored_depth(map, s, v, texel));
}

// Golden-angle spiral (Vogel 1979): the i-th of n points that fill the unit disc evenly.
fn spiral(i: f32, n: f32, turn: f32) -> vec2f {
    let angle = i * 2.3999632 + turn;
    return sqrt((i + 0.5) / n) * vec2f(cos(angle), sin(angle));
}

// An angle for each pixel whose pattern hides itself (Jimenez 2014).
fn turn_of(pixel: vec2f) -> f32 {
    return 6.2831853 * fract(52.9829189 * fract(dot(floor(pixel), vec2f(0.06711056, 0.00583715))));
}

fn shadow_disc(map: texture_depth_2d_array, s: u32, v: u32, r: Receiver, uvz: vec3f, radius: f32) -> f32 {
    let size = shadow_sources[s].texels;
    let gradient = plane_gradient(s, v, r, uvz) / size;
    let samples = shadow_sources[s].samples;
    let turn = turn_of(r.pixel);
    let middle = uvz.xy * size;
    var lit = 0.0;
    for (var i = 0.0; i < samples; i += 1.0) {
        let texel = floor(middle + radius * spiral(i, samples, turn));
        let depth = uvz.z + dot(gradient, texel + 0.5 - middle);
        lit += select(0.0, 1.0, depth <= stored_depth(map, s, v, vec2i(texel)));
    }
    return lit / samples;
}

fn shadow_pcf(map: texture_depth_2d_array, s: u32, v: u32, r: Receiver, kernel: u32) -> f32 {
    let radius = shadow_sources[s].views[v].radius;
    // From the receiver to the middle of the farthest texel.
    var reach = 1.41421 * (radius + 0.5);
    if (kernel == KERNEL_TENT) {
        reach = 1.41421 * (radius + 1.0);
    }
    if (kernel == KERNEL_POISSON) {
        reach = radius + 0.5 + 0.70711;
    }
    let at = projected(s, v, biased(s, v, r, reach));
    if (!projected(s, v, r.position).inside || !at.inside) {
        return 1.0;
    }
    if (kernel == KERNEL_POISSON) {
        return shadow_disc(map, s, v, r, at.uvz, radius + 0.5);
    }
    let size = shadow_sources[s].texels;
    let gradient = plane_gradient(s, v, r, at.uvz) / size;
    let middle = at.uvz.xy * size;
    var first = floor(middle) - round(radius);
    var last = floor(middle) + round(radius);
    if (kernel == KERNEL_TENT) {
        first = floor(middle - radius - 0.5);
        last = floor(middle + radius + 0.5);
    }
    let narrow = -0.5 * 9.0 / (radius * radius);
    var lit = 0.0;
    var sum = 0.0;
    for (var y = first.y; y <= last.y; y += 1.0) {
        for (var x = first.x; x <= last.x; x += 1.0) {
            let offset = vec2f(x, y) + 0.5 - middle;
            var weight = 1.0;
            if (kernel == KERNEL_TENT) {
                let share = saturate(radius + 1.0 - abs(offset));
                weight = share.x * share.y;
            }
            if (kernel == KERNEL_GAUSSIAN) {
                weight = exp(narrow * dot(offset, offset));
            }
            let depth = at.uvz.z + dot(gradient, offset);
            lit += select(0.0, weight, depth <= stored_depth(map, s, v, vec2i(vec2f(x, y))));
            sum += weight;
        }
    }
    return lit / sum;
}

// Depth along the axis from a stored one.
fn linear_depth(s: u32, v: u32, stored: f32) -> f32 {
    let near = shadow_sources[s].views[v].near;
    let far = shadow_sources[s].views[v].far;
    if (shadow_sources[s].perspective > 0.0) {
        return near * far / (far - stored * (far - near));
    }
    return near + stored * (far - near);
}

fn shadow_pcss(map: texture_depth_2d_array, s: u32, v: u32, r: Receiver) -> f32 {
    let straight = projected(s, v, r.position);
    if (!straight.inside) {
        return 1.0;
    }
    let size = shadow_sources[s].texels;
    let light = shadow_sources[s].light_size;
    let near = shadow_sources[s].views[v].near;
    let depth = axial_depth(s, v, r.position);
    let width = texel_width(s, v, depth);
    let perspective = shadow_sources[s].perspective > 0.0;
    let widest = 0.125 * size;

    // Blockers lie within the cone from the receiver to the light, which is widest at the near plane.
    let cone = select(light * (depth - near) / width, light * (depth - near) / depth / texel_width(s, v, near), perspective);
    let search = clamp(0.5 * cone, 1.0, widest);
    let gradient = plane_gradient(s, v, r, straight.uvz) / size;
    let samples = shadow_sources[s].samples;
    let turn = turn_of(r.pixel);
    let middle = straight.uvz.xy * size;
    // A blocker is in front of the receiver's plane by more than the map can tell.
    let reach = select(search, 0.0, shadow_sources[s].receiver_plane > 0.0) + 0.70711;
    let compared = projected(s, v, biased(s, v, r, reach)).uvz.z;
    var blockers = 0.0;
    var sum = 0.0;
    for (var i = 0.0; i < samples; i += 1.0) {
        let texel = floor(middle + search * spiral(i, samples, turn));
        let stored = stored_depth(map, s, v, vec2i(texel));
        if (stored < compared + dot(gradient, texel + 0.5 - middle)) {
            sum += linear_depth(s, v, stored);
            blockers += 1.0;
        }
    }
    if (blockers == 0.0) {
        return 1.0;
    }
    let blocker = max(sum / blockers, near);
    let penumbra = max(depth - blocker, 0.0) * light / select(1.0, blocker, perspective);
    let radius = clamp(0.5 * penumbra / width, 0.5, widest);
    let at = projected(s, v, biased(s, v, r, radius + 0.70711));
    return shadow_disc(map, s, v, r, at.uvz, radius);
}
