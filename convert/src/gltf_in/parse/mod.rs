//! From JSON to [`Model`]: types, ranges and indices are checked here.

mod animation;
mod data;
mod material;
mod mesh;
mod node;

use super::fault::{Checked, Fault};
use super::json::At;
use super::model::Model;

/// Reads the whole JSON text.
pub(super) fn parse(root: &At<'_>) -> Checked<Model> {
    let counts = Counts::of(root)?;
    let mut model = Model {
        buffers: each(root, "buffers", data::buffer)?,
        views: each(root, "bufferViews", |at| data::view(at, &counts))?,
        accessors: each(root, "accessors", |at| data::accessor(at, &counts))?,
        images: each(root, "images", |at| data::image(at, &counts))?,
        samplers: each(root, "samplers", data::sampler)?,
        textures: each(root, "textures", |at| data::texture(at, &counts))?,
        materials: each(root, "materials", |at| material::material(at, &counts))?,
        meshes: each(root, "meshes", |at| mesh::mesh(at, &counts))?,
        skins: each(root, "skins", |at| node::skin(at, &counts))?,
        cameras: each(root, "cameras", node::camera)?,
        lights: match root.extension("KHR_lights_punctual") {
            Some(extension) => each(&extension, "lights", node::light)?,
            None => Vec::new(),
        },
        nodes: each(root, "nodes", |at| node::node(at, &counts))?,
        scenes: each(root, "scenes", |at| node::scene(at, &counts))?,
        scene: root.index_of("scene", counts.scenes, "scene")?,
        animations: each(root, "animations", |at| animation::animation(at, &counts))?,
    };
    if model.scene.is_none() && !model.scenes.is_empty() {
        model.scene = Some(0);
    }
    data::check_ranges(&model)?;
    Ok(model)
}

/// How long the file's lists are.
struct Counts {
    buffers: usize,
    views: usize,
    accessors: usize,
    images: usize,
    samplers: usize,
    textures: usize,
    materials: usize,
    meshes: usize,
    skins: usize,
    cameras: usize,
    lights: usize,
    nodes: usize,
    scenes: usize,
}

impl Counts {
    fn of(root: &At<'_>) -> Checked<Self> {
        let count = |key: &str| root.list(key).map(|items| items.len());
        Ok(Self {
            buffers: count("buffers")?,
            views: count("bufferViews")?,
            accessors: count("accessors")?,
            images: count("images")?,
            samplers: count("samplers")?,
            textures: count("textures")?,
            materials: count("materials")?,
            meshes: count("meshes")?,
            skins: count("skins")?,
            cameras: count("cameras")?,
            lights: match root.extension("KHR_lights_punctual") {
                Some(extension) => extension.list("lights")?.len(),
                None => 0,
            },
            nodes: count("nodes")?,
            scenes: count("scenes")?,
        })
    }
}

fn each<T>(at: &At<'_>, key: &str, read: impl Fn(&At<'_>) -> Checked<T>) -> Checked<Vec<T>> {
    at.list(key)?
        .iter()
        .map(|item| {
            item.object()?;
            read(item)
        })
        .collect()
}

fn name(at: &At<'_>) -> Checked<Option<String>> {
    Ok(at.text_of("name")?.map(str::to_owned).filter(|name| !name.trim().is_empty()))
}

/// Checks that the file is glTF 2.0.
pub(super) fn check_version(root: &At<'_>) -> Checked<()> {
    let asset = root.require("asset")?;
    let version = asset.require("version")?.text()?;
    let major = |version: &str| version.split('.').next().and_then(|major| major.parse::<u32>().ok());
    let needed = asset.text_of("minVersion")?.unwrap_or(version);
    match (major(version), major(needed)) {
        (None, _) => Err(asset.fault_of("version", format!("expected a version like \"2.0\", found {version:?}"))),
        (Some(2), Some(2)) if asset.get("minVersion").is_none() || needed == "2.0" => Ok(()),
        (Some(1), _) => Err(Fault::unsupported(
            format!("glTF version {version}"),
            "convert the file to glTF 2.0 first (`gltf-pipeline -i old.gltf -o new.gltf` does it)",
        )),
        _ => Err(Fault::unsupported(format!("glTF version {needed}"), "export the file as glTF 2.0")),
    }
}
