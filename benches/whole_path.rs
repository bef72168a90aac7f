//! The command `aam` on a large file against `assimp`, if it is installed (Debian: assimp-utils), on the OBJ of the same geometry.
//! Each command runs by itself, in turn with the others; what is told of it are the least time that passed, the least processor
//! time, and the most memory that was resident.
//!
//! `ROUNDS` says how often each runs, 3 times if not.

#[path = "../aam/benches/grid/mod.rs"]
mod grid;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use aam::WriteOptions;

/// Vertices along each side of the grid: 1 M vertices, 2 M triangles.
const SIDE: usize = 1000;

/// A command, with names of files in the folder of the benchmark.
const AAM: [&str; 4] =
    ["aam info grid.aam", "aam convert grid.aam grid.glb", "aam convert grid.glb back.aam", "aam fmt --check grid.aam"];
const ASSIMP: [&str; 3] =
    ["assimp info grid.obj", "assimp export grid.obj assimp.glb -fglb2", "assimp export grid.obj assimp.obj"];

/// What a command took.
#[derive(Clone, Copy)]
struct Taken {
    passed: Duration,
    processor: Duration,
    /// Bytes.
    memory: u64,
}

fn main() {
    let folder = tempfile::tempdir().expect("a folder for the benchmark");
    let document = grid::grid(SIDE, Some(4));
    aam::write_file(&folder.path().join("grid.aam"), &document, &WriteOptions::default()).expect("writable");
    std::fs::write(folder.path().join("grid.obj"), grid::obj(&document)).expect("writable");
    drop(document);

    let installed = Command::new("assimp").arg("version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok();
    let mut rows: Vec<(&str, Vec<Taken>)> = AAM.map(|command| (command, Vec::new())).to_vec();
    if installed {
        rows.extend(ASSIMP.map(|command| (command, Vec::new())));
    } else {
        println!("assimp is not installed, so there is nothing to compare with");
    }
    let rounds = std::env::var("ROUNDS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(3);
    for _ in 0..rounds {
        for (command, taken) in &mut rows {
            taken.push(run(command, folder.path()));
        }
    }
    println!("{:<44} {:>10} {:>10} {:>12}", "", "s", "cpu s", "memory, MB");
    for (command, taken) in &rows {
        let Some(best) = best(taken) else { continue };
        let (passed, processor) = (best.passed.as_secs_f64(), best.processor.as_secs_f64());
        println!("{command:<44} {passed:>10.2} {processor:>10.2} {:>12}", best.memory / 1_000_000);
    }
    let of = |command: &str| rows.iter().find(|row| row.0 == command).and_then(|row| best(&row.1));
    println!("{:<74} {:>10} {:>10}", "ratio of times", "passed", "cpu");
    for (peer, own) in [(ASSIMP[0], AAM[0]), (ASSIMP[1], AAM[0]), (ASSIMP[1], AAM[1]), (ASSIMP[1], AAM[2])] {
        let (Some(peer_took), Some(took)) = (of(peer), of(own)) else { continue };
        let [passed, processor] = [|taken: Taken| taken.passed, |taken: Taken| taken.processor]
            .map(|time| time(peer_took).as_secs_f64() / time(took).as_secs_f64());
        println!("{:<74} {passed:>10.1} {processor:>10.1}", format!("{peer} / {own}"));
    }
}

/// The least times and the most memory.
fn best(taken: &[Taken]) -> Option<Taken> {
    taken.iter().copied().reduce(|a, b| Taken {
        passed: a.passed.min(b.passed),
        processor: a.processor.min(b.processor),
        memory: a.memory.max(b.memory),
    })
}

/// Runs a command in a folder. Files that it writes are there before it or not, as they are for anyone who repeats a command.
fn run(command: &str, folder: &Path) -> Taken {
    let mut words = command.split(' ');
    let program = match words.next() {
        Some("aam") => env!("CARGO_BIN_EXE_aam"),
        other => other.expect("a program"),
    };
    let mut command = Command::new(program);
    command.args(words).current_dir(folder).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let start = Instant::now();
    let child = command.spawn().expect("the program starts");
    let (succeeded, processor, memory) = wait(child);
    assert!(succeeded, "{command:?} fails");
    Taken { passed: start.elapsed(), processor, memory }
}

/// Waits for a process: whether it succeeded, its processor time, and the most memory that was resident.
#[cfg(target_os = "linux")]
fn wait(child: std::process::Child) -> (bool, Duration, u64) {
    let mut status = 0;
    let mut usage = std::mem::MaybeUninit::<libc::rusage>::zeroed();
    let id = libc::pid_t::try_from(child.id()).expect("the id of a process");
    #[expect(unsafe_code, reason = "the standard library waits without telling what a process used")]
    // SAFETY: both pointers are those of live variables of these types; zeros are a valid `rusage`.
    let (waited, usage) = unsafe { (libc::wait4(id, &raw mut status, 0, usage.as_mut_ptr()), usage.assume_init()) };
    assert_eq!(waited, id, "nobody else waits for it");
    let time = |time: libc::timeval| Duration::new(time.tv_sec as u64, time.tv_usec as u32 * 1000);
    (status == 0, time(usage.ru_utime) + time(usage.ru_stime), usage.ru_maxrss as u64 * 1024)
}

/// Only the first of these is told here.
#[cfg(not(target_os = "linux"))]
fn wait(mut child: std::process::Child) -> (bool, Duration, u64) {
    (child.wait().is_ok_and(|status| status.success()), Duration::ZERO, 0)
}
