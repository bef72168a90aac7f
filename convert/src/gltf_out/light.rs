//! Lights as `KHR_lights_punctual`, and cameras.
//!
//! A light of diffuse colour 1 lights a white diffuse surface that faces it to 1. In glTF's units that is an illuminance of
//! π lux, so a directional light has an intensity of π·colour lux and a point light with falloff, full at one metre, π·colour
//! candela. Every point light of glTF falls off with the square of the distance; one that does not in AAM gets the intensity
//! with which it lights the middle of the model as before.

use std::f32::consts::{FRAC_PI_2, PI};

use aam_scene::{Camera, Falloff, Light, LightKind, LightShape, Projection};
use glam::{Mat3, Quat, Vec3};
use serde_json::{Map, Value, json};

use super::axes;
use super::extras::{number, numbers, wrap};
use super::json::{self, Index, LightRef, Node, Orthographic, Perspective, Root, Spot};
use super::notes::Notes;

/// Adds a node for each light. `center` is the middle of the model, in AAM's axes.
pub(super) fn lights(lights: &[Light], center: Vec3, root: &mut Root, notes: &mut Notes) -> Vec<Index> {
    let mut nodes = Vec::new();
    let mut written = Vec::new();
    for (number, light) in lights.iter().enumerate() {
        let subject =
            if light.name.is_empty() { format!("light {number}") } else { format!("light \"{}\"", light.name) };
        let Some((node, light)) = one(light, written.len() as Index, center, &subject, notes) else {
            notes.lost(&subject, "light", "its place, direction or colour is not a number");
            continue;
        };
        nodes.push(root.nodes.len() as Index);
        root.nodes.push(node);
        written.push(light);
    }
    if !written.is_empty() {
        root.extensions.lights = Some(json::Lights { lights: written });
    }
    nodes
}

fn one(light: &Light, index: Index, center: Vec3, subject: &str, notes: &mut Notes) -> Option<(Node, json::Light)> {
    let brightest = light.diffuse.max_element();
    let usable = light.diffuse.is_finite() && light.diffuse.min_element() >= 0.0;
    let (color, strength) = match (usable, brightest > 0.0) {
        (true, true) => ((light.diffuse / brightest).to_array(), PI * brightest),
        (true, false) => ([1.0; 3], 0.0),
        (false, _) => return None,
    };
    let (kind, position, direction, falloff, spot) = match light.kind {
        LightKind::Directional { direction } => ("directional", Vec3::ZERO, Some(direction), None, None),
        LightKind::Point { position, falloff } => ("point", position, None, Some(falloff), None),
        LightKind::Spot { position, direction, inner, outer, falloff } => {
            let outer = outer.clamp(1e-3, FRAC_PI_2);
            let spot = Spot { inner_cone_angle: inner.clamp(0.0, 0.999 * outer), outer_cone_angle: outer };
            ("spot", position, Some(direction), Some(falloff), Some(spot))
        }
    };
    let mut node = Node { name: light.name.clone(), ..Node::default() };
    node.extensions.light = Some(LightRef { light: index });
    if !position.is_finite() {
        return None;
    }
    if position != Vec3::ZERO {
        node.translation = Some(axes::vector(position).to_array());
    }
    if let Some(direction) = direction {
        let turn = Quat::from_rotation_arc(Vec3::NEG_Z, axes::vector(direction).try_normalize()?).normalize();
        node.rotation = (turn != Quat::IDENTITY).then(|| turn.to_array());
    }
    let mut intensity = strength;
    let mut members = Map::new();
    if falloff == Some(Falloff::None) {
        let distance = position.distance(center);
        let distance = if distance.is_finite() && distance > 1e-3 { distance } else { 1.0 };
        intensity = strength * distance * distance;
        members.insert("falloff".into(), "none".into());
        let note = "glTF's fall off with distance; it lights the middle of the model as before";
        notes.changed_by(subject, "light falloff", note, (distance.into(), format!("{distance:.2} m")));
    }
    if !intensity.is_finite() {
        return None;
    }
    if light.ambient != Vec3::ZERO {
        members.insert("ambient".into(), numbers(&light.ambient.to_array()));
        notes.lost(subject, "ambient light", "glTF leaves light from everywhere to the viewer");
    }
    if light.specular != light.diffuse {
        members.insert("specular".into(), numbers(&light.specular.to_array()));
        notes.lost(subject, "specular light colour", "glTF's lights have one colour");
    }
    if let Some(shape) = &light.shape {
        members.insert("shape".into(), shape_of(shape));
        notes.lost(subject, "light shape", "glTF's lights are points");
    }
    let extras = wrap(members);
    Some((node, json::Light { name: light.name.clone(), kind, color, intensity, spot, extras }))
}

fn shape_of(shape: &LightShape) -> Value {
    match *shape {
        LightShape::Disc { radius } => json!({ "form": "disc", "radius": number(radius) }),
        LightShape::Rectangle { width, height } => {
            json!({ "form": "rectangle", "width": number(width), "height": number(height) })
        }
        LightShape::Sphere { radius } => json!({ "form": "sphere", "radius": number(radius) }),
    }
}

/// Adds a node for each camera.
pub(super) fn cameras(cameras: &[Camera], root: &mut Root, notes: &mut Notes) -> Vec<Index> {
    let mut nodes = Vec::new();
    for (number, camera) in cameras.iter().enumerate() {
        let subject =
            if camera.name.is_empty() { format!("camera {number}") } else { format!("camera \"{}\"", camera.name) };
        let Some((mut node, camera)) = camera_node(camera) else {
            notes.lost(&subject, "camera", "its numbers are no view: check position, target, near and far");
            continue;
        };
        node.camera = Some(root.cameras.len() as Index);
        root.cameras.push(camera);
        nodes.push(root.nodes.len() as Index);
        root.nodes.push(node);
    }
    nodes
}

fn camera_node(camera: &Camera) -> Option<(Node, json::Camera)> {
    let back = (axes::vector(camera.position) - axes::vector(camera.target)).try_normalize()?;
    let up = axes::vector(camera.up);
    let right = up.cross(back).try_normalize().unwrap_or_else(|| back.any_orthonormal_vector());
    let turn = Quat::from_mat3(&Mat3::from_cols(right, back.cross(right), back)).normalize();
    let planes = camera.near > 0.0 && camera.far > camera.near;
    if !(planes && camera.position.is_finite() && turn.is_finite()) {
        return None;
    }
    let node = Node {
        name: camera.name.clone(),
        translation: Some(axes::vector(camera.position).to_array()),
        rotation: Some(turn.to_array()),
        ..Node::default()
    };
    let mut out = json::Camera {
        name: camera.name.clone(),
        kind: "perspective",
        perspective: None,
        orthographic: None,
        extras: wrap(Map::from_iter([("target".to_owned(), number(camera.position.distance(camera.target)))])),
    };
    match camera.projection {
        Projection::Perspective { fov_y } => {
            let yfov = Some(fov_y).filter(|fov| *fov > 0.0 && *fov < PI)?;
            let zfar = Some(camera.far).filter(|far| far.is_finite());
            out.perspective = Some(Perspective { yfov, znear: camera.near, zfar });
        }
        Projection::Orthographic { height } => {
            let ymag = 0.5 * Some(height).filter(|height| *height > 0.0 && height.is_finite())?;
            let zfar = Some(camera.far).filter(|far| far.is_finite())?;
            out.kind = "orthographic";
            out.orthographic = Some(Orthographic { xmag: ymag, ymag, znear: camera.near, zfar });
        }
    }
    Some((node, out))
}
