//! How fast the tracer is: `cargo run --release -p aam-reference --example rays_per_second [triangles]`.
//!
//! A bumpy sphere that fills the picture's height, one point light, one thread and then all.

use std::num::NonZeroUsize;
use std::sync::Arc;

use aam_reference::{Error, LightSize, Options, Stats, render};
use aam_scene::{
    Aabb, Background, Falloff, Light, LightKind, Material, MaterialId, Mesh, MeshId, Node, Scene, Subset, View,
};
use glam::{Affine3A, Vec3};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let triangles: u32 = std::env::args().nth(1).map_or(Ok(1_000_000), |text| text.parse())?;
    let scene = bumpy_sphere(triangles);
    let view = View { camera: scene.fitting_camera(4.0 / 3.0), width: 1024, height: 768, frame: 0.0 };
    for (name, threads) in [("1 thread", NonZeroUsize::new(1)), ("all threads", None)] {
        for (what, shadows) in [("camera rays", None), ("with shadow rays", Some(LightSize::Point))] {
            let options = Options { samples_per_pixel: 4, shadows, threads, ..Options::default() };
            report(&format!("{name}, {what}"), render(&scene, &view, &options).map(|(_, stats)| stats))?;
        }
    }
    Ok(())
}

fn report(name: &str, stats: Result<Stats, Error>) -> Result<(), Error> {
    let stats = stats?;
    println!(
        "{name}: {} triangles, build {:.2} s, {} rays in {:.2} s = {:.2} M rays/s",
        stats.triangles,
        stats.build.as_secs_f64(),
        stats.camera_rays + stats.shadow_rays,
        stats.trace.as_secs_f64(),
        stats.rays_per_second() * 1e-6
    );
    Ok(())
}

fn bumpy_sphere(triangles: u32) -> Scene {
    let n = ((f64::from(triangles) / 2.0).sqrt().ceil() as u32).max(3);
    let point = |i: u32, j: u32| {
        let (u, v) = (i as f32 / n as f32 * std::f32::consts::TAU, j as f32 / n as f32 * std::f32::consts::PI);
        let radius = 1.0 + 0.05 * (20.0 * u).sin() * (13.0 * v).cos();
        radius * Vec3::new(u.cos() * v.sin(), u.sin() * v.sin(), v.cos())
    };
    let positions: Vec<Vec3> = (0..=n).flat_map(|j| (0..=n).map(move |i| point(i, j))).collect();
    let index = |i: u32, j: u32| j * (n + 1) + i;
    let faces = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    let indices: Vec<u32> = faces
        .flat_map(|(i, j)| {
            let (a, b, c, d) = (index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j));
            [a, b, c, a, c, d]
        })
        .collect();
    let mesh = Mesh {
        bounds: Aabb::of(positions.iter().copied()),
        normals: positions.iter().map(|position| position.normalize()).collect(),
        subsets: vec![Subset { first_index: 0, index_count: indices.len() as u32, material: MaterialId(0) }],
        positions,
        indices,
        ..Mesh::default()
    };
    let light = Light {
        name: String::new(),
        kind: LightKind::Point { position: Vec3::new(3.0, -2.0, 4.0), falloff: Falloff::None },
        ambient: Vec3::splat(0.2),
        diffuse: Vec3::ONE,
        specular: Vec3::ONE,
        shape: None,
    };
    let node =
        Node { name: String::new(), parent: None, local: Affine3A::IDENTITY, mesh: Some(MeshId(0)), visible: true };
    Scene {
        nodes: vec![node],
        meshes: vec![Arc::new(mesh)],
        materials: vec![Material { specular: Vec3::ONE, exponent: 40.0, ..Material::default() }],
        lights: vec![light],
        background: Background::Transparent,
        ..Scene::default()
    }
}
