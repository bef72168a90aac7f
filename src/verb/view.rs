//! `aam view`: a window.

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use aam_convert::{Format, Progress};
use aam_physics::physics_meshes;
use aam_renderer::Msaa;
use aam_scene::{NodeId, SceneFile};
use aam_view::{Opened, Opener, Options, Outline, Saver, ViewError};

use crate::cli::{ReadArgs, ViewArgs};
use crate::demo::Demo;
use crate::failure::Failure;
use crate::terminal::Terminal;
use crate::verb::render::warning_text;
use crate::{open, outlines};

pub(crate) fn run(args: &ViewArgs, _terminal: &Terminal) -> Result<ExitCode, Failure> {
    for file in &args.files {
        // Said here, where it can be mended, rather than in a window.
        let meta = std::fs::metadata(file).map_err(|error| Failure::io(file, "read", &error))?;
        if meta.is_dir() {
            return Err(
                Failure::new(format_args!("{}: cannot read: it is a folder", file.display())).help("name a file in it")
            );
        }
        if Format::of(file).is_none() && !SceneFile::is_one(file) {
            return Err(Failure::new(format_args!("{}: unknown format", file.display()))
                .help(format_args!("known extensions are {}", open::FORMATS)));
        }
    }
    let demo = args.demo.then(Demo::unpack).transpose()?;
    let read = Arc::new(args.read.clone());
    let opener: Opener = Arc::new(move |path: &Path, stage: &dyn Fn(&str)| opened(path, &read, stage));
    let saver: Saver = Arc::new(|path, before, after, camera| {
        open::save_scene(path, before, after, camera).map_err(|failure| failure.text())
    });
    let samples = args.msaa.parse::<u32>().unwrap_or_default();
    let options = Options {
        files: demo.as_ref().map_or_else(|| args.files.clone(), Demo::scenes),
        size: [args.size.width, args.size.height],
        msaa: Msaa::try_from(samples).map_err(Failure::new)?,
        opener,
        saver,
        formats: open::FORMATS.into(),
    };
    aam_view::run(&options).map_err(|error| match &error {
        ViewError::NoDisplay { reason } => Failure::new(format_args!("no window can be opened: {reason}"))
            .help("`aam render FILE -o picture.png` draws without one"),
        ViewError::Gpu(gpu) => {
            Failure::new(gpu).help("`aam render FILE -o picture.png --engine reference` draws without a GPU")
        }
        ViewError::Lost(_) => Failure::new(&error),
    })?;
    Ok(ExitCode::SUCCESS)
}

/// Tells the window what is being done.
struct Stages<'a>(&'a dyn Fn(&str));

impl Progress for Stages<'_> {
    fn stage(&self, name: &str, _total: u64) {
        (self.0)(name);
    }

    fn step(&self, _done: u64) {}
}

fn opened(path: &Path, read: &ReadArgs, stage: &dyn Fn(&str)) -> Result<Opened, String> {
    let opened = open::scene(path, read, &Stages(stage)).map_err(|failure| failure.text())?;
    let outlines = opened.documents.iter().flat_map(|(document, first)| {
        // Nodes stand parents first, which objects need not.
        let nodes = aam_scene::object_nodes(document);
        outlines::of(document).into_iter().filter_map(move |outline| {
            let node = NodeId(u32::try_from(first + nodes.get(outline.object)?.index()).ok()?);
            Some(Outline { node, segments: outline.segments, triangles: outline.triangles })
        })
    });
    let mut warnings: Vec<String> = opened.warnings.iter().map(warning_text).collect();
    let mut bodies = Vec::new();
    for (document, first) in &opened.documents {
        let nodes = aam_scene::object_nodes(document);
        let (meshes, odd) = physics_meshes(document);
        warnings.extend(odd.iter().map(warning_text));
        let node = |object: usize| u32::try_from(first + nodes.get(object)?.index()).ok().map(NodeId);
        bodies.extend(meshes.into_iter().filter_map(|(object, mesh)| Some((node(object)?, mesh))));
    }
    Ok(Opened {
        outlines: outlines.collect(),
        bodies,
        camera: opened.camera,
        sources: opened.sources,
        warnings,
        scene: opened.scene,
    })
}
