//! Sources that the tests of findings change to provoke them.
#![allow(dead_code, reason = "each of them uses a part")]

/// A character with everything in it; no finding at all.
pub(crate) const CLEAN: &str = "\
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

/// Two frames of two objects without geometry; no finding of a reader.
pub(crate) const MULTIFRAME: &str = "\
MATERIALS
MatCount: 0
ENDMATERIALS
GEOMETRY
NObj: 2
NFrames: 2
Animation_mode: Full
Frame: 0
{
	Obj: 0 a
	Par: -1
	{
	MatID: -1
	V_List: 0
	}
	Obj: 1 b
	Par: -1
	{
	MatID: -1
	V_List: 0
	}
}
Frame: 1
{
	Obj: 0 a
	Par: -1
	{
	MatID: -1
	V_List: 0
	}
	Obj: 1 b
	Par: -1
	{
	MatID: -1
	V_List: 0
	}
}
ENDGEOMETRY
";

/// A texture's block.
pub(crate) const TEXTURE: &str =
    "{\nFN: n.png\nFi: PYRAMIDAL\nIn: 1\nUA: 0\nVA: 0\nWA: 0\nUO: 0\nVO: 0\nUT: 1\nVT: 1\n}\n";

/// A source with the first of one text replaced by another.
#[track_caller]
pub(crate) fn changed(source: &str, from: &str, to: &str) -> String {
    assert!(source.contains(from), "the source has no {from:?}");
    source.replacen(from, to, 1)
}

/// Multi materials within each other, that many deep.
pub(crate) fn nested(depth: usize) -> String {
    "Name: m\nClass: Multi\nNSubs: 1\nSub 0\n{\n".repeat(depth)
}
