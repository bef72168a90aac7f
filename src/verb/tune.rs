//! `aam tune`: the cheapest settings that are accurate enough for a file.

mod physics;
mod shadows;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueHint};

use crate::args;
use crate::cli::{ReadArgs, TuneArgs, TuneWhat};
use crate::failure::Failure;
use crate::terminal::Terminal;

const EXAMPLES: &str = "\
Examples:
  aam tune --physics chair.glb                     how many convex hulls are enough
  aam tune --physics chair.glb -o chair.aam        and writes the bodies
  aam tune --physics chair.glb --max-error 0.02 --json

Each object is dropped on a bed of pegs, with its exact surface and with 1, 2, 4 … hulls. Two errors count: how far its
path is off in the half second after the first touch, and how far it moves from where the exact one rests.
docs/techniques/rigid-bodies.md says more.

Exit codes: 0 done, 1 an object needs more hulls than --hulls allows, 2 it could not be done.";

#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct TunePhysicsArgs {
    /// File to tune for: .aam .gltf .glb .obj .stl .ply
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: PathBuf,
    /// File to write with the bodies that were chosen; the extension decides its format
    #[arg(short, long, value_name = "PATH", value_hint = ValueHint::FilePath)]
    output: Option<PathBuf>,
    /// The largest error of path and rest, as a part of the object's diagonal
    #[arg(long, value_name = "E", default_value = "0.05", value_parser = args::fraction)]
    max_error: f32,
    /// The most hulls to try
    #[arg(long, value_name = "N", default_value = "64", value_parser = clap::value_parser!(u32).range(1..=1024))]
    hulls: u32,
    /// From how many different turns each object is dropped
    #[arg(long, value_name = "N", default_value = "9", value_parser = clap::value_parser!(u32).range(1..=1000))]
    drops: u32,
    /// As JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

pub(crate) fn run(args: &TuneArgs, terminal: &Terminal) -> Result<ExitCode, Failure> {
    match &args.what {
        TuneWhat::Shadows(args) => shadows::run(args, terminal),
        TuneWhat::Physics(args) => physics::run(args, terminal),
    }
}
