//! How restless a shadow is while something moves by less than a texel.

use aam_reference::{LightSize, Options};
use aam_scene::{LightKind, NodeId, Scene, View};
use glam::{Affine3A, Quat, Vec3};

use super::{Painter, Subject};
use crate::LabError;

/// Pictures of each motion after the first.
const STEPS: u32 = 4;

/// A step in texels of a map of [`TEXELS`] texels a side around the whole scene.
const STEP: f32 = 0.25;
const TEXELS: f32 = 1024.0;

/// For each motion the largest mean change of the visibility between two neighbouring pictures, over the pixels that
/// face the light; `None` where the scene has nothing that moves so.
///
/// Each of the four steps is a quarter of a texel of a map of 1024 texels a side around the whole scene: the camera
/// moves to its side, the light around the middle of the scene, and all objects but the largest to the camera's side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flicker {
    /// The camera moves.
    pub camera: Option<f64>,
    /// The light moves.
    pub light: Option<f64>,
    /// What casts moves.
    pub caster: Option<f64>,
}

impl Flicker {
    /// The largest of the three.
    pub fn most(&self) -> Option<f64> {
        [self.camera, self.light, self.caster].into_iter().flatten().reduce(f64::max)
    }

    /// Of a technique. `still` is its visibility without motion, and `faces` says which pixels count.
    ///
    /// # Errors
    /// A picture cannot be drawn.
    pub fn of(
        painter: &mut dyn Painter,
        scene: &Scene,
        subject: &Subject,
        still: &[f32],
        faces: &[bool],
    ) -> Result<Self, LabError> {
        Self::over(scene, subject, still, faces, &mut |scene, view| painter.visibility(scene, view))
    }

    /// Of the exact shadow of a point.
    ///
    /// # Errors
    /// The reference cannot draw the scene.
    pub fn of_truth(subject: &Subject, still: &[f32], faces: &[bool]) -> Result<Self, LabError> {
        Self::over(&subject.scene, subject, still, faces, &mut |scene, view| {
            let (mut visibility, _) = aam_reference::visibility(scene, view, LightSize::Point, &Options::default())?;
            let seen = visibility.lights.swap_remove(subject.light);
            Ok(seen.into_iter().map(|seen| seen.map_or(1.0, |seen| seen.share)).collect())
        })
    }

    fn over(
        scene: &Scene,
        subject: &Subject,
        still: &[f32],
        faces: &[bool],
        draw: &mut dyn FnMut(&Scene, &View) -> Result<Vec<f32>, LabError>,
    ) -> Result<Self, LabError> {
        let mut worst = |motion: Motion| -> Result<Option<f64>, LabError> {
            let mut before = still.to_vec();
            let mut most = 0.0_f64;
            for step in 1..=STEPS {
                let Some((scene, view)) = motion.moved(scene, subject, step as f32 * STEP) else { return Ok(None) };
                let after = draw(&scene, &view)?;
                most = most.max(mean_change(&before, &after, faces));
                before = after;
            }
            Ok(Some(most))
        };
        Ok(Self { camera: worst(Motion::Camera)?, light: worst(Motion::Light)?, caster: worst(Motion::Caster)? })
    }
}

fn mean_change(before: &[f32], after: &[f32], faces: &[bool]) -> f64 {
    let apart = before.iter().zip(after).zip(faces).filter(|(_, faces)| **faces);
    let (sum, count) =
        apart.fold((0.0, 0_u32), |(sum, count), ((a, b), _)| (sum + f64::from((a - b).abs()), count + 1));
    sum / f64::from(count.max(1))
}

#[derive(Clone, Copy)]
enum Motion {
    Camera,
    Light,
    Caster,
}

impl Motion {
    fn moved(self, scene: &Scene, subject: &Subject, texels: f32) -> Option<(Scene, View)> {
        let bounds = scene.bounds();
        let distance = texels * bounds.diagonal() / TEXELS;
        let camera = &subject.view.camera;
        let aside = (camera.target - camera.position).cross(camera.up).normalize_or(Vec3::X) * distance;
        let (mut scene, mut view) = (scene.clone(), subject.view.clone());
        match self {
            Self::Camera => {
                view.camera.position += aside;
                view.camera.target += aside;
            }
            Self::Light => {
                let middle = bounds.center();
                // A texel at the far side of the scene.
                let angle = texels / TEXELS;
                let turn = Quat::from_axis_angle(scene.up.axis(), angle);
                match &mut scene.lights.get_mut(subject.light)?.kind {
                    LightKind::Directional { direction } => *direction = turn * *direction,
                    // A lamp over the middle would turn in place.
                    LightKind::Point { position, .. } if (*position - middle).length() < 0.25 * bounds.diagonal() => {
                        *position += aside;
                    }
                    LightKind::Point { position, .. } => *position = middle + turn * (*position - middle),
                    LightKind::Spot { position, .. } => *position += aside,
                }
            }
            Self::Caster => {
                let moving = movers(&scene)?;
                // Nodes that move by themselves would undo it.
                if scene.animation.is_some() {
                    return None;
                }
                let world = scene.world_transforms();
                for id in moving {
                    let node = &mut scene.nodes[id.index()];
                    let above = node.parent.and_then(|parent| world.get(parent.index())).copied();
                    let local = above.unwrap_or(Affine3A::IDENTITY).inverse().transform_vector3(aside);
                    node.local.translation += glam::Vec3A::from(local);
                }
            }
        }
        Some((scene, view))
    }
}

/// All nodes with a mesh but the one with the largest, if there are others; of those that hang below each other the top.
fn movers(scene: &Scene) -> Option<Vec<NodeId>> {
    let world = scene.world_transforms();
    let size = |index: usize| {
        let mesh = scene.nodes[index].mesh.and_then(|mesh| scene.meshes.get(mesh.index()))?;
        Some(mesh.bounds.transformed(&world[index]).diagonal())
    };
    let sizes: Vec<Option<f32>> = (0..scene.nodes.len()).map(size).collect();
    let largest = (0..sizes.len())
        .filter(|&index| sizes[index].is_some())
        .max_by(|&a, &b| sizes[a].unwrap_or(0.0).total_cmp(&sizes[b].unwrap_or(0.0)))?;
    let mut moves: Vec<bool> = Vec::with_capacity(sizes.len());
    let mut tops = Vec::new();
    for (index, node) in scene.nodes.iter().enumerate() {
        let above = node.parent.is_some_and(|parent| moves.get(parent.index()).copied().unwrap_or(false));
        let own = sizes[index].is_some() && index != largest;
        if own && !above {
            tops.push(NodeId(index as u32));
        }
        moves.push(above || own);
    }
    (!tops.is_empty()).then_some(tops)
}
