//! What the reader accepts, what it refuses, and the words in which it does.

use aam::document::{Encoding, Flagged, Header, MaterialBody, TexCounts};
use aam::{Document, ReadOptions, ReadOutcome, Text, WriteOptions, read, write};

const SOURCE: &str = "\
AAM_MESH
MATERIALS
MatCount: 1
Mat# 0
{
	Name: TEXTURE PARQUET
	Class: Standard
	Am: 1.0 1.0 1.0
	Di: 1.0 0.5 1.0
	Sp: 0.0 0.0 0.0
	Tr: 0.0
	Sh: 0.1
	WS: 1.0
	Sh: BLINN
	Tx: Y
	{
		FN: TEXTURE PARQUET.jpg
		Fi: PYRAMIDAL
		Ch: 5
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
}
ENDMATERIALS
GEOMETRY SmGEnabled
NObj: 2
NFrames: 1
Animation_mode: None
Frame: 0
{
	Obj: 0 the first one
	Par: -1
	{
	MatID: 0
	UserProp: 
	V_List: 3
		0.0 -0.0 0.0
		1.0 0.0 0.0
		0.0 1.0 0.0
	TV_List: 3
		0.0 0.0
		1.0 0.0
		0.0 1.0
	I_List: 1 1
		NEWGROUP: 46
		I: 0 1 2 -2147483648
		TI: 0 1 2
		ENDGROUP
	}

	Obj: 1 node
	Par: 0
	{
	MatID: -1
	V_List: 0
	TV_List: 0
	I_List: 0
	}
}
ENDGEOMETRY
";

fn accept(source: &[u8]) -> ReadOutcome {
    read(source, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn refuse(source: &[u8]) -> (&'static str, String) {
    match read(source, &ReadOptions::default()) {
        Ok(_) => panic!("accepted:\n{}", String::from_utf8_lossy(source)),
        Err(error) => (error.code, error.to_string()),
    }
}

fn changed(from: &str, to: &str) -> String {
    assert!(SOURCE.contains(from), "{from:?} is not in the source");
    SOURCE.replacen(from, to, 1)
}

fn strict(source: &[u8]) -> bool {
    read(source, &ReadOptions { strict: true, ..ReadOptions::default() }).is_ok()
}

#[test]
fn a_document_holds_what_the_file_says() {
    let outcome = accept(SOURCE.as_bytes());
    assert!(outcome.findings.is_empty() && strict(SOURCE.as_bytes()));
    let document = outcome.document;
    assert_eq!(document.header, Some(Header::Mesh));
    let MaterialBody::Single(material) = &document.materials[0].body else { panic!("a single material") };
    assert_eq!(material.diffuse, [1.0, 0.5, 1.0]);
    assert_eq!(material.shading.as_ref().map(|shading| shading.word.decoded()), Some("BLINN".into()));
    assert_eq!(material.layers[0].as_ref().map(|texture| texture.file.decoded()), Some("TEXTURE PARQUET.jpg".into()));
    assert_eq!(material.layers[1], Flagged::No);
    assert_eq!(material.layers[2], Flagged::Omitted);
    let object = &document.objects()[0];
    assert_eq!((object.name.decoded().as_str(), object.parent), ("the first one", -1));
    assert_eq!(object.user_properties, Some(Text::from("")));
    assert_eq!(object.vertices[0][1].to_bits(), (-0.0f32).to_bits());
    let faces = object.faces.as_ref().expect("faces");
    assert_eq!(faces.triangles[0].smoothing, i32::MIN);
    assert_eq!((faces.groups[0].id, &faces.tex_counts), (46, &TexCounts::Uniform(1)));
    assert_eq!(write(&document, &WriteOptions::default()).expect("writable"), SOURCE.as_bytes(), "canonical already");
}

#[test]
fn any_line_end_and_indentation_will_do() {
    let expected = accept(SOURCE.as_bytes()).document;
    for end in ["\r\n", "\r", "\n\n", " \t\n   \t"] {
        let outcome = accept(SOURCE.replace('\n', end).as_bytes());
        assert!(outcome.findings.is_empty(), "{end:?}: {:?}", outcome.findings);
        assert_eq!(outcome.document, expected, "{end:?}");
    }
    let mixed: String =
        SOURCE.lines().zip(["\n", "\r", "\r\n"].into_iter().cycle()).flat_map(|(l, e)| [l, e]).collect();
    assert_eq!(accept(mixed.as_bytes()).document, expected);
}

#[test]
fn errors_say_where_what_and_what_instead() {
    for (from, to, text) in [
        (
            "Tr: 0.0",
            "Tr: none",
            "11:6: error[syntax/expected]: expected a number, found `none`\n    |  Tr: none\n    |      ^",
        ),
        (
            "Sp: 0.0 0.0 0.0\n\tTr: 0.0",
            "Tr: 0.0\n\tSp: 0.0 0.0 0.0",
            "10:2: error[syntax/tag-order]: expected `Sp:`, found `Tr:`, which belongs after it\n    |  Tr: 0.0\n    |  ^",
        ),
        (
            "MatID: 0",
            "matid: 0",
            "41:2: error[syntax/tag-case]: expected `MatID:`, found `matid:`; tags are case-sensitive\n    |  matid: 0\n    |  ^",
        ),
        (
            "V_List: 3",
            "V_List: 4000000000",
            "43:10: error[count/too-large]: 4000000000 vertices cannot fit into the 250 bytes that are left\n    |  V_List: 4000000000\n    |          ^",
        ),
        (
            "I: 0 1 2",
            "I: 0 3 2",
            "53:8: error[geometry/index]: index 3 is outside the vertices (V_List) (0 to 2)\n    |   I: 0 3 2 -2147483648\n    |        ^",
        ),
        (
            "TI: 0 1 2",
            "TI: 0 -1 2",
            "54:9: error[geometry/index]: index -1 is outside the texture vertices (TV_List) (0 to 2)\n    |   TI: 0 -1 2\n    |         ^",
        ),
        ("NObj: 2", "NObj: 3", "66:1: error[syntax/expected]: expected `Obj:`, found `}`\n    | }\n    | ^"),
        (
            "NObj: 2",
            "NObj: 1",
            "58:2: error[count/mismatch]: NObj says 1, but another object follows\n    |  Obj: 1 node\n    |  ^",
        ),
        (
            "ENDGEOMETRY",
            "",
            "68:1: error[syntax/expected]: expected `ENDGEOMETRY`, found the end of the file\n    | \n    | ^",
        ),
    ] {
        assert_eq!(refuse(changed(from, to).as_bytes()).1, text, "{from:?} → {to:?}");
    }
    let (code, text) = refuse(b"# Blender v2.79\no Cube\n");
    assert_eq!(
        (code, text.lines().next()),
        (
            "syntax/expected",
            Some("1:1: error[syntax/expected]: expected an AAM document, which starts with `MATERIALS`, found `#`")
        )
    );
    assert!(refuse(b"").1.contains("found the end of the file"));
}

#[test]
fn hostile_counts_and_indices_are_refused_before_they_cost_anything() {
    for (from, to, code) in [
        ("MatCount: 1", "MatCount: 4294967295", "count/too-large"),
        ("MatCount: 1", "MatCount: 99999999999999999999999", "count/too-large"),
        ("MatCount: 1", "MatCount: -1", "syntax/expected"),
        ("NObj: 2", "NObj: 4000000000", "count/too-large"),
        ("NFrames: 1", "NFrames: 4000000000", "count/too-large"),
        ("TV_List: 3", "TV_List: 4000000000", "count/too-large"),
        ("I_List: 1 1", "I_List: 4000000000 1", "count/too-large"),
        ("I_List: 1 1", "I_List: 1 4000000000", "count/too-large"),
        ("I: 0 1 2", "I: 0 1 -2147483648", "geometry/index"),
        ("I: 0 1 2", "I: 0 1 2147483647", "geometry/index"),
        ("I: 0 1 2", "I: 0 1 4294967295", "geometry/index"),
        ("I: 0 1 2", "I: 0 1 9999999999999999999999", "value/range"),
        ("MatID: 0", "MatID: 0.5", "syntax/expected"),
    ] {
        assert_eq!(refuse(changed(from, to).as_bytes()).0, code, "{from:?} → {to:?}");
    }
}

#[test]
fn a_million_nested_materials_are_refused() {
    let mut text = String::from("MATERIALS\nMatCount: 1\nMat# 0\n{\n");
    text.push_str(&"Name: m\nClass: Multi\nNSubs: 1\nSub 0\n{\n".repeat(1_000_000));
    assert_eq!(refuse(text.as_bytes()).0, "limit/nesting");
}

#[test]
fn values_that_are_not_finite_are_kept_with_a_warning() {
    for (text, check) in [
        ("-1.#IND", f32::is_nan as fn(f32) -> bool),
        ("1.#QNAN", f32::is_nan),
        ("nan", f32::is_nan),
        ("1e39", f32::is_infinite),
        ("-inf", f32::is_infinite),
    ] {
        let source = changed("0.0 1.0\n\tI_List", &format!("0.0 {text}\n\tI_List"));
        let outcome = accept(source.as_bytes());
        assert_eq!(outcome.findings.len(), 1, "{text}: {:?}", outcome.findings);
        assert_eq!(outcome.findings[0].code, "value/not-finite");
        let value = outcome.document.objects()[0].faces.as_ref().expect("faces").tex_coords[2][1];
        assert!(check(value), "{text} is read as {value}");
        assert!(!strict(source.as_bytes()));
        let again = write(&outcome.document, &WriteOptions::default()).expect("writable");
        let value = accept(&again).document.objects()[0].faces.as_ref().expect("faces").tex_coords[2][1];
        assert!(check(value), "{text} is written and read as {value}");
    }
}

#[test]
fn a_million_warnings_do_not_fill_the_memory() {
    let rows = "\t\t-1.#IND 0.0\n".repeat(100_000);
    let source = changed("TV_List: 3\n\t\t0.0 0.0\n\t\t1.0 0.0\n\t\t0.0 1.0\n", &format!("TV_List: 100000\n{rows}"));
    let findings = accept(source.as_bytes()).findings;
    assert!(findings.len() <= 21, "{} findings", findings.len());
    assert_eq!(findings.last().map(|f| f.message.as_str()), Some("99980 more of the same"));
}

#[test]
fn unknown_text_stays_in_its_place() {
    let source = changed("\tMatID: -1\n", "\tLastPose: 3 of 4\n\tMatID: -1\n")
        .replacen("\tWS: 1.0\n", "\tGloss: 0.25\n\t{\n\tInner: Y\n\t}\n\tWS: 1.0\n", 1)
        .replacen("\tV_List: 0\n", "\tW_List: 2\n\t1.0 2.0\n\t3.0 4.0\n\tV_List: 0\n", 1)
        .replacen("ENDGEOMETRY", "Note: the end\nENDGEOMETRY", 1)
        .replacen("MATERIALS\n", "SHADERS\nvoid main() { }\nENDSHADERS\nMATERIALS\n", 1);
    let outcome = accept(source.as_bytes());
    let codes: Vec<&str> = outcome.findings.iter().map(|finding| finding.code).collect();
    assert_eq!(codes, ["syntax/unknown-tag"; 5]);
    let written = write(&outcome.document, &WriteOptions::default()).expect("writable");
    assert_eq!(String::from_utf8_lossy(&written), source);
    assert!(!strict(source.as_bytes()));
    let meant = accept(changed("\tMatID: -1\n", "\tMatId2: 1\n\tMatID: -1\n").as_bytes());
    assert!(meant.findings[0].message.contains("did you mean `MatID:`?"), "{}", meant.findings[0]);
}

#[test]
fn unknown_rows_survive_binary_but_unknown_lists_cannot() {
    let with = |tag: &str| changed("\tMatID: -1\n", &format!("\tMatID: -1\n\t{tag} 2\n\t1.0 2.0\n\t3.0 4.0\n"));
    let binary = WriteOptions { encoding: Some(Encoding::Binary), ..WriteOptions::default() };
    let document = accept(with("Bones:").as_bytes()).document;
    let written = write(&document, &binary).expect("rows are text in either encoding");
    assert_eq!(accept(&written).document, Document { encoding: Encoding::Binary, ..document });
    let document = accept(with("W_List:").as_bytes()).document;
    let error = write(&document, &binary).expect_err("readers take it for binary data");
    assert_eq!(
        error.to_string(),
        "unknown text: \"W_List:\" cannot stand in a BINARY file: readers take it for binary data"
    );
}

#[test]
fn names_keep_their_bytes() {
    let mut source = SOURCE.as_bytes().to_vec();
    let at = source.windows(4).position(|window| window == b"node").expect("the name");
    for bytes in [&b"Gr\xfc\xdfe"[..], "Größe ✓".as_bytes(), b"nul\0 bell\x07", b"\xff\xfe\xc3("] {
        source
            .splice(at..at + source[at..].iter().position(|&b| b == b'\n').expect("a line end"), bytes.iter().copied());
        let document = accept(&source).document;
        assert_eq!(document.objects()[1].name.bytes(), bytes);
        assert_eq!(write(&document, &WriteOptions::default()).expect("writable"), source);
    }
    assert_eq!(Text::from(&b"Gr\xfc\xdfe"[..]).decoded(), "Grüße");
}

#[test]
fn a_form_feed_is_part_of_a_word() {
    let document = accept(changed("Fi: PYRAMIDAL", "Fi: \u{c}YRAMIDAL").as_bytes()).document;
    let again = write(&document, &WriteOptions::default()).expect("writable");
    assert_eq!(accept(&again).document, document);
}

#[test]
fn rows_broken_over_lines_are_read_as_numbers() {
    let source = changed(
        "\tMatID: -1",
        "\tPiv: 1 2 3\n0\n\t0 0 1\n\tMir: 0\n\tTM: 1 0\n 0 0 1 0 0 0 1\n5 6 7\n1 1 1\n\tMatID: -1",
    );
    let document = accept(source.as_bytes()).document;
    let node = document.objects()[1].node.expect("a transform");
    assert_eq!((node.pivot_position, node.position), ([1.0, 2.0, 3.0], [5.0, 6.0, 7.0]));
}

#[test]
fn one_huge_line_is_no_special_case() {
    let numbers = "0.5 ".repeat(3 * 300_000);
    let source = changed("V_List: 0", &format!("V_List: 300000 {numbers}"));
    assert_eq!(accept(source.as_bytes()).document.objects()[1].vertices.len(), 300_000);
}
