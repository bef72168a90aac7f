//! What is behind everything.

use aam_scene::{Background, Pixels, ToneMap};
use glam::Vec3;

use crate::environment::SkyUniform;
use crate::lights::color;
use crate::materials::bind;
use crate::mips::{Meaning, srgb_decode};
use crate::pipelines::{Constants, PassFormat, PipelineKey};
use crate::shader::Program;
use crate::textures::TextureTable;
use crate::upload::Uploader;
use crate::{RenderError, Renderer};

/// What is behind everything, ready to be drawn.
#[derive(Debug)]
pub(crate) struct Backdrop {
    /// In the values of the pass.
    pub clear: wgpu::Color,
    /// A picture: its bind group and its pipeline.
    pub picture: Option<(wgpu::BindGroup, PipelineKey)>,
}

/// True if nothing shines through.
pub(crate) fn is_opaque(background: &Background, textures: &mut TextureTable) -> bool {
    match background {
        Background::Transparent => false,
        Background::Color(_) | Background::Environment => true,
        Background::Picture(image) => !textures.is_translucent(image),
    }
}

/// A colour as clear value: decoded if blending is linear.
fn clear_color(stored: Vec3, linear: bool) -> wgpu::Color {
    let stored = color(stored).min(Vec3::ONE);
    let [r, g, b] = stored.to_array().map(|c| f64::from(if linear { srgb_decode(c) } else { c }));
    wgpu::Color { r, g, b, a: 1.0 }
}

impl Renderer {
    /// The sky box.
    pub(crate) fn sky(
        &mut self,
        cube: &wgpu::TextureView,
        uniform: &SkyUniform,
        tone_map: ToneMap,
        pass: PassFormat,
        uploader: &mut Uploader<'_>,
    ) -> Result<Backdrop, RenderError> {
        let constants = Constants { tone_map, ..Constants::default() };
        let key = PipelineKey { constants, ..PipelineKey::new(Program::Sky, pass) };
        self.pipelines.ensure(&self.gpu, key, None)?;
        self.sky_uniform.set(uploader, bytemuck::bytes_of(uniform))?;
        let sampler = self.environments.sampler(&self.gpu);
        let layout = self.pipelines.sky_layout(&self.gpu);
        let group = self.sky_uniform.get().map(|buffer| {
            self.gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("sky"),
                layout,
                entries: &[
                    bind(0, buffer.as_entire_binding()),
                    bind(1, wgpu::BindingResource::Sampler(sampler)),
                    bind(2, wgpu::BindingResource::TextureView(cube)),
                ],
            })
        });
        Ok(Backdrop { clear: wgpu::Color::TRANSPARENT, picture: group.map(|group| (group, key)) })
    }

    pub(crate) fn backdrop(
        &mut self,
        background: &Background,
        linear: bool,
        pass: PassFormat,
        uploader: &mut Uploader<'_>,
        warnings: &mut Vec<String>,
    ) -> Result<Backdrop, RenderError> {
        let image = match background {
            Background::Transparent => return Ok(Backdrop { clear: wgpu::Color::TRANSPARENT, picture: None }),
            Background::Color(color) => return Ok(Backdrop { clear: clear_color(*color, linear), picture: None }),
            // There is none.
            Background::Environment => {
                return self.backdrop(&Background::default(), linear, pass, uploader, warnings);
            }
            Background::Picture(image) => image,
        };
        let meaning = if linear { Meaning::Srgb } else { Meaning::Stored };
        let name = "background picture";
        let texture = self.textures.ensure(uploader, image, name, meaning, self.picture, warnings)?;
        let encode = !linear && matches!(image.pixels, Pixels::RgbF32(_));
        let key = PipelineKey::new(Program::Background { encode }, pass);
        self.pipelines.ensure(&self.gpu, key, None)?;
        let device = self.gpu.device();
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some(name),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        let group = self.textures.view(texture).map(|view| {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(name),
                layout: self.pipelines.picture_layout(&self.gpu),
                entries: &[
                    bind(0, wgpu::BindingResource::Sampler(&sampler)),
                    bind(1, wgpu::BindingResource::TextureView(view)),
                ],
            })
        });
        Ok(Backdrop { clear: wgpu::Color::TRANSPARENT, picture: group.map(|group| (group, key)) })
    }
}
