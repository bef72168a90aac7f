//! The shadow-mapping demo: its scenes one after the other, its moving spheres, its keys.
//!
//! After M. Carofano's demo of 2023: space goes to the next scene, L looks from the light, P and U pause and resume, R
//! starts again, and arrows change how fast the spheres of the first scene turn.

use std::path::{Path, PathBuf};
use std::time::Duration;

use aam_scene::Scene;
use glam::{Affine3A, Quat};

/// Degrees a second at first.
const SPEED: f32 = 20.0;

/// What the demo's keys ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DemoAction {
    NextScene,
    Pause,
    Resume,
    /// Angle and speed as at first.
    Reset,
    /// Degrees a second more; the angle starts again.
    Faster(i16),
}

/// The scenes, and where the motion stands.
#[derive(Debug)]
pub(crate) struct Demo {
    files: Vec<PathBuf>,
    current: usize,
    /// Degrees.
    angle: f32,
    /// Degrees a second.
    pub(crate) speed: f32,
    pub(crate) paused: bool,
    moving: Vec<Moving>,
}

/// A node that turns around the up axis.
#[derive(Debug)]
struct Moving {
    node: usize,
    /// Node to world at rest.
    rest: Affine3A,
    /// World to the parent.
    to_parent: Affine3A,
}

impl Demo {
    /// A demo of these scenes, if there are several.
    pub(crate) fn new(files: &[PathBuf]) -> Option<Self> {
        let files = files.to_vec();
        let demo = Self { files, current: 0, angle: 0.0, speed: SPEED, paused: false, moving: Vec::new() };
        (demo.files.len() > 1).then_some(demo)
    }

    /// The scene that is shown: its number from 1, and how many there are.
    pub(crate) fn place(&self) -> (usize, usize) {
        (self.current + 1, self.files.len())
    }

    /// Does what was asked for; gives the file that is to be opened then.
    pub(crate) fn act(&mut self, action: DemoAction) -> Option<&Path> {
        match action {
            DemoAction::NextScene => {
                (self.angle, self.speed) = (0.0, SPEED);
                self.moving.clear();
                self.current = (self.current + 1) % self.files.len();
                return self.files.get(self.current).map(PathBuf::as_path);
            }
            DemoAction::Pause => self.paused = true,
            DemoAction::Resume => self.paused = false,
            DemoAction::Reset => (self.angle, self.speed) = (0.0, SPEED),
            DemoAction::Faster(by) => (self.angle, self.speed) = (0.0, self.speed + f32::from(by)),
        }
        None
    }

    /// Looks for what moves in a scene at rest: the spheres with a number of their own.
    pub(crate) fn adopt(&mut self, scene: &Scene) {
        let world = scene.world_transforms();
        let numbered = |name: &str| name.strip_prefix("Sphere ").is_some_and(|number| number.parse::<u32>().is_ok());
        let moving = scene.nodes.iter().enumerate().filter(|(_, node)| numbered(&node.name)).map(|(index, node)| {
            let parent = node.parent.and_then(|parent| world.get(parent.index())).copied();
            Moving { node: index, rest: world[index], to_parent: parent.unwrap_or(Affine3A::IDENTITY).inverse() }
        });
        self.moving = moving.collect();
    }

    /// Lets time pass; true while something moves.
    pub(crate) fn advance(&mut self, time: Duration) -> bool {
        let moves = !self.paused && self.speed != 0.0 && !self.moving.is_empty();
        if moves {
            self.angle = (self.angle + self.speed * time.as_secs_f32()) % 360.0;
        }
        moves
    }

    /// Puts what moves where it is at this angle.
    pub(crate) fn pose(&self, scene: &mut Scene) {
        let turn = Affine3A::from_quat(Quat::from_axis_angle(scene.up.axis(), self.angle.to_radians()));
        for Moving { node, rest, to_parent } in &self.moving {
            if let Some(node) = scene.nodes.get_mut(*node) {
                node.local = *to_parent * turn * *rest;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use aam_scene::{Node, NodeId};
    use glam::Vec3;

    use super::*;

    fn scene() -> Scene {
        let node = |name: &str, parent: Option<u32>, x: f32| Node {
            name: name.into(),
            parent: parent.map(NodeId),
            local: Affine3A::from_translation(Vec3::X * x),
            mesh: None,
            visible: true,
        };
        let nodes = vec![node("torus.aam", None, 5.0), node("Torus", Some(0), 1.0), node("Sphere 1", Some(0), -3.0)];
        Scene { nodes, ..Scene::default() }
    }

    fn demo() -> Demo {
        Demo::new(&["a", "b", "c"].map(PathBuf::from)).expect("three scenes")
    }

    #[test]
    fn numbered_spheres_turn_around_the_up_axis_and_nothing_else() {
        let (mut demo, mut scene) = (demo(), scene());
        demo.adopt(&scene);
        demo.speed = 90.0;
        assert!(demo.advance(Duration::from_secs(1)));
        demo.pose(&mut scene);
        let world = scene.world_transforms();
        assert!(world[2].transform_point3(Vec3::ZERO).abs_diff_eq(Vec3::Y * 2.0, 1e-5), "{:?}", world[2]);
        assert!(world[1].transform_point3(Vec3::ZERO).abs_diff_eq(Vec3::X * 6.0, 1e-5));
        demo.act(DemoAction::Faster(-10));
        demo.pose(&mut scene);
        assert!(scene.world_transforms()[2].abs_diff_eq(demo.moving[0].rest, 1e-5), "an arrow starts the angle again");
    }

    #[test]
    fn keys_do_as_in_the_demo() {
        let mut demo = demo();
        demo.adopt(&scene());
        demo.act(DemoAction::Pause);
        assert!(!demo.advance(Duration::from_secs(1)) && demo.angle == 0.0);
        demo.act(DemoAction::Resume);
        demo.act(DemoAction::Faster(10));
        assert!(demo.advance(Duration::from_secs(1)) && demo.angle == SPEED + 10.0);
        demo.act(DemoAction::Reset);
        assert_eq!((demo.angle, demo.speed), (0.0, SPEED));
        let next = |demo: &mut Demo| demo.act(DemoAction::NextScene).map(Path::to_owned);
        assert_eq!([next(&mut demo), next(&mut demo), next(&mut demo)], ["b", "c", "a"].map(|name| Some(name.into())));
        assert!(!demo.advance(Duration::from_secs(1)), "nothing moves in a scene that is not there yet");
        assert!(Demo::new(&["a".into()]).is_none(), "one file is no demo");
    }
}
