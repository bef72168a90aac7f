//! What sources see, for people: the view of a source as a camera, and its map as a picture.

use aam_scene::{Camera, Projection, Scene, ShadowFilter, ShadowLayout, View};
use bytemuck::{Pod, Zeroable};

use super::ShadowTable;
use super::casters::instance_boxes;
use super::fit::{MapView, Placement, Surroundings, place};
use super::uniform::Warp;
use crate::RenderError;
use crate::draws;
use crate::materials::bind;
use crate::pipelines::{PassFormat, PipelineKey, Pipelines};
use crate::shader::Program;
use crate::upload::Uploader;

/// The camera that sees what the map of a shadow source sees, through a square window. `view` is the picture's, whose
/// frame of the animation counts; `source` is a position in [`aam_scene::Shadows::sources`].
///
/// # Errors
/// A sentence: why there is no such camera, or not just one.
pub fn shadow_camera(scene: &Scene, view: &View, source: usize) -> Result<Camera, String> {
    let shadows = scene.shadows.as_ref().ok_or("the scene has no shadows")?;
    let count = shadows.sources.len();
    let source = shadows.sources.get(source).ok_or_else(|| format!("the scene has {count} shadow sources"))?;
    match source.settings.technique.layout {
        ShadowLayout::One => {}
        ShadowLayout::Cube => return Err("a cube looks to all sides".into()),
        ShadowLayout::Cascades => return Err("each cascade sees something else".into()),
    }
    if let Some(volume) = &source.volume {
        return Ok(Camera { name: source.name.clone(), ..volume.clone() });
    }
    let frame = if view.frame >= 0.0 { view.frame as usize } else { 0 };
    let list = draws::place(scene, frame).map_err(|error| error.to_string())?;
    let (casts, receives) = (shadows.casters.of(&scene.nodes), shadows.receivers.of(&scene.nodes));
    let boxes: Vec<_> = instance_boxes(scene, &list)
        .into_iter()
        .zip(&list.nodes)
        .filter(|(_, node)| casts[**node as usize] || receives[**node as usize])
        .map(|(aabb, _)| aabb)
        .collect();
    let (lights, _) = scene.effective_lights(&view.camera);
    let around = Surroundings { lights: &lights, up: scene.up, view, boxes: &boxes };
    let Placement { views, perspective, .. } = place(source, &around)?;
    let seen = views.first().ok_or("it has no map")?;
    Ok(camera(seen, perspective, source.name.clone()))
}

fn camera(seen: &MapView, perspective: bool, name: String) -> Camera {
    let to_world = seen.view.inverse();
    let (up, back) = (to_world.y_axis.truncate(), to_world.z_axis.truncate());
    let half = 1.0 / seen.projection.y_axis.y;
    // Depths may be negative where there is no place to look from: it is put before all that is seen.
    let room = 0.01 * (seen.far - seen.near);
    let (back_by, near) = if perspective { (0.0, seen.near) } else { (room - seen.near, room) };
    let position = to_world.w_axis.truncate() + back * back_by;
    let far = seen.far + back_by;
    Camera {
        name,
        position: position.as_vec3(),
        target: (position - back * far).as_vec3(),
        up: up.as_vec3(),
        projection: if perspective {
            Projection::Perspective { fov_y: (2.0 * half.atan()) as f32 }
        } else {
            Projection::Orthographic { height: (2.0 * half) as f32 }
        },
        near: near as f32,
        far: far as f32,
    }
}

/// What decides about the shader that shows a map: the technique whose moments it holds, or `None` for depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct MapKind(Option<ShadowFilter>);

impl MapKind {
    fn of(filter: ShadowFilter) -> Self {
        Self(filter.has_moments().then_some(filter))
    }

    pub(crate) fn is_depth(self) -> bool {
        self.0.is_none()
    }

    pub(crate) fn all() -> Vec<Self> {
        let mut kinds: Vec<Self> = ShadowFilter::ALL.iter().copied().map(Self::of).collect();
        kinds.sort_unstable();
        kinds.dedup();
        kinds
    }

    /// The value of every feature that the shader's files ask for.
    pub(crate) fn features(self) -> Vec<(&'static str, bool)> {
        use ShadowFilter::{Esm, Evsm2, Evsm4};
        vec![
            ("MOMENTS", self.0.is_some()),
            ("EXPONENTIAL", matches!(self.0, Some(Esm | Evsm2 | Evsm4))),
            ("NEGATIVE_FIRST", self.0 == Some(Evsm4)),
        ]
    }
}

/// `ShownMap` in `shaders/shadow_map.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct GpuShownMap {
    size: [f32; 2],
    grid: [f32; 2],
    layers: f32,
    near: f32,
    far: f32,
    perspective: f32,
    exponent: f32,
    shift: f32,
    padding: [f32; 2],
}

/// A map to be shown: its bind group, and the pipeline.
#[derive(Debug)]
pub(crate) struct ShownMap {
    pub group: wgpu::BindGroup,
    pub pipeline: PipelineKey,
}

impl ShadowTable {
    /// Prepares the map of the source in a slot to be shown; `None` if there is none.
    pub(crate) fn show(
        &mut self,
        slot: usize,
        settings: &aam_scene::ShadowSettings,
        size: [u32; 2],
        pass: PassFormat,
        shared: &mut Pipelines,
        uploader: &mut Uploader<'_>,
    ) -> Result<Option<ShownMap>, RenderError> {
        let Some(map) = self.maps.get(slot).and_then(Option::as_ref) else { return Ok(None) };
        if settings.technique.filter == ShadowFilter::Volume {
            return Ok(None);
        }
        let Some(placement) = &map.placement else { return Ok(None) };
        let Some(view) = placement.views.first() else { return Ok(None) };
        let gpu = uploader.gpu;
        let kind = MapKind::of(settings.technique.filter);
        let grid = match map.key.layers {
            1 => [1.0, 1.0],
            2 => [2.0, 1.0],
            3 | 4 => [2.0, 2.0],
            _ => [3.0, 2.0],
        };
        let warp = Warp::of(settings);
        let uniform = GpuShownMap {
            size: size.map(|side| side as f32),
            grid,
            layers: map.key.layers as f32,
            near: view.near as f32,
            far: view.far as f32,
            perspective: f32::from(u8::from(placement.perspective)),
            exponent: warp.exponent,
            shift: warp.shift,
            padding: [0.0; 2],
        };
        let pipeline = PipelineKey::new(Program::ShadowMap(kind), pass);
        shared.ensure(gpu, pipeline, None)?;
        self.shown_uniform.set(uploader, bytemuck::bytes_of(&uniform))?;
        let Some(buffer) = self.shown_uniform.get() else { return Ok(None) };
        let group = gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("shown shadow map"),
            layout: shared.map_layout(gpu, kind),
            entries: &[bind(0, buffer.as_entire_binding()), bind(1, wgpu::BindingResource::TextureView(&map.array))],
        });
        Ok(Some(ShownMap { group, pipeline }))
    }
}
