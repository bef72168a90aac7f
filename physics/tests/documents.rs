//! From the `PHYSICS` of a file to bodies.

use std::path::Path;

use aam::Document;
use aam::document::BodyMode;
use aam_physics::{Registration, Settings, Shape, Simulator, physics_meshes};
use aam_scene::{BuildOptions, NoTextures, NodeId, build, object_nodes};

fn fixture() -> Document {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/assets/physics.aam");
    aam::read_file(&path, &aam::ReadOptions::default()).expect("a fixture").document
}

fn simulator(document: &Document, settings: Settings) -> Simulator {
    let scene = build(document, &NoTextures, &BuildOptions::default()).scene;
    let nodes = object_nodes(document);
    let mut simulator = Simulator::new(settings, Registration::Automatic).expect("settings");
    for (object, mesh) in &physics_meshes(document).0 {
        simulator.object_created(nodes[*object], mesh);
    }
    assert_eq!(simulator.prepare(&scene), []);
    simulator.start().expect("prepared");
    simulator
}

#[test]
fn a_file_gives_its_bodies() {
    let document = fixture();
    let (meshes, findings) = physics_meshes(&document);
    assert_eq!(findings, []);
    assert_eq!(meshes.len(), document.physics.as_ref().expect("bodies").bodies.len());
    let find = |name: &str| meshes.values().find(|mesh| mesh.name == name).expect("a body");
    assert!(matches!(find("Bowl").shape, Shape::Triangles { .. }));
    assert_eq!((find("Bowl").mode, find("Bowl").mass), (BodyMode::Static, None));
    assert_eq!(find("Turnstile").mode, BodyMode::Kinematic);
    let Shape::Compound { primitives, pieces } = &find("Stool").shape else { panic!("a compound") };
    assert_eq!((primitives.len(), pieces.len(), find("Stool").mass), (0, 4, Some(1.2)));
    // Not every object needs a body, and a file none at all.
    let mut bare = document.clone();
    bare.physics = None;
    assert!(physics_meshes(&bare).0.is_empty());
}

#[test]
fn bodies_that_lack_something_are_left_out_and_said() {
    let mut document = fixture();
    let bodies = &mut document.physics.as_mut().expect("bodies").bodies;
    let dynamic = bodies.iter().position(|body| body.mode == BodyMode::Dynamic).expect("one");
    let change = |change: &dyn Fn(&mut aam::document::Body)| {
        let mut body = bodies[dynamic].clone();
        change(&mut body);
        body
    };
    let broken = vec![
        bodies[dynamic].clone(),
        change(&|_| {}),
        change(&|body| body.object = 999),
        change(&|body| (body.object, body.mass) = (0, None)),
        change(&|body| (body.object, body.static_friction) = (0, f32::NAN)),
        change(&|body| (body.object, body.restitution) = (0, 1.5)),
        change(&|body| (body.object, body.primitives, body.pieces) = (0, None, None)),
    ];
    *bodies = broken;
    let (meshes, findings) = physics_meshes(&document);
    assert_eq!(meshes.len(), 1);
    let messages: Vec<&str> = findings.iter().map(|finding| finding.message.as_str()).collect();
    for (message, reason) in
        messages.iter().zip(["already", "no object", "mass", "friction", "restitution", "aam convert --physics"])
    {
        assert!(message.contains(reason), "{message}");
    }
    assert_eq!(messages.len(), 6);
}

/// The ball rolls off the seesaw and over the edge of the slab; all others come to rest on it.
#[test]
fn the_workbench_comes_to_rest() {
    let document = fixture();
    let mut simulator = simulator(&document, Settings::default());
    let bodies: Vec<NodeId> = simulator.bodies().collect();
    for _ in 0..600 {
        simulator.step().expect("a good step");
    }
    let mut awake = Vec::new();
    for node in &bodies {
        let (name, state) = (simulator.name(*node).expect("a name"), simulator.state(*node).expect("simulated"));
        let position = state.pose.position;
        if name == "Steel Ball" {
            assert!(position.z < -1.0, "the ball is at {position}");
            continue;
        }
        assert!(position.z > -0.1 && position.truncate().length() < 5.0, "{name} is at {position}");
        if state.mode == BodyMode::Dynamic && !state.sleeping {
            awake.push((name, position, state.velocity, state.angular_velocity));
        }
    }
    assert!(awake.is_empty(), "{awake:?}");
}
