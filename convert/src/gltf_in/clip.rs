//! One animation: chosen, decoded, and evaluated at any time exactly as glTF 2.0 §3.11 and appendix C say.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DQuat, DVec3, DVec4};

use aam::{Limit, Limits};

use crate::{ConvertError, ImportOptions};

use super::accessor::Reader;
use super::fault::{Checked, Fault};
use super::limits;
use super::log::Log;
use super::model::{Channel, Interpolation, Model, Parts, Target, Transform};

/// A clip that can be evaluated.
#[derive(Debug)]
pub(super) struct Clip {
    pub name: String,
    /// Seconds from 0 to the last key.
    pub duration: f32,
    tracks: Vec<Track>,
}

/// One moving property of one node.
#[derive(Debug)]
struct Track {
    node: usize,
    target: Target,
    interpolation: Interpolation,
    times: Arc<[f32]>,
    values: Arc<[f32]>,
    /// Numbers in one value.
    width: usize,
}

/// What an animation's name is when it has none.
fn title(model: &Model, number: usize) -> String {
    model.animations[number].name.clone().unwrap_or_else(|| format!("animation {number}"))
}

/// Finds the clip that the options ask for, by name or else by number; the first if they ask for none. `none` asks for
/// the model at rest.
fn choose(model: &Model, options: &ImportOptions) -> Checked<Option<usize>> {
    let count = model.animations.len();
    let Some(wanted) = &options.animation else { return Ok((count > 0).then_some(0)) };
    let named = (0..count).find(|&number| model.animations[number].name.as_deref() == Some(wanted));
    let numbered = || wanted.parse().ok().filter(|&number: &usize| number < count);
    if let Some(number) = named.or_else(numbered) {
        return Ok(Some(number));
    }
    if wanted == "none" {
        return Ok(None);
    }
    const LISTED: usize = 20;
    let list: Vec<String> =
        (0..count.min(LISTED)).map(|number| format!("{number} {:?}", title(model, number))).collect();
    let more = if count > LISTED { " and others" } else { "" };
    let known = if count == 0 { "the file has none".into() } else { format!("the file has {}{more}", list.join(", ")) };
    let names = model.animations.iter().filter_map(|animation| animation.name.as_deref());
    let near = aam::nearest(wanted.as_bytes(), names).map(|name| format!("; did you mean {name:?}?"));
    let near = near.unwrap_or_default();
    Err(ConvertError::Option(format!("--animation {wanted}: there is no such animation; {known}{near}")).into())
}

/// The clip of an import, if it has one.
pub(super) fn find(reader: Reader<'_>, options: &ImportOptions, log: &mut Log) -> Checked<Option<Clip>> {
    let model = reader.model;
    let chosen = choose(model, options)?;
    for number in (0..model.animations.len()).filter(|&number| Some(number) != chosen) {
        let note = "an AAM file holds one; convert again with --animation";
        log.lost(&format!("animation {:?}", title(model, number)), "animation", note);
    }
    let Some(chosen) = chosen else { return Ok(None) };
    let animation = &model.animations[chosen];
    let subject = format!("animation {:?}", title(model, chosen));
    for ignored in &animation.ignored {
        log.lost(&subject, "animation channel", ignored);
    }
    let count = |accessor: usize| model.accessors[accessor].count as u64;
    let numbers = animation.channels.iter().map(|channel| count(channel.input).saturating_add(count(channel.output)));
    limits::check_keys(numbers.fold(0, u64::saturating_add))?;
    let mut known = Known::new();
    let tracks = animation.channels.iter().map(|channel| track(reader, channel, &mut known));
    let tracks = tracks.collect::<Checked<Vec<_>>>()?;
    let duration = tracks.iter().filter_map(|track| track.times.last()).copied().fold(0.0, f32::max);
    if let Some(channel) =
        animation.channels.iter().find(|channel| matches!(model.nodes[channel.node].transform, Transform::Matrix(_)))
    {
        let note = format!("node {} has a matrix and moves; its matrix was taken apart", channel.node);
        log.changed(&subject, "animation channel", note, None);
    }
    Ok(Some(Clip { name: title(model, chosen), duration, tracks }))
}

/// Accessors that were decoded, which channels share: the numbers, and how many make an element.
type Known = BTreeMap<usize, (Arc<[f32]>, usize)>;

fn numbers(reader: Reader<'_>, accessor: usize, usage: &str, known: &mut Known) -> Checked<(Arc<[f32]>, usize)> {
    if let Some(found) = known.get(&accessor) {
        return Ok(found.clone());
    }
    let (numbers, width) = reader.flat(accessor, usage)?;
    let found = (Arc::from(numbers), width);
    known.insert(accessor, found.clone());
    Ok(found)
}

fn track(reader: Reader<'_>, channel: &Channel, known: &mut Known) -> Checked<Track> {
    let model = reader.model;
    let (times, width) = numbers(reader, channel.input, "an animation's times", known)?;
    let place = &model.accessors[channel.input].place;
    if width != 1 {
        return Err(Fault::broken(format!("{place}/type"), "an animation's times need SCALAR"));
    }
    if times.is_empty() {
        return Err(Fault::broken(place, "an animation sampler needs at least one time"));
    }
    if times[0] < 0.0 || times.windows(2).any(|pair| pair[1] < pair[0]) {
        return Err(Fault::broken(place, "an animation's times must not be negative and must increase"));
    }
    let (values, shape) = numbers(reader, channel.output, "an animation's values", known)?;
    let place = &model.accessors[channel.output].place;
    let width = match channel.target {
        Target::Translation | Target::Scale => 3,
        Target::Rotation => 4,
        Target::Weights => model.nodes[channel.node].mesh.map_or(0, |mesh| model.meshes[mesh].targets),
    };
    if width == 0 {
        let message = "a channel moves the weights of a node whose mesh has no morph targets";
        return Err(Fault::broken(&channel.place, message));
    }
    let wanted_shape = if channel.target == Target::Weights { 1 } else { width };
    if shape != wanted_shape {
        let message = format!("values have {shape} numbers each, but the property needs {wanted_shape}");
        return Err(Fault::broken(format!("{place}/type"), message));
    }
    let parts = if channel.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let wanted = times.len().checked_mul(parts * width);
    if wanted != Some(values.len()) {
        let message =
            format!("{} numbers for {} times; {} a time are needed", values.len(), times.len(), parts * width);
        return Err(Fault::broken(format!("{place}/count"), message));
    }
    Ok(Track { node: channel.node, target: channel.target, interpolation: channel.interpolation, times, values, width })
}

impl Clip {
    /// How many frames the clip has at a rate: from time 0 to the first frame at or after its end.
    pub(super) fn frames(&self, rate: f32, limits: &Limits) -> Checked<usize> {
        // A duration that is a whole number of frames but for rounding gets no frame more.
        let last = (f64::from(self.duration) * f64::from(rate) - 1e-3).ceil().max(0.0);
        let frames = (last as u64).saturating_add(1);
        let too_many = |exceeded| Fault::Limit { exceeded, way_out: "lower --fps or cut the animation" };
        limits.check(Limit::Frames, frames).map_err(too_many)?;
        Ok(usize::try_from(frames).unwrap_or(usize::MAX))
    }

    /// For each node whether the clip moves it: it has keys, and one is not where the node rests.
    pub(super) fn moving(&self, rest: &[Transform]) -> Vec<bool> {
        let mut moving = vec![false; rest.len()];
        for track in &self.tracks {
            let rest = parts_of(&rest[track.node]);
            let constant = match track.target {
                Target::Translation => track.is_constant(&rest.translation.to_array()),
                Target::Rotation => track.is_constant(&rest.rotation.to_array()),
                Target::Scale => track.is_constant(&rest.scale.to_array()),
                Target::Weights => true,
            };
            moving[track.node] |= !constant;
        }
        moving
    }

    /// How many properties the clip drives.
    pub(super) fn tracks(&self) -> usize {
        self.tracks.len()
    }

    /// The nodes whose morph weights the clip drives.
    pub(super) fn morphed(&self) -> impl Iterator<Item = usize> {
        self.tracks.iter().filter(|track| track.target == Target::Weights).map(|track| track.node)
    }

    /// Puts every driven property where it is at a time.
    pub(super) fn pose(&self, time: f32, locals: &mut [Transform], weights: &mut [Vec<f32>]) {
        for track in &self.tracks {
            if track.target == Target::Weights {
                weights[track.node] = track.at(time).into_iter().map(|value| value as f32).collect();
                continue;
            }
            let local = &mut locals[track.node];
            let mut parts = parts_of(local);
            let value = track.at(time);
            match track.target {
                Target::Translation => parts.translation = DVec3::from_slice(&value),
                Target::Scale => parts.scale = DVec3::from_slice(&value),
                Target::Rotation => parts.rotation = DQuat::from_slice(&value),
                Target::Weights => {}
            }
            *local = Transform::Parts(parts);
        }
    }
}

fn parts_of(transform: &Transform) -> Parts {
    match transform {
        Transform::Parts(parts) => *parts,
        Transform::Matrix(matrix) => {
            let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
            Parts { translation, rotation, scale }
        }
    }
}

impl Track {
    fn is_constant(&self, rest: &[f64]) -> bool {
        let step = if self.interpolation == Interpolation::CubicSpline { 3 * self.width } else { self.width };
        let first = step - self.width;
        let close = |values: &[f32]| values.iter().zip(rest).all(|(a, b)| (f64::from(*a) - b).abs() <= 1e-6);
        let still = |tangent: &[f32]| tangent.iter().all(|value| *value == 0.0);
        self.values.chunks_exact(step).all(|key| match self.interpolation {
            Interpolation::CubicSpline => {
                close(&key[self.width..2 * self.width]) && still(&key[..self.width]) && still(&key[2 * self.width..])
            }
            Interpolation::Step | Interpolation::Linear => close(&key[first..]),
        })
    }

    /// The value of a key: 0 the incoming tangent, 1 the value, 2 the outgoing tangent.
    fn key(&self, key: usize, part: usize) -> &[f32] {
        let start = match self.interpolation {
            Interpolation::CubicSpline => (3 * key + part) * self.width,
            Interpolation::Step | Interpolation::Linear => key * self.width,
        };
        self.values.get(start..start + self.width).unwrap_or(&[])
    }

    fn at(&self, time: f32) -> Vec<f64> {
        let wide = |values: &[f32]| values.iter().map(|&value| f64::from(value)).collect::<Vec<f64>>();
        let last = self.times.len() - 1;
        let next = self.times.partition_point(|&key| key <= time);
        // Outside its keys a property stays as it is at the nearest one.
        let mut value = if next == 0 {
            wide(self.key(0, 1))
        } else if next > last {
            wide(self.key(last, 1))
        } else {
            let key = next - 1;
            let length = f64::from(self.times[next]) - f64::from(self.times[key]);
            let part = if length > 0.0 { (f64::from(time) - f64::from(self.times[key])) / length } else { 0.0 };
            match self.interpolation {
                Interpolation::Step => wide(self.key(key, 1)),
                Interpolation::Linear if self.target == Target::Rotation => {
                    slerp(self.key(key, 1), self.key(next, 1), part).to_array().to_vec()
                }
                Interpolation::Linear => {
                    let pairs = self.key(key, 1).iter().zip(self.key(next, 1));
                    pairs.map(|(&a, &b)| f64::from(a) + part * (f64::from(b) - f64::from(a))).collect()
                }
                Interpolation::CubicSpline => self.spline(key, part, length),
            }
        };
        if self.target == Target::Rotation {
            value = quaternion(&value).to_array().to_vec();
        }
        value
    }

    /// A cubic Hermite spline between two keys, its tangents scaled by the time between them.
    fn spline(&self, key: usize, part: f64, length: f64) -> Vec<f64> {
        let (squared, cubed) = (part * part, part * part * part);
        let factors = [
            2.0 * cubed - 3.0 * squared + 1.0,
            length * (cubed - 2.0 * squared + part),
            3.0 * squared - 2.0 * cubed,
            length * (cubed - squared),
        ];
        let terms = [self.key(key, 1), self.key(key, 2), self.key(key + 1, 1), self.key(key + 1, 0)];
        (0..self.width)
            .map(|at| terms.iter().zip(factors).map(|(term, factor)| factor * f64::from(term[at])).sum())
            .collect()
    }
}

/// Numbers as a unit quaternion; zeros are no turn.
fn quaternion(values: &[f64]) -> DQuat {
    let vector = DVec4::from_slice(values);
    vector.try_normalize().map_or(DQuat::IDENTITY, DQuat::from_vec4)
}

/// Spherical interpolation along the shorter way (glTF 2.0 appendix C.4).
fn slerp(a: &[f32], b: &[f32], part: f64) -> DQuat {
    let unit = |values: &[f32]| quaternion(&values.iter().map(|&value| f64::from(value)).collect::<Vec<_>>());
    let (a, b) = (DVec4::from(unit(a)), DVec4::from(unit(b)));
    let dot = a.dot(b);
    let angle = dot.abs().min(1.0).acos();
    let vector = if angle < 1e-6 {
        a.lerp(b * dot.signum(), part)
    } else {
        (a * (angle * (1.0 - part)).sin() + b * (dot.signum() * (angle * part).sin())) / angle.sin()
    };
    DQuat::from_vec4(vector.normalize())
}
