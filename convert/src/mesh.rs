//! Meshes on their way into a document: normals to smoothing, materials to groups.

use std::collections::{BTreeMap, HashMap};

use aam::Document;
use aam::document::{
    Displacement, Faces, Flagged, Frame, Geometry, Group, Header, Material, MaterialBody, Object, Rgb, SingleMaterial,
    Triangle,
};
use aam::meaning::{SmoothingRule, corner_normals};
use glam::Vec3;

use crate::smoothing::{Recovered, recover};
use crate::{Report, uv_lines};

/// An object as an importer reads it.
#[derive(Default)]
pub(crate) struct Part {
    pub(crate) name: String,
    /// In AAM's axes.
    pub(crate) vertices: Vec<[f32; 3]>,
    /// One for each vertex, or none.
    pub(crate) colors: Vec<Rgb>,
    /// v is 0 at the bottom.
    pub(crate) tex_coords: Vec<[f32; 2]>,
    pub(crate) triangles: Vec<PartTriangle>,
    /// Normals that corners shall have, one triple for each triangle, or none.
    pub(crate) normals: Vec<[[f32; 3]; 3]>,
}

/// A triangle of a [`Part`].
#[derive(Clone, Copy)]
pub(crate) struct PartTriangle {
    pub(crate) vertices: [u32; 3],
    pub(crate) tex_coords: Option<[u32; 3]>,
    /// A position in the list of materials.
    pub(crate) material: Option<u32>,
    /// A 3ds Max mask.
    pub(crate) smoothing: i32,
}

/// A material as an importer reads it.
pub(crate) struct PartMaterial {
    pub(crate) name: String,
    pub(crate) single: SingleMaterial,
    pub(crate) displacement: Option<Displacement>,
}

/// From a file's axes to AAM's, for positions and for directions.
pub(crate) fn to_z_up(up: aam_scene::Up, [x, y, z]: [f32; 3]) -> [f32; 3] {
    match up {
        // Not `-z` alone, so that 0 does not become −0.
        aam_scene::Up::Y => [x, 0.0 - z, y],
        aam_scene::Up::Z => [x, y, z],
    }
}

/// From AAM's axes to a file's; the inverse of [`to_z_up`].
pub(crate) fn from_z_up(up: aam_scene::Up, [x, y, z]: [f32; 3]) -> [f32; 3] {
    match up {
        aam_scene::Up::Y => [x, z, 0.0 - y],
        aam_scene::Up::Z => [x, y, z],
    }
}

impl Part {
    /// Makes vertices of equal position and colour one, so that smoothing crosses where they meet. Vertices keep the
    /// order of first use; those that no triangle uses go.
    pub(crate) fn weld(&mut self) {
        let mut known: HashMap<([u32; 3], [u32; 3]), u32> = HashMap::new();
        let mut vertices = Vec::new();
        let mut colors = Vec::new();
        // Adding zero makes −0 and 0 one place.
        let bits = |values: [f32; 3]| values.map(|value| (value + 0.0).to_bits());
        for triangle in &mut self.triangles {
            for index in &mut triangle.vertices {
                let at = *index as usize;
                let color = self.colors.get(at).copied();
                let key = (bits(self.vertices[at]), color.map_or([0; 3], bits));
                *index = *known.entry(key).or_insert_with(|| {
                    vertices.push(self.vertices[at]);
                    colors.extend(color);
                    vertices.len() as u32 - 1
                });
            }
        }
        (self.vertices, self.colors) = (vertices, colors);
    }

    /// Whether the masks of the triangles give [`Part::normals`] within a tolerance in degrees.
    pub(crate) fn masks_give_normals(&self, tolerance: f32) -> bool {
        let triangles: Vec<Triangle> = self
            .triangles
            .iter()
            .map(|triangle| Triangle { vertices: triangle.vertices, smoothing: triangle.smoothing })
            .collect();
        let limit = f64::from(tolerance).to_radians().max(2e-6);
        corner_normals(&self.vertices, &triangles, SmoothingRule::Masks).iter().zip(&self.normals).all(
            |(given, wanted)| {
                given.iter().zip(wanted).all(|(given, wanted)| {
                    let wanted = Vec3::from(*wanted).as_dvec3();
                    // A normal that is zero or not finite asks for nothing.
                    wanted.try_normalize().is_none_or(|wanted| {
                        2.0 * (0.5 * (given.as_dvec3() - wanted).length()).min(1.0).asin() <= limit
                    })
                })
            },
        )
    }

    /// Replaces the masks by those that give [`Part::normals`], or as near as masks come.
    fn recover(&mut self, tolerance: f32) -> Recovered {
        let triangles: Vec<[u32; 3]> = self.triangles.iter().map(|triangle| triangle.vertices).collect();
        let recovered = recover(&self.vertices, &triangles, &self.normals, tolerance);
        for (triangle, mask) in self.triangles.iter_mut().zip(&recovered.masks) {
            triangle.smoothing = *mask;
        }
        recovered
    }
}

/// Makes a static document of parts. `tolerance` is that of [`recover`]; `keep_uvs` gives triangles a `TI:` line even
/// where their material has no texture.
pub(crate) fn document(
    parts: Vec<Part>,
    materials: &[PartMaterial],
    tolerance: f32,
    keep_uvs: bool,
    report: &mut Report,
) -> Document {
    let mut used = Used { materials, list: Vec::new(), known: BTreeMap::new() };
    let mut objects = Vec::with_capacity(parts.len());
    for part in parts {
        let id = objects.len() as i32;
        objects.push(object(id, part, &mut used, tolerance, keep_uvs, report));
    }
    Document {
        header: Some(Header::Mesh),
        materials: used.list,
        geometry: Geometry {
            smoothing_groups: true,
            animation_frames: 1,
            frames: vec![Frame { objects, ..Frame::default() }],
            ..Geometry::default()
        },
        ..Document::default()
    }
}

fn object(id: i32, mut part: Part, used: &mut Used, tolerance: f32, keep_uvs: bool, report: &mut Report) -> Object {
    let subject = format!("object \"{}\"", part.name);
    let mut explicit = None;
    if !part.normals.is_empty() && !part.masks_give_normals(tolerance) {
        let recovered = part.recover(tolerance);
        if recovered.explicit.is_some() {
            report.changed(
                &subject,
                "normals",
                format!(
                    "explicit normals are written, since no smoothing groups give {} of {} corners; {} bytes",
                    recovered.corners_off, recovered.corners, recovered.explicit_bytes
                ),
                Some(format!("{:.2}° without them", recovered.worst_degrees)),
            );
        } else {
            report.changed(
                &subject,
                "normals",
                "smoothing groups give them back",
                Some(format!("{:.3}°", recovered.worst_degrees)),
            );
        }
        explicit = recovered.explicit;
    }

    // Triangles of one material stand together, in order of the material's first use.
    let mut order: Vec<Option<u32>> = Vec::new();
    let mut rank: BTreeMap<Option<u32>, usize> = BTreeMap::new();
    let ranks: Vec<usize> = part
        .triangles
        .iter()
        .map(|triangle| {
            *rank.entry(triangle.material).or_insert_with(|| {
                order.push(triangle.material);
                order.len() - 1
            })
        })
        .collect();
    let mut sorted: Vec<usize> = (0..part.triangles.len()).collect();
    sorted.sort_by_key(|index| ranks[*index]);
    let mut totals = vec![0; order.len()];
    ranks.iter().for_each(|rank| totals[*rank] += 1);

    let material = used.material(&part.name, &order);
    let mut faces = Faces::default();
    let mut counts = Vec::with_capacity(sorted.len());
    for index in &sorted {
        let triangle = &part.triangles[*index];
        faces.triangles.push(Triangle { vertices: triangle.vertices, smoothing: triangle.smoothing });
        let layers = triangle.material.map_or(0, |material| {
            let layers = &used.materials[material as usize].single.layers;
            layers.iter().filter(|layer| layer.as_ref().is_some()).count()
        });
        let lines = triangle.tex_coords.map_or(0, |_| layers.max(usize::from(keep_uvs)));
        faces.tex_indices.extend(triangle.tex_coords.iter().flat_map(|indices| std::iter::repeat_n(*indices, lines)));
        counts.push(lines as u8);
    }
    faces.tex_counts = uv_lines::tex_counts(counts);
    faces.tex_coords = part.tex_coords;
    uv_lines::drop_unused(&mut faces);
    if faces.tex_indices.is_empty() && part.triangles.iter().any(|triangle| triangle.tex_coords.is_some()) {
        report.lost(&subject, "texture coordinates", "its materials have no texture, so nothing would use them");
    }
    // In a Multi the id is the position of the sub-material, else it repeats `MatID`.
    let ids = (0..).map(|sub| if order.len() > 1 { sub } else { material });
    faces.groups = ids.zip(totals).map(|(id, triangles)| Group { id, triangles }).collect();
    if let Some(explicit) = explicit {
        faces.normal_indices = sorted.iter().map(|index| explicit.indices[*index]).collect();
        faces.normals = Some(explicit.normals);
    }

    let displaced = || order.iter().flatten().map(|material| used.materials[*material as usize].displacement);
    let displacement = displaced().flatten().next();
    if displaced().flatten().any(|other| Some(other) != displacement) {
        report.lost(
            &subject,
            "displacement",
            "its materials displace differently; the first one's values hold for all",
        );
    }
    Object {
        id,
        name: aam::Text::one_line(&part.name),
        parent: -1,
        material,
        displacement,
        vertices: part.vertices,
        skin: Flagged::Omitted,
        colors: (!part.colors.is_empty()).then_some(part.colors),
        faces: Some(faces),
        ..Object::default()
    }
}

/// The document's materials, as objects come to need them.
struct Used<'a> {
    materials: &'a [PartMaterial],
    list: Vec<Material>,
    /// Where in the list the combination of materials is.
    known: BTreeMap<Vec<Option<u32>>, i32>,
}

impl Used<'_> {
    /// `MatID` for an object with these materials: objects with the same ones in the same order share.
    fn material(&mut self, name: &str, order: &[Option<u32>]) -> i32 {
        if let [] | [None] = order {
            return -1;
        }
        if let Some(known) = self.known.get(order) {
            return *known;
        }
        let number = self.list.len() as i32;
        self.known.insert(order.to_vec(), number);
        let one = |number: i32, material: &Option<u32>| match material {
            Some(material) => single(number, &self.materials[*material as usize]),
            None => default_material(number),
        };
        let material = match order {
            [material] => one(number, material),
            _ => {
                let subs = (0..).zip(order).map(|(sub, material)| one(sub, material)).collect();
                let body = MaterialBody::Multi(subs);
                Material { number, name: aam::Text::one_line(name), body, unknown: Vec::new() }
            }
        };
        self.list.push(material);
        number
    }
}

fn single(number: i32, material: &PartMaterial) -> Material {
    let mut single = material.single.clone();
    // The format has no material without these two lines.
    for layer in &mut single.layers[..2] {
        if matches!(layer, Flagged::Omitted) {
            *layer = Flagged::No;
        }
    }
    let body = MaterialBody::Single(Box::new(single));
    Material { number, name: aam::Text::one_line(&material.name), body, unknown: Vec::new() }
}

/// For triangles without a material in an object that has some.
fn default_material(number: i32) -> Material {
    let single =
        SingleMaterial { class: "Standard".into(), ambient: [0.8; 3], diffuse: [0.8; 3], ..SingleMaterial::default() };
    self::single(number, &PartMaterial { name: "default".into(), single, displacement: None })
}
