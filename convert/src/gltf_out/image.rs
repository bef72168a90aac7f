//! Textures: files that glTF knows are copied, others become PNG, baked ones are added.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use aam::Limits;
use aam_scene::{FoundTexture, Image, Pixels, TextureData, TextureSource, load_texture};
use image::{ColorType, ImageDecoder, ImageFormat, ImageReader};

use crate::files::within;
use crate::{Asset, ConvertError, TextureFile};

use super::json::{self, Index};
use super::notes::Notes;

/// An 8-bit picture that was made here, top row first.
#[derive(Clone, Debug)]
pub(super) struct Baked {
    pub width: u32,
    pub height: u32,
    /// Red, green, blue, alpha.
    pub pixels: Vec<[u8; 4]>,
}

/// An image of the file.
#[derive(Debug)]
struct Entry {
    /// The path beside a `.gltf` file, with its extension.
    path: String,
    mime: &'static str,
    bytes: TextureFile,
}

/// What is known of a texture file.
#[derive(Clone, Copy, Debug)]
struct Known {
    /// A position in [`Images::entries`].
    entry: Index,
    transparent: bool,
}

/// The images of the file.
#[derive(Debug)]
pub(super) struct Images<'a> {
    asset: &'a Asset,
    limits: Limits,
    entries: Vec<Entry>,
    /// By the document's name; `None` where there is no such image.
    names: BTreeMap<String, Option<Known>>,
    /// By file.
    keys: BTreeMap<String, Known>,
    taken: BTreeSet<String>,
}

impl<'a> Images<'a> {
    /// Of an asset's textures, none yet.
    pub(super) fn new(asset: &'a Asset, limits: Limits) -> Self {
        Self {
            asset,
            limits,
            entries: Vec::new(),
            names: BTreeMap::new(),
            keys: BTreeMap::new(),
            taken: BTreeSet::new(),
        }
    }

    /// The image of a texture that a material names; `None` where there is none that can be used.
    pub(super) fn named(&mut self, name: &str, notes: &mut Notes) -> Option<Index> {
        self.known(name, notes).map(|known| known.entry)
    }

    /// Whether a texture has transparent texels.
    pub(super) fn is_transparent(&mut self, name: &str, notes: &mut Notes) -> bool {
        self.known(name, notes).is_some_and(|known| known.transparent)
    }

    /// The pixels of a texture.
    pub(super) fn pixels(&self, name: &str) -> Option<Image> {
        load_texture(&self.asset.find(name).ok()?, &self.limits).ok()
    }

    /// Adds a picture that was made here, named after a texture.
    pub(super) fn add(&mut self, name: &str, word: &str, picture: &Baked) -> Result<Index, ConvertError> {
        let opaque = picture.pixels.iter().all(|texel| texel[3] == 255);
        let bytes = if opaque {
            let rgb: Vec<u8> = picture.pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
            encode(picture.width, picture.height, png::ColorType::Rgb, &rgb)?
        } else {
            encode(picture.width, picture.height, png::ColorType::Rgba, picture.pixels.as_flattened())?
        };
        let path = self.path_of(&format!("{}{word}.png", stem(name)), "png");
        self.entries.push(Entry { path, mime: "image/png", bytes: TextureFile::InMemory(bytes.into()) });
        Ok(self.entries.len() as Index - 1)
    }

    fn known(&mut self, name: &str, notes: &mut Notes) -> Option<Known> {
        if let Some(known) = self.names.get(name) {
            return *known;
        }
        let known = match self.load(name, notes) {
            Ok(known) => Some(known),
            Err(reason) => {
                notes.lost(&format!("texture \"{name}\""), "texture", format!("it is left out: {reason}"));
                None
            }
        };
        self.names.insert(name.to_owned(), known);
        known
    }

    fn load(&mut self, name: &str, notes: &mut Notes) -> Result<Known, String> {
        let found = self.asset.find(name)?;
        if let Some(known) = self.keys.get(&found.key) {
            return Ok(*known);
        }
        let bytes = match &found.data {
            TextureData::OnDisk(path) => aam::read_bytes(path, &self.limits).map_err(|e| e.to_string())?.into(),
            TextureData::InMemory(bytes) => Arc::clone(bytes),
        };
        let found = FoundTexture { key: found.key, data: TextureData::InMemory(bytes.clone()) };
        let copied = match header(&bytes) {
            Some((ImageFormat::Png, color)) => Some(("image/png", "png", color)),
            Some((ImageFormat::Jpeg, color)) => Some(("image/jpeg", "jpg", color)),
            _ => None,
        };
        let known = if let Some((mime, extension, color)) = copied {
            let transparent = color.has_alpha() && is_transparent(&load_texture(&found, &self.limits)?);
            let file = self.asset.textures.get(name).cloned().unwrap_or(TextureFile::InMemory(bytes));
            let path = self.path_of(name, extension);
            self.entries.push(Entry { path, mime, bytes: file });
            Known { entry: self.entries.len() as Index - 1, transparent }
        } else {
            let image = load_texture(&found, &self.limits)?;
            let (color, pixels) = eight_bits(&image);
            let bytes = encode(image.width, image.height, color, &pixels).map_err(|error| error.to_string())?;
            let subject = format!("texture \"{name}\"");
            if matches!(image.pixels, Pixels::Rgba8(_)) {
                notes.changed(&subject, "texture", "glTF knows PNG and JPEG only: written as PNG");
            } else {
                notes.changed(
                    &subject,
                    "texture",
                    "glTF knows PNG and JPEG only: written as PNG with 8 bits a channel",
                );
            }
            let path = self.path_of(name, "png");
            self.entries.push(Entry { path, mime: "image/png", bytes: TextureFile::InMemory(bytes.into()) });
            Known { entry: self.entries.len() as Index - 1, transparent: is_transparent(&image) }
        };
        self.keys.insert(found.key, known);
        Ok(known)
    }

    /// A path beside the file, not taken yet (letter case apart): the texture's own where that stays in the folder.
    fn path_of(&mut self, name: &str, extension: &str) -> String {
        let slashed = name.replace('\\', "/");
        let inside = within(name).filter(|_| !slashed.contains(|letter: char| letter.is_control()));
        let wanted = if inside.is_some() { slashed.as_str() } else { slashed.rsplit('/').next().unwrap_or("") };
        let (folder, file) = wanted.rsplit_once('/').map_or(("", wanted), |(folder, file)| (folder, file));
        let file = Path::new(file);
        let same = file.extension().and_then(|own| own.to_str()).is_some_and(|own| {
            own.eq_ignore_ascii_case(extension) || (extension == "jpg" && own.eq_ignore_ascii_case("jpeg"))
        });
        let own = if same { file.extension().and_then(|own| own.to_str()).unwrap_or(extension) } else { extension };
        let stem = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let stem: String = stem.chars().map(|c| if c.is_control() || c == ':' { '_' } else { c }).collect();
        let stem = if stem.is_empty() { "texture".to_owned() } else { stem };
        let prefix = if folder.is_empty() { String::new() } else { format!("{folder}/") };
        let mut path = format!("{prefix}{stem}.{own}");
        let mut number = 1;
        while !self.taken.insert(path.to_lowercase()) {
            number += 1;
            path = format!("{prefix}{stem}-{number}.{own}");
        }
        path
    }

    /// The JSON of all images, as files beside the main one.
    pub(super) fn beside(self) -> (Vec<json::Image>, BTreeMap<String, TextureFile>) {
        let mut files = BTreeMap::new();
        let mut images = Vec::new();
        for entry in self.entries {
            images.push(json::Image {
                name: stem(&entry.path).to_owned(),
                uri: Some(super::container::uri_of(&entry.path)),
                ..json::Image::default()
            });
            files.insert(entry.path, entry.bytes);
        }
        (images, files)
    }

    /// The JSON of all images, put into the buffer.
    pub(super) fn embedded(self, buffers: &mut super::buffer::Buffers) -> Result<Vec<json::Image>, ConvertError> {
        let mut images = Vec::new();
        for entry in self.entries {
            let view = match &entry.bytes {
                TextureFile::OnDisk(path) => buffers.file(&aam::read_bytes(path, &self.limits)?),
                TextureFile::InMemory(bytes) => buffers.file(bytes),
            };
            images.push(json::Image {
                name: stem(&entry.path).to_owned(),
                mime_type: Some(entry.mime),
                buffer_view: Some(view),
                ..json::Image::default()
            });
        }
        Ok(images)
    }
}

/// A file's name without folder and extension.
fn stem(path: &str) -> &str {
    let file = path.rsplit(['/', '\\']).next().unwrap_or(path);
    file.rsplit_once('.').map_or(file, |(stem, _)| stem)
}

fn header(bytes: &[u8]) -> Option<(ImageFormat, ColorType)> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().ok()?;
    let format = reader.format()?;
    Some((format, reader.into_decoder().ok()?.color_type()))
}

fn is_transparent(image: &Image) -> bool {
    match &image.pixels {
        Pixels::Rgba8(values) => values.chunks_exact(4).any(|texel| texel[3] < u8::MAX),
        Pixels::Rgba16(values) => values.chunks_exact(4).any(|texel| texel[3] < u16::MAX),
        Pixels::RgbF32(_) => false,
    }
}

/// The picture with 8 bits a channel, without alpha where it has none. Floating-point values are radiance: they are
/// clipped at 1 and sRGB-encoded.
fn eight_bits(image: &Image) -> (png::ColorType, Vec<u8>) {
    let texel = |at: u32| sample(image, at % image.width, at / image.width);
    let byte = |value: f32| (255.0 * value.clamp(0.0, 1.0)).round() as u8;
    let count = image.width * image.height;
    if is_transparent(image) {
        (png::ColorType::Rgba, (0..count).flat_map(|at| texel(at).map(byte)).collect())
    } else {
        let rgb = |[r, g, b, _]: [f32; 4]| [r, g, b].map(byte);
        (png::ColorType::Rgb, (0..count).flat_map(|at| rgb(texel(at))).collect())
    }
}

/// The stored values of a texel, in `[0, 1]`. Floating-point pictures hold radiance, which is sRGB-encoded and may exceed 1.
fn sample(image: &Image, x: u32, y: u32) -> [f32; 4] {
    let at = y as usize * image.width as usize + x as usize;
    let texel = match &image.pixels {
        Pixels::Rgba8(values) => {
            values[4 * at..].first_chunk().map(|texel: &[u8; 4]| texel.map(|v| f32::from(v) / 255.0))
        }
        Pixels::Rgba16(values) => {
            values[4 * at..].first_chunk().map(|texel: &[u16; 4]| texel.map(|v| f32::from(v) / 65535.0))
        }
        Pixels::RgbF32(values) => values[3 * at..].first_chunk().map(|texel: &[f32; 3]| {
            let [r, g, b] = texel.map(crate::phong::encode_srgb);
            [r, g, b, 1.0]
        }),
    };
    texel.unwrap_or([0.0; 4])
}

/// The stored values at a texture coordinate (v up): repeating, bilinear.
pub(super) fn bilinear(image: &Image, u: f64, v: f64) -> [f32; 4] {
    let split = |coordinate: f64, size: u32| {
        let place = coordinate.rem_euclid(1.0) * f64::from(size) - 0.5;
        let low = place.floor();
        let wrap = |texel: f64| texel.rem_euclid(f64::from(size)) as u32 % size;
        (wrap(low), wrap(low + 1.0), (place - low) as f32)
    };
    let (x0, x1, fx) = split(u, image.width);
    let (y0, y1, fy) = split(1.0 - v, image.height);
    let corners = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)].map(|(x, y)| sample(image, x, y));
    std::array::from_fn(|channel| {
        let [a, b, c, d] = corners.map(|corner| corner[channel]);
        let (top, bottom) = (a + (b - a) * fx, c + (d - c) * fx);
        top + (bottom - top) * fy
    })
}

/// The mean of the stored values.
pub(super) fn mean(image: &Image) -> [f32; 3] {
    let mut sums = [0.0_f64; 3];
    for y in 0..image.height {
        for x in 0..image.width {
            let texel = sample(image, x, y);
            for channel in 0..3 {
                sums[channel] += f64::from(texel[channel]);
            }
        }
    }
    sums.map(|sum| (sum / (f64::from(image.width) * f64::from(image.height))) as f32)
}

fn encode(width: u32, height: u32, color: png::ColorType, pixels: &[u8]) -> Result<Vec<u8>, ConvertError> {
    let failed =
        |error: png::EncodingError| ConvertError::Option(format!("a texture cannot be written as PNG: {error}"));
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(pixels).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(bytes)
}
