//! Diffuse light in spherical harmonics.

use std::f32::consts::PI;

use aam_scene::CubeFace;
use glam::{Vec2, Vec3, Vec4};

use super::cube::Cube;

/// Coefficients in use: bands 0, 1, 2, then 4. The clamped cosine has nothing in band 3.
pub(crate) const COEFFICIENTS: usize = 18;

/// Coefficients of the reflected light: those of the light times those of the clamped cosine over π (1, 2/3, 1/4, −1/24;
/// Ramamoorthi and Hanrahan, "An Efficient Representation for Irradiance Environment Maps", 2001, eq. 8), times those of
/// the basis, so that the shader multiplies with polynomials only. Bands from `bands` on are 0.
pub(crate) fn reflected(cube: &Cube, bands: u32) -> [Vec4; COEFFICIENTS] {
    let side = cube.side;
    let mut sums = [Vec3::ZERO; COEFFICIENTS];
    let mut sphere = 0.0_f32;
    for (index, texel) in cube.texels.iter().enumerate() {
        let (face, place) = (CubeFace::ALL[index / (side * side)], index % (side * side));
        let direction = Cube::direction(face, place % side, place / side, side);
        let at = 2.0 * (Vec2::new((place % side) as f32, (place / side) as f32) + 0.5) / side as f32 - 1.0;
        let solid_angle = (1.0 + at.length_squared()).powf(-1.5);
        sphere += solid_angle;
        for (sum, basis) in sums.iter_mut().zip(polynomials(lookup(direction))) {
            *sum += *texel * (solid_angle * basis);
        }
    }
    let scale = 4.0 * PI / sphere;
    std::array::from_fn(|index| {
        let (band, cosine) = match index {
            0 => (0, 1.0),
            1..4 => (1, 2.0 / 3.0),
            4..9 => (2, 0.25),
            _ => (4, -1.0 / 24.0),
        };
        let norm = NORMS[index] * NORMS[index];
        if band < bands { (sums[index] * (scale * cosine * norm)).extend(0.0) } else { Vec4::ZERO }
    })
}

/// The direction that addresses a cube texture: the shader's polynomials are of that one.
fn lookup(direction: Vec3) -> Vec3 {
    Vec3::new(direction.x, direction.y, -direction.z)
}

/// The basis without its factors; the same as in `shaders/environment.wgsl`.
fn polynomials(d: Vec3) -> [f32; COEFFICIENTS] {
    let Vec3 { x, y, z } = d;
    let (xx, yy, zz) = (x * x, y * y, z * z);
    [
        1.0,
        y,
        z,
        x,
        x * y,
        y * z,
        3.0 * zz - 1.0,
        x * z,
        xx - yy,
        x * y * (xx - yy),
        y * z * (3.0 * xx - yy),
        x * y * (7.0 * zz - 1.0),
        y * z * (7.0 * zz - 3.0),
        35.0 * zz * zz - 30.0 * zz + 3.0,
        x * z * (7.0 * zz - 3.0),
        (xx - yy) * (7.0 * zz - 1.0),
        x * z * (xx - 3.0 * yy),
        xx * (xx - 3.0 * yy) - yy * (3.0 * xx - yy),
    ]
}

/// Factors of the orthonormal real basis.
const NORMS: [f32; COEFFICIENTS] = [
    0.282_094_8,
    0.488_602_5,
    0.488_602_5,
    0.488_602_5,
    1.092_548_4,
    1.092_548_4,
    0.315_391_57,
    1.092_548_4,
    0.546_274_2,
    2.503_343,
    1.770_130_8,
    0.946_174_7,
    0.669_046_5,
    0.105_785_55,
    0.669_046_5,
    0.473_087_35,
    1.770_130_8,
    0.625_835_7,
];

#[cfg(test)]
mod tests {
    use super::super::cube::tests::panorama;
    use super::*;

    fn evaluate(coefficients: &[Vec4; COEFFICIENTS], direction: Vec3) -> Vec3 {
        let terms = polynomials(lookup(direction));
        coefficients.iter().zip(terms).map(|(c, term)| c.truncate() * term).sum()
    }

    #[test]
    fn the_basis_is_orthonormal() {
        let cube = Cube::new(&panorama(8, |_| Vec3::ONE), true, 64);
        for one in 0..COEFFICIENTS {
            for other in 0..=one {
                let (mut sum, mut sphere) = (0.0_f64, 0.0_f64);
                for index in 0..cube.texels.len() {
                    let (face, place) = (CubeFace::ALL[index / 4096], index % 4096);
                    let direction = Cube::direction(face, place % 64, place / 64, 64);
                    let at = 2.0 * (Vec2::new((place % 64) as f32, (place / 64) as f32) + 0.5) / 64.0 - 1.0;
                    let weight = f64::from((1.0 + at.length_squared()).powf(-1.5));
                    let basis = polynomials(direction);
                    sum += weight * f64::from(basis[one] * NORMS[one] * basis[other] * NORMS[other]);
                    sphere += weight;
                }
                let expected = if one == other { 1.0 } else { 0.0 };
                assert!((sum / sphere * 4.0 * std::f64::consts::PI - expected).abs() < 2e-3, "{one} {other} {sum}");
            }
        }
    }

    #[test]
    fn smooth_light_is_reflected_exactly_and_a_sun_to_the_stated_error() {
        let smooth = Cube::new(&panorama(256, |d| Vec3::new(1.0 + d.y, 2.0 + d.x * d.z, 1.0 + d.z)), true, 64);
        let direct = smooth.over_lobes(1.0, 8);
        let sun = Vec3::new(0.3, 0.8, -0.5).normalize();
        let sunny = Cube::new(&panorama(256, |d| Vec3::splat(if d.dot(sun) > 0.995 { 400.0 } else { 0.0 })), true, 64);
        let irradiance = sunny.over_lobes(1.0, 32);
        let peak = irradiance.texels.iter().map(|texel| texel.x).fold(0.0, f32::max);
        let worst = |exact: &Cube, coefficients: &[Vec4; COEFFICIENTS]| {
            let side = exact.side;
            let texels = exact.texels.iter().enumerate();
            texels
                .map(|(index, texel)| {
                    let (face, place) = (CubeFace::ALL[index / (side * side)], index % (side * side));
                    let direction = Cube::direction(face, place % side, place / side, side);
                    (evaluate(coefficients, direction) - *texel).abs().max_element()
                })
                .fold(0.0, f32::max)
        };
        assert!(worst(&direct, &reflected(&smooth, 3)) < 2e-3);
        // The largest error for light from one point, as a share of the largest irradiance: 1/4 with two bands (1/4 + x/2
        // at x = ±1), 3/32 with three and 15/256 with five (both at x = 0). There a disc of 0.1 radians is half above the
        // horizon, and sheds 2/(3π) of that angle.
        let seen = 2.0 / (3.0 * PI) * 0.1;
        for (bands, exact) in [(2, 0.25), (3, 3.0 / 32.0 - seen), (5, 15.0 / 256.0 - seen)] {
            let (low, high) = (0.85 * exact, 1.15 * exact);
            let error = worst(&irradiance, &reflected(&sunny, bands)) / peak;
            assert!((low..high).contains(&error), "{bands} bands: {error}");
        }
    }
}
