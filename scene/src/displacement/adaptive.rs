//! Tessellation as fine as the picture needs: edges are halved while the map, seen from the camera, deviates too much.
//!
//! Whether an edge is halved follows from the edge alone: its ends, and the map around it on all its sides. So triangles on
//! both sides of it agree without knowing of each other, and there are no cracks between different factors. A triangle none
//! of whose edges is halved is drawn as it is: the square of the map around its longest edge, as far as √3/2 of its length,
//! holds all of it, so that its error is below the edge's bound.

use glam::{Affine3A, Mat3, Vec2, Vec3};

use super::base::Base;
use super::detail::Detail;
use super::height::transformed;
use super::plan::{Builder, Plan, check_count};
use super::surface::Surface;
use super::{DisplacementError, MAX_TESSELLATION, MAX_TRIANGLES, MIN_PIXEL_ERROR};
use crate::{Projection, View};

/// How far from the middle of a triangle's longest side its farthest corner can be, in lengths of that side.
const REACH: f32 = 0.866_026;

/// Where surfaces are seen from, and how exact they must be.
#[derive(Clone, Debug, PartialEq)]
pub struct Viewer {
    /// From each instance's coordinates to the camera's, and the most that this stretches anything.
    instances: Vec<(Affine3A, f32)>,
    /// Pixels that a length at distance 1 is seen as at most; at any distance for parallel views.
    pixels: f32,
    perspective: bool,
    /// Tangents of half the view's angles, or half its width and height for parallel views.
    half: Vec2,
    near: f32,
    /// The largest deviation in pixels.
    tolerance: f32,
}

impl Viewer {
    /// A view of a mesh's instances, given by their world transforms. Between two tessellations that are both within half of
    /// `pixel_error` of the displaced surface, no point moves by more than `pixel_error` pixels.
    pub fn new(view: &View, world: &[Affine3A], pixel_error: f32) -> Self {
        let camera = &view.camera;
        let to_camera = Affine3A::from_mat4(camera.view());
        let height = view.height.max(1) as f32;
        let (perspective, half, pixels) = match camera.projection {
            Projection::Perspective { fov_y } => {
                let tangent = (0.5 * fov_y).tan();
                let half = Vec2::new(tangent * view.aspect(), tangent);
                // Off the axis a length along the view is seen as up to this much more.
                (true, half, 0.5 * height / tangent * (1.0 + half.length_squared()).sqrt())
            }
            Projection::Orthographic { height: metres } => {
                let half = Vec2::new(0.5 * metres * view.aspect(), 0.5 * metres);
                (false, half, height / metres)
            }
        };
        let place = |world: &Affine3A| (to_camera * *world, stretch(&Mat3::from(world.matrix3)));
        Self {
            instances: world.iter().map(place).filter(|(place, _)| place.is_finite()).collect(),
            pixels,
            perspective,
            half,
            near: camera.near,
            tolerance: 0.5 * if pixel_error > MIN_PIXEL_ERROR { pixel_error } else { MIN_PIXEL_ERROR },
        }
    }

    /// Whether an error of this length, somewhere within `reach` of a point, is seen as more than is allowed.
    fn sees(&self, point: Vec3, reach: f32, error: f32) -> bool {
        self.instances.iter().any(|(place, stretch)| {
            let center = place.transform_point3(point);
            let (depth, reach) = (-center.z, reach * stretch);
            if depth + reach < self.near {
                return false;
            }
            let aside = [0, 1].into_iter().any(|axis: usize| {
                let tangent = self.half[axis];
                let edge = if self.perspective {
                    depth * tangent + reach * (1.0 + tangent * tangent).sqrt()
                } else {
                    tangent + reach
                };
                center[axis].abs() > edge
            });
            let nearest = if self.perspective { (depth - reach).max(self.near) } else { 1.0 };
            !aside && error * stretch * self.pixels > self.tolerance * nearest
        })
    }
}

/// The largest factor by which a matrix makes a vector longer.
fn stretch(matrix: &Mat3) -> f32 {
    let squares = matrix.transpose() * *matrix;
    let mut longest = 0.0_f32;
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        let mut v = axis;
        for _ in 0..24 {
            v = (squares * v).normalize_or_zero();
        }
        longest = longest.max((*matrix * v).length());
    }
    1.001 * longest
}

/// A base triangle in the map.
struct Chart {
    /// Its corners in texels.
    uvs: [Vec2; 3],
    /// Lengths in the object for a length of one texel, at most.
    stretch: f32,
    /// Its longest side in the object.
    size: f32,
}

struct Cutter<'a> {
    base: &'a Base,
    surface: &'a Surface<'a>,
    detail: &'a Detail,
    viewer: &'a Viewer,
    tolerance_factor: f32,
    charts: Vec<Chart>,
    reach: f32,
}

type Numerators = [u16; 3];

const PARTS: u16 = MAX_TESSELLATION as u16;

/// Half way between two places, if that is a place.
fn middle(p: Numerators, q: Numerators) -> Option<Numerators> {
    let even = (0..3).all(|k| (p[k] + q[k]).is_multiple_of(2));
    even.then(|| [0, 1, 2].map(|k| (p[k] + q[k]) / 2))
}

fn mix<T>(of: [T; 3], at: Numerators) -> T
where
    T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    let [a, b, c] = of;
    let weight = |k: usize| f32::from(at[k]) / f32::from(PARTS);
    a * weight(0) + b * weight(1) + c * weight(2)
}

impl<'a> Cutter<'a> {
    fn new(base: &'a Base, surface: &'a Surface<'a>, detail: &'a Detail, viewer: &'a Viewer) -> Self {
        let (width, height) = surface.heights.size();
        let texels = Vec2::new(width as f32, height as f32);
        let chart = |vertices: &[u32; 3]| {
            let at = |vertex: u32| {
                let uv = surface.uvs[vertex as usize];
                let uv = if uv.is_finite() { uv } else { Vec2::ZERO };
                transformed(&surface.transform, uv) * texels
            };
            let uvs = vertices.map(at);
            let p = vertices.map(|vertex| surface.positions[vertex as usize]);
            let size = [0, 1, 2].map(|k| p[k].distance(p[(k + 1) % 3])).into_iter().fold(0.0, f32::max);
            Chart { uvs, stretch: texel_size(uvs, p), size }
        };
        Self {
            base,
            surface,
            detail,
            viewer,
            tolerance_factor: 1.0,
            charts: base.triangles.iter().map(chart).collect(),
            reach: surface.bias.abs().max((surface.bias + surface.scale).abs()),
        }
    }

    /// The place to halve an edge of a part of a base triangle at; `None` if it stays whole.
    fn halved(&self, triangle: u32, p: Numerators, q: Numerators) -> Option<Numerators> {
        let at = middle(p, q)?;
        let vertices = self.base.triangles[triangle as usize];
        let side = (0..3).find(|side| p[(side + 2) % 3] == 0 && q[(side + 2) % 3] == 0);
        let needed = match side {
            None => {
                // The same question from both parts that the edge is between.
                let (p, q) = if p < q { (p, q) } else { (q, p) };
                let chart = &self.charts[triangle as usize];
                let uvs = [mix(chart.uvs, p), mix(chart.uvs, q)];
                let normals = vertices.map(|vertex| self.surface.normals[vertex as usize]);
                let turn = mix(normals, p).normalize_or_zero() - mix(normals, q).normalize_or_zero();
                let point = mix(vertices.map(|vertex| self.surface.positions[vertex as usize]), at);
                self.needs(point, turn.length(), [(uvs, chart)].into_iter())
            }
            Some(side) => {
                let edge = &self.base.edges[self.base.triangle_edges[triangle as usize][side] as usize];
                let second = if vertices[side] == edge.ends[1] { side } else { (side + 1) % 3 };
                let along =
                    [p[second].min(q[second]), p[second].max(q[second])].map(|n| f32::from(n) / f32::from(PARTS));
                let classes = edge.ends.map(|vertex| self.base.classes[vertex as usize]);
                let [first, last] = edge.ends.map(|vertex| self.surface.normals[vertex as usize]);
                let normals = along.map(|t| (first * (1.0 - t) + last * t).normalize_or_zero());
                let [first, last] = edge.ends.map(|vertex| self.surface.positions[vertex as usize]);
                let t = 0.5 * (along[0] + along[1]);
                let sides = self.base.edge_groups.get(edge.group).iter().map(|&triangle| {
                    let vertices = self.base.triangles[triangle as usize];
                    let is = |k: usize, which: usize| self.base.classes[vertices[k] as usize] == classes[which];
                    let from = (0..3).find(|&k| is(k, 0)).unwrap_or(0);
                    let to = (0..3).find(|&k| k != from && is(k, 1)).unwrap_or((from + 1) % 3);
                    let chart = &self.charts[triangle as usize];
                    (along.map(|t| chart.uvs[from] * (1.0 - t) + chart.uvs[to] * t), chart)
                });
                self.needs(first * (1.0 - t) + last * t, normals[0].distance(normals[1]), sides)
            }
        };
        needed.then_some(at)
    }

    /// Whether an edge around a point, over which the normal turns by so much, is too coarse on any of its sides.
    fn needs<'b>(&self, point: Vec3, turn: f32, sides: impl Iterator<Item = ([Vec2; 2], &'b Chart)>) -> bool {
        sides.into_iter().any(|([from, to], chart)| {
            let length = from.distance(to);
            let bounds = self.detail.around(0.5 * (from + to), REACH * length);
            let scale = self.surface.scale.abs();
            let heights = scale * bounds.deviation(length);
            // Normals that turn bend the surface too, as does a slope along them.
            let turned = turn * turn * self.reach / 6.0 + 0.25 * turn * scale * bounds.range();
            let error = (heights + turned) / self.tolerance_factor;
            let reach = (chart.stretch * REACH * length).min(chart.size) + self.reach;
            error > 0.0 && self.viewer.sees(point, reach, error)
        })
    }

    /// Cuts all triangles, or stops at more than `allowed`.
    fn cut(&self, allowed: u64) -> Option<Plan> {
        let mut builder = Builder::new(self.base, PARTS);
        let mut parts: Vec<[Numerators; 3]> = Vec::new();
        for triangle in 0..self.base.triangles.len() as u32 {
            parts.push([[PARTS, 0, 0], [0, PARTS, 0], [0, 0, PARTS]]);
            while let Some(corners) = parts.pop() {
                let halves = [0, 1, 2].map(|k| self.halved(triangle, corners[k], corners[(k + 1) % 3]));
                if halves.iter().any(Option::is_some) {
                    self.split(triangle, corners, halves, &mut parts);
                    continue;
                }
                let points = corners.map(|corner| builder.point(triangle, corner));
                builder.plan.indices.extend(points);
                if builder.plan.indices.len() as u64 > 3 * allowed {
                    return None;
                }
            }
            builder.end_triangle();
        }
        Some(builder.plan)
    }

    /// The parts of a part, some of whose edges are halved.
    fn split(
        &self,
        triangle: u32,
        corners: [Numerators; 3],
        halves: [Option<Numerators>; 3],
        parts: &mut Vec<[Numerators; 3]>,
    ) {
        if let [Some(a), Some(b), Some(c)] = halves {
            let [p, q, r] = corners;
            parts.extend([[p, a, c], [a, q, b], [c, b, r], [a, b, c]]);
            return;
        }
        for k in 0..3 {
            let [p, q, r] = [0, 1, 2].map(|step| corners[(k + step) % 3]);
            match [0, 1, 2].map(|step| halves[(k + step) % 3]) {
                [Some(a), None, None] => parts.extend([[p, a, r], [a, q, r]]),
                [Some(a), Some(b), None] => {
                    let uvs = self.charts[triangle as usize].uvs;
                    let length = |from, to| mix(uvs, from).distance_squared(mix(uvs, to));
                    parts.push([a, q, b]);
                    if length(p, b) < length(a, r) {
                        parts.extend([[p, a, b], [p, b, r]]);
                    } else {
                        parts.extend([[p, a, r], [a, b, r]]);
                    }
                }
                _ => {}
            }
        }
    }
}

/// The longest that a texel can be in the object, on a triangle; infinite where the map has no area.
fn texel_size(uvs: [Vec2; 3], positions: [Vec3; 3]) -> f32 {
    let [q1, q2] = [uvs[1] - uvs[0], uvs[2] - uvs[0]];
    let [e1, e2] = [positions[1] - positions[0], positions[2] - positions[0]];
    let area = q1.perp_dot(q2);
    // Columns of the matrix from texels to the object.
    let (u, v) = ((e1 * q2.y - e2 * q1.y) / area, (e2 * q1.x - e1 * q2.x) / area);
    let (a, b, c) = (u.length_squared(), u.dot(v), v.length_squared());
    let largest = 0.5 * (a + c) + (0.25 * (a - c) * (a - c) + b * b).sqrt();
    if largest.is_finite() { largest.sqrt() } else { f32::INFINITY }
}

impl Plan {
    /// Halves edges until the surface is within half the viewer's pixel error everywhere, but never into more than
    /// [`MAX_TESSELLATION`] parts. Also says by how much the pixel error had to be multiplied so that there are at most
    /// `allowed` triangles: 1, or a power of two.
    ///
    /// # Errors
    /// The base mesh has more than `allowed` triangles already.
    pub fn adaptive(
        base: &Base,
        surface: &Surface<'_>,
        detail: &Detail,
        viewer: &Viewer,
        mesh: &str,
        allowed: u64,
    ) -> Result<(Self, f32), DisplacementError> {
        let allowed = allowed.min(MAX_TRIANGLES);
        check_count(mesh, 1, base.triangles.len() as u64, allowed)?;
        let mut cutter = Cutter::new(base, surface, detail, viewer);
        loop {
            if let Some(plan) = cutter.cut(allowed) {
                return Ok((plan, cutter.tolerance_factor));
            }
            // By squares, so that an error out of all proportion costs a few attempts, not one for each of its bits.
            cutter.tolerance_factor = (cutter.tolerance_factor * cutter.tolerance_factor).max(2.0);
        }
    }
}
