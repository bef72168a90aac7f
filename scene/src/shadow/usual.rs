//! Shadows of a scene that says nothing about them.

use glam::Vec3;

use super::{ShadowLayout, ShadowSettings, ShadowSource, ShadowTechnique, Shadows};
use crate::{Aabb, Light, LightKind, Scene};

/// The widest view of one map, in radians: what a light sees under a wider angle takes the six maps of a cube.
const WIDEST: f32 = 2.1;

impl Shadows {
    /// The shadow of each light that lights anything, computed in the same way. Who casts and receives, and what may be
    /// left out, stays as the scene has it. `settings` are those of one map; a light that stands among what it lights
    /// gets a cube where its technique can be laid out as one.
    pub fn of_lights(scene: &Scene, settings: ShadowSettings) -> Self {
        let bounds = scene.bounds();
        let lit = scene.lights.iter().enumerate().filter(|(_, light)| light.diffuse.max(light.specular) != Vec3::ZERO);
        let sources = lit.map(|(index, light)| ShadowSource {
            name: if light.name.is_empty() { format!("light {}", index + 1) } else { light.name.clone() },
            ..ShadowSource::of_light(index, laid_out(settings, light, &bounds))
        });
        Self { sources: sources.collect(), ..scene.shadows.clone().unwrap_or_default() }
    }
}

/// The settings with the layout that a light needs, if it has been left open.
fn laid_out(settings: ShadowSettings, light: &Light, bounds: &Aabb) -> ShadowSettings {
    let cube = ShadowTechnique { layout: ShadowLayout::Cube, ..settings.technique };
    if settings.technique.layout == ShadowLayout::One && cube.exists() && angle(light, bounds) > WIDEST {
        ShadowSettings { technique: cube, ..settings }
    } else {
        settings
    }
}

/// The angle of the cone in which a light sees all of a box, or all that it lights.
fn angle(light: &Light, bounds: &Aabb) -> f32 {
    match light.kind {
        LightKind::Directional { .. } => 0.0,
        LightKind::Spot { outer, .. } => 2.0 * outer,
        LightKind::Point { position, .. } => {
            if bounds.is_empty() {
                return 0.0;
            }
            let axis = (bounds.center() - position).normalize_or_zero();
            let half = bounds.corners().into_iter().map(|corner| {
                let towards = (corner - position).normalize_or_zero();
                towards.dot(axis).clamp(-1.0, 1.0).acos()
            });
            2.0 * half.fold(0.0, f32::max)
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Affine3A;

    use super::*;
    use crate::{Falloff, Members, Mesh, MeshId, Node, NodeId};

    fn scene(kinds: &[LightKind]) -> Scene {
        let positions = vec![Vec3::splat(-1.0), Vec3::ONE];
        let mesh = Mesh { bounds: Aabb::of(positions.clone()), positions, ..Mesh::default() };
        let light = |kind: &LightKind| Light {
            name: String::new(),
            kind: kind.clone(),
            ambient: Vec3::ONE,
            diffuse: Vec3::ONE,
            specular: Vec3::ZERO,
            shape: None,
        };
        let local = Affine3A::IDENTITY;
        Scene {
            nodes: vec![Node { name: String::new(), parent: None, local, mesh: Some(MeshId(0)), visible: true }],
            meshes: vec![Arc::new(mesh)],
            lights: kinds.iter().map(light).collect(),
            ..Scene::default()
        }
    }

    #[test]
    fn lights_among_what_they_light_get_cubes() {
        let point = |position| LightKind::Point { position, falloff: Falloff::None };
        let spot = |outer| LightKind::Spot {
            position: Vec3::Z * 9.0,
            direction: Vec3::NEG_Z,
            inner: 0.1,
            outer,
            falloff: Falloff::None,
        };
        let kinds = [
            point(Vec3::ZERO),
            point(Vec3::Z * 1.5),
            point(Vec3::Z * 5.0),
            spot(0.5),
            spot(1.3),
            LightKind::Directional { direction: Vec3::NEG_Z },
        ];
        let techniques = |text: &str| -> Vec<String> {
            let shadows = Shadows::of_lights(&scene(&kinds), text.parse().unwrap());
            shadows.sources.iter().map(|source| source.settings.to_string()).collect()
        };
        let (one, cube) = ("pcf:radius=3", "cube-pcf:radius=3");
        assert_eq!(techniques(one), [cube, cube, one, one, cube, one]);
        assert_eq!(techniques("csm-pcf"), ["csm-pcf"; 6], "a layout that was named stays");
        assert_eq!(techniques("pcss"), ["pcss"; 6], "what cannot be a cube stays");
    }

    #[test]
    fn only_lights_that_light_have_shadows_and_members_stay() {
        let sun = LightKind::Directional { direction: Vec3::NEG_Z };
        let mut scene = scene(&[sun.clone(), sun]);
        scene.lights[0].diffuse = Vec3::ZERO;
        scene.lights[1].name = "sun".into();
        let casters = Members::Only(vec![NodeId(0)]);
        scene.shadows = Some(Shadows { casters: casters.clone(), ..Shadows::default() });
        let shadows = Shadows::of_lights(&scene, ShadowSettings::default());
        let sources: Vec<_> = shadows.sources.iter().map(|source| (source.name.as_str(), source.light)).collect();
        assert_eq!((sources, shadows.casters), (vec![("sun", Some(1))], casters));
    }
}
