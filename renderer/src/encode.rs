//! Recording draw calls.

use std::ops::Range;

use aam_scene::Scene;

use crate::FrameStats;
use crate::displacement::{DisplacementTable, SurfaceKey};
use crate::draws::{Batch, DrawList, mesh_of};
use crate::materials::{MaterialSlot, MaterialTable};
use crate::meshes::MeshTable;
use crate::overlay::{OverlayDraw, OverlayKind};
use crate::pipelines::{Constants, PassFormat, PipelineKey, Pipelines};
use crate::shader::Variant;
use crate::sort::Sorted;

/// Where everything that a pass draws with is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sources<'a> {
    pub scene: &'a Scene,
    pub list: &'a DrawList,
    pub meshes: &'a MeshTable,
    pub displacements: &'a DisplacementTable,
    pub materials: &'a MaterialTable,
    pub pipelines: &'a Pipelines,
    pub instances: Option<&'a wgpu::Buffer>,
    pub sorted: &'a Sorted,
    pub sorted_indices: Option<&'a wgpu::Buffer>,
    pub format: PassFormat,
    pub constants: Constants,
    /// Bind group 3 of surfaces that an environment lights.
    pub environment: Option<&'a wgpu::BindGroup>,
}

/// Records into a pass, and changes only the state that differs.
#[derive(Debug)]
pub(crate) struct Recorder<'a> {
    from: Sources<'a>,
    stats: &'a mut FrameStats,
    pipeline: Option<PipelineKey>,
    material: Option<MaterialSlot>,
    vertices: Option<(usize, Option<SurfaceKey>, Variant)>,
    indices: Option<IndexSource>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum IndexSource {
    Mesh(usize),
    Edges(usize),
    Displaced(SurfaceKey),
    DisplacedEdges(SurfaceKey),
    Sorted,
}

impl<'a> Recorder<'a> {
    /// Bind group 0 of the pass must be the frame's, and nobody else may set state in between.
    pub(crate) fn new(from: Sources<'a>, stats: &'a mut FrameStats) -> Self {
        Self { from, stats, pipeline: None, material: None, vertices: None, indices: None }
    }

    /// Draws opaque batches.
    pub(crate) fn opaque(&mut self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some(group) = self.from.environment {
            pass.set_bind_group(3, group, &[]);
        }
        for batch in &self.from.list.opaque {
            let indices = batch.displaced.map_or(IndexSource::Mesh(batch.mesh), IndexSource::Displaced);
            if self.prepare(pass, batch, indices) {
                let range = match batch.displaced {
                    Some(key) => 0..self.from.displacements.get(key).map_or(0, |surface| surface.index_count),
                    None => batch.indices.clone(),
                };
                self.draw_indexed(pass, range, batch.instances.clone(), 3);
            }
        }
    }

    /// Draws transparent triangles in their order.
    pub(crate) fn blended(&mut self, pass: &mut wgpu::RenderPass<'_>) {
        for run in &self.from.sorted.runs {
            if self.prepare(pass, &self.from.list.blended[run.batch], IndexSource::Sorted) {
                self.stats.sorted_triangles += run.indices.len() as u64 / 3;
                self.draw_indexed(pass, run.indices.clone(), run.instance..run.instance + 1, 3);
            }
        }
    }

    /// Draws overlays.
    pub(crate) fn overlays(&mut self, pass: &mut wgpu::RenderPass<'_>, draws: &[OverlayDraw]) {
        for draw in draws {
            if !self.set_pipeline(pass, draw.pipeline) {
                continue;
            }
            // Overlays have vertex buffers of their own.
            self.vertices = None;
            match &draw.kind {
                OverlayKind::Edges { mesh, instances } => self.edges(pass, *mesh, instances.clone()),
                OverlayKind::DisplacedEdges { surface, instances } => {
                    self.displaced_edges(pass, *surface, instances.clone());
                }
                OverlayKind::Normals { mesh, instances } => self.normals(pass, *mesh, instances.clone()),
                OverlayKind::Vertices { buffer, count } => {
                    pass.set_vertex_buffer(0, buffer.slice(..));
                    self.draw(pass, 0..*count, 0..1, if draw.pipeline.lines { 0 } else { 3 });
                }
            }
        }
    }

    fn edges(&mut self, pass: &mut wgpu::RenderPass<'_>, mesh: usize, instances: Range<u32>) {
        let Some(gpu_mesh) = self.from.meshes.get(&self.from.scene.meshes[mesh]) else { return };
        let positions = gpu_mesh.stream(crate::meshes::Stream::Position);
        let (Some(positions), Some((edges, count)), Some(placed)) = (positions, &gpu_mesh.edges, self.from.instances)
        else {
            return;
        };
        if *count == 0 {
            return;
        }
        pass.set_vertex_buffer(0, positions.slice(..));
        pass.set_vertex_buffer(1, placed.slice(..));
        self.set_indices(pass, IndexSource::Edges(mesh), edges);
        self.draw_indexed(pass, 0..*count, instances, 0);
    }

    fn displaced_edges(&mut self, pass: &mut wgpu::RenderPass<'_>, key: SurfaceKey, instances: Range<u32>) {
        let Some(surface) = self.from.displacements.get(key) else { return };
        let positions = surface.stream(crate::meshes::Stream::Position);
        if let (Some(positions), Some((edges, count)), Some(placed)) = (positions, &surface.edges, self.from.instances)
        {
            pass.set_vertex_buffer(0, positions.slice(..));
            pass.set_vertex_buffer(1, placed.slice(..));
            self.set_indices(pass, IndexSource::DisplacedEdges(key), edges);
            self.draw_indexed(pass, 0..*count, instances, 0);
        }
    }

    fn normals(&mut self, pass: &mut wgpu::RenderPass<'_>, mesh: usize, instances: Range<u32>) {
        let data = &self.from.scene.meshes[mesh];
        let lines = self.from.meshes.get(data).and_then(|mesh| mesh.normal_lines.as_ref());
        if let (Some((lines, _)), Some(placed)) = (lines, self.from.instances) {
            pass.set_vertex_buffer(0, lines.slice(..));
            pass.set_vertex_buffer(1, placed.slice(..));
            self.draw(pass, 0..2 * data.positions.len() as u32, instances, 0);
        }
    }

    /// Sets everything that a batch is drawn with; false if something is missing.
    fn prepare(&mut self, pass: &mut wgpu::RenderPass<'_>, batch: &Batch, indices: IndexSource) -> bool {
        let key = batch.pipeline(self.from.format, self.from.constants);
        let mesh = self.from.meshes.get(mesh_of(self.from.scene, batch));
        let material = self.from.materials.bind_group(batch.material);
        let (Some(mesh), Some(material), Some(instances)) = (mesh, material, self.from.instances) else {
            return false;
        };
        if !self.set_pipeline(pass, key) {
            return false;
        }
        if self.material != Some(batch.material) {
            pass.set_bind_group(1, material, &[]);
            self.material = Some(batch.material);
        }
        // Texture coordinates belong to the layers that the variant reads, or to the whole picture's choice.
        let surface = batch.displaced.map(|key| self.from.displacements.get(key));
        let drawn = (batch.mesh, batch.displaced, batch.variant);
        if self.vertices != Some(drawn) {
            let mut slot = 0;
            for stream in batch.streams() {
                let buffer = match surface {
                    Some(surface) => surface.and_then(|surface| surface.stream(stream)),
                    None => mesh.stream(stream),
                };
                let Some(buffer) = buffer else { return false };
                pass.set_vertex_buffer(slot, buffer.slice(..));
                slot += 1;
            }
            pass.set_vertex_buffer(slot, instances.slice(..));
            self.vertices = Some(drawn);
        }
        match (indices, self.from.sorted_indices) {
            (IndexSource::Sorted, Some(buffer)) => self.set_indices(pass, indices, buffer),
            (IndexSource::Sorted, None) => return false,
            _ => {
                let displaced = surface.flatten().map(|surface| &surface.indices);
                self.set_indices(pass, indices, displaced.unwrap_or(&mesh.indices));
            }
        }
        true
    }

    fn set_pipeline(&mut self, pass: &mut wgpu::RenderPass<'_>, key: PipelineKey) -> bool {
        if self.pipeline == Some(key) {
            return true;
        }
        let Some(pipeline) = self.from.pipelines.get(&key) else { return false };
        pass.set_pipeline(pipeline);
        self.pipeline = Some(key);
        self.stats.pipeline_switches += 1;
        true
    }

    fn set_indices(&mut self, pass: &mut wgpu::RenderPass<'_>, source: IndexSource, buffer: &wgpu::Buffer) {
        if self.indices != Some(source) {
            pass.set_index_buffer(buffer.slice(..), wgpu::IndexFormat::Uint32);
            self.indices = Some(source);
        }
    }

    fn draw_indexed(
        &mut self,
        pass: &mut wgpu::RenderPass<'_>,
        indices: Range<u32>,
        instances: Range<u32>,
        corners: u64,
    ) {
        self.count(indices.len(), instances.len(), corners);
        pass.draw_indexed(indices, 0, instances);
    }

    fn draw(&mut self, pass: &mut wgpu::RenderPass<'_>, vertices: Range<u32>, instances: Range<u32>, corners: u64) {
        self.count(vertices.len(), instances.len(), corners);
        pass.draw(vertices, instances);
    }

    /// `corners` is 3 for triangles, 0 for lines.
    fn count(&mut self, vertices: usize, instances: usize, corners: u64) {
        self.stats.draws += 1;
        if let Some(triangles) = (vertices as u64).checked_div(corners) {
            self.stats.triangles += triangles * instances as u64;
        }
    }
}
