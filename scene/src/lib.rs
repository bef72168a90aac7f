//! What is to be drawn: nodes in a hierarchy, meshes, materials, textures, lights, cameras, environment; and the scene
//! file that lists them.
//!
//! A [`Scene`] is plain data without GPU handles, so that the renderer, the reference tracer, physics and tests share
//! it. Ids are positions in its lists. Conventions: right-handed, metres, [`Scene::up`] says which way is up; texture
//! coordinate v is 0 at the image's bottom row; colours and colour textures are sRGB-encoded, normal and displacement
//! maps are data.

mod build;
pub mod displacement;
mod environment;
mod file;
mod frames;
mod materials;
mod mesh;
mod pose;
mod shadow;
mod texture;
mod types;
mod weld;

pub use build::{BuildOptions, Built, build, object_nodes};
pub use displacement::{DisplacementError, DisplacementMode};
pub use environment::*;
pub use file::{
    AssetEntry, BackgroundEntry, EnvironmentEntry, LightEntry, MemberEntry, NodeEntry, SCENE_EXTENSION, SceneFile,
    SceneFileError, SceneSyntaxError, ShadowEntry, ShadowsEntry,
};
pub use shadow::*;
pub use texture::{FolderTextures, FoundTexture, NoTextures, TextureData, TextureSource, load_texture};
pub use types::*;
