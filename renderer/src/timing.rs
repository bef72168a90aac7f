//! GPU time by pass, through timestamp queries.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use crate::{Gpu, PassTime};

/// The most timestamps in a frame.
const MAX_STAMPS: u32 = 256;

/// Those that are left for the picture.
const PICTURE_STAMPS: u32 = 16;

/// Frames whose results may be under way at once.
const IN_FLIGHT: usize = 3;

const FREE: u8 = 0;
const WAITING: u8 = 1;
const READY: u8 = 2;
const FAILED: u8 = 3;

/// Reads timestamps some frames later, without making anyone wait.
#[derive(Debug)]
pub(crate) struct Timing {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    read_backs: Vec<ReadBack>,
    nanoseconds_a_tick: f64,
    latest: Option<Vec<PassTime>>,
}

#[derive(Debug)]
struct ReadBack {
    buffer: wgpu::Buffer,
    state: Arc<AtomicU8>,
    spans: Vec<Span>,
}

/// A pass and its first and last timestamp.
#[derive(Clone, Copy, Debug)]
struct Span {
    name: &'static str,
    first: u32,
    last: u32,
}

/// The timestamps of one frame while it is recorded.
#[derive(Debug, Default)]
pub(crate) struct Stamps {
    spans: Vec<Span>,
    used: u32,
}

impl Stamps {
    /// Reserves the first and last timestamp of a pass before the picture; `None` once there are too many.
    pub(crate) fn pass(&mut self, name: &'static str) -> Option<[u32; 2]> {
        if self.used + 2 + PICTURE_STAMPS > MAX_STAMPS {
            return None;
        }
        let first = self.used;
        self.used += 2;
        self.spans.push(Span { name, first, last: first + 1 });
        Some([first, first + 1])
    }

    /// Reserves the timestamps of a pass with named parts: one before each, and one after all.
    pub(crate) fn parts(&mut self, names: &[&'static str]) -> Vec<u32> {
        let first = self.used;
        self.used += names.len() as u32 + 1;
        self.spans.extend((first..).zip(names).map(|(stamp, name)| Span { name, first: stamp, last: stamp + 1 }));
        (first..self.used).collect()
    }
}

impl Timing {
    /// `None` where the device has no timestamps.
    pub(crate) fn new(gpu: &Gpu) -> Option<Self> {
        if !gpu.device().features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let buffer = |usage| {
            gpu.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: 8 * u64::from(MAX_STAMPS),
                usage,
                mapped_at_creation: false,
            })
        };
        let read_back = || ReadBack {
            buffer: buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
            state: Arc::new(AtomicU8::new(FREE)),
            spans: Vec::new(),
        };
        Some(Self {
            queries: gpu.device().create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: MAX_STAMPS,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            read_backs: (0..IN_FLIGHT).map(|_| read_back()).collect(),
            nanoseconds_a_tick: f64::from(gpu.queue().get_timestamp_period()),
            latest: None,
        })
    }

    /// The queries that stamps are written to.
    pub(crate) fn queries(&self) -> &wgpu::QuerySet {
        &self.queries
    }

    /// Whether results of another frame can be received.
    pub(crate) fn has_room(&self) -> bool {
        self.read_backs.iter().any(|read_back| read_back.state.load(Ordering::Acquire) == FREE)
    }

    /// Records the copying of a frame's timestamps; returns where to, for [`Timing::submitted`].
    pub(crate) fn resolve(&mut self, encoder: &mut wgpu::CommandEncoder, stamps: Stamps) -> Option<usize> {
        let place = self.read_backs.iter().position(|read_back| read_back.state.load(Ordering::Acquire) == FREE)?;
        encoder.resolve_query_set(&self.queries, 0..stamps.used, &self.resolved, 0);
        let size = 8 * u64::from(stamps.used);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.read_backs[place].buffer, 0, size);
        self.read_backs[place].spans = stamps.spans;
        Some(place)
    }

    /// Asks for the results of a frame that was submitted.
    pub(crate) fn submitted(&mut self, place: usize) {
        let read_back = &self.read_backs[place];
        read_back.state.store(WAITING, Ordering::Release);
        let state = Arc::clone(&read_back.state);
        read_back.buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            state.store(if result.is_ok() { READY } else { FAILED }, Ordering::Release);
        });
    }

    /// Takes in what has arrived, and returns the times of the last frame that is known.
    pub(crate) fn collect(&mut self) -> Option<Vec<PassTime>> {
        for read_back in &mut self.read_backs {
            match read_back.state.load(Ordering::Acquire) {
                READY => {
                    let ticks: Option<Vec<u64>> = read_back
                        .buffer
                        .get_mapped_range(..)
                        .ok()
                        .map(|bytes| bytes.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect());
                    read_back.buffer.unmap();
                    read_back.state.store(FREE, Ordering::Release);
                    self.latest = ticks.map(|ticks| times(&ticks, &read_back.spans, self.nanoseconds_a_tick));
                }
                FAILED => read_back.state.store(FREE, Ordering::Release),
                _ => {}
            }
        }
        self.latest.clone()
    }
}

fn times(ticks: &[u64], spans: &[Span], nanoseconds_a_tick: f64) -> Vec<PassTime> {
    let mut times: Vec<PassTime> = Vec::new();
    for span in spans {
        let elapsed = ticks[span.last as usize].saturating_sub(ticks[span.first as usize]);
        let ms = elapsed as f64 * nanoseconds_a_tick * 1e-6;
        match times.iter_mut().find(|time| time.name == span.name) {
            Some(time) => time.ms += ms,
            None => times.push(PassTime { name: span.name, ms }),
        }
    }
    times
}
