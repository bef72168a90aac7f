//! Pictures computed over a surface's texture coordinates: for what AAM draws from two textures and glTF from one, and for
//! normals in axes that glTF does not have.

use aam::document::Layer;
use aam_scene::Image;
use glam::{DMat3, DVec2, DVec3, Mat3, Vec2, Vec3};

use super::image::{Baked, bilinear};
use super::model::{Model, Variant};

/// The longest side of a baked picture, unless a source is longer.
const MAX_SIDE: u32 = 4096;

/// How far colours of two surfaces at one texel may be apart, of 255.
const SAME_COLOR: u8 = 10;

/// As [`SAME_COLOR`], for unit normals: 4.5°.
const SAME_NORMAL: u8 = 10;

/// The part of the texels that two surfaces may want differently (those at the edges of triangles).
const MAX_CONFLICT: f64 = 0.01;

/// How far colours are carried on past the edges of the surface, in texels, for filtering and small mip levels.
const MARGIN: usize = 16;

/// The picture of `T ⊗ (E + D ⊗ LM)` on stored values, in the light map's coordinates; `None` where no one picture can
/// show it: where surfaces share texels of the light map but not the diffuse texture's.
pub(super) fn light_map(
    model: &Model<'_>,
    variant: &Variant,
    diffuse: Option<&Image>,
    light: &Image,
    shade: impl Fn([f32; 4], [f32; 4]) -> [f32; 4],
) -> Option<Baked> {
    let leaf = model.leaf(variant)?;
    let to_light = leaf.layers[Layer::LightMap as usize].as_ref()?.transform;
    let white = [1.0; 4];
    let Some(diffuse) = diffuse else {
        let texel = |uv: DVec2| shade(white, bilinear(light, uv.x, uv.y));
        return Some(fill(light.width, light.height, texel));
    };
    let to_diffuse = leaf.layers[Layer::Diffuse as usize].as_ref()?.transform;
    let shared = variant.sets[Layer::Diffuse as usize] == variant.sets[Layer::LightMap as usize];
    if let Some(across) = tiling(to_light, to_diffuse).filter(|_| shared) {
        let side = |light: u32, diffuse: u32, times: DVec2| {
            let wanted = f64::from(diffuse) * times.length();
            light.max((wanted.min(f64::from(MAX_SIDE)) as u32).max(1))
        };
        let width = side(light.width, diffuse.width, across.x_axis.truncate());
        let height = side(light.height, diffuse.height, across.y_axis.truncate());
        return Some(fill(width, height, |uv| {
            let at = across.transform_point2(uv);
            shade(bilinear(diffuse, at.x, at.y), bilinear(light, uv.x, uv.y))
        }));
    }
    let pieces = pieces(model, variant, Layer::LightMap, to_light)?;
    let other: Vec<[Vec2; 3]> = variant.uses.iter().flat_map(|&of| triangles(model.uvs(of, Layer::Diffuse))).collect();
    let [width, height] = density(&pieces, &other, to_diffuse, light, diffuse);
    let mut canvas = Canvas::new(width, height, SAME_COLOR);
    for (piece, corners) in pieces.iter().zip(&other) {
        let corners = corners.map(|uv| to_diffuse.transform_point2(uv).as_dvec2());
        rasterize(width, height, *piece, |texel, uv, weights| {
            let at: DVec2 = corners.iter().zip(weights).map(|(corner, weight)| *corner * weight).sum();
            canvas.put(texel, shade(bilinear(diffuse, at.x, at.y), bilinear(light, uv.x, uv.y)));
        });
    }
    canvas.finish()
}

/// The transform from one texture's picture to another's, where it repeats with it: its linear part is whole numbers.
fn tiling(from: Mat3, to: Mat3) -> Option<DMat3> {
    let from = from.as_dmat3();
    if from.determinant().abs() < 1e-12 {
        return None;
    }
    let across = to.as_dmat3() * from.inverse();
    let linear = [across.x_axis.x, across.x_axis.y, across.y_axis.x, across.y_axis.y];
    let whole = linear.iter().all(|value| (value - value.round()).abs() < 1e-4 && value.abs() < 1e4);
    whole.then_some(across)
}

fn fill(width: u32, height: u32, color: impl Fn(DVec2) -> [f32; 4]) -> Baked {
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            pixels.push(bytes(color(center(x, y, width, height))));
        }
    }
    Baked { width, height, pixels }
}

fn center(x: u32, y: u32, width: u32, height: u32) -> DVec2 {
    DVec2::new((f64::from(x) + 0.5) / f64::from(width), 1.0 - (f64::from(y) + 0.5) / f64::from(height))
}

fn bytes(color: [f32; 4]) -> [u8; 4] {
    color.map(|value| (255.0 * value.clamp(0.0, 1.0)).round() as u8)
}

fn triangles(uvs: &[Vec2]) -> impl Iterator<Item = [Vec2; 3]> {
    uvs.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]])
}

/// The triangles of a variant in a layer's picture; `None` where they cover it more than a few times, so that no texel is
/// theirs alone.
fn pieces(model: &Model<'_>, variant: &Variant, layer: Layer, transform: Mat3) -> Option<Vec<[DVec2; 3]>> {
    let mut pieces = Vec::new();
    let mut area = 0.0;
    for &of in &variant.uses {
        for corners in triangles(model.uvs(of, layer)) {
            let piece = corners.map(|uv| transform.transform_point2(uv).as_dvec2());
            let [a, b, c] = piece;
            area += 0.5 * (b - a).perp_dot(c - a).abs();
            let extent = a.max(b).max(c) - a.min(b).min(c);
            if !(extent.max_element() <= 2.0) || !(a.length() < 1e6) {
                return None;
            }
            pieces.push(piece);
        }
    }
    (area <= 4.0).then_some(pieces)
}

/// The size at which the diffuse texture keeps its texels where it lies on the light map.
fn density(pieces: &[[DVec2; 3]], other: &[[Vec2; 3]], to_diffuse: Mat3, light: &Image, diffuse: &Image) -> [u32; 2] {
    let area = |[a, b, c]: [DVec2; 3]| (b - a).perp_dot(c - a).abs();
    let light_area: f64 = pieces.iter().copied().map(area).sum();
    let diffuse_area: f64 =
        other.iter().map(|corners| area(corners.map(|uv| to_diffuse.transform_point2(uv).as_dvec2()))).sum();
    let texels = |image: &Image| f64::from(image.width) * f64::from(image.height);
    let finer = (diffuse_area * texels(diffuse) / (light_area * texels(light)).max(f64::MIN_POSITIVE)).sqrt();
    let longest = light.width.max(light.height);
    let finer = finer.clamp(1.0, (f64::from(MAX_SIDE) / f64::from(longest)).max(1.0));
    [light.width, light.height].map(|side| (f64::from(side) * finer).round() as u32)
}

/// Object-space normals as tangent-space normals, in the map's coordinates; `None` where surfaces share texels and would
/// need different ones.
pub(super) fn tangent_normals(model: &Model<'_>, place: usize, map: &Image) -> Option<Baked> {
    let variant = &model.variants[place];
    let transform = model.leaf(variant)?.layers[Layer::Normal as usize].as_ref()?.transform;
    let pieces = pieces(model, variant, Layer::Normal, transform)?;
    let mut canvas = Canvas::new(map.width, map.height, SAME_NORMAL);
    let mut next = pieces.iter();
    let mut tangents = None;
    for &(object, subset) in &variant.uses {
        if tangents.as_ref().is_none_or(|(of, _)| *of != object) {
            tangents = Some((object, model.tangents(object, |variant| variant == place)?));
        }
        let Some((_, tangents)) = &tangents else { return None };
        let mesh = &model.meshes[object];
        let subset = mesh.subsets[subset];
        for triangle in subset.first..subset.first + subset.count {
            let piece = next.next()?;
            let corners: [usize; 3] = std::array::from_fn(|corner| 3 * triangle + corner);
            let normals = corners.map(|corner| mesh.normals[corner].as_dvec3());
            let along = corners.map(|corner| tangents[corner].truncate().as_dvec3());
            let sign = f64::from(tangents[corners[0]].w);
            rasterize(map.width, map.height, *piece, |texel, uv, weights| {
                let mix = |of: [DVec3; 3]| of.iter().zip(weights).map(|(v, weight)| *v * weight).sum::<DVec3>();
                let (n, t) = (mix(normals), mix(along));
                let frame = DMat3::from_cols(t, sign * n.cross(t), n);
                let [x, y, z, _] = bilinear(map, uv.x, uv.y);
                let wanted = 2.0 * Vec3::new(x, y, z).as_dvec3() - 1.0;
                if frame.determinant().abs() < 1e-9 || wanted.length_squared() < 1e-6 {
                    return;
                }
                let local = (frame.inverse() * wanted).normalize().as_vec3() * 0.5 + 0.5;
                canvas.put(texel, [local.x, local.y, local.z, 1.0]);
            });
        }
    }
    canvas.finish_with([128, 128, 255, 255])
}

/// Calls for each texel whose centre lies in a triangle of texture coordinates (v up): the texel (the picture repeats),
/// its coordinates, and the weights of the corners.
fn rasterize(width: u32, height: u32, corners: [DVec2; 3], mut texel: impl FnMut(usize, DVec2, [f64; 3])) {
    let size = DVec2::new(f64::from(width), f64::from(height));
    let [a, b, c] = corners.map(|uv| DVec2::new(uv.x, 1.0 - uv.y) * size - 0.5);
    let area = (b - a).perp_dot(c - a);
    if area == 0.0 {
        return;
    }
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    for y in low.y.ceil() as i64..=high.y.floor() as i64 {
        let Some((from, to)) = span([a, b, c], y as f64) else { continue };
        for x in from.ceil() as i64..=to.floor() as i64 {
            let at = DVec2::new(x as f64, y as f64);
            let weight = |from: DVec2, to: DVec2| (to - from).perp_dot(at - from) / area;
            let weights = [weight(b, c), weight(c, a), weight(a, b)];
            let (column, row) = (x.rem_euclid(i64::from(width)), y.rem_euclid(i64::from(height)));
            let uv = (at + 0.5) / size;
            texel((row * i64::from(width) + column) as usize, DVec2::new(uv.x, 1.0 - uv.y), weights);
        }
    }
}

/// Where a row crosses a triangle.
fn span(corners: [DVec2; 3], y: f64) -> Option<(f64, f64)> {
    let mut range: Option<(f64, f64)> = None;
    for edge in 0..3 {
        let (p, q) = (corners[edge], corners[(edge + 1) % 3]);
        if p.y.min(q.y) > y || p.y.max(q.y) < y {
            continue;
        }
        let ends = if p.y == q.y { [p.x, q.x] } else { [p.x + (q.x - p.x) * (y - p.y) / (q.y - p.y); 2] };
        for x in ends {
            range = Some(range.map_or((x, x), |(low, high)| (low.min(x), high.max(x))));
        }
    }
    range
}

/// A picture that surfaces are painted on.
struct Canvas {
    width: usize,
    height: usize,
    tolerance: u8,
    texels: Vec<[u8; 4]>,
    painted: Vec<bool>,
    strokes: usize,
    conflicts: usize,
}

impl Canvas {
    fn new(width: u32, height: u32, tolerance: u8) -> Self {
        let (width, height) = (width as usize, height as usize);
        let count = width * height;
        Self {
            width,
            height,
            tolerance,
            texels: vec![[0; 4]; count],
            painted: vec![false; count],
            strokes: 0,
            conflicts: 0,
        }
    }

    fn put(&mut self, texel: usize, color: [f32; 4]) {
        let color = bytes(color);
        self.strokes += 1;
        if self.painted[texel] {
            let apart =
                self.texels[texel].iter().zip(color).any(|(there, color)| there.abs_diff(color) > self.tolerance);
            self.conflicts += usize::from(apart);
        } else {
            self.painted[texel] = true;
            self.texels[texel] = color;
        }
    }

    /// The picture, carried on past its edges, the rest in the mean colour.
    fn finish(self) -> Option<Baked> {
        let mut sum = [0_u64; 4];
        let mut count = 0_u64;
        for (texel, _) in self.texels.iter().zip(&self.painted).filter(|(_, painted)| **painted) {
            sum.iter_mut().zip(texel).for_each(|(sum, value)| *sum += u64::from(*value));
            count += 1;
        }
        let mean = sum.map(|sum| (sum / count.max(1)) as u8);
        self.finish_with(mean)
    }

    /// As [`Canvas::finish`], the rest in a colour of choice.
    fn finish_with(mut self, rest: [u8; 4]) -> Option<Baked> {
        if self.strokes == 0 || self.conflicts as f64 > MAX_CONFLICT * self.strokes as f64 {
            return None;
        }
        let mut edge: Vec<usize> = (0..self.texels.len()).filter(|&texel| self.painted[texel]).collect();
        for _ in 0..MARGIN {
            let mut next = Vec::new();
            for texel in edge {
                let (x, y) = (texel % self.width, texel / self.width);
                let beside = [
                    (y, (x + 1) % self.width),
                    (y, (x + self.width - 1) % self.width),
                    ((y + 1) % self.height, x),
                    ((y + self.height - 1) % self.height, x),
                ];
                for (row, column) in beside {
                    let at = row * self.width + column;
                    if !self.painted[at] {
                        self.painted[at] = true;
                        self.texels[at] = self.texels[texel];
                        next.push(at);
                    }
                }
            }
            edge = next;
        }
        let paint = |(texel, painted)| if painted { texel } else { rest };
        let pixels = self.texels.into_iter().zip(self.painted).map(paint).collect();
        Some(Baked { width: self.width as u32, height: self.height as u32, pixels })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_covers_the_texels_it_covers() {
        let corners = [DVec2::new(0.0, 0.0), DVec2::new(1.0, 0.0), DVec2::new(0.0, 1.0)];
        let mut hits = Vec::new();
        rasterize(4, 4, corners, |texel, uv, weights| {
            let at: DVec2 = corners.iter().zip(weights).map(|(corner, weight)| *corner * weight).sum();
            assert!((at - uv).length() < 1e-12, "{at} {uv}");
            hits.push(texel);
        });
        // Rows from the top; the hypotenuse goes through the centres of four texels.
        assert_eq!(hits, [0, 4, 5, 8, 9, 10, 12, 13, 14, 15]);
    }

    #[test]
    fn triangles_beyond_the_edge_go_on_at_the_other() {
        let corners = [DVec2::new(0.75, 0.0), DVec2::new(1.25, 0.0), DVec2::new(0.75, 2.0)];
        let mut hits = std::collections::BTreeSet::new();
        rasterize(4, 1, corners, |texel, _, _| {
            hits.insert(texel);
        });
        assert_eq!(hits.into_iter().collect::<Vec<_>>(), [0, 3]);
    }

    #[test]
    fn surfaces_that_disagree_give_no_picture() {
        let mut canvas = Canvas::new(2, 2, SAME_COLOR);
        canvas.put(0, [0.5, 0.5, 0.5, 1.0]);
        canvas.put(0, [0.51, 0.5, 0.5, 1.0]);
        canvas.put(3, [1.0; 4]);
        assert_eq!(canvas.conflicts, 0);
        canvas.put(3, [0.0; 4]);
        assert!(canvas.finish().is_none());
    }

    #[test]
    fn colours_go_on_past_the_edge() {
        let mut canvas = Canvas::new(64, 1, SAME_COLOR);
        canvas.put(0, [1.0, 0.0, 0.0, 1.0]);
        let baked = canvas.finish_with([0, 0, 0, 255]).unwrap();
        let red = baked.pixels.iter().filter(|texel| **texel == [255, 0, 0, 255]).count();
        assert_eq!(red, 1 + 2 * MARGIN);
    }

    #[test]
    fn pictures_that_repeat_together() {
        let scale = |s: f32| Mat3::from_cols(Vec3::X * s, Vec3::Y * s, Vec3::new(0.3, 0.1, 1.0));
        assert!(tiling(scale(1.0), scale(4.0)).is_some());
        assert!(tiling(scale(4.0), scale(1.0)).is_none());
        assert!(tiling(scale(0.0), scale(1.0)).is_none());
    }
}
