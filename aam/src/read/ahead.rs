//! The rows of a large list on several threads.
//!
//! Where in its list a row belongs is known from counting lines, provided that every item takes the same number of them. So the
//! text is cut at line ends, lines are counted, and every thread fills its own part of the list. A part counts only if all before
//! it ended where it starts with as many items as there are lines for: so the result is that of one thread. At anything unusual
//! all threads stop, and the caller reads on from the place where one thread alone would have come to it.

use super::context::Context;
use super::short::text_start;

/// How many items one thread reads before others join in, which tells how long an item is. Twice as many is where two threads were
/// measured to be no slower than one.
const FIRST: usize = 16 << 10;

/// How many items a thread reads at least.
const LEAST: usize = 4 << 10;

/// The room for items of a list that are still to be read.
pub(crate) trait Target: Send + Sized {
    /// How many items there is room for.
    fn room(&self) -> usize;

    /// The room for the first so many items, and the rest.
    fn split(self, items: usize) -> (Self, Self);

    /// Reads items until the room is full or something unusual comes, white space before each skipped. Gives how many were
    /// read, and the place right behind the last of them.
    fn fill(self, bytes: &[u8], at: usize) -> (usize, usize);
}

/// As [`Target::fill`], on as many threads as the options say. Each item usually takes so many lines.
pub(crate) fn fill<T: Target>(cx: &Context<'_>, at: usize, target: T, lines: usize) -> (usize, usize) {
    let threads = cx.options.threads;
    if threads <= 1 || target.room() < 2 * FIRST {
        return target.fill(cx.bytes, at);
    }
    let (first, mut rest) = target.split(FIRST);
    let (mut items, mut end) = first.fill(cx.bytes, at);
    if items < FIRST {
        return (items, end);
    }
    while rest.room() > 0 {
        // Never more than have been read so far, lest a list that is interrupted often be read over and over.
        let wanted = rest.room().min(items);
        let bytes = (end - at).div_ceil(items).saturating_mul(wanted);
        let (next, others) = rest.split(wanted);
        let (read, behind) = together(cx.bytes, end, next, bytes, lines, threads.min(wanted / LEAST));
        (items, end, rest) = (items + read, behind, others);
        if read < wanted {
            break;
        }
    }
    (items, end)
}

/// Where a part of the text starts, and which item is its first.
#[derive(Clone, Copy)]
struct Start {
    at: usize,
    item: usize,
}

/// Fills all the room from about so many bytes.
fn together<T: Target>(
    bytes: &[u8],
    at: usize,
    target: T,
    length: usize,
    lines: usize,
    threads: usize,
) -> (usize, usize) {
    let room = target.room();
    let starts = starts(bytes, text_start(bytes, at), length, lines, threads, room);
    let mut parts = Vec::with_capacity(starts.len());
    let mut rest = target;
    for (place, start) in starts.iter().enumerate() {
        let end = starts.get(place + 1).map_or(room, |next| next.item);
        let (part, others) = rest.split(end - start.item);
        parts.push(part);
        rest = others;
    }
    let jobs = parts.into_iter().zip(&starts).map(|(part, start)| move || part.fill(bytes, start.at)).collect();
    let (mut items, mut end) = (0, at);
    for (place, (read, behind)) in side_by_side(jobs).into_iter().enumerate() {
        if text_start(bytes, end) != text_start(bytes, starts[place].at) || items != starts[place].item {
            break;
        }
        if read > 0 {
            (items, end) = (items + read, behind);
        }
    }
    (items, end)
}

/// Cuts about so many bytes into one part for each thread.
fn starts(bytes: &[u8], at: usize, length: usize, lines: usize, threads: usize, room: usize) -> Vec<Start> {
    let end = bytes.len().min(at.saturating_add(length));
    let mut cuts = vec![at];
    for part in 1..threads {
        // Not by a product, which a large number of threads would carry out of range.
        let guess = at + (end - at) / threads * part;
        match memchr::memchr(b'\n', &bytes[guess..end]) {
            Some(line_end) => cuts.push(guess + line_end + 1),
            None => break,
        }
    }
    let jobs =
        cuts.windows(2).map(|part| move || memchr::memchr_iter(b'\n', &bytes[part[0]..part[1]]).count()).collect();
    let mut starts = vec![Start { at, item: 0 }];
    let mut before = 0;
    for (count, &cut) in side_by_side(jobs).into_iter().zip(&cuts[1..]) {
        before += count;
        // An item starts only so many lines further on.
        let missing = before.next_multiple_of(lines) - before;
        let at = match missing {
            0 => cut,
            _ => match memchr::memchr_iter(b'\n', &bytes[cut..]).nth(missing - 1) {
                Some(line_end) => cut + line_end + 1,
                None => break,
            },
        };
        let item = (before + missing) / lines;
        if item >= room {
            break;
        }
        starts.push(Start { at, item });
    }
    starts
}

/// The results of all jobs, each on a thread of its own; only the first few where the system gives no more threads.
fn side_by_side<J: FnOnce() -> R + Send, R: Send>(jobs: Vec<J>) -> Vec<R> {
    let mut jobs = jobs.into_iter();
    let Some(first) = jobs.next() else { return Vec::new() };
    std::thread::scope(|scope| {
        let others: Vec<_> = jobs.map_while(|job| std::thread::Builder::new().spawn_scoped(scope, job).ok()).collect();
        let mut results = vec![first()];
        for other in others {
            match other.join() {
                Ok(result) => results.push(result),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        results
    })
}
