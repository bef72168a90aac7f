// Points of a tessellated surface, displaced: docs/techniques/shading.md, section 11. The formulas are those of
// `scene/src/displacement/surface.rs`.

#import heights
#import tessellation

@group(0) @binding(0) var<uniform> displacement: Displacement;
@group(0) @binding(1) var<storage, read> points: array<Point>;
@group(0) @binding(2) var<storage, read> samples: array<Place>;
@group(0) @binding(3) var<storage, read> base_positions: array<f32>;
@group(0) @binding(4) var<storage, read> base_normals: array<f32>;
@group(0) @binding(5) var<storage, read> base_uvs: array<f32>;
@group(0) @binding(6) var map: texture_2d<u32>;
@group(0) @binding(7) var<storage, read_write> positions: array<f32>;
#if NORMALS
@group(0) @binding(8) var<storage, read_write> normals: array<f32>;
#endif

fn position_of(vertex: u32) -> vec3f {
    return vec3f(base_positions[3u * vertex], base_positions[3u * vertex + 1u], base_positions[3u * vertex + 2u]);
}

fn normal_of(vertex: u32) -> vec3f {
    return vec3f(base_normals[3u * vertex], base_normals[3u * vertex + 1u], base_normals[3u * vertex + 2u]);
}

fn uv_of(vertex: u32) -> vec2f {
    return vec2f(base_uvs[2u * vertex], base_uvs[2u * vertex + 1u]);
}

fn height_uv(place: Place) -> vec2f {
    let w = weights(place);
    let uv = uv_of(place.corner_0) * w.x + uv_of(place.corner_1) * w.y + uv_of(place.corner_2) * w.z;
    return vec2f(dot(displacement.row_u, vec3f(uv, 1.0)), dot(displacement.row_v, vec3f(uv, 1.0)));
}

fn distance_at(place: Place) -> f32 {
    return displacement.bias + displacement.scale * height(map, displacement.texel, height_uv(place));
}

#if NORMALS
fn slope(uv: vec2f) -> vec2f {
    let size = vec2f(textureDimensions(map));
    let du = vec2f(1.0 / size.x, 0.0);
    let dv = vec2f(0.0, 1.0 / size.y);
    let kind = displacement.texel;
    let change = vec2f(
        height(map, kind, uv + du) - height(map, kind, uv - du),
        height(map, kind, uv + dv) - height(map, kind, uv - dv),
    );
    return change * (0.5 * size);
}

fn unit_scale(v: vec3f) -> vec3f {
    let largest = max(max(abs(v.x), abs(v.y)), abs(v.z));
    return select(vec3f(0.0), v / largest, largest > 0.0 && largest < 3.4e38);
}

// A side of the base triangle, displaced.
fn side(n: vec3f, edge: vec3f, turn: vec3f, rise: f32, d: f32, len: f32) -> vec3f {
    let flat_edge = edge - n * dot(n, edge);
    let turned = (turn - n * dot(n, turn)) / len;
    return unit_scale(flat_edge + turned * d + n * rise);
}

fn displaced_normal(place: Place, n: vec3f, len: f32, d: f32) -> vec3f {
    let p = position_of(place.corner_0);
    let edge_1 = position_of(place.corner_1) - p;
    let edge_2 = position_of(place.corner_2) - p;
    let m = normal_of(place.corner_0);
    let turn_1 = normal_of(place.corner_1) - m;
    let turn_2 = normal_of(place.corner_2) - m;
    let t = uv_of(place.corner_0);
    let step_1 = uv_of(place.corner_1) - t;
    let step_2 = uv_of(place.corner_2) - t;
    let s = slope(height_uv(place)) * displacement.scale;
    let rise_1 = dot(s, vec2f(dot(displacement.row_u.xy, step_1), dot(displacement.row_v.xy, step_1)));
    let rise_2 = dot(s, vec2f(dot(displacement.row_u.xy, step_2), dot(displacement.row_v.xy, step_2)));
    let outside = dot(cross(unit_scale(edge_1), unit_scale(edge_2)), n);
    let across = unit_scale(cross(side(n, edge_1, turn_1, rise_1, d, len), side(n, edge_2, turn_2, rise_2, d, len)));
    let squared = dot(across, across);
    if (outside != 0.0 && squared > 0.0 && squared < 3.4e38) {
        return across * (select(1.0, -1.0, outside < 0.0) / sqrt(squared));
    }
    return n;
}
#endif

@compute @workgroup_size(128)
fn compute(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let index = invocation(group, groups, local);
    if (index >= displacement.point_count) {
        return;
    }
    let point = points[index];
    let place = point.place;
    let w = weights(place);
    let base = position_of(place.corner_0) * w.x + position_of(place.corner_1) * w.y + position_of(place.corner_2) * w.z;
    let interpolated = normal_of(place.corner_0) * w.x + normal_of(place.corner_1) * w.y + normal_of(place.corner_2) * w.z;
    let len = length(interpolated);
    let n = select(vec3f(0.0), interpolated / len, len > 0.0);

    // Vertices at a seam of the texture coordinates go to one place: all take the mean over the triangles there.
    var d = 0.0;
    if (point.sample_count == 0u) {
        d = distance_at(place);
    } else {
        for (var i = 0u; i < point.sample_count; i++) {
            d += distance_at(samples[point.first_sample + i]);
        }
        d /= f32(point.sample_count);
    }
    let moved = base + n * d;
    positions[3u * index] = moved.x;
    positions[3u * index + 1u] = moved.y;
    positions[3u * index + 2u] = moved.z;

#if NORMALS
    var normal = interpolated;
    if (len > 0.0) {
        var sum = vec3f(0.0);
        if (point.sample_count == 0u) {
            sum = displaced_normal(place, n, len, d);
        } else {
            for (var i = 0u; i < point.sample_count; i++) {
                sum += displaced_normal(samples[point.first_sample + i], n, len, d);
            }
        }
        let squared = dot(sum, sum);
        normal = len * select(n, sum * inverseSqrt(max(squared, 1e-30)), squared > 0.0);
    }
    normals[3u * index] = normal.x;
    normals[3u * index + 1u] = normal.y;
    normals[3u * index + 2u] = normal.z;
#endif
}
