//! Shadows: who casts and receives them, where from, and how they are computed.

mod outside;
mod parameter;
mod settings;
mod usual;

use crate::{Camera, NodeId};

pub use outside::CasterOutside;
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

impl Shadows {
    /// The same with so many nodes before all others.
    #[must_use]
    pub fn below(mut self, nodes: u32) -> Self {
        for members in [&mut self.casters, &mut self.receivers] {
            if let Members::Only(ids) = members {
                ids.iter_mut().for_each(|id| id.0 = id.0.saturating_add(nodes));
            }
        }
        self
    }
}

impl ShadowSource {
    /// The shadow of a light, in a volume that fits.
    pub fn of_light(light: usize, settings: ShadowSettings) -> Self {
        Self { name: String::new(), enabled: true, light: Some(light), volume: None, settings }
    }
}

impl Members {
    /// The same with or without a node and all below it. What stands above a node that is no member is none either.
    #[must_use]
    pub fn with(&self, nodes: &[crate::Node], changed: NodeId, member: bool) -> Self {
        let mut members = self.of(nodes);
        let mut below = vec![false; nodes.len()];
        for (index, node) in nodes.iter().enumerate() {
            let above = node.parent.and_then(|parent| below.get(parent.index()).copied()).unwrap_or(false);
            below[index] = above || index == changed.index();
            if below[index] {
                members[index] = member;
            }
        }
        // Parents stand before their children.
        for (index, node) in nodes.iter().enumerate().rev() {
            if let (false, Some(above)) =
                (members[index], node.parent.and_then(|parent| members[..index].get_mut(parent.index())))
            {
                *above = false;
            }
        }
        if members.iter().all(|member| *member) {
            return Self::All;
        }
        let topmost = |index: usize| {
            let above = nodes[index].parent.and_then(|parent| members.get(parent.index()).copied());
            members[index] && !above.unwrap_or(false)
        };
        Self::Only((0..nodes.len()).filter(|index| topmost(*index)).map(|index| NodeId(index as u32)).collect())
    }

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

#[cfg(test)]
mod tests {
    use glam::Affine3A;

    use super::*;
    use crate::Node;

    #[test]
    fn members_come_and_go_with_what_is_below_them() {
        let node = |parent: Option<u32>| Node {
            name: String::new(),
            parent: parent.map(NodeId),
            local: Affine3A::IDENTITY,
            mesh: None,
            visible: true,
        };
        // 0 ─ 1 ─ 2, 0 ─ 3, and 4 alone.
        let nodes = [node(None), node(Some(0)), node(Some(1)), node(Some(0)), node(None)];
        let only = |ids: &[u32]| Members::Only(ids.iter().copied().map(NodeId).collect());
        assert_eq!(only(&[1]).of(&nodes), [false, true, true, false, false], "children go with their parents");
        let less = Members::All.with(&nodes, NodeId(1), false);
        assert_eq!(less, only(&[3, 4]));
        assert_eq!(less.with(&nodes, NodeId(2), true), only(&[2, 3, 4]));
        assert_eq!(less.with(&nodes, NodeId(0), true), Members::All);
        assert_eq!(only(&[]).with(&nodes, NodeId(4), true), only(&[4]));
        let shadows = Shadows { casters: only(&[1]), ..Shadows::default() }.below(2);
        assert_eq!((shadows.casters, shadows.receivers), (only(&[3]), Members::All));
    }
}
