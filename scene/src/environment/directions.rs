//! Which direction each point of a picture lies in.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

/// A face of a cube as a viewer in its middle sees it, not mirrored. The order is that of the layers of a cube texture,
/// and of the usual file names `px nx py ny pz nz`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CubeFace {
    /// Towards +x.
    Right,
    /// Towards −x.
    Left,
    /// Towards +y; its lower edge meets the front's upper one.
    Up,
    /// Towards −y; its upper edge meets the front's lower one.
    Down,
    /// Towards −z.
    Front,
    /// Towards +z.
    Back,
}

impl CubeFace {
    /// All six, in order.
    pub const ALL: [Self; 6] = [Self::Right, Self::Left, Self::Up, Self::Down, Self::Front, Self::Back];

    /// The name for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Left => "left",
            Self::Up => "up",
            Self::Down => "down",
            Self::Front => "front",
            Self::Back => "back",
        }
    }
}

/// The direction of a point of a face, of which the coordinate along the face's axis is ±1. The point is in `[0, 1]²`,
/// `(0, 0)` at the upper left; beyond that the face's plane goes on.
pub fn cube_direction(face: CubeFace, point: Vec2) -> Vec3 {
    let (s, t) = (2.0 * point.x - 1.0, 2.0 * point.y - 1.0);
    match face {
        CubeFace::Right => Vec3::new(1.0, -t, s),
        CubeFace::Left => Vec3::new(-1.0, -t, -s),
        CubeFace::Up => Vec3::new(s, 1.0, -t),
        CubeFace::Down => Vec3::new(s, -1.0, t),
        CubeFace::Front => Vec3::new(s, -t, -1.0),
        CubeFace::Back => Vec3::new(-s, -t, 1.0),
    }
}

/// The face that a direction meets, and where: the inverse of [`cube_direction`], for directions of any length but 0.
pub fn cube_point(direction: Vec3) -> (CubeFace, Vec2) {
    let size = direction.abs();
    let Vec3 { x, y, z } = direction;
    let (face, s, t, depth) = if size.x >= size.y && size.x >= size.z {
        if x > 0.0 { (CubeFace::Right, z, -y, size.x) } else { (CubeFace::Left, -z, -y, size.x) }
    } else if size.y >= size.z {
        if y > 0.0 { (CubeFace::Up, x, -z, size.y) } else { (CubeFace::Down, x, z, size.y) }
    } else if z < 0.0 {
        (CubeFace::Front, x, -y, size.z)
    } else {
        (CubeFace::Back, -x, -y, size.z)
    };
    (face, 0.5 * Vec2::new(s, t) / depth + 0.5)
}

/// The unit direction of a point of a panorama, in `[0, 1]²`, `(0, 0)` at the upper left.
pub fn panorama_direction(point: Vec2) -> Vec3 {
    let (around, down) = (TAU * (point.x - 0.5), PI * point.y);
    Vec3::new(down.sin() * around.sin(), down.cos(), -down.sin() * around.cos())
}

/// The point of a panorama in a direction of any length but 0: the inverse of [`panorama_direction`].
pub fn panorama_point(direction: Vec3) -> Vec2 {
    let Vec3 { x, y, z } = direction;
    let level = x.hypot(z);
    // Straight up or down any column will do.
    let around = if level > 0.0 { x.atan2(-z) } else { 0.0 };
    Vec2::new(0.5 + around / TAU, level.atan2(y) / PI)
}
