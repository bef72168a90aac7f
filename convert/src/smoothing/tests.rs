use super::*;

use glam::Vec3;
use proptest::prelude::*;

/// The format's rule, written the slow way round, corner by corner and face by face.
fn rule(vertices: &[[f32; 3]], triangles: &[[u32; 3]], masks: &[i32]) -> Vec<[[f32; 3]; 3]> {
    let face_normals: Vec<Vec3> = triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|index| Vec3::from(vertices[index as usize]));
            (b - a).cross(c - a).normalize_or_zero()
        })
        .collect();
    (0..triangles.len())
        .map(|face| {
            triangles[face].map(|vertex| {
                let smooth = (0..triangles.len())
                    .filter(|other| triangles[*other].contains(&vertex))
                    .filter(|other| *other == face || masks[face] & masks[*other] != 0);
                smooth.map(|other| face_normals[other]).sum::<Vec3>().normalize_or_zero().to_array()
            })
        })
        .collect()
}

fn worst_degrees(a: &[[[f32; 3]; 3]], b: &[[[f32; 3]; 3]]) -> f32 {
    a.iter()
        .flatten()
        .zip(b.iter().flatten())
        .map(|(a, b)| 2.0 * (0.5 * (Vec3::from(*a) - Vec3::from(*b)).length()).min(1.0).asin().to_degrees())
        .fold(0.0, f32::max)
}

/// Recovers from the normals of known masks, and checks that masks come back that give the same normals.
fn assert_recovers(vertices: &[[f32; 3]], triangles: &[[u32; 3]], masks: &[i32]) -> Recovered {
    let authored = rule(vertices, triangles, masks);
    let found = recover(vertices, triangles, &authored, 0.001);
    assert_eq!(
        found.explicit, None,
        "{} of {} corners off by up to {}°",
        found.corners_off, found.corners, found.worst_degrees
    );
    let off = worst_degrees(&authored, &rule(vertices, triangles, &found.masks));
    assert!(off < 1e-5_f32.to_degrees(), "{off}°");
    found
}

const CUBE: [[f32; 3]; 8] =
    [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0., 0., 1.], [1., 0., 1.], [1., 1., 1.], [0., 1., 1.]];
const CUBE_FACES: [[u32; 3]; 12] = [
    [0, 2, 1],
    [0, 3, 2],
    [4, 5, 6],
    [4, 6, 7],
    [0, 1, 5],
    [0, 5, 4],
    [1, 2, 6],
    [1, 6, 5],
    [2, 3, 7],
    [2, 7, 6],
    [3, 0, 4],
    [3, 4, 7],
];

/// A closed cylinder of `sides` quads with fans as caps: vertices, triangles, and which part a triangle is (0 side, 1, 2).
fn cylinder(sides: u32, height: f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>, Vec<u32>) {
    let mut vertices = vec![[0., 0., 0.], [0., 0., height]];
    let (mut triangles, mut parts) = (Vec::new(), Vec::new());
    for side in 0..sides {
        let turn = std::f32::consts::TAU * side as f32 / sides as f32;
        vertices.push([turn.cos(), turn.sin(), 0.]);
        vertices.push([turn.cos(), turn.sin(), height]);
        let next = (side + 1) % sides;
        let [a, b, c, d] = [2 + 2 * side, 2 + 2 * next, 3 + 2 * next, 3 + 2 * side];
        triangles.extend([[a, b, c], [a, c, d], [0, b, a], [1, d, c]]);
        parts.extend([0, 0, 1, 2]);
    }
    (vertices, triangles, parts)
}

#[test]
fn a_faceted_cube_needs_no_masks() {
    assert_eq!(assert_recovers(&CUBE, &CUBE_FACES, &[0; 12]).masks, [0; 12]);
}

#[test]
fn a_wholly_smooth_cube_is_one_group() {
    assert_eq!(assert_recovers(&CUBE, &CUBE_FACES, &[4; 12]).masks, [1; 12]);
}

#[test]
fn a_cylinder_with_caps_is_one_group_and_flat_caps() {
    let (vertices, triangles, parts) = cylinder(24, 2.0);
    let masks: Vec<i32> = parts.iter().map(|part| 1 << part).collect();
    let found = assert_recovers(&vertices, &triangles, &masks);
    for (mask, part) in found.masks.iter().zip(&parts) {
        assert_eq!(*mask, i32::from(*part == 0));
    }
}

#[test]
fn domed_caps_get_bits_of_their_own() {
    let (mut vertices, triangles, parts) = cylinder(24, 2.0);
    vertices[0][2] = -0.5;
    vertices[1][2] = 2.5;
    let masks: Vec<i32> = parts.iter().map(|part| 1 << part).collect();
    let found = assert_recovers(&vertices, &triangles, &masks);
    // The caps do not touch, so they may share.
    assert!(found.masks.iter().all(|mask| [1, 2].contains(mask)), "{:?}", found.masks);
}

#[test]
fn a_bevel_smooth_with_both_sides_that_are_not_smooth_with_each_other() {
    // Three strips along x: a floor, a bevel and a wall; floor and wall meet the bevel, and each other at no edge.
    let profile = [[0.0, 0.0], [1.0, 0.0], [1.3, 0.3], [1.3, 1.3]];
    let vertices: Vec<[f32; 3]> = (0..8).flat_map(|x| profile.map(|[y, z]| [x as f32, y, z])).collect();
    let (mut triangles, mut masks) = (Vec::new(), Vec::new());
    for x in 0..7_u32 {
        for (strip, mask) in [(0, 1), (1, 3), (2, 2)] {
            let [a, b] = [4 * x + strip, 4 * (x + 1) + strip];
            triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
            masks.extend([mask, mask]);
        }
    }
    assert_recovers(&vertices, &triangles, &masks);
}

#[test]
fn masks_that_are_not_transitive_at_a_vertex() {
    // A pyramid whose sides are each smooth with their two neighbours, not with the one across.
    let vertices = [[0., 0., 1.], [1., 0., 0.], [0., 1., 0.], [-1., 0., 0.], [0., -1., 0.3]];
    let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];
    assert_recovers(&vertices, &triangles, &[0b1001, 0b0011, 0b0110, 0b1100]);
}

#[test]
fn normals_that_no_mask_gives_become_explicit() {
    // Analytic normals of a coarse cylinder: the rule counts the two triangles of a quad twice, so it misses them.
    let (vertices, triangles, parts) = cylinder(8, 1.0);
    let authored: Vec<[[f32; 3]; 3]> = triangles
        .iter()
        .zip(&parts)
        .map(|(triangle, part)| {
            triangle.map(|index| match part {
                0 => Vec3::from(vertices[index as usize]).with_z(0.0).normalize().to_array(),
                1 => [0., 0., -1.],
                _ => [0., 0., 1.],
            })
        })
        .collect();
    let found = recover(&vertices, &triangles, &authored, 0.5);
    let explicit = found.explicit.as_ref().expect("masks cannot give these");
    assert_eq!(explicit.normals.len(), 10);
    for (indices, authored) in explicit.indices.iter().zip(&authored) {
        for (index, authored) in indices.iter().zip(authored) {
            assert!(Vec3::from(explicit.normals[*index as usize]).distance(Vec3::from(*authored)) < 1e-6);
        }
    }
    // Every corner of the side is off by 7.5°: (2·a + b)/3 of two directions 45° apart is 15° from one, their middle 22.5°.
    assert_eq!(found.corners_off, 8 * 6);
    let expected = (45_f32.to_radians().sin() / (2.0 + 45_f32.to_radians().cos())).atan().to_degrees();
    assert!((found.worst_degrees - (22.5 - expected)).abs() < 1e-3, "{} {expected}", found.worst_degrees);
    let text = explicit.normals.iter().map(|[x, y, z]| format!("{x} {y} {z}\n").len()).sum::<usize>()
        + explicit.indices.iter().map(|[a, b, c]| format!("NI: {a} {b} {c}\n").len()).sum::<usize>();
    assert_eq!(found.explicit_bytes, text as u64);
    // The masks beside them still keep the side smooth and apart from the caps.
    for (mask, part) in found.masks.iter().zip(&parts) {
        assert_eq!(*mask != 0, *part == 0);
    }
}

#[test]
fn a_finer_cylinder_is_within_the_tolerance() {
    let (vertices, triangles, parts) = cylinder(256, 1.0);
    let authored: Vec<_> = triangles
        .iter()
        .zip(&parts)
        .map(|(triangle, part)| {
            triangle.map(|index| match part {
                0 => Vec3::from(vertices[index as usize]).with_z(0.0).normalize().to_array(),
                1 => [0., 0., -1.],
                _ => [0., 0., 1.],
            })
        })
        .collect();
    let found = recover(&vertices, &triangles, &authored, 0.5);
    assert_eq!((found.explicit, found.corners_off), (None, 0));
    assert!(found.worst_degrees > 0.1 && found.worst_degrees < 0.5, "{}", found.worst_degrees);
}

#[test]
fn a_crease_that_ends_on_a_surface_cannot_be_masks() {
    // Four quads around the origin; the edge from the origin along +x is hard at its far end and smooth at the origin.
    let vertices: Vec<[f32; 3]> = (0..9)
        .map(|at| [(at % 3) as f32, (at / 3) as f32, [0.0, 0.3, 0.1, 0.5, 0.2, 0.9, 0.0, 0.4, 0.2][at]])
        .collect();
    let mut triangles = Vec::new();
    for at in [0_u32, 1, 3, 4] {
        triangles.extend([[at, at + 1, at + 4], [at, at + 4, at + 3]]);
    }
    let below = [true, true, true, true, false, false, false, false];
    let smooth = rule(&vertices, &triangles, &[1; 8]);
    let split: Vec<i32> = below.iter().map(|below| if *below { 1 } else { 2 }).collect();
    let hard = rule(&vertices, &triangles, &split);
    let authored: Vec<[[f32; 3]; 3]> = (0..8)
        .map(|face| [0, 1, 2].map(|at| if triangles[face][at] == 5 { hard[face][at] } else { smooth[face][at] }))
        .collect();
    let found = recover(&vertices, &triangles, &authored, 0.5);
    assert!(found.explicit.is_some());
}

#[test]
fn missing_normals_and_broken_triangles_ask_for_nothing() {
    let vertices = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [f32::NAN, 0., 0.]];
    let triangles = [[0, 1, 2], [0, 1, 1], [0, 1, 9], [0, 1, 3], [0, 2, 1]];
    let none = [[0., 0., 0.], [f32::NAN, 1., 0.], [f32::INFINITY, 0., 0.]];
    let found = recover(&vertices, &triangles, &[none; 5], 0.5);
    assert_eq!((found.masks, found.explicit, found.corners), (vec![0; 5], None, 0));
    assert_eq!(recover(&[], &[], &[], 0.5), Recovered::default());
}

#[test]
fn many_faces_at_one_vertex_take_no_square_of_time() {
    let (vertices, triangles, _) = cylinder(100_000, 1.0);
    let authored: Vec<[[f32; 3]; 3]> = (0..triangles.len() as u32)
        .map(|face| [0, 1, 2].map(|at| [(face % 97) as f32, ((3 * face + at) % 89) as f32, 1.0]))
        .collect();
    let found = recover(&vertices, &triangles, &authored, 0.5);
    assert!(found.explicit.is_some());
}

/// A triangulated height field of `side`² quads, in general position.
fn grid(side: u32, heights: &[f32]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let across = side + 1;
    let vertices = (0..across * across)
        .map(|at| [(at % across) as f32, (at / across) as f32, heights[at as usize % heights.len()]])
        .collect();
    let mut triangles = Vec::new();
    for y in 0..side {
        for x in 0..side {
            let at = y * across + x;
            triangles.extend([[at, at + 1, at + across + 1], [at, at + across + 1, at + across]]);
        }
    }
    (vertices, triangles)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Regions, overlapping regions and noise: masks that are the union of a few bits.
    #[test]
    fn masks_of_few_bits_are_recovered(
        heights in prop::collection::vec(-1.0_f32..1.0, 121),
        bits in prop::collection::vec((0_u32..4, 0_u32..4, prop::bool::weighted(0.3)), 200),
    ) {
        let (vertices, triangles) = grid(10, &heights);
        let masks: Vec<i32> =
            bits.iter().map(|(a, b, both)| if *both { 1 << a | 1 << b } else { 1 << a }).collect();
        assert_recovers(&vertices, &triangles, &masks);
    }

    /// Any masks at all: the normals come back, as masks or explicit.
    #[test]
    fn any_masks_give_their_normals_back(
        heights in prop::collection::vec(-1.0_f32..1.0, 49),
        masks in prop::collection::vec(any::<i32>(), 72),
        thin in prop::collection::vec(any::<i32>(), 144),
    ) {
        let (vertices, triangles) = grid(6, &heights);
        let masks: Vec<i32> = masks.iter().zip(thin.chunks(2)).map(|(mask, thin)| mask & thin[0] & thin[1]).collect();
        let authored = rule(&vertices, &triangles, &masks);
        let found = recover(&vertices, &triangles, &authored, 0.001);
        let given = match &found.explicit {
            None => rule(&vertices, &triangles, &found.masks),
            Some(explicit) => explicit.indices.iter().map(|row| row.map(|at| explicit.normals[at as usize])).collect(),
        };
        prop_assert!(worst_degrees(&authored, &given) < 1e-5_f32.to_degrees());
    }
}

/// The smoothing groups of real files, from their normals alone. Blender's numbers are made masks by this too.
#[test]
fn groups_of_real_files_are_recovered() {
    let Some(folder) = std::env::var_os("AAM_CORPUS").map(std::path::PathBuf::from) else {
        println!("skipped: AAM_CORPUS is not set");
        return;
    };
    let (mut objects, mut recovered, mut corners, mut off) = (0, 0, 0, 0);
    let mut paths: Vec<_> = std::fs::read_dir(folder.join("aam")).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        let document = aam::read_file(&path, &aam::ReadOptions::default()).unwrap().document;
        let rule = SmoothingRule::of(&document);
        for object in document.objects() {
            let triangles: Vec<[u32; 3]> =
                object.faces.iter().flat_map(|faces| &faces.triangles).map(|triangle| triangle.vertices).collect();
            let normals = aam::meaning::object_normals(object, rule);
            let normals: Vec<[[f32; 3]; 3]> =
                normals.iter().map(|corners| corners.map(|normal| normal.to_array())).collect();
            let found = recover(&object.vertices, &triangles, &normals, 0.5);
            objects += 1;
            recovered += usize::from(found.explicit.is_none());
            corners += found.corners;
            off += found.corners_off;
        }
    }
    println!("{recovered} of {objects} objects, {} of {corners} corners", corners - off);
    assert_eq!(recovered, objects);
}
