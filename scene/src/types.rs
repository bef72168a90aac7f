//! The scene's data types.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{Affine3A, Mat3, Mat4, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

use crate::{Environment, Shadows, ToneMap};

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(pub u32);

        impl $name {
            /// The position in the scene's list.
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }
    };
}

id!(
    /// A position in [`Scene::nodes`].
    NodeId
);
id!(
    /// A position in [`Scene::meshes`].
    MeshId
);
id!(
    /// A position in [`Scene::materials`].
    MaterialId
);
id!(
    /// A position in [`Scene::textures`].
    TextureId
);

/// Everything that a frame shows.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Which way is up.
    pub up: Up,
    /// Objects. A parent stands before its children.
    pub nodes: Vec<Node>,
    /// Meshes, shared by nodes.
    pub meshes: Vec<Arc<Mesh>>,
    /// Materials, shared by subsets.
    pub materials: Vec<Material>,
    /// Textures, shared by material layers: one for each distinct file.
    pub textures: Vec<Texture>,
    /// Lights. Empty means [`Scene::effective_lights`] puts one at the camera.
    pub lights: Vec<Light>,
    /// Cameras that files brought along.
    pub cameras: Vec<Camera>,
    /// What is behind everything.
    pub background: Background,
    /// Light from all around. Where it lights, it takes the place of the lights and of ambient colours.
    pub environment: Option<Environment>,
    /// On which values lighting computes.
    pub shading: Shading,
    /// Exposure in stops: surfaces and the sky box appear brighter by 2 to this power.
    pub exposure: f32,
    /// How light beyond white is shown.
    pub tone_map: ToneMap,
    /// Animation over time, if any mesh or node moves.
    pub animation: Option<Animation>,
    /// Shadows, if there are any.
    pub shadows: Option<Shadows>,
}

/// The axis that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// +Y, as in glTF.
    Y,
    /// +Z, as in AAM and 3ds Max.
    #[default]
    Z,
}

impl Up {
    /// The unit vector.
    pub const fn axis(self) -> Vec3 {
        match self {
            Self::Y => Vec3::Y,
            Self::Z => Vec3::Z,
        }
    }
}

/// The values that lighting computes on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shading {
    /// On the stored, encoded values, clamped at the end, as VR3Lib and XVR did.
    #[default]
    Source,
    /// Colours are decoded from sRGB first, lit in linear light, and encoded last.
    Linear,
}

/// An object: a place, and perhaps a mesh.
#[derive(Clone, Debug)]
pub struct Node {
    /// Name.
    pub name: String,
    /// Parent; it stands before this node in [`Scene::nodes`].
    pub parent: Option<NodeId>,
    /// From this node's coordinates to its parent's.
    pub local: Affine3A,
    /// What is drawn here.
    pub mesh: Option<MeshId>,
    /// False hides this node and its children.
    pub visible: bool,
}

/// Triangles with their attributes, welded: equal corners are one vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Name.
    pub name: String,
    /// Positions in the object's coordinates.
    pub positions: Vec<Vec3>,
    /// Unit normals, one for each position.
    pub normals: Vec<Vec3>,
    /// Tangents (xyz) and the bitangent's sign (w), one for each position; only where a tangent-space normal map needs them.
    pub tangents: Option<Vec<Vec4>>,
    /// Vertex colours, sRGB-encoded with alpha, one for each position.
    pub colors: Option<Vec<Vec4>>,
    /// Texture coordinates for each of the four layers, one for each position.
    pub uvs: [Option<Vec<Vec2>>; 4],
    /// Triples of positions, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
    /// Runs of `indices` with one material each; together they cover `indices` in order.
    pub subsets: Vec<Subset>,
    /// The box around all positions, those of later frames included.
    pub bounds: Aabb,
    /// Displacement parameters, if the object has them.
    pub displacement: Option<Displacement>,
    /// Later frames of a multiframe mesh: the same vertices elsewhere. Frame f of the animation is entry f − 1.
    pub frames: Vec<MeshFrame>,
}

/// One later frame of a multiframe mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFrame {
    /// Positions, as many as [`Mesh::positions`].
    pub positions: Vec<Vec3>,
    /// Normals, as many.
    pub normals: Vec<Vec3>,
}

/// A run of triangles that share a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subset {
    /// First index in [`Mesh::indices`].
    pub first_index: u32,
    /// How many indices (three for each triangle).
    pub index_count: u32,
    /// The material.
    pub material: MaterialId,
}

/// Displacement mapping of a mesh: `P' = P + n·(bias + scale·h)`, `h` in `[0, 1]`, in object units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement {
    /// Parts that each edge is cut into, at least 1.
    pub tessellation: u32,
    /// Displacement where the map is 0.
    pub bias: f32,
    /// Added displacement where the map is 1.
    pub scale: f32,
}

/// An axis-aligned box. Empty when `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Default for Aabb {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Aabb {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box around points; points that are not finite are left out.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points
            .into_iter()
            .filter(|point| point.is_finite())
            .fold(Self::EMPTY, |aabb, point| Self { min: aabb.min.min(point), max: aabb.max.max(point) })
    }

    /// True when it holds nothing.
    pub fn is_empty(&self) -> bool {
        !(self.min.cmple(self.max).all())
    }

    /// The box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Centre; the origin when empty.
    pub fn center(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { 0.5 * (self.min + self.max) }
    }

    /// Its eight corners; of an empty one they mean nothing.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|corner| {
            let pick = |bit: usize| if corner >> bit & 1 == 0 { self.min[bit] } else { self.max[bit] };
            Vec3::new(pick(0), pick(1), pick(2))
        })
    }

    /// Length of the diagonal; 0 when empty.
    pub fn diagonal(&self) -> f32 {
        // Squares of large coordinates leave the range of 32 bits.
        if self.is_empty() { 0.0 } else { self.max.as_dvec3().distance(self.min.as_dvec3()) as f32 }
    }

    /// How far from its centre a camera with these axes (right, up, backward) stands to see all of the box, when
    /// `tangents` are those of half its angles, wide and high; and how far the box reaches towards the camera.
    pub fn fitting_distance(&self, [right, up, backward]: [Vec3; 3], tangents: Vec2) -> (f32, f32) {
        let half = if self.is_empty() { Vec3::ZERO } else { 0.5 * self.max - 0.5 * self.min };
        let (mut distance, mut depth) = (0.0_f32, 0.0_f32);
        for corner in (Self { min: -half, max: half }).corners() {
            let towards = corner.dot(backward);
            depth = depth.max(towards);
            let aside = (corner.dot(right).abs() / tangents.x).max(corner.dot(up).abs() / tangents.y);
            distance = distance.max(towards + aside);
        }
        (distance, depth)
    }

    /// The box around the transformed box.
    #[must_use]
    pub fn transformed(&self, transform: &Affine3A) -> Self {
        if self.is_empty() {
            return *self;
        }
        Self::of(self.corners().map(|corner| transform.transform_point3(corner)))
    }
}

/// The four texture layers, as positions in [`Material::layers`] and [`Mesh::uvs`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Layer {
    /// Diffuse texture, multiplies the whole lit colour.
    Diffuse = 0,
    /// Light map, replaces lighting.
    LightMap = 1,
    /// Normal map.
    Normal = 2,
    /// Displacement map, red channel.
    Displacement = 3,
}

impl Layer {
    /// All four, in order.
    pub const ALL: [Self; 4] = [Self::Diffuse, Self::LightMap, Self::Normal, Self::Displacement];
}

/// Phong parameters and texture layers. Colours are sRGB-encoded as in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name.
    pub name: String,
    /// Emission E, added whatever the light; may exceed 1.
    pub emission: Vec3,
    /// Ambient reflectance A.
    pub ambient: Vec3,
    /// Diffuse reflectance D.
    pub diffuse: Vec3,
    /// Specular reflectance S.
    pub specular: Vec3,
    /// Phong exponent n; 0 means no highlight.
    pub exponent: f32,
    /// 1 − transparency, in `[0, 1]`.
    pub opacity: f32,
    /// Fragments with alpha below it are discarded.
    pub alpha_cutoff: Option<f32>,
    /// Texture layers, by [`Layer`].
    pub layers: [Option<TextureLayer>; 4],
}

impl Default for Material {
    /// A light grey diffuse material without highlight.
    fn default() -> Self {
        Self {
            name: String::new(),
            emission: Vec3::ZERO,
            ambient: Vec3::splat(0.8),
            diffuse: Vec3::splat(0.8),
            specular: Vec3::ZERO,
            exponent: 0.0,
            opacity: 1.0,
            alpha_cutoff: None,
            layers: [const { None }; 4],
        }
    }
}

/// A texture as a material layer uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureLayer {
    /// Which texture.
    pub texture: TextureId,
    /// Applied to `(u, v, 1)` before sampling; v is 0 at the bottom.
    pub transform: Mat3,
    /// Space of a normal map.
    pub normal_space: NormalSpace,
    /// `In:`; scales xy of a tangent-space normal map, unused otherwise.
    pub intensity: f32,
}

/// The frame in which a normal map's vectors are given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum NormalSpace {
    /// The object's own axes.
    #[default]
    Object,
    /// The MikkTSpace tangent frame.
    Tangent,
}

/// An image that layers refer to.
#[derive(Clone, Debug)]
pub struct Texture {
    /// The name as the document gives it.
    pub name: String,
    /// Where it was found.
    pub path: Option<PathBuf>,
    /// The pixels, or why there are none; a layer whose texture has none counts as absent.
    pub image: Result<Arc<Image>, String>,
}

/// Pixels, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width in pixels, at least 1.
    pub width: u32,
    /// Height in pixels, at least 1.
    pub height: u32,
    /// The values.
    pub pixels: Pixels,
}

/// Pixel values, row after row from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// Four bytes a pixel: red, green, blue, alpha; alpha is not premultiplied.
    Rgba8(Vec<u8>),
    /// 16 bits for each of red, green, blue, alpha.
    Rgba16(Vec<u16>),
    /// Linear radiance, three floats a pixel; values above 1 kept.
    RgbF32(Vec<f32>),
}

/// A light source. Colours multiply the material's terms of the same name.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name.
    pub name: String,
    /// What kind of source, and where.
    pub kind: LightKind,
    /// Ambient colour.
    pub ambient: Vec3,
    /// Diffuse colour; may exceed 1.
    pub diffuse: Vec3,
    /// Specular colour; may exceed 1.
    pub specular: Vec3,
    /// Its extent, for soft shadows; `None` is a point.
    pub shape: Option<LightShape>,
}

/// The kinds of light.
#[derive(Clone, Debug, PartialEq)]
pub enum LightKind {
    /// Shines from a point to all sides.
    Point {
        /// World position.
        position: Vec3,
        /// How it weakens with distance.
        falloff: Falloff,
    },
    /// Shines everywhere in one direction.
    Directional {
        /// Direction in which light travels; need not be unit.
        direction: Vec3,
    },
    /// Shines from a point into a cone.
    Spot {
        /// World position.
        position: Vec3,
        /// Axis of the cone, away from the light; need not be unit.
        direction: Vec3,
        /// Half angle in radians inside which the light is full.
        inner: f32,
        /// Half angle in radians outside which there is none.
        outer: f32,
        /// How it weakens with distance.
        falloff: Falloff,
    },
}

/// How light weakens with distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Falloff {
    /// Not at all, as in the source.
    #[default]
    None,
    /// With the inverse square: full at one metre.
    InverseSquare,
}

/// The extent of a light: which points it shines from. What that means for shading stands in
/// `docs/techniques/shading.md`.
///
/// A flat shape faces the light's direction; that of a point light faces the middle of the scene. A directional light is
/// infinitely far away, and its lengths are those of a shape one metre from the viewer: the sun, half a degree wide, is
/// a disc of radius 0.00465.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// A disc.
    Disc {
        /// Radius in metres.
        radius: f32,
    },
    /// A rectangle. Its width runs level; along X where it faces straight up or down.
    Rectangle {
        /// Full width in metres.
        width: f32,
        /// Full height in metres.
        height: f32,
    },
    /// A sphere.
    Sphere {
        /// Radius in metres.
        radius: f32,
    },
}

/// A camera: where it stands, where it looks, what it sees.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name.
    pub name: String,
    /// World position.
    pub position: Vec3,
    /// The point in the middle of the picture.
    pub target: Vec3,
    /// Roughly up; need not be perpendicular.
    pub up: Vec3,
    /// Projection.
    pub projection: Projection,
    /// Distance of the near plane, above 0.
    pub near: f32,
    /// Distance of the far plane, above `near`.
    pub far: f32,
}

/// How the camera projects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Perspective.
    Perspective {
        /// Vertical field of view in radians.
        fov_y: f32,
    },
    /// Orthographic.
    Orthographic {
        /// Height of the picture in metres.
        height: f32,
    },
}

impl Camera {
    /// World to camera: x right, y up, looking down −Z.
    pub fn view(&self) -> Mat4 {
        let forward = (self.target - self.position).try_normalize().unwrap_or(Vec3::NEG_Z);
        let up = if forward.cross(self.up).length_squared() > 1e-10 * self.up.length_squared() {
            self.up
        } else {
            forward.any_orthonormal_vector()
        };
        glam::camera::rh::view::look_to_mat4(self.position, forward, up.normalize_or(Vec3::Y))
    }

    /// Camera to clip space, depth 0 near … 1 far.
    pub fn projection_matrix(&self, aspect: f32) -> Mat4 {
        match self.projection {
            Projection::Perspective { fov_y } => {
                glam::camera::rh::proj::directx::perspective(fov_y, aspect, self.near, self.far)
            }
            Projection::Orthographic { height } => {
                let (h, w) = (0.5 * height, 0.5 * height * aspect);
                glam::camera::rh::proj::directx::orthographic(-w, w, -h, h, self.near, self.far)
            }
        }
    }
}

/// What is behind everything.
#[derive(Clone, Debug, PartialEq)]
pub enum Background {
    /// Nothing: the picture is transparent there.
    Transparent,
    /// One colour, sRGB-encoded.
    Color(Vec3),
    /// A picture that fills the viewport.
    Picture(Arc<Image>),
    /// The sky box: [`Scene::environment`], or the default colour where there is none.
    Environment,
}

impl Default for Background {
    /// A dark blue grey, so that black and white objects both show.
    fn default() -> Self {
        Self::Color(Vec3::new(0.18, 0.20, 0.23))
    }
}

/// Poses over time.
#[derive(Clone, Debug, Default)]
pub struct Animation {
    /// Frames a second.
    pub frames_per_second: f32,
    /// How many frames.
    pub frame_count: usize,
    /// Nodes that move: local transforms for each frame.
    pub nodes: Vec<NodeMotion>,
}

/// The motion of one node, sampled once a frame.
#[derive(Clone, Debug)]
pub struct NodeMotion {
    /// The node.
    pub node: NodeId,
    /// Its local transform at each frame, [`Animation::frame_count`] of them.
    pub locals: Vec<Affine3A>,
}

impl Scene {
    /// Node to world for every node, in order. A parent that does not stand before its child counts as none.
    pub fn world_transforms(&self) -> Vec<Affine3A> {
        let mut world: Vec<Affine3A> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let parent = node.parent.and_then(|id| world.get(id.index()));
            world.push(parent.map_or(node.local, |parent| *parent * node.local));
        }
        world
    }

    /// This scene with each node on its own at this place in the world: without parents, and nodes do not move. What is
    /// visible stays so.
    #[must_use]
    pub fn posed(&self, world: &[Affine3A]) -> Self {
        let mut scene = self.clone();
        let visible = self.visibility();
        for (index, node) in scene.nodes.iter_mut().enumerate() {
            node.parent = None;
            node.visible = visible[index];
            if let Some(place) = world.get(index) {
                node.local = *place;
            }
        }
        if let Some(animation) = &mut scene.animation {
            animation.nodes.clear();
        }
        scene
    }

    /// Whether each node and all its ancestors are visible.
    pub fn visibility(&self) -> Vec<bool> {
        let mut visible: Vec<bool> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let parent = node.parent.and_then(|id| visible.get(id.index()));
            visible.push(node.visible && parent.copied().unwrap_or(true));
        }
        visible
    }

    /// The box around all visible meshes in the world, wherever displacement maps may move them.
    pub fn bounds(&self) -> Aabb {
        let world = self.world_transforms();
        let visible = self.visibility();
        let mut bounds = Aabb::EMPTY;
        for (index, node) in self.nodes.iter().enumerate() {
            if let (true, Some(mesh)) = (visible[index], node.mesh.and_then(|id| self.meshes.get(id.index()))) {
                bounds = bounds.union(&crate::displacement::bounds(mesh).transformed(&world[index]));
            }
        }
        bounds
    }

    /// The scene's lights, or one white point light at the camera if there are none (the flag is then true).
    pub fn effective_lights(&self, camera: &Camera) -> (Vec<Light>, bool) {
        if !self.lights.is_empty() {
            return (self.lights.clone(), false);
        }
        let head = Light {
            name: "camera light".into(),
            kind: LightKind::Point { position: camera.position, falloff: Falloff::None },
            ambient: Vec3::splat(0.2),
            diffuse: Vec3::ONE,
            specular: Vec3::ONE,
            shape: None,
        };
        (vec![head], true)
    }

    /// The environment that takes the place of lights, if there is one.
    pub fn lighting_environment(&self) -> Option<&Environment> {
        self.environment.as_ref().filter(|environment| environment.is_lit_by())
    }

    /// A perspective camera that sees everything, from the front, the right and a little above.
    pub fn fitting_camera(&self, aspect: f32) -> Camera {
        let direction = match self.up {
            Up::Z => Vec3::new(0.5, -0.75, 0.43),
            Up::Y => Vec3::new(0.5, 0.43, 0.75),
        };
        self.fitting_camera_from(direction, aspect)
    }

    /// A perspective camera that sees everything with a small margin, looking from `direction` (from the centre towards
    /// the camera). It looks at the box around everything, at the first frame of moving nodes.
    pub fn fitting_camera_from(&self, direction: Vec3, aspect: f32) -> Camera {
        const FOV_Y: f32 = 0.7;
        const MARGIN: f32 = 1.05;
        let bounds = self.bounds();
        // A point is seen from about a metre away, and so is nothing.
        let radius = Some(0.5 * bounds.diagonal()).filter(|&radius| radius > 0.0).unwrap_or(0.5);
        let backward = direction.normalize_or(Vec3::Y);
        let up = if backward.cross(self.up.axis()).length() < 1e-3 {
            match self.up {
                Up::Z => Vec3::Y,
                Up::Y => Vec3::NEG_Z,
            }
        } else {
            self.up.axis()
        };
        let right = up.cross(backward).normalize_or(Vec3::X);
        let upward = backward.cross(right);
        let tangent = (0.5 * FOV_Y).tan();
        let wide = tangent * if aspect > 0.0 { aspect } else { 1.0 };
        let (nearest, depth) = bounds.fitting_distance([right, upward, backward], Vec2::new(wide, tangent) / MARGIN);
        let distance = nearest.max(if bounds.diagonal() > 0.0 { depth + 2e-3 * radius } else { 1.0 });
        Camera {
            name: "fit".into(),
            position: bounds.center() + backward * distance,
            target: bounds.center(),
            up,
            projection: Projection::Perspective { fov_y: FOV_Y },
            near: (0.5 * (distance - depth)).max(1e-3 * distance),
            far: distance + 2.0 * radius,
        }
    }
}

/// What to draw a picture of: a camera and a size. A value, so that one frame may have several.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Picture width in pixels, at least 1.
    pub width: u32,
    /// Picture height in pixels, at least 1.
    pub height: u32,
    /// Frame of the animation, fractions between frames are rounded down.
    pub frame: f32,
}

impl View {
    /// Width over height.
    pub fn aspect(&self) -> f32 {
        self.width.max(1) as f32 / self.height.max(1) as f32
    }
}

#[cfg(test)]
#[path = "types_tests.rs"]
mod tests;
