//! Texture layers and vertex colours: digest requirements 17–22, 30–32, 46 and 47.

use std::sync::Arc;

use aam_renderer::{RenderOptions, Show};
use aam_scene::*;
use glam::{Affine2, Affine3A, Mat3, Quat, Vec2, Vec3, Vec4};

use crate::common::*;

fn set(scene: &mut Scene, layer: Layer, used: TextureLayer) {
    scene.materials[0].layers[layer as usize] = Some(used);
}

/// An image of one colour.
fn plain(color: [u8; 4]) -> Image {
    image8(1, 1, |_, _| color)
}

fn unit(color: [u8; 4]) -> Vec3 {
    Vec4::from_array(color.map(|c| f32::from(c) / 255.0)).truncate()
}

#[test]
fn r17_the_texture_multiplies_highlight_and_emission_too() {
    let Some(mut renderer) = renderer() else { return };
    let material = Material { specular: Vec3::ONE, exponent: 10.0, emission: Vec3::splat(0.3), ..black() };
    let mut scene = scene_of(quad(), material, vec![directional(Vec3::NEG_Z, Vec3::splat(0.5))]);
    let red = layer(&mut scene, plain([255, 0, 0, 255]));
    set(&mut scene, Layer::Diffuse, red);
    assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), Vec3::new(0.8, 0.0, 0.0));
}

#[test]
fn r18_the_texture_matrix_acts_from_the_bottom_left_and_costs_no_upload() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = scene_of(quad(), glow(Vec3::ONE), vec![dark()]);
    // Four quarters of 16 texels: red, green above; blue, white below.
    let quarters = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]];
    let image = image8(32, 32, |x, y| quarters[(2 * (y / 16) + x / 16) as usize]);
    let texel = |u: f32, v: f32| {
        let (x, y) = ((32.0 * u.rem_euclid(1.0)) as u32, (32.0 * (1.0 - v).rem_euclid(1.0)) as u32);
        quarters[(2 * (y.min(31) / 16) + x.min(31) / 16) as usize]
    };
    let used = layer(&mut scene, image);
    let matrices = [
        Affine2::IDENTITY,
        Affine2::from_scale(Vec2::splat(2.0)),
        Affine2::from_scale_angle_translation(Vec2::new(1.0, 3.0), 0.0, Vec2::new(0.25, 0.1)),
        Affine2::from_angle(std::f32::consts::FRAC_PI_2),
        Affine2::from_scale_angle_translation(Vec2::new(1.5, 0.7), 0.4, Vec2::new(-0.3, 2.2)),
    ];
    for (number, matrix) in matrices.into_iter().enumerate() {
        set(&mut scene, Layer::Diffuse, TextureLayer { transform: Mat3::from(matrix), ..used });
        let picture = draw(&mut renderer, &scene, &front(), &options()).save(&format!("r18-{number}"));
        if number > 0 {
            assert!(picture.stats.bytes_uploaded < 1024, "{} bytes", picture.stats.bytes_uploaded);
        }
        let mut compared = 0;
        for (x, y) in (0..64 * 64).map(|i| (i % 64, i / 64)) {
            let uv = Vec2::new((x as f32 + 0.5) / 64.0, 1.0 - (y as f32 + 0.5) / 64.0);
            let at = matrix.transform_point2(uv);
            // Away from the quarters' borders, where texels mix.
            let inside = |c: f32| (0.12..0.38).contains(&c.rem_euclid(0.5));
            if inside(at.x) && inside(at.y) {
                assert_color(picture.at(x, y), unit(texel(at.x, at.y)));
                compared += 1;
            }
        }
        assert!(compared > 500, "{compared}");
    }
}

#[test]
fn r19_layers_have_their_own_coordinates_and_matrices() {
    let Some(mut renderer) = renderer() else { return };
    let mut mesh = quad();
    // The diffuse texture runs along x, the light map along y, in a pool of their own each.
    let along =
        |pick: fn(&Vec3) -> f32| Some(quad().positions.iter().map(|p| Vec2::new(0.5 * pick(p) + 0.5, 0.5)).collect());
    mesh.uvs[Layer::Diffuse as usize] = along(|p| p.x);
    mesh.uvs[Layer::LightMap as usize] = along(|p| p.y);
    let mut scene = scene_of(mesh, Material { diffuse: Vec3::ONE, ..black() }, vec![dark()]);
    let halves = |a: u8, b: u8| image8(16, 1, move |x, _| if x < 8 { [a, a, a, 255] } else { [b, b, b, 255] });
    let diffuse = layer(&mut scene, halves(255, 102));
    let light_map = layer(&mut scene, halves(51, 255));
    set(&mut scene, Layer::Diffuse, diffuse);
    set(&mut scene, Layer::LightMap, light_map);
    let expected = |left: f32, below: f32| {
        move |x: u32, y: u32| Vec3::splat(if x < 32 { left } else { 0.4 } * if y >= 32 { below } else { 1.0 })
    };
    let check = |picture: &Picture, expected: &dyn Fn(u32, u32) -> Vec3| {
        for (x, y) in [(16, 16), (48, 16), (16, 48), (48, 48)] {
            assert_color(picture.at(x, y), expected(x, y));
        }
    };
    check(&draw(&mut renderer, &scene, &front(), &options()), &expected(1.0, 0.2));
    // Moving one layer by half its width leaves the other where it is.
    let half = Mat3::from_translation(Vec2::new(0.5, 0.0));
    set(&mut scene, Layer::LightMap, TextureLayer { transform: half, ..light_map });
    let swapped = |x: u32, y: u32| expected(1.0, 0.2)(x, 63 - y);
    check(&draw(&mut renderer, &scene, &front(), &options()), &swapped);
}

#[test]
fn r20_what_is_far_smaller_than_a_pixel_becomes_its_mean() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = scene_of(quad(), glow(Vec3::ONE), vec![dark()]);
    // 65 texels a side: levels of odd sizes.
    for size in [64, 65] {
        let board = image8(size, size, |x, y| if (x + y) % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] });
        let used = layer(&mut scene, board);
        let transform = Mat3::from_scale(Vec2::splat(64.0));
        set(&mut scene, Layer::Diffuse, TextureLayer { transform, ..used });
        for (shading, mean) in [(Shading::Source, 0.5), (Shading::Linear, encode(0.5))] {
            let shaded = RenderOptions { shading: Some(shading), ..options() };
            let picture = draw(&mut renderer, &scene, &front(), &shaded);
            for (x, y) in [(3, 3), (20, 41), (60, 2)] {
                assert_near(picture.at(x, y), [mean, mean, mean, 1.0], 2.0);
            }
        }
    }
}

#[test]
fn r21_light_maps_replace_lighting() {
    let Some(mut renderer) = renderer() else { return };
    let (emission, diffuse) = (Vec3::new(0.1, 0.0, 0.05), Vec3::new(0.5, 0.9, 0.7));
    let material = Material { emission, diffuse, ambient: Vec3::ONE, specular: Vec3::ONE, exponent: 3.0, ..black() };
    let mut scene = scene_of(quad(), material, vec![directional(Vec3::NEG_Z, Vec3::ONE)]);
    let (map, texel) = ([200, 100, 50, 255], [255, 204, 153, 255]);
    let used = layer(&mut scene, plain(map));
    set(&mut scene, Layer::LightMap, used);
    let used = layer(&mut scene, plain(texel));
    set(&mut scene, Layer::Diffuse, used);
    let expected = unit(texel) * (emission + diffuse * unit(map));
    assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), expected);
    scene.lights = vec![];
    scene.materials[0] = Material { ambient: Vec3::ZERO, specular: Vec3::ZERO, ..scene.materials[0].clone() };
    let slanted = Camera { position: Vec3::new(3.0, 1.0, 4.0), ..front() };
    assert_color(draw(&mut renderer, &scene, &slanted, &options()).center(), expected);
    // In linear light.
    let linear = RenderOptions { shading: Some(Shading::Linear), ..options() };
    let decoded = |c: Vec3| Vec3::from_array(c.to_array().map(decode));
    let expected = decoded(unit(texel)) * (decoded(emission) + decoded(diffuse) * decoded(unit(map)));
    let expected = Vec3::from_array(expected.to_array().map(encode));
    assert_color(draw(&mut renderer, &scene, &front(), &linear).center(), expected);
}

#[test]
fn r22_the_light_map_wins_over_the_normal_map() {
    let Some(mut renderer) = renderer() else { return };
    let material = Material { diffuse: Vec3::ONE, ..black() };
    let mut scene = scene_of(quad(), material, vec![directional(Vec3::NEG_Z, Vec3::ONE)]);
    let normal_map = layer(&mut scene, plain([255, 128, 128, 255]));
    set(&mut scene, Layer::Normal, normal_map);
    let light_map = layer(&mut scene, plain([100, 150, 200, 255]));
    set(&mut scene, Layer::LightMap, light_map);
    assert_eq!(draw(&mut renderer, &scene, &front(), &options()).center(), [100, 150, 200, 255]);
    assert_eq!(renderer.resources().textures, 1, "the normal map is not uploaded");
    // Without coordinates for it the light map does not count.
    Arc::make_mut(&mut scene.meshes[0]).uvs[Layer::LightMap as usize] = None;
    assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), Vec3::splat(0.004));
}

/// The unit vector that a texel of a normal map means.
fn vector(texel: [u8; 4]) -> Vec3 {
    (2.0 * unit(texel) - 1.0).normalize()
}

#[test]
fn r30_object_space_normals_are_data_and_made_unit() {
    let Some(mut renderer) = renderer() else { return };
    for texel in [[255, 128, 128, 0], [128, 128, 255, 255], [180, 90, 200, 9], [140, 128, 160, 255]] {
        let n = vector(texel);
        // The light along X sees the x of the normal, in both modes the same number before encoding.
        for (axis, value) in [(Vec3::X, n.x), (Vec3::Y, n.y), (Vec3::Z, n.z)] {
            let lights = vec![directional(-axis, Vec3::ONE)];
            let mut scene = scene_of(quad(), Material { diffuse: Vec3::ONE, ..black() }, lights);
            let used = layer(&mut scene, plain(texel));
            set(&mut scene, Layer::Normal, used);
            let value = value.max(0.0);
            assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), Vec3::splat(value));
            let linear = RenderOptions { shading: Some(Shading::Linear), ..options() };
            assert_color(draw(&mut renderer, &scene, &front(), &linear).center(), Vec3::splat(encode(value)));
        }
    }
    // (255, 128, 128) is +X within half a degree.
    assert!(vector([255, 128, 128, 255]).angle_between(Vec3::X).to_degrees() < 0.5);
}

#[test]
fn r31_object_space_normals_turn_and_stretch_with_the_object() {
    let Some(mut renderer) = renderer() else { return };
    let texel = [190, 160, 230, 255];
    let light = Vec3::new(0.5, 1.0, 2.0).normalize();
    for local in [
        Affine3A::IDENTITY,
        Affine3A::from_quat(Quat::from_rotation_z(1.2)),
        Affine3A::from_quat(Quat::from_axis_angle(Vec3::new(1.0, 2.0, 0.0).normalize(), 0.5)),
        Affine3A::from_scale(Vec3::new(1.0, 3.0, 2.0)),
        Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0)),
    ] {
        let mut scene =
            scene_of(quad(), Material { diffuse: Vec3::ONE, ..black() }, vec![directional(-light, Vec3::ONE)]);
        scene.nodes[0].local = local;
        let used = layer(&mut scene, plain(texel));
        set(&mut scene, Layer::Normal, used);
        let turned = Mat3::from(local.matrix3).inverse().transpose() * vector(texel);
        let expected = Vec3::splat(turned.normalize().dot(light).max(0.0));
        assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), expected);
    }
}

#[test]
fn tangent_space_normals_lean_along_u_and_v() {
    let Some(mut renderer) = renderer() else { return };
    let texel = [200, 90, 220, 255];
    let c = 2.0 * unit(texel) - 1.0;
    // The frame, in the object: u along t, v along b = w (n × t).
    for (t, w) in [(Vec3::X, 1.0), (Vec3::Y, 1.0), (Vec3::X, -1.0)] {
        for intensity in [1.0, 0.3] {
            for local in [
                Affine3A::IDENTITY,
                Affine3A::from_scale(Vec3::new(2.0, 1.0, 1.0)),
                Affine3A::from_quat(Quat::from_rotation_x(0.4)),
            ] {
                let mut mesh = quad();
                mesh.tangents = Some(vec![t.extend(w); 4]);
                let mut scene = scene_of(mesh, Material { diffuse: Vec3::ONE, ..black() }, vec![]);
                scene.nodes[0].local = local;
                let used = layer(&mut scene, plain(texel));
                set(&mut scene, Layer::Normal, TextureLayer { normal_space: NormalSpace::Tangent, intensity, ..used });
                let n = intensity * (c.x * t + c.y * w * Vec3::Z.cross(t)) + c.z * Vec3::Z;
                let n = (Mat3::from(local.matrix3).inverse().transpose() * n).normalize();
                for axis in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z] {
                    scene.lights = vec![directional(-axis, Vec3::ONE)];
                    let expected = Vec3::splat(n.dot(axis).max(0.0));
                    assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), expected);
                }
            }
        }
    }
}

#[test]
fn a_tangent_space_map_on_a_mesh_without_tangents_counts_as_absent() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene =
        scene_of(quad(), Material { diffuse: Vec3::ONE, ..black() }, vec![directional(Vec3::NEG_Z, Vec3::ONE)]);
    let used = layer(&mut scene, plain([255, 128, 128, 255]));
    set(&mut scene, Layer::Normal, TextureLayer { normal_space: NormalSpace::Tangent, ..used });
    assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), Vec3::ONE);
}

#[test]
fn r46_r47_layers_without_coordinates_or_image_are_left_out() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = scene_of(quad(), glow(Vec3::ONE), vec![dark()]);
    let used = layer(&mut scene, plain([255, 0, 0, 255]));
    set(&mut scene, Layer::Diffuse, used);
    let mut bare = quad();
    bare.uvs = Default::default();
    scene.meshes.push(Arc::new(bare));
    scene.nodes = [(0, -0.5), (1, 0.5)]
        .map(|(mesh, x)| {
            let place = Vec3::new(x, 0.0, 0.0);
            node(mesh, Affine3A::from_scale_rotation_translation(Vec3::splat(0.4), Quat::IDENTITY, place))
        })
        .into();
    let picture = draw(&mut renderer, &scene, &front(), &options());
    assert_eq!((picture.at(16, 32), picture.at(48, 32)), ([255, 0, 0, 255], [255; 4]));
    // Two keys, two programs, two draws.
    assert_eq!((picture.stats.pipelines_built, picture.stats.draws), (2, 2));
    // Without its image the layer is gone for both, and one program does.
    scene.textures[0].image = Err("not found".into());
    let picture = draw(&mut renderer, &scene, &front(), &options());
    assert_eq!((picture.at(16, 32), picture.at(48, 32)), ([255; 4], [255; 4]));
    assert_eq!((picture.stats.pipelines_built, picture.stats.pipeline_switches), (0, 1));
}

#[test]
fn vertex_colours_multiply_and_are_decoded_in_linear_light() {
    let Some(mut renderer) = renderer() else { return };
    let mut mesh = quad();
    let (left, right) = (Vec4::new(0.2, 0.8, 0.5, 1.0), Vec4::new(1.0, 0.3, 0.5, 1.0));
    mesh.colors = Some(mesh.positions.iter().map(|p| if p.x < 0.0 { left } else { right }).collect());
    let mut scene = scene_of(mesh, glow(Vec3::splat(0.9)), vec![dark()]);
    let used = layer(&mut scene, plain([204, 255, 255, 255]));
    set(&mut scene, Layer::Diffuse, used);
    let share = (48.0 + 0.5) / 64.0;
    let texel = unit([204, 255, 255, 255]);
    let mixed = left.lerp(right, share).truncate();
    assert_color(draw(&mut renderer, &scene, &front(), &options()).at(48, 20), 0.9 * texel * mixed);
    let linear = RenderOptions { shading: Some(Shading::Linear), ..options() };
    let decoded = |c: Vec3| Vec3::from_array(c.to_array().map(decode));
    let mixed = decoded(left.truncate()).lerp(decoded(right.truncate()), share);
    let expected = decode(0.9) * decoded(texel) * mixed;
    let expected = Vec3::from_array(expected.to_array().map(encode));
    assert_color(draw(&mut renderer, &scene, &front(), &linear).at(48, 20), expected);
}

#[test]
fn sixteen_bit_and_float_images_are_drawn() {
    let Some(mut renderer) = renderer() else { return };
    let [r, g, b] = [0.123, 0.5, 0.987];
    let code = |v: f32| (v * 65535.0).round() as u16;
    let deep = Image { width: 1, height: 1, pixels: Pixels::Rgba16(vec![code(r), code(g), code(b), 65535]) };
    let float = Image { width: 1, height: 1, pixels: Pixels::RgbF32(vec![r, g, 3.0]) };
    for (image, half, linear) in [
        (deep, Vec3::new(r, g, b), Vec3::new(r, g, b).map(decode)),
        // Float images are linear, whatever the mode; 3 stays 3 until the end.
        (float, Vec3::new(r, g, 3.0), Vec3::new(r, g, 3.0)),
    ] {
        let mut scene = scene_of(quad(), glow(Vec3::splat(0.5)), vec![dark()]);
        let used = layer(&mut scene, image);
        set(&mut scene, Layer::Diffuse, used);
        assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), 0.5 * half);
        let in_linear = RenderOptions { shading: Some(Shading::Linear), ..options() };
        let expected = (decode(0.5) * linear).min(Vec3::ONE).map(encode);
        assert_color(draw(&mut renderer, &scene, &front(), &in_linear).center(), expected);
    }
}

#[test]
fn layers_and_coordinates_can_be_shown_alone() {
    let Some(mut renderer) = renderer() else { return };
    let texels = [[10, 20, 30, 255], [200, 100, 50, 255], [128, 128, 255, 255], [77, 77, 77, 255]];
    let mut scene = scene_of(quad(), Material { diffuse: Vec3::splat(0.1), ..black() }, vec![dark()]);
    scene.shading = Shading::Linear;
    for (which, texel) in Layer::ALL.into_iter().zip(texels) {
        let used = layer(&mut scene, plain(texel));
        set(&mut scene, which, used);
        let shown = RenderOptions { show: Show::Layer(which), ..options() };
        assert_eq!(draw(&mut renderer, &scene, &front(), &shown).center(), texel, "{which:?}");
    }
    let shown = RenderOptions { show: Show::Uvs(Layer::LightMap), ..options() };
    let picture = draw(&mut renderer, &scene, &front(), &shown);
    assert_color(picture.at(10, 20), Vec3::new(10.5 / 64.0, 1.0 - 20.5 / 64.0, 0.0));
    Arc::make_mut(&mut scene.meshes[0]).uvs = Default::default();
    for show in [Show::Uvs(Layer::Diffuse), Show::Layer(Layer::Normal)] {
        let picture = draw(&mut renderer, &scene, &front(), &RenderOptions { show, ..options() });
        assert_color(picture.center(), Vec3::splat(0.2));
    }
}

#[test]
fn anisotropic_filtering_keeps_detail_at_grazing_angles() {
    let Some(mut renderer) = renderer() else { return };
    // Stripes along the view on a floor: across it they are wide enough, along it there is nothing to blur.
    let mut scene = scene_of(quad(), glow(Vec3::ONE), vec![dark()]);
    let stripes = image8(64, 64, |x, _| if x / 4 % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] });
    let used = layer(&mut scene, stripes);
    set(&mut scene, Layer::Diffuse, used);
    let position = Vec3::new(0.0, -3.0, 0.3);
    let camera = Camera { position, target: Vec3::ZERO, up: Vec3::Z, ..perspective(position) };
    let mut contrast = |anisotropy: u16| {
        let filtered = RenderOptions { anisotropy, ..options() };
        let picture = draw_sized(&mut renderer, &scene, &camera, &filtered, 256, 128).save("anisotropy");
        let row = (90..166).map(|x| i32::from(picture.at(x, 66)[0]));
        let values: Vec<i32> = row.collect();
        values.windows(2).map(|pair| (pair[0] - pair[1]).abs()).sum::<i32>()
    };
    let (off, on) = (contrast(1), contrast(16));
    assert!(on > 2 * off, "{on} against {off}");
    // Beyond the range counts as its end.
    assert_eq!((contrast(0), contrast(999)), (off, on));
}
