//! Reading and writing against peers in the same run: the same grid as AAM (text and binary) and as OBJ (`tobj`), a bare
//! scan for line ends, a copy of the bytes, and several threads against one. Ratios are what counts; they are printed at the end.
//! On a busy machine the processor time of the calling thread says more than the time that passed. Linux tells it.

use std::alloc::{GlobalAlloc, Layout, System};
use std::fmt::Write as _;
use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use aam::document::{Encoding, Faces, Frame, Geometry, Group, Object, TexCounts, Triangle};
use aam::{Document, ReadOptions, WriteOptions, read, write};

/// Vertices along each side of the grid: 1 M vertices, 2 M triangles.
const SIDE: usize = 1000;
/// What is compared runs in turn, so that whatever else the machine does meanwhile meets all of them.
const ROUNDS: usize = 9;

/// The system's allocator, with a count of the bytes in use and of the most there were.
struct Counting;

static IN_USE: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

impl Counting {
    fn add(bytes: usize) {
        MOST.fetch_max(IN_USE.fetch_add(bytes, Ordering::Relaxed) + bytes, Ordering::Relaxed);
    }
}

#[expect(unsafe_code, reason = "an allocator is unsafe to write; this one hands every call on as it is")]
// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        Self::add(layout.size());
        // SAFETY: the caller's promises are those that the system's allocator asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        Self::add(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        Self::add(size);
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The most bytes in use while something is made, and the bytes in use by what was made.
fn memory<T>(make: impl FnOnce() -> T) -> (usize, usize) {
    let before = IN_USE.load(Ordering::Relaxed);
    MOST.store(before, Ordering::Relaxed);
    let made = make();
    let (most, after) = (MOST.load(Ordering::Relaxed), IN_USE.load(Ordering::Relaxed));
    drop(made);
    (most - before, after - before)
}

/// A height field with one texture coordinate for each vertex. With `digits` the decimals are those that exporters write, else any
/// `f32`.
fn grid(digits: Option<i32>) -> Document {
    let rounded = |value: f64| match digits {
        Some(digits) => ((value * 10f64.powi(digits)).round() / 10f64.powi(digits)) as f32,
        None => value as f32,
    };
    let at = |i: usize| i as f64 / (SIDE - 1) as f64;
    let mut object = Object { name: "grid".into(), parent: -1, material: -1, ..Object::default() };
    let mut faces = Faces { tex_counts: TexCounts::Uniform(1), ..Faces::default() };
    for y in 0..SIDE {
        for x in 0..SIDE {
            let (u, v) = (at(x), at(y));
            let height = (u * 17.0).sin() * (v * 13.0).cos();
            object.vertices.push([rounded(u * 100.0), rounded(v * 100.0), rounded(height)]);
            faces.tex_coords.push([rounded(u), rounded(v)]);
        }
    }
    for y in 0..SIDE - 1 {
        for x in 0..SIDE - 1 {
            let a = (y * SIDE + x) as u32;
            let (b, c, d) = (a + 1, a + SIDE as u32, a + SIDE as u32 + 1);
            for vertices in [[a, b, d], [a, d, c]] {
                faces.triangles.push(Triangle { vertices, smoothing: 1 });
                faces.tex_indices.push(vertices);
            }
        }
    }
    faces.groups.push(Group { id: 0, triangles: faces.triangles.len() });
    object.faces = Some(faces);
    let frames = vec![Frame { objects: vec![object], ..Frame::default() }];
    Document {
        geometry: Geometry { smoothing_groups: true, animation_frames: 1, frames, ..Geometry::default() },
        ..Document::default()
    }
}

/// The same as an OBJ.
fn obj(document: &Document) -> String {
    let object = &document.objects()[0];
    let faces = object.faces.as_ref().expect("the grid has faces");
    let mut text = String::from("o grid\n");
    for [x, y, z] in &object.vertices {
        writeln!(text, "v {x:.4} {y:.4} {z:.4}").expect("memory");
    }
    for [u, v] in &faces.tex_coords {
        writeln!(text, "vt {u:.4} {v:.4}").expect("memory");
    }
    text.push_str("s 1\n");
    for triangle in &faces.triangles {
        let [a, b, c] = triangle.vertices.map(|index| index + 1);
        writeln!(text, "f {a}/{a} {b}/{b} {c}/{c}").expect("memory");
    }
    text
}

/// Text without the blanks at the starts of lines, as the OBJ has none.
fn unindented(bytes: &[u8]) -> Vec<u8> {
    bytes.split_inclusive(|&byte| byte == b'\n').flat_map(|line| line.trim_ascii_start()).copied().collect()
}

/// Something to be timed, and the bytes it reads or writes.
struct Task<'a> {
    name: &'static str,
    bytes: usize,
    run: Box<dyn FnMut() -> Taken + 'a>,
    taken: Vec<Taken>,
}

/// The time that passed, and the processor time of the calling thread.
#[derive(Clone, Copy)]
struct Taken {
    passed: Duration,
    processor: Duration,
}

/// Zero where the system does not tell.
fn processor_time() -> Duration {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    Duration::from_nanos(text.split(' ').next().and_then(|first| first.parse().ok()).unwrap_or(0))
}

impl<'a> Task<'a> {
    /// What is made is dropped outside the time that is taken.
    fn new<T: 'a>(name: &'static str, bytes: usize, mut make: impl FnMut() -> T + 'a) -> Self {
        let run = move || {
            let (processor, start) = (processor_time(), Instant::now());
            let made = black_box(make());
            let taken = Taken { passed: start.elapsed(), processor: processor_time().saturating_sub(processor) };
            drop(made);
            taken
        };
        Self { name, bytes, run: Box::new(run), taken: Vec::new() }
    }
}

fn main() {
    let (document, precise) = (grid(Some(4)), grid(None));
    let fixed = WriteOptions { digits: Some(4), ..WriteOptions::default() };
    let text = unindented(&write(&document, &fixed).expect("writable"));
    let shortest = write(&document, &WriteOptions::default()).expect("writable");
    let precise_text = write(&precise, &WriteOptions::default()).expect("writable");
    let binary_options = WriteOptions { encoding: Some(Encoding::Binary), ..WriteOptions::default() };
    let binary = write(&document, &binary_options).expect("writable");
    let obj = obj(&document);

    let reading = |bytes: &[u8], threads: usize| {
        read(black_box(bytes), &ReadOptions { threads, ..ReadOptions::default() }).expect("readable")
    };
    let writing = |document: &Document, options: &WriteOptions| write(black_box(document), options).expect("writable");
    let text_options = WriteOptions::default();
    let mut tasks = [
        Task::new("read text", text.len(), || reading(&text, 1)),
        Task::new("read text, 2 threads", text.len(), || reading(&text, 2)),
        Task::new("read OBJ (tobj)", obj.len(), || {
            let options = tobj::LoadOptions { triangulate: true, single_index: false, ..tobj::LoadOptions::default() };
            tobj::load_obj_buf(&mut black_box(obj.as_bytes()), &options, |_| Ok((Vec::new(), Default::default())))
                .expect("readable")
        }),
        Task::new("line scan (memchr)", text.len(), || memchr::memchr_iter(b'\n', black_box(&text)).count()),
        Task::new("write text", shortest.len(), || writing(&document, &text_options)),
        Task::new("read what was written", shortest.len(), || reading(&shortest, 1)),
        Task::new("write text, any f32", precise_text.len(), || writing(&precise, &text_options)),
        Task::new("read text, any f32", precise_text.len(), || reading(&precise_text, 1)),
        Task::new("read binary", binary.len(), || reading(&binary, 1)),
        Task::new("copy of the binary", binary.len(), || black_box(&binary).to_vec()),
        Task::new("write binary", binary.len(), || writing(&document, &binary_options)),
    ];
    for round in 0..=ROUNDS {
        for task in &mut tasks {
            let taken = (task.run)();
            // The first round warms up.
            if round > 0 {
                task.taken.push(taken);
            }
        }
    }

    println!("{} vertices, {} triangles, {ROUNDS} rounds", SIDE * SIDE, 2 * (SIDE - 1) * (SIDE - 1));
    println!("{:<24} {:>10} {:>10} {:>10} {:>10}", "", "median ms", "best ms", "best MB/s", "cpu ms");
    let times = |task: &Task<'_>| {
        let mut passed: Vec<f64> = task.taken.iter().map(|taken| taken.passed.as_secs_f64()).collect();
        passed.sort_by(f64::total_cmp);
        let processor = task.taken.iter().map(|taken| taken.processor.as_secs_f64()).fold(f64::INFINITY, f64::min);
        [passed[ROUNDS / 2], passed[0], processor]
    };
    for task in &tasks {
        let [median, best, processor] = times(task);
        let speed = task.bytes as f64 / 1e6 / best;
        let (median, best, processor) = (median * 1e3, best * 1e3, processor * 1e3);
        println!("{:<24} {median:>10.1} {best:>10.1} {speed:>10.0} {processor:>10.1}", task.name);
    }
    println!("{:<44} {:>8} {:>8} {:>8}", "ratio of times", "medians", "bests", "cpu");
    for (above, below) in [
        ("read OBJ (tobj)", "read text"),
        ("line scan (memchr)", "read text"),
        ("read text", "read text, 2 threads"),
        ("copy of the binary", "read binary"),
        ("read what was written", "write text"),
        ("read text, any f32", "write text, any f32"),
    ] {
        let of = |name: &str| times(tasks.iter().find(|task| task.name == name).expect("a task"));
        let ([a, b, c], [d, e, f]) = (of(above), of(below));
        println!("{:<44} {:>8.2} {:>8.2} {:>8.2}", format!("{above} / {below}"), a / d, b / e, c / f);
    }
    for (name, bytes, threads) in [("text", &text, 1), ("text, 2 threads", &text, 2), ("binary", &binary, 1)] {
        let (most, document) = memory(|| reading(bytes, threads));
        let ratio = most as f64 / document as f64;
        println!("memory, {name}: at most {most} bytes for a document of {document}: {ratio:.3}");
    }
}
