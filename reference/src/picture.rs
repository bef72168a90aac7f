//! Backgrounds, and the bytes of the finished picture.

use std::sync::Arc;

use aam_scene::{Background, Pixels, Shading};
use glam::{Vec2, Vec3, Vec4};

use crate::camera::RayMaker;
use crate::colour;
use crate::texture::{Encoding, Texture, Wrap};

/// The background in the values that lighting computes on, multiplied with its alpha.
#[derive(Debug)]
pub(crate) enum Backdrop {
    Plain(Vec4),
    Picture { texture: Texture, encode: bool },
}

impl Backdrop {
    pub(crate) fn new(background: &Background, shading: Shading) -> Self {
        match background {
            Background::Color(color) => {
                let color = colour::saturate(*color);
                Self::Plain(match shading {
                    Shading::Source => color.extend(1.0),
                    Shading::Linear => colour::decode_rgb(color).extend(1.0),
                })
            }
            Background::Picture(image) if Texture::is_whole(image) => {
                let linear = shading == Shading::Linear;
                // A float picture is linear, and is encoded for display in both modes.
                let encode = !linear && matches!(image.pixels, Pixels::RgbF32(_));
                let encoding = if linear { Encoding::Srgb } else { Encoding::Stored };
                Self::Picture { texture: Texture::new(&Arc::clone(image), encoding, Wrap::Clamp), encode }
            }
            Background::Transparent | Background::Picture(_) => Self::Plain(Vec4::ZERO),
        }
    }

    /// At a point given in pixels from the picture's top left corner.
    pub(crate) fn at(&self, pixel: Vec2, rays: &RayMaker, footprint: f32) -> Vec4 {
        match self {
            Self::Plain(color) => *color,
            Self::Picture { texture, encode } => {
                let step = footprint / rays.size;
                let uv = Vec2::new(pixel.x / rays.size.x, 1.0 - pixel.y / rays.size.y);
                let texel = texture.sample(uv, [Vec2::new(step.x, 0.0), Vec2::new(0.0, step.y)]);
                let color = colour::saturate(texel.truncate());
                let color = if *encode { colour::encode_rgb(color) } else { color };
                (color * texel.w).extend(texel.w)
            }
        }
    }
}

/// A premultiplied colour as bytes with straight alpha.
pub(crate) fn to_bytes(color: Vec4, shading: Shading) -> [u8; 4] {
    let straight = if color.w > 0.0 { color.truncate() / color.w } else { Vec3::ZERO };
    let encoded = match shading {
        Shading::Source => straight,
        Shading::Linear => colour::encode_rgb(straight.max(Vec3::ZERO)),
    };
    let byte = |value: f32| (colour::saturate_one(value) * 255.0 + 0.5) as u8;
    [byte(encoded.x), byte(encoded.y), byte(encoded.z), byte(color.w)]
}
