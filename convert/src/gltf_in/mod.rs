//! glTF 2.0 in: `.gltf` with external or embedded buffers, and `.glb`.
//!
//! The way through: `container` finds the parts of the file, `json` and `parse` make a `model` with every index
//! and range checked, `accessor` and `primitive` decode geometry, `material` maps materials and `texture` and
//! `bake` make their textures, `surface` joins and welds a mesh, `stage` decides between the three forms of a
//! document and `assemble` makes it. Axes turn from Y up to Z up, and texture coordinates from v down to v up.
//!
//! Nothing in the file is trusted: sizes are checked against the bytes that are there, and products of counts against
//! `limits`, before anything is allocated; nodes are walked without recursion; files are read in the asset's folder
//! alone unless the options say otherwise.

mod accessor;
mod assemble;
mod bake;
mod buffers;
mod character;
mod clip;
mod container;
mod extensions;
mod fault;
mod graph;
mod json;
mod limits;
mod log;
mod material;
mod model;
mod names;
mod normals;
mod outfit;
mod palette;
mod parse;
mod pose;
mod primitive;
mod stage;
mod surface;
mod texture;
mod uri;
mod usage;
mod uv_transform;

#[cfg(test)]
mod tests;

use std::path::Path;
use std::sync::Arc;

use crate::{Asset, ConvertError, ImportOptions, Progress};

use accessor::Reader;
use assemble::Assembly;
use buffers::Buffers;
use clip::Clip;
use fault::{Checked, Fault};
use graph::Graph;
use json::At;
use log::Log;
use material::Mapped;
use model::{Material, Model};
use palette::Palette;
use primitive::Primitive;
use stage::{Form, Moment};
use surface::Surface;
use texture::Textures;

/// Reads the bytes of a glTF 2.0 file, JSON or GLB; which of the two, its first bytes say. The files that they name are
/// sought in the folder of `path`.
///
/// Static scenes become `AAM_MESH` in world coordinates. A clip that moves nodes as wholes makes `AAM_CHARACTER` with
/// sampled keys (so does [`ImportOptions::hierarchy`], without keys), one that bends a skin or a morph makes
/// `AAM_MESH_MULTIFRAME`. [`Asset::report`] says what was kept, changed and lost.
///
/// # Errors
/// [`ConvertError::Broken`] with a JSON pointer or byte offset where the file contradicts itself,
/// [`ConvertError::Unsupported`] where it needs an extension that is not here, [`ConvertError::Option`] where an option
/// does not fit the file, [`ConvertError::File`] where a file cannot be read.
pub(crate) fn import(
    bytes: Vec<u8>,
    path: &Path,
    options: &ImportOptions,
    progress: &dyn Progress,
) -> Result<Asset, ConvertError> {
    run(bytes, path, options, progress).map_err(|fault| fault.into_error(path))
}

fn run(bytes: Vec<u8>, path: &Path, options: &ImportOptions, progress: &dyn Progress) -> Checked<Asset> {
    let rate = options.frames_per_second;
    if !(rate.is_finite() && rate > 0.0) {
        return Err(ConvertError::Option(format!("--fps {rate}: frames a second must be more than 0")).into());
    }
    let mut log = Log::default();
    let file = Arc::new(bytes);
    let container = container::open(&file)?;
    for oddity in &container.oddities {
        log.changed("", "GLB container", oddity, None);
    }
    let text = file.get(container.json.clone()).unwrap_or(&[]);
    let value: serde_json::Value = serde_json::from_slice(text).map_err(|error| {
        Fault::broken(format!("line {} column {}", error.line(), error.column()), format!("no JSON: {error}"))
    })?;
    let root = At::root(&value);
    parse::check_version(&root)?;
    extensions::check(&root, &mut log)?;
    let model = parse::parse(&root)?;
    drop(value);
    let folder = path.parent().unwrap_or(Path::new(""));
    let buffers = Buffers::load(&model, &file, container.binary, folder, options)?;
    let reader = Reader { model: &model, buffers: &buffers };
    let graph = Graph::of(&model)?;
    report_scenes(&model, &graph, &mut log);

    let mut moment = Moment::rest(&model, &graph)?;
    let clip = clip::find(reader, options, &mut log)?;
    let form = form(&model, &graph, &moment, clip.as_ref(), options, &mut log);
    let frames =
        clip.as_ref().filter(|_| form != Form::Static).map_or(Ok(1), |clip| clip.frames(rate, &options.limits))?;
    let size = file.len().saturating_add(buffers.bytes());
    stage::check_size(&model, &graph, form, frames, clip.as_ref(), &options.limits, size)?;

    let mut asset = Asset::default();
    let meshes = decode(reader, &graph, options.keep_uvs, &mut log, progress)?;
    let (mapped, names) = materials(&model, &buffers, &meshes, path, options, &mut asset, &mut log, progress)?;
    let surfaces = join(&model, meshes, &mapped, options.keep_uvs, &mut log);
    let mesh_names: Vec<String> = (0..model.meshes.len()).map(|mesh| mesh_name(&model, mesh)).collect();

    let mut start = moment.clone();
    if let Some(clip) = clip.as_ref().filter(|_| form != Form::Static) {
        start.go_to(0.0, clip, &graph);
        start.check(&model)?;
    }
    if form == Form::Full {
        moment = start.clone();
    }
    let assembly = Assembly {
        model: &model,
        graph: &graph,
        surfaces: &surfaces,
        palette: Palette::of(&mapped, &names, &surfaces, &mesh_names),
        inverse_binds: pose::inverse_binds(reader)?,
        clip: clip.as_ref(),
        frames,
        form,
        options,
    };
    let bounds = assembly.document(&mut moment, &mut asset, &mut log, progress)?;
    outfit::add(&model, &graph, &start, clip.as_ref(), bounds, &mut asset, &mut log);
    asset.report = log.into_report();
    Ok(asset)
}

/// The form of the document, with what must be said of it.
fn form(
    model: &Model,
    graph: &Graph,
    moment: &Moment,
    clip: Option<&Clip>,
    options: &ImportOptions,
    log: &mut Log,
) -> Form {
    let mut form = stage::form(model, graph, moment, clip, options.hierarchy);
    if let Some(clip) = clip {
        if form == Form::Character && character::needs_frames(model, graph, moment, clip) {
            let note = "a moving node hangs below one that shears, which keys cannot say; written frame by frame";
            log.changed("", "animation", note, None);
            form = Form::Full;
        }
        if form == Form::Static {
            log.lost(&format!("animation {:?}", clip.name), "animation", "it moves nothing that is drawn");
        }
    }
    if form == Form::Full && options.hierarchy {
        let note = "a document of vertices frame by frame is in world coordinates; --hierarchy has no effect";
        log.lost("", "hierarchy", note);
    }
    form
}

fn report_scenes(model: &Model, graph: &Graph, log: &mut Log) {
    for (number, scene) in model.scenes.iter().enumerate().filter(|(number, _)| Some(*number) != model.scene) {
        let name = scene.name.clone().unwrap_or_else(|| number.to_string());
        log.lost(&format!("scene {name:?}"), "scene", "a document holds one; the file's default scene was taken");
    }
    if graph.false_roots > 0 {
        let note = format!("{} nodes that the scene lists have parents; they stand without them", graph.false_roots);
        log.changed("", "scene", note, None);
    }
    if graph.hidden > 0 {
        log.lost("", "hidden nodes", format!("{} nodes that the file hides are not in the document", graph.hidden));
    }
    if model.materials.iter().any(|material| !material.double_sided) {
        let count = model.materials.iter().filter(|material| !material.double_sided).count();
        let note = format!("{count} of {}; AAM draws both sides of every face", model.materials.len());
        log.changed("", "single-sided materials", note, None);
    }
}

fn mesh_name(model: &Model, mesh: usize) -> String {
    model.meshes[mesh].name.clone().unwrap_or_else(|| format!("mesh {mesh}"))
}

/// Decodes the meshes that the scene shows.
fn decode(
    reader: Reader<'_>,
    graph: &Graph,
    keep_uvs: bool,
    log: &mut Log,
    progress: &dyn Progress,
) -> Checked<Vec<Option<Vec<Primitive>>>> {
    let model = reader.model;
    let mut shown = vec![false; model.meshes.len()];
    for mesh in graph.scene.iter().filter_map(|&node| model.nodes[node].mesh) {
        shown[mesh] = true;
    }
    progress.stage("decoding meshes", model.meshes.len() as u64);
    let mut meshes = Vec::new();
    for (number, mesh) in model.meshes.iter().enumerate() {
        let subject = format!("mesh {:?}", mesh_name(model, number));
        if !shown[number] {
            meshes.push(None);
            continue;
        }
        let mut primitives = Vec::new();
        for primitive in &mesh.primitives {
            let mut sets = primitive.material.map_or_else(Vec::new, |at| material::sets(&model.materials[at]));
            if keep_uvs && !sets.contains(&0) {
                sets.push(0);
            }
            primitives.extend(primitive::decode(reader, primitive, &sets, &subject, log)?);
        }
        meshes.push((!primitives.is_empty()).then_some(primitives));
        progress.step(number as u64 + 1);
    }
    Ok(meshes)
}

/// Maps all materials, and last the default one; with their names.
#[expect(clippy::too_many_arguments, reason = "a step of one function, not an interface")]
fn materials(
    model: &Model,
    buffers: &Buffers,
    meshes: &[Option<Vec<Primitive>>],
    path: &Path,
    options: &ImportOptions,
    asset: &mut Asset,
    log: &mut Log,
    progress: &dyn Progress,
) -> Checked<(Vec<Mapped>, Vec<String>)> {
    progress.stage("materials and textures", model.materials.len() as u64);
    let mut textures = Textures::find(model, buffers, path, options, log)?;
    let mut users: Vec<Vec<&Primitive>> = vec![Vec::new(); model.materials.len() + 1];
    for primitive in meshes.iter().flatten().flatten() {
        users[primitive.material.unwrap_or(model.materials.len())].push(primitive);
    }
    let default = Material::default();
    let mut mapped = Vec::new();
    let mut names = Vec::new();
    for (number, material) in model.materials.iter().chain([&default]).enumerate() {
        let name = match &material.name {
            Some(name) => name.clone(),
            None if number == model.materials.len() => "default".into(),
            None => format!("material {number}"),
        };
        let subject = format!("material {name:?}");
        mapped.push(material::map(material, &subject, &users[number], &mut textures, log)?);
        names.push(name);
        progress.step(number as u64 + 1);
    }
    asset.textures = textures.into_files();
    Ok((mapped, names))
}

fn join(
    model: &Model,
    meshes: Vec<Option<Vec<Primitive>>>,
    mapped: &[Mapped],
    keep_uvs: bool,
    log: &mut Log,
) -> Vec<Option<Surface>> {
    meshes
        .into_iter()
        .enumerate()
        .map(|(number, primitives)| {
            let subject = format!("mesh {:?}", mesh_name(model, number));
            primitives.map(|primitives| Surface::join(primitives, mapped, keep_uvs, &subject, log))
        })
        .collect()
}
