//! The command as a user meets it: verbs, messages, exit codes.

mod common;

use std::fs;

use common::{Folder, SQUARE, square};

// ---- help and arguments -----------------------------------------------------------------------------------------

#[test]
fn help_teaches_by_example() {
    let folder = Folder::new();
    let help = folder.aam(&["--help"]).succeeds();
    for verb in ["convert", "render", "view", "simulate", "info", "check", "fmt", "completions"] {
        assert!(help.out.contains(verb), "{verb} is listed");
        let help = folder.aam(&[verb, "--help"]).succeeds();
        assert!(help.out.contains(&format!("Examples:\n  aam {verb}")), "{}", help.out);
    }
    assert!(help.out.contains("Exit codes:"));
    assert_eq!(folder.aam(&[]).code, Some(2), "nothing to do is a usage error");
    assert!(folder.aam(&["--version"]).succeeds().out.starts_with("aam "));
}

#[test]
fn slips_are_guessed() {
    let folder = Folder::new();
    assert!(folder.aam(&["covnert", "x.gltf"]).fails(2).err.contains("convert"));
    assert!(folder.aam(&["convert", "x.gltf", "--hierachy"]).fails(2).err.contains("--hierarchy"));
    assert!(folder.aam(&["render", "x.aam", "-o", "x.png", "--engine", "refrence"]).fails(2).err.contains("reference"));
    // Values that are no fixed list.
    folder.write("a.aam", SQUARE);
    folder.copy_fixture("crate.glb");
    let render = ["render", "a.aam", "-o", "x.png", "--size", "8x8", "--engine", "reference"];
    folder.aam(&[&render[..], &["--view", "frnot"]].concat()).fails(2).says("did you mean front?");
    folder.aam(&[&render[..], &["--background", "grene"]].concat()).fails(2).says("did you mean green?");
    image::RgbImage::new(4, 4).save(folder.path("light.png")).expect("a picture");
    let convert = ["convert", "crate.glb", "--light-map", "Flor Tiles=light.png"];
    folder.aam(&convert).fails(2).says("did you mean \"Floor Tiles\"?");
    assert!(!folder.has("x.png") && !folder.has("crate.aam"));
}

#[test]
fn numbers_beyond_reason_are_refused() {
    let folder = Folder::new();
    folder.write("a.aam", SQUARE);
    let render = ["render", "a.aam", "-o", "a.png"];
    for (option, value) in [
        ("--size", "99999999999x1"),
        ("--size", "0x0"),
        ("--fov", "1e99"),
        ("--fov", "180"),
        ("--turntable", "99999999999"),
        ("--samples", "0"),
        ("--msaa", "3"),
        ("--camera-position", "1,2,inf"),
        ("--frame", "nan"),
        ("--fps", "0"),
        ("--max-file-size", "999999999999T"),
        ("--max-objects", "0"),
        ("--background", "#12345"),
    ] {
        let failure = folder.aam(&[&render[..], &[option, value]].concat()).fails(2);
        assert!(
            failure.err.contains(option) && failure.err.contains("expected")
                || failure.err.contains("possible")
                || failure.err.contains("not in"),
            "{option} {value}: {}",
            failure.err
        );
    }
    let convert = ["convert", "a.aam", "b.glb"];
    for (option, value) in [("--hulls", "0"), ("--digits", "300"), ("--normal-tolerance", "-1"), ("--tf", "1e9")] {
        folder.aam(&[&convert[..], &[option, value]].concat()).fails(2);
    }
    folder.aam(&["convert", "a.aam", "b.glb", "--mass", "3"]).fails(2).says("--physics");
    assert!(!folder.has("a.png") && !folder.has("b.glb"));
}

#[test]
fn what_is_not_there_is_said() {
    let folder = Folder::new();
    folder.write("model.aam", SQUARE);
    folder.write("empty.aam", "");
    fs::create_dir(folder.path("folder.aam")).expect("a folder");
    for verb in [&["info"][..], &["check"], &["fmt"], &["convert"], &["render", "-o", "x.png"], &["view"]] {
        let run = |file: &str| folder.aam(&[verb, &[file]].concat());
        run("nothing.aam").fails(2).says("nothing.aam").says("there is no such file");
        run("model.glb").fails(2).says("did you mean").says("model.aam");
        run("nowhere/model.aam").fails(2).says("the folder nowhere does not exist");
        if verb != ["view"] {
            run("folder.aam").fails(2).says("it is a folder");
        }
    }
    for verb in [&["info"][..], &["fmt"], &["convert", "--output", "x.glb"], &["render", "-o", "x.png"]] {
        folder.aam(&[verb, &["empty.aam"]].concat()).fails(2).says("empty.aam");
    }
    folder.aam(&["check", "empty.aam"]).fails(1);
    folder.write("notes.txt", "hello");
    folder.aam(&["info", "notes.txt"]).fails(2).says("notes.txt").says(".gltf");
    folder.aam(&["render", "notes.txt", "-o", "x.png"]).fails(2).says("notes.txt");
}

#[test]
fn quiet_and_colours_are_respected() {
    let folder = Folder::new();
    folder.write("a.aam", SQUARE);
    let plain = folder.aam(&["check", "a.aam"]).succeeds();
    assert!(!plain.out.contains('\u{1b}') && !plain.out.is_empty());
    let forced = folder.command(&["check", "a.aam"]).env("CLICOLOR_FORCE", "1").output().expect("aam runs");
    assert!(forced.stdout.contains(&0x1b), "colours can be forced");
    let silent = folder.aam(&["-q", "check", "a.aam"]).succeeds();
    assert!(silent.out.is_empty() && silent.err.is_empty());
    folder.aam(&["-q", "-v", "check", "a.aam"]).fails(2);
}

#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_is_no_error() {
    use std::process::Stdio;
    let folder = Folder::new();
    folder.write("a.aam", SQUARE);
    for arguments in [&["info", "a.aam"][..], &["check", "a.aam", "--json"], &["completions", "bash"]] {
        let mut child =
            folder.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("aam starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("aam ends");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && error.is_empty(), "{arguments:?}: {error}");
    }
}

#[test]
fn completions_know_the_verbs() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = folder.aam(&["completions", shell]).succeeds().out;
        assert!(script.contains("turntable") && script.contains("convert"), "{shell}");
    }
}

// ---- check and fmt ----------------------------------------------------------------------------------------------

#[test]
fn check_tells_clean_from_wrong() {
    let folder = Folder::new();
    folder.write("clean.aam", SQUARE);
    folder.write("broken.aam", &SQUARE.replace("NObj: 1", "NObj: one"));
    folder.write("wrong.aam", &SQUARE.replace("MatID: 0", "MatID: 7"));
    folder.write("odd.aam", &SQUARE.replace("Tr: 0.0", "Tr: 3.0"));
    folder.aam(&["check", "clean.aam"]).succeeds().says("no errors");
    let broken = folder.aam(&["check", "broken.aam"]).fails(1);
    broken.says("broken.aam:").says("error[").says("one").says("^");
    folder.aam(&["check", "wrong.aam"]).fails(1).says("object/material-missing");
    folder.aam(&["check", "odd.aam"]).succeeds().says("warning[material/transparency-range]");
    folder.aam(&["check", "odd.aam", "--strict"]).fails(1).says("error[material/transparency-range]");
    folder.aam(&["check", "odd.aam", "--strict", "--ignore", "material/transparency-range"]).succeeds();
    folder.aam(&["check", "odd.aam", "--ignore", "no/such"]).fails(2);
    folder.aam(&["check", "clean.aam", "nothing.aam", "wrong.aam"]).fails(2).says("clean.aam").says("wrong.aam");
    let model = folder.fixture("crate.gltf");
    folder.aam(&["check", &model]).fails(2).says("only AAM");
}

#[test]
fn check_prints_json() {
    let folder = Folder::new();
    folder.write("wrong.aam", &SQUARE.replace("MatID: 0", "MatID: 7"));
    folder.write("broken.aam", "MATERIALS\nMatCount: x\n");
    let json = folder.aam(&["check", "wrong.aam", "broken.aam", "--json"]).fails(1).json();
    assert_eq!(json[0]["file"], "wrong.aam");
    assert_eq!(json[0]["errors"], 1);
    let finding = json[0]["findings"].as_array().expect("a list").iter().find(|f| f["severity"] == "error");
    assert_eq!(finding.expect("an error")["code"], "object/material-missing");
    assert!(finding.expect("an error")["position"]["line"].as_u64() > Some(1));
    assert_eq!(json[1]["findings"][0]["position"]["line"], 2);
    assert_eq!(json[1]["findings"][0]["position"]["column"], 11);
}

#[test]
fn check_shows_the_line_of_each_finding() {
    let folder = Folder::new();
    folder.write("odd.aam", &SQUARE.replace("Tr: 0.0", "Tr: 3.0").replace("MatID: 0", "MatID: 7"));
    let shown = folder.aam(&["check", "odd.aam"]).fails(1);
    shown.says(
        "odd.aam:3:1: warning[material/transparency-range]: material 0 \"m\": Tr is 3, not from 0 to 1\n    | Mat# 0\n    | ^\n",
    );
    shown.says("    |  Obj: 0 square\n    |  ^\n");
    folder.write("slip.aam", &SQUARE.replace("MatID: 0", "MadID: 0"));
    let slip = folder.aam(&["check", "slip.aam"]).fails(1);
    slip.says("`MadID:` is unknown; did you mean `MatID:`").says("    |  MadID: 0\n    |  ^\n");
    slip.says("1 error, no warnings; nothing else could be checked");
    folder.aam(&["info", "slip.aam"]).fails(2).says("did you mean `MatID:`").says("Write the tag as the message shows");
}

#[test]
fn check_shows_what_is_asked_for_with_the_severity_that_is_asked_for() {
    let folder = Folder::new();
    folder.write("odd.aam", &SQUARE.replace("Tr: 0.0", "Tr: 3.0").replace("MatID: 0", "MatID: 7"));
    folder.write("broken.aam", "MATERIALS\nMatCount: x\n");
    let findings = |code: i32, options: &[&str]| -> Vec<String> {
        let json = folder.aam(&[&["check", "odd.aam", "--json"], options].concat()).ends_with(code).json();
        let list = json[0]["findings"].as_array().expect("a list").clone();
        list.iter().map(|f| format!("{} {}", f["severity"], f["code"]).replace('"', "")).collect()
    };
    let (tr, unused, missing) = ("material/transparency-range", "material/unused", "object/material-missing");
    let all = [format!("info {unused}"), format!("warning {tr}"), format!("error {missing}")];
    assert_eq!(findings(1, &[]), all);
    assert_eq!(findings(0, &["--only", "material"]), all[..2]);
    assert_eq!(findings(0, &["--only", &format!("{tr},{unused}"), "--ignore", unused]), all[1..2]);
    assert_eq!(findings(0, &["--ignore", missing]), all[..2]);
    assert_eq!(findings(0, &["--ignore", "material/*", "--info", "object"]), [format!("info {missing}")]);
    let raised = [format!("error {unused}"), format!("error {tr}"), format!("info {missing}")];
    assert_eq!(findings(1, &["--error", "material", "--info", missing]), raised, "the code follows the severity");
    assert_eq!(findings(0, &["--strict", "--warning", tr, "--ignore", "object"]), all[..2]);
    assert_eq!(findings(1, &["--strict", "--ignore", "object"])[1], format!("error {tr}"));
    for options in [["--ignore", "syntax"], ["--info", "syntax/expected"], ["--only", "physics"]] {
        let broken = folder.aam(&[&["check", "broken.aam"], &options[..]].concat()).fails(1);
        broken.says("error[syntax/expected]");
    }
    for option in ["--only", "--ignore", "--error", "--warning", "--info"] {
        let slip = folder.aam(&["check", "odd.aam", option, "material/transparency"]).fails(2);
        slip.says(option).says("there is no such finding");
        folder.aam(&["check", "odd.aam", option, "matreial"]).fails(2).says("did you mean material?");
    }
    folder.aam(&["check", "odd.aam", "--error", tr, "--info", tr]).fails(2).says("two severities");
}

#[test]
fn check_lists_its_codes() {
    let folder = Folder::new();
    let all = folder.aam(&["check", "--list"]).succeeds();
    assert_eq!(all.out.lines().count(), aam::check::CODES.len());
    let some = folder.aam(&["check", "--list", "--only", "limit", "--warning", "limit/nesting"]).succeeds();
    assert!(some.out.lines().all(|line| line.contains("limit/")), "{}", some.out);
    some.says("warning  limit/nesting").says("error    limit/objects");
    folder.aam(&["check"]).fails(2).says("FILE");
    folder.aam(&["check", "--list", "a.aam"]).fails(2);
}

#[test]
fn check_sees_what_textures_are() {
    let folder = Folder::new();
    let texture = "Tx: Y\n{\nFN: a.png\nFi: PYRAMIDAL\nIn: 1\nUA: 0\nVA: 0\nWA: 0\nUO: 0\nVO: 0\nUT: 1\nVT: 1\n}";
    folder.write("a.aam", &SQUARE.replace("Tx: N", texture));
    image::RgbImage::new(40, 30).save(folder.path("a.png")).expect("a picture");
    let clean = folder.aam(&["check", "a.aam", "--only", "texture"]).succeeds();
    assert!(!clean.out.contains("warning["), "{}", clean.out);
    let limited = folder.aam(&["check", "a.aam", "--max-texture-pixels", "1000"]).succeeds();
    limited.says("warning[texture/unreadable]: texture \"a.png\": 40 × 30 = 1200 pixels are more than the limit of 1000; raise it with --max-texture-pixels");
    folder.write("a.png", "not a picture");
    folder.aam(&["check", "a.aam", "--error", "texture/unreadable"]).fails(1).says("error[texture/unreadable]");
}

#[test]
fn check_sees_that_textures_are_missing() {
    let folder = Folder::new();
    let texture = "Tx: Y\n{\nFN: nothing.png\nFi: PYRAMIDAL\nIn: 1\nUA: 0\nVA: 0\nWA: 0\nUO: 0\nVO: 0\nUT: 1\nVT: 1\n}";
    folder.write("a.aam", &SQUARE.replace("Tx: N", texture));
    folder.aam(&["check", "a.aam"]).succeeds().says("texture/missing").says("nothing.png");
}

#[test]
fn fmt_rewrites_once() {
    let folder = Folder::new();
    let messy = SQUARE.replace('\n', "\r\n").replace("Di: 0.9", "Di:   0.90000");
    folder.write("a.aam", &messy);
    folder.aam(&["fmt", "--check", "a.aam"]).fails(1).says("not canonical");
    assert_eq!(folder.read("a.aam"), messy.as_bytes(), "--check changes nothing");
    folder.aam(&["fmt", "a.aam"]).succeeds().says("rewritten");
    let canonical = folder.read("a.aam");
    assert!(!canonical.contains(&b'\r'));
    let quiet = folder.aam(&["fmt", "a.aam"]).succeeds();
    assert!(quiet.out.is_empty(), "a canonical file is left: {}", quiet.out);
    folder.aam(&["fmt", "--check", "a.aam"]).succeeds();
    let streamed = folder.aam_with_input(&["fmt", "-"], messy.as_bytes()).succeeds();
    assert_eq!(streamed.bytes, canonical);
}

#[test]
fn fmt_keeps_binary_binary_and_leaves_broken_files() {
    let folder = Folder::new();
    folder.write("a.aam", SQUARE);
    folder.aam(&["convert", "a.aam", "b.aam", "--binary"]).succeeds();
    assert!(folder.read("b.aam").starts_with(b"BINARY"));
    folder.aam(&["fmt", "b.aam"]).succeeds();
    assert!(folder.read("b.aam").starts_with(b"BINARY"));
    let broken = SQUARE.replace("NObj: 1", "NObj: 2");
    folder.write("broken.aam", &broken);
    folder.aam(&["fmt", "broken.aam", "a.aam"]).fails(2).says("broken.aam");
    assert_eq!(folder.read("broken.aam"), broken.as_bytes());
    let model = folder.fixture("crate.gltf");
    folder.aam(&["fmt", &model]).fails(2).says("only AAM");
}

#[cfg(unix)]
#[test]
fn fmt_keeps_links_and_modes() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    folder.write("real.aam", &SQUARE.replace('\n', "\r\n"));
    fs::set_permissions(folder.path("real.aam"), fs::Permissions::from_mode(0o640)).expect("a mode");
    std::os::unix::fs::symlink("real.aam", folder.path("link.aam")).expect("a link");
    folder.aam(&["fmt", "link.aam"]).succeeds();
    assert!(folder.path("link.aam").symlink_metadata().expect("a link").is_symlink());
    assert!(!folder.read("real.aam").contains(&b'\r'));
    assert_eq!(folder.path("real.aam").metadata().expect("a file").permissions().mode() & 0o777, 0o640);
}

// ---- limits -----------------------------------------------------------------------------------------------------

#[test]
fn limits_name_what_was_found_and_the_option_that_raises_them() {
    let folder = Folder::new();
    folder.write("a.aam", SQUARE);
    let deep = "\tName: m\n\tClass: Multi\n\tNSubs: 1\n\tSub 0\n\t{\n".repeat(3);
    let single = "\tName: m\n\tClass: Standard";
    let nested = SQUARE.replace(single, &(deep + single)).replace("\tTS: N\n", "\tTS: N\n\t}\n\t}\n\t}\n");
    folder.write("nested.aam", &nested);
    folder.aam(&["check", "nested.aam"]).succeeds();
    folder.copy_fixture("crate.glb");
    let square_and = |more: &str| SQUARE.replace("NObj: 1", "NObj: 2").replace("\n}\nENDGEOMETRY", more);
    let second = "\n\tObj: 1 b\n\tPar: -1\n\t{\n\tMatID: 0\n\tV_List: 0\n\t}\n}\nENDGEOMETRY";
    folder.write("two.aam", &square_and(second));
    folder.aam(&["check", "two.aam"]).succeeds();
    folder.copy_fixture("multiframe.aam");
    folder.copy_fixture("crate.obj");
    for (file, option, low, found) in [
        ("a.aam", "--max-file-size", "100", "bytes are more than the limit of 100"),
        ("two.aam", "--max-objects", "1", "2 objects over all frames are more than the limit of 1"),
        ("a.aam", "--max-vertices", "3", "4 vertices over all frames are more than the limit of 3"),
        ("a.aam", "--max-triangles", "1", "2 triangles are more than the limit of 1"),
        ("multiframe.aam", "--max-frames", "2", "frames are more than the limit of 2"),
        ("nested.aam", "--max-nesting", "2", "3 levels of Multi materials are more than the limit of 2"),
        ("crate.glb", "--max-file-size", "100", "bytes are more than the limit of 100"),
        ("crate.glb", "--max-vertices", "3", "vertices over all frames are more than the limit of 3"),
        ("crate.glb", "--max-triangles", "1", "triangles are more than the limit of 1"),
        ("crate.obj", "--max-vertices", "3", "vertices over all frames are more than the limit of 3"),
    ] {
        for verb in [&["info"][..], &["convert", "-o", "out.aam"], &["render", "-o", "out.png"], &["check"], &["fmt"]] {
            if !file.ends_with(".aam") && ["check", "fmt"].contains(&verb[0]) {
                continue;
            }
            let code = if verb == ["check"] && option != "--max-file-size" { 1 } else { 2 };
            let before = folder.read(file);
            let refused = folder.aam(&[verb, &[file, option, low]].concat()).fails(code);
            refused.says(file).says(found).says(&format!("raise it with {option}"));
            assert!(before == folder.read(file) && !folder.has("out.aam") && !folder.has("out.png"), "{verb:?} {file}");
        }
    }
    folder.aam(&["info", "nested.aam", "--max-nesting", "3"]).succeeds();
    for (option, value) in
        [("--max-objects", "0"), ("--max-nesting", "1000"), ("--max-vertices", "-1"), ("--max-frames", "x")]
    {
        folder.aam(&["info", "a.aam", &format!("{option}={value}")]).fails(2).says(option);
    }
    let huge = folder.path("huge.aam");
    fs::File::create(&huge).and_then(|file| file.set_len(5 << 30)).expect("a sparse file");
    folder.aam(&["check", "huge.aam"]).fails(2).says("5368709120 bytes are more than the limit of 4294967296");
}

#[test]
fn limits_are_documented() {
    let read =
        |name: &str| fs::read_to_string(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).expect(name);
    let (readme, format) = (read("README.md"), read("docs/format.md"));
    for limit in aam::Limit::ALL {
        assert!(readme.contains(limit.option()), "README.md lacks {}", limit.option());
        let default = aam::Limits::DEFAULT.of(limit);
        let row = format!("| `{}` | {default} |", limit.option());
        assert!(format.contains(&row), "docs/format.md lacks {row}");
    }
}

// ---- info -------------------------------------------------------------------------------------------------------

#[test]
fn info_counts() {
    let folder = Folder::new();
    folder.write("a.aam", SQUARE);
    let text = folder.aam(&["info", "a.aam"]).succeeds();
    text.says("1 object").says("4 vertices").says("2 triangles").says("square");
    let json = folder.aam(&["info", "a.aam", "--json"]).succeeds().json();
    assert_eq!((&json["vertices"], &json["triangles"]), (&4.into(), &2.into()));
    assert_eq!(json["bounds"]["max"], serde_json::json!([1.0, 0.0, 1.0]));
    assert_eq!(json["objects"][0]["name"], "square");
}

#[test]
fn info_reads_what_convert_reads() {
    let folder = Folder::new();
    for name in ["crate.gltf", "crate.glb", "crate.obj"] {
        let json = folder.aam(&["info", &folder.fixture(name), "--json"]).succeeds().json();
        assert!(json["triangles"].as_u64() > Some(100), "{name}");
        let textures = json["texture_files"].as_array().expect("a list");
        assert!(!textures.is_empty() && textures.iter().all(|texture| texture["width"].as_u64() > Some(0)), "{name}");
    }
}

// ---- convert ----------------------------------------------------------------------------------------------------

#[test]
fn convert_writes_a_file_its_textures_and_a_report() {
    let folder = Folder::new();
    folder.copy_fixture("crate.glb");
    let done = folder.aam(&["convert", "crate.glb", "--report", "report.json"]).succeeds();
    done.says("crate.glb (").says("→ crate.aam (").says("lost");
    assert!(folder.read("crate.aam").starts_with(b"AAM_MESH") || folder.read("crate.aam").starts_with(b"MATERIALS"));
    folder.aam(&["check", "crate.aam"]).succeeds();
    let report: serde_json::Value = serde_json::from_slice(&folder.read("report.json")).expect("JSON");
    assert_eq!(report["input"], "crate.glb");
    let lines = report["changes"].as_array().expect("a list");
    assert!(!lines.is_empty() && lines.iter().all(|line| line["outcome"].is_string() && line["note"].is_string()));
    let info = folder.aam(&["info", "crate.aam", "--json"]).succeeds().json();
    let textures = info["texture_files"].as_array().expect("a list");
    assert!(!textures.is_empty() && textures.iter().all(|texture| texture["problem"].is_null()), "{info}");

    folder.aam(&["convert", "crate.glb"]).succeeds();
    let verbose = folder.aam(&["convert", "crate.glb", "-v"]).succeeds();
    assert!(verbose.out.lines().count() >= done.out.lines().count());
}

#[test]
fn convert_never_replaces_its_input() {
    let folder = Folder::new();
    folder.write("a.aam", SQUARE);
    for output in ["a.aam", "./a.aam"] {
        folder.aam(&["convert", "a.aam", output, "--force", "--binary"]).fails(2);
    }
    folder.aam(&["convert", "a.aam"]).fails(2).says("a.aam");
    folder.aam(&["convert", "a.aam", "b.aam", "--report", "a.aam"]).fails(2);
    assert_eq!(folder.read("a.aam"), SQUARE.as_bytes());
}

#[test]
fn convert_goes_there_and_back() {
    let folder = Folder::new();
    folder.write("a.aam", SQUARE);
    for format in ["glb", "gltf", "obj"] {
        let there = format!("there.{format}");
        folder.aam(&["convert", "a.aam", &there]).succeeds();
        folder.aam(&["convert", &there, &format!("back-{format}.aam")]).succeeds();
        let json = folder.aam(&["info", &format!("back-{format}.aam"), "--json"]).succeeds().json();
        assert_eq!(json["triangles"], 2, "{format}");
        let max = json["bounds"]["max"].as_array().expect("three numbers").iter();
        let max: Vec<f64> = max.map(|value| value.as_f64().expect("a number")).collect();
        assert!((max[0] - 1.0).abs() < 1e-5 && max[1].abs() < 1e-5 && (max[2] - 1.0).abs() < 1e-5, "{format} {max:?}");
    }
    folder.aam(&["convert", "a.aam", "a.stl"]).fails(2).says(".glb");
    folder.aam(&["convert", "a.aam", "nowhere/b.glb"]).fails(2).says("mkdir -p nowhere");
}

#[test]
fn convert_options_reach_the_file() {
    let folder = Folder::new();
    folder.copy_fixture("crate.glb");
    folder.aam(&["convert", "crate.glb", "node.aam", "--hierarchy"]).succeeds();
    assert!(folder.read("node.aam").starts_with(b"AAM_CHARACTER"));
    folder.write("a.aam", SQUARE);
    folder.aam(&["convert", "a.aam", "b.aam", "--digits", "3", "--crlf"]).succeeds();
    let text = String::from_utf8(folder.read("b.aam")).expect("text");
    assert!(text.contains("-1.000 0.000 -1.000\r\n"), "{text}");
    folder.aam(&["convert", "a.aam", "c.aam", "--max-file-size", "100"]).fails(2).says("--max-file-size");
    assert!(!folder.has("c.aam"));
}

#[test]
fn convert_adds_layers() {
    let folder = Folder::new();
    folder.copy_fixture("crate.glb");
    let light = image::RgbImage::from_pixel(4, 4, image::Rgb([200, 100, 50]));
    light.save(folder.path("light.png")).expect("a picture");
    let add = |more: &[&str]| folder.aam(&[&["convert", "crate.glb", "a.aam", "--force"], more].concat());
    add(&["--light-map", "Floor Tiles=light.png"]).succeeds();
    let json = folder.aam(&["info", "a.aam", "--json"]).succeeds().json();
    let lit = |json: &serde_json::Value| {
        let materials = json["materials"].as_array().expect("a list").iter();
        materials.filter(|material| material["layers"][1] == "light.png").count()
    };
    assert_eq!(lit(&json), 1, "{json}");
    add(&["--displacement", "Floor Tiles=light.png", "--tf", "5", "--bias", "-0.1", "--scale", "0.2"]).succeeds();
    let text = String::from_utf8_lossy(&folder.read("a.aam")).into_owned();
    assert!(text.contains("TF: 5") && text.contains("BI: -0.1") && text.contains("SC: 0.2"));
    add(&["--light-map", "Nobody=light.png"]).fails(2).says("Nobody");
    add(&["--light-map", "nothing.png"]).fails(2).says("nothing.png");
    add(&["--bias", "1"]).fails(2).says("--displacement");
}

/// A box, one metre wide and deep, as an object of an OBJ file that already holds `before` of them.
fn block(name: &str, before: usize, height: f32) -> String {
    let mut text = format!("o {name}\n");
    for corner in 0..8 {
        let [x, y, z] = [1, 2, 4].map(|bit| u8::from(corner & bit != 0));
        text += &format!("v {x} {} {z}\n", f32::from(y) * height);
    }
    for face in [[1, 5, 7, 3], [2, 4, 8, 6], [1, 2, 6, 5], [3, 7, 8, 4], [1, 3, 4, 2], [5, 6, 8, 7]] {
        let [a, b, c, d] = face.map(|corner| corner + 8 * before);
        text += &format!("f {a} {b} {c} {d}\n");
    }
    text
}

#[test]
fn convert_makes_bodies() {
    let folder = Folder::new();
    folder.write("blocks.obj", &[block("low", 0, 1.0), block("high", 1, 2.0)].concat());
    let convert = |more: &[&str]| {
        folder.aam(&[&["convert", "blocks.obj", "a.aam"], more].concat()).succeeds();
        folder.aam(&["info", "a.aam", "--json"]).succeeds().json()
    };
    let json = convert(&["--physics", "dynamic", "--mass", "6", "--hulls", "3", "--restitution", "0.25"]);
    assert_eq!(json["bodies"], serde_json::json!([0, 0, 2]));
    let text = String::from_utf8_lossy(&folder.read("a.aam")).into_owned();
    let numbers = |tag: &str| -> Vec<f64> {
        text.lines().filter_map(|line| line.trim().strip_prefix(tag)?.trim().parse().ok()).collect()
    };
    // The second block has twice the volume of the first.
    assert!(numbers("Ma:").iter().zip([2.0, 4.0]).all(|(mass, wanted)| (mass - wanted).abs() < 1e-3), "{text}");
    assert_eq!((numbers("NConvex:"), numbers("Re:")), (vec![1.0, 1.0], vec![0.25, 0.25]));
    folder.aam(&["check", "a.aam"]).succeeds();
    let json = convert(&["--physics", "static"]);
    assert_eq!(json["bodies"], serde_json::json!([2, 0, 0]));
}

#[test]
fn convert_takes_several_files() {
    let folder = Folder::new();
    folder.write("a.aam", SQUARE);
    folder.write("broken.obj", "f 1 2 3\n");
    for name in ["one.glb", "two.glb"] {
        folder.aam(&["convert", "a.aam", name]).succeeds();
    }
    let two = folder.read("two.glb");
    folder.aam(&["convert", "one.glb", "two.glb"]).fails(2).says("-o out/");
    assert_eq!(folder.read("two.glb"), two, "a glob of two does not replace the second");
    folder.aam(&["convert", "one.glb", "two.glb", "-o", "out"]).succeeds().says("2 files converted");
    assert!(folder.has("out/one.aam") && folder.has("out/two.aam"));
    let partly = folder.aam(&["convert", "one.glb", "broken.obj", "nothing.glb", "-o", "out2"]).fails(2);
    partly.says("1 file converted, 2 failed").says("broken.obj").says("nothing.glb");
    assert!(folder.has("out2/one.aam"));
}

// ---- render -----------------------------------------------------------------------------------------------------

#[test]
fn render_draws_what_is_there() {
    let folder = Folder::new();
    folder.write("a.aam", SQUARE);
    let render = |more: &[&str]| {
        folder.aam(&[&["render", "a.aam", "-o", "a.png", "--size", "64x48"], more].concat()).succeeds();
        folder.picture("a.png")
    };
    for engine in ["gpu", "reference"] {
        if engine == "gpu" && !common::has_gpu() {
            println!("skipped: no GPU adapter");
            continue;
        }
        let picture = render(&["--engine", engine, "--view", "front", "--background", "0,0,1"]).into_rgba8();
        assert_eq!(picture.dimensions(), (64, 48));
        let (middle, corner) = (picture.get_pixel(32, 24).0, picture.get_pixel(1, 1).0);
        assert!(middle[0] > 120 && middle[2] < 60, "{engine}: the square is red, {middle:?}");
        assert_eq!(corner, [0, 0, 255, 255], "{engine}: the background is blue");
        let picture = render(&["--engine", engine, "--background", "transparent"]);
        assert!(picture.color().has_alpha());
        let picture = picture.into_rgba8();
        assert_eq!((picture.get_pixel(0, 0).0[3], picture.get_pixel(32, 24).0[3]), (0, 255), "{engine}");
        let above = render(&["--engine", engine, "--view", "top", "--background", "black"]).into_rgb8();
        let red = above.pixels().filter(|pixel| pixel.0[0] > 100).count();
        assert!(red < 64 * 4, "{engine}: from above it is a line, {red}");
    }
}

#[test]
fn render_writes_where_it_is_told() {
    let folder = Folder::new();
    folder.write("a.aam", SQUARE);
    let reference = ["render", "a.aam", "--engine", "reference", "--size", "40x30", "--samples", "1"];
    let render = |more: &[&str]| folder.aam(&[&reference[..], more].concat());
    let piped = render(&["-o", "-"]).succeeds();
    let picture = image::load_from_memory(&piped.bytes).expect("a PNG on standard output");
    assert_eq!((picture.width(), picture.height()), (40, 30));
    render(&["-o", "turn.png", "--turntable", "4"]).succeeds().says("turn_00.png … turn_03.png");
    let turned: Vec<_> = (0..4).map(|number| folder.read(&format!("turn_{number:02}.png"))).collect();
    assert!(turned[0] != turned[1] && turned[1] != turned[2], "every picture is from elsewhere");
    render(&["-o", "x{n}.png", "--turntable", "2"]).succeeds();
    assert!(folder.has("x00.png") && folder.has("x01.png"));
    let timed = render(&["-o", "a.png", "--time"]).succeeds();
    for step in ["load", "encode", "total"] {
        assert!(timed.err.contains(step), "{step}: {}", timed.err);
    }
    render(&["-o", "a.jpg"]).fails(2).says("PNG").says("a.png");
    render(&["-o", "nowhere/a.png"]).fails(2).says("mkdir -p nowhere");
    render(&["-o", "-", "--turntable", "2"]).fails(2);
    render(&["-o", "a.png", "--view", "nobody"]).fails(2).says("front");
    render(&["-o", "a.png", "--camera-position", "1,1,1", "--camera-target", "1,1,1"]).fails(2);
}

/// Two squares beside each other, the blue one hidden, seen by a camera of the file.
const SCENE: &str = "\
active_camera = \"door\"

[background]
color = [0, 1, 0]

[[asset]]
path = \"red.aam\"
position = [-2, 0, 0]

[[asset]]
path = \"blue.aam\"
position = [2, 0, 0]
visible = false

[[light]]
kind = \"directional\"
direction = [0, 1, 0]

[[camera]]
name = \"door\"
position = [0, -9, 0]
target = [0, 0, 0]
up = [0, 0, 1]
fov_y = 50
near = 0.1
far = 100
";

#[test]
fn render_takes_scene_files() {
    let folder = Folder::new();
    folder.write("red.aam", SQUARE);
    folder.write("blue.aam", &square("0.1 0.1 0.9"));
    folder.write("room.scene.toml", SCENE);
    let render = |more: &[&str]| {
        let reference = ["render", "room.scene.toml", "-o", "a.png", "--size", "90x60", "--engine", "reference"];
        folder.aam(&[&reference[..], more].concat())
    };
    let done = render(&[]).succeeds();
    assert!(!done.err.contains("no lights"), "{}", done.err);
    let picture = folder.picture("a.png").into_rgb8();
    assert_eq!(picture.get_pixel(2, 2).0, [0, 255, 0]);
    assert!(picture.get_pixel(30, 30).0[0] > 100, "the red square is left of the middle");
    assert_eq!(picture.get_pixel(60, 30).0, [0, 255, 0], "the blue square is hidden");
    render(&["--view", "door", "--background", "white"]).succeeds();
    assert_eq!(folder.picture("a.png").into_rgb8().get_pixel(2, 2).0, [255, 255, 255]);
    folder.write("room.scene.toml", &SCENE.replace("red.aam", "green.aam"));
    render(&[]).fails(2).says("green.aam").says("there is no such file");
    folder.write("room.scene.toml", &SCENE.replace("color = [0, 1, 0]", "color = \"green\""));
    render(&[]).fails(2).says("room.scene.toml:4:").says("expected");
    folder.aam(&["info", "room.scene.toml"]).fails(2).says("aam view");
}

#[test]
fn render_traces_shadows_and_bounces() {
    let folder = Folder::new();
    let file = folder.fixture("demo-torus.scene.toml");
    let render = |more: &[&str]| {
        let reference = ["render", &file, "-o", "a.png", "--size", "48x36", "--engine", "reference", "--samples", "1"];
        folder.aam(&[&reference[..], more].concat())
    };
    let mut pictures = Vec::new();
    for more in [&["--shadows=none"][..], &["--shadows=point"], &["--shadows"], &["--shadows", "--light-samples", "2"]]
    {
        render(more).succeeds();
        pictures.push(folder.read("a.png"));
    }
    assert!((1..pictures.len()).all(|at| !pictures[..at].contains(&pictures[at])), "each option changes the picture");
    render(&["--shadows=area"]).succeeds();
    assert!(folder.read("a.png") == pictures[2], "area is what --shadows means");
    render(&[]).succeeds();
    assert!(folder.read("a.png") == pictures[2], "the file says that there are shadows");
    render(&["--bounces", "1"]).succeeds().says("linear light");
    render(&["--bounces", "1", "--shading", "source"]).fails(2).says("--shading linear");
    render(&["--bounces", "1", "--shadows=none"]).fails(2).says("through walls");
    render(&["--shadows=wide"]).fails(2).says("there are hard, pcf").says("point and area").says("--shadows=help");
    render(&["--shadows=pcf"]).fails(2).says("no technique pcf").says("--shadows=area");
    let help = folder.aam(&["render", "--shadows=help"]).succeeds();
    assert!(help.out.contains("evsm4") && help.out.contains("bleed_reduction"), "{}", help.out);
    for (option, value) in [("--bounces", "1025"), ("--light-samples", "0")] {
        render(&[option, value]).fails(2).says(option);
    }
}

#[test]
fn render_takes_every_format() {
    let folder = Folder::new();
    for name in ["crate.gltf", "crate.glb", "crate.obj"] {
        let file = folder.fixture(name);
        let arguments = ["render", &file, "-o", "a.png", "--size", "96x72", "--engine", "reference", "--samples", "1"];
        folder.aam(&arguments).succeeds();
        let picture = folder.picture("a.png").into_rgb8();
        let colors: std::collections::BTreeSet<_> = picture.pixels().map(|pixel| pixel.0).collect();
        assert!(colors.len() > 200, "{name} has {} colours", colors.len());
    }
}

#[test]
fn without_a_gpu_the_reference_draws_and_says_so() {
    let folder = Folder::new();
    folder.write("a.aam", SQUARE);
    let run = |more: &[&str]| {
        let arguments = [&["render", "a.aam", "-o", "a.png", "--size", "32x32"], more].concat();
        let mut command = folder.command(&arguments);
        command
            .env("VK_ICD_FILENAMES", "/nonexistent")
            .env("VK_DRIVER_FILES", "/nonexistent")
            .env("WGPU_BACKEND", "vulkan");
        common::Ran::of(command.output().expect("aam runs"))
    };
    let fallen_back = run(&[]).succeeds();
    assert!(
        fallen_back.err.contains("reference engine") && fallen_back.err.contains("no GPU adapter"),
        "{}",
        fallen_back.err
    );
    assert!(fallen_back.err.trim().lines().filter(|line| line.contains("reference engine")).count() == 1);
    assert!(folder.picture("a.png").into_rgb8().get_pixel(16, 16).0[0] > 100);
    fs::remove_file(folder.path("a.png")).expect("removed");
    run(&["--engine", "gpu"]).fails(2).says("--engine reference");
    assert!(!folder.has("a.png"));
    run(&["--engine", "reference"]).succeeds();
}

#[test]
fn a_red_and_a_blue_square_differ() {
    let folder = Folder::new();
    for (name, color) in [("red", "0.9 0.1 0.1"), ("blue", "0.1 0.1 0.9")] {
        folder.write(&format!("{name}.aam"), &square(color));
        let (file, picture) = (format!("{name}.aam"), format!("{name}.png"));
        folder
            .aam(&["render", &file, "-o", &picture, "--size", "32x32", "--engine", "reference", "--view", "front"])
            .succeeds();
    }
    let pixel = |name: &str| folder.picture(name).into_rgb8().get_pixel(16, 16).0;
    assert!(pixel("red.png")[0] > pixel("red.png")[2] && pixel("blue.png")[2] > pixel("blue.png")[0]);
}
