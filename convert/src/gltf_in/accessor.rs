//! Numbers out of buffers. Ranges were checked when the file was parsed; nothing here trusts `min` and `max`.

use super::buffers::Buffers;
use super::fault::{Checked, Fault};
use super::limits;
use super::model::{Accessor, Component, Kind, Model};

/// Which elements of an accessor are wanted.
#[derive(Clone, Copy, Debug)]
pub(super) enum Rows<'a> {
    All,
    /// These, each below the accessor's count.
    Some(&'a [u32]),
}

impl Rows<'_> {
    const fn count(self, all: usize) -> usize {
        match self {
            Self::All => all,
            Self::Some(chosen) => chosen.len(),
        }
    }

    /// The element's number in the accessor.
    fn number(self, at: usize) -> usize {
        match self {
            Self::All => at,
            Self::Some(chosen) => chosen.get(at).map_or(at, |&row| row as usize),
        }
    }
}

/// Reads accessors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reader<'a> {
    pub model: &'a Model,
    pub buffers: &'a Buffers,
}

impl<'a> Reader<'a> {
    /// An accessor, if it has this shape and its bytes are there.
    fn expect(&self, accessor: usize, kinds: &[Kind], usage: &str) -> Checked<&'a Accessor> {
        let accessor = &self.model.accessors[accessor];
        if kinds.contains(&accessor.kind) {
            let sparse = accessor.sparse.as_ref().map(|sparse| [sparse.index_view, sparse.value_view]);
            for view in accessor.view.into_iter().chain(sparse.into_iter().flatten()) {
                self.buffers.check(&self.model.views[view])?;
            }
            if accessor.view.is_none() && accessor.count > self.buffers.bytes().max(limits::ZERO_FILLED) {
                let message =
                    format!("{} elements without a buffer view are more than the file has bytes", accessor.count);
                return Err(Fault::broken(format!("{}/count", accessor.place), message));
            }
            return Ok(accessor);
        }
        let wanted: Vec<_> = kinds.iter().map(|kind| kind.word()).collect();
        let message = format!("{usage} needs {}, found {}", wanted.join(" or "), accessor.kind.word());
        Err(Fault::broken(format!("{}/type", accessor.place), message))
    }

    /// How many positions an accessor holds, each with bytes behind it.
    pub(super) fn position_count(&self, accessor: usize) -> Checked<usize> {
        Ok(self.expect(accessor, &[Kind::Vec3], "POSITION")?.count)
    }

    /// Rows of `N` numbers.
    fn rows<const N: usize>(&self, accessor: &Accessor, rows: Rows<'_>, normalized: bool) -> Vec<[f32; N]> {
        let size = accessor.kind.size(accessor.component);
        if let (true, Rows::Some(chosen)) = (accessor.sparse.is_some(), rows) {
            let all: Vec<[f32; N]> = self.rows(accessor, Rows::All, normalized);
            return chosen.iter().map(|&row| all.get(row as usize).copied().unwrap_or([0.0; N])).collect();
        }
        let mut found = match accessor.view {
            Some(view) => {
                let view = &self.model.views[view];
                let bytes = self.buffers.view(view).get(accessor.offset..).unwrap_or(&[]);
                let layout = Layout { bytes, stride: view.stride.unwrap_or(size), component: accessor.component };
                layout.decode(rows, accessor.count, normalized)
            }
            None => vec![[0.0; N]; rows.count(accessor.count)],
        };
        if let Some(sparse) = &accessor.sparse {
            let bytes = self.buffers.view(&self.model.views[sparse.value_view]);
            let bytes = bytes.get(sparse.value_offset..).unwrap_or(&[]);
            let layout = Layout { bytes, stride: size, component: accessor.component };
            let values = layout.decode(Rows::All, sparse.count, normalized);
            for (index, value) in self.sparse_indices(accessor).zip(values) {
                if let Some(row) = found.get_mut(index) {
                    *row = value;
                }
            }
        }
        found
    }

    fn sparse_indices(&self, accessor: &Accessor) -> impl Iterator<Item = usize> + use<'a> {
        let bytes = accessor.sparse.as_ref().map(|sparse| {
            let bytes = self.buffers.view(&self.model.views[sparse.index_view]);
            (bytes.get(sparse.index_offset..).unwrap_or(&[]), sparse.index_component, sparse.count)
        });
        let (bytes, component, count) = bytes.unwrap_or((&[], Component::U8, 0));
        integers(bytes, component.size(), count, component).map(|index| index as usize)
    }

    /// Checks what only the data can tell about the sparse part.
    fn check_sparse(&self, accessor: &Accessor) -> Checked<()> {
        match self.sparse_indices(accessor).find(|&index| index >= accessor.count) {
            None => Ok(()),
            Some(index) => Err(Fault::broken(
                format!("{}/sparse/indices", accessor.place),
                format!("element {index} is replaced, but there are only {}", accessor.count),
            )),
        }
    }

    /// Rows of `N` numbers from an accessor of that shape.
    pub(super) fn floats<const N: usize>(
        &self,
        accessor: usize,
        rows: Rows<'_>,
        usage: &str,
    ) -> Checked<Vec<[f32; N]>> {
        let kind = match N {
            1 => Kind::Scalar,
            2 => Kind::Vec2,
            3 => Kind::Vec3,
            _ => Kind::Vec4,
        };
        let accessor = self.expect(accessor, &[kind], usage)?;
        self.check_sparse(accessor)?;
        Ok(self.rows(accessor, rows, accessor.normalized))
    }

    /// As [`Reader::floats`], but every number must be finite.
    pub(super) fn finite<const N: usize>(
        &self,
        accessor: usize,
        rows: Rows<'_>,
        usage: &str,
    ) -> Checked<Vec<[f32; N]>> {
        let found = self.floats(accessor, rows, usage)?;
        match found.iter().position(|row: &[f32; N]| row.iter().any(|value| !value.is_finite())) {
            None => Ok(found),
            Some(at) => {
                let place = &self.model.accessors[accessor].place;
                let message = format!("element {} of {usage} is not finite: {:?}", rows.number(at), found[at]);
                Err(Fault::broken(place, message))
            }
        }
    }

    /// Skin weights: integers are always normalised.
    pub(super) fn weights(&self, accessor: usize, rows: Rows<'_>) -> Checked<Vec<[f32; 4]>> {
        let accessor = self.expect(accessor, &[Kind::Vec4], "WEIGHTS")?;
        self.check_sparse(accessor)?;
        Ok(self.rows(accessor, rows, true))
    }

    /// Colours, with alpha 1 where the accessor has none: integers are always normalised.
    pub(super) fn colors(&self, accessor: usize, rows: Rows<'_>) -> Checked<Vec<[f32; 4]>> {
        let accessor = self.expect(accessor, &[Kind::Vec3, Kind::Vec4], "COLOR_0")?;
        self.check_sparse(accessor)?;
        Ok(if accessor.kind == Kind::Vec4 {
            self.rows(accessor, rows, true)
        } else {
            self.rows::<3>(accessor, rows, true).into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect()
        })
    }

    /// Joint numbers.
    pub(super) fn joints(&self, accessor: usize, rows: Rows<'_>) -> Checked<Vec<[u32; 4]>> {
        let accessor = self.expect(accessor, &[Kind::Vec4], "JOINTS")?;
        if !matches!(accessor.component, Component::U8 | Component::U16) {
            let message = "JOINTS must be unsigned bytes or shorts";
            return Err(Fault::broken(format!("{}/componentType", accessor.place), message));
        }
        self.check_sparse(accessor)?;
        // Both types are exact in 32-bit floats.
        let found: Vec<[f32; 4]> = self.rows(accessor, rows, false);
        Ok(found.into_iter().map(|row| row.map(|joint| joint as u32)).collect())
    }

    /// Vertex numbers, each below `limit`.
    pub(super) fn indices(&self, accessor: usize, limit: usize) -> Checked<Vec<u32>> {
        let accessor = self.expect(accessor, &[Kind::Scalar], "indices")?;
        if !matches!(accessor.component, Component::U8 | Component::U16 | Component::U32) {
            let message = "indices must be unsigned integers";
            return Err(Fault::broken(format!("{}/componentType", accessor.place), message));
        }
        self.check_sparse(accessor)?;
        let mut indices = match accessor.view {
            Some(view) => {
                let view = &self.model.views[view];
                let bytes = self.buffers.view(view).get(accessor.offset..).unwrap_or(&[]);
                let stride = view.stride.unwrap_or(accessor.component.size());
                integers(bytes, stride, accessor.count, accessor.component).collect()
            }
            None => vec![0; accessor.count],
        };
        if let Some(sparse) = &accessor.sparse {
            let bytes = self.buffers.view(&self.model.views[sparse.value_view]);
            let bytes = bytes.get(sparse.value_offset..).unwrap_or(&[]);
            let values = integers(bytes, accessor.component.size(), sparse.count, accessor.component);
            for (at, value) in self.sparse_indices(accessor).zip(values) {
                if let Some(index) = indices.get_mut(at) {
                    *index = value;
                }
            }
        }
        match indices.iter().position(|&index| index as usize >= limit) {
            None => Ok(indices),
            Some(at) => Err(Fault::broken(
                &accessor.place,
                format!("element {at} is vertex {}, but there are only {limit}", indices[at]),
            )),
        }
    }

    /// The first so many matrices, column by column.
    pub(super) fn matrices(&self, accessor: usize, count: usize, usage: &str) -> Checked<Vec<[f32; 16]>> {
        let accessor = self.expect(accessor, &[Kind::Mat4], usage)?;
        if accessor.component != Component::F32 {
            let message = format!("{usage} must be 32-bit floats");
            return Err(Fault::broken(format!("{}/componentType", accessor.place), message));
        }
        self.check_sparse(accessor)?;
        let first: Vec<u32> = (0..u32::try_from(count).unwrap_or(u32::MAX)).collect();
        let rows = self.rows::<16>(accessor, Rows::Some(&first), false);
        match rows.iter().position(|row| row.iter().any(|value| !value.is_finite())) {
            None => Ok(rows),
            Some(row) => Err(Fault::broken(&accessor.place, format!("matrix {row} of {usage} is not finite"))),
        }
    }

    /// The numbers of an accessor of any vector shape, one after the other, with how many make an element.
    pub(super) fn flat(&self, accessor: usize, usage: &str) -> Checked<(Vec<f32>, usize)> {
        let shape = self.expect(accessor, &[Kind::Scalar, Kind::Vec3, Kind::Vec4], usage)?.kind;
        Ok(match shape {
            Kind::Scalar => (self.finite::<1>(accessor, Rows::All, usage)?.into_iter().flatten().collect(), 1),
            Kind::Vec3 => (self.finite::<3>(accessor, Rows::All, usage)?.into_iter().flatten().collect(), 3),
            _ => (self.finite::<4>(accessor, Rows::All, usage)?.into_iter().flatten().collect(), 4),
        })
    }
}

/// Elements in memory.
#[derive(Clone, Copy, Debug)]
struct Layout<'a> {
    bytes: &'a [u8],
    stride: usize,
    component: Component,
}

impl Layout<'_> {
    fn decode<const N: usize>(self, rows: Rows<'_>, count: usize, normalized: bool) -> Vec<[f32; N]> {
        // glTF 2.0 §3.11: f = max(c / (2ⁿ⁻¹ − 1), −1) for signed, c / (2ⁿ − 1) for unsigned integers.
        match (self.component, normalized) {
            (Component::F32, _) => self.spread(rows, count, f32::from_le_bytes),
            (Component::I8, false) => self.spread(rows, count, |b| f32::from(i8::from_le_bytes(b))),
            (Component::I8, true) => self.spread(rows, count, |b| (f32::from(i8::from_le_bytes(b)) / 127.0).max(-1.0)),
            (Component::U8, false) => self.spread(rows, count, |b| f32::from(u8::from_le_bytes(b))),
            (Component::U8, true) => self.spread(rows, count, |b| f32::from(u8::from_le_bytes(b)) / 255.0),
            (Component::I16, false) => self.spread(rows, count, |b| f32::from(i16::from_le_bytes(b))),
            (Component::I16, true) => {
                self.spread(rows, count, |b| (f32::from(i16::from_le_bytes(b)) / 32767.0).max(-1.0))
            }
            (Component::U16, false) => self.spread(rows, count, |b| f32::from(u16::from_le_bytes(b))),
            (Component::U16, true) => self.spread(rows, count, |b| f32::from(u16::from_le_bytes(b)) / 65535.0),
            (Component::U32, false) => self.spread(rows, count, |b| u32::from_le_bytes(b) as f32),
            (Component::U32, true) => {
                self.spread(rows, count, |b| (f64::from(u32::from_le_bytes(b)) / f64::from(u32::MAX)) as f32)
            }
        }
    }

    fn spread<const N: usize, const SIZE: usize>(
        self,
        rows: Rows<'_>,
        count: usize,
        convert: impl Fn([u8; SIZE]) -> f32,
    ) -> Vec<[f32; N]> {
        let row = |row: usize| {
            let element = self.bytes.get(row * self.stride..).unwrap_or(&[]);
            std::array::from_fn(|at| {
                element.get(at * SIZE..).and_then(|rest| rest.first_chunk()).map_or(0.0, |chunk| convert(*chunk))
            })
        };
        match rows {
            Rows::All => (0..count).map(row).collect(),
            Rows::Some(chosen) => chosen.iter().map(|&at| row(at as usize)).collect(),
        }
    }
}

fn integers(bytes: &[u8], stride: usize, count: usize, component: Component) -> impl Iterator<Item = u32> {
    (0..count).map(move |row| {
        let element = bytes.get(row * stride..).unwrap_or(&[]);
        match component {
            Component::U8 | Component::I8 => element.first().map_or(0, |&byte| u32::from(byte)),
            Component::U16 | Component::I16 => {
                element.first_chunk().map_or(0, |chunk| u32::from(u16::from_le_bytes(*chunk)))
            }
            Component::U32 | Component::F32 => element.first_chunk().map_or(0, |chunk| u32::from_le_bytes(*chunk)),
        }
    })
}
