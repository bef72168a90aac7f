//! Files from an enemy: each is refused with its code, or read, at a cost in proportion to its size.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use aam::document::Encoding;
use aam::{ReadOptions, WriteOptions, read, write};

/// A character with a list of every kind, each with one element.
const WHOLE: &str = "\
AAM_CHARACTER
MATERIALS
MatCount: 1
Mat# 0
{
	Name: both
	Class: Multi
	NSubs: 1
	Sub 0
	{
		Name: a
		Class: Standard
		Am: 0 0 0
		Di: 0 0 0
		Sp: 0 0 0
		Tr: 0
		Sh: 0
		Tx: N
		TS: N
	}
}
ENDMATERIALS
GEOMETRY
NObj: 1
NFrames: 1
Animation_mode: Keyframe
Frame: 0
{
	Obj: 0 a
	Par: -1
	{
	Piv: 0 0 0 0 0 0 0
	Mir: 0
	TM: 1 0 0 0 1 0 0 0 1 0 0 0 1 1 1
	MatID: 0
	V_List: 1
		0 0 0
	SKIN: Y
		0 1 0 1.0
	C_List: 1
		1 1 1
	TV_List: 1
		0 0
	N_List: 1
		0 0 1
	I_List: 1 1
		NEWGROUP: 0
		I: 0 0 0 0
		NI: 0 0 0
		TI: 0 0 0
		ENDGROUP
	Anim_Ctrl: Y
		PsSam: 1
			0 0 0 0
		RtSam: 1
			0 0 0 1 0
		ScSam: 1
			0 0 0 0 1 1 1 1
	}
}
ENDGEOMETRY
PHYSICS
NBody: 1
Body: 0 a
{
	Mode: Dynamic
	SF: 0.5
	DF: 0.5
	Re: 0
	Ma: 1
	NPrim: 1
		Sphere: 0 0 0 1
	NConvex: 1
		Convex: 0
		{
		V_List: 1
			0 0 0
		I_List: 1
			I: 0 0 0
		}
}
ENDPHYSICS
";

fn code(source: &[u8]) -> &'static str {
    match read(source, &ReadOptions::default()) {
        Ok(_) => "",
        Err(error) => error.code,
    }
}

#[test]
fn no_count_is_believed() {
    let document = read(WHOLE.as_bytes(), &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert!(document.findings.is_empty(), "{:?}", document.findings);
    let mut counts = 0;
    for (start, line) in WHOLE.match_indices('\n').map(|(at, _)| at + 1).map(|start| (start, &WHOLE[start..])) {
        let line = line.lines().next().unwrap_or_default();
        let Some((tag, _)) = line.split_once(": 1") else { continue };
        let known = ["Count", "NSubs", "NObj", "NFrames", "_List", "NBody", "NPrim", "NConvex", "Sam"];
        if !known.iter().any(|known| tag.contains(known)) {
            continue;
        }
        counts += 1;
        let at = start + tag.len() + 2;
        for (huge, code_wanted) in [
            ("4000000000", "count/too-large"),
            ("18446744073709551615", "count/too-large"),
            ("99999999999999999999999999", "count/too-large"),
            ("-1", "syntax/expected"),
            ("nan", "syntax/expected"),
        ] {
            let source = [&WHOLE[..at], huge, &WHOLE[at + 1..]].concat();
            // Keys may run over as many frames as one can count; nothing is made for each.
            let wanted = if tag == "NFrames" && huge == "4000000000" { "" } else { code_wanted };
            assert_eq!(code(source.as_bytes()), wanted, "{line} with {huge}");
        }
    }
    assert_eq!(counts, 17, "every list of the file");
    // Counts inside a row.
    for (from, to) in [("I_List: 1 1\n\t\tNEW", "I_List: 1 4000000000\n\t\tNEW"), ("0 1 0 1.0", "0 4000000000 0 1.0")] {
        assert!(WHOLE.contains(from));
        assert_eq!(code(WHOLE.replacen(from, to, 1).as_bytes()), "count/too-large", "{to}");
    }
}

#[test]
fn no_index_is_believed() {
    for (from, what) in [
        ("I: 0 0 0 0", "I: # 0 0 0"),
        ("NI: 0 0 0", "NI: 0 # 0"),
        ("TI: 0 0 0", "TI: 0 0 #"),
        ("I: 0 0 0\n\t\t}", "I: 0 0 #\n\t\t}"),
        ("0 1 0 1.0", "# 1 0 1.0"),
    ] {
        assert!(WHOLE.contains(from), "{from}");
        for (index, wanted) in [
            ("1", "geometry/index"),
            ("-1", "geometry/index"),
            ("-2147483648", "geometry/index"),
            ("2147483647", "geometry/index"),
            ("4294967295", "geometry/index"),
            ("4294967296", "value/range"),
            ("9999999999999999999999", "value/range"),
            ("0.5", "syntax/expected"),
        ] {
            let source = WHOLE.replacen(from, &what.replace('#', index), 1);
            assert_eq!(code(source.as_bytes()), wanted, "{what} with {index}");
        }
    }
    let document = read(WHOLE.as_bytes(), &ReadOptions::default()).expect("readable").document;
    let binary = write(&document, &WriteOptions { encoding: Some(Encoding::Binary), ..WriteOptions::default() });
    let binary = binary.expect("writable");
    let at = binary.windows(3).position(|window| window == b"I: ").expect("a triangle") + 3;
    for index in [1, -1, i32::MIN, i32::MAX] {
        let mut source = binary.clone();
        source[at..at + 4].copy_from_slice(&index.to_le_bytes());
        assert_eq!(code(&source), "geometry/index", "{index}");
    }
}

/// A number that is none is pointed at, whatever list it stands in.
#[test]
fn every_number_that_is_none_is_pointed_at() {
    let mut numbers = 0;
    let mut at = 0;
    for word in WHOLE.split_inclusive([' ', '\t', '\n']) {
        let token = word.trim_end();
        if token.parse::<f32>().is_ok() {
            let source = [&WHOLE[..at], "x", &WHOLE[at + token.len()..]].concat();
            match read(source.as_bytes(), &ReadOptions::default()) {
                Ok(_) => panic!("accepted:\n{source}"),
                Err(error) => assert_eq!((error.code, error.offset), ("syntax/expected", at), "{error}"),
            }
            numbers += 1;
        }
        at += word.len();
    }
    assert!(numbers > 100, "{numbers}");
}

#[test]
fn nul_is_text_in_a_name_and_rubbish_elsewhere() {
    let name = WHOLE.replacen("Obj: 0 a", "Obj: 0 a\0b", 1);
    let document = read(name.as_bytes(), &ReadOptions::default()).expect("a name of any bytes").document;
    assert_eq!(document.objects()[0].name.bytes(), b"a\0b");
    for (from, to) in [("MatID: 0", "MatID: \0"), ("NObj: 1", "NObj: 1\0"), ("0 0 1\n", "0 \0 1\n")] {
        assert_eq!(code(WHOLE.replacen(from, to, 1).as_bytes()), "syntax/expected", "{to:?}");
    }
    assert_eq!(code(&[0; 4096]), "syntax/expected");
}

#[test]
fn a_large_file_cut_anywhere_is_refused_or_whole() {
    let mut vertices = String::new();
    for number in 0..20_000 {
        let _ = writeln!(vertices, "\t\t{number} {}.25 -{}e-3", number % 7, number % 1000);
    }
    let source = WHOLE
        .replacen("V_List: 1\n\t\t0 0 0\n\tSKIN: Y\n\t\t0 1 0 1.0", &format!("V_List: 20000\n{vertices}\tSKIN: N"), 1)
        .replacen("\tC_List: 1\n\t\t1 1 1\n", "", 1);
    let whole = read(source.as_bytes(), &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}")).document;
    let binary = WriteOptions { encoding: Some(Encoding::Binary), ..WriteOptions::default() };
    let binary = write(&whole, &binary).expect("writable");
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    for file in [source.as_bytes(), &binary] {
        // Behind ENDGEOMETRY a file without its PHYSICS is a document.
        let geometry = file.windows(11).position(|window| window == b"ENDGEOMETRY").expect("its end") + 11;
        for _ in 0..5_000 {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            let end = (state % file.len() as u64) as usize;
            match read(&file[..end], &ReadOptions::default()) {
                Ok(_) => assert!((geometry..geometry + 8).contains(&end) || end + 2 > file.len(), "cut at {end}"),
                Err(error) => assert!(error.offset <= end, "cut at {end}: {error}"),
            }
        }
    }
}

/// A file of many times the same text in one place.
fn many(before: &str, each: impl Fn(usize) -> String, after: &str) -> String {
    const SIZE: usize = 3_000_000;
    let mut text = String::from(before);
    let mut count = 0;
    while text.len() < SIZE {
        text.push_str(&each(count));
        count += 1;
    }
    text.push_str(after);
    text.replacen("@", &count.to_string(), 1)
}

/// Files that are as dense as can be in one kind of thing.
fn dense() -> Vec<(&'static str, String)> {
    let head = &WHOLE[..WHOLE.find("NObj: 1").expect("objects")];
    let object = "Obj: 0\nPar: 0\n{\nMatID: 0\nV_List: 0\n}\n";
    let before_list = |list: &str| WHOLE.split_at(WHOLE.find(list).expect("the list"));
    let empty = "MATERIALS\nMatCount: 0\nENDMATERIALS\nGEOMETRY\n";
    let lists =
        format!("{empty}NObj: 1\nNFrames: 1\nAnimation_mode: None\nFrame: 0\n{{\nObj: 0 a\nPar: -1\n{{\nMatID: 0\n");
    let end = "}\n}\nENDGEOMETRY\n";
    vec![
        (
            "materials",
            many(
                "MATERIALS\nMatCount: @\n",
                |_| "Mat# 0\n{\nName:\nClass:\nAm: 0 0 0\nDi: 0 0 0\nSp: 0 0 0\nTr: 0\nSh: 0\nTx: N\nTS: N\n}\n".into(),
                &format!("ENDMATERIALS\n{}", &empty[empty.find("GEOMETRY").expect("it")..])
                    .replace("GEOMETRY\n", "GEOMETRY\nNObj: 0\nNFrames: 0\nAnimation_mode: None\nENDGEOMETRY\n"),
            ),
        ),
        (
            "objects",
            many(
                &format!("{empty}NObj: @\nNFrames: 1\nAnimation_mode: None\nFrame: 0\n{{\n"),
                |_| object.into(),
                "}\nENDGEOMETRY\n",
            ),
        ),
        (
            "frames",
            many(
                &format!("{empty}NObj: 0\nNFrames: @\nAnimation_mode: Full\n"),
                |_| "Frame: 0\n{\n}\n".into(),
                "ENDGEOMETRY\n",
            ),
        ),
        ("vertices", many(&format!("{lists}V_List: @\n"), |_| "0 0 0\n".into(), end)),
        (
            "triangles",
            many(
                &format!("{lists}V_List: 1\n0 0 0\nTV_List: 0\nI_List: @ 1\nNEWGROUP: 0\n"),
                |_| "I:0 0 0 0\n".into(),
                &format!("ENDGROUP\n{end}"),
            ),
        ),
        (
            "groups",
            many(&format!("{lists}V_List: 0\nTV_List: 0\nI_List: 0 @\n"), |_| "NEWGROUP: 0\nENDGROUP\n".into(), end),
        ),
        ("tracks", {
            let (before, after) = before_list("PsSam: 1");
            let after = &after[after.find("\t}").expect("the object's end")..];
            many(before, |_| "PsSam: 0\n".into(), after)
        }),
        ("unknown tags", many(&lists, |at| format!("x{at}\n"), &format!("V_List: 0\n{end}"))),
        (
            "unknown tags between objects",
            many(
                &format!("{empty}NObj: @\nNFrames: 1\nAnimation_mode: None\nFrame: 0\n{{\n"),
                |_| format!("x\n{object}"),
                "}\nENDGEOMETRY\n",
            ),
        ),
        (
            "lines of one unknown tag",
            many(&format!("{lists}Unknown:\n"), |_| "0\n".into(), &format!("V_List: 0\n{end}")),
        ),
        ("empty lines", many(head, |_| "\r\n".into(), "x")),
        ("warnings", many(&format!("{lists}V_List: @\n"), |_| "nan nan nan\n".into(), end)),
        ("open braces", many(&format!("{lists}Unknown:\n"), |_| "{\n".into(), "")),
        ("one word", many("MATERIALS\nMatCount: ", |_| "1".into(), "")),
        (
            "one name",
            many(
                &format!("{empty}NObj: 1\nNFrames: 1\nAnimation_mode: None\nFrame: 0\n{{\nObj: 0 "),
                |_| "name ".into(),
                "\n",
            ),
        ),
    ]
}

/// Reads the file that the environment names, and says what memory that took beyond the file itself. Run by
/// [`memory_is_bounded_by_the_file`] as a process of its own.
#[test]
#[ignore = "run by another test"]
fn measure() {
    let Some(path) = std::env::var_os("AAM_HOSTILE_FILE") else { return };
    let bytes = std::fs::read(path).expect("a readable file");
    let peak = || {
        let status = std::fs::read_to_string("/proc/self/status").expect("a Linux system");
        let line = status.lines().find(|line| line.starts_with("VmHWM:")).expect("the peak").to_owned();
        line.split_ascii_whitespace().nth(1).and_then(|word| word.parse::<usize>().ok()).expect("a number")
    };
    let before = peak();
    let outcome = read(&bytes, &ReadOptions::default());
    let after = peak();
    let code = outcome.as_ref().map_or_else(|error| error.code, |_| "read");
    println!("measured {} {} {code}", 1024 * (after - before), bytes.len());
}

#[test]
fn memory_is_bounded_by_the_file() {
    /// An object without anything is 36 bytes of text and ten times as much in memory; while lists grow they are there
    /// twice.
    const MOST: f64 = 32.0;
    if !Path::new("/proc/self/status").exists() {
        println!("skipped: peak memory is read from /proc, which is not here");
        return;
    }
    let folder = std::env::temp_dir().join(format!("aam-hostile-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join("hostile.aam");
    for (name, text) in dense() {
        std::fs::write(&path, text).expect("written");
        let output = Command::new(std::env::current_exe().expect("this program"))
            .args(["--ignored", "--exact", "measure", "--nocapture"])
            .env("AAM_HOSTILE_FILE", &path)
            .output()
            .expect("this program starts");
        let text = String::from_utf8_lossy(&output.stdout);
        let words: Vec<&str> = text
            .lines()
            .find_map(|line| line.split_once("measured ").map(|(_, rest)| rest.split(' ').collect()))
            .unwrap_or_else(|| panic!("{name}: {text}{}", String::from_utf8_lossy(&output.stderr)));
        let [taken, size] = [words[0], words[1]].map(|word| word.parse::<f64>().expect("a number"));
        println!("{name}: {:.1} times the file ({})", taken / size, words[2]);
        assert!(taken <= MOST * size, "{name}: {taken} bytes for {size}");
    }
    std::fs::remove_dir_all(&folder).expect("removed");
}

/// Whatever is read is written again in a time in proportion to its size: nothing looks through a list for each element
/// of another. (A test that hangs is one that fails.)
#[test]
fn dense_files_are_checked_and_written_again() {
    for (name, text) in dense() {
        let Ok(outcome) = read(text.as_bytes(), &ReadOptions::default()) else { continue };
        let findings = aam::check(&outcome.document, Some((text.as_bytes(), &outcome.places)));
        let written =
            write(&outcome.document, &WriteOptions::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
        println!("{name}: {} findings, {} bytes", findings.len(), written.len());
    }
}

/// Two gigabytes without a line end.
#[test]
#[ignore = "takes 7 GB of memory and a while"]
fn a_line_of_two_gigabytes() {
    let count = 360_000_000_usize;
    let (before, after) = WHOLE.split_at(WHOLE.find("V_List: 1").expect("the list"));
    let after = &after[after.find("TV_List").expect("the next list")..];
    let mut text = before.replace('\n', " \n").into_bytes();
    text.extend_from_slice(format!("V_List: {count} ").as_bytes());
    for _ in 0..count {
        text.extend_from_slice(b"0 0 0 ");
    }
    assert!(text.len() > 2_000_000_000);
    let options =
        ReadOptions { limits: aam::Limits { vertices: u64::MAX, ..aam::Limits::default() }, ..ReadOptions::default() };
    let cut = read(&text, &options).expect_err("nothing follows");
    assert_eq!(cut.code, "syntax/expected");
    assert!(cut.excerpt.to_string().len() < 400, "the message shows a part of the line");
    text.push(b'\n');
    text.extend_from_slice(after.as_bytes());
    let outcome = read(&text, &options).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(outcome.document.objects()[0].vertices.len(), count);
}

/// A file is mapped where it can be, and read otherwise: with the same result.
#[test]
fn files_that_cannot_be_mapped_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.aam");
    std::fs::write(&path, b"").unwrap();
    let error = aam::read_file(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("MATERIALS"), "{error}");
    let error = aam::read_file(folder.path(), &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("folder"), "{error}");
    #[cfg(unix)]
    {
        let source =
            b"MATERIALS\nMatCount: 0\nENDMATERIALS\nGEOMETRY\nNObj: 0\nNFrames: 0\nAnimation_mode: None\nENDGEOMETRY\n";
        std::fs::write(&path, source).unwrap();
        let pipe = folder.path().join("pipe.aam");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let writer = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::write(pipe, source)
        });
        let piped = aam::read_file(&pipe, &ReadOptions::default()).unwrap();
        writer.join().unwrap().unwrap();
        assert!(piped == aam::read_file(&path, &ReadOptions::default()).unwrap());
    }
}
