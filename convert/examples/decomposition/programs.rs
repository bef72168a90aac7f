//! The programs: ours and parry3d are run, the hulls of the others are read.

use std::path::{Path, PathBuf};

use aam_convert::hulls::{Hull, HullOptions, decompose, measure as quality};
use aam_convert::{ImportOptions, Silent, import};
use parry3d::glamx::Vec3;
use parry3d::transformation::vhacd::{VHACD, VHACDParameters};
use parry3d::transformation::voxelization::FillMode;

use crate::Error;
use crate::table::Row;

/// Samples are so far apart, as a part of the diagonal: nearer than those that the program itself measures with.
const SPACING: f32 = 4e-3;

/// Every program on every mesh of a folder, or on those named.
pub(crate) fn measure(meshes: &Path, peers: &Path, names: &[&str]) -> Result<Vec<Row>, Error> {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(meshes)?.map(|entry| Ok(entry?.path())).collect::<Result<_, Error>>()?;
    files.retain(|file| {
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        file.extension().is_some_and(|ending| ending == "obj") && (names.is_empty() || names.contains(&&*stem))
    });
    files.sort();
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut rows = Vec::new();
    for file in &files {
        rows.extend(one_thread.install(|| mesh(file, peers).map_err(|error| error.to_string()))?);
    }
    Ok(rows)
}

fn mesh(file: &Path, peers: &Path) -> Result<Vec<Row>, Error> {
    let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    // One mesh of all objects.
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for part in parts(file)? {
        let base = vertices.len() as u32;
        vertices.extend(part.vertices);
        triangles.extend(part.triangles.iter().map(|triangle| triangle.map(|index| index + base)));
    }
    let mut rows = Vec::new();
    let mut add = |program: String, hulls: &[Hull], seconds: f64| -> Result<(), Error> {
        let found = quality(&vertices, &triangles, hulls, SPACING)?;
        let row = Row {
            mesh: name.clone(),
            triangles: triangles.len(),
            program,
            hulls: hulls.len(),
            most_vertices: hulls.iter().map(|hull| hull.vertices.len()).max().unwrap_or(0),
            outside_max: 100.0 * f64::from(found.outside.max),
            outside_mean: 100.0 * f64::from(found.outside.mean),
            uncovered_max: 100.0 * f64::from(found.uncovered.max),
            uncovered_mean: 100.0 * f64::from(found.uncovered.mean),
            seconds,
        };
        println!(
            "{:<14} {:<22} {:>4} hulls, {:>4} vertices, outside {:.2} / {:.3}, uncovered {:.2} / {:.3}, {:.2} s",
            row.mesh,
            row.program,
            row.hulls,
            row.most_vertices,
            row.outside_max,
            row.outside_mean,
            row.uncovered_max,
            row.uncovered_mean,
            seconds
        );
        rows.push(row);
        Ok(())
    };
    let mut count = None;
    for program in ["coacd-0.05", "coacd-0.1", "coacd-0.2", "vhacd-64", "vhacd-32", "vhacd-16"] {
        let path = peers.join(format!("{name}.{program}.obj"));
        if !path.exists() {
            println!("{name:<14} {program:<22} has no hulls");
            continue;
        }
        let hulls = parts(&path)?;
        if program == "coacd-0.05" {
            count = Some(hulls.len());
        }
        let seconds = std::fs::read_to_string(path.with_extension("txt"))?.trim().parse()?;
        add(program.into(), &hulls, seconds)?;
    }
    let counts = [8, 16, 32, 64].map(|hulls| (format!("aam {hulls}"), Some(hulls)));
    let counts = counts.into_iter().chain([("aam 2 %".into(), None)]);
    for (program, hulls) in counts.chain(count.map(|count| ("aam at CoACD's count".into(), Some(count)))) {
        let mut options = HullOptions::default();
        if let Some(hulls) = hulls {
            (options.max_hulls, options.max_error) = (hulls, None);
        }
        let (found, seconds) = timed(|| decompose(&vertices, &triangles, &options));
        add(program, &found?.hulls, seconds)?;
    }
    for (resolution, concavity) in [(64, 0.01), (128, 0.005)] {
        let (hulls, seconds) = timed(|| parry(&vertices, &triangles, resolution, concavity));
        add(format!("parry-{resolution}"), &hulls, seconds)?;
    }
    Ok(rows)
}

fn parry(vertices: &[[f32; 3]], triangles: &[[u32; 3]], resolution: u32, concavity: f32) -> Vec<Hull> {
    let points: Vec<Vec3> = vertices.iter().map(|vertex| Vec3::from(*vertex)).collect();
    let parameters = VHACDParameters {
        resolution,
        concavity,
        fill_mode: FillMode::FloodFill { detect_cavities: false },
        ..VHACDParameters::default()
    };
    let found = VHACD::decompose(&parameters, &points, triangles, true).compute_exact_convex_hulls(&points, triangles);
    let hulls = found.into_iter().map(|(vertices, triangles)| Hull {
        vertices: vertices.iter().map(|vertex| vertex.to_array()).collect(),
        triangles,
        ..Hull::default()
    });
    hulls.filter(|hull| hull.vertices.len() > 3).collect()
}

/// What a call gives, and the processor time that it takes.
fn timed<T>(call: impl FnOnce() -> T) -> (T, f64) {
    let before = processor_time();
    let found = call();
    (found, processor_time() - before)
}

/// User time of this process in seconds, in steps of 10 ms (proc(5)).
fn processor_time() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    after_name.split_whitespace().nth(11).and_then(|ticks| ticks.parse::<f64>().ok()).unwrap_or(f64::NAN) / 100.0
}

/// Each object of a file.
fn parts(path: &Path) -> Result<Vec<Hull>, Error> {
    let asset = import(path, &ImportOptions::default(), &Silent)?;
    let parts = asset.document.objects().iter().map(|object| Hull {
        vertices: object.vertices.clone(),
        triangles: object.faces.iter().flat_map(|faces| &faces.triangles).map(|triangle| triangle.vertices).collect(),
        ..Hull::default()
    });
    Ok(parts.filter(|part| !part.triangles.is_empty()).collect())
}
