//! The table of all finding codes: what each means and how to mend it. `docs/checks.md` is made from it.

use crate::Severity;

/// One row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CodeInfo {
    /// The stable code.
    pub code: &'static str,
    /// Its severity, unless the user sets another.
    pub severity: Severity,
    /// What it means.
    pub meaning: &'static str,
    /// What to do.
    pub remedy: &'static str,
}

const fn error(code: &'static str, meaning: &'static str, remedy: &'static str) -> CodeInfo {
    CodeInfo { code, severity: Severity::Error, meaning, remedy }
}

const fn warning(code: &'static str, meaning: &'static str, remedy: &'static str) -> CodeInfo {
    CodeInfo { code, severity: Severity::Warning, meaning, remedy }
}

const fn info(code: &'static str, meaning: &'static str, remedy: &'static str) -> CodeInfo {
    CodeInfo { code, severity: Severity::Info, meaning, remedy }
}

/// The row of a code.
pub fn code_info(code: &str) -> Option<&'static CodeInfo> {
    CODES.iter().find(|info| info.code == code)
}

/// Every code that reading or checking can give, by group.
pub static CODES: &[CodeInfo] = &[
    // syntax
    error(
        "syntax/expected",
        "Something else stands where the grammar wants a certain word or number.",
        "Mend the line shown; the message says what belongs there.",
    ),
    error(
        "syntax/tag-order",
        "A known tag stands too early, too late or twice.",
        "Tags of a block have a fixed order: move the line.",
    ),
    error("syntax/tag-case", "A tag is right but for upper and lower case.", "Write the tag as the message shows it."),
    error(
        "syntax/misspelt-tag",
        "A tag that is needed is missing, and an unknown word much like it stands before that place.",
        "Write the tag as the message shows it.",
    ),
    warning(
        "syntax/unknown-tag",
        "A tag that the format does not know; it is kept in its place.",
        "Correct the spelling, or leave it if another program needs it.",
    ),
    error(
        "syntax/unknown-list",
        "An unknown list in a BINARY file, whose length nobody can know.",
        "Remove the list or convert the file to ASCII with the program that wrote it.",
    ),
    warning(
        "syntax/trailing-text",
        "Text after a tag's values, or after the document's end, is ignored.",
        "Remove it, or run `aam fmt`.",
    ),
    warning("syntax/stray-brace", "A `}` without its `{`, as some exporters write.", "Run `aam fmt`."),
    warning(
        "syntax/repeated-tag",
        "`Tx:` or `TS:` stands twice; the last one counts.",
        "Run `aam fmt`, or remove the first.",
    ),
    warning(
        "syntax/missing-tag",
        "`I_List:` without a `TV_List:` before it.",
        "Run `aam fmt`, which writes `TV_List: 0`.",
    ),
    warning("syntax/missing-count", "`I_List:` without the number of groups.", "Run `aam fmt`."),
    warning(
        "syntax/byte-order-mark",
        "A UTF-8 byte order mark stands before the document.",
        "Run `aam fmt`; other readers may refuse the file.",
    ),
    // counts, values, limits
    error(
        "count/too-large",
        "A count says more than the rest of the file could hold.",
        "The file is cut short, or the count is wrong.",
    ),
    error("count/mismatch", "A count and what follows do not agree.", "Correct the count or the list."),
    error("value/range", "A whole number does not fit 32 bits.", "Correct the number."),
    warning(
        "value/not-finite",
        "A number is not finite (`-1.#IND`, `1.#QNAN`, `inf`, `1e39`).",
        "Export again, or replace the value.",
    ),
    error(
        "limit/objects",
        "The document has more objects, counted again in each frame, than allowed.",
        "Raise the limit with `--max-objects` if the file is meant to be so large.",
    ),
    error(
        "limit/vertices",
        "The document has more vertices, counted again in each frame, than allowed.",
        "Raise the limit with `--max-vertices` if the file is meant to be so large.",
    ),
    error(
        "limit/triangles",
        "The document has more triangles than allowed.",
        "Raise the limit with `--max-triangles` if the file is meant to be so large.",
    ),
    error(
        "limit/frames",
        "The document has more frames than allowed.",
        "Raise the limit with `--max-frames` if the file is meant to be so large.",
    ),
    error(
        "limit/nesting",
        "Multi materials nest deeper than allowed.",
        "Flatten the material, or raise the limit with `--max-nesting`.",
    ),
    // structure
    error(
        "object/duplicate-id",
        "Two objects have the same id, so `Par:` and `Body:` are ambiguous.",
        "Give each object its own id.",
    ),
    warning(
        "object/missing-parent",
        "`Par:` names no object; the object counts as a root.",
        "Correct `Par:`, or write -1.",
    ),
    error(
        "object/parent-cycle",
        "An object is its own ancestor; the cycle is cut at the object named.",
        "Correct `Par:`.",
    ),
    info("object/empty-name", "An object has no name.", "Name it, so that people and scene files can refer to it."),
    info("object/duplicate-name", "Two objects share a name.", "Rename one if a scene file refers to it."),
    error("object/material-missing", "`MatID:` is neither -1 nor a material of the file.", "Correct `MatID:`."),
    info(
        "object/empty",
        "An object without triangles: a pure node.",
        "Nothing, if it is meant as a group or a locator.",
    ),
    // materials
    warning(
        "material/number",
        "The number after `Mat#` or `Sub` is not its position.",
        "Renumber; `MatID:` counts positions, `NEWGROUP:` numbers.",
    ),
    warning("material/duplicate-sub", "Two sub-materials have the same number; the first one counts.", "Renumber."),
    warning(
        "material/empty-multi",
        "A Multi material without sub-materials; the default material is drawn.",
        "Give it a sub-material, or make it single.",
    ),
    warning("material/color-range", "A component of `Am`, `Di` or `Sp` is outside [0, 1].", "Bring it into the range."),
    error("material/negative-emission", "A component of `SI` is negative.", "Emission adds light; make it 0 or more."),
    warning("material/transparency-range", "`Tr` is outside [0, 1] and is clamped.", "0 is opaque, 1 is invisible."),
    warning(
        "material/shininess",
        "`Sh` is above 1 but not above 128 and is taken as the exponent itself, or negative and is taken as none.",
        "Write the exponent divided by 128.",
    ),
    warning("material/alpha-cutoff-range", "`AC` is outside [0, 1].", "Bring it into the range."),
    warning(
        "material/light-and-normal-map",
        "A light map and a normal map on one material: the light map wins.",
        "Remove one of the two.",
    ),
    info(
        "material/displacement-without-shading-map",
        "A displacement map without a normal or light map: normals are those of the displaced surface.",
        "Add the normal map that belongs to the height map.",
    ),
    info("material/unused", "No object uses the material.", "Remove it if nothing else needs it."),
    // textures
    error(
        "texture/empty-name",
        "A texture block without a file name.",
        "Write the name after `FN:`, or `N` after the layer's tag.",
    ),
    warning(
        "texture/outside-folder",
        "A texture path is absolute or leaves the document's folder; it is not read unless allowed.",
        "Put the file beside the document and write its name alone.",
    ),
    warning(
        "texture/missing",
        "A texture file is not there; the layer counts as absent.",
        "Put it beside the document.",
    ),
    warning(
        "texture/unreadable",
        "A texture file cannot be decoded, or is over a limit; the layer counts as absent.",
        "Save it again as PNG or JPEG, or raise the limit that the message names.",
    ),
    warning(
        "texture/zero-tiling",
        "`UT` or `VT` is 0: the whole surface shows one line of texels.",
        "Write 1 for no tiling.",
    ),
    info(
        "texture/rotation-axes",
        "`UA` or `VA` is not 0; only `WA` turns a texture.",
        "Nothing, or move the angle to `WA`.",
    ),
    info(
        "texture/intensity",
        "`In` is not 1 on a layer where it is kept but not applied.",
        "Nothing; only a tangent-space normal map uses it.",
    ),
    // geometry
    error("geometry/index", "An index points outside its list.", "Export again; the file is damaged."),
    error("geometry/layers", "A triangle has more than four `TI:` rows.", "Export again; the file is damaged."),
    error("geometry/tessellation", "The tessellation factor is not a positive whole number.", "Write 1 or more."),
    warning(
        "geometry/large-tessellation",
        "The tessellation factor is above 64: each triangle becomes more than 4096.",
        "Lower `TF`, or model the detail.",
    ),
    warning(
        "geometry/displacement-without-map",
        "An object has `TF BI SC`, but none of its materials has a displacement map.",
        "Add `TD`, or remove the three tags.",
    ),
    warning(
        "geometry/map-without-displacement",
        "A material with a displacement map is used by an object without `TF BI SC`; it is not displaced.",
        "Add the three tags.",
    ),
    warning(
        "geometry/displaced-hard-edges",
        "A displaced object has several smoothing groups: its surface will tear at hard edges.",
        "Put all its triangles into one group.",
    ),
    info(
        "geometry/degenerate-triangle",
        "Triangles without area: two corners are the same, or all lie on a line.",
        "Remove them; they draw nothing.",
    ),
    info(
        "geometry/duplicate-triangle",
        "The same triangle twice; both copies fight for the same depth.",
        "Remove one.",
    ),
    info("geometry/unused-vertex", "Vertices that no triangle uses.", "Remove them."),
    warning(
        "geometry/group",
        "`NEWGROUP:` names no sub-material of the object's Multi material.",
        "Correct the id; another sub-material is drawn.",
    ),
    warning(
        "geometry/layer-count",
        "Triangles have more or fewer `TI:` rows than their material has layers.",
        "Layers without a row are not drawn; export again.",
    ),
    info(
        "geometry/smoothing-ignored",
        "Triangles have smoothing numbers, but `SmGEnabled` is missing.",
        "Write `GEOMETRY SmGEnabled` if they are meant.",
    ),
    warning(
        "geometry/normal-length",
        "Explicit normals are not of unit length.",
        "Normalise them; they are normalised when used.",
    ),
    error(
        "geometry/zero-normal",
        "An explicit normal is zero and gives no direction.",
        "Replace it by the face's normal.",
    ),
    warning("geometry/vertex-color-range", "Vertex colours are outside [0, 1].", "Bring them into the range."),
    warning(
        "geometry/far-from-origin",
        "The object is so far from the origin that 32-bit positions are coarser than a ten-thousandth of its size.",
        "Move it nearer and place it by the scene file.",
    ),
    error("geometry/skin-bone", "A skin names a bone that is no object of the file.", "Correct the bone's id."),
    warning("geometry/skin-weights", "The weights of a vertex are negative or do not sum to 1.", "Normalise them."),
    // animation
    warning("animation/object-order", "A later frame lists its objects in another order.", "Export again."),
    warning(
        "animation/frame-numbers",
        "The numbers after `Frame:` do not count 0, 1, 2 …; the order in the file counts.",
        "Renumber.",
    ),
    warning(
        "animation/mode",
        "The header, `Animation_mode` and the number of frames do not fit each other.",
        "Multiframe files are `Full`, characters are `Keyframe`, static files have one frame.",
    ),
    error("animation/rate", "`FPS` is not a positive number.", "Write the frames a second, or remove the tag for 30."),
    warning(
        "animation/unsorted-keys",
        "Keys are not in the order of their frames; they are sorted when used.",
        "Sort them.",
    ),
    warning("animation/duplicate-key", "Two keys of a track at the same frame; the last one counts.", "Remove one."),
    warning(
        "animation/repeated-track",
        "An object has two tracks for the same motion; the last one counts.",
        "Remove one.",
    ),
    info("animation/empty-track", "A track without keys.", "Remove it."),
    warning(
        "animation/zero-axis",
        "A rotation key with a zero axis counts as no rotation.",
        "Write any unit axis with angle 0.",
    ),
    info("animation/key-outside", "Keys lie outside the frames 0 … `NFrames` − 1.", "Raise `NFrames`."),
    warning(
        "transform/zero-scale",
        "`TM` scales an axis to 0: the object is flat and has no normals.",
        "Write 1 for no scale.",
    ),
    warning(
        "transform/rotation",
        "The nine rotation numbers of `TM` are not a rotation (not orthonormal within 1 %).",
        "Export again; the object will look sheared.",
    ),
    // physics
    error("physics/no-object", "A body names no object.", "Correct the id after `Body:`."),
    warning("physics/name", "A body's name is not its object's name; the id decides.", "Correct the name."),
    error("physics/duplicate-body", "An object has two bodies.", "Remove one."),
    error("physics/friction", "A friction coefficient is negative or not finite.", "Write 0 or more."),
    error("physics/restitution", "Restitution is outside [0, 1].", "0 keeps no speed in a bounce, 1 all of it."),
    error("physics/mass", "A dynamic body has no positive mass.", "Write `Ma:` in kilograms."),
    warning("physics/unused-mass", "A static or kinematic body has a mass, which means nothing.", "Remove `Ma:`."),
    warning(
        "physics/static-pieces",
        "A static body has convex pieces or primitives; its shape is the object's own triangles.",
        "Remove them.",
    ),
    error(
        "physics/no-shape",
        "A kinematic or dynamic body has neither primitives nor convex pieces.",
        "Run `aam convert --physics`.",
    ),
    error("physics/static-empty", "A static body's object has no triangles.", "Name an object that has a mesh."),
    error(
        "physics/open-piece",
        "A convex piece is not a closed surface.",
        "Make the pieces again with `aam convert --physics`.",
    ),
    error(
        "physics/not-convex",
        "A piece is not convex within 1e-4 of its diagonal, or inside out.",
        "Make the pieces again with `aam convert --physics`.",
    ),
    error("physics/flat-piece", "A convex piece has no volume.", "Remove it, or make the pieces again."),
    warning(
        "physics/piece-vertices",
        "A convex piece has more than 64 vertices, over the limit of engines that compute on the GPU.",
        "Make the pieces again with fewer vertices.",
    ),
    error(
        "physics/too-many-vertices",
        "A convex piece has more than 255 vertices, over the limit of common physics engines.",
        "Make the pieces again with fewer vertices.",
    ),
    error(
        "physics/primitive",
        "A primitive has a size that is not positive, or an orientation that is no quaternion.",
        "Correct its numbers.",
    ),
];
