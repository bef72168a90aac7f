//! Material libraries (Wavefront, "MTL material format", 1995, with the metallic-roughness keys of the 2014 proposal
//! "Physically-based rendering extensions to MTL" by Exocortex).
//!
//! A broken line spoils its own value and nothing else: the mesh can still be used.

use std::collections::BTreeMap;

use crate::source::{Source, shown};
use crate::{ConvertError, Report};

use super::statements::{Statement, Statements};

/// A `newmtl` block, as written.
#[derive(Clone, Debug, Default)]
pub(super) struct Mtl {
    pub(super) name: String,
    pub(super) ambient: Option<[f32; 3]>,
    pub(super) diffuse: Option<[f32; 3]>,
    pub(super) specular: Option<[f32; 3]>,
    pub(super) emission: Option<[f32; 3]>,
    /// `Ns`.
    pub(super) exponent: Option<f32>,
    /// `d`, else 1 − `Tr`.
    pub(super) opacity: Option<f32>,
    /// `illum`.
    pub(super) model: Option<i32>,
    /// `Pr`.
    pub(super) roughness: Option<f32>,
    /// `Pm`.
    pub(super) metallic: Option<f32>,
    pub(super) maps: BTreeMap<Slot, Map>,
    /// What has no place in a Phong material: statement and reason.
    pub(super) lost: Vec<(String, &'static str)>,
}

/// What a texture is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Slot {
    /// `map_Kd`
    Diffuse,
    /// `map_Ka`
    Ambient,
    /// `map_Ks`
    Specular,
    /// `map_Ke`
    Emission,
    /// `map_Ns`
    Exponent,
    /// `map_d`, `map_Tr`
    Opacity,
    /// `norm`: a tangent-space normal map
    Normal,
    /// `bump`, `map_bump`: heights that only shade
    Bump,
    /// `disp`: heights that move the surface
    Displacement,
    /// `map_Pr`
    Roughness,
    /// `map_Pm`
    Metallic,
    /// `refl`
    Reflection,
    /// `decal`
    Decal,
}

impl Slot {
    const ALL: [(Self, &'static [&'static str]); 13] = [
        (Self::Diffuse, &["map_Kd"]),
        (Self::Ambient, &["map_Ka"]),
        (Self::Specular, &["map_Ks"]),
        (Self::Emission, &["map_Ke"]),
        (Self::Exponent, &["map_Ns"]),
        (Self::Opacity, &["map_d", "map_Tr", "map_opacity"]),
        (Self::Normal, &["norm", "map_Kn", "map_norm"]),
        (Self::Bump, &["bump", "map_bump"]),
        (Self::Displacement, &["disp", "map_disp"]),
        (Self::Roughness, &["map_Pr"]),
        (Self::Metallic, &["map_Pm"]),
        (Self::Reflection, &["refl", "map_refl"]),
        (Self::Decal, &["decal"]),
    ];

    fn of(keyword: &[u8]) -> Option<Self> {
        let names = |names: &[&str]| names.iter().any(|name| name.as_bytes().eq_ignore_ascii_case(keyword));
        Self::ALL.iter().find(|(_, spellings)| names(spellings)).map(|(slot, _)| *slot)
    }

    /// The statement, for messages.
    pub(super) fn word(self) -> &'static str {
        Self::ALL.iter().find(|(slot, _)| *slot == self).map_or("map", |(_, spellings)| spellings[0])
    }
}

/// A texture statement.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    pub(super) file: String,
    /// `-o`
    pub(super) offset: [f64; 2],
    /// `-s`
    pub(super) scale: [f64; 2],
    /// `-bm`
    pub(super) bump: f32,
    /// `-mm base gain`
    pub(super) base: f32,
    pub(super) gain: f32,
    /// `-clamp on`
    pub(super) clamp: bool,
    /// `-imfchan`
    pub(super) channel: Option<u8>,
    /// Other options that would change the picture.
    pub(super) unused: Vec<String>,
}

impl Default for Map {
    fn default() -> Self {
        Self {
            file: String::new(),
            offset: [0.0; 2],
            scale: [1.0; 2],
            bump: 1.0,
            base: 0.0,
            gain: 1.0,
            clamp: false,
            channel: None,
            unused: Vec::new(),
        }
    }
}

/// The materials of a library, in order; the last of two with one name counts.
pub(super) fn parse(source: Source, report: &mut Report) -> Vec<Mtl> {
    let mut materials: Vec<Mtl> = Vec::new();
    let mut places: BTreeMap<String, usize> = BTreeMap::new();
    let mut current = None;
    let mut faults = 0;
    for mut statement in Statements::new(source.bytes) {
        let Some((offset, keyword)) = statement.word() else { continue };
        if keyword.eq_ignore_ascii_case(b"newmtl") {
            let name = statement.rest();
            let place = *places.entry(name.clone()).or_insert(materials.len());
            let material = Mtl { name, ..Mtl::default() };
            if place == materials.len() {
                materials.push(material);
            } else {
                materials[place] = material;
            }
            current = Some(place);
            continue;
        }
        let result = match current {
            Some(place) => materials[place].statement(source, keyword, &mut statement),
            None => Err(source.broken(offset, format!("`{}` stands before the first `newmtl`", shown(keyword)))),
        };
        if let Err(error) = result {
            faults += 1;
            if faults <= 20 {
                let subject = current.map_or_else(String::new, |place| materials[place].subject());
                report.lost(&subject, &shown(keyword), error.to_string());
            }
        }
    }
    if faults > 20 {
        report.lost("", "material library", format!("{}: {} further broken lines", source.path.display(), faults - 20));
    }
    materials
}

impl Mtl {
    /// What the report calls it.
    pub(super) fn subject(&self) -> String {
        format!("material \"{}\"", self.name)
    }

    fn statement(&mut self, source: Source, keyword: &[u8], statement: &mut Statement) -> Result<(), ConvertError> {
        if let Some(slot) = Slot::of(keyword) {
            let map = map(source, slot, statement)?;
            self.maps.insert(slot, map);
            return Ok(());
        }
        match keyword {
            b"Ka" => self.ambient = self.color(source, "Ka", statement)?,
            b"Kd" => self.diffuse = self.color(source, "Kd", statement)?,
            b"Ks" => self.specular = self.color(source, "Ks", statement)?,
            b"Ke" => self.emission = self.color(source, "Ke", statement)?,
            b"Ns" => self.exponent = Some(source.number(statement, "an exponent")?.max(0.0)),
            b"d" => {
                if statement.peek() == Some(b"-halo") {
                    statement.word();
                    self.lose("d -halo", "opacity does not depend on the angle of view");
                }
                self.opacity = Some(source.number(statement, "an opacity")?.clamp(0.0, 1.0));
            }
            b"Tr" => {
                let transparency = source.number(statement, "a transparency")?.clamp(0.0, 1.0);
                self.opacity.get_or_insert(1.0 - transparency);
            }
            b"illum" => self.model = Some(source.number(statement, "an illumination model")? as i32),
            b"Pr" => self.roughness = Some(source.number(statement, "a roughness")?.clamp(0.0, 1.0)),
            b"Pm" => self.metallic = Some(source.number(statement, "a metallic factor")?.clamp(0.0, 1.0)),
            b"Tf" => {
                if self.color(source, "Tf", statement)?.is_some_and(|filter| filter != [1.0; 3]) {
                    self.lose("Tf", "light is not coloured on its way through");
                }
            }
            b"Ps" | b"Pc" | b"Pcr" | b"aniso" | b"anisor" => {
                if source.number(statement, "a factor")? != 0.0 {
                    self.lose(&shown(keyword), "sheen, clear coat and anisotropy are not part of Phong");
                }
            }
            // Without reflected or refracted rays these say nothing.
            b"Ni" | b"sharpness" => {}
            _ => self.lose(&shown(keyword), "this statement is not known"),
        }
        Ok(())
    }

    fn lose(&mut self, statement: &str, reason: &'static str) {
        if self.lost.len() < 20 && !self.lost.iter().any(|(known, _)| known == statement) {
            self.lost.push((statement.to_owned(), reason));
        }
    }

    /// `r g b`, or `r` for grey; the `spectral` and `xyz` forms give nothing.
    fn color(
        &mut self,
        source: Source,
        keyword: &str,
        statement: &mut Statement,
    ) -> Result<Option<[f32; 3]>, ConvertError> {
        if matches!(statement.peek(), Some(b"spectral" | b"xyz")) {
            self.lose(keyword, "only colours given as red, green and blue are used");
            return Ok(None);
        }
        let red = source.number(statement, "a colour")?.max(0.0);
        if statement.peek().is_none() {
            return Ok(Some([red; 3]));
        }
        let green = source.number(statement, "a colour")?.max(0.0);
        let blue = source.number(statement, "a colour")?.max(0.0);
        Ok(Some([red, green, blue]))
    }
}

/// Options, then the file name, which may contain blanks.
fn map(source: Source, slot: Slot, statement: &mut Statement) -> Result<Map, ConvertError> {
    let mut map = Map::default();
    while let Some(option) = statement.peek().filter(|word| word.len() > 1 && word[0] == b'-') {
        let known: &[&[u8]] = &[
            b"-o",
            b"-s",
            b"-t",
            b"-mm",
            b"-bm",
            b"-clamp",
            b"-blendu",
            b"-blendv",
            b"-cc",
            b"-boost",
            b"-texres",
            b"-imfchan",
            b"-type",
        ];
        if !known.contains(&option) {
            // A file name may begin with `-`.
            break;
        }
        statement.word();
        let switch =
            |statement: &mut Statement| statement.word().is_some_and(|(_, word)| word.eq_ignore_ascii_case(b"on"));
        match option {
            b"-o" => map.offset = vector(source, statement, 0.0)?,
            b"-s" => map.scale = vector(source, statement, 1.0)?,
            b"-t" => {
                if vector(source, statement, 0.0)? != [0.0; 2] {
                    map.unused.push("-t".into());
                }
            }
            b"-mm" => {
                map.base = source.number(statement, "a base")?;
                map.gain = source.number(statement, "a gain")?;
            }
            b"-bm" => map.bump = source.number(statement, "a bump multiplier")?,
            b"-clamp" => map.clamp = switch(statement),
            b"-cc" => {
                if switch(statement) {
                    map.unused.push("-cc on".into());
                }
            }
            b"-boost" | b"-texres" => {
                source.number(statement, "a number")?;
            }
            b"-imfchan" => map.channel = statement.word().and_then(|(_, word)| word.first().copied()),
            // Blending between pixels is always on; `-type` is for reflection maps.
            _ => {
                statement.word();
            }
        }
    }
    map.file = statement.rest();
    if map.file.is_empty() {
        return Err(source.unexpected("a file name", None, statement));
    }
    if slot == Slot::Reflection {
        map.unused.clear();
    }
    Ok(map)
}

/// Up to three numbers, of which the first two count.
fn vector(source: Source, statement: &mut Statement, default: f64) -> Result<[f64; 2], ConvertError> {
    let mut values = [default; 3];
    let mut count = 0;
    let number = |word: &[u8]| fast_float2::parse::<f64, _>(word).ok().filter(|number| number.is_finite());
    while count < 3
        && let Some(value) = statement.peek().and_then(number)
    {
        values[count] = value;
        count += 1;
        statement.word();
    }
    if count == 0 {
        let found = statement.word();
        return Err(source.unexpected("a number", found, statement));
    }
    Ok([values[0], values[1]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn read(text: &str) -> (Vec<Mtl>, Report) {
        let mut report = Report::default();
        let materials = parse(Source { path: Path::new("t.mtl"), bytes: text.as_bytes() }, &mut report);
        (materials, report)
    }

    #[test]
    fn values_and_maps() {
        let (materials, report) = read(
            "newmtl dark wood\nKa 0.1\nKd .5 .25 .125\nKs 1 1 1\nKe 0 0 2\nNs 96.5\nTr 0.25\nillum 2\nPr .4\nPm 1\nNi 1.45\n\
             map_Kd -s 2 3 1 -o 0.5 -clamp on my textures\\dark wood.png\nbump -bm 0.3 -imfchan r h.png\n\
             map_Bump -bm 0.5 h2.png\ndisp -mm -0.1 0.2 -texres 512 d.png\nnorm -n.png\nmap_d a.png\nKd 2\nd 0.5\n",
        );
        assert_eq!(report.changes, []);
        let [wood] = &materials[..] else { panic!("{materials:?}") };
        assert_eq!(wood.name, "dark wood");
        assert_eq!((wood.ambient, wood.diffuse), (Some([0.1; 3]), Some([2.0; 3])));
        assert_eq!((wood.emission, wood.exponent, wood.opacity), (Some([0.0, 0.0, 2.0]), Some(96.5), Some(0.5)));
        assert_eq!((wood.model, wood.roughness, wood.metallic), (Some(2), Some(0.4), Some(1.0)));
        let diffuse = &wood.maps[&Slot::Diffuse];
        assert_eq!(diffuse.file, "my textures\\dark wood.png");
        assert_eq!((diffuse.scale, diffuse.offset, diffuse.clamp), ([2.0, 3.0], [0.5, 0.0], true));
        assert_eq!((wood.maps[&Slot::Bump].bump, wood.maps[&Slot::Bump].file.as_str()), (0.5, "h2.png"));
        let displacement = &wood.maps[&Slot::Displacement];
        assert_eq!((displacement.base, displacement.gain, displacement.file.as_str()), (-0.1, 0.2, "d.png"));
        assert_eq!(wood.maps[&Slot::Normal].file, "-n.png");
        assert_eq!(wood.maps[&Slot::Opacity].file, "a.png");
    }

    #[test]
    fn opacity_wins_over_transparency() {
        for text in ["newmtl a\nd 0.25\nTr 0.5\n", "newmtl a\nTr 0.5\nd 0.25\n"] {
            assert_eq!(read(text).0[0].opacity, Some(0.25));
        }
    }

    #[test]
    fn broken_lines_are_reported_and_the_rest_is_used() {
        let (materials, report) =
            read("Kd 1 1 1\nnewmtl a\nKd 0.8,0.8 1\nKs 1 1 1\nmap_Kd -s\nmap_Ks\nKa xyz 1 1 1\nwhat 3\n");
        assert_eq!((materials[0].diffuse, materials[0].specular), (None, Some([1.0; 3])));
        let notes: Vec<String> =
            report.changes.iter().map(|change| change.note.lines().next().unwrap_or_default().to_owned()).collect();
        assert_eq!(
            notes,
            [
                "t.mtl: 1:1: `Kd` stands before the first `newmtl`",
                "t.mtl: 3:4: expected a colour, found `0.8,0.8`",
                "t.mtl: 5:10: expected a number, found the end of the line",
                "t.mtl: 6:7: expected a file name, found the end of the line",
            ]
        );
        let lost: Vec<&str> = materials[0].lost.iter().map(|(statement, _)| statement.as_str()).collect();
        assert_eq!(lost, ["Ka", "what"]);
    }

    #[test]
    fn the_last_of_two_materials_with_one_name() {
        let (materials, _) = read("newmtl a\nKd 1 0 0\nnewmtl b\nnewmtl a\nKs 1 1 1\n");
        assert_eq!(materials.iter().map(|material| material.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
        assert_eq!((materials[0].diffuse, materials[0].specular), (None, Some([1.0; 3])));
    }
}
