// One pass of a separable Gaussian blur: along rows, or along columns.

#import fullscreen

struct Blur {
    // Texels from the middle to the edge.
    radius: f32,
    layer: u32,
}

@group(0) @binding(0) var moments: texture_2d_array<f32>;
@group(0) @binding(1) var<uniform> blur: Blur;

override VERTICAL: bool = false;

@fragment
fn fragment(in: Fullscreen) -> @location(0) vec4f {
    let middle = vec2i(in.clip.xy);
    let last = vec2i(textureDimensions(moments)) - 1;
    let direction = select(vec2i(1, 0), vec2i(0, 1), VERTICAL);
    let narrow = -4.5 / (blur.radius * blur.radius);
    let reach = i32(ceil(blur.radius));
    var weights = 1.0;
    for (var i = 1; i <= reach; i++) {
        weights += 2.0 * exp(narrow * f32(i * i));
    }
    // Weights sum to 1 before they meet moments that nearly fill their range.
    var sum = textureLoad(moments, middle, blur.layer, 0) / weights;
    for (var i = 1; i <= reach; i++) {
        let weight = exp(narrow * f32(i * i)) / weights;
        let before = textureLoad(moments, clamp(middle - i * direction, vec2i(0), last), blur.layer, 0);
        let after = textureLoad(moments, clamp(middle + i * direction, vec2i(0), last), blur.layer, 0);
        sum += weight * before + weight * after;
    }
    return sum;
}
