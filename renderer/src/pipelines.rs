//! Pipelines: each is built when something first needs it, and kept.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use aam_scene::ToneMap;

use crate::draws::Instance;
use crate::environment::EnvironmentTerms;
use crate::lights::LightEnds;
use crate::shader::{Program, Surface, Variant, source};
use crate::shadows::MapKind;
use crate::{Gpu, RenderError};

/// Format of depth buffers.
pub(crate) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// What a pass draws to: pipelines must match it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct PassFormat {
    pub color: wgpu::TextureFormat,
    pub samples: u32,
    pub depth: bool,
}

/// Identifies a pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct PipelineKey {
    pub program: Program,
    pub pass: PassFormat,
    /// For nodes that mirror: their triangles turn the other way.
    pub mirrored: bool,
    /// Pairs of vertices are lines.
    pub lines: bool,
    pub constants: Constants,
}

impl PipelineKey {
    /// For triangles that do not turn the other way, of a program without constants.
    pub(crate) fn new(program: Program, pass: PassFormat) -> Self {
        Self { program, pass, mirrored: false, lines: false, constants: Constants::default() }
    }
}

/// Values that the shader of a shaded surface treats as constants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Constants {
    pub lights: LightEnds,
    /// The camera is orthographic.
    pub parallel: bool,
    pub environment: EnvironmentTerms,
    pub tone_map: ToneMap,
    /// The shadow source that is shown, by its position in the shader's list.
    pub shown_source: u32,
}

impl Constants {
    /// Those that a variant reads; the others make no further pipelines.
    pub(crate) fn read_by(self, variant: &Variant) -> Self {
        let Self { lights, parallel, shown_source, environment, tone_map } = self;
        match variant.surface {
            Surface::Lit { specular, .. } => {
                Self { lights, parallel: parallel && (specular || variant.relief), tone_map, ..Self::default() }
            }
            Surface::ShowShadow => Self { shown_source, ..Self::default() },
            Surface::Environment { specular, .. } => {
                let environment =
                    EnvironmentTerms { specular: if specular { environment.specular } else { 0 }, ..environment };
                Self { parallel: parallel && (specular || variant.relief), environment, tone_map, ..Self::default() }
            }
            _ if variant.is_shaded() => Self { parallel: parallel && variant.relief, tone_map, ..Self::default() },
            _ => Self { parallel: parallel && variant.relief, ..Self::default() },
        }
    }

    /// Their names and values in WGSL.
    fn values(self, program: &Program) -> Vec<(&'static str, f64)> {
        let tone_map = ("TONE_MAP", f64::from(self.tone_map as u8));
        let parallel = ("PARALLEL", f64::from(u8::from(self.parallel)));
        match program {
            Program::Sky => vec![tone_map],
            Program::Surface(variant) => match variant.surface {
                Surface::Lit { .. } => vec![
                    tone_map,
                    parallel,
                    ("POINT_END", f64::from(self.lights.point)),
                    ("DIRECTIONAL_END", f64::from(self.lights.directional)),
                    ("SPOT_END", f64::from(self.lights.spot)),
                ],
                Surface::Environment { specular, .. } => {
                    let mut values =
                        vec![tone_map, parallel, ("ENVIRONMENT_DIFFUSE", f64::from(self.environment.diffuse))];
                    if specular {
                        values.push(("ENVIRONMENT_SPECULAR", f64::from(self.environment.specular)));
                    }
                    values
                }
                Surface::ShowShadow => vec![("SHOWN_SOURCE", f64::from(self.shown_source))],
                _ => {
                    let shaded = variant.is_shaded().then_some(tone_map);
                    shaded.into_iter().chain(variant.relief.then_some(parallel)).collect()
                }
            },
            _ => Vec::new(),
        }
    }
}

/// Which textures a material's bind group has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct MapSet {
    pub base: bool,
    pub second: bool,
    pub relief: bool,
}

impl MapSet {
    fn index(self) -> usize {
        usize::from(self.base) + 2 * usize::from(self.second) + 4 * usize::from(self.relief)
    }
}

/// Pipelines, shader modules and layouts built so far.
#[derive(Debug)]
pub(crate) struct Pipelines {
    pipelines: HashMap<PipelineKey, wgpu::RenderPipeline>,
    modules: HashMap<Program, wgpu::ShaderModule>,
    frame_layout: wgpu::BindGroupLayout,
    material_layouts: [Option<wgpu::BindGroupLayout>; 8],
    picture_layout: Option<wgpu::BindGroupLayout>,
    texel_layout: Option<wgpu::BindGroupLayout>,
    environment_layout: Option<wgpu::BindGroupLayout>,
    sky_layout: Option<wgpu::BindGroupLayout>,
    /// Of depth, of moments.
    map_layouts: [Option<wgpu::BindGroupLayout>; 2],
}

impl Pipelines {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let uniform = |binding, visibility| layout_entry(binding, visibility, UNIFORM);
        let frame_layout = layout(
            gpu,
            "frame",
            &[uniform(0, wgpu::ShaderStages::VERTEX_FRAGMENT), uniform(1, wgpu::ShaderStages::FRAGMENT)],
        );
        Self {
            pipelines: HashMap::new(),
            modules: HashMap::new(),
            frame_layout,
            material_layouts: Default::default(),
            picture_layout: None,
            texel_layout: None,
            environment_layout: None,
            sky_layout: None,
            map_layouts: Default::default(),
        }
    }

    /// Layout of bind group 0 of everything that is placed in the world.
    pub(crate) fn frame_layout(&self) -> &wgpu::BindGroupLayout {
        &self.frame_layout
    }

    /// Layout of bind group 1 of surfaces.
    pub(crate) fn material_layout(&mut self, gpu: &Gpu, maps: MapSet) -> &wgpu::BindGroupLayout {
        self.material_layouts[maps.index()].get_or_insert_with(|| {
            let mut entries = vec![layout_entry(0, wgpu::ShaderStages::VERTEX_FRAGMENT, UNIFORM)];
            if maps.base || maps.second {
                entries.push(layout_entry(1, wgpu::ShaderStages::FRAGMENT, SAMPLER));
            }
            if maps.base {
                entries.push(layout_entry(2, wgpu::ShaderStages::FRAGMENT, texture(true)));
            }
            if maps.second {
                entries.push(layout_entry(3, wgpu::ShaderStages::FRAGMENT, texture(true)));
            }
            if maps.relief {
                entries.push(layout_entry(4, wgpu::ShaderStages::VERTEX_FRAGMENT, UNIFORM));
                entries.push(layout_entry(5, wgpu::ShaderStages::FRAGMENT, HEIGHTS));
            }
            layout(gpu, "material", &entries)
        })
    }

    /// Layout of a sampled picture.
    pub(crate) fn picture_layout(&mut self, gpu: &Gpu) -> &wgpu::BindGroupLayout {
        self.picture_layout.get_or_insert_with(|| {
            layout(
                gpu,
                "picture",
                &[
                    layout_entry(0, wgpu::ShaderStages::FRAGMENT, SAMPLER),
                    layout_entry(1, wgpu::ShaderStages::FRAGMENT, texture(true)),
                ],
            )
        })
    }

    /// Layout of a picture that is read texel by texel.
    pub(crate) fn texel_layout(&mut self, gpu: &Gpu) -> &wgpu::BindGroupLayout {
        self.texel_layout.get_or_insert_with(|| {
            layout(gpu, "texels", &[layout_entry(0, wgpu::ShaderStages::FRAGMENT, texture(false))])
        })
    }

    /// Layout of bind group 3 of surfaces that an environment lights.
    pub(crate) fn environment_layout(&mut self, gpu: &Gpu) -> &wgpu::BindGroupLayout {
        self.environment_layout.get_or_insert_with(|| {
            let entry = |binding, ty| layout_entry(binding, wgpu::ShaderStages::FRAGMENT, ty);
            layout(gpu, "environment", &[entry(0, UNIFORM), entry(1, SAMPLER), entry(2, CUBE), entry(3, CUBE)])
        })
    }

    /// Layout of the sky box.
    pub(crate) fn sky_layout(&mut self, gpu: &Gpu) -> &wgpu::BindGroupLayout {
        self.sky_layout.get_or_insert_with(|| {
            let entry = |binding, ty| layout_entry(binding, wgpu::ShaderStages::FRAGMENT, ty);
            layout(gpu, "sky", &[entry(0, UNIFORM), entry(1, SAMPLER), entry(2, CUBE)])
        })
    }

    /// Layout of a shadow map that is shown.
    pub(crate) fn map_layout(&mut self, gpu: &Gpu, kind: MapKind) -> &wgpu::BindGroupLayout {
        self.map_layouts[usize::from(!kind.is_depth())].get_or_insert_with(|| {
            let sample_type = if kind.is_depth() {
                wgpu::TextureSampleType::Depth
            } else {
                wgpu::TextureSampleType::Float { filterable: false }
            };
            let map = wgpu::BindingType::Texture {
                sample_type,
                view_dimension: wgpu::TextureViewDimension::D2Array,
                multisampled: false,
            };
            let entry = |binding, ty| layout_entry(binding, wgpu::ShaderStages::FRAGMENT, ty);
            layout(gpu, "shown shadow map", &[entry(0, UNIFORM), entry(1, map)])
        })
    }

    /// Makes sure that a pipeline is built.
    pub(crate) fn ensure(
        &mut self,
        gpu: &Gpu,
        key: PipelineKey,
        shadows: Option<&wgpu::BindGroupLayout>,
    ) -> Result<(), RenderError> {
        if self.pipelines.contains_key(&key) {
            return Ok(());
        }
        if let Entry::Vacant(place) = self.modules.entry(key.program) {
            let text = source(&key.program)?;
            place.insert(gpu.device().create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(&format!("{:?}", key.program)),
                source: wgpu::ShaderSource::Wgsl(text.into()),
            }));
        }
        let pipeline = self.build(gpu, key, shadows);
        self.pipelines.insert(key, pipeline);
        Ok(())
    }

    /// A pipeline that was made sure of.
    pub(crate) fn get(&self, key: &PipelineKey) -> Option<&wgpu::RenderPipeline> {
        self.pipelines.get(key)
    }

    pub(crate) fn len(&self) -> usize {
        self.pipelines.len()
    }

    pub(crate) fn module_count(&self) -> usize {
        self.modules.len()
    }

    fn build(&mut self, gpu: &Gpu, key: PipelineKey, shadows: Option<&wgpu::BindGroupLayout>) -> wgpu::RenderPipeline {
        let material_maps = match key.program {
            Program::Surface(variant) => {
                Some(MapSet { base: variant.base_map(), second: variant.second_map(), relief: variant.relief })
            }
            _ => None,
        };
        let environment = matches!(key.program, Program::Surface(Variant { surface: Surface::Environment { .. }, .. }));
        let groups: Vec<Option<wgpu::BindGroupLayout>> = match key.program {
            Program::Background { .. } => vec![Some(self.picture_layout(gpu).clone())],
            Program::Sky => vec![Some(self.sky_layout(gpu).clone())],
            Program::Present { .. } => vec![Some(self.texel_layout(gpu).clone())],
            Program::ShadowMap(kind) => vec![Some(self.map_layout(gpu, kind).clone())],
            _ => {
                let material = material_maps.map(|maps| Some(self.material_layout(gpu, maps).clone()));
                let shadows =
                    shadows.filter(|_| matches!(key.program, Program::Surface(variant) if !variant.shadows.is_empty()));
                let shadows = shadows.map(|layout| Some(layout.clone()));
                let environment = environment.then(|| [None, Some(self.environment_layout(gpu).clone())]);
                let rest = material.into_iter().chain(shadows).chain(environment.into_iter().flatten());
                [Some(self.frame_layout.clone())].into_iter().chain(rest).collect()
            }
        };
        let groups: Vec<Option<&wgpu::BindGroupLayout>> = groups.iter().map(Option::as_ref).collect();
        let label = format!("{:?}", key.program);
        let layout = gpu.device().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(&label),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let attributes = VertexBuffers::of(&key);
        let blends = match key.program {
            Program::Surface(variant) => variant.alpha.blend,
            Program::Edges { .. } | Program::Normals { .. } | Program::Shape { .. } => true,
            _ => false,
        };
        let module = &self.modules[&key.program];
        let constants = key.constants.values(&key.program);
        let compilation_options =
            wgpu::PipelineCompilationOptions { constants: &constants, ..wgpu::PipelineCompilationOptions::default() };
        gpu.device().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(&label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("vertex"),
                compilation_options: compilation_options.clone(),
                buffers: &attributes.layouts(),
            },
            primitive: wgpu::PrimitiveState {
                topology: if key.lines {
                    wgpu::PrimitiveTopology::LineList
                } else {
                    wgpu::PrimitiveTopology::TriangleList
                },
                front_face: if key.mirrored { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
                cull_mode: None,
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: key.pass.depth.then(|| depth_state(&key.program)),
            multisample: wgpu::MultisampleState { count: key.pass.samples, ..wgpu::MultisampleState::default() },
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some("fragment"),
                compilation_options,
                targets: &[Some(wgpu::ColorTargetState {
                    format: key.pass.color,
                    blend: blends.then_some(BLEND),
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// Straight colours over a premultiplied picture: `C·α + dst·(1 − α)`, alpha `α + dst·(1 − α)`.
const BLEND: wgpu::BlendState = wgpu::BlendState {
    color: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::SrcAlpha,
        dst_factor: wgpu::BlendFactor::OneMinusSrcAlpha,
        operation: wgpu::BlendOperation::Add,
    },
    alpha: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::OneMinusSrcAlpha,
        operation: wgpu::BlendOperation::Add,
    },
};

/// Depth is reversed: the greater is nearer.
fn depth_state(program: &Program) -> wgpu::DepthStencilState {
    use wgpu::CompareFunction::{Always, Greater, GreaterEqual};
    let (write, compare) = match program {
        Program::Surface(variant) if variant.alpha.blend => (false, GreaterEqual),
        Program::Surface(_) => (true, Greater),
        Program::Shape { nudge: true, .. } | Program::Edges { .. } | Program::Normals { .. } => (false, GreaterEqual),
        _ => (false, Always),
    };
    wgpu::DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

pub(crate) const UNIFORM: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Uniform,
    has_dynamic_offset: false,
    min_binding_size: None,
};

const SAMPLER: wgpu::BindingType = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);

pub(crate) const fn texture(filterable: bool) -> wgpu::BindingType {
    wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    }
}

/// Displacement maps.
const HEIGHTS: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Uint,
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};

const CUBE: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: true },
    view_dimension: wgpu::TextureViewDimension::Cube,
    multisampled: false,
};

pub(crate) const fn layout_entry(
    binding: u32,
    visibility: wgpu::ShaderStages,
    ty: wgpu::BindingType,
) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
}

pub(crate) fn layout(gpu: &Gpu, label: &str, entries: &[wgpu::BindGroupLayoutEntry]) -> wgpu::BindGroupLayout {
    gpu.device().create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
}

/// A vertex buffer of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slot {
    Position,
    Normal,
    Tangent,
    Color,
    BaseUv,
    SecondUv,
    ReliefUv,
}

/// The vertex buffers of a surface variant in their order; the instances follow.
pub(crate) fn surface_slots(variant: &Variant) -> impl Iterator<Item = Slot> + use<> {
    [
        (true, Slot::Position),
        (variant.vertex_normals(), Slot::Normal),
        (variant.tangents(), Slot::Tangent),
        (variant.vertex_colors(), Slot::Color),
        (variant.base_uv(), Slot::BaseUv),
        (variant.second_map(), Slot::SecondUv),
        (variant.relief, Slot::ReliefUv),
    ]
    .into_iter()
    .filter_map(|(used, slot)| used.then_some(slot))
}

/// Vertex buffer layouts, held so that they can be borrowed.
struct VertexBuffers(Vec<(u64, wgpu::VertexStepMode, Vec<wgpu::VertexAttribute>)>);

impl VertexBuffers {
    fn of(key: &PipelineKey) -> Self {
        use wgpu::VertexFormat::{Float32x2, Float32x3, Float32x4};
        use wgpu::VertexStepMode::{Instance as PerInstance, Vertex};
        let attribute = |format, offset, shader_location| wgpu::VertexAttribute { format, offset, shader_location };
        let single =
            |format: wgpu::VertexFormat, location| (format.size(), Vertex, vec![attribute(format, 0, location)]);
        let instances = |normals: bool, receivers: bool| {
            let mut attributes: Vec<_> = (0..3).map(|row| attribute(Float32x4, 16 * row, 8 + row as u32)).collect();
            if normals {
                attributes.extend((0..3).map(|column| attribute(Float32x3, 48 + 12 * column, 11 + column as u32)));
            }
            if receivers {
                attributes.push(attribute(wgpu::VertexFormat::Float32, 84, 14));
            }
            (size_of::<Instance>() as u64, PerInstance, attributes)
        };
        Self(match key.program {
            Program::Surface(variant) => surface_slots(&variant)
                .map(|slot| match slot {
                    Slot::Position => single(Float32x3, 0),
                    Slot::Normal => single(Float32x3, 1),
                    Slot::Tangent => single(Float32x4, 2),
                    Slot::Color => single(Float32x4, 3),
                    Slot::BaseUv => single(Float32x2, 4),
                    Slot::SecondUv => single(Float32x2, 5),
                    Slot::ReliefUv => single(Float32x2, 6),
                })
                .chain([instances(variant.node_normals(), variant.shadows.masked)])
                .collect(),
            Program::Edges { .. } => vec![single(Float32x3, 0), instances(false, false)],
            Program::Normals { .. } => {
                vec![
                    (24, Vertex, vec![attribute(Float32x3, 0, 0), attribute(Float32x3, 12, 1)]),
                    instances(true, false),
                ]
            }
            Program::Shape { .. } => {
                vec![(28, Vertex, vec![attribute(Float32x3, 0, 0), attribute(Float32x4, 12, 2)])]
            }
            _ => Vec::new(),
        })
    }

    fn layouts(&self) -> Vec<Option<wgpu::VertexBufferLayout<'_>>> {
        self.0
            .iter()
            .map(|(array_stride, step_mode, attributes)| {
                Some(wgpu::VertexBufferLayout { array_stride: *array_stride, step_mode: *step_mode, attributes })
            })
            .collect()
    }
}
