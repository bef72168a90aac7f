//! Determinism, frames of animation, and input that should not be.

mod common;

use std::num::NonZeroUsize;
use std::sync::{Arc, Mutex};

use aam_reference::{Error, LightSize, Options, radiance, render, visibility};
use aam_scene::{
    Animation, Falloff, Layer, LightKind, LightShape, MeshFrame, NodeId, NodeMotion, Projection, Scene, Shading,
    Texture, View,
};
use common::*;
use glam::{Affine3A, Vec2, Vec3};

#[test]
fn the_picture_does_not_depend_on_the_number_of_threads() {
    let mut scene = scene(vec![sphere(40), quad(-0.5)], chalk(), point_light(1.0, 2.0, 3.0));
    scene.materials[0].opacity = 0.7;
    put_texture(&mut scene, Layer::Diffuse, image(37, 11, |x, y| [(7 * x) as u8, (23 * y) as u8, 90, 255]));
    let view = from_above(77);
    let pictures = [1, 2, 5].map(|threads| {
        let threads = NonZeroUsize::new(threads);
        draw_with(&scene, &view, &Options { shadows: Some(LightSize::Point), threads, ..Options::default() }).bytes
    });
    assert!(pictures[0] == pictures[1] && pictures[0] == pictures[2]);
}

#[test]
fn neither_does_light_of_chance_but_on_the_seed() {
    let mut scene = scene(vec![sphere(40), quad(-0.5)], chalk(), point_light(1.0, 2.0, 3.0));
    scene.materials[0].diffuse = Vec3::splat(0.7);
    scene.lights[0].shape = Some(LightShape::Sphere { radius: 0.8 });
    let draw = |threads, seed| {
        let options = Options {
            samples_per_pixel: 4,
            shadows: Some(LightSize::Area),
            light_samples: 4,
            bounces: 6,
            environment: Vec3::splat(0.2),
            shading: Some(Shading::Linear),
            threads: NonZeroUsize::new(threads),
            seed,
            ..Options::default()
        };
        let (seen, _) = visibility(&scene, &from_above(40), LightSize::Area, &options).unwrap();
        (radiance(&scene, &from_above(40), &options).unwrap().0, seen)
    };
    let one = draw(1, 0);
    assert!(one == draw(2, 0) && one == draw(5, 0));
    let other = draw(1, 1);
    assert!(one.0 != other.0 && one.1 != other.1);
}

#[test]
fn progress_ends_at_one() {
    let seen = Mutex::new(Vec::new());
    let note = |fraction: f32| seen.lock().unwrap().push(fraction);
    let options = Options { progress: Some(&note), ..Options::default() };
    let (_, stats) = render(&scene(vec![quad(0.0)], chalk(), straight_down()), &from_above(30), &options).unwrap();
    let mut seen = seen.into_inner().unwrap();
    seen.sort_by(f32::total_cmp);
    assert!(seen.len() == 4 && seen[3] == 1.0 && seen[0] > 0.0, "{seen:?}");
    assert_eq!(
        (stats.triangles, stats.camera_rays, stats.shadow_rays, stats.camera_light),
        (2, 30 * 30 * 16, 0, false)
    );
}

#[test]
fn frames_move_nodes_and_vertices_and_the_last_one_stays() {
    let mut scene = scene(vec![quad(0.0)], glowing(1.0, 1.0, 1.0), straight_down());
    let right = |x: f32| Affine3A::from_translation(Vec3::new(x, 0.0, 0.0));
    scene.animation = Some(Animation {
        frames_per_second: 30.0,
        frame_count: 2,
        nodes: vec![NodeMotion { node: NodeId(0), locals: vec![right(0.0), right(1.0)] }],
    });
    let mesh = Arc::make_mut(&mut scene.meshes[0]);
    let up: Vec<Vec3> = mesh.positions.iter().map(|position| *position + Vec3::Y).collect();
    mesh.frames = vec![
        MeshFrame { positions: mesh.positions.clone(), normals: mesh.normals.clone() },
        MeshFrame { positions: up, normals: mesh.normals.clone() },
    ];
    let quarters = |frame: f32| {
        let picture = draw(&scene, &View { frame, ..from_above(2) }, 1);
        [picture.at(0, 0)[3], picture.at(1, 0)[3], picture.at(0, 1)[3], picture.at(1, 1)[3]]
    };
    assert_eq!(quarters(0.9), [255, 255, 255, 255]);
    assert_eq!(quarters(1.0), [0, 255, 0, 255]);
    for frame in [2.0, 1e9, f32::INFINITY] {
        assert_eq!(quarters(frame), [0, 255, 0, 0]);
    }
    for frame in [-3.0, f32::NAN] {
        assert_eq!(quarters(frame), [255, 255, 255, 255]);
    }
}

#[test]
fn parents_carry_their_children() {
    let mut scene = scene(vec![quad(0.0)], glowing(1.0, 1.0, 1.0), straight_down());
    let mut parent = node(0, Affine3A::from_translation(Vec3::X));
    parent.mesh = None;
    scene.nodes.insert(0, parent.clone());
    scene.nodes.insert(1, aam_scene::Node { parent: Some(NodeId(0)), ..parent });
    scene.nodes[1].local = Affine3A::from_rotation_z(std::f32::consts::FRAC_PI_2);
    scene.nodes[2].parent = Some(NodeId(1));
    scene.nodes[2].local = Affine3A::from_translation(Vec3::new(-1.0, 0.0, 0.0));
    // (−1, 0) turned by 90° is (0, −1), moved right is (1, −1).
    let picture = draw(&scene, &from_above(2), 1);
    assert_eq!([(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| picture.at(x, y)[3]), [0, 0, 0, 255]);
}

#[test]
fn a_scene_without_lights_is_lit_from_the_camera_and_says_so() {
    let mut scene = scene(vec![quad(0.0)], chalk(), straight_down());
    scene.lights.clear();
    let (_, stats) = render(&scene, &from_above(3), &Options::default()).unwrap();
    assert!(stats.camera_light);
    assert_eq!(draw(&scene, &from_above(3), 1).at(1, 1), [255; 4]);
}

#[test]
fn impossible_requests_are_refused_with_a_reason() {
    let scene = Scene::default();
    let refuse = |view: &View, samples: u32| {
        render(&scene, view, &Options { samples_per_pixel: samples, ..Options::default() }).unwrap_err()
    };
    let view = from_above(4);
    assert_eq!(refuse(&View { width: 0, ..view.clone() }, 1), Error::Size { width: 0, height: 4 });
    assert!(matches!(refuse(&View { height: u32::MAX, ..view.clone() }, 1), Error::Size { .. }));
    assert_eq!(refuse(&view, 0), Error::Samples(0));
    assert_eq!(refuse(&view, 1 << 20), Error::Samples(1 << 20));
    let breakages: [fn(&mut View); 7] = [
        |view| view.camera.position.x = f32::NAN,
        |view| view.camera.near = 0.0,
        |view| view.camera.far = view.camera.near,
        |view| view.camera.far = f32::INFINITY,
        |view| view.camera.projection = Projection::Perspective { fov_y: 0.0 },
        |view| view.camera.projection = Projection::Perspective { fov_y: 3.2 },
        |view| view.camera.projection = Projection::Orthographic { height: f32::NAN },
    ];
    for breakage in breakages {
        let mut view = view.clone();
        breakage(&mut view);
        assert!(matches!(refuse(&view, 1), Error::Camera(_)));
    }
    let many = Scene { lights: vec![light(straight_down()); 65], ..Scene::default() };
    assert_eq!(render(&many, &view, &Options::default()).unwrap_err(), Error::Lights(65));
}

#[test]
fn a_camera_that_looks_along_its_up_vector_still_sees() {
    let scene = scene(vec![quad(0.0)], chalk(), straight_down());
    let mut view = from_above(3);
    for up in [Vec3::Z, Vec3::ZERO] {
        view.camera.up = up;
        assert_eq!(draw(&scene, &view, 1).at(1, 1), [255; 4]);
    }
}

#[test]
fn broken_meshes_are_drawn_as_far_as_they_are_whole() {
    let mut broken = quad(0.0);
    broken.positions.push(Vec3::new(f32::NAN, 0.0, 0.0));
    broken.positions.push(Vec3::splat(1e30));
    broken.normals.extend([Vec3::Z; 2]);
    broken.indices.extend([0, 1, 4, 0, 1, 5, 0, 1, u32::MAX, 2]);
    broken.subsets[0].index_count = 1000;
    for uvs in &mut broken.uvs {
        *uvs = Some(vec![Vec2::NAN; 6]);
    }
    // Missing normals are those of the faces.
    broken.normals.clear();
    let mut scene = scene(vec![broken], chalk(), straight_down());
    put_texture(&mut scene, Layer::Diffuse, image(1, 1, |_, _| [255; 4]));
    scene.nodes.push(node(77, Affine3A::IDENTITY));
    scene.nodes.push(node(0, Affine3A::from_scale(Vec3::splat(f32::NAN))));
    let (_, stats) = render(&scene, &from_above(3), &Options::default()).unwrap();
    assert_eq!((stats.triangles, stats.skipped_triangles), (2, 3 + 5));
    assert_eq!(draw(&scene, &from_above(3), 1).at(1, 1), [255; 4]);

    scene.textures[0] = Texture { name: String::new(), path: None, image: Err("gone".into()) };
    assert_eq!(draw(&scene, &from_above(3), 1).at(1, 1), [255; 4], "a layer without an image counts as absent");
    Arc::make_mut(&mut scene.meshes[0]).subsets[0].material.0 = 99;
    assert_eq!(draw(&scene, &from_above(3), 1).at(1, 1), [204, 204, 204, 255], "the default material");
}

#[test]
fn numbers_that_are_none_become_what_the_shading_page_says() {
    let mut scene = scene(vec![quad(0.0)], chalk(), straight_down());
    let material = &mut scene.materials[0];
    material.emission = Vec3::new(f32::NAN, -1.0, f32::INFINITY);
    material.specular = Vec3::ONE;
    material.exponent = f32::NAN;
    material.opacity = f32::NAN;
    scene.lights.push(light(LightKind::Directional { direction: Vec3::NAN }));
    scene.lights.push(light(LightKind::Point { position: Vec3::INFINITY, falloff: Falloff::InverseSquare }));
    assert_eq!(draw(&scene, &from_above(3), 1).at(1, 1), [255; 4]);
}

#[test]
fn triangles_that_no_hierarchy_can_part_are_not_a_trap() {
    // All at one place, all around one centre, and each twice as far as the last.
    let layouts: [fn(f32) -> (f32, f32); 3] =
        [|_| (1.0, 0.0), |i| (1.0 + i, 0.0), |i| (1.0, -(i % 30.0).exp2() / 1e3 - i / 1e9)];
    for layout in layouts {
        let mut mesh = quad(0.0);
        let (corners, count) = (mesh.positions.clone(), 50_000);
        let place = |i: u32| {
            let (scale, z) = layout(i as f32);
            corners.iter().map(move |corner| *corner * scale + Vec3::Z * z)
        };
        mesh.positions = (0..count).flat_map(place).collect();
        mesh.normals = vec![Vec3::Z; mesh.positions.len()];
        mesh.indices = (0..count).flat_map(|i| [0, 1, 2, 0, 2, 3].map(|corner| 4 * i + corner)).collect();
        mesh.subsets[0].index_count = mesh.indices.len() as u32;
        let scene = scene(vec![mesh], chalk(), straight_down());
        let (_, stats) = render(&scene, &from_above(3), &Options::default()).unwrap();
        assert_eq!(draw(&scene, &from_above(3), 1).at(1, 1), [255; 4]);
        assert!(stats.build + stats.trace < std::time::Duration::from_secs(20), "{stats:?}");
    }
}
