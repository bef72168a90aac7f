//! What a frame shows, beside the scene itself.

use std::sync::Arc;

use aam_scene::{Background, DisplacementMode, Layer, Shading};
use glam::Vec3;

use crate::EnvironmentDetail;

/// Samples a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Msaa {
    /// One: jagged edges.
    X1,
    /// Four: smooth edges. The default.
    #[default]
    X4,
}

impl Msaa {
    /// Samples a pixel.
    pub const fn samples(self) -> u32 {
        match self {
            Self::X1 => 1,
            Self::X4 => 4,
        }
    }
}

impl TryFrom<u32> for Msaa {
    type Error = String;

    fn try_from(samples: u32) -> Result<Self, String> {
        match samples {
            1 => Ok(Self::X1),
            4 => Ok(Self::X4),
            _ => Err(format!("{samples} samples a pixel are not offered: 1 or 4")),
        }
    }
}

/// Which aspect of the surfaces is drawn. All but [`Show::Lit`] show values as stored, without light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Show {
    /// The lit picture.
    #[default]
    Lit,
    /// One texture layer alone. Surfaces without it are dark grey.
    Layer(Layer),
    /// The world-space shading normal n as the colour (n + 1) / 2.
    Normals,
    /// How much of its light a shadow source lets through, from black to white: the source at this position in
    /// [`aam_scene::Shadows::sources`].
    Shadow(usize),
    /// The map of the shadow source at this position in [`aam_scene::Shadows::sources`], near the source light, far dark:
    /// one square, or one for each cascade or face of a cube. Black where there is none.
    ShadowMap(usize),
    /// Fractional part of a layer's texture coordinates, after the texture matrix, as red and green. Surfaces without
    /// them are dark grey.
    Uvs(Layer),
}

/// Lines and wire drawn over the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlays {
    /// The edges of all triangles.
    pub wireframe: bool,
    /// The normal of each vertex, as a line of this length in metres.
    pub normals: Option<f32>,
    /// The box around each node's mesh.
    pub bounds: bool,
    /// Further lines and triangles, for example hulls. Each is uploaded once, for as long as its `Arc` lives.
    pub shapes: Vec<Arc<Shape>>,
}

impl Overlays {
    /// True when nothing is drawn over the picture.
    pub fn is_empty(&self) -> bool {
        !self.wireframe && self.normals.is_none() && !self.bounds && self.shapes.is_empty()
    }
}

/// Lines or triangles in world coordinates, in plain colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Pairs or triples of vertices; a rest is not drawn.
    pub vertices: Vec<ShapeVertex>,
    /// How `vertices` are joined.
    pub kind: ShapeKind,
    /// False draws it in front of everything.
    pub depth_test: bool,
}

/// How the vertices of a shape are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ShapeKind {
    /// Each two are a line.
    Lines,
    /// Each three are a triangle, seen from both sides.
    Triangles,
}

/// A vertex of a shape.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct ShapeVertex {
    /// World position.
    pub position: Vec3,
    /// sRGB-encoded colour with alpha (not premultiplied).
    pub color: [f32; 4],
}

/// How to draw.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Samples a pixel.
    pub msaa: Msaa,
    /// Instead of [`aam_scene::Scene::shading`].
    pub shading: Option<Shading>,
    /// Instead of [`aam_scene::Scene::background`].
    pub background: Option<Background>,
    /// How displacement maps are drawn.
    pub displacement: DisplacementMode,
    /// Which aspect of the surfaces is drawn.
    pub show: Show,
    /// Lines drawn over the picture.
    pub overlays: Overlays,
    /// How finely the scene's environment is kept.
    pub environment: EnvironmentDetail,
    /// Largest ratio of a texture's anisotropic filter, 1 (off, the default) to 16.
    pub anisotropy: u16,
    /// Draws shadow maps only where there is none from an earlier picture: for several pictures of one moment. Casters
    /// that moved since leave their shadow behind.
    pub keep_shadow_maps: bool,
    /// Measures GPU time where the device can.
    pub gpu_timing: bool,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            msaa: Msaa::default(),
            shading: None,
            background: None,
            displacement: DisplacementMode::default(),
            show: Show::default(),
            overlays: Overlays::default(),
            environment: EnvironmentDetail::default(),
            anisotropy: 1,
            keep_shadow_maps: false,
            gpu_timing: true,
        }
    }
}
