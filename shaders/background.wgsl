// A picture that fills the viewport.

#import color
#import fullscreen

@group(0) @binding(0) var picture_sampler: sampler;
@group(0) @binding(1) var picture: texture_2d<f32>;

@fragment
fn fragment(in: Fullscreen) -> @location(0) vec4f {
    let texel = textureSample(picture, picture_sampler, in.uv);
    var color = saturate(texel.rgb);
#if ENCODE
    color = srgb_encode(color);
#endif
    return vec4f(color * texel.a, texel.a);
}
