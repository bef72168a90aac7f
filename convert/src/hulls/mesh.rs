//! Triangles that planes cut.

use std::collections::BTreeMap;

use glam::DVec3;

/// Points nearer to a plane than this (of a box of longest side 1) are on it.
const ON: f64 = 1e-7;

/// The points where `normal · p` is `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub(super) normal: DVec3,
    pub(super) offset: f64,
}

impl Plane {
    /// The plane through a point; the normal need not be unit. `None` if it has no direction.
    pub(super) fn through(point: DVec3, normal: DVec3) -> Option<Self> {
        let normal = normal.try_normalize()?;
        Some(Self { normal, offset: normal.dot(point) })
    }

    /// The distance, 0 for what is on the plane.
    fn distance(&self, point: DVec3) -> f64 {
        let distance = self.normal.dot(point) - self.offset;
        if distance.abs() < ON { 0.0 } else { distance }
    }
}

/// Triangles, outside counter-clockwise.
#[derive(Clone, Debug, Default)]
pub(super) struct Mesh {
    pub(super) vertices: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    pub(super) fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|index| self.vertices[index as usize])
    }

    /// Adds the triangles of another.
    pub(super) fn append(&mut self, other: &Self) {
        let base = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|index| index + base)));
    }

    /// The corners of the bounding box.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let low = self.vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = self.vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        (low, high)
    }

    /// The volume inside, negative for a mesh that is inside out; of an open mesh it is that of its cone from the origin.
    pub(super) fn volume(&self) -> f64 {
        let volume = |triangle: &[u32; 3]| {
            let [a, b, c] = self.corners(*triangle);
            a.dot(b.cross(c)) / 6.0
        };
        self.triangles.iter().map(volume).sum()
    }

    fn area(&self) -> f64 {
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = self.corners(*triangle);
            0.5 * (b - a).cross(c - a).length()
        };
        self.triangles.iter().map(area).sum()
    }

    /// About so many triangles of the same shape: the vertices in each cell of a grid are made one.
    pub(super) fn simplified(&self, triangles: usize) -> Self {
        // A surface meets a cell in about two triangles.
        let cell = (2.0 * self.area() / triangles as f64).sqrt().max(1e-6);
        let mut found = Self::default();
        let mut cells: BTreeMap<[i64; 3], u32> = BTreeMap::new();
        let numbers: Vec<u32> = self
            .vertices
            .iter()
            .map(|vertex| {
                *cells.entry((*vertex / cell).floor().to_array().map(|value| value as i64)).or_insert_with(|| {
                    found.vertices.push(*vertex);
                    found.vertices.len() as u32 - 1
                })
            })
            .collect();
        let triangles = self.triangles.iter().map(|triangle| triangle.map(|index| numbers[index as usize]));
        found.triangles = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        found
    }

    /// Which side of a plane a triangle is on: behind (0), in front (1), or both. What lies in the plane bounds a solid
    /// behind the triangle.
    fn sides(&self, triangle: [u32; 3], distances: &[f64], plane: &Plane) -> [bool; 2] {
        let each = triangle.map(|index| distances[index as usize]);
        let sides = [each.iter().any(|distance| *distance < 0.0), each.iter().any(|distance| *distance > 0.0)];
        if sides == [false; 2] {
            let [a, b, c] = self.corners(triangle);
            let behind = (b - a).cross(c - a).dot(plane.normal) > 0.0;
            return [behind, !behind];
        }
        sides
    }

    fn distances(&self, plane: &Plane) -> Vec<f64> {
        self.vertices.iter().map(|vertex| plane.distance(*vertex)).collect()
    }

    /// The points of each side of a plane, whose hulls are those of the sides.
    pub(super) fn points_beside(&self, plane: &Plane) -> [Vec<DVec3>; 2] {
        let distances = self.distances(plane);
        let mut used = vec![0_u8; self.vertices.len()];
        let mut points = [Vec::new(), Vec::new()];
        for triangle in &self.triangles {
            let sides = self.sides(*triangle, &distances, plane);
            if sides != [true; 2] {
                let bit = 1 << u8::from(sides[1]);
                triangle.iter().for_each(|index| used[*index as usize] |= bit);
                continue;
            }
            for i in 0..3 {
                let (from, to) = (triangle[i], triangle[(i + 1) % 3]);
                let (before, after) = (distances[from as usize], distances[to as usize]);
                used[from as usize] |= u8::from(before <= 0.0) | u8::from(before >= 0.0) << 1;
                if before * after < 0.0 {
                    let point = self.crossing(from, to, before, after);
                    points.iter_mut().for_each(|side| side.push(point));
                }
            }
        }
        for (vertex, sides) in self.vertices.iter().zip(used) {
            (0..2).filter(|side| sides >> side & 1 == 1).for_each(|side| points[side].push(*vertex));
        }
        points
    }

    /// Where an edge meets the plane. The same for both directions of the edge.
    fn crossing(&self, from: u32, to: u32, before: f64, after: f64) -> DVec3 {
        let ((from, before), (to, after)) =
            if from < to { ((from, before), (to, after)) } else { ((to, after), (from, before)) };
        let (from, to) = (self.vertices[from as usize], self.vertices[to as usize]);
        from + (to - from) * (before / (before - after))
    }

    /// The two sides of a plane, behind and in front.
    pub(super) fn cut(&self, plane: &Plane) -> [Self; 2] {
        let distances = self.distances(plane);
        [false, true].map(|front| {
            let sign = if front { 1.0 } else { -1.0 };
            let mut side = Side::default();
            for triangle in &self.triangles {
                let sides = self.sides(*triangle, &distances, plane);
                if !sides[usize::from(front)] {
                    continue;
                }
                if !sides[usize::from(!front)] {
                    let triangle = triangle.map(|index| side.keep(self, index));
                    side.mesh.triangles.push(triangle);
                    continue;
                }
                let mut polygon = [0; 4];
                let mut count = 0;
                for i in 0..3 {
                    let (from, to) = (triangle[i], triangle[(i + 1) % 3]);
                    let (before, after) = (distances[from as usize], distances[to as usize]);
                    if before * sign >= 0.0 {
                        polygon[count] = side.keep(self, from);
                        count += 1;
                    }
                    if before * after < 0.0 {
                        polygon[count] = side.cross(self, from, to, before, after);
                        count += 1;
                    }
                }
                side.mesh.triangles.extend((1..count - 1).map(|i| [polygon[0], polygon[i], polygon[i + 1]]));
            }
            side.mesh
        })
    }
}

/// One side of a cut, while it grows.
#[derive(Default)]
struct Side {
    mesh: Mesh,
    kept: BTreeMap<(u32, u32), u32>,
}

impl Side {
    fn number(&mut self, key: (u32, u32), point: impl FnOnce() -> DVec3) -> u32 {
        *self.kept.entry(key).or_insert_with(|| {
            self.mesh.vertices.push(point());
            self.mesh.vertices.len() as u32 - 1
        })
    }

    fn keep(&mut self, mesh: &Mesh, index: u32) -> u32 {
        self.number((index, index), || mesh.vertices[index as usize])
    }

    fn cross(&mut self, mesh: &Mesh, from: u32, to: u32, before: f64, after: f64) -> u32 {
        self.number((from.min(to), from.max(to)), || mesh.crossing(from, to, before, after))
    }
}
