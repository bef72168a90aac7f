//! Opening whatever file the user names: as an asset, or as a scene to draw.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use aam::{Document, Finding, Limits};
use aam_convert::{Asset, Format, ImportOptions, Progress};
use aam_scene::{
    BuildOptions, Built, Camera, FolderTextures, FoundTexture, NoTextures, Scene, SceneFile, Shading, TextureSource,
};

use crate::cli::{Axis, ReadArgs};
use crate::failure::Failure;

/// Extensions that can be opened.
pub(crate) const FORMATS: &str = ".aam .gltf .glb .obj .stl .ply .scene.toml";

/// A file as a scene.
pub(crate) struct OpenedScene {
    pub(crate) scene: Scene,
    /// What was odd on the way.
    pub(crate) warnings: Vec<Finding>,
    /// The camera to look through first, if the file names one.
    pub(crate) camera: Option<Camera>,
    /// Files that it came from, beside textures.
    pub(crate) sources: Vec<PathBuf>,
    /// Each document in it, and the node of its first object.
    pub(crate) documents: Vec<(Arc<Document>, usize)>,
}

/// The format of a file, for people.
pub(crate) fn format_name(path: &Path) -> &'static str {
    match Format::of(path) {
        Some(Format::Aam) => "AAM",
        Some(Format::Gltf) => "glTF",
        Some(Format::Glb) => "glTF binary",
        Some(Format::Obj) => "OBJ",
        Some(Format::Stl) => "STL",
        Some(Format::Ply) => "PLY",
        None => "unknown",
    }
}

/// How importers read, from the arguments.
pub(crate) fn import_options(args: &ReadArgs) -> ImportOptions {
    ImportOptions {
        animation: args.animation.clone(),
        frames_per_second: args.fps,
        allow_outside: args.allow_outside,
        up: args.up.map(|axis| match axis {
            Axis::Y => aam_scene::Up::Y,
            Axis::Z => aam_scene::Up::Z,
        }),
        limits: args.limits.limits(),
        ..ImportOptions::default()
    }
}

/// A file as an asset.
pub(crate) fn asset(path: &Path, options: &ImportOptions, progress: &dyn Progress) -> Result<Asset, Failure> {
    // Said before a format that cannot be guessed from nothing.
    std::fs::metadata(path).map_err(|error| Failure::io(path, "read", &error))?;
    if SceneFile::is_one(path) {
        return Err(Failure::new(format_args!(
            "{}: this needs one asset, and a scene file lists several",
            path.display()
        ))
        .help("`aam view` and `aam render` take scene files"));
    }
    Ok(aam_convert::import(path, options, progress)?)
}

/// A file as a scene: an asset, or what a scene file lists.
pub(crate) fn scene(path: &Path, args: &ReadArgs, progress: &dyn Progress) -> Result<OpenedScene, Failure> {
    if !SceneFile::is_one(path) {
        let part = part(path, args, progress)?;
        return Ok(OpenedScene {
            scene: part.scene,
            warnings: part.warnings,
            camera: None,
            sources: Vec::new(),
            documents: vec![(part.document, 0)],
        });
    }
    let file = SceneFile::read(path)?;
    let sources = file.asset_paths(path);
    // An asset that stands in several places is read once.
    let mut parts: BTreeMap<&Path, Part> = BTreeMap::new();
    for source in &sources {
        if !parts.contains_key(source.as_path()) {
            if SceneFile::is_one(source) {
                return Err(Failure::new(format_args!(
                    "{}: {} is a scene file itself",
                    path.display(),
                    source.display()
                ))
                .help("list its assets instead"));
            }
            parts.insert(source, part(source, args, progress)?);
        }
    }
    let used = || sources.iter().filter_map(|source| parts.get(source.as_path()));
    let mut first = 0;
    let mut documents = Vec::new();
    for part in used() {
        // Each asset hangs below a node of its own.
        documents.push((Arc::clone(&part.document), first + 1));
        first += 1 + part.scene.nodes.len();
    }
    let built = file.assemble(used().map(|part| part.scene.clone()).collect(), path);
    let mut warnings: Vec<Finding> = parts.values().flat_map(|part| part.warnings.iter().cloned()).collect();
    warnings.extend(built.warnings);
    Ok(OpenedScene { camera: file.active(&built.scene).cloned(), scene: built.scene, warnings, sources, documents })
}

/// The convex hulls of an asset's bodies as a scene, moved apart by `amount`.
pub(crate) fn exploded(
    path: &Path,
    args: &ReadArgs,
    amount: f32,
    progress: &dyn Progress,
) -> Result<OpenedScene, Failure> {
    let asset = asset(path, &import_options(args), progress)?;
    let document = aam_physics::exploded(&asset.document, amount).ok_or_else(|| {
        Failure::new(format_args!("{}: no body has convex hulls or simple shapes", path.display()))
            .help(format_args!("`aam decompose {} -o hulls.aam` makes some", path.display()))
    })?;
    let Built { scene, warnings } = aam_scene::build(&document, &NoTextures, &BuildOptions::default());
    Ok(OpenedScene { scene, warnings, camera: None, sources: Vec::new(), documents: vec![(Arc::new(document), 0)] })
}

/// One asset of a scene.
struct Part {
    scene: Scene,
    document: Arc<Document>,
    warnings: Vec<Finding>,
}

fn part(path: &Path, args: &ReadArgs, progress: &dyn Progress) -> Result<Part, Failure> {
    let asset = asset(path, &import_options(args), progress)?;
    progress.stage("loading textures", 0);
    let textures = Textures::new(&asset, path, args);
    let Built { mut scene, warnings } = aam_scene::build(&asset.document, &textures, &BuildOptions::default());
    scene.lights.extend(asset.lights);
    scene.cameras.extend(asset.cameras);
    if matches!(Format::of(path), Some(Format::Gltf | Format::Glb)) {
        scene.shading = Shading::Linear;
    }
    Ok(Part { scene, document: Arc::new(asset.document), warnings })
}

/// Writes what was changed in the scene of a file to its scene file, or to one beside an asset; gives its name.
pub(crate) fn save_scene(path: &Path, before: &Scene, after: &Scene, camera: &Camera) -> Result<PathBuf, Failure> {
    if SceneFile::is_one(path) {
        let mut file = SceneFile::read(path)?;
        file.record(before, after, camera);
        file.write(path)?;
        return Ok(path.to_owned());
    }
    let target = SceneFile::path_beside(path);
    let plain = SceneFile::of_asset(&target, path);
    let mut file = if target.exists() { SceneFile::read(&target)? } else { plain.clone() };
    if file.asset_paths(&target) != plain.asset_paths(&target) {
        return Err(Failure::new(format_args!("{} is there already and shows something else", target.display()))
            .help("open that file to change it, or rename it"));
    }
    // As the scene file sees it: below a node for the asset.
    let assembled = |scene: &Scene| {
        let mut assembled = plain.assemble(vec![scene.clone()], &target).scene;
        assembled.background = scene.background.clone();
        assembled.shadows = scene.shadows.clone().map(|shadows| shadows.below(1));
        assembled
    };
    file.record(&assembled(before), &assembled(after), camera);
    file.write(&target)?;
    Ok(target)
}

/// An asset's textures within limits; where it has none of a name, the file's folder says why.
pub(crate) struct Textures<'a> {
    asset: &'a Asset,
    folder: FolderTextures,
}

impl<'a> Textures<'a> {
    pub(crate) fn new(asset: &'a Asset, path: &Path, args: &ReadArgs) -> Self {
        let mut folder = FolderTextures::beside(path);
        folder.allow_outside = args.allow_outside;
        folder.limits = args.limits.limits();
        Self { asset, folder }
    }
}

impl TextureSource for Textures<'_> {
    fn find(&self, name: &str) -> Result<FoundTexture, String> {
        self.asset.find(name).or_else(|_| self.folder.find(name))
    }

    fn limits(&self) -> Limits {
        self.folder.limits()
    }
}
