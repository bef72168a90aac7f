//! Drawing shadow volumes: what the camera sees is drawn first, then volumes count behind it, and what was counted as
//! often in as out is lit.

use std::collections::HashMap;
use std::sync::Arc;

use aam_scene::{Aabb, Projection, Scene, View};
use glam::{DAffine3, DVec4, Vec3};

use super::casters::{CasterDraw, placed};
use super::fit::Placement;
use super::pipelines::{CasterKey, counting_format};
use super::record::{CasterSources, begin};
use super::uniform::GpuCasterView;
use super::volume::Topology;
use super::{ShadowTable, uniform_stride};
use crate::camera::boundless_clip;
use crate::draws::DrawList;
use crate::meshes::{MeshTable, cpu_positions};
use crate::targets::{TargetKey, TargetPool};
use crate::timing::Stamps;
use crate::upload::Uploader;
use crate::{FrameStats, RenderError};

/// What is drawn of the volumes of a frame.
#[derive(Debug, Default)]
pub(crate) struct VolumeFrame {
    /// What the camera sees, and the place of its view in the caster uniforms.
    pub seen: Vec<(CasterDraw, CasterKey)>,
    pub camera: u32,
    pub passes: Vec<VolumePass>,
}

impl VolumeFrame {
    pub(crate) fn is_empty(&self) -> bool {
        self.passes.is_empty()
    }
}

/// The volumes of one source.
#[derive(Debug)]
pub(crate) struct VolumePass {
    source: usize,
    /// Place in the caster uniforms.
    offset: u32,
    pub draws: Vec<VolumeDraw>,
}

/// The volume of one instance.
#[derive(Debug)]
pub(crate) struct VolumeDraw {
    corners: wgpu::Buffer,
    count: u32,
    instance: u32,
    pub mirrored: bool,
}

/// What volumes are made from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Volumes<'a> {
    pub scene: &'a Scene,
    pub list: &'a DrawList,
    pub meshes: &'a MeshTable,
    pub boxes: &'a [Aabb],
    pub view: &'a View,
    pub eye: Vec3,
    pub placement: &'a Placement,
}

/// A mesh at an animation frame.
type Shape = (u64, usize);

/// A shape, and where the source stands for it.
type VolumeKey = (Shape, [u64; 4]);

#[derive(Debug)]
struct Built {
    /// `None` where there is no volume: nothing faces the source.
    corners: Option<(wgpu::Buffer, u32)>,
    used: bool,
}

/// Volumes made so far, for as long as neither caster nor source moves.
#[derive(Debug, Default)]
pub(crate) struct VolumeTable {
    topologies: HashMap<Shape, (Arc<Topology>, bool)>,
    built: HashMap<VolumeKey, Built>,
}

/// A distance beyond everything that casts or receives, as seen by a camera without perspective.
pub(crate) fn reach(view: &View, boxes: &[Aabb]) -> f32 {
    let all = boxes.iter().fold(Aabb::EMPTY, |sum, aabb| sum.union(aabb));
    let corner = all.max.abs().max(all.min.abs());
    if all.is_empty() { 1.0 } else { 2.0 * (all.diagonal() + (corner + view.camera.position.abs()).length()) }
}

impl VolumeTable {
    /// Makes the volumes of all casters that a source has, and says how they are drawn.
    pub(crate) fn prepare(
        &mut self,
        source: usize,
        from: &Volumes<'_>,
        casts: impl Fn(u32) -> bool,
        uploader: &mut Uploader<'_>,
        views: &mut Vec<GpuCasterView>,
    ) -> Result<VolumePass, RenderError> {
        let Volumes { scene, list, meshes, boxes, view, eye, placement } = *from;
        let reach = reach(view, boxes);
        let parallel = matches!(view.camera.projection, Projection::Orthographic { .. });
        let clip = boundless_clip(view, 2.0 * reach);
        let mut pass = VolumePass { source, offset: views.len() as u32, draws: Vec::new() };
        views.push(GpuCasterView::of_volume(clip, placement, if parallel { reach } else { 0.0 }, eye));
        for drawn in &list.meshes {
            let mesh = &scene.meshes[drawn.mesh];
            let Some(gpu_mesh) = meshes.get(mesh) else { continue };
            let shape = (gpu_mesh.serial, drawn.frame);
            for instance in drawn.instances.clone().filter(|instance| casts(*instance)) {
                let world = placed(&list.instances[instance as usize]);
                let matrix = world.matrix3;
                let exact = DAffine3::from_mat3_translation(
                    glam::DMat3::from_cols(
                        matrix.x_axis.as_dvec3(),
                        matrix.y_axis.as_dvec3(),
                        matrix.z_axis.as_dvec3(),
                    ),
                    world.translation.as_dvec3(),
                );
                let inverse = exact.inverse();
                let local: DVec4 = if placement.perspective {
                    inverse.transform_point3(placement.origin).extend(1.0)
                } else {
                    inverse.transform_vector3(placement.origin).extend(0.0)
                };
                // What is flattened to a plane has no inside to be seen from; its shadow is a line.
                if !local.is_finite() {
                    continue;
                }
                let key = (shape, local.to_array().map(f64::to_bits));
                if !self.built.contains_key(&key) {
                    let (topology, _) = self
                        .topologies
                        .entry(shape)
                        .or_insert_with(|| (Arc::new(Topology::of(mesh, cpu_positions(mesh, drawn.frame))), true));
                    let volume = topology.volume(mesh, cpu_positions(mesh, drawn.frame), local);
                    let corners = if volume.corners.is_empty() {
                        None
                    } else {
                        let bytes = bytemuck::cast_slice(&volume.corners);
                        let buffer = uploader.buffer("shadow volume", wgpu::BufferUsages::VERTEX, bytes)?;
                        Some((buffer, volume.corners.len() as u32))
                    };
                    self.built.insert(key, Built { corners, used: true });
                }
                if let Some((_, used)) = self.topologies.get_mut(&shape) {
                    *used = true;
                }
                let Some(built) = self.built.get_mut(&key) else { continue };
                built.used = true;
                if let Some((corners, count)) = &built.corners {
                    pass.draws.push(VolumeDraw {
                        corners: corners.clone(),
                        count: *count,
                        instance,
                        mirrored: exact.matrix3.determinant() < 0.0,
                    });
                }
            }
        }
        Ok(pass)
    }

    /// Frees what this frame did not use.
    pub(crate) fn sweep(&mut self) {
        self.built.retain(|_, built| std::mem::take(&mut built.used));
        self.topologies.retain(|_, (_, used)| std::mem::take(used));
    }
}

impl ShadowTable {
    /// Records what counts the pixels in volumes.
    pub(super) fn record_volumes(
        &self,
        frame: &VolumeFrame,
        from: &CasterSources<'_>,
        targets: &mut TargetPool,
        encoder: &mut wgpu::CommandEncoder,
        mut stamps: Option<&mut Stamps>,
        stats: &mut FrameStats,
    ) {
        for (number, volumes) in frame.passes.iter().enumerate() {
            let Some(map) = &self.maps[volumes.source] else { continue };
            let key = TargetKey {
                width: map.key.width,
                height: map.key.height,
                format: counting_format(from.gpu),
                samples: 1,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            };
            let (_, depth) = targets.get(from.gpu, key, from.picture);
            let attachment = |depth_load, stencil_load| wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(wgpu::Operations { load: depth_load, store: wgpu::StoreOp::Store }),
                stencil_ops: Some(wgpu::Operations { load: stencil_load, store: wgpu::StoreOp::Store }),
            };
            let zero = wgpu::LoadOp::Clear(0);
            if number == 0 {
                let seen = attachment(wgpu::LoadOp::Clear(0.0), zero);
                let mut pass = begin(encoder, "shadow volumes", None, Some(seen), from, stamps.as_deref_mut());
                self.record_casters(&mut pass, &frame.seen, frame.camera, from, stats);
            }
            let counted = attachment(wgpu::LoadOp::Load, zero);
            let mut pass = begin(encoder, "shadow volumes", None, Some(counted), from, stamps.as_deref_mut());
            let (Some(frame_group), Some(group), Some(instances), Some(mask)) =
                (from.frame_group, &self.caster_group, from.instances, self.pipelines.mask())
            else {
                continue;
            };
            pass.set_bind_group(0, frame_group, &[]);
            let offset = volumes.offset as usize * uniform_stride(from.gpu);
            pass.set_bind_group(2, group, &[offset as u32]);
            for draw in &volumes.draws {
                let Some(pipeline) = self.pipelines.volume(draw.mirrored) else { continue };
                pass.set_pipeline(pipeline);
                pass.set_vertex_buffer(0, draw.corners.slice(..));
                pass.set_vertex_buffer(1, instances.slice(..));
                pass.draw(0..draw.count, draw.instance..draw.instance + 1);
                stats.draws += 1;
                stats.caster_draws += 1;
                stats.triangles += u64::from(draw.count / 3);
            }
            drop(pass);
            let counted = attachment(wgpu::LoadOp::Load, wgpu::LoadOp::Load);
            let color = Some((&map.layers[0], wgpu::Color::BLACK));
            let mut pass = begin(encoder, "shadow volumes", color, Some(counted), from, stamps.as_deref_mut());
            pass.set_pipeline(mask);
            pass.set_stencil_reference(0);
            pass.draw(0..3, 0..1);
            stats.shadow_maps += 1;
        }
    }
}
