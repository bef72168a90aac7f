//! Where things appear: digest requirements 1–5.

use std::sync::Arc;

use aam_scene::*;
use glam::{Affine3A, Quat, Vec3};

use crate::common::*;

const WHITE: Vec3 = Vec3::ONE;

#[test]
fn r1_the_camera_looks_down_minus_z() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = scene_of(quad(), glow(WHITE), vec![dark()]);
    let camera = perspective(Vec3::ZERO);
    for (z, seen) in [(-2.0, 255), (2.0, 0)] {
        scene.nodes[0].local = at(z);
        assert_eq!(draw(&mut renderer, &scene, &camera, &options()).center(), [seen, seen, seen, 255]);
    }
}

#[test]
fn r2_x_is_right_and_y_is_up_in_the_picture() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = scene_of(quad(), glow(WHITE), vec![dark()]);
    // A quarter of the picture, at the lower left.
    scene.nodes[0].local =
        Affine3A::from_scale_rotation_translation(Vec3::splat(0.5), Quat::IDENTITY, Vec3::new(-0.5, -0.5, 0.0));
    for camera in [front(), Camera { near: 0.5, ..perspective(Vec3::Z) }] {
        let picture = draw(&mut renderer, &scene, &camera, &options());
        let lit = (0..64 * 64).filter(|i| picture.at(i % 64, i / 64)[0] == 255).count();
        assert_eq!(lit, 32 * 32);
        assert_eq!(picture.at(0, 63)[0], 255);
        assert_eq!(picture.at(31, 32)[0], 255);
        assert_eq!(picture.at(32, 32)[0], 0);
    }
}

#[test]
fn r3_both_sides_are_drawn_and_lit_towards_the_viewer() {
    let Some(mut renderer) = renderer() else { return };
    let material = Material { diffuse: WHITE, ..black() };
    let light = |z: f32| vec![directional(Vec3::new(0.0, 0.0, -z), WHITE)];
    let mut scene = scene_of(quad(), material, light(1.0));
    let behind = Camera { position: Vec3::new(0.0, 0.0, -5.0), ..front() };
    // Each side is lit by the light on its side alone.
    for (camera, lit_by) in [(front(), 1.0), (behind, -1.0)] {
        for z in [1.0, -1.0] {
            scene.lights = light(z);
            let expected = if z == lit_by { 255 } else { 0 };
            let picture = draw(&mut renderer, &scene, &camera, &options());
            assert_eq!(picture.center(), [expected, expected, expected, 255]);
        }
    }
}

#[test]
fn r3_a_mirrored_node_shows_the_same_side() {
    let Some(mut renderer) = renderer() else { return };
    // One face inwards would be dark: the light is where the camera is.
    let mut scene = scene_of(sphere(16), Material { diffuse: WHITE, ..black() }, vec![point(front().position, WHITE)]);
    let plain = draw(&mut renderer, &scene, &front(), &options());
    scene.nodes[0].local = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let mirrored = draw(&mut renderer, &scene, &front(), &options());
    assert!(plain.center()[0] > 250);
    let worst = (0..64 * 64)
        .map(|i| plain.at(i % 64, i / 64)[0].abs_diff(mirrored.at(63 - i % 64, i / 64)[0]))
        .filter(|difference| *difference > 2)
        .count();
    assert!(worst <= 8, "{worst} pixels differ");
}

#[test]
fn r4_poses_multiply_down_the_hierarchy() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = scene_of(quad(), glow(WHITE), vec![dark()]);
    let turn = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    // Turned by a quarter, then moved along what is now +Y, then shrunk: a parent without mesh counts as well.
    let chain = [
        (None, Affine3A::from_quat(turn)),
        (Some(NodeId(0)), Affine3A::from_translation(Vec3::new(0.5, 0.0, 0.0))),
        (Some(NodeId(1)), Affine3A::from_translation(Vec3::new(0.0, 0.5, 0.0))),
        (Some(NodeId(2)), Affine3A::from_scale(Vec3::splat(0.25))),
    ];
    scene.nodes = chain.into_iter().map(|(parent, local)| Node { parent, mesh: None, ..node(0, local) }).collect();
    scene.nodes[3].mesh = Some(MeshId(0));
    // Turned by 90°, (0.5, 0.5) is (−0.5, 0.5): columns 8–23 and rows 8–23.
    let picture = draw(&mut renderer, &scene, &front(), &options());
    let lit: Vec<(u32, u32)> =
        (0..64 * 64).map(|i| (i % 64, i / 64)).filter(|&(x, y)| picture.at(x, y)[0] > 0).collect();
    assert_eq!(lit.len(), 16 * 16);
    assert!(lit.iter().all(|&(x, y)| (8..24).contains(&x) && (8..24).contains(&y)));
    // Hiding a parent hides it.
    scene.nodes[1].visible = false;
    assert_eq!(draw(&mut renderer, &scene, &front(), &options()).stats.draws, 0);
}

#[test]
fn r5_v_is_zero_at_the_images_bottom() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = scene_of(quad(), glow(WHITE), vec![dark()]);
    // Red, green above; blue, white below.
    let colors = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]];
    let layer = layer(&mut scene, image8(2, 2, |x, y| colors[(2 * y + x) as usize]));
    scene.materials[0].layers[Layer::Diffuse as usize] = Some(layer);
    let picture = draw(&mut renderer, &scene, &front(), &options()).save("r5-uv");
    for (x, y, color) in [(16, 16, colors[0]), (48, 16, colors[1]), (16, 48, colors[2]), (48, 48, colors[3])] {
        // The texels' centres, half a pixel off.
        let expected = color.map(|c| f32::from(c) / 255.0);
        assert_near(picture.at(x, y), expected, 10.0);
    }
}

#[test]
fn animation_frames_move_nodes_and_vertices() {
    let Some(mut renderer) = renderer() else { return };
    let mut mesh = quad();
    let shifted = mesh.positions.iter().map(|p| 0.5 * *p + Vec3::new(0.5, 0.0, 0.0)).collect();
    mesh.frames = vec![MeshFrame { positions: shifted, normals: mesh.normals.clone() }];
    let mut scene = scene_of(mesh, glow(WHITE), vec![dark()]);
    let down = Affine3A::from_translation(Vec3::new(0.0, -0.5, 0.0));
    scene.animation = Some(Animation {
        frames_per_second: 30.0,
        frame_count: 3,
        nodes: vec![NodeMotion { node: NodeId(0), locals: vec![Affine3A::IDENTITY, Affine3A::IDENTITY, down] }],
    });
    let mut lit = |frame: f32| {
        let view = View { camera: front(), width: 64, height: 64, frame };
        let (image, _) = renderer.render_to_image(&scene, &view, &options()).unwrap();
        let Pixels::Rgba8(bytes) = image.pixels else { panic!() };
        let at = |x: usize, y: usize| bytes[4 * (y * 64 + x)] == 255;
        [at(5, 5), at(48, 36), at(48, 44), at(48, 60)]
    };
    assert_eq!(lit(0.0), [true; 4]);
    assert_eq!(lit(1.9), [false, true, true, false]);
    assert_eq!(lit(2.0), [false, true, true, true]);
    assert_eq!(lit(99.0), lit(2.0));
    assert_eq!(lit(f32::NAN), lit(0.0));
    assert_eq!(lit(-3.0), lit(0.0));
}

#[test]
fn far_from_the_origin_nothing_jitters() {
    let Some(mut renderer) = renderer() else { return };
    let material = Material { diffuse: WHITE, specular: WHITE, exponent: 20.0, ..black() };
    let mut scene = scene_of(sphere(32), material, vec![point(Vec3::new(2.0, 3.0, 4.0), WHITE)]);
    let near_by = draw(&mut renderer, &scene, &perspective(Vec3::new(0.0, 0.0, 3.0)), &options());
    // Powers of two, so that the scene itself is not rounded.
    let offset = Vec3::new(16384.0, -8192.0, 32768.0);
    scene.nodes[0].local = Affine3A::from_translation(offset);
    scene.lights = vec![point(Vec3::new(2.0, 3.0, 4.0) + offset, WHITE)];
    let far_away = draw(&mut renderer, &scene, &perspective(Vec3::new(0.0, 0.0, 3.0) + offset), &options());
    assert_eq!(near_by.bytes, far_away.bytes);
}

#[test]
fn depth_tells_apart_what_is_near_and_far() {
    let Some(mut renderer) = renderer() else { return };
    if renderer.gpu().summary().backend == "gl" {
        println!("skipped: wgpu's GL backend takes depth through −1 … 1, where floats near the far plane are coarse");
        return;
    }
    // A red square 1/1000 of its distance in front of a green one, from a millimetre to 100 km.
    let mut scene = scene_of(quad(), glow(Vec3::X), vec![dark()]);
    let mut green = quad();
    green.subsets[0].material = MaterialId(1);
    scene.meshes.push(Arc::new(green));
    scene.materials.push(glow(Vec3::Y));
    for distance in [1e-3, 1.0, 1e3, 1e5] {
        let placed = |factor: f32| {
            let scale = Vec3::splat(2.0 * distance);
            let position = Vec3::new(0.0, 0.0, -distance * factor);
            Affine3A::from_scale_rotation_translation(scale, Quat::IDENTITY, position)
        };
        // The farther one first and last.
        scene.nodes = vec![node(1, placed(1.001)), node(0, placed(1.0)), node(1, placed(1.001))];
        let camera = Camera { near: 1e-4, far: 1e6, ..perspective(Vec3::ZERO) };
        let picture = draw(&mut renderer, &scene, &camera, &options());
        assert!(picture.bytes.chunks(4).all(|pixel| pixel == [255, 0, 0, 255]), "at {distance} m");
    }
}
