//! How fast the tracer is: `cargo run --release -p aam-reference --example rays_per_second [triangles [folder]]`.
//!
//! 64 bumpy spheres in a box, on one thread: rays from the camera, from what they meet to a lamp, and from there in random
//! directions. With a folder, the triangles and the rays are written there for another tracer, as little-endian floats:
//! nine for a triangle, and for a ray origin, direction, distance within which it matters, and what was found (the
//! distance met, −1 for none; of rays to the lamp 1 where it is hidden, 0 elsewhere).

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use aam_reference::{LightSize, Options, Tracer, render};
use aam_scene::{
    Aabb, Background, Camera, Falloff, Light, LightKind, Material, MaterialId, Mesh, MeshId, Node, Projection, Scene,
    Subset, View,
};
use glam::{Affine3A, Vec3};

const LAMP: Vec3 = Vec3::new(0.7, -1.42, 0.9);

/// Runs of each measurement; the fastest counts, for others may use the machine too.
const RUNS: usize = 5;

struct Ray {
    origin: Vec3,
    direction: Vec3,
    distance: f32,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let triangles: u32 = arguments.next().map_or(Ok(1_000_000), |text| text.parse())?;
    let folder = arguments.next().map(PathBuf::from);
    let scene = spheres(triangles / 64);
    let view = View {
        camera: Camera {
            name: String::new(),
            position: Vec3::new(0.1, -1.45, 0.2),
            target: Vec3::ZERO,
            up: Vec3::Z,
            projection: Projection::Perspective { fov_y: 1.2 },
            near: 0.01,
            far: 10.0,
        },
        width: 1024,
        height: 768,
        frame: 0.0,
    };
    let start = Instant::now();
    let tracer = Tracer::new(&scene, 0.0)?;
    println!("{} triangles, hierarchy built in {:.2} s", tracer.triangles(), start.elapsed().as_secs_f64());

    let primary = primary(&view);
    let met: Vec<Vec3> = primary
        .iter()
        .filter_map(|ray| Some(ray.origin + ray.direction * (tracer.nearest(ray.origin, ray.direction)? * 0.9999)))
        .collect();
    let nearest = |ray: &Ray| tracer.nearest(ray.origin, ray.direction).unwrap_or(-1.0);
    let hidden = |ray: &Ray| f32::from(u8::from(tracer.blocked(ray.origin, ray.direction, ray.distance)));
    let kinds: [(&str, Vec<Ray>, &dyn Fn(&Ray) -> f32); 3] = [
        ("primary", primary, &nearest),
        ("shadow", met.iter().map(|point| towards(*point, LAMP - point)).collect(), &hidden),
        ("incoherent", met.iter().zip(0..).map(|(point, seed)| anywhere(*point, seed)).collect(), &nearest),
    ];
    for (name, rays, trace) in &kinds {
        let mut best = f64::INFINITY;
        let mut found = Vec::new();
        for _ in 0..RUNS {
            let start = seconds();
            found = rays.iter().map(trace).collect();
            best = best.min(seconds() - start);
        }
        let share = found.iter().filter(|found| **found > 0.0).count() as f64 / found.len() as f64;
        let speed = rays.len() as f64 / best * 1e-6;
        println!("{name:12} {speed:6.2} M rays/s, {:.1} % of {} meet something", 100.0 * share, rays.len());
        if let Some(folder) = &folder {
            let values = rays.iter().zip(&found).flat_map(|(ray, found)| {
                let [origin, direction] = [ray.origin, ray.direction].map(|v| v.to_array());
                origin.into_iter().chain(direction).chain([ray.distance, *found])
            });
            write(&folder.join(name), values)?;
        }
    }
    if let Some(folder) = &folder {
        write(&folder.join("triangles"), corners(&scene))?;
    }
    for (name, shadows) in [("picture", None), ("with shadows", Some(LightSize::Point))] {
        let options = Options { samples_per_pixel: 4, shadows, threads: NonZeroUsize::new(1), ..Options::default() };
        let stats = render(&scene, &view, &options)?.1;
        println!("{name:12} {:6.2} M rays/s, shading included", stats.rays_per_second() * 1e-6);
    }
    Ok(())
}

/// A clock that stands still while others have the processor, where the system has one.
fn seconds() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    let spent = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = spent.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.get_or_init(Instant::now).elapsed().as_secs_f64(), |time| time * 1e-9)
}

fn primary(view: &View) -> Vec<Ray> {
    let inverse = view.camera.view().inverse();
    let tangent = 0.6_f32.tan();
    let pixels = (0..view.height).flat_map(|y| (0..view.width).map(move |x| (x as f32 + 0.5, y as f32 + 0.5)));
    let ray = |(x, y): (f32, f32)| {
        let (width, height) = (view.width as f32, view.height as f32);
        let at = Vec3::new((2.0 * x - width) / height * tangent, (1.0 - 2.0 * y / height) * tangent, -1.0);
        Ray { distance: f32::INFINITY, ..towards(view.camera.position, inverse.transform_vector3(at)) }
    };
    pixels.map(ray).collect()
}

fn towards(origin: Vec3, offset: Vec3) -> Ray {
    Ray { origin, direction: offset.normalize(), distance: offset.length() }
}

/// A direction of the unit sphere by a hash of a number.
fn anywhere(origin: Vec3, seed: u32) -> Ray {
    let hash = |salt: u32| {
        let mut x = seed.wrapping_mul(2).wrapping_add(salt).wrapping_mul(0x9e37_79b9);
        x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
        x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
        (x ^ x >> 16) as f32 / u32::MAX as f32
    };
    let (z, angle) = (2.0 * hash(0) - 1.0, std::f32::consts::TAU * hash(1));
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Ray { origin, direction: Vec3::new(radius * angle.cos(), radius * angle.sin(), z), distance: f32::INFINITY }
}

fn write(path: &std::path::Path, values: impl Iterator<Item = f32>) -> std::io::Result<()> {
    std::fs::write(path.with_extension("f32"), values.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
}

fn corners(scene: &Scene) -> impl Iterator<Item = f32> {
    let world = scene.world_transforms();
    scene.nodes.iter().zip(world).flat_map(|(node, world)| {
        let mesh = &scene.meshes[node.mesh.map_or(0, MeshId::index)];
        mesh.indices.iter().flat_map(move |index| world.transform_point3(mesh.positions[*index as usize]).to_array())
    })
}

/// 64 spheres in a box from −1.5 to 1.5.
fn spheres(triangles: u32) -> Scene {
    let n = ((f64::from(triangles) / 2.0).sqrt().ceil() as u32).max(3);
    let grid = |i: u32, j: u32| {
        let (u, v) = (i as f32 / n as f32 * std::f32::consts::TAU, j as f32 / n as f32 * std::f32::consts::PI);
        let radius = 0.28 + 0.03 * (20.0 * u).sin() * (13.0 * v).cos();
        radius * Vec3::new(u.cos() * v.sin(), u.sin() * v.sin(), v.cos())
    };
    let corner = |index: u32| Vec3::new((index & 1) as f32, (index >> 1 & 1) as f32, (index >> 2) as f32) * 3.0 - 1.5;
    let sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let ball = mesh(
        (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| grid(i, j)).collect(),
        (0..n).flat_map(|j| (0..n).map(move |i| [j * (n + 1) + i, (j + 1) * (n + 1) + i])),
        |[a, b]| [a, b, b + 1, a, b + 1, a + 1],
    );
    let room = mesh((0..8).map(corner).collect(), sides.into_iter(), |[a, b, c, d]: [u32; 4]| [a, b, c, a, c, d]);
    let place = |index: u32| {
        let at = Vec3::new((index & 3) as f32, (index >> 2 & 3) as f32, (index >> 4) as f32) - 1.5;
        node(0, Affine3A::from_translation(0.7 * at) * Affine3A::from_rotation_y(index as f32))
    };
    let light = Light {
        name: String::new(),
        kind: LightKind::Point { position: LAMP, falloff: Falloff::None },
        ambient: Vec3::splat(0.2),
        diffuse: Vec3::ONE,
        specular: Vec3::ONE,
        shape: None,
    };
    Scene {
        nodes: (0..64).map(place).chain([node(1, Affine3A::IDENTITY)]).collect(),
        meshes: vec![Arc::new(ball), Arc::new(room)],
        materials: vec![Material { specular: Vec3::ONE, exponent: 40.0, ..Material::default() }],
        lights: vec![light],
        background: Background::Transparent,
        ..Scene::default()
    }
}

fn node(mesh: u32, local: Affine3A) -> Node {
    Node { name: String::new(), parent: None, local, mesh: Some(MeshId(mesh)), visible: true }
}

fn mesh<const N: usize>(
    positions: Vec<Vec3>,
    faces: impl Iterator<Item = [u32; N]>,
    triangles: impl Fn([u32; N]) -> [u32; 6],
) -> Mesh {
    let indices: Vec<u32> = faces.flat_map(triangles).collect();
    Mesh {
        bounds: Aabb::of(positions.iter().copied()),
        normals: positions.iter().map(|position| position.normalize_or(Vec3::Z)).collect(),
        subsets: vec![Subset { first_index: 0, index_count: indices.len() as u32, material: MaterialId(0) }],
        positions,
        indices,
        ..Mesh::default()
    }
}
