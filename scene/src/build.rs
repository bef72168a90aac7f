//! From a document to a scene.

use std::sync::Arc;

use aam::document::{AnimationMode, Object};
use aam::meaning::{
    Hierarchy, Materials, Motion, ObjectMesh, SmoothingRule, frame_range, frames_per_second, has_local_coordinates,
    object_motions,
};
use aam::{Document, Finding, Severity};

use crate::frames::{affordable_frames, later_objects};
use crate::materials::{MaterialList, Textures};
use crate::mesh::{Meshes, Shared, weld_mesh};
use crate::{Animation, Node, NodeId, NodeMotion, Scene, TextureSource, Up};

/// How to build. The default is what `aam view` uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// The most frames that an animation is sampled at; the rest is cut off with a warning. Default 10 000.
    pub max_frames: usize,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { max_frames: 10_000 }
    }
}

/// The most transforms that are kept for the animation of a whole scene (64 bytes each).
const MAX_TRANSFORMS: usize = 1 << 24;

/// A scene, and what was odd on the way to it.
#[derive(Clone, Debug, Default)]
pub struct Built {
    /// The scene.
    pub scene: Scene,
    /// What was left out or replaced: hierarchy first, then object by object, then textures, then animation.
    pub warnings: Vec<Finding>,
}

/// Builds the scene of a document: one node for each object of frame 0, parents before children.
///
/// - Objects that draw nothing are nodes without a mesh. Triangles that cannot be drawn are left out, with a warning
///   ([`ObjectMesh`] says which); those without area stay.
/// - Corners that agree in everything that is drawn (in all frames) are one vertex. Meshes hold the attributes that their
///   materials use: texture coordinates only for layers that have an image, tangents only where a tangent-space normal
///   map is not hidden by a light map.
/// - Equal materials, equal meshes, and textures that are one file under several names are there once. Materials and
///   textures that no triangle uses are left out. A texture that cannot be had is kept with the reason and warned of once.
/// - A `Full` animation becomes later frames of its meshes, keys become transforms sampled once a frame from the first to
///   the last key.
///
/// Nothing in a document makes this fail; the same document and textures give the same scene.
pub fn build(document: &Document, textures: &dyn TextureSource, options: &BuildOptions) -> Built {
    let materials = Materials::of(document);
    let rule = SmoothingRule::of(document);
    let hierarchy = Hierarchy::of(document.objects());
    let mut warnings = hierarchy.findings.clone();
    warnings.extend(unused_numbers(document));

    let mut meshes: Vec<ObjectMesh> =
        document.objects().iter().map(|object| ObjectMesh::of(object, &materials, rule)).collect();
    for (object, mesh) in document.objects().iter().zip(&mut meshes) {
        warnings.append(&mut mesh.findings);
        warnings.extend(unused_pivot(document, object));
    }
    let subsets = meshes.iter().flat_map(|mesh| &mesh.subsets);
    let textures = Textures::load(&materials, subsets, textures, &mut warnings);

    let frame_count = frame_count(document, options);
    let later = later_objects(document, frame_count.kept, &mut warnings);
    let frame_count = frame_count.at_most(affordable_frames(&meshes, &later, frame_count.kept));
    let shared = Shared { materials: &materials, textures: &textures, rule };
    let mut material_list = MaterialList::default();
    let mut mesh_list = Meshes::default();
    let mut mesh_of = Vec::with_capacity(meshes.len());
    for ((object, mesh), later) in document.objects().iter().zip(&meshes).zip(&later) {
        if mesh.triangles.is_empty() {
            mesh_of.push(None);
            continue;
        }
        let later = &later[..later.len().min(frame_count.kept - 1)];
        let ids: Vec<_> = mesh.subsets.iter().map(|subset| material_list.of(subset, &materials, &textures)).collect();
        mesh_of.push(Some(mesh_list.share(Arc::new(weld_mesh(object, mesh, &ids, later, &shared)))));
    }

    let motions = object_motions(document);
    let first =
        if has_local_coordinates(document) { frame_range(document).map_or(0.0, |(first, _)| first) } else { 0.0 };
    let node_of = nodes_in_order(&hierarchy.order);
    let mut nodes: Vec<Node> = Vec::with_capacity(meshes.len());
    for &index in &hierarchy.order {
        nodes.push(Node {
            name: document.objects()[index].name.decoded(),
            parent: hierarchy.parents[index].map(|parent| node_of[parent]),
            local: motions[index].at(first),
            mesh: mesh_of[index],
            visible: true,
        });
    }
    let animation = animation(document, &motions, &node_of, first, frame_count, &mut warnings);
    let scene = Scene {
        up: Up::Z,
        nodes,
        meshes: mesh_list.list,
        materials: material_list.list,
        textures: textures.list,
        animation,
        ..Scene::default()
    };
    Built { scene, warnings }
}

/// The node that [`build`] makes of each object of frame 0, by the object's position. Parents come before children, which
/// in a document need not be so.
pub fn object_nodes(document: &Document) -> Vec<NodeId> {
    nodes_in_order(&Hierarchy::of(document.objects()).order)
}

fn nodes_in_order(order: &[usize]) -> Vec<NodeId> {
    let mut nodes = vec![NodeId(0); order.len()];
    for (node, &object) in order.iter().enumerate() {
        nodes[object] = NodeId(node as u32);
    }
    nodes
}

fn unused_numbers(document: &Document) -> Option<Finding> {
    let faces = || document.objects().iter().filter_map(|object| object.faces.as_ref());
    let numbered = || faces().any(|faces| faces.triangles.iter().any(|triangle| triangle.smoothing != 0));
    (!document.geometry.smoothing_groups && numbered()).then(|| Finding {
        code: "geometry/smoothing-off",
        severity: Severity::Info,
        position: None,
        subject: String::new(),
        message: "GEOMETRY stands without SmGEnabled, so that smoothing numbers mean nothing; faces are drawn flat"
            .to_owned(),
    })
}

fn unused_pivot(document: &Document, object: &Object) -> Option<Finding> {
    let node = object.node.as_ref().filter(|_| has_local_coordinates(document))?;
    let [x, y, z, _] = node.pivot_orientation;
    let set = node.pivot_position.iter().chain(&[x, y, z]).any(|&value| value != 0.0);
    set.then(|| Finding {
        code: "pose/pivot",
        severity: Severity::Info,
        position: None,
        subject: format!("object {} \"{}\"", object.id, object.name),
        message: "Piv is not zero; it is kept, and moves nothing".to_owned(),
    })
}

/// How many frames an animation has, and how many of them are played; both at least 1.
#[derive(Clone, Copy)]
struct FrameCount {
    wanted: usize,
    kept: usize,
}

impl FrameCount {
    fn at_most(self, limit: usize) -> Self {
        Self { kept: self.kept.min(limit).max(1), ..self }
    }
}

fn frame_count(document: &Document, options: &BuildOptions) -> FrameCount {
    // A length that no number of frames can hold saturates.
    let length = frame_range(document).map_or(0.0, |(first, last)| (f64::from(last) - f64::from(first)).ceil());
    let wanted = (length as usize).saturating_add(1);
    FrameCount { wanted, kept: wanted }.at_most(options.max_frames)
}

fn animation(
    document: &Document,
    motions: &[Motion],
    node_of: &[NodeId],
    first: f32,
    mut count: FrameCount,
    warnings: &mut Vec<Finding>,
) -> Option<Animation> {
    let moves = |index: &usize| motions[*index].frame_range().is_some_and(|(first, last)| first < last);
    let moving: Vec<usize> = match document.geometry.animation {
        AnimationMode::Full => Vec::new(),
        AnimationMode::None | AnimationMode::Keyframe => (0..motions.len()).filter(moves).collect(),
    };
    count = count.at_most(MAX_TRANSFORMS / moving.len().max(1));
    if count.kept < count.wanted {
        warnings.push(Finding {
            code: "animation/cut",
            severity: Severity::Warning,
            position: None,
            subject: "animation".to_owned(),
            message: format!("of {} frames only the first {} are played", count.wanted, count.kept),
        });
    }
    if count.kept < 2 {
        return None;
    }
    let mut nodes: Vec<NodeMotion> = moving
        .into_iter()
        .map(|index| {
            let locals = (0..count.kept).map(|frame| motions[index].at(first + frame as f32)).collect();
            NodeMotion { node: node_of[index], locals }
        })
        .filter(|motion: &NodeMotion| motion.locals.windows(2).any(|pair| pair[0] != pair[1]))
        .collect();
    nodes.sort_by_key(|motion| motion.node);
    Some(Animation { frames_per_second: frames_per_second(document), frame_count: count.kept, nodes })
}

#[cfg(test)]
#[path = "build_tests.rs"]
mod tests;
