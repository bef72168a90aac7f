//! What an object draws.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3, Vec4};

use crate::document::{Faces, Layer, NormalSpace, Object, Triangle};
use crate::meaning::{Bounds, Lookup, Materials, SmoothingRule, object_normals, tangents};
use crate::{Finding, Severity};

/// The triangles of an object, corner by corner, grouped by material.
///
/// Corner `3 t + c` is corner `c` of triangle `t`. Triangles stand in the order of [`ObjectMesh::subsets`], and within
/// a subset in file order. Triangles that cannot be drawn are left out: those with an index beyond the vertices, with
/// one vertex twice, or with a position that is not finite. Triangles that merely have no area are kept, since a later
/// frame may give them one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectMesh {
    /// For each triangle its position in [`Faces::triangles`].
    pub triangles: Vec<u32>,
    /// For each corner its position in [`Object::vertices`]; always in range, and the position is finite.
    pub corners: Vec<u32>,
    /// For each corner its unit normal.
    pub normals: Vec<Vec3>,
    /// For each layer, if any subset has texture coordinates for it: those of each corner, finite (zero in the other
    /// subsets).
    pub uvs: [Option<Vec<Vec2>>; 4],
    /// For each vertex its colour in `[0, 1]`, if the object has a colour for every vertex.
    pub colors: Option<Vec<Vec3>>,
    /// Runs of triangles with one material, in the order in which the file first uses them.
    pub subsets: Vec<ObjectSubset>,
    /// The box around the positions that are used.
    pub bounds: Option<Bounds>,
    /// What was left out or replaced, and why.
    pub findings: Vec<Finding>,
}

/// A run of triangles with one material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjectSubset {
    /// A position in [`Materials::leaves`], or `None` for the default material.
    pub material: Option<usize>,
    /// The layers that these triangles have texture coordinates for. A layer of the material without them is not drawn.
    pub uv_layers: [bool; 4],
    /// First triangle.
    pub first: usize,
    /// How many.
    pub count: usize,
}

/// Corners are numbered with 32 bits.
const MAX_TRIANGLES: usize = u32::MAX as usize / 3;

/// How often something in an object could not be used.
#[derive(Default)]
struct Counts {
    out_of_range: usize,
    not_finite: usize,
    repeated: usize,
    bad_uv_index: usize,
    bad_uv: usize,
    missing_uv: usize,
}

impl ObjectMesh {
    /// The mesh of an object of frame 0.
    ///
    /// The n-th `TI:` line of a triangle belongs to the n-th layer that its material has; lines that are missing leave
    /// the layer without texture coordinates, lines that are too many belong to nothing.
    pub fn of(object: &Object, materials: &Materials, rule: SmoothingRule) -> Self {
        let mut mesh = Self::default();
        let Some(faces) = &object.faces else {
            return mesh;
        };
        if faces.triangles.len() > MAX_TRIANGLES {
            report(object, &mut mesh.findings, Severity::Error, "mesh/too-large", faces.triangles.len(), |count| {
                format!("{count} triangles are more than the {MAX_TRIANGLES} that one object may have; it is not drawn")
            });
            return mesh;
        }
        let mut counts = Counts::default();
        let runs = mesh.sort_triangles(object, faces, materials, &mut counts);
        mesh.fill_corners(object, faces, materials, &runs, rule, &mut counts);
        mesh.colors = vertex_colors(object, &mut mesh.findings);
        let positions = mesh.corners.iter().map(|&vertex| Vec3::from(object.vertices[vertex as usize]));
        mesh.bounds = Bounds::of(positions);
        counts.report(object, &mut mesh.findings);
        mesh
    }

    /// Sorts the triangles that can be drawn into subsets; gives for each triangle where its `TI:` lines stand.
    fn sort_triangles(
        &mut self,
        object: &Object,
        faces: &Faces,
        materials: &Materials,
        counts: &mut Counts,
    ) -> Vec<(u32, u32)> {
        let mut subset_of: BTreeMap<(Option<usize>, [bool; 4]), usize> = BTreeMap::new();
        let mut chosen: Vec<(u32, u32)> = Vec::new();
        let mut runs = vec![(0, 0); faces.triangles.len()];
        let mut lines = faces.tex_indices_of_triangles();
        let (mut substitutes, mut missing) = (0, 0);
        let mut next = 0;
        let mut run_start = 0_u32;
        // What stands after the last group (no file does that) counts as a group 0.
        let rest = crate::document::Group { id: 0, triangles: usize::MAX };
        for group in faces.groups.iter().chain([&rest]) {
            let end = next + group.triangles.min(faces.triangles.len() - next);
            if next == end {
                continue;
            }
            let lookup = materials.lookup(object.material, group.id);
            match lookup {
                Lookup::Substitute(_) => substitutes += 1,
                Lookup::Missing => missing += 1,
                Lookup::Named(_) | Lookup::Default => {}
            }
            let layers: Vec<Layer> =
                lookup.leaf().map_or_else(Vec::new, |leaf| materials.leaves()[leaf].present_layers().collect());
            let mut last: Option<([bool; 4], usize)> = None;
            for (run, index) in runs[next..end].iter_mut().zip(next..) {
                let given = lines.next().unwrap_or(&[]);
                *run = (run_start, given.len() as u32);
                run_start += given.len() as u32;
                if !drawable(&faces.triangles[index], object, counts) {
                    continue;
                }
                let uv_layers = usable_layers(&layers, given, faces.tex_coords.len(), counts);
                let subset = match last {
                    Some((same, subset)) if same == uv_layers => subset,
                    _ => {
                        let new = subset_of.len();
                        *subset_of.entry((lookup.leaf(), uv_layers)).or_insert(new)
                    }
                };
                last = Some((uv_layers, subset));
                chosen.push((subset as u32, index as u32));
            }
            next = end;
        }
        // Stable: within a subset in file order.
        chosen.sort_by_key(|&(subset, _)| subset);
        let mut subsets: Vec<_> = subset_of.into_iter().map(|(key, subset)| (subset, key)).collect();
        subsets.sort_unstable_by_key(|&(subset, _)| subset);
        let mut first = 0;
        for (run, (_, (material, uv_layers))) in chosen.chunk_by(|a, b| a.0 == b.0).zip(subsets) {
            self.subsets.push(ObjectSubset { material, uv_layers, first, count: run.len() });
            first += run.len();
        }
        self.triangles = chosen.into_iter().map(|(_, index)| index).collect();
        report(object, &mut self.findings, Severity::Info, "material/substitute", substitutes, |count| {
            format!("{count} groups have an id that no sub-material has; the sub at id mod count is used")
        });
        report(object, &mut self.findings, Severity::Warning, "material/missing", missing, |_| {
            format!("MatID {} names no material; the default material is used", object.material)
        });
        runs
    }

    fn fill_corners(
        &mut self,
        object: &Object,
        faces: &Faces,
        materials: &Materials,
        runs: &[(u32, u32)],
        rule: SmoothingRule,
        counts: &mut Counts,
    ) {
        let normals = object_normals(object, rule);
        self.corners = Vec::with_capacity(3 * self.triangles.len());
        self.normals = Vec::with_capacity(3 * self.triangles.len());
        for &index in &self.triangles {
            self.corners.extend(faces.triangles[index as usize].vertices);
            self.normals.extend(normals[index as usize]);
        }
        for layer in Layer::ALL {
            if !self.subsets.iter().any(|subset| subset.uv_layers[layer as usize]) {
                continue;
            }
            let mut uvs = vec![Vec2::ZERO; self.corners.len()];
            for subset in self.subsets.iter().filter(|subset| subset.uv_layers[layer as usize]) {
                let Some(line) = subset
                    .material
                    .and_then(|leaf| materials.leaves()[leaf].present_layers().position(|present| present == layer))
                else {
                    continue;
                };
                for triangle in subset.first..subset.first + subset.count {
                    let (start, _) = runs[self.triangles[triangle] as usize];
                    let indices = faces.tex_indices[start as usize + line];
                    for corner in 0..3 {
                        let uv = Vec2::from(faces.tex_coords[indices[corner] as usize]);
                        if uv.is_finite() {
                            uvs[3 * triangle + corner] = uv;
                        } else {
                            counts.bad_uv += 1;
                        }
                    }
                }
            }
            self.uvs[layer as usize] = Some(uvs);
        }
    }

    /// For each corner its MikkTSpace tangent (xyz) and bitangent sign (w) for the normal map of its material, if any
    /// subset has a tangent-space normal map with texture coordinates and a material that `wanted` accepts (it gets the
    /// position in [`Materials::leaves`]). Corners of other subsets have some frame perpendicular to their normal.
    ///
    /// Tangents follow the coordinates that the map is sampled at, thus after the layer's transform.
    pub fn tangents(
        &self,
        object: &Object,
        materials: &Materials,
        wanted: impl Fn(usize) -> bool,
    ) -> Option<Vec<Vec4>> {
        let layer = Layer::Normal as usize;
        let raw = self.uvs[layer].as_ref()?;
        let mut uvs = vec![Vec2::ZERO; self.corners.len()];
        let mut any = false;
        for subset in self.subsets.iter().filter(|subset| subset.uv_layers[layer]) {
            let Some(leaf) = subset.material.filter(|&leaf| wanted(leaf)) else {
                continue;
            };
            let Some(map) = &materials.leaves()[leaf].layers[layer] else {
                continue;
            };
            if map.normal_space != NormalSpace::Tangent {
                continue;
            }
            any = true;
            for corner in 3 * subset.first..3 * (subset.first + subset.count) {
                uvs[corner] = map.transform.transform_point2(raw[corner]);
            }
        }
        any.then(|| {
            let positions: Vec<Vec3> =
                self.corners.iter().map(|&vertex| Vec3::from(object.vertices[vertex as usize])).collect();
            tangents(&positions, &self.normals, &uvs)
        })
    }
}

fn drawable(triangle: &Triangle, object: &Object, counts: &mut Counts) -> bool {
    let [a, b, c] = triangle.vertices;
    let positions = triangle.vertices.map(|vertex| object.vertices.get(vertex as usize));
    if positions.iter().any(Option::is_none) {
        counts.out_of_range += 1;
    } else if positions.iter().flatten().any(|position| !Vec3::from(**position).is_finite()) {
        counts.not_finite += 1;
    } else if a == b || b == c || c == a {
        counts.repeated += 1;
    } else {
        return true;
    }
    false
}

fn usable_layers(layers: &[Layer], given: &[[u32; 3]], pool: usize, counts: &mut Counts) -> [bool; 4] {
    let mut usable = [false; 4];
    for (line, &layer) in layers.iter().enumerate() {
        match given.get(line) {
            Some(indices) if indices.iter().all(|&index| (index as usize) < pool) => usable[layer as usize] = true,
            Some(_) => counts.bad_uv_index += 1,
            None => counts.missing_uv += 1,
        }
    }
    usable
}

fn vertex_colors(object: &Object, findings: &mut Vec<Finding>) -> Option<Vec<Vec3>> {
    let colors = object.colors.as_ref().filter(|colors| !colors.is_empty())?;
    if colors.len() != object.vertices.len() {
        report(object, findings, Severity::Warning, "mesh/color-count", colors.len(), |count| {
            format!("C_List has {count} colours for {} vertices; it is not used", object.vertices.len())
        });
        return None;
    }
    let component = |value: f32| if value.is_nan() { 1.0 } else { value.clamp(0.0, 1.0) };
    Some(colors.iter().map(|rgb| Vec3::from(rgb.map(component))).collect())
}

impl Counts {
    fn report(&self, object: &Object, findings: &mut Vec<Finding>) {
        let mut warn = |code, count, message: &dyn Fn(usize) -> String| {
            report(object, findings, Severity::Warning, code, count, message);
        };
        warn("mesh/index-out-of-range", self.out_of_range, &|count| {
            format!("{count} triangles name vertices beyond the {}; they are left out", object.vertices.len())
        });
        warn("mesh/not-finite", self.not_finite, &|count| {
            format!("{count} triangles have a position that is not a number; they are left out")
        });
        warn("mesh/uv-index-out-of-range", self.bad_uv_index, &|count| {
            format!("{count} TI lines name texture coordinates that do not exist; the layer is not drawn there")
        });
        warn("mesh/uv-not-finite", self.bad_uv, &|count| {
            format!("{count} corners have a texture coordinate that is not a number; 0 0 is used")
        });
        warn("mesh/uv-missing", self.missing_uv, &|count| {
            format!("{count} TI lines that the material's layers need are missing; the layer is not drawn there")
        });
        report(object, findings, Severity::Info, "mesh/repeated-vertex", self.repeated, |count| {
            format!("{count} triangles use one vertex twice; they are left out")
        });
    }
}

fn report(
    object: &Object,
    findings: &mut Vec<Finding>,
    severity: Severity,
    code: &'static str,
    count: usize,
    message: impl Fn(usize) -> String,
) {
    if count > 0 {
        let subject = format!("object {} \"{}\"", object.id, object.name);
        findings.push(Finding { code, severity, position: None, subject, message: message(count) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Document;
    use crate::document::{Flagged, Group, Material, MaterialBody, SingleMaterial, TexCounts, Texture};

    fn material(number: i32, layers: &[Layer]) -> Material {
        let mut single = SingleMaterial::default();
        for &layer in layers {
            single.layers[layer as usize] = Flagged::Yes(Box::new(Texture::new("t.png")));
        }
        let body = MaterialBody::Single(Box::new(single));
        Material { number, name: format!("m{number}").into(), body, unknown: Vec::new() }
    }

    fn materials(list: Vec<Material>) -> Materials {
        Materials::of(&Document { materials: list, ..Document::default() })
    }

    fn object(material: i32, faces: Faces) -> Object {
        Object {
            id: 3,
            name: "Lamp".into(),
            material,
            vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
            faces: Some(faces),
            ..Object::default()
        }
    }

    fn quad() -> Faces {
        Faces {
            tex_coords: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [f32::NAN, 0.0]],
            triangles: vec![
                Triangle { vertices: [0, 1, 2], smoothing: 1 },
                Triangle { vertices: [2, 1, 3], smoothing: 1 },
            ],
            groups: vec![Group { id: 0, triangles: 2 }],
            ..Faces::default()
        }
    }

    #[test]
    fn lines_belong_to_present_layers_in_order() {
        let mut faces = quad();
        faces.tex_counts = TexCounts::Uniform(2);
        faces.tex_indices = vec![[0, 1, 2], [1, 2, 3], [2, 1, 3], [3, 3, 3]];
        let materials = materials(vec![material(0, &[Layer::LightMap, Layer::Normal])]);
        let mesh = ObjectMesh::of(&object(0, faces), &materials, SmoothingRule::Masks);
        assert_eq!(
            mesh.subsets,
            [ObjectSubset { material: Some(0), uv_layers: [false, true, true, false], first: 0, count: 2 }]
        );
        assert_eq!(mesh.uvs[0], None);
        assert_eq!(mesh.uvs[1].as_ref().unwrap()[..3], [Vec2::ZERO, Vec2::X, Vec2::Y]);
        assert_eq!(mesh.uvs[2].as_ref().unwrap()[..3], [Vec2::X, Vec2::Y, Vec2::ONE]);
        assert_eq!(mesh.uvs[1].as_ref().unwrap()[3..], [Vec2::Y, Vec2::X, Vec2::ONE]);
        assert_eq!(mesh.corners, [0, 1, 2, 2, 1, 3]);
        assert_eq!(mesh.normals, [Vec3::Z; 6]);
        assert_eq!(mesh.bounds, Some(Bounds { min: Vec3::ZERO, max: Vec3::new(1.0, 1.0, 0.0) }));
        assert_eq!(mesh.findings, []);
    }

    #[test]
    fn what_is_missing_splits_the_subset() {
        let mut faces = quad();
        faces.tex_counts = TexCounts::Each(vec![1, 0]);
        faces.tex_indices = vec![[0, 4, 2]];
        let materials = materials(vec![material(0, &[Layer::Diffuse])]);
        let mesh = ObjectMesh::of(&object(0, faces), &materials, SmoothingRule::Masks);
        assert_eq!(mesh.subsets.len(), 2);
        assert!(mesh.subsets[0].uv_layers[0] && !mesh.subsets[1].uv_layers[0]);
        assert_eq!(mesh.uvs[0].as_ref().unwrap()[..3], [Vec2::ZERO, Vec2::ZERO, Vec2::Y], "NaN became 0");
        let codes: Vec<_> = mesh.findings.iter().map(|finding| finding.code).collect();
        assert_eq!(codes, ["mesh/uv-not-finite", "mesh/uv-missing"]);
        assert_eq!(mesh.findings[0].subject, "object 3 \"Lamp\"");
    }

    #[test]
    fn lines_without_a_material_belong_to_nothing() {
        let mut faces = quad();
        faces.tex_counts = TexCounts::Uniform(1);
        faces.tex_indices = vec![[0, 1, 2], [90, 91, 92]];
        let mesh = ObjectMesh::of(&object(-1, faces), &materials(Vec::new()), SmoothingRule::Masks);
        assert_eq!(mesh.subsets, [ObjectSubset { material: None, uv_layers: [false; 4], first: 0, count: 2 }]);
        assert_eq!(mesh.findings, []);
    }

    #[test]
    fn groups_of_a_multi_become_subsets() {
        let body = MaterialBody::Multi(vec![material(0, &[]), material(1, &[])]);
        let multi = Material { number: 0, name: "multi".into(), body, unknown: Vec::new() };
        let mut faces = quad();
        faces.triangles.extend([Triangle { vertices: [0, 1, 3], smoothing: 1 }; 3]);
        faces.groups = [(1, 1), (0, 1), (1, 1), (46, 1)].map(|(id, triangles)| Group { id, triangles }).to_vec();
        let mesh = ObjectMesh::of(&object(0, faces), &materials(vec![multi]), SmoothingRule::Masks);
        let subsets: Vec<_> = mesh.subsets.iter().map(|s| (s.material, s.first, s.count)).collect();
        assert_eq!(subsets, [(Some(1), 0, 2), (Some(0), 2, 3)], "46 and what no group holds are in the first sub");
        assert_eq!(mesh.triangles, [0, 2, 1, 3, 4]);
        assert_eq!(mesh.findings.len(), 1);
        assert_eq!(mesh.findings[0].code, "material/substitute");
    }

    #[test]
    fn triangles_that_cannot_be_drawn_are_left_out() {
        let mut faces = quad();
        faces.triangles.extend([
            Triangle { vertices: [0, 1, 1], smoothing: 1 },
            Triangle { vertices: [0, 1, u32::MAX], smoothing: 1 },
            Triangle { vertices: [0, 1, 4], smoothing: 1 },
        ]);
        faces.groups[0].triangles = 5;
        let mut object = object(7, faces);
        object.vertices.push([0.0, f32::INFINITY, 0.0]);
        object.colors = Some(vec![[2.0, f32::NAN, -1.0]; 5]);
        let mesh = ObjectMesh::of(&object, &materials(Vec::new()), SmoothingRule::Masks);
        assert_eq!(mesh.triangles, [0, 1]);
        assert_eq!(mesh.colors, Some(vec![Vec3::new(1.0, 1.0, 0.0); 5]));
        let codes: Vec<_> = mesh.findings.iter().map(|finding| finding.code).collect();
        let expected = ["material/missing", "mesh/index-out-of-range", "mesh/not-finite", "mesh/repeated-vertex"];
        assert_eq!(codes, expected);
        object.colors = Some(vec![[1.0; 3]; 2]);
        let mesh = ObjectMesh::of(&object, &materials(Vec::new()), SmoothingRule::Masks);
        assert_eq!(mesh.colors, None);
    }

    #[test]
    fn tangents_follow_the_transformed_coordinates() {
        let mut turned = material(0, &[Layer::Normal]);
        if let MaterialBody::Single(single) = &mut turned.body
            && let Flagged::Yes(texture) = &mut single.layers[Layer::Normal as usize]
        {
            texture.normal_space = Some(NormalSpace::Tangent);
            texture.rotation[2] = std::f32::consts::FRAC_PI_2;
        }
        let mut faces = quad();
        faces.tex_counts = TexCounts::Uniform(1);
        faces.tex_indices = vec![[0, 1, 2], [2, 1, 3]];
        let object = object(0, faces);
        let materials = materials(vec![turned]);
        let mesh = ObjectMesh::of(&object, &materials, SmoothingRule::Masks);
        // u' = −v: the map's u axis runs along −Y.
        for tangent in mesh.tangents(&object, &materials, |_| true).unwrap() {
            assert!(tangent.abs_diff_eq(Vec4::new(0.0, -1.0, 0.0, 1.0), 1e-6), "{tangent}");
        }
        assert_eq!(mesh.tangents(&object, &materials, |_| false), None);
    }
}
