//! Animations.

use std::collections::BTreeSet;

use crate::gltf_in::fault::Checked;
use crate::gltf_in::json::At;
use crate::gltf_in::model::{Animation, Channel, Interpolation, Target};

use super::{Counts, name};

pub(super) fn animation(at: &At<'_>, counts: &Counts) -> Checked<Animation> {
    let samplers = at.require("samplers")?.items()?;
    let mut driven = BTreeSet::new();
    let mut animation = Animation { name: name(at)?, channels: Vec::new(), ignored: Vec::new() };
    for channel in at.require("channels")?.items()? {
        let sampler = &samplers[channel.require("sampler")?.index(samplers.len(), "sampler of this animation")?];
        let target = channel.require("target")?;
        let path = target.require("path")?;
        let node = target.index_of("node", counts.nodes, "node")?;
        let property = match path.text()? {
            "translation" => Some(Target::Translation),
            "rotation" => Some(Target::Rotation),
            "scale" => Some(Target::Scale),
            "weights" => Some(Target::Weights),
            _ => None,
        };
        let (Some(node), Some(property)) = (node, property) else {
            animation.ignored.push(format!("a channel that moves {:?}", path.text()?));
            continue;
        };
        if !driven.insert((node, property)) {
            animation.ignored.push(format!("a second channel for the {} of node {node}", path.text()?));
            continue;
        }
        animation.channels.push(Channel {
            node,
            target: property,
            interpolation: interpolation(sampler)?,
            input: sampler.require("input")?.index(counts.accessors, "accessor")?,
            output: sampler.require("output")?.index(counts.accessors, "accessor")?,
            place: channel.place().to_owned(),
        });
    }
    Ok(animation)
}

fn interpolation(sampler: &At<'_>) -> Checked<Interpolation> {
    Ok(match sampler.text_of("interpolation")? {
        None | Some("LINEAR") => Interpolation::Linear,
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::CubicSpline,
        Some(other) => {
            return Err(sampler.fault_of("interpolation", format!("{other:?} is none of LINEAR, STEP, CUBICSPLINE")));
        }
    })
}
