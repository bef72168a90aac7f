//! The window's surface, the device, and the painting of egui's shapes.

use std::sync::Arc;

use aam_renderer::{Gpu, GpuError};
use egui_wgpu::ScreenDescriptor;
use winit::dpi::PhysicalSize;
use winit::event_loop::OwnedDisplayHandle;
use winit::window::Window;

/// The most frames that wait to be shown: fewer means less lag behind the mouse.
const FRAME_LATENCY: u32 = 1;

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Presented {
    /// It is shown.
    Yes,
    /// The window has no picture at the moment (minimised, covered, size 0).
    Hidden,
    /// The surface was made anew; draw again.
    Again,
}

/// The device and the window's surface.
pub(crate) struct Graphics {
    instance: wgpu::Instance,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    pub(crate) gpu: Gpu,
    pub(crate) painter: egui_wgpu::Renderer,
}

impl Graphics {
    /// A device that draws to the window.
    pub(crate) fn new(window: &Arc<Window>, display: OwnedDisplayHandle) -> Result<Self, GpuError> {
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_with_display_handle_from_env(Box::new(display)));
        let surface = instance
            .create_surface(Arc::clone(window))
            .map_err(|error| GpuError::NoAdapter { reason: error.to_string() })?;
        let gpu = Gpu::for_surface(&instance, &surface)?;
        let unsuitable =
            |reason: &str| GpuError::Unsuitable { adapter: gpu.summary().name.clone(), reason: reason.into() };
        let capabilities = surface.get_capabilities(gpu.adapter());
        // egui blends in encoded values, so the plain format is right although the bytes are sRGB.
        let format = capabilities
            .formats
            .iter()
            .copied()
            .find(|format| matches!(format, wgpu::TextureFormat::Bgra8Unorm | wgpu::TextureFormat::Rgba8Unorm))
            .or_else(|| capabilities.formats.first().copied())
            .ok_or_else(|| unsuitable("it cannot present to this window"))?;
        let PhysicalSize { width, height } = window.inner_size();
        let mut config = surface
            .get_default_config(gpu.adapter(), width.max(1), height.max(1))
            .ok_or_else(|| unsuitable("it cannot present to this window"))?;
        config.format = format;
        config.present_mode = wgpu::PresentMode::AutoVsync;
        config.desired_maximum_frame_latency = FRAME_LATENCY;
        surface.configure(gpu.device(), &config);
        let painter = egui_wgpu::Renderer::new(gpu.device(), format, egui_wgpu::RendererOptions::default());
        Ok(Self { instance, surface, config, gpu, painter })
    }

    /// The largest side of a texture, which egui's font atlas must keep to.
    pub(crate) fn max_texture_side(&self) -> u32 {
        self.gpu.device().limits().max_texture_dimension_2d
    }

    /// Draws egui's output to the window, whose size is `size` in pixels.
    pub(crate) fn paint(
        &mut self,
        window: &Arc<Window>,
        size: PhysicalSize<u32>,
        primitives: &[egui::ClippedPrimitive],
        mut textures: egui::TexturesDelta,
        pixels_per_point: f32,
    ) -> Result<Presented, String> {
        // Also a hidden window's textures are taken, for egui sends each only once.
        for (id, deltas) in &textures.set {
            for delta in deltas {
                self.painter.update_texture(self.gpu.device(), self.gpu.queue(), *id, delta);
            }
        }
        let presented = self.paint_primitives(window, size, primitives, pixels_per_point);
        for id in &textures.free {
            self.painter.free_texture(id);
        }
        textures.clear();
        presented
    }

    fn paint_primitives(
        &mut self,
        window: &Arc<Window>,
        size: PhysicalSize<u32>,
        primitives: &[egui::ClippedPrimitive],
        pixels_per_point: f32,
    ) -> Result<Presented, String> {
        let largest = self.max_texture_side();
        let (width, height) = (size.width.min(largest), size.height.min(largest));
        if width == 0 || height == 0 {
            return Ok(Presented::Hidden);
        }
        if (width, height) != (self.config.width, self.config.height) {
            (self.config.width, self.config.height) = (width, height);
            self.surface.configure(self.gpu.device(), &self.config);
        }
        let frame = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(frame) | wgpu::CurrentSurfaceTexture::Suboptimal(frame) => frame,
            wgpu::CurrentSurfaceTexture::Timeout | wgpu::CurrentSurfaceTexture::Occluded => {
                return Ok(Presented::Hidden);
            }
            wgpu::CurrentSurfaceTexture::Outdated => {
                self.surface.configure(self.gpu.device(), &self.config);
                return Ok(Presented::Again);
            }
            wgpu::CurrentSurfaceTexture::Lost => {
                self.surface = self.instance.create_surface(Arc::clone(window)).map_err(|error| error.to_string())?;
                self.surface.configure(self.gpu.device(), &self.config);
                return Ok(Presented::Again);
            }
            wgpu::CurrentSurfaceTexture::Validation => return Err("the window's surface cannot be drawn to".into()),
        };
        let view = frame.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let screen = ScreenDescriptor { size_in_pixels: [width, height], pixels_per_point };
        let (device, queue) = (self.gpu.device(), self.gpu.queue());
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("window") });
        let mut commands = self.painter.update_buffers(device, queue, &mut encoder, primitives, &screen);
        {
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("window"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
            self.painter.render(&mut pass.forget_lifetime(), primitives, &screen);
        }
        commands.push(encoder.finish());
        queue.submit(commands);
        window.pre_present_notify();
        queue.present(frame);
        Ok(Presented::Yes)
    }
}

impl Graphics {
    /// A texture to draw a picture to and to show it from.
    pub(crate) fn picture_view(&self, [width, height]: [u32; 2]) -> wgpu::TextureView {
        let texture = self.gpu.device().create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }
}
