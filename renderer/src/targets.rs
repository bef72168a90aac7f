//! Render targets of the renderer's own, kept while pictures of their size are drawn.

use crate::{Gpu, RenderError};

/// What a target is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TargetKey {
    pub width: u32,
    pub height: u32,
    pub format: wgpu::TextureFormat,
    pub samples: u32,
    pub usage: wgpu::TextureUsages,
}

#[derive(Debug)]
struct Entry {
    key: TargetKey,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    last_used: u64,
}

/// Pictures that an unused target outlives, so that a few views of different sizes can alternate.
const KEEP: u64 = 4;

/// The targets there are.
#[derive(Debug, Default)]
pub(crate) struct TargetPool {
    entries: Vec<Entry>,
}

impl TargetPool {
    /// A texture of this kind and its view. The contents are whatever they were.
    pub(crate) fn get(&mut self, gpu: &Gpu, key: TargetKey, picture: u64) -> (wgpu::Texture, wgpu::TextureView) {
        if let Some(entry) = self.entries.iter_mut().find(|entry| entry.key == key) {
            entry.last_used = picture;
            return (entry.texture.clone(), entry.view.clone());
        }
        let texture = gpu.device().create_texture(&wgpu::TextureDescriptor {
            label: Some("render target"),
            size: wgpu::Extent3d { width: key.width, height: key.height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: key.samples,
            dimension: wgpu::TextureDimension::D2,
            format: key.format,
            usage: key.usage,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        self.entries.push(Entry { key, texture: texture.clone(), view: view.clone(), last_used: picture });
        (texture, view)
    }

    /// Frees targets that were not used for some pictures.
    pub(crate) fn sweep(&mut self, picture: u64) {
        self.entries.retain(|entry| entry.last_used + KEEP > picture);
    }

    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }
}

/// Whether a picture of this size can be drawn at all.
pub(crate) fn check_size(gpu: &Gpu, width: u32, height: u32) -> Result<(), RenderError> {
    if width == 0 || height == 0 {
        return Err(RenderError::EmptyPicture { width, height });
    }
    let allowed = gpu.device().limits().max_texture_dimension_2d;
    if width.max(height) > allowed {
        return Err(RenderError::Limit {
            what: format!("a picture of {width}×{height} pixels"),
            needed: u64::from(width.max(height)),
            limit: "maxTextureDimension2D",
            allowed: u64::from(allowed),
        });
    }
    Ok(())
}
