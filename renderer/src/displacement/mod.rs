//! Displaced surfaces: tessellated on the CPU ([`aam_scene::displacement`]), displaced by compute passes into ordinary
//! vertex streams, which every pass draws with the shaders that it has. What a surface is made of changes seldom; nothing
//! is computed again while it stays the same, and nothing is there for scenes that nothing displaces.
//!
//! Limits: docs/techniques/displacement.md.

mod heights;
mod jobs;

use std::collections::HashMap;
use std::sync::{Arc, Weak};

use aam_scene::displacement::{
    Base, Detail, Displaced, HeightMap, MAX_TRIANGLES, Plan, Surface, Viewer, classes, coarser_warning, of_subset,
    warnings,
};
use aam_scene::{DisplacementMode, Image, Mesh, Scene, Subset, View};
use glam::{Affine3A, Vec3};

use crate::RenderError;
use crate::meshes::{GpuMesh, Stream, ensure_stream};
use crate::shader::Program;
use crate::upload::Uploader;
use heights::HeightTable;
use jobs::{ComputePipelines, InterpolateParameters, Job};

pub(crate) use jobs::DisplaceParameters;

/// Frames that an unused surface is kept for.
const KEEP: u64 = 60;

/// Identifies the displaced surface of a mesh's subset: the mesh by its address, which no other gets meanwhile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SurfaceKey {
    mesh: usize,
    subset: u32,
}

/// What the points and triangles of a surface follow from.
#[derive(Clone, Debug, PartialEq)]
enum Shape {
    /// A tessellation factor.
    Uniform(u32),
    /// The surface and who looks at it.
    Adaptive(Motion, Viewer),
}

/// What positions and recomputed normals follow from, beside points.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Motion {
    frame: usize,
    image: usize,
    parameters: DisplaceParameters,
}

/// What a stream was filled from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Filled {
    Displaced(Motion),
    /// From the base mesh at a frame.
    Interpolated(usize),
}

/// A displaced surface on the GPU: vertex streams, and the triangles between them.
#[derive(Debug)]
pub(crate) struct GpuSurface {
    mesh: Weak<Mesh>,
    shape: Shape,
    point_count: u32,
    pub indices: wgpu::Buffer,
    pub index_count: u32,
    points: wgpu::Buffer,
    samples: wgpu::Buffer,
    streams: [Option<(wgpu::Buffer, Filled)>; Stream::COUNT],
    /// What it was cut from, if it is cut again as the view changes.
    base: Option<Arc<Base>>,
    /// What it is made of, where the CPU needs that.
    plan: Option<Plan>,
    /// Line list of all edges, for the wireframe.
    pub edges: Option<(wgpu::Buffer, u32)>,
    /// Triangles and displaced positions for sorting, where they are transparent.
    pub sorting: Option<Sorting>,
    last_used: u64,
}

/// A displaced surface on the CPU.
#[derive(Debug)]
pub(crate) struct Sorting {
    motion: Motion,
    /// No other has it.
    pub serial: u64,
    pub positions: Vec<Vec3>,
    pub indices: Vec<u32>,
}

/// A surface as the CPU sees it.
struct Source<'a> {
    mesh: &'a Arc<Mesh>,
    displaced: &'a Displaced<'a>,
    heights: &'a HeightMap,
    motion: Motion,
}

impl Source<'_> {
    /// Looks at the surface on the CPU.
    fn with_surface<T>(&self, look: impl FnOnce(&Surface<'_>) -> T) -> T {
        let Self { mesh, displaced, heights, motion } = self;
        look(&Surface {
            positions: mesh.positions_at(motion.frame),
            normals: &mesh.normals_at(motion.frame),
            uvs: displaced.uvs,
            heights,
            transform: displaced.transform,
            bias: displaced.parameters.bias,
            scale: displaced.parameters.scale,
        })
    }
}

impl GpuSurface {
    /// A stream that was made sure of.
    pub(crate) fn stream(&self, stream: Stream) -> Option<&wgpu::Buffer> {
        self.streams[stream.index()].as_ref().map(|(buffer, _)| buffer)
    }

    fn buffers(&self) -> impl Iterator<Item = &wgpu::Buffer> {
        let streams = self.streams.iter().flatten().map(|(buffer, _)| buffer);
        let edges = self.edges.iter().map(|(buffer, _)| buffer);
        streams.chain([&self.indices, &self.points, &self.samples]).chain(edges)
    }
}

/// What of a surface is needed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Needs {
    pub frame: usize,
    /// Its triangles are sorted.
    pub sorted: bool,
    /// Its edges are drawn.
    pub edges: bool,
    pub picture: u64,
}

/// A displacement map as a fragment shader reads it.
#[derive(Clone, Debug)]
pub(crate) struct Relief {
    pub parameters: DisplaceParameters,
    /// Which map; no other has the number.
    pub map: u64,
    pub view: wgpu::TextureView,
}

/// The displaced surfaces on the GPU.
#[derive(Debug, Default)]
pub(crate) struct DisplacementTable {
    surfaces: HashMap<SurfaceKey, GpuSurface>,
    heights: HeightTable,
    /// How uneven maps are, where something is tessellated adaptively.
    details: HashMap<usize, (Weak<Image>, Arc<Detail>)>,
    pub(crate) pipelines: ComputePipelines,
    /// Work of the frame at hand.
    pub(crate) jobs: Vec<Job>,
    /// Triangles that displacement may still make in the frame at hand.
    allowed: u64,
    /// Meshes whose warnings were said.
    said: HashMap<usize, Weak<Mesh>>,
    last_serial: u64,
}

impl DisplacementTable {
    /// Begins a frame.
    pub(crate) fn begin(&mut self) {
        self.jobs.clear();
        self.allowed = MAX_TRIANGLES;
    }

    /// A surface that was made sure of.
    pub(crate) fn get(&self, key: SurfaceKey) -> Option<&GpuSurface> {
        self.surfaces.get(&key)
    }

    /// Makes sure that the map of a subset that is drawn by parallax is on the GPU; `None` where nothing displaces it.
    pub(crate) fn relief(
        &mut self,
        uploader: &mut Uploader<'_>,
        scene: &Scene,
        mesh: &Mesh,
        subset: &Subset,
        said: &mut Vec<String>,
    ) -> Result<Option<Relief>, RenderError> {
        let Some(displaced) = of_subset(scene, mesh, subset) else { return Ok(None) };
        let Some(heights) = HeightMap::new(displaced.image) else { return Ok(None) };
        let map = self.heights.ensure(uploader, displaced.image, &heights, &mesh.name, said)?;
        let parameters = DisplaceParameters {
            row_u: displaced.transform.row(0).to_array(),
            bias: displaced.parameters.bias,
            row_v: displaced.transform.row(1).to_array(),
            scale: displaced.parameters.scale,
            texel: map.texel,
            point_count: 0,
            padding: [0; 2],
        };
        Ok(Some(Relief { parameters, map: map.serial, view: map.view.clone() }))
    }

    /// Makes sure that the displaced surface of a mesh's subset is on the GPU with the streams that are read, once the jobs
    /// have run; `None` where nothing displaces it.
    #[expect(clippy::too_many_arguments, reason = "a surface follows from mesh, material, options and time")]
    pub(crate) fn ensure(
        &mut self,
        uploader: &mut Uploader<'_>,
        scene: &Scene,
        mesh: &Arc<Mesh>,
        gpu_mesh: &mut GpuMesh,
        subset: u32,
        (mode, view, world): (DisplacementMode, &View, &[Affine3A]),
        streams: impl Iterator<Item = Stream>,
        needs: Needs,
        said: &mut Vec<String>,
    ) -> Result<Option<SurfaceKey>, RenderError> {
        if !matches!(mode, DisplacementMode::Uniform | DisplacementMode::Adaptive { .. }) {
            return Ok(None);
        }
        let Some(displaced) = of_subset(scene, mesh, &mesh.subsets[subset as usize]) else { return Ok(None) };
        let Some(heights) = HeightMap::new(displaced.image) else { return Ok(None) };
        if !can_compute(uploader.gpu) {
            return Err(RenderError::Mesh {
                mesh: mesh.name.clone(),
                reason: "this GPU has no compute shaders, which displacement needs: switch displacement off".into(),
            });
        }
        let address = Arc::as_ptr(mesh) as usize;
        if let std::collections::hash_map::Entry::Vacant(e) = self.said.entry(address) {
            e.insert(Arc::downgrade(mesh));
            said.extend(warnings(mesh));
        }
        let key = SurfaceKey { mesh: address, subset };
        let map = self.heights.ensure(uploader, displaced.image, &heights, &mesh.name, said)?;
        let matrix = displaced.transform;
        let motion = Motion {
            frame: needs.frame,
            image: Arc::as_ptr(displaced.image) as usize,
            parameters: DisplaceParameters {
                row_u: matrix.row(0).to_array(),
                bias: displaced.parameters.bias,
                row_v: matrix.row(1).to_array(),
                scale: displaced.parameters.scale,
                texel: map.texel,
                point_count: 0,
                padding: [0; 2],
            },
        };
        let source = Source { mesh, displaced: &displaced, heights: &heights, motion };
        let shape = match mode {
            DisplacementMode::Adaptive { pixel_error } => {
                Shape::Adaptive(motion, Viewer::new(view, world, pixel_error))
            }
            _ => Shape::Uniform(displaced.parameters.tessellation),
        };
        self.ensure_shape(uploader, &source, key, shape, needs, said)?;
        let Some(surface) = self.surfaces.get_mut(&key) else { return Ok(None) };
        if surface.index_count == 0 {
            return Ok(Some(key));
        }
        let map = self.heights.ensure(uploader, displaced.image, &heights, &mesh.name, said)?;
        for stream in [Stream::Normal, Stream::Uv(3)] {
            ensure_stream(uploader, gpu_mesh, mesh, stream)?;
        }
        let filled = |stream: Stream| match stream {
            Stream::Position => Filled::Displaced(motion),
            Stream::Normal if displaced.recompute_normals => Filled::Displaced(motion),
            Stream::Normal => Filled::Interpolated(needs.frame),
            _ => Filled::Interpolated(0),
        };
        let mut stale = Vec::new();
        for stream in streams {
            let filled = filled(stream);
            let size = u64::from(surface.point_count) * 4 * u64::from(components(stream));
            let entry = &mut surface.streams[stream.index()];
            if entry.as_ref().is_none_or(|(_, known)| *known != filled) {
                let buffer = match entry.take() {
                    Some((buffer, _)) => buffer,
                    None => {
                        let what = format!("displaced {stream:?} of mesh {:?}", mesh.name);
                        storage(uploader, &what, wgpu::BufferUsages::VERTEX, size)?
                    }
                };
                *entry = Some((buffer, filled));
                stale.push((stream, filled));
            }
        }
        let displaces =
            |stream: Stream| stale.iter().any(|(s, filled)| *s == stream && matches!(filled, Filled::Displaced(_)));
        let normals = displaces(Stream::Normal);
        if displaces(Stream::Position) || normals {
            let base = [Stream::Position, Stream::Normal, Stream::Uv(3)].map(|stream| gpu_mesh.stream(stream));
            if let (Some(out), [Some(positions), Some(base_normals), Some(uvs)]) =
                (surface.stream(Stream::Position), base)
            {
                let mut resources: Vec<wgpu::BindingResource<'_>> =
                    [&surface.points, &surface.samples, positions, base_normals, uvs]
                        .map(wgpu::Buffer::as_entire_binding)
                        .into();
                resources.push(wgpu::BindingResource::TextureView(&map.view));
                resources.push(out.as_entire_binding());
                resources
                    .extend(surface.stream(Stream::Normal).filter(|_| normals).map(wgpu::Buffer::as_entire_binding));
                let parameters = DisplaceParameters { point_count: surface.point_count, ..motion.parameters };
                let parameters = bytemuck::bytes_of(&parameters);
                let program = Program::Displace { normals };
                let job = self.pipelines.job(uploader, program, parameters, &resources, surface.point_count)?;
                self.jobs.push(job);
            }
        }
        for (stream, _) in stale.iter().filter(|(_, filled)| matches!(filled, Filled::Interpolated(_))) {
            ensure_stream(uploader, gpu_mesh, mesh, *stream)?;
            let (Some(base), Some(out)) = (gpu_mesh.stream(*stream), surface.stream(*stream)) else { continue };
            let parameters = InterpolateParameters {
                point_count: surface.point_count,
                components: components(*stream),
                padding: [0; 2],
            };
            let resources = [&surface.points, base, out].map(wgpu::Buffer::as_entire_binding);
            let parameters = bytemuck::bytes_of(&parameters);
            let job =
                self.pipelines.job(uploader, Program::Interpolate, parameters, &resources, surface.point_count)?;
            self.jobs.push(job);
        }
        if needs.edges
            && surface.edges.is_none()
            && let Some(plan) = &surface.plan
        {
            surface.edges = Some(edges(uploader, plan, &mesh.name)?);
        }
        if needs.sorted
            && surface.sorting.as_ref().is_none_or(|sorting| sorting.motion != motion)
            && let Some(plan) = &surface.plan
        {
            self.last_serial += 1;
            let positions = source.with_surface(|surface| surface.vertices(plan, false).0);
            let indices = plan.indices.clone();
            surface.sorting = Some(Sorting { motion, serial: self.last_serial, positions, indices });
        }
        Ok(Some(key))
    }

    fn ensure_shape(
        &mut self,
        uploader: &mut Uploader<'_>,
        source: &Source<'_>,
        key: SurfaceKey,
        shape: Shape,
        Needs { sorted, edges, picture, .. }: Needs,
        said: &mut Vec<String>,
    ) -> Result<(), RenderError> {
        let mesh = source.mesh;
        let keep_plan = sorted || edges;
        let known = self.surfaces.get_mut(&key).filter(|surface| surface.mesh.strong_count() > 0);
        let base = known.as_ref().and_then(|surface| surface.base.clone());
        if let Some(surface) = known.filter(|known| known.shape == shape && (known.plan.is_some() || !keep_plan)) {
            let triangles = u64::from(surface.index_count / 3);
            if surface.last_used != picture && triangles <= self.allowed {
                self.allowed -= triangles;
                surface.last_used = picture;
            }
            if surface.last_used == picture {
                return Ok(());
            }
        }
        let new_base = || Arc::new(Base::new(mesh, &mesh.subsets[key.subset as usize], &classes(mesh)));
        let base = base.unwrap_or_else(new_base);
        let plan = match &shape {
            Shape::Uniform(factor) => Plan::uniform(&base, *factor, &mesh.name, self.allowed)?,
            Shape::Adaptive(_, viewer) => {
                let detail = self.detail(source);
                let (plan, coarser) = source.with_surface(|surface| {
                    Plan::adaptive(&base, surface, &detail, viewer, &mesh.name, self.allowed)
                })?;
                said.extend(coarser_warning(mesh, coarser));
                plan
            }
        };
        self.allowed -= (plan.triangle_count() as u64).min(self.allowed);
        let of = |what: &str| format!("{what} of displaced mesh {:?}", mesh.name);
        let filled = |uploader: &mut Uploader<'_>, what: &str, usage, bytes: &[u8]| {
            // A binding must not be empty.
            let buffer = storage(uploader, &of(what), usage, (bytes.len() as u64).max(256))?;
            uploader.write(&buffer, 0, bytes);
            Ok::<_, RenderError>(buffer)
        };
        let none = wgpu::BufferUsages::empty();
        let surface = GpuSurface {
            mesh: Arc::downgrade(mesh),
            base: matches!(shape, Shape::Adaptive(..)).then_some(base),
            shape,
            point_count: plan.points.len() as u32,
            index_count: plan.indices.len() as u32,
            indices: filled(uploader, "indices", wgpu::BufferUsages::INDEX, bytemuck::cast_slice(&plan.indices))?,
            points: filled(uploader, "points", none, bytemuck::cast_slice(&plan.points))?,
            samples: filled(uploader, "samples", none, bytemuck::cast_slice(&plan.samples))?,
            streams: Default::default(),
            plan: keep_plan.then_some(plan),
            edges: None,
            sorting: None,
            last_used: picture,
        };
        self.surfaces.insert(key, surface);
        Ok(())
    }

    fn detail(&mut self, source: &Source<'_>) -> Arc<Detail> {
        let image = source.displaced.image;
        let address = Arc::as_ptr(image) as usize;
        let new = || (Arc::downgrade(image), Arc::new(Detail::new(source.heights)));
        Arc::clone(&self.details.entry(address).or_insert_with(new).1)
    }

    /// Frees what belongs to meshes and images that are gone, and surfaces that were not drawn for long.
    pub(crate) fn sweep(&mut self, picture: u64) {
        self.surfaces.retain(|_, surface| surface.mesh.strong_count() > 0 && surface.last_used + KEEP >= picture);
        self.said.retain(|_, mesh| mesh.strong_count() > 0);
        self.details.retain(|_, (image, _)| image.strong_count() > 0);
        self.heights.sweep();
    }

    /// Points that the jobs of the frame at hand displace.
    pub(crate) fn point_count(&self) -> u64 {
        self.jobs.iter().map(Job::displaced_points).sum()
    }

    pub(crate) fn len(&self) -> usize {
        self.surfaces.len()
    }

    pub(crate) fn bytes(&self) -> u64 {
        let surfaces = self.surfaces.values().flat_map(GpuSurface::buffers).map(wgpu::Buffer::size).sum::<u64>();
        surfaces + self.heights.bytes()
    }
}

/// Whether the device has compute shaders with as many storage buffers as a pass binds.
fn can_compute(gpu: &crate::Gpu) -> bool {
    let limits = gpu.device().limits();
    limits.max_storage_buffers_per_shader_stage >= 8 && limits.max_compute_invocations_per_workgroup >= 128
}

/// What a vertex buffer is used for beside drawing.
pub(crate) fn readable(gpu: &crate::Gpu) -> wgpu::BufferUsages {
    if can_compute(gpu) { wgpu::BufferUsages::STORAGE } else { wgpu::BufferUsages::empty() }
}

/// Floats of a stream's vertex.
fn components(stream: Stream) -> u32 {
    match stream {
        Stream::Position | Stream::Normal => 3,
        Stream::Tangent | Stream::Color => 4,
        Stream::Uv(_) => 2,
    }
}

/// A buffer that compute passes can bind.
fn storage(
    uploader: &Uploader<'_>,
    what: &str,
    usage: wgpu::BufferUsages,
    size: u64,
) -> Result<wgpu::Buffer, RenderError> {
    let allowed = uploader.gpu.device().limits().max_storage_buffer_binding_size;
    if size > allowed {
        let limit = "maxStorageBufferBindingSize";
        return Err(RenderError::Limit { what: what.to_owned(), needed: size, limit, allowed });
    }
    uploader.empty_buffer(what, usage | wgpu::BufferUsages::STORAGE, size)
}

/// Each edge of a surface once, as a line list.
fn edges(uploader: &mut Uploader<'_>, plan: &Plan, mesh: &str) -> Result<(wgpu::Buffer, u32), RenderError> {
    let sides = plan.indices.chunks_exact(3).flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
    let mut edges: Vec<[u32; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.dedup();
    let what = format!("edges of displaced mesh {mesh:?}");
    let buffer = uploader.buffer(&what, wgpu::BufferUsages::INDEX, bytemuck::cast_slice(&edges))?;
    Ok((buffer, 2 * edges.len() as u32))
}
