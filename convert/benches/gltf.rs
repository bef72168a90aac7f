//! glTF → AAM against nothing but loading the glTF: reading the file and every value of every accessor once with the
//! gltf crate. The ratio says what a faithful conversion costs on top: checks, world coordinates, the recovery of
//! smoothing groups, materials, and writing.

#[path = "../../aam/benches/grid/mod.rs"]
mod grid;

use std::hint::black_box;
use std::path::Path;
use std::time::{Duration, Instant};

use aam_convert::{Asset, ConvertOptions, ExportOptions, ImportOptions, Silent, convert, export, import};

/// Vertices along each side of the large grid: 250,000 vertices, 498,002 triangles.
const SIDE: usize = 500;
const RUNS: usize = 7;

fn main() {
    let folder = tempfile::tempdir().expect("a folder for the benchmark");
    let large = folder.path().join("grid.glb");
    let document = grid::grid(SIDE, None);
    export(&Asset { document, ..Asset::default() }, &large, &ExportOptions::default()).expect("writable");
    let crate_model = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/assets/crate.gltf");
    println!(
        "{:<24}{:>12}{:>12}{:>12}{:>10}{:>10}",
        "median of 7, ms", "load", "import", "convert", "import/", "convert/"
    );
    for (name, path) in [("grid, 498 k triangles", large), ("crate.gltf, 10.7 k", crate_model)] {
        measure(name, &path, folder.path());
    }
}

fn measure(name: &str, path: &Path, folder: &Path) {
    let out = folder.join("out.aam");
    let (mut loads, mut imports, mut conversions) = (Vec::new(), Vec::new(), Vec::new());
    // In turn, so that what else the machine does meets all three alike; the first round warms up.
    for run in 0..=RUNS {
        let times = [
            timed(|| {
                black_box(load(path));
            }),
            timed(|| {
                black_box(import(path, &ImportOptions::default(), &Silent).expect("readable"));
            }),
            timed(|| {
                let options = ConvertOptions {
                    export: ExportOptions { overwrite: true, ..ExportOptions::default() },
                    ..ConvertOptions::default()
                };
                black_box(convert(path, Some(&out), &options, &Silent).expect("convertible"));
            }),
        ];
        if run > 0 {
            loads.push(times[0]);
            imports.push(times[1]);
            conversions.push(times[2]);
        }
    }
    let [load, import, conversion] = [loads, imports, conversions].map(|mut times: Vec<Duration>| {
        times.sort();
        times[RUNS / 2].as_secs_f64() * 1e3
    });
    println!(
        "{name:<24}{load:>12.1}{import:>12.1}{conversion:>12.1}{:>10.1}{:>10.1}",
        import / load,
        conversion / load
    );
}

fn timed(run: impl FnOnce()) -> Duration {
    let start = Instant::now();
    run();
    start.elapsed()
}

/// Reads the file, its buffers and every value of its meshes; pictures are not decoded.
fn load(path: &Path) -> f64 {
    let gltf = gltf::Gltf::open(path).expect("readable");
    let mut blob = gltf.blob.clone();
    let buffers: Vec<Vec<u8>> = gltf
        .buffers()
        .map(|buffer| match buffer.source() {
            gltf::buffer::Source::Bin => blob.take().expect("a binary chunk"),
            gltf::buffer::Source::Uri(uri) => std::fs::read(path.with_file_name(uri)).expect("readable"),
        })
        .collect();
    let mut sum = 0.0;
    for primitive in gltf.meshes().flat_map(|mesh| mesh.primitives()) {
        let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
        let triples = reader.read_positions().into_iter().flatten().chain(reader.read_normals().into_iter().flatten());
        sum += triples.flatten().map(f64::from).sum::<f64>();
        for set in 0..2 {
            let coords = reader.read_tex_coords(set).map(|coords| coords.into_f32());
            sum += coords.into_iter().flatten().flatten().map(f64::from).sum::<f64>();
        }
        let indices = reader.read_indices().map(|indices| indices.into_u32());
        sum += indices.into_iter().flatten().map(f64::from).sum::<f64>();
    }
    sum
}
