//! AAM documents as glTF 2.0.
//!
//! | AAM | glTF |
//! |---|---|
//! | axes, Z up | (x, y, z) → (x, z, −y); v → 1 − v |
//! | objects, `Par`, names | nodes; objects in world coordinates get identity transforms |
//! | triangles | welded, indexed primitives, one for each material; `NORMAL` from smoothing groups or `N_List` |
//! | `C_List` | `COLOR_0`, decoded from sRGB |
//! | characters: `TM`, `Mir`, keys | translation, rotation, scale; sampled channels for what moves |
//! | `Full` frames | morph targets with normals, one-hot weights |
//! | materials, textures | see [`material`] |
//! | lights, cameras | see [`light`] |
//! | `PHYSICS` | see [`physics`] |
//! | all else | `extras`, see [`extras`] |

mod animation;
mod axes;
mod bake;
mod buffer;
mod container;
mod extras;
mod image;
mod json;
mod light;
mod material;
mod mesh;
mod model;
mod notes;
mod physics;
mod surface;
mod uv_transform;

use std::collections::BTreeMap;

use aam::Limits;
use aam::document::Flagged;
use aam::meaning::{has_local_coordinates, world_transforms};
use aam_scene::Aabb;
use glam::Vec3;

use crate::files::Files;
use crate::{Asset, ConvertError, TextureFile};

use buffer::Buffers;
use image::Images;
use json::{Animation, Buffer, Index, Node, Root, Sampler, Scene, Texture};
use model::{Model, subject_of};
use notes::Notes;

/// The two forms of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Container {
    /// `.gltf`, with a `.bin` and the textures beside it.
    Gltf,
    /// `.glb`, with everything inside.
    Glb,
}

/// The glTF file of an asset. `stem` is the file's name without extension.
///
/// # Errors
/// Positions that are not numbers, textures that cannot be read, or more data than the container holds.
pub(crate) fn export(asset: &Asset, stem: &str, container: Container, limits: &Limits) -> Result<Files, ConvertError> {
    let mut notes = Notes::default();
    let model = Model::of(&asset.document)?;
    let mut root = Root {
        asset: json::AssetInfo { version: "2.0", generator: concat!("aam ", env!("CARGO_PKG_VERSION")).to_owned() },
        ..Root::default()
    };
    let mut buffers = Buffers::default();
    let mut images = Images::new(asset, *limits);

    let materials = material::build(&model, &mut images, &mut notes)?;
    let material_of: Vec<(Index, bool)> =
        materials.iter().enumerate().map(|(index, material)| (index as Index, material.normal_map)).collect();
    root.materials = materials.into_iter().map(|material| material.material).collect();
    objects(&model, &material_of, &mut root, &mut buffers, &mut notes);
    physics::bodies(&model, &mut root, &mut buffers, &mut notes)?;
    let mut roots: Vec<Index> = (0..model.hierarchy.parents.len())
        .filter(|&object| model.hierarchy.parents[object].is_none())
        .map(|object| object as Index)
        .collect();
    roots.extend(light::lights(&asset.lights, center(&model), &mut root, &mut notes));
    roots.extend(light::cameras(&asset.cameras, &mut root, &mut notes));
    if !roots.is_empty() {
        root.scene = Some(0);
        root.scenes = vec![Scene { nodes: roots }];
    }
    root.extras = extras::of_document(&asset.document);
    report_losses(&model, &mut notes);

    finish(root, buffers, images, stem, container, notes)
}

/// Writes a node for each object, in their order, with meshes, parents and movement.
fn objects(
    model: &Model<'_>,
    material_of: &[(Index, bool)],
    root: &mut Root,
    buffers: &mut Buffers,
    notes: &mut Notes,
) {
    let mut animation = Animation { name: "animation".into(), ..Animation::default() };
    let mut morphing = Vec::new();
    let mut targets = 0;
    let rests = animation::sample(model, &mut animation, buffers, notes);
    for (index, (object, rest)) in model.document.objects().iter().zip(&rests).enumerate() {
        let mut node = Node {
            name: object.name.decoded(),
            translation: animation::translation(rest),
            rotation: animation::rotation(rest),
            scale: animation::scale(rest),
            extras: extras::of_object(object, index),
            ..Node::default()
        };
        if let Some(out) = mesh::build(model, index, material_of, buffers, notes) {
            node.mesh = Some(root.meshes.len() as Index);
            if out.targets > 0 {
                morphing.push(index as Index);
                targets = out.targets;
            }
            root.meshes.push(out.mesh);
        }
        root.nodes.push(node);
    }
    for (child, parent) in model.hierarchy.parents.iter().enumerate() {
        if let Some(parent) = parent {
            root.nodes[*parent].children.push(child as Index);
        }
    }
    animation::weights(model, &morphing, targets, &mut animation, buffers);
    if !animation.channels.is_empty() {
        root.animations.push(animation);
    }
}

/// The middle of the model in the world, in AAM's axes.
fn center(model: &Model<'_>) -> Vec3 {
    let world = world_transforms(model.document, &model.hierarchy, 0.0);
    let boxes = model.meshes.iter().zip(&world).filter_map(|(mesh, world)| mesh.bounds?.transformed(world));
    boxes.map(|bounds| Aabb { min: bounds.min, max: bounds.max }).fold(Aabb::EMPTY, |all, one| all.union(&one)).center()
}

/// Says what no part of the file holds.
fn report_losses(model: &Model<'_>, notes: &mut Notes) {
    for (object, mesh) in model.document.objects().iter().zip(&model.meshes) {
        let subject = subject_of(object);
        if matches!(object.skin, Flagged::Yes(_)) {
            notes.lost(&subject, "skin", "AAM says which bones pull a vertex but not from where; it is not exported");
        }
        if object.displacement.is_some() {
            notes.lost(&subject, "displacement", "glTF has none; TF, BI and SC stay in extras");
        }
        for finding in &mesh.findings {
            notes.changed(&subject, "triangles", finding.message.clone());
        }
        if object.node.is_some() && !has_local_coordinates(model.document) {
            notes.changed(&subject, "transform", "TM says nothing in a document of world coordinates");
        }
    }
    for finding in &model.hierarchy.findings {
        notes.changed(&finding.subject, "hierarchy", finding.message.clone());
    }
    let smooth = model.document.objects().iter().any(|object| object.faces.is_some());
    if smooth && model.document.geometry.smoothing_groups {
        notes.changed("", "smoothing groups", "the normals that they give are written");
    }
}

fn finish(
    mut root: Root,
    mut buffers: Buffers,
    images: Images<'_>,
    stem: &str,
    container: Container,
    notes: Notes,
) -> Result<Files, ConvertError> {
    let mut beside: BTreeMap<String, TextureFile> = BTreeMap::new();
    root.images = match container {
        Container::Glb => images.embedded(&mut buffers)?,
        Container::Gltf => {
            let (images, files) = images.beside();
            beside = files;
            images
        }
    };
    if !root.images.is_empty() {
        // Repeat, trilinear: what AAM's textures are.
        root.samplers = vec![Sampler { mag_filter: 9729, min_filter: 9987, wrap_s: 10497, wrap_t: 10497 }];
        root.textures = (0..root.images.len()).map(|source| Texture { sampler: 0, source: source as Index }).collect();
    }
    let (bytes, views, accessors) = buffers.finish();
    root.buffer_views = views;
    root.accessors = accessors;
    let bin = format!("{stem}.bin");
    if !bytes.is_empty() {
        let uri = (container == Container::Gltf).then(|| container::uri_of(&bin));
        root.buffers = vec![Buffer { uri, byte_length: bytes.len() as u64 }];
    }
    root.extensions_used = used(&root);
    let main = match container {
        Container::Glb => container::glb(&root, &bytes)?,
        Container::Gltf => {
            if !bytes.is_empty() {
                beside.insert(bin, TextureFile::InMemory(bytes.into()));
            }
            container::text(&root, true)?
        }
    };
    Ok(Files { main, beside, report: notes.into_report() })
}

/// The extensions that the file uses, in alphabetical order.
fn used(root: &Root) -> Vec<&'static str> {
    let materials = || root.materials.iter().map(|material| &material.extensions);
    let transforms = root.materials.iter().any(|material| {
        let infos = [&material.pbr_metallic_roughness.base_color_texture, &material.emissive_texture];
        let normal = material.normal_texture.as_ref().map(|texture| &texture.extensions);
        infos.into_iter().flatten().map(|info| &info.extensions).chain(normal).any(|used| used.transform.is_some())
    });
    let physics = root.nodes.iter().any(|node| node.extensions.physics.is_some());
    [
        ("KHR_implicit_shapes", root.extensions.shapes.is_some()),
        ("KHR_lights_punctual", root.extensions.lights.is_some()),
        ("KHR_materials_emissive_strength", materials().any(|used| used.emissive_strength.is_some())),
        ("KHR_materials_specular", materials().any(|used| used.specular.is_some())),
        ("KHR_materials_unlit", materials().any(|used| used.unlit.is_some())),
        ("KHR_physics_rigid_bodies", physics),
        ("KHR_texture_transform", transforms),
    ]
    .into_iter()
    .filter_map(|(name, used)| used.then_some(name))
    .collect()
}
