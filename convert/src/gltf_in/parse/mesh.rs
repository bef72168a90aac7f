//! Meshes and their primitives.

use crate::gltf_in::fault::{Checked, Fault};
use crate::gltf_in::json::At;
use crate::gltf_in::model::{Attributes, Mesh, Mode, Primitive};

use super::{Counts, name};

/// Sets of four bones a vertex. Real files have one or two.
const MOST_BONE_SETS: usize = 16;

pub(super) fn mesh(at: &At<'_>, counts: &Counts) -> Checked<Mesh> {
    let primitives: Vec<Primitive> =
        at.require("primitives")?.items()?.iter().map(|item| primitive(item, counts)).collect::<Checked<_>>()?;
    let targets = primitives.first().map_or(0, |primitive| primitive.targets.len());
    if let Some(other) = primitives.iter().find(|primitive| primitive.targets.len() != targets) {
        let message = format!("{} morph targets, but the mesh's first primitive has {targets}", other.targets.len());
        return Err(Fault::broken(format!("{}/targets", other.place), message));
    }
    let weights = at.all_numbers_of("weights")?.unwrap_or_default();
    if !weights.is_empty() && weights.len() != targets {
        return Err(at.fault_of("weights", format!("{} weights for {targets} morph targets", weights.len())));
    }
    Ok(Mesh { name: name(at)?, primitives, weights, targets, extras: at.get("extras").map(|extras| extras.to_json()) })
}

fn primitive(at: &At<'_>, counts: &Counts) -> Checked<Primitive> {
    at.object()?;
    let mode = match at.unsigned_of("mode")?.unwrap_or(4) {
        0 => Mode::Points,
        1..=3 => Mode::Lines,
        4 => Mode::Triangles,
        5 => Mode::Strip,
        6 => Mode::Fan,
        other => return Err(at.fault_of("mode", format!("{other} is no primitive mode (0 to 6)"))),
    };
    let attributes = attributes(&at.require("attributes")?, counts)?;
    if attributes.position.is_none_or(|position| position >= counts.accessors)
        && at.extension("KHR_draco_mesh_compression").is_some()
    {
        return Err(super::super::extensions::draco());
    }
    let mut targets = Vec::new();
    for target in at.list("targets")? {
        let mut found = (None, None);
        for (key, value) in target.members()? {
            let accessor = value.index(counts.accessors, "accessor")?;
            match key {
                "POSITION" => found.0 = Some(accessor),
                "NORMAL" => found.1 = Some(accessor),
                _ => {}
            }
        }
        targets.push(found);
    }
    Ok(Primitive {
        attributes,
        indices: at.index_of("indices", counts.accessors, "accessor")?,
        material: at.index_of("material", counts.materials, "material")?,
        mode,
        targets,
        place: at.place().to_owned(),
    })
}

fn attributes(at: &At<'_>, counts: &Counts) -> Checked<Attributes> {
    let mut found = Attributes::default();
    let (mut joints, mut weights) = (Vec::new(), Vec::new());
    for (key, value) in at.members()? {
        let accessor = value.index(counts.accessors, "accessor")?;
        let numbered = |prefix: &str| key.strip_prefix(prefix).and_then(|number| number.parse::<u32>().ok());
        match key {
            "POSITION" => found.position = Some(accessor),
            "NORMAL" => found.normal = Some(accessor),
            "TANGENT" => found.tangent = Some(accessor),
            "COLOR_0" => found.color = Some(accessor),
            _ => {
                if let Some(set) = numbered("TEXCOORD_") {
                    found.tex_coords.push((set, accessor));
                } else if let Some(set) = numbered("JOINTS_") {
                    joints.push((set, accessor));
                } else if let Some(set) = numbered("WEIGHTS_") {
                    weights.push((set, accessor));
                } else {
                    found.ignored.push(key.to_owned());
                }
            }
        }
    }
    for list in [&mut joints, &mut weights] {
        list.sort_unstable();
        if list.iter().enumerate().any(|(at, (set, _))| usize::try_from(*set) != Ok(at)) {
            return Err(at.fault("JOINTS_n and WEIGHTS_n must be numbered from 0 without a gap"));
        }
    }
    if joints.len() != weights.len() {
        return Err(at.fault(format!("{} JOINTS_n, but {} WEIGHTS_n", joints.len(), weights.len())));
    }
    if joints.len() > MOST_BONE_SETS {
        return Err(at.fault(format!("{} sets of joints; no more than {MOST_BONE_SETS} are read", joints.len())));
    }
    found.joints = joints.into_iter().map(|(_, accessor)| accessor).collect();
    found.weights = weights.into_iter().map(|(_, accessor)| accessor).collect();
    Ok(found)
}
