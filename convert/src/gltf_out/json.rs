//! The JSON of a glTF file: what this exporter writes of the schema, and nothing else.
//!
//! Names follow the schema. Lists that are empty and values that are the schema's default are left out.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

/// A position in one of the lists of [`Root`].
pub(super) type Index = u32;

fn is_false(value: &bool) -> bool {
    !value
}

fn is_zero(value: &u64) -> bool {
    *value == 0
}

#[derive(Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Root {
    pub asset: AssetInfo,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub extensions_used: Vec<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scene: Option<Index>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub scenes: Vec<Scene>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<Node>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cameras: Vec<Camera>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<Mesh>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<Material>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub textures: Vec<Texture>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub images: Vec<Image>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub samplers: Vec<Sampler>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub animations: Vec<Animation>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub accessors: Vec<Accessor>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub buffer_views: Vec<BufferView>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub buffers: Vec<Buffer>,
    #[serde(skip_serializing_if = "RootExtensions::is_empty")]
    pub extensions: RootExtensions,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extras: Option<Value>,
}

#[derive(Debug, Default, Serialize)]
pub(super) struct AssetInfo {
    pub version: &'static str,
    pub generator: String,
}

#[derive(Debug, Default, Serialize)]
pub(super) struct RootExtensions {
    #[serde(rename = "KHR_lights_punctual", skip_serializing_if = "Option::is_none")]
    pub lights: Option<Lights>,
    #[serde(rename = "KHR_implicit_shapes", skip_serializing_if = "Option::is_none")]
    pub shapes: Option<Shapes>,
    #[serde(rename = "KHR_physics_rigid_bodies", skip_serializing_if = "Option::is_none")]
    pub physics: Option<PhysicsMaterials>,
}

impl RootExtensions {
    fn is_empty(&self) -> bool {
        self.lights.is_none() && self.shapes.is_none() && self.physics.is_none()
    }
}

#[derive(Debug, Default, Serialize)]
pub(super) struct Scene {
    pub nodes: Vec<Index>,
}

#[derive(Debug, Default, Serialize)]
pub(super) struct Node {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<Index>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<Index>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub translation: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<[f32; 4]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub children: Vec<Index>,
    #[serde(skip_serializing_if = "NodeExtensions::is_empty")]
    pub extensions: NodeExtensions,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extras: Option<Value>,
}

#[derive(Debug, Default, Serialize)]
pub(super) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual", skip_serializing_if = "Option::is_none")]
    pub light: Option<LightRef>,
    #[serde(rename = "KHR_physics_rigid_bodies", skip_serializing_if = "Option::is_none")]
    pub physics: Option<RigidBody>,
}

impl NodeExtensions {
    fn is_empty(&self) -> bool {
        self.light.is_none() && self.physics.is_none()
    }
}

#[derive(Debug, Serialize)]
pub(super) struct LightRef {
    pub light: Index,
}

// ---- meshes -----------------------------------------------------------------------------------------------------

#[derive(Debug, Default, Serialize)]
pub(super) struct Mesh {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    pub primitives: Vec<Primitive>,
}

#[derive(Debug, Serialize)]
pub(super) struct Primitive {
    /// Attribute name to accessor.
    pub attributes: BTreeMap<String, Index>,
    pub indices: Index,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<Index>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub targets: Vec<BTreeMap<&'static str, Index>>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: Index,
    #[serde(skip_serializing_if = "is_zero")]
    pub byte_offset: u64,
    pub component_type: u32,
    pub count: u64,
    #[serde(rename = "type")]
    pub kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<Vec<f32>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<Vec<f32>>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub buffer: Index,
    #[serde(skip_serializing_if = "is_zero")]
    pub byte_offset: u64,
    pub byte_length: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub byte_stride: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<u32>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uri: Option<String>,
    pub byte_length: u64,
}

// ---- materials --------------------------------------------------------------------------------------------------

#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Material {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    pub pbr_metallic_roughness: MetallicRoughness,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_texture: Option<NormalTexture>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub emissive_texture: Option<TextureInfo>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub emissive_factor: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alpha_mode: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alpha_cutoff: Option<f32>,
    #[serde(skip_serializing_if = "is_false")]
    pub double_sided: bool,
    #[serde(skip_serializing_if = "MaterialExtensions::is_empty")]
    pub extensions: MaterialExtensions,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extras: Option<Value>,
}

#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct MetallicRoughness {
    pub base_color_factor: [f32; 4],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_color_texture: Option<TextureInfo>,
    pub metallic_factor: f32,
    pub roughness_factor: f32,
}

#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_unlit", skip_serializing_if = "Option::is_none")]
    pub unlit: Option<Empty>,
    #[serde(rename = "KHR_materials_emissive_strength", skip_serializing_if = "Option::is_none")]
    pub emissive_strength: Option<EmissiveStrength>,
    #[serde(rename = "KHR_materials_specular", skip_serializing_if = "Option::is_none")]
    pub specular: Option<Specular>,
}

impl MaterialExtensions {
    fn is_empty(&self) -> bool {
        self.unlit.is_none() && self.emissive_strength.is_none() && self.specular.is_none()
    }
}

/// `{}`.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Empty {}

#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct EmissiveStrength {
    pub emissive_strength: f32,
}

#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Specular {
    pub specular_factor: f32,
    pub specular_color_factor: [f32; 3],
}

#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureInfo {
    pub index: Index,
    #[serde(skip_serializing_if = "is_first_set")]
    pub tex_coord: u32,
    #[serde(skip_serializing_if = "TextureExtensions::is_empty")]
    pub extensions: TextureExtensions,
}

#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct NormalTexture {
    pub index: Index,
    #[serde(skip_serializing_if = "is_first_set")]
    pub tex_coord: u32,
    pub scale: f32,
    #[serde(skip_serializing_if = "TextureExtensions::is_empty")]
    pub extensions: TextureExtensions,
}

fn is_first_set(set: &u32) -> bool {
    *set == 0
}

#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct TextureExtensions {
    #[serde(rename = "KHR_texture_transform", skip_serializing_if = "Option::is_none")]
    pub transform: Option<TextureTransform>,
}

impl TextureExtensions {
    fn is_empty(&self) -> bool {
        self.transform.is_none()
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct TextureTransform {
    pub offset: [f32; 2],
    pub rotation: f32,
    pub scale: [f32; 2],
}

#[derive(Debug, Serialize)]
pub(super) struct Texture {
    pub sampler: Index,
    pub source: Index,
}

#[derive(Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Image {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uri: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mime_type: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub buffer_view: Option<Index>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Sampler {
    pub mag_filter: u32,
    pub min_filter: u32,
    pub wrap_s: u32,
    pub wrap_t: u32,
}

// ---- animation --------------------------------------------------------------------------------------------------

#[derive(Debug, Default, Serialize)]
pub(super) struct Animation {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    pub channels: Vec<Channel>,
    pub samplers: Vec<AnimationSampler>,
}

#[derive(Debug, Serialize)]
pub(super) struct Channel {
    pub sampler: Index,
    pub target: ChannelTarget,
}

#[derive(Debug, Serialize)]
pub(super) struct ChannelTarget {
    pub node: Index,
    pub path: &'static str,
}

#[derive(Debug, Serialize)]
pub(super) struct AnimationSampler {
    pub input: Index,
    pub output: Index,
    pub interpolation: &'static str,
}

// ---- lights and cameras -----------------------------------------------------------------------------------------

#[derive(Debug, Serialize)]
pub(super) struct Lights {
    pub lights: Vec<Light>,
}

#[derive(Debug, Serialize)]
pub(super) struct Light {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    #[serde(rename = "type")]
    pub kind: &'static str,
    pub color: [f32; 3],
    pub intensity: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spot: Option<Spot>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extras: Option<Value>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Spot {
    pub inner_cone_angle: f32,
    pub outer_cone_angle: f32,
}

#[derive(Debug, Serialize)]
pub(super) struct Camera {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    #[serde(rename = "type")]
    pub kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub perspective: Option<Perspective>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orthographic: Option<Orthographic>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extras: Option<Value>,
}

#[derive(Debug, Serialize)]
pub(super) struct Perspective {
    pub yfov: f32,
    pub znear: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zfar: Option<f32>,
}

#[derive(Debug, Serialize)]
pub(super) struct Orthographic {
    pub xmag: f32,
    pub ymag: f32,
    pub znear: f32,
    pub zfar: f32,
}

// ---- physics ----------------------------------------------------------------------------------------------------

#[derive(Debug, Default, Serialize)]
pub(super) struct Shapes {
    pub shapes: Vec<Shape>,
}

/// A shape of `KHR_implicit_shapes`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub(super) enum Shape {
    Sphere { sphere: SphereShape },
    Box { r#box: BoxShape },
    Capsule { capsule: CapsuleShape },
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct SphereShape {
    pub radius: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct BoxShape {
    pub size: [f32; 3],
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct CapsuleShape {
    pub height: f32,
    pub radius_bottom: f32,
    pub radius_top: f32,
}

#[derive(Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct PhysicsMaterials {
    pub physics_materials: Vec<PhysicsMaterial>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct PhysicsMaterial {
    pub static_friction: f32,
    pub dynamic_friction: f32,
    pub restitution: f32,
}

#[derive(Debug, Default, Serialize)]
pub(super) struct RigidBody {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<RigidMotion>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub collider: Option<Collider>,
}

#[derive(Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct RigidMotion {
    #[serde(skip_serializing_if = "is_false")]
    pub is_kinematic: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<f32>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Collider {
    pub geometry: ColliderGeometry,
    pub physics_material: Index,
}

#[derive(Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ColliderGeometry {
    #[serde(skip_serializing_if = "is_false")]
    pub convex_hull: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<Index>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node: Option<Index>,
}
