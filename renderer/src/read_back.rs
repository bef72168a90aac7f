//! Getting a picture from the GPU.

use std::time::Duration;

use crate::{Gpu, RenderError};

/// Bytes that a row of a copied texture is padded to.
const ROW_ALIGNMENT: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;

/// How long the answer may take once the GPU is done.
const PATIENCE: Duration = Duration::from_secs(10);

/// Copies the first level of a texture of four bytes a texel into memory, top row first; waits for the GPU.
pub(crate) fn read_texels(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<u8>, RenderError> {
    let (width, height) = (texture.width(), texture.height());
    let row = 4 * width;
    let padded = row.next_multiple_of(ROW_ALIGNMENT);
    let size = u64::from(padded) * u64::from(height);
    let allowed = gpu.device().limits().max_buffer_size;
    if size > allowed {
        let what = format!("reading back a picture of {width}×{height} pixels");
        return Err(RenderError::Limit { what, needed: size, limit: "maxBufferSize", allowed });
    }
    let buffer = gpu.device().create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("read back") });
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded),
                rows_per_image: Some(height),
            },
        },
        texture.size(),
    );
    gpu.queue().submit([encoder.finish()]);
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver is gone only if waiting failed, which is reported below.
        let _ = sender.send(result);
    });
    let fault = |message: String| RenderError::Gpu { during: "read the picture back", message };
    gpu.wait().map_err(fault)?;
    // Where several threads share the device, another one may be about to deliver the answer.
    match receiver.recv_timeout(PATIENCE) {
        Ok(Ok(())) => {}
        Ok(Err(error)) => return Err(fault(error.to_string())),
        Err(_) => return Err(fault("the device did not answer".into())),
    }
    let mapped = buffer.get_mapped_range(..).map_err(|error| fault(error.to_string()))?;
    let mut pixels = Vec::with_capacity(row as usize * height as usize);
    for line in mapped.chunks_exact(padded as usize) {
        pixels.extend_from_slice(&line[..row as usize]);
    }
    drop(mapped);
    buffer.unmap();
    Ok(pixels)
}
