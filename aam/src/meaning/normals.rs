//! Normals: explicit ones, and those that smoothing groups give.

use glam::{DVec3, Vec3};

use crate::document::{Faces, Object, Triangle};
use crate::meaning::SmoothingRule;

/// Below this sine of the angle between two edges a triangle has no area: what remains is rounding.
const MIN_SINE: f64 = 1e-10;

/// At a vertex where more different masks meet than this (3ds Max has 32 bits, and a vertex few faces), comparing each
/// with each would take long; a face then counts once for every group it shares, which needs one sum for each bit.
const MAX_MASKS: usize = 256;

/// The unit normal of a triangle, counter-clockwise seen from outside; `None` if it has no area or is not finite.
pub fn face_normal(a: Vec3, b: Vec3, c: Vec3) -> Option<Vec3> {
    unit_normal(a, b, c).map(|normal| normal.as_vec3())
}

fn unit_normal(a: Vec3, b: Vec3, c: Vec3) -> Option<DVec3> {
    // Products of 64-bit numbers neither overflow nor vanish for any 32-bit coordinates.
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    let (ab, ac) = (b - a, c - a);
    let (normal, scale) = (ab.cross(ac), ab.length() * ac.length());
    (normal.length() > MIN_SINE * scale).then(|| normal.normalize())
}

/// A unit normal for each corner of each triangle, from smoothing groups.
///
/// It is the unweighted mean of the unit normals of the faces at that vertex index that are smooth with the corner's
/// face, itself included. Faces without area add nothing. Where the mean vanishes (a face and its own back side) the
/// corner gets its face's normal, and where that does not exist either, +Z. An index beyond `positions` counts as a
/// triangle without area.
pub fn corner_normals(positions: &[[f32; 3]], triangles: &[Triangle], rule: SmoothingRule) -> Vec<[Vec3; 3]> {
    let faces: Vec<DVec3> = triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.vertices.map(|vertex| positions.get(vertex as usize).copied().map(Vec3::from));
            a.zip(b).zip(c).and_then(|((a, b), c)| unit_normal(a, b, c)).unwrap_or(DVec3::ZERO)
        })
        .collect();
    let flat = |face: DVec3| if face == DVec3::ZERO { Vec3::Z } else { face.as_vec3() };
    let mut normals: Vec<[Vec3; 3]> = faces.iter().map(|&face| [flat(face); 3]).collect();
    if rule == SmoothingRule::Flat {
        return normals;
    }

    // Corners that smooth with anything, sorted by vertex: `starts` holds where each vertex' run begins.
    let smooth = |triangle: &Triangle| triangle.smoothing != 0;
    let mut starts = vec![0_usize; positions.len() + 1];
    let vertices = || {
        triangles.iter().enumerate().filter(|(_, triangle)| smooth(triangle)).flat_map(|(face, triangle)| {
            triangle.vertices.into_iter().enumerate().map(move |(corner, vertex)| (face, corner, vertex as usize))
        })
    };
    for (_, _, vertex) in vertices() {
        if let Some(count) = starts.get_mut(vertex + 1) {
            *count += 1;
        }
    }
    for vertex in 0..positions.len() {
        starts[vertex + 1] += starts[vertex];
    }
    let mut corners = vec![Corner::default(); starts[positions.len()]];
    let mut next = starts.clone();
    for (face, corner, vertex) in vertices() {
        if vertex < positions.len() {
            corners[next[vertex]] = Corner { smoothing: triangles[face].smoothing, face, corner };
            next[vertex] += 1;
        }
    }

    let mut sums = Vec::new();
    for vertex in 0..positions.len() {
        let run = &mut corners[starts[vertex]..starts[vertex + 1]];
        // Stable, so that sums are formed in file order whatever else the file holds.
        run.sort_by_key(|corner| corner.smoothing);
        sums.clear();
        sums.extend(run.chunk_by(|a, b| a.smoothing == b.smoothing).map(|corners| GroupSum {
            smoothing: corners[0].smoothing,
            count: corners.len(),
            sum: corners.iter().map(|corner| faces[corner.face]).sum(),
        }));
        let mut at = 0;
        for (group, mean) in sums.iter().zip(means(&sums, rule)) {
            for corner in &run[at..at + group.count] {
                if let Some(normal) = mean {
                    normals[corner.face][corner.corner] = normal;
                }
            }
            at += group.count;
        }
    }
    normals
}

#[derive(Clone, Copy, Default)]
struct Corner {
    smoothing: i32,
    face: usize,
    corner: usize,
}

/// The faces with one smoothing number at one vertex.
struct GroupSum {
    smoothing: i32,
    count: usize,
    sum: DVec3,
}

/// For each group the unit mean over all groups that are smooth with it, or `None` where it vanishes.
fn means(groups: &[GroupSum], rule: SmoothingRule) -> impl Iterator<Item = Option<Vec3>> {
    let many = rule == SmoothingRule::Masks && groups.len() > MAX_MASKS;
    let bits = if many { bit_sums(groups) } else { [DVec3::ZERO; 32] };
    groups.iter().map(move |group| {
        let (sum, count) = match rule {
            SmoothingRule::Masks if many => {
                let shared = (0..32).filter(|bit| group.smoothing >> bit & 1 != 0);
                (shared.map(|bit| bits[bit]).sum(), groups.len())
            }
            SmoothingRule::Masks => {
                let smooth = || groups.iter().filter(|other| rule.smooth(group.smoothing, other.smoothing));
                (smooth().map(|other| other.sum).sum::<DVec3>(), smooth().map(|other| other.count).sum())
            }
            SmoothingRule::Flat | SmoothingRule::Numbers => (group.sum, group.count),
        };
        // The sum of many unit vectors that cancel is rounding, not a direction.
        (sum.length() > 1e-12 * count as f64).then(|| sum.normalize().as_vec3())
    })
}

fn bit_sums(groups: &[GroupSum]) -> [DVec3; 32] {
    std::array::from_fn(|bit| {
        groups.iter().filter(|group| group.smoothing >> bit & 1 != 0).map(|group| group.sum).sum()
    })
}

/// A unit normal for each corner of each triangle of an object: its explicit ones (`N_List:` and `NI:`), else from
/// smoothing groups. An explicit normal that is missing, zero or not finite falls back to smoothing groups.
pub fn object_normals(object: &Object, rule: SmoothingRule) -> Vec<[Vec3; 3]> {
    object
        .faces
        .as_ref()
        .map_or_else(Vec::new, |faces| faces_normals(faces, &object.vertices, faces.normals.as_deref(), rule))
}

/// As [`object_normals`], for a later frame of a `Full` animation: `first` is the object in frame 0, which has the
/// faces, `later` the same object in the later frame. Explicit normals are the later frame's own `N_List:`, indexed by
/// the `NI:` of frame 0; a frame without one uses smoothing groups.
pub fn frame_normals(first: &Object, later: &Object, rule: SmoothingRule) -> Vec<[Vec3; 3]> {
    first
        .faces
        .as_ref()
        .map_or_else(Vec::new, |faces| faces_normals(faces, &later.vertices, later.frame_normals.as_deref(), rule))
}

fn faces_normals(
    faces: &Faces,
    positions: &[[f32; 3]],
    explicit: Option<&[[f32; 3]]>,
    rule: SmoothingRule,
) -> Vec<[Vec3; 3]> {
    let smoothed = || corner_normals(positions, &faces.triangles, rule);
    let Some(explicit) = explicit else {
        return smoothed();
    };
    let mut fallback = None;
    (0..faces.triangles.len())
        .map(|triangle| {
            std::array::from_fn(|corner| {
                let index = faces.normal_indices.get(triangle).map(|indices| indices[corner] as usize);
                let written = index.and_then(|index| explicit.get(index)).map(|&normal| Vec3::from(normal));
                // Through 64 bits: the square of a tiny or huge 32-bit length is not a number of 32 bits.
                let unit = written.and_then(|normal| normal.as_dvec3().try_normalize());
                unit.map_or_else(|| fallback.get_or_insert_with(smoothed)[triangle][corner], |unit| unit.as_vec3())
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(vertices: [u32; 3], smoothing: i32) -> Triangle {
        Triangle { vertices, smoothing }
    }

    /// The unit cube around (½, ½, ½), two triangles a side: −Z, +Z, −Y, +Y, −X, +X.
    fn cube(smoothing: [i32; 6]) -> (Vec<[f32; 3]>, Vec<Triangle>) {
        let positions = (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32]).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads
            .into_iter()
            .zip(smoothing)
            .flat_map(|([a, b, c, d], smoothing)| [triangle([a, b, c], smoothing), triangle([a, c, d], smoothing)])
            .collect();
        (positions, triangles)
    }

    const SIDES: [Vec3; 6] = [Vec3::NEG_Z, Vec3::Z, Vec3::NEG_Y, Vec3::Y, Vec3::NEG_X, Vec3::X];

    fn close(a: Vec3, b: Vec3) -> bool {
        a.abs_diff_eq(b, 1e-6)
    }

    #[test]
    fn a_cube_with_a_mask_for_each_side_is_flat() {
        let (positions, triangles) = cube([1, 2, 4, 8, 16, 32]);
        for (face, normals) in corner_normals(&positions, &triangles, SmoothingRule::Masks).iter().enumerate() {
            assert!(normals.iter().all(|&normal| close(normal, SIDES[face / 2])), "face {face}: {normals:?}");
        }
    }

    #[test]
    fn a_cube_with_one_mask_means_over_triangles() {
        let (positions, triangles) = cube([1; 6]);
        let normals = corner_normals(&positions, &triangles, SmoothingRule::Masks);
        // Each corner of the cube is met by one or two triangles of each of three sides, unweighted.
        for vertex in 0..8_u32 {
            let mut expected = Vec3::ZERO;
            for (face, triangle) in triangles.iter().enumerate() {
                if triangle.vertices.contains(&vertex) {
                    expected += SIDES[face / 2];
                }
            }
            for (triangle, normals) in triangles.iter().zip(&normals) {
                for (_, &found) in triangle.vertices.iter().zip(normals).filter(|(at, _)| **at == vertex) {
                    assert!(close(found, expected.normalize()), "vertex {vertex}: {found} is not {expected}");
                }
            }
        }
    }

    #[test]
    fn zero_is_flat_in_every_rule() {
        let (positions, triangles) = cube([0; 6]);
        for rule in [SmoothingRule::Flat, SmoothingRule::Masks, SmoothingRule::Numbers] {
            let normals = corner_normals(&positions, &triangles, rule);
            assert!(normals.iter().enumerate().all(|(face, n)| n.iter().all(|&n| close(n, SIDES[face / 2]))));
        }
    }

    /// Three faces that share the edge from the origin along X, at 0°, 60° and 120°.
    fn fan(smoothing: [i32; 3]) -> (Vec<[f32; 3]>, Vec<Triangle>) {
        let mut positions = vec![[0.0; 3], [1.0, 0.0, 0.0]];
        let mut triangles = Vec::new();
        for (face, smoothing) in smoothing.into_iter().enumerate() {
            let angle = (60.0 * face as f32).to_radians();
            positions.push([0.0, angle.cos(), angle.sin()]);
            triangles.push(triangle([0, 1, 2 + face as u32], smoothing));
        }
        (positions, triangles)
    }

    fn fan_normal(degrees: f32) -> Vec3 {
        let angle = degrees.to_radians();
        Vec3::new(0.0, -angle.sin(), angle.cos())
    }

    #[test]
    fn masks_are_pairwise_not_transitive() {
        let (positions, triangles) = fan([0b01, 0b11, 0b10]);
        let normals = corner_normals(&positions, &triangles, SmoothingRule::Masks);
        assert!(close(normals[0][0], fan_normal(30.0)), "the first smooths with the middle");
        assert!(close(normals[1][0], fan_normal(60.0)), "the middle with both");
        assert!(close(normals[2][0], fan_normal(90.0)), "the last with the middle, not with the first");
        assert!(close(normals[2][2], fan_normal(120.0)), "a vertex of its own");
    }

    #[test]
    fn plain_numbers_smooth_where_equal() {
        let (positions, triangles) = fan([1, 3, 1]);
        let normals = corner_normals(&positions, &triangles, SmoothingRule::Numbers);
        assert!(close(normals[0][0], fan_normal(60.0)), "the mean of 0° and 120°");
        assert!(close(normals[1][0], fan_normal(60.0)), "its own");
        let masks = corner_normals(&positions, &triangles, SmoothingRule::Masks);
        assert!(close(masks[0][0], fan_normal(60.0)), "as masks 1 and 3 share a bit: all three");
        let (positions, triangles) = fan([1, 3, 2]);
        let normals = corner_normals(&positions, &triangles, SmoothingRule::Numbers);
        assert!(close(normals[0][0], fan_normal(0.0)) && close(normals[2][0], fan_normal(120.0)));
    }

    #[test]
    fn the_sign_bit_of_a_mask_is_a_group() {
        let (positions, triangles) = fan([i32::MIN, i32::MIN | 1, 2]);
        let normals = corner_normals(&positions, &triangles, SmoothingRule::Masks);
        assert!(close(normals[0][0], fan_normal(30.0)));
    }

    #[test]
    fn faces_without_area_add_nothing_and_get_a_direction() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0], [f32::NAN; 3]];
        let triangles = [
            triangle([0, 1, 2], 1),
            triangle([0, 1, 3], 1),
            triangle([0, 1, 1], 1),
            triangle([0, 1, 4], 1),
            triangle([0, 1, 99], 1),
            triangle([3, 3, 3], 1),
            triangle([0, 1, 3], 0),
        ];
        let normals = corner_normals(&positions, &triangles, SmoothingRule::Masks);
        assert!(normals.iter().flatten().all(|normal| *normal == Vec3::Z), "{normals:?}");
    }

    #[test]
    fn a_face_and_its_back_keep_their_own_sides() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let triangles = [triangle([0, 1, 2], 1), triangle([0, 2, 1], 1)];
        let normals = corner_normals(&positions, &triangles, SmoothingRule::Masks);
        assert_eq!(normals, [[Vec3::Z; 3], [Vec3::NEG_Z; 3]]);
    }

    #[test]
    fn size_does_not_matter() {
        for scale in [1e-30_f32, 1e-3, 1e3, 1e30] {
            let normal = face_normal(Vec3::ZERO, Vec3::new(scale, 0.0, 0.0), Vec3::new(0.0, scale, 0.0));
            assert_eq!(normal, Some(Vec3::Z), "scale {scale}");
        }
        assert_eq!(face_normal(Vec3::ZERO, Vec3::splat(f32::INFINITY), Vec3::X), None);
    }

    /// A cone of many faces around one vertex, each with the mask that `mask` gives.
    fn cone(count: u32, mask: impl Fn(u32) -> i32) -> (Vec<[f32; 3]>, Vec<Triangle>) {
        let mut positions = vec![[0.0, 0.0, 1.0]];
        let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(count);
        positions.extend((0..count).map(|i| [angle(i).cos() as f32, angle(i).sin() as f32, 0.0]));
        let triangles = (0..count).map(|i| triangle([0, 1 + i, 1 + (i + 1) % count], mask(i))).collect();
        (positions, triangles)
    }

    #[test]
    fn a_vertex_with_very_many_faces_takes_linear_time() {
        let (positions, triangles) = cone(400_000, |_| 1);
        let normals = corner_normals(&positions, &triangles, SmoothingRule::Masks);
        assert!(normals.iter().all(|normals| close(normals[0], Vec3::Z)));
        // Every mask another, all with bit 0: by symmetry the tip still points up.
        let (positions, triangles) = cone(400_000, |i| 1 | (i as i32) << 1);
        let normals = corner_normals(&positions, &triangles, SmoothingRule::Masks);
        assert!(normals.iter().all(|normals| normals[0].is_normalized()));
        let (positions, triangles) = cone(400_000, |i| i as i32 + 1);
        let numbers = corner_normals(&positions, &triangles, SmoothingRule::Numbers);
        assert!(numbers.iter().all(|normals| normals[0].is_normalized()));
    }

    #[test]
    fn many_masks_stay_exact_up_to_the_limit() {
        let (positions, triangles) = cone(MAX_MASKS as u32, |i| 1 | (i as i32) << 1);
        let normals = corner_normals(&positions, &triangles, SmoothingRule::Masks);
        assert!(normals.iter().all(|normals| close(normals[0], Vec3::Z)), "all share bit 0");
    }

    fn with_normals(normals: Vec<[f32; 3]>, indices: Vec<[u32; 3]>) -> Object {
        let faces = Faces {
            triangles: vec![triangle([0, 1, 2], 1)],
            normals: Some(normals),
            normal_indices: indices,
            ..Faces::default()
        };
        Object { vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], faces: Some(faces), ..Object::default() }
    }

    #[test]
    fn explicit_normals_win_where_they_are_usable() {
        let object = with_normals(vec![[3.0, 0.0, 0.0], [0.0; 3], [1e-30, 0.0, 0.0]], vec![[0, 1, 2]]);
        let normals = object_normals(&object, SmoothingRule::Masks);
        assert_eq!(normals, [[Vec3::X, Vec3::Z, Vec3::X]]);
        let object = with_normals(vec![[f32::NAN; 3], [0.0, 2.0, 0.0]], vec![[0, 1, 9]]);
        assert_eq!(object_normals(&object, SmoothingRule::Masks), [[Vec3::Z, Vec3::Y, Vec3::Z]]);
        let object = with_normals(vec![[1.0, 0.0, 0.0]], Vec::new());
        assert_eq!(object_normals(&object, SmoothingRule::Masks), [[Vec3::Z; 3]]);
    }

    #[test]
    fn later_frames_have_normals_of_their_own() {
        let first = with_normals(vec![[1.0, 0.0, 0.0]], vec![[0, 0, 0]]);
        let turned = vec![[0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut later = Object { vertices: turned, ..Object::default() };
        assert_eq!(
            frame_normals(&first, &later, SmoothingRule::Masks),
            [[Vec3::X; 3]],
            "computed: the face now faces +X"
        );
        later.frame_normals = Some(vec![[0.0, 0.0, -2.0]]);
        assert_eq!(frame_normals(&first, &later, SmoothingRule::Masks), [[Vec3::NEG_Z; 3]]);
    }
}
