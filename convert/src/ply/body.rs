//! The data after the header.

use crate::source::{Source, Words, shown};
use crate::{ConvertError, Report};

use super::header::{Element, Format, Header, Property, Type};

/// What a PLY file says.
#[derive(Default)]
pub(super) struct Model {
    pub(super) positions: Vec<[f32; 3]>,
    /// One for each position, or none.
    pub(super) normals: Vec<[f32; 3]>,
    /// One for each position, or none; white is 1.
    pub(super) colors: Vec<[f32; 3]>,
    /// One for each position, or none; v is 0 at the bottom.
    pub(super) tex_coords: Vec<[f32; 2]>,
    /// The corners of all faces, one after the other; every index is in range.
    pub(super) corners: Vec<u32>,
    /// The first corner of each face; each has three at least.
    pub(super) faces: Vec<u32>,
    /// One for each corner, or none.
    pub(super) corner_tex_coords: Vec<[f32; 2]>,
    small_faces: usize,
    /// Elements and properties that are not used.
    unused: Vec<String>,
}

/// What a property of a vertex is for: a position in [`Vertex`].
const VERTEX: [(&str, usize); 21] = [
    ("x", 0),
    ("y", 1),
    ("z", 2),
    ("nx", 3),
    ("ny", 4),
    ("nz", 5),
    ("red", 6),
    ("green", 7),
    ("blue", 8),
    ("diffuse_red", 6),
    ("diffuse_green", 7),
    ("diffuse_blue", 8),
    ("r", 6),
    ("g", 7),
    ("b", 8),
    ("u", 9),
    ("v", 10),
    ("s", 9),
    ("t", 10),
    ("texture_u", 9),
    ("texture_v", 10),
];

type Vertex = [f64; 11];

pub(super) fn read(source: Source, header: &Header, report: &mut Report) -> Result<Model, ConvertError> {
    let mut data = Data { source, format: header.format, words: Words::new(source.bytes, header.end) };
    let mut model = Model::default();
    let mut strips = Vec::new();
    for element in &header.elements {
        data.check_room(element)?;
        match element.name.as_str() {
            "vertex" => model.vertices(&mut data, element)?,
            "face" => model.faces(&mut data, element)?,
            "tristrips" => model.strips(&mut data, element, &mut strips)?,
            _ => {
                if element.count > 0 {
                    model.leave_out(format!("{} × {}", element.count, element.name));
                }
                // What has no properties takes no bytes, however many there are of it.
                for _ in 0..if element.properties.is_empty() { 0 } else { element.count } {
                    for property in &element.properties {
                        data.skip(property)?;
                    }
                }
            }
        }
    }
    model.add_strips(&strips);
    let count = model.positions.len();
    if let Some(corner) = model.corners.iter().find(|corner| **corner as usize >= count) {
        let message = format!("a face names vertex {corner}, but there are {count}");
        return Err(source.broken_byte(header.end, message));
    }
    if !model.unused.is_empty() {
        report.lost("", "elements and properties", format!("not used: {}", model.unused.join(", ")));
    }
    if model.small_faces > 0 {
        report.lost("", "faces", format!("{} have fewer than three corners", model.small_faces));
    }
    Ok(model)
}

/// Names in the report.
const MOST_UNUSED: usize = 20;

impl Model {
    fn leave_out(&mut self, name: String) {
        if self.unused.len() < MOST_UNUSED && !self.unused.contains(&name) {
            self.unused.push(name);
        }
    }

    fn vertices(&mut self, data: &mut Data, element: &Element) -> Result<(), ConvertError> {
        let mut slots: Vec<Option<usize>> = Vec::new();
        let mut white = 1.0;
        for property in &element.properties {
            let known = VERTEX.iter().find(|(name, _)| *name == property.name).map(|(_, slot)| *slot);
            let slot = known.filter(|slot| property.length.is_none() && !slots.contains(&Some(*slot)));
            if slot.is_none() {
                self.leave_out(property.name.clone());
            }
            if slot == Some(6) {
                white = property.kind.white();
            }
            slots.push(slot);
        }
        let has = |wanted: std::ops::Range<usize>| wanted.clone().all(|slot| slots.contains(&Some(slot)));
        if !has(0..3) {
            return Err(data.source.broken(element.offset, "the vertices have no x, y and z"));
        }
        let (normals, colors, tex_coords) = (has(3..6), has(6..9), has(9..11));
        for _ in 0..element.count {
            let mut vertex: Vertex = [0.0; 11];
            let start = data.words.at;
            for (property, slot) in element.properties.iter().zip(&slots) {
                match slot {
                    Some(slot) => vertex[*slot] = data.scalar(property.kind)?,
                    None => data.skip(property)?,
                }
            }
            let [x, y, z, nx, ny, nz, r, g, b, u, v] = vertex.map(|value| value as f32);
            if !(x.is_finite() && y.is_finite() && z.is_finite()) {
                return Err(data.broken(start, "a vertex has a coordinate that is no finite number"));
            }
            self.positions.push([x, y, z]);
            self.normals.extend(normals.then_some([nx, ny, nz]));
            let scaled = |value: f32| if value.is_finite() { value / white as f32 } else { 1.0 };
            self.colors.extend(colors.then_some([scaled(r), scaled(g), scaled(b)]));
            self.tex_coords.extend(tex_coords.then_some([finite(u), finite(v)]));
        }
        Ok(())
    }

    fn faces(&mut self, data: &mut Data, element: &Element) -> Result<(), ConvertError> {
        let is_list = |property: &&Property| property.length.is_some();
        let indices = element.properties.iter().position(|property| {
            is_list(&property) && matches!(property.name.as_str(), "vertex_indices" | "vertex_index")
        });
        let Some(indices) = indices else {
            return Err(data.source.broken(element.offset, "the faces have no list `vertex_indices`"));
        };
        let coords = element.properties.iter().position(|property| is_list(&property) && property.name == "texcoord");
        for (at, property) in element.properties.iter().enumerate() {
            if at != indices && Some(at) != coords {
                self.leave_out(property.name.clone());
            }
        }
        let mut numbers = Vec::new();
        let mut uvs = Vec::new();
        for _ in 0..element.count {
            for (at, property) in element.properties.iter().enumerate() {
                if at == indices {
                    data.list(property, &mut numbers)?;
                } else if Some(at) == coords {
                    data.list(property, &mut uvs)?;
                } else {
                    data.skip(property)?;
                }
            }
            if numbers.len() < 3 {
                self.small_faces += 1;
                continue;
            }
            self.faces.push(data.number_of(self.corners.len())?);
            for number in &numbers {
                self.corners.push(data.index(*number)?);
            }
            if coords.is_some() {
                // u and v for each corner; a face without them has zeros.
                uvs.resize(2 * numbers.len(), 0.0);
                self.corner_tex_coords
                    .extend(uvs.chunks_exact(2).map(|uv| [finite(uv[0] as f32), finite(uv[1] as f32)]));
            }
        }
        Ok(())
    }

    /// Lists of vertices in which −1 begins a new strip.
    fn strips(&mut self, data: &mut Data, element: &Element, strips: &mut Vec<Vec<u32>>) -> Result<(), ConvertError> {
        let mut numbers = Vec::new();
        for _ in 0..if element.properties.is_empty() { 0 } else { element.count } {
            for property in &element.properties {
                if property.length.is_none() || !matches!(property.name.as_str(), "vertex_indices" | "vertex_index") {
                    data.skip(property)?;
                    continue;
                }
                data.list(property, &mut numbers)?;
                for strip in numbers.split(|number| *number < 0.0) {
                    strips.push(strip.iter().map(|number| data.index(*number)).collect::<Result<_, _>>()?);
                }
            }
        }
        Ok(())
    }

    /// Every other triangle of a strip is wound the other way.
    fn add_strips(&mut self, strips: &[Vec<u32>]) {
        for strip in strips {
            for (at, corners) in strip.windows(3).enumerate() {
                let [a, b, c] = [corners[0], corners[1], corners[2]];
                // Repeated vertices only steer the strip.
                if a != b && b != c && c != a {
                    self.faces.push(self.corners.len() as u32);
                    self.corners.extend(if at % 2 == 0 { [a, b, c] } else { [b, a, c] });
                    if !self.corner_tex_coords.is_empty() {
                        self.corner_tex_coords.extend([[0.0; 2]; 3]);
                    }
                }
            }
        }
    }
}

fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}

/// Where in the data the reader is.
struct Data<'a> {
    source: Source<'a>,
    format: Format,
    words: Words<'a>,
}

impl Data<'_> {
    fn broken(&self, offset: usize, message: impl Into<String>) -> ConvertError {
        match self.format {
            Format::Text => self.source.broken(offset, message),
            _ => self.source.broken_byte(offset, message),
        }
    }

    /// Counts are believed only as far as there are bytes for them.
    fn check_room(&self, element: &Element) -> Result<(), ConvertError> {
        // The last value of a text needs no blank after it.
        let left = (self.source.bytes.len() - self.words.at) as u64 + 1;
        let least = element.least_size(self.format);
        if element.count.saturating_mul(least) > left {
            let message = format!("{} × {} cannot be in the {left} bytes that are left", element.count, element.name);
            return Err(self.source.broken(element.offset, message));
        }
        Ok(())
    }

    fn scalar(&mut self, kind: Type) -> Result<f64, ConvertError> {
        if self.format == Format::Text {
            let found = self.words.next();
            let value = found.and_then(|(_, word)| fast_float2::parse::<f64, _>(word).ok());
            return value.ok_or_else(|| self.source.expected("a number", found, self.words.at));
        }
        let at = self.words.at;
        let Some(bytes) = self.source.bytes.get(at..at + kind.size()) else {
            return Err(self.broken(at, "the file ends in the middle of its data"));
        };
        self.words.at += kind.size();
        let mut little = [0_u8; 8];
        let little = &mut little[..kind.size()];
        little.copy_from_slice(bytes);
        if self.format == Format::BigEndian {
            little.reverse();
        }
        Ok(match (kind, &*little) {
            (Type::I8, &[a]) => f64::from(a.cast_signed()),
            (Type::U8, &[a]) => f64::from(a),
            (Type::I16, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
            (Type::U16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
            (Type::I32, &[a, b, c, d]) => f64::from(i32::from_le_bytes([a, b, c, d])),
            (Type::U32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
            (Type::F32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
            (Type::F64, &[a, b, c, d, e, f, g, h]) => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
            _ => 0.0,
        })
    }

    fn list(&mut self, property: &Property, values: &mut Vec<f64>) -> Result<(), ConvertError> {
        values.clear();
        let start = self.words.at;
        let length = self.scalar(property.length.unwrap_or(Type::U8))?;
        let least = if self.format == Format::Text { 2 } else { property.kind.size() };
        let most = (self.source.bytes.len() - self.words.at + 1) / least;
        if length.fract() != 0.0 || length < 0.0 || length > most as f64 {
            let message = format!("a list `{}` has {length} entries, but there are bytes for {most}", property.name);
            return Err(self.broken(start, message));
        }
        for _ in 0..length as usize {
            values.push(self.scalar(property.kind)?);
        }
        Ok(())
    }

    fn skip(&mut self, property: &Property) -> Result<(), ConvertError> {
        if property.length.is_some() {
            let mut values = Vec::new();
            return self.list(property, &mut values);
        }
        self.scalar(property.kind).map(drop)
    }

    fn index(&self, number: f64) -> Result<u32, ConvertError> {
        if number.fract() == 0.0 && (0.0..f64::from(u32::MAX)).contains(&number) {
            Ok(number as u32)
        } else {
            Err(self.broken(self.words.at, format!("a face names vertex {}", shown(number.to_string().as_bytes()))))
        }
    }

    fn number_of(&self, corners: usize) -> Result<u32, ConvertError> {
        u32::try_from(corners).map_err(|_| self.broken(self.words.at, "the file has more than 2³² corners of faces"))
    }
}
