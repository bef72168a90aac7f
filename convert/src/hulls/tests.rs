use std::path::PathBuf;

use super::*;
use crate::{ImportOptions, Silent, import};

type Mesh = (Vec<[f32; 3]>, Vec<[u32; 3]>);

fn cuboid(low: [f32; 3], high: [f32; 3]) -> Mesh {
    let vertices =
        (0..8).map(|corner: usize| std::array::from_fn(|i| if corner >> i & 1 == 0 { low[i] } else { high[i] }));
    let quads: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (vertices.collect(), quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

fn both((mut vertices, mut triangles): Mesh, (more, further): Mesh) -> Mesh {
    let base = vertices.len() as u32;
    vertices.extend(more);
    triangles.extend(further.into_iter().map(|triangle| triangle.map(|index| index + base)));
    (vertices, triangles)
}

/// A surface of revolution around z: (radius, height) rings; the last joins the first if it is closed.
fn turned(profile: &[(f32, f32)], around: u32, closed: bool) -> Mesh {
    let mut vertices = Vec::new();
    for at in 0..around {
        let (sin, cos) = (std::f32::consts::TAU * at as f32 / around as f32).sin_cos();
        vertices.extend(profile.iter().map(|(radius, height)| [radius * cos, radius * sin, *height]));
    }
    let rows = profile.len() as u32;
    let mut triangles = Vec::new();
    for at in 0..around {
        for row in 0..if closed { rows } else { rows - 1 } {
            let [a, b] = [at * rows, (at + 1) % around * rows];
            let next = (row + 1) % rows;
            triangles.extend([[a + row, b + row, b + next], [a + row, b + next, a + next]]);
        }
    }
    (vertices, triangles)
}

fn torus(major: f32, minor: f32, around: u32) -> Mesh {
    let ring: Vec<(f32, f32)> = (0..around / 2)
        .map(|at| (std::f32::consts::TAU * at as f32 / (around / 2) as f32).sin_cos())
        .map(|(sin, cos)| (major + minor * cos, minor * sin))
        .collect();
    turned(&ring, around, true)
}

fn sphere(around: u32) -> Mesh {
    let rows = around / 2;
    let profile: Vec<(f32, f32)> = (0..=rows)
        .map(|row| {
            let turn = std::f32::consts::PI * row as f32 / rows as f32;
            // Exactly one point at each pole.
            (if row == 0 || row == rows { 0.0 } else { turn.sin() }, -turn.cos())
        })
        .collect();
    turned(&profile, around, false)
}

/// Decomposes, and checks what must hold of every decomposition.
fn pieces((vertices, triangles): &Mesh, options: &HullOptions) -> Decomposition {
    let found = decompose(vertices, triangles, options).unwrap();
    assert!(!found.hulls.is_empty() && found.hulls.len() <= options.max_hulls);
    for hull in &found.hulls {
        assert!(hull.vertices.len() <= options.max_vertices);
        let mesh = Polyhedron {
            vertices: hull.vertices.iter().map(|vertex| DVec3::from(vertex.map(f64::from))).collect(),
            triangles: hull.triangles.clone(),
        };
        assert!(mesh.worst_dent() <= 1e-4 * mesh.diagonal(), "{}", mesh.worst_dent());
        assert!(mesh.volume() > 0.0);
    }
    found
}

fn volume(found: &Decomposition) -> f64 {
    found.hulls.iter().map(|hull| hull.volume).sum()
}

#[test]
fn convex_meshes_are_one_piece() {
    let inside_out = |(vertices, triangles): Mesh| -> Mesh {
        (vertices, triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect())
    };
    let cone = turned(&[(0.0, 0.0), (1.0, 0.0), (0.0, 2.0)], 48, false);
    for (name, mesh) in [
        ("cuboid", cuboid([100.0, 200.0, -5.0], [101.0, 200.5, 9.0])),
        ("inside out", inside_out(cuboid([0.0; 3], [1.0; 3]))),
        ("cone", cone),
        ("cylinder", turned(&[(0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (1.0, 2.0), (0.0, 2.0)], 32, false)),
    ] {
        let found = pieces(&mesh, &HullOptions::default());
        assert_eq!(found.hulls.len(), 1, "{name}");
        assert!(found.quality.hausdorff() < 1e-5, "{name}: {found:?}");
    }
    let ball = sphere(60);
    let found = pieces(&ball, &HullOptions::default());
    assert_eq!((found.hulls.len(), found.hulls[0].vertices.len()), (1, 64));
    // The limit on vertices shows.
    assert!((0.003..0.03).contains(&found.quality.uncovered.max), "{:?}", found.quality);
    let found = pieces(&ball, &HullOptions { max_vertices: 255, ..HullOptions::default() });
    assert!(found.quality.hausdorff() < 0.01, "{:?}", found.quality);
}

#[test]
fn a_fine_torus_is_not_taken_for_convex() {
    let (vertices, triangles) = torus(1.0, 0.4, 400);
    assert!(!Unit::new(&vertices, &triangles).unwrap().is_convex());
}

#[test]
fn two_boxes_are_two_pieces() {
    let mesh = both(cuboid([0.0; 3], [1.0; 3]), cuboid([3.0, 0.0, 0.0], [4.0, 1.0, 1.0]));
    let found = pieces(&mesh, &HullOptions::default());
    assert_eq!(found.hulls.len(), 2);
    assert!(found.quality.hausdorff() < 1e-5 && (volume(&found) - 2.0).abs() < 1e-5, "{found:?}");
    // More do not help, so more are not made.
    let best = pieces(&mesh, &HullOptions { max_error: None, ..HullOptions::default() });
    assert_eq!(best.hulls.len(), 2);
}

#[test]
fn a_torus_keeps_its_hole() {
    let mesh = torus(1.0, 0.3, 48);
    let exact = 2.0 * std::f64::consts::PI.powi(2) * 0.09;
    let found = pieces(&mesh, &HullOptions::default());
    assert!((8..=16).contains(&found.hulls.len()), "{}", found.hulls.len());
    assert!(found.quality.outside.max < 0.02 && found.quality.uncovered.max < 0.01, "{:?}", found.quality);
    assert!((volume(&found) / exact - 1.0).abs() < 0.1, "{} {exact}", volume(&found));
    assert_eq!(found, pieces(&mesh, &HullOptions::default()));
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(found, one.install(|| pieces(&mesh, &HullOptions::default())), "threads change nothing");
}

#[test]
fn an_error_that_is_asked_for_is_kept_with_few_pieces() {
    let mesh = torus(1.0, 0.3, 48);
    let mut last = 0;
    for error in [0.2, 0.05, 0.02] {
        let found = pieces(&mesh, &HullOptions { max_error: Some(error), ..HullOptions::default() });
        assert!(found.quality.hausdorff() <= error, "{error}: {:?}", found.quality);
        assert!(found.hulls.len() >= last);
        last = found.hulls.len();
    }
    assert_eq!(pieces(&mesh, &HullOptions { max_error: Some(0.5), ..HullOptions::default() }).hulls.len(), 1);
}

#[test]
fn a_limit_on_pieces() {
    let mesh = torus(1.0, 0.3, 32);
    for limit in [1, 2, 5] {
        let found = pieces(&mesh, &HullOptions { max_hulls: limit, ..HullOptions::default() });
        assert_eq!(found.hulls.len(), limit);
    }
}

#[test]
fn an_open_shell_has_pieces() {
    // A bowl without thickness.
    let profile: Vec<(f32, f32)> =
        (0..12).map(|at| (at as f32 / 8.0).sin_cos()).map(|(sin, cos)| (sin, -cos)).collect();
    let found = pieces(&turned(&profile, 40, false), &HullOptions::default());
    assert!(found.hulls.len() > 4, "{}", found.hulls.len());
    assert!(found.quality.outside.max < 0.1, "{:?}", found.quality);
}

/// Whether a point is in some piece.
fn is_filled(found: &Decomposition, point: [f32; 3]) -> bool {
    let point = DVec3::from(point.map(f64::from));
    found.hulls.iter().any(|hull| {
        let vertices: Vec<DVec3> = hull.vertices.iter().map(|vertex| DVec3::from(vertex.map(f64::from))).collect();
        let piece = Polyhedron { vertices, triangles: hull.triangles.clone() };
        piece.planes().iter().all(|(normal, offset)| normal.dot(point) <= *offset)
    })
}

#[test]
fn holes_stay_open() {
    // A probe from one point to another meets nothing on its way. A gap may be filled whose middle is nearer to the
    // surface than the error that is allowed; these are wider than that.
    let probes = [
        ("torus", [0.0, 0.0, -1.0], [0.0, 0.0, 1.0], 0.04),
        ("cup", [0.5, -1.0, 0.45], [0.5, 1.0, 0.45], 0.04),
        ("gear", [0.0, 0.0, -1.0], [0.0, 0.0, 1.0], 0.04),
        ("house", [0.9, -1.0, 0.95], [0.9, 3.0, 0.95], 0.04),
        ("fence", [0.33, -1.0, 0.5], [0.33, 1.0, 0.5], 0.01),
    ];
    for (name, from, to, error) in probes {
        let mesh = aam_fixtures::solids::solid(name).unwrap().triangles();
        let found = pieces(&mesh, &HullOptions { max_error: Some(error), ..HullOptions::default() });
        for step in 0..=100 {
            let share = step as f32 / 100.0;
            let point: [f32; 3] = std::array::from_fn(|i| from[i] + share * (to[i] - from[i]));
            assert!(!is_filled(&found, point), "{name}: {point:?} in one of {} pieces", found.hulls.len());
        }
    }
}

#[test]
fn what_is_wrong_with_a_mesh_does_not_matter() {
    let (vertices, triangles) = aam_fixtures::solids::solid("l").unwrap().triangles();
    let l = (vertices, triangles);
    let options = HullOptions::default();
    let exact = pieces(&l, &options);
    assert_eq!((exact.hulls.len(), exact.quality.hausdorff() < 1e-5), (2, true));
    let reversed = |[a, b, c]: [u32; 3]| [a, c, b];
    let inside_out = (l.0.clone(), l.1.iter().copied().map(reversed).collect());
    let duplicated = both(l.clone(), l.clone());
    let both_ways = both(l.clone(), inside_out.clone());
    let soup: Mesh = (
        l.1.iter().flatten().map(|index| l.0[*index as usize]).collect(),
        (0..l.1.len() as u32).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect(),
    );
    let with_waste = (l.0.clone(), l.1.iter().copied().chain([[0, 0, 1], [2, 2, 2]]).collect());
    for (name, mesh) in [
        ("inside out", inside_out),
        ("every triangle twice", duplicated),
        ("every triangle both ways", both_ways),
        ("without shared vertices", soup),
        ("with triangles without area", with_waste),
    ] {
        let found = pieces(&mesh, &options);
        assert!(found.hulls.len() <= 3 && found.quality.hausdorff() < 0.02, "{name}: {:?}", found.quality);
        assert!((volume(&found) / volume(&exact) - 1.0).abs() < 0.05, "{name}: {}", volume(&found));
    }
}

#[test]
fn self_intersecting_and_disconnected_meshes_come_apart() {
    for (name, most) in [("chair", 10), ("fence", 13)] {
        let found = pieces(&aam_fixtures::solids::solid(name).unwrap().triangles(), &HullOptions::default());
        assert!(found.hulls.len() <= most && found.quality.hausdorff() < 0.02, "{name}: {:?}", found.quality);
    }
}

#[test]
fn sheets_and_fins_become_plates() {
    // Three fins on one edge: no edge of a solid has three.
    let fin = |turn: f32| {
        let (sin, cos) = turn.sin_cos();
        (vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [cos, sin, 1.0], [cos, sin, 0.0]], vec![[0, 1, 2], [0, 2, 3]])
    };
    let fins = both(both(fin(0.0), fin(2.1)), fin(4.2));
    let bent = both(fin(0.0), fin(1.5));
    for (name, mesh, most) in [("fins", fins, 6), ("a bent sheet", bent, 4)] {
        let found = pieces(&mesh, &HullOptions::default());
        assert!(found.hulls.len() <= most && found.quality.hausdorff() < 0.02, "{name}: {:?}", found);
    }
}

#[test]
fn small_holes_of_a_scan_are_closed() {
    // A dent in a ball makes it no convex mesh; a missing triangle must not make it hollow.
    let (mut vertices, mut triangles) = sphere(40);
    let top = vertices.iter().position(|vertex| vertex[2] > 0.999).unwrap();
    let at_top = vertices[top];
    vertices.iter_mut().filter(|vertex| **vertex == at_top).for_each(|vertex| vertex[2] = 0.7);
    triangles.remove(triangles.len() / 2);
    let found = pieces(&(vertices, triangles), &HullOptions { max_error: Some(0.05), ..HullOptions::default() });
    assert!(found.hulls.len() <= 4, "{}", found.hulls.len());
    assert!(is_filled(&found, [0.0, 0.0, -0.5]));
}

#[test]
fn simple_shapes_are_found() {
    let options = HullOptions { primitives: true, ..HullOptions::default() };
    let found = pieces(&aam_fixtures::solids::solid("chair").unwrap().triangles(), &options);
    assert!(found.hulls.iter().all(|hull| matches!(hull.primitive, Some(Primitive::Box { .. }))), "{found:?}");
    assert!(found.quality.hausdorff() < 0.002);
    let found = pieces(&sphere(60), &options);
    let Some(Primitive::Sphere { center, radius }) = found.hulls[0].primitive else { panic!("{found:?}") };
    assert!((radius - 1.0).abs() < 0.02 && Vec3::from(center).length() < 0.02, "{center:?} {radius}");
    let found = pieces(&aam_fixtures::solids::solid("l").unwrap().triangles(), &options);
    assert_eq!(found.hulls.iter().filter(|hull| hull.primitive.is_some()).count(), 2);
}

#[test]
fn threads_change_nothing() {
    let mesh = aam_fixtures::solids::solid("gear").unwrap().triangles();
    let options = HullOptions { max_hulls: 20, max_error: None, ..HullOptions::default() };
    let [one, four] = [1, 4].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| pieces(&mesh, &options))
    });
    assert_eq!(one, four);
}

#[test]
fn what_has_no_pieces() {
    let options = HullOptions::default();
    let square = [[0.0_f32; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(decompose(&[], &[], &options), Err(HullError::Empty));
    assert_eq!(decompose(&square, &[], &options), Err(HullError::Empty));
    assert_eq!(decompose(&[[1.0; 3]; 3], &[[0, 1, 2]; 5], &options), Err(HullError::Empty));
    assert_eq!(decompose(&square, &[[0, 1, 1], [0, 0, 2]], &options), Err(HullError::Empty));
    assert_eq!(decompose(&square, &[[0, 1, 2], [0, 2, 3]], &options), Err(HullError::Flat));
    assert!(matches!(decompose(&square, &[[0, 1, 4]], &options), Err(HullError::Broken(_))));
    assert!(matches!(decompose(&[[f32::NAN; 3]; 3], &[[0, 1, 2]], &options), Err(HullError::Broken(_))));
    for wrong in [
        HullOptions { max_hulls: 0, ..options },
        HullOptions { max_vertices: 3, ..options },
        HullOptions { max_vertices: 256, ..options },
        HullOptions { max_error: Some(0.0), ..options },
        HullOptions { max_error: Some(f32::NAN), ..options },
    ] {
        assert!(matches!(decompose(&square, &[[0, 1, 2]], &wrong), Err(HullError::Option(_))));
    }
}

#[test]
fn odd_meshes_neither_panic_nor_hang() {
    let mut number = 7_u32;
    let mut random = move || {
        number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (number >> 8) as f32 / 16_777_216.0
    };
    let options = HullOptions { max_hulls: 8, ..HullOptions::default() };
    for round in 0..18 {
        let scale = [1e-30, 1e-6, 1.0, 1e6, 1e30, 1e37][round % 6];
        let squash = [1.0, 1e-3, 1e-7][round % 3];
        let count = 3 * (1 + round * 4);
        let vertices: Vec<[f32; 3]> =
            (0..count).map(|_| [random() * scale, random() * scale * squash, random() * scale]).collect();
        let triangles: Vec<[u32; 3]> = (0..count as u32 / 3).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
        if let Ok(found) = decompose(&vertices, &triangles, &options) {
            assert!(found.hulls.len() <= 8);
        }
    }
}

#[test]
fn many_large_triangles_take_bounded_time() {
    let mut number = 3_u32;
    let mut random = move || {
        number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (number >> 8) as f32 / 16_777_216.0
    };
    let vertices: Vec<[f32; 3]> = (0..30_000).map(|_| [random(), random(), random()]).collect();
    let triangles: Vec<[u32; 3]> = (0..10_000).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
    let unit = Unit::new(&vertices, &triangles).unwrap();
    // At 128 voxels this would be some 10¹⁰ tests.
    assert!(unit.voxels().len() <= 16 * 18 * 18);
}

/// Pieces and error for models that peers were measured on; the bounds are a little above what is reached.
#[test]
fn corpus_models() {
    let Some(folder) = std::env::var_os("AAM_CORPUS").map(PathBuf::from) else {
        println!("skipped: AAM_CORPUS is not set");
        return;
    };
    for name in ["fandisk", "rocker-arm", "spot", "stanford-bunny", "suzanne", "teapot"] {
        let asset = import(&folder.join(format!("obj/{name}.obj")), &ImportOptions::default(), &Silent).unwrap();
        let object = &asset.document.objects()[0];
        let triangles: Vec<[u32; 3]> =
            object.faces.as_ref().unwrap().triangles.iter().map(|triangle| triangle.vertices).collect();
        let start = std::time::Instant::now();
        let found = pieces(&(object.vertices.clone(), triangles), &HullOptions::default());
        println!(
            "{name}: {} pieces, error {:.2} %, uncovered {:.2} %, {} dropped, {:.1?}",
            found.hulls.len(),
            100.0 * found.quality.outside.max,
            100.0 * found.quality.uncovered.max,
            found.dropped,
            start.elapsed()
        );
        assert!(found.quality.hausdorff() <= 0.03, "{name}");
    }
}
