//! Wavefront OBJ with MTL, in and out.

mod material;
mod mtl;
mod numbers;
mod parse;
mod read;
mod statements;
mod textures;
mod write;
mod write_mtl;

#[cfg(test)]
mod tests;

pub(crate) use read::import;
pub(crate) use write::export;
