//! Pipelines of the passes that draw and blur maps.

use std::collections::HashMap;

use aam_scene::{CasterFaces, ShadowFilter};

use super::set::ShadowSet;
use crate::draws::{Batch, Instance};
use crate::meshes::Stream;
use crate::pipelines::{MapSet, Pipelines, UNIFORM, layout, layout_entry};
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
            maps: MapSet { base: batch.variant.base_map(), second: batch.variant.second_map() },
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
                let maps = MapSet { base: textured, second: colors };
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
}

/// Pipelines and layouts of shadow maps built so far.
#[derive(Debug, Default)]
pub(crate) struct ShadowPipelines {
    casters: HashMap<CasterKey, wgpu::RenderPipeline>,
    blurs: HashMap<(wgpu::TextureFormat, bool), wgpu::RenderPipeline>,
    modules: HashMap<Program, wgpu::ShaderModule>,
    caster_layout: Option<wgpu::BindGroupLayout>,
    blur_layout: Option<wgpu::BindGroupLayout>,
    receiver_layouts: HashMap<ShadowSet, wgpu::BindGroupLayout>,
}

/// Whether f32 textures can be sampled with a linear filter.
pub(crate) fn is_filterable(gpu: &Gpu) -> bool {
    gpu.device().features().contains(wgpu::Features::FLOAT32_FILTERABLE)
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
        self.casters.len() + self.blurs.len()
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
                let sample_type = if kind.filter.has_moments() {
                    wgpu::TextureSampleType::Float { filterable }
                } else {
                    wgpu::TextureSampleType::Depth
                };
                let binding = super::glue::map_binding(index);
                entries.push(layout_entry(binding, wgpu::ShaderStages::FRAGMENT, array_texture(sample_type)));
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
                depth_compare: Some(wgpu::CompareFunction::Less),
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
