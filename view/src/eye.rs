//! The camera that the user moves: it orbits a target, pans, comes closer, looks around and flies.

use aam_scene::{Aabb, Camera, Projection, Up};
use glam::{Vec2, Vec3};

/// Steepest look up or down, just short of the pole.
const STEEPEST: f32 = 1.570;
const FOV_Y: f32 = 0.7;
/// How much larger than what is fitted the picture is.
const MARGIN: f32 = 1.08;

/// A camera as angles around a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Eye {
    up: Up,
    /// The point in the middle of the picture.
    target: Vec3,
    /// Around the up axis; 0 stands in front.
    yaw: f32,
    /// Above the horizon.
    pitch: f32,
    distance: f32,
    fov_y: f32,
    orthographic: bool,
    /// The scene's box, which the steps and the depth range follow.
    bounds: Aabb,
}

/// The standard directions to look from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Front,
    Back,
    Left,
    Right,
    Top,
    Bottom,
    Corner,
}

impl Side {
    pub(crate) const ALL: [(Self, &'static str); 7] = [
        (Self::Front, "Front"),
        (Self::Back, "Back"),
        (Self::Left, "Left"),
        (Self::Right, "Right"),
        (Self::Top, "Top"),
        (Self::Bottom, "Bottom"),
        (Self::Corner, "Corner"),
    ];

    /// Yaw and pitch.
    fn angles(self) -> (f32, f32) {
        use std::f32::consts::{FRAC_PI_2, PI};
        match self {
            Self::Front => (0.0, 0.0),
            Self::Back => (PI, 0.0),
            Self::Left => (-FRAC_PI_2, 0.0),
            Self::Right => (FRAC_PI_2, 0.0),
            Self::Top => (0.0, STEEPEST),
            Self::Bottom => (0.0, -STEEPEST),
            Self::Corner => (0.588, 0.445),
        }
    }
}

impl Eye {
    /// Stands at the front right corner and sees all of the box.
    pub(crate) fn new(up: Up, bounds: Aabb, aspect: f32) -> Self {
        let (yaw, pitch) = Side::Corner.angles();
        let mut eye =
            Self { up, target: Vec3::ZERO, yaw, pitch, distance: 1.0, fov_y: FOV_Y, orthographic: false, bounds };
        eye.fit(bounds, aspect);
        eye
    }

    /// Takes a new scene's box without moving.
    pub(crate) fn set_bounds(&mut self, up: Up, bounds: Aabb) {
        self.up = up;
        self.bounds = bounds;
    }

    /// Looks the same way from where all of the box is seen.
    pub(crate) fn fit(&mut self, bounds: Aabb, aspect: f32) {
        let high = (0.5 * self.fov_y).tan() / MARGIN;
        let (right, up) = self.right_and_up();
        let tangents = Vec2::new(high * aspect.clamp(0.05, 20.0), high);
        let (distance, depth) = bounds.fitting_distance([right, up, self.back()], tangents);
        self.target = bounds.center();
        self.distance = distance.max(depth + 0.01 * radius(&bounds));
    }

    /// Looks from a standard direction.
    pub(crate) fn look_from(&mut self, side: Side) {
        (self.yaw, self.pitch) = side.angles();
    }

    /// Stands and looks as a camera of the file does; its roll is lost.
    pub(crate) fn look_through(&mut self, camera: &Camera) {
        let back = camera.position - camera.target;
        if !(back.length() > 0.0 && back.is_finite()) {
            return;
        }
        self.distance = back.length();
        self.target = camera.target;
        let direction = back / self.distance;
        let (side, front, height) = match self.up {
            Up::Z => (direction.x, -direction.y, direction.z),
            Up::Y => (direction.x, direction.z, direction.y),
        };
        self.pitch = height.clamp(-1.0, 1.0).asin().clamp(-STEEPEST, STEEPEST);
        if side.hypot(front) > 1e-6 {
            self.yaw = side.atan2(front);
        }
        match camera.projection {
            Projection::Perspective { fov_y } => {
                self.orthographic = false;
                self.fov_y = fov_y.clamp(0.02, 3.0);
            }
            Projection::Orthographic { height } => {
                self.orthographic = true;
                self.distance = (0.5 * height / (0.5 * self.fov_y).tan()).max(1e-6);
            }
        }
    }

    /// Turns around the target, by a drag in points.
    pub(crate) fn orbit(&mut self, drag: Vec2) {
        self.yaw = (self.yaw - drag.x * 0.008).rem_euclid(std::f32::consts::TAU);
        self.pitch = (self.pitch + drag.y * 0.008).clamp(-STEEPEST, STEEPEST);
    }

    /// Turns the head where it stands.
    pub(crate) fn look(&mut self, drag: Vec2) {
        let position = self.position();
        self.yaw = (self.yaw - drag.x * 0.004).rem_euclid(std::f32::consts::TAU);
        self.pitch = (self.pitch + drag.y * 0.004).clamp(-STEEPEST, STEEPEST);
        self.target = position - self.back() * self.distance;
    }

    /// Moves sideways so that the target follows the pointer; `height` is that of the picture in points.
    pub(crate) fn pan(&mut self, drag: Vec2, height: f32) {
        let per_point = 2.0 * self.distance * (0.5 * self.fov_y).tan() / height.max(1.0);
        let (right, up) = self.right_and_up();
        self.target += (-right * drag.x + up * drag.y) * per_point;
    }

    /// Comes closer by wheel notches; close to the target it goes on through it.
    pub(crate) fn zoom(&mut self, notches: f32) {
        let factor = 0.88_f32.powf(notches.clamp(-20.0, 20.0));
        let radius = radius(&self.bounds);
        let least = 1e-3 * radius;
        let wanted = self.distance * factor;
        if wanted < least && !self.orthographic {
            self.target -= self.back() * (self.distance - wanted).max(0.02 * radius);
            self.distance = least;
        } else {
            self.distance = wanted.clamp(least.min(self.distance), (1e4 * radius).max(self.distance));
        }
    }

    /// Flies: right, up, forward, as fractions of the scene's size.
    pub(crate) fn fly(&mut self, motion: Vec3) {
        let (right, up) = self.right_and_up();
        self.target += (right * motion.x + up * motion.y - self.back() * motion.z) * radius(&self.bounds);
    }

    /// Between perspective and orthographic, with the target at the same size.
    pub(crate) fn toggle_orthographic(&mut self) {
        self.orthographic = !self.orthographic;
    }

    pub(crate) fn orthographic(&self) -> bool {
        self.orthographic
    }

    /// The camera of this moment.
    pub(crate) fn camera(&self) -> Camera {
        let mut camera = Camera {
            name: "view".into(),
            position: self.position(),
            target: self.target,
            up: self.right_and_up().1,
            projection: if self.orthographic {
                Projection::Orthographic { height: 2.0 * self.distance * (0.5 * self.fov_y).tan() }
            } else {
                Projection::Perspective { fov_y: self.fov_y }
            },
            near: 0.0,
            far: 0.0,
        };
        (camera.near, camera.far) = self.depth_range(camera.position);
        camera
    }

    /// Near and far planes around the box.
    fn depth_range(&self, position: Vec3) -> (f32, f32) {
        let radius = radius(&self.bounds);
        let middle = (self.bounds.center() - position).dot(-self.back());
        let far = (middle + radius).max(1e-2 * radius) * 1.01;
        let near = (middle - radius).max(if self.orthographic { f32::MIN } else { 2e-4 * far.max(radius) });
        (near * 0.99, far)
    }

    fn position(&self) -> Vec3 {
        self.target + self.back() * self.distance
    }

    /// Unit vector from the target to the eye.
    fn back(&self) -> Vec3 {
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        let (height, level) = self.pitch.sin_cos();
        match self.up {
            Up::Z => Vec3::new(level * sin_yaw, -level * cos_yaw, height),
            Up::Y => Vec3::new(level * sin_yaw, height, level * cos_yaw),
        }
    }

    fn right_and_up(&self) -> (Vec3, Vec3) {
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        let right = match self.up {
            Up::Z => Vec3::new(cos_yaw, sin_yaw, 0.0),
            Up::Y => Vec3::new(cos_yaw, 0.0, -sin_yaw),
        };
        (right, self.back().cross(right))
    }
}

fn radius(bounds: &Aabb) -> f32 {
    let radius = 0.5 * bounds.diagonal();
    if radius.is_finite() && radius > 1e-6 { radius } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_box() -> Aabb {
        Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE }
    }

    /// The point's place in the picture, −1 to 1, and its depth.
    fn project(camera: &Camera, point: Vec3) -> Vec3 {
        (camera.projection_matrix(1.0) * camera.view()).project_point3(point)
    }

    #[test]
    fn everything_is_seen_at_first_from_every_side() {
        for up in [Up::Y, Up::Z] {
            for (side, name) in Side::ALL {
                let mut eye = Eye::new(up, unit_box(), 1.0);
                eye.look_from(side);
                eye.fit(unit_box(), 1.0);
                for corner in 0..8 {
                    let pick = |bit: u8| if corner & bit == 0 { -1.0 } else { 1.0 };
                    let seen = project(&eye.camera(), Vec3::new(pick(1), pick(2), pick(4)));
                    assert!(seen.x.abs() <= 1.0 && seen.y.abs() <= 1.0, "{up:?} {name} {seen}");
                    assert!((0.0..=1.0).contains(&seen.z), "{up:?} {name} {seen}");
                }
            }
        }
    }

    #[test]
    fn the_front_shows_x_to_the_right_and_up_upwards() {
        for up in [Up::Y, Up::Z] {
            let mut eye = Eye::new(up, unit_box(), 1.0);
            eye.look_from(Side::Front);
            let camera = eye.camera();
            assert!(project(&camera, Vec3::X).x > 0.1, "{up:?}");
            assert!(project(&camera, up.axis()).y > 0.1, "{up:?}");
        }
    }

    #[test]
    fn a_drag_to_the_right_turns_the_front_to_the_right() {
        let mut eye = Eye::new(Up::Z, unit_box(), 1.0);
        eye.look_from(Side::Front);
        let front = Vec3::new(0.0, -1.0, 0.0);
        eye.orbit(Vec2::new(40.0, 0.0));
        assert!(project(&eye.camera(), front).x > 0.05);
        eye.orbit(Vec2::new(-40.0, 40.0));
        assert!(project(&eye.camera(), front).y < -0.05, "dragging down shows it from above");
    }

    #[test]
    fn panning_moves_the_target_with_the_pointer() {
        for up in [Up::Y, Up::Z] {
            let mut eye = Eye::new(up, unit_box(), 1.0);
            let target = eye.camera().target;
            eye.pan(Vec2::new(100.0, -50.0), 400.0);
            let seen = project(&eye.camera(), target);
            assert!((seen.x - 0.5).abs() < 1e-3 && (seen.y - 0.25).abs() < 1e-3, "{up:?} {seen}");
        }
    }

    #[test]
    fn looking_and_flying_move_head_and_body() {
        let mut eye = Eye::new(Up::Z, unit_box(), 1.0);
        let before = eye.camera();
        eye.look(Vec2::new(30.0, 10.0));
        assert!(eye.camera().position.distance(before.position) < 1e-4);
        assert!(eye.camera().target.distance(before.target) > 0.1);
        let before = eye.camera();
        eye.fly(Vec3::new(0.0, 0.0, 0.5));
        let step = eye.camera().position - before.position;
        assert!(step.dot(before.target - before.position) > 0.0);
    }

    #[test]
    fn zooming_never_passes_into_nonsense() {
        let mut eye = Eye::new(Up::Z, unit_box(), 1.0);
        for _ in 0..500 {
            eye.zoom(20.0);
        }
        assert!(eye.camera().position.is_finite() && eye.camera().near > 0.0);
        for _ in 0..500 {
            eye.zoom(-20.0);
        }
        let camera = eye.camera();
        assert!(camera.position.is_finite() && camera.far > camera.near && camera.far.is_finite());
    }

    #[test]
    fn a_camera_of_the_file_is_taken_over() {
        let camera = Camera {
            name: "door".into(),
            position: Vec3::new(3.0, -4.0, 2.0),
            target: Vec3::new(0.5, 0.0, 1.0),
            up: Vec3::Z,
            projection: Projection::Perspective { fov_y: 1.0 },
            near: 0.1,
            far: 100.0,
        };
        let mut eye = Eye::new(Up::Z, unit_box(), 1.0);
        eye.look_through(&camera);
        let seen = eye.camera();
        assert!(seen.position.distance(camera.position) < 1e-4, "{}", seen.position);
        assert!(seen.target.distance(camera.target) < 1e-4);
        assert_eq!(seen.projection, camera.projection);
    }

    #[test]
    fn an_empty_scene_has_a_camera() {
        let eye = Eye::new(Up::Y, Aabb::EMPTY, 1.0);
        let camera = eye.camera();
        assert!(camera.position.is_finite() && camera.near > 0.0 && camera.far > camera.near);
    }

    #[test]
    fn orthographic_keeps_the_target_plane_at_its_size() {
        let mut eye = Eye::new(Up::Z, unit_box(), 1.0);
        let right = eye.right_and_up().0;
        let before = project(&eye.camera(), eye.target + right);
        eye.toggle_orthographic();
        let after = project(&eye.camera(), eye.target + right);
        assert!((before.x - after.x).abs() < 1e-4, "{before} {after}");
    }
}
