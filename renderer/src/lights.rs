//! Lights as the shaders see them.

use aam_scene::{Falloff, Light, LightKind};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use crate::RenderError;
use crate::shader::LightKinds;

/// Most lights that a frame can have.
pub const MAX_LIGHTS: usize = 64;

/// `Light` in `shaders/lights.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct GpuLight {
    diffuse: Vec3,
    inverse_square: f32,
    specular: Vec3,
    cone_outer: f32,
    place: Vec3,
    cone_scale: f32,
    direction: Vec3,
    padding: f32,
}

/// `Lights` in `shaders/lights.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuLights {
    ambient: Vec3,
    point_end: u32,
    directional_end: u32,
    spot_end: u32,
    padding: [u32; 2],
    list: [GpuLight; MAX_LIGHTS],
}

/// Packs a scene's lights, relative to the eye. Lights that shed only ambient light, or whose place is no place, count
/// in the sum of ambient colours alone.
pub(crate) fn pack(lights: &[Light], eye: Vec3) -> Result<(GpuLights, LightKinds), RenderError> {
    if lights.len() > MAX_LIGHTS {
        return Err(RenderError::TooManyLights { count: lights.len() });
    }
    let mut packed = GpuLights::zeroed();
    let mut kinds = LightKinds::default();
    let mut by_kind: [Vec<GpuLight>; 3] = Default::default();
    for light in lights {
        packed.ambient += color(light.ambient);
        let base = GpuLight { diffuse: color(light.diffuse), specular: color(light.specular), ..Default::default() };
        if base.diffuse == Vec3::ZERO && base.specular == Vec3::ZERO {
            continue;
        }
        match light.kind {
            LightKind::Point { position, falloff } if position.is_finite() => {
                kinds.point = true;
                by_kind[0].push(GpuLight { place: position - eye, ..base.weakening(falloff, &mut kinds) });
            }
            LightKind::Directional { direction } => {
                if let Some(direction) = direction.try_normalize() {
                    kinds.directional = true;
                    by_kind[1].push(GpuLight { place: -direction, ..base });
                }
            }
            LightKind::Spot { position, direction, inner, outer, falloff } if position.is_finite() => {
                if let (Some(direction), true) = (direction.try_normalize(), inner.is_finite() && outer.is_finite()) {
                    kinds.spot = true;
                    by_kind[2].push(GpuLight {
                        place: position - eye,
                        direction,
                        cone_outer: outer.cos(),
                        cone_scale: 1.0 / (inner.cos() - outer.cos()).max(1e-3),
                        ..base.weakening(falloff, &mut kinds)
                    });
                }
            }
            LightKind::Point { .. } | LightKind::Spot { .. } => {}
        }
    }
    let mut ends = [0; 3];
    let mut count = 0;
    for (end, list) in ends.iter_mut().zip(&by_kind) {
        packed.list[count..count + list.len()].copy_from_slice(list);
        count += list.len();
        *end = count as u32;
    }
    [packed.point_end, packed.directional_end, packed.spot_end] = ends;
    Ok((packed, kinds))
}

impl GpuLight {
    fn weakening(self, falloff: Falloff, kinds: &mut LightKinds) -> Self {
        match falloff {
            Falloff::None => self,
            Falloff::InverseSquare => {
                kinds.falloff = true;
                Self { inverse_square: 1.0, ..self }
            }
        }
    }
}

/// A colour that can be computed with: no component negative or not finite.
pub(crate) fn color(color: Vec3) -> Vec3 {
    Vec3::from_array(color.to_array().map(|c| if c.is_finite() { c.max(0.0) } else { 0.0 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(position: Vec3) -> Light {
        Light {
            name: String::new(),
            kind: LightKind::Point { position, falloff: Falloff::None },
            ambient: Vec3::splat(0.1),
            diffuse: Vec3::ONE,
            specular: Vec3::ONE,
            shape: None,
        }
    }

    #[test]
    fn layout_is_that_of_the_shader() {
        assert_eq!(size_of::<GpuLight>(), 64);
        assert_eq!(size_of::<GpuLights>(), 32 + 64 * MAX_LIGHTS);
    }

    #[test]
    fn lights_are_grouped_by_kind_in_their_order() {
        let directional = |direction| Light { kind: LightKind::Directional { direction }, ..point(Vec3::ZERO) };
        let lights = [directional(Vec3::X), point(Vec3::ONE), directional(Vec3::Z), point(Vec3::X)];
        let (packed, kinds) = pack(&lights, Vec3::ONE).unwrap();
        assert_eq!((packed.point_end, packed.directional_end, packed.spot_end), (2, 4, 4));
        assert_eq!(
            packed.list[..4].map(|light| light.place),
            [Vec3::ZERO, Vec3::new(0.0, -1.0, -1.0), Vec3::NEG_X, Vec3::NEG_Z]
        );
        assert_eq!(kinds, LightKinds { point: true, directional: true, spot: false, falloff: false });
    }

    #[test]
    fn lights_without_a_place_keep_their_ambient_colour() {
        let lights = [
            point(Vec3::NAN),
            Light { kind: LightKind::Directional { direction: Vec3::ZERO }, ..point(Vec3::ZERO) },
            Light { diffuse: Vec3::ZERO, specular: Vec3::splat(f32::NAN), ..point(Vec3::ZERO) },
        ];
        let (packed, kinds) = pack(&lights, Vec3::ZERO).unwrap();
        assert!((packed.ambient - Vec3::splat(0.3)).length() < 1e-6);
        assert!(!kinds.any() && packed.spot_end == 0);
    }

    #[test]
    fn one_light_too_many_is_an_error() {
        assert!(pack(&vec![point(Vec3::ONE); MAX_LIGHTS], Vec3::ZERO).is_ok());
        let error = pack(&vec![point(Vec3::ONE); MAX_LIGHTS + 1], Vec3::ZERO).err().unwrap();
        assert!(error.to_string().contains("65 lights; at most 64"), "{error}");
    }
}
