//! Convex decomposition, for the bodies of a physics simulation.
//!
//! A convex mesh is its own hull. Others are cut by V-HACD (K. Mamou, "Volumetric Hierarchical Approximate Convex
//! Decomposition", 2016) as in parry3d, on a grid of 128 voxels along the longest side; the surface in each part gets a
//! hull of our own, exactly convex and with a limit on its vertices. The mesh is checked and scaled to a unit box first,
//! so that what parry3d asserts of its input holds.

mod clouds;
mod measure;
mod quickhull;

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use parry3d::transformation::vhacd::{VHACD, VHACDParameters};
use parry3d::transformation::voxelization::{FillMode, VoxelSet, VoxelizedVolume};

use measure::{Error, Surface};
use quickhull::{Polyhedron, hull, plane_normal};

/// How to decompose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullOptions {
    /// The most pieces, at least 1. Default 64.
    pub max_hulls: usize,
    /// Largest distance between pieces and surface, as a part of the bounding box's diagonal. Where it is given, pieces
    /// are no more than needed to keep it, as far as `max_hulls` allows.
    pub max_error: Option<f32>,
    /// The most vertices of a piece, from 4 to 255. Default 64, what GPU physics takes.
    pub max_vertices: usize,
}

impl Default for HullOptions {
    fn default() -> Self {
        Self { max_hulls: 64, max_error: None, max_vertices: 64 }
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
}

/// Convex pieces of a mesh, largest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Decomposition {
    /// The pieces.
    pub hulls: Vec<Hull>,
    /// Largest distance from the outside of the pieces to the surface, as a part of the diagonal (one-way Hausdorff, by
    /// about 10 000 samples).
    pub error: f32,
    /// Largest distance from the surface to the pieces, likewise: what a limit on vertices cuts off.
    pub uncovered: f32,
    /// Parts that are points or lines, and were left out. (Flat ones become plates, half a voxel thick.)
    pub dropped: usize,
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
/// V-HACD's concavity limit where no error is asked for, as peers measure best with this resolution.
const CONCAVITY: f32 = 0.005;
/// Limits to try where one is, from few pieces to many.
const CONCAVITIES: [f32; 6] = [0.08, 0.03, 0.012, 0.005, 0.002, 0.0008];
/// Parts with less volume (of a box of longest side 1) are flat.
const MOST_FLAT: f64 = 1e-9;
/// The largest dent of a piece, as a part of its diagonal.
const CONVEX: f64 = 1e-4;
/// Tests of a triangle against a voxel that one decomposition may cost.
const MOST_TESTS: f64 = 2e7;
/// The thickness of the plate that a flat part becomes, in voxels.
const PLATE: f64 = 0.5;

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
    let mut surface = Surface::new(&mesh.vertices, &mesh.triangles).ok_or(HullError::Empty)?;
    let whole = hull(&mesh.vertices, options.max_vertices).ok_or(HullError::Flat)?;
    if options.max_hulls == 1 || mesh.is_convex() {
        return mesh.finish(vec![whole], 0, &surface, options);
    }

    let mut voxels = Some(mesh.voxels());
    if let Some(voxels) = &voxels {
        surface.fill(voxels);
    }
    let concavities: &[f32] = if options.max_error.is_some() { &CONCAVITIES } else { &[CONCAVITY] };
    let mut best: Option<(Vec<Polyhedron>, usize, Error)> = None;
    let limit = options.max_error.map_or(f64::INFINITY, f64::from);
    if options.max_error.is_some() {
        let error = surface.error(std::slice::from_ref(&whole));
        best = Some((vec![whole.clone()], 0, error));
    }
    for concavity in concavities {
        if best.as_ref().is_some_and(|(_, _, error)| error.worst() <= limit) {
            break;
        }
        let (pieces, dropped) = mesh.pieces(voxels.take().unwrap_or_else(|| mesh.voxels()), *concavity, options);
        if pieces.is_empty() {
            continue;
        }
        let error = surface.error(&pieces);
        if best.as_ref().is_none_or(|(_, _, least)| error.worst() < least.worst()) {
            best = Some((pieces, dropped, error));
        }
    }
    let (pieces, dropped) = best.map_or_else(|| (vec![whole], 0), |(pieces, dropped, _)| (pieces, dropped));
    mesh.finish(pieces, dropped, &surface, options)
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
            "--max-error must be above 0; 0.02 is 2 % of the bounding box's diagonal".into(),
        ));
    }
    Ok(())
}

/// A mesh scaled to a unit box, vertices of equal position made one, triangles without area left out.
struct Unit {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    center: DVec3,
    scale: f64,
}

impl Unit {
    fn new(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Self, HullError> {
        let mut used = Vec::new();
        let mut numbers: BTreeMap<[u32; 3], u32> = BTreeMap::new();
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
        welded.retain(|triangle| {
            let [a, b, c] = triangle.map(|index| vertices[index as usize]);
            (b - a).cross(c - a).length() > 1e-14
        });
        if welded.is_empty() { Err(HullError::Empty) } else { Ok(Self { vertices, triangles: welded, center, scale }) }
    }

    /// Whether the mesh is the surface of a convex solid: closed, in one piece, without handles, and no edge bends
    /// inwards. Then it is convex as a whole (J. van Heijenoort, "On Locally Convex Manifolds", 1952).
    fn is_convex(&self) -> bool {
        /// Angles in radians that bend inwards by less are rounding.
        const FLAT: f64 = 1e-4;
        let mut edges: Vec<((u32, u32), u32)> = Vec::with_capacity(3 * self.triangles.len());
        for (face, &[a, b, c]) in self.triangles.iter().enumerate() {
            edges.extend([((a, b), face as u32), ((b, c), face as u32), ((c, a), face as u32)]);
        }
        edges.sort_unstable();
        if edges.windows(2).any(|pair| pair[0].0 == pair[1].0) {
            return false;
        }
        let normal = |face: u32| {
            let [a, b, c] = self.triangles[face as usize].map(|index| self.vertices[index as usize]);
            (b - a).cross(c - a).normalize_or_zero()
        };
        let mut neighbors = vec![[u32::MAX; 3]; self.triangles.len()];
        let mut counts = vec![0; self.triangles.len()];
        // The mesh may be inside out; then every edge bends the other way.
        let (mut inwards, mut outwards) = (0, 0);
        for ((a, b), face) in &edges {
            let Ok(other) = edges.binary_search_by_key(&(*b, *a), |(edge, _)| *edge) else { return false };
            let other = edges[other].1;
            neighbors[*face as usize][counts[*face as usize]] = other;
            counts[*face as usize] += 1;
            let along = (self.vertices[*b as usize] - self.vertices[*a as usize]).normalize_or_zero();
            let bend = normal(*face).cross(normal(other)).dot(along);
            outwards += usize::from(bend > FLAT);
            inwards += usize::from(bend < -FLAT);
        }
        if inwards > 0 && outwards > 0 {
            return false;
        }
        let mut reached = vec![false; self.triangles.len()];
        let mut pending = vec![0];
        let mut count = 0;
        while let Some(face) = pending.pop() {
            if !std::mem::replace(&mut reached[face as usize], true) {
                count += 1;
                pending.extend(neighbors[face as usize].iter().filter(|face| **face != u32::MAX));
            }
        }
        let mut corners: Vec<u32> = self.triangles.iter().flatten().copied().collect();
        corners.sort_unstable();
        corners.dedup();
        count == self.triangles.len() && corners.len() + self.triangles.len() == edges.len() / 2 + 2
    }

    fn points(&self) -> Vec<Vec3> {
        self.vertices.iter().map(|vertex| vertex.as_vec3()).collect()
    }

    /// The mesh as voxels, filled. Many large triangles take a coarser grid, to bound the work.
    fn voxels(&self) -> VoxelSet {
        let extents: Vec<DVec3> = self
            .triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(|index| self.vertices[index as usize]);
                a.max(b).max(c) - a.min(b).min(c)
            })
            .collect();
        let tests = |resolution: u32| -> f64 {
            extents.iter().map(|extent| (*extent * f64::from(resolution) + 3.0).element_product()).sum()
        };
        let resolution = [RESOLUTION, 64, 32, 16].into_iter().find(|resolution| tests(*resolution) <= MOST_TESTS);
        let fill = FillMode::FloodFill { detect_cavities: false };
        VoxelizedVolume::voxelize(&self.points(), &self.triangles, resolution.unwrap_or(8), fill, true).into()
    }

    /// The hulls of the parts of a decomposition, merged to as many as may be, and how many parts had no volume.
    fn pieces(&self, voxels: VoxelSet, concavity: f32, options: &HullOptions) -> (Vec<Polyhedron>, usize) {
        // This limit is really one on the depth of cuts, and a low one leaves parts whole that sorely need a cut: so it
        // is high, and what is too many is merged below.
        let parameters =
            VHACDParameters { concavity, resolution: RESOLUTION, max_convex_hulls: 1024, ..VHACDParameters::default() };
        let parts = VHACD::from_voxels(&parameters, voxels);
        let clouds = clouds::of_parts(&self.vertices, &self.triangles, parts.voxel_parts());
        let mut pieces = Vec::new();
        let mut dropped = 0;
        for points in clouds {
            // A wall without thickness becomes a plate, or nothing would stop at it.
            let solid = hull(&points, options.max_vertices).filter(|piece| piece.volume() > MOST_FLAT);
            match solid.or_else(|| plate(&points, options.max_vertices)) {
                Some(piece) => pieces.push(piece),
                None => dropped += 1,
            }
        }
        merge(&mut pieces, options);
        (pieces, dropped)
    }

    /// Back to the mesh's own scale, with everything verified and measured.
    fn finish(
        &self,
        mut pieces: Vec<Polyhedron>,
        mut dropped: usize,
        surface: &Surface,
        options: &HullOptions,
    ) -> Result<Decomposition, HullError> {
        pieces.sort_by(|a, b| b.volume().total_cmp(&a.volume()));
        let error = surface.error(&pieces);
        let mut hulls = Vec::with_capacity(pieces.len());
        for piece in pieces {
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
            hulls.push(Hull {
                vertices: piece.vertices.iter().map(|vertex| vertex.as_vec3().to_array()).collect(),
                volume: piece.volume(),
                triangles: piece.triangles,
            });
        }
        if hulls.is_empty() {
            return Err(HullError::Flat);
        }
        Ok(Decomposition { hulls, error: error.outside as f32, uncovered: error.uncovered as f32, dropped })
    }
}

/// The hull of points in a plane, made [`PLATE`] thick; `None` if they are on one line.
fn plate(points: &[DVec3], most_vertices: usize) -> Option<Polyhedron> {
    let normal = plane_normal(points)?;
    let half = 0.5 * PLATE / f64::from(RESOLUTION) * normal;
    let both: Vec<DVec3> = points.iter().flat_map(|point| [*point - half, *point + half]).collect();
    hull(&both, most_vertices)
}

/// Joins the two pieces whose common hull adds the least volume, until there are no more than allowed. Pieces that touch
/// come first.
fn merge(pieces: &mut Vec<Polyhedron>, options: &HullOptions) {
    let joined = |a: &Polyhedron, b: &Polyhedron| {
        let points: Vec<DVec3> = a.vertices.iter().chain(&b.vertices).copied().collect();
        hull(&points, options.max_vertices).map(|union| (union.volume() - a.volume() - b.volume(), union))
    };
    let touch = |a: &(DVec3, DVec3), b: &(DVec3, DVec3)| {
        let margin = 1.0 / f64::from(RESOLUTION);
        (a.0 - margin).cmple(b.1).all() && (b.0 - margin).cmple(a.1).all()
    };
    let mut volumes: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    let mut boxes: Vec<(DVec3, DVec3)> = pieces.iter().map(Polyhedron::bounds).collect();
    let mut ids: Vec<usize> = (0..pieces.len()).collect();
    let mut next = pieces.len();
    let mut only_touching = true;
    while pieces.len() > options.max_hulls {
        let mut best: Option<(f64, usize, usize)> = None;
        for a in 0..pieces.len() {
            for b in a + 1..pieces.len() {
                if only_touching && !touch(&boxes[a], &boxes[b]) {
                    continue;
                }
                let added = *volumes
                    .entry((ids[a], ids[b]))
                    .or_insert_with(|| joined(&pieces[a], &pieces[b]).map_or(f64::INFINITY, |(added, _)| added));
                if best.is_none_or(|(least, _, _)| added < least) {
                    best = Some((added, a, b));
                }
            }
        }
        let Some((a, b, union)) = best.and_then(|(_, a, b)| Some((a, b, joined(&pieces[a], &pieces[b])?.1))) else {
            if std::mem::replace(&mut only_touching, false) {
                continue;
            }
            return;
        };
        for index in [b, a] {
            pieces.remove(index);
            boxes.remove(index);
            ids.remove(index);
        }
        // The new one stands last, so that its number is larger than those of all others.
        boxes.push(union.bounds());
        pieces.push(union);
        ids.push(next);
        next += 1;
    }
}

#[cfg(test)]
mod tests;
