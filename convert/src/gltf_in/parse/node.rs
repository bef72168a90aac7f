//! Nodes, scenes, skins, cameras and lights.

use glam::{DAffine3, DMat4, DQuat, DVec3};

use crate::gltf_in::fault::Checked;
use crate::gltf_in::json::At;
use crate::gltf_in::model::{Camera, Lens, Light, LightKind, Node, Parts, Scene, Skin, Transform};

use super::{Counts, name};

pub(super) fn node(at: &At<'_>, counts: &Counts) -> Checked<Node> {
    let light = match at.extension("KHR_lights_punctual") {
        Some(extension) => Some(extension.require("light")?.index(counts.lights, "light")?),
        None => None,
    };
    let hidden = match at.extension("KHR_node_visibility") {
        Some(extension) => extension.get("visible").is_some() && !extension.flag("visible")?,
        None => false,
    };
    Ok(Node {
        name: name(at)?,
        children: at.list("children")?.iter().map(|child| child.index(counts.nodes, "node")).collect::<Checked<_>>()?,
        transform: transform(at)?,
        mesh: at.index_of("mesh", counts.meshes, "mesh")?,
        skin: at.index_of("skin", counts.skins, "skin")?,
        camera: at.index_of("camera", counts.cameras, "camera")?,
        light,
        weights: at.all_numbers_of("weights")?,
        hidden,
        extras: at.get("extras").map(|extras| extras.to_json()),
        place: at.place().to_owned(),
    })
}

fn transform(at: &At<'_>) -> Checked<Transform> {
    if let Some(columns) = at.numbers_of::<16>("matrix")? {
        let matrix = DMat4::from_cols_array(&columns.map(f64::from));
        let last = matrix.row(3);
        if !last.abs_diff_eq(glam::DVec4::W, 1e-6) {
            return Err(at.fault_of("matrix", "the last row must be 0 0 0 1; a projection is no place of a node"));
        }
        return Ok(Transform::Matrix(DAffine3::from_mat4(matrix)));
    }
    let mut parts = Parts::IDENTITY;
    if let Some(translation) = at.numbers_of::<3>("translation")? {
        parts.translation = DVec3::from(translation.map(f64::from));
    }
    if let Some(rotation) = at.numbers_of::<4>("rotation")? {
        let rotation = DQuat::from_array(rotation.map(f64::from));
        if rotation.length_squared() < 1e-12 {
            return Err(at.fault_of("rotation", "a quaternion of zeros is no rotation"));
        }
        parts.rotation = rotation.normalize();
    }
    if let Some(scale) = at.numbers_of::<3>("scale")? {
        parts.scale = DVec3::from(scale.map(f64::from));
    }
    Ok(Transform::Parts(parts))
}

pub(super) fn scene(at: &At<'_>, counts: &Counts) -> Checked<Scene> {
    let roots = at.list("nodes")?.iter().map(|root| root.index(counts.nodes, "node")).collect::<Checked<_>>()?;
    Ok(Scene { name: name(at)?, roots })
}

pub(super) fn skin(at: &At<'_>, counts: &Counts) -> Checked<Skin> {
    let joints = at.require("joints")?;
    let joints: Vec<usize> =
        joints.items()?.iter().map(|joint| joint.index(counts.nodes, "node")).collect::<Checked<_>>()?;
    if joints.is_empty() {
        return Err(at.fault_of("joints", "a skin needs at least one joint"));
    }
    // The joints alone say where a skin is; but what is named must be there.
    at.index_of("skeleton", counts.nodes, "node")?;
    Ok(Skin {
        joints,
        inverse_bind: at.index_of("inverseBindMatrices", counts.accessors, "accessor")?,
        place: at.place().to_owned(),
    })
}

pub(super) fn camera(at: &At<'_>) -> Checked<Camera> {
    let kind = at.require("type")?;
    let positive = |lens: &At<'_>, key: &str| lens.number_in(key, f32::MIN_POSITIVE, f32::MAX);
    let required = |lens: &At<'_>, key: &str| -> Checked<f32> {
        lens.require(key)?;
        Ok(positive(lens, key)?.unwrap_or(1.0))
    };
    let (lens, near, far) = match kind.text()? {
        "perspective" => {
            let lens = at.require("perspective")?;
            let fov_y = required(&lens, "yfov")?;
            let shape = Lens::Perspective { fov_y, aspect: positive(&lens, "aspectRatio")? };
            (shape, required(&lens, "znear")?, positive(&lens, "zfar")?)
        }
        "orthographic" => {
            let lens = at.require("orthographic")?;
            let magnitude = |key: &str| -> Checked<f32> {
                lens.require(key)?;
                match lens.number_of(key)?.map(f32::abs) {
                    Some(value) if value > 0.0 => Ok(value),
                    _ => Err(lens.fault_of(key, "must not be 0")),
                }
            };
            lens.require("znear")?;
            let near = lens.number_in("znear", 0.0, f32::MAX)?.unwrap_or(0.0);
            let shape = Lens::Orthographic { half_width: magnitude("xmag")?, half_height: magnitude("ymag")? };
            (shape, near, Some(required(&lens, "zfar")?))
        }
        other => return Err(kind.fault(format!("{other:?} is neither perspective nor orthographic"))),
    };
    if let Some(far) = far.filter(|far| *far <= near) {
        return Err(at.fault(format!("zfar {far} must be more than znear {near}")));
    }
    Ok(Camera { name: name(at)?, lens, near, far })
}

pub(super) fn light(at: &At<'_>) -> Checked<Light> {
    let kind = at.require("type")?;
    let kind = match kind.text()? {
        "directional" => LightKind::Directional,
        "point" => LightKind::Point,
        "spot" => {
            let (mut inner, mut outer) = (0.0, std::f32::consts::FRAC_PI_4);
            if let Some(spot) = at.get("spot") {
                let right = std::f32::consts::FRAC_PI_2 + 1e-6;
                inner = spot.number_in("innerConeAngle", 0.0, right)?.unwrap_or(inner);
                outer = spot.number_in("outerConeAngle", 0.0, right)?.unwrap_or(outer);
                if inner > outer {
                    return Err(spot.fault(format!("innerConeAngle {inner} is more than outerConeAngle {outer}")));
                }
            }
            LightKind::Spot { inner, outer }
        }
        other => return Err(kind.fault(format!("{other:?} is none of directional, point and spot"))),
    };
    let color: [f32; 3] = at.numbers_of("color")?.unwrap_or([1.0; 3]);
    if let Some(value) = color.iter().find(|value| **value < 0.0) {
        return Err(at.fault_of("color", format!("a colour of {value} is less than 0")));
    }
    Ok(Light {
        name: name(at)?,
        kind,
        color,
        intensity: at.number_in("intensity", 0.0, f32::MAX)?.unwrap_or(1.0),
        range: at.number_in("range", 0.0, f32::MAX)?,
    })
}
