//! Shadows: what each source needs is placed, drawn, blurred and bound. `docs/techniques/shadows.md` says what it means.

mod casters;
mod fit;
mod glue;
mod limits;
mod pipelines;
mod record;
mod set;
mod show;
mod uniform;
mod volume;
mod volumes;

use aam_scene::{BlurKind, CasterFaces, Light, Scene, ShadowFilter, ShadowSettings, Shadows, View};
use glam::{DMat4, Vec3};

use crate::camera::clip_from_world;
use crate::draws::DrawList;
use crate::materials::bind;
use crate::meshes::MeshTable;
use crate::pipelines::Pipelines;
use crate::upload::{DynamicBuffer, Uploader};
use crate::{Gpu, RenderError};

pub(crate) use self::glue::{bindings, sources as functions};
pub use self::limits::{ShadowLimit, shadow_limits};
pub(crate) use self::pipelines::{Caster, is_filterable};
pub(crate) use self::record::CasterSources;
pub use self::set::MAX_SHADOW_SOURCES;
pub(crate) use self::set::{ShadowSet, SourceKind};
pub use self::show::shadow_camera;
pub(crate) use self::show::{MapKind, ShownMap};
use casters::{CasterDraw, caster_draws, instance_boxes, may_reach};
use fit::{Placement, Surroundings, place};
use pipelines::{CasterKey, ShadowPipelines};
use uniform::{GpuCasterView, GpuSource, empty_moments};

/// What a frame's sources are, before anything is placed.
#[derive(Clone, Debug, Default)]
pub(crate) struct SourceList {
    pub set: ShadowSet,
    /// For each source of the set its position in [`Shadows::sources`].
    pub indices: Vec<usize>,
}

impl SourceList {
    /// The sources that can be seen. `light_order` says where each of the scene's lights stands in the shader's list.
    pub(crate) fn new(
        scene: &Scene,
        light_order: &[Option<u8>],
        shown: Option<usize>,
        filterable: bool,
        warnings: &mut Vec<String>,
    ) -> Self {
        let Some(shadows) = &scene.shadows else { return Self::default() };
        let mut list = Self::default();
        let mut kinds = Vec::new();
        for (index, source) in shadows.sources.iter().enumerate().filter(|(_, source)| source.enabled) {
            let name = source_name(shadows, index);
            if let Err(reason) = source.settings.check() {
                warnings.push(format!("shadow {name} is not drawn: {reason}"));
                continue;
            }
            let technique = source.settings.technique;
            if !technique.exists() {
                warnings.push(format!("shadow {name} is not drawn: there is no technique {technique}"));
                continue;
            }
            // A light that shines on nothing is not darkened, unless its shadow is asked for.
            let light = match source.light {
                None => None,
                Some(light) => match light_order.get(light).copied().flatten() {
                    Some(place) => Some(place),
                    None if shown == Some(index) => None,
                    None => continue,
                },
            };
            if source.settings.intensity == 0.0 {
                continue;
            }
            if kinds.len() == MAX_SHADOW_SOURCES {
                warnings.push(format!(
                    "shadow {name} is not drawn: only {MAX_SHADOW_SOURCES} sources can cast shadows at once"
                ));
                continue;
            }
            kinds.push(SourceKind {
                layout: technique.layout,
                filter: technique.filter,
                kernel: source.settings.kernel,
                light,
            });
            list.indices.push(index);
        }
        // Without sources shaders are those of a scene without shadows.
        if !kinds.is_empty() {
            let masked = shadows.receivers != aam_scene::Members::All;
            list.set = ShadowSet::new(kinds, masked, filterable);
        }
        list
    }
}

fn source_name(shadows: &Shadows, index: usize) -> String {
    match shadows.sources.get(index).map(|source| source.name.as_str()) {
        Some(name) if !name.is_empty() => format!("{name:?}"),
        _ => format!("{index}"),
    }
}

/// A source's map on the GPU.
#[derive(Debug)]
struct Map {
    key: MapKey,
    layers: Vec<wgpu::TextureView>,
    array: wgpu::TextureView,
    /// What it was last drawn for; lookups must use the same placement.
    placement: Option<Placement>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct MapKey {
    format: wgpu::TextureFormat,
    width: u32,
    height: u32,
    layers: u32,
}

impl MapKey {
    fn bytes(self) -> u64 {
        let texel = u64::from(self.format.block_copy_size(None).unwrap_or(4));
        texel * u64::from(self.width) * u64::from(self.height) * u64::from(self.layers)
    }
}

/// The maps that are drawn in this frame.
#[derive(Debug, Default)]
pub(crate) struct FrameShadows {
    passes: Vec<MapPass>,
    blurs: Vec<BlurPass>,
    volumes: volumes::VolumeFrame,
}

impl FrameShadows {
    /// Nothing is drawn before the picture.
    pub(crate) fn is_empty(&self) -> bool {
        self.passes.is_empty() && self.volumes.is_empty()
    }
}

#[derive(Debug)]
struct MapPass {
    source: usize,
    layer: usize,
    settings: ShadowSettings,
    /// Place in the caster uniforms.
    offset: u32,
    draws: Vec<(CasterDraw, CasterKey)>,
}

#[derive(Debug)]
struct BlurPass {
    source: usize,
    layer: usize,
    /// Place in the blur uniforms of passes that read the map; that of those that read the other texture follows.
    offset: u32,
    running: bool,
}

/// Maps, pipelines and uniforms of all sources.
#[derive(Debug)]
pub(crate) struct ShadowTable {
    pub pipelines: ShadowPipelines,
    volumes: volumes::VolumeTable,
    maps: Vec<Option<Map>>,
    source_uniform: DynamicBuffer,
    caster_uniform: DynamicBuffer,
    blur_uniform: DynamicBuffer,
    shown_uniform: DynamicBuffer,
    caster_group: Option<wgpu::BindGroup>,
    sampler: Option<wgpu::Sampler>,
    group: Option<wgpu::BindGroup>,
}

impl Default for ShadowTable {
    fn default() -> Self {
        use wgpu::BufferUsages;
        Self {
            pipelines: ShadowPipelines::default(),
            volumes: volumes::VolumeTable::default(),
            maps: Vec::new(),
            source_uniform: DynamicBuffer::new("shadow sources", BufferUsages::UNIFORM),
            caster_uniform: DynamicBuffer::new("caster views", BufferUsages::UNIFORM),
            blur_uniform: DynamicBuffer::new("blurs", BufferUsages::UNIFORM),
            shown_uniform: DynamicBuffer::new("shown shadow map", BufferUsages::UNIFORM),
            caster_group: None,
            sampler: None,
            group: None,
        }
    }
}

/// What a frame's shadows are prepared from.
#[derive(Debug)]
pub(crate) struct Preparation<'a> {
    pub scene: &'a Scene,
    pub view: &'a View,
    pub lights: &'a [Light],
    pub list: &'a mut DrawList,
    pub meshes: &'a MeshTable,
    pub sources: &'a SourceList,
    pub eye: Vec3,
    /// Maps of an earlier frame are used again.
    pub keep: bool,
}

impl ShadowTable {
    /// Bind group 2 of surfaces that receive shadows.
    pub(crate) fn group(&self) -> Option<&wgpu::BindGroup> {
        self.group.as_ref()
    }

    /// Bytes of all maps.
    pub(crate) fn bytes(&self) -> u64 {
        self.maps.iter().flatten().map(|map| map.key.bytes()).sum()
    }

    /// How many maps there are.
    pub(crate) fn len(&self) -> usize {
        self.maps.iter().flatten().count()
    }

    /// Places the sources, and says what has to be drawn. Maps of sources that are gone are freed.
    pub(crate) fn prepare(
        &mut self,
        preparation: Preparation<'_>,
        shared: &mut Pipelines,
        uploader: &mut Uploader<'_>,
        warnings: &mut Vec<String>,
    ) -> Result<FrameShadows, RenderError> {
        let Preparation { scene, view, lights, list, meshes, sources, eye, keep } = preparation;
        let mut frame = FrameShadows::default();
        let Some(shadows) = scene.shadows.as_ref().filter(|_| !sources.set.is_empty()) else {
            self.maps.clear();
            self.volumes = volumes::VolumeTable::default();
            self.group = None;
            return Ok(frame);
        };
        let gpu = uploader.gpu.clone();
        let casts = shadows.casters.of(&scene.nodes);
        let receives = shadows.receivers.of(&scene.nodes);
        for (instance, node) in list.instances.iter_mut().zip(&list.nodes) {
            instance.receives = f32::from(u8::from(receives[*node as usize]));
        }
        let boxes = instance_boxes(scene, list);
        let taking_part: Vec<_> = boxes
            .iter()
            .zip(&list.nodes)
            .filter(|(_, node)| casts[**node as usize] || receives[**node as usize])
            .map(|(aabb, _)| *aabb)
            .collect();
        let around = Surroundings { lights, up: scene.up, view, boxes: &taking_part };
        let camera_clip = clip_from_world(view);

        let mut changed = self.maps.len() != sources.indices.len();
        self.maps.resize_with(sources.indices.len(), || None);
        let mut uniforms = Vec::new();
        let mut caster_views: Vec<GpuCasterView> = Vec::new();
        let mut blurs = Vec::new();
        for (slot, &index) in sources.indices.iter().enumerate() {
            let source = &shadows.sources[index];
            let settings = source.settings;
            let placement = match place(source, &around) {
                Ok(placement) => placement,
                Err(reason) => {
                    warnings.push(format!("shadow {} is not drawn: {reason}", source_name(shadows, index)));
                    uniforms.push(GpuSource::nowhere(slot));
                    changed |= self.ensure_map(&gpu, slot, MapKey::placeholder(settings))?;
                    continue;
                }
            };
            let key = match settings.technique.filter {
                ShadowFilter::Volume => MapKey::mask(view),
                _ => MapKey::of(&settings, placement.views.len()),
            };
            let is_new = self.ensure_map(&gpu, slot, key)?;
            changed |= is_new;
            let Some(map) = &mut self.maps[slot] else { continue };
            let kept = keep && !is_new && map.placement.is_some();
            let placement = match &map.placement {
                Some(old) if kept => old.clone(),
                _ => placement,
            };
            let light = source.light.and_then(|light| lights.get(light));
            uniforms.push(GpuSource::new(slot, &settings, &placement, light, eye));
            if kept {
                continue;
            }
            if settings.technique.filter == ShadowFilter::Volume {
                let volumes = volumes::Volumes { scene, list, meshes, boxes: &boxes, view, eye, placement: &placement };
                let casting = |instance: u32| casts[list.nodes[instance as usize] as usize];
                let pass = self.volumes.prepare(slot, &volumes, casting, uploader, &mut caster_views)?;
                for draw in &pass.draws {
                    self.pipelines.ensure_volume(&gpu, shared.frame_layout(), draw.mirrored)?;
                }
                self.pipelines.ensure_volume(&gpu, shared.frame_layout(), false)?;
                frame.volumes.passes.push(pass);
                map.placement = Some(placement);
                continue;
            }
            let unseen = |clip: &DMat4| {
                shadows.culling.sources && camera_clip.is_some_and(|camera| !volumes_may_meet(&camera, clip))
            };
            for (layer, map_view) in placement.views.iter().enumerate() {
                let clip = map_view.projection * map_view.view;
                if unseen(&clip) {
                    continue;
                }
                let draws = caster_draws(list, |instance| {
                    casts[list.nodes[instance as usize] as usize]
                        && (!shadows.culling.casters || may_reach(&boxes[instance as usize], &clip))
                });
                let faces = match (settings.faces, shadows.culling.back_faces) {
                    (CasterFaces::Both, true) => CasterFaces::Front,
                    (faces, _) => faces,
                };
                let mut keyed = Vec::with_capacity(draws.len());
                for draw in draws {
                    let batch = draw.batch.of(list);
                    let caster = Caster::of(batch, settings.technique.filter);
                    let key = CasterKey { caster, format: key.format, faces, mirrored: batch.mirrored, seen: false };
                    self.pipelines.ensure_caster(&gpu, shared, key)?;
                    keyed.push((draw, key));
                }
                frame.passes.push(MapPass {
                    source: slot,
                    layer,
                    settings,
                    offset: caster_views.len() as u32,
                    draws: keyed,
                });
                caster_views.push(GpuCasterView::new(&settings, &placement, map_view, eye));
                if settings.technique.filter.has_moments() && map_view.radius > 0.05 {
                    let running = settings.blur == BlurKind::Running;
                    let reach = if running {
                        self.pipelines.ensure_running(&gpu, settings.technique.filter, key.format)?;
                        running_width(map_view.radius)
                    } else {
                        self.pipelines.ensure_blur(&gpu, key.format)?;
                        map_view.radius as f32
                    };
                    frame.blurs.push(BlurPass { source: slot, layer, offset: blurs.len() as u32, running });
                    blurs.extend([(reach, layer as u32), (reach, 0)]);
                }
            }
            map.placement = Some(placement);
        }
        self.volumes.sweep();
        if !frame.volumes.passes.is_empty() {
            let reach = volumes::reach(view, &boxes);
            frame.volumes.camera = caster_views.len() as u32;
            caster_views.push(GpuCasterView::of_camera(crate::camera::boundless_clip(view, 2.0 * reach)));
            for (index, batch) in list.opaque.iter().enumerate() {
                let key = CasterKey {
                    caster: Caster::of(batch, ShadowFilter::Volume),
                    format: pipelines::counting_format(&gpu),
                    faces: CasterFaces::Both,
                    mirrored: batch.mirrored,
                    seen: true,
                };
                self.pipelines.ensure_caster(&gpu, shared, key)?;
                let draw = CasterDraw { batch: casters::BatchId::Opaque(index), instances: batch.instances.clone() };
                frame.volumes.seen.push((draw, key));
            }
        }
        self.upload(&gpu, uploader, &uniforms, &caster_views, &blurs, &mut changed)?;
        if changed || self.group.is_none() {
            self.group = self.receiver_group(&gpu, sources);
        }
        Ok(frame)
    }

    fn upload(
        &mut self,
        gpu: &Gpu,
        uploader: &mut Uploader<'_>,
        sources: &[GpuSource],
        casters: &[GpuCasterView],
        blurs: &[(f32, u32)],
        changed: &mut bool,
    ) -> Result<(), RenderError> {
        *changed |= self.source_uniform.set(uploader, bytemuck::cast_slice(sources))?;
        let stride = uniform_stride(gpu);
        let mut bytes = Vec::with_capacity(stride * casters.len());
        for caster in casters {
            bytes.extend_from_slice(bytemuck::bytes_of(caster));
            bytes.resize(bytes.len().next_multiple_of(stride), 0);
        }
        if self.caster_uniform.set(uploader, &bytes)? || self.caster_group.is_none() {
            let layout = self.pipelines.caster_layout(gpu);
            self.caster_group = self.caster_uniform.get().map(|buffer| {
                gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("caster"),
                    layout,
                    entries: &[bind(0, part_of::<GpuCasterView>(buffer))],
                })
            });
        }
        let mut bytes = Vec::with_capacity(stride * blurs.len());
        for (radius, layer) in blurs {
            bytes.extend_from_slice(&radius.to_ne_bytes());
            bytes.extend_from_slice(&layer.to_ne_bytes());
            bytes.resize(bytes.len().next_multiple_of(stride), 0);
        }
        self.blur_uniform.set(uploader, &bytes)?;
        Ok(())
    }

    /// Makes sure that a source has a map of this kind; true if it is a new one.
    fn ensure_map(&mut self, gpu: &Gpu, slot: usize, key: MapKey) -> Result<bool, RenderError> {
        if self.maps[slot].as_ref().is_some_and(|map| map.key == key) {
            return Ok(false);
        }
        let limits = gpu.device().limits();
        if key.width.max(key.height) > limits.max_texture_dimension_2d {
            return Err(RenderError::Limit {
                what: format!("a shadow map of {}×{} texels", key.width, key.height),
                needed: u64::from(key.width.max(key.height)),
                limit: "maxTextureDimension2D",
                allowed: u64::from(limits.max_texture_dimension_2d),
            });
        }
        let texture = gpu.device().create_texture(&wgpu::TextureDescriptor {
            label: Some("shadow map"),
            size: wgpu::Extent3d { width: key.width, height: key.height, depth_or_array_layers: key.layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: key.format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC
                | key.storage(),
            view_formats: &[],
        });
        let view = |dimension, base_array_layer, array_layer_count| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(dimension),
                base_array_layer,
                array_layer_count: Some(array_layer_count),
                ..wgpu::TextureViewDescriptor::default()
            })
        };
        let layers = (0..key.layers).map(|layer| view(wgpu::TextureViewDimension::D2, layer, 1)).collect();
        let kind = if key.is_mask() { wgpu::TextureViewDimension::D2 } else { wgpu::TextureViewDimension::D2Array };
        let array = view(kind, 0, key.layers);
        self.maps[slot] = Some(Map { key, layers, array, placement: None });
        Ok(true)
    }

    fn receiver_group(&mut self, gpu: &Gpu, sources: &SourceList) -> Option<wgpu::BindGroup> {
        let filter = if is_filterable(gpu) { wgpu::FilterMode::Linear } else { wgpu::FilterMode::Nearest };
        let sampler = self.sampler.get_or_insert_with(|| {
            gpu.device().create_sampler(&wgpu::SamplerDescriptor {
                label: Some("shadow maps"),
                mag_filter: filter,
                min_filter: filter,
                ..wgpu::SamplerDescriptor::default()
            })
        });
        let mut entries = vec![
            bind(0, self.source_uniform.get()?.as_entire_binding()),
            bind(1, wgpu::BindingResource::Sampler(sampler)),
        ];
        for (slot, map) in self.maps.iter().enumerate() {
            let array = &map.as_ref()?.array;
            entries.push(bind(glue::map_binding(slot), wgpu::BindingResource::TextureView(array)));
        }
        Some(gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("shadows"),
            layout: self.pipelines.receiver_layout(gpu, &sources.set),
            entries: &entries,
        }))
    }
}

/// Bytes from one uniform to the next in a buffer of several.
fn uniform_stride(gpu: &Gpu) -> usize {
    256_usize.max(gpu.device().limits().min_uniform_buffer_offset_alignment as usize)
}

fn part_of<T>(buffer: &wgpu::Buffer) -> wgpu::BindingResource<'_> {
    let size = std::num::NonZeroU64::new(size_of::<T>() as u64);
    wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size })
}

impl MapKey {
    fn of(settings: &ShadowSettings, layers: usize) -> Self {
        use wgpu::TextureFormat::{Depth16Unorm, Depth32Float, R32Float, Rg32Float, Rgba32Float};
        let format = match settings.technique.filter.channels() {
            0 if settings.bits == 16 => Depth16Unorm,
            0 => Depth32Float,
            1 => R32Float,
            2 => Rg32Float,
            _ => Rgba32Float,
        };
        Self { format, width: settings.resolution, height: settings.resolution, layers: layers as u32 }
    }

    /// For a source that sees nothing.
    fn placeholder(settings: ShadowSettings) -> Self {
        let format = match settings.technique.filter {
            ShadowFilter::Volume => wgpu::TextureFormat::R8Unorm,
            _ => Self::of(&settings, 1).format,
        };
        Self { format, width: 1, height: 1, layers: 1 }
    }

    /// A texel for each pixel of the picture.
    fn mask(view: &View) -> Self {
        Self { format: wgpu::TextureFormat::R8Unorm, width: view.width, height: view.height, layers: 1 }
    }

    /// Maps of moments can be blurred by a compute shader.
    fn storage(self) -> wgpu::TextureUsages {
        match self.format {
            wgpu::TextureFormat::R32Float | wgpu::TextureFormat::Rg32Float | wgpu::TextureFormat::Rgba32Float => {
                wgpu::TextureUsages::STORAGE_BINDING
            }
            _ => wgpu::TextureUsages::empty(),
        }
    }

    fn is_mask(self) -> bool {
        self.format == wgpu::TextureFormat::R8Unorm
    }
}

/// The width of two means of equal weights that together have the variance of a Gaussian whose standard deviation is a
/// third of the radius: `2·(width² − 1)/12 = radius²/9`.
fn running_width(radius: f64) -> f32 {
    (1.0 + 2.0 / 3.0 * radius * radius).sqrt().round().clamp(1.0, 64.0) as f32
}

/// Whether what a camera and a source see may have a point in common, both as world to clip space.
fn volumes_may_meet(camera: &DMat4, source: &DMat4) -> bool {
    let corners = |clip: &DMat4| -> Option<[glam::DVec3; 8]> {
        let inverse = clip.inverse();
        let corners = std::array::from_fn(|corner| {
            let pick = |bit: usize| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
            inverse.project_point3(glam::DVec3::new(pick(0), pick(1), 0.5 + 0.5 * pick(2)))
        });
        corners.iter().all(|corner| corner.is_finite()).then_some(corners)
    };
    let apart = |clip: &DMat4, corners: [glam::DVec3; 8]| {
        let corners = corners.map(|corner| *clip * corner.extend(1.0));
        let outside = |beyond: fn(&glam::DVec4) -> bool| corners.iter().all(beyond);
        outside(|c| c.x < -c.w)
            || outside(|c| c.x > c.w)
            || outside(|c| c.y < -c.w)
            || outside(|c| c.y > c.w)
            || outside(|c| c.z < 0.0)
            || outside(|c| c.z > c.w)
    };
    match (corners(camera), corners(source)) {
        (Some(of_camera), Some(of_source)) => !(apart(camera, of_source) || apart(source, of_camera)),
        _ => true,
    }
}
