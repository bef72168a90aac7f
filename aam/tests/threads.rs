//! What is read does not depend on the number of threads: the same document bit for bit, the same warnings, the same error at
//! the same place.

use aam::document::Encoding;
use aam::{ReadOptions, WriteOptions, read, write};

/// Rows along each side of a grid that is large enough for several threads.
const SIDE: usize = 190;

/// Everything that reading gives, the document as bytes so that NaN equals itself.
fn outcome(bytes: &[u8], threads: usize) -> Result<String, String> {
    let options = ReadOptions { threads, ..ReadOptions::default() };
    match read(bytes, &options) {
        Ok(outcome) => {
            let binary = WriteOptions { encoding: Some(Encoding::Binary), ..WriteOptions::default() };
            let document = write(&outcome.document, &binary).map_err(|error| error.to_string())?;
            let places = (outcome.places, outcome.findings);
            Ok(format!("{places:?} {} {:x}", document.len(), fingerprint(&document)))
        }
        Err(error) => Err(format!("{error} {error:?}")),
    }
}

/// FNV-1a.
fn fingerprint(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[track_caller]
fn the_same(what: &str, bytes: &[u8]) -> Result<String, String> {
    let one = outcome(bytes, 1);
    for threads in [2, 5, usize::MAX] {
        assert!(one == outcome(bytes, threads), "{what}: {threads} threads");
    }
    one
}

/// How the rows of a grid are written.
struct Grid {
    indent: &'static str,
    line_end: &'static str,
    normals: bool,
    layers: fn(usize) -> usize,
    groups: usize,
    smoothing: i32,
}

const PLAIN: Grid = Grid { indent: "", line_end: "\n", normals: false, layers: |_| 1, groups: 1, smoothing: 1 };

impl Grid {
    fn lines(&self) -> Vec<String> {
        let value = |place: usize| (place as f64 * 0.377).sin() * 100.0;
        let vertices = SIDE * SIDE;
        let mut lines: Vec<String> = "MATERIALS\nMatCount: 0\nENDMATERIALS\nGEOMETRY SmGEnabled\nNObj: 1\nNFrames: 1\n\
            Animation_mode: None\nFrame: 0\n{\nObj: 0 grid\nPar: -1\n{\nMatID: -1"
            .lines()
            .map(str::to_owned)
            .collect();
        lines.push(format!("V_List: {vertices}"));
        let rows = |n: usize| (0..vertices).map(move |row| (0..n).map(move |column| value(row * 3 + column)));
        let text = |row: &mut dyn Iterator<Item = f64>| row.map(|v| format!("{v:.4}")).collect::<Vec<_>>().join(" ");
        lines.extend(rows(3).map(|mut row| text(&mut row)));
        lines.push(format!("TV_List: {vertices}"));
        lines.extend(rows(2).map(|mut row| text(&mut row)));
        if self.normals {
            lines.push(format!("N_List: {vertices}"));
            lines.extend(rows(3).map(|mut row| text(&mut row)));
        }
        let cells = (SIDE - 1) * (SIDE - 1);
        lines.push(format!("I_List: {} {}", 2 * cells, self.groups));
        for group in 0..self.groups {
            lines.push(format!("NEWGROUP: {group}"));
            for cell in cells * group / self.groups..cells * (group + 1) / self.groups {
                let a = cell / (SIDE - 1) * SIDE + cell % (SIDE - 1);
                let corners = [[a, a + 1, a + SIDE + 1], [a, a + SIDE + 1, a + SIDE]];
                for (half, [a, b, c]) in corners.into_iter().enumerate() {
                    lines.push(format!("I: {a} {b} {c} {}", self.smoothing));
                    if self.normals {
                        lines.push(format!("NI: {a} {b} {c}"));
                    }
                    for layer in 0..(self.layers)(2 * cell + half) {
                        let c = if layer == 0 { c } else { b };
                        lines.push(format!("TI: {a} {b} {c}"));
                    }
                }
            }
            lines.push("ENDGROUP".into());
        }
        lines.extend(["}", "}", "ENDGEOMETRY"].map(str::to_owned));
        lines
    }

    fn bytes(&self) -> Vec<u8> {
        self.join(&self.lines())
    }

    fn join(&self, lines: &[String]) -> Vec<u8> {
        lines.iter().flat_map(|line| [self.indent, line, self.line_end]).collect::<String>().into_bytes()
    }
}

#[test]
fn layouts() {
    let plain = the_same("plain", &PLAIN.bytes()).expect("readable");
    for (what, grid) in [
        ("indented", Grid { indent: "\t\t", ..PLAIN }),
        ("CR LF", Grid { line_end: "\r\n", ..PLAIN }),
        ("CR", Grid { line_end: "\r", ..PLAIN }),
        ("double line ends", Grid { line_end: "\n\n", ..PLAIN }),
        ("no line ends", Grid { line_end: " \t", ..PLAIN }),
    ] {
        match the_same(what, &grid.bytes()) {
            Ok(outcome) => assert_eq!(outcome.rsplit(' ').next(), plain.rsplit(' ').next(), "{what}"),
            Err(error) => assert!(what == "no line ends", "{what}: {error}"),
        }
    }
    for (what, grid) in [
        ("normals", Grid { normals: true, ..PLAIN }),
        ("no layer", Grid { layers: |_| 0, ..PLAIN }),
        ("four layers", Grid { layers: |_| 4, ..PLAIN }),
        ("layers and normals", Grid { layers: |_| 2, normals: true, ..PLAIN }),
        ("one triangle with another layer", Grid { layers: |n| 1 + usize::from(n == 50_001), ..PLAIN }),
        ("layers that change", Grid { layers: |n| n % 3, ..PLAIN }),
        ("layers that change late", Grid { layers: |n| 4 * n / 80_000, ..PLAIN }),
        ("many groups", Grid { groups: 3000, ..PLAIN }),
        ("few groups", Grid { groups: 3, ..PLAIN }),
        ("masks", Grid { smoothing: i32::MIN, ..PLAIN }),
    ] {
        the_same(what, &grid.bytes()).expect(what);
    }
}

#[test]
fn rows_that_are_not_one_to_a_line() {
    let lines = PLAIN.lines();
    let list = |tag: &str| lines.iter().position(|line| line.starts_with(tag)).expect("the list") + 1;
    for start in [list("V_List"), list("TV_List"), list("NEWGROUP")] {
        let triangles = lines[start].starts_with("I:");
        for place in [start + 4, start + 17_000, start + 24_001, start + 36_000] {
            let changed = |line: &str| {
                let mut lines = lines.clone();
                lines[place] = line.to_owned();
                PLAIN.join(&lines)
            };
            let old = &lines[place];
            let (first, others) = old.split_at(old.find(' ').expect("several numbers"));
            the_same("a row over two lines", &changed(&format!("{first}\n{others}"))).expect("readable");
            the_same("a blank line", &changed(&format!("\n{old}"))).expect("readable");
            let mut joined = lines.clone();
            let next = joined.remove(place + 1);
            joined[place] = format!("{old} {next}");
            the_same("two rows on a line", &PLAIN.join(&joined)).expect("readable");
            the_same("no number", &changed(&format!("{first} x{others}"))).expect_err("not a number");
            the_same("a row less", &changed("")).ok();
            the_same("a row more", &changed(&format!("{old}\n{old}"))).ok();
            if triangles {
                the_same("another mask", &changed(&format!("{old} ").replace(" 1 ", " -1 "))).ok();
                the_same("an index too large", &changed("I: 1 2 36100 1")).expect_err("out of range");
            } else {
                the_same("another form", &changed(&old.replacen(' ', "e-3 ", 1))).expect("readable");
                let odd = the_same("not finite", &changed(&format!("nan{others}"))).expect("readable");
                assert!(odd.contains("value/not-finite"));
            }
        }
    }
}

#[test]
fn damaged_files() {
    let whole = Grid { layers: |n| 1 + usize::from(n == 50_000), groups: 2, ..PLAIN }.bytes();
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut below = |limit: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % limit as u64) as usize
    };
    for _ in 0..40 {
        the_same("cut", &whole[..below(whole.len())]).expect_err("cut short");
        let mut damaged = whole.clone();
        for _ in 0..1 + below(3) {
            let place = below(damaged.len());
            damaged[place] = b" \n\r.-e0915TNI:x\0\xff"[below(17)];
        }
        the_same("damaged", &damaged).ok();
    }
}
