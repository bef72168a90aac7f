//! The exact words in which the reader refuses and warns: the place, what is wrong, the line with a marker.

mod sources;

use aam::document::{Encoding, MaterialBody};
use aam::{Excerpt, Limits, Position, ReadOptions, WriteOptions, read, write};

use sources::{CLEAN, MULTIFRAME, TEXTURE, changed, nested};

/// The error of each changed source, as the user sees it.
#[track_caller]
fn refusals(source: &str, changes: &[(&str, &str)]) -> String {
    let refusal = |&(from, to): &(&str, &str)| {
        let source = changed(source, from, to);
        match read(source.as_bytes(), &ReadOptions::default()) {
            Ok(_) => panic!("accepted: {from:?} → {to:?}"),
            Err(error) => format!("{error}\n"),
        }
    };
    changes.iter().map(refusal).collect()
}

/// The findings of a source that is read, as `aam check` shows them but for the file's name.
fn warnings(bytes: &[u8]) -> String {
    let outcome = read(bytes, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert!(!outcome.findings.is_empty(), "nothing to warn of");
    let mut text = String::new();
    for finding in &outcome.findings {
        text.push_str(&format!("{finding}\n"));
        if let Some(position) = finding.position {
            text.push_str(&format!("{}\n", Excerpt::at(bytes, Position::walk(bytes).offset(position))));
        }
    }
    text
}

/// The clean character as a BINARY file, and a change in its bytes.
fn binary(change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut document = read(CLEAN.as_bytes(), &ReadOptions::default()).expect("clean").document;
    document.encoding = Encoding::Binary;
    let mut bytes = write(&document, &WriteOptions::default()).expect("writable");
    change(&mut bytes);
    bytes
}

/// The first place of a text in bytes, and behind it.
#[track_caller]
fn after(bytes: &[u8], text: &[u8]) -> usize {
    bytes.windows(text.len()).position(|window| window == text).expect("the text") + text.len()
}

/// Compares a text with the recorded one; `INSTA_UPDATE=always` records it anew.
#[track_caller]
fn recorded(name: &str, text: String) {
    insta::with_settings!({ omit_expression => true }, { insta::assert_snapshot!(name, text) });
}

fn refusal(bytes: &[u8]) -> String {
    read(bytes, &ReadOptions::default()).expect_err("a refusal").to_string() + "\n"
}

#[test]
fn what_is_no_document() {
    let sources: [&[u8]; 8] = [
        b"",
        b"\n\n   \n",
        b"# Blender v2.79\no Cube\n",
        b"o Cube\nv 0 0 0\n",
        b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR",
        b"AAM_MESH\nBINARY\nMATERIALS\nMatCount: 0\nENDMATERIALS\n",
        b"AAM_MESH\nMATERIAL\nMatCount: 0\nENDMATERIALS\n",
        b"SHADERS\nvoid main() {}\nMATERIALS\n",
    ];
    recorded("what_is_no_document", sources.map(refusal).concat());
}

#[test]
fn tags() {
    recorded(
        "tags",
        refusals(
            CLEAN,
            &[
                // Another tag, or the end, where one must stand.
                ("\tTr: 0.0\n\tSh: 0.25\n", "\tSh: 0.25\n"),
                ("\tTr: 0.0\n\tSh: 0.25\n", "\tSh: 0.25\n\tTr: 0.0\n"),
                ("\tTr: 0.0\n", "\tTr: 0.0\n\tAm: 0 0 0\n"),
                ("ENDGEOMETRY", ""),
                ("GEOMETRY SmGEnabled", "GOEMETRY SmGEnabled"),
                ("\tPar: -1\n\t{", "\tPar: -1\n"),
                ("\tI_List: 4 1\n", ""),
                ("ENDPHYSICS", "}"),
                // Letter case.
                ("\tMatID: 0", "\tmatid: 0"),
                ("NBody: 2", "NBODY: 2"),
                // Misspelt, with the place of the slip and not that of the tag after it.
                ("\tMatID: 0", "\tMadID: 0"),
                ("\tMatID: 0", "\tMatID 0"),
                ("\tMatID: 0", "\tMatID:0"),
                ("\tName: skin", "\tNmae: skin"),
                ("Mat# 0", "Mat 0"),
                ("\tV_List: 4", "\tV_Lits: 4"),
                ("ENDMATERIALS", "ENDMATERIAL"),
                ("Animation_mode: Keyframe", "AnimationMode: Keyframe"),
                ("\tDF: 0.5", "\tDf.: 0.5"),
                // An unknown block that does not end.
                ("ENDGEOMETRY", "Extra\n{\nENDGEOMETRY"),
            ],
        ),
    );
}

#[test]
fn values() {
    recorded(
        "values",
        refusals(
            CLEAN,
            &[
                ("\tTr: 0.0", "\tTr: none"),
                ("\tTr: 0.0", "\tTr: 0,5"),
                ("\tTr: 0.0", "\tTr:"),
                ("\tDi: 0.5 0.5 0.5", "\tDi: 0.5 0.5"),
                ("MatCount: 2", "MatCount: two"),
                ("MatCount: 2", "MatCount: -2"),
                ("\tMatID: 0", "\tMatID: 0.5"),
                ("\tMatID: 0", "\tMatID: 4294967296"),
                ("\tMir: 0", "\tMir: 2"),
                ("\tTx: Y", "\tTx: Yes"),
                ("\t\tFi: PYRAMIDAL", "\t\tFi:"),
                ("Animation_mode: Keyframe", "Animation_mode: Key"),
                ("\tMode: Dynamic", "\tMode: Dynmic"),
                ("\t\tSphere: 0 0 0 1", "\t\tShpere: 0 0 0 1"),
                ("\t\tSphere: 0 0 0 1", "\t\tSphere: 0 0 0 big"),
                ("\tPsSam: 1\n\t\t\t0 0 0 0", "\tPsSam: 1\n\t\t\t0 0 x 0"),
                ("\tV_List: 4\n\t\t0 0 0", "\tV_List: 4\n\t\t0 zero 0"),
                ("\tMatID: 0\n", "\tMatID: 0\n\tTF: 0\n\tBI: 0\n\tSC: 1\n"),
            ],
        ),
    );
    let normal_map = format!("\tTS: N\n\tTN: Y\n{}\tAC", TEXTURE.replace("}\n", "NS: WORLD\n}\n"));
    recorded("values_of_a_normal_map", refusals(CLEAN, &[("\tTS: N\n\tAC", &normal_map)]));
}

#[test]
fn counts() {
    recorded(
        "counts",
        refusals(
            CLEAN,
            &[
                ("MatCount: 2", "MatCount: 1"),
                ("MatCount: 2", "MatCount: 3"),
                ("MatCount: 2", "MatCount: 4000000000"),
                ("MatCount: 2", "MatCount: 99999999999999999999999"),
                ("NObj: 2", "NObj: 1"),
                ("NObj: 2", "NObj: 3"),
                ("NObj: 2", "NObj: 4000000000"),
                ("\tV_List: 4", "\tV_List: 3"),
                ("\tV_List: 4", "\tV_List: 5"),
                ("\tV_List: 4", "\tV_List: 4000000000"),
                ("\tC_List: 4\n\t\t1 1 1\n", "\tC_List: 3\n"),
                ("I_List: 4 1", "I_List: 3 1"),
                ("I_List: 4 1", "I_List: 5 1"),
                ("I_List: 4 1", "I_List: 4 2"),
                ("I_List: 4 1", "I_List: 4000000000 1"),
                ("I_List: 4 1", "I_List: 4 4000000000"),
                ("\tRtSam: 2", "\tRtSam: 4000000000"),
                ("NBody: 2", "NBody: 3"),
                ("\tNConvex: 1", "\tNConvex: 4000000000"),
            ],
        ),
    );
    let frames = refusals(
        MULTIFRAME,
        &[
            ("NFrames: 2", "NFrames: 1"),
            ("NFrames: 2", "NFrames: 3"),
            ("NFrames: 2", "NFrames: 4000000000"),
            (
                "Frame: 1\n{\n\tObj: 0 a\n\tPar: -1\n\t{\n\tMatID: -1\n\tV_List: 0",
                "Frame: 1\n{\n\tObj: 0 a\n\tPar: -1\n\t{\n\tMatID: -1\n\tV_List: 1\n\t\t0 0 0",
            ),
            (
                "Frame: 1\n{\n\tObj: 0 a\n\tPar: -1\n\t{\n\tMatID: -1\n\tV_List: 0",
                "Frame: 1\n{\n\tObj: 0 a\n\tPar: -1\n\t{\n\tMatID: -1\n\tV_List: 0\n\tN_List: 1\n\t\t0 0 1",
            ),
        ],
    );
    recorded("counts_of_frames", frames);
}

#[test]
fn triangles() {
    let rows = "\t\tI: 0 2 1 1\n\t\tNI: 0 0 0\n\t\tTI: 0 1 2\n";
    recorded(
        "triangles",
        refusals(
            CLEAN,
            &[
                ("I: 0 2 1 1", "I: 0 4 1 1"),
                ("I: 0 2 1 1", "I: 0 -1 1 1"),
                ("I: 0 2 1 1", "I: 0 99999999999 1 1"),
                ("I: 0 2 1 1", "I: 0 2 1"),
                ("NI: 0 0 0", "NI: 0 0 1"),
                ("TI: 0 1 2", "TI: 0 1 3"),
                (rows, "\t\tTI: 0 1 2\n"),
                (rows, "\t\tI: 0 2 1 1\n\t\tTI: 0 1 2\n\t\tNI: 0 0 0\n"),
                (
                    rows,
                    "\t\tI: 0 2 1 1\n\t\tNI: 0 0 0\n\t\tTI: 0 1 2\n\t\tTI: 0 1 2\n\t\tTI: 0 1 2\n\t\tTI: 0 1 2\n\t\tTI: 0 1 2\n",
                ),
                ("I: 0 1 2 1\n\t\tENDGROUP", "I: 0 1 2 1\n\t\tNI: 0 0 0\n\t\tENDGROUP"),
                ("I: 0 1 2 1\n\t\tENDGROUP", "I: 0 1 2 1\n\t\tTI: 0 1 2\n\t\tENDGROUP"),
                ("\t\tNEWGROUP: 1\n", ""),
                ("I: 0 1 2 1\n\t\tENDGROUP", "I: 0 1 2 1\n"),
                ("\t\t2 1 1 1.0", "\t\t7 1 1 1.0"),
                ("\t\t\tI: 0 3 2", "\t\t\tI: 0 3 4"),
            ],
        ),
    );
}

#[test]
fn limits() {
    let mut texts = String::new();
    let standard = Limits::default();
    for (source, limits) in [
        (MULTIFRAME, Limits { objects: 3, ..standard }),
        (CLEAN, Limits { vertices: 10, ..standard }),
        (CLEAN, Limits { triangles: 8, ..standard }),
        (MULTIFRAME, Limits { frames: 1, ..standard }),
        (&changed(CLEAN, "\tName: skin\n\tClass: Standard", &nested(40)), standard),
        (&changed(CLEAN, "\tName: skin\n\tClass: Standard", &nested(300)), Limits { nesting: u64::MAX, ..standard }),
    ] {
        let error = read(source.as_bytes(), &ReadOptions { limits, ..ReadOptions::default() }).expect_err("a refusal");
        texts.push_str(&format!("{error}\n"));
    }
    recorded("limits", texts);
}

#[test]
fn a_document_at_its_limits_is_accepted() {
    let limits = Limits { objects: 2, vertices: 11, triangles: 9, frames: 1, nesting: 1, ..Limits::default() };
    let options = ReadOptions { limits, ..ReadOptions::default() };
    let document = read(CLEAN.as_bytes(), &options).unwrap_or_else(|error| panic!("{error}")).document;
    limits.check_document(&document).unwrap_or_else(|error| panic!("{error}"));
    for (lower, option) in [
        (Limits { objects: 1, ..limits }, "--max-objects"),
        (Limits { vertices: 10, ..limits }, "--max-vertices"),
        (Limits { triangles: 8, ..limits }, "--max-triangles"),
        (Limits { frames: 0, ..limits }, "--max-frames"),
        (Limits { nesting: 0, ..limits }, "--max-nesting"),
    ] {
        let by_text = read(CLEAN.as_bytes(), &ReadOptions { limits: lower, ..options.clone() }).expect_err(option);
        let by_document = lower.check_document(&document).expect_err(option).to_string();
        assert!(by_document.contains(option), "{by_document}");
        assert_eq!(by_text.message, by_document, "the same words");
    }
}

#[test]
fn the_deepest_nesting_fits_a_small_stack() {
    let depth = Limits::DEEPEST_NESTING as usize;
    let single = "\tName: skin\n\tClass: Standard";
    let source = changed(CLEAN, single, &(nested(depth) + single)).replacen(
        "\tAC: 0.5\n",
        &format!("\tAC: 0.5\n{}", "}\n".repeat(depth)),
        1,
    );
    let limits = Limits { nesting: u64::MAX, ..Limits::default() };
    let read_all = move || {
        let outcome = read(source.as_bytes(), &ReadOptions { limits, ..ReadOptions::default() });
        let document = outcome.unwrap_or_else(|error| panic!("{error}")).document;
        let written = write(&document, &WriteOptions::default()).expect("writable");
        let again = read(&written, &ReadOptions { limits, ..ReadOptions::default() }).expect("readable").document;
        assert!(again == document && matches!(again.materials[0].body, MaterialBody::Multi(_)));
        assert_eq!(aam::check(&again, None), []);
    };
    std::thread::Builder::new().stack_size(1 << 20).spawn(read_all).expect("a thread").join().expect("enough stack");
}

#[test]
fn binary_lists() {
    let mut texts = String::new();
    let mut refuse = |change: &dyn Fn(&mut Vec<u8>)| texts.push_str(&refusal(&binary(change)));
    refuse(&|bytes| {
        let at = after(bytes, b"V_List: 4");
        bytes[at] = b' ';
    });
    refuse(&|bytes| bytes.truncate(after(bytes, b"V_List: 4\n") + 47));
    refuse(&|bytes| bytes.truncate(after(bytes, b"V_List: 4\n") + 12));
    refuse(&|bytes| {
        let at = after(bytes, b"\nI: ");
        bytes[at..at + 4].copy_from_slice(&77_i32.to_le_bytes());
    });
    refuse(&|bytes| {
        let at = after(bytes, b"\nI: ") - 1;
        bytes[at] = b'\t';
    });
    refuse(&|bytes| bytes.truncate(after(bytes, b"\nI: ") + 6));
    refuse(&|bytes| {
        let at = after(bytes, b"\tV_List") - "V_List".len();
        bytes[at] = b'W';
    });
    refuse(&|bytes| {
        let at = after(bytes, b"\tV_List") - "V_List".len();
        bytes[at..at + 2].copy_from_slice(b"XY");
    });
    recorded("binary_lists", texts);
}

#[test]
fn what_is_accepted_with_a_warning() {
    let tag = |tag: &str| changed(CLEAN, "\tPiv: ", &format!("\t{tag}\n\tPiv: "));
    let sources = [
        changed(CLEAN, "AAM_CHARACTER", "\u{feff}AAM_CHARACTER"),
        changed(CLEAN, "MATERIALS\n", "SHADERS\nvoid main() {}\nENDSHADERS\nMATERIALS\n"),
        changed(CLEAN, "AAM_CHARACTER", "AAM_CHARACTRE"),
        changed(CLEAN, "SmGEnabled", "SmGEnable"),
        tag("LastPose: 3 of 4"),
        tag("UserProps: shiny"),
        tag("Skelett:\n\t{\n\t1 2 3\n\t}"),
        changed(CLEAN, "\t\tRtSam: 2", "\t\tRtSmp: 0\n\t\tRtSam: 2"),
        changed(CLEAN, "\tMa: 1.0", "\tMas: 1.0"),
        changed(CLEAN, "\tMir: 0", "\tMir: 0 left over"),
        changed(CLEAN, "ENDMATERIALS", "}\nENDMATERIALS"),
        changed(CLEAN, "\tAnim_Ctrl: Y", "\t}\n\tAnim_Ctrl: Y"),
        changed(CLEAN, "\tTS: N\n\tAC", "\tTS: N\n\tTS: N\n\tAC"),
        changed(CLEAN, "\tTV_List: 0\n", ""),
        changed(CLEAN, "I_List: 1 1", "I_List: 1"),
        changed(CLEAN, "\tTr: 0.0", "\tTr: -1.#IND"),
        changed(CLEAN, "\tTr: 0.0", "\tTr: 1e39"),
        changed(CLEAN, "ENDPHYSICS\n", "ENDPHYSICS\nNotes: none\n"),
        changed(CLEAN, "PHYSICS\n", "PHYSCIS\n"),
    ];
    let mut texts: String = sources.iter().map(|source| warnings(source.as_bytes())).collect();
    texts.push_str(&warnings(&binary(|bytes| {
        let at = after(bytes, b"V_List: 4\n");
        bytes[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    })));
    recorded("what_is_accepted_with_a_warning", texts);
}

#[test]
fn a_million_unknown_tags_are_counted_once() {
    let source = changed(CLEAN, "\tPiv: ", &("\tMadID: 1\n".repeat(1_000_000) + "\tPiv: "));
    let outcome = read(source.as_bytes(), &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(outcome.findings.len(), 21);
    assert_eq!(outcome.findings.last().map(|finding| finding.message.as_str()), Some("999980 more of the same"));
}
