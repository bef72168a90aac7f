//! How good a collision shape has to be: the same object dropped with it and with its exact surface.
//!
//! A flat floor touches no more than the hull of an object, so the objects fall on a bed of rounded pegs, which reach into
//! holes and between legs. After the first impacts two paths part whatever their shapes are, as any throw of dice does;
//! so paths are compared for half a second from the first touch only, and rest by itself: the object is placed where the
//! exact one came to rest, and it is measured how far it moves from there.

use std::sync::Arc;
use std::time::{Duration, Instant};

use aam::document::{BodyMode, Primitive};
use aam_scene::{Node, NodeId, Scene};
use glam::{Affine3A, Quat, Vec3};

use crate::{Material, PhysicsError, PhysicsMesh, Registration, Settings, Shape, Simulator};

/// Steps are so long, and there are so many a second of each part of the test.
const TIME_STEP: f32 = 1.0 / 240.0;
const ITERATIONS: usize = 8;
const FALLING: u32 = 5 * 240;
const COMPARED: u32 = 120;
const RESTING: u32 = 240;
/// Jitter is that of the last half second.
const LAST: u32 = 120;
/// Pegs, for an object whose diagonal is a metre.
const PEG_RADIUS: f32 = 0.05;
const PEG_HEIGHT: f32 = 0.3;
const PEG_SPACING: f32 = 0.55;
const PEGS: i32 = 4;
/// The control starts so far to the side, as a part of the diagonal.
const SHIFT: f32 = 1e-3;

/// What of an object can be compared.
#[derive(Clone, Debug)]
pub struct DropTest {
    /// From the object's coordinates to those of the test, where its diagonal is a metre.
    scale: f32,
    center: Vec3,
    corners: [Vec3; 8],
    exact: Vec<Fall>,
    control: DropErrors,
}

/// One drop of the exact shape.
#[derive(Clone, Debug)]
struct Fall {
    start: Affine3A,
    /// From the first touch on, one step after the other.
    path: Vec<Affine3A>,
    touch: u32,
    rest: Affine3A,
}

/// How far a shape's motion is from that of the exact surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DropErrors {
    /// Distance of the corners of the bounding box over the half second from the first touch on, root mean square, as a
    /// part of the diagonal: the middle one of all drops.
    pub path: f32,
    /// Likewise, the worst drop.
    pub worst_path: f32,
    /// How far the corners move in a second from where the exact shape rests, root mean square, as a part of the
    /// diagonal: the middle one of all drops.
    pub rest: f32,
    /// Likewise, the worst drop.
    pub worst_rest: f32,
    /// Speed of the corners at the end of that second, root mean square, in diagonals a second: the middle one.
    pub jitter: f32,
    /// Time of one step of 1/240 s, the mean.
    pub step_time: Duration,
}

impl DropErrors {
    /// The larger of the errors of path and rest.
    pub fn largest(&self) -> f32 {
        self.path.max(self.rest)
    }
}

impl DropTest {
    /// Drops the exact shape, from `drops` different turns (at least 1), and once more from a thousandth of the diagonal
    /// beside, which shows how sensitive its motion is by itself.
    ///
    /// `exact` is best a closed surface of triangles; a very fine compound is the next best.
    ///
    /// # Errors
    /// The shape has no size, or is no solid.
    pub fn new(exact: &Shape, drops: u32) -> Result<Self, PhysicsError> {
        let points = points(exact);
        let (low, high) = points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        let scale = (high - low).length().recip();
        if !(scale.is_finite() && scale > 0.0) {
            return Err(PhysicsError::Value("the size of the object"));
        }
        let center = 0.5 * (low + high);
        let half = 0.5 * (high - low) * scale;
        let corners = std::array::from_fn(|bits| {
            let sign = |axis: usize| if bits >> axis & 1 == 0 { -1.0 } else { 1.0 };
            half * Vec3::new(sign(0), sign(1), sign(2))
        });
        let mut test = Self { scale, center, corners, exact: Vec::new(), control: DropErrors::default() };
        let shape = test.unit(exact);
        test.exact = (0..drops.max(1)).map(|drop| test.fall(&shape, start(drop))).collect::<Result<_, _>>()?;
        test.control = test.errors(&shape, Affine3A::from_translation(Vec3::new(SHIFT, 0.0, 0.0)))?;
        Ok(test)
    }

    /// How far the exact shape is from itself, started a thousandth of its diagonal to the side: errors below this tell
    /// nothing.
    pub fn control(&self) -> &DropErrors {
        &self.control
    }

    /// Drops another shape of the same object.
    ///
    /// # Errors
    /// The shape is no solid.
    pub fn compare(&self, shape: &Shape) -> Result<DropErrors, PhysicsError> {
        self.errors(&self.unit(shape), Affine3A::IDENTITY)
    }

    fn errors(&self, shape: &Shape, shift: Affine3A) -> Result<DropErrors, PhysicsError> {
        let (mut paths, mut rests, mut jitters) = (Vec::new(), Vec::new(), Vec::new());
        let (mut time, mut steps) = (Duration::ZERO, 0);
        for exact in &self.exact {
            let begun = Instant::now();
            let mut stage = Stage::new(shape, shift * exact.start)?;
            let mut square = 0.0;
            for step in 0..exact.touch + exact.path.len() as u32 {
                // What falls apart is far off at once.
                let place = stage.step().unwrap_or(Affine3A::from_translation(Vec3::splat(1.0)));
                if let Some(there) = step.checked_sub(exact.touch).and_then(|step| exact.path.get(step as usize)) {
                    square += self.square_distance(&place, there) / exact.path.len() as f32;
                }
            }
            paths.push(square.sqrt());
            let mut stage = Stage::new(shape, exact.rest)?;
            let (mut before, mut speed) = (exact.rest, 0.0);
            for step in 0..RESTING {
                let place = stage.step().unwrap_or(Affine3A::from_translation(Vec3::splat(1.0)));
                if step >= RESTING - LAST {
                    speed += self.square_distance(&place, &before) / (TIME_STEP * TIME_STEP * LAST as f32);
                }
                before = place;
            }
            rests.push(self.square_distance(&before, &exact.rest).sqrt());
            jitters.push(speed.sqrt());
            time += begun.elapsed();
            steps += exact.touch + exact.path.len() as u32 + RESTING;
        }
        let [path, rest, jitter] = [&mut paths, &mut rests, &mut jitters].map(|values| {
            values.sort_by(f32::total_cmp);
            (values[values.len() / 2], values[values.len() - 1])
        });
        Ok(DropErrors {
            path: path.0,
            worst_path: path.1,
            rest: rest.0,
            worst_rest: rest.1,
            jitter: jitter.0,
            step_time: time / steps.max(1),
        })
    }

    fn fall(&self, shape: &Shape, start: Affine3A) -> Result<Fall, PhysicsError> {
        let mut stage = Stage::new(shape, start)?;
        let mut fall = Fall { start, path: Vec::new(), touch: 0, rest: start };
        let mut touched = false;
        for step in 0..FALLING {
            fall.rest = stage.step()?;
            if !touched && stage.touches() {
                (touched, fall.touch) = (true, step);
            }
            if touched && step < fall.touch + COMPARED {
                fall.path.push(fall.rest);
            }
        }
        Ok(fall)
    }

    /// The mean of the squares of the corners' distances.
    fn square_distance(&self, a: &Affine3A, b: &Affine3A) -> f32 {
        let square = |corner: &Vec3| a.transform_point3(*corner).distance_squared(b.transform_point3(*corner));
        self.corners.iter().map(square).sum::<f32>() / 8.0
    }

    /// The shape with a diagonal of a metre, around the middle of its box.
    fn unit(&self, shape: &Shape) -> Shape {
        let (scale, center) = (self.scale, self.center);
        let at = |point: &Vec3| (*point - center) * scale;
        let place = |point: [f32; 3]| at(&Vec3::from(point)).to_array();
        match shape {
            Shape::Triangles { vertices, triangles } => {
                Shape::Triangles { vertices: vertices.iter().map(at).collect(), triangles: triangles.clone() }
            }
            Shape::Compound { primitives, pieces } => Shape::Compound {
                primitives: primitives
                    .iter()
                    .map(|primitive| match *primitive {
                        Primitive::Box { center, orientation, half } => {
                            Primitive::Box { center: place(center), orientation, half: half.map(|value| value * scale) }
                        }
                        Primitive::Sphere { center, radius } => {
                            Primitive::Sphere { center: place(center), radius: radius * scale }
                        }
                        Primitive::Capsule { a, b, radius } => {
                            Primitive::Capsule { a: place(a), b: place(b), radius: radius * scale }
                        }
                    })
                    .collect(),
                pieces: pieces.iter().map(|piece| piece.iter().map(at).collect()).collect(),
            },
        }
    }
}

fn points(shape: &Shape) -> Vec<Vec3> {
    match shape {
        Shape::Triangles { vertices, triangles } => {
            triangles.as_flattened().iter().filter_map(|index| vertices.get(*index as usize).copied()).collect()
        }
        Shape::Compound { pieces, .. } => pieces.concat(),
    }
}

/// Turns that are spread evenly, above different places between the pegs.
fn start(drop: u32) -> Affine3A {
    // A low-discrepancy sequence (M. Roberts' generalised golden ratio in four dimensions).
    let part = |power: i32| (0.5 + f64::from(drop) / 1.167_303_978_261_418_7_f64.powi(power)).fract() as f32;
    let (u, v, w) = (part(1), part(2) * std::f32::consts::TAU, part(3) * std::f32::consts::TAU);
    // A uniform turn (K. Shoemake, "Uniform Random Rotations", 1992).
    let turn =
        Quat::from_xyzw((1.0 - u).sqrt() * v.sin(), (1.0 - u).sqrt() * v.cos(), u.sqrt() * w.sin(), u.sqrt() * w.cos());
    let place =
        Vec3::new(PEG_SPACING * (part(4) - 0.5), PEG_SPACING * (part(4) * 7.0).fract() - 0.5 * PEG_SPACING, 1.0);
    Affine3A::from_rotation_translation(turn.normalize(), place)
}

/// The bed of pegs and one object.
struct Stage {
    scene: Scene,
    simulator: Simulator,
    object: NodeId,
}

impl Stage {
    fn new(shape: &Shape, place: Affine3A) -> Result<Self, PhysicsError> {
        let material = Material::default();
        let ground = |primitive: Primitive| PhysicsMesh {
            name: "ground".into(),
            mode: BodyMode::Static,
            material,
            mass: None,
            shape: Shape::Compound { primitives: vec![primitive], pieces: vec![] },
        };
        let floor = Primitive::Box { center: [0.0, 0.0, -0.5], orientation: [0.0; 4], half: [20.0, 20.0, 0.5] };
        let peg = Primitive::Capsule { a: [0.0; 3], b: [0.0, 0.0, PEG_HEIGHT - PEG_RADIUS], radius: PEG_RADIUS };
        let (floor, peg) = (Arc::new(ground(floor)), Arc::new(ground(peg)));
        let object = PhysicsMesh {
            name: "object".into(),
            mode: BodyMode::Dynamic,
            material,
            mass: Some(1.0),
            shape: shape.clone(),
        };
        let mut scene = Scene::default();
        let settings =
            Settings { time_step: TIME_STEP, iterations: ITERATIONS, sleeping: false, ..Settings::default() };
        let mut simulator = Simulator::new(settings, Registration::Automatic)?;
        let mut add = |mesh: &Arc<PhysicsMesh>, local: Affine3A| {
            let node = NodeId(scene.nodes.len() as u32);
            scene.nodes.push(Node { name: mesh.name.clone(), parent: None, local, mesh: None, visible: true });
            simulator.object_created(node, mesh);
            node
        };
        add(&floor, Affine3A::IDENTITY);
        for row in -PEGS..=PEGS {
            for column in -PEGS..=PEGS {
                // Six neighbours at the same distance.
                let x = PEG_SPACING * (column as f32 + if row & 1 == 0 { 0.0 } else { 0.5 });
                let y = PEG_SPACING * 0.75_f32.sqrt() * row as f32;
                add(&peg, Affine3A::from_translation(Vec3::new(x, y, 0.0)));
            }
        }
        let object = add(&Arc::new(object), place);
        simulator.prepare(&scene);
        simulator.start()?;
        simulator.state(object).map_err(|_| PhysicsError::Value("the volume of the object"))?;
        Ok(Self { scene, simulator, object })
    }

    /// One step; gives where the object is then.
    fn step(&mut self) -> Result<Affine3A, PhysicsError> {
        self.simulator.step()?;
        let places = self.simulator.world_transforms(&self.scene);
        places.get(self.object.index()).copied().ok_or(PhysicsError::NotSimulated(self.object))
    }

    fn touches(&self) -> bool {
        !self.simulator.contacts().is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of these half extents as a closed surface and as a hull.
    fn block(half: Vec3) -> (Shape, Shape) {
        let corner = |bits: u32| {
            let sign = |axis: u32| if bits >> axis & 1 == 0 { -1.0 } else { 1.0 };
            half * Vec3::new(sign(0), sign(1), sign(2)) + Vec3::splat(7.0)
        };
        let vertices: Vec<Vec3> = (0..8).map(corner).collect();
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        (
            Shape::Triangles { vertices: vertices.clone(), triangles },
            Shape::Compound { primitives: vec![], pieces: vec![vertices] },
        )
    }

    #[test]
    fn a_convex_object_moves_as_its_exact_surface() {
        let (exact, hull) = block(Vec3::new(3.0, 2.0, 1.0));
        let test = DropTest::new(&exact, 4).expect("a solid");
        let errors = test.compare(&hull).expect("a solid");
        assert!(errors.rest < 0.01 && errors.path < 0.02, "{errors:?}, control {:?}", test.control());
        let again = test.compare(&hull).expect("a solid");
        assert_eq!((again.path, again.rest, again.jitter), (errors.path, errors.rest, errors.jitter));
    }

    #[test]
    fn a_filled_hole_is_an_error() {
        // A frame of four bars, and the block that fills it.
        let bar = |center: [f32; 3], half: [f32; 3]| Primitive::Box { center, orientation: [0.0; 4], half };
        let bars = [
            bar([0.0, 0.8, 0.0], [1.0, 0.2, 0.2]),
            bar([0.0, -0.8, 0.0], [1.0, 0.2, 0.2]),
            bar([0.8, 0.0, 0.0], [0.2, 0.6, 0.2]),
            bar([-0.8, 0.0, 0.0], [0.2, 0.6, 0.2]),
        ];
        let corners: Vec<Vec3> = (0..8_u32)
            .map(|bits| {
                let sign = |axis: u32| if bits >> axis & 1 == 0 { -1.0 } else { 1.0 };
                Vec3::new(sign(0), sign(1), 0.2 * sign(2))
            })
            .collect();
        // Its points, which primitives do not have.
        let pieces = |primitive: &Primitive| {
            let Primitive::Box { center, half, .. } = *primitive else { unreachable!("all are boxes") };
            corners.iter().map(|c| Vec3::from(center) + Vec3::from(half) * c.signum()).collect::<Vec<_>>()
        };
        let frame = Shape::Compound { primitives: vec![], pieces: bars.iter().map(pieces).collect() };
        let filled = Shape::Compound { primitives: vec![], pieces: vec![corners.clone()] };
        let test = DropTest::new(&frame, 6).expect("a solid");
        let (same, other) = (test.compare(&frame).expect("a solid"), test.compare(&filled).expect("a solid"));
        assert!(same.largest() < 1e-2, "{same:?}");
        assert!(other.worst_rest > 0.02 && other.largest() > same.largest(), "{other:?} {same:?}");
    }

    #[test]
    fn what_has_no_volume_is_refused() {
        let flat = Shape::Triangles { vertices: vec![Vec3::ZERO, Vec3::X, Vec3::Y], triangles: vec![[0, 1, 2]] };
        assert!(DropTest::new(&flat, 1).is_err());
        let nothing = Shape::Triangles { vertices: vec![], triangles: vec![] };
        assert!(DropTest::new(&nothing, 1).is_err());
    }
}
