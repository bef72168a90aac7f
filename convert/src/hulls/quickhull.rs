//! The convex hull of points, with a limit on its vertices.
//!
//! Quickhull (Barber, Dobkin, Huhdanpaa, "The Quickhull Algorithm for Convex Hulls", 1996) that always takes the point
//! farthest outside of all, so that stopping at any time leaves the hull of the points that matter most. Which faces a
//! point sees is decided by exact predicates (J. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust
//! Geometric Predicates", 1997), so the result is convex however close the points are.

use glam::DVec3;
use robust::{Coord3D, orient3d};

use super::measure::area;

/// A closed convex mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Polyhedron {
    pub(super) vertices: Vec<DVec3>,
    /// Counter-clockwise seen from outside.
    pub(super) triangles: Vec<[u32; 3]>,
}

struct Face {
    corners: [u32; 3],
    /// The faces beyond the edges from each corner to the next.
    neighbors: [u32; 3],
    normal: DVec3,
    /// Points with `normal · p` above this are outside.
    offset: f64,
    /// Points that this face sees, and none before it did.
    outside: Vec<u32>,
    /// The one of them that is farthest, and how far.
    farthest: (f64, u32),
    alive: bool,
}

impl Face {
    fn distance(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// The hull of points, of which at most `most_vertices` (at least 4) become its vertices; points that stand out by less
/// than 10⁻⁵ of the extent are left out. `None` if the points lie in a plane, within 10⁻⁶ of their extent.
pub(super) fn hull(points: &[DVec3], most_vertices: usize) -> Option<Polyhedron> {
    let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let size = (high - low).max_element();
    if !(size.is_finite() && size > 0.0) {
        return None;
    }
    let mut builder = Builder { points, faces: Vec::new(), alive: 0, fan: vec![0; points.len()] };
    builder.start(FLAT * size)?;
    // Each step adds a vertex; some go inside again, so there may be a few more steps than vertices.
    for _ in 0..4 * most_vertices {
        // Euler's formula of a closed surface of triangles.
        if builder.alive / 2 + 2 >= most_vertices {
            break;
        }
        let Some((face, point)) = builder.farthest(1e-5 * size) else { break };
        if builder.side(face, builder.point(point)) > 0.0 {
            builder.add(face, point);
        } else {
            // Only by rounding, beside a face that is next to nothing.
            builder.leave_out(face, point);
        }
    }
    Some(builder.finish())
}

/// The thickness (of a mesh whose longest side is 1) of the plate that flat points become.
const PLATE: f64 = 1.0 / 256.0;
/// Hulls that are thinner in the mean are flat.
const FLAT_HULL: f64 = 1e-4;

/// The hull of points; one in a plane becomes a thin plate, or nothing would stop at it. `None` if they are on one line.
pub(super) fn solid(points: &[DVec3], most_vertices: usize) -> Option<Polyhedron> {
    let thick = |piece: &Polyhedron| piece.volume() > FLAT_HULL * 0.5 * area(piece);
    let found = hull(points, most_vertices).filter(thick);
    found.or_else(|| {
        let aside = 0.5 * PLATE * plane_normal(points)?;
        let both: Vec<DVec3> = points.iter().flat_map(|point| [*point - aside, *point + aside]).collect();
        hull(&both, most_vertices)
    })
}

/// The normal of the plane in which points lie roughly; `None` if they are on one line, within 10⁻⁶ of their extent.
fn plane_normal(points: &[DVec3]) -> Option<DVec3> {
    let (a, _, c, along) = triangle(points)?;
    let (a, c) = (points[a as usize], points[c as usize]);
    along.cross(c - a).try_normalize()
}

/// The first of the points that are farthest by some measure.
fn farthest(points: &[DVec3], distance: impl Fn(DVec3) -> f64) -> Option<u32> {
    let all = 0..points.len() as u32;
    all.rev().max_by(|a, b| distance(points[*a as usize]).total_cmp(&distance(points[*b as usize])))
}

/// Three points far apart, and the direction from the first to the second.
fn triangle(points: &[DVec3]) -> Option<(u32, u32, u32, DVec3)> {
    let extremes: Vec<u32> = [DVec3::X, DVec3::Y, DVec3::Z]
        .into_iter()
        .flat_map(|axis| [farthest(points, |p| p.dot(axis)), farthest(points, |p| -p.dot(axis))])
        .collect::<Option<_>>()?;
    let pairs = extremes.iter().flat_map(|a| extremes.iter().map(move |b| (*a, *b)));
    let length = |(a, b): (u32, u32)| points[a as usize].distance_squared(points[b as usize]);
    let (a, b) = pairs.rev().max_by(|x, y| length(*x).total_cmp(&length(*y)))?;
    let (pa, pb) = (points[a as usize], points[b as usize]);
    let along = (pb - pa).try_normalize()?;
    let c = farthest(points, |p| (p - pa).reject_from(along).length_squared())?;
    let aside = (points[c as usize] - pa).reject_from(along).length();
    (aside > FLAT * pa.distance(pb)).then_some((a, b, c, along))
}

/// Points within this part of their extent are in a line or plane.
const FLAT: f64 = 1e-6;

struct Builder<'a> {
    points: &'a [DVec3],
    faces: Vec<Face>,
    /// How many faces are alive.
    alive: usize,
    /// The face of the newest fan that starts at each point of the horizon.
    fan: Vec<u32>,
}

impl Builder<'_> {
    /// Above 0 if a point is outside of a face, 0 if it is in its plane.
    fn side(&self, face: u32, point: DVec3) -> f64 {
        let coordinates = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
        let [a, b, c] = self.faces[face as usize].corners.map(|corner| coordinates(self.point(corner)));
        -orient3d(a, b, c, coordinates(point))
    }

    fn point(&self, index: u32) -> DVec3 {
        self.points[index as usize]
    }

    /// A first tetrahedron.
    fn start(&mut self, flat: f64) -> Option<()> {
        let (a, b, c, _) = triangle(self.points)?;
        let (pa, pb) = (self.point(a), self.point(b));
        let normal = (pb - pa).cross(self.point(c) - pa).try_normalize()?;
        let d = farthest(self.points, |p| (p - pa).dot(normal).abs())?;
        let height = (self.point(d) - pa).dot(normal);
        if height.abs() <= flat {
            return None;
        }
        let (b, c) = if height > 0.0 { (c, b) } else { (b, c) };
        let everything: Vec<u32> =
            (0..self.points.len() as u32).filter(|point| ![a, b, c, d].contains(point)).collect();
        let made = [([a, b, c], [1, 2, 3]), ([a, d, b], [3, 2, 0]), ([b, d, c], [1, 3, 0]), ([c, d, a], [2, 1, 0])]
            .map(|(corners, neighbors)| self.push(corners, neighbors));
        self.distribute(everything, &made);
        Some(())
    }

    fn push(&mut self, corners: [u32; 3], neighbors: [u32; 3]) -> u32 {
        let [a, b, c] = corners.map(|corner| self.point(corner));
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let offset = normal.dot(a);
        let (outside, farthest) = (Vec::new(), (0.0, 0));
        self.faces.push(Face { corners, neighbors, normal, offset, outside, farthest, alive: true });
        self.alive += 1;
        self.faces.len() as u32 - 1
    }

    /// Gives each point to the face that it is farthest outside of.
    fn distribute(&mut self, points: Vec<u32>, faces: &[u32]) {
        for point in points {
            let place = self.point(point);
            let mut best = (0.0, None);
            for face in faces {
                let distance = self.faces[*face as usize].distance(place);
                if distance > best.0 {
                    best = (distance, Some(*face));
                }
            }
            if let (distance, Some(face)) = best {
                let face = &mut self.faces[face as usize];
                face.outside.push(point);
                if distance > face.farthest.0 {
                    face.farthest = (distance, point);
                }
            }
        }
    }

    fn leave_out(&mut self, face: u32, point: u32) {
        let face = &mut self.faces[face as usize];
        face.outside.retain(|other| *other != point);
        let distances = face.outside.iter().map(|other| (face.distance(self.points[*other as usize]), *other));
        face.farthest = distances.fold((0.0, 0), |best, each| if each.0 > best.0 { each } else { best });
    }

    /// The point farthest outside, and a face that sees it.
    fn farthest(&self, least: f64) -> Option<(u32, u32)> {
        let mut best = (least, None);
        for (index, face) in self.faces.iter().enumerate() {
            if face.alive && face.farthest.0 > best.0 {
                best = (face.farthest.0, Some((index as u32, face.farthest.1)));
            }
        }
        best.1
    }

    fn kill(&mut self, face: u32) -> Vec<u32> {
        let face = &mut self.faces[face as usize];
        face.alive = false;
        self.alive -= 1;
        std::mem::take(&mut face.outside)
    }

    fn add(&mut self, seen_from: u32, point: u32) {
        let place = self.point(point);
        // All connected faces that the point sees, those in its plane too, so that none of the new ones is a sliver.
        let mut visible = vec![seen_from];
        let mut loose = self.kill(seen_from);
        let mut at = 0;
        while at < visible.len() {
            for neighbor in self.faces[visible[at] as usize].neighbors {
                if self.faces[neighbor as usize].alive && self.side(neighbor, place) >= 0.0 {
                    loose.append(&mut self.kill(neighbor));
                    visible.push(neighbor);
                }
            }
            at += 1;
        }
        let first = self.faces.len() as u32;
        for face in visible {
            let Face { corners, neighbors, .. } = self.faces[face as usize];
            for edge in 0..3 {
                let outer = neighbors[edge];
                if self.faces[outer as usize].alive && outer < first {
                    let (from, to) = (corners[edge], corners[(edge + 1) % 3]);
                    let made = self.push([from, to, point], [outer, 0, 0]);
                    self.fan[from as usize] = made;
                    let beyond = &mut self.faces[outer as usize];
                    if let Some(back) =
                        (0..3).find(|back| beyond.corners[*back] == to && beyond.neighbors[*back] == face)
                    {
                        beyond.neighbors[back] = made;
                    }
                }
            }
        }
        let made: Vec<u32> = (first..self.faces.len() as u32).collect();
        for &face in &made {
            let next = self.fan[self.faces[face as usize].corners[1] as usize];
            self.faces[face as usize].neighbors[1] = next;
            self.faces[next as usize].neighbors[2] = face;
        }
        loose.retain(|other| *other != point);
        self.distribute(loose, &made);
    }

    fn vertices(&self) -> Vec<u32> {
        let mut used: Vec<u32> = self.faces.iter().filter(|face| face.alive).flat_map(|face| face.corners).collect();
        used.sort_unstable();
        used.dedup();
        used
    }

    fn finish(self) -> Polyhedron {
        let used = self.vertices();
        let number = |corner: u32| used.binary_search(&corner).unwrap_or(0) as u32;
        Polyhedron {
            vertices: used.iter().map(|index| self.point(*index)).collect(),
            triangles: self.faces.iter().filter(|face| face.alive).map(|face| face.corners.map(number)).collect(),
        }
    }
}

impl Polyhedron {
    pub(super) fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|index| self.vertices[index as usize])
    }

    /// The corners of the bounding box.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let low = self.vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = self.vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        (low, high)
    }

    pub(super) fn diagonal(&self) -> f64 {
        let (low, high) = self.bounds();
        (high - low).length()
    }

    pub(super) fn volume(&self) -> f64 {
        let origin = self.vertices.first().copied().unwrap_or_default();
        let volume = |triangle: &[u32; 3]| {
            let [a, b, c] = self.corners(*triangle).map(|corner| corner - origin);
            a.dot(b.cross(c)) / 6.0
        };
        self.triangles.iter().map(volume).sum()
    }

    /// Outward unit normal and offset of each face that has an area.
    pub(super) fn planes(&self) -> Vec<(DVec3, f64)> {
        let plane = |triangle: &[u32; 3]| {
            let [a, b, c] = self.corners(*triangle);
            let normal = (b - a).cross(c - a).try_normalize()?;
            Some((normal, normal.dot(a)))
        };
        self.triangles.iter().filter_map(plane).collect()
    }

    /// How far the vertex that is farthest outside of a face's plane is outside of it; 0 or less for a convex mesh. A
    /// mesh that is not closed gives infinity.
    pub(super) fn worst_dent(&self) -> f64 {
        let mut edges: Vec<(u32, u32)> =
            self.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        edges.sort_unstable();
        let once = edges.windows(2).all(|pair| pair[0] != pair[1]);
        let closed = edges.iter().all(|(a, b)| edges.binary_search(&(*b, *a)).is_ok());
        if !once || !closed || edges.is_empty() {
            return f64::INFINITY;
        }
        let planes = self.planes();
        let dents = planes
            .iter()
            .flat_map(|(normal, offset)| self.vertices.iter().map(move |vertex| normal.dot(*vertex) - offset));
        dents.fold(f64::NEG_INFINITY, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(count: usize, seed: u32) -> impl Iterator<Item = DVec3> {
        let mut number = seed;
        let mut next = move || {
            number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(number >> 8) / 8_388_608.0 - 1.0
        };
        (0..count).map(move |_| DVec3::new(next(), next(), next()))
    }

    fn assert_hull(points: &[DVec3], most: usize) -> Polyhedron {
        let found = hull(points, most).unwrap();
        assert!(found.vertices.len() <= most);
        assert!(found.worst_dent() < 1e-9, "{}", found.worst_dent());
        assert!(found.volume() > 0.0);
        assert_eq!(found.triangles.len(), 2 * found.vertices.len() - 4);
        found
    }

    #[test]
    fn a_cube_with_everything_inside_and_on_it() {
        let mut points: Vec<DVec3> = random(2000, 1).collect();
        for (x, y, z) in (0..3).flat_map(|x| (0..3).flat_map(move |y| (0..3).map(move |z| (x, y, z)))) {
            points.push(DVec3::new(f64::from(x), f64::from(y), f64::from(z)) - 1.0);
        }
        let found = assert_hull(&points, 64);
        assert_eq!(found.vertices.len(), 8);
        assert!((found.volume() - 8.0).abs() < 1e-12);
    }

    #[test]
    fn points_on_a_sphere_and_a_limit() {
        let points: Vec<DVec3> = random(3000, 7).map(|point| point.normalize()).collect();
        let whole = assert_hull(&points, 3000);
        // A few stand out by too little.
        assert!((2990..=3000).contains(&whole.vertices.len()), "{}", whole.vertices.len());
        let few = assert_hull(&points, 64);
        assert_eq!(few.vertices.len(), 64);
        assert!(few.volume() > 0.85 * whole.volume(), "{} of {}", few.volume(), whole.volume());
        assert_eq!(few, assert_hull(&points, 64));
    }

    #[test]
    fn prisms_of_many_sides_have_coplanar_caps() {
        let turn = |at: usize| std::f64::consts::TAU * at as f64 / 30.0;
        let ring = (0..30).flat_map(|at| [-1.0, 1.0].map(|z| DVec3::new(turn(at).cos(), turn(at).sin(), z)));
        let found = assert_hull(&ring.collect::<Vec<_>>(), 64);
        assert_eq!(found.vertices.len(), 60);
        let area = 0.5 * 30.0 * (std::f64::consts::TAU / 30.0).sin();
        assert!((found.volume() - 2.0 * area).abs() < 1e-9);
    }

    #[test]
    fn flat_points_have_none() {
        assert_eq!(hull(&[], 64), None);
        assert_eq!(hull(&[DVec3::ONE; 9], 64), None);
        let line: Vec<DVec3> = (0..9).map(|at| DVec3::splat(f64::from(at))).collect();
        assert_eq!(hull(&line, 64), None);
        let plane: Vec<DVec3> = random(100, 3).map(|point| point.with_z(0.25 * point.x)).collect();
        assert_eq!(hull(&plane, 64), None);
    }

    #[test]
    fn random_clusters_and_scales() {
        for seed in 0..200 {
            let scale = 10_f64.powi(seed as i32 % 12 - 6);
            // Snapped to a grid, so that many are coplanar and collinear.
            let points: Vec<DVec3> =
                random(60, seed).map(|point| (point * 3.0).round() * scale * DVec3::new(1.0, 0.5, 0.25)).collect();
            if let Some(found) = hull(&points, 255) {
                let dent = found.worst_dent() / scale;
                assert!(dent < 1e-8, "seed {seed}: {dent}");
                let planes = found.planes();
                let most = planes
                    .iter()
                    .flat_map(|(normal, offset)| points.iter().map(move |point| normal.dot(*point) - offset));
                assert!(most.fold(f64::NEG_INFINITY, f64::max) < 1e-6 * scale, "seed {seed}: a point is outside");
            }
        }
    }
}
