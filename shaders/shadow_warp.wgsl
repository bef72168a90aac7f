// Depths in [0, 1], and the moments that maps keep of them.

#if EVSM2 || EVSM4 || ESM
fn warped(depth: f32, exponent: f32, shift: f32) -> f32 {
    return exp(exponent * (depth - shift));
}
#endif

fn moments_of(depth: f32, exponent: f32, shift: f32) -> vec4f {
#if VSM
    return vec4f(depth, depth * depth, 0.0, 0.0);
#endif
#if ESM
    return vec4f(warped(depth, exponent, shift), 0.0, 0.0, 0.0);
#endif
#if EVSM2
    let positive = warped(depth, exponent, shift);
    return vec4f(positive, positive * positive, 0.0, 0.0);
#endif
#if EVSM4
    let positive = warped(depth, exponent, shift);
    let negative = -warped(depth, -exponent, shift);
    return vec4f(negative, negative * negative, positive, positive * positive);
#endif
#if MSM
    let square = depth * depth;
    return vec4f(depth, square, depth * square, square * square);
#endif
}
