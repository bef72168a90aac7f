//! Lights and cameras for the scene file.
//!
//! **Intensity.** glTF's lights have photometric units: candela for points and spots, lux for directions. A white
//! diffuse surface under E lux sends E/π back, and in AAM it sends back the light's diffuse colour; so a light's colour
//! is `color · intensity / π`, falling off with the inverse square (1 candela is 1 lux at one metre). Colours stay
//! linear, and ambient is 0. Scenes with lights in the thousands are meant for an exposure, which AAM does not have;
//! the report says so.

use std::f32::consts::PI;

use aam_scene::{Camera, Falloff, Light, LightKind, Projection};
use glam::{DAffine3, DVec3, Vec3};

use crate::Asset;

use super::clip::Clip;
use super::graph::{Graph, to_aam};
use super::log::Log;
use super::model::{self, Lens, Model};
use super::stage::Moment;

/// Light colours above this need an exposure.
const GLARING: f32 = 20.0;

/// The widest field of view in radians.
const WIDEST: f32 = 3.1;

/// Adds the scene's lights and cameras to the asset. `bounds` is the box around everything, in AAM's axes.
pub(super) fn add(
    model: &Model,
    graph: &Graph,
    moment: &Moment,
    clip: Option<&Clip>,
    bounds: Option<[DVec3; 2]>,
    asset: &mut Asset,
    log: &mut Log,
) {
    let mut moving = clip.map_or_else(|| vec![false; model.nodes.len()], |clip| clip.moving(&moment.locals));
    for &node in &graph.order {
        if let Some(parent) = graph.parents[node] {
            moving[node] |= moving[parent];
        }
    }
    let mut brightest = 0.0_f32;
    for &node in &graph.scene {
        let own = &model.nodes[node];
        let world = &moment.worlds[node];
        if let Some(light) = own.light {
            let light = &model.lights[light];
            let name = light.name.clone().or_else(|| own.name.clone()).unwrap_or_else(|| format!("light {node}"));
            if light.range.is_some() {
                log.lost(&format!("light {name:?}"), "light range", "the light falls off with the inverse square only");
            }
            if moving[node] {
                log.lost(&format!("light {name:?}"), "light animation", "it stands where it is at the start");
            }
            let light = self::light(light, name, world);
            brightest = brightest.max(light.diffuse.max_element());
            asset.lights.push(light);
        }
        if let Some(camera) = own.camera {
            let camera = &model.cameras[camera];
            let name = own.name.clone().or_else(|| camera.name.clone()).unwrap_or_else(|| format!("camera {node}"));
            if moving[node] {
                log.lost(&format!("camera {name:?}"), "camera animation", "it stands where it is at the start");
            }
            asset.cameras.push(self::camera(camera, name, world, bounds, log));
        }
    }
    if !asset.lights.is_empty() {
        let note = "candela and lux became colours: color · intensity / π; they go to the scene file";
        log.changed("", "lights", note, None);
        if brightest > GLARING {
            let note = format!(
                "the brightest light has a colour of {brightest:.0}, made for a camera with exposure; scale the lights in the scene file"
            );
            log.changed("", "light intensity", note, None);
        }
    }
    if !asset.cameras.is_empty() {
        log.kept("", "cameras", "they go to the scene file");
    }
}

fn light(light: &model::Light, name: String, world: &DAffine3) -> Light {
    let position = vec3(to_aam(world.translation));
    let direction = vec3(to_aam(axis(world, DVec3::NEG_Z)));
    let falloff = Falloff::InverseSquare;
    let color = Vec3::from(light.color.map(|value| (value * (light.intensity / PI)).min(f32::MAX)));
    Light {
        name,
        kind: match light.kind {
            model::LightKind::Directional => LightKind::Directional { direction },
            model::LightKind::Point => LightKind::Point { position, falloff },
            model::LightKind::Spot { inner, outer } => LightKind::Spot { position, direction, inner, outer, falloff },
        },
        ambient: Vec3::ZERO,
        diffuse: color,
        specular: color,
        shape: None,
    }
}

fn camera(camera: &model::Camera, name: String, world: &DAffine3, bounds: Option<[DVec3; 2]>, log: &mut Log) -> Camera {
    let position = to_aam(world.translation);
    let forward = to_aam(axis(world, DVec3::NEG_Z));
    let up = to_aam(axis(world, DVec3::Y));
    let [low, high] = bounds.unwrap_or([position; 2]);
    // The point that orbiting turns around: as far as the middle of everything, if that lies ahead.
    let ahead = (0.5 * (low + high) - position).dot(forward);
    let distance = if ahead > f64::from(camera.near) { ahead } else { 1.0 };
    let farthest = (low - position).abs().max((high - position).abs()).length();
    let subject = format!("camera {name:?}");
    let (projection, aspect) = match camera.lens {
        Lens::Perspective { fov_y, aspect } => {
            if fov_y > WIDEST {
                let note = format!("{fov_y} is no angle that a plane picture can have; it is {WIDEST}");
                log.changed(&subject, "camera field of view", note, None);
            }
            (Projection::Perspective { fov_y: fov_y.min(WIDEST) }, aspect)
        }
        Lens::Orthographic { half_height, half_width } => {
            (Projection::Orthographic { height: 2.0 * half_height }, Some(half_width / half_height))
        }
    };
    if let Some(aspect) = aspect {
        log.lost(&subject, "camera aspect ratio", format!("{aspect:.3}; the picture's own is used"));
    }
    let far = camera.far.unwrap_or_else(|| {
        let far = (1000.0 * camera.near).max(2.0 * farthest as f32);
        log.changed(&subject, "camera far plane", format!("there was none; it is at {far}"), None);
        far
    });
    let near = if camera.near > 0.0 { camera.near } else { far * 1e-6 };
    Camera {
        name,
        position: vec3(position),
        target: vec3(position + forward * distance),
        up: vec3(up),
        projection,
        near,
        far,
    }
}

/// An axis of a node in the world.
fn axis(world: &DAffine3, axis: DVec3) -> DVec3 {
    (world.matrix3 * axis).try_normalize().unwrap_or(axis)
}

fn vec3(vector: DVec3) -> Vec3 {
    vector.as_vec3()
}
