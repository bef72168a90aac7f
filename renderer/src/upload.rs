//! Copying to the GPU, counted and within its limits.

use crate::{Gpu, RenderError};

/// Creates and fills buffers and textures, and counts the bytes.
#[derive(Debug)]
pub(crate) struct Uploader<'a> {
    pub(crate) gpu: &'a Gpu,
    /// Bytes copied so far.
    pub(crate) bytes: u64,
}

impl<'a> Uploader<'a> {
    pub(crate) fn new(gpu: &'a Gpu) -> Self {
        Self { gpu, bytes: 0 }
    }

    /// An empty buffer; `what` names it in errors.
    pub(crate) fn empty_buffer(
        &self,
        what: &str,
        usage: wgpu::BufferUsages,
        size: u64,
    ) -> Result<wgpu::Buffer, RenderError> {
        let allowed = self.gpu.device().limits().max_buffer_size;
        if size > allowed {
            return Err(RenderError::Limit { what: what.to_owned(), needed: size, limit: "maxBufferSize", allowed });
        }
        Ok(self.gpu.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            size,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        }))
    }

    /// A buffer with contents, whose length is a multiple of 4.
    pub(crate) fn buffer(
        &mut self,
        what: &str,
        usage: wgpu::BufferUsages,
        contents: &[u8],
    ) -> Result<wgpu::Buffer, RenderError> {
        let buffer = self.empty_buffer(what, usage, contents.len() as u64)?;
        self.write(&buffer, 0, contents);
        Ok(buffer)
    }

    /// Replaces part of a buffer.
    pub(crate) fn write(&mut self, buffer: &wgpu::Buffer, offset: u64, contents: &[u8]) {
        self.gpu.queue().write_buffer(buffer, offset, contents);
        self.bytes += contents.len() as u64;
    }

    /// Fills rows of a texture without mip levels.
    pub(crate) fn write_rows(
        &mut self,
        texture: &wgpu::Texture,
        first: u32,
        (width, height): (u32, u32),
        bytes_per_texel: u32,
        contents: &[u8],
    ) {
        let origin = wgpu::Origin3d { x: 0, y: first, z: 0 };
        self.gpu.queue().write_texture(
            wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() },
            contents,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * bytes_per_texel),
                rows_per_image: Some(height),
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        self.bytes += contents.len() as u64;
    }

    /// Fills one level of a texture.
    pub(crate) fn write_level(
        &mut self,
        texture: &wgpu::Texture,
        mip_level: u32,
        (width, height): (u32, u32),
        bytes_per_texel: u32,
        contents: &[u8],
    ) {
        self.write_layers(texture, mip_level, (width, height, 1), bytes_per_texel, contents);
    }

    /// Fills one level of all layers of a texture.
    pub(crate) fn write_layers(
        &mut self,
        texture: &wgpu::Texture,
        mip_level: u32,
        (width, height, depth_or_array_layers): (u32, u32, u32),
        bytes_per_texel: u32,
        contents: &[u8],
    ) {
        self.gpu.queue().write_texture(
            wgpu::TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() },
            contents,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * bytes_per_texel),
                rows_per_image: Some(height),
            },
            wgpu::Extent3d { width, height, depth_or_array_layers },
        );
        self.bytes += contents.len() as u64;
    }
}

/// A buffer whose contents change from frame to frame; what stays the same is not copied again.
#[derive(Debug)]
pub(crate) struct DynamicBuffer {
    what: &'static str,
    usage: wgpu::BufferUsages,
    buffer: Option<wgpu::Buffer>,
    contents: Vec<u8>,
}

impl DynamicBuffer {
    pub(crate) const fn new(what: &'static str, usage: wgpu::BufferUsages) -> Self {
        Self { what, usage, buffer: None, contents: Vec::new() }
    }

    /// Makes the buffer start with `contents`, whose length is a multiple of 4. Returns true if the buffer is a new
    /// one.
    pub(crate) fn set(&mut self, uploader: &mut Uploader<'_>, contents: &[u8]) -> Result<bool, RenderError> {
        let fits = self.buffer.as_ref().is_some_and(|buffer| buffer.size() >= contents.len() as u64);
        if fits {
            if let (Some(buffer), Some((start, end))) = (&self.buffer, changed_range(&self.contents, contents)) {
                uploader.write(buffer, start as u64, &contents[start..end]);
            }
        } else if !contents.is_empty() {
            let size = (contents.len() as u64).next_power_of_two().max(256);
            let size = size.min(uploader.gpu.device().limits().max_buffer_size).max(contents.len() as u64);
            let buffer = uploader.empty_buffer(self.what, self.usage, size)?;
            uploader.write(&buffer, 0, contents);
            self.buffer = Some(buffer);
        }
        self.contents.clear();
        self.contents.extend_from_slice(contents);
        Ok(!fits)
    }

    /// The buffer, once something was put into it.
    pub(crate) fn get(&self) -> Option<&wgpu::Buffer> {
        self.buffer.as_ref()
    }
}

/// The part of `new` outside of which it equals `old`, in whole words; `None` if all of `new` is there already.
fn changed_range(old: &[u8], new: &[u8]) -> Option<(usize, usize)> {
    let common = old.len().min(new.len());
    let start = old.iter().zip(new).position(|(a, b)| a != b).unwrap_or(common);
    if start == new.len() {
        return None;
    }
    let end = if new.len() > old.len() {
        new.len()
    } else {
        // Bytes behind `new` stay as they were, and nobody reads them.
        common - old[..common].iter().rev().zip(new[..common].iter().rev()).take_while(|(a, b)| a == b).count()
    };
    Some((start / 4 * 4, end.next_multiple_of(4)))
}

#[cfg(test)]
mod tests {
    use super::changed_range;

    #[test]
    fn only_what_differs_is_copied() {
        assert_eq!(changed_range(b"abcdefgh", b"abcdefgh"), None);
        assert_eq!(changed_range(b"abcdefgh", b"abcd"), None);
        assert_eq!(changed_range(b"abcdefghijkl", b"abcdeXghijkl"), Some((4, 8)));
        assert_eq!(changed_range(b"abcd", b"abcdefgh"), Some((4, 8)));
        assert_eq!(changed_range(b"", b"abcd"), Some((0, 4)));
        assert_eq!(changed_range(b"abcdefgh", b"Xbcd"), Some((0, 4)));
        assert_eq!(changed_range(b"", b""), None);
    }
}
