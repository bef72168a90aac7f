//! Lights as a point sees them.

use aam_scene::{Falloff, Light, LightKind};
use glam::{Vec2, Vec3};

use crate::extent::{self, Extent};
use crate::surface::or_zero;

/// A light with its constants worked out.
#[derive(Clone, Debug)]
pub(crate) struct Lamp {
    pub(crate) ambient: Vec3,
    pub(crate) diffuse: Vec3,
    pub(crate) specular: Vec3,
    /// `None` where the place or the direction is unusable: such a light is only ambient.
    source: Option<Source>,
    extent: Option<Extent>,
}

#[derive(Clone, Debug)]
enum Source {
    Directional { towards: Vec3 },
    Point { position: Vec3, falloff: Falloff, cone: Option<Cone> },
}

#[derive(Clone, Debug)]
struct Cone {
    axis: Vec3,
    cos_outer: f32,
    scale: f32,
}

/// What reaches a point from a light, or from a point of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Incident {
    /// Unit vector towards the light.
    pub(crate) towards: Vec3,
    /// Factor for falloff, cone and extent; may be 0.
    pub(crate) strength: f32,
    /// Distance to the light.
    pub(crate) distance: f32,
}

impl Lamp {
    /// `middle` is what flat point lights face.
    pub(crate) fn new(light: &Light, middle: Vec3, up: Vec3) -> Self {
        let color = |color: Vec3| Vec3::from_array(color.to_array().map(or_zero));
        let source = match light.kind {
            LightKind::Directional { direction } => {
                direction.try_normalize().map(|axis| Source::Directional { towards: -axis })
            }
            LightKind::Point { position, falloff } => {
                position.is_finite().then_some(Source::Point { position, falloff, cone: None })
            }
            LightKind::Spot { position, direction, inner, outer, falloff } => {
                direction.try_normalize().filter(|_| position.is_finite()).map(|axis| {
                    let cos_outer = outer.cos();
                    let scale = 1.0 / (inner.cos() - cos_outer).max(1e-3);
                    Source::Point { position, falloff, cone: Some(Cone { axis, cos_outer, scale }) }
                })
            }
        };
        let facing = source.as_ref().map(|source| match source {
            Source::Directional { towards } => -*towards,
            Source::Point { cone: Some(cone), .. } => cone.axis,
            Source::Point { position, .. } => (middle - position).normalize_or(Vec3::NEG_Z),
        });
        let extent = light.shape.as_ref().zip(facing).and_then(|(shape, facing)| Extent::new(shape, facing, up));
        let [ambient, diffuse, specular] = [light.ambient, light.diffuse, light.specular].map(color);
        Self { ambient, diffuse, specular, source, extent }
    }

    /// True where the light shines from more than one point.
    pub(crate) fn is_extended(&self) -> bool {
        self.extent.is_some()
    }

    /// From the middle of the light; `None` where only the ambient term reaches the point.
    pub(crate) fn at(&self, point: Vec3) -> Option<Incident> {
        self.from(point, Vec3::ZERO).filter(|incident| incident.strength > 0.0)
    }

    /// From one point of the light, chosen by a point of the unit square. The mean over the square is the light.
    pub(crate) fn sample(&self, point: Vec3, sample: Vec2) -> Option<Incident> {
        match self.extent? {
            Extent::Flat(flat) => self.from(point, flat.offset(sample)),
            Extent::Sphere(radius) => {
                let middle = self.from(point, Vec3::ZERO)?;
                let far = middle.distance.is_infinite();
                let sine = if far { radius } else { radius / middle.distance }.min(1.0);
                let seen = extent::cone(middle.towards, sine, sample);
                let distance = if far {
                    f32::INFINITY
                } else {
                    let aside = middle.distance * (seen.aside * (2.0 - seen.aside)).max(0.0).sqrt();
                    let deep = (radius * radius - aside * aside).max(0.0).sqrt();
                    (middle.distance * (1.0 - seen.aside) - deep).max(0.0)
                };
                Some(Incident { towards: seen.towards, strength: middle.strength * seen.weight, distance })
            }
        }
    }

    /// From a place beside the light's; for a light at infinity, as much to the side as at a distance of 1.
    fn from(&self, point: Vec3, beside: Vec3) -> Option<Incident> {
        match self.source.as_ref()? {
            Source::Directional { towards } => {
                Some(Incident { towards: (*towards + beside).normalize(), strength: 1.0, distance: f32::INFINITY })
            }
            Source::Point { position, falloff, cone } => {
                let offset = position + beside - point;
                let distance = offset.length();
                let towards = offset.try_normalize()?;
                let weakened = match falloff {
                    Falloff::None => 1.0,
                    Falloff::InverseSquare => 1.0 / (distance * distance).max(1e-4),
                };
                let inside = cone.as_ref().map_or(1.0, |cone| {
                    let slope = ((-towards).dot(cone.axis) - cone.cos_outer) * cone.scale;
                    slope.clamp(0.0, 1.0).powi(2)
                });
                Some(Incident { towards, strength: weakened * inside, distance })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use aam_scene::LightShape;

    use super::*;

    fn light(kind: LightKind) -> Light {
        Light { name: String::new(), kind, ambient: Vec3::ZERO, diffuse: Vec3::ONE, specular: Vec3::ONE, shape: None }
    }

    #[test]
    fn falloff_and_cone_follow_their_formulas() {
        let at = |kind: LightKind, point: Vec3| {
            Lamp::new(&light(kind), Vec3::ZERO, Vec3::Z).at(point).map(|incident| incident.strength)
        };
        let position = Vec3::new(0.0, 0.0, 4.0);
        let point = |falloff| LightKind::Point { position, falloff };
        assert_eq!(at(point(Falloff::None), Vec3::ZERO), Some(1.0));
        assert_eq!(at(point(Falloff::InverseSquare), Vec3::ZERO), Some(1.0 / 16.0));
        assert_eq!(at(point(Falloff::InverseSquare), Vec3::new(0.0, 0.0, 3.999)), Some(1e4));
        assert_eq!(at(point(Falloff::None), position), None);

        let spot = LightKind::Spot {
            position,
            direction: Vec3::new(0.0, 0.0, -2.0),
            inner: 0.3,
            outer: 0.5,
            falloff: Falloff::None,
        };
        let below = |angle: f32| Vec3::new(4.0 * angle.tan(), 0.0, 0.0);
        assert_eq!(at(spot.clone(), below(0.29)), Some(1.0));
        assert_eq!(at(spot.clone(), below(0.51)), None);
        let expected = ((0.4_f32.cos() - 0.5_f32.cos()) / (0.3_f32.cos() - 0.5_f32.cos())).powi(2);
        assert!((at(spot, below(0.4)).unwrap() - expected).abs() < 1e-5);
    }

    #[test]
    fn unusable_lights_are_only_ambient() {
        let nowhere = LightKind::Point { position: Vec3::NAN, falloff: Falloff::None };
        let aimless = LightKind::Directional { direction: Vec3::ZERO };
        for kind in [nowhere, aimless] {
            let mut light = light(kind);
            light.ambient = Vec3::new(0.5, -1.0, f32::NAN);
            light.shape = Some(LightShape::Disc { radius: 1.0 });
            let lamp = Lamp::new(&light, Vec3::ZERO, Vec3::Z);
            assert_eq!((lamp.at(Vec3::X), lamp.ambient), (None, Vec3::new(0.5, 0.0, 0.0)));
            assert!(!lamp.is_extended());
        }
    }
}
