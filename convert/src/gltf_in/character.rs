//! Local transforms and keys: `AAM_CHARACTER`.
//!
//! `TM` holds a rotation, a position and a scale. A glTF node's translation, rotation and scale are just that, so they
//! carry over exactly, each in AAM's axes. A node's `matrix`, or what a chain of such nodes leaves over, may shear; then
//! the whole linear part goes into the vertices below it and `TM` keeps the position alone.

use std::collections::BTreeMap;

use aam::document::{NodeTransform, PositionSample, RotationSample, ScaleSample, Track};
use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::clip::Clip;
use super::graph::{Graph, to_aam};
use super::log::Log;
use super::model::{Model, Parts, Transform};
use super::stage::Moment;

/// Where every node is relative to its parent.
#[derive(Debug)]
pub(super) struct Places {
    /// The rest pose that `TM` can express.
    pub rest: Vec<Transform>,
    /// What `TM` cannot express, to be applied to the vertices of the node.
    pub baked: Vec<DMat3>,
}

impl Places {
    /// `TM` of a node.
    pub(super) fn transform(&self, node: usize) -> NodeTransform {
        let parts = parts(&self.rest[node]);
        let rotation = DMat3::from_quat(turn(parts.rotation));
        NodeTransform {
            // Rows, for row vectors: the images of the axes.
            rotation: [rotation.x_axis, rotation.y_axis, rotation.z_axis].map(plain),
            position: plain(to_aam(parts.translation)),
            scale: plain(swapped(parts.scale)),
            ..NodeTransform::default()
        }
    }

    /// From a node's coordinates, with what was baked taken out, to the world, in AAM's axes.
    pub(super) fn world(&self, node: usize, moment: &Moment) -> DAffine3 {
        let axes = DAffine3::from_mat3(DMat3::from_cols(to_aam(DVec3::X), to_aam(DVec3::Y), to_aam(DVec3::Z)));
        let world = moment.worlds[node];
        let unbaked = if self.baked[node] == DMat3::IDENTITY {
            world
        } else {
            world * DAffine3::from_mat3(self.baked[node].inverse())
        };
        axes * unbaked * axes.inverse()
    }
}

/// Whether any node that the clip moves hangs below a shear, so that no keys could express it.
pub(super) fn needs_frames(model: &Model, graph: &Graph, moment: &Moment, clip: &Clip) -> bool {
    let moving = clip.moving(&moment.locals);
    let (_, baked) = split(model, graph, moment);
    graph.scene.iter().any(|&node| {
        let above = graph.parents[node].is_some_and(|parent| baked[parent] != DMat3::IDENTITY);
        moving[node] && (above || baked[node] != DMat3::IDENTITY)
    })
}

/// The places of all nodes at rest.
pub(super) fn places(model: &Model, graph: &Graph, moment: &Moment, log: &mut Log) -> Places {
    let (rest, baked) = split(model, graph, moment);
    let count = graph.scene.iter().filter(|&&node| baked[node] != DMat3::IDENTITY).count();
    if count > 0 {
        let note = format!("{count} nodes shear, which TM cannot say; that part went into the vertices");
        log.changed("", "node transforms", note, None);
    }
    Places { rest, baked }
}

/// Local transforms that `TM` can express, and what they leave for the vertices.
fn split(model: &Model, graph: &Graph, moment: &Moment) -> (Vec<Transform>, Vec<DMat3>) {
    let mut rest = moment.locals.clone();
    let mut baked = vec![DMat3::IDENTITY; model.nodes.len()];
    for &node in &graph.order {
        let above = graph.parents[node].map_or(DMat3::IDENTITY, |parent| baked[parent]);
        let local = model.nodes[node].transform;
        if above == DMat3::IDENTITY && matches!(local, Transform::Parts(_)) {
            continue;
        }
        let whole = DAffine3::from_mat3(above) * moment.locals[node].affine();
        let (scale, rotation, translation) = whole.to_scale_rotation_translation();
        let parts = Parts { translation, rotation, scale };
        let size = whole.matrix3.to_cols_array().iter().fold(0.0, |size: f64, value| size.max(value.abs()));
        let finite = scale.is_finite() && rotation.is_finite();
        if finite && parts.affine().matrix3.abs_diff_eq(whole.matrix3, 1e-6 * size) {
            rest[node] = Transform::Parts(parts);
        } else {
            rest[node] = Transform::Parts(Parts { translation, ..Parts::IDENTITY });
            baked[node] = whole.matrix3;
        }
    }
    (rest, baked)
}

/// Keys at every frame for the properties that move, by node.
pub(super) fn keys(
    graph: &Graph,
    clip: &Clip,
    places: &Places,
    driven: &[bool],
    frames: usize,
    rate: f32,
) -> BTreeMap<usize, Vec<Track>> {
    let nodes: Vec<usize> = graph.scene.iter().copied().filter(|&node| driven[node]).collect();
    let mut samples: Vec<Vec<Parts>> = vec![Vec::with_capacity(frames); nodes.len()];
    let mut locals = places.rest.clone();
    let mut weights = vec![Vec::new(); locals.len()];
    for frame in 0..frames {
        clip.pose(frame as f32 / rate, &mut locals, &mut weights);
        for (samples, &node) in samples.iter_mut().zip(&nodes) {
            samples.push(parts(&locals[node]));
        }
    }
    nodes
        .into_iter()
        .zip(samples)
        .map(|(node, samples)| {
            let rest = parts(&places.rest[node]);
            let mut tracks = Vec::new();
            let numbered = || (0..).map(|frame: u32| frame as f32).zip(&samples);
            if samples.iter().any(|sample| sample.translation != rest.translation) {
                let key = |(frame, sample): (f32, &Parts)| PositionSample {
                    frame,
                    position: plain(to_aam(sample.translation)),
                };
                tracks.push(Track::PositionSampled(numbered().map(key).collect()));
            }
            if samples.iter().any(|sample| sample.rotation != rest.rotation) {
                tracks.push(Track::RotationSampled(numbered().map(rotation_key).collect()));
            }
            if samples.iter().any(|sample| sample.scale != rest.scale) {
                let key = |(frame, sample): (f32, &Parts)| ScaleSample {
                    frame,
                    axes: [0.0, 0.0, 0.0, 1.0],
                    scale: plain(swapped(sample.scale)),
                };
                tracks.push(Track::ScaleSampled(numbered().map(key).collect()));
            }
            (node, tracks)
        })
        .filter(|(_, tracks)| !tracks.is_empty())
        .collect()
}

/// Axis and angle of a rotation, the angle from 0 to π.
fn rotation_key((frame, sample): (f32, &Parts)) -> RotationSample {
    let turned = turn(sample.rotation);
    let turned = if turned.w < 0.0 { -turned } else { turned };
    let (axis, angle) = turned.to_axis_angle();
    RotationSample { frame, axis: plain(axis), angle: angle as f32 }
}

fn parts(transform: &Transform) -> Parts {
    match transform {
        Transform::Parts(parts) => *parts,
        Transform::Matrix(matrix) => {
            let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
            Parts { translation, rotation, scale }
        }
    }
}

/// A rotation in AAM's axes: the same angle about the turned axis.
fn turn(rotation: DQuat) -> DQuat {
    let axis = to_aam(DVec3::new(rotation.x, rotation.y, rotation.z));
    DQuat::from_xyzw(axis.x, axis.y, axis.z, rotation.w)
}

/// A scale in AAM's axes.
const fn swapped(scale: DVec3) -> DVec3 {
    DVec3::new(scale.x, scale.z, scale.y)
}

fn plain(vector: DVec3) -> [f32; 3] {
    // Adding zero turns -0 into 0.
    vector.as_vec3().to_array().map(|value| value + 0.0)
}
