//! The light from a direction.

use std::sync::LazyLock;

use glam::{Vec2, Vec3};

use super::{CubeFace, EnvironmentMap, MapLayout, cube_direction, cube_point, panorama_point};
use crate::{Image, Pixels};

impl EnvironmentMap {
    /// The light from a direction of the map, of any length but 0: bilinear between texels, across the edges of faces and
    /// the poles too. `decode` takes 8- and 16-bit pictures for sRGB-encoded colours and gives linear light; without it
    /// their values are light as they are. Float pictures are never decoded.
    pub fn light(&self, direction: Vec3, decode: bool) -> Vec3 {
        match self.layout() {
            MapLayout::Panorama(image) => {
                let (width, height) = (i64::from(image.width), i64::from(image.height));
                let place = panorama_point(direction) * Vec2::new(width as f32, height as f32) - 0.5;
                between(place, |x, y| {
                    // Beyond a pole lies the other half of the first or last row.
                    let (x, y) = match y {
                        y if y < 0 => (x + width / 2, 0),
                        y if y >= height => (x + width / 2, height - 1),
                        y => (x, y),
                    };
                    texel(image, x.rem_euclid(width), y, decode)
                })
            }
            MapLayout::Cube(faces) => {
                let (face, point) = cube_point(direction);
                let side = i64::from(faces[0].width);
                between(point * side as f32 - 0.5, |x, y| face_texel(faces, side, face, (x, y), decode))
            }
        }
    }
}

/// A texel of a face, or of the neighbour that the face's plane meets beyond its edge.
fn face_texel(faces: &[Image; 6], side: i64, face: CubeFace, (x, y): (i64, i64), decode: bool) -> Vec3 {
    let inside = 0..side;
    if inside.contains(&x) && inside.contains(&y) {
        return texel(&faces[face as usize], x, y, decode);
    }
    let middle = (Vec2::new(x as f32, y as f32) + 0.5) / side as f32;
    let (face, point) = cube_point(cube_direction(face, middle));
    let place = |p: f32| ((p * side as f32) as i64).clamp(0, side - 1);
    texel(&faces[face as usize], place(point.x), place(point.y), decode)
}

fn between(place: Vec2, texel: impl Fn(i64, i64) -> Vec3) -> Vec3 {
    // A direction that is not finite looks somewhere.
    let place = if place.is_finite() { place } else { Vec2::ZERO };
    let first = place.floor();
    let (x, y, part) = (first.x as i64, first.y as i64, place - first);
    let row = |y| texel(x, y).lerp(texel(x + 1, y), part.x);
    row(y).lerp(row(y + 1), part.y)
}

fn texel(image: &Image, x: i64, y: i64, decode: bool) -> Vec3 {
    static DECODED: LazyLock<[f32; 256]> =
        LazyLock::new(|| std::array::from_fn(|byte| srgb_decode(byte as f32 / 255.0)));
    let index = y as usize * image.width as usize + x as usize;
    match &image.pixels {
        Pixels::Rgba8(values) if decode => Vec3::from([0, 1, 2].map(|c| DECODED[usize::from(values[4 * index + c])])),
        Pixels::Rgba8(values) => Vec3::from([0, 1, 2].map(|c| f32::from(values[4 * index + c]) / 255.0)),
        Pixels::Rgba16(values) => Vec3::from([0, 1, 2].map(|c| {
            let stored = f32::from(values[4 * index + c]) / 65535.0;
            if decode { srgb_decode(stored) } else { stored }
        })),
        Pixels::RgbF32(values) => Vec3::from([0, 1, 2].map(|c| values[3 * index + c])),
    }
}

/// IEC 61966-2-1.
fn srgb_decode(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
