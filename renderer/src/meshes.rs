//! Meshes on the GPU: one copy of each, for as long as the mesh lives, and of its streams only those that a shader reads.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, Weak};

use aam_scene::Mesh;
use glam::{Vec2, Vec3, Vec4};

use crate::upload::Uploader;
use crate::{RenderError, displacement};

/// A vertex attribute that has a buffer of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Stream {
    Position,
    Normal,
    Tangent,
    Color,
    /// Texture coordinates of a layer.
    Uv(u8),
}

impl Stream {
    pub(crate) const COUNT: usize = 8;

    pub(crate) fn index(self) -> usize {
        match self {
            Self::Position => 0,
            Self::Normal => 1,
            Self::Tangent => 2,
            Self::Color => 3,
            Self::Uv(layer) => 4 + usize::from(layer),
        }
    }
}

/// A mesh on the GPU.
#[derive(Debug)]
pub(crate) struct GpuMesh {
    mesh: Weak<Mesh>,
    /// No other mesh has it, whatever its address.
    pub serial: u64,
    streams: [Option<wgpu::Buffer>; Stream::COUNT],
    pub indices: wgpu::Buffer,
    /// The mesh's indices where some of its own had to be put out of action.
    repaired: Option<Vec<u32>>,
    /// The animation frame that positions and normals are from.
    frame: usize,
    /// Some vertex colour has an alpha below 1.
    pub translucent_colors: bool,
    /// Line list of all edges, for the wireframe.
    pub edges: Option<(wgpu::Buffer, u32)>,
    /// Line list of vertex normals (position and normal, zero at the foot), of animation frame `.1`.
    pub normal_lines: Option<(wgpu::Buffer, usize)>,
}

impl GpuMesh {
    /// A stream that was made sure of.
    pub(crate) fn stream(&self, stream: Stream) -> Option<&wgpu::Buffer> {
        self.streams[stream.index()].as_ref()
    }

    /// The indices as drawn.
    pub(crate) fn cpu_indices<'a>(&'a self, mesh: &'a Mesh) -> &'a [u32] {
        self.repaired.as_deref().unwrap_or(&mesh.indices)
    }

    fn buffers(&self) -> impl Iterator<Item = &wgpu::Buffer> {
        let overlays = self.edges.iter().map(|(buffer, _)| buffer);
        let overlays = overlays.chain(self.normal_lines.iter().map(|(buffer, _)| buffer));
        self.streams.iter().flatten().chain([&self.indices]).chain(overlays)
    }
}

/// The meshes on the GPU, by address (which no other mesh gets while the table knows it).
#[derive(Debug, Default)]
pub(crate) struct MeshTable {
    entries: HashMap<usize, GpuMesh>,
    last_serial: u64,
}

impl MeshTable {
    /// Makes sure that a mesh's indices and positions are on the GPU, the latter in the given frame.
    pub(crate) fn ensure(
        &mut self,
        uploader: &mut Uploader<'_>,
        mesh: &Arc<Mesh>,
        frame: usize,
    ) -> Result<&mut GpuMesh, RenderError> {
        let address = Arc::as_ptr(mesh) as usize;
        if !self.entries.contains_key(&address) {
            check(mesh)?;
            let repaired = repaired_indices(mesh);
            let indices = repaired.as_deref().unwrap_or(&mesh.indices);
            self.last_serial += 1;
            let entry = GpuMesh {
                mesh: Arc::downgrade(mesh),
                serial: self.last_serial,
                streams: Default::default(),
                indices: uploader.buffer(
                    &format!("indices of mesh {:?}", mesh.name),
                    wgpu::BufferUsages::INDEX,
                    bytemuck::cast_slice(indices),
                )?,
                repaired,
                frame,
                translucent_colors: mesh.colors.iter().flatten().any(|color| color.w < 1.0),
                edges: None,
                normal_lines: None,
            };
            self.entries.insert(address, entry);
        }
        let entry = self
            .entries
            .get_mut(&address)
            .ok_or_else(|| RenderError::Mesh { mesh: mesh.name.clone(), reason: "it is not on the GPU".into() })?;
        if entry.frame != frame {
            entry.frame = frame;
            for stream in [Stream::Position, Stream::Normal] {
                if let Some(buffer) = &entry.streams[stream.index()] {
                    with_contents(mesh, stream, frame, |bytes| uploader.write(buffer, 0, bytes));
                }
            }
        }
        ensure_stream(uploader, entry, mesh, Stream::Position)?;
        Ok(entry)
    }

    /// A mesh that was made sure of.
    pub(crate) fn get(&self, mesh: &Arc<Mesh>) -> Option<&GpuMesh> {
        self.entries.get(&(Arc::as_ptr(mesh) as usize))
    }

    /// Frees what belongs to meshes that are gone.
    pub(crate) fn sweep(&mut self) {
        self.entries.retain(|_, entry| entry.mesh.strong_count() > 0);
    }

    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    pub(crate) fn buffer_count(&self) -> usize {
        self.entries.values().map(|entry| entry.buffers().count()).sum()
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.entries.values().flat_map(GpuMesh::buffers).map(wgpu::Buffer::size).sum()
    }
}

/// Makes sure that a stream is on the GPU.
pub(crate) fn ensure_stream(
    uploader: &mut Uploader<'_>,
    entry: &mut GpuMesh,
    mesh: &Mesh,
    stream: Stream,
) -> Result<(), RenderError> {
    if entry.streams[stream.index()].is_none() {
        let what = format!("{stream:?} of mesh {:?}", mesh.name);
        let usage = wgpu::BufferUsages::VERTEX | displacement::readable(uploader.gpu);
        let upload = |bytes: &[u8]| uploader.buffer(&what, usage, bytes);
        entry.streams[stream.index()] = Some(with_contents(mesh, stream, entry.frame, upload)?);
    }
    Ok(())
}

/// Makes sure that the line list of a mesh's edges is on the GPU: each edge once.
pub(crate) fn ensure_edges(uploader: &mut Uploader<'_>, entry: &mut GpuMesh, mesh: &Mesh) -> Result<(), RenderError> {
    if entry.edges.is_none() {
        let mut edges: Vec<[u32; 2]> = entry
            .cpu_indices(mesh)
            .chunks_exact(3)
            .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
            .filter(|[a, b]| a != b)
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        let count = u32::try_from(2 * edges.len()).map_err(|_| RenderError::Mesh {
            mesh: mesh.name.clone(),
            reason: "it has more edges than a wireframe can show".into(),
        })?;
        let what = format!("edges of mesh {:?}", mesh.name);
        let buffer = uploader.buffer(&what, wgpu::BufferUsages::INDEX, bytemuck::cast_slice(&edges))?;
        entry.edges = Some((buffer, count));
    }
    Ok(())
}

/// Makes sure that the line list of a mesh's vertex normals is on the GPU.
pub(crate) fn ensure_normal_lines(
    uploader: &mut Uploader<'_>,
    entry: &mut GpuMesh,
    mesh: &Mesh,
) -> Result<(), RenderError> {
    if entry.normal_lines.as_ref().is_none_or(|(_, frame)| *frame != entry.frame) {
        let lines: Vec<[[Vec3; 2]; 2]> = positions(mesh, entry.frame)
            .iter()
            .zip(&*normals(mesh, entry.frame))
            .map(|(&position, &normal)| [[position, Vec3::ZERO], [position, normal]])
            .collect();
        let what = format!("normal lines of mesh {:?}", mesh.name);
        let buffer = uploader.buffer(&what, wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(&lines))?;
        entry.normal_lines = Some((buffer, entry.frame));
    }
    Ok(())
}

fn check(mesh: &Mesh) -> Result<(), RenderError> {
    let fault = |reason: String| Err(RenderError::Mesh { mesh: mesh.name.clone(), reason });
    let count = mesh.positions.len();
    // Line lists of normals have twice as many vertices.
    if u32::try_from(mesh.indices.len()).is_err() || u32::try_from(2 * count).is_err() {
        return fault("it has more than 4294967295 indices or 2147483647 vertices".into());
    }
    let same = |what: &str, length: usize| {
        if length == count { Ok(()) } else { Err(format!("it has {count} positions but {length} {what}")) }
    };
    let lengths = || {
        same("normals", mesh.normals.len())?;
        same("tangents", mesh.tangents.as_ref().map_or(count, Vec::len))?;
        same("vertex colours", mesh.colors.as_ref().map_or(count, Vec::len))?;
        for uvs in mesh.uvs.iter().flatten() {
            same("texture coordinates", uvs.len())?;
        }
        for (index, frame) in mesh.frames.iter().enumerate() {
            same(&format!("positions in frame {}", index + 1), frame.positions.len())?;
            same(&format!("normals in frame {}", index + 1), frame.normals.len())?;
        }
        Ok(())
    };
    if let Err(reason) = lengths() {
        return fault(reason);
    }
    for (index, subset) in mesh.subsets.iter().enumerate() {
        let end = u64::from(subset.first_index) + u64::from(subset.index_count);
        if end > mesh.indices.len() as u64 {
            return fault(format!("subset {index} ends at index {end} of {}", mesh.indices.len()));
        }
    }
    Ok(())
}

/// The indices with every triangle collapsed that has a corner which is not there or not finite; `None` if all are
/// well.
fn repaired_indices(mesh: &Mesh) -> Option<Vec<u32>> {
    let good = |index: &u32| mesh.positions.get(*index as usize).is_some_and(|position| position.is_finite());
    if mesh.indices.iter().all(good) {
        return None;
    }
    let mut indices = mesh.indices.clone();
    for triangle in indices.chunks_mut(3) {
        if !triangle.iter().all(good) {
            triangle.fill(0);
        }
    }
    Some(indices)
}

/// Values with those that are not good replaced; no copy is made if all are.
fn repaired<'a, T: Copy>(values: &'a [T], good: impl Fn(&T) -> bool, repair: impl Fn(usize, T) -> T) -> Cow<'a, [T]> {
    if values.iter().all(&good) {
        return Cow::Borrowed(values);
    }
    let repair = |(index, value): (usize, &T)| if good(value) { *value } else { repair(index, *value) };
    Cow::Owned(values.iter().enumerate().map(repair).collect())
}

/// Positions at a frame, all finite.
fn positions(mesh: &Mesh, frame: usize) -> Cow<'_, [Vec3]> {
    let base = |index: usize| mesh.positions.get(index).copied().filter(|position| position.is_finite());
    repaired(cpu_positions(mesh, frame), |position| position.is_finite(), |index, _| base(index).unwrap_or_default())
}

/// The positions that triangles are sorted by, at a frame.
pub(crate) fn cpu_positions(mesh: &Mesh, frame: usize) -> &[Vec3] {
    frame_of(mesh, frame).map_or(&mesh.positions, |later| &later.positions)
}

fn frame_of(mesh: &Mesh, frame: usize) -> Option<&aam_scene::MeshFrame> {
    frame.checked_sub(1).and_then(|later| mesh.frames.get(later))
}

/// Normals at a frame; those that have no direction are made from the triangles around.
fn normals(mesh: &Mesh, frame: usize) -> Cow<'_, [Vec3]> {
    let stored = frame_of(mesh, frame).map_or(&mesh.normals, |later| &later.normals);
    let good = |normal: &Vec3| normal.is_finite() && *normal != Vec3::ZERO;
    let sums = if stored.iter().all(good) { Vec::new() } else { face_normal_sums(mesh, &positions(mesh, frame)) };
    repaired(stored, good, |index, _| sums.get(index).copied().unwrap_or_default().normalize_or(Vec3::Z))
}

/// For each vertex, the sum of the unit normals of its triangles.
fn face_normal_sums(mesh: &Mesh, positions: &[Vec3]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for triangle in mesh.indices.chunks_exact(3) {
        let corner = |which: usize| positions.get(triangle[which] as usize).copied();
        if let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) {
            let face = (b - a).cross(c - a).normalize_or_zero();
            for &index in triangle {
                sums[index as usize] += face;
            }
        }
    }
    sums
}

/// Hands over the bytes of a stream at a frame.
fn with_contents<R>(mesh: &Mesh, stream: Stream, frame: usize, use_bytes: impl FnOnce(&[u8]) -> R) -> R {
    match stream {
        Stream::Position => use_bytes(bytemuck::cast_slice(&positions(mesh, frame))),
        Stream::Normal => use_bytes(bytemuck::cast_slice(&normals(mesh, frame))),
        Stream::Tangent => {
            let tangents = mesh.tangents.as_deref().unwrap_or_default();
            use_bytes(bytemuck::cast_slice(&repaired(tangents, |tangent| tangent.is_finite(), |_, _| Vec4::W)))
        }
        Stream::Color => {
            let colors = mesh.colors.as_deref().unwrap_or_default();
            let good = |color: &Vec4| color.to_array().iter().all(|c| (0.0..=1.0).contains(c));
            let clamp = |c: f32| if c.is_nan() { 0.0 } else { c.clamp(0.0, 1.0) };
            let clamped = |_, color: Vec4| Vec4::from_array(color.to_array().map(clamp));
            use_bytes(bytemuck::cast_slice(&repaired(colors, good, clamped)))
        }
        Stream::Uv(layer) => {
            let uvs = mesh.uvs[usize::from(layer)].as_deref().unwrap_or_default();
            let finite = |c: f32| if c.is_finite() { c } else { 0.0 };
            let made_finite = |_, uv: Vec2| Vec2::from_array(uv.to_array().map(finite));
            use_bytes(bytemuck::cast_slice(&repaired(uvs, |uv| uv.is_finite(), made_finite)))
        }
    }
}
