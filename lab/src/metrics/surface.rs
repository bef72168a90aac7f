//! How far a tessellated surface is from the displaced surface that it stands for.

use aam_scene::displacement::{Base, Place, Plan, Point, Surface};
use glam::{DVec3, Vec3};

/// Distances of points of the limit surface, an infinitely fine tessellation, from a tessellated one, in object units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceError {
    /// Root of the mean squared distance, by area of the base mesh.
    pub rms: f64,
    /// The largest.
    pub max: f64,
    /// Area of the base mesh that was looked at.
    pub area: f64,
}

impl SurfaceError {
    /// The error over both surfaces.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        let area = self.area + other.area;
        let squares = self.area * self.rms * self.rms + other.area * other.rms * other.rms;
        let rms = if area > 0.0 { (squares / area).sqrt() } else { 0.0 };
        Self { rms, max: self.max.max(other.max), area }
    }
}

/// Looks at the limit of `surface`, of which `drawn` is drawn with a plan (the same surface but for what is left out), at the points of a lattice of `parts` parts along each edge of the base mesh, whatever the
/// plan, and takes the distance from the tessellated triangle that has the point in it: the nearest triangle of all is not
/// farther.
pub fn surface_error(base: &Base, surface: &Surface<'_>, drawn: &Surface<'_>, plan: &Plan, parts: u16) -> SurfaceError {
    let (positions, _) = drawn.vertices(plan, false);
    let (mut sum, mut total, mut max) = (0.0, 0.0, 0.0_f64);
    let mut start = 0;
    for number in 0..base.len() {
        let vertices = base.triangle(number);
        let corners = vertices.map(|vertex| surface.positions[vertex as usize].as_dvec3());
        let area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
        let end = plan.ends[number] as usize;
        let (mut squares, mut count) = (0.0, 0_u32);
        for triangle in plan.indices[start..end].chunks_exact(3) {
            let [a, b, c] = [triangle[0], triangle[1], triangle[2]].map(|point| point as usize);
            let places = [a, b, c].map(|point| weights(&plan.points[point].place, vertices));
            let corners = [a, b, c].map(|point| positions[point].as_dvec3());
            inside(places, parts, |numerators| {
                let [i, j, k] = numerators;
                let place = Place { corners: vertices, weights: [i, j, k, parts] };
                let (limit, _) = surface.vertex(&Point { place, first_sample: 0, sample_count: 0 }, &[], false);
                let apart = distance_squared(limit, corners);
                squares += apart;
                max = max.max(apart);
                count += 1;
            });
        }
        start = end;
        if count > 0 {
            sum += area * squares / f64::from(count);
            total += area;
        }
    }
    let rms = if total > 0.0 { (sum / total).sqrt() } else { 0.0 };
    SurfaceError { rms, max: max.sqrt(), area: 0.5 * total }
}

/// Weights of a base triangle's corners at a place that lies in it.
fn weights(place: &Place, vertices: [u32; 3]) -> [f64; 3] {
    let [n0, n1, n2, denominator] = place.weights.map(f64::from);
    let mut weights = [0.0; 3];
    for (corner, numerator) in place.corners.into_iter().zip([n0, n1, n2]) {
        if let Some(k) = vertices.iter().position(|&vertex| vertex == corner) {
            weights[k] += numerator / denominator;
        }
    }
    weights
}

/// Calls for each lattice point in a part of a base triangle; those on sides are in both parts.
fn inside(places: [[f64; 3]; 3], parts: u16, mut visit: impl FnMut([u16; 3])) {
    let lattice = places.map(|weights| [weights[0], weights[1]].map(|weight| weight * f64::from(parts)));
    let [a, b, c] = lattice;
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    if area == 0.0 {
        return;
    }
    let span = |axis: usize| {
        let values = lattice.map(|point| point[axis]);
        let low = values.into_iter().fold(f64::INFINITY, f64::min);
        let high = values.into_iter().fold(0.0, f64::max);
        (low - 1e-6).ceil().max(0.0) as u16..=((high + 1e-6).floor() as u16).min(parts)
    };
    for i in span(0) {
        for j in span(1) {
            let p = [f64::from(i), f64::from(j)];
            let v = ((p[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (p[1] - a[1])) / area;
            let w = ((b[0] - a[0]) * (p[1] - a[1]) - (p[0] - a[0]) * (b[1] - a[1])) / area;
            if v >= -1e-9 && w >= -1e-9 && v + w <= 1.0 + 1e-9 && i + j <= parts {
                visit([i, j, parts - i - j]);
            }
        }
    }
}

/// From a point to the nearest of a triangle.
fn distance_squared(p: Vec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let p = p.as_dvec3();
    let (u, v, w) = (b - a, c - a, p - a);
    let normal = u.cross(v);
    let area = normal.length_squared();
    if area > 0.0 {
        let (s, t) = (w.cross(v).dot(normal) / area, u.cross(w).dot(normal) / area);
        if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
            return w.dot(normal).powi(2) / area;
        }
    }
    let to_side = |from: DVec3, to: DVec3| {
        let along = to - from;
        let share = (p - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        p.distance_squared(from + along * share.clamp(0.0, 1.0))
    };
    to_side(a, b).min(to_side(b, c)).min(to_side(c, a))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use aam_scene::displacement::{Detail, HeightMap, Viewer, classes, of_subset};
    use aam_scene::{Scene, View};
    use glam::Affine3A;

    use super::*;

    fn medallion() -> (Scene, View) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/assets/medallion.scene.toml");
        let (scene, camera) = crate::load(&path).unwrap();
        (scene, View { camera: camera.unwrap(), width: 1024, height: 768, frame: 0.0 })
    }

    fn with_surface<T>(scene: &Scene, look: impl FnOnce(&Base, &Surface<'_>) -> T) -> T {
        let mesh = &scene.meshes[0];
        let displaced = of_subset(scene, mesh, &mesh.subsets[0]).unwrap();
        let heights = HeightMap::new(displaced.image).unwrap();
        let base = Base::new(mesh, &mesh.subsets[0], &classes(mesh));
        let surface = Surface {
            positions: &mesh.positions,
            normals: &mesh.normals,
            uvs: displaced.uvs,
            heights: &heights,
            transform: displaced.transform,
            bias: displaced.parameters.bias,
            scale: displaced.parameters.scale,
        };
        look(&base, &surface)
    }

    #[test]
    fn finer_tessellations_are_nearer_with_the_square_of_their_factor() {
        let (scene, _) = medallion();
        with_surface(&scene, |base, surface| {
            let error =
                |factor| surface_error(base, surface, surface, &Plan::uniform(base, factor, "", 1 << 23).unwrap(), 96);
            let errors = [4, 8, 16, 32].map(|factor| error(factor).rms);
            println!("{errors:?}");
            assert!(errors.windows(2).all(|pair| pair[1] < 0.5 * pair[0]), "{errors:?}");
            // Both are the same up to rounding.
            assert!(error(96).rms < 1e-7, "{}", error(96).rms);
        });
    }

    #[test]
    fn adaptive_reaches_the_error_of_uniform_with_a_quarter_of_its_triangles() {
        let (scene, view) = medallion();
        with_surface(&scene, |base, surface| {
            let detail = Detail::new(surface.heights);
            // Below, the detail needs more triangles than a coarse grid has.
            for factor in [16, 32] {
                let uniform = Plan::uniform(base, factor, "", 1 << 23).unwrap();
                let goal = surface_error(base, surface, surface, &uniform, 96);
                let mut pixel_error = 1000.0;
                let (adaptive, error) = loop {
                    let viewer = Viewer::new(&view, &[Affine3A::IDENTITY], pixel_error);
                    let (plan, _) = Plan::adaptive(base, surface, &detail, &viewer, "", 1 << 23).unwrap();
                    let error = surface_error(base, surface, surface, &plan, 96);
                    if error.rms <= goal.rms {
                        break (plan, error);
                    }
                    pixel_error *= 0.85;
                };
                let (few, many) = (adaptive.triangle_count(), uniform.triangle_count());
                println!(
                    "factor {factor}: {many} triangles, RMS {:.2e}; adaptive {pixel_error:.2} pixels: {few} triangles, RMS {:.2e}",
                    goal.rms, error.rms
                );
                assert!(4 * few <= many, "factor {factor}: {few} of {many} triangles");
            }
        });
    }
}
