//! Casters that a source does not see whole: their shadows are missing or cut.

use glam::Vec3;

use super::{ShadowSource, Shadows};
use crate::{Camera, Mesh, NodeId, Scene};

/// A caster that reaches out of a source's volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CasterOutside {
    /// The caster.
    pub node: NodeId,
    /// Its middle is outside too.
    pub middle: bool,
    /// All of it is outside: it casts nothing.
    pub wholly: bool,
}

impl Shadows {
    /// The casters that reach out of a volume, in the order of the nodes, at the first frame.
    pub fn casters_outside(&self, scene: &Scene, volume: &Camera) -> Vec<CasterOutside> {
        let clip = volume.projection_matrix(1.0) * volume.view();
        let inside = |point: Vec3| {
            let seen = clip * point.extend(1.0);
            seen.w > 0.0 && seen.x.abs() <= seen.w && seen.y.abs() <= seen.w && (0.0..=seen.w).contains(&seen.z)
        };
        let world = scene.world_transforms();
        let (visible, casts) = (scene.visibility(), self.casters.of(&scene.nodes));
        let outside = |index: usize, mesh: &Mesh| {
            if mesh.positions.is_empty() {
                return None;
            }
            let at = |point: &Vec3| inside(world[index].transform_point3(*point));
            // A volume is convex: what has its corners inside is inside.
            if mesh.bounds.corners().iter().all(at) {
                return None;
            }
            let seen = mesh.positions.iter().filter(|point| at(point)).count();
            (seen < mesh.positions.len()).then(|| CasterOutside {
                node: NodeId(index as u32),
                middle: !at(&mesh.bounds.center()),
                wholly: seen == 0,
            })
        };
        let mesh = |index: usize| scene.nodes[index].mesh.and_then(|id| scene.meshes.get(id.index()));
        (0..scene.nodes.len())
            .filter(|&index| visible[index] && casts[index])
            .filter_map(|index| outside(index, mesh(index)?))
            .collect()
    }

    /// A sentence about the casters that a source with a volume of its own does not see whole.
    pub fn cut_casters(&self, scene: &Scene, source: &ShadowSource) -> Option<String> {
        let casters = self.casters_outside(scene, source.volume.as_ref()?);
        let some = |count: usize, one: &str, many: &str| match count {
            1 => format!("1 caster {one}"),
            _ => format!("{count} casters {many}"),
        };
        let outside = casters.iter().filter(|caster| caster.middle).count();
        let what = match (outside, casters.len() - outside) {
            (0, 0) => return None,
            (0, cut) => format!("{} out of its volume", some(cut, "reaches", "reach")),
            (outside, 0) => format!("{} outside of its volume", some(outside, "stands", "stand")),
            (outside, cut) => {
                let cut = some(cut, "reaches", "reach");
                format!("{} outside of its volume and {cut} out of it", some(outside, "stands", "stand"))
            }
        };
        Some(format!("{what}: there nothing casts and all is lit; without a volume of its own it sees them all"))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Affine3A;

    use super::*;
    use crate::{Aabb, Members, MeshId, Node, Projection, ShadowSettings};

    #[test]
    fn casters_that_reach_out_of_a_volume_are_counted() {
        let positions = vec![Vec3::splat(-0.5), Vec3::splat(0.5)];
        let mesh = Mesh { bounds: Aabb::of(positions.clone()), positions, ..Mesh::default() };
        let node = |x: f32| Node {
            name: String::new(),
            parent: None,
            local: Affine3A::from_translation(Vec3::X * x),
            mesh: Some(MeshId(0)),
            visible: true,
        };
        let scene = Scene {
            nodes: [0.0, 1.8, 2.2, 3.0, -1.8].map(node).into(),
            meshes: vec![Arc::new(mesh)],
            ..Scene::default()
        };
        let volume = Camera {
            name: String::new(),
            position: Vec3::Z * 5.0,
            target: Vec3::ZERO,
            up: Vec3::Y,
            projection: Projection::Orthographic { height: 4.0 },
            near: 1.0,
            far: 9.0,
        };
        let shadows = Shadows::default();
        let outside = |index: u32, middle, wholly| CasterOutside { node: NodeId(index), middle, wholly };
        assert_eq!(
            shadows.casters_outside(&scene, &volume),
            [outside(1, false, false), outside(2, true, false), outside(3, true, true), outside(4, false, false)]
        );
        let source = ShadowSource { volume: Some(volume), ..ShadowSource::of_light(0, ShadowSettings::default()) };
        let told = shadows.cut_casters(&scene, &source).unwrap();
        assert!(told.starts_with("2 casters stand outside of its volume and 2 casters reach out of it: "), "{told}");
        let one = Shadows { casters: Members::Only(vec![NodeId(4)]), ..Shadows::default() };
        assert!(one.cut_casters(&scene, &source).unwrap().starts_with("1 caster reaches out of its volume: "));
        let none = Shadows { casters: Members::Only(vec![NodeId(0)]), ..Shadows::default() };
        assert_eq!(none.cut_casters(&scene, &source), None);
        assert_eq!(shadows.cut_casters(&scene, &ShadowSource { volume: None, ..source }), None, "it is fitted");
    }
}
