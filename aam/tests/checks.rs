//! Every code of the table is given by a file that deserves it, and by no clean file.

use std::collections::BTreeSet;

use aam::check::CODES;
use aam::{Finding, ReadOptions, check, read};

/// A character with everything in it; no finding at all.
const CLEAN: &str = "\
AAM_CHARACTER
MATERIALS
MatCount: 2
Mat# 0
{
	Name: skin
	Class: Standard
	Am: 0.5 0.5 0.5
	Di: 0.5 0.5 0.5
	Sp: 0.0 0.0 0.0
	Tr: 0.0
	Sh: 0.25
	SI: 0.0 0.0 0.0
	Tx: Y
	{
		FN: skin.png
		Fi: PYRAMIDAL
		In: 1.0
		UA: 0.0
		VA: 0.0
		WA: 0.0
		UO: 0.0
		VO: 0.0
		UT: 1.0
		VT: 1.0
	}
	TS: N
	AC: 0.5
}
Mat# 1
{
	Name: both
	Class: Multi
	NSubs: 2
	Sub 0
	{
		Name: a
		Class: Standard
		Am: 0.5 0.5 0.5
		Di: 0.5 0.5 0.5
		Sp: 0.0 0.0 0.0
		Tr: 0.0
		Sh: 0.0
		Tx: N
		TS: N
	}
	Sub 1
	{
		Name: b
		Class: Standard
		Am: 0.5 0.5 0.5
		Di: 0.5 0.5 0.5
		Sp: 0.0 0.0 0.0
		Tr: 0.0
		Sh: 0.0
		Tx: N
		TS: N
	}
}
ENDMATERIALS
GEOMETRY SmGEnabled
NObj: 2
NFrames: 11
Animation_mode: Keyframe
FPS: 25.0
Frame: 0
{
	Obj: 0 arm
	Par: -1
	{
	Piv: 0 0 0 0 0 0 0
	Mir: 0
	TM: 1 0 0 0 1 0 0 0 1 0 0 0 1 1 1
	MatID: 0
	V_List: 4
		0 0 0
		1 0 0
		0 1 0
		0 0 1
	SKIN: Y
		0 1 0 1.0
		1 1 0 1.0
		2 1 1 1.0
		3 2 0 0.5 1 0.5
	C_List: 4
		1 1 1
		1 1 1
		1 1 1
		1 1 1
	TV_List: 3
		0 0
		1 0
		0 1
	N_List: 1
		0 0 1
	I_List: 4 1
		NEWGROUP: 0
		I: 0 2 1 1
		NI: 0 0 0
		TI: 0 1 2
		I: 0 1 3 1
		NI: 0 0 0
		TI: 0 1 2
		I: 1 2 3 1
		NI: 0 0 0
		TI: 0 1 2
		I: 0 3 2 1
		NI: 0 0 0
		TI: 0 1 2
		ENDGROUP
	Anim_Ctrl: Y
		RtSam: 2
			0 0 0 1 0.5
			10 0 0 1 1.5
		PsSam: 1
			0 0 0 0
	}
	Obj: 1 hand
	Par: 0
	{
	Piv: 0 0 0 0 0 0 0
	Mir: 0
	TM: 1 0 0 0 1 0 0 0 1 0 0 0 1 1 1
	MatID: 1
	V_List: 3
		2 0 0
		3 0 0
		2 1 0
	TV_List: 0
	I_List: 1 1
		NEWGROUP: 1
		I: 0 1 2 1
		ENDGROUP
	Anim_Ctrl: N
	}
}
ENDGEOMETRY
PHYSICS
NBody: 2
Body: 0 arm
{
	Mode: Dynamic
	SF: 0.5
	DF: 0.5
	Re: 0.0
	Ma: 1.0
	NPrim: 1
		Sphere: 0 0 0 1
	NConvex: 1
	Convex: 0
	{
		V_List: 4
			0 0 0
			1 0 0
			0 1 0
			0 0 1
		I_List: 4
			I: 0 2 1
			I: 0 1 3
			I: 1 2 3
			I: 0 3 2
	}
}
Body: 1 hand
{
	Mode: Static
	SF: 0.5
	DF: 0.5
	Re: 0.0
}
ENDPHYSICS
";

/// All findings of a source, a refusal to read included.
fn findings(source: &str) -> Vec<Finding> {
    match read(source.as_bytes(), &ReadOptions::default()) {
        Ok(outcome) => {
            let mut findings = outcome.findings;
            findings.extend(check(&outcome.document, Some((source.as_bytes(), &outcome.places))));
            findings
        }
        Err(error) => vec![Finding {
            code: error.code,
            severity: aam::Severity::Error,
            position: Some(error.position),
            subject: String::new(),
            message: error.message,
        }],
    }
}

#[test]
fn a_clean_file_has_no_findings() {
    assert_eq!(findings(CLEAN), []);
    let strict = ReadOptions { strict: true, ..ReadOptions::default() };
    read(CLEAN.as_bytes(), &strict).unwrap_or_else(|error| panic!("{error}"));
}

fn nested(depth: usize) -> String {
    let mut text = String::new();
    for _ in 0..depth {
        text.push_str("Name: m\nClass: Multi\nNSubs: 1\nSub 0\n{\n");
    }
    text
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
    let texture = "{\nFN: n.png\nFi: PYRAMIDAL\nIn: 1\nUA: 0\nVA: 0\nWA: 0\nUO: 0\nVO: 0\nUT: 1\nVT: 1\n}\n";
    vec![
        one("syntax/expected", "MatCount: 2", "MatCount: two"),
        one("syntax/tag-order", "Tr: 0.0\n\tSh: 0.25", "Sh: 0.25\n\tTr: 0.0"),
        one("syntax/tag-case", "MatID: 0", "MatId: 0"),
        one("syntax/unknown-tag", "\tMatID: 0", "\tMadID: 3\n\tMatID: 0"),
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
        ("material/light-and-normal-map", vec![("\tTS: N\n\tAC", format!("\tTS: Y\n{texture}\tTN: Y\n{texture}\tAC"))]),
        (
            "material/displacement-without-shading-map",
            vec![("\tTS: N\n\tAC", format!("\tTS: N\n\tTD: Y\n{texture}\tAC"))],
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
        ("geometry/map-without-displacement", vec![("\tTS: N\n\tAC", format!("\tTS: N\n\tTD: Y\n{texture}\tAC"))]),
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

/// A later frame with its objects in another order needs a multiframe file.
const MULTIFRAME: &str = "MATERIALS\nMatCount: 0\nENDMATERIALS\nGEOMETRY\nNObj: 2\nNFrames: 2\nAnimation_mode: Full\n\
Frame: 0\n{\nObj: 0 a\nPar: -1\n{\nMatID: -1\nV_List: 0\n}\nObj: 1 b\nPar: -1\n{\nMatID: -1\nV_List: 0\n}\n}\n\
Frame: 1\n{\nObj: 1 b\nPar: -1\n{\nMatID: -1\nV_List: 0\n}\nObj: 0 a\nPar: -1\n{\nMatID: -1\nV_List: 0\n}\n}\nENDGEOMETRY\n";

#[test]
fn every_code_is_given_by_a_file_that_deserves_it() {
    let mut provoked = BTreeSet::new();
    for (code, changes) in provocations() {
        let mut source = CLEAN.to_owned();
        for (from, to) in &changes {
            assert!(source.contains(from), "{code}: the clean file has no {from:?}");
            source = source.replacen(from, to, 1);
        }
        let found = findings(&source);
        let hit = found.iter().find(|finding| finding.code == code);
        let hit = hit.unwrap_or_else(|| panic!("{code} is not among {found:#?}"));
        let info = CODES.iter().find(|info| info.code == code).expect("a code of the table");
        assert_eq!(hit.severity, info.severity, "{code}");
        assert!(hit.position.is_some() || hit.subject == "animation", "{code} has no place");
        assert!(!hit.message.is_empty());
        provoked.insert(code);
    }
    assert!(findings(MULTIFRAME).iter().any(|finding| finding.code == "animation/object-order"));
    provoked.insert("animation/object-order");
    // These need the file system and are given by the command.
    provoked.extend(["texture/missing", "texture/unreadable"]);
    let all: BTreeSet<&str> = CODES.iter().map(|info| info.code).collect();
    assert_eq!(all.len(), CODES.len(), "a code stands twice in the table");
    assert_eq!(provoked, all, "codes without a provocation");
}

#[test]
fn the_page_of_codes_is_up_to_date() {
    let mut page = String::from(
        "# Findings of `aam check`\n\nEvery finding has a stable code. Severity `error` makes `aam check` exit with 1; in strict mode each \
         irregularity that the reader accepts with a warning is an error too.\n\nThis page is made from the code table; \
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
