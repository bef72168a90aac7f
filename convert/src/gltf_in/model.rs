//! A glTF file as plain data, with every index checked against the list that it points into, so that whatever comes
//! later may index freely.

use glam::{DAffine3, DQuat, DVec3};

/// The file without its binary data.
#[derive(Debug, Default)]
pub(super) struct Model {
    pub buffers: Vec<Buffer>,
    pub views: Vec<View>,
    pub accessors: Vec<Accessor>,
    pub images: Vec<Image>,
    pub samplers: Vec<Sampler>,
    pub textures: Vec<Texture>,
    pub materials: Vec<Material>,
    pub meshes: Vec<Mesh>,
    pub skins: Vec<Skin>,
    pub cameras: Vec<Camera>,
    pub lights: Vec<Light>,
    pub nodes: Vec<Node>,
    pub scenes: Vec<Scene>,
    /// The scene that is shown; `None` when the file has no scenes.
    pub scene: Option<usize>,
    pub animations: Vec<Animation>,
}

#[derive(Debug)]
pub(super) struct Buffer {
    pub uri: Option<String>,
    pub length: usize,
    /// An extension's name, where only that extension can fill the buffer.
    pub filled_by: Option<&'static str>,
    pub place: String,
}

#[derive(Debug)]
pub(super) struct View {
    pub buffer: usize,
    pub offset: usize,
    pub length: usize,
    pub stride: Option<usize>,
}

/// The types of numbers in a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    pub(super) const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// The shapes of an accessor's elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar,
    Vec2,
    Vec3,
    Vec4,
    Mat2,
    Mat3,
    Mat4,
}

impl Kind {
    pub(super) const fn word(self) -> &'static str {
        match self {
            Self::Scalar => "SCALAR",
            Self::Vec2 => "VEC2",
            Self::Vec3 => "VEC3",
            Self::Vec4 => "VEC4",
            Self::Mat2 => "MAT2",
            Self::Mat3 => "MAT3",
            Self::Mat4 => "MAT4",
        }
    }

    /// Bytes from one element to the next where they stand close; the columns of a matrix start at multiples of four.
    pub(super) const fn size(self, component: Component) -> usize {
        let [columns, rows] = self.shape();
        let column = rows * component.size();
        if columns == 1 { column } else { columns * column.next_multiple_of(4) }
    }

    /// Bytes that one element needs: the last column of a matrix may end early.
    pub(super) const fn needed(self, component: Component) -> usize {
        let [columns, rows] = self.shape();
        let column = rows * component.size();
        (columns - 1) * column.next_multiple_of(4) + column
    }

    /// Columns and rows.
    const fn shape(self) -> [usize; 2] {
        match self {
            Self::Scalar => [1, 1],
            Self::Vec2 => [1, 2],
            Self::Vec3 => [1, 3],
            Self::Vec4 => [1, 4],
            Self::Mat2 => [2, 2],
            Self::Mat3 => [3, 3],
            Self::Mat4 => [4, 4],
        }
    }
}

#[derive(Debug)]
pub(super) struct Accessor {
    pub view: Option<usize>,
    pub offset: usize,
    pub count: usize,
    pub component: Component,
    pub kind: Kind,
    pub normalized: bool,
    pub sparse: Option<Sparse>,
    pub place: String,
}

#[derive(Debug)]
pub(super) struct Sparse {
    pub count: usize,
    pub index_view: usize,
    pub index_offset: usize,
    pub index_component: Component,
    pub value_view: usize,
    pub value_offset: usize,
}

#[derive(Debug)]
pub(super) struct Image {
    pub name: Option<String>,
    pub source: ImageSource,
    pub place: String,
}

#[derive(Debug)]
pub(super) enum ImageSource {
    Uri(String),
    View(usize),
    /// Neither is there, which only an unknown extension can mean.
    Nothing,
}

/// A sampler, as far as it differs from what AAM does: repeat, trilinear.
#[derive(Clone, Debug, Default)]
pub(super) struct Sampler {
    /// How the picture goes on beyond its edges, where that is not by repeating.
    pub wrap: Option<&'static str>,
    /// The filter, where it is not a linear one.
    pub filter: Option<&'static str>,
}

#[derive(Debug)]
pub(super) struct Texture {
    /// The image, or an extension's name where only that extension has one.
    pub image: Result<usize, &'static str>,
    pub sampler: Option<usize>,
    pub place: String,
}

/// A use of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TextureRef {
    pub texture: usize,
    /// The `TEXCOORD` set.
    pub set: u32,
    pub transform: UvTransform,
}

/// `KHR_texture_transform`: scale first, then turn, then move, in glTF's texture space (v down).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvTransform {
    pub offset: [f32; 2],
    pub rotation: f32,
    pub scale: [f32; 2],
}

impl Default for UvTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2] }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum AlphaMode {
    #[default]
    Opaque,
    Mask {
        cutoff: f32,
    },
    Blend,
}

#[derive(Clone, Debug)]
pub(super) struct Material {
    pub name: Option<String>,
    pub workflow: Workflow,
    pub base_color: [f32; 4],
    pub base_texture: Option<TextureRef>,
    pub normal: Option<(TextureRef, f32)>,
    pub occlusion: Option<(TextureRef, f32)>,
    pub emissive: [f32; 3],
    pub emissive_texture: Option<TextureRef>,
    pub alpha: AlphaMode,
    pub double_sided: bool,
    /// Extensions that are not honoured.
    pub ignored: Vec<String>,
    /// `extras`, as JSON.
    pub extras: Option<String>,
}

/// How a material answers to light.
#[derive(Clone, Debug)]
pub(super) enum Workflow {
    MetallicRoughness {
        metallic: f32,
        roughness: f32,
        texture: Option<TextureRef>,
        /// Reflectance of the dielectric part at normal incidence, from `KHR_materials_specular` and `_ior`.
        f0: [f32; 3],
    },
    SpecularGlossiness {
        specular: [f32; 3],
        glossiness: f32,
        texture: Option<TextureRef>,
    },
    Unlit,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: None,
            workflow: Workflow::MetallicRoughness {
                metallic: 1.0,
                roughness: 1.0,
                texture: None,
                f0: [crate::phong::DEFAULT_F0; 3],
            },
            base_color: [1.0; 4],
            base_texture: None,
            normal: None,
            occlusion: None,
            emissive: [0.0; 3],
            emissive_texture: None,
            alpha: AlphaMode::Opaque,
            double_sided: false,
            ignored: Vec::new(),
            extras: None,
        }
    }
}

impl Material {
    /// Every use of a texture.
    pub(super) fn textures(&self) -> impl Iterator<Item = TextureRef> {
        let other = match &self.workflow {
            Workflow::MetallicRoughness { texture, .. } | Workflow::SpecularGlossiness { texture, .. } => *texture,
            Workflow::Unlit => None,
        };
        let normal = self.normal.map(|(texture, _)| texture);
        let occlusion = self.occlusion.map(|(texture, _)| texture);
        [self.base_texture, other, normal, occlusion, self.emissive_texture].into_iter().flatten()
    }
}

#[derive(Debug)]
pub(super) struct Mesh {
    pub name: Option<String>,
    pub primitives: Vec<Primitive>,
    pub weights: Vec<f32>,
    /// How many morph targets every primitive has.
    pub targets: usize,
    /// `extras`, as JSON.
    pub extras: Option<String>,
}

/// How indices make triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    Points,
    Lines,
    Triangles,
    Strip,
    Fan,
}

#[derive(Debug, Default)]
pub(super) struct Attributes {
    pub position: Option<usize>,
    pub normal: Option<usize>,
    pub tangent: Option<usize>,
    /// `TEXCOORD_n` by n.
    pub tex_coords: Vec<(u32, usize)>,
    pub color: Option<usize>,
    /// `JOINTS_n` and `WEIGHTS_n`, in order of n.
    pub joints: Vec<usize>,
    pub weights: Vec<usize>,
    /// Attributes that are not honoured.
    pub ignored: Vec<String>,
}

#[derive(Debug)]
pub(super) struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    pub mode: Mode,
    /// POSITION and NORMAL of each morph target.
    pub targets: Vec<(Option<usize>, Option<usize>)>,
    pub place: String,
}

#[derive(Debug)]
pub(super) struct Skin {
    pub joints: Vec<usize>,
    pub inverse_bind: Option<usize>,
    pub place: String,
}

#[derive(Debug)]
pub(super) struct Camera {
    pub name: Option<String>,
    pub lens: Lens,
    pub near: f32,
    pub far: Option<f32>,
}

#[derive(Debug)]
pub(super) enum Lens {
    Perspective { fov_y: f32, aspect: Option<f32> },
    Orthographic { half_height: f32, half_width: f32 },
}

#[derive(Debug)]
pub(super) struct Light {
    pub name: Option<String>,
    pub kind: LightKind,
    pub color: [f32; 3],
    pub intensity: f32,
    pub range: Option<f32>,
}

#[derive(Debug)]
pub(super) enum LightKind {
    Directional,
    Point,
    Spot { inner: f32, outer: f32 },
}

#[derive(Debug)]
pub(super) struct Node {
    pub name: Option<String>,
    pub children: Vec<usize>,
    pub transform: Transform,
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    pub camera: Option<usize>,
    pub light: Option<usize>,
    pub weights: Option<Vec<f32>>,
    pub hidden: bool,
    /// `extras`, as JSON.
    pub extras: Option<String>,
    pub place: String,
}

/// A node's place relative to its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Transform {
    Parts(Parts),
    Matrix(DAffine3),
}

/// Translation, rotation, scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parts {
    pub translation: DVec3,
    pub rotation: DQuat,
    pub scale: DVec3,
}

impl Parts {
    pub(super) const IDENTITY: Self = Self { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE };

    pub(super) fn affine(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

impl Transform {
    pub(super) fn affine(&self) -> DAffine3 {
        match self {
            Self::Parts(parts) => parts.affine(),
            Self::Matrix(matrix) => *matrix,
        }
    }
}

#[derive(Debug)]
pub(super) struct Scene {
    pub name: Option<String>,
    pub roots: Vec<usize>,
}

#[derive(Debug)]
pub(super) struct Animation {
    pub name: Option<String>,
    pub channels: Vec<Channel>,
    /// What cannot be honoured, one sentence each.
    pub ignored: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Target {
    Translation,
    Rotation,
    Scale,
    Weights,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

#[derive(Debug)]
pub(super) struct Channel {
    pub node: usize,
    pub target: Target,
    pub interpolation: Interpolation,
    pub input: usize,
    pub output: usize,
    pub place: String,
}
