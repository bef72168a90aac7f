//! Light from all around: a panorama or the six faces of a cube, and in which direction each of their points lies.
//!
//! Directions here are those of the map's own frame: x to the right, y up, and the middle of the picture at −z.
//! [`Environment::map_from_world`] leads there from the world.

mod directions;
mod map;
mod sample;

use std::sync::Arc;

use glam::{Mat3, Vec3};
use serde::{Deserialize, Serialize};

use crate::{Shading, Up};

pub use directions::{CubeFace, cube_direction, cube_point, panorama_direction, panorama_point};
pub use map::{EnvironmentMap, EnvironmentPictures, MapLayout, load_environment};

/// Light that reaches surfaces from all around, infinitely far away.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// The light from each direction.
    pub map: Arc<EnvironmentMap>,
    /// It lights the diffuse terms of materials.
    pub diffuse: bool,
    /// Surfaces with a specular term reflect it.
    pub specular: bool,
    /// How sharply; `None` leaves it to the shading: [`SpecularFilter::Mirror`] for [`Shading::Source`],
    /// [`SpecularFilter::Phong`] for [`Shading::Linear`].
    pub filter: Option<SpecularFilter>,
    /// Turn about the scene's up axis in radians, counter-clockwise seen from above.
    pub rotation: f32,
    /// Factor for all of it, not negative.
    pub intensity: f32,
}

/// How sharply surfaces reflect an environment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SpecularFilter {
    /// Every surface with a specular term is a mirror, whatever its exponent, as in VR3Lib.
    Mirror,
    /// The mean over the Phong lobe of the material's exponent.
    Phong,
}

/// How light becomes a colour that can be shown, after exposure and for each fragment. The formulas stand in
/// `docs/techniques/shading.md`, section 5.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ToneMap {
    /// Each channel is cut at 1, as in VR3Lib.
    #[default]
    Clamp,
    /// `c / (1 + c)` for each channel (Reinhard et al., "Photographic Tone Reproduction", 2002, eq. 3).
    Reinhard,
    /// The film-like curve of the Academy Color Encoding System, in S. Hill's fit.
    Aces,
    /// Khronos PBR Neutral (2024): colours below 0.76 keep their hue and nearly their value.
    Neutral,
}

/// The most that exposure can be, in stops up or down.
pub const MAX_EXPOSURE: f32 = 32.0;

/// The factor of an exposure in stops; 1 where it is not a number.
pub fn exposure_factor(stops: f32) -> f32 {
    if stops.is_nan() { 1.0 } else { stops.clamp(-MAX_EXPOSURE, MAX_EXPOSURE).exp2() }
}

impl Environment {
    /// Diffuse and specular light, as it comes.
    pub fn new(map: Arc<EnvironmentMap>) -> Self {
        Self { map, diffuse: true, specular: true, filter: None, rotation: 0.0, intensity: 1.0 }
    }

    /// True where it takes the place of lights.
    pub fn is_lit_by(&self) -> bool {
        self.diffuse || self.specular
    }

    /// The filter that a shading asks for.
    pub fn filter_for(&self, shading: Shading) -> SpecularFilter {
        self.filter.unwrap_or(match shading {
            Shading::Source => SpecularFilter::Mirror,
            Shading::Linear => SpecularFilter::Phong,
        })
    }

    /// The intensity; 0 where it is negative or not a number, and never infinite.
    pub fn factor(&self) -> f32 {
        if self.intensity > 0.0 { self.intensity.min(1e6) } else { 0.0 }
    }

    /// From directions in the world to those of the map.
    pub fn map_from_world(&self, up: Up) -> Mat3 {
        let rotation = if self.rotation.is_finite() { self.rotation } else { 0.0 };
        let level = match up {
            Up::Y => Mat3::IDENTITY,
            // x stays, y leads away from the viewer at the front, z is up.
            Up::Z => Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y),
        };
        Mat3::from_rotation_y(-rotation) * level
    }
}

#[cfg(test)]
mod tests;
