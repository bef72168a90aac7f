//! Lights as the shaders see them.

/// Most lights that a frame can have.
pub const MAX_LIGHTS: usize = 64;
