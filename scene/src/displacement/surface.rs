//! The displaced surface: where a point of a base triangle goes, and the normal there. `shaders/displace.wgsl` has the same
//! formulas.

use glam::{Mat3, Vec2, Vec3};

use super::height::{HeightMap, transformed};
use super::plan::{Place, Plan, Point};

/// Everything that decides about the displaced surface of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Positions of the base mesh.
    pub positions: &'a [Vec3],
    /// Normals of the base mesh, as many.
    pub normals: &'a [Vec3],
    /// Its texture coordinates for the displacement map, as many.
    pub uvs: &'a [Vec2],
    /// The map.
    pub heights: &'a HeightMap,
    /// Texture matrix.
    pub transform: Mat3,
    /// Displacement where the map is 0.
    pub bias: f32,
    /// Added where it is 1.
    pub scale: f32,
}

/// Corners of a place with their weights.
struct Corners<'a> {
    surface: &'a Surface<'a>,
    place: &'a Place,
    weights: [f32; 3],
}

impl Corners<'_> {
    fn mix<T>(&self, of: impl Fn(usize) -> T) -> T
    where
        T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
    {
        let [a, b, c] = self.place.corners.map(|corner| corner as usize);
        of(a) * self.weights[0] + of(b) * self.weights[1] + of(c) * self.weights[2]
    }

    /// Texture coordinate of a corner.
    fn uv(&self, corner: usize) -> Vec2 {
        let Vec2 { x, y } = self.surface.uvs[corner];
        Vec2::new(if x.is_finite() { x } else { 0.0 }, if y.is_finite() { y } else { 0.0 })
    }

    fn height_uv(&self) -> Vec2 {
        transformed(&self.surface.transform, self.mix(|corner| self.uv(corner)))
    }

    fn displacement(&self) -> f32 {
        self.surface.bias + self.surface.scale * self.surface.heights.at(self.height_uv())
    }

    /// How an attribute changes along the two sides from the first corner.
    fn sides<T: std::ops::Sub<Output = T> + Copy>(&self, of: impl Fn(usize) -> T) -> [T; 2] {
        let [a, b, c] = self.place.corners.map(|corner| corner as usize);
        let first = of(a);
        [of(b) - first, of(c) - first]
    }

    /// The unit normal of the displaced surface, on the side of the base normal.
    ///
    /// The base is taken to be as smooth as its normals are: its sides are seen in the plane at right angles to the normal
    /// n, and displaced they are `e − n(n·e) + d·∂n + n·∂d`. A displacement that is the same everywhere keeps n.
    fn normal(&self, n: Vec3, length: f32, d: f32) -> Vec3 {
        let edges = self.sides(|corner| self.surface.positions[corner]);
        let turns = self.sides(|corner| self.surface.normals[corner]);
        let steps = self.sides(|corner| self.uv(corner));
        let slope = self.surface.heights.slope(self.height_uv()) * self.surface.scale;
        let matrix = &self.surface.transform;
        let side = |k: usize| {
            let step = matrix.x_axis.truncate() * steps[k].x + matrix.y_axis.truncate() * steps[k].y;
            let flat = edges[k] - n * n.dot(edges[k]);
            let turned = (turns[k] - n * n.dot(turns[k])) / length;
            unit_scale(flat + turned * d + n * slope.dot(step))
        };
        let outside = unit_scale(edges[0]).cross(unit_scale(edges[1])).dot(n);
        let normal = unit_scale(side(0).cross(side(1))) * if outside < 0.0 { -1.0 } else { 1.0 };
        let squared = normal.length_squared();
        if outside != 0.0 && squared > 0.0 && squared.is_finite() { normal / squared.sqrt() } else { n }
    }
}

/// A vector whose largest component is 1, or 0: so that products of tiny or huge ones stay in range.
fn unit_scale(v: Vec3) -> Vec3 {
    let largest = v.abs().max_element();
    if largest > 0.0 && largest.is_finite() { v / largest } else { Vec3::ZERO }
}

impl Surface<'_> {
    fn corners<'a>(&'a self, place: &'a Place) -> Corners<'a> {
        let [a, b, c, denominator] = place.weights.map(f32::from);
        Corners { surface: self, place, weights: [a / denominator, b / denominator, c / denominator] }
    }

    /// Position and normal of a vertex of a plan: `P + n·d` with d the mean over its samples. With `recompute` the normal
    /// is that of the displaced surface, else the base's; both are as long as the base's is there.
    pub fn vertex(&self, point: &Point, samples: &[Place], recompute: bool) -> (Vec3, Vec3) {
        let own = self.corners(&point.place);
        let position = own.mix(|corner| self.positions[corner]);
        let interpolated = own.mix(|corner| self.normals[corner]);
        let length = interpolated.length();
        let n = if length > 0.0 { interpolated / length } else { Vec3::ZERO };
        let range = point.first_sample as usize..(point.first_sample + point.sample_count) as usize;
        let shared = &samples[range];
        let d = if shared.is_empty() {
            own.displacement()
        } else {
            shared.iter().map(|place| self.corners(place).displacement()).sum::<f32>() / shared.len() as f32
        };
        let displaced = position + n * d;
        if !recompute || n == Vec3::ZERO {
            return (displaced, interpolated);
        }
        let normal = if shared.is_empty() {
            own.normal(n, length, d)
        } else {
            let sum: Vec3 = shared.iter().map(|place| self.corners(place).normal(n, length, d)).sum();
            if sum.length_squared() > 0.0 { sum.normalize() } else { n }
        };
        (displaced, normal * length)
    }

    /// Positions and normals of all vertices of a plan.
    pub fn vertices(&self, plan: &Plan, recompute: bool) -> (Vec<Vec3>, Vec<Vec3>) {
        plan.points.iter().map(|point| self.vertex(point, &plan.samples, recompute)).unzip()
    }
}

impl Point {
    /// An attribute of the base mesh at this point.
    pub fn mix<T>(&self, of: &[T]) -> T
    where
        T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T> + Copy,
    {
        let [a, b, c, denominator] = self.place.weights.map(f32::from);
        let [i, j, k] = self.place.corners.map(|corner| of[corner as usize]);
        i * (a / denominator) + j * (b / denominator) + k * (c / denominator)
    }
}
