//! The binary buffer, and the accessors into it.
//!
//! Data of one kind and stride shares one view, so that a file has a handful of views however many meshes it has.

use glam::{Vec2, Vec3, Vec4};

use super::json::{Accessor, BufferView, Index};

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// A view under construction.
#[derive(Debug)]
struct View {
    bytes: Vec<u8>,
    stride: Option<u32>,
    target: Option<u32>,
}

/// Kinds of data that have a view each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Vertices { stride: u32 },
    Indices { bytes: u32 },
    Animation,
}

/// Collects binary data.
#[derive(Debug, Default)]
pub(super) struct Buffers {
    views: Vec<View>,
    shared: Vec<(Kind, Index)>,
    pub(super) accessors: Vec<Accessor>,
}

impl Buffers {
    fn view(&mut self, kind: Kind) -> Index {
        if let Some((_, view)) = self.shared.iter().find(|(shared, _)| *shared == kind) {
            return *view;
        }
        let view = self.views.len() as Index;
        let (stride, target) = match kind {
            Kind::Vertices { stride } => (Some(stride), Some(ARRAY_BUFFER)),
            Kind::Indices { .. } => (None, Some(ELEMENT_ARRAY_BUFFER)),
            Kind::Animation => (None, None),
        };
        self.views.push(View { bytes: Vec::new(), stride, target });
        self.shared.push((kind, view));
        view
    }

    fn floats<const N: usize>(&mut self, kind: Kind, rows: impl Iterator<Item = [f32; N]>, bounded: bool) -> Index {
        let view = self.view(kind);
        let bytes = &mut self.views[view as usize].bytes;
        let byte_offset = bytes.len() as u64;
        let (mut min, mut max) = ([f32::INFINITY; N], [f32::NEG_INFINITY; N]);
        let mut count = 0;
        for row in rows {
            for (at, value) in row.into_iter().enumerate() {
                bytes.extend_from_slice(&value.to_le_bytes());
                min[at] = min[at].min(value);
                max[at] = max[at].max(value);
            }
            count += 1;
        }
        let word = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        self.accessors.push(Accessor {
            buffer_view: view,
            byte_offset,
            component_type: FLOAT,
            count,
            kind: word,
            min: bounded.then(|| min.to_vec()),
            max: bounded.then(|| max.to_vec()),
        });
        self.accessors.len() as Index - 1
    }

    /// Positions, with their bounds.
    pub(super) fn positions(&mut self, rows: impl Iterator<Item = Vec3>) -> Index {
        self.floats(Kind::Vertices { stride: 12 }, rows.map(|row| row.to_array()), true)
    }

    /// Normals, colours and their like.
    pub(super) fn vectors(&mut self, rows: impl Iterator<Item = Vec3>) -> Index {
        self.floats(Kind::Vertices { stride: 12 }, rows.map(|row| row.to_array()), false)
    }

    /// Tangents.
    pub(super) fn tangents(&mut self, rows: impl Iterator<Item = Vec4>) -> Index {
        self.floats(Kind::Vertices { stride: 16 }, rows.map(|row| row.to_array()), false)
    }

    /// Texture coordinates.
    pub(super) fn coordinates(&mut self, rows: impl Iterator<Item = Vec2>) -> Index {
        self.floats(Kind::Vertices { stride: 8 }, rows.map(|row| row.to_array()), false)
    }

    /// Triangle corners, in 16 bits where `vertices` are few enough. (The largest 16-bit index restarts a primitive.)
    pub(super) fn indices(&mut self, corners: &[u32], vertices: usize) -> Index {
        let short = vertices <= usize::from(u16::MAX);
        let view = self.view(Kind::Indices { bytes: if short { 2 } else { 4 } });
        let bytes = &mut self.views[view as usize].bytes;
        let byte_offset = bytes.len() as u64;
        for &corner in corners {
            if short {
                bytes.extend_from_slice(&(corner as u16).to_le_bytes());
            } else {
                bytes.extend_from_slice(&corner.to_le_bytes());
            }
        }
        self.accessors.push(Accessor {
            buffer_view: view,
            byte_offset,
            component_type: if short { UNSIGNED_SHORT } else { UNSIGNED_INT },
            count: corners.len() as u64,
            kind: "SCALAR",
            min: None,
            max: None,
        });
        self.accessors.len() as Index - 1
    }

    /// Times of keys, in seconds, with their bounds.
    pub(super) fn times(&mut self, rows: &[f32]) -> Index {
        self.floats(Kind::Animation, rows.iter().map(|&time| [time]), true)
    }

    /// Values of keys.
    pub(super) fn keys<const N: usize>(&mut self, rows: impl Iterator<Item = [f32; N]>) -> Index {
        self.floats(Kind::Animation, rows, false)
    }

    /// A file inside the buffer.
    pub(super) fn file(&mut self, bytes: &[u8]) -> Index {
        self.views.push(View { bytes: bytes.to_vec(), stride: None, target: None });
        self.views.len() as Index - 1
    }

    /// The buffer's bytes and the views into it; each view starts at a multiple of four.
    pub(super) fn finish(self) -> (Vec<u8>, Vec<BufferView>, Vec<Accessor>) {
        let mut bytes = Vec::new();
        let mut views = Vec::new();
        for view in self.views {
            views.push(BufferView {
                buffer: 0,
                byte_offset: bytes.len() as u64,
                byte_length: view.bytes.len() as u64,
                byte_stride: view.stride,
                target: view.target,
            });
            bytes.extend(view.bytes);
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        }
        (bytes, views, self.accessors)
    }
}
