//! Lines over the picture: edges and normals of meshes, boxes, and the caller's shapes.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Weak};

use aam_scene::{Aabb, Scene, displacement};
use glam::Vec3;

use crate::displacement::SurfaceKey;
use crate::draws::{DrawList, DrawnMesh, Instance};
use crate::meshes::{MeshTable, cpu_positions, ensure_edges, ensure_normal_lines};
use crate::pipelines::{PassFormat, PipelineKey};
use crate::shader::Program;
use crate::upload::{DynamicBuffer, Uploader};
use crate::{Overlays, RenderError, Shape, ShapeKind, ShapeVertex};

/// Colour of bounding boxes.
const BOUNDS_COLOR: [f32; 4] = [0.3, 0.9, 0.45, 1.0];

/// Buffers of overlays.
#[derive(Debug)]
pub(crate) struct OverlayTable {
    shapes: HashMap<usize, (Weak<Shape>, wgpu::Buffer)>,
    bounds: DynamicBuffer,
}

/// One draw of an overlay.
#[derive(Clone, Debug)]
pub(crate) struct OverlayDraw {
    pub pipeline: PipelineKey,
    pub kind: OverlayKind,
}

/// What an overlay draws.
#[derive(Clone, Debug)]
pub(crate) enum OverlayKind {
    /// Edges of a mesh in all its instances.
    Edges { mesh: usize, instances: Range<u32> },
    /// Edges of a displaced surface in all its instances.
    DisplacedEdges { surface: SurfaceKey, instances: Range<u32> },
    /// Vertex normals of a mesh in all its instances.
    Normals { mesh: usize, instances: Range<u32> },
    /// Vertices from a buffer.
    Vertices { buffer: wgpu::Buffer, count: u32 },
}

impl OverlayTable {
    pub(crate) fn new() -> Self {
        Self { shapes: HashMap::new(), bounds: DynamicBuffer::new("bounds", wgpu::BufferUsages::VERTEX) }
    }

    /// Puts on the GPU what the overlays need, and lists their draws. Pipelines match `pass`.
    #[expect(clippy::too_many_arguments, reason = "overlays read most of a frame's parts")]
    pub(crate) fn prepare(
        &mut self,
        overlays: &Overlays,
        scene: &Scene,
        list: &DrawList,
        meshes: &mut MeshTable,
        uploader: &mut Uploader<'_>,
        pass: PassFormat,
        linear: bool,
    ) -> Result<Vec<OverlayDraw>, RenderError> {
        let mut draws = Vec::new();
        let key = |program, lines| PipelineKey { lines, ..PipelineKey::new(program, pass) };
        if overlays.wireframe || overlays.normals.is_some() {
            for DrawnMesh { mesh, frame, instances, .. } in list.meshes.iter().cloned() {
                let data = &scene.meshes[mesh];
                let entry = meshes.ensure(uploader, data, frame)?;
                let displaced = list.displaced.iter().filter(|(of, _)| overlays.wireframe && *of == mesh);
                let surfaces: Vec<SurfaceKey> = displaced.map(|(_, surface)| *surface).collect();
                draws.extend(surfaces.iter().map(|&surface| {
                    let kind = OverlayKind::DisplacedEdges { surface, instances: instances.clone() };
                    OverlayDraw { pipeline: key(Program::Edges { linear }, true), kind }
                }));
                if overlays.wireframe && surfaces.len() < data.subsets.len() {
                    ensure_edges(uploader, entry, data)?;
                    let kind = OverlayKind::Edges { mesh, instances: instances.clone() };
                    draws.push(OverlayDraw { pipeline: key(Program::Edges { linear }, true), kind });
                }
                if overlays.normals.is_some() {
                    ensure_normal_lines(uploader, entry, data)?;
                    let kind = OverlayKind::Normals { mesh, instances };
                    draws.push(OverlayDraw { pipeline: key(Program::Normals { linear }, true), kind });
                }
            }
        }
        if overlays.bounds {
            let vertices = bounds(scene, list);
            self.bounds.set(uploader, bytemuck::cast_slice(&vertices))?;
            if let Some(buffer) = self.bounds.get().filter(|_| !vertices.is_empty()) {
                let kind = OverlayKind::Vertices { buffer: buffer.clone(), count: vertices.len() as u32 };
                draws.push(OverlayDraw { pipeline: key(Program::Shape { linear, nudge: true }, true), kind });
            }
        }
        for shape in &overlays.shapes {
            let group = match shape.kind {
                ShapeKind::Lines => 2,
                ShapeKind::Triangles => 3,
            };
            let count = shape.vertices.len() / group * group;
            if count == 0 {
                continue;
            }
            let buffer = self.shape(uploader, shape)?;
            let pipeline = key(Program::Shape { linear, nudge: shape.depth_test }, shape.kind == ShapeKind::Lines);
            draws.push(OverlayDraw { pipeline, kind: OverlayKind::Vertices { buffer, count: count as u32 } });
        }
        Ok(draws)
    }

    fn shape(&mut self, uploader: &mut Uploader<'_>, shape: &Arc<Shape>) -> Result<wgpu::Buffer, RenderError> {
        let address = Arc::as_ptr(shape) as usize;
        if let Some((_, buffer)) = self.shapes.get(&address) {
            return Ok(buffer.clone());
        }
        let contents = bytemuck::cast_slice(&shape.vertices);
        let buffer = uploader.buffer("shape", wgpu::BufferUsages::VERTEX, contents)?;
        self.shapes.insert(address, (Arc::downgrade(shape), buffer.clone()));
        Ok(buffer)
    }

    /// Frees shapes that are gone.
    pub(crate) fn sweep(&mut self) {
        self.shapes.retain(|_, (shape, _)| shape.strong_count() > 0);
    }
}

/// The twelve edges of each drawn mesh's box, in each instance.
fn bounds(scene: &Scene, list: &DrawList) -> Vec<ShapeVertex> {
    let mut vertices = Vec::new();
    for drawn in &list.meshes {
        let mesh = &scene.meshes[drawn.mesh];
        let aabb = Aabb::of(cpu_positions(mesh, drawn.frame).iter().copied());
        if aabb.is_empty() {
            continue;
        }
        let is_displaced = list.displaced.iter().any(|(of, _)| *of == drawn.mesh);
        let reach = if is_displaced { displacement::reach(mesh) } else { 0.0 };
        let aabb = Aabb { min: aabb.min - reach, max: aabb.max + reach };
        let corner = |bits: u32| {
            let pick = |axis: usize| if bits >> axis & 1 == 0 { aabb.min[axis] } else { aabb.max[axis] };
            Vec3::new(pick(0), pick(1), pick(2))
        };
        for instance in &list.instances[drawn.instances.start as usize..drawn.instances.end as usize] {
            for (a, b) in (0..8u32).flat_map(|a| [1, 2, 4].map(|bit| (a, a | bit))).filter(|(a, b)| a != b) {
                vertices.extend(
                    [a, b].map(|bits| ShapeVertex { position: placed(instance, corner(bits)), color: BOUNDS_COLOR }),
                );
            }
        }
    }
    vertices
}

fn placed(instance: &Instance, p: Vec3) -> Vec3 {
    Vec3::from_array(instance.rows.map(|row| Vec3::new(row[0], row[1], row[2]).dot(p) + row[3]))
}
