//! Shadows: who casts and receives them, where from, and how they are computed.

mod parameter;
mod settings;
mod usual;

use crate::{Camera, NodeId};

pub use parameter::{ParameterError, Range as ParameterRange, ShadowParameter};
pub use settings::{
    BlurKind, CasterFaces, DepthMetric, PcfKernel, ShadowFilter, ShadowLayout, ShadowSettings, ShadowTechnique,
};

/// Which objects take part in shadows, and which sources cast them.
///
/// A source is not a light: VR3Lib's darken the diffuse and specular terms of every light, and so do those here
/// that belong to none. Ambient light and emission are never darkened.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shadows {
    /// Where shadows come from. Several multiply.
    pub sources: Vec<ShadowSource>,
    /// What casts; children cast with their parents.
    pub casters: Members,
    /// What is darkened; children are darkened with their parents.
    pub receivers: Members,
    /// What may be left out of the maps.
    pub culling: ShadowCulling,
    /// Displaced surfaces cast as they are drawn, not as the flat mesh that they are made from.
    pub displaced: bool,
}

/// A set of objects.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Members {
    /// Every object.
    #[default]
    All,
    /// These nodes and all below them.
    Only(Vec<NodeId>),
}

/// What may be left out where it cannot be seen. None of it changes the picture of closed meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShadowCulling {
    /// Triangles that face away from the source. Surfaces that are open or wound the wrong way lose their shadow.
    pub back_faces: bool,
    /// Objects wholly outside of the source's volume.
    pub casters: bool,
    /// Sources whose volume the camera does not see: neither drawn nor filtered.
    pub sources: bool,
}

impl Default for ShadowCulling {
    /// Objects and sources, which is always exact.
    fn default() -> Self {
        Self { back_faces: false, casters: true, sources: true }
    }
}

/// Where a shadow comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowSource {
    /// Name.
    pub name: String,
    /// Off: it costs nothing and casts nothing.
    pub enabled: bool,
    /// The position in [`Scene::lights`](crate::Scene::lights) of the light that it darkens; `None` darkens all.
    pub light: Option<usize>,
    /// What the source sees, through a square window. Outside everything is lit. `None`, which needs a light, fits it
    /// around what casts and receives.
    pub volume: Option<Camera>,
    /// How it is computed.
    pub settings: ShadowSettings,
}

impl ShadowSource {
    /// The shadow of a light, in a volume that fits.
    pub fn of_light(light: usize, settings: ShadowSettings) -> Self {
        Self { name: String::new(), enabled: true, light: Some(light), volume: None, settings }
    }
}

impl Members {
    /// Whether each of a scene's nodes is a member.
    pub fn of(&self, nodes: &[crate::Node]) -> Vec<bool> {
        let Self::Only(roots) = self else { return vec![true; nodes.len()] };
        let roots: std::collections::HashSet<NodeId> = roots.iter().copied().collect();
        let mut members: Vec<bool> = Vec::with_capacity(nodes.len());
        for (index, node) in (0..).zip(nodes) {
            let above = node.parent.and_then(|parent| members.get(parent.index()).copied()).unwrap_or(false);
            members.push(above || roots.contains(&NodeId(index)));
        }
        members
    }
}
