//! Opening whatever file the user names: as an asset, or as a scene to draw.

use std::path::{Path, PathBuf};

use aam::document::{Body, Primitive};
use aam::{Document, Finding};
use aam_convert::{Asset, Format, ImportOptions, Progress, Report};
use aam_scene::{BuildOptions, FolderTextures, FoundTexture, Scene, Shading, TextureLimits, TextureSource};
use glam::Vec3;

use crate::cli::{Axis, ReadArgs};
use crate::failure::Failure;

/// Extensions that can be opened.
pub(crate) const FORMATS: &str = ".aam .gltf .glb .obj .stl .ply .scene.toml";

/// A file as a scene.
pub(crate) struct OpenedScene {
    pub(crate) scene: Scene,
    /// What was odd on the way.
    pub(crate) warnings: Vec<Finding>,
    /// What an importer kept, changed and lost; empty for AAM.
    pub(crate) report: Report,
    /// It is a scene file, whose cameras are there to be looked through.
    pub(crate) is_scene_file: bool,
    /// Files that it came from, beside textures.
    pub(crate) sources: Vec<PathBuf>,
    /// Each document in it, and the node of its first object.
    pub(crate) documents: Vec<(Document, usize)>,
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
        max_file_size: args.max_file_size,
        max_texture_pixels: args.max_texture_pixels,
        ..ImportOptions::default()
    }
}

/// A file as an asset.
pub(crate) fn asset(path: &Path, options: &ImportOptions, progress: &dyn Progress) -> Result<Asset, Failure> {
    // Said before a format that cannot be guessed from nothing.
    std::fs::metadata(path).map_err(|error| Failure::io(path, "read", &error))?;
    Ok(aam_convert::import(path, options, progress)?)
}

/// A file as a scene.
pub(crate) fn scene(path: &Path, args: &ReadArgs, progress: &dyn Progress) -> Result<OpenedScene, Failure> {
    let asset = asset(path, &import_options(args), progress)?;
    progress.stage("loading textures", 0);
    let textures = Textures::new(&asset, path, args);
    let built = aam_scene::build(&asset.document, &textures, &BuildOptions::default());
    let mut scene = built.scene;
    scene.lights.extend(asset.lights);
    scene.cameras.extend(asset.cameras);
    if matches!(Format::of(path), Some(Format::Gltf | Format::Glb)) {
        scene.shading = Shading::Linear;
    }
    Ok(OpenedScene {
        scene,
        warnings: built.warnings,
        report: asset.report,
        is_scene_file: false,
        sources: Vec::new(),
        documents: vec![(asset.document, 0)],
    })
}

/// Writes what was changed in a window to the scene file; gives its name.
pub(crate) fn save_scene(path: &Path, scene: &Scene, camera: &aam_scene::Camera) -> Result<PathBuf, Failure> {
    let _ = (path, scene, camera);
    Err(Failure::new("not yet"))
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
        folder.limits = TextureLimits { max_pixels: args.max_texture_pixels, max_file_size: args.max_file_size };
        Self { asset, folder }
    }
}

impl TextureSource for Textures<'_> {
    fn find(&self, name: &str) -> Result<FoundTexture, String> {
        self.asset.find(name).or_else(|_| self.folder.find(name))
    }

    fn limits(&self) -> TextureLimits {
        self.folder.limits()
    }
}

/// The edges of a document's collision shapes: object (as position in frame 0) and lines in its coordinates.
pub(crate) fn collision_outlines(document: &Document) -> Vec<(usize, Vec<[Vec3; 2]>)> {
    let bodies = document.physics.iter().flat_map(|physics| &physics.bodies);
    bodies
        .filter_map(|body| {
            let object = document.objects().iter().position(|object| object.id == body.object)?;
            Some(body_outlines(body).map(move |segments| (object, segments)))
        })
        .flatten()
        .collect()
}

fn body_outlines(body: &Body) -> impl Iterator<Item = Vec<[Vec3; 2]>> {
    let pieces = body.pieces.iter().flatten().map(|piece| {
        let point = |index: u32| piece.vertices.get(index as usize).copied().map(Vec3::from_array);
        let mut edges: Vec<[u32; 2]> = piece
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        edges.into_iter().filter_map(|[a, b]| Some([point(a)?, point(b)?])).collect()
    });
    pieces.chain(body.primitives.iter().flatten().map(primitive_outline))
}

fn primitive_outline(primitive: &Primitive) -> Vec<[Vec3; 2]> {
    match *primitive {
        Primitive::Box { center, orientation, half } => {
            let turn = glam::Quat::from_array(orientation);
            let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { glam::Quat::IDENTITY };
            let corner = |bits: u8| {
                let sign = |bit: u8| if bits & bit == 0 { -1.0 } else { 1.0 };
                Vec3::from_array(center) + turn * (Vec3::from_array(half) * Vec3::new(sign(1), sign(2), sign(4)))
            };
            let edges = (0..8_u8).flat_map(|bits| [1, 2, 4].map(|bit| (bits, bit)));
            edges.filter(|(bits, bit)| bits & bit == 0).map(|(bits, bit)| [corner(bits), corner(bits | bit)]).collect()
        }
        Primitive::Sphere { center, radius } => {
            let axes = [(Vec3::X, Vec3::Y), (Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::X)];
            axes.into_iter().flat_map(|(a, b)| arc(center.into(), radius * a, radius * b, 1.0)).collect()
        }
        Primitive::Capsule { a, b, radius } => {
            let (a, b) = (Vec3::from_array(a), Vec3::from_array(b));
            let along = (b - a).normalize_or(Vec3::Z);
            let (side, other) = along.any_orthonormal_pair();
            let (side, other, along) = (radius * side, radius * other, radius * along);
            let mut lines = Vec::new();
            for (end, out) in [(a, -along), (b, along)] {
                lines.extend(arc(end, side, other, 1.0));
                lines.extend(arc(end, side, out, 0.5));
                lines.extend(arc(end, other, out, 0.5));
            }
            lines.extend([side, -side, other, -other].map(|offset| [a + offset, b + offset]));
            lines
        }
    }
}

/// Part of a circle from `center + a` through `center + b`.
fn arc(center: Vec3, a: Vec3, b: Vec3, turns: f32) -> impl Iterator<Item = [Vec3; 2]> {
    const STEPS: u16 = 48;
    let steps = (f32::from(STEPS) * turns) as u16;
    let point = move |step: u16| {
        let (sin, cos) = (f32::from(step) / f32::from(STEPS) * std::f32::consts::TAU).sin_cos();
        center + a * cos + b * sin
    };
    (0..steps).map(move |step| [point(step), point(step + 1)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outline(primitive: Primitive) -> Vec<[Vec3; 2]> {
        primitive_outline(&primitive)
    }

    #[test]
    fn outlines_lie_on_the_shapes() {
        let ball = outline(Primitive::Sphere { center: [1.0, 2.0, 3.0], radius: 2.0 });
        assert_eq!(ball.len(), 3 * 48);
        assert!(ball.iter().flatten().all(|p| (p.distance(Vec3::new(1.0, 2.0, 3.0)) - 2.0).abs() < 1e-4));
        let cube =
            outline(Primitive::Box { center: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0], half: [1.0, 2.0, 3.0] });
        assert_eq!(cube.len(), 12);
        assert!(cube.iter().flatten().all(|p| p.abs() == Vec3::new(1.0, 2.0, 3.0)));
        let (a, b) = (Vec3::ZERO, Vec3::new(0.0, 0.0, 2.0));
        let pill = outline(Primitive::Capsule { a: a.into(), b: b.into(), radius: 0.5 });
        let distance = |p: &Vec3| p.distance(Vec3::new(0.0, 0.0, p.z.clamp(0.0, 2.0)));
        assert!(pill.iter().flatten().all(|p| (distance(p) - 0.5).abs() < 1e-5));
    }
}
