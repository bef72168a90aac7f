//! Which casters a map is drawn with.

use std::ops::Range;

use aam_scene::{Aabb, Scene};
use glam::{DMat4, DVec4, Vec3};

use crate::draws::{Batch, DrawList, Instance};

/// A run of triangles in a map: a batch of the list's, and some of its instances.
#[derive(Clone, Debug)]
pub(crate) struct CasterDraw {
    pub batch: BatchId,
    pub instances: Range<u32>,
}

/// A batch of a draw list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BatchId {
    Opaque(usize),
    Blended(usize),
    Unseen(usize),
}

impl BatchId {
    pub(crate) fn of(self, list: &DrawList) -> &Batch {
        match self {
            Self::Opaque(index) => &list.opaque[index],
            Self::Blended(index) => &list.blended[index],
            Self::Unseen(index) => &list.unseen[index],
        }
    }

    fn all(list: &DrawList) -> impl Iterator<Item = Self> + use<> {
        let opaque = (0..list.opaque.len()).map(Self::Opaque);
        let blended = (0..list.blended.len()).map(Self::Blended);
        opaque.chain(blended).chain((0..list.unseen.len()).map(Self::Unseen))
    }
}

/// The box in the world around each instance.
pub(crate) fn instance_boxes(scene: &Scene, list: &DrawList) -> Vec<Aabb> {
    let mut boxes = vec![Aabb::EMPTY; list.instances.len()];
    for drawn in &list.meshes {
        let bounds = scene.meshes[drawn.mesh].bounds;
        for instance in drawn.instances.clone() {
            boxes[instance as usize] = bounds.transformed(&placed(&list.instances[instance as usize]));
        }
    }
    boxes
}

pub(crate) fn placed(instance: &Instance) -> glam::Affine3A {
    let [x, y, z] = instance.rows;
    let column = |i: usize| Vec3::new(x[i], y[i], z[i]);
    glam::Affine3A::from_cols(column(0).into(), column(1).into(), column(2).into(), column(3).into())
}

/// What is drawn into a view's map. `casts` says it of each instance.
pub(crate) fn caster_draws(list: &DrawList, casts: impl Fn(u32) -> bool) -> Vec<CasterDraw> {
    let mut draws = Vec::new();
    for batch in BatchId::all(list) {
        let instances = batch.of(list).instances.clone();
        let mut run: Option<Range<u32>> = None;
        for instance in instances.filter(|instance| casts(*instance)) {
            match &mut run {
                Some(run) if run.end == instance => run.end += 1,
                _ => {
                    draws.extend(run.take().map(|instances| CasterDraw { batch, instances }));
                    run = Some(instance..instance + 1);
                }
            }
        }
        draws.extend(run.map(|instances| CasterDraw { batch, instances }));
    }
    draws
}

/// Whether a box may reach into a volume, given world to clip space (depth 0 to 1). Never wrong about one that does.
pub(crate) fn may_reach(aabb: &Aabb, clip: &DMat4) -> bool {
    if aabb.is_empty() {
        return false;
    }
    let corners: [DVec4; 8] = std::array::from_fn(|corner| {
        let pick = |bit: usize, low: f32, high: f32| f64::from(if corner >> bit & 1 == 0 { low } else { high });
        *clip
            * DVec4::new(
                pick(0, aabb.min.x, aabb.max.x),
                pick(1, aabb.min.y, aabb.max.y),
                pick(2, aabb.min.z, aabb.max.z),
                1.0,
            )
    });
    let outside = |beyond: fn(&DVec4) -> bool| corners.iter().all(beyond);
    !(outside(|c| c.x < -c.w)
        || outside(|c| c.x > c.w)
        || outside(|c| c.y < -c.w)
        || outside(|c| c.y > c.w)
        || outside(|c| c.z < 0.0)
        || outside(|c| c.z > c.w))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn boxes_outside_of_a_plane_are_left_out() {
        let clip = glam::camera::rh::proj::directx::orthographic(-1.0, 1.0, -1.0, 1.0, 0.0, 2.0).as_dmat4();
        let unit = |center: Vec3| Aabb { min: center - 0.5, max: center + 0.5 };
        for (center, reaches) in [
            (Vec3::new(0.0, 0.0, -1.0), true),
            (Vec3::new(1.4, 0.0, -1.0), true),
            (Vec3::new(1.6, 0.0, -1.0), false),
            (Vec3::new(0.0, 0.0, 0.6), false),
            (Vec3::new(0.0, -1.6, -1.0), false),
            (Vec3::new(0.0, 0.0, -2.6), false),
        ] {
            assert_eq!(may_reach(&unit(center), &clip), reaches, "{center}");
        }
        assert!(!may_reach(&Aabb::EMPTY, &clip));
        // What lies behind a pyramid's tip is outside, though its projection is not.
        let pyramid = glam::camera::rh::proj::directx::perspective(1.5, 1.0, 0.1, 10.0).as_dmat4();
        assert!(!may_reach(&unit(Vec3::new(0.0, 0.0, 3.0)), &pyramid));
        assert!(may_reach(&unit(Vec3::ZERO), &(pyramid * DMat4::from_translation(DVec3::new(0.0, 0.0, -3.0)))));
    }
}
