//! Bodies for a simulation, from the objects of a document.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use aam::document::{Body, BodyMode, Convex, Object, Physics, Primitive};
use glam::DVec3;

use crate::hulls::{Decomposition, Hull, HullError, HullOptions, decompose};
use crate::{Asset, ConvertError, Progress, Report};

/// The bodies that objects become.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhysicsOptions {
    /// How they move.
    pub mode: BodyMode,
    /// The mass of all dynamic bodies together in kilograms, shared out by volume.
    pub mass: Option<f32>,
    /// Kilograms a cubic metre; used where no mass is given.
    pub density: Option<f32>,
    /// Static friction, at least 0. Default 0.5.
    pub static_friction: f32,
    /// Dynamic friction, at least 0. Default 0.5.
    pub dynamic_friction: f32,
    /// Restitution, from 0 (no bounce) to 1. Default 0.
    pub restitution: f32,
    /// How kinematic and dynamic bodies are cut into convex pieces.
    pub hulls: HullOptions,
}

/// The density of water, in kilograms a cubic metre: that of dynamic bodies without mass and density.
pub const DEFAULT_DENSITY: f32 = 1000.0;

impl PhysicsOptions {
    /// Bodies of one mode, with the default values.
    pub fn new(mode: BodyMode) -> Self {
        Self {
            mode,
            mass: None,
            density: None,
            static_friction: 0.5,
            dynamic_friction: 0.5,
            restitution: 0.0,
            hulls: HullOptions::default(),
        }
    }

    fn check(&self) -> Result<(), ConvertError> {
        let wrong = |message: String| Err(ConvertError::Option(message));
        for (option, value) in [("--mass", self.mass), ("--density", self.density)] {
            if let Some(value) = value {
                if !(value.is_finite() && value > 0.0) {
                    return wrong(format!("{option} must be above 0, not {value}"));
                }
                if self.mode != BodyMode::Dynamic {
                    let mode = self.mode.word();
                    return wrong(format!("{option} is for dynamic bodies; {mode} ones have no mass"));
                }
            }
        }
        if self.mass.is_some() && self.density.is_some() {
            return wrong("--mass and --density exclude each other".into());
        }
        for (name, value) in [("static friction", self.static_friction), ("dynamic friction", self.dynamic_friction)] {
            if !(value.is_finite() && value >= 0.0) {
                return wrong(format!("the {name} must be at least 0, not {value}"));
            }
        }
        if !(0.0..=1.0).contains(&self.restitution) {
            return wrong(format!("the restitution must be between 0 and 1, not {}", self.restitution));
        }
        Ok(())
    }
}

/// What an object was made into.
#[derive(Clone, Debug)]
pub struct Decomposed {
    /// Which object: its place in the document.
    pub object: usize,
    /// Its convex pieces.
    pub decomposition: Decomposition,
    /// The volume that the mesh encloses, if it is closed.
    pub closed_volume: Option<f64>,
    /// How long it took.
    pub time: Duration,
}

/// Gives every object with triangles a body, in place of those that were there.
///
/// Static bodies collide with the object's own triangles. Others get convex pieces in the object's coordinates, and
/// dynamic ones a mass: their volume times the density. The volume is that of the mesh where it is closed (divergence
/// theorem), else that of the pieces; the report says which. It is measured in the object's own coordinates, as the
/// pieces are: mass scales with the object.
///
/// Gives what the objects were made into, in order; nothing for static bodies.
///
/// # Errors
/// When an option is out of range, or no object can be such a body.
pub fn add_bodies(
    asset: &mut Asset,
    options: &PhysicsOptions,
    progress: &dyn Progress,
) -> Result<Vec<Decomposed>, ConvertError> {
    options.check()?;
    let solid = options.mode != BodyMode::Static;
    let with_triangles = |object: &Object| object.faces.as_ref().is_some_and(|faces| !faces.triangles.is_empty());
    let objects: Vec<(usize, &Object)> =
        asset.document.objects().iter().enumerate().filter(|(_, object)| with_triangles(object)).collect();
    if solid {
        progress.stage("convex pieces", objects.len() as u64);
    }
    let mut bodies = Vec::new();
    let mut made = Vec::new();
    let mut failed = None;
    for (index, (place, object)) in objects.into_iter().enumerate() {
        progress.step(index as u64);
        let subject = format!("object \"{}\"", object.name);
        let mut body = Body {
            object: object.id,
            name: object.name.clone(),
            mode: options.mode,
            static_friction: options.static_friction,
            dynamic_friction: options.dynamic_friction,
            restitution: options.restitution,
            mass: None,
            primitives: None,
            pieces: None,
            unknown: Vec::new(),
        };
        if !solid {
            asset.report.kept(&subject, "collision", "a static body; its shape is the object's own triangles");
            bodies.push(body);
            continue;
        }
        let triangles: Vec<[u32; 3]> =
            object.faces.iter().flat_map(|faces| &faces.triangles).map(|triangle| triangle.vertices).collect();
        let start = Instant::now();
        let decomposition = match decompose(&object.vertices, &triangles, &options.hulls) {
            Ok(decomposition) => decomposition,
            Err(error @ HullError::Option(_)) => return Err(ConvertError::Option(error.to_string())),
            Err(error) => {
                asset.report.lost(&subject, "collision", format!("no body: {error}"));
                failed.get_or_insert(format!("{subject}: {error}"));
                continue;
            }
        };
        let largest = decomposition.hulls.iter().map(|hull| hull.vertices.len()).max().unwrap_or(0);
        let pieces = match decomposition.hulls.len() {
            1 => "one convex piece".to_owned(),
            count => format!("{count} convex pieces"),
        };
        let mut note = format!("{pieces}, {largest} vertices at most");
        let simple = decomposition.hulls.iter().filter(|hull| hull.primitive.is_some()).count();
        if simple > 0 {
            note += &format!(", {simple} of them as boxes, spheres and capsules");
        }
        if decomposition.quality.uncovered.max > 1e-4 {
            note += &format!(
                "; up to {:.2} % of the diagonal stands out of them",
                100.0 * decomposition.quality.uncovered.max
            );
        }
        if let Some(wanted) = options.hulls.max_error
            && decomposition.quality.hausdorff() > wanted
        {
            note += &format!("; the error of {:.2} % asked for is not reached, allow more pieces", 100.0 * wanted);
        }
        let size = format!("{:.2} % of the diagonal", 100.0 * decomposition.quality.outside.max);
        asset.report.changed(&subject, "collision", note, Some(size));

        let convex = |(number, hull): (i32, &Hull)| Convex {
            number,
            vertices: hull.vertices.clone(),
            triangles: hull.triangles.clone(),
        };
        let (simple, others): (Vec<&Hull>, Vec<&Hull>) =
            decomposition.hulls.iter().partition(|hull| hull.primitive.is_some());
        let primitives: Vec<Primitive> = simple.iter().filter_map(|hull| hull.primitive).collect();
        body.primitives = (!primitives.is_empty()).then_some(primitives);
        body.pieces = (!others.is_empty()).then(|| (0..).zip(others).map(convex).collect());
        made.push(Decomposed {
            object: place,
            closed_volume: closed_volume(&object.vertices, &triangles),
            decomposition,
            time: start.elapsed(),
        });
        bodies.push(body);
    }
    if bodies.is_empty() {
        return Err(ConvertError::Option(match failed {
            Some(reason) => format!("no object can be a {} body: {reason}", options.mode.word().to_lowercase()),
            None => "there are no objects with triangles to make bodies of".into(),
        }));
    }
    if options.mode == BodyMode::Dynamic {
        share_mass(&mut bodies, &made, options, &mut asset.report);
    }
    asset.document.physics = Some(Physics { bodies, unknown: Vec::new() });
    Ok(made)
}

/// Gives dynamic bodies their masses, by volume.
fn share_mass(bodies: &mut [Body], made: &[Decomposed], options: &PhysicsOptions, report: &mut Report) {
    let volume = |one: &Decomposed| {
        one.closed_volume.unwrap_or_else(|| one.decomposition.hulls.iter().map(|hull| hull.volume).sum())
    };
    let all: f64 = made.iter().map(volume).sum();
    for (body, one) in bodies.iter_mut().zip(made) {
        let volume = volume(one);
        let mass = match options.mass {
            Some(mass) => f64::from(mass) * volume / all,
            None => volume * f64::from(options.density.unwrap_or(DEFAULT_DENSITY)),
        };
        // The format asks for a mass above 0.
        body.mass = Some((mass as f32).clamp(f32::MIN_POSITIVE, f32::MAX));
        let of =
            if one.closed_volume.is_some() { "the closed mesh" } else { "its convex pieces, since the mesh is open" };
        let subject = format!("object \"{}\"", body.name);
        report.kept(&subject, "mass", format!("{mass:.4} kg: {volume:.6} m³ of {of}"));
    }
}

/// The volume that a closed mesh encloses, by the divergence theorem; `None` if it is open, inside out in parts, or
/// encloses nothing.
fn closed_volume(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<f64> {
    let mut numbers: BTreeMap<[u32; 3], u32> = BTreeMap::new();
    let mut edges: BTreeMap<(u32, u32), i64> = BTreeMap::new();
    let mut volume = 0.0;
    let origin = DVec3::from(vertices.first()?.map(f64::from));
    for triangle in triangles {
        let positions = triangle.map(|index| vertices.get(index as usize).copied());
        let [Some(a), Some(b), Some(c)] = positions else { return None };
        let corners = [a, b, c].map(|position| {
            let next = numbers.len() as u32;
            *numbers.entry(position.map(|value| (value + 0.0).to_bits())).or_insert(next)
        });
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (from, to) = (corners[from], corners[to]);
            // Each edge as often one way as the other.
            *edges.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
        }
        let [a, b, c] = [a, b, c].map(|position| DVec3::from(position.map(f64::from)) - origin);
        volume += a.dot(b.cross(c)) / 6.0;
    }
    let closed = edges.iter().all(|((from, to), balance)| from == to || *balance == 0);
    (closed && volume.abs() > 0.0 && volume.is_finite()).then_some(volume.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ConvertOptions, ExportOptions, ImportOptions, Silent, convert, export, import};

    const CUBE: &str = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\nv 2 2 2\nv 0 2 2\n\
        f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    const PLATE: &str = "o plate\nv 9 9 9\nv 10 9 9\nv 10 9 10\nf -1 -2 -3\n";

    fn asset(text: &str) -> Asset {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.obj");
        std::fs::write(&path, text).unwrap();
        import(&path, &ImportOptions::default(), &Silent).unwrap()
    }

    fn bodies(text: &str, options: &PhysicsOptions) -> Result<(Vec<Body>, Asset), String> {
        let mut asset = asset(text);
        add_bodies(&mut asset, options, &Silent).map_err(|error| error.to_string())?;
        Ok((asset.document.physics.clone().unwrap().bodies, asset))
    }

    #[test]
    fn static_bodies_have_no_pieces() {
        let options = PhysicsOptions::new(BodyMode::Static);
        let (bodies, _) = bodies(&format!("o cube\n{CUBE}{PLATE}"), &options).unwrap();
        assert_eq!(bodies.iter().map(|body| body.name.decoded()).collect::<Vec<_>>(), ["cube", "plate"]);
        assert!(bodies.iter().all(|body| body.pieces.is_none() && body.mass.is_none()));
        assert_eq!((bodies[0].static_friction, bodies[0].dynamic_friction, bodies[0].restitution), (0.5, 0.5, 0.0));
    }

    #[test]
    fn a_dynamic_cube_weighs_its_volume() {
        let mut options = PhysicsOptions::new(BodyMode::Dynamic);
        let (found, asset) = bodies(CUBE, &options).unwrap();
        assert_eq!(found[0].mass, Some(8000.0));
        let pieces = found[0].pieces.as_ref().unwrap();
        assert_eq!((pieces.len(), pieces[0].vertices.len(), pieces[0].triangles.len()), (1, 8, 12));
        let note =
            |asset: &Asset| asset.report.changes.iter().find(|change| change.property == "mass").unwrap().note.clone();
        assert_eq!(note(&asset), "8000.0000 kg: 8.000000 m³ of the closed mesh");
        options.density = Some(2.0);
        assert_eq!(bodies(CUBE, &options).unwrap().0[0].mass, Some(16.0));
        // Without its lid it is open.
        let open = CUBE.replace("f 5 6 7 8\n", "");
        let (found, asset) = bodies(&open, &options).unwrap();
        // That of its pieces, which are as thick as the error allows: far from the 16 kg of what the box holds.
        let volume = |piece: &Convex| -> f32 {
            let corners = |triangle: &[u32; 3]| triangle.map(|at| glam::Vec3::from(piece.vertices[at as usize]));
            piece.triangles.iter().map(corners).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
        };
        let pieces: f32 = found[0].pieces.iter().flatten().map(volume).sum();
        let mass = found[0].mass.unwrap();
        assert!((mass - 2.0 * pieces).abs() < 1e-3 && (0.3..2.0).contains(&mass), "{mass} kg, {pieces} m³");
        assert!(note(&asset).contains("since the mesh is open"));
    }

    #[test]
    fn a_mass_is_shared_by_volume() {
        let far: String = CUBE
            .lines()
            .map(|line| match line.strip_prefix("v ") {
                Some(rest) => {
                    let values: Vec<f32> =
                        rest.split(' ').map(|word| word.parse::<f32>().unwrap() / 2.0 + 10.0).collect();
                    format!("v {} {} {}\n", values[0], values[1], values[2])
                }
                None => {
                    let numbers: Vec<i32> = line[2..].split(' ').map(|word| word.parse::<i32>().unwrap() - 9).collect();
                    format!("f {} {} {} {}\n", numbers[0], numbers[1], numbers[2], numbers[3])
                }
            })
            .collect();
        let options = PhysicsOptions { mass: Some(9.0), ..PhysicsOptions::new(BodyMode::Dynamic) };
        let (found, _) = bodies(&format!("o large\n{CUBE}o small\n{far}"), &options).unwrap();
        assert_eq!(found.iter().map(|body| body.mass.unwrap()).collect::<Vec<_>>(), [8.0, 1.0]);
    }

    #[test]
    fn what_cannot_be_a_body() {
        let options = PhysicsOptions::new(BodyMode::Kinematic);
        assert!(
            bodies(PLATE, &options)
                .unwrap_err()
                .contains("no object can be a kinematic body: object \"plate\": it is flat")
        );
        let (found, asset) = bodies(&format!("o cube\n{CUBE}{PLATE}"), &options).unwrap();
        assert_eq!(found.len(), 1);
        assert!(
            asset
                .report
                .changes
                .iter()
                .any(|change| change.subject == "object \"plate\"" && change.note.contains("flat"))
        );
        for (wrong, message) in [
            (PhysicsOptions { mass: Some(1.0), ..options }, "--mass is for dynamic bodies"),
            (PhysicsOptions { mass: Some(-1.0), ..PhysicsOptions::new(BodyMode::Dynamic) }, "--mass must be above 0"),
            (
                PhysicsOptions { mass: Some(1.0), density: Some(1.0), ..PhysicsOptions::new(BodyMode::Dynamic) },
                "exclude each other",
            ),
            (PhysicsOptions { restitution: 1.5, ..options }, "between 0 and 1"),
            (PhysicsOptions { static_friction: f32::NAN, ..options }, "static friction must be at least 0"),
            (PhysicsOptions { hulls: HullOptions { max_hulls: 0, ..options.hulls }, ..options }, "--hulls"),
        ] {
            let error = bodies(CUBE, &wrong).unwrap_err();
            assert!(error.contains(message), "{error}");
        }
    }

    #[test]
    fn bodies_are_in_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.obj");
        std::fs::write(&path, CUBE).unwrap();
        let options =
            ConvertOptions { physics: Some(PhysicsOptions::new(BodyMode::Dynamic)), ..ConvertOptions::default() };
        let converted = convert(&path, None, &options, &Silent).unwrap();
        let outcome = aam::read_file(&converted.output, &aam::ReadOptions::default()).unwrap();
        assert_eq!(outcome.findings, []);
        assert_eq!(aam::check(&outcome.document, None), []);
        assert_eq!(outcome.document.physics.as_ref().unwrap().bodies[0].mass, Some(8000.0));
        // And gone from the original format.
        let back = Asset { document: outcome.document, ..Asset::default() };
        let original = ExportOptions { original: true, ..ExportOptions::default() };
        let report = export(&back, &folder.path().join("o.aam"), &original).unwrap();
        assert!(report.changes.iter().any(|change| change.property == "physics"));
    }
}
