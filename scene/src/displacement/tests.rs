use std::collections::{BTreeMap, BTreeSet};
use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::*;
use crate::{MaterialId, MeshId, Node, Pixels, Texture, TextureId, TextureLayer};

fn image(width: u32, height: u32, value: impl Fn(u32, u32) -> f32) -> Arc<Image> {
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels = texels.flat_map(|(x, y)| [(65535.0 * value(x, y)) as u16, 7, 9, 65535]).collect();
    Arc::new(Image { width, height, pixels: Pixels::Rgba16(pixels) })
}

fn with_subset(mut mesh: Mesh) -> Mesh {
    let index_count = mesh.indices.len() as u32;
    mesh.subsets = vec![Subset { first_index: 0, index_count, material: MaterialId(0) }];
    mesh.bounds = Aabb::of(mesh.positions.iter().copied());
    mesh
}

fn triangle() -> Mesh {
    with_subset(Mesh {
        positions: vec![Vec3::ZERO, Vec3::new(3.0, 0.0, 0.0), Vec3::new(1.0, 2.0, 0.0)],
        normals: vec![Vec3::Z; 3],
        uvs: [None, None, None, Some(vec![Vec2::ZERO, Vec2::X, Vec2::Y])],
        indices: vec![0, 1, 2],
        ..Mesh::default()
    })
}

/// A sphere of radius 1 whose texture coordinates have a seam, and a vertex of their own for each triangle at the poles.
fn sphere(across: u32, down: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let mut uvs = Vec::new();
    for j in 0..=down {
        for i in 0..=across {
            let (phi, theta) = (TAU * (i % across) as f32 / across as f32, PI * j as f32 / down as f32);
            // Exactly one place for all vertices of a pole and of the seam.
            let ring = if j == 0 || j == down { 0.0 } else { theta.sin() };
            let p = Vec3::new(ring * phi.cos(), ring * phi.sin(), theta.cos());
            mesh.positions.push(p);
            mesh.normals.push(p);
            uvs.push(Vec2::new(i as f32 / across as f32, 1.0 - j as f32 / down as f32));
        }
    }
    for j in 0..down {
        for i in 0..across {
            let a = j * (across + 1) + i;
            let b = a + across + 1;
            if j > 0 {
                mesh.indices.extend([a, b, a + 1]);
            }
            if j + 1 < down {
                mesh.indices.extend([a + 1, b, b + 1]);
            }
        }
    }
    mesh.uvs[Layer::Displacement as usize] = Some(uvs);
    with_subset(mesh)
}

fn scene(mesh: Mesh, image: Arc<Image>) -> Scene {
    let layer = TextureLayer {
        texture: TextureId(0),
        transform: Mat3::IDENTITY,
        normal_space: NormalSpace::Object,
        intensity: 1.0,
    };
    let mut material = Material::default();
    material.layers[Layer::Displacement as usize] = Some(layer);
    let node =
        Node { name: String::new(), parent: None, local: Affine3A::IDENTITY, mesh: Some(MeshId(0)), visible: true };
    Scene {
        nodes: vec![node],
        meshes: vec![Arc::new(mesh)],
        materials: vec![material],
        textures: vec![Texture { name: "heights".into(), path: None, image: Ok(image) }],
        ..Scene::default()
    }
}

fn with(mut mesh: Mesh, tessellation: u32, bias: f32, scale: f32) -> Mesh {
    mesh.displacement = Some(Displacement { tessellation, bias, scale });
    mesh
}

/// Looks at the origin from so far away.
fn view(distance: f32) -> View {
    let camera = crate::Camera {
        name: String::new(),
        position: Vec3::new(0.6, -0.8, 0.0) * distance,
        target: Vec3::ZERO,
        up: Vec3::Z,
        projection: crate::Projection::Perspective { fov_y: 0.8 },
        near: 0.01,
        far: 100.0,
    };
    View { camera, width: 800, height: 600, frame: 0.0 }
}

/// The displaced mesh of a scene of one.
fn drawn(scene: &Scene) -> Arc<Mesh> {
    Arc::clone(&displaced(scene, &view(4.0), DisplacementMode::Uniform).unwrap().0.meshes[0])
}

fn corners(mesh: &Mesh) -> impl Iterator<Item = [Vec3; 3]> {
    mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|index| mesh.positions[index as usize]))
}

fn bits(p: Vec3) -> [u32; 3] {
    p.to_array().map(|c| (c + 0.0).to_bits())
}

/// Fails unless each edge of a surface, by the bits of its ends, is met once in each direction: no crack, not even one of
/// the last bit.
fn assert_watertight(mesh: &Mesh) {
    let mut edges: BTreeMap<[[u32; 3]; 2], i32> = BTreeMap::new();
    for triangle in corners(mesh) {
        for k in 0..3 {
            let [a, b] = [triangle[k], triangle[(k + 1) % 3]].map(bits);
            *edges.entry(if a < b { [a, b] } else { [b, a] }).or_default() += if a < b { 1 } else { -1 };
        }
    }
    let open = edges.values().filter(|sum| **sum != 0).count();
    assert_eq!(open, 0, "of {} edges", edges.len());
}

#[test]
fn a_factor_gives_its_square_of_triangles_and_each_point_once() {
    let mesh = triangle();
    let base = Base::new(&mesh, &mesh.subsets[0], &classes(&mesh));
    for factor in (1..=16).chain([37, 64, MAX_TESSELLATION]) {
        let plan = Plan::uniform(&base, factor, "", MAX_TRIANGLES).unwrap();
        assert_eq!(plan.triangle_count(), (factor * factor) as usize);
        assert_eq!(plan.points.len(), ((factor + 1) * (factor + 2) / 2) as usize);
        let places: BTreeSet<[u32; 3]> = plan.points.iter().map(|point| bits(point.mix(&mesh.positions))).collect();
        assert_eq!(places.len(), plan.points.len(), "all points differ");
        let used: BTreeSet<u32> = plan.indices.iter().copied().collect();
        assert_eq!(used.len(), plan.points.len(), "all points are used");
    }
}

#[test]
fn triangles_keep_their_winding_and_their_area() {
    let mesh = triangle();
    let base = Base::new(&mesh, &mesh.subsets[0], &classes(&mesh));
    for factor in 1..=16 {
        let plan = Plan::uniform(&base, factor, "", MAX_TRIANGLES).unwrap();
        let positions: Vec<Vec3> = plan.points.iter().map(|point| point.mix(&mesh.positions)).collect();
        let areas = plan.indices.chunks_exact(3).map(|t| {
            let [a, b, c] = [t[0], t[1], t[2]].map(|point| positions[point as usize]);
            0.5 * (b - a).cross(c - a).z
        });
        let areas: Vec<f32> = areas.collect();
        assert!(areas.iter().all(|area| *area > 0.0), "factor {factor}");
        assert!((areas.iter().sum::<f32>() - 3.0).abs() < 1e-4, "factor {factor}");
    }
}

#[test]
fn a_height_that_is_the_same_everywhere_moves_all_points_by_it_and_keeps_normals() {
    for (h, bias, scale) in [(0.0, 0.25, 9.0), (1.0, -0.5, 0.75), (0.5, 0.1, -0.4)] {
        let scene = scene(with(sphere(12, 6), 5, bias, scale), image(4, 4, |_, _| h));
        let mesh = drawn(&scene);
        let plain = drawn(&{
            let mut scene = scene.clone();
            Arc::make_mut(&mut scene.meshes[0]).displacement =
                Some(Displacement { tessellation: 5, bias: 1e-30, scale: 0.0 });
            scene
        });
        let moved = bias + scale * ((65535.0 * h) as u16 as f32 / 65535.0);
        for ((p, n), (q, m)) in mesh.positions.iter().zip(&mesh.normals).zip(plain.positions.iter().zip(&plain.normals))
        {
            assert!((*p - (*q + m.normalize() * moved)).length() < 1e-5, "{p} {q}");
            assert!((n.normalize() - m.normalize()).length() < 1e-4, "{n} {m}");
        }
    }
}

#[test]
fn only_the_red_channel_counts_and_texels_0_and_1_give_bias_and_bias_plus_scale() {
    for (red, expected) in [(0, 0.25), (255, 0.75)] {
        let pixels = [red, 255 - red, 77, 3].repeat(4);
        let image = Arc::new(Image { width: 2, height: 2, pixels: Pixels::Rgba8(pixels) });
        let mesh = drawn(&scene(with(triangle(), 3, 0.25, 0.5), image));
        assert!(mesh.positions.iter().all(|p| (p.z - expected).abs() < 1e-6));
    }
}

#[test]
fn a_closed_surface_stays_closed_also_where_the_map_has_a_seam() {
    // The left and right columns of the map differ as much as they can.
    let seam = image(64, 32, |x, y| if (x + y % 7) < 32 { 0.0 } else { 1.0 });
    let noise = image(61, 37, |x, y| ((x * 7919 + y * 104_729) % 1000) as f32 / 1000.0);
    for image in [seam, noise] {
        for factor in [1, 2, 3, 7, 16] {
            let mesh = drawn(&scene(with(sphere(9, 5), factor, -0.1, 0.4), Arc::clone(&image)));
            assert_watertight(&mesh);
        }
    }
}

#[test]
fn an_icosahedron_of_separate_corners_stays_closed() {
    // Every triangle with vertices of its own, whose texture coordinates have nothing to do with those next to it.
    let base = sphere(7, 4);
    let mut mesh = Mesh::default();
    let mut uvs = Vec::new();
    for (index, &vertex) in base.indices.iter().enumerate() {
        mesh.positions.push(base.positions[vertex as usize]);
        mesh.normals.push(base.normals[vertex as usize]);
        mesh.indices.push(index as u32);
        uvs.push(Vec2::new((index * 37 % 101) as f32 / 101.0, (index * 53 % 97) as f32 / 97.0));
    }
    mesh.uvs[3] = Some(uvs);
    let noise = image(32, 32, |x, y| ((x * 31 + y * 17) % 11) as f32 / 10.0);
    assert_watertight(&drawn(&scene(with(with_subset(mesh), 6, 0.0, 0.3), noise)));
}

#[test]
fn normals_are_those_of_the_displaced_surface() {
    // A plane displaced by a sine: z = 0.1 sin(2π u), normal (−0.2π cos(2π u), 0, 1).
    let mut mesh = triangle();
    mesh.positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let map = image(256, 4, |x, _| 0.5 + 0.5 * (TAU * (x as f32 + 0.5) / 256.0).sin());
    let mesh = drawn(&scene(with(mesh, 32, -0.1, 0.2), map));
    let mut worst = 0.0_f32;
    for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
        let exact = Vec3::new(-0.2 * PI * (TAU * p.x).cos(), 0.0, 1.0).normalize();
        worst = worst.max(n.normalize().angle_between(exact));
    }
    assert!(worst < 0.005, "{worst} rad");
}

#[test]
fn a_sphere_with_a_bulge_has_the_normals_of_its_triangles() {
    let bulge = image(256, 128, |x, y| {
        let (u, v) = (x as f32 / 256.0 - 0.5, y as f32 / 128.0 - 0.5);
        (-40.0 * (u * u + v * v)).exp()
    });
    let mesh = drawn(&scene(with(sphere(32, 16), 8, -0.05, 0.35), bulge));
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    for t in mesh.indices.chunks_exact(3) {
        let [a, b, c] = [t[0], t[1], t[2]].map(|index| mesh.positions[index as usize]);
        t.iter().for_each(|index| sums[*index as usize] += (b - a).cross(c - a).normalize_or_zero());
    }
    // A facet of the base mesh leans up to 0.1 rad away from the sphere's own normal.
    let angles: Vec<f32> = mesh.normals.iter().zip(&sums).map(|(n, sum)| n.angle_between(*sum)).collect();
    let mean = angles.iter().sum::<f32>() / angles.len() as f32;
    assert!(mean < 0.06, "{mean} rad in the mean");
    assert!(mesh.normals.iter().all(|n| n.is_finite() && (n.length() - 1.0).abs() < 0.02));
}

#[test]
fn what_should_not_be_gives_finite_surfaces() {
    let noise = image(8, 8, |x, y| ((x + 3 * y) % 5) as f32 / 4.0);
    let strange = [f32::NAN, f32::INFINITY, -f32::INFINITY, f32::MAX, -f32::MAX, 1e-38, -2.0];
    for value in strange {
        for (bias, scale) in [(value, 0.5), (0.5, value), (value, value)] {
            let mesh = drawn(&scene(with(sphere(6, 4), 3, bias, scale), Arc::clone(&noise)));
            assert!(mesh.positions.iter().chain(&mesh.normals).all(|v| v.is_finite()), "bias {bias}, scale {scale}");
            assert_watertight(&mesh);
        }
    }
    for value in strange {
        let mut mesh = with(sphere(6, 4), 3, 0.0, 0.2);
        mesh.uvs[3].as_mut().unwrap()[10] = Vec2::splat(value);
        mesh.uvs[3].as_mut().unwrap()[11].y = value;
        let mut scene = scene(mesh, Arc::clone(&noise));
        assert!(drawn(&scene).positions.iter().all(|p| p.is_finite()));
        scene.materials[0].layers[3].as_mut().unwrap().transform.x_axis.x = value;
        assert!(drawn(&scene).positions.iter().chain(&drawn(&scene).normals).all(|v| v.is_finite()));
    }
}

#[test]
fn degenerate_coordinates_and_normals_are_survived() {
    let noise = image(8, 8, |x, y| ((x + 3 * y) % 5) as f32 / 4.0);
    // All of the map's coordinates in one place: the displacement is the same everywhere.
    let mut mesh = with(sphere(6, 4), 4, 0.0, 0.2);
    mesh.uvs[3].as_mut().unwrap().fill(Vec2::splat(0.3));
    let flat = drawn(&scene(mesh, Arc::clone(&noise)));
    assert!(flat.normals.iter().all(|n| n.is_finite() && n.length() > 0.5));
    // Normals that cancel on the way from one corner to the next: nothing moves there.
    let mut mesh = with(triangle(), 2, 0.0, 1.0);
    mesh.normals = vec![Vec3::Z, Vec3::NEG_Z, Vec3::Z];
    let cancelled = drawn(&scene(mesh, Arc::clone(&noise)));
    assert!(cancelled.positions.iter().chain(&cancelled.normals).all(|v| v.is_finite()));
    // No normals at all: those of the triangles are taken.
    let mut mesh = with(triangle(), 2, 0.5, 0.0);
    mesh.normals = vec![Vec3::ZERO, Vec3::NAN, Vec3::ZERO];
    let made = drawn(&scene(mesh, noise));
    assert!(made.positions.iter().all(|p| (p.z - 0.5).abs() < 1e-6));
}

#[test]
fn triangles_that_are_none_are_left_out() {
    let mut mesh = with(triangle(), 4, 0.0, 1.0);
    mesh.positions.push(Vec3::NAN);
    mesh.normals.push(Vec3::Z);
    mesh.uvs[3].as_mut().unwrap().push(Vec2::ZERO);
    mesh.indices.extend([0, 1, 3, 0, 0, 1, 0, 1, 900]);
    let mesh = drawn(&scene(with_subset(mesh), image(2, 2, |x, _| x as f32)));
    assert_eq!(mesh.indices.len(), 3 * 16);
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
}

#[test]
fn too_many_triangles_are_refused_before_they_take_memory() {
    let mut mesh = with(triangle(), u32::MAX, 0.0, 1.0);
    mesh.name = "Moon".into();
    mesh.indices = [0, 1, 2].repeat(100_000);
    let scene = scene(with_subset(mesh), image(2, 2, |x, _| x as f32));
    let refused = displaced(&scene, &view(4.0), DisplacementMode::Uniform).unwrap_err().to_string();
    assert!(
        refused.starts_with("displacing mesh \"Moon\" with a tessellation factor of 1024 makes 104857600000"),
        "{refused}"
    );
    let said = warnings(&scene.meshes[0]);
    assert!(said.len() == 1 && said[0].contains("4294967295") && said[0].contains("1024"), "{said:?}");
}

#[test]
fn what_nothing_displaces_is_shared() {
    let map = image(2, 2, |x, _| x as f32);
    let plain = scene(triangle(), Arc::clone(&map));
    let shared = |scene: &Scene, mode| matches!(displaced(scene, &view(4.0), mode), Ok((Cow::Borrowed(_), _)));
    assert!(shared(&plain, DisplacementMode::Uniform), "no parameters");
    assert!(
        shared(&scene(with(triangle(), 8, 0.0, 0.0), Arc::clone(&map)), DisplacementMode::Uniform),
        "nothing moves"
    );
    let mut moved = scene(with(triangle(), 8, 0.0, 1.0), map);
    assert!(!shared(&moved, DisplacementMode::Uniform));
    assert!(shared(&moved, DisplacementMode::Off));
    Arc::make_mut(&mut moved.meshes[0]).uvs[3] = None;
    assert!(shared(&moved, DisplacementMode::Uniform), "no coordinates");
}

#[test]
fn bounds_hold_every_displaced_point() {
    let noise = image(8, 8, |x, y| ((x + 3 * y) % 5) as f32 / 4.0);
    for (bias, scale) in [(0.1, 0.5), (-0.3, 0.1), (0.2, -0.9)] {
        let scene = scene(with(sphere(8, 4), 6, bias, scale), Arc::clone(&noise));
        let bounds = scene.bounds();
        let mesh = drawn(&scene);
        assert!(mesh.positions.iter().all(|p| p.cmpge(bounds.min).all() && p.cmple(bounds.max).all()));
        assert_eq!(reach(&scene.meshes[0]), bias.abs().max((bias + scale).abs()));
    }
}

#[test]
fn other_attributes_are_interpolated_and_other_subsets_kept() {
    let mut mesh = with(triangle(), 2, 0.0, 1.0);
    mesh.uvs[0] = Some(vec![Vec2::ZERO, Vec2::new(2.0, 0.0), Vec2::new(0.0, 4.0)]);
    mesh.colors = Some(vec![glam::Vec4::ONE; 3]);
    mesh.indices = vec![0, 1, 2, 2, 1, 0];
    let mut mesh = with_subset(mesh);
    mesh.subsets[0].index_count = 3;
    mesh.subsets.push(Subset { first_index: 3, index_count: 3, material: MaterialId(1) });
    let mut scene = scene(mesh, image(2, 2, |_, _| 1.0));
    scene.materials.push(Material::default());
    let mesh = drawn(&scene);
    assert_eq!(mesh.subsets[1], Subset { first_index: 12, index_count: 3, material: MaterialId(1) });
    assert_eq!((mesh.positions.len(), mesh.indices.len()), (6 + 3, 12 + 3));
    let uvs = mesh.uvs[0].as_ref().unwrap();
    assert!(uvs[..6].contains(&Vec2::new(1.0, 2.0)) && mesh.colors.as_ref().unwrap().len() == 9);
    assert!(mesh.positions[6..].iter().all(|p| p.z == 0.0));
}

/// A flat square of so many cells a side, whose map covers it once.
fn court(cells: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let mut uvs = Vec::new();
    for j in 0..=cells {
        for i in 0..=cells {
            let uv = Vec2::new(i as f32, j as f32) / cells as f32;
            mesh.positions.push((uv - 0.5).extend(0.0) * 2.0);
            mesh.normals.push(Vec3::Z);
            uvs.push(uv);
        }
    }
    for j in 0..cells {
        for i in 0..cells {
            let a = j * (cells + 1) + i;
            mesh.indices.extend([a, a + 1, a + cells + 2, a, a + cells + 2, a + cells + 1]);
        }
    }
    mesh.uvs[3] = Some(uvs);
    with_subset(mesh)
}

/// Waves inside a disc that covers a twentieth of the map, nothing elsewhere.
fn waves() -> Arc<Image> {
    image(256, 256, |x, y| {
        let d = Vec2::new(x as f32 - 90.0, y as f32 - 160.0) / 256.0;
        let inside = (1.0 - d.length() / 0.13).max(0.0);
        0.5 + 0.5 * (inside * inside).min(1.0) * (90.0 * d.x).sin() * (70.0 * d.y).cos()
    })
}

fn adaptive(scene: &Scene, distance: f32, pixel_error: f32) -> Arc<Mesh> {
    let mode = DisplacementMode::Adaptive { pixel_error };
    Arc::clone(&displaced(scene, &view(distance), mode).unwrap().0.meshes[0])
}

/// The height of a mesh above a flat base, where a vertical line meets it.
fn height_over(mesh: &Mesh, at: Vec2) -> Option<f32> {
    corners(mesh).find_map(|[a, b, c]| {
        let (u, v, w) = ((b - a).truncate(), (c - a).truncate(), at - a.truncate());
        let area = u.perp_dot(v);
        let (s, t) = (w.perp_dot(v) / area, u.perp_dot(w) / area);
        (s >= -1e-5 && t >= -1e-5 && s + t <= 1.0 + 1e-5).then_some(a.z + s * (b.z - a.z) + t * (c.z - a.z))
    })
}

#[test]
fn adaptive_tessellation_is_watertight_whatever_its_factors() {
    let noise = image(61, 37, |x, y| if x > 40 { ((x * 7919 + y * 104_729) % 1000) as f32 / 1000.0 } else { 0.5 });
    for (distance, pixel_error) in [(1.6, 1.0), (3.0, 4.0), (3.0, 20.0), (20.0, 1.0), (1.05, 8.0)] {
        let scene = scene(with(sphere(9, 5), 1, -0.05, 0.1), Arc::clone(&noise));
        let mesh = adaptive(&scene, distance, pixel_error);
        assert_watertight(&mesh);
        println!("{distance} m, {pixel_error} pixels: {} triangles", mesh.indices.len() / 3);
    }
}

#[test]
fn adaptive_tessellation_keeps_what_it_promises() {
    let scene = scene(with(court(6), 1, 0.0, 0.1), waves());
    let heights = HeightMap::new(scene.textures[0].image.as_ref().unwrap()).unwrap();
    let view = view(3.0);
    let camera = view.camera.view();
    for pixel_error in [1.0, 4.0, 16.0] {
        let mesh = adaptive(&scene, 3.0, pixel_error);
        let mut worst = 0.0_f32;
        for step in 0..2000 {
            let uv = Vec2::new((step as f32 * 0.618_034).fract(), (step as f32 * 0.754_878).fract());
            let at = (uv - 0.5) * 2.0;
            let there = height_over(&mesh, at).unwrap();
            let depth = -camera.transform_point3(at.extend(0.0)).z;
            worst = worst.max((there - 0.1 * heights.at(uv)).abs() * 300.0 / 0.4_f32.tan() / depth);
        }
        println!("{pixel_error} pixels: {} triangles, {worst} pixels apart", mesh.indices.len() / 3);
        assert!(worst <= 0.5 * pixel_error, "{worst} of {pixel_error}");
    }
}

#[test]
fn triangles_go_where_the_heights_are() {
    let scene = scene(with(court(6), 1, 0.0, 0.1), waves());
    let mesh = adaptive(&scene, 3.0, 1.0);
    let middle = Vec2::new(90.0 / 256.0 - 0.5, 0.5 - 160.0 / 256.0) * 2.0;
    let (mut near, mut far) = (0, 0);
    for [a, b, c] in corners(&mesh) {
        let center = ((a + b + c) / 3.0).truncate();
        if center.distance(middle) < 0.3 { near += 1 } else { far += 1 }
    }
    assert!(near > 8 * far, "{near} in the disc, {far} outside");
    // From far away there is nothing to see, nor behind the camera.
    assert!(adaptive(&scene, 90.0, 8.0).indices.len() < 3 * 200);
    let mut away = view(3.0);
    away.camera.target = away.camera.position * 2.0;
    let mode = DisplacementMode::ADAPTIVE;
    assert_eq!(displaced(&scene, &away, mode).unwrap().0.meshes[0].indices.len(), 3 * 72);
}

#[test]
fn adaptive_tessellation_of_what_should_not_be_ends() {
    let noise = image(8, 8, |x, y| ((x + 3 * y) % 5) as f32 / 4.0);
    for value in [f32::NAN, f32::MAX, -1.0, 1e-38] {
        let scene = scene(with(sphere(4, 3), 3, value, 0.5), Arc::clone(&noise));
        for pixel_error in [20.0, f32::NAN, f32::INFINITY] {
            let mode = DisplacementMode::Adaptive { pixel_error };
            let mut far = view(3.0);
            far.camera.position *= if pixel_error.is_nan() { 1e9 } else { 1.0 };
            if let Ok((scene, _)) = displaced(&scene, &far, mode) {
                assert!(scene.meshes[0].positions.iter().all(|p| p.is_finite()));
            }
        }
    }
    let mut mesh = with(court(2), 1, 0.0, 1.0);
    mesh.uvs[3].as_mut().unwrap().fill(Vec2::splat(0.7));
    assert_eq!(adaptive(&scene(mesh, noise), 3.0, 0.1).indices.len(), 3 * 8, "one height everywhere");
}
