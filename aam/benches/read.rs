//! Reading and writing against peers in the same run: the same grid as AAM (text and binary) and as OBJ (`tobj`), a bare
//! scan for line ends, a copy of the bytes, and several threads against one. Ratios are what counts; they are printed at the end.
//! On a busy machine the processor time of the calling thread says more than the time that passed. Linux tells it.
//!
//! Words choose the tasks whose names they are part of. `ROUNDS` says how often each runs, 9 times if not. `FAST_OBJ` may name a
//! program that reads the OBJ of its first argument and prints the milliseconds that passed and those of the processor; one of a
//! few lines is in `docs/techniques/reading.md`.

mod grid;

use std::alloc::{GlobalAlloc, Layout, System};
use std::hint::black_box;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use aam::document::Encoding;
use aam::{Document, ReadOptions, WriteOptions, read, read_file, write};

use grid::{grid, obj, unindented};

/// Vertices along each side of the grid: 1 M vertices, 2 M triangles.
const SIDE: usize = 1000;

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

#[cfg(target_os = "linux")]
fn processor_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::try_from(time).unwrap_or_default()
}

/// Not told here.
#[cfg(not(target_os = "linux"))]
fn processor_time() -> Duration {
    Duration::ZERO
}

/// What a program says of the time that it took to read a file.
fn told_by(program: &str, path: &Path) -> Taken {
    let output = Command::new(program).arg(path).output().expect("FAST_OBJ names a program that runs");
    let text = String::from_utf8_lossy(&output.stdout);
    let mut times = text.split_whitespace().map(|word| Duration::from_secs_f64(word.parse::<f64>().expect("ms") / 1e3));
    let mut time = || times.next().expect("FAST_OBJ prints two times");
    Taken { passed: time(), processor: time() }
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
    let (document, precise) = (grid(SIDE, Some(4)), grid(SIDE, None));
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
    let folder = tempfile::tempdir().expect("a folder for the benchmark");
    let [text_path, obj_path] = ["grid.aam", "grid.obj"].map(|name| folder.path().join(name));
    std::fs::write(&text_path, &text).expect("the text is written");
    std::fs::write(&obj_path, &obj).expect("the OBJ is written");
    let mut tasks = vec![
        Task::new("read text", text.len(), || reading(&text, 1)),
        Task::new("read text, 2 threads", text.len(), || reading(&text, 2)),
        Task::new("read text file", text.len(), || {
            read_file(black_box(&text_path), &ReadOptions { threads: 1, ..ReadOptions::default() }).expect("readable")
        }),
        Task::new("line scan (memchr)", text.len(), || memchr::memchr_iter(b'\n', black_box(&text)).count()),
        Task::new("write text", shortest.len(), || writing(&document, &text_options)),
        Task::new("read what was written", shortest.len(), || reading(&shortest, 1)),
        Task::new("write text, any f32", precise_text.len(), || writing(&precise, &text_options)),
        Task::new("read text, any f32", precise_text.len(), || reading(&precise_text, 1)),
        Task::new("read binary", binary.len(), || reading(&binary, 1)),
        Task::new("copy of the binary", binary.len(), || black_box(&binary).to_vec()),
        Task::new("write binary", binary.len(), || writing(&document, &binary_options)),
        // Last, since others would pay for the memory that it leaves in pieces.
        Task::new("read OBJ (tobj)", obj.len(), || {
            let options = tobj::LoadOptions { triangulate: true, single_index: false, ..tobj::LoadOptions::default() };
            tobj::load_obj_buf(&mut black_box(obj.as_bytes()), &options, |_| Ok((Vec::new(), Default::default())))
                .expect("readable")
        }),
    ];
    if let Ok(program) = std::env::var("FAST_OBJ") {
        let run = Box::new(move || told_by(&program, &obj_path));
        tasks.push(Task { name: "read OBJ file (fast_obj)", bytes: obj.len(), run, taken: Vec::new() });
    }
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    tasks.retain(|task| words.is_empty() || words.iter().any(|word| task.name.contains(word.as_str())));
    let rounds = std::env::var("ROUNDS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(9);
    // What is compared runs in turn, so that whatever else the machine does meanwhile meets all of them.
    for round in 0..=rounds {
        for task in &mut tasks {
            let taken = (task.run)();
            // The first round warms up.
            if round > 0 {
                task.taken.push(taken);
            }
        }
    }

    println!("{} vertices, {} triangles, {rounds} rounds", SIDE * SIDE, 2 * (SIDE - 1) * (SIDE - 1));
    println!("{:<26} {:>10} {:>10} {:>10} {:>10}", "", "median ms", "best ms", "best MB/s", "cpu ms");
    let times = |task: &Task<'_>| {
        let mut passed: Vec<f64> = task.taken.iter().map(|taken| taken.passed.as_secs_f64()).collect();
        passed.sort_by(f64::total_cmp);
        let processor = task.taken.iter().map(|taken| taken.processor.as_secs_f64()).fold(f64::INFINITY, f64::min);
        [passed[rounds / 2], passed[0], processor]
    };
    for task in &tasks {
        let [median, best, processor] = times(task);
        let speed = task.bytes as f64 / 1e6 / best;
        let (median, best, processor) = (median * 1e3, best * 1e3, processor * 1e3);
        println!("{:<26} {median:>10.1} {best:>10.1} {speed:>10.0} {processor:>10.1}", task.name);
    }
    println!("{:<44} {:>8} {:>8} {:>8}", "ratio of times", "medians", "bests", "cpu");
    for (above, below) in [
        ("read OBJ (tobj)", "read text"),
        ("line scan (memchr)", "read text"),
        ("read text", "read text, 2 threads"),
        ("read text file", "read OBJ file (fast_obj)"),
        ("copy of the binary", "read binary"),
        ("read what was written", "write text"),
        ("read text, any f32", "write text, any f32"),
    ] {
        let of = |name: &str| tasks.iter().find(|task| task.name == name).map(times);
        let (Some([a, b, c]), Some([d, e, f])) = (of(above), of(below)) else { continue };
        println!("{:<44} {:>8.2} {:>8.2} {:>8.2}", format!("{above} / {below}"), a / d, b / e, c / f);
    }
    for (name, bytes, threads) in [("text", &text, 1), ("text, 2 threads", &text, 2), ("binary", &binary, 1)] {
        let (most, document) = memory(|| reading(bytes, threads));
        let ratio = most as f64 / document as f64;
        println!("memory, {name}: at most {most} bytes for a document of {document}: {ratio:.3}");
    }
}
