//! Small scenes whose pictures can be worked out by hand.
#![allow(dead_code, reason = "each test file uses a part of it")]

use std::sync::Arc;

use aam_reference::{Options, render};
use aam_scene::{
    Background, Camera, Falloff, Image, Layer, Light, LightKind, Material, MaterialId, Mesh, MeshId, Node, NormalSpace,
    Pixels, Projection, Scene, Subset, Texture, TextureId, TextureLayer, View,
};
use glam::{Affine3A, Mat3, Vec2, Vec3};

/// A mesh with one subset of material 0, and the same coordinates for all four layers.
pub(crate) fn mesh(positions: Vec<Vec3>, normals: Vec<Vec3>, uvs: Vec<Vec2>, indices: Vec<u32>) -> Mesh {
    let subset = Subset { first_index: 0, index_count: indices.len() as u32, material: MaterialId(0) };
    let bounds = aam_scene::Aabb::of(positions.iter().copied());
    let uvs = [const { None }; 4].map(|_: Option<()>| Some(uvs.clone()));
    Mesh { positions, normals, uvs, indices, subsets: vec![subset], bounds, ..Mesh::default() }
}

/// The square −1..1 in x and y at a height, facing +Z, with texture coordinates 0..1 from its lower left corner.
pub(crate) fn quad(z: f32) -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    mesh(
        corners.map(|(x, y)| Vec3::new(x, y, z)).to_vec(),
        vec![Vec3::Z; 4],
        corners.map(|(x, y)| Vec2::new(0.5 * x + 0.5, 0.5 * y + 0.5)).to_vec(),
        vec![0, 1, 2, 0, 2, 3],
    )
}

/// The unit sphere around Z, of `2·n` × `n` quads.
pub(crate) fn sphere(n: u32) -> Mesh {
    let point = |i: u32, j: u32| {
        let (u, v) = (i as f32 / (2 * n) as f32, j as f32 / n as f32);
        let (longitude, latitude) = (u * std::f32::consts::TAU, (v - 0.5) * std::f32::consts::PI);
        (Vec3::new(longitude.cos() * latitude.cos(), longitude.sin() * latitude.cos(), latitude.sin()), Vec2::new(u, v))
    };
    let grid: Vec<(Vec3, Vec2)> = (0..=n).flat_map(|j| (0..=2 * n).map(move |i| point(i, j))).collect();
    let index = |i: u32, j: u32| j * (2 * n + 1) + i;
    let faces = (0..n).flat_map(|j| {
        (0..2 * n).flat_map(move |i| {
            let (a, b, c, d) = (index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
            [a, b, c, a, c, d]
        })
    });
    let positions: Vec<Vec3> = grid.iter().map(|point| point.0).collect();
    mesh(positions.clone(), positions, grid.iter().map(|point| point.1).collect(), faces.collect())
}

/// An 8-bit image from a function of column and row (0 at the top).
pub(crate) fn image(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Arc<Image> {
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels = Pixels::Rgba8(texels.flat_map(|(x, y)| texel(x, y)).collect());
    Arc::new(Image { width, height, pixels })
}

pub(crate) fn node(mesh: u32, local: Affine3A) -> Node {
    Node { name: String::new(), parent: None, local, mesh: Some(MeshId(mesh)), visible: true }
}

/// Meshes where they are, with black transparent surroundings and no ambient light.
pub(crate) fn scene(meshes: Vec<Mesh>, material: Material, light: LightKind) -> Scene {
    Scene {
        nodes: (0..meshes.len()).map(|index| node(index as u32, Affine3A::IDENTITY)).collect(),
        meshes: meshes.into_iter().map(Arc::new).collect(),
        materials: vec![material],
        lights: vec![self::light(light)],
        background: Background::Transparent,
        ..Scene::default()
    }
}

pub(crate) fn light(kind: LightKind) -> Light {
    Light { name: String::new(), kind, ambient: Vec3::ZERO, diffuse: Vec3::ONE, specular: Vec3::ONE, shape: None }
}

pub(crate) fn point_light(x: f32, y: f32, z: f32) -> LightKind {
    LightKind::Point { position: Vec3::new(x, y, z), falloff: Falloff::None }
}

pub(crate) fn straight_down() -> LightKind {
    LightKind::Directional { direction: Vec3::NEG_Z }
}

/// Adds a texture and puts it on a layer of material 0.
pub(crate) fn put_texture(scene: &mut Scene, layer: Layer, image: Arc<Image>) {
    let texture = TextureId(scene.textures.len() as u32);
    scene.textures.push(Texture { name: String::new(), path: None, image: Ok(image) });
    let layer_of =
        TextureLayer { texture, transform: Mat3::IDENTITY, normal_space: NormalSpace::Object, intensity: 1.0 };
    scene.materials[0].layers[layer as usize] = Some(layer_of);
}

/// Straight down on the square −1..1, `side` pixels wide, from a height of 5.
pub(crate) fn from_above(side: u32) -> View {
    View {
        camera: Camera {
            name: String::new(),
            position: Vec3::new(0.0, 0.0, 5.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            projection: Projection::Orthographic { height: 2.0 },
            near: 0.1,
            far: 100.0,
        },
        width: side,
        height: side,
        frame: 0.0,
    }
}

/// A white material that only reflects diffusely.
pub(crate) fn chalk() -> Material {
    Material { ambient: Vec3::ZERO, diffuse: Vec3::ONE, ..Material::default() }
}

/// A material that shines by itself.
pub(crate) fn glowing(r: f32, g: f32, b: f32) -> Material {
    Material { emission: Vec3::new(r, g, b), ambient: Vec3::ZERO, diffuse: Vec3::ZERO, ..Material::default() }
}

/// A picture, with access by column and row.
pub(crate) struct Picture {
    pub(crate) width: u32,
    pub(crate) bytes: Vec<u8>,
}

impl Picture {
    pub(crate) fn at(&self, x: u32, y: u32) -> [u8; 4] {
        let index = 4 * (y * self.width + x) as usize;
        [0, 1, 2, 3].map(|channel| self.bytes[index + channel])
    }

    pub(crate) fn mean(&self, channel: usize) -> f64 {
        let values = self.bytes.iter().skip(channel).step_by(4);
        values.map(|value| f64::from(*value)).sum::<f64>() / (self.bytes.len() / 4) as f64
    }
}

pub(crate) fn draw(scene: &Scene, view: &View, samples: u32) -> Picture {
    draw_with(scene, view, &Options { samples_per_pixel: samples, ..Options::default() })
}

pub(crate) fn draw_with(scene: &Scene, view: &View, options: &Options<'_>) -> Picture {
    let (image, _) = render(scene, view, options).unwrap();
    let Pixels::Rgba8(bytes) = image.pixels else { panic!("8-bit pictures") };
    Picture { width: image.width, bytes }
}

/// Asserts that two colours differ by at most one step in each channel.
#[track_caller]
pub(crate) fn assert_color(found: [u8; 4], expected: [f32; 4]) {
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((f32::from(found) - 255.0 * expected).abs() <= 1.0, "{found} is not {}", 255.0 * expected);
    }
}
