//! The passes of a frame.

use aam_scene::{Scene, View};

use crate::backdrop::Backdrop;
use crate::displacement::DisplacementTable;
use crate::draws::DrawList;
use crate::encode::{Recorder, Sources};
use crate::materials::bind;
use crate::overlay::OverlayDraw;
use crate::pipelines::{Constants, DEPTH_FORMAT, PassFormat, PipelineKey};
use crate::shader::Program;
use crate::shadows::{CasterSources, FrameShadows, ShownMap, SourceList};
use crate::targets::TargetKey;
use crate::timing::{Stamps, Timing};
use crate::{Alpha, FrameStats, RenderError, RenderOptions, Renderer, Target};

/// Everything that a frame draws, on the GPU already.
#[derive(Debug)]
pub(crate) struct Frame {
    pub list: DrawList,
    pub overlays: Vec<OverlayDraw>,
    pub sources: SourceList,
    pub shadows: FrameShadows,
    /// A shadow map that is shown instead of the scene.
    pub map: Option<ShownMap>,
    pub backdrop: Backdrop,
    pub format: PassFormat,
    pub constants: Constants,
    /// Bind group 3 of surfaces that an environment lights.
    pub environment: Option<wgpu::BindGroup>,
    /// Drawn into the target itself.
    pub direct: bool,
    /// Drawn in linear light.
    pub linear: bool,
}

/// What the picture's pass draws to.
struct Attachments<'a> {
    color: &'a wgpu::TextureView,
    resolved: Option<&'a wgpu::TextureView>,
    depth: Option<&'a wgpu::TextureView>,
}

impl Renderer {
    /// The uniform buffers never change their size, so one bind group does.
    pub(crate) fn make_frame_group(&mut self) {
        if let (None, Some(frame), Some(lights)) =
            (&self.frame_group, self.frame_uniform.get(), self.light_uniform.get())
        {
            self.frame_group = Some(self.gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("frame"),
                layout: self.pipelines.frame_layout(),
                entries: &[bind(0, frame.as_entire_binding()), bind(1, lights.as_entire_binding())],
            }));
        }
    }

    /// Builds the pipelines that are not there yet.
    pub(crate) fn build_pipelines(&mut self, frame: &Frame) -> Result<(), RenderError> {
        let shadows = &frame.sources.set;
        let receiving = (!shadows.is_empty()).then(|| self.shadows.pipelines.receiver_layout(&self.gpu, shadows));
        for batch in frame.list.opaque.iter().chain(&frame.list.blended) {
            self.pipelines.ensure(&self.gpu, batch.pipeline(frame.format, frame.constants), receiving)?;
        }
        frame.overlays.iter().try_for_each(|draw| self.pipelines.ensure(&self.gpu, draw.pipeline, None))
    }

    /// Records and submits the passes of a frame.
    pub(crate) fn record(
        &mut self,
        scene: &Scene,
        view: &View,
        options: &RenderOptions,
        target: &Target<'_>,
        frame: &Frame,
        stats: &mut FrameStats,
    ) -> Result<(), RenderError> {
        if options.gpu_timing && self.timing.is_none() {
            self.timing = Timing::new(&self.gpu);
        }
        let timed = options.gpu_timing && self.timing.as_ref().is_some_and(Timing::has_room);
        let mut stamps = timed.then(Stamps::default);

        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let (format, picture) = (frame.format, self.picture);
        let mut own = |format, samples, usage| {
            let key = TargetKey { width: view.width, height: view.height, format, samples, usage };
            self.targets.get(&self.gpu, key, picture).1
        };
        let intermediate = (!frame.direct).then(|| own(format.color, 1, usage | wgpu::TextureUsages::TEXTURE_BINDING));
        let multisampled = (format.samples > 1).then(|| own(format.color, format.samples, usage));
        let depth = format.depth.then(|| own(DEPTH_FORMAT, format.samples, usage));
        let finished = intermediate.as_ref().unwrap_or(target.view);
        let attachments = Attachments {
            color: multisampled.as_ref().unwrap_or(finished),
            resolved: multisampled.as_ref().map(|_| finished),
            depth: depth.as_ref(),
        };

        let mut encoder =
            self.gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("picture") });
        self.record_displacement(&mut encoder, stamps.as_mut());
        if !frame.shadows.is_empty() {
            let casters = CasterSources {
                gpu: &self.gpu,
                scene,
                list: &frame.list,
                meshes: &self.meshes,
                materials: &self.materials,
                instances: self.instances.get(),
                frame_group: self.frame_group.as_ref(),
                timing: self.timing.as_ref(),
                picture,
            };
            self.shadows.record(&frame.shadows, &casters, &mut self.targets, &mut encoder, stamps.as_mut(), stats);
        }
        self.record_picture(scene, frame, &attachments, &mut encoder, stamps.as_mut(), stats);
        if let Some(intermediate) = &intermediate {
            self.record_present(frame.linear, intermediate, target, &mut encoder, stamps.as_mut())?;
            stats.draws += 1;
            stats.triangles += 1;
        }
        let read_back =
            self.timing.as_mut().zip(stamps).and_then(|(timing, stamps)| timing.resolve(&mut encoder, stamps));
        self.gpu.queue().submit([encoder.finish()]);
        if let Some(timing) = &mut self.timing {
            if let Some(read_back) = read_back {
                timing.submitted(read_back);
            }
            // Takes in what has ended. It fails only if the device was lost, which is looked for anyway.
            let _ = self.gpu.device().poll(wgpu::PollType::Poll);
            stats.gpu = timing.collect().filter(|_| options.gpu_timing);
        }
        Ok(())
    }

    /// What changed of displaced surfaces.
    fn record_displacement(&self, encoder: &mut wgpu::CommandEncoder, stamps: Option<&mut Stamps>) {
        let DisplacementTable { jobs, pipelines, .. } = &self.displacements;
        if jobs.is_empty() {
            return;
        }
        let marks = stamps.map(|stamps| stamps.parts(&["displacement"]));
        let queries = self.timing.as_ref().map(Timing::queries);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("displacement"),
            timestamp_writes: queries.zip(marks.as_ref()).map(|(query_set, marks)| wgpu::ComputePassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: marks.first().copied(),
                end_of_pass_write_index: marks.last().copied(),
            }),
        });
        pipelines.record(&mut pass, jobs);
    }

    /// Background, opaque surfaces, transparent ones, overlays: one pass.
    fn record_picture(
        &self,
        scene: &Scene,
        frame: &Frame,
        attachments: &Attachments<'_>,
        encoder: &mut wgpu::CommandEncoder,
        stamps: Option<&mut Stamps>,
        stats: &mut FrameStats,
    ) {
        let has_parts = self.gpu.device().features().contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES);
        let mut parts = vec!["opaque"];
        parts.extend((!frame.list.blended.is_empty()).then_some("transparent"));
        parts.extend((!frame.overlays.is_empty()).then_some("overlays"));
        let marks = stamps.map(|stamps| stamps.parts(if has_parts { &parts } else { &["picture"] }));
        let queries = self.timing.as_ref().map(Timing::queries);
        let multisampled = attachments.resolved.is_some();
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: attachments.color,
                depth_slice: None,
                resolve_target: attachments.resolved,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(frame.backdrop.clear),
                    store: if multisampled { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store },
                },
            })],
            depth_stencil_attachment: attachments.depth.map(|view| wgpu::RenderPassDepthStencilAttachment {
                view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            timestamp_writes: queries.zip(marks.as_ref()).map(|(query_set, marks)| wgpu::RenderPassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: marks.first().copied(),
                end_of_pass_write_index: marks.last().copied(),
            }),
            occlusion_query_set: None,
            multiview_mask: None,
        });
        // The stamps between the first and the last.
        let mut between = marks.iter().flat_map(|marks| &marks[1..marks.len() - 1]).copied();
        let mut next_part = |pass: &mut wgpu::RenderPass<'_>| {
            if let (Some(queries), Some(mark)) = (queries, between.next()) {
                pass.write_timestamp(queries, mark);
            }
        };

        if let Some((group, key)) = &frame.backdrop.picture
            && let Some(pipeline) = self.pipelines.get(key)
        {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.draw(0..3, 0..1);
            stats.draws += 1;
            stats.triangles += 1;
            stats.pipeline_switches += 1;
        }
        if let Some(map) = &frame.map
            && let Some(pipeline) = self.pipelines.get(&map.pipeline)
        {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &map.group, &[]);
            pass.draw(0..3, 0..1);
            stats.draws += 1;
            stats.triangles += 1;
            stats.pipeline_switches += 1;
        }
        let Some(group) = self.frame_group.as_ref().filter(|_| frame.format.depth) else { return };
        pass.set_bind_group(0, group, &[]);
        if let Some(group) = self.shadows.group().filter(|_| !frame.sources.set.is_empty()) {
            pass.set_bind_group(2, group, &[]);
        }
        let sources = Sources {
            scene,
            list: &frame.list,
            meshes: &self.meshes,
            displacements: &self.displacements,
            materials: &self.materials,
            pipelines: &self.pipelines,
            instances: self.instances.get(),
            sorted: &self.sorted,
            sorted_indices: self.sorted_indices.get(),
            format: frame.format,
            constants: frame.constants,
            environment: frame.environment.as_ref(),
        };
        let mut recorder = Recorder::new(sources, stats);
        recorder.opaque(&mut pass);
        if !frame.list.blended.is_empty() {
            next_part(&mut pass);
            recorder.blended(&mut pass);
        }
        if !frame.overlays.is_empty() {
            next_part(&mut pass);
            recorder.overlays(&mut pass, &frame.overlays);
        }
    }

    /// Converts a finished picture to the target's values.
    fn record_present(
        &mut self,
        linear: bool,
        finished: &wgpu::TextureView,
        target: &Target<'_>,
        encoder: &mut wgpu::CommandEncoder,
        stamps: Option<&mut Stamps>,
    ) -> Result<(), RenderError> {
        let srgb = target.format.is_srgb();
        let program = Program::Present {
            encode: linear && !srgb,
            decode: !linear && srgb,
            premultiply: target.alpha == Alpha::Premultiplied,
        };
        let pass = PassFormat { color: target.format, samples: 1, depth: false };
        let key = PipelineKey::new(program, pass);
        self.pipelines.ensure(&self.gpu, key, None)?;
        let group = self.gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("present"),
            layout: self.pipelines.texel_layout(&self.gpu),
            entries: &[bind(0, wgpu::BindingResource::TextureView(finished))],
        });
        let marks = stamps.map(|stamps| stamps.parts(&["present"]));
        let queries = self.timing.as_ref().map(Timing::queries);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("present"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target.view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: None,
            timestamp_writes: queries.zip(marks.as_ref()).map(|(query_set, marks)| wgpu::RenderPassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: marks.first().copied(),
                end_of_pass_write_index: marks.last().copied(),
            }),
            occlusion_query_set: None,
            multiview_mask: None,
        });
        if let Some(pipeline) = self.pipelines.get(&key) {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.draw(0..3, 0..1);
        }
        Ok(())
    }
}
