//! What is uploaded, compiled and kept: only what the scene uses, and once. Digest requirements 46, 48 and 50.

use std::sync::Arc;

use aam_renderer::{Msaa, RenderOptions, Resources};
use aam_scene::*;
use glam::{Affine3A, Vec3, Vec4};

use crate::common::*;

fn msaa() -> RenderOptions {
    RenderOptions { msaa: Msaa::X4, ..options() }
}

#[test]
fn an_empty_scene_costs_nothing_but_the_picture() {
    let Some(mut renderer) = renderer() else { return };
    let picture = draw(&mut renderer, &Scene::default(), &front(), &msaa());
    assert_eq!((picture.stats.draws, picture.stats.bytes_uploaded, picture.stats.pipelines_built), (0, 0, 0));
    // The picture itself is the one target: no depth, no samples.
    assert_eq!(renderer.resources(), Resources { targets: 1, ..Resources::default() });
    // Nodes without meshes, and meshes without triangles, are nothing either.
    let mut scene = scene_of(Mesh::default(), black(), vec![]);
    scene.nodes.push(Node { mesh: None, ..node(0, Affine3A::IDENTITY) });
    let picture = draw(&mut renderer, &scene, &front(), &msaa());
    assert_eq!((picture.stats.draws, renderer.resources().meshes, renderer.resources().targets), (0, 0, 1));
}

#[test]
fn targets_are_those_that_the_options_need() {
    let Some(mut renderer) = renderer() else { return };
    let scene = scene_of(quad(), glow(Vec3::ONE), vec![dark()]);
    draw(&mut renderer, &scene, &front(), &options());
    assert_eq!(renderer.resources().targets, 2, "picture and depth");
    let Some(mut renderer) = self::renderer() else { return };
    draw(&mut renderer, &scene, &front(), &msaa());
    assert_eq!(renderer.resources().targets, 3, "picture, samples and depth");
    // Those of another size go after some pictures.
    for _ in 0..6 {
        draw_sized(&mut renderer, &scene, &front(), &msaa(), 32, 32);
    }
    assert_eq!(renderer.resources().targets, 3);
}

#[test]
fn only_streams_that_a_shader_reads_are_uploaded() {
    let Some(mut renderer) = renderer() else { return };
    let mut mesh = quad();
    mesh.tangents = Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4]);
    mesh.colors = Some(vec![Vec4::ONE; 4]);
    let mut scene =
        scene_of(mesh, Material { diffuse: Vec3::ONE, ..black() }, vec![directional(Vec3::NEG_Z, Vec3::ONE)]);
    draw(&mut renderer, &scene, &front(), &options());
    // Positions, indices, normals, colours.
    assert_eq!(renderer.resources().mesh_buffers, 4);
    // A normal map adds tangents and its coordinates.
    let used = layer(&mut scene, image8(1, 1, |_, _| [128, 128, 255, 255]));
    let used = TextureLayer { normal_space: NormalSpace::Tangent, ..used };
    scene.materials[0].layers[Layer::Normal as usize] = Some(used);
    draw(&mut renderer, &scene, &front(), &options());
    assert_eq!((renderer.resources().mesh_buffers, renderer.resources().textures), (6, 1));
    // What shines by itself needs no normals.
    let Some(mut renderer) = self::renderer() else { return };
    let mut bare = quad();
    bare.uvs = Default::default();
    draw(&mut renderer, &scene_of(bare, glow(Vec3::ONE), vec![dark()]), &front(), &options());
    assert_eq!(renderer.resources().mesh_buffers, 2);
}

#[test]
fn r46_pipelines_are_built_once_when_first_needed() {
    let Some(mut renderer) = renderer() else { return };
    let light = vec![directional(Vec3::NEG_Z, Vec3::ONE)];
    let mut scene = scene_of(quad(), Material { diffuse: Vec3::ONE, ..black() }, light);
    let built = |picture: Picture| picture.stats.pipelines_built;
    assert_eq!(built(draw(&mut renderer, &scene, &front(), &options())), 1);
    assert_eq!(built(draw(&mut renderer, &scene, &front(), &options())), 0);
    // Another value is no other feature.
    scene.materials[0].diffuse = Vec3::new(0.1, 0.2, 0.3);
    scene.lights[0].diffuse = Vec3::splat(0.5);
    assert_eq!(built(draw(&mut renderer, &scene, &front(), &options())), 0);
    // Another kind of light is: the same shader with other constants.
    scene.lights.push(point(Vec3::Z, Vec3::ONE));
    assert_eq!(built(draw(&mut renderer, &scene, &front(), &options())), 1);
    scene.materials[0] = Material { specular: Vec3::ONE, exponent: 4.0, ..scene.materials[0].clone() };
    assert_eq!(built(draw(&mut renderer, &scene, &front(), &options())), 1);
    // A specular colour with exponent 0 is none.
    scene.materials[0].exponent = 0.0;
    assert_eq!(built(draw(&mut renderer, &scene, &front(), &options())), 0);
    assert_eq!(renderer.resources().shaders_built, 2);
    // Samples make another pipeline, of the same shader.
    assert_eq!(built(draw(&mut renderer, &scene, &front(), &msaa())), 1);
    assert_eq!(renderer.resources().shaders_built, 2);
}

#[test]
fn r48_equal_keys_switch_no_pipeline() {
    let Some(mut renderer) = renderer() else { return };
    let mut mesh = quad();
    let half = |first_index, material| Subset { first_index, index_count: 3, material: MaterialId(material) };
    mesh.subsets = vec![half(0, 0), half(3, 1)];
    let mut scene = scene_of(mesh, glow(Vec3::X), vec![dark()]);
    scene.materials.push(glow(Vec3::Y));
    for number in 0..3 {
        scene.nodes.push(node(0, at(-f32::from(number as u8))));
    }
    let stats = draw(&mut renderer, &scene, &front(), &options()).stats;
    // Two subsets with four instances each.
    assert_eq!((stats.draws, stats.triangles, stats.pipeline_switches), (2, 8, 1));
}

#[test]
fn r50_equal_things_are_there_once_and_go_with_their_last_user() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = scene_of(quad(), glow(Vec3::ONE), vec![dark()]);
    let used = layer(&mut scene, image8(4, 4, |x, y| [60 * x as u8, 60 * y as u8, 0, 255]));
    scene.materials[0].layers[Layer::Diffuse as usize] = Some(used);
    // Another material with the same texture, an equal material, the same mesh twice.
    scene.materials.push(Material { emission: Vec3::X, ..scene.materials[0].clone() });
    scene.materials.push(scene.materials[0].clone());
    scene.nodes.push(node(0, at(-1.0)));
    let mut mesh = quad();
    mesh.subsets = (0..2).map(|i| Subset { first_index: 3 * i, index_count: 3, material: MaterialId(1 + i) }).collect();
    scene.meshes.push(Arc::new(mesh));
    scene.nodes.push(node(1, at(-2.0)));
    let first = draw(&mut renderer, &scene, &front(), &options());
    let resources = renderer.resources();
    assert_eq!((resources.meshes, resources.textures, resources.materials), (2, 1, 2));
    let again = draw(&mut renderer, &scene, &front(), &options());
    assert_eq!((again.stats.bytes_uploaded, again.bytes == first.bytes), (0, true));
    // A clone of the scene shares them; they go when both are gone.
    let copy = scene.clone();
    drop(scene);
    assert_eq!(draw(&mut renderer, &copy, &front(), &options()).stats.bytes_uploaded, 0);
    drop(copy);
    draw(&mut renderer, &Scene::default(), &front(), &options());
    let resources = renderer.resources();
    assert_eq!((resources.meshes, resources.textures, resources.materials, resources.bytes), (0, 0, 0, 0));
}

#[test]
fn changing_the_mode_keeps_one_copy_of_each_texture() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = scene_of(quad(), glow(Vec3::ONE), vec![dark()]);
    let used = layer(&mut scene, image8(4, 4, |x, _| [60 * x as u8, 0, 0, 255]));
    scene.materials[0].layers[Layer::Diffuse as usize] = Some(used);
    for shading in [Shading::Source, Shading::Linear, Shading::Source] {
        scene.shading = shading;
        draw(&mut renderer, &scene, &front(), &options());
        assert_eq!((renderer.resources().textures, renderer.resources().materials), (1, 1));
    }
}

#[test]
fn only_what_changed_is_uploaded() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = scene_of(sphere(32), glow(Vec3::ONE), vec![dark()]);
    for number in 0..100 {
        scene.nodes.push(node(0, at(-number as f32)));
    }
    draw(&mut renderer, &scene, &front(), &options());
    // One node moves along z: one number of one instance.
    scene.nodes[50].local = at(3.0);
    assert_eq!(draw(&mut renderer, &scene, &front(), &options()).stats.bytes_uploaded, 4);
    // The camera moves: at most the frame's uniform and the lights' relative places.
    let bytes = draw(&mut renderer, &scene, &perspective(Vec3::Z), &options()).stats.bytes_uploaded;
    assert!(bytes <= 96 + 64, "{bytes}");
}

#[test]
fn equal_frames_are_equal_to_the_bit_whatever_came_before() {
    let Some(mut first) = renderer() else { return };
    let Some(mut second) = renderer() else { return };
    let material =
        Material { diffuse: Vec3::splat(0.7), specular: Vec3::splat(0.4), exponent: 9.0, opacity: 0.6, ..black() };
    let mut scene = scene_of(sphere(24), material, vec![point(Vec3::new(1.0, 2.0, 3.0), Vec3::ONE)]);
    scene.meshes.push(Arc::new(quad()));
    scene.nodes.push(node(1, at(0.2)));
    scene.materials.push(glow(Vec3::X));
    Arc::make_mut(&mut scene.meshes[1]).subsets[0].material = MaterialId(1);
    let camera = perspective(Vec3::new(0.3, 0.2, 2.5));
    let a = draw(&mut first, &scene, &camera, &msaa());
    // The other one has drawn other things before, and the same from elsewhere.
    draw(&mut second, &scene_of(quad(), glow(Vec3::Y), vec![]), &front(), &options());
    draw(&mut second, &scene, &front(), &msaa());
    let b = draw(&mut second, &scene, &camera, &msaa());
    assert_eq!(a.bytes, b.bytes);
}

#[test]
fn passes_are_timed_where_the_device_can() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = scene_of(sphere(64), Material { diffuse: Vec3::ONE, ..black() }, vec![]);
    let can = renderer.gpu().device().features().contains(wgpu::Features::TIMESTAMP_QUERY);
    let stats = draw_sized(&mut renderer, &scene, &front(), &msaa(), 256, 256).stats;
    assert_eq!(stats.gpu.is_some(), can);
    scene.materials[0].opacity = 0.5;
    let stats = draw_sized(&mut renderer, &scene, &front(), &msaa(), 256, 256).stats;
    if let Some(passes) = &stats.gpu {
        let names: Vec<&str> = passes.iter().map(|pass| pass.name).collect();
        assert!(names == ["opaque", "transparent"] || names == ["picture"], "{names:?}");
        println!("{passes:?}");
        // All triangles are in the second part: the first one only clears.
        assert!(passes.len() == 1 || passes[1].ms > passes[0].ms, "{passes:?}");
        let total = stats.gpu_ms().unwrap();
        assert!(total > 0.0 && total < 5000.0, "{total} ms");
    }
    let untimed = RenderOptions { gpu_timing: false, ..msaa() };
    assert_eq!(draw(&mut renderer, &scene, &front(), &untimed).stats.gpu, None);
}
