//! Light from all around, from the arguments.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use aam::Limits;
use aam_scene::{
    Background, CubeFace, Environment, EnvironmentMap, EnvironmentPictures, FoundTexture, Scene, Shading,
    SpecularFilter, TextureData, ToneMap, load_environment,
};

use crate::cli::{EnvironmentArgs, EnvironmentLight, ReflectionFilter, ToneMapping};
use crate::failure::Failure;
use crate::terminal::Terminal;

/// What stands for a face's name in a pattern.
const FACE: &str = "{face}";

/// Puts what the arguments say about light into a scene.
pub(crate) fn apply(
    args: &EnvironmentArgs,
    scene: &mut Scene,
    limits: &Limits,
    terminal: &Terminal,
) -> Result<(), Failure> {
    if let Some(path) = &args.environment {
        let map = load(path, limits)?;
        for note in map.notes() {
            terminal.warning(format_args!("{}: {note}", path.display()));
        }
        scene.environment = Some(Environment::new(Arc::new(map)));
        scene.background = Background::Environment;
    }
    let wanted = args.environment_light.is_some()
        || args.environment_filter.is_some()
        || args.environment_rotation.is_some()
        || args.environment_intensity.is_some();
    match &mut scene.environment {
        Some(environment) => {
            if let Some(light) = args.environment_light {
                environment.diffuse = matches!(light, EnvironmentLight::Both | EnvironmentLight::Diffuse);
                environment.specular = matches!(light, EnvironmentLight::Both | EnvironmentLight::Specular);
            }
            if let Some(filter) = args.environment_filter {
                environment.filter = Some(match filter {
                    ReflectionFilter::Mirror => SpecularFilter::Mirror,
                    ReflectionFilter::Phong => SpecularFilter::Phong,
                });
            }
            if let Some(degrees) = args.environment_rotation {
                environment.rotation = degrees.to_radians();
            }
            if let Some(intensity) = args.environment_intensity {
                environment.intensity = intensity;
            }
        }
        None if wanted => {
            return Err(Failure::new("the scene has no environment that could be changed")
                .help("name its picture: --environment FILE"));
        }
        None => {}
    }
    if let Some(stops) = args.exposure {
        scene.exposure = stops;
    }
    if let Some(tone_map) = args.tone_map {
        scene.tone_map = match tone_map {
            ToneMapping::Clamp => ToneMap::Clamp,
            ToneMapping::Reinhard => ToneMap::Reinhard,
            ToneMapping::Aces => ToneMap::Aces,
            ToneMapping::Neutral => ToneMap::Neutral,
        };
    }
    Ok(())
}

/// Says what may surprise: values that are linear are shown as they are.
pub(crate) fn tell(args: &EnvironmentArgs, scene: &Scene, terminal: &Terminal) {
    let linear = scene.environment.as_ref().is_some_and(|environment| environment.map.is_linear());
    if args.environment.is_some() && linear && scene.shading == Shading::Source {
        terminal.note(
            "light is computed on stored values, as the source did, so the environment looks dark; --shading linear encodes it",
        );
    }
}

fn load(path: &Path, limits: &Limits) -> Result<EnvironmentMap, Failure> {
    let text = path.to_string_lossy();
    let pictures = if text.contains(FACE) {
        EnvironmentPictures::Faces(Box::new(faces(&text)?.map(found)))
    } else {
        std::fs::metadata(path).map_err(|error| Failure::io(path, "read", &error))?;
        EnvironmentPictures::One(found(path.to_owned()))
    };
    load_environment(&pictures, limits).map_err(|reason| {
        Failure::new(format_args!("{}: {reason}", path.display())).help(
            "an environment is a panorama (2:1), the cross of a cube (4:3 or 3:4), or six files such as sky_{face}.png",
        )
    })
}

/// The six files of a pattern, by the names of faces or by those of their axes.
fn faces(pattern: &str) -> Result<[PathBuf; 6], Failure> {
    let axes = ["px", "nx", "py", "ny", "pz", "nz"];
    let named = |names: [&str; 6]| names.map(|name| PathBuf::from(pattern.replace(FACE, name)));
    let (by_name, by_axis) = (named(CubeFace::ALL.map(CubeFace::name)), named(axes));
    let there = |paths: &[PathBuf; 6]| paths.iter().filter(|path| path.is_file()).count();
    let paths = if there(&by_axis) > there(&by_name) { by_axis } else { by_name };
    match paths.iter().find(|path| !path.is_file()) {
        None => Ok(paths),
        Some(missing) => Err(Failure::new(format_args!("{}: there is no such file", missing.display()))
            .help("{face} stands for right, left, up, down, front and back, or for px, nx, py, ny, pz and nz")),
    }
}

fn found(path: PathBuf) -> FoundTexture {
    FoundTexture { key: path.to_string_lossy().into_owned(), data: TextureData::OnDisk(path) }
}
