//! Which camera the arguments ask for.

use aam_scene::{Aabb, Camera, Projection, Scene, Up, View};
use glam::{Quat, Vec2, Vec3};

use crate::cli::RenderArgs;
use crate::failure::Failure;
use crate::shadows;

const SIDES: [&str; 7] = ["front", "back", "left", "right", "top", "bottom", "iso"];

/// The camera for the first (or only) picture.
///
/// `active` is the one that the file names to be looked through first.
pub(crate) fn choose(args: &RenderArgs, scene: &Scene, active: Option<&Camera>) -> Result<Camera, Failure> {
    let aspect = args.size.width as f32 / args.size.height as f32;
    let bounds = scene.bounds();
    let mut camera = match (&args.view, args.camera_position) {
        (Some(name), _) if is_source(name) => return of_source(name, args, scene),
        (Some(name), _) => named(name, scene, aspect)?,
        (None, Some(position)) => Camera {
            name: "camera".into(),
            position,
            target: args.camera_target.unwrap_or_else(|| bounds.center()),
            ..scene.fitting_camera(aspect)
        },
        (None, None) => match active {
            Some(camera) => camera.clone(),
            None => scene.fitting_camera(aspect),
        },
    };
    let from_file = scene.cameras.contains(&camera);
    if let (Some(target), None) = (args.camera_target, args.camera_position) {
        camera.position += target - camera.target;
        camera.target = target;
    }
    if let Some(up) = args.camera_up {
        camera.up = up;
    }
    if let Some(degrees) = args.fov {
        let fov_y = degrees.to_radians();
        if let (false, None, Projection::Perspective { fov_y: before }) =
            (from_file, args.camera_position, camera.projection)
        {
            // What was fitted stays fitted, with the same margin.
            let backward = (camera.position - camera.target).normalize_or(Vec3::Y);
            let right = camera.up.cross(backward).normalize_or(Vec3::X);
            let distance = |fov_y: f32| {
                let high = (0.5 * fov_y).tan();
                bounds.fitting_distance([right, backward.cross(right), backward], Vec2::new(high * aspect, high)).0
            };
            let margin = camera.position.distance(camera.target) / distance(before).max(f32::MIN_POSITIVE);
            camera.position = camera.target + backward * (margin.clamp(1.0, 2.0) * distance(fov_y));
        }
        camera.projection = Projection::Perspective { fov_y };
    }
    if !camera.position.is_finite() || camera.position == camera.target {
        return Err(Failure::new("the camera stands where it looks at")
            .help("give --camera-position and --camera-target two different places"));
    }
    if camera.up.cross(camera.target - camera.position).length() <= 1e-6 * camera.up.length() {
        camera.up = other_up(scene.up);
    }
    if !from_file {
        (camera.near, camera.far) = depth_range(&camera, &bounds);
    }
    Ok(camera)
}

/// `light` or `light:NAME`.
fn is_source(name: &str) -> bool {
    let word = name.split(':').next().unwrap_or(name);
    word.eq_ignore_ascii_case("light")
}

/// The view of a shadow source.
fn of_source(name: &str, args: &RenderArgs, scene: &Scene) -> Result<Camera, Failure> {
    let name = name.split_once(':').map(|(_, name)| name).filter(|name| !name.is_empty());
    let index = shadows::source(scene, name)?;
    let size = args.size;
    let fit = scene.fitting_camera(size.width as f32 / size.height as f32);
    let view = View { camera: fit, width: size.width, height: size.height, frame: args.frame };
    aam_renderer::shadow_camera(scene, &view, index)
        .map_err(|reason| Failure::new(format_args!("there is no view from this shadow source: {reason}")))
}

fn other_up(up: Up) -> Vec3 {
    match up {
        Up::Z => Vec3::Y,
        Up::Y => Vec3::NEG_Z,
    }
}

fn named(name: &str, scene: &Scene, aspect: f32) -> Result<Camera, Failure> {
    // Given for +Z up and the front at −Y.
    let direction = match name.to_ascii_lowercase().as_str() {
        "front" => Vec3::NEG_Y,
        "back" => Vec3::Y,
        "left" => Vec3::NEG_X,
        "right" => Vec3::X,
        "top" => Vec3::Z,
        "bottom" => Vec3::NEG_Z,
        "iso" => Vec3::new(1.0, -1.0, 1.0),
        _ => {
            let exact = scene.cameras.iter().find(|camera| camera.name == name);
            let loose = || scene.cameras.iter().find(|camera| camera.name.eq_ignore_ascii_case(name));
            return exact.or_else(loose).cloned().ok_or_else(|| unknown(name, scene));
        }
    };
    let direction = match scene.up {
        Up::Z => direction,
        Up::Y => Vec3::new(direction.x, direction.z, -direction.y),
    };
    Ok(scene.fitting_camera_from(direction, aspect))
}

fn unknown(name: &str, scene: &Scene) -> Failure {
    let cameras: Vec<&str> =
        scene.cameras.iter().map(|camera| camera.name.as_str()).filter(|name| !name.is_empty()).collect();
    let cameras = match cameras.len() {
        0 => "the file has no named camera".to_owned(),
        _ => format!("cameras of the file: {}", cameras.join(", ")),
    };
    let known = SIDES.into_iter().chain(scene.cameras.iter().map(|camera| camera.name.as_str()));
    let near = match aam::nearest(name.as_bytes(), known) {
        Some(near) => format!("; did you mean {near}?"),
        None => String::new(),
    };
    Failure::new(format_args!("there is no view {name:?}{near}"))
        .help(format_args!("views: {}; light and light:NAME for shadow sources; {cameras}", SIDES.join(", ")))
}

/// Near and far planes around the scene.
fn depth_range(camera: &Camera, bounds: &Aabb) -> (f32, f32) {
    let radius = (0.5 * bounds.diagonal()).max(1e-6);
    let forward = (camera.target - camera.position).normalize_or(Vec3::Y);
    let middle = (bounds.center() - camera.position).dot(forward);
    let far = (middle + radius).max(1e-2 * radius) * 1.01;
    let near = (middle - radius).max(2e-4 * far.max(radius)) * 0.99;
    (near, far)
}

/// The camera after turning around the scene's up axis by a fraction of the circle.
pub(crate) fn turned(camera: &Camera, up: Up, fraction: f32) -> Camera {
    let turn = Quat::from_axis_angle(up.axis(), fraction * std::f32::consts::TAU);
    Camera {
        position: camera.target + turn * (camera.position - camera.target),
        up: turn * camera.up,
        ..camera.clone()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use aam_scene::{Mesh, MeshId, Node};
    use clap::Parser;
    use glam::Affine3A;

    use super::*;
    use crate::cli::{Cli, Verb};

    fn args(words: &[&str]) -> Box<RenderArgs> {
        let words = ["aam", "render", "x.aam", "-o", "x.png", "--size", "200x100"].iter().chain(words);
        match Cli::try_parse_from(words).expect("arguments").verb {
            Verb::Render(args) => args,
            _ => unreachable!("render was asked for"),
        }
    }

    fn scene(up: Up) -> Scene {
        let corners = vec![Vec3::splat(-1.0), Vec3::ONE];
        let mesh = Mesh { bounds: Aabb::of(corners.clone()), positions: corners, ..Mesh::default() };
        let node = Node {
            name: "box".into(),
            parent: None,
            local: Affine3A::from_translation(Vec3::new(10.0, 0.0, 0.0)),
            mesh: Some(MeshId(0)),
            visible: true,
        };
        let door = Camera {
            name: "Door".into(),
            position: Vec3::new(0.0, 5.0, 1.0),
            target: Vec3::ZERO,
            up: Vec3::Z,
            projection: Projection::Perspective { fov_y: 1.0 },
            near: 0.5,
            far: 50.0,
        };
        Scene { up, nodes: vec![node], meshes: vec![Arc::new(mesh)], cameras: vec![door], ..Scene::default() }
    }

    /// Every corner of the box is in the picture and between near and far.
    fn sees_all(camera: &Camera) -> bool {
        let matrix = camera.projection_matrix(2.0) * camera.view();
        (0..8).all(|corner| {
            let pick = |bit: u8| if corner & bit == 0 { -1.0 } else { 1.0 };
            let seen = matrix.project_point3(Vec3::new(10.0 + pick(1), pick(2), pick(4)));
            seen.x.abs() <= 1.0 && seen.y.abs() <= 1.0 && (0.0..=1.0).contains(&seen.z)
        })
    }

    #[test]
    fn every_side_sees_everything() {
        for up in [Up::Y, Up::Z] {
            for side in SIDES {
                for fov in ["20", "90", "150"] {
                    let camera = choose(&args(&["--view", side, "--fov", fov]), &scene(up), None).expect("a camera");
                    assert!(sees_all(&camera), "{up:?} {side} {fov} {camera:?}");
                }
            }
        }
    }

    #[test]
    fn the_front_is_where_gltf_has_it() {
        let z = choose(&args(&["--view", "front"]), &scene(Up::Z), None).expect("a camera");
        assert!(z.position.y < -1.0 && (z.position.x - 10.0).abs() < 1e-4);
        let y = choose(&args(&["--view", "front"]), &scene(Up::Y), None).expect("a camera");
        assert!(y.position.z > 1.0 && (y.position.x - 10.0).abs() < 1e-4);
    }

    #[test]
    fn a_camera_of_the_file_is_found_by_name() {
        let scene = scene(Up::Z);
        assert_eq!(choose(&args(&["--view", "door"]), &scene, None).expect("a camera"), scene.cameras[0]);
        assert_eq!(choose(&args(&[]), &scene, scene.cameras.first()).expect("a camera"), scene.cameras[0]);
        assert_eq!(choose(&args(&[]), &scene, None).expect("a camera").name, "fit");
        let error = choose(&args(&["--view", "window"]), &scene, None).expect_err("no such camera");
        assert!(error.help.is_some_and(|help| help.contains("Door") && help.contains("front")));
    }

    #[test]
    fn places_can_be_given() {
        let given = args(&["--camera-position", "10,-6,0", "--camera-target", "10,0,0.5", "--camera-up", "0,0,1"]);
        let camera = choose(&given, &scene(Up::Z), None).expect("a camera");
        assert_eq!((camera.position, camera.target), (Vec3::new(10.0, -6.0, 0.0), Vec3::new(10.0, 0.0, 0.5)));
        assert!(camera.near > 0.0 && camera.near < 5.0 && camera.far > 7.0);
        let inside = choose(&args(&["--camera-position", "10,0.1,0"]), &scene(Up::Z), None).expect("a camera");
        assert!(inside.near > 0.0 && inside.near < 0.01);
        let nowhere = args(&["--camera-position", "1,2,3", "--camera-target", "1,2,3"]);
        assert!(choose(&nowhere, &scene(Up::Z), None).is_err());
    }

    #[test]
    fn looking_along_up_is_possible() {
        let above = args(&["--camera-position", "10,0,9", "--camera-target", "10,0,0"]);
        let camera = choose(&above, &scene(Up::Z), None).expect("a camera");
        assert!(camera.view().is_finite() && sees_all(&camera));
    }

    #[test]
    fn a_turntable_goes_around_and_comes_back() {
        let scene = scene(Up::Z);
        let start = choose(&args(&[]), &scene, None).expect("a camera");
        let quarter = turned(&start, scene.up, 0.25);
        assert!((quarter.position.z - start.position.z).abs() < 1e-4);
        assert!(quarter.position.distance(start.position) > 1.0 && sees_all(&quarter));
        assert!(turned(&start, scene.up, 1.0).position.distance(start.position) < 1e-3);
    }
}
