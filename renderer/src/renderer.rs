//! Drawing frames.

use std::time::Instant;

use aam_scene::{Background, Image, Pixels, Projection, Scene, Shading, View};

use crate::backdrop;
use crate::camera::{FrameUniform, view_direction};
use crate::displacement::DisplacementTable;
use crate::draws::{self, Mode, Tables};
use crate::environment::{EnvironmentTable, EnvironmentTerms, SkyUniform, Wanted};
use crate::frame::Frame;
use crate::lights;
use crate::materials::MaterialTable;
use crate::meshes::MeshTable;
use crate::overlay::OverlayTable;
use crate::pipelines::{Constants, PassFormat, Pipelines};
use crate::read_back::read_texels;
use crate::scopes::Scopes;
use crate::shadows::{Preparation, ShadowTable, SourceList, is_filterable};
use crate::sort::Sorted;
use crate::targets::{TargetKey, TargetPool, check_size};
use crate::textures::TextureTable;
use crate::timing::Timing;
use crate::upload::{DynamicBuffer, Uploader};
use crate::{Alpha, FrameStats, Gpu, RenderError, RenderOptions, Resources, Show, Target};

/// What pictures are drawn to if the target cannot be drawn to directly: enough for straight colours of low alpha.
const INTERMEDIATE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Draws scenes. Keeps what it uploaded for as long as the scene's meshes and images live.
#[derive(Debug)]
pub struct Renderer {
    pub(crate) gpu: Gpu,
    /// Pictures drawn so far.
    pub(crate) picture: u64,
    pub(crate) meshes: MeshTable,
    pub(crate) textures: TextureTable,
    pub(crate) materials: MaterialTable,
    pub(crate) displacements: DisplacementTable,
    pub(crate) pipelines: Pipelines,
    pub(crate) targets: TargetPool,
    pub(crate) overlays: OverlayTable,
    pub(crate) environments: EnvironmentTable,
    pub(crate) sky_uniform: DynamicBuffer,
    pub(crate) sorted: Sorted,
    pub(crate) shadows: ShadowTable,
    pub(crate) frame_uniform: DynamicBuffer,
    pub(crate) light_uniform: DynamicBuffer,
    pub(crate) frame_group: Option<wgpu::BindGroup>,
    pub(crate) instances: DynamicBuffer,
    pub(crate) sorted_indices: DynamicBuffer,
    pub(crate) timing: Option<Timing>,
}

impl Renderer {
    /// A renderer that has uploaded and compiled nothing yet.
    pub fn new(gpu: Gpu) -> Self {
        use wgpu::BufferUsages;
        Self {
            pipelines: Pipelines::new(&gpu),
            gpu,
            picture: 0,
            meshes: MeshTable::default(),
            textures: TextureTable::default(),
            materials: MaterialTable::default(),
            displacements: DisplacementTable::default(),
            targets: TargetPool::default(),
            overlays: OverlayTable::new(),
            environments: EnvironmentTable::new(),
            sky_uniform: DynamicBuffer::new("sky", BufferUsages::UNIFORM),
            sorted: Sorted::default(),
            shadows: ShadowTable::default(),
            frame_uniform: DynamicBuffer::new("frame", BufferUsages::UNIFORM),
            light_uniform: DynamicBuffer::new("lights", BufferUsages::UNIFORM),
            frame_group: None,
            instances: DynamicBuffer::new("instances", BufferUsages::VERTEX),
            sorted_indices: DynamicBuffer::new("sorted indices", BufferUsages::INDEX),
            timing: None,
        }
    }

    /// The device that it draws with.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Draws one frame and submits it, without waiting for the GPU.
    ///
    /// # Errors
    /// [`RenderError`] says what the scene, the view or the device does not allow; nothing is to be seen then.
    pub fn render(
        &mut self,
        scene: &Scene,
        view: &View,
        options: &RenderOptions,
        target: &Target<'_>,
    ) -> Result<FrameStats, RenderError> {
        check_size(&self.gpu, view.width, view.height)?;
        check_target(view, target)?;
        self.guarded("drew a picture", |renderer| renderer.draw(scene, view, options, target))
    }

    /// Draws one frame and reads it back, as straight-alpha RGBA8, top row first.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_to_image(
        &mut self,
        scene: &Scene,
        view: &View,
        options: &RenderOptions,
    ) -> Result<(Image, FrameStats), RenderError> {
        check_size(&self.gpu, view.width, view.height)?;
        let shading = shading(scene, options);
        let key = TargetKey {
            width: view.width,
            height: view.height,
            format: Target::fitting_format(wgpu::TextureFormat::Rgba8Unorm, shading),
            samples: 1,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        };
        let picture = self.picture + 1;
        self.guarded("drew a picture to read back", |renderer| {
            let (texture, texture_view) = renderer.targets.get(&renderer.gpu, key, picture);
            let target = Target { view: &texture_view, format: key.format, alpha: Alpha::Straight };
            let mut stats = renderer.draw(scene, view, options, &target)?;
            let start = Instant::now();
            let pixels = read_texels(&renderer.gpu, &texture)?;
            stats.cpu.read_back_ms = milliseconds(start);
            if options.gpu_timing {
                stats.gpu = renderer.timing.as_mut().and_then(Timing::collect);
            }
            Ok((Image { width: view.width, height: view.height, pixels: Pixels::Rgba8(pixels) }, stats))
        })
    }

    /// How much of its light the shadow source at a position in [`aam_scene::Shadows::sources`] lets through to the
    /// surface in the middle of each pixel, top row first: from 1 − intensity in full shadow to 1, which is also where
    /// no surface is seen. Surfaces that blend are looked through. Of the options [`RenderOptions::keep_shadow_maps`]
    /// and [`RenderOptions::gpu_timing`] matter.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn visibility(
        &mut self,
        scene: &Scene,
        view: &View,
        source: usize,
        options: &RenderOptions,
    ) -> Result<(Vec<f32>, FrameStats), RenderError> {
        check_size(&self.gpu, view.width, view.height)?;
        let options = RenderOptions {
            msaa: crate::Msaa::X1,
            background: Some(Background::Color(glam::Vec3::ONE)),
            show: Show::Shadow(source),
            overlays: crate::Overlays::default(),
            ..options.clone()
        };
        let key = TargetKey {
            width: view.width,
            height: view.height,
            format: wgpu::TextureFormat::R32Float,
            samples: 1,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        };
        let picture = self.picture + 1;
        self.guarded("drew a shadow to read back", |renderer| {
            let (texture, texture_view) = renderer.targets.get(&renderer.gpu, key, picture);
            let target = Target { view: &texture_view, format: key.format, alpha: Alpha::Premultiplied };
            let mut stats = renderer.draw(scene, view, &options, &target)?;
            let start = Instant::now();
            let bytes = read_texels(&renderer.gpu, &texture)?;
            stats.cpu.read_back_ms = milliseconds(start);
            if options.gpu_timing {
                stats.gpu = renderer.timing.as_mut().and_then(Timing::collect);
            }
            Ok((bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect(), stats))
        })
    }

    fn pipelines_built(&self) -> usize {
        self.pipelines.len() + self.shadows.pipelines.len() + self.displacements.pipelines.len()
    }

    /// Waits for the GPU and returns the times of the last frame; `None` as for [`FrameStats::gpu`].
    ///
    /// # Errors
    /// When the device was lost.
    pub fn finish(&mut self) -> Result<Option<Vec<crate::PassTime>>, RenderError> {
        self.gpu.wait().map_err(|reason| RenderError::DeviceLost { reason })?;
        Ok(self.timing.as_mut().and_then(Timing::collect))
    }

    /// What it holds on the GPU at the moment.
    pub fn resources(&self) -> Resources {
        Resources {
            meshes: self.meshes.len(),
            mesh_buffers: self.meshes.buffer_count(),
            displaced_surfaces: self.displacements.len(),
            textures: self.textures.len(),
            materials: self.materials.len(),
            shaders_built: self.pipelines.module_count()
                + self.shadows.pipelines.module_count()
                + self.displacements.pipelines.len(),
            pipelines_built: self.pipelines_built(),
            targets: self.targets.len(),
            shadow_maps: self.shadows.len(),
            bytes: self.meshes.bytes()
                + self.displacements.bytes()
                + self.textures.bytes()
                + self.environments.bytes()
                + self.shadows.bytes(),
            environment_bytes: self.environments.bytes(),
        }
    }

    /// Runs something and turns what the device reports meanwhile into an error. What was made on the GPU may be
    /// invalid then, and is given up.
    fn guarded<T>(
        &mut self,
        during: &'static str,
        run: impl FnOnce(&mut Self) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        if let Some(reason) = self.gpu.lost() {
            return Err(RenderError::DeviceLost { reason });
        }
        let scopes = Scopes::open(&self.gpu);
        let result = run(self);
        let reported = scopes.close(&self.gpu, during);
        if reported.is_err() && self.gpu.lost().is_none() {
            *self = Self { picture: self.picture, ..Self::new(self.gpu.clone()) };
        }
        reported.and(result)
    }

    fn draw(
        &mut self,
        scene: &Scene,
        view: &View,
        options: &RenderOptions,
        target: &Target<'_>,
    ) -> Result<FrameStats, RenderError> {
        let start = Instant::now();
        self.picture += 1;
        let mut stats = FrameStats::default();
        let gpu = self.gpu.clone();
        let mut uploader = Uploader::new(&gpu);
        let pipelines_before = self.pipelines_built();

        let linear = shading(scene, options) == Shading::Linear;
        let normal_length = options.overlays.normals.unwrap_or(0.0);
        let mut uniform = FrameUniform::new(view, normal_length)?;
        uniform.exposure = aam_scene::exposure_factor(scene.exposure);
        let detail = options.environment.usable();
        let shading = if linear { Shading::Linear } else { Shading::Source };
        let lighting = scene.lighting_environment().filter(|_| options.show == Show::Lit);
        let terms = lighting.map(|environment| EnvironmentTerms::new(environment, &detail, shading));
        // An environment takes the place of lights.
        let (scene_lights, camera_light) =
            if lighting.is_some() { (Vec::new(), false) } else { scene.effective_lights(&view.camera) };
        let packed_lights = lights::pack(&scene_lights, uniform.eye)?;
        stats.lights = scene_lights.len() as u32;
        stats.camera_light = camera_light;

        let animation_frame = if view.frame >= 0.0 { view.frame as usize } else { 0 };
        let shown = match options.show {
            Show::Shadow(source) | Show::ShadowMap(source) => Some(source),
            _ => None,
        };
        let sources = match options.show {
            // An environment casts none.
            Show::Lit if lighting.is_some() => SourceList::default(),
            Show::Lit | Show::Shadow(_) | Show::ShadowMap(_) => {
                let filterable = is_filterable(&gpu);
                SourceList::new(scene, &packed_lights.order, shown, filterable, &mut stats.warnings)
            }
            _ => SourceList::default(),
        };
        let mode = Mode {
            show: options.show,
            shadows: sources.set,
            linear,
            lit: packed_lights.ends.spot > 0,
            environment: terms,
            falloff: packed_lights.falloff,
            ambient_light: packed_lights.ambient,
            anisotropy: options.anisotropy.clamp(1, 16),
            animation_frame,
            displacement: options.displacement,
            wireframe: options.overlays.wireframe,
            picture: self.picture,
        };
        let mut tables = Tables {
            meshes: &mut self.meshes,
            textures: &mut self.textures,
            materials: &mut self.materials,
            displacements: &mut self.displacements,
            pipelines: &mut self.pipelines,
        };
        let mut list = draws::prepare(scene, view, &mode, &mut tables, &mut uploader, &mut stats.warnings)?;
        stats.displaced_points = self.displacements.point_count();
        let preparation = Preparation {
            scene,
            view,
            lights: &scene_lights,
            list: &mut list,
            meshes: &self.meshes,
            sources: &sources,
            eye: uniform.eye,
            keep: options.keep_shadow_maps,
        };
        let shadows = self.shadows.prepare(preparation, &mut self.pipelines, &mut uploader, &mut stats.warnings)?;
        stats.shadow_bytes = self.shadows.bytes();
        let shows_map = matches!(options.show, Show::ShadowMap(_));
        let anything =
            !list.opaque.is_empty() || !list.blended.is_empty() || !options.overlays.is_empty() && !shows_map;

        let background = options.background.as_ref().unwrap_or(&scene.background);
        let direct = draws_directly(target, linear, backdrop::is_opaque(background, &mut self.textures));
        let format = PassFormat {
            color: if direct { target.format } else { INTERMEDIATE_FORMAT },
            samples: if anything { options.msaa.samples() } else { 1 },
            depth: anything,
        };
        let wanted = Wanted {
            terms: terms.filter(|_| draws::is_lit_by_environment(&list)).unwrap_or_default(),
            sky: *background == Background::Environment,
        };
        let (mut environment, mut sky) = (None, None);
        if let Some(map) = scene.environment.as_ref().filter(|_| wanted.sky || wanted.terms != Default::default()) {
            let Self { environments, pipelines, picture, .. } = self;
            let ready =
                environments.ensure(&mut uploader, pipelines, map, scene.up, shading, &detail, wanted, *picture)?;
            environment = ready.group;
            sky = ready.sky.map(|cube| (cube, SkyUniform::new(map, scene, view)));
        }
        let backdrop = match sky {
            Some((cube, uniform)) => self.sky(&cube, &uniform, scene.tone_map, format, &mut uploader)?,
            None => self.backdrop(background, linear, format, &mut uploader, &mut stats.warnings)?,
        };
        let overlays =
            self.overlays.prepare(&options.overlays, scene, &list, &mut self.meshes, &mut uploader, format, linear)?;
        if anything || !shadows.is_empty() {
            self.frame_uniform.set(&mut uploader, bytemuck::bytes_of(&uniform))?;
            self.light_uniform.set(&mut uploader, bytemuck::bytes_of(&packed_lights.list))?;
            self.instances.set(&mut uploader, bytemuck::cast_slice(&list.instances))?;
            self.make_frame_group();
        }
        let shown_slot = shown.and_then(|shown| sources.indices.iter().position(|index| *index == shown));
        let map = match (shown_slot, &scene.shadows) {
            (Some(slot), Some(all)) if shows_map => {
                let settings = &all.sources[sources.indices[slot]].settings;
                let size = [view.width, view.height];
                self.shadows.show(slot, settings, size, format, &mut self.pipelines, &mut uploader)?
            }
            _ => None,
        };
        let constants = Constants {
            lights: packed_lights.ends,
            parallel: matches!(view.camera.projection, Projection::Orthographic { .. }),
            environment: wanted.terms,
            tone_map: scene.tone_map,
            // Beyond the list's end where the source casts nothing: all is lit.
            shown_source: shown_slot.map_or(u32::MAX, |place| place as u32),
        };
        let frame =
            Frame { constants, list, overlays, sources, shadows, map, backdrop, environment, format, direct, linear };
        stats.cpu.upload_ms = milliseconds(start);

        let start = Instant::now();
        self.build_pipelines(&frame)?;
        stats.cpu.pipelines_ms = milliseconds(start);

        let start = Instant::now();
        if frame.list.blended.is_empty() {
            self.sorted = Sorted::default();
        } else {
            let direction = view_direction(&view.camera);
            let list = &frame.list;
            if self.sorted.update(
                scene,
                list,
                &self.meshes,
                &self.displacements,
                animation_frame,
                uniform.eye,
                direction,
            )? {
                self.sorted_indices.set(&mut uploader, bytemuck::cast_slice(&self.sorted.indices))?;
            }
        }
        stats.cpu.sort_ms = milliseconds(start);

        let start = Instant::now();
        self.record(scene, view, options, target, &frame, &mut stats)?;
        stats.cpu.encode_ms = milliseconds(start);
        stats.pipelines_built = (self.pipelines_built() - pipelines_before) as u32;
        stats.bytes_uploaded = uploader.bytes;
        self.sweep();
        Ok(stats)
    }

    /// Frees what belongs to meshes, images and shapes that are gone.
    fn sweep(&mut self) {
        self.meshes.sweep();
        self.textures.sweep(self.picture);
        self.materials.sweep(&self.textures, self.picture);
        self.displacements.sweep(self.picture);
        self.targets.sweep(self.picture);
        self.overlays.sweep();
        self.environments.sweep(self.picture);
    }
}

/// The values that lighting computes on; what shows stored values does so on them.
fn shading(scene: &Scene, options: &RenderOptions) -> Shading {
    match options.show {
        Show::Lit => options.shading.unwrap_or(scene.shading),
        _ => Shading::Source,
    }
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// Whether no converting pass is needed.
fn draws_directly(target: &Target<'_>, linear: bool, opaque: bool) -> bool {
    target.format.is_srgb() == linear && (opaque || target.alpha == Alpha::Premultiplied)
}

fn check_target(view: &View, target: &Target<'_>) -> Result<(), RenderError> {
    use wgpu::TextureFormat::{Bgra8Unorm, Bgra8UnormSrgb, Rgba8Unorm, Rgba8UnormSrgb, Rgba16Float};
    if !matches!(target.format, Bgra8Unorm | Bgra8UnormSrgb | Rgba8Unorm | Rgba8UnormSrgb | Rgba16Float) {
        return Err(RenderError::TargetFormat { format: format!("{:?}", target.format) });
    }
    let texture = target.view.texture();
    if (texture.width(), texture.height()) != (view.width, view.height) {
        return Err(RenderError::TargetSize {
            view_width: view.width,
            view_height: view.height,
            target_width: texture.width(),
            target_height: texture.height(),
        });
    }
    Ok(())
}
