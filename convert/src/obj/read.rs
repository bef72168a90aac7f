//! From OBJ files to assets.
//!
//! - An object is an `o`; in a file without `o`, it is a `g`. Parts of one name are one object.
//! - Smoothing: `s` groups become mask bits. Authored normals (`vn`) decide where they disagree with the `s` groups, or
//!   where there are none; a file with neither is flat, as the format says.
//! - Axes: +Y up unless told otherwise.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use aam::document::Triangle;
use aam::meaning::{SmoothingRule, corner_normals};
use aam::read_bytes;
use aam_scene::Up;

use crate::mesh::{Part, PartMaterial, PartTriangle, document, to_z_up};
use crate::polygon::Triangulator;
use crate::source::Source;
use crate::{Asset, ConvertError, ImportOptions, Progress, Report};

use super::material;
use super::mtl::{self, Mtl};
use super::parse::{Corner, Model, NONE, State, parse};
use super::textures::Textures;

/// Reads the bytes of an OBJ file, and its libraries.
pub(crate) fn import(
    bytes: Vec<u8>,
    path: &Path,
    options: &ImportOptions,
    progress: &dyn Progress,
) -> Result<Asset, ConvertError> {
    let source = Source { path, bytes: &bytes };
    let model = parse(source, progress)?;
    if model.faces.is_empty() {
        return Err(source.no_faces());
    }
    drop(bytes);
    progress.stage("meshes", 0);
    let mut asset = Asset::default();
    let report = &mut asset.report;
    report_ignored(&model, report);

    let mut textures = Textures::new(path, options);
    let library = libraries(path, &model, &mut textures, options, report);
    let materials = materials(&model, &library, &mut textures, report);
    asset.textures = textures.into_files();

    let up = options.up.unwrap_or(Up::Y);
    let faces = triangles(&model, report);
    let parts = parts(path, &model, &faces, up, options, report);
    asset.document = document(parts, &materials, options.normal_tolerance, options.keep_uvs, report);
    Ok(asset)
}

fn report_ignored(model: &Model, report: &mut Report) {
    for (statement, count) in &model.ignored {
        let what = match statement.as_str() {
            "l" => "lines: AAM has triangles only",
            "p" => "points: AAM has triangles only",
            "curv" | "curv2" | "surf" | "vp" | "parm" | "trim" | "hole" | "scrv" | "sp" | "end" | "con" | "cstype"
            | "deg" | "bmat" | "step" => "curves and free-form surfaces are not converted",
            _ => "a statement that means nothing to a mesh",
        };
        report.lost("", &format!("`{statement}` statements"), format!("{count}: {what}"));
    }
    if model.small_faces > 0 {
        report.lost("", "faces", format!("{} have fewer than three corners", model.small_faces));
    }
    if model.odd_tex_coords > 0 {
        let note = format!("{} are no finite numbers and become 0", model.odd_tex_coords);
        report.changed("", "texture coordinates", note, None);
    }
    if model.weights > 0 {
        report.lost(
            "",
            "vertex weights",
            format!("{} vertices have a weight, which polygons do not use", model.weights),
        );
    }
}

/// Reads the material libraries that can be found.
fn libraries(
    path: &Path,
    model: &Model,
    textures: &mut Textures,
    options: &ImportOptions,
    report: &mut Report,
) -> BTreeMap<String, (Mtl, String)> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut found = BTreeMap::new();
    for statement in &model.libraries {
        // A name may contain blanks, or a line may name several files.
        let whole = textures.library_file(statement);
        let files: Vec<&str> =
            if whole.is_ok() { vec![statement] } else { statement.split_ascii_whitespace().collect() };
        for file in files {
            let library = match textures.library_file(file) {
                Ok(library) => library,
                Err(reason) => {
                    report.lost("", "material library", format!("{file}: {reason}"));
                    continue;
                }
            };
            let bytes = match read_bytes(&library, &options.limits) {
                Ok(bytes) => bytes,
                Err(error) => {
                    report.lost("", "material library", error.to_string());
                    continue;
                }
            };
            let shown = library.strip_prefix(std::fs::canonicalize(folder).unwrap_or_default()).unwrap_or(&library);
            let prefix =
                file.replace('\\', "/").rsplit_once('/').map_or_else(String::new, |(prefix, _)| format!("{prefix}/"));
            for mtl in mtl::parse(Source { path: shown, bytes: &bytes }, report) {
                found.insert(mtl.name.clone(), (mtl, prefix.clone()));
            }
        }
    }
    found
}

/// The materials that faces use, in order of first use.
fn materials(
    model: &Model,
    library: &BTreeMap<String, (Mtl, String)>,
    textures: &mut Textures,
    report: &mut Report,
) -> Vec<PartMaterial> {
    let mut used = vec![false; model.materials.list.len()];
    model.states.iter().filter(|state| state.material != NONE).for_each(|state| used[state.material as usize] = true);
    let names: BTreeSet<&String> =
        model.materials.list.iter().zip(&used).filter(|(_, used)| **used).map(|(name, _)| name).collect();
    let unused = library.keys().filter(|name| !names.contains(name)).count();
    if unused > 0 {
        report.lost("", "materials", format!("{unused} of the library are used by no face"));
    }
    let names = model.materials.list.iter().zip(used);
    names
        .map(|(name, used)| {
            let unknown = Mtl { name: name.clone(), ..Mtl::default() };
            let mtl = match library.get(name) {
                Some((mtl, prefix)) => {
                    textures.library.clone_from(prefix);
                    mtl
                }
                None => {
                    if used {
                        let note = "no library has it; it becomes a grey one";
                        report.lost(&unknown.subject(), "material", note);
                    }
                    &unknown
                }
            };
            if !used {
                return PartMaterial { name: name.clone(), single: Default::default(), displacement: None };
            }
            let converted = material::convert(mtl, textures, report);
            PartMaterial { name: name.clone(), single: converted.single, displacement: converted.displacement }
        })
        .collect()
}

/// A triangle of the model.
struct Face {
    corners: [Corner; 3],
    state: u32,
}

/// Cuts all polygons.
fn triangles(model: &Model, report: &mut Report) -> Vec<Face> {
    let mut triangulator = Triangulator::default();
    let mut points = Vec::new();
    let mut cut = Vec::new();
    let mut faces = Vec::with_capacity(model.corners.len().saturating_sub(2 * model.faces.len()));
    let (mut odd, mut mixed) = (0, 0);
    for (index, face) in model.faces.iter().enumerate() {
        let corners = model.corners_of(index);
        let with = corners.iter().filter(|corner| corner.tex_coord != NONE).count();
        mixed += usize::from(with != 0 && with != corners.len());
        points.clear();
        points.extend(corners.iter().map(|corner| model.positions[corner.position as usize]));
        cut.clear();
        odd += usize::from(!triangulator.triangulate(&points, &mut cut));
        faces.extend(cut.iter().map(|triangle| Face {
            corners: triangle.map(|at| Corner {
                // Texture coordinates of some corners only are those of none.
                tex_coord: if with == corners.len() { corners[at as usize].tex_coord } else { NONE },
                ..corners[at as usize]
            }),
            state: face.state,
        }));
    }
    if odd > 0 {
        let note = format!("{odd} cross themselves or have no area; their triangles may overlap");
        report.changed("", "polygons", note, None);
    }
    if mixed > 0 {
        report.lost("", "texture coordinates", format!("{mixed} faces have them at some of their corners only"));
    }
    faces
}

fn parts(
    path: &Path,
    model: &Model,
    faces: &[Face],
    up: Up,
    options: &ImportOptions,
    report: &mut Report,
) -> Vec<Part> {
    let by_object = model.states.iter().any(|state| state.object != NONE);
    if by_object {
        let mut groups: BTreeMap<u32, (u32, bool)> = BTreeMap::new();
        for state in &model.states {
            let (first, several) = groups.entry(state.object).or_insert((state.group, false));
            *several |= *first != state.group;
        }
        let several = groups.values().filter(|(_, several)| *several).count();
        if several > 0 {
            report.lost("", "groups", format!("{several} objects (o) are divided into groups (g), which are not kept"));
        }
    }
    let names = if by_object { &model.objects.list } else { &model.groups.list };
    let key = |state: &State| if by_object { state.object } else { state.group };

    // The part of each state, in order of first use.
    let mut known: BTreeMap<u32, usize> = BTreeMap::new();
    let mut keys = Vec::new();
    let part_of: Vec<usize> = model
        .states
        .iter()
        .map(|state| {
            *known.entry(key(state)).or_insert_with(|| {
                keys.push(key(state));
                keys.len() - 1
            })
        })
        .collect();
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); keys.len()];
    for (index, face) in faces.iter().enumerate() {
        members[part_of[face.state as usize]].push(index as u32);
    }

    let smoothing = Smoothing::of(model, faces, keys.len() > 1);
    let stem = path.file_stem().map_or_else(|| "object".into(), |stem| stem.to_string_lossy().into_owned());
    let has_normals = faces.iter().flat_map(|face| face.corners).any(|corner| corner.normal != NONE);
    if !has_normals && !model.smoothing {
        let note = "the file has neither normals nor smoothing groups, so every face is flat";
        report.changed("", "normals", note, None);
    }
    let builder = Builder { model, faces, smoothing, up, tolerance: options.normal_tolerance };
    keys.iter()
        .zip(members)
        .map(|(key, members)| {
            let name = names.get(*key as usize).filter(|name| !name.is_empty()).unwrap_or(&stem);
            builder.part(name, &members)
        })
        .collect()
}

/// Which bits smoothing groups become, and the normals that they give where bits cannot.
struct Smoothing {
    /// The bit of each group.
    bits: BTreeMap<i32, i32>,
    /// The normals of all corners by the file's own rule: equal numbers are smooth, also from one object to another.
    /// `None` where masks within objects give the same.
    normals: Option<Vec<[[f32; 3]; 3]>>,
}

impl Smoothing {
    fn of(model: &Model, faces: &[Face], several_objects: bool) -> Self {
        let mut numbers: Vec<i32> = Vec::new();
        for state in model.states.iter().filter(|state| state.smoothing != 0) {
            if numbers.last() != Some(&state.smoothing) {
                numbers.push(state.smoothing);
            }
        }
        // In order of first use; the numbers 1 to 32 keep their bits where there are no others.
        let plain = numbers.iter().all(|number| (1..=32).contains(number));
        let mut bits = BTreeMap::new();
        for number in numbers {
            let next = bits.len() as u32;
            bits.entry(number).or_insert(if plain { number as u32 - 1 } else { next });
        }
        let enough = bits.len() <= 32;
        let bits: BTreeMap<i32, i32> =
            bits.into_iter().map(|(number, bit)| (number, 1_u32.checked_shl(bit).unwrap_or(0).cast_signed())).collect();
        let shared = several_objects && !bits.is_empty() && vertices_are_shared(model, faces);
        let normals = (!enough || shared).then(|| {
            let triangles: Vec<Triangle> = faces
                .iter()
                .map(|face| Triangle {
                    vertices: face.corners.map(|corner| corner.position),
                    smoothing: model.states[face.state as usize].smoothing,
                })
                .collect();
            let normals = corner_normals(&model.positions, &triangles, SmoothingRule::Numbers);
            normals.into_iter().map(|corners| corners.map(|normal| normal.to_array())).collect()
        });
        Self { bits, normals }
    }
}

/// Whether faces of different states, which may be different objects, meet at a vertex.
fn vertices_are_shared(model: &Model, faces: &[Face]) -> bool {
    let mut owner = vec![NONE; model.positions.len()];
    faces.iter().any(|face| {
        let state = &model.states[face.state as usize];
        let object = if state.object == NONE { state.group } else { state.object };
        face.corners.iter().any(|corner| {
            let owner = &mut owner[corner.position as usize];
            let foreign = *owner != NONE && *owner != object;
            *owner = object;
            foreign
        })
    })
}

struct Builder<'a> {
    model: &'a Model,
    faces: &'a [Face],
    smoothing: Smoothing,
    up: Up,
    tolerance: f32,
}

impl Builder<'_> {
    fn part(&self, name: &str, members: &[u32]) -> Part {
        let model = self.model;
        let corners = || members.iter().flat_map(|face| self.faces[*face as usize].corners);
        let mut vertices = Renumbered::new(corners().map(|corner| corner.position));
        let tex_coords = Renumbered::new(corners().map(|corner| corner.tex_coord).filter(|index| *index != NONE));
        let place = |index: &u32| to_z_up(self.up, model.positions[*index as usize]);
        let mut part = Part {
            name: name.to_owned(),
            vertices: vertices.list.iter().map(place).collect(),
            colors: Vec::new(),
            tex_coords: tex_coords.list.iter().map(|index| model.tex_coords[*index as usize]).collect(),
            ..Part::default()
        };
        if !model.colors.is_empty() {
            let brightest = model.colors.iter().flatten().copied().fold(0.0, f32::max);
            // Some programs write 0 to 255.
            let scale = if brightest > 1.0 && brightest <= 255.0 { 1.0 / 255.0 } else { 1.0 };
            let colors = std::mem::take(&mut vertices.list);
            let color = |index: &u32| model.colors.get(*index as usize).map_or([1.0; 3], |rgb| rgb.map(|c| c * scale));
            part.colors = colors.iter().map(color).collect();
        }
        for face in members {
            let face = &self.faces[*face as usize];
            let state = &model.states[face.state as usize];
            let textured = face.corners.iter().all(|corner| corner.tex_coord != NONE);
            part.triangles.push(PartTriangle {
                vertices: face.corners.map(|corner| vertices.number(corner.position)),
                tex_coords: textured.then(|| face.corners.map(|corner| tex_coords.number(corner.tex_coord))),
                material: (state.material != NONE).then_some(state.material),
                smoothing: self.smoothing.bits.get(&state.smoothing).copied().unwrap_or(0),
            });
        }
        self.smooth(&mut part, members);
        part
    }

    /// Gives the part the normals that it shall have where the masks of its `s` groups do not give them already.
    fn smooth(&self, part: &mut Part, members: &[u32]) {
        let authored = |corner: &Corner| match self.model.normals.get(corner.normal as usize) {
            Some(normal) => to_z_up(self.up, *normal),
            None => [0.0; 3],
        };
        let faces = || members.iter().map(|face| &self.faces[*face as usize]);
        if faces().flat_map(|face| &face.corners).any(|corner| corner.normal != NONE) {
            part.normals = faces().map(|face| [0, 1, 2].map(|at| authored(&face.corners[at]))).collect();
            if self.model.smoothing && part.masks_give_normals(self.tolerance) {
                part.normals.clear();
            } else {
                // Programs that write normals often repeat a position for each of them.
                part.weld();
            }
        } else if let Some(normals) = &self.smoothing.normals {
            part.normals = members.iter().map(|face| normals[*face as usize].map(|n| to_z_up(self.up, n))).collect();
        }
    }
}

/// The indices that an object uses of a file's list, and their numbers in a list of its own, in the same order.
struct Renumbered {
    list: Vec<u32>,
    /// The numbers as a table where the list is dense, to be quick.
    table: Vec<u32>,
    first: u32,
    sparse: BTreeMap<u32, u32>,
}

impl Renumbered {
    fn new(indices: impl Iterator<Item = u32> + Clone) -> Self {
        let (mut low, mut high, mut count) = (u32::MAX, 0, 0_usize);
        for index in indices.clone() {
            (low, high, count) = (low.min(index), high.max(index), count + 1);
        }
        let mut found = Self { list: Vec::new(), table: Vec::new(), first: low, sparse: BTreeMap::new() };
        if count == 0 {
            return found;
        }
        let span = (high - low) as usize + 1;
        if span <= 8 * count {
            found.table.resize(span, NONE);
            indices.for_each(|index| found.table[(index - low) as usize] = 0);
            for (at, number) in found.table.iter_mut().enumerate().filter(|(_, number)| **number == 0) {
                *number = found.list.len() as u32;
                found.list.push(low + at as u32);
            }
        } else {
            found.sparse = indices.map(|index| (index, 0)).collect();
            for (index, number) in &mut found.sparse {
                *number = found.list.len() as u32;
                found.list.push(*index);
            }
        }
        found
    }

    fn number(&self, index: u32) -> u32 {
        match self.table.get((index - self.first) as usize) {
            Some(number) => *number,
            None => self.sparse.get(&index).copied().unwrap_or(0),
        }
    }
}
