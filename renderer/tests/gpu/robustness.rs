//! Input that should not be: an error or a picture, never a panic.

use std::sync::Arc;

use aam_renderer::{Overlays, RenderError, RenderOptions, Renderer, Show};
use aam_scene::*;
use glam::{Affine3A, Mat3, Quat, Vec2, Vec3, Vec4};

use crate::common::*;

fn refuse(renderer: &mut Renderer, scene: &Scene, camera: Camera, width: u32, height: u32) -> RenderError {
    let view = View { camera, width, height, frame: 0.0 };
    renderer.render_to_image(scene, &view, &options()).expect_err("an error")
}

#[test]
fn pictures_of_no_size_or_too_large_are_refused() {
    let Some(mut renderer) = renderer() else { return };
    let scene = scene_of(quad(), black(), vec![]);
    for (width, height) in [(0, 0), (0, 5), (5, 0)] {
        assert!(matches!(refuse(&mut renderer, &scene, front(), width, height), RenderError::EmptyPicture { .. }));
    }
    let error = refuse(&mut renderer, &scene, front(), 1 << 20, 8).to_string();
    assert!(error.contains("1048576×8") && error.contains("maxTextureDimension2D"), "{error}");
    assert!(matches!(
        refuse(&mut renderer, &scene, Camera { near: 0.0, ..perspective(Vec3::ZERO) }, 8, 8),
        RenderError::Camera { .. }
    ));
    // One pixel is a picture, and the renderer still works.
    assert_eq!(draw_sized(&mut renderer, &scene, &front(), &options(), 1, 1).bytes, [0, 0, 0, 255]);
    draw_sized(&mut renderer, &scene, &front(), &options(), 4096, 1);
}

#[test]
fn broken_positions_take_only_their_triangles_away() {
    let Some(mut renderer) = renderer() else { return };
    for broken in [f32::NAN, f32::INFINITY] {
        let mut mesh = quad();
        mesh.positions[3].x = broken;
        let scene = scene_of(mesh, glow(Vec3::ONE), vec![dark()]);
        let picture = draw(&mut renderer, &scene, &front(), &options());
        assert_eq!((picture.at(50, 50)[0], picture.at(10, 10)[0]), (255, 0));
        let glass = scene_of((*scene.meshes[0]).clone(), Material { opacity: 0.5, ..glow(Vec3::ONE) }, vec![dark()]);
        let picture = draw(&mut renderer, &glass, &front(), &options());
        assert_eq!((picture.at(50, 50)[0], picture.at(10, 10)[0], picture.stats.sorted_triangles), (128, 0, 1));
    }
    let mut mesh = quad();
    mesh.indices[5] = 77;
    let picture = draw(&mut renderer, &scene_of(mesh, glow(Vec3::ONE), vec![dark()]), &front(), &options());
    assert_eq!((picture.at(50, 50)[0], picture.at(10, 10)[0]), (255, 0));
}

#[test]
fn broken_normals_are_made_from_the_triangles() {
    let Some(mut renderer) = renderer() else { return };
    for normal in [Vec3::NAN, Vec3::ZERO, Vec3::new(f32::INFINITY, 0.0, 0.0)] {
        let mut mesh = quad();
        mesh.normals = vec![normal; 4];
        let light = vec![directional(Vec3::NEG_Z, Vec3::splat(0.8))];
        let scene =
            scene_of(mesh, Material { diffuse: Vec3::ONE, specular: Vec3::ONE, exponent: 300.0, ..black() }, light);
        let with_normals =
            RenderOptions { overlays: Overlays { normals: Some(0.1), ..Overlays::default() }, ..options() };
        draw(&mut renderer, &scene, &front(), &with_normals);
        assert_color(draw(&mut renderer, &scene, &front(), &options()).center(), Vec3::ONE);
    }
}

#[test]
fn other_broken_numbers_do_no_harm() {
    let Some(mut renderer) = renderer() else { return };
    let mut mesh = quad();
    mesh.uvs[0] = Some(vec![Vec2::NAN; 4]);
    mesh.colors = Some(vec![Vec4::new(f32::NAN, 2.0, -1.0, 1.0), Vec4::NAN, Vec4::INFINITY, Vec4::ONE]);
    mesh.tangents = Some(vec![Vec4::NAN; 4]);
    let material = Material {
        ambient: Vec3::NAN,
        diffuse: Vec3::new(f32::INFINITY, -1.0, 0.5),
        exponent: f32::NAN,
        alpha_cutoff: Some(f32::NAN),
        ..black()
    };
    let mut scene = scene_of(mesh, material, vec![]);
    let used = layer(&mut scene, image8(2, 2, |_, _| [255; 4]));
    let broken = TextureLayer {
        transform: Mat3::from_cols(Vec3::NAN, Vec3::Y, Vec3::Z),
        intensity: f32::NAN,
        normal_space: NormalSpace::Tangent,
        ..used
    };
    scene.materials[0].layers = [Some(broken), None, Some(broken), None];
    scene.lights = vec![
        point(Vec3::NAN, Vec3::ONE),
        point(Vec3::Z, Vec3::new(f32::NAN, -3.0, f32::INFINITY)),
        directional(Vec3::ZERO, Vec3::ONE),
        Light {
            kind: LightKind::Spot {
                position: Vec3::Z,
                direction: Vec3::ZERO,
                inner: f32::NAN,
                outer: 0.0,
                falloff: Falloff::InverseSquare,
            },
            ..point(Vec3::ZERO, Vec3::ONE)
        },
    ];
    for show in [Show::Lit, Show::Normals, Show::Uvs(Layer::Diffuse), Show::Layer(Layer::Normal)] {
        let picture = draw(&mut renderer, &scene, &front(), &RenderOptions { show, ..options() });
        assert_eq!(picture.center()[3], 255);
    }
    // A node that is nowhere is not drawn, nor are its children.
    scene.nodes[0].local = Affine3A::from_translation(Vec3::NAN);
    scene.nodes.push(Node { parent: Some(NodeId(0)), ..node(0, Affine3A::IDENTITY) });
    assert_eq!(draw(&mut renderer, &scene, &front(), &options()).stats.draws, 0);
}

#[test]
fn degenerate_geometry_is_no_trouble() {
    let Some(mut renderer) = renderer() else { return };
    let mut mesh = quad();
    mesh.indices.extend([0, 0, 0, 1, 1, 2, 0, 1]);
    finish(&mut mesh);
    for opacity in [1.0, 0.5] {
        let mut scene = scene_of(
            mesh.clone(),
            Material { opacity, diffuse: Vec3::ONE, ..black() },
            vec![directional(Vec3::NEG_Z, Vec3::ONE)],
        );
        let all = RenderOptions {
            overlays: Overlays { wireframe: true, normals: Some(0.1), bounds: true, shapes: vec![] },
            ..options()
        };
        draw(&mut renderer, &scene, &front(), &all);
        assert_near(draw(&mut renderer, &scene, &front(), &options()).center(), [opacity, opacity, opacity, 1.0], 1.0);
        // Flattened along its normal it is still lit as what it is.
        scene.nodes[0].local = Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0));
        assert_near(draw(&mut renderer, &scene, &front(), &options()).center(), [opacity, opacity, opacity, 1.0], 1.0);
        scene.nodes[0].local = Affine3A::from_scale(Vec3::ZERO);
        assert_eq!(draw(&mut renderer, &scene, &front(), &options()).center()[0], 0);
        scene.nodes[0].local = Affine3A::from_scale(Vec3::splat(1e38));
        draw(&mut renderer, &scene, &front(), &options());
    }
}

#[test]
fn contradictions_are_told() {
    let Some(mut renderer) = renderer() else { return };
    let told = |renderer: &mut Renderer, scene: &Scene, part: &str| {
        let error = refuse(renderer, scene, front(), 8, 8).to_string();
        assert!(error.contains(part), "{error}");
    };
    let broken = |change: &dyn Fn(&mut Mesh)| {
        let mut mesh = quad();
        change(&mut mesh);
        scene_of(mesh, black(), vec![])
    };
    told(
        &mut renderer,
        &broken(&|mesh| mesh.normals.truncate(3)),
        "mesh \"quad\" cannot be drawn: it has 4 positions but 3 normals",
    );
    told(&mut renderer, &broken(&|mesh| mesh.colors = Some(vec![])), "4 positions but 0 vertex colours");
    told(&mut renderer, &broken(&|mesh| mesh.uvs[2] = Some(vec![])), "4 positions but 0 texture coordinates");
    told(&mut renderer, &broken(&|mesh| mesh.frames = vec![MeshFrame::default()]), "0 positions in frame 1");
    told(&mut renderer, &broken(&|mesh| mesh.subsets[0].material = MaterialId(9)), "material 9 of 1");
    told(&mut renderer, &broken(&|mesh| mesh.subsets[0].first_index = u32::MAX), "ends at index 4294967301 of 6");
    // Also if the mesh was drawn before, in a scene with more materials.
    let mut scene = scene_of(quad(), black(), vec![]);
    draw(&mut renderer, &scene, &front(), &options());
    scene.materials.clear();
    told(&mut renderer, &scene, "material 0 of 0");
    let mut scene = scene_of(quad(), black(), vec![]);
    scene.nodes[0].mesh = Some(MeshId(4));
    told(&mut renderer, &scene, "mesh 4 of 1");
    let mut scene = scene_of(quad(), glow(Vec3::ONE), vec![]);
    let used = layer(&mut scene, Image { width: 3, height: 3, pixels: Pixels::Rgba8(vec![0; 5]) });
    scene.materials[0].layers[0] = Some(used);
    told(&mut renderer, &scene, "3 × 3 pixels need 36 values, and there are 5");
    // A layer whose texture is not there at all counts as absent.
    scene.textures.clear();
    assert_eq!(draw(&mut renderer, &scene, &front(), &options()).center(), [255; 4]);
}

#[test]
fn a_texture_larger_than_the_limit_is_downscaled_with_a_warning() {
    let Some(mut renderer) = renderer() else { return };
    let limit = renderer.gpu().device().limits().max_texture_dimension_2d;
    let mut scene = scene_of(quad(), glow(Vec3::ONE), vec![dark()]);
    let width = 2 * limit + 2;
    let used = layer(&mut scene, image8(width, 1, |x, _| if x < limit { [200, 0, 0, 255] } else { [0, 0, 100, 255] }));
    scene.materials[0].layers[0] = Some(used);
    let picture = draw(&mut renderer, &scene, &front(), &options());
    assert_eq!((picture.at(10, 32), picture.at(50, 32)), ([200, 0, 0, 255], [0, 0, 100, 255]));
    assert_eq!(picture.stats.warnings.len(), 1);
    assert!(picture.stats.warnings[0].contains(&format!("{width} × 1 pixels")), "{}", picture.stats.warnings[0]);
    assert!(draw(&mut renderer, &scene, &front(), &options()).stats.warnings.is_empty(), "said once");
}

#[test]
fn ten_thousand_nodes() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = scene_of(quad(), glow(Vec3::splat(0.8)), vec![dark()]);
    scene.nodes.clear();
    for i in 0..10_000u16 {
        let place = Vec3::new(f32::from(i % 100) / 50.0 - 0.99, f32::from(i / 100) / 50.0 - 0.99, 0.0);
        let mut placed = node(0, Affine3A::from_scale_rotation_translation(Vec3::splat(0.009), Quat::IDENTITY, place));
        // A long chain is no recursion.
        placed.parent = (i > 0).then(|| NodeId(u32::from(i) - 1));
        if i > 0 {
            placed.local = Affine3A::IDENTITY;
        }
        scene.nodes.push(placed);
    }
    let chain = draw(&mut renderer, &scene, &front(), &options());
    assert_eq!((chain.stats.draws, chain.stats.triangles), (1, 20_000));
    // Each with a mesh and a material of its own.
    scene.meshes.clear();
    scene.materials.clear();
    for i in 0..10_000u32 {
        let mut mesh = quad();
        mesh.subsets[0].material = MaterialId(i);
        scene.meshes.push(Arc::new(mesh));
        scene.materials.push(glow(Vec3::splat(i as f32 / 1e4)));
        let place = Vec3::new((i % 100) as f32 / 50.0 - 0.99, (i / 100) as f32 / 50.0 - 0.99, 0.0);
        let local = Affine3A::from_scale_rotation_translation(Vec3::splat(0.01), Quat::IDENTITY, place);
        scene.nodes[i as usize] = node(i, local);
    }
    let picture = draw_sized(&mut renderer, &scene, &front(), &options(), 100, 100).save("ten-thousand");
    assert_eq!((picture.stats.draws, picture.stats.pipeline_switches), (10_000, 1));
    assert_color(picture.at(50, 49), Vec3::splat(0.505));
}

#[test]
fn a_lost_device_is_an_error() {
    let Ok(gpu) = aam_renderer::Gpu::headless() else { return };
    let mut renderer = Renderer::new(gpu);
    let scene = scene_of(quad(), glow(Vec3::ONE), vec![dark()]);
    draw(&mut renderer, &scene, &front(), &options());
    renderer.gpu().device().destroy();
    let _ = renderer.gpu().wait();
    let error = refuse(&mut renderer, &scene, front(), 8, 8);
    assert!(matches!(error, RenderError::DeviceLost { .. }), "{error}");
}
