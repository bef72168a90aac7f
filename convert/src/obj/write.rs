//! From assets to OBJ files.
//!
//! Each object is an `o` and a `g` of its name, in world coordinates at the first frame, with `v`, `vt`, `vn`, `usemtl`
//! and `s`. Masks are pairwise and `s` numbers are not: where the two cannot say the same, the normals (which are always
//! written) carry it, and the report says so.

use std::collections::{BTreeMap, HashMap};
use std::fmt::Write as _;

use aam::document::{Faces, Layer, Object};
use aam::meaning::{
    Hierarchy, Materials, SmoothingRule, frame_range, has_local_coordinates, object_normals, world_transforms,
};
use aam_scene::Up;
use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};

use crate::files::Files;
use crate::mesh::from_z_up;
use crate::{Asset, ConvertError, ExportOptions, Report};

use super::numbers::{Numbers, numbers};
use super::write_mtl::Library;

/// The OBJ file of an asset, its material library and its textures.
pub(crate) fn export(asset: &Asset, stem: &str, options: &ExportOptions) -> Result<Files, ConvertError> {
    let document = &asset.document;
    let mut files = Files::default();
    report_lost(asset, &mut files.report);
    let mut library = Library::new(asset, &mut files.report);
    let mut writer = Writer {
        up: options.up.unwrap_or(Up::Y),
        rule: SmoothingRule::of(document),
        materials: Materials::of(document),
        names: BTreeMap::new(),
        text: String::new(),
        bases: [1; 3],
        flips: 0,
    };
    if library.is_needed() {
        let _ = writeln!(writer.text, "mtllib {stem}.mtl");
    }
    let hierarchy = Hierarchy::of(document.objects());
    let first = frame_range(document).map_or(0.0, |(first, _)| first);
    let poses = world_transforms(document, &hierarchy, first);
    for (object, pose) in document.objects().iter().zip(&poses) {
        writer.object(object, pose, &mut library, &mut files.report);
    }
    if writer.flips > 0 {
        let note = format!("{} mirrored objects have their triangles turned, to face outwards", writer.flips);
        files.report.changed("", "winding", note, None);
    }
    files.main = writer.text.into_bytes();
    library.into_files(stem, asset, &mut files);
    Ok(files)
}

/// What an OBJ file has no place for.
fn report_lost(asset: &Asset, report: &mut Report) {
    let document = &asset.document;
    if has_local_coordinates(document) || frame_range(document).is_some() {
        let note = "the first frame is written, in world coordinates; OBJ has no animation";
        report.lost("", "animation", note);
    }
    let count = |has: &dyn Fn(&Object) -> bool| document.objects().iter().filter(|object| has(object)).count();
    for (property, lost, note) in [
        ("hierarchy", count(&|object| object.parent != -1), "objects have a parent, which OBJ cannot say"),
        ("skins", count(&|object| object.skin.as_ref().is_some()), "objects have bone weights"),
        ("user properties", count(&|object| object.user_properties.is_some()), "objects have user properties"),
        ("empty objects", count(&|object| faces_of(object).is_none()), "objects have no triangles and are left out"),
        ("physics", document.physics.as_ref().map_or(0, |physics| physics.bodies.len()), "bodies"),
        ("lights", asset.lights.len(), "lights"),
        ("cameras", asset.cameras.len(), "cameras"),
    ] {
        if lost > 0 {
            report.lost("", property, format!("{lost} {note}"));
        }
    }
}

fn faces_of(object: &Object) -> Option<&Faces> {
    object.faces.as_ref().filter(|faces| !faces.triangles.is_empty())
}

struct Writer {
    up: Up,
    rule: SmoothingRule,
    materials: Materials,
    /// How often an object's name occurred.
    names: BTreeMap<String, u32>,
    text: String,
    /// The next index of a `v`, a `vt` and a `vn` line.
    bases: [usize; 3],
    flips: usize,
}

/// One run of triangles with one material, and how they get texture coordinates.
struct Run {
    leaf: Option<usize>,
    triangles: std::ops::Range<usize>,
}

impl Writer {
    fn object(&mut self, object: &Object, pose: &Affine3A, library: &mut Library, report: &mut Report) {
        let Some(faces) = faces_of(object) else { return };
        let subject = format!("object \"{}\"", object.name);
        let name = self.unique_name(&object.name.decoded());
        let _ = write!(self.text, "o {name}\ng {name}\n");

        let colors = object.colors.as_ref().filter(|colors| colors.len() == object.vertices.len());
        let still = *pose == Affine3A::IDENTITY;
        for (index, vertex) in object.vertices.iter().enumerate() {
            let placed = if still { *vertex } else { pose.transform_point3(Vec3::from(*vertex)).to_array() };
            let [x, y, z] = from_z_up(self.up, placed).map(|value| if value.is_finite() { value } else { 0.0 });
            let _ = write!(self.text, "v {x} {y} {z}");
            if let Some([r, g, b]) = colors.map(|colors| colors[index]) {
                let _ = write!(self.text, " {r} {g} {b}");
            }
            self.text.push('\n');
        }

        let runs = self.runs(object, faces);
        let tex_coords = self.tex_coords(faces, &runs, &subject, library, report);
        let normals = self.normals(object, faces, pose, still);
        let flip = pose.matrix3.determinant() < 0.0;
        self.flips += usize::from(flip);
        let Numbers { numbers, exact } = numbers(faces, object.vertices.len(), self.rule);
        if !exact {
            let note = "groups overlap in a way that OBJ's numbers cannot say; the normals (vn) have it";
            report.changed(&subject, "smoothing groups", note, None);
        }

        let mut last_number = None;
        for run in &runs {
            if let Some(leaf) = run.leaf {
                library.use_leaf(leaf, object.displacement, &subject, report);
                let _ = writeln!(self.text, "usemtl {}", library.name(leaf));
            } else if library.is_needed() {
                self.text.push_str("usemtl\n");
            }
            for index in run.triangles.clone() {
                if last_number != Some(numbers[index]) {
                    last_number = Some(numbers[index]);
                    match numbers[index] {
                        0 => self.text.push_str("s off\n"),
                        number => drop(writeln!(self.text, "s {number}")),
                    }
                }
                self.face(faces, index, tex_coords[index], normals[index], object.vertices.len(), flip);
            }
        }
        self.bases[0] += object.vertices.len();
    }

    /// A triangle; one that names vertices that are not there is left out.
    fn face(
        &mut self,
        faces: &Faces,
        index: usize,
        tex_coords: Option<[usize; 3]>,
        normals: [usize; 3],
        vertices: usize,
        flip: bool,
    ) {
        let corners = faces.triangles[index].vertices;
        if corners.iter().any(|corner| *corner as usize >= vertices) {
            return;
        }
        self.text.push('f');
        for at in if flip { [0, 2, 1] } else { [0, 1, 2] } {
            let (vertex, normal) = (self.bases[0] + corners[at] as usize, normals[at]);
            let _ = match tex_coords {
                Some(tex_coords) => write!(self.text, " {vertex}/{}/{normal}", tex_coords[at]),
                None => write!(self.text, " {vertex}//{normal}"),
            };
        }
        self.text.push('\n');
    }

    fn runs(&self, object: &Object, faces: &Faces) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        let mut start = 0;
        let rest = aam::document::Group { id: 0, triangles: usize::MAX };
        for group in faces.groups.iter().chain([&rest]) {
            let end = start + group.triangles.min(faces.triangles.len() - start);
            if end > start {
                runs.push(Run { leaf: self.materials.lookup(object.material, group.id).leaf(), triangles: start..end });
            }
            start = end;
        }
        runs
    }

    /// Writes `vt` lines; gives the indices of each triangle's corners.
    fn tex_coords(
        &mut self,
        faces: &Faces,
        runs: &[Run],
        subject: &str,
        library: &Library,
        report: &mut Report,
    ) -> Vec<Option<[usize; 3]>> {
        let base = self.bases[1];
        let finite = |uv: [f32; 2]| uv.map(|value| if value.is_finite() { value } else { 0.0 });
        for [u, v] in faces.tex_coords.iter().copied().map(finite) {
            let _ = writeln!(self.text, "vt {u} {v}");
        }
        self.bases[1] += faces.tex_coords.len();

        let mut differing = 0;
        // Coordinates that a rotated texture needs in another place.
        let mut turned: HashMap<(usize, u32), usize> = HashMap::new();
        let mut lines = faces.tex_indices_of_triangles();
        let mut result = Vec::with_capacity(faces.triangles.len());
        for run in runs {
            let layers: Vec<Layer> =
                run.leaf.map_or_else(Vec::new, |leaf| self.materials.leaves()[leaf].present_layers().collect());
            let place = layers.iter().position(|layer| *layer == Layer::Diffuse).unwrap_or(0);
            let turn = run.leaf.and_then(|leaf| library.turn(leaf).map(|matrix| (leaf, matrix)));
            for given in lines.by_ref().take(run.triangles.len()) {
                let line = given.get(place).or(given.first());
                let line = line.filter(|line| line.iter().all(|index| (*index as usize) < faces.tex_coords.len()));
                differing += usize::from(given.iter().any(|other| Some(other) != line));
                result.push(line.map(|line| {
                    line.map(|index| match turn {
                        None => base + index as usize,
                        Some((leaf, matrix)) => *turned.entry((leaf, index)).or_insert_with(|| {
                            let uv = matrix.transform_point2(Vec2::from(finite(faces.tex_coords[index as usize])));
                            let _ = writeln!(self.text, "vt {} {}", uv.x, uv.y);
                            self.bases[1] += 1;
                            self.bases[1] - 1
                        }),
                    })
                }));
            }
        }
        if differing > 0 {
            let note = format!("{differing} triangles have further texture coordinates, and OBJ has one set");
            report.lost(subject, "texture coordinates", note);
        }
        result
    }

    /// Writes `vn` lines; gives the indices of each triangle's corners.
    fn normals(&mut self, object: &Object, faces: &Faces, pose: &Affine3A, still: bool) -> Vec<[usize; 3]> {
        let meant = object_normals(object, self.rule);
        let explicit = |triangle: usize, corner: usize| {
            let index = faces.normal_indices.get(triangle)?[corner];
            // As it is written, to the bit, where it says anything.
            let normal = Vec3::from(*faces.normals.as_ref()?.get(index as usize)?);
            (normal.is_finite() && normal != Vec3::ZERO).then_some(normal)
        };
        let matrix = normal_matrix(&pose.matrix3);
        let mut known: HashMap<[u32; 3], usize> = HashMap::new();
        let mut result = Vec::with_capacity(meant.len());
        for (triangle, corners) in meant.iter().enumerate() {
            result.push([0, 1, 2].map(|corner| {
                let normal = explicit(triangle, corner).unwrap_or(corners[corner]);
                let placed = if still {
                    normal
                } else {
                    Vec3::from((matrix * Vec3A::from(normal)).normalize_or(Vec3A::from(normal)))
                };
                let normal = from_z_up(self.up, placed.to_array()).map(|value| value + 0.0);
                *known.entry(normal.map(f32::to_bits)).or_insert_with(|| {
                    let [x, y, z] = normal;
                    let _ = writeln!(self.text, "vn {x} {y} {z}");
                    self.bases[2] += 1;
                    self.bases[2] - 1
                })
            }));
        }
        result
    }

    /// A name that no other object has, without what a reader would take for something else.
    fn unique_name(&mut self, name: &str) -> String {
        let name = clean(name, "object");
        let count = self.names.entry(name.clone()).or_default();
        *count += 1;
        if *count == 1 { name } else { format!("{name}_{count}") }
    }
}

/// A name as one word or several on a line.
pub(super) fn clean(name: &str, otherwise: &str) -> String {
    let name: String = name.chars().map(|c| if c.is_control() || c == '#' { '_' } else { c }).collect();
    let name = name.trim().trim_end_matches('\\');
    if name.is_empty() { otherwise.to_owned() } else { name.to_owned() }
}

/// Normals go by the inverse transpose; the cofactors are that but for a positive factor and the sign.
fn normal_matrix(matrix: &Mat3A) -> Mat3A {
    let cofactors = Mat3A::from_cols(
        matrix.y_axis.cross(matrix.z_axis),
        matrix.z_axis.cross(matrix.x_axis),
        matrix.x_axis.cross(matrix.y_axis),
    );
    if matrix.determinant() < 0.0 { -cofactors } else { cofactors }
}
