//! Tangent frames by MikkTSpace (Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008), the frames that normal
//! maps are baked in.

use std::collections::HashMap;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};

/// The MikkTSpace code calls itself once for each face around a vertex and compares them with each other: beyond this
/// many faces that share a corner it would need too much stack.
const MAX_FAN: usize = 1024;
/// The most comparisons for each corner that MikkTSpace may cost over a whole mesh; ordinary meshes need about six.
const MAX_COMPARISONS: usize = 64;

/// For each corner a unit tangent (xyz), perpendicular to the normal, and the sign of the bitangent (w, ±1):
/// B = w·cross(N, T). T points to increasing u and B to increasing v.
///
/// The three slices run corner by corner, three for each triangle; what is beyond the shortest of them is ignored.
/// Where texture coordinates give no direction (no area in the texture, or values that are not finite), T is some unit
/// vector perpendicular to N and w is 1. Triangles without area take the frame of a neighbour with the same corner.
/// Meshes with thousands of triangles around one corner, where MikkTSpace takes quadratic time, get its angle-weighted
/// mean over all faces at the corner that have the same handedness, connected by an edge or not.
pub fn tangents(positions: &[Vec3], normals: &[Vec3], uvs: &[Vec2]) -> Vec<Vec4> {
    let count = positions.len().min(normals.len()).min(uvs.len()) / 3 * 3;
    let corners = Corners { positions: &positions[..count], normals: &normals[..count], uvs: &uvs[..count] };
    let shared = corners.weld();
    let healthy: Vec<u32> = (0..count as u32 / 3).filter(|&triangle| corners.healthy(triangle as usize)).collect();

    let mut faces_at = vec![0_usize; count];
    for corner in healthy.iter().flat_map(|&triangle| 3 * triangle as usize..3 * triangle as usize + 3) {
        faces_at[shared[corner] as usize] += 1;
    }
    let largest = faces_at.iter().copied().max().unwrap_or(0);
    let comparisons = faces_at.iter().fold(0_usize, |sum, &faces| sum.saturating_add(faces.saturating_mul(faces)));
    let budget = (1_usize << 22).saturating_add(MAX_COMPARISONS.saturating_mul(count));

    let mut found: Vec<Option<Vec4>> = vec![None; count];
    let affordable = largest <= MAX_FAN && comparisons <= budget;
    let mut mesh = Mesh { corners: &corners, triangles: &healthy, found: &mut found };
    if !(affordable && generate_tangents(&mut mesh).is_ok()) {
        corners.angle_weighted(&healthy, &shared, &mut found);
    }

    // Triangles without area borrow from the first corner that is the same as theirs.
    let mut lender: Vec<Option<Vec4>> = vec![None; count];
    for corner in 0..count {
        let place = &mut lender[shared[corner] as usize];
        *place = place.or(found[corner]);
    }
    (0..count).map(|corner| corners.usable(corner, found[corner].or(lender[shared[corner] as usize]))).collect()
}

struct Corners<'a> {
    positions: &'a [Vec3],
    normals: &'a [Vec3],
    uvs: &'a [Vec2],
}

impl Corners<'_> {
    /// For each corner the first one with the same position, normal and texture coordinates.
    fn weld(&self) -> Vec<u32> {
        // Adding zero turns −0 into 0.
        let bits = |value: f32| (value + 0.0).to_bits();
        let mut first: HashMap<[u32; 8], u32> = HashMap::with_capacity(self.positions.len() / 4);
        (0..self.positions.len())
            .map(|corner| {
                let [x, y, z] = self.positions[corner].to_array().map(bits);
                let [nx, ny, nz] = self.normals[corner].to_array().map(bits);
                let [u, v] = self.uvs[corner].to_array().map(bits);
                *first.entry([x, y, z, nx, ny, nz, u, v]).or_insert(corner as u32)
            })
            .collect()
    }

    /// Whether a triangle has three different finite positions and finite attributes.
    fn healthy(&self, triangle: usize) -> bool {
        let range = 3 * triangle..3 * triangle + 3;
        let p = &self.positions[range.clone()];
        let finite = range.into_iter().all(|corner| {
            self.positions[corner].is_finite() && self.normals[corner].is_finite() && self.uvs[corner].is_finite()
        });
        finite && p[0] != p[1] && p[1] != p[2] && p[2] != p[0]
    }

    /// A unit tangent perpendicular to the corner's normal, from what was found.
    fn usable(&self, corner: usize, found: Option<Vec4>) -> Vec4 {
        let normal = self.normals[corner].try_normalize().unwrap_or(Vec3::Z);
        found
            .and_then(|found| {
                let tangent = found.truncate().reject_from_normalized(normal).try_normalize()?;
                Some(tangent.extend(found.w))
            })
            .unwrap_or_else(|| normal.any_orthonormal_vector().extend(1.0))
    }

    fn angle_weighted(&self, triangles: &[u32], shared: &[u32], found: &mut [Option<Vec4>]) {
        // Two sums at each welded corner: mirrored and unmirrored texture coordinates do not mix.
        let mut sums = vec![[Vec3::ZERO; 2]; self.positions.len()];
        let mut mirrored = vec![None; self.positions.len() / 3];
        for &triangle in triangles {
            let first = 3 * triangle as usize;
            let (p, t) = (&self.positions[first..first + 3], &self.uvs[first..first + 3]);
            let (e1, e2) = (t[1] - t[0], t[2] - t[0]);
            let area = e1.perp_dot(e2);
            if area == 0.0 || !area.is_finite() {
                continue;
            }
            mirrored[triangle as usize] = Some(area < 0.0);
            let along = ((p[1] - p[0]) * e2.y - (p[2] - p[0]) * e1.y) * area.signum();
            for corner in 0..3 {
                let normal = self.normals[first + corner];
                let project = |vector: Vec3| (vector - normal * normal.dot(vector)).normalize_or_zero();
                let to = |other: usize| project(p[(corner + other) % 3] - p[corner]);
                let angle = to(1).dot(to(2)).clamp(-1.0, 1.0).acos();
                sums[shared[first + corner] as usize][usize::from(area < 0.0)] += project(along) * angle;
            }
        }
        for &triangle in triangles {
            if let Some(mirrored) = mirrored[triangle as usize] {
                for corner in 3 * triangle as usize..3 * triangle as usize + 3 {
                    let tangent = sums[shared[corner] as usize][usize::from(mirrored)].try_normalize();
                    found[corner] = tangent.map(|tangent| tangent.extend(if mirrored { -1.0 } else { 1.0 }));
                }
            }
        }
    }
}

/// The healthy triangles, as MikkTSpace asks for them.
struct Mesh<'a> {
    corners: &'a Corners<'a>,
    triangles: &'a [u32],
    found: &'a mut [Option<Vec4>],
}

impl Mesh<'_> {
    fn corner(&self, face: usize, vertex: usize) -> usize {
        3 * self.triangles[face] as usize + vertex
    }
}

impl Geometry for Mesh<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vertex: usize) -> [f32; 3] {
        self.corners.positions[self.corner(face, vertex)].to_array()
    }

    fn normal(&self, face: usize, vertex: usize) -> [f32; 3] {
        self.corners.normals[self.corner(face, vertex)].to_array()
    }

    fn tex_coord(&self, face: usize, vertex: usize) -> [f32; 2] {
        self.corners.uvs[self.corner(face, vertex)].to_array()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, vertex: usize) {
        let corner = self.corner(face, vertex);
        self.found[corner] = space.map(|space| Vec4::from(space.tangent_encoded()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames_are_sound(normals: &[Vec3], tangents: &[Vec4]) {
        for (normal, tangent) in normals.iter().zip(tangents) {
            assert!(tangent.truncate().is_normalized(), "{tangent}");
            assert!(tangent.truncate().dot(*normal).abs() < 1e-5, "{tangent} is not perpendicular to {normal}");
            assert_eq!(tangent.w.abs(), 1.0);
        }
    }

    /// A square in the XY plane; `uv` maps a position to texture coordinates.
    fn square(uv: impl Fn(Vec3) -> Vec2) -> (Vec<Vec3>, Vec<Vec3>, Vec<Vec2>) {
        let corner = |x, y| Vec3::new(x, y, 0.0);
        let positions = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let positions: Vec<_> = positions.into_iter().map(|(x, y)| corner(x, y)).collect();
        let uvs = positions.iter().map(|&position| uv(position)).collect();
        (positions, vec![Vec3::Z; 6], uvs)
    }

    #[test]
    fn a_square_has_the_axes_of_its_texture() {
        let (positions, normals, uvs) = square(|p| Vec2::new(p.x, p.y));
        assert_eq!(tangents(&positions, &normals, &uvs), [Vec4::new(1.0, 0.0, 0.0, 1.0); 6]);
        let (positions, normals, uvs) = square(|p| Vec2::new(-p.x, p.y));
        assert_eq!(tangents(&positions, &normals, &uvs), [Vec4::new(-1.0, 0.0, 0.0, -1.0); 6], "mirrored");
        let (positions, normals, uvs) = square(|p| Vec2::new(p.y, -p.x));
        assert_eq!(tangents(&positions, &normals, &uvs), [Vec4::new(0.0, 1.0, 0.0, 1.0); 6], "turned");
    }

    #[test]
    fn texture_coordinates_without_direction_give_some_frame() {
        let (positions, normals, mut uvs) = square(|_| Vec2::splat(0.5));
        frames_are_sound(&normals, &tangents(&positions, &normals, &uvs));
        uvs[0] = Vec2::new(f32::NAN, f32::INFINITY);
        frames_are_sound(&normals, &tangents(&positions, &normals, &uvs));
        let huge: Vec<Vec3> = positions.iter().map(|p| *p * 1e38).collect();
        frames_are_sound(&normals, &tangents(&huge, &normals, &uvs));
        let (positions, normals, uvs) = square(|p| Vec2::new(1e-30 * p.x, 1e30 * p.y));
        frames_are_sound(&normals, &tangents(&positions, &normals, &uvs));
        assert_eq!(tangents(&positions[..2], &normals, &uvs), [], "less than a triangle");
    }

    #[test]
    fn a_triangle_without_area_takes_its_neighbours_frame() {
        let (mut positions, mut normals, mut uvs) = square(|p| Vec2::new(p.y, -p.x));
        positions.extend([positions[0], positions[0], positions[1]]);
        normals.extend([Vec3::Z; 3]);
        uvs.extend([uvs[0], uvs[0], uvs[1]]);
        let found = tangents(&positions, &normals, &uvs);
        assert_eq!(found[6..], [Vec4::new(0.0, 1.0, 0.0, 1.0); 3]);
    }

    /// A closed fan around the origin, planar mapped.
    fn fan(count: usize) -> (Vec<Vec3>, Vec<Vec3>, Vec<Vec2>) {
        let rim = |i: usize| {
            let angle = std::f64::consts::TAU * (i % count) as f64 / count as f64;
            Vec3::new(angle.cos() as f32, angle.sin() as f32, 0.0)
        };
        let positions: Vec<Vec3> = (0..count).flat_map(|i| [Vec3::ZERO, rim(i), rim(i + 1)]).collect();
        let uvs = positions.iter().map(|p| Vec2::new(p.x, p.y)).collect();
        let normals = vec![Vec3::Z; positions.len()];
        (positions, normals, uvs)
    }

    #[test]
    fn a_large_fan_is_neither_slow_nor_deep() {
        for faces in [MAX_FAN, 200_000] {
            let (positions, normals, uvs) = fan(faces);
            for tangent in tangents(&positions, &normals, &uvs) {
                assert!(tangent.abs_diff_eq(Vec4::new(1.0, 0.0, 0.0, 1.0), 1e-3), "{tangent}");
            }
        }
    }

    #[test]
    fn the_linear_way_agrees_with_mikktspace() {
        // A bumpy grid with shared, tilted normals and sheared texture coordinates, half of them mirrored.
        let size = 24;
        let point = |x: usize, y: usize| {
            let (x, y) = (x as f32, y as f32);
            Vec3::new(x, y, (0.7 * x).sin() + (0.4 * y).cos())
        };
        let normal = |x: usize, y: usize| {
            let (x, y) = (x as f32, y as f32);
            Vec3::new(-0.7 * (0.7 * x).cos(), 0.4 * (0.4 * y).sin(), 1.0).normalize()
        };
        let (mut positions, mut normals, mut uvs) = (Vec::new(), Vec::new(), Vec::new());
        for x in 0..size {
            for y in 0..size {
                for (dx, dy) in [(0, 0), (1, 0), (1, 1), (0, 0), (1, 1), (0, 1)] {
                    let (i, j) = (x + dx, y + dy);
                    positions.push(point(i, j));
                    normals.push(normal(i, j));
                    let side = if x < size / 2 { 1.0 } else { -1.0 };
                    uvs.push(Vec2::new(side * (i as f32 - 12.0) + 0.3 * j as f32, 1.7 * j as f32));
                }
            }
        }
        let truth = tangents(&positions, &normals, &uvs);
        frames_are_sound(&normals, &truth);
        let corners = Corners { positions: &positions, normals: &normals, uvs: &uvs };
        let all: Vec<u32> = (0..positions.len() as u32 / 3).collect();
        let mut found = vec![None; positions.len()];
        corners.angle_weighted(&all, &corners.weld(), &mut found);
        for (corner, truth) in truth.iter().enumerate() {
            assert!(corners.usable(corner, found[corner]).abs_diff_eq(*truth, 1e-4), "corner {corner}");
        }
    }
}
