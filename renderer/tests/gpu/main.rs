//! Pictures against closed forms, on whatever adapter there is.

mod background;
mod common;
mod conventions;
mod corpus;
mod costs;
mod displacement;
mod environment;
mod layers;
mod lighting;
mod overlays;
mod robustness;
mod shadows;
mod transparency;
