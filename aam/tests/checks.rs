//! Every code of the table is given by a file that deserves it, and by no clean file.

mod sources;

use std::collections::BTreeSet;
use std::str::FromStr;

use aam::check::{CODES, CodePattern, Rules, groups};
use aam::{Excerpt, Finding, Limits, Position, ReadOptions, Severity, check, read};

use sources::{CLEAN, MULTIFRAME, TEXTURE, changed, nested};

/// All findings of a source, a refusal to read included.
fn findings(source: &str, limits: Limits) -> Vec<Finding> {
    match read(source.as_bytes(), &ReadOptions { limits, ..ReadOptions::default() }) {
        Ok(outcome) => {
            let mut findings = outcome.findings;
            findings.extend(check(&outcome.document, Some((source.as_bytes(), &outcome.places))));
            findings
        }
        Err(error) => vec![error.into()],
    }
}

#[test]
fn a_clean_file_has_no_findings() {
    assert_eq!(findings(CLEAN, Limits::default()), []);
    let strict = ReadOptions { strict: true, ..ReadOptions::default() };
    read(CLEAN.as_bytes(), &strict).unwrap_or_else(|error| panic!("{error}"));
}

/// What to change in the clean file to get a finding.
fn provocations() -> Vec<(&'static str, Vec<(&'static str, String)>)> {
    let one = |code, from, to: &str| (code, vec![(from, to.to_owned())]);
    let ring: String = (0..70)
        .map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / 70.0;
            format!("{:.5} {:.5} 0\n", angle.cos(), angle.sin())
        })
        .collect();
    let fan = |n: usize| -> String {
        (0..n).map(|i| format!("I: {i} {} {n}\nI: {} {i} {}\n", (i + 1) % n, (i + 1) % n, n + 1)).collect()
    };
    let piece = "V_List: 4\n\t\t\t0 0 0\n\t\t\t1 0 0\n\t\t\t0 1 0\n\t\t\t0 0 1\n\t\tI_List: 4\n\t\t\tI: 0 2 1\n\t\t\tI: 0 1 3\n\t\t\tI: 1 2 3\n\t\t\tI: 0 3 2\n";
    let bipyramid =
        |points: &str, n: usize| format!("V_List: {}\n{points}0 0 1\n0 0 -1\nI_List: {}\n{}", n + 2, 2 * n, fan(n));
    let many: String = (0..300)
        .map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / 300.0;
            format!("{:.6} {:.6} 0\n", angle.cos(), angle.sin())
        })
        .collect();
    vec![
        one("syntax/expected", "MatCount: 2", "MatCount: two"),
        one("syntax/tag-order", "Tr: 0.0\n\tSh: 0.25", "Sh: 0.25\n\tTr: 0.0"),
        one("syntax/tag-case", "MatID: 0", "MatId: 0"),
        one("syntax/unknown-tag", "\tMatID: 0", "\tMadID: 3\n\tMatID: 0"),
        one("syntax/misspelt-tag", "\tMatID: 0", "\tMadID: 0"),
        (
            "syntax/unknown-list",
            vec![("AAM_CHARACTER", "BINARY\nAAM_CHARACTER".into()), ("\tV_List: 4", "\tX_List: 4\n\tV_List: 4".into())],
        ),
        one("syntax/trailing-text", "Mir: 0", "Mir: 0 left over"),
        one("syntax/stray-brace", "ENDMATERIALS", "}\nENDMATERIALS"),
        one("syntax/repeated-tag", "\tTS: N\n\tAC", "\tTS: N\n\tTS: N\n\tAC"),
        one("syntax/missing-tag", "\tTV_List: 0\n", ""),
        one("syntax/missing-count", "I_List: 1 1", "I_List: 1"),
        one("syntax/byte-order-mark", "AAM_CHARACTER", "\u{feff}AAM_CHARACTER"),
        one("count/too-large", "V_List: 4", "V_List: 4000000000"),
        one("count/mismatch", "NObj: 2", "NObj: 1"),
        one("value/range", "MatID: 0", "MatID: 4294967296"),
        one("value/not-finite", "TV_List: 3\n\t\t0 0", "TV_List: 3\n\t\t0 -1.#IND"),
        ("limit/nesting", vec![("\tName: skin\n\tClass: Standard", nested(40))]),
        one("object/duplicate-id", "Obj: 1 hand", "Obj: 0 hand"),
        one("object/missing-parent", "Par: 0", "Par: 7"),
        one("object/parent-cycle", "Par: -1", "Par: 1"),
        one("object/empty-name", "Obj: 1 hand", "Obj: 1"),
        one("object/duplicate-name", "Obj: 1 hand", "Obj: 1 arm"),
        one("object/material-missing", "MatID: 0", "MatID: 2"),
        one("object/empty", "I_List: 1 1\n\t\tNEWGROUP: 1\n\t\tI: 0 1 2 1\n\t\tENDGROUP", "I_List: 0"),
        one("material/number", "Mat# 0", "Mat# 5"),
        one("material/duplicate-sub", "Sub 1", "Sub 0"),
        (
            "material/empty-multi",
            vec![
                ("\tName: skin", "\tName: skin\n\tClass: Multi\n\tNSubs: 0\n}\nMat# 1\n{\n\tName: x".into()),
                ("MatCount: 2", "MatCount: 3".into()),
            ],
        ),
        one("material/color-range", "Di: 0.5 0.5 0.5\n\tSp", "Di: 0.5 1.5 0.5\n\tSp"),
        one("material/negative-emission", "SI: 0.0 0.0 0.0", "SI: 0.0 -1.0 0.0"),
        one("material/transparency-range", "Tr: 0.0\n\tSh: 0.25", "Tr: 2.0\n\tSh: 0.25"),
        one("material/shininess", "Sh: 0.25", "Sh: 100.0"),
        one("material/alpha-cutoff-range", "AC: 0.5", "AC: 5"),
        ("material/light-and-normal-map", vec![("\tTS: N\n\tAC", format!("\tTS: Y\n{TEXTURE}\tTN: Y\n{TEXTURE}\tAC"))]),
        (
            "material/displacement-without-shading-map",
            vec![("\tTS: N\n\tAC", format!("\tTS: N\n\tTD: Y\n{TEXTURE}\tAC"))],
        ),
        one("material/unused", "MatID: 0", "MatID: -1"),
        one("texture/empty-name", "FN: skin.png", "FN:"),
        one("texture/outside-folder", "FN: skin.png", "FN: ..\\skin.png"),
        one("texture/zero-tiling", "UT: 1.0", "UT: 0.0"),
        one("texture/rotation-axes", "UA: 0.0", "UA: 1.0"),
        one("texture/intensity", "In: 1.0", "In: 0.3"),
        one("geometry/index", "I: 0 2 1 1", "I: 0 4 1 1"),
        one(
            "geometry/layers",
            "TI: 0 1 2\n\t\tI: 0 1 3 1",
            "TI: 0 1 2\nTI: 0 1 2\nTI: 0 1 2\nTI: 0 1 2\nTI: 0 1 2\n\t\tI: 0 1 3 1",
        ),
        one("geometry/tessellation", "\tV_List: 3", "\tTF: 0\n\tBI: 0\n\tSC: 1\n\tV_List: 3"),
        one("geometry/large-tessellation", "\tV_List: 3", "\tTF: 100\n\tBI: 0\n\tSC: 1\n\tV_List: 3"),
        one("geometry/displacement-without-map", "\tV_List: 3", "\tTF: 2\n\tBI: 0\n\tSC: 1\n\tV_List: 3"),
        ("geometry/map-without-displacement", vec![("\tTS: N\n\tAC", format!("\tTS: N\n\tTD: Y\n{TEXTURE}\tAC"))]),
        (
            "geometry/displaced-hard-edges",
            vec![
                ("\tMatID: 0\n", "\tMatID: 0\n\tTF: 2\n\tBI: 0\n\tSC: 1\n".into()),
                ("I: 0 2 1 1", "I: 0 2 1 2".into()),
            ],
        ),
        one("geometry/degenerate-triangle", "I: 0 2 1 1", "I: 0 2 0 1"),
        one("geometry/duplicate-triangle", "I: 0 1 3 1", "I: 2 1 0 1"),
        one("geometry/unused-vertex", "I: 0 1 2 1\n\t\tENDGROUP\n\tAnim", "I: 0 1 1 1\n\t\tENDGROUP\n\tAnim"),
        one("geometry/group", "NEWGROUP: 1", "NEWGROUP: 46"),
        one("geometry/layer-count", "\t\tTI: 0 1 2\n\t\tI: 0 1 3 1", "\t\tI: 0 1 3 1"),
        one("geometry/smoothing-ignored", "GEOMETRY SmGEnabled", "GEOMETRY"),
        one("geometry/normal-length", "N_List: 1\n\t\t0 0 1", "N_List: 1\n\t\t0 0 2"),
        one("geometry/zero-normal", "N_List: 1\n\t\t0 0 1", "N_List: 1\n\t\t0 0 0"),
        one("geometry/vertex-color-range", "C_List: 4\n\t\t1 1 1", "C_List: 4\n\t\t1 2 1"),
        one("geometry/far-from-origin", "2 0 0\n\t\t3 0 0\n\t\t2 1 0", "2 0 1e6\n\t\t3 0 1e6\n\t\t2 1 1e6"),
        one("geometry/skin-bone", "2 1 1 1.0", "2 1 9 1.0"),
        one("geometry/skin-weights", "2 1 1 1.0", "2 1 1 0.7"),
        one("animation/frame-numbers", "Frame: 0", "Frame: 3"),
        one("animation/mode", "AAM_CHARACTER", "AAM_MESH"),
        one("animation/rate", "FPS: 25.0", "FPS: 0"),
        one("animation/unsorted-keys", "10 0 0 1 1.5", "-1 0 0 1 1.5"),
        one("animation/duplicate-key", "10 0 0 1 1.5", "0 0 0 1 1.5"),
        one("animation/repeated-track", "PsSam: 1\n\t\t\t0 0 0 0", "RtIPA: 1\n\t\t\t0 0 0 0"),
        one("animation/empty-track", "PsSam: 1\n\t\t\t0 0 0 0", "PsSam: 0"),
        one("animation/zero-axis", "10 0 0 1 1.5", "10 0 0 0 1.5"),
        one("animation/key-outside", "10 0 0 1 1.5", "11 0 0 1 1.5"),
        one("transform/zero-scale", "0 0 0 1 1 1\n\tMatID: 0", "0 0 0 1 0 1\n\tMatID: 0"),
        one(
            "transform/rotation",
            "TM: 1 0 0 0 1 0 0 0 1 0 0 0 1 1 1\n\tMatID: 0",
            "TM: 1 1 0 0 1 0 0 0 1 0 0 0 1 1 1\n\tMatID: 0",
        ),
        one("physics/no-object", "Body: 0 arm", "Body: 8 arm"),
        one("physics/name", "Body: 0 arm", "Body: 0 leg"),
        one("physics/duplicate-body", "Body: 1 hand", "Body: 0 arm"),
        one("physics/friction", "SF: 0.5", "SF: -0.5"),
        one("physics/restitution", "Re: 0.0", "Re: 1.5"),
        one("physics/mass", "\tMa: 1.0\n", ""),
        one("physics/unused-mass", "Re: 0.0\n}", "Re: 0.0\n\tMa: 2\n}"),
        one("physics/static-pieces", "Re: 0.0\n}", "Re: 0.0\n\tNPrim: 1\n\tSphere: 0 0 0 1\n}"),
        one("physics/no-shape", "Mode: Static", "Mode: Kinematic"),
        one("physics/static-empty", "I_List: 1 1\n\t\tNEWGROUP: 1\n\t\tI: 0 1 2 1\n\t\tENDGROUP", "I_List: 0"),
        one("physics/open-piece", "\t\t\tI: 0 3 2\n", "\t\t\tI: 0 2 1\n"),
        one(
            "physics/not-convex",
            "I: 0 2 1\n\t\t\tI: 0 1 3\n\t\t\tI: 1 2 3\n\t\t\tI: 0 3 2",
            "I: 0 1 2\n\t\t\tI: 0 3 1\n\t\t\tI: 1 3 2\n\t\t\tI: 0 2 3",
        ),
        one("physics/flat-piece", "0 0 1\n\t\tI_List", "1 1 0\n\t\tI_List"),
        ("physics/piece-vertices", vec![(piece, bipyramid(&ring, 70))]),
        ("physics/too-many-vertices", vec![(piece, bipyramid(&many, 300))]),
        one("physics/primitive", "Sphere: 0 0 0 1", "Sphere: 0 0 0 -1"),
    ]
}

/// For each code a source that deserves it, and the limits to read it with.
fn provoking() -> Vec<(&'static str, String, Limits)> {
    let standard = Limits::default();
    let from_clean = provocations().into_iter().map(|(code, changes)| {
        let source = changes.iter().fold(CLEAN.to_owned(), |source, (from, to)| changed(&source, from, to));
        (code, source, standard)
    });
    let (first, second) = MULTIFRAME.split_at(MULTIFRAME.find("Frame: 1").expect("a second frame"));
    let swapped = second.replacen("Obj: 0 a", "Obj: x", 1).replacen("Obj: 1 b", "Obj: 0 a", 1);
    let others = [
        ("animation/object-order", format!("{first}{}", swapped.replacen("Obj: x", "Obj: 1 b", 1)), standard),
        ("limit/objects", MULTIFRAME.into(), Limits { objects: 3, ..standard }),
        ("limit/vertices", CLEAN.into(), Limits { vertices: 10, ..standard }),
        ("limit/triangles", CLEAN.into(), Limits { triangles: 8, ..standard }),
        ("limit/frames", MULTIFRAME.into(), Limits { frames: 1, ..standard }),
    ];
    from_clean.chain(others).collect()
}

#[test]
fn every_code_is_given_by_a_file_that_deserves_it() {
    let mut provoked = BTreeSet::new();
    for (code, source, limits) in provoking() {
        let found = findings(&source, limits);
        let hit = found.iter().find(|finding| finding.code == code);
        let hit = hit.unwrap_or_else(|| panic!("{code} is not among {found:#?}"));
        let info = CODES.iter().find(|info| info.code == code).expect("a code of the table");
        assert_eq!(hit.severity, info.severity, "{code}");
        assert!(hit.position.is_some() || hit.subject == "animation", "{code} has no place");
        assert!(!hit.message.is_empty());
        provoked.insert(code);
    }
    // These need the file system and are given by the command.
    provoked.extend(["texture/missing", "texture/unreadable"]);
    let all: BTreeSet<&str> = CODES.iter().map(|info| info.code).collect();
    assert_eq!(all.len(), CODES.len(), "a code stands twice in the table");
    assert_eq!(provoked, all, "codes without a provocation");
}

/// Each finding as `aam check` shows it but for the file's name: the place, the sentence, the line with a marker.
#[test]
fn the_texts_of_findings_are_as_recorded() {
    let provoking = provoking();
    for group in groups() {
        let mut texts = String::new();
        for (code, source, limits) in provoking.iter().filter(|(code, ..)| code.split('/').next() == Some(group)) {
            let found = findings(source, *limits);
            let hit = found.iter().find(|finding| finding.code == *code).expect("it was provoked");
            texts.push_str(&format!("{hit}\n"));
            if let Some(position) = hit.position {
                let offset = Position::walk(source.as_bytes()).offset(position);
                texts.push_str(&format!("{}\n", Excerpt::at(source.as_bytes(), offset)));
            }
        }
        insta::with_settings!({ omit_expression => true }, { insta::assert_snapshot!(group, texts) });
    }
}

fn pattern(text: &str) -> CodePattern {
    text.parse().unwrap_or_else(|error| panic!("{text}: {error}"))
}

#[test]
fn codes_and_groups_are_named_and_slips_are_guessed() {
    assert!(pattern("material/shininess").matches("material/shininess"));
    assert!(!pattern("material/shininess").matches("material/number"));
    for group in ["material", "material/", "material/*"] {
        assert!(pattern(group).matches("material/number") && !pattern(group).matches("texture/missing"), "{group}");
    }
    for (wrong, near) in [
        ("material/shinyness", Some("material/shininess")),
        ("matreial", Some("material")),
        ("Texture/Missing", Some("texture/missing")),
        ("unknown-tag", Some("syntax/unknown-tag")),
        ("skin-weight", Some("geometry/skin-weights")),
        ("", None),
        ("no/such", None),
        ("*", None),
    ] {
        let error = CodePattern::from_str(wrong).expect_err(wrong);
        assert_eq!(error.near, near, "{wrong}");
    }
    assert_eq!(
        CodePattern::from_str("no/such").expect_err("unknown").to_string(),
        "there is no such finding; groups of findings are syntax, count, value, limit, object, material, texture, geometry, animation, transform, physics"
    );
}

#[test]
fn rules_choose_findings_and_set_their_severity() {
    let source = changed(&changed(CLEAN, "MatID: 0", "MatID: 2"), "Sh: 0.25", "Sh: 100.0");
    let found = |rules: &Rules| {
        let mut found = findings(&source, Limits::default());
        rules.apply(&mut found);
        found.iter().map(|finding| (finding.code, finding.severity)).collect::<Vec<_>>()
    };
    let (missing, shininess, unused) = ("object/material-missing", "material/shininess", "material/unused");
    let (error, warning, info) = (Severity::Error, Severity::Warning, Severity::Info);
    let all = Rules::default();
    assert_eq!(found(&all), [(unused, info), (shininess, warning), (missing, error)]);
    assert_eq!(
        found(&Rules { only: vec![pattern("material")], ..all.clone() }),
        [(unused, info), (shininess, warning)]
    );
    assert_eq!(found(&Rules { ignore: vec![pattern("material")], ..all.clone() }), [(missing, error)]);
    let both = Rules { only: vec![pattern("material")], ignore: vec![pattern(unused)], ..all.clone() };
    assert_eq!(found(&both), [(shininess, warning)]);
    assert_eq!(
        found(&Rules { strict: true, ..all.clone() }),
        [(unused, info), (shininess, error), (missing, error)],
        "strict makes errors of warnings alone"
    );
    // The code counts more than its group, whichever comes first, and both more than strictness.
    for severities in [
        [(pattern("material"), error), (pattern(shininess), info)],
        [(pattern(shininess), info), (pattern("material"), error)],
    ] {
        let rules = Rules { severities: severities.to_vec(), strict: true, ..all.clone() };
        assert_eq!(found(&rules), [(unused, error), (shininess, info), (missing, error)]);
        assert_eq!(rules.contradiction(), None);
    }
    let twice = Rules { severities: vec![(pattern("object/*"), info), (pattern("object"), warning)], ..all };
    assert_eq!(twice.contradiction(), Some(pattern("object")));
}

#[test]
fn the_page_of_codes_is_up_to_date() {
    let mut page = String::from(
        "# Findings of `aam check`\n\nEvery finding has a stable code and a severity. A finding of severity `error` makes `aam check` exit with 1.\n\n\
         - `--only CODE,…` and `--ignore CODE,…` choose what is shown. A code may also be a group: `texture` is all of `texture/…`.\n\
         - `--error CODE,…`, `--warning CODE,…` and `--info CODE,…` set the severity; a code counts more than its group.\n\
         - `--strict` makes errors of all warnings whose severity is not set.\n\
         - `--json` prints findings for programs, as [checks.schema.json](checks.schema.json) describes.\n\n\
         An error that ends the reading (`syntax/…`, `count/…`, `limit/…` and a few of `geometry/…`) is always shown, and always an error.\n\n\
         This page is made from the code table; \
         `UPDATE_DOCS=1 cargo test -p aam --test checks` writes it.\n",
    );
    let mut group = "";
    for info in CODES {
        let (this, _) = info.code.split_once('/').expect("group/what");
        if this != group {
            group = this;
            page.push_str(&format!("\n## {group}\n\n| code | severity | meaning | what to do |\n|---|---|---|---|\n"));
        }
        page.push_str(&format!("| `{}` | {} | {} | {} |\n", info.code, info.severity, info.meaning, info.remedy));
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/checks.md");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(path, &page).expect("writable docs");
    }
    let current = std::fs::read_to_string(path).unwrap_or_default();
    assert!(current == page, "docs/checks.md is out of date: UPDATE_DOCS=1 cargo test -p aam --test checks");
}
