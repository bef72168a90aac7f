//! Recording the passes that draw and blur maps.

use aam_scene::Scene;

use super::casters::CasterDraw;
use super::pipelines::{CasterKey, RunningKey};
use super::{BlurPass, FrameShadows, Map, MapPass, ShadowTable, empty_moments, uniform_stride};
use crate::draws::{DrawList, mesh_of};
use crate::materials::{MaterialTable, bind};
use crate::meshes::MeshTable;
use crate::pipelines::DEPTH_FORMAT;
use crate::targets::{TargetKey, TargetPool};
use crate::timing::{Stamps, Timing};
use crate::{FrameStats, Gpu};

/// Where everything that maps are drawn with is.
#[derive(Debug)]
pub(crate) struct CasterSources<'a> {
    pub gpu: &'a Gpu,
    pub scene: &'a Scene,
    pub list: &'a DrawList,
    pub meshes: &'a MeshTable,
    pub materials: &'a MaterialTable,
    pub instances: Option<&'a wgpu::Buffer>,
    pub frame_group: Option<&'a wgpu::BindGroup>,
    pub timing: Option<&'a Timing>,
    pub picture: u64,
}

impl ShadowTable {
    /// Records all passes before the picture.
    pub(crate) fn record(
        &self,
        frame: &FrameShadows,
        from: &CasterSources<'_>,
        targets: &mut TargetPool,
        encoder: &mut wgpu::CommandEncoder,
        mut stamps: Option<&mut Stamps>,
        stats: &mut FrameStats,
    ) {
        for pass in &frame.passes {
            self.record_map(pass, from, targets, encoder, stamps.as_deref_mut(), stats);
            stats.shadow_maps += 1;
        }
        self.record_volumes(&frame.volumes, from, targets, encoder, stamps.as_deref_mut(), stats);
        for blur in &frame.blurs {
            let Some(map) = &self.maps[blur.source] else { continue };
            let key = TargetKey {
                width: map.key.width,
                height: map.key.height,
                format: map.key.format,
                samples: 1,
                usage: wgpu::TextureUsages::TEXTURE_BINDING
                    | if blur.running {
                        wgpu::TextureUsages::STORAGE_BINDING
                    } else {
                        wgpu::TextureUsages::RENDER_ATTACHMENT
                    },
            };
            let (texture, scratch) = targets.get(from.gpu, key, from.picture);
            let scratch_array = texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..wgpu::TextureViewDescriptor::default()
            });
            if blur.running {
                self.record_running(blur, map, (&scratch, &scratch_array), from, encoder, stamps.as_deref_mut());
                continue;
            }
            let steps = [
                ("shadow blur rows", &map.array, &scratch, false),
                ("shadow blur columns", &scratch_array, &map.layers[blur.layer], true),
            ];
            for (step, (name, source, target, vertical)) in steps.into_iter().enumerate() {
                let Some(pipeline) = self.pipelines.blur(map.key.format, vertical) else { continue };
                let Some(group) = self.blur_group(from.gpu, source) else { continue };
                let mut pass =
                    begin(encoder, name, Some((target, wgpu::Color::BLACK)), None, from, stamps.as_deref_mut());
                pass.set_pipeline(pipeline);
                let offset = (blur.offset as usize + step) * uniform_stride(from.gpu);
                pass.set_bind_group(0, &group, &[offset as u32]);
                pass.draw(0..3, 0..1);
            }
        }
    }

    fn record_running(
        &self,
        blur: &BlurPass,
        map: &Map,
        (scratch, scratch_array): (&wgpu::TextureView, &wgpu::TextureView),
        from: &CasterSources<'_>,
        encoder: &mut wgpu::CommandEncoder,
        mut stamps: Option<&mut Stamps>,
    ) {
        let layer = &map.layers[blur.layer];
        let means = RunningKey::means(map.key.format);
        let passes =
            ["shadow blur rows", "shadow blur columns"].into_iter().flat_map(|name| means.map(|key| (name, key)));
        for (name, key) in passes {
            // There and back again.
            let (source, target) = if key.second { (scratch_array, layer) } else { (&map.array, scratch) };
            let (Some(pipeline), Some(layout), Some(uniform)) = (
                self.pipelines.running(&key),
                self.pipelines.built_running_layout(map.key.format),
                self.blur_uniform.get(),
            ) else {
                continue;
            };
            let size = std::num::NonZeroU64::new(8);
            let group = from.gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("running blur"),
                layout,
                entries: &[
                    bind(0, wgpu::BindingResource::TextureView(source)),
                    bind(1, wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer: uniform, offset: 0, size })),
                    bind(2, wgpu::BindingResource::TextureView(target)),
                ],
            });
            let marks = stamps.as_deref_mut().and_then(|stamps| stamps.pass(name));
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(name),
                timestamp_writes: from.timing.zip(marks).map(|(timing, [first, last])| {
                    wgpu::ComputePassTimestampWrites {
                        query_set: timing.queries(),
                        beginning_of_pass_write_index: Some(first),
                        end_of_pass_write_index: Some(last),
                    }
                }),
            });
            pass.set_pipeline(pipeline);
            let offset = (blur.offset as usize + usize::from(key.second)) * uniform_stride(from.gpu);
            pass.set_bind_group(0, &group, &[offset as u32]);
            pass.dispatch_workgroups(map.key.width.div_ceil(16), 1, 1);
        }
    }

    fn blur_group(&self, gpu: &Gpu, source: &wgpu::TextureView) -> Option<wgpu::BindGroup> {
        let size = std::num::NonZeroU64::new(8);
        let radius = wgpu::BufferBinding { buffer: self.blur_uniform.get()?, offset: 0, size };
        Some(gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("blur"),
            layout: self.pipelines.built_blur_layout()?,
            entries: &[
                bind(0, wgpu::BindingResource::TextureView(source)),
                bind(1, wgpu::BindingResource::Buffer(radius)),
            ],
        }))
    }

    fn record_map(
        &self,
        map_pass: &MapPass,
        from: &CasterSources<'_>,
        targets: &mut TargetPool,
        encoder: &mut wgpu::CommandEncoder,
        stamps: Option<&mut Stamps>,
        stats: &mut FrameStats,
    ) {
        let Some(map) = &self.maps[map_pass.source] else { return };
        let layer = &map.layers[map_pass.layer];
        let moments = map_pass.settings.technique.filter.has_moments();
        let own_depth = moments.then(|| {
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
            let (width, height) = (map.key.width, map.key.height);
            targets.get(from.gpu, TargetKey { width, height, format: DEPTH_FORMAT, samples: 1, usage }, from.picture).1
        });
        let [r, g, b, a] = empty_moments(&map_pass.settings);
        let color = moments.then_some((layer, wgpu::Color { r, g, b, a }));
        let depth = (own_depth.as_ref().unwrap_or(layer), !moments);
        let (view, keep) = depth;
        let depth = keeps_depth(view, wgpu::LoadOp::Clear(1.0), keep);
        let mut pass = begin(encoder, "shadow maps", color, Some(depth), from, stamps);
        self.record_casters(&mut pass, &map_pass.draws, map_pass.offset, from, stats);
    }

    /// Draws casters as the view at a place in the caster uniforms sees them.
    pub(super) fn record_casters(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        draws: &[(CasterDraw, CasterKey)],
        offset: u32,
        from: &CasterSources<'_>,
        stats: &mut FrameStats,
    ) {
        let (Some(frame_group), Some(caster_group), Some(instances)) =
            (from.frame_group, &self.caster_group, from.instances)
        else {
            return;
        };
        pass.set_bind_group(0, frame_group, &[]);
        let offset = offset as usize * uniform_stride(from.gpu);
        pass.set_bind_group(2, caster_group, &[offset as u32]);
        for (draw, key) in draws {
            let batch = draw.batch.of(from.list);
            let (Some(pipeline), Some(mesh)) =
                (self.pipelines.caster(key), from.meshes.get(mesh_of(from.scene, batch)))
            else {
                continue;
            };
            pass.set_pipeline(pipeline);
            if key.caster.cut.is_some() {
                let Some(material) = from.materials.bind_group(batch.material) else { continue };
                pass.set_bind_group(1, material, &[]);
            }
            let mut slot = 0;
            for stream in key.caster.streams(batch.base_layer()) {
                if let Some(buffer) = mesh.stream(stream) {
                    pass.set_vertex_buffer(slot, buffer.slice(..));
                }
                slot += 1;
            }
            pass.set_vertex_buffer(slot, instances.slice(..));
            pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(batch.indices.clone(), 0, draw.instances.clone());
            stats.draws += 1;
            stats.caster_draws += 1;
            stats.triangles += batch.indices.len() as u64 / 3 * draw.instances.len() as u64;
        }
    }
}

/// A depth attachment without stencil.
fn keeps_depth(
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<f32>,
    keep: bool,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load,
            store: if keep { wgpu::StoreOp::Store } else { wgpu::StoreOp::Discard },
        }),
        stencil_ops: None,
    }
}

pub(super) fn begin<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    name: &'static str,
    color: Option<(&wgpu::TextureView, wgpu::Color)>,
    depth: Option<wgpu::RenderPassDepthStencilAttachment<'_>>,
    from: &CasterSources<'_>,
    stamps: Option<&mut Stamps>,
) -> wgpu::RenderPass<'e> {
    let marks = stamps.and_then(|stamps| stamps.pass(name));
    let attachment = color.map(|(view, clear)| {
        Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(clear), store: wgpu::StoreOp::Store },
        })
    });
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(name),
        color_attachments: attachment.as_slice(),
        depth_stencil_attachment: depth,
        timestamp_writes: from.timing.zip(marks).map(|(timing, [first, last])| wgpu::RenderPassTimestampWrites {
            query_set: timing.queries(),
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(last),
        }),
        occlusion_query_set: None,
        multiview_mask: None,
    })
}
