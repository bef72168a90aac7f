//! A simulation as an animated document.

use aam::Document;
use aam::document::{AnimationMode, Flagged, Header, NodeTransform, Object, PositionSample, RotationSample, Track};
use aam_scene::{NodeId, Scene};
use glam::{Affine3A, Vec3};

use crate::Simulator;
use crate::pose::{Pose, Poses};

/// A document that plays what was simulated.
#[derive(Clone, Debug, Default)]
pub struct Film {
    /// A character whose objects move by keys, one for each frame.
    pub document: Document,
    /// What of the original is not in it, as sentences.
    pub left_out: Vec<&'static str>,
}

impl Simulator {
    /// A document with its objects where they were at these moments, one frame for each, `frames_per_second` apart.
    ///
    /// `nodes` holds the scene's node of each object of the document's first frame. Each object becomes one without parent,
    /// with its scale and shear in its vertices and its place and turn in keys, so that nothing is lost in taking
    /// transforms apart; objects that follow a body move with it.
    pub fn film(
        &self,
        document: &Document,
        nodes: &[NodeId],
        scene: &Scene,
        frames: &[Poses],
        frames_per_second: f32,
    ) -> Film {
        let mut film = Film { document: document.clone(), left_out: Vec::new() };
        let Some(first) = frames.first() else { return film };
        let places = self.transforms_at(scene, first);
        let geometry = &mut film.document.geometry;
        if geometry.animation != AnimationMode::None {
            film.left_out.push("the animation that the file had is left out");
        }
        if film.document.physics.take().is_some() {
            film.left_out.push("PHYSICS is left out: this file plays what was simulated");
        }
        geometry.frames.truncate(1);
        geometry.animation = if frames.len() > 1 { AnimationMode::Keyframe } else { AnimationMode::None };
        geometry.animation_frames = frames.len() as u32;
        geometry.frames_per_second = Some(frames_per_second);
        film.document.header = Some(Header::Character);
        let objects = geometry.frames.first_mut().map_or(&mut [][..], |frame| &mut frame.objects[..]);
        let mut skinned = false;
        for (object, node) in objects.iter_mut().zip(nodes) {
            let body = self.body_above(scene, *node);
            let pose = |poses: &Poses| body.and_then(|body| poses.poses.get(body).copied()).unwrap_or_default();
            let start = pose(first);
            let place = places.get(node.index()).copied().unwrap_or(Affine3A::IDENTITY);
            bake(object, &(start.to_affine().inverse() * place));
            object.parent = -1;
            object.node = Some(rest(start));
            skinned |= matches!(std::mem::take(&mut object.skin), Flagged::Yes(_));
            let poses: Vec<Pose> = frames.iter().map(pose).collect();
            object.keys =
                if poses.iter().any(|pose| *pose != start) { Flagged::Yes(keys(&poses)) } else { Flagged::No };
        }
        if skinned {
            film.left_out.push("skins are left out");
        }
        film
    }

    /// The body that a node is or follows.
    fn body_above(&self, scene: &Scene, node: NodeId) -> Option<usize> {
        let mut node = Some(node);
        // A parent stands before its child, so that this ends.
        while let Some(here) = node {
            if let Some(body) = self.body_of(here) {
                return Some(body);
            }
            node = scene.nodes.get(here.index())?.parent.filter(|parent| *parent < here);
        }
        None
    }
}

/// Puts a transform into an object's vertices and normals.
fn bake(object: &mut Object, map: &Affine3A) {
    for vertex in &mut object.vertices {
        *vertex = map.transform_point3(Vec3::from(*vertex)).to_array();
    }
    let Some(faces) = &mut object.faces else { return };
    let normal = map.matrix3.inverse().transpose();
    for value in faces.normals.iter_mut().flatten() {
        *value = (normal * Vec3::from(*value)).normalize_or(Vec3::Z).to_array();
    }
    if map.matrix3.determinant() < 0.0 {
        // A reflection turns triangles inside out.
        faces.triangles.iter_mut().for_each(|triangle| triangle.vertices.swap(1, 2));
        faces.normal_indices.iter_mut().for_each(|corners| corners.swap(1, 2));
        faces.tex_indices.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
}

fn rest(pose: Pose) -> NodeTransform {
    let matrix = glam::Mat3::from_quat(pose.rotation);
    // The rows of the file are the columns of a matrix for column vectors.
    NodeTransform {
        rotation: [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.to_array()),
        position: pose.position.to_array(),
        ..NodeTransform::default()
    }
}

fn keys(poses: &[Pose]) -> Vec<Track> {
    let numbered = || poses.iter().enumerate().map(|(frame, pose)| (frame as f32, pose));
    let positions =
        numbered().map(|(frame, pose)| PositionSample { frame, position: pose.position.to_array() }).collect();
    let rotations = numbered()
        .map(|(frame, pose)| {
            let (axis, angle) = pose.rotation.to_axis_angle();
            RotationSample { frame, axis: axis.to_array(), angle }
        })
        .collect();
    vec![Track::PositionSampled(positions), Track::RotationSampled(rotations)]
}
