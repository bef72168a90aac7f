//! Backgrounds, and the bytes of the finished picture.

use std::sync::Arc;

use aam_scene::{Background, Pixels, Shading};
use glam::{Vec2, Vec3, Vec4};

use crate::camera::RayMaker;
use crate::colour;
use crate::display::Display;
use crate::sky::Sky;
use crate::texture::{Encoding, Texture, Wrap};

/// The background in the values that lighting computes on, multiplied with its alpha.
#[derive(Debug)]
pub(crate) enum Backdrop<'a> {
    Plain(Vec4),
    Picture { texture: Texture, encode: bool },
    Sky { sky: &'a Sky, display: Option<Display> },
}

impl<'a> Backdrop<'a> {
    /// `display` is what the sky's light is shown by.
    pub(crate) fn new(
        background: &Background,
        shading: Shading,
        sky: Option<&'a Sky>,
        display: Option<Display>,
    ) -> Self {
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
            Background::Environment => match sky {
                Some(sky) => Self::Sky { sky, display },
                None => Self::new(&Background::default(), shading, None, None),
            },
            Background::Transparent | Background::Picture(_) => Self::Plain(Vec4::ZERO),
        }
    }

    /// At a point given in pixels from the picture's top left corner.
    pub(crate) fn at(&self, pixel: Vec2, rays: &RayMaker, footprint: f32) -> Vec4 {
        match self {
            Self::Plain(color) => *color,
            Self::Sky { sky, display } => {
                let light = sky.radiance(rays.ray(pixel).direction);
                display.map_or(light, |display| display.apply(light)).extend(1.0)
            }
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
