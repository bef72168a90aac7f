//! The scene as it is to be written: which nodes become objects, in which form, under which names, and where they are
//! at each moment.

use std::collections::BTreeSet;

use aam::Limits;
use glam::DAffine3;

use super::clip::Clip;
use super::fault::{Checked, Fault};
use super::graph::Graph;
use super::limits::Size;
use super::model::{Mode, Model, Primitive, Transform};

/// The three forms of a document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// World coordinates, one frame.
    Static,
    /// Local coordinates and transforms, keys where nodes move.
    Character,
    /// World coordinates of every frame.
    Full,
}

/// A moment of the scene.
#[derive(Clone, Debug)]
pub(super) struct Moment {
    pub locals: Vec<Transform>,
    pub worlds: Vec<DAffine3>,
    /// Morph weights of each node.
    pub weights: Vec<Vec<f32>>,
}

impl Moment {
    /// The scene at rest.
    pub(super) fn rest(model: &Model, graph: &Graph) -> Checked<Self> {
        let locals: Vec<Transform> = model.nodes.iter().map(|node| node.transform).collect();
        let weights = model.nodes.iter().map(|node| {
            let Some(mesh) = node.mesh else { return Ok(Vec::new()) };
            let mesh = &model.meshes[mesh];
            match &node.weights {
                Some(weights) if weights.len() != mesh.targets => {
                    let message = format!("{} weights for {} morph targets", weights.len(), mesh.targets);
                    Err(Fault::broken(format!("{}/weights", node.place), message))
                }
                Some(weights) => Ok(weights.clone()),
                None if mesh.weights.is_empty() => Ok(vec![0.0; mesh.targets]),
                None => Ok(mesh.weights.clone()),
            }
        });
        let weights = weights.collect::<Checked<_>>()?;
        let worlds = graph.worlds(|node| locals[node].affine());
        let moment = Self { locals, worlds, weights };
        moment.check(model)?;
        Ok(moment)
    }

    /// Goes to a time of a clip.
    pub(super) fn go_to(&mut self, time: f32, clip: &Clip, graph: &Graph) {
        clip.pose(time, &mut self.locals, &mut self.weights);
        self.worlds = graph.worlds(|node| self.locals[node].affine());
    }

    /// Refuses transforms that multiply beyond all numbers.
    pub(super) fn check(&self, model: &Model) -> Checked<()> {
        let fits = |world: &DAffine3| world.to_cols_array().iter().all(|value| value.abs() <= 1e30);
        match self.worlds.iter().position(|world| !fits(world)) {
            None => Ok(()),
            Some(node) => Err(Fault::broken(
                &model.nodes[node].place,
                "the transforms from here to the root multiply to more than 32-bit numbers hold",
            )),
        }
    }
}

/// Which form the scene needs.
pub(super) fn form(model: &Model, graph: &Graph, moment: &Moment, clip: Option<&Clip>, hierarchy: bool) -> Form {
    let Some(clip) = clip else { return if hierarchy { Form::Character } else { Form::Static } };
    let mut moving = clip.moving(&moment.locals);
    for &node in &graph.order {
        if let Some(parent) = graph.parents[node] {
            moving[node] |= moving[parent];
        }
    }
    let morphed: BTreeSet<usize> = clip.morphed().collect();
    let skins: Vec<bool> = model.skins.iter().map(|skin| skin.joints.iter().any(|&joint| moving[joint])).collect();
    let bends = |node: usize| {
        let shown = &model.nodes[node];
        shown.mesh.is_some() && (morphed.contains(&node) || shown.skin.is_some_and(|skin| skins[skin]))
    };
    if graph.scene.iter().any(|&node| bends(node)) {
        Form::Full
    } else if hierarchy || graph.scene.iter().any(|&node| moving[node] && model.nodes[node].mesh.is_some()) {
        Form::Character
    } else {
        Form::Static
    }
}

/// Checks how large the document will be, before anything large is made. `bytes` is the size of all that was read.
pub(super) fn check_size(
    model: &Model,
    graph: &Graph,
    form: Form,
    frames: usize,
    clip: Option<&Clip>,
    limits: &Limits,
    bytes: usize,
) -> Checked<()> {
    let mut mesh_sizes = vec![(0_u64, 0_u64); model.meshes.len()];
    for (size, mesh) in mesh_sizes.iter_mut().zip(&model.meshes) {
        for primitive in &mesh.primitives {
            let Some(position) = primitive.attributes.position else { continue };
            let count = model.accessors[position].count as u64;
            let corners = primitive.indices.map_or(count, |indices| model.accessors[indices].count as u64);
            size.0 += count.min(corners);
            size.1 += match primitive.mode {
                Mode::Points | Mode::Lines => 0,
                Mode::Triangles => corners / 3,
                Mode::Strip | Mode::Fan => corners.saturating_sub(2),
            };
        }
    }
    let repeated = if form == Form::Full { frames as u64 } else { 1 };
    let mut size = Size::default();
    let mut decoded = vec![false; model.meshes.len()];
    for &node in &graph.scene {
        size.objects += repeated;
        let Some(mesh) = model.nodes[node].mesh else { continue };
        let (vertices, triangles) = mesh_sizes[mesh];
        size.vertices = size.vertices.saturating_add(vertices.saturating_mul(repeated));
        size.triangles = size.triangles.saturating_add(triangles);
        let targets = model.meshes[mesh].targets as u64;
        size.morphs = size.morphs.saturating_add(vertices.saturating_mul(targets).saturating_mul(repeated));
        if !std::mem::replace(&mut decoded[mesh], true) {
            let sparse = model.meshes[mesh].primitives.iter().map(|primitive| sparse_elements(model, primitive));
            let sparse = sparse.fold(0, u64::saturating_add);
            size.decoded = size.decoded.saturating_add(vertices.saturating_mul(1 + targets)).saturating_add(sparse);
        }
    }
    if let Some(clip) = clip.filter(|_| form != Form::Static) {
        let joints: usize = model.skins.iter().map(|skin| skin.joints.len()).sum();
        let posed = (model.nodes.len() + clip.tracks() + joints) as u64;
        size.poses = posed.saturating_mul(frames as u64);
    }
    size.check(limits, bytes as u64)
}

/// Elements of the sparse accessors that a primitive uses. Of these all are decoded, however few the triangles name.
fn sparse_elements(model: &Model, primitive: &Primitive) -> u64 {
    let attributes = &primitive.attributes;
    let single = [attributes.position, attributes.normal, attributes.color].into_iter().flatten();
    let sets = attributes.tex_coords.iter().map(|(_, accessor)| *accessor);
    let bones = attributes.joints.iter().chain(&attributes.weights).copied();
    let targets = primitive.targets.iter().flat_map(|(positions, normals)| [*positions, *normals]).flatten();
    let all = single.chain(sets).chain(bones).chain(targets).map(|accessor| &model.accessors[accessor]);
    all.filter(|accessor| accessor.sparse.is_some()).fold(0, |sum, accessor| sum.saturating_add(accessor.count as u64))
}
