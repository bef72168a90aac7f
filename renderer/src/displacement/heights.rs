//! Displacement maps on the GPU: heights as they are stored, one channel, read texel by texel. A texture unit's filter has
//! weights of 8 bits, and half floats 11 bits of height: both show as steps.

use std::collections::HashMap;
use std::sync::{Arc, Weak};

use aam_scene::displacement::HeightMap;
use aam_scene::{Image, Pixels};

use crate::RenderError;
use crate::upload::Uploader;

/// Texels that are handed over at once.
const CHUNK: usize = 1 << 22;

/// A map on the GPU.
#[derive(Debug)]
pub(super) struct GpuHeights {
    image: Weak<Image>,
    pub(super) view: wgpu::TextureView,
    /// How a texel is read: `texel` in `shaders/heights.wgsl`.
    pub(super) texel: u32,
    /// No other map has it.
    pub(super) serial: u64,
    bytes: u64,
}

/// The maps on the GPU, by the address of their image.
#[derive(Debug, Default)]
pub(super) struct HeightTable {
    maps: HashMap<usize, GpuHeights>,
    last_serial: u64,
}

impl HeightTable {
    /// Makes sure that a map is on the GPU. Warnings name the mesh.
    pub(super) fn ensure(
        &mut self,
        uploader: &mut Uploader<'_>,
        image: &Arc<Image>,
        heights: &HeightMap,
        mesh: &str,
        warnings: &mut Vec<String>,
    ) -> Result<&GpuHeights, RenderError> {
        let address = Arc::as_ptr(image) as usize;
        if !self.maps.contains_key(&address) {
            self.last_serial += 1;
            let entry = upload(uploader, image, heights, mesh, self.last_serial, warnings)?;
            self.maps.insert(address, entry);
        }
        Ok(&self.maps[&address])
    }

    pub(super) fn sweep(&mut self) {
        self.maps.retain(|_, entry| entry.image.strong_count() > 0);
    }

    pub(super) fn bytes(&self) -> u64 {
        self.maps.values().map(|entry| entry.bytes).sum()
    }
}

fn upload(
    uploader: &mut Uploader<'_>,
    image: &Arc<Image>,
    heights: &HeightMap,
    mesh: &str,
    serial: u64,
    warnings: &mut Vec<String>,
) -> Result<GpuHeights, RenderError> {
    let (width, height) = heights.size();
    let limit = uploader.gpu.device().limits().max_texture_dimension_2d as usize;
    // Each texel of the texture is the mean of this many texels a side.
    let step = width.max(height).div_ceil(limit);
    let (columns, rows) = (width.div_ceil(step), height.div_ceil(step));
    if step > 1 {
        warnings.push(format!(
            "the displacement map of mesh {mesh:?} is {width} × {height} texels; this GPU takes at most {limit} a side \
             (maxTextureDimension2D), so it is drawn at {columns} × {rows}"
        ));
    }
    let (format, texel, texel_bytes) = match image.pixels {
        Pixels::Rgba8(_) => (wgpu::TextureFormat::R8Uint, 0, 1),
        Pixels::Rgba16(_) => (wgpu::TextureFormat::R16Uint, 1, 2),
        Pixels::RgbF32(_) => (wgpu::TextureFormat::R32Uint, 2, 4_usize),
    };
    let size = wgpu::Extent3d { width: columns as u32, height: rows as u32, depth_or_array_layers: 1 };
    let texture = uploader.gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some(&format!("heights of mesh {mesh:?}")),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let before = uploader.bytes;
    let rows_a_chunk = (CHUNK / columns).clamp(1, rows);
    let mut bytes = Vec::with_capacity(rows_a_chunk * columns * texel_bytes);
    for first in (0..rows).step_by(rows_a_chunk) {
        bytes.clear();
        let count = rows_a_chunk.min(rows - first);
        for y in first..first + count {
            for x in 0..columns {
                let value = mean(heights, [x, y], step);
                match texel {
                    0 => bytes.push((255.0 * value).round() as u8),
                    1 => bytes.extend_from_slice(&((65535.0 * value).round() as u16).to_le_bytes()),
                    _ => bytes.extend_from_slice(&value.to_bits().to_le_bytes()),
                }
            }
        }
        uploader.write_rows(&texture, first as u32, (columns as u32, count as u32), texel_bytes as u32, &bytes);
    }
    Ok(GpuHeights {
        image: Arc::downgrade(image),
        view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
        texel,
        serial,
        bytes: uploader.bytes - before,
    })
}

/// The mean of a block of texels.
fn mean(heights: &HeightMap, [x, y]: [usize; 2], step: usize) -> f32 {
    if step == 1 {
        return heights.texel(x, y);
    }
    let (width, height) = heights.size();
    let (left, top) = (x * step, y * step);
    let (right, bottom) = ((left + step).min(width), (top + step).min(height));
    let sum: f64 = (top..bottom).flat_map(|y| (left..right).map(move |x| f64::from(heights.texel(x, y)))).sum();
    (sum / ((right - left) * (bottom - top)) as f64) as f32
}
