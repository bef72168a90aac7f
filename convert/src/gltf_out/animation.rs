//! Keys of a character as animation channels, later frames as weights of morph targets.

use aam::meaning::{Motion, frame_range, frames_per_second, has_local_coordinates, local_transform, object_motions};
use glam::{DQuat, DVec3, Vec3};

use super::axes::Parts;
use super::buffer::Buffers;
use super::json::{Animation, AnimationSampler, Channel, ChannelTarget, Index};
use super::model::{Model, subject_of};
use super::notes::Notes;

/// More samples than this, over all objects, are not written: two keys far apart would make a small file a huge one.
const MAX_SAMPLES: usize = 4_000_000;

/// The largest entry that a matrix may lose by being taken apart, relative to its largest, before it is reported.
const SHEAR: f64 = 1e-4;

/// Samples the keys of all objects at every whole frame of the animation and adds a channel for each part that moves.
/// Gives the transform of each object's node; the node of an object has the object's position in frame 0.
pub(super) fn sample(
    model: &Model<'_>,
    animation: &mut Animation,
    buffers: &mut Buffers,
    notes: &mut Notes,
) -> Vec<Parts> {
    let document = model.document;
    let motions = object_motions(document);
    let moving = motions.iter().filter(|motion| is_moving(motion)).count();
    let (frames, times) = frames(model, moving, notes);
    let mut input = None;
    let mut rests = Vec::new();
    for (node, (object, motion)) in document.objects().iter().zip(&motions).enumerate() {
        let still = object.node.as_ref().filter(|_| has_local_coordinates(document));
        let mut rest = Parts::of(&still.map(local_transform).unwrap_or_default());
        let mut error = rest.error;
        if motion.frame_range().is_some() {
            let frames = if is_moving(motion) { &frames[..] } else { &frames[..1] };
            let sampled = samples(motion, frames);
            error = sampled.iter().fold(0.0, |error: f64, parts| error.max(parts.error));
            let mut add = |path, output, buffers: &mut Buffers| {
                let input = *input.get_or_insert_with(|| buffers.times(&times));
                push(animation, node as Index, path, input, output);
            };
            // A part that keys hold still is the node's own; one that moves leaves `TM` in the node.
            if moves(&sampled, |parts| parts.translation, |a, b| a == b) {
                let output = buffers.keys(sampled.iter().map(|parts| parts.translation.to_array()));
                add("translation", output, buffers);
            } else {
                rest.translation = sampled[0].translation;
            }
            if moves(&sampled, |parts| parts.rotation, same_rotation) {
                let output = buffers.keys(sampled.iter().map(|parts| parts.rotation.as_quat().to_array()));
                add("rotation", output, buffers);
            } else {
                rest.rotation = sampled[0].rotation;
            }
            if moves(&sampled, |parts| parts.scale, same_scale) {
                let output = buffers.keys(sampled.iter().map(|parts| parts.scale.as_vec3().to_array()));
                add("scale", output, buffers);
            } else {
                rest.scale = sampled[0].scale;
            }
        }
        if error > SHEAR {
            let note = "it shears, which a node of glTF cannot; the nearest turn and scale stand in";
            notes.changed_by(&subject_of(object), "transform", note, (error, format!("{:.2} %", 100.0 * error)));
        }
        rests.push(rest);
    }
    rests
}

/// Frames a second, within what keeps times finite and apart.
fn rate(model: &Model<'_>) -> f32 {
    frames_per_second(model.document).clamp(1e-3, 1e6)
}

fn is_moving(motion: &Motion) -> bool {
    motion.frame_range().is_some_and(|(first, last)| first < last)
}

/// The frames to sample, at least one, and their times in seconds.
fn frames(model: &Model<'_>, moving: usize, notes: &mut Notes) -> (Vec<f32>, Vec<f32>) {
    let range = frame_range(model.document);
    let (first, last) = range.map_or((0.0, 0.0), |(first, last)| (first.floor(), last.ceil()));
    let most = (MAX_SAMPLES / moving.max(1)).max(2);
    // Beyond 2²² frames 32 bits do not tell their times apart.
    let exact = first.abs().max(last.abs()) <= 4_194_304.0;
    let count = if exact { ((last - first) as usize + 1).min(most) } else { 1 };
    let frames: Vec<f32> = (0..count).map(|step| first + step as f32).collect();
    let sampled = frames[frames.len() - 1];
    if sampled < last {
        notes.lost("", "animation", format!("what comes after frame {sampled} is left out: there are too many frames"));
    }
    let zero = first.min(0.0);
    if zero < 0.0 && frames.len() > 1 {
        notes.changed("", "animation", format!("glTF's time starts at 0, which is frame {zero}"));
    }
    let fps = rate(model);
    let times = frames.iter().map(|frame| (frame - zero) / fps).collect();
    (frames, times)
}

fn samples(motion: &Motion, frames: &[f32]) -> Vec<Parts> {
    let mut sampled: Vec<Parts> = frames.iter().map(|&frame| Parts::of(&motion.at(frame))).collect();
    // The shorter way from each rotation to the next.
    for at in 1..sampled.len() {
        if sampled[at].rotation.dot(sampled[at - 1].rotation) < 0.0 {
            sampled[at].rotation = -sampled[at].rotation;
        }
    }
    sampled
}

fn moves<T>(sampled: &[Parts], part: impl Fn(&Parts) -> T, same: impl Fn(&T, &T) -> bool) -> bool {
    let first = part(&sampled[0]);
    sampled.iter().any(|parts| !same(&part(parts), &first))
}

/// Equal but for what rounding the matrix to 32 bits does.
fn same_rotation(a: &DQuat, b: &DQuat) -> bool {
    a.dot(*b).abs() > 1.0 - 1e-13
}

/// As [`same_rotation`].
fn same_scale(a: &DVec3, b: &DVec3) -> bool {
    (*a - *b).abs().max_element() <= 1e-6 * b.abs().max_element()
}

/// Adds the weights that show the later frames of meshes with morph targets, one at a time. `nodes` are the nodes of such
/// meshes.
pub(super) fn weights(
    model: &Model<'_>,
    nodes: &[Index],
    targets: usize,
    animation: &mut Animation,
    buffers: &mut Buffers,
) {
    if nodes.is_empty() || targets == 0 {
        return;
    }
    let fps = rate(model);
    let times: Vec<f32> = (0..=targets).map(|frame| frame as f32 / fps).collect();
    let input = buffers.times(&times);
    let rows = (0..=targets).flat_map(|frame| (1..=targets).map(move |target| [f32::from(u8::from(target == frame))]));
    let output = buffers.keys(rows);
    for &node in nodes {
        push(animation, node, "weights", input, output);
    }
}

fn push(animation: &mut Animation, node: Index, path: &'static str, input: Index, output: Index) {
    // The channels of `weights` all share the sampler that was made last.
    let last = animation.samplers.last().is_some_and(|sampler| (sampler.input, sampler.output) == (input, output));
    if !last {
        animation.samplers.push(AnimationSampler { input, output, interpolation: "LINEAR" });
    }
    let sampler = animation.samplers.len() as Index - 1;
    animation.channels.push(Channel { sampler, target: ChannelTarget { node, path } });
}

/// A translation in glTF's axes, `None` where it is none.
pub(super) fn translation(parts: &Parts) -> Option<[f32; 3]> {
    (parts.translation != Vec3::ZERO).then(|| parts.translation.to_array())
}

/// A rotation as glTF has it, `None` where it is none.
pub(super) fn rotation(parts: &Parts) -> Option<[f32; 4]> {
    let turn = parts.rotation.as_quat();
    (turn.xyz() != Vec3::ZERO).then(|| turn.normalize().to_array())
}

/// A scale as glTF has it, `None` where it is none.
pub(super) fn scale(parts: &Parts) -> Option<[f32; 3]> {
    // 1 as nearly as lengths of 32-bit vectors are.
    let is_one = same_scale(&parts.scale, &DVec3::ONE);
    (!is_one).then(|| parts.scale.as_vec3().to_array())
}
