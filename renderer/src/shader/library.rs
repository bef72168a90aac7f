//! The shader files, and the programs that are made of them.

use super::assemble::{Features, ShaderError, assemble};
use aam_scene::ShadowFilter;

use super::variant::Variant;
use crate::lights::MAX_LIGHTS;
use crate::shadows;

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../../shaders/", $name, ".wgsl")))),*]
    };
}

/// Every file of `shaders/`, by name.
const FILES: &[(&str, &str)] = files![
    "background",
    "color",
    "displace",
    "environment",
    "frame",
    "fullscreen",
    "heights",
    "interpolate",
    "lights",
    "material",
    "node",
    "overlay",
    "phong",
    "present",
    "relief",
    "shadow",
    "shadow_blur",
    "shadow_caster",
    "shadow_compare",
    "shadow_extrude",
    "shadow_map",
    "shadow_mask",
    "shadow_moments",
    "shadow_running_blur",
    "shadow_volume",
    "shadow_warp",
    "sky",
    "surface",
    "tessellation",
    "tone_map",
];

/// A shader program: a root file and the features that hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Program {
    /// A mesh subset.
    Surface(Variant),
    /// The edges of a mesh.
    Edges { linear: bool },
    /// The normals of a mesh.
    Normals { linear: bool },
    /// Lines or triangles in world coordinates; `nudge` brings them in front of what they lie on.
    Shape { linear: bool, nudge: bool },
    /// Points of a tessellated surface: where displacement moves them, and the `normals` there.
    Displace { normals: bool },
    /// Another attribute of a mesh at the points of a tessellated surface.
    Interpolate,
    /// A caster in a shadow map.
    Caster(shadows::Caster),
    /// A pass of the blur of a shadow map.
    Blur,
    /// A shadow map as a picture.
    ShadowMap(shadows::MapKind),
    /// A pass of the blur whose cost does not grow with the radius.
    RunningBlur(ShadowFilter),
    /// The volume that a caster shades.
    Extrude,
    /// The pixels that are in no volume.
    Mask,
    /// A background picture.
    Background { encode: bool },
    /// The environment as background.
    Sky,
    /// The last pass, into a target that could not be drawn to directly.
    Present { encode: bool, decode: bool, premultiply: bool },
}

impl Program {
    fn root(&self) -> &'static str {
        match self {
            Self::Surface(_) => "surface",
            Self::Edges { .. } | Self::Normals { .. } | Self::Shape { .. } => "overlay",
            Self::Displace { .. } => "displace",
            Self::Interpolate => "interpolate",
            Self::Caster(_) => "shadow_caster",
            Self::Blur => "shadow_blur",
            Self::ShadowMap(_) => "shadow_map",
            Self::RunningBlur(_) => "shadow_running_blur",
            Self::Extrude => "shadow_extrude",
            Self::Mask => "shadow_mask",
            Self::Background { .. } => "background",
            Self::Sky => "sky",
            Self::Present { .. } => "present",
        }
    }

    fn features(&self) -> Features {
        let overlay = |node: bool, normals: bool, nudge: bool, linear: bool| {
            vec![("NODE", node), ("NODE_NORMALS", normals), ("RECEIVERS", false), ("NUDGE", nudge), ("LINEAR", linear)]
        };
        match *self {
            Self::Surface(variant) => variant.features(),
            Self::Edges { linear } => overlay(true, false, true, linear),
            Self::Normals { linear } => overlay(true, true, true, linear),
            Self::Shape { linear, nudge } => overlay(false, false, nudge, linear),
            Self::Displace { normals } => vec![("NORMALS", normals)],
            Self::Interpolate => Vec::new(),
            Self::Caster(caster) => caster.features(),
            Self::ShadowMap(kind) => kind.features(),
            Self::RunningBlur(filter) => vec![
                ("ESM", filter == ShadowFilter::Esm),
                ("VSM", filter == ShadowFilter::Vsm),
                ("EVSM2", filter == ShadowFilter::Evsm2),
            ],
            Self::Extrude => vec![("NODE_NORMALS", false), ("RECEIVERS", false)],
            Self::Blur | Self::Mask => Vec::new(),
            Self::Background { encode } => vec![("ENCODE", encode)],
            Self::Sky => Vec::new(),
            Self::Present { encode, decode, premultiply } => {
                vec![("ENCODE", encode), ("DECODE", decode), ("PREMULTIPLY", premultiply)]
            }
        }
    }
}

/// Every shader that a picture can ask for: what it is, and its WGSL.
///
/// # Errors
/// A shader file that cannot be assembled: a fault of this program.
pub fn shader_sources() -> Result<Vec<(String, String)>, ShaderError> {
    all_programs().iter().map(|program| Ok((format!("{program:?}"), source(program)?))).collect()
}

/// Every legal program, in a fixed order.
fn all_programs() -> Vec<Program> {
    let mut programs: Vec<Program> = Variant::all().into_iter().map(Program::Surface).collect();
    for linear in [false, true] {
        programs.extend([Program::Edges { linear }, Program::Normals { linear }]);
        programs.extend([false, true].map(|nudge| Program::Shape { linear, nudge }));
    }
    programs.extend([false, true].map(|normals| Program::Displace { normals }));
    programs.push(Program::Interpolate);
    programs.extend(shadows::Caster::all().into_iter().map(Program::Caster));
    programs.extend([Program::Blur, Program::Extrude, Program::Mask]);
    programs.extend(ShadowFilter::ALL.iter().filter(|filter| filter.has_moments()).map(|f| Program::RunningBlur(*f)));
    programs.extend(shadows::MapKind::all().into_iter().map(Program::ShadowMap));
    programs.extend([false, true].map(|encode| Program::Background { encode }));
    programs.push(Program::Sky);
    for premultiply in [false, true] {
        programs.extend([(false, false), (true, false), (false, true)].map(|(encode, decode)| Program::Present {
            encode,
            decode,
            premultiply,
        }));
    }
    programs
}

/// The WGSL text of a program.
pub(crate) fn source(program: &Program) -> Result<String, ShaderError> {
    let set = match program {
        Program::Surface(variant) => variant.shadows,
        _ => shadows::ShadowSet::NONE,
    };
    let (bindings, functions) = (shadows::bindings(&set), shadows::functions(&set));
    let find = |name: &str| match name {
        "shadow_bindings" => Some(bindings.as_str()),
        "shadow_functions" => Some(functions.as_str()),
        _ => FILES.iter().find(|(file, _)| *file == name).map(|(_, text)| *text),
    };
    let body = assemble(program.root(), &find, &program.features())?;
    Ok(format!("const MAX_LIGHTS: u32 = {MAX_LIGHTS}u;\n{body}"))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Validates like the device does, without one.
    fn validate(program: &Program) -> Result<(), String> {
        let text = source(program).map_err(|error| error.to_string())?;
        let module = naga::front::wgsl::parse_str(&text).map_err(|error| error.emit_to_string(&text))?;
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
            .validate(&module)
            .map(|_| ())
            .map_err(|error| error.emit_to_string(&text))
    }

    #[test]
    fn every_variant_is_valid_wgsl() {
        let programs = all_programs();
        let middle = programs.len() / 2;
        let check = |half: &[Program]| {
            for program in half {
                if let Err(message) = validate(program) {
                    panic!("{program:?}\n{message}");
                }
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(|| check(&programs[..middle]));
            check(&programs[middle..]);
        });
    }

    #[test]
    fn the_enumeration_is_complete_and_has_no_doubles() {
        let programs = all_programs();
        let distinct: BTreeSet<&Program> = programs.iter().collect();
        assert_eq!(distinct.len(), programs.len());
        // Lit: 3 normal sources × 2 (specular) × 2 (falloff); 3 × 2 lit by an environment; light-mapped; flat. Each with 2
        // (diffuse map) × 3 (vertex colours) × 4 (alpha). Then 6 that show stored values, and samples of shadow sets, lit and shown.
        let shadowed = 2 * shadows::ShadowSet::samples().len();
        // Relief with each lit or textured surface.
        let relief = (3 * 2 * 2 + 3 * 2 + 1) * 2 + 1;
        assert_eq!(Variant::all().len(), (3 * 2 * 2 + 3 * 2 + 1 + 1) * 2 * 3 * 4 + 6 + shadowed + relief);
        let shadows = shadows::Caster::all().len() + 3 + 5 + 6;
        assert_eq!(programs.len(), Variant::all().len() + 8 + shadows + 3 + 2 + 1 + 6);
    }

    #[test]
    fn the_files_are_those_of_the_folder() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders");
        let on_disk: BTreeSet<String> = std::fs::read_dir(folder)
            .unwrap()
            .filter_map(|entry| entry.unwrap().file_name().to_str()?.strip_suffix(".wgsl").map(str::to_owned))
            .collect();
        let listed: BTreeSet<String> = FILES.iter().map(|(name, _)| (*name).to_owned()).collect();
        assert_eq!(on_disk, listed);
    }

    #[test]
    fn a_variant_reads_only_what_it_uses() {
        let text = |variant: Variant| source(&Program::Surface(variant)).unwrap();
        let flat = text(Variant {
            surface: super::super::Surface::Flat,
            diffuse_map: false,
            color: super::super::ColorSource::None,
            alpha: super::super::AlphaMode::OPAQUE,
            shadows: shadows::ShadowSet::NONE,
            relief: false,
        });
        for absent in ["in.normal", "textureSample(base_map", "fn phong", "discard", "@location(1)"] {
            assert!(!flat.contains(absent), "{absent} in\n{flat}");
        }
    }
}
