//! Where a frame is drawn to.

use aam_scene::Shading;

/// How a target keeps the picture's alpha.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Alpha {
    /// Colour is multiplied with alpha (in linear light where the target is an sRGB format), as windows and `egui` expect.
    #[default]
    Premultiplied,
    /// Colour is independent of alpha, as in PNG files.
    Straight,
}

/// Where a frame is drawn to: all of a single-sampled texture's first level.
///
/// A frame is drawn straight into the target if its format fits the shading mode (see [`Target::fitting_format`]) and
/// no transparent background asks for more precision; otherwise into a texture of the renderer's own, which one more
/// pass converts. The bytes in the target are sRGB-encoded in both cases.
#[derive(Clone, Copy, Debug)]
pub struct Target<'a> {
    /// The view drawn to; its texture needs the usage `RENDER_ATTACHMENT`.
    pub view: &'a wgpu::TextureView,
    /// Format of the view.
    pub format: wgpu::TextureFormat,
    /// How alpha is kept.
    pub alpha: Alpha,
}

impl<'a> Target<'a> {
    /// A view that has the format of its texture, with premultiplied alpha.
    pub fn new(view: &'a wgpu::TextureView) -> Self {
        Self { view, format: view.texture().format(), alpha: Alpha::Premultiplied }
    }

    /// The variant of `format` that a mode is drawn to without a converting pass: the plain one for
    /// [`Shading::Source`], the sRGB one for [`Shading::Linear`].
    pub fn fitting_format(format: wgpu::TextureFormat, shading: Shading) -> wgpu::TextureFormat {
        match shading {
            Shading::Source => format.remove_srgb_suffix(),
            Shading::Linear => format.add_srgb_suffix(),
        }
    }
}
