// An attribute of a mesh at the points of a tessellated surface.

#import tessellation

struct Interpolation {
    point_count: u32,
    // Floats of the attribute.
    components: u32,
}

@group(0) @binding(0) var<uniform> interpolation: Interpolation;
@group(0) @binding(1) var<storage, read> points: array<Point>;
@group(0) @binding(2) var<storage, read> base: array<f32>;
@group(0) @binding(3) var<storage, read_write> result: array<f32>;

@compute @workgroup_size(128)
fn compute(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let index = invocation(group, groups, local);
    if (index >= interpolation.point_count) {
        return;
    }
    let place = points[index].place;
    let w = weights(place);
    let n = interpolation.components;
    for (var i = 0u; i < n; i++) {
        result[n * index + i] =
            base[n * place.corner_0 + i] * w.x + base[n * place.corner_1 + i] * w.y + base[n * place.corner_2 + i] * w.z;
    }
}
