//! The statements of an OBJ file (Wavefront, "Object Files (.obj)", Advanced Visualizer appendix B1).

use std::collections::{BTreeMap, HashMap};

use crate::source::{Source, shown};
use crate::{ConvertError, Progress};

use super::statements::{Statement, Statements};

/// No index, no name.
pub(super) const NONE: u32 = u32::MAX;

/// What an OBJ file says.
#[derive(Default)]
pub(super) struct Model {
    pub(super) positions: Vec<[f32; 3]>,
    /// One for each position, white where a line has none; empty if no line has one.
    pub(super) colors: Vec<[f32; 3]>,
    /// v is 0 at the bottom.
    pub(super) tex_coords: Vec<[f32; 2]>,
    /// As written: not unit, perhaps not even finite.
    pub(super) normals: Vec<[f32; 3]>,
    /// The corners of all faces, one after the other; every index is in range.
    pub(super) corners: Vec<Corner>,
    /// The faces, with three corners at least.
    pub(super) faces: Vec<Face>,
    /// What faces have in common with the ones before them.
    pub(super) states: Vec<State>,
    pub(super) objects: Names,
    pub(super) groups: Names,
    pub(super) materials: Names,
    /// `mtllib` lines, as they stand.
    pub(super) libraries: Vec<String>,
    /// Whether there is an `s` line.
    pub(super) smoothing: bool,
    /// Points, lines, curves and whatever else is not in [`Model`]: how many of each statement.
    pub(super) ignored: BTreeMap<String, usize>,
    /// Faces with fewer than three corners.
    pub(super) small_faces: usize,
    /// `v` lines with a weight other than 1.
    pub(super) weights: usize,
    /// `vt` lines with a value that is no finite number, which became 0.
    pub(super) odd_tex_coords: usize,
}

/// A corner of a face.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub(super) position: u32,
    /// Or [`NONE`].
    pub(super) tex_coord: u32,
    /// Or [`NONE`].
    pub(super) normal: u32,
}

/// A polygon: the corners from `first` to the next face's.
#[derive(Clone, Copy)]
pub(super) struct Face {
    pub(super) first: u32,
    /// A position in [`Model::states`].
    pub(super) state: u32,
}

/// What `o`, `g`, `s` and `usemtl` said last.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct State {
    /// A position in [`Model::objects`], or [`NONE`].
    pub(super) object: u32,
    /// A position in [`Model::groups`], or [`NONE`].
    pub(super) group: u32,
    /// A position in [`Model::materials`], or [`NONE`].
    pub(super) material: u32,
    /// The smoothing group, 0 for none.
    pub(super) smoothing: i32,
}

/// Names in order of first use.
#[derive(Default)]
pub(super) struct Names {
    pub(super) list: Vec<String>,
    known: HashMap<String, u32>,
}

impl Names {
    fn number(&mut self, name: String) -> u32 {
        *self.known.entry(name).or_insert_with_key(|name| {
            self.list.push(name.clone());
            self.list.len() as u32 - 1
        })
    }
}

impl Model {
    /// The corners of a face.
    pub(super) fn corners_of(&self, face: usize) -> &[Corner] {
        let end = self.faces.get(face + 1).map_or(self.corners.len(), |next| next.first as usize);
        &self.corners[self.faces[face].first as usize..end]
    }
}

/// Statements that are known and mean nothing to a mesh; others are counted under their own names up to this many.
const MOST_IGNORED: usize = 40;

pub(super) fn parse(source: Source, progress: &dyn Progress) -> Result<Model, ConvertError> {
    let mut parser = Parser {
        source,
        model: Model::default(),
        state: State { object: NONE, group: NONE, material: NONE, smoothing: 0 },
        ahead: Vec::new(),
        known: 0,
    };
    progress.stage("reading", source.bytes.len() as u64);
    let mut statements = Statements::new(source.bytes);
    let mut told = 0;
    while let Some(mut statement) = statements.next() {
        if let Some((_, keyword)) = statement.word() {
            parser.statement(keyword, &mut statement)?;
        }
        if statements.offset() - told > 1 << 20 {
            told = statements.offset();
            progress.step(told as u64);
        }
    }
    parser.finish()
}

struct Parser<'a> {
    source: Source<'a>,
    model: Model,
    state: State,
    /// Indices of lines that had not come yet: kind, index, and where it stands.
    ahead: Vec<(Kind, u32, usize)>,
    /// How many statements were understood.
    known: usize,
}

#[derive(Clone, Copy)]
enum Kind {
    Position,
    TexCoord,
    Normal,
}

impl Kind {
    const fn word(self) -> &'static str {
        match self {
            Self::Position => "v",
            Self::TexCoord => "vt",
            Self::Normal => "vn",
        }
    }
}

impl Parser<'_> {
    fn statement(&mut self, keyword: &[u8], statement: &mut Statement) -> Result<(), ConvertError> {
        self.known += 1;
        match keyword {
            b"v" => self.vertex(statement)?,
            b"vt" => {
                let u = self.loose(statement, "a texture coordinate")?;
                let v = if statement.peek().is_some() { self.loose(statement, "a texture coordinate")? } else { 0.0 };
                self.model.odd_tex_coords += usize::from(!(u.is_finite() && v.is_finite()));
                self.model.tex_coords.push([u, v].map(|value| if value.is_finite() { value } else { 0.0 }));
            }
            b"vn" => {
                let mut normal = [0.0; 3];
                for value in &mut normal {
                    *value = self.loose(statement, "a normal's coordinate")?;
                }
                self.model.normals.push(normal);
            }
            b"f" | b"fo" => self.face(statement)?,
            b"o" => self.state.object = self.model.objects.number(statement.rest()),
            b"g" => self.state.group = self.model.groups.number(statement.rest()),
            b"s" => self.smoothing(statement)?,
            b"usemtl" => {
                let name = statement.rest();
                self.state.material = if name.is_empty() { NONE } else { self.model.materials.number(name) };
            }
            b"mtllib" => self.model.libraries.push(statement.rest()),
            _ => {
                self.known -= usize::from(!KNOWN.contains(&keyword));
                let name = shown(keyword);
                if self.model.ignored.len() < MOST_IGNORED || self.model.ignored.contains_key(&name) {
                    *self.model.ignored.entry(name).or_default() += 1;
                }
            }
        }
        Ok(())
    }

    /// A number that need not be finite: exporters write `nan` or `-1.#IND` for the normals and texture coordinates of
    /// faces without area, and the file is not broken by that.
    fn loose(&self, statement: &mut Statement, what: &str) -> Result<f32, ConvertError> {
        let word = statement.word();
        let number = word.and_then(|(_, word)| {
            let microsoft = || word.windows(2).any(|pair| pair[0] == b'#' && pair[1].is_ascii_uppercase());
            fast_float2::parse::<f32, _>(word).ok().or_else(|| microsoft().then_some(f32::NAN))
        });
        number.ok_or_else(|| self.source.unexpected(what, word, statement))
    }

    fn vertex(&mut self, statement: &mut Statement) -> Result<(), ConvertError> {
        let mut position = [0.0; 3];
        for value in &mut position {
            *value = self.source.number(statement, "a coordinate")?;
        }
        let mut more = [0.0; 4];
        let mut count = 0;
        while count < 4 && statement.peek().is_some() {
            more[count] = self.source.number(statement, "a weight or a colour")?;
            count += 1;
        }
        // x y z [w], x y z r g b, or x y z w r g b.
        let color = match count {
            3 => Some([more[0], more[1], more[2]]),
            4 => Some([more[1], more[2], more[3]]),
            _ => None,
        };
        self.model.weights += usize::from(matches!(count, 1 | 4) && more[0] != 1.0);
        if let Some(color) = color {
            self.model.colors.resize(self.model.positions.len(), [1.0; 3]);
            self.model.colors.push(color);
        } else if !self.model.colors.is_empty() {
            self.model.colors.push([1.0; 3]);
        }
        self.model.positions.push(position);
        Ok(())
    }

    fn smoothing(&mut self, statement: &mut Statement) -> Result<(), ConvertError> {
        let word = statement.word();
        self.model.smoothing = true;
        self.state.smoothing = match word {
            Some((_, b"off" | b"OFF" | b"Off" | b"null")) => 0,
            Some((_, digits)) => std::str::from_utf8(digits)
                .ok()
                .and_then(|digits| digits.parse::<u32>().ok())
                .map(u32::cast_signed)
                .ok_or_else(|| self.source.unexpected("a smoothing group or `off`", word, statement))?,
            None => return Err(self.source.unexpected("a smoothing group or `off`", word, statement)),
        };
        Ok(())
    }

    fn face(&mut self, statement: &mut Statement) -> Result<(), ConvertError> {
        let first = self.model.corners.len();
        while let Some((offset, word)) = statement.word() {
            let mut parts = word.split(|byte| *byte == b'/');
            let mut next = |kind: Kind, this: &mut Self| match parts.next() {
                None | Some(b"") => Ok(NONE),
                Some(part) => this.index(kind, part, offset, word),
            };
            let corner = Corner {
                position: next(Kind::Position, self)?,
                tex_coord: next(Kind::TexCoord, self)?,
                normal: next(Kind::Normal, self)?,
            };
            if corner.position == NONE || parts.next().is_some() {
                return Err(self.source.unexpected(
                    "a corner (v, v/vt, v//vn or v/vt/vn)",
                    Some((offset, word)),
                    statement,
                ));
            }
            self.model.corners.push(corner);
        }
        if self.model.corners.len() - first < 3 {
            self.model.corners.truncate(first);
            self.model.small_faces += 1;
            return Ok(());
        }
        if self.model.corners.len() >= NONE as usize {
            return Err(self.source.broken(statement.offset(), "the file has more than 2³² corners of faces"));
        }
        if self.model.states.last() != Some(&self.state) {
            self.model.states.push(self.state);
        }
        let state = self.model.states.len() as u32 - 1;
        self.model.faces.push(Face { first: first as u32, state });
        Ok(())
    }

    /// An index from a file: from 1 up, or from −1 (the line before) down.
    fn index(&mut self, kind: Kind, part: &[u8], offset: usize, word: &[u8]) -> Result<u32, ConvertError> {
        let count = match kind {
            Kind::Position => self.model.positions.len(),
            Kind::TexCoord => self.model.tex_coords.len(),
            Kind::Normal => self.model.normals.len(),
        } as i64;
        let number = integer(part).ok_or_else(|| {
            self.source
                .broken(offset, format!("expected an index of a `{}` line, found `{}`", kind.word(), shown(word)))
        })?;
        let index = if number < 0 { count + number } else { number - 1 };
        if number == 0 || index < 0 || index >= i64::from(NONE) {
            let message = match number {
                0 => "an index is 0; they start at 1".to_owned(),
                _ => format!("index {number} is out of range: there are {count} `{}` lines so far", kind.word()),
            };
            return Err(self.source.broken(offset, message));
        }
        if index >= count {
            self.ahead.push((kind, index as u32, offset));
        }
        Ok(index as u32)
    }

    fn finish(self) -> Result<Model, ConvertError> {
        let Self { source, model, ahead, known, .. } = self;
        for (kind, index, offset) in ahead {
            let count = match kind {
                Kind::Position => model.positions.len(),
                Kind::TexCoord => model.tex_coords.len(),
                Kind::Normal => model.normals.len(),
            };
            if index as usize >= count {
                let message = format!(
                    "index {} is out of range: the file has {count} `{}` lines",
                    u64::from(index) + 1,
                    kind.word()
                );
                return Err(source.broken(offset, message));
            }
        }
        if known == 0 && !model.ignored.is_empty() {
            return Err(source.broken(0, "this is not an OBJ file: it has no statement of that format"));
        }
        Ok(model)
    }
}

/// Statements of the format that are not used here.
const KNOWN: [&[u8]; 24] = [
    b"vp",
    b"p",
    b"l",
    b"curv",
    b"curv2",
    b"surf",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"mg",
    b"bevel",
    b"lod",
    b"usemap",
    b"maplib",
    b"shadow_obj",
    b"trace_obj",
];

fn integer(digits: &[u8]) -> Option<i64> {
    let (negative, digits) = match digits {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        _ => (false, digits),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut number = 0_i64;
    for digit in digits {
        number = 10 * number + i64::from(digit.is_ascii_digit().then(|| digit - b'0')?);
    }
    Some(if negative { -number } else { number })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Silent;
    use std::path::Path;

    fn read(text: &str) -> Result<Model, String> {
        let source = Source { path: Path::new("t.obj"), bytes: text.as_bytes() };
        parse(source, &Silent).map_err(|error| error.to_string().lines().next().unwrap_or_default().to_owned())
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0 0\nvt 1\nvn 0 0 1\n";

    #[test]
    fn corners_in_all_forms() {
        let text = format!("{SQUARE}f 1 2 3\nf 1/1 2/2 3/3\nf 1//1 2//1 3//1\nf 1/1/1 2/2/1 -2/-1/-1 -1/-3/-1\n");
        let model = read(&text).unwrap();
        let rows: Vec<Vec<[u32; 3]>> = (0..4)
            .map(|face| model.corners_of(face).iter().map(|c| [c.position, c.tex_coord, c.normal]).collect())
            .collect();
        assert_eq!(rows[0], [[0, NONE, NONE], [1, NONE, NONE], [2, NONE, NONE]]);
        assert_eq!(rows[1], [[0, 0, NONE], [1, 1, NONE], [2, 2, NONE]]);
        assert_eq!(rows[2], [[0, NONE, 0], [1, NONE, 0], [2, NONE, 0]]);
        assert_eq!(rows[3], [[0, 0, 0], [1, 1, 0], [2, 2, 0], [3, 0, 0]]);
        assert_eq!(model.tex_coords, [[0., 0.], [1., 0.], [1., 0.]]);
    }

    #[test]
    fn indices_are_checked() {
        for (line, message) in [
            ("f 1 2 0", "9:7: an index is 0; they start at 1"),
            ("f 1 2 5", "9:7: index 5 is out of range: the file has 4 `v` lines"),
            ("f 1 2 -5", "9:7: index -5 is out of range: there are 4 `v` lines so far"),
            ("f 1 2/4 3", "9:5: index 4 is out of range: the file has 3 `vt` lines"),
            ("f 1 2 3//2", "9:7: index 2 is out of range: the file has 1 `vn` lines"),
            ("f 1 2 x", "9:7: expected an index of a `v` line, found `x`"),
            ("f 1 2 3/1/1/1", "9:7: expected a corner (v, v/vt, v//vn or v/vt/vn), found `3/1/1/1`"),
            ("f 1 2 /1", "9:7: expected a corner (v, v/vt, v//vn or v/vt/vn), found `/1`"),
            ("f 1 2 99999999999999999999", "9:7: expected an index of a `v` line, found `99999999999999999999`"),
            ("v 1 nan 2", "9:5: expected a coordinate, found `nan`"),
            ("v 1 1e40 2", "9:5: expected a coordinate, found `1e40`"),
            ("v 1 2", "9:6: expected a coordinate, found the end of the line"),
            ("s x", "9:3: expected a smoothing group or `off`, found `x`"),
        ] {
            let error = read(&format!("{SQUARE}{line}\n")).err().unwrap_or_default();
            assert_eq!(error, format!("t.obj: {message}"), "{line}");
        }
        // An index of a line that comes later is out of order, but clear.
        assert!(read("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 1 1 0\n").is_ok());
        assert!(read("hello world\nthis is text\n").err().unwrap().contains("not an OBJ file"));
        assert!(read("").is_ok());
    }

    #[test]
    fn normals_and_texture_coordinates_that_are_no_numbers() {
        let model = read("v 0 0 0\nvt nan 0.5\nvt 0.25 -1.#IND00\nvn nan -1.#QNAN 0\n").unwrap();
        assert_eq!((&model.tex_coords[..], model.odd_tex_coords), (&[[0.0, 0.5], [0.25, 0.0]][..], 2));
        assert!(model.normals[0][0].is_nan() && model.normals[0][1].is_nan());
        assert!(read("vt x 0\n").is_err() && read("v 0 nan 0\n").is_err() && read("v 0 -1.#IND 0\n").is_err());
    }

    #[test]
    fn states_and_names() {
        let model = read(&format!(
            "{SQUARE}o my box\ng a b\nusemtl red\ns 3\nf 1 2 3\nf 1 3 4\ns off\nf 1 2 4\ng\nusemtl\ns 4294967295\nf 1 2 3\n"
        ))
        .unwrap();
        assert_eq!(model.objects.list, ["my box"]);
        assert_eq!(model.groups.list, ["a b", ""]);
        assert_eq!(model.faces.iter().map(|face| face.state).collect::<Vec<_>>(), [0, 0, 1, 2]);
        assert_eq!(model.states.iter().map(|state| state.smoothing).collect::<Vec<_>>(), [3, 0, -1]);
        assert_eq!(model.states[2].material, NONE);
    }

    #[test]
    fn colours_weights_and_what_is_ignored() {
        let model =
            read("v 1 2 3\nv 1 2 3 2\nv 1 2 3 .5 .25 0\nv 1 2 3 1 .1 .2 .3\nl 1 2\np 1\nl 2 3\nf 1 2\nwhat 3\n")
                .unwrap();
        assert_eq!(model.colors, [[1.0; 3], [1.0; 3], [0.5, 0.25, 0.0], [0.1, 0.2, 0.3]]);
        assert_eq!((model.weights, model.small_faces), (1, 1));
        let ignored: Vec<_> = model.ignored.iter().map(|(name, count)| (name.as_str(), *count)).collect();
        assert_eq!(ignored, [("l", 2), ("p", 1), ("what", 1)]);
    }
}
