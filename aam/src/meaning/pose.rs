//! Where objects are: local transforms, hierarchy, and both over time.
//!
//! Objects of a character are in their own coordinates and `TM:` (or keys) takes them to their parent. In every other
//! document vertices are world coordinates and `Par:` only names a parent: all transforms are the identity.

use std::collections::{BTreeMap, btree_map};

use glam::{Affine3A, DMat3, DVec3};

use super::tracks::Curves;
use crate::document::{AnimationMode, Header, NodeTransform, Object};
use crate::{Document, Finding, Severity};

/// The transform from an object to its parent that `TM:` and `Mir:` say.
///
/// A point goes from object to parent as `p_parent = (p ⊙ scale)·R + position` with row vectors and the rows of R as
/// written. `Mir: 1` says that the whole reflects: where scale and R do not reflect on their own, all three axes are
/// negated, since that is how 3ds Max splits a reflecting matrix (Shoemake, "Polar Matrix Decomposition", Graphics Gems
/// IV, 1994). `Piv:` moves nothing: the origin of `TM` is the pivot, and the vertices are already given relative to it
/// (in the one real character file every `Piv` is zero). Numbers that are not finite count as those of the identity.
pub fn local_transform(node: &NodeTransform) -> Affine3A {
    Rest::of(node).compose(None, None, None)
}

/// `TM` and `Mir`, made harmless.
#[derive(Clone, Debug, PartialEq)]
struct Rest {
    position: DVec3,
    /// As a matrix for column vectors: the rows of R are its columns.
    rotation: DMat3,
    scale: DVec3,
    mirrored: bool,
}

impl Default for Rest {
    fn default() -> Self {
        Self { position: DVec3::ZERO, rotation: DMat3::IDENTITY, scale: DVec3::ONE, mirrored: false }
    }
}

impl Rest {
    fn of(node: &NodeTransform) -> Self {
        let finite = |values: [f32; 3], otherwise: f64| {
            DVec3::from(values.map(|value| if value.is_finite() { f64::from(value) } else { otherwise }))
        };
        let rows = node.rotation.map(|row| DVec3::from(row.map(f64::from)));
        let rotation = DMat3::from_cols(rows[0], rows[1], rows[2]);
        Self {
            position: finite(node.position, 0.0),
            rotation: if rotation.is_finite() { rotation } else { DMat3::IDENTITY },
            scale: finite(node.scale, 1.0),
            mirrored: node.mirrored,
        }
    }

    /// The transform, with any part replaced. One that leaves the range of numbers is the identity.
    fn compose(&self, position: Option<DVec3>, rotation: Option<DMat3>, scale: Option<DMat3>) -> Affine3A {
        let scale = scale.unwrap_or(DMat3::from_diagonal(self.scale));
        let mut linear = rotation.unwrap_or(self.rotation) * scale;
        if self.mirrored && linear.determinant() > 0.0 {
            linear = -linear;
        }
        let position = position.unwrap_or(self.position);
        let transform = Affine3A::from_mat3_translation(linear.as_mat3(), position.as_vec3());
        if transform.is_finite() { transform } else { Affine3A::IDENTITY }
    }
}

/// How an object moves against its parent. The default does not move and is the identity.
///
/// Keys replace the part of `TM` that they are of, as absolute local values. Positions, scales and sampled rotations are
/// linear between keys (rotations on the shortest way; samples stand at every frame, so that nothing is invented at
/// whole frames), `RtIPA` is linear in the Euler angles, which turn about X, then Y, then Z. Bézier keys are cubic
/// Hermite curves whose tangents are in units a frame, both in the direction of time. `RtTcb` is the Kochanek–Bartels
/// spline on the logarithms of quaternions. Axis and angle turn right-handed. Outside its keys a track holds its first or
/// last value; keys that are not finite are left out; of several keys at one frame the last counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    rest: Rest,
    curves: Curves,
}

impl Motion {
    /// The motion that an object's `TM:` and keys say.
    pub fn of(object: &Object) -> Self {
        Self {
            rest: object.node.as_ref().map(Rest::of).unwrap_or_default(),
            curves: object.keys.as_ref().map(|tracks| Curves::of(tracks)).unwrap_or_default(),
        }
    }

    /// The transform from the object to its parent at a frame. A frame that is not a number counts as 0.
    pub fn at(&self, frame: f32) -> Affine3A {
        let frame = if frame.is_nan() { 0.0 } else { f64::from(frame) };
        let Curves { position, rotation, scale } = &self.curves;
        self.rest.compose(
            position.as_ref().map(|curve| curve.at(frame)),
            rotation.as_ref().map(|curve| curve.at(frame)),
            scale.as_ref().map(|curve| curve.at(frame)),
        )
    }

    /// The first and the last frame that has a key.
    pub fn frame_range(&self) -> Option<(f32, f32)> {
        let Curves { position, rotation, scale } = &self.curves;
        [
            position.as_ref().map(|curve| curve.range()),
            rotation.as_ref().map(|curve| curve.range()),
            scale.as_ref().map(|curve| curve.range()),
        ]
        .into_iter()
        .flatten()
        .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
        .map(|(first, last)| (first as f32, last as f32))
    }
}

/// Whether objects are in coordinates of their own: in a `Keyframe` animation, and under the header of a character or
/// avatar unless its frames are `Full`.
pub fn has_local_coordinates(document: &Document) -> bool {
    match document.geometry.animation {
        AnimationMode::Keyframe => true,
        AnimationMode::None => matches!(document.header, Some(Header::Character | Header::Avatar)),
        AnimationMode::Full => false,
    }
}

/// How each object of frame 0 moves; the identity for all where vertices are world coordinates.
pub fn object_motions(document: &Document) -> Vec<Motion> {
    let local = has_local_coordinates(document);
    document.objects().iter().map(|object| if local { Motion::of(object) } else { Motion::default() }).collect()
}

/// The transform from each object of frame 0 to the world at a frame.
pub fn world_transforms(document: &Document, hierarchy: &Hierarchy, frame: f32) -> Vec<Affine3A> {
    let mut world: Vec<Affine3A> = object_motions(document).iter().map(|motion| motion.at(frame)).collect();
    if has_local_coordinates(document) {
        for &object in &hierarchy.order {
            if let Some(parent) = hierarchy.parents[object] {
                world[object] = world[parent] * world[object];
            }
        }
    }
    world
}

/// The first and last frame of the animation, or `None` if nothing moves. A `Full` animation runs over the positions of
/// its frames, whatever their numbers; other animations over their keys.
pub fn frame_range(document: &Document) -> Option<(f32, f32)> {
    let range = if document.geometry.animation == AnimationMode::Full {
        Some((0.0, document.geometry.frames.len().saturating_sub(1) as f32))
    } else {
        let ranges = object_motions(document).into_iter().filter_map(|motion| motion.frame_range());
        ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    };
    range.filter(|(first, last)| first < last)
}

/// `FPS:` if it is a usable number, else 30.
pub fn frames_per_second(document: &Document) -> f32 {
    document.geometry.frames_per_second.filter(|fps| fps.is_finite() && *fps > 0.0).unwrap_or(30.0)
}

/// Who is whose parent, checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hierarchy {
    /// For each object of frame 0 its parent's position, if it has one.
    pub parents: Vec<Option<usize>>,
    /// All positions, parents before children, otherwise in file order.
    pub order: Vec<usize>,
    /// Cycles that were cut, parents that do not exist, ids that stand twice.
    pub findings: Vec<Finding>,
}

impl Hierarchy {
    /// The hierarchy of the objects of a frame. A parent may stand after its children. Of several objects with one id
    /// the first is meant. In a cycle the object that stands first in the file loses its parent.
    pub fn of(objects: &[Object]) -> Self {
        let mut hierarchy = Self::default();
        let mut by_id = BTreeMap::new();
        for (index, object) in objects.iter().enumerate() {
            match by_id.entry(object.id) {
                btree_map::Entry::Vacant(place) => {
                    place.insert(index);
                }
                btree_map::Entry::Occupied(first) => {
                    let other = &objects[*first.get()];
                    let message =
                        format!("object \"{}\" has the same id; parents and bodies mean that one", other.name);
                    hierarchy.report(object, "hierarchy/duplicate-id", message);
                }
            }
        }
        for object in objects {
            let parent = by_id.get(&object.parent).copied();
            if parent.is_none() && object.parent != -1 {
                let message = format!("parent {} does not exist; the object has none", object.parent);
                hierarchy.report(object, "hierarchy/missing-parent", message);
            }
            hierarchy.parents.push(if object.parent == -1 { None } else { parent });
        }
        hierarchy.cut_cycles(objects);
        hierarchy.sort();
        hierarchy
    }

    fn report(&mut self, object: &Object, code: &'static str, message: String) {
        let subject = format!("object {} \"{}\"", object.id, object.name);
        self.findings.push(Finding { code, severity: Severity::Warning, position: None, subject, message });
    }

    fn cut_cycles(&mut self, objects: &[Object]) {
        // The walk in which each object was first met, counted from 1.
        let mut walk_of = vec![0_usize; objects.len()];
        for start in 0..objects.len() {
            let mut met = None;
            let mut at = Some(start);
            while let Some(object) = at {
                if walk_of[object] != 0 {
                    met = Some(object).filter(|&object| walk_of[object] == start + 1);
                    break;
                }
                walk_of[object] = start + 1;
                at = self.parents[object];
            }
            let Some(met) = met else {
                continue;
            };
            let cycle: Vec<usize> =
                std::iter::successors(Some(met), |&object| self.parents[object].filter(|&parent| parent != met))
                    .collect();
            let first = cycle.iter().copied().min().unwrap_or(met);
            self.parents[first] = None;
            let message = match cycle.len() {
                1 => "it is its own parent; it now has none".to_owned(),
                count => format!("its {count} ancestors lead back to itself; it now has no parent"),
            };
            self.report(&objects[first], "hierarchy/cycle", message);
        }
    }

    fn sort(&mut self) {
        let mut placed = vec![false; self.parents.len()];
        let mut waiting = Vec::new();
        for start in 0..self.parents.len() {
            let mut at = Some(start);
            while let Some(object) = at.filter(|&object| !placed[object]) {
                placed[object] = true;
                waiting.push(object);
                at = self.parents[object];
            }
            self.order.extend(waiting.drain(..).rev());
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{Mat3, Vec3};

    use super::*;
    use crate::document::{Flagged, Frame, Geometry, PositionSample, Track};

    fn node(rotation: [[f32; 3]; 3], position: [f32; 3], scale: [f32; 3]) -> NodeTransform {
        NodeTransform { rotation, position, scale, ..NodeTransform::default() }
    }

    const QUARTER: [[f32; 3]; 3] = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn a_point_is_scaled_then_turned_then_moved() {
        let transform = local_transform(&node(QUARTER, [10.0, 20.0, 30.0], [2.0, 3.0, 4.0]));
        // (1,1,1) ⊙ scale = (2,3,4); times rows: 2·(0,1,0) + 3·(−1,0,0) + 4·(0,0,1).
        assert_eq!(transform.transform_point3(Vec3::ONE), Vec3::new(7.0, 22.0, 34.0));
        assert_eq!(local_transform(&NodeTransform::default()), Affine3A::IDENTITY);
    }

    #[test]
    fn a_mirrored_object_is_reflected_exactly_once() {
        let mut plain = node(QUARTER, [1.0, 0.0, 0.0], [2.0, 2.0, 2.0]);
        plain.mirrored = true;
        let transform = local_transform(&plain);
        assert_eq!(transform.transform_point3(Vec3::X), Vec3::new(1.0, -2.0, 0.0), "negated, moved as before");
        assert!(Mat3::from(transform.matrix3).determinant() < 0.0);
        // Already reflecting: nothing to add.
        plain.scale = [-2.0, 2.0, 2.0];
        assert_eq!(local_transform(&plain).transform_point3(Vec3::X), Vec3::new(1.0, -2.0, 0.0));
        assert_eq!(local_transform(&plain).transform_point3(Vec3::Z), Vec3::new(1.0, 0.0, 2.0));
        // A scale of zero reflects nothing.
        plain.scale = [0.0; 3];
        assert!(local_transform(&plain).is_finite());
    }

    #[test]
    fn numbers_that_are_not_finite_are_those_of_the_identity() {
        let bad = node([[f32::NAN; 3]; 3], [1.0, f32::INFINITY, 2.0], [f32::NAN, 2.0, 1.0]);
        let expected =
            Affine3A::from_mat3_translation(Mat3::from_diagonal(Vec3::new(1.0, 2.0, 1.0)), Vec3::new(1.0, 0.0, 2.0));
        assert_eq!(local_transform(&bad), expected);
        let huge = node([[1e30; 3], [1e30, -1e30, 0.0], [0.0, 0.0, 1e30]], [0.0; 3], [1e30; 3]);
        assert_eq!(local_transform(&huge), Affine3A::IDENTITY);
    }

    fn object(id: i32, parent: i32) -> Object {
        Object { id, parent, name: format!("o{id}").into(), ..Object::default() }
    }

    fn moved(id: i32, parent: i32, x: f32) -> Object {
        let transform = NodeTransform { position: [x, 0.0, 0.0], scale: [2.0; 3], ..NodeTransform::default() };
        Object { node: Some(transform), ..object(id, parent) }
    }

    fn document(animation: AnimationMode, objects: Vec<Object>) -> Document {
        let frames = vec![Frame { objects, ..Frame::default() }];
        Document { geometry: Geometry { animation, frames, ..Geometry::default() }, ..Document::default() }
    }

    fn origins(document: &Document, frame: f32) -> Vec<Vec3> {
        let hierarchy = Hierarchy::of(document.objects());
        world_transforms(document, &hierarchy, frame).iter().map(|world| Vec3::from(world.translation)).collect()
    }

    #[test]
    fn parents_carry_their_children_wherever_they_stand() {
        // The grandchild first, then the child, then the parent.
        let objects = vec![moved(2, 1, 1.0), moved(1, 0, 10.0), moved(0, -1, 100.0)];
        let document = document(AnimationMode::Keyframe, objects);
        let expected = [Vec3::X * (100.0 + 2.0 * 10.0 + 4.0), Vec3::X * 120.0, Vec3::X * 100.0];
        assert_eq!(origins(&document, 0.0), expected);
        assert_eq!(Hierarchy::of(document.objects()).order, [2, 1, 0]);
    }

    #[test]
    fn static_documents_are_in_world_coordinates() {
        for animation in [AnimationMode::None, AnimationMode::Full] {
            let document = document(animation, vec![moved(0, -1, 5.0), moved(1, 0, 5.0)]);
            assert_eq!(origins(&document, 0.0), [Vec3::ZERO; 2]);
        }
        let mut character = document(AnimationMode::None, vec![moved(0, -1, 5.0)]);
        character.header = Some(Header::Character);
        assert_eq!(origins(&character, 0.0), [Vec3::X * 5.0]);
    }

    #[test]
    fn wrong_parents_are_cut_and_reported() {
        let cases = [
            (vec![(0, 0)], vec![None], vec!["hierarchy/cycle"]),
            (vec![(0, 1), (1, 2), (2, 0), (3, 0)], vec![None, Some(2), Some(0), Some(0)], vec!["hierarchy/cycle"]),
            (vec![(5, 2), (1, 2), (2, 1)], vec![Some(2), None, Some(1)], vec!["hierarchy/cycle"]),
            (vec![(0, 7)], vec![None], vec!["hierarchy/missing-parent"]),
            (vec![(0, -1), (0, -1), (1, 0)], vec![None, None, Some(0)], vec!["hierarchy/duplicate-id"]),
            (vec![(-1, -1), (1, -1)], vec![None, None], vec![]),
        ];
        for (pairs, parents, codes) in cases {
            let objects: Vec<_> = pairs.iter().map(|&(id, parent)| object(id, parent)).collect();
            let hierarchy = Hierarchy::of(&objects);
            assert_eq!(hierarchy.parents, parents, "{pairs:?}");
            let found: Vec<_> = hierarchy.findings.iter().map(|finding| finding.code).collect();
            assert_eq!(found, codes, "{pairs:?}");
            let mut seen = vec![false; pairs.len()];
            for &object in &hierarchy.order {
                assert!(
                    hierarchy.parents[object].is_none_or(|parent| seen[parent]),
                    "{pairs:?}: {:?}",
                    hierarchy.order
                );
                seen[object] = true;
            }
            assert!(seen.iter().all(|&seen| seen));
        }
    }

    #[test]
    fn long_chains_take_linear_time_and_no_stack() {
        let count = 200_000;
        let objects: Vec<_> = (0..count).map(|id| object(id, if id + 1 < count { id + 1 } else { -1 })).collect();
        let hierarchy = Hierarchy::of(&objects);
        assert_eq!(hierarchy.order[0], count as usize - 1);
        assert_eq!(hierarchy.findings, []);
    }

    #[test]
    fn keys_replace_their_part_of_the_transform() {
        let mut object = moved(0, -1, 5.0);
        let row = |frame, x| PositionSample { frame, position: [x, 1.0, 0.0] };
        object.keys = Flagged::Yes(vec![Track::PositionSampled(vec![row(10.0, 0.0), row(20.0, 8.0)])]);
        let motion = Motion::of(&object);
        assert_eq!(motion.at(15.0).transform_point3(Vec3::Z), Vec3::new(4.0, 1.0, 2.0), "scale stays that of TM");
        assert_eq!(motion.at(f32::NAN), motion.at(0.0));
        assert_eq!(motion.frame_range(), Some((10.0, 20.0)));
        let keyed = document(AnimationMode::Keyframe, vec![object, moved(1, -1, 0.0)]);
        assert_eq!(frame_range(&keyed), Some((10.0, 20.0)));
        assert_eq!(frame_range(&document(AnimationMode::Keyframe, vec![moved(1, -1, 0.0)])), None);
        let mut full = document(AnimationMode::Full, vec![Object::default()]);
        assert_eq!(frame_range(&full), None);
        full.geometry.frames.resize_with(4, Frame::default);
        assert_eq!(frame_range(&full), Some((0.0, 3.0)));
    }
}
