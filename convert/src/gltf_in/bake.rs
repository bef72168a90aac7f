//! Textures made of others: alpha removed, occlusion multiplied in.

use crate::phong;

/// A decoded picture, top row first.
#[derive(Debug)]
pub(super) struct Pixels {
    pub width: u32,
    pub height: u32,
    pub rgba: Vec<u8>,
}

impl Pixels {
    /// The texel at a texture coordinate (v down), repeating.
    pub(super) fn nearest(&self, [u, v]: [f32; 2]) -> [u8; 4] {
        let at = |coordinate: f32, size: u32| {
            // A coordinate that is not finite becomes 0 by the cast.
            let texel = (coordinate.rem_euclid(1.0) * size as f32) as u32;
            texel.min(size.saturating_sub(1))
        };
        self.texel(at(u, self.width), at(v, self.height))
    }

    fn texel(&self, x: u32, y: u32) -> [u8; 4] {
        let at = (y as usize * self.width as usize + x as usize) * 4;
        self.rgba.get(at..).and_then(|rest| rest.first_chunk()).copied().unwrap_or_default()
    }

    /// The picture at another size: bilinear, repeating; the same where the size is.
    fn resampled(&self, x: u32, y: u32, width: u32, height: u32) -> [u8; 4] {
        if (width, height) == (self.width, self.height) {
            return self.texel(x, y);
        }
        let split = |at: u32, to: u32, from: u32| {
            let center = (f64::from(at) + 0.5) * f64::from(from) / f64::from(to) - 0.5;
            let low = center.floor();
            let wrap = |texel: f64| texel.rem_euclid(f64::from(from)) as u32;
            (wrap(low), wrap(low + 1.0), (center - low) as f32)
        };
        let (x0, x1, fx) = split(x, width, self.width);
        let (y0, y1, fy) = split(y, height, self.height);
        let corners = [self.texel(x0, y0), self.texel(x1, y0), self.texel(x0, y1), self.texel(x1, y1)];
        std::array::from_fn(|channel| {
            let [a, b, c, d] = corners.map(|corner| f32::from(corner[channel]));
            let (top, bottom) = (a + (b - a) * fx, c + (d - c) * fx);
            (top + (bottom - top) * fy).round() as u8
        })
    }

    /// Whether any texel is transparent.
    pub(super) fn has_alpha(&self) -> bool {
        self.rgba.chunks_exact(4).any(|texel| texel[3] < 255)
    }
}

/// What a diffuse texture is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Recipe {
    /// The image with colour and alpha; white where there is none.
    pub base: Option<usize>,
    /// The image whose red channel is occlusion, and the bits of its strength.
    pub occlusion: Option<(usize, u32)>,
    /// Whether alpha is taken away.
    pub opaque: bool,
}

impl Recipe {
    /// An image as it is.
    pub(super) const fn image_alone(image: usize) -> Self {
        Self { base: Some(image), occlusion: None, opaque: false }
    }

    /// The image, if nothing is to be done to it.
    pub(super) fn untouched(&self) -> Option<usize> {
        self.base.filter(|_| self.occlusion.is_none() && !self.opaque)
    }

    /// The image that gives the result its name.
    pub(super) fn image(&self) -> Option<usize> {
        self.base.or_else(|| self.occlusion.map(|(image, _)| image))
    }

    /// What the result's name ends with.
    pub(super) const fn word(&self) -> &'static str {
        match (self.occlusion, self.opaque) {
            (Some(_), _) => "_occluded",
            (None, true) => "_opaque",
            (None, false) => "",
        }
    }
}

/// A texture to be written.
#[derive(Debug)]
pub(super) struct Composed {
    width: u32,
    height: u32,
    bytes: Vec<u8>,
    color: png::ColorType,
}

/// The size of a texture made of these: the larger one in each direction.
pub(super) fn size(base: Option<&Pixels>, occlusion: Option<&Pixels>) -> [u32; 2] {
    let pictures = || base.into_iter().chain(occlusion);
    let largest = |length: fn(&Pixels) -> u32| pictures().map(length).max().unwrap_or(0);
    [largest(|picture| picture.width), largest(|picture| picture.height)]
}

/// Makes a texture; `None` if a picture that the recipe names is not given.
pub(super) fn compose(recipe: &Recipe, base: Option<&Pixels>, occlusion: Option<&Pixels>) -> Option<Composed> {
    let [width, height] = size(base, occlusion);
    if width == 0 || height == 0 {
        return None;
    }
    let opaque = recipe.opaque || base.is_none_or(|base| !base.has_alpha());
    let strength = f32::from_bits(recipe.occlusion.map_or(0, |(_, strength)| strength));
    let darken = Darkening::new(strength);
    let channels = if opaque { 3 } else { 4 };
    let mut bytes = Vec::with_capacity(width as usize * height as usize * channels);
    for y in 0..height {
        for x in 0..width {
            let mut texel = base.map_or([255; 4], |base| base.resampled(x, y, width, height));
            if let Some(occlusion) = occlusion {
                let light = occlusion.resampled(x, y, width, height)[0];
                for channel in &mut texel[..3] {
                    *channel = darken.of(*channel, light);
                }
            }
            bytes.extend_from_slice(&texel[..channels]);
        }
    }
    Some(Composed { width, height, bytes, color: if opaque { png::ColorType::Rgb } else { png::ColorType::Rgba } })
}

/// What occlusion of a strength leaves of a light value (glTF 2.0 §3.9.3): `1 + strength·(occlusion − 1)`.
pub(super) fn occluded(occlusion: f32, strength: f32) -> f32 {
    1.0 + strength * (occlusion - 1.0)
}

/// Every stored colour value under every stored occlusion value, multiplied in linear light.
struct Darkening(Vec<u8>);

impl Darkening {
    fn new(strength: f32) -> Self {
        let table = (0..=255_u8).flat_map(|light| {
            let left = occluded(f32::from(light) / 255.0, strength);
            (0..=255_u8).map(move |stored| {
                let linear = phong::decode_srgb(f32::from(stored) / 255.0) * left;
                (phong::encode_srgb(linear) * 255.0).round() as u8
            })
        });
        Self(table.collect())
    }

    fn of(&self, stored: u8, light: u8) -> u8 {
        self.0.get(usize::from(light) << 8 | usize::from(stored)).copied().unwrap_or(stored)
    }
}

impl Composed {
    /// The texture as a PNG file, quickly packed.
    pub(super) fn encode(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(self.color);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.bytes)?;
        writer.finish()?;
        Ok(bytes)
    }
}
