//! Images on the GPU: one texture for each image and meaning, for as long as the image lives.

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Weak};

use aam_scene::{Image, Pixels};

use crate::RenderError;
use crate::mips::{self, Level, Meaning, Texel};
use crate::upload::Uploader;

/// Identifies a texture: the image by its address (which no other gets while the table knows it), and its meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct TextureKey {
    image: usize,
    meaning: Meaning,
}

#[derive(Debug)]
struct Entry {
    image: Weak<Image>,
    view: wgpu::TextureView,
    bytes: u64,
    last_used: u64,
}

/// The textures on the GPU.
#[derive(Debug, Default)]
pub(crate) struct TextureTable {
    entries: HashMap<TextureKey, Entry>,
    /// Whether an image has an alpha below 1; found out once.
    translucent: HashMap<usize, (Weak<Image>, bool)>,
}

impl TextureTable {
    /// Makes sure that an image is on the GPU. `name` is for messages.
    pub(crate) fn ensure(
        &mut self,
        uploader: &mut Uploader<'_>,
        image: &Arc<Image>,
        name: &str,
        meaning: Meaning,
        frame: u64,
        warnings: &mut Vec<String>,
    ) -> Result<TextureKey, RenderError> {
        let key = TextureKey { image: Arc::as_ptr(image) as usize, meaning };
        if let Some(entry) = self.entries.get_mut(&key) {
            entry.last_used = frame;
            return Ok(key);
        }
        let (view, bytes) = upload(uploader, image, name, meaning, warnings)?;
        self.entries.insert(key, Entry { image: Arc::downgrade(image), view, bytes, last_used: frame });
        Ok(key)
    }

    /// The view of a texture that is there.
    pub(crate) fn view(&self, key: TextureKey) -> Option<&wgpu::TextureView> {
        self.entries.get(&key).map(|entry| &entry.view)
    }

    pub(crate) fn contains(&self, key: TextureKey) -> bool {
        self.entries.contains_key(&key)
    }

    /// Whether any alpha of the image is below 1.
    pub(crate) fn is_translucent(&mut self, image: &Arc<Image>) -> bool {
        let address = Arc::as_ptr(image) as usize;
        let entry = self.translucent.entry(address).or_insert_with(|| {
            let translucent = match &image.pixels {
                Pixels::Rgba8(values) => values.iter().skip(3).step_by(4).any(|&alpha| alpha < u8::MAX),
                Pixels::Rgba16(values) => values.iter().skip(3).step_by(4).any(|&alpha| alpha < u16::MAX),
                Pixels::RgbF32(_) => false,
            };
            (Arc::downgrade(image), translucent)
        });
        entry.1
    }

    /// Frees textures whose image is gone, and those of another meaning than the one that this frame used. Returns
    /// whether any went.
    pub(crate) fn sweep(&mut self, frame: u64) -> bool {
        self.translucent.retain(|_, (image, _)| image.strong_count() > 0);
        let used: HashSet<usize> =
            self.entries.iter().filter(|(_, entry)| entry.last_used == frame).map(|(key, _)| key.image).collect();
        let before = self.entries.len();
        self.entries.retain(|key, entry| {
            entry.image.strong_count() > 0 && (entry.last_used == frame || !used.contains(&key.image))
        });
        self.entries.len() < before
    }

    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.entries.values().map(|entry| entry.bytes).sum()
    }
}

/// Number of values a pixel.
fn channels(pixels: &Pixels) -> (usize, usize) {
    match pixels {
        Pixels::Rgba8(values) => (values.len(), 4),
        Pixels::Rgba16(values) => (values.len(), 4),
        Pixels::RgbF32(values) => (values.len(), 3),
    }
}

/// Fills in row `y` of an image; colours are decoded if they are encoded and to be computed on in linear light.
fn read_row(image: &Image, meaning: Meaning, y: u32, out: &mut [Texel]) {
    let width = image.width as usize;
    let start = y as usize * width;
    match &image.pixels {
        Pixels::Rgba8(values) => {
            let table = &*mips::SRGB8;
            for (texel, code) in out.iter_mut().zip(values[4 * start..].chunks_exact(4)) {
                let color = |code: u8| match meaning {
                    Meaning::Srgb => table[usize::from(code)],
                    Meaning::Stored | Meaning::Vectors => f32::from(code) / 255.0,
                };
                *texel = [color(code[0]), color(code[1]), color(code[2]), f32::from(code[3]) / 255.0];
            }
        }
        Pixels::Rgba16(values) => {
            for (texel, code) in out.iter_mut().zip(values[4 * start..].chunks_exact(4)) {
                let value = [0, 1, 2, 3].map(|channel| f32::from(code[channel]) / 65535.0);
                *texel = match meaning {
                    Meaning::Srgb => {
                        let color = [0, 1, 2].map(|channel: usize| mips::srgb_decode(value[channel]));
                        [color[0], color[1], color[2], value[3]]
                    }
                    Meaning::Stored | Meaning::Vectors => value,
                };
            }
        }
        Pixels::RgbF32(values) => {
            for (texel, value) in out.iter_mut().zip(values[3 * start..].chunks_exact(3)) {
                let finite = |v: f32| if v.is_finite() { v } else { 0.0 };
                *texel = [finite(value[0]), finite(value[1]), finite(value[2]), 1.0];
            }
        }
    }
}

/// Appends the bytes of texels in the texture's format.
fn encode(texels: &[Texel], format: wgpu::TextureFormat, out: &mut Vec<u8>) {
    match format {
        wgpu::TextureFormat::Rgba16Float => {
            out.reserve(8 * texels.len());
            for value in texels.iter().flatten() {
                out.extend_from_slice(&mips::half_encode(*value).to_le_bytes());
            }
        }
        wgpu::TextureFormat::Rgba8UnormSrgb => {
            out.reserve(4 * texels.len());
            for [r, g, b, a] in texels {
                out.extend_from_slice(&[*r, *g, *b].map(mips::srgb8_encode));
                out.push(mips::unorm8_encode(*a));
            }
        }
        _ => {
            out.reserve(4 * texels.len());
            out.extend(texels.iter().flatten().map(|value| mips::unorm8_encode(*value)));
        }
    }
}

fn upload(
    uploader: &mut Uploader<'_>,
    image: &Image,
    name: &str,
    meaning: Meaning,
    warnings: &mut Vec<String>,
) -> Result<(wgpu::TextureView, u64), RenderError> {
    let (values, channels) = channels(&image.pixels);
    let expected = u64::from(image.width) * u64::from(image.height) * channels as u64;
    if image.width == 0 || image.height == 0 || values as u64 != expected {
        return Err(RenderError::Image {
            image: name.to_owned(),
            reason: format!("{} × {} pixels need {expected} values, and there are {values}", image.width, image.height),
        });
    }
    let bytes = match &image.pixels {
        Pixels::Rgba8(bytes) => Some(bytes),
        _ => None,
    };
    let (format, texel_bytes) = match (bytes.is_some(), meaning) {
        (true, Meaning::Srgb) => (wgpu::TextureFormat::Rgba8UnormSrgb, 4),
        (true, Meaning::Stored | Meaning::Vectors) => (wgpu::TextureFormat::Rgba8Unorm, 4),
        (false, _) => (wgpu::TextureFormat::Rgba16Float, 8),
    };
    let levels = mips::level_count(image.width, image.height);
    let limit = uploader.gpu.device().limits().max_texture_dimension_2d;
    let skipped = (0..levels).find(|level| image.width.max(image.height) >> level <= limit).unwrap_or(levels - 1);
    let base = ((image.width >> skipped).max(1), (image.height >> skipped).max(1));
    if skipped > 0 {
        warnings.push(format!(
            "texture {name:?} is {} × {} pixels; this GPU takes at most {limit} a side (maxTextureDimension2D), so it is \
             drawn at {} × {}",
            image.width, image.height, base.0, base.1
        ));
    }
    let texture = uploader.gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size: wgpu::Extent3d { width: base.0, height: base.1, depth_or_array_layers: 1 },
        mip_level_count: levels - skipped,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });

    let before = uploader.bytes;
    let mut buffer = Vec::new();
    if skipped == 0 {
        // 8-bit texels are kept bit for bit.
        if let Some(bytes) = bytes {
            uploader.write_level(&texture, 0, base, texel_bytes, bytes);
        } else {
            let mut row = vec![[0.0; 4]; image.width as usize];
            for y in 0..image.height {
                read_row(image, meaning, y, &mut row);
                encode(&row, format, &mut buffer);
            }
            uploader.write_level(&texture, 0, base, texel_bytes, &buffer);
        }
    }
    let mut current: Option<Level> = None;
    for level in 1..levels {
        let next = match &current {
            None => mips::next_level(image.width, image.height, meaning, |y, out| read_row(image, meaning, y, out)),
            Some(level) => mips::next_level(level.width, level.height, meaning, |y, out| {
                let start = y as usize * level.width as usize;
                out.copy_from_slice(&level.texels[start..start + level.width as usize]);
            }),
        };
        if level >= skipped {
            buffer.clear();
            encode(&next.texels, format, &mut buffer);
            uploader.write_level(&texture, level - skipped, (next.width, next.height), texel_bytes, &buffer);
        }
        current = Some(next);
    }
    Ok((texture.create_view(&wgpu::TextureViewDescriptor::default()), uploader.bytes - before))
}
