//! Which shadows a picture has.

use std::fmt::Write;

use aam_reference::LightSize;
use aam_renderer::Show;
use aam_scene::{Scene, ShadowFilter, ShadowLayout, ShadowParameter, ShadowSettings, ShadowTechnique, Shadows, View};

use crate::args::{ShadowChoice, ShowArg};
use crate::failure::Failure;

/// Gives the scene the shadows that were chosen, for the GPU.
pub(crate) fn on_gpu(choice: Option<ShadowChoice>, scene: &mut Scene) -> Result<(), Failure> {
    match choice {
        None => {}
        Some(ShadowChoice::None) => scene.shadows = None,
        Some(ShadowChoice::Usual) if has_sources(scene) => {}
        Some(ShadowChoice::Usual) => scene.shadows = Some(Shadows::of_lights(scene, ShadowSettings::default())),
        Some(ShadowChoice::Technique(settings)) => scene.shadows = Some(Shadows::of_lights(scene, settings)),
        Some(ShadowChoice::Point | ShadowChoice::Area) => {
            return Err(Failure::new("the GPU engine does not trace shadows").help(
                "add --engine reference, or name a technique such as --shadows=pcf (--shadows=help lists them)",
            ));
        }
    }
    Ok(())
}

/// The shadows that the reference engine traces: those that were chosen, or of a file that has some. Light that bounces
/// has them always, since it would pass through walls without.
pub(crate) fn traced(choice: Option<ShadowChoice>, scene: &Scene, bounces: bool) -> Result<Option<LightSize>, Failure> {
    match choice {
        None => Ok((bounces || has_sources(scene)).then_some(LightSize::Area)),
        Some(ShadowChoice::None) if bounces => {
            Err(Failure::new("--bounces cannot be drawn with --shadows=none: light would pass through walls")
                .help("leave one of them out"))
        }
        Some(ShadowChoice::None) => Ok(None),
        Some(ShadowChoice::Usual | ShadowChoice::Area) => Ok(Some(LightSize::Area)),
        Some(ShadowChoice::Point) => Ok(Some(LightSize::Point)),
        Some(ShadowChoice::Technique(settings)) => {
            Err(Failure::new(format_args!("the reference engine traces shadows and has no technique {settings}"))
                .help("use --shadows=area or --shadows=point, or draw with --engine gpu"))
        }
    }
}

/// Where the shadows of a scene do not hold as they are set: all of it, or only what is not in the file's volumes.
pub(crate) fn limits(scene: &Scene, view: &View, all: bool) -> Vec<String> {
    let Some(shadows) = &scene.shadows else { return Vec::new() };
    let mut found = Vec::new();
    for (index, source) in shadows.sources.iter().enumerate().filter(|(_, source)| source.enabled) {
        let name = if source.name.is_empty() { (index + 1).to_string() } else { format!("{:?}", source.name) };
        let reasons = if all {
            aam_renderer::shadow_limits(scene, view, index).iter().map(|limit| limit.reason().to_owned()).collect()
        } else {
            Vec::from_iter(shadows.cut_casters(scene, source))
        };
        found.extend(reasons.into_iter().map(|reason| format!("shadow {name}: {reason}")));
    }
    found
}

/// What of the scene is drawn, on the GPU.
pub(crate) fn show(what: &ShowArg, scene: &Scene) -> Result<Show, Failure> {
    Ok(match what {
        ShowArg::Lit => Show::Lit,
        ShowArg::Normals => Show::Normals,
        ShowArg::Shadow(name) => Show::Shadow(source(scene, name.as_deref())?),
        ShowArg::Depth(name) => {
            let index = source(scene, name.as_deref())?;
            let technique = scene.shadows.as_ref().map(|shadows| shadows.sources[index].settings.technique);
            if technique.is_some_and(|technique| technique.filter == ShadowFilter::Volume) {
                return Err(Failure::new("shadow volumes have no map")
                    .help("name a technique that has one, such as --shadows=pcf"));
            }
            Show::ShadowMap(index)
        }
    })
}

/// The position of a shadow source of a scene by its name, or by its number from 1; without either of the first.
pub(crate) fn source(scene: &Scene, name: Option<&str>) -> Result<usize, Failure> {
    let sources = scene.shadows.as_ref().map_or(&[][..], |shadows| &shadows.sources);
    if sources.is_empty() {
        return Err(Failure::new("the scene has no shadow source")
            .help("add --shadows, which makes one for every light, or a [[shadow]] to the scene file"));
    }
    let Some(name) = name else { return Ok(0) };
    let exact = sources.iter().position(|source| source.name == name);
    let loose = || sources.iter().position(|source| source.name.eq_ignore_ascii_case(name));
    let numbered = || name.parse::<usize>().ok()?.checked_sub(1).filter(|index| *index < sources.len());
    exact.or_else(loose).or_else(numbered).ok_or_else(|| {
        let names: Vec<String> = (1..)
            .zip(sources)
            .map(|(number, source)| if source.name.is_empty() { number.to_string() } else { source.name.clone() })
            .collect();
        Failure::new(format_args!("there is no shadow source {name:?}"))
            .help(format_args!("there are {}", names.join(", ")))
    })
}

fn has_sources(scene: &Scene) -> bool {
    scene.shadows.as_ref().is_some_and(|shadows| shadows.sources.iter().any(|source| source.enabled))
}

/// Every technique and parameter, for people.
pub(crate) fn help() -> String {
    let mut text = String::from(
        "Shadows: --shadows=TECHNIQUE[:PARAMETER=VALUE,…], such as --shadows=evsm4:resolution=512,radius=5\n\n\
         Without a technique, the [[shadow]] entries of the scene file, or of every light pcf with one map; a light that\n\
         stands among what it lights gets a cube of six.\n\nTechniques:\n",
    );
    for filter in ShadowFilter::ALL.iter().copied() {
        let others: Vec<String> = ShadowTechnique::all()
            .into_iter()
            .filter(|technique| technique.filter == filter && technique.layout != ShadowLayout::One)
            .map(|technique| technique.to_string())
            .collect();
        let also = if others.is_empty() { String::new() } else { format!(" Also {}.", others.join(", ")) };
        let _ = writeln!(text, "  {:<8}{}{also}", filter.word(), filter.meaning());
    }
    text.push_str("\nLayouts:\n");
    for layout in ShadowLayout::ALL.iter().filter(|layout| **layout != ShadowLayout::One) {
        let _ = writeln!(text, "  {:<8}{}", format!("{layout}-"), layout.meaning());
    }
    text.push_str("\nParameters, each with its range, its usual value, and the techniques that have it:\n");
    for parameter in ShadowParameter::ALL {
        let _ = writeln!(text, "  {:<16}{}", parameter.key, parameter.meaning);
        let _ = writeln!(text, "  {:<16}{}; {}; {}", "", parameter.range, usual(parameter), who_has(parameter));
    }
    text.push_str(
        "\nReference engine: area (lights as large as the scene file says), point (lights are points).\n\
         none leaves out the shadows of the file.\n",
    );
    text
}

/// The value that a parameter has unless it is set.
fn usual(parameter: &ShadowParameter) -> String {
    let mut values: Vec<String> = ShadowTechnique::all()
        .into_iter()
        .filter(|technique| parameter.belongs_to(*technique))
        .map(|technique| parameter.get(&ShadowSettings::new(technique)))
        .collect();
    values.sort();
    values.dedup();
    format!("usually {}", values.join(" or "))
}

fn who_has(parameter: &ShadowParameter) -> String {
    let all = ShadowTechnique::all();
    let having = all.iter().filter(|technique| parameter.belongs_to(**technique));
    let layouts: Vec<ShadowLayout> = ShadowLayout::ALL
        .iter()
        .copied()
        .filter(|layout| all.iter().any(|technique| technique.layout == *layout && parameter.belongs_to(*technique)))
        .collect();
    let filters: Vec<&str> = ShadowFilter::ALL
        .iter()
        .filter(|filter| having.clone().any(|technique| technique.filter == **filter))
        .map(|filter| filter.word())
        .collect();
    let filters = if filters.len() == ShadowFilter::ALL.len() { "all".to_owned() } else { filters.join(", ") };
    match layouts[..] {
        [ShadowLayout::One] if ShadowLayout::ALL.len() > 1 => format!("{filters}, one map only"),
        [ShadowLayout::Cascades] => "all with cascades".into(),
        _ => filters,
    }
}
