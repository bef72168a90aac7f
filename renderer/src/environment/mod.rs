//! Light from all around: what `docs/techniques/shading.md`, section 11, means on the GPU.
//!
//! Diffuse light is a small cube of exact means, or coefficients of spherical harmonics. Specular light is a cube whose
//! levels are means over Phong lobes, each twice as wide as the one before; for mirrors, over texels. All of it is made on
//! the CPU, so that every device has the same, once for each map and choice of [`EnvironmentDetail`], and only what the
//! scene asks for. Cost, error and limits stand in `docs/techniques/environment.md`.

mod cube;
mod harmonics;
mod table;

use aam_scene::{Environment, Projection, Scene, Shading, SpecularFilter, Up, View};
use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Vec3, Vec4};

pub(crate) use table::{EnvironmentTable, Wanted};

/// How finely an environment is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EnvironmentDetail {
    /// How diffuse light is kept.
    pub diffuse: DiffuseLight,
    /// The largest side of a face of the specular map in texels, a power of two from 4 to 2048. A smaller picture gets a
    /// smaller one. Default 256.
    pub specular_size: u32,
    /// The most levels of the specular map, the sharp one included; exponents below that of the last reflect as it does.
    /// Default 12, which is all of them.
    pub specular_levels: u32,
}

/// How diffuse light is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DiffuseLight {
    /// A cube of exact means, with so many texels along a face: a power of two from 2 to 256. Default, with 16.
    Cube(u32),
    /// Spherical harmonics of so many bands: 2, 3 or 5 (for the clamped cosine has nothing in band 3). Light from one point
    /// has an error of up to 25 %, 9.4 % and 5.9 % of its peak.
    Harmonics(u32),
}

impl Default for EnvironmentDetail {
    fn default() -> Self {
        Self { diffuse: DiffuseLight::Cube(16), specular_size: 256, specular_levels: 12 }
    }
}

impl EnvironmentDetail {
    /// The same with every number brought to the nearest that is offered.
    pub(crate) fn usable(self) -> Self {
        let power = |side: u32, least: u32, most: u32| (side.clamp(least, most) + 1).next_power_of_two() / 2;
        let power = |side, least: u32, most| power(side, least, most).max(least);
        Self {
            diffuse: match self.diffuse {
                DiffuseLight::Cube(side) => DiffuseLight::Cube(power(side, 2, 256)),
                DiffuseLight::Harmonics(bands) => DiffuseLight::Harmonics(match bands {
                    0..=2 => 2,
                    3 | 4 => 3,
                    _ => 5,
                }),
            },
            specular_size: power(self.specular_size, 4, 2048),
            specular_levels: self.specular_levels.clamp(1, 12),
        }
    }
}

/// The width of a level's lobe (the square root of 1 over its exponent) in texels of that level.
const LOBE_TEXELS: f32 = 1.5;

/// The smallest face of a level of lobes.
const SMALLEST_LOBE_SIDE: u32 = 4;

/// The exponent of level 1 of a specular map; that of each further level is a quarter of it.
fn first_exponent(side: u32) -> f32 {
    let width = LOBE_TEXELS * std::f32::consts::FRAC_PI_2 / (0.5 * side as f32);
    1.0 / (width * width)
}

/// What an environment does to surfaces: constants of pipelines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct EnvironmentTerms {
    /// 0 off, 1 cube, otherwise bands of spherical harmonics.
    pub diffuse: u32,
    /// 0 off, 1 mirror, 2 Phong.
    pub specular: u32,
}

impl EnvironmentTerms {
    pub(crate) fn new(environment: &Environment, detail: &EnvironmentDetail, shading: Shading) -> Self {
        let diffuse = match detail.diffuse {
            DiffuseLight::Cube(_) => 1,
            DiffuseLight::Harmonics(bands) => bands,
        };
        let specular = match environment.filter_for(shading) {
            SpecularFilter::Mirror => 1,
            SpecularFilter::Phong => 2,
        };
        Self {
            diffuse: if environment.diffuse { diffuse } else { 0 },
            specular: if environment.specular { specular } else { 0 },
        }
    }
}

/// `Environment` in `shaders/environment.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct EnvironmentUniform {
    /// Columns of the matrix from world directions to those that address a cube texture.
    lookup: [Vec4; 3],
    factor: f32,
    first_exponent: f32,
    last_level: f32,
    padding: f32,
    harmonics: [Vec4; harmonics::COEFFICIENTS],
}

/// `Sky` in `shaders/sky.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct SkyUniform {
    /// Direction through the middle of the picture.
    middle: Vec3,
    /// Intensity times exposure.
    factor: f32,
    /// From there to the right edge and to the upper one.
    right: Vec4,
    up: Vec4,
}

impl SkyUniform {
    pub(crate) fn new(environment: &Environment, scene: &Scene, view: &View) -> Self {
        let to_lookup = lookup(environment, scene.up);
        let matrix = view.camera.view();
        let row = |index: usize| to_lookup * matrix.row(index).truncate();
        let half = match view.camera.projection {
            Projection::Perspective { fov_y } => (0.5 * fov_y).tan(),
            // Parallel rays all see the same.
            Projection::Orthographic { .. } => 0.0,
        };
        Self {
            middle: -row(2),
            factor: environment.factor() * aam_scene::exposure_factor(scene.exposure),
            right: (row(0) * half * view.aspect()).extend(0.0),
            up: (row(1) * half).extend(0.0),
        }
    }
}

/// From world directions to those that address a cube texture, whose frame is left-handed.
fn lookup(environment: &Environment, up: Up) -> Mat3 {
    Mat3::from_diagonal(Vec3::new(1.0, 1.0, -1.0)) * environment.map_from_world(up)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_those_of_the_shaders() {
        assert_eq!((size_of::<EnvironmentUniform>(), size_of::<SkyUniform>()), (352, 48));
    }

    #[test]
    fn details_are_brought_to_what_is_offered() {
        let odd = |diffuse, size, levels| {
            EnvironmentDetail { diffuse, specular_size: size, specular_levels: levels }.usable()
        };
        assert_eq!(EnvironmentDetail::default().usable(), EnvironmentDetail::default());
        assert_eq!(
            odd(DiffuseLight::Cube(0), 0, 0),
            EnvironmentDetail { diffuse: DiffuseLight::Cube(2), specular_size: 4, specular_levels: 1 }
        );
        assert_eq!(odd(DiffuseLight::Cube(300), u32::MAX, 99).specular_size, 2048);
        assert_eq!(odd(DiffuseLight::Cube(100), 300, 3).diffuse, DiffuseLight::Cube(64));
        assert_eq!(odd(DiffuseLight::Cube(16), 300, 3).specular_size, 256);
        for (bands, offered) in [(0, 2), (2, 2), (4, 3), (9, 5)] {
            assert_eq!(odd(DiffuseLight::Harmonics(bands), 64, 1).diffuse, DiffuseLight::Harmonics(offered));
        }
    }
}
