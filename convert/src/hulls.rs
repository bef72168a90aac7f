//! Convex decomposition, for the bodies of a physics simulation.
//!
//! A convex mesh is its own hull. Others are cut by planes, the worst part first, until the hull of each part is near
//! enough to the surface; then parts whose common hull is near enough too are joined again. How far a hull is outside is
//! read from a grid of distances to the surface, so a plane is judged by the error that it leaves, which is the measure
//! of X. Wei et al., "Approximate Convex Decomposition for 3D Meshes with Collision-Aware Concavity and Tree Search",
//! 2022, sec. 4, for a fraction of its cost. The cuts are made in the mesh itself, so the hulls touch its surface.

mod close;
mod field;
mod fit;
mod measure;
mod merge;
mod mesh;
mod primitive;
mod quickhull;
mod split;

use std::collections::{HashMap, HashSet};

use aam::document::Primitive;
use glam::{DVec3, Vec3};
use parry3d::transformation::voxelization::{FillMode, VoxelSet, VoxelizedVolume};

use field::Field;
use fit::fitted;
use measure::SPACING;
use merge::{Group, merge, refine};
use mesh::Mesh;
use primitive::{NEGLIGIBLE, Simple};
use quickhull::{Polyhedron, hull};
use split::Parts;

/// How to decompose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullOptions {
    /// The most pieces, at least 1. Default 64.
    pub max_hulls: usize,
    /// Largest distance between the pieces and the surface, either way, as a part of the bounding box's diagonal: pieces are
    /// no more than needed to keep it, as far as `max_hulls` allows. `None` takes as many as allowed for the least error
    /// that the grid tells from none. Default 0.02.
    pub max_error: Option<f32>,
    /// The most vertices of a piece, from 4 to 255. Default 64, what GPU physics takes.
    pub max_vertices: usize,
    /// Looks for boxes, spheres and capsules that are as near to the surface as the pieces. Default false.
    pub primitives: bool,
}

impl Default for HullOptions {
    fn default() -> Self {
        Self { max_hulls: 64, max_error: Some(0.02), max_vertices: 64, primitives: false }
    }
}

/// A closed convex mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hull {
    /// Positions.
    pub vertices: Vec<[f32; 3]>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The volume.
    pub volume: f64,
    /// A simple shape that is as near to the surface, if [`HullOptions::primitives`] asks for it.
    pub primitive: Option<Primitive>,
}

/// Convex pieces of a mesh, largest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Decomposition {
    /// The pieces.
    pub hulls: Vec<Hull>,
    /// How near they are to the surface.
    pub quality: Quality,
    /// Parts that are points or lines, and were left out. (Flat ones become plates, half a voxel thick.)
    pub dropped: usize,
}

/// Distances from one shape to another, as parts of the diagonal of the mesh's bounding box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distances {
    /// The largest: the one-way Hausdorff distance.
    pub max: f32,
    /// The mean over the area.
    pub mean: f32,
}

/// How far convex pieces are from a mesh, both ways, by samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Quality {
    /// From the outside of the union of the pieces to the surface. What is inside of another piece or of the solid, or on
    /// the cut between two pieces, is not on the outside.
    pub outside: Distances,
    /// From the surface to the pieces: what a limit on vertices cuts off.
    pub uncovered: Distances,
    /// Samples are so far apart, as a part of the diagonal: the largest distances can be underestimated by about half of it.
    pub spacing: f32,
    /// The same two of each piece: of its own outside, and of the part of the surface that is nearer to it than to others.
    pub pieces: Vec<[Distances; 2]>,
}

impl Quality {
    /// The Hausdorff distance: the larger of both ways.
    pub fn hausdorff(&self) -> f32 {
        self.outside.max.max(self.uncovered.max)
    }

    /// The mean of the mean distances of both ways.
    pub fn mean(&self) -> f32 {
        0.5 * (self.outside.mean + self.uncovered.mean)
    }
}

/// Why a mesh has no convex pieces.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HullError {
    /// There is no triangle with an area.
    #[error("it has no triangle with an area, so it has no shape to collide with")]
    Empty,
    /// All points lie in a plane.
    #[error("it is flat: without volume it cannot be a solid body (a static body may be flat)")]
    Flat,
    /// A position is not finite, or an index is out of range.
    #[error("{0}")]
    Broken(String),
    /// An option is out of range.
    #[error("{0}")]
    Option(String),
    /// A piece is not convex within a ten-thousandth of its diagonal.
    #[error("piece {piece} is not convex: a vertex is {dent:.2e} of its diagonal outside of a face")]
    NotConvex {
        /// Which one.
        piece: usize,
        /// By how much, as a part of its diagonal.
        dent: f64,
    },
}

/// Voxels along the longest side.
const RESOLUTION: u32 = 128;
/// A distance (of a mesh whose longest side is 1) that the grid does not tell from none: less than a voxel.
const FINEST: f64 = 0.75 / RESOLUTION as f64;
/// So many times four times more parts than pieces are cut, to be joined again.
const FINER: [usize; 4] = [4, 6, 8, 16];
/// How often the limit is drawn tighter when the result misses it.
const ATTEMPTS: usize = 4;
/// The largest dent of a piece, as a part of its diagonal.
const CONVEX: f64 = 1e-4;
/// Tests of a triangle against a voxel that one decomposition may cost.
const MOST_TESTS: f64 = 2e7;

/// Cuts a mesh into convex pieces. The same mesh and options give the same pieces.
///
/// # Errors
/// When the mesh has no volume to fill, is broken, or an option is out of range.
pub fn decompose(
    vertices: &[[f32; 3]],
    triangles: &[[u32; 3]],
    options: &HullOptions,
) -> Result<Decomposition, HullError> {
    check_options(options)?;
    let mesh = Unit::new(vertices, triangles)?;
    let field = mesh.field()?;
    let whole = hull(&mesh.mesh.vertices, options.max_vertices).ok_or(HullError::Flat)?;
    if options.max_hulls == 1 || mesh.is_convex() {
        return mesh.finish(vec![whole], 0, &field, options);
    }
    let diagonal = mesh.diagonal();
    let mut parts = Parts::new(mesh.starts(&field, options.max_hulls), &field);
    let mut best: Option<Found> = None;
    let wanted = options.max_error.map(f64::from);
    let attempts = if wanted.is_some() { ATTEMPTS } else { FINER.len() };
    // Parts are judged by fewer samples than the result, so what seems good enough may turn out not to be.
    let mut strictness = 1.0;
    for attempt in 0..attempts {
        let limit = (strictness * wanted.unwrap_or(0.0) * diagonal).max(FINEST);
        let finer = if wanted.is_some() { FINER[FINER.len() - 1] } else { FINER[attempt] };
        parts.cut(&field, limit, (finer * options.max_hulls).div_ceil(4));
        let (pieces, dropped) = join(&parts, &field, limit, options);
        let quality = Quality::of(&pieces, &mesh.mesh, &field, SPACING);
        let found = Found { pieces, dropped, quality };
        if best.as_ref().is_none_or(|best| found.badness(wanted) < best.badness(wanted)) {
            best = Some(found.clone());
        }
        let error = f64::from(found.quality.hausdorff());
        if let Some(wanted) = wanted {
            if error <= wanted {
                break;
            }
            strictness *= (wanted / error).clamp(0.5, 0.85);
        }
    }
    let (pieces, dropped) = best.map_or_else(|| (vec![whole], 0), |found| (found.pieces, found.dropped));
    mesh.finish(pieces, dropped, &field, options)
}

/// Pieces, and what came of them.
#[derive(Clone)]
struct Found {
    pieces: Vec<Polyhedron>,
    dropped: usize,
    quality: Quality,
}

impl Found {
    /// By which results are compared: by the error that is to be kept, else by both errors.
    fn badness(&self, wanted: Option<f64>) -> f32 {
        match wanted {
            Some(_) => self.quality.hausdorff(),
            // The mean is about a quarter of the largest.
            None => self.quality.hausdorff() + 4.0 * self.quality.mean(),
        }
    }
}

/// Measures convex pieces, whoever made them, by samples so far apart (as a part of the diagonal).
///
/// # Errors
/// When the mesh is broken or has no triangle with an area.
pub fn measure(
    vertices: &[[f32; 3]],
    triangles: &[[u32; 3]],
    hulls: &[Hull],
    spacing: f32,
) -> Result<Quality, HullError> {
    let mesh = Unit::new(vertices, triangles)?;
    let place = |vertex: &[f32; 3]| (DVec3::from(vertex.map(f64::from)) - mesh.center) / mesh.scale;
    let pieces: Vec<Polyhedron> = hulls
        .iter()
        .map(|hull| Polyhedron {
            vertices: hull.vertices.iter().map(place).collect(),
            triangles: hull.triangles.clone(),
        })
        .collect();
    Ok(Quality::of(&pieces, &mesh.mesh, &mesh.field()?, f64::from(spacing)))
}

fn check_options(options: &HullOptions) -> Result<(), HullError> {
    if options.max_hulls == 0 {
        return Err(HullError::Option("--hulls must be at least 1".into()));
    }
    if !(4..=255).contains(&options.max_vertices) {
        return Err(HullError::Option("a hull can have from 4 to 255 vertices".into()));
    }
    if options.max_error.is_some_and(|error| !(error.is_finite() && error > 0.0)) {
        return Err(HullError::Option(
            "the error must be above 0 and up to 100 % of the bounding box's diagonal".into(),
        ));
    }
    Ok(())
}

/// A mesh scaled to a unit box, vertices of equal position made one, triangles without area left out.
struct Unit {
    mesh: Mesh,
    /// Whether there are holes, of those that are not closed.
    open: bool,
    center: DVec3,
    scale: f64,
}

impl Unit {
    fn new(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Self, HullError> {
        let mut used = Vec::new();
        let mut numbers: HashMap<[u32; 3], u32> = HashMap::new();
        let mut welded = Vec::with_capacity(triangles.len());
        for (index, triangle) in triangles.iter().enumerate() {
            let mut corners = [0; 3];
            for (corner, vertex) in corners.iter_mut().zip(triangle) {
                let position = vertices.get(*vertex as usize).ok_or_else(|| {
                    HullError::Broken(format!("triangle {index} names vertex {vertex} of {}", vertices.len()))
                })?;
                if !position.iter().all(|value| value.is_finite()) {
                    return Err(HullError::Broken(format!(
                        "vertex {vertex} has a coordinate that is no finite number"
                    )));
                }
                *corner = *numbers.entry(position.map(|value| (value + 0.0).to_bits())).or_insert_with(|| {
                    used.push(DVec3::from(position.map(f64::from)));
                    used.len() as u32 - 1
                });
            }
            welded.push(corners);
        }
        let low = used.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = used.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let scale = (high - low).max_element();
        if used.is_empty() || scale <= 0.0 {
            return Err(HullError::Empty);
        }
        let center = 0.5 * (low + high);
        let vertices: Vec<DVec3> = used.into_iter().map(|vertex| (vertex - center) / scale).collect();
        // Of triangles between the same vertices one is enough, whichever way round.
        let mut seen = HashSet::new();
        welded.retain(|triangle| {
            let [a, b, c] = triangle.map(|index| vertices[index as usize]);
            let mut key = *triangle;
            key.sort_unstable();
            (b - a).cross(c - a).length() > 1e-14 && seen.insert(key)
        });
        if welded.is_empty() {
            return Err(HullError::Empty);
        }
        let mut mesh = Mesh { vertices, triangles: welded };
        if mesh.volume() < 0.0 {
            // Inside out.
            mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        let open = mesh.close_holes();
        Ok(Self { mesh, open, center, scale })
    }

    /// What is cut first: the components that are not inside of others, or all as one if there are more than pieces.
    fn starts(&self, field: &Field, most: usize) -> Vec<Mesh> {
        let mut found = self.mesh.components(most).unwrap_or_default();
        found.retain(|component| !component.vertices.iter().all(|vertex| field.is_inside(*vertex)));
        if found.is_empty() { vec![self.mesh.clone()] } else { found }
    }

    fn diagonal(&self) -> f64 {
        let (low, high) = self.mesh.bounds();
        (high - low).length()
    }

    fn field(&self) -> Result<Field, HullError> {
        Field::new(&self.mesh.vertices, &self.mesh.triangles, &self.voxels(), self.open).ok_or(HullError::Empty)
    }

    /// Whether the mesh is the surface of a convex solid: closed, in one piece, without handles, and no edge bends
    /// inwards. Then it is convex as a whole (J. van Heijenoort, "On Locally Convex Manifolds", 1952).
    fn is_convex(&self) -> bool {
        /// Angles in radians that bend inwards by less are rounding.
        const FLAT: f64 = 1e-4;
        let mut edges: Vec<((u32, u32), u32)> = Vec::with_capacity(3 * self.mesh.triangles.len());
        for (face, &[a, b, c]) in self.mesh.triangles.iter().enumerate() {
            edges.extend([((a, b), face as u32), ((b, c), face as u32), ((c, a), face as u32)]);
        }
        edges.sort_unstable();
        if edges.windows(2).any(|pair| pair[0].0 == pair[1].0) {
            return false;
        }
        let normal = |face: u32| {
            let [a, b, c] = self.mesh.triangles[face as usize].map(|index| self.mesh.vertices[index as usize]);
            (b - a).cross(c - a).normalize_or_zero()
        };
        let mut neighbors = vec![[u32::MAX; 3]; self.mesh.triangles.len()];
        let mut counts = vec![0; self.mesh.triangles.len()];
        // The mesh may be inside out; then every edge bends the other way.
        let (mut inwards, mut outwards) = (0, 0);
        for ((a, b), face) in &edges {
            let Ok(other) = edges.binary_search_by_key(&(*b, *a), |(edge, _)| *edge) else { return false };
            let other = edges[other].1;
            neighbors[*face as usize][counts[*face as usize]] = other;
            counts[*face as usize] += 1;
            let along = (self.mesh.vertices[*b as usize] - self.mesh.vertices[*a as usize]).normalize_or_zero();
            let bend = normal(*face).cross(normal(other)).dot(along);
            outwards += usize::from(bend > FLAT);
            inwards += usize::from(bend < -FLAT);
        }
        if inwards > 0 && outwards > 0 {
            return false;
        }
        let mut reached = vec![false; self.mesh.triangles.len()];
        let mut pending = vec![0];
        let mut count = 0;
        while let Some(face) = pending.pop() {
            if !std::mem::replace(&mut reached[face as usize], true) {
                count += 1;
                pending.extend(neighbors[face as usize].iter().filter(|face| **face != u32::MAX));
            }
        }
        let mut corners: Vec<u32> = self.mesh.triangles.iter().flatten().copied().collect();
        corners.sort_unstable();
        corners.dedup();
        count == self.mesh.triangles.len() && corners.len() + self.mesh.triangles.len() == edges.len() / 2 + 2
    }

    fn points(&self) -> Vec<Vec3> {
        self.mesh.vertices.iter().map(|vertex| vertex.as_vec3()).collect()
    }

    /// The voxels that the mesh goes through. Many large triangles take a coarser grid, to bound the work.
    fn voxels(&self) -> VoxelSet {
        let extents: Vec<DVec3> = self
            .mesh
            .triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(|index| self.mesh.vertices[index as usize]);
                a.max(b).max(c) - a.min(b).min(c)
            })
            .collect();
        let tests = |resolution: u32| -> f64 {
            extents.iter().map(|extent| (*extent * f64::from(resolution) + 3.0).element_product()).sum()
        };
        let resolution = [RESOLUTION, 64, 32, 16].into_iter().find(|resolution| tests(*resolution) <= MOST_TESTS);
        let (points, fill) = (self.points(), FillMode::SurfaceOnly);
        VoxelizedVolume::voxelize(&points, &self.mesh.triangles, resolution.unwrap_or(8), fill, true).into()
    }

    /// Back to the mesh's own scale, with everything verified and measured.
    fn finish(
        &self,
        mut pieces: Vec<Polyhedron>,
        mut dropped: usize,
        field: &Field,
        options: &HullOptions,
    ) -> Result<Decomposition, HullError> {
        pieces.sort_by(|a, b| b.volume().total_cmp(&a.volume()));
        let (simple, mut quality) = self.simplified(&pieces, field, options);
        let errors = std::mem::take(&mut quality.pieces);
        let mut hulls = Vec::with_capacity(pieces.len());
        for ((piece, simple), errors) in pieces.into_iter().zip(simple).zip(errors) {
            // Rounding to 32 bits turns small faces, so the hull is made anew of what will be written.
            let place = |vertex: &DVec3| (*vertex * self.scale + self.center).as_vec3().as_dvec3();
            let rounded: Vec<DVec3> = piece.vertices.iter().map(place).collect();
            let Some(piece) = hull(&rounded, options.max_vertices) else {
                dropped += 1;
                continue;
            };
            let dent = piece.worst_dent() / piece.diagonal();
            if dent > CONVEX {
                return Err(HullError::NotConvex { piece: hulls.len(), dent });
            }
            quality.pieces.push(errors);
            hulls.push(Hull {
                vertices: piece.vertices.iter().map(|vertex| vertex.as_vec3().to_array()).collect(),
                volume: piece.volume(),
                primitive: simple.map(|simple| simple.placed(self.scale, self.center)),
                triangles: piece.triangles,
            });
        }
        if hulls.is_empty() {
            return Err(HullError::Flat);
        }
        Ok(Decomposition { hulls, quality, dropped })
    }
}

impl Unit {
    /// Simple shapes for the pieces that they are no farther from the surface than, and how good the whole is.
    fn simplified(
        &self,
        pieces: &[Polyhedron],
        field: &Field,
        options: &HullOptions,
    ) -> (Vec<Option<Simple>>, Quality) {
        let quality = Quality::of(pieces, &self.mesh, field, SPACING);
        let worst = |errors: &[Distances; 2]| f64::from(errors[0].max.max(errors[1].max));
        let mut simple: Vec<Option<Simple>> = vec![None; pieces.len()];
        if !options.primitives {
            return (simple, quality);
        }
        let diagonal = self.diagonal();
        for (simple, (piece, errors)) in simple.iter_mut().zip(pieces.iter().zip(&quality.pieces)) {
            *simple = Simple::fitting(piece, worst(errors) * diagonal);
        }
        let measured = |simple: &[Option<Simple>]| {
            let shapes: Vec<Polyhedron> = pieces
                .iter()
                .zip(simple)
                .map(|(piece, simple)| simple.and_then(|simple| simple.polyhedron()).unwrap_or_else(|| piece.clone()))
                .collect();
            Quality::of(&shapes, &self.mesh, field, SPACING)
        };
        let found = measured(&simple);
        for (simple, (before, after)) in simple.iter_mut().zip(quality.pieces.iter().zip(&found.pieces)) {
            if worst(after) > worst(before).max(NEGLIGIBLE) {
                *simple = None;
            }
        }
        let quality = if simple.iter().any(Option::is_some) { measured(&simple) } else { quality };
        (simple, quality)
    }
}

/// The hulls of parts, joined as far as a limit allows, and how many have no volume.
fn join(parts: &Parts, field: &Field, limit: f64, options: &HullOptions) -> (Vec<Polyhedron>, usize) {
    let groups =
        parts.0.iter().enumerate().filter_map(|(index, part)| {
            Some(Group { parts: vec![index], hull: part.hull.clone()?, excess: part.excess })
        });
    let groups = merge(groups.collect(), field, limit, options.max_hulls);
    let (groups, halves) = refine(parts, groups, field, options.max_hulls);
    let part = |index: usize| parts.0.get(index).unwrap_or_else(|| &halves[index - parts.0.len()]);
    let mut dropped = 0;
    let pieces = groups.into_iter().filter_map(|group| {
        let points = group.parts.iter().flat_map(|index| &part(*index).mesh.vertices);
        let piece = fitted(&points.copied().collect::<Vec<_>>(), options.max_vertices);
        dropped += usize::from(piece.is_none());
        piece
    });
    (pieces.collect(), dropped)
}

#[cfg(test)]
mod tests;
