//! Lights as the shaders see them.

use aam_scene::{Falloff, Light, LightKind};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use crate::RenderError;

/// Most lights that a frame can have.
pub const MAX_LIGHTS: usize = 64;

/// `Light` in `shaders/lights.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuLight {
    diffuse: Vec3,
    inverse_square: f32,
    specular: Vec3,
    cone_outer: f32,
    place: Vec3,
    cone_scale: f32,
    direction: Vec3,
    padding: f32,
}

/// `lights` in `shaders/lights.wgsl`.
pub(crate) type GpuLights = [GpuLight; MAX_LIGHTS];

/// Where each kind of light ends in the list, which begins with point lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct LightEnds {
    pub point: u32,
    pub directional: u32,
    pub spot: u32,
}

/// A scene's lights as the shaders see them.
#[derive(Clone, Debug)]
pub(crate) struct PackedLights {
    pub list: GpuLights,
    pub ends: LightEnds,
    /// Some weaken with distance.
    pub falloff: bool,
    /// Sum of all ambient colours.
    pub ambient: Vec3,
    /// The place in the list of each of the scene's lights that is there.
    pub order: Vec<Option<u8>>,
}

/// Packs a scene's lights, relative to the eye. Lights that shed only ambient light, or whose place is no place, count
/// in the sum of ambient colours alone.
pub(crate) fn pack(lights: &[Light], eye: Vec3) -> Result<PackedLights, RenderError> {
    if lights.len() > MAX_LIGHTS {
        return Err(RenderError::TooManyLights { count: lights.len() });
    }
    let mut packed = PackedLights {
        list: GpuLights::zeroed(),
        ends: LightEnds::default(),
        falloff: false,
        ambient: Vec3::ZERO,
        order: vec![None; lights.len()],
    };
    let mut by_kind: [Vec<GpuLight>; 3] = Default::default();
    // Kind and place among its like.
    let mut places: Vec<(usize, usize, usize)> = Vec::new();
    for (number, light) in lights.iter().enumerate() {
        let before = [0, 1, 2].map(|kind: usize| by_kind[kind].len());
        packed.ambient += color(light.ambient);
        let base = GpuLight { diffuse: color(light.diffuse), specular: color(light.specular), ..Default::default() };
        if base.diffuse == Vec3::ZERO && base.specular == Vec3::ZERO {
            continue;
        }
        match light.kind {
            LightKind::Point { position, falloff } if position.is_finite() => {
                by_kind[0].push(GpuLight { place: position - eye, ..base.weakening(falloff, &mut packed.falloff) });
            }
            LightKind::Directional { direction } => {
                if let Some(direction) = direction.try_normalize() {
                    by_kind[1].push(GpuLight { place: -direction, ..base });
                }
            }
            LightKind::Spot { position, direction, inner, outer, falloff } if position.is_finite() => {
                if let (Some(direction), true) = (direction.try_normalize(), inner.is_finite() && outer.is_finite()) {
                    by_kind[2].push(GpuLight {
                        place: position - eye,
                        direction,
                        cone_outer: outer.cos(),
                        cone_scale: 1.0 / (inner.cos() - outer.cos()).max(1e-3),
                        ..base.weakening(falloff, &mut packed.falloff)
                    });
                }
            }
            LightKind::Point { .. } | LightKind::Spot { .. } => {}
        }
        let added = (0..3).find(|&kind| by_kind[kind].len() > before[kind]);
        places.extend(added.map(|kind| (number, kind, before[kind])));
    }
    let mut count = 0;
    let mut place = |kind: &[GpuLight]| {
        packed.list[count..count + kind.len()].copy_from_slice(kind);
        count += kind.len();
        count as u32
    };
    let [point, directional, spot] = &by_kind;
    packed.ends = LightEnds { point: place(point), directional: place(directional), spot: place(spot) };
    let starts = [0, packed.ends.point, packed.ends.directional];
    for (number, kind, place) in places {
        packed.order[number] = u8::try_from(starts[kind] as usize + place).ok();
    }
    Ok(packed)
}

impl GpuLight {
    fn weakening(self, falloff: Falloff, any: &mut bool) -> Self {
        match falloff {
            Falloff::None => self,
            Falloff::InverseSquare => {
                *any = true;
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
    }

    #[test]
    fn lights_are_grouped_by_kind_in_their_order() {
        let directional = |direction| Light { kind: LightKind::Directional { direction }, ..point(Vec3::ZERO) };
        let lights = [directional(Vec3::X), point(Vec3::ONE), directional(Vec3::Z), point(Vec3::X)];
        let packed = pack(&lights, Vec3::ONE).unwrap();
        assert_eq!(packed.ends, LightEnds { point: 2, directional: 4, spot: 4 });
        let places: [Vec3; 4] = std::array::from_fn(|light| packed.list[light].place);
        assert_eq!(places, [Vec3::ZERO, Vec3::new(0.0, -1.0, -1.0), Vec3::NEG_X, Vec3::NEG_Z]);
        assert_eq!(packed.order, [Some(2), Some(0), Some(3), Some(1)]);
        assert!(!packed.falloff);
    }

    #[test]
    fn lights_without_a_place_keep_their_ambient_colour() {
        let lights = [
            point(Vec3::NAN),
            Light { kind: LightKind::Directional { direction: Vec3::ZERO }, ..point(Vec3::ZERO) },
            Light { diffuse: Vec3::ZERO, specular: Vec3::splat(f32::NAN), ..point(Vec3::ZERO) },
        ];
        let packed = pack(&lights, Vec3::ZERO).unwrap();
        assert!((packed.ambient - Vec3::splat(0.3)).length() < 1e-6);
        assert_eq!(packed.ends, LightEnds::default());
    }

    #[test]
    fn one_light_too_many_is_an_error() {
        assert!(pack(&vec![point(Vec3::ONE); MAX_LIGHTS], Vec3::ZERO).is_ok());
        let error = pack(&vec![point(Vec3::ONE); MAX_LIGHTS + 1], Vec3::ZERO).err().unwrap();
        assert!(error.to_string().contains("65 lights; at most 64"), "{error}");
    }
}
