// Shadow volumes: what was counted behind each pixel is in a mask of the picture's size.

#import shadow

fn shadow_volume(mask: texture_2d<f32>, s: u32, r: Receiver) -> f32 {
    // A volume that was given bounds the shadow; one without views is the whole world.
    if (shadow_sources[s].view_count > 0.0 && !projected(s, 0u, r.position).inside) {
        return 1.0;
    }
    return textureLoad(mask, vec2i(r.pixel), 0).r;
}
