// Takes a finished picture (premultiplied, in the space that blending happened in) to the target's space and alpha.

#import color
#import fullscreen

@group(0) @binding(0) var picture: texture_2d<f32>;

@fragment
fn fragment(in: Fullscreen) -> @location(0) vec4f {
    let texel = textureLoad(picture, vec2i(in.clip.xy), 0);
    var color = saturate(texel.rgb / max(texel.a, 1e-6));
#if ENCODE
    color = srgb_encode(color);
#endif
#if DECODE
    color = srgb_decode(color);
#endif
#if PREMULTIPLY
    color *= texel.a;
#endif
    return vec4f(color, texel.a);
}
