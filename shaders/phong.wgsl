// Phong reflection of all lights: docs/techniques/shading.md, sections 1 and 2.

#import lights

fn reflected(light: Light, towards: vec3f, factor: f32, normal: vec3f, view: vec3f) -> vec3f {
    let cosine = dot(normal, towards);
    var color = material.diffuse * light.diffuse * (factor * saturate(cosine));
#if SPECULAR
    let mirrored = 2.0 * cosine * normal - towards;
    let highlight = dot(view, mirrored);
    // Where log(0) is not minus infinity, pow(0, n) is not 0.
    let lobe = select(0.0, pow(min(highlight, 1.0), material.exponent), highlight > 0.0);
    color += material.specular * light.specular * (factor * lobe);
#endif
    return color;
}

fn falloff(light: Light, squared_distance: f32) -> f32 {
#if FALLOFF
    return select(1.0, 1.0 / max(squared_distance, 1e-4), light.inverse_square > 0.0);
#else
    return 1.0;
#endif
}

// What is left of a light's diffuse and specular terms.
fn shadowed(light: u32) -> f32 {
#if SHADOWS
    return unshadowed(light);
#else
    return 1.0;
#endif
}

fn phong(position: vec3f, normal: vec3f) -> vec3f {
#if SPECULAR
    let view = towards_eye(position);
#else
    let view = vec3f(0.0);
#endif
    var sum = material.constant;
    for (var i = 0u; i < POINT_END; i++) {
        let offset = lights[i].place - position;
        let factor = falloff(lights[i], dot(offset, offset)) * shadowed(i);
        sum += reflected(lights[i], unit(offset), factor, normal, view);
    }
    for (var i = POINT_END; i < DIRECTIONAL_END; i++) {
        sum += reflected(lights[i], lights[i].place, shadowed(i), normal, view);
    }
    for (var i = DIRECTIONAL_END; i < SPOT_END; i++) {
        let offset = lights[i].place - position;
        let towards = unit(offset);
        let cosine = dot(-towards, lights[i].direction);
        let cone = saturate((cosine - lights[i].cone_outer) * lights[i].cone_scale);
        let factor = falloff(lights[i], dot(offset, offset)) * cone * cone * shadowed(i);
        sum += reflected(lights[i], towards, factor, normal, view);
    }
    return sum;
}
