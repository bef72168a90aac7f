//! The binary data of a file: external, embedded and GLB buffers.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::ImportOptions;

use super::extensions;
use super::fault::{Checked, Fault};
use super::model::{Model, View};
use super::uri::{self, Source};

/// The bytes of every buffer.
#[derive(Debug)]
pub(super) struct Buffers {
    data: Vec<Data>,
}

#[derive(Debug)]
enum Data {
    There(Arc<Vec<u8>>, Range<usize>),
    /// Nothing says where the bytes are. That is no fault until something needs them.
    Absent {
        place: String,
        filled_by: Option<&'static str>,
    },
}

impl Buffers {
    /// Loads every buffer and checks that it is as long as the file says. `binary` is the GLB chunk in `file`.
    pub(super) fn load(
        model: &Model,
        file: &Arc<Vec<u8>>,
        binary: Option<Range<usize>>,
        folder: &Path,
        options: &ImportOptions,
    ) -> Checked<Self> {
        let mut known: BTreeMap<PathBuf, Arc<Vec<u8>>> = BTreeMap::new();
        let mut data = Vec::new();
        for (number, buffer) in model.buffers.iter().enumerate() {
            let place = format!("{}/uri", buffer.place);
            let (bytes, range) = match &buffer.uri {
                Some(uri) => {
                    let bytes = match uri::follow(uri, folder, options.allow_outside, &place)? {
                        Source::Data(bytes) => Arc::new(bytes),
                        Source::Missing { name } => {
                            return Err(Fault::broken(place, format!("the file {name:?} does not exist")));
                        }
                        Source::File { path, .. } => match known.get(&path) {
                            Some(bytes) => Arc::clone(bytes),
                            None => {
                                let bytes = Arc::new(aam::read_bytes(&path, &options.limits)?);
                                known.insert(path, Arc::clone(&bytes));
                                bytes
                            }
                        },
                    };
                    let range = 0..bytes.len();
                    (bytes, range)
                }
                None => match (&binary, number) {
                    (Some(range), 0) => (Arc::clone(file), range.clone()),
                    _ => {
                        data.push(Data::Absent { place, filled_by: buffer.filled_by });
                        continue;
                    }
                },
            };
            if buffer.length > range.len() {
                let message = format!("{} bytes are promised, but there are {}", buffer.length, range.len());
                return Err(Fault::broken(format!("{}/byteLength", buffer.place), message));
            }
            data.push(Data::There(bytes, range.start..range.start + buffer.length));
        }
        Ok(Self { data })
    }

    /// How many bytes all buffers have.
    pub(super) fn bytes(&self) -> usize {
        let lengths = self.data.iter().map(|data| match data {
            Data::There(_, range) => range.len(),
            Data::Absent { .. } => 0,
        });
        lengths.fold(0, usize::saturating_add)
    }

    /// Checks that the bytes of a view are there.
    pub(super) fn check(&self, view: &View) -> Checked<()> {
        match &self.data[view.buffer] {
            Data::There(..) => Ok(()),
            Data::Absent { filled_by: Some(extension), .. } => Err(extensions::meshopt(extension)),
            Data::Absent { place, filled_by: None } => {
                Err(Fault::broken(place, "is missing, and there is no binary chunk that could stand for it"))
            }
        }
    }

    /// The bytes of a view; its range was checked against the buffer's length. None where they are not there.
    pub(super) fn view(&self, view: &View) -> &[u8] {
        let Data::There(bytes, range) = &self.data[view.buffer] else { return &[] };
        bytes.get(range.clone()).and_then(|buffer| buffer.get(view.offset..view.offset + view.length)).unwrap_or(&[])
    }
}
