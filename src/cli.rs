//! The arguments of every verb. Help texts teach by example.

use std::path::PathBuf;

use aam::check::{CodePattern, Rules};
use aam::{Limits, Severity};
use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum, ValueHint};
use glam::Vec3;

use crate::args::{self, Background, CodeParser, ShadowChoice, ShadowParser, ShowArg, Size, TextureFor};
use crate::verb::tune::TunePhysicsArgs;

const EXAMPLES: &str = "\
Examples:
  aam convert model.gltf                    write model.aam and its textures beside it
  aam render model.aam -o picture.png       draw a picture without a window
  aam view model.aam                        look at it in a window
  aam decompose model.gltf -o model.aam     convex hulls for physics
  aam check model.aam                       say what is wrong in it
  aam chart shadows room.scene.toml -o out  measure shadow techniques on a scene

Exit codes:
  0    done
  1    `check` found errors, `fmt --check` found a file that is not canonical, what `simulate` simulated broke,
       or nothing that `tune` measured reaches the goal
  2    it could not be done: wrong arguments, a file that cannot be read or written
  101  a mistake in this program

Files may be .aam, .gltf, .glb, .obj, .stl, .ply, and for view, render and simulate also .scene.toml.
`aam VERB --help` shows examples of each verb.";

/// Convert, inspect, draw and check AAM (Ascii Animated Mesh) assets.
#[derive(Debug, Parser)]
#[command(name = "aam", version, propagate_version = true, arg_required_else_help = true, after_help = EXAMPLES)]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) global: Global,
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

/// Options of all verbs.
#[derive(Debug, Args)]
#[command(next_display_order = 900)]
pub(crate) struct Global {
    /// Say more; -vv adds warnings of the graphics libraries, -vvv all they say
    #[arg(short, long, global = true, action = ArgAction::Count)]
    pub(crate) verbose: u8,
    /// Say nothing but results and errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Convert between AAM, glTF, OBJ and others
    Convert(Box<ConvertArgs>),
    /// Cut the objects of a file into convex hulls
    Decompose(Box<DecomposeArgs>),
    /// Draw a picture of a file
    Render(Box<RenderArgs>),
    /// Look at a file in a window
    View(ViewArgs),
    /// Let the bodies of a file fall, collide and come to rest
    Simulate(SimulateArgs),
    /// Measure techniques on a scene: speed against accuracy
    Chart(ChartArgs),
    /// Choose the cheapest technique that is accurate enough for a scene
    Tune(TuneArgs),
    /// Show what a file holds
    Info(InfoArgs),
    /// Find what is wrong in AAM files
    Check(CheckArgs),
    /// Rewrite AAM files in their canonical layout
    Fmt(FmtArgs),
    /// Print a completion script for a shell
    Completions(CompletionsArgs),
}

/// How files are read, whatever is then done with them.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Reading")]
pub(crate) struct ReadArgs {
    /// Take this animation clip; without it the first
    #[arg(long, value_name = "NAME")]
    pub(crate) animation: Option<String>,
    /// Sample animations at this rate
    #[arg(long, value_name = "N", default_value = "30", value_parser = args::frames_per_second)]
    pub(crate) fps: f32,
    /// Which axis points up in the input, where its format does not say (OBJ, STL, PLY)
    #[arg(long, value_name = "AXIS")]
    pub(crate) up: Option<Axis>,
    /// Read textures outside the file's own folder
    #[arg(long)]
    pub(crate) allow_outside: bool,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

/// How large what is read may be. Numbers may end in K, M, G or T, which are powers of 1024.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Limits")]
pub(crate) struct LimitArgs {
    /// Refuse files of more bytes (64K, 512M, 4G)
    #[arg(long, value_name = "BYTES", default_value = "4G", value_parser = args::amount)]
    max_file_size: u64,
    /// Refuse documents of more objects, over all frames
    #[arg(long, value_name = "N", default_value = "8M", value_parser = args::amount)]
    max_objects: u64,
    /// Refuse documents of more vertices, over all frames
    #[arg(long, value_name = "N", default_value = "256M", value_parser = args::amount)]
    max_vertices: u64,
    /// Refuse documents of more triangles
    #[arg(long, value_name = "N", default_value = "64M", value_parser = args::amount)]
    max_triangles: u64,
    /// Refuse documents and clips of more frames
    #[arg(long, value_name = "N", default_value = "1M", value_parser = args::amount)]
    max_frames: u64,
    /// Leave out textures of more pixels
    #[arg(long, value_name = "N", default_value = "256M", value_parser = args::amount)]
    max_texture_pixels: u64,
    /// Refuse materials that nest deeper
    #[arg(long, value_name = "N", default_value = "32", value_parser = clap::value_parser!(u64).range(1..=Limits::DEEPEST_NESTING))]
    max_nesting: u64,
}

impl LimitArgs {
    pub(crate) fn limits(&self) -> Limits {
        Limits {
            file_size: self.max_file_size,
            objects: self.max_objects,
            vertices: self.max_vertices,
            triangles: self.max_triangles,
            frames: self.max_frames,
            texture_pixels: self.max_texture_pixels,
            nesting: self.max_nesting,
        }
    }
}

/// An axis that points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Axis {
    Y,
    Z,
}

const CONVERT_EXAMPLES: &str = "\
Examples:
  aam convert model.gltf                    write model.aam and its textures beside it
  aam convert model.aam model.glb           back to glTF
  aam convert a.glb b.obj c.stl -o out/     several files into a folder
  aam convert truck.glb --hierarchy         keep the node hierarchy and its animation (AAM_CHARACTER)
  aam convert room.obj --light-map Walls=walls_lm.png
  aam convert chair.glb --physics dynamic --mass 6 --hulls 8
  aam convert model.gltf --report report.json -v

Input:  .gltf .glb .obj .stl .ply .aam       Output: .aam .glb .gltf .obj
docs/report.schema.json describes the report.
The output's name decides its format. An output that you name is overwritten; an input never is.";

#[derive(Debug, Args)]
#[command(
    after_help = CONVERT_EXAMPLES,
    override_usage = "aam convert [OPTIONS] IN [OUT]\n       aam convert [OPTIONS] IN... -o FOLDER"
)]
pub(crate) struct ConvertArgs {
    /// File to convert, and the output's name; with --output all are inputs
    #[arg(value_name = "IN [OUT]", required = true, value_hint = ValueHint::FilePath)]
    pub(crate) files: Vec<PathBuf>,
    /// Output file, or the folder that several outputs go to
    #[arg(short, long, value_name = "PATH", value_hint = ValueHint::AnyPath)]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite also files that you did not name, such as a texture or a scene file of the same name
    #[arg(short, long)]
    pub(crate) force: bool,
    /// Write what was kept, changed and lost as JSON
    #[arg(long, value_name = "FILE.json", value_hint = ValueHint::FilePath)]
    pub(crate) report: Option<PathBuf>,
    /// Write local transforms and keys (AAM_CHARACTER) instead of world coordinates
    #[arg(long)]
    pub(crate) hierarchy: bool,
    /// Write explicit normals only where smoothing groups miss them by more than this many degrees
    #[arg(long, value_name = "DEGREES", default_value = "0.5", value_parser = args::tolerance)]
    pub(crate) normal_tolerance: f32,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
    #[command(flatten)]
    pub(crate) textures: TextureArgs,
    #[command(flatten)]
    pub(crate) physics: PhysicsArgs,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Textures that the input lacks")]
pub(crate) struct TextureArgs {
    /// Add a light map, to one material or to all
    #[arg(long, value_name = "[MATERIAL=]FILE", value_parser = args::texture_for)]
    pub(crate) light_map: Vec<TextureFor>,
    /// Add a tangent-space normal map
    #[arg(long, value_name = "[MATERIAL=]FILE", value_parser = args::texture_for)]
    pub(crate) normal_map: Vec<TextureFor>,
    /// Add a displacement map; --tf, --bias and --scale say how it is applied
    #[arg(long, value_name = "[MATERIAL=]FILE", value_parser = args::texture_for)]
    pub(crate) displacement: Vec<TextureFor>,
    /// Parts that displacement cuts each edge into (TF); without it 8
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64), requires = "displacement")]
    pub(crate) tf: Option<u32>,
    /// Displacement where the map is black (BI), in object units; without it 0
    #[arg(long, value_name = "F", value_parser = args::number, allow_hyphen_values = true, requires = "displacement")]
    pub(crate) bias: Option<f32>,
    /// Added displacement where the map is white (SC), in object units; without it 1
    #[arg(long, value_name = "F", value_parser = args::number, allow_hyphen_values = true, requires = "displacement")]
    pub(crate) scale: Option<f32>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Physics bodies")]
pub(crate) struct PhysicsArgs {
    /// Give every object a body
    #[arg(long, value_name = "MODE")]
    pub(crate) physics: Option<BodyMode>,
    /// Mass of all dynamic bodies together in kilograms, shared out by volume
    #[arg(long, value_name = "KG", value_parser = args::positive, requires = "physics", conflicts_with = "density")]
    pub(crate) mass: Option<f32>,
    /// Mass from the volume, in kilograms per cubic metre; without both that of water, 1000
    #[arg(long, value_name = "KG/M3", value_parser = args::positive, requires = "physics")]
    pub(crate) density: Option<f32>,
    /// Static friction; without it 0.5
    #[arg(long, value_name = "F", value_parser = args::not_negative, requires = "physics")]
    pub(crate) static_friction: Option<f32>,
    /// Dynamic friction; without it 0.5
    #[arg(long, value_name = "F", value_parser = args::not_negative, requires = "physics")]
    pub(crate) dynamic_friction: Option<f32>,
    /// Restitution, from 0 (the default) to 1
    #[arg(long, value_name = "F", value_parser = args::fraction, requires = "physics")]
    pub(crate) restitution: Option<f32>,
    #[command(flatten)]
    pub(crate) hulls: HullArgs,
}

/// How objects are cut into convex hulls.
#[derive(Debug, Args)]
#[command(next_help_heading = "Convex hulls")]
pub(crate) struct HullArgs {
    /// At most this many hulls for each object, 64 if only an error is asked for; alone, the best so many can do
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub(crate) hulls: Option<u32>,
    /// As few hulls as are this close to the surface, in % of the object's diagonal; without it and --hulls 2
    #[arg(long, value_name = "%", value_parser = args::percent)]
    pub(crate) max_error: Option<f32>,
    /// At most this many vertices in a hull; 64 is what physics on a GPU takes
    #[arg(long, value_name = "N", default_value = "64", value_parser = clap::value_parser!(u8).range(4..=255))]
    pub(crate) max_verts_per_hull: u8,
    /// Boxes, spheres and capsules in place of hulls that they are as near to the surface as
    #[arg(long)]
    pub(crate) primitives: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum BodyMode {
    /// Never moves
    Static,
    /// Moved by the program
    Kinematic,
    /// Moved by forces
    Dynamic,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Writing AAM")]
pub(crate) struct WriteArgs {
    /// Only what the original format of XVR knows; what does not fit is reported as lost
    #[arg(long)]
    pub(crate) original: bool,
    /// Bulk data as little-endian binary
    #[arg(long)]
    pub(crate) binary: bool,
    /// This many digits after the point; without it as many as the number needs
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=20))]
    pub(crate) digits: Option<u8>,
    /// End lines with CR LF
    #[arg(long)]
    pub(crate) crlf: bool,
}

const DECOMPOSE_EXAMPLES: &str = "\
Examples:
  aam decompose chair.glb -o chair.aam               as few hulls as are within 2 % of the diagonal
  aam decompose chair.glb -o chair.glb --hulls 8     the best that eight hulls can do
  aam decompose chair.glb -o hulls.obj --max-error 0.5 --hulls 128
  aam decompose chair.glb -o chair.aam --primitives  boxes, spheres and capsules where they do as well
  aam decompose chair.glb -o hulls.json --report report.json

Output: .aam (PHYSICS), .glb .gltf (the draft extensions KHR_physics_rigid_bodies and KHR_implicit_shapes),
        .obj (an object for each hull), .json (vertices, triangles, volumes)
The same file and options give the same hulls, on any number of threads; nothing is random.
docs/decompose.schema.json describes the report, docs/techniques/decomposition.md the method and its limits.

Exit codes: 0 done, also where an error that was asked for takes more hulls than are allowed (it is said),
2 it could not be done.";

#[derive(Debug, Args)]
#[command(after_help = DECOMPOSE_EXAMPLES)]
pub(crate) struct DecomposeArgs {
    /// File to decompose: .aam .gltf .glb .obj .stl .ply
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// Where the hulls go: .aam .glb .gltf .obj .json
    #[arg(short, long, value_name = "PATH", value_hint = ValueHint::FilePath)]
    pub(crate) output: PathBuf,
    /// Write hulls, vertices, distances both ways, volumes and times as JSON
    #[arg(long, value_name = "FILE.json", value_hint = ValueHint::FilePath)]
    pub(crate) report: Option<PathBuf>,
    /// How the bodies of the objects move
    #[arg(long, value_name = "MODE", default_value = "dynamic")]
    pub(crate) mode: BodyMode,
    #[command(flatten)]
    pub(crate) hulls: HullArgs,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

const RENDER_EXAMPLES: &str = "\
Examples:
  aam render model.aam -o picture.png
  aam render model.glb -o top.png --view top --size 1920x1080 --background white
  aam render model.aam -o cut.png --camera-position 3,-4,2 --camera-target 0,0,1 --fov 35
  aam render model.aam -o turn.png --turntable 36          turn_00.png … turn_35.png
  aam render model.aam -o '{n}.png' --turntable 36         00.png … 35.png
  aam render model.aam -o - > picture.png
  aam render moon.aam -o moon.png --displacement adaptive --pixel-error 0.5
  aam render room.scene.toml -o room.png --shadows=evsm4:resolution=512,radius=5
  aam render room.scene.toml -o map.png --shadows --show depth --size 512x512
  aam render model.aam -o hulls.png --explode 0.3          its convex hulls, moved apart
  aam render room.scene.toml -o room.png --engine reference --samples 16 --shadows
  aam render room.scene.toml -o room.png --engine reference --samples 64 --bounces 4
  aam render model.glb -o model.png --environment sky.hdr --exposure -1 --tone-map aces
  aam render model.aam -o model.png --environment 'sky_{face}.png'     six faces: sky_right.png … or sky_px.png …";

#[derive(Debug, Args)]
#[command(after_help = RENDER_EXAMPLES)]
pub(crate) struct RenderArgs {
    /// File to draw: .aam .gltf .glb .obj .stl .ply .scene.toml
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// PNG to write; - is standard output, {n} the number of a turntable picture
    #[arg(short, long, value_name = "FILE.png", value_hint = ValueHint::FilePath)]
    pub(crate) output: PathBuf,
    /// Picture size in pixels
    #[arg(short, long, value_name = "WxH", default_value = "1280x720", value_parser = args::size)]
    pub(crate) size: Size,
    /// Look from front, back, left, right, top, bottom or iso, through a camera of the file by its name, or from a shadow
    /// source: light:NAME, or light for the first
    #[arg(long, value_name = "NAME", conflicts_with = "camera_position")]
    pub(crate) view: Option<String>,
    /// Where the camera stands, in world coordinates
    #[arg(long, value_name = "X,Y,Z", value_parser = args::vector, allow_hyphen_values = true)]
    pub(crate) camera_position: Option<Vec3>,
    /// The point in the middle of the picture; without it the middle of the scene
    #[arg(long, value_name = "X,Y,Z", value_parser = args::vector, allow_hyphen_values = true)]
    pub(crate) camera_target: Option<Vec3>,
    /// The direction that is up in the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = args::vector, allow_hyphen_values = true)]
    pub(crate) camera_up: Option<Vec3>,
    /// Vertical field of view
    #[arg(long, value_name = "DEGREES", value_parser = args::field_of_view)]
    pub(crate) fov: Option<f32>,
    /// transparent, a name, #rrggbb, or R,G,B from 0 to 1
    #[arg(short, long, value_name = "COLOR", value_parser = args::background)]
    pub(crate) background: Option<Background>,
    /// Compute on colours as stored, or in linear light; without it as the file's kind asks
    #[arg(long, value_name = "MODE")]
    pub(crate) shading: Option<Shading>,
    #[command(flatten)]
    pub(crate) environment: EnvironmentArgs,
    /// Draw lit, normals, or of a shadow source what it lets through (shadow:NAME) or its map, near is light (depth:NAME);
    /// without :NAME of the first (GPU)
    #[arg(long, value_name = "WHAT", default_value = "lit", value_parser = args::show)]
    pub(crate) show: ShowArg,
    /// Draw on the GPU, or by ray tracing on the CPU; without it the GPU if there is one
    #[arg(long, value_name = "ENGINE")]
    pub(crate) engine: Option<Engine>,
    /// Samples for each pixel on the GPU
    #[arg(long, value_name = "N", default_value = "4", value_parser = ["1", "4"])]
    pub(crate) msaa: String,
    /// Samples for each pixel of the reference engine
    #[arg(long, value_name = "N", default_value = "4", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) samples: u32,
    /// Shadows of every light where the file has no [[shadow]]: on the GPU by a technique such as evsm4:radius=5
    /// (=help lists them), by the reference engine of lights as large as the file says (=area) or of points (=point);
    /// =none leaves out those of the file
    #[arg(
        long,
        value_name = "WHAT",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "usual",
        value_parser = ShadowParser,
        hide_possible_values = true
    )]
    pub(crate) shadows: Option<ShadowChoice>,
    /// Shadow rays to each light that has a size, for each sample (reference engine)
    #[arg(long, value_name = "N", default_value = "16", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub(crate) light_samples: u32,
    /// Directions in which each sample looks at an environment, for diffuse and specular light each (reference engine)
    #[arg(long, value_name = "N", default_value = "64", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub(crate) environment_samples: u32,
    /// Light that surfaces give on to each other, so many times, in linear light and with shadows (reference engine)
    #[arg(long, value_name = "N", default_value = "0", value_parser = clap::value_parser!(u32).range(0..=1024))]
    pub(crate) bounces: u32,
    /// How displacement maps are drawn
    #[arg(long, value_name = "MODE", default_value = "uniform")]
    pub(crate) displacement: Displacement,
    /// Pixels that a point may move when adaptive tessellation changes; without it 1
    #[arg(long, value_name = "PIXELS", value_parser = args::pixel_error)]
    pub(crate) pixel_error: Option<f32>,
    /// Frame of the animation, from 0
    #[arg(long, value_name = "F", default_value = "0", value_parser = args::not_negative)]
    pub(crate) frame: f32,
    /// Draw N pictures around the object, into numbered files
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) turntable: Option<u32>,
    /// Draw the convex hulls of the bodies, each in its own colour, moved apart by AMOUNT times their distance from the
    /// middle; 0 leaves them in place
    #[arg(long, value_name = "AMOUNT", value_parser = args::not_negative)]
    pub(crate) explode: Option<f32>,
    /// Show how long each step took
    #[arg(long)]
    pub(crate) time: bool,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

/// Light from all around, and how light is shown.
#[derive(Clone, Debug, Args)]
pub(crate) struct EnvironmentArgs {
    /// Light from all around, instead of lights: a panorama, the cross of a cube, or six files such as 'sky_{face}.png'
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) environment: Option<PathBuf>,
    /// What the environment lights; with none it is only seen, and lights shine
    #[arg(long, value_name = "WHICH")]
    pub(crate) environment_light: Option<EnvironmentLight>,
    /// How sharply surfaces reflect it; without it mirror for source shading and phong for linear
    #[arg(long, value_name = "FILTER")]
    pub(crate) environment_filter: Option<ReflectionFilter>,
    /// Turn it about the up axis, counter-clockwise seen from above
    #[arg(long, value_name = "DEGREES", value_parser = args::number, allow_hyphen_values = true)]
    pub(crate) environment_rotation: Option<f32>,
    /// Factor for its light
    #[arg(long, value_name = "F", value_parser = args::not_negative)]
    pub(crate) environment_intensity: Option<f32>,
    /// Show light brighter by so many stops: 1 is twice as bright, -1 half
    #[arg(long, value_name = "STOPS", value_parser = args::exposure, allow_hyphen_values = true)]
    pub(crate) exposure: Option<f32>,
    /// How light beyond white is shown; without it clamp
    #[arg(long, value_name = "CURVE")]
    pub(crate) tone_map: Option<ToneMapping>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum EnvironmentLight {
    /// Diffuse and specular terms
    Both,
    /// Diffuse terms only
    Diffuse,
    /// Specular terms only
    Specular,
    /// Nothing
    None,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ReflectionFilter {
    /// Whatever the exponent, as VR3Lib did
    Mirror,
    /// By the lobe of the material's exponent
    Phong,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ToneMapping {
    /// Cut at 1, as VR3Lib did
    Clamp,
    /// c / (1 + c)
    Reinhard,
    /// Like film
    Aces,
    /// Khronos PBR Neutral
    Neutral,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Shading {
    /// As VR3Lib and XVR did
    Source,
    /// Decoded from sRGB first, encoded last
    Linear,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Displacement {
    /// The base mesh alone
    Off,
    /// Each edge cut into as many parts as the file says (TF)
    Uniform,
    /// Edges halved until --pixel-error holds
    Adaptive,
    /// The base mesh, with the map looked up along the ray of sight (GPU engine)
    Parallax,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum LightSize {
    /// Every light is a point
    Point,
    /// Lights are as large as the scene file says
    Area,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Engine {
    /// wgpu
    Gpu,
    /// Ray tracing on the CPU
    Reference,
}

const VIEW_EXAMPLES: &str = "\
Examples:
  aam view model.aam
  aam view model.glb
  aam view room.scene.toml
  aam view --demo                           how shadow mapping works, step by step, in three scenes
  aam view a.scene.toml b.scene.toml        several files with the demo's keys: space goes to the next

Drag to turn, shift-drag or middle-drag to move, wheel to come closer, F to fit, H for all keys.
The window follows the file: save it elsewhere and the picture changes.";

#[derive(Debug, Args)]
#[command(after_help = VIEW_EXAMPLES)]
pub(crate) struct ViewArgs {
    /// File to look at: .aam .gltf .glb .obj .stl .ply .scene.toml; without it drop one on the window
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) files: Vec<PathBuf>,
    /// Show the shadow-mapping demo: space goes to the next scene, L looks from the light, P and U pause and resume, R
    /// starts again, arrows change the speed
    #[arg(long, conflicts_with = "files")]
    pub(crate) demo: bool,
    /// Window size in pixels
    #[arg(short, long, value_name = "WxH", default_value = "1280x800", value_parser = args::size)]
    pub(crate) size: Size,
    /// Samples for each pixel
    #[arg(long, value_name = "N", default_value = "4", value_parser = ["1", "4"])]
    pub(crate) msaa: String,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

const SIMULATE_EXAMPLES: &str = "\
Examples:
  aam simulate model.aam                          say where its bodies come to rest
  aam simulate model.aam -o fall.glb --time 4     an animation; .aam and .gltf too
  aam simulate room.scene.toml -o poses.csv --fps 60
  aam simulate room.scene.toml -o fall.png --fps 10       pictures: fall_00.png … fall_50.png
  aam simulate model.aam --steps 600 --dt 1/240 --hash
  aam convert chair.glb --physics dynamic && aam simulate chair.aam --gravity 0,0,-1.62

Bodies are those of PHYSICS in AAM files; `aam convert --physics` makes some. Up is the file's, gravity 9.81 m/s² down.
Each step is as long as the others, and the same file and options give the same hash on every run.

Exit codes: 0 done, 1 a body broke or was lost: the simulation was stopped there and what is written ends there,
2 it could not be done.";

#[derive(Debug, Args)]
#[command(after_help = SIMULATE_EXAMPLES)]
pub(crate) struct SimulateArgs {
    /// File to simulate: .aam, or a .scene.toml that lists some
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// Poses as .json or .csv, an animation as .aam, .glb or .gltf, or pictures as .png; --fps says how many a second
    #[arg(short, long, value_name = "PATH", value_hint = ValueHint::FilePath)]
    pub(crate) output: Option<PathBuf>,
    /// Size of pictures in pixels
    #[arg(short, long, value_name = "WxH", default_value = "1280x720", value_parser = args::size)]
    pub(crate) size: Size,
    /// Simulated time; without it and --steps 5
    #[arg(long, value_name = "SECONDS", value_parser = args::positive, conflicts_with = "steps")]
    pub(crate) time: Option<f32>,
    /// Simulate this many steps
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub(crate) steps: Option<u64>,
    /// Length of a step, such as 1/240 or 0.004
    #[arg(long, value_name = "SECONDS", default_value = "1/60", value_parser = args::time_step)]
    pub(crate) dt: f32,
    /// Acceleration of free bodies in m/s²; without it 9.81 down
    #[arg(long, value_name = "X,Y,Z", value_parser = args::vector, allow_hyphen_values = true)]
    pub(crate) gravity: Option<Vec3>,
    /// Solver iterations a step: more are more accurate, and slower
    #[arg(long, value_name = "N", default_value = "4", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) iterations: u32,
    /// Which bodies fast ones cannot pass through within a step
    #[arg(long, value_name = "WHICH", default_value = "static")]
    pub(crate) continuous: Continuous,
    /// Stop when a body is farther than this many metres from where the bodies started
    #[arg(long, value_name = "METRES", default_value = "100000", value_parser = args::positive)]
    pub(crate) max_distance: f32,
    /// Print a hash of all poses and velocities after every step
    #[arg(long)]
    pub(crate) hash: bool,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

/// Continuous collision detection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Continuous {
    /// None
    Off,
    /// Static bodies
    Static,
    /// All bodies
    All,
}

const CHART_EXAMPLES: &str = "\
Examples:
  aam chart shadows room.scene.toml -o room-chart            up to 15 minutes; then open room-chart/index.html
  aam chart shadows room.scene.toml -o room-chart --quick    up to two minutes
  aam chart shadows room.scene.toml -o room-chart --techniques hard,pcf,evsm4 --light sun";

#[derive(Debug, Args)]
#[command(after_help = CHART_EXAMPLES)]
pub(crate) struct ChartArgs {
    #[command(subcommand)]
    pub(crate) what: ChartWhat,
}

#[derive(Debug, Subcommand)]
pub(crate) enum ChartWhat {
    /// Shadows of a light, against what the reference traces
    Shadows(Box<ChartShadowsArgs>),
}

const CHART_SHADOWS_EXAMPLES: &str = "\
Examples:
  aam chart shadows room.scene.toml -o room-chart            up to 15 minutes; then open room-chart/index.html
  aam chart shadows room.scene.toml -o room-chart --quick    up to two minutes
  aam chart shadows room.scene.toml -o room-chart --techniques hard,pcf,evsm4 --light sun

The folder gets index.html (plots and pictures, one page without anything else), data.csv (one row for each setting and
truth), data.json (docs/chart-shadows.schema.json describes it) and fronts.svg. Files of these names are overwritten.
Errors are those of the light's visibility, over the pixels that face it, against the light as a point and against the
light as large as the scene says.";

#[derive(Debug, Args)]
#[command(after_help = CHART_SHADOWS_EXAMPLES)]
pub(crate) struct ChartShadowsArgs {
    /// Scene to measure on: .scene.toml, or an asset that brings a light
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// Folder to write to; it is made if it is not there
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) measure: MeasureArgs,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

/// What is measured of shadows.
#[derive(Clone, Debug, Args)]
pub(crate) struct MeasureArgs {
    /// A few settings of each technique, in at most two minutes
    #[arg(long, conflicts_with = "full")]
    pub(crate) quick: bool,
    /// A dense grid and a finer truth, however long it takes
    #[arg(long)]
    pub(crate) full: bool,
    /// Only these techniques, such as hard,pcf,csm-evsm4
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', value_parser = args::shadow_technique)]
    pub(crate) techniques: Vec<aam_scene::ShadowTechnique>,
    /// Picture size in pixels
    #[arg(short, long, value_name = "WxH", default_value = "512x384", value_parser = args::size)]
    pub(crate) size: Size,
    /// The light, by its name or its number from 1; without it the first with a shape
    #[arg(long, value_name = "NAME")]
    pub(crate) light: Option<String>,
    /// Look through a camera of the file by its name; without it the file's active one
    #[arg(long, value_name = "NAME")]
    pub(crate) view: Option<String>,
    /// Frame of the animation, from 0
    #[arg(long, value_name = "F", default_value = "0", value_parser = args::not_negative)]
    pub(crate) frame: f32,
}

const TUNE_EXAMPLES: &str = "\
Examples:
  aam tune shadows room.scene.toml --max-error 0.05             the cheapest with an RMSE of at most 0.05
  aam tune shadows room.scene.toml --budget-ms 4                the most accurate within 4 ms a frame on this machine
  aam tune shadows room.scene.toml --max-error 0.05 --dry-run   only say what would be written
  aam tune --physics chair.glb                                  how many convex hulls are enough";

#[derive(Debug, Args)]
#[command(after_help = TUNE_EXAMPLES)]
pub(crate) struct TuneArgs {
    #[command(subcommand)]
    pub(crate) what: TuneWhat,
}

#[derive(Debug, Subcommand)]
pub(crate) enum TuneWhat {
    /// Shadow techniques and their parameters; the word may be left out
    Shadows(Box<TuneShadowsArgs>),
    /// The fewest convex hulls with which bodies move as their surface would; also --physics
    Physics(Box<TunePhysicsArgs>),
}

const TUNE_SHADOWS_EXAMPLES: &str = "\
Examples:
  aam tune shadows room.scene.toml --max-error 0.05             the cheapest with an RMSE of at most 0.05
  aam tune shadows room.scene.toml --budget-ms 4                the most accurate within 4 ms a frame on this machine
  aam tune shadows room.scene.toml --max-error 0.05 --dry-run   only say what would be written

The choice is written into the scene file as [[shadow]], or into one beside an asset. Lights whose shadow no camera of the
scene sees get none, and objects that cast nothing into view are no casters.
Without --quick or --full it takes up to 15 minutes for each light.

Exit codes: 0 done, 1 nothing that was measured reaches the goal: what comes closest is written,
2 it could not be done.";

#[derive(Debug, Args)]
#[command(after_help = TUNE_SHADOWS_EXAMPLES)]
#[command(group = clap::ArgGroup::new("goal").required(true).args(["max_error", "budget_ms"]))]
pub(crate) struct TuneShadowsArgs {
    /// Scene to tune: .scene.toml, or an asset that brings a light
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// The cheapest whose visibility has a root mean squared error of at most this, from 0 to 1
    #[arg(long, value_name = "E", value_parser = args::fraction)]
    pub(crate) max_error: Option<f32>,
    /// The most accurate that takes at most so much GPU time a frame
    #[arg(long, value_name = "MS", value_parser = args::positive)]
    pub(crate) budget_ms: Option<f32>,
    /// What the light is taken for
    #[arg(long, value_name = "TRUTH", default_value = "area")]
    pub(crate) truth: LightSize,
    /// Write to this scene file instead
    #[arg(short, long, value_name = "FILE.scene.toml", value_hint = ValueHint::FilePath, conflicts_with = "dry_run")]
    pub(crate) output: Option<PathBuf>,
    /// Write nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    #[command(flatten)]
    pub(crate) measure: MeasureArgs,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

const INFO_EXAMPLES: &str = "\
Examples:
  aam info model.aam
  aam info model.glb --json | jq '.vertices, .triangles'

docs/info.schema.json describes the JSON.";

#[derive(Debug, Args)]
#[command(after_help = INFO_EXAMPLES)]
pub(crate) struct InfoArgs {
    /// File to look into: .aam .gltf .glb .obj .stl .ply
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

const CHECK_EXAMPLES: &str = "\
Examples:
  aam check model.aam
  aam check models/*.aam --strict
  aam check model.aam --only geometry,physics --ignore geometry/unused-vertex
  aam check model.aam --error texture --info texture/rotation-axes
  aam check --list                          every code, its severity and meaning
  aam check model.aam --json | jq '.[].findings[].code'

A CODE is one finding, such as texture/missing, or a group of them, such as texture. The severity
of a code counts more than that of its group. An error that ends the reading is always shown, and
always an error. docs/checks.schema.json describes the JSON.

Exit codes: 0 no finding of error severity, 1 at least one, 2 a file could not be read.";

#[derive(Debug, Args)]
#[command(after_help = CHECK_EXAMPLES)]
pub(crate) struct CheckArgs {
    /// AAM files
    #[arg(value_name = "FILE", required_unless_present = "list", value_hint = ValueHint::FilePath)]
    pub(crate) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) rules: RuleArgs,
    /// Show the codes that would be looked for, and no file
    #[arg(long, conflicts_with_all = ["files", "json"])]
    pub(crate) list: bool,
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

/// Which findings are shown, and how bad they are.
#[derive(Debug, Args)]
pub(crate) struct RuleArgs {
    /// Everything that is otherwise a warning is an error
    #[arg(long)]
    strict: bool,
    /// Show only these findings
    #[arg(long, value_name = "CODE,…", value_delimiter = ',', value_parser = CodeParser, hide_possible_values = true)]
    only: Vec<CodePattern>,
    /// Leave these findings out
    #[arg(long, value_name = "CODE,…", value_delimiter = ',', value_parser = CodeParser, hide_possible_values = true)]
    ignore: Vec<CodePattern>,
    /// These findings are errors
    #[arg(long, value_name = "CODE,…", value_delimiter = ',', value_parser = CodeParser, hide_possible_values = true)]
    error: Vec<CodePattern>,
    /// These findings are warnings
    #[arg(long, value_name = "CODE,…", value_delimiter = ',', value_parser = CodeParser, hide_possible_values = true)]
    warning: Vec<CodePattern>,
    /// These findings are only for information
    #[arg(long, value_name = "CODE,…", value_delimiter = ',', value_parser = CodeParser, hide_possible_values = true)]
    info: Vec<CodePattern>,
}

impl RuleArgs {
    pub(crate) fn rules(&self) -> Rules {
        let kinds = [(&self.error, Severity::Error), (&self.warning, Severity::Warning), (&self.info, Severity::Info)];
        let severities =
            kinds.into_iter().flat_map(|(patterns, severity)| patterns.iter().map(move |p| (*p, severity)));
        Rules {
            only: self.only.clone(),
            ignore: self.ignore.clone(),
            severities: severities.collect(),
            strict: self.strict,
        }
    }
}

const FMT_EXAMPLES: &str = "\
Examples:
  aam fmt model.aam                          rewrite in place
  aam fmt --check models/*.aam               only say which are not canonical (exit code 1)
  aam fmt - < in.aam > out.aam

A BINARY file stays BINARY. A file is replaced as a whole or not at all.";

#[derive(Debug, Args)]
#[command(after_help = FMT_EXAMPLES)]
pub(crate) struct FmtArgs {
    /// AAM files; - reads standard input and writes standard output
    #[arg(value_name = "FILE", required = true, value_hint = ValueHint::FilePath)]
    pub(crate) files: Vec<PathBuf>,
    /// Change nothing; exit with 1 if a file is not canonical
    #[arg(long)]
    pub(crate) check: bool,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  aam completions bash > ~/.local/share/bash-completion/completions/aam
  aam completions zsh > ~/.zfunc/_aam
  aam completions fish > ~/.config/fish/completions/aam.fish";

#[derive(Debug, Args)]
#[command(after_help = COMPLETIONS_EXAMPLES)]
pub(crate) struct CompletionsArgs {
    /// The shell
    #[arg(value_name = "SHELL")]
    pub(crate) shell: clap_complete::Shell,
}

#[cfg(test)]
mod tests {
    use aam::{Limit, Limits};
    use clap::{CommandFactory, Parser};

    use super::{ChartArgs, ChartWhat, Cli, TuneArgs, TuneWhat, Verb};

    #[test]
    fn arguments_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn limits_are_the_same_everywhere_and_their_defaults_those_of_the_library() {
        for words in [
            &["aam", "info", "a"][..],
            &["aam", "convert", "a"],
            &["aam", "render", "a", "-o", "b"],
            &["aam", "view", "a"],
            &["aam", "simulate", "a"],
            &["aam", "chart", "shadows", "a", "-o", "b"],
            &["aam", "tune", "shadows", "a", "--max-error", "0.1"],
            &["aam", "tune", "physics", "a"],
            &["aam", "decompose", "a", "-o", "b"],
            &["aam", "check", "a"],
            &["aam", "fmt", "a"],
        ] {
            let limits = |more: &[&str]| {
                let words: Vec<&str> = words.iter().chain(more).copied().collect();
                match Cli::try_parse_from(words).expect("arguments").verb {
                    Verb::Convert(args) => args.read.limits.limits(),
                    Verb::Decompose(args) => args.read.limits.limits(),
                    Verb::Render(args) => args.read.limits.limits(),
                    Verb::View(args) => args.read.limits.limits(),
                    Verb::Info(args) => args.read.limits.limits(),
                    Verb::Simulate(args) => args.read.limits.limits(),
                    Verb::Check(args) => args.limits.limits(),
                    Verb::Fmt(args) => args.limits.limits(),
                    Verb::Chart(ChartArgs { what: ChartWhat::Shadows(args) }) => args.read.limits.limits(),
                    Verb::Tune(TuneArgs { what: TuneWhat::Shadows(args) }) => args.read.limits.limits(),
                    Verb::Tune(TuneArgs { what: TuneWhat::Physics(args) }) => args.read.limits.limits(),
                    Verb::Completions(_) => unreachable!("it reads nothing"),
                }
            };
            assert_eq!(limits(&[]), Limits::DEFAULT, "{words:?}");
            for limit in Limit::ALL {
                let changed = limits(&[limit.option(), "7"]);
                assert_eq!(changed.of(limit), 7, "{words:?} {}", limit.option());
                let others = Limit::ALL.into_iter().filter(|other| *other != limit);
                assert!(others.into_iter().all(|other| changed.of(other) == Limits::DEFAULT.of(other)));
            }
        }
    }
}
