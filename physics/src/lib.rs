//! Rigid bodies: the `PHYSICS` of documents, simulated with rapier3d, giving poses back to a scene.
//!
//! - [`PhysicsMesh`] is what a document says about one object: how it moves, its material, its mass and its collision
//!   shape. It never changes, and any number of simulators share it.
//! - [`Simulator`] holds registered objects. [`Simulator::prepare`] copies them, with their initial places, into a
//!   world of their own; [`Simulator::start`] lets them move; [`Simulator::end`] forgets all of it. The scene is never
//!   changed: [`Simulator::world_transforms`] says where its nodes are meanwhile.
//! - [`Background`] steps a simulator on a thread of its own, in real time, and gives interpolated poses without waiting.
//! - [`DropTest`] says how far the motion of a coarse collision shape is from that of the exact surface.
//! - [`Film`] is a document that plays what was simulated.
//! - [`exploded`] is a document that shows collision shapes, moved apart.
//!
//! Lengths are metres, masses kilograms, times seconds, angles radians. Steps have a fixed length, and the same scene
//! gives the same poses bit for bit on every run of a program on one kind of machine; [`Simulator::hash`] tells.

mod background;
mod collider;
mod contact;
mod drop;
mod error;
mod explode;
mod film;
mod friction;
mod grab;
mod joint;
mod mesh;
mod moments;
mod motion;
mod pose;
mod settings;
mod simulator;
mod world;

pub use aam::document::{BodyMode, Primitive};
pub use background::{Background, Collected};
pub use contact::Contact;
pub use drop::{DropErrors, DropTest};
pub use error::{Divergence, PhysicsError, What};
pub use explode::exploded;
pub use film::Film;
pub use joint::{Joint, JointKind};
pub use mesh::{Material, PhysicsMesh, Shape, physics_meshes};
pub use moments::Moments;
pub use pose::{Places, Pose, Poses};
pub use settings::{Continuous, Settings};
pub use simulator::{BodyState, Registration, Simulator};
