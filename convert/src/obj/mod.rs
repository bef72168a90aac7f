//! Wavefront OBJ with MTL, in and out.

mod material;
mod mtl;
mod parse;
mod read;
mod statements;
mod textures;

pub(crate) use read::import;
