// Light from all around: docs/techniques/shading.md, section 11.

struct Environment {
    // From world directions to those that address a cube.
    lookup: mat3x3f,
    factor: f32,
    // Exponent of level 1 of the specular cube; that of each further level is a quarter of it.
    first_exponent: f32,
    last_level: f32,
    // Diffuse light in bands 0, 1, 2, then 4, factors included.
    harmonics: array<vec4f, 18>,
}

@group(3) @binding(0) var<uniform> environment: Environment;
@group(3) @binding(1) var environment_sampler: sampler;
@group(3) @binding(2) var diffuse_cube: texture_cube<f32>;
@group(3) @binding(3) var specular_cube: texture_cube<f32>;

// 0 off, 1 cube, otherwise bands of spherical harmonics.
override ENVIRONMENT_DIFFUSE: u32 = 0u;
#if SPECULAR
// 1 mirror, 2 Phong.
override ENVIRONMENT_SPECULAR: u32 = 1u;
#endif

fn harmonic(index: u32) -> vec3f {
    return environment.harmonics[index].rgb;
}

// The mean over the cosine around a unit direction.
fn diffuse_light(d: vec3f) -> vec3f {
    if (ENVIRONMENT_DIFFUSE == 1u) {
        return textureSampleLevel(diffuse_cube, environment_sampler, d, 0.0).rgb;
    }
    var sum = harmonic(0u) + d.y * harmonic(1u) + d.z * harmonic(2u) + d.x * harmonic(3u);
    let squares = d * d;
    if (ENVIRONMENT_DIFFUSE > 2u) {
        sum += d.x * d.y * harmonic(4u) + d.y * d.z * harmonic(5u) + (3.0 * squares.z - 1.0) * harmonic(6u)
            + d.x * d.z * harmonic(7u) + (squares.x - squares.y) * harmonic(8u);
    }
    if (ENVIRONMENT_DIFFUSE > 3u) {
        let difference = squares.x - squares.y;
        let seven = 7.0 * squares.z;
        sum += d.x * d.y * difference * harmonic(9u) + d.y * d.z * (3.0 * squares.x - squares.y) * harmonic(10u)
            + d.x * d.y * (seven - 1.0) * harmonic(11u) + d.y * d.z * (seven - 3.0) * harmonic(12u)
            + (squares.z * (35.0 * squares.z - 30.0) + 3.0) * harmonic(13u) + d.x * d.z * (seven - 3.0) * harmonic(14u)
            + difference * (seven - 1.0) * harmonic(15u) + d.x * d.z * (squares.x - 3.0 * squares.y) * harmonic(16u)
            + (squares.x * (squares.x - 3.0 * squares.y) - squares.y * (3.0 * squares.x - squares.y)) * harmonic(17u);
    }
    return max(sum, vec3f(0.0));
}

#if SPECULAR
// The mean over the Phong lobe around a unit direction, or what a mirror shows.
fn specular_light(d: vec3f, exponent: f32) -> vec3f {
    if (ENVIRONMENT_SPECULAR == 1u) {
        return textureSample(specular_cube, environment_sampler, d).rgb;
    }
    // A lobe has the variance 1 / n. Directions that a pixel's width covers add that of a box. Between levels the share of
    // the next one is that which gives the lobe's variance; level 0 has none.
    let across = dpdx(d);
    let down = dpdy(d);
    let variance = 1.0 / max(exponent, 1e-3) + max(dot(across, across), dot(down, down)) / 12.0;
    // A level that is no number may be read from anywhere.
    let relative = clamp(environment.first_exponent * variance, 0.0, 1e9);
    let whole = floor(0.5 * log2(max(relative, 1.0)));
    let wide = 1.0 + whole + (relative * exp2(-2.0 * whole) - 1.0) / 3.0;
    let wanted = select(relative, wide, relative > 1.0);
    let last = environment.last_level;
    let level = select(select(0.0, last, wanted >= last), wanted, wanted > 0.0 && wanted < last);
    return textureSampleLevel(specular_cube, environment_sampler, d, level).rgb;
}
#endif

// What a surface of the material gives back, before its texture.
fn lit_by_environment(position: vec3f, normal: vec3f) -> vec3f {
    var sum = material.constant;
    if (ENVIRONMENT_DIFFUSE > 0u) {
        sum += material.diffuse * (environment.factor * diffuse_light(environment.lookup * normal));
    }
#if SPECULAR
    let view = towards_eye(position);
    let mirrored = 2.0 * dot(normal, view) * normal - view;
    sum += material.specular * (environment.factor * specular_light(environment.lookup * mirrored, material.exponent));
#endif
    return sum;
}
