//! The time of a frame against that of a minimal program that draws the same triangles with the same shading: what the
//! renderer's generality costs. Both wait for the GPU at the end of each frame; 1024 × 768 pixels.
//!
//! Criterion keeps the history of both. Since frame times vary from run to run, the ratio is measured by itself: frames
//! of both in turn, in one run.

use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

use aam_renderer::{Gpu, Msaa, RenderOptions, Renderer, Target};
use aam_scene::*;
use criterion::{BenchmarkId, Criterion};
use glam::{Affine3A, Mat4, Vec3, Vec4};

const WIDTH: u32 = 1024;
const HEIGHT: u32 = 768;

const LIGHT: Vec3 = Vec3::new(3.0, 4.0, 5.0);

fn main() {
    let gpu = match Gpu::headless() {
        Ok(gpu) => gpu,
        Err(error) => {
            println!("skipped: {error}");
            return;
        }
    };
    println!("adapter: {}", gpu.summary());
    let mut criterion = Criterion::default()
        .sample_size(15)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3))
        .configure_from_args();
    let mut ratios = Vec::new();
    for msaa in [Msaa::X1, Msaa::X4] {
        for (name, rings) in [("10k", 50), ("100k", 158), ("1M", 500)] {
            let scene = scene(rings);
            let triangles = scene.meshes[0].indices.len() / 3;
            let mut ours = Ours::new(&gpu, scene, msaa);
            let minimal = Minimal::new(&gpu, &ours.scene.meshes[0], &ours.view, msaa);
            let mut group = criterion.benchmark_group(format!("frame/msaa{}", msaa.samples()));
            group.bench_function(BenchmarkId::new("minimal", name), |b| b.iter(|| minimal.frame()));
            group.bench_function(BenchmarkId::new("renderer", name), |b| b.iter(|| ours.frame()));
            group.finish();
            ratios.push((msaa, triangles, ratio(&mut ours, &minimal)));
        }
    }
    println!("\nmsaa  triangles  minimal ms  renderer ms  ratio (median of pairs)");
    for (msaa, triangles, (minimal, ours, ratio)) in ratios {
        println!("{:>4}  {triangles:>9}  {minimal:>10.2}  {ours:>11.2}  {ratio:.3}", msaa.samples());
    }
    criterion.final_summary();
}

/// Median times of both in milliseconds, and the median of the ratios of neighbouring frames.
fn ratio(ours: &mut Ours, minimal: &Minimal) -> (f64, f64, f64) {
    let mut times = [Vec::new(), Vec::new(), Vec::new()];
    for round in 0..60 {
        let mut pair = [0.0; 2];
        // Whoever comes second may find caches warm: they take turns.
        for turn in 0..2 {
            let which = (round + turn) % 2;
            let start = Instant::now();
            if which == 0 {
                minimal.frame()
            } else {
                ours.frame()
            }
            pair[which] = start.elapsed().as_secs_f64() * 1e3;
        }
        times[0].push(pair[0]);
        times[1].push(pair[1]);
        times[2].push(pair[1] / pair[0]);
    }
    let [a, b, c] = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    (a, b, c)
}

/// A sphere of 4 · rings² triangles, lit by one point light.
fn scene(rings: u32) -> Scene {
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
    mesh.subsets = vec![Subset { first_index: 0, index_count: mesh.indices.len() as u32, material: MaterialId(0) }];
    mesh.bounds = Aabb::of(mesh.positions.iter().copied());
    let material = Material {
        ambient: Vec3::splat(0.1),
        diffuse: Vec3::new(0.7, 0.5, 0.3),
        specular: Vec3::splat(0.4),
        exponent: 32.0,
        ..Material::default()
    };
    let light = Light {
        name: "lamp".into(),
        kind: LightKind::Point { position: LIGHT, falloff: Falloff::None },
        ambient: Vec3::ONE,
        diffuse: Vec3::ONE,
        specular: Vec3::ONE,
        shape: None,
    };
    Scene {
        nodes: vec![Node {
            name: "sphere".into(),
            parent: None,
            local: Affine3A::from_rotation_x(0.3),
            mesh: Some(MeshId(0)),
            visible: true,
        }],
        meshes: vec![Arc::new(mesh)],
        materials: vec![material],
        lights: vec![light],
        ..Scene::default()
    }
}

fn target(gpu: &Gpu, format: wgpu::TextureFormat, samples: u32) -> wgpu::TextureView {
    let texture = gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: WIDTH, height: HEIGHT, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// The renderer.
struct Ours {
    renderer: Renderer,
    scene: Scene,
    view: View,
    options: RenderOptions,
    target: wgpu::TextureView,
}

impl Ours {
    fn new(gpu: &Gpu, scene: Scene, msaa: Msaa) -> Self {
        let camera = scene.fitting_camera(WIDTH as f32 / HEIGHT as f32);
        Self {
            renderer: Renderer::new(gpu.clone()),
            view: View { camera, width: WIDTH, height: HEIGHT, frame: 0.0 },
            options: RenderOptions { msaa, ..RenderOptions::default() },
            target: target(gpu, wgpu::TextureFormat::Rgba8Unorm, 1),
            scene,
        }
    }

    fn frame(&mut self) {
        let stats = self.renderer.render(&self.scene, &self.view, &self.options, &Target::new(&self.target)).unwrap();
        black_box(stats);
        self.renderer.gpu().wait().unwrap();
    }
}

/// The least that draws the same.
struct Minimal {
    gpu: Gpu,
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
    target: wgpu::TextureView,
    samples: Option<wgpu::TextureView>,
    depth: wgpu::TextureView,
}

const SHADER: &str = "
struct Uniforms {
    clip_from_world: mat4x4f,
    world_from_object: mat4x4f,
    eye: vec4f,
    light: vec4f,
    ambient: vec4f,
    diffuse: vec4f,
    specular_exponent: vec4f,
}
@group(0) @binding(0) var<uniform> u: Uniforms;
struct Varyings {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
}
@vertex
fn vertex(@location(0) position: vec3f, @location(1) normal: vec3f) -> Varyings {
    let world = u.world_from_object * vec4f(position, 1.0);
    // The node does not scale.
    return Varyings(u.clip_from_world * world, world.xyz, (u.world_from_object * vec4f(normal, 0.0)).xyz);
}
@fragment
fn fragment(in: Varyings, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let n = normalize(in.normal) * select(-1.0, 1.0, front);
    let l = normalize(u.light.xyz - in.position);
    let v = normalize(u.eye.xyz - in.position);
    let cosine = dot(n, l);
    let r = 2.0 * cosine * n - l;
    let color = u.ambient.rgb + u.diffuse.rgb * saturate(cosine)
        + u.specular_exponent.rgb * pow(saturate(dot(v, r)), u.specular_exponent.a);
    return vec4f(saturate(color), 1.0);
}
";

impl Minimal {
    fn new(gpu: &Gpu, mesh: &Mesh, view: &View, msaa: Msaa) -> Self {
        let device = gpu.device();
        let samples = msaa.samples();
        let buffer = |usage, bytes: &[u8]| {
            let usage = usage | wgpu::BufferUsages::COPY_DST;
            let size = bytes.len() as u64;
            let buffer =
                device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
            gpu.queue().write_buffer(&buffer, 0, bytes);
            buffer
        };
        let vertices: Vec<[Vec3; 2]> =
            mesh.positions.iter().zip(&mesh.normals).map(|(position, normal)| [*position, *normal]).collect();
        let camera = &view.camera;
        let mut uniforms: Vec<Vec4> = Vec::new();
        uniforms.extend(columns(camera.projection_matrix(view.aspect()) * camera.view()));
        uniforms.extend(columns(Mat4::from_rotation_x(0.3)));
        uniforms.extend([camera.position.extend(1.0), LIGHT.extend(1.0), Vec3::splat(0.1).extend(0.0)]);
        uniforms.extend([Vec3::new(0.7, 0.5, 0.3).extend(0.0), Vec3::splat(0.4).extend(32.0)]);
        let uniform = buffer(wgpu::BufferUsages::UNIFORM, bytemuck::cast_slice(&uniforms));
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: 24,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
                })],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: wgpu::TextureFormat::Depth32Float,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::TextureFormat::Rgba8Unorm.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
        });
        Self {
            gpu: gpu.clone(),
            pipeline,
            group,
            vertices: buffer(wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(&vertices)),
            indices: buffer(wgpu::BufferUsages::INDEX, bytemuck::cast_slice(&mesh.indices)),
            count: mesh.indices.len() as u32,
            target: target(gpu, wgpu::TextureFormat::Rgba8Unorm, 1),
            samples: (samples > 1).then(|| target(gpu, wgpu::TextureFormat::Rgba8Unorm, samples)),
            depth: target(gpu, wgpu::TextureFormat::Depth32Float, samples),
        }
    }

    fn frame(&self) {
        let mut encoder = self.gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: None,
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: self.samples.as_ref().unwrap_or(&self.target),
                    depth_slice: None,
                    resolve_target: self.samples.as_ref().map(|_| &self.target),
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color { r: 0.18, g: 0.20, b: 0.23, a: 1.0 }),
                        store: if self.samples.is_some() { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store },
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.depth,
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.group, &[]);
            pass.set_vertex_buffer(0, self.vertices.slice(..));
            pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..self.count, 0, 0..1);
        }
        self.gpu.queue().submit([encoder.finish()]);
        self.gpu.wait().unwrap();
    }
}

fn columns(matrix: Mat4) -> [Vec4; 4] {
    [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis]
}
