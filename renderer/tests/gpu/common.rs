//! Small scenes, and pictures of them.

use std::sync::{Arc, OnceLock};

use aam_renderer::{FrameStats, Gpu, Msaa, RenderOptions, Renderer};
use aam_scene::*;
use glam::{Affine3A, Mat3, Vec2, Vec3};

/// A renderer, or nothing where there is no adapter: the test is then skipped, except in CI.
pub(crate) fn renderer() -> Option<Renderer> {
    static GPU: OnceLock<Result<Gpu, String>> = OnceLock::new();
    match GPU.get_or_init(|| Gpu::headless().map_err(|error| error.to_string())) {
        Ok(gpu) => Some(Renderer::new(gpu.clone())),
        Err(reason) => {
            assert!(std::env::var("CI").as_deref() != Ok("true"), "CI needs a GPU adapter: {reason}");
            println!("skipped: no GPU adapter ({reason})");
            None
        }
    }
}

/// A picture with its pixels.
pub(crate) struct Picture {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) bytes: Vec<u8>,
    pub(crate) stats: FrameStats,
}

impl Picture {
    /// Counted from the top left.
    pub(crate) fn at(&self, x: u32, y: u32) -> [u8; 4] {
        let start = 4 * (y * self.width + x) as usize;
        self.bytes[start..start + 4].try_into().unwrap()
    }

    pub(crate) fn center(&self) -> [u8; 4] {
        self.at(self.width / 2, self.height / 2)
    }

    /// Saves it for looking at, if `AAM_PICTURES` names a folder.
    pub(crate) fn save(self, name: &str) -> Self {
        if let Some(folder) = std::env::var_os("AAM_PICTURES") {
            let path = std::path::Path::new(&folder).join(format!("{name}.png"));
            image::save_buffer(path, &self.bytes, self.width, self.height, image::ColorType::Rgba8).unwrap();
        }
        self
    }
}

/// Draws with one sample a pixel, on black, shading stored values, unless the options say otherwise.
pub(crate) fn options() -> RenderOptions {
    RenderOptions { msaa: Msaa::X1, background: Some(Background::Color(Vec3::ZERO)), ..RenderOptions::default() }
}

pub(crate) fn draw(renderer: &mut Renderer, scene: &Scene, camera: &Camera, options: &RenderOptions) -> Picture {
    draw_sized(renderer, scene, camera, options, 64, 64)
}

pub(crate) fn draw_sized(
    renderer: &mut Renderer,
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    width: u32,
    height: u32,
) -> Picture {
    let view = View { camera: camera.clone(), width, height, frame: 0.0 };
    let (image, stats) = renderer.render_to_image(scene, &view, options).unwrap();
    let Pixels::Rgba8(bytes) = image.pixels else { panic!("not 8-bit") };
    Picture { width, height, bytes, stats }
}

/// Looks along −Z from z = 5 and sees 2 × 2 metres around the origin.
pub(crate) fn front() -> Camera {
    Camera {
        name: "front".into(),
        position: Vec3::new(0.0, 0.0, 5.0),
        target: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::Orthographic { height: 2.0 },
        near: 0.1,
        far: 100.0,
    }
}

/// Looks along −Z from `position` with a field of view of 90°.
pub(crate) fn perspective(position: Vec3) -> Camera {
    Camera {
        name: "perspective".into(),
        position,
        target: position + Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: std::f32::consts::FRAC_PI_2 },
        near: 0.1,
        far: 100.0,
    }
}

/// The square [−1, 1]² at z = 0, facing +Z, with (0, 0) … (1, 1) as coordinates of all layers.
pub(crate) fn quad() -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let uvs: Vec<Vec2> = corners.iter().map(|&(x, y)| Vec2::new(0.5 * x + 0.5, 0.5 * y + 0.5)).collect();
    let mut mesh = Mesh {
        name: "quad".into(),
        positions: corners.iter().map(|&(x, y)| Vec3::new(x, y, 0.0)).collect(),
        normals: vec![Vec3::Z; 4],
        uvs: [0; 4].map(|_| Some(uvs.clone())),
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Mesh::default()
    };
    finish(&mut mesh);
    mesh
}

/// Gives a mesh one subset with material 0, and its bounds.
pub(crate) fn finish(mesh: &mut Mesh) {
    let index_count = mesh.indices.len() as u32;
    mesh.subsets = vec![Subset { first_index: 0, index_count, material: MaterialId(0) }];
    mesh.bounds = Aabb::of(mesh.positions.iter().copied());
}

/// A sphere of radius 1 with smooth normals.
pub(crate) fn sphere(rings: u32) -> Mesh {
    let mut mesh = Mesh { name: "sphere".into(), ..Mesh::default() };
    let (across, down) = (2 * rings, rings);
    for j in 0..=down {
        for i in 0..=across {
            let (phi, theta) =
                (std::f32::consts::TAU * i as f32 / across as f32, std::f32::consts::PI * j as f32 / down as f32);
            let p = Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            mesh.positions.push(p);
            mesh.normals.push(p);
        }
    }
    for j in 0..down {
        for i in 0..across {
            let a = j * (across + 1) + i;
            let b = a + across + 1;
            mesh.indices.extend([a, b, a + 1, a + 1, b, b + 1]);
        }
    }
    finish(&mut mesh);
    mesh
}

pub(crate) fn node(mesh: u32, local: Affine3A) -> Node {
    Node { name: String::new(), parent: None, local, mesh: Some(MeshId(mesh)), visible: true }
}

pub(crate) fn at(z: f32) -> Affine3A {
    Affine3A::from_translation(Vec3::new(0.0, 0.0, z))
}

/// One mesh at the origin with one material, lit by `lights`.
pub(crate) fn scene_of(mesh: Mesh, material: Material, lights: Vec<Light>) -> Scene {
    Scene {
        nodes: vec![node(0, Affine3A::IDENTITY)],
        meshes: vec![Arc::new(mesh)],
        materials: vec![material],
        lights,
        ..Scene::default()
    }
}

/// Everything zero but what is asked for.
pub(crate) fn black() -> Material {
    Material { ambient: Vec3::ZERO, diffuse: Vec3::ZERO, ..Material::default() }
}

/// A material that shines by itself.
pub(crate) fn glow(color: Vec3) -> Material {
    Material { emission: color, ..black() }
}

/// A point light without ambient colour.
pub(crate) fn point(position: Vec3, color: Vec3) -> Light {
    Light {
        name: String::new(),
        kind: LightKind::Point { position, falloff: Falloff::None },
        ambient: Vec3::ZERO,
        diffuse: color,
        specular: color,
        shape: None,
    }
}

/// A light that does nothing, so that the scene is not lit from the camera.
pub(crate) fn dark() -> Light {
    point(Vec3::ZERO, Vec3::ZERO)
}

pub(crate) fn directional(direction: Vec3, color: Vec3) -> Light {
    Light { kind: LightKind::Directional { direction }, ..point(Vec3::ZERO, color) }
}

/// Adds an image and returns a layer that uses it.
pub(crate) fn layer(scene: &mut Scene, image: Image) -> TextureLayer {
    scene.textures.push(Texture { name: "image".into(), path: None, image: Ok(Arc::new(image)) });
    TextureLayer {
        texture: TextureId(scene.textures.len() as u32 - 1),
        transform: Mat3::IDENTITY,
        normal_space: NormalSpace::Object,
        intensity: 1.0,
    }
}

/// An 8-bit image from its rows, top first.
pub(crate) fn image8(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [u8; 4]) -> Image {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(|(x, y)| pixel(x, y)).collect();
    Image { width, height, pixels: Pixels::Rgba8(pixels) }
}

/// Fails unless all channels are within `tolerance` of the expected ones.
#[track_caller]
pub(crate) fn assert_near(found: [u8; 4], expected: [f32; 4], tolerance: f32) {
    let worst = found
        .iter()
        .zip(expected)
        .map(|(&found, expected)| (f32::from(found) - 255.0 * expected).abs())
        .fold(0.0, f32::max);
    assert!(worst <= tolerance, "{found:?}, not {:?}", expected.map(|c| c * 255.0));
}

/// Fails unless the colour is within 1/255 (and rounding), and alpha 1.
#[track_caller]
pub(crate) fn assert_color(found: [u8; 4], expected: Vec3) {
    assert_near(found, expected.clamp(Vec3::ZERO, Vec3::ONE).extend(1.0).to_array(), 1.0);
}

/// sRGB.
pub(crate) fn decode(c: f32) -> f32 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// sRGB.
pub(crate) fn encode(c: f32) -> f32 {
    if c <= 0.0031308 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

/// Numbers from 0 to 1 that are the same in every run.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1_u64 << 24) as f32
    }
}
