//! What is behind everything, and targets of all kinds: digest requirement 45.

use std::sync::Arc;

use aam_renderer::{Alpha, RenderError, RenderOptions, Renderer, Target};
use aam_scene::*;
use glam::Vec3;

use crate::common::*;

fn behind(background: Background, shading: Shading) -> RenderOptions {
    RenderOptions { background: Some(background), shading: Some(shading), ..options() }
}

#[test]
fn colours_appear_as_they_are_in_both_modes() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = Scene { lights: vec![dark()], ..Scene::default() };
    for code in [0u8, 1, 7, 64, 128, 200, 254, 255] {
        let color = Vec3::splat(f32::from(code) / 255.0);
        for shading in [Shading::Source, Shading::Linear] {
            let picture = draw(&mut renderer, &scene, &front(), &behind(Background::Color(color), shading));
            assert_eq!(picture.center(), [code, code, code, 255], "{shading:?}");
        }
    }
    // The scene's own, when the options have none.
    scene.background = Background::Color(Vec3::new(1.0, 0.0, 0.2));
    let own = RenderOptions { background: None, ..options() };
    assert_eq!(draw(&mut renderer, &scene, &front(), &own).center(), [255, 0, 51, 255]);
}

#[test]
fn r45_a_picture_fills_the_viewport_and_stays() {
    let Some(mut renderer) = renderer() else { return };
    let scene = scene_of(sphere(8), glow(Vec3::Y), vec![dark()]);
    let image = image8(64, 64, |x, y| [4 * x as u8, 4 * y as u8, 77, 255]);
    let picture = Background::Picture(Arc::new(image.clone()));
    let Pixels::Rgba8(expected) = image.pixels else { panic!() };
    // The camera is inside of nothing and looks away.
    for shading in [Shading::Source, Shading::Linear] {
        for position in [Vec3::new(0.0, 0.0, -3.0), Vec3::new(9.0, 0.0, -9.0)] {
            let found = draw(&mut renderer, &scene, &perspective(position), &behind(picture.clone(), shading));
            assert!(found.bytes.iter().zip(&expected).all(|(a, b)| a.abs_diff(*b) <= 1), "{shading:?}");
        }
        // It is stretched, and stays behind.
        let found = draw_sized(
            &mut renderer,
            &scene,
            &perspective(Vec3::new(0.0, 0.0, 2.0)),
            &behind(picture.clone(), shading),
            128,
            64,
        );
        assert_eq!(found.center(), [0, 255, 0, 255]);
        assert_near(found.at(2, 32), [1.25 * 4.0 / 255.0 - 0.5 * 4.0 / 255.0, 0.5, 77.0 / 255.0, 1.0], 2.0);
    }
}

#[test]
fn a_float_picture_is_encoded_and_a_translucent_one_keeps_its_alpha() {
    let Some(mut renderer) = renderer() else { return };
    let scene = Scene { lights: vec![dark()], ..Scene::default() };
    for shading in [Shading::Source, Shading::Linear] {
        let float = Image { width: 1, height: 1, pixels: Pixels::RgbF32(vec![0.2, 0.5, 4.0]) };
        let options = behind(Background::Picture(Arc::new(float)), shading);
        let expected = Vec3::new(encode(0.2), encode(0.5), 1.0);
        assert_color(draw(&mut renderer, &scene, &front(), &options).center(), expected);
        let pale = Background::Picture(Arc::new(image8(1, 1, |_, _| [200, 100, 50, 60])));
        let found = draw(&mut renderer, &scene, &front(), &behind(pale, shading)).center();
        assert_near(found, [200.0, 100.0, 50.0, 60.0].map(|c| c / 255.0), 1.0);
    }
}

/// Draws into a texture of a format and reads it back.
fn draw_to(
    renderer: &mut Renderer,
    scene: &Scene,
    options: &RenderOptions,
    format: wgpu::TextureFormat,
    alpha: Alpha,
) -> [u8; 4] {
    let gpu = renderer.gpu().clone();
    let texture = gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 64, height: 64, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let target_view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    let view = View { camera: front(), width: 64, height: 64, frame: 0.0 };
    renderer.render(scene, &view, options, &Target { alpha, ..Target::new(&target_view) }).unwrap();
    let buffer = gpu.device().create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 64 * 64 * 4,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(256), rows_per_image: None };
    let destination = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), destination, texture.size());
    gpu.queue().submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |result| result.unwrap());
    gpu.wait().unwrap();
    let bytes = buffer.get_mapped_range(..).unwrap();
    let [a, b, c, d]: [u8; 4] = bytes[256 * 32 + 128..][..4].try_into().unwrap();
    let bgra = matches!(format, wgpu::TextureFormat::Bgra8Unorm | wgpu::TextureFormat::Bgra8UnormSrgb);
    if bgra { [c, b, a, d] } else { [a, b, c, d] }
}

#[test]
fn every_target_gets_the_same_bytes() {
    use wgpu::TextureFormat::{Bgra8Unorm, Bgra8UnormSrgb, Rgba8Unorm, Rgba8UnormSrgb};
    let Some(mut renderer) = renderer() else { return };
    let color = Vec3::new(0.9, 0.3, 0.6);
    let solid = scene_of(quad(), glow(color), vec![dark()]);
    let faint = scene_of(quad(), Material { opacity: 0.4, ..glow(color) }, vec![dark()]);
    for shading in [Shading::Source, Shading::Linear] {
        let options = behind(Background::Transparent, shading);
        for format in [Rgba8Unorm, Bgra8Unorm, Rgba8UnormSrgb, Bgra8UnormSrgb] {
            for alpha in [Alpha::Straight, Alpha::Premultiplied] {
                assert_near(draw_to(&mut renderer, &solid, &options, format, alpha), color.extend(1.0).to_array(), 1.0);
            }
            let straight = draw_to(&mut renderer, &faint, &options, format, Alpha::Straight);
            assert_near(straight, color.extend(0.4).to_array(), 1.0);
            // Multiplied in the values that the target's hardware blends.
            let multiplied = if format.is_srgb() { color.map(|c| encode(0.4 * decode(c))) } else { 0.4 * color };
            let found = draw_to(&mut renderer, &faint, &options, format, Alpha::Premultiplied);
            assert_near(found, multiplied.extend(0.4).to_array(), 1.0);
        }
    }
}

#[test]
fn targets_that_do_not_fit_are_refused() {
    let Some(mut renderer) = renderer() else { return };
    let gpu = renderer.gpu().clone();
    let texture = |format, width| {
        gpu.device().create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height: 8, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        })
    };
    let view = View { camera: front(), width: 8, height: 8, frame: 0.0 };
    let mut refuse = |format, width| {
        let target = texture(format, width).create_view(&wgpu::TextureViewDescriptor::default());
        renderer.render(&Scene::default(), &view, &options(), &Target::new(&target)).unwrap_err()
    };
    assert!(matches!(refuse(wgpu::TextureFormat::Rgba8Unorm, 9), RenderError::TargetSize { target_width: 9, .. }));
    assert!(matches!(refuse(wgpu::TextureFormat::R8Unorm, 8), RenderError::TargetFormat { .. }));
}
