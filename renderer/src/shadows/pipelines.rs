//! Pipelines of the passes that draw and blur maps.

use std::collections::HashMap;

use aam_scene::{CasterFaces, ShadowFilter};

use super::set::ShadowSet;
use crate::draws::{Batch, Instance};
use crate::meshes::Stream;
use crate::pipelines::{MapSet, Pipelines, UNIFORM, layout, layout_entry, texture};
use crate::shader::{Program, source};
use crate::{Gpu, RenderError};

/// What decides about the shader of a caster.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Caster {
    /// The moments that are kept; `None` keeps depth alone.
    pub moments: Option<ShadowFilter>,
    /// Parts are cut out by alpha.
    pub cut: Option<Cut>,
}

/// How parts of a caster are cut out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Cut {
    /// Textures of the material's bind group.
    pub maps: MapSet,
    /// The first of them has the alpha.
    pub textured: bool,
    /// Vertex colours have alpha too.
    pub colors: bool,
    /// The surface blends.
    pub blend: bool,
}

impl Caster {
    pub(crate) fn of(batch: &Batch, filter: ShadowFilter) -> Self {
        let alpha = batch.variant.alpha;
        let cut = (alpha.test || alpha.blend).then(|| Cut {
            maps: MapSet {
                base: batch.variant.base_map(),
                second: batch.variant.second_map(),
                relief: batch.variant.relief,
            },
            textured: batch.variant.base_map(),
            colors: batch.variant.vertex_colors(),
            blend: alpha.blend,
        });
        Self { moments: filter.has_moments().then_some(filter), cut }
    }

    /// The value of every feature that the shader's files ask for.
    pub(crate) fn features(&self) -> Vec<(&'static str, bool)> {
        let keeps = |filter| self.moments == Some(filter);
        let cut = |asked: fn(Cut) -> bool| self.cut.is_some_and(asked);
        vec![
            ("NODE_NORMALS", false),
            ("RECEIVERS", false),
            ("MOMENTS", self.moments.is_some()),
            ("VSM", keeps(ShadowFilter::Vsm)),
            ("ESM", keeps(ShadowFilter::Esm)),
            ("EVSM2", keeps(ShadowFilter::Evsm2)),
            ("EVSM4", keeps(ShadowFilter::Evsm4)),
            ("MSM", keeps(ShadowFilter::Msm)),
            ("CUT", self.cut.is_some()),
            ("BASE_MAP", cut(|cut| cut.textured)),
            ("BASE_UV", cut(|cut| cut.textured)),
            ("SECOND_MAP", false),
            ("VERTEX_COLORS", cut(|cut| cut.colors)),
            ("BLEND", cut(|cut| cut.blend)),
        ]
    }

    /// Its vertex streams in the order of its buffers.
    pub(crate) fn streams(self, base_layer: u8) -> impl Iterator<Item = Stream> {
        let cut = self.cut;
        [
            Some(Stream::Position),
            cut.filter(|cut| cut.colors).map(|_| Stream::Color),
            cut.filter(|cut| cut.textured).map(|_| Stream::Uv(base_layer)),
        ]
        .into_iter()
        .flatten()
    }

    /// Every kind that there is, but for textures that the shader does not read.
    pub(crate) fn all() -> Vec<Self> {
        let moments = ShadowFilter::ALL.iter().copied().filter(|filter| filter.has_moments()).map(Some);
        let mut casters = Vec::new();
        for moments in moments.chain([None]) {
            casters.push(Self { moments, cut: None });
            for (textured, colors, blend) in [(true, false, false), (false, true, true), (true, true, true)] {
                let maps = MapSet { base: textured, second: colors, relief: false };
                casters.push(Self { moments, cut: Some(Cut { maps, textured, colors, blend }) });
            }
        }
        casters
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct CasterKey {
    pub caster: Caster,
    pub format: wgpu::TextureFormat,
    pub faces: CasterFaces,
    pub mirrored: bool,
    /// Drawn for the camera, whose depth is reversed.
    pub seen: bool,
}

/// A pass of the running blur.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct RunningKey {
    pub format: wgpu::TextureFormat,
    /// The second of two means, which turns rows into columns.
    pub second: bool,
}

impl RunningKey {
    /// Both means.
    pub(crate) fn means(format: wgpu::TextureFormat) -> [Self; 2] {
        [false, true].map(|second| Self { format, second })
    }
}

/// Pipelines and layouts of shadow maps built so far.
#[derive(Debug, Default)]
pub(crate) struct ShadowPipelines {
    casters: HashMap<CasterKey, wgpu::RenderPipeline>,
    blurs: HashMap<(wgpu::TextureFormat, bool), wgpu::RenderPipeline>,
    running: HashMap<RunningKey, wgpu::ComputePipeline>,
    running_layouts: HashMap<wgpu::TextureFormat, wgpu::BindGroupLayout>,
    volumes: HashMap<bool, wgpu::RenderPipeline>,
    mask: Option<wgpu::RenderPipeline>,
    modules: HashMap<Program, wgpu::ShaderModule>,
    caster_layout: Option<wgpu::BindGroupLayout>,
    blur_layout: Option<wgpu::BindGroupLayout>,
    receiver_layouts: HashMap<ShadowSet, wgpu::BindGroupLayout>,
}

/// Whether f32 textures can be sampled with a linear filter.
pub(crate) fn is_filterable(gpu: &Gpu) -> bool {
    gpu.device().features().contains(wgpu::Features::FLOAT32_FILTERABLE)
}

/// Depth with eight bits to count in.
pub(crate) fn counting_format(gpu: &Gpu) -> wgpu::TextureFormat {
    if gpu.device().features().contains(wgpu::Features::DEPTH32FLOAT_STENCIL8) {
        wgpu::TextureFormat::Depth32FloatStencil8
    } else {
        wgpu::TextureFormat::Depth24PlusStencil8
    }
}

const DYNAMIC_UNIFORM: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Uniform,
    has_dynamic_offset: true,
    min_binding_size: None,
};

const fn array_texture(sample_type: wgpu::TextureSampleType) -> wgpu::BindingType {
    wgpu::BindingType::Texture { sample_type, view_dimension: wgpu::TextureViewDimension::D2Array, multisampled: false }
}

impl ShadowPipelines {
    pub(crate) fn len(&self) -> usize {
        self.casters.len()
            + self.blurs.len()
            + self.running.len()
            + self.volumes.len()
            + usize::from(self.mask.is_some())
    }

    pub(crate) fn module_count(&self) -> usize {
        self.modules.len()
    }

    /// Layout of the bind group of a map's view.
    pub(crate) fn caster_layout(&mut self, gpu: &Gpu) -> &wgpu::BindGroupLayout {
        self.caster_layout.get_or_insert_with(|| {
            layout(gpu, "caster", &[layout_entry(0, wgpu::ShaderStages::VERTEX_FRAGMENT, DYNAMIC_UNIFORM)])
        })
    }

    /// Layout of the bind group of a blur pass.
    pub(crate) fn blur_layout(&mut self, gpu: &Gpu) -> &wgpu::BindGroupLayout {
        self.blur_layout.get_or_insert_with(|| {
            let moments = array_texture(wgpu::TextureSampleType::Float { filterable: false });
            layout(
                gpu,
                "blur",
                &[
                    layout_entry(0, wgpu::ShaderStages::FRAGMENT, moments),
                    layout_entry(1, wgpu::ShaderStages::FRAGMENT, DYNAMIC_UNIFORM),
                ],
            )
        })
    }

    /// The same, once it was asked for.
    pub(crate) fn built_blur_layout(&self) -> Option<&wgpu::BindGroupLayout> {
        self.blur_layout.as_ref()
    }

    /// Layout of bind group 2 of surfaces that receive shadows.
    pub(crate) fn receiver_layout(&mut self, gpu: &Gpu, set: &ShadowSet) -> &wgpu::BindGroupLayout {
        self.receiver_layouts.entry(*set).or_insert_with(|| {
            let filterable = is_filterable(gpu);
            let filtering =
                if filterable { wgpu::SamplerBindingType::Filtering } else { wgpu::SamplerBindingType::NonFiltering };
            let mut entries = vec![
                layout_entry(0, wgpu::ShaderStages::FRAGMENT, UNIFORM),
                layout_entry(1, wgpu::ShaderStages::FRAGMENT, wgpu::BindingType::Sampler(filtering)),
            ];
            for (index, kind) in set.iter().enumerate() {
                let kind = match kind.filter {
                    ShadowFilter::Volume => texture(false),
                    filter if filter.has_moments() => array_texture(wgpu::TextureSampleType::Float { filterable }),
                    _ => array_texture(wgpu::TextureSampleType::Depth),
                };
                entries.push(layout_entry(super::glue::map_binding(index), wgpu::ShaderStages::FRAGMENT, kind));
            }
            layout(gpu, "shadows", &entries)
        })
    }

    pub(crate) fn caster(&self, key: &CasterKey) -> Option<&wgpu::RenderPipeline> {
        self.casters.get(key)
    }

    pub(crate) fn blur(&self, format: wgpu::TextureFormat, vertical: bool) -> Option<&wgpu::RenderPipeline> {
        self.blurs.get(&(format, vertical))
    }

    fn module(&mut self, gpu: &Gpu, program: Program) -> Result<wgpu::ShaderModule, RenderError> {
        if let Some(module) = self.modules.get(&program) {
            return Ok(module.clone());
        }
        let module = gpu.device().create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(&format!("{program:?}")),
            source: wgpu::ShaderSource::Wgsl(source(&program)?.into()),
        });
        self.modules.insert(program, module.clone());
        Ok(module)
    }

    /// Makes sure that a caster's pipeline is built.
    pub(crate) fn ensure_caster(
        &mut self,
        gpu: &Gpu,
        shared: &mut Pipelines,
        key: CasterKey,
    ) -> Result<(), RenderError> {
        if self.casters.contains_key(&key) {
            return Ok(());
        }
        let module = self.module(gpu, Program::Caster(key.caster))?;
        let material = key.caster.cut.map(|cut| shared.material_layout(gpu, cut.maps).clone());
        let view = self.caster_layout(gpu).clone();
        let pipeline_layout = gpu.device().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("caster"),
            bind_group_layouts: &[Some(shared.frame_layout()), material.as_ref(), Some(&view)],
            immediate_size: 0,
        });
        use wgpu::VertexFormat::{Float32x2, Float32x3, Float32x4};
        let attribute = |format, offset, shader_location| wgpu::VertexAttribute { format, offset, shader_location };
        let mut buffers: Vec<(u64, wgpu::VertexStepMode, Vec<wgpu::VertexAttribute>)> = key
            .caster
            .streams(0)
            .map(|stream| {
                let (format, location) = match stream {
                    Stream::Color => (Float32x4, 3),
                    Stream::Uv(_) => (Float32x2, 4),
                    _ => (Float32x3, 0),
                };
                (format.size(), wgpu::VertexStepMode::Vertex, vec![attribute(format, 0, location)])
            })
            .collect();
        let rows = (0..3).map(|row| attribute(Float32x4, 16 * u64::from(row), 8 + row)).collect();
        buffers.push((size_of::<Instance>() as u64, wgpu::VertexStepMode::Instance, rows));
        let layouts: Vec<_> = buffers
            .iter()
            .map(|(array_stride, step_mode, attributes)| {
                Some(wgpu::VertexBufferLayout { array_stride: *array_stride, step_mode: *step_mode, attributes })
            })
            .collect();
        let is_depth = key.caster.moments.is_none();
        let targets = [(!is_depth).then_some(wgpu::ColorTargetState {
            format: key.format,
            blend: None,
            write_mask: wgpu::ColorWrites::ALL,
        })];
        let has_fragments = !is_depth || key.caster.cut.is_some();
        let pipeline = gpu.device().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("caster"),
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &layouts,
            },
            primitive: wgpu::PrimitiveState {
                front_face: if key.mirrored { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
                cull_mode: match key.faces {
                    CasterFaces::Both => None,
                    CasterFaces::Front => Some(wgpu::Face::Back),
                    CasterFaces::Back => Some(wgpu::Face::Front),
                },
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: if is_depth { key.format } else { crate::pipelines::DEPTH_FORMAT },
                depth_write_enabled: Some(true),
                depth_compare: Some(if key.seen {
                    wgpu::CompareFunction::Greater
                } else {
                    wgpu::CompareFunction::Less
                }),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: has_fragments.then(|| wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: if is_depth { &[] } else { &targets },
            }),
            multiview_mask: None,
            cache: None,
        });
        self.casters.insert(key, pipeline);
        Ok(())
    }

    pub(crate) fn volume(&self, mirrored: bool) -> Option<&wgpu::RenderPipeline> {
        self.volumes.get(&mirrored)
    }

    pub(crate) fn mask(&self) -> Option<&wgpu::RenderPipeline> {
        self.mask.as_ref()
    }

    pub(crate) fn running(&self, key: &RunningKey) -> Option<&wgpu::ComputePipeline> {
        self.running.get(key)
    }

    /// Layout of the bind group of a running blur's pass, once it was asked for.
    pub(crate) fn built_running_layout(&self, format: wgpu::TextureFormat) -> Option<&wgpu::BindGroupLayout> {
        self.running_layouts.get(&format)
    }

    /// Makes sure that the pipelines of a running blur are built.
    pub(crate) fn ensure_running(
        &mut self,
        gpu: &Gpu,
        filter: ShadowFilter,
        format: wgpu::TextureFormat,
    ) -> Result<(), RenderError> {
        for key in RunningKey::means(format) {
            if self.running.contains_key(&key) {
                continue;
            }
            let module = self.module(gpu, Program::RunningBlur(filter))?;
            let group = self.running_layouts.entry(format).or_insert_with(|| {
                let compute = wgpu::ShaderStages::COMPUTE;
                let target = wgpu::BindingType::StorageTexture {
                    access: wgpu::StorageTextureAccess::WriteOnly,
                    format,
                    view_dimension: wgpu::TextureViewDimension::D2,
                };
                let moments = array_texture(wgpu::TextureSampleType::Float { filterable: false });
                layout(
                    gpu,
                    "running blur",
                    &[
                        layout_entry(0, compute, moments),
                        layout_entry(1, compute, DYNAMIC_UNIFORM),
                        layout_entry(2, compute, target),
                    ],
                )
            });
            let pipeline_layout = gpu.device().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("running blur"),
                bind_group_layouts: &[Some(group)],
                immediate_size: 0,
            });
            let constants = [("SECOND", f64::from(u8::from(key.second)))];
            let pipeline = gpu.device().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("running blur"),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some("blur"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &constants,
                    ..wgpu::PipelineCompilationOptions::default()
                },
                cache: None,
            });
            self.running.insert(key, pipeline);
        }
        Ok(())
    }

    /// Makes sure that the pipelines of shadow volumes are built.
    pub(crate) fn ensure_volume(
        &mut self,
        gpu: &Gpu,
        frame_layout: &wgpu::BindGroupLayout,
        mirrored: bool,
    ) -> Result<(), RenderError> {
        let format = counting_format(gpu);
        let mask_target = [Some(wgpu::ColorTargetState {
            format: wgpu::TextureFormat::R8Unorm,
            blend: None,
            write_mask: wgpu::ColorWrites::ALL,
        })];
        if !self.volumes.contains_key(&mirrored) {
            let module = self.module(gpu, Program::Extrude)?;
            let view = self.caster_layout(gpu).clone();
            let pipeline_layout = gpu.device().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("shadow volume"),
                bind_group_layouts: &[Some(frame_layout), None, Some(&view)],
                immediate_size: 0,
            });
            let count = |depth_fail_op| wgpu::StencilFaceState {
                compare: wgpu::CompareFunction::Always,
                fail_op: wgpu::StencilOperation::Keep,
                depth_fail_op,
                pass_op: wgpu::StencilOperation::Keep,
            };
            let attribute = |format, offset, shader_location| wgpu::VertexAttribute { format, offset, shader_location };
            let corner = [attribute(wgpu::VertexFormat::Float32x4, 0, 0)];
            let rows: Vec<_> =
                (0..3).map(|row| attribute(wgpu::VertexFormat::Float32x4, 16 * u64::from(row), 8 + row)).collect();
            let buffer = |array_stride, step_mode, attributes| {
                Some(wgpu::VertexBufferLayout { array_stride, step_mode, attributes })
            };
            let pipeline = gpu.device().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("shadow volume"),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("vertex"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[
                        buffer(16, wgpu::VertexStepMode::Vertex, &corner),
                        buffer(size_of::<Instance>() as u64, wgpu::VertexStepMode::Instance, &rows),
                    ],
                },
                primitive: wgpu::PrimitiveState {
                    front_face: if mirrored { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
                    ..wgpu::PrimitiveState::default()
                },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format,
                    depth_write_enabled: Some(false),
                    depth_compare: Some(wgpu::CompareFunction::Greater),
                    stencil: wgpu::StencilState {
                        front: count(wgpu::StencilOperation::DecrementWrap),
                        back: count(wgpu::StencilOperation::IncrementWrap),
                        read_mask: 0xff,
                        write_mask: 0xff,
                    },
                    // A few roundings behind the surface that they start from. By slope it would move the shadow's edge.
                    bias: wgpu::DepthBiasState { constant: -16, slope_scale: 0.0, clamp: 0.0 },
                }),
                multisample: wgpu::MultisampleState::default(),
                fragment: None,
                multiview_mask: None,
                cache: None,
            });
            self.volumes.insert(mirrored, pipeline);
        }
        if self.mask.is_none() {
            let module = self.module(gpu, Program::Mask)?;
            let pipeline_layout = gpu.device().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("shadow mask"),
                bind_group_layouts: &[],
                immediate_size: 0,
            });
            let uncounted =
                wgpu::StencilFaceState { compare: wgpu::CompareFunction::Equal, ..wgpu::StencilFaceState::IGNORE };
            self.mask = Some(gpu.device().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("shadow mask"),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("vertex"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: Some(wgpu::DepthStencilState {
                    format,
                    depth_write_enabled: Some(false),
                    depth_compare: Some(wgpu::CompareFunction::Always),
                    stencil: wgpu::StencilState { front: uncounted, back: uncounted, read_mask: 0xff, write_mask: 0 },
                    bias: wgpu::DepthBiasState::default(),
                }),
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("fragment"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &mask_target,
                }),
                multiview_mask: None,
                cache: None,
            }));
        }
        Ok(())
    }

    /// Makes sure that both pipelines of a blur are built.
    pub(crate) fn ensure_blur(&mut self, gpu: &Gpu, format: wgpu::TextureFormat) -> Result<(), RenderError> {
        for vertical in [false, true] {
            if self.blurs.contains_key(&(format, vertical)) {
                continue;
            }
            let module = self.module(gpu, Program::Blur)?;
            let group = self.blur_layout(gpu).clone();
            let pipeline_layout = gpu.device().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("blur"),
                bind_group_layouts: &[Some(&group)],
                immediate_size: 0,
            });
            let constants = [("VERTICAL", f64::from(u8::from(vertical)))];
            let pipeline = gpu.device().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("blur"),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("vertex"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("fragment"),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &constants,
                        ..wgpu::PipelineCompilationOptions::default()
                    },
                    targets: &[Some(wgpu::ColorTargetState {
                        format,
                        blend: None,
                        write_mask: wgpu::ColorWrites::ALL,
                    })],
                }),
                multiview_mask: None,
                cache: None,
            });
            self.blurs.insert((format, vertical), pipeline);
        }
        Ok(())
    }
}
