//! What of a scene's shadows can be seen at all.

use std::collections::BTreeSet;

use aam_reference::{LightSize, Options, Tracer};
use aam_scene::{Light, LightKind, LightShape, NodeId, Scene, View};
use glam::{Mat4, Vec2, Vec3};

use crate::LabError;

/// Rays to a light with a size, for each pixel that it darkens.
const RAYS: u32 = 16;

/// What of a scene's shadows some views see.
#[derive(Clone, Debug, PartialEq)]
pub struct Needs {
    /// How many views were looked through.
    pub views: usize,
    /// Each of the scene's lights, in their order.
    pub lights: Vec<SourceNeeds>,
}

/// What of a light's shadow some views see.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SourceNeeds {
    /// Pixels, over all views, that face the light.
    pub faces: usize,
    /// Those of them that do not see all of it, as large as it is.
    pub darkened: usize,
    /// The nodes that stand in the way.
    pub casters: Vec<NodeId>,
}

impl Needs {
    /// Looks through all views, with one ray a pixel and [`RAYS`] from there to each light that has a size.
    ///
    /// A node is no caster if on each of these rays a triangle that lets nothing through is nearer to the light: without
    /// it each ray is as blocked as before. What falls between the rays is not seen.
    ///
    /// # Errors
    /// The reference cannot draw the scene.
    pub fn of(scene: &Scene, views: &[View]) -> Result<Self, LabError> {
        let mut lights = vec![(SourceNeeds::default(), BTreeSet::new()); scene.lights.len()];
        let bounds = scene.bounds();
        for view in views {
            let options = Options { light_samples: RAYS, ..Options::default() };
            let (visibility, _) = aam_reference::visibility(scene, view, LightSize::Area, &options)?;
            let tracer = Tracer::new(scene, view.frame)?;
            let rays = Rays::new(view);
            for ((light, seen), (needs, casters)) in scene.lights.iter().zip(&visibility.lights).zip(&mut lights) {
                for (index, seen) in seen.iter().enumerate() {
                    let Some(seen) = seen else { continue };
                    needs.faces += 1;
                    if seen.share >= 1.0 {
                        continue;
                    }
                    needs.darkened += 1;
                    let pixel = Vec2::new((index % view.width as usize) as f32, (index / view.width as usize) as f32);
                    let (origin, direction) = rays.through(pixel + 0.5);
                    // The first surface may be one that is looked through; what lies behind it has the same light in its way
                    // from its own place.
                    let Some(distance) = tracer.nearest(origin, direction) else { continue };
                    let spot = origin + distance * direction;
                    for ray in 0..RAYS {
                        let Some(from) = light_point(light, spot, ray, &bounds) else { continue };
                        // Short of the surface itself.
                        tracer.along(from, spot - from, 1.0 - 1e-4, |node| {
                            casters.insert(node);
                        });
                    }
                }
            }
        }
        let lights =
            lights.into_iter().map(|(needs, casters)| SourceNeeds { casters: casters.into_iter().collect(), ..needs });
        Ok(Self { views: views.len(), lights: lights.collect() })
    }

    /// The nodes that stand in the way of any light.
    pub fn casters(&self) -> Vec<NodeId> {
        let all: BTreeSet<NodeId> = self.lights.iter().flat_map(|needs| needs.casters.iter().copied()).collect();
        all.into_iter().collect()
    }
}

/// Rays from a camera through a picture.
struct Rays {
    world_from_clip: Mat4,
    size: Vec2,
}

impl Rays {
    fn new(view: &View) -> Self {
        let clip = view.camera.projection_matrix(view.aspect()) * view.camera.view();
        Self { world_from_clip: clip.inverse(), size: Vec2::new(view.width as f32, view.height as f32) }
    }

    /// From the near plane; 1 is a length on the way to the far plane.
    fn through(&self, pixel: Vec2) -> (Vec3, Vec3) {
        let ndc = 2.0 * pixel / self.size - 1.0;
        let near = self.world_from_clip.project_point3(Vec3::new(ndc.x, -ndc.y, 0.0));
        let far = self.world_from_clip.project_point3(Vec3::new(ndc.x, -ndc.y, 1.0));
        (near, far - near)
    }
}

/// A point of the ball or disc around a light; the first is its middle. A light that is far away stands behind everything.
fn light_point(light: &Light, spot: Vec3, index: u32, bounds: &aam_scene::Aabb) -> Option<Vec3> {
    let radius = match light.shape {
        None => 0.0,
        Some(LightShape::Disc { radius } | LightShape::Sphere { radius }) => radius,
        Some(LightShape::Rectangle { width, height }) => 0.5 * width.hypot(height),
    };
    let (middle, towards) = match light.kind {
        LightKind::Point { position, .. } | LightKind::Spot { position, .. } => (position, position - spot),
        LightKind::Directional { direction } => {
            let towards = -direction.try_normalize()?;
            let far = bounds.diagonal().max(1.0) + spot.distance(bounds.center());
            // The shape stands one metre from the viewer.
            return Some(spot + far * (towards + aside(towards, radius, index)));
        }
    };
    if index > 0 && radius == 0.0 {
        return None;
    }
    Some(middle + aside(towards.try_normalize()?, radius, index))
}

/// A point of a disc across a direction, spread evenly by the golden angle; the first is the middle.
fn aside(towards: Vec3, radius: f32, index: u32) -> Vec3 {
    let (u, v) = towards.any_orthonormal_pair();
    let distance = radius * (index as f32 / RAYS.saturating_sub(1).max(1) as f32).sqrt();
    let angle = 2.399_963_2 * index as f32;
    distance * (angle.cos() * u + angle.sin() * v)
}
