//! The surface of a mesh: all its primitives together, welded, with materials, texture coordinates and colours in the
//! form that AAM wants. It is made once for a mesh; every node that shows the mesh poses it.

use std::collections::{BTreeMap, HashMap};
use std::hash::Hash;

use aam::document::{Faces, Group, Rgb, TexCounts};
use glam::DVec3;

use crate::phong;

use super::log::Log;
use super::material::{LayerCoords, Mapped};
use super::primitive::{Influence, Primitive};

/// A mesh's primitives as one surface. A *source* is a vertex of the glTF file; a *vertex* is one of the document, which
/// several sources share that differ only in normal or texture coordinates.
#[derive(Debug, Default)]
pub(super) struct Surface {
    /// Positions of sources, in glTF's axes.
    pub positions: Vec<[f32; 3]>,
    /// Normals of sources; zero where there is none.
    pub normals: Vec<[f32; 3]>,
    /// Whether any source has a normal.
    pub has_normals: bool,
    /// For each triangle whether it comes from a primitive without normals.
    pub flat: Vec<bool>,
    pub influences: Vec<Influence>,
    pub influences_per_source: usize,
    pub targets: Vec<Target>,
    /// The vertex of each source.
    pub vertex_of: Vec<u32>,
    /// A source for each vertex.
    pub sources: Vec<u32>,
    /// Triples of sources, group after group.
    pub triangles: Vec<[u32; 3]>,
    /// The material of each group, by position in the list of mapped materials, and how many triangles it has.
    pub groups: Vec<(usize, usize)>,
    /// The colour of each vertex, sRGB-encoded.
    pub colors: Option<Vec<Rgb>>,
    pub tex_coords: Vec<[f32; 2]>,
    /// Texture indices, triangle after triangle, layer after layer.
    pub tex_indices: Vec<[u32; 3]>,
    pub tex_counts: Vec<u8>,
}

/// What a morph target adds to each source; empty where it adds nothing.
#[derive(Debug, Default)]
pub(super) struct Target {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
}

impl Surface {
    /// Joins primitives. The last of `materials` is for those without one. `keep_uvs` keeps the coordinates of primitives
    /// whose material has no texture.
    pub(super) fn join(
        mut primitives: Vec<Primitive>,
        materials: &[Mapped],
        keep_uvs: bool,
        subject: &str,
        log: &mut Log,
    ) -> Self {
        let slot = |material: Option<usize>| material.unwrap_or(materials.len().saturating_sub(1));
        // Stable: groups in order of first appearance, each primitive in its own order.
        let mut ranks: BTreeMap<usize, usize> = BTreeMap::new();
        for primitive in &primitives {
            let next = ranks.len();
            ranks.entry(slot(primitive.material)).or_insert(next);
        }
        primitives.sort_by_key(|primitive| ranks.get(&slot(primitive.material)).copied());

        let mut surface = Self {
            influences_per_source: primitives.iter().map(|p| p.influences_per_vertex).max().unwrap_or(0),
            ..Self::default()
        };
        let targets = primitives.iter().map(|primitive| primitive.targets.len()).max().unwrap_or(0);
        surface.targets.resize_with(targets, Target::default);
        let mut colors = Colors::default();
        let mut coords = Coords::default();
        for primitive in &primitives {
            let slot = slot(primitive.material);
            let mut layers = materials.get(slot).map_or([None; 4], |material| material.layers);
            if keep_uvs && layers == [None; 4] && primitive.uv(0).is_some() {
                layers[0] = Some(LayerCoords { set: 0, baked: None });
            }
            coords.add(primitive, &layers, &mut surface, subject, log);
            colors.add(primitive, surface.positions.len());
            surface.add(primitive);
            match surface.groups.last_mut() {
                Some((last, count)) if *last == slot => *count += primitive.triangles.len(),
                _ => surface.groups.push((slot, primitive.triangles.len())),
            }
        }
        surface.tex_coords = coords.pool;
        surface.weld(&colors.linear);
        surface.colors = colors.finish(&surface.sources, subject, log);
        surface
    }

    fn add(&mut self, primitive: &Primitive) {
        let first = self.positions.len() as u32;
        let end = self.positions.len() + primitive.positions.len();
        self.positions.extend_from_slice(&primitive.positions);
        match &primitive.normals {
            Some(normals) => {
                self.normals.extend_from_slice(normals);
                self.has_normals = true;
            }
            None => self.normals.resize(end, [0.0; 3]),
        }
        let per_vertex = primitive.influences_per_vertex;
        for vertex in 0..primitive.positions.len() {
            let own = primitive.influences.get(vertex * per_vertex..(vertex + 1) * per_vertex).unwrap_or(&[]);
            self.influences.extend_from_slice(own);
            self.influences.resize((first as usize + vertex + 1) * self.influences_per_source, Influence::default());
        }
        for (target, added) in self.targets.iter_mut().zip(&primitive.targets) {
            for (all, own) in [(&mut target.positions, &added.positions), (&mut target.normals, &added.normals)] {
                if let Some(own) = own {
                    all.resize(first as usize, [0.0; 3]);
                    all.extend_from_slice(own);
                } else if !all.is_empty() {
                    all.resize(end, [0.0; 3]);
                }
            }
        }
        let faces = self.flat.len() + primitive.triangles.len();
        self.flat.resize(faces, primitive.normals.is_none());
        self.triangles.extend(primitive.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first)));
    }

    /// Gives sources with the same position, colour, bones and morphs one vertex, so that faces meet there.
    fn weld(&mut self, colors: &[[f32; 4]]) {
        // Zero and minus zero are one place.
        let bits = |row: &[f32; 3]| row.map(|value| (value + 0.0).to_bits());
        let mut ids = vec![0; self.positions.len()];
        refine(&mut ids, |source| bits(&self.positions[source]));
        if !colors.is_empty() {
            refine(&mut ids, |source| colors[source].map(f32::to_bits));
        }
        for at in 0..self.influences_per_source {
            refine(&mut ids, |source| {
                let influence = self.influences[source * self.influences_per_source + at];
                (influence.joint, influence.weight.to_bits())
            });
        }
        for target in &self.targets {
            if !target.positions.is_empty() {
                refine(&mut ids, |source| bits(&target.positions[source]));
            }
        }
        // Numbered by first use, so that the list reads in the order of the triangles.
        let mut numbers: Vec<Option<u32>> = vec![None; ids.len()];
        let mut sources = Vec::new();
        for &source in self.triangles.as_flattened() {
            let number = &mut numbers[ids[source as usize] as usize];
            if number.is_none() {
                *number = Some(sources.len() as u32);
                sources.push(source);
            }
        }
        self.vertex_of = ids.iter().map(|&id| numbers[id as usize].unwrap_or(0)).collect();
        self.sources = sources;
    }

    /// For each source a number that it shares with those whose normals stay the same however the surface moves.
    pub(super) fn normal_classes(&self) -> Vec<u32> {
        let bits = |row: &[f32; 3]| row.map(|value| (value + 0.0).to_bits());
        // Bones may turn equal normals at different vertices apart.
        let mut ids = if self.influences_per_source > 0 { self.vertex_of.clone() } else { vec![0; self.normals.len()] };
        refine(&mut ids, |source| bits(&self.normals[source]));
        for target in &self.targets {
            if !target.normals.is_empty() {
                refine(&mut ids, |source| bits(&target.normals[source]));
            }
        }
        ids
    }

    /// A source's position under morph weights.
    pub(super) fn position(&self, source: usize, weights: &[f32]) -> DVec3 {
        self.morphed(self.positions[source], source, weights, |target| &target.positions)
    }

    /// A source's normal under morph weights, not of unit length; zero where there is none.
    pub(super) fn normal(&self, source: usize, weights: &[f32]) -> DVec3 {
        if self.normals[source] == [0.0; 3] {
            return DVec3::ZERO;
        }
        self.morphed(self.normals[source], source, weights, |target| &target.normals)
    }

    fn morphed(
        &self,
        base: [f32; 3],
        source: usize,
        weights: &[f32],
        deltas: impl Fn(&Target) -> &Vec<[f32; 3]>,
    ) -> DVec3 {
        let mut sum = DVec3::from(base.map(f64::from));
        for (target, &weight) in self.targets.iter().zip(weights) {
            if weight != 0.0
                && let Some(delta) = deltas(target).get(source)
            {
                sum += f64::from(weight) * DVec3::from(delta.map(f64::from));
            }
        }
        sum
    }

    /// The bones of a source.
    pub(super) fn bones(&self, source: usize) -> &[Influence] {
        let per_source = self.influences_per_source;
        self.influences.get(source * per_source..(source + 1) * per_source).unwrap_or(&[])
    }

    /// Triples of vertices.
    pub(super) fn vertex_triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.triangles.iter().map(|triangle| triangle.map(|source| self.vertex_of[source as usize]))
    }

    /// Texture coordinates and groups as a document holds them; triangles and normals are the pose's.
    pub(super) fn faces(&self, mirrored: bool, group: impl Fn(usize) -> i32) -> Faces {
        let tex_counts = match self.tex_counts.split_first() {
            Some((first, rest)) if rest.iter().any(|count| count != first) => TexCounts::Each(self.tex_counts.clone()),
            Some((first, _)) => TexCounts::Uniform(*first),
            None => TexCounts::Uniform(0),
        };
        Faces {
            tex_coords: self.tex_coords.clone(),
            tex_indices: self.tex_indices.iter().map(|&triangle| wound(triangle, mirrored)).collect(),
            tex_counts,
            groups: self.groups.iter().map(|&(slot, triangles)| Group { id: group(slot), triangles }).collect(),
            ..Faces::default()
        }
    }
}

/// A triangle's corners, the other way round where the surface is mirrored.
pub(super) fn wound<T>([a, b, c]: [T; 3], mirrored: bool) -> [T; 3] {
    if mirrored { [a, c, b] } else { [a, b, c] }
}

/// Splits classes of equal ids where keys differ.
fn refine<K: Hash + Eq>(ids: &mut [u32], key: impl Fn(usize) -> K) {
    let mut classes: HashMap<(u32, K), u32> = HashMap::with_capacity(ids.len());
    for (at, id) in ids.iter_mut().enumerate() {
        let next = classes.len() as u32;
        *id = *classes.entry((*id, key(at))).or_insert(next);
    }
}

/// Vertex colours of all primitives; those without are white.
#[derive(Default)]
struct Colors {
    linear: Vec<[f32; 4]>,
}

impl Colors {
    fn add(&mut self, primitive: &Primitive, before: usize) {
        if let Some(colors) = &primitive.colors {
            self.linear.resize(before, [1.0; 4]);
            self.linear.extend_from_slice(colors);
        } else if !self.linear.is_empty() {
            self.linear.resize(before + primitive.positions.len(), [1.0; 4]);
        }
    }

    fn finish(&self, sources: &[u32], subject: &str, log: &mut Log) -> Option<Vec<Rgb>> {
        if self.linear.is_empty() {
            return None;
        }
        let used = || sources.iter().map(|&source| self.linear[source as usize]);
        let (mut least, mut outside) = (1.0_f32, 0_usize);
        for [r, g, b, alpha] in used() {
            least = least.min(alpha);
            outside += usize::from([r, g, b].iter().any(|value| !(0.0..=1.0).contains(value)));
        }
        if least < 1.0 {
            let note = format!("AAM's vertex colours have no alpha (the least was {least:.3})");
            log.lost(subject, "vertex colour alpha", note);
        }
        if outside > 0 {
            log.changed(subject, "vertex colours", format!("{outside} were clamped to 0 … 1"), None);
        }
        let white = used().all(|[r, g, b, _]| [r, g, b] == [1.0; 3]);
        (!white).then(|| used().map(|[r, g, b, _]| [r, g, b].map(|v| phong::encode_srgb(v.clamp(0.0, 1.0)))).collect())
    }
}

/// The pool of texture coordinates of an object.
#[derive(Default)]
struct Coords {
    pool: Vec<[f32; 2]>,
    known: HashMap<[u32; 2], u32>,
}

impl Coords {
    fn index(&mut self, uv: [f32; 2]) -> u32 {
        *self.known.entry(uv.map(f32::to_bits)).or_insert_with(|| {
            self.pool.push(uv);
            self.pool.len() as u32 - 1
        })
    }

    /// Adds the texture indices of a primitive's triangles.
    fn add(
        &mut self,
        primitive: &Primitive,
        layers: &[Option<LayerCoords>; 4],
        surface: &mut Surface,
        subject: &str,
        log: &mut Log,
    ) {
        let mut made: Vec<(LayerCoords, Vec<u32>)> = Vec::new();
        let mut present = Vec::new();
        for layer in layers.iter().flatten() {
            let at = made.iter().position(|(other, _)| other == layer).unwrap_or_else(|| {
                made.push((*layer, self.of_vertices(primitive, layer, subject, log)));
                made.len() - 1
            });
            present.push(at);
        }
        for triangle in &primitive.triangles {
            surface.tex_counts.push(present.len() as u8);
            for &at in &present {
                surface.tex_indices.push(triangle.map(|vertex| made[at].1[vertex as usize]));
            }
        }
    }

    fn of_vertices(&mut self, primitive: &Primitive, layer: &LayerCoords, subject: &str, log: &mut Log) -> Vec<u32> {
        let transform = layer.baked.unwrap_or_default();
        let mut pooled = |uv: [f32; 2]| {
            let [u, v] = transform.apply(uv);
            // AAM counts v from the bottom. Adding zero turns -0 into 0.
            self.index([u + 0.0, 1.0 - v])
        };
        match primitive.uv(layer.set) {
            Some(uvs) => uvs.iter().map(|&uv| pooled(uv)).collect(),
            None => {
                let note = format!("TEXCOORD_{} is missing; its texture shows one texel everywhere", layer.set);
                log.changed(subject, "texture coordinates", note, None);
                vec![pooled([0.0; 2]); primitive.positions.len()]
            }
        }
    }
}
