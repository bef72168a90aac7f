//! Later frames of meshes in a `Full` animation.

use std::collections::HashMap;

use aam::document::{AnimationMode, Object};
use aam::meaning::{ObjectMesh, SmoothingRule, frame_normals};
use aam::{Document, Finding, Severity};
use glam::Vec3;

use crate::MeshFrame;

/// The most corners that normals are formed for over all frames; about a minute of work.
const MAX_CORNERS: usize = 1 << 30;
/// The most vertices that later frames may hold together (24 bytes each).
const MAX_VERTICES: usize = 1 << 28;

/// For each object of frame 0 the same object in each later frame of a `Full` animation, or nothing if it never changes.
///
/// An object is looked for at the same place in the list, or else by its id. The first frame that lacks it, or has it with
/// another number of vertices, ends its motion, with a warning: it stays as it was.
pub(crate) fn later_objects<'a>(
    document: &'a Document,
    frame_count: usize,
    warnings: &mut Vec<Finding>,
) -> Vec<Vec<&'a Object>> {
    let first = document.objects();
    let mut later: Vec<Vec<&Object>> = vec![Vec::new(); first.len()];
    if document.geometry.animation != AnimationMode::Full {
        return later;
    }
    let mut alive: Vec<usize> = (0..first.len()).filter(|&index| !first[index].vertices.is_empty()).collect();
    for (number, frame) in document.geometry.frames.iter().enumerate().take(frame_count).skip(1) {
        let mut by_id: Option<HashMap<i32, &Object>> = None;
        alive.retain(|&index| {
            let object = &first[index];
            let here = frame.objects.get(index).filter(|here| here.id == object.id);
            let same = here.or_else(|| {
                let by_id =
                    by_id.get_or_insert_with(|| frame.objects.iter().rev().map(|object| (object.id, object)).collect());
                by_id.get(&object.id).copied()
            });
            match same.filter(|same| same.vertices.len() == object.vertices.len()) {
                Some(same) => {
                    later[index].push(same);
                    true
                }
                None => {
                    warnings.push(Finding {
                        code: "animation/object-missing",
                        severity: Severity::Warning,
                        position: None,
                        subject: format!("object {} \"{}\"", object.id, object.name),
                        message: format!(
                            "frame {number} lacks it or has another number of vertices; it stays still from there"
                        ),
                    });
                    false
                }
            }
        });
    }
    for (object, later) in first.iter().zip(&mut later) {
        if !later.iter().any(|later| later.frame_normals.is_some() || later.vertices != object.vertices) {
            later.clear();
        }
    }
    later
}

/// How many frames can be had within the limits on work and memory.
pub(crate) fn affordable_frames(meshes: &[ObjectMesh], later: &[Vec<&Object>], wanted: usize) -> usize {
    let moving = meshes.iter().zip(later).filter(|(_, later)| !later.is_empty());
    let (corners, vertices) = moving.fold((0, 0), |(corners, vertices), (mesh, _)| {
        (corners + mesh.corners.len(), vertices + mesh.corners.len().min(MAX_VERTICES))
    });
    // Welding leaves fewer vertices than corners, typically a quarter; how many is known too late.
    let by_work = MAX_CORNERS / corners.max(1);
    let by_memory = MAX_VERTICES / (vertices / 4).max(1);
    wanted.min(by_work.min(by_memory).saturating_add(1))
}

/// What the corners of a moving mesh are told apart by, so that those of one vertex have one normal in every frame: the
/// smoothing number that their normals are formed by (of faces that smooth with none, the face), the explicit normal.
pub(crate) struct NormalKeys<'a> {
    object: &'a Object,
    rule: SmoothingRule,
    explicit: bool,
    formed: bool,
}

impl<'a> NormalKeys<'a> {
    pub(crate) fn new(object: &'a Object, later: &[&Object], rule: SmoothingRule) -> Self {
        let explicit = later.iter().any(|later| later.frame_normals.is_some());
        let formed = later.iter().any(|later| later.frame_normals.is_none());
        Self { object, rule, explicit, formed }
    }

    pub(crate) fn of(&self, triangle: u32, corner: usize) -> [u32; 3] {
        let Some(faces) = &self.object.faces else {
            return [0; 3];
        };
        let smoothing = faces.triangles[triangle as usize].smoothing;
        let [kind, number] = if !self.formed {
            [0, 0]
        } else if self.rule == SmoothingRule::Flat || smoothing == 0 {
            [1, triangle]
        } else {
            [2, smoothing.cast_unsigned()]
        };
        let normal = faces.normal_indices.get(triangle as usize).filter(|_| self.explicit);
        [kind, number, normal.map_or(u32::MAX, |normal| normal[corner])]
    }
}

/// The later frames of a mesh. `corners` holds for each of its vertices one corner of `mesh`. A position that is not
/// finite stays where it was.
pub(crate) fn mesh_frames(
    first: &Object,
    later: &[&Object],
    mesh: &ObjectMesh,
    corners: &[usize],
    rule: SmoothingRule,
) -> Vec<MeshFrame> {
    let mut last: Vec<Vec3> =
        corners.iter().map(|&corner| Vec3::from(first.vertices[mesh.corners[corner] as usize])).collect();
    later
        .iter()
        .map(|object| {
            for (last, &corner) in last.iter_mut().zip(corners) {
                let position = Vec3::from(object.vertices[mesh.corners[corner] as usize]);
                if position.is_finite() {
                    *last = position;
                }
            }
            let normals = frame_normals(first, object, rule);
            let normal = |&corner: &usize| normals[mesh.triangles[corner / 3] as usize][corner % 3];
            MeshFrame { positions: last.clone(), normals: corners.iter().map(normal).collect() }
        })
        .collect()
}
