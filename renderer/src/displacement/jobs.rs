//! Compute passes that fill the streams of a tessellated surface.

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};

use crate::materials::bind;
use crate::shader::{Program, source};
use crate::upload::Uploader;
use crate::{Gpu, RenderError};

/// Points a workgroup: `WORKGROUP` in `shaders/tessellation.wgsl`.
const WORKGROUP: u32 = 128;

/// Workgroups along the first dimension of a dispatch, at most.
const ROW: u32 = 1 << 15;

/// `Displacement` in `shaders/heights.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct DisplaceParameters {
    pub(super) row_u: [f32; 3],
    pub(super) bias: f32,
    pub(super) row_v: [f32; 3],
    pub(super) scale: f32,
    pub(super) texel: u32,
    pub(super) point_count: u32,
    pub(super) padding: [u32; 2],
}

/// `Interpolation` in `shaders/interpolate.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct InterpolateParameters {
    pub(super) point_count: u32,
    pub(super) components: u32,
    pub(super) padding: [u32; 2],
}

/// Work for the GPU before the picture is drawn.
#[derive(Debug)]
pub(crate) struct Job {
    program: Program,
    group: wgpu::BindGroup,
    point_count: u32,
}

impl Job {
    /// Points that it displaces.
    pub(super) fn displaced_points(&self) -> u64 {
        if matches!(self.program, Program::Displace { .. }) { self.point_count.into() } else { 0 }
    }
}

/// The compute pipelines built so far.
#[derive(Debug, Default)]
pub(crate) struct ComputePipelines(HashMap<Program, wgpu::ComputePipeline>);

impl ComputePipelines {
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    fn ensure(&mut self, gpu: &Gpu, program: Program) -> Result<&wgpu::ComputePipeline, RenderError> {
        if let std::collections::hash_map::Entry::Vacant(e) = self.0.entry(program) {
            let text = source(&program)?;
            let label = format!("{program:?}");
            let module = gpu.device().create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(&label),
                source: wgpu::ShaderSource::Wgsl(text.into()),
            });
            let pipeline = gpu.device().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(&label),
                layout: None,
                module: &module,
                entry_point: Some("compute"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
            e.insert(pipeline);
        }
        Ok(&self.0[&program])
    }

    /// A job with its parameters and what else it binds.
    pub(super) fn job(
        &mut self,
        uploader: &mut Uploader<'_>,
        program: Program,
        parameters: &[u8],
        resources: &[wgpu::BindingResource<'_>],
        point_count: u32,
    ) -> Result<Job, RenderError> {
        let parameters = uploader.buffer("displacement parameters", wgpu::BufferUsages::UNIFORM, parameters)?;
        let pipeline = self.ensure(uploader.gpu, program)?;
        let mut entries = vec![bind(0, parameters.as_entire_binding())];
        entries.extend((1..).zip(resources).map(|(binding, resource)| bind(binding, resource.clone())));
        let group = uploader.gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("displacement"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        Ok(Job { program, group, point_count })
    }

    /// Records jobs into a pass.
    pub(crate) fn record(&self, pass: &mut wgpu::ComputePass<'_>, jobs: &[Job]) {
        for job in jobs {
            let Some(pipeline) = self.0.get(&job.program) else { continue };
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &job.group, &[]);
            let groups = job.point_count.div_ceil(WORKGROUP);
            pass.dispatch_workgroups(groups.min(ROW), groups.div_ceil(ROW), 1);
        }
    }
}
