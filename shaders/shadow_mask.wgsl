// Marks the pixels that the stencil test lets through: those in no volume.

#import fullscreen

@fragment
fn fragment(in: Fullscreen) -> @location(0) vec4f {
    return vec4f(1.0);
}
