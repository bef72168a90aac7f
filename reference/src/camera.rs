//! Rays through the picture.

use aam_scene::{Projection, View};
use glam::{Vec2, Vec3};

use crate::options::Error;

/// Makes the ray through any point of the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayMaker {
    position: Vec3,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    perspective: bool,
    pub(crate) size: Vec2,
    pub(crate) near: f32,
    pub(crate) far: f32,
}

/// A ray whose parameter is the depth along the camera's axis, with its change from pixel to pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CameraRay {
    pub(crate) origin: Vec3,
    pub(crate) direction: Vec3,
    /// Change of origin and direction for one pixel to the right and one down.
    pub(crate) origin_change: [Vec3; 2],
    pub(crate) direction_change: [Vec3; 2],
}

impl RayMaker {
    pub(crate) fn new(view: &View) -> Result<Self, Error> {
        let camera = &view.camera;
        let refuse = |why: &str| Err(Error::Camera(why.into()));
        if !(camera.position.is_finite() && camera.target.is_finite() && camera.up.is_finite()) {
            return refuse("its position, target or up is not finite");
        }
        if !(camera.near > 0.0 && camera.near < camera.far && camera.far.is_finite()) {
            return refuse("its near plane must be above 0 and its far plane beyond that");
        }
        let (half_height, perspective) = match camera.projection {
            Projection::Perspective { fov_y } if fov_y > 0.0 && fov_y < std::f32::consts::PI => {
                ((0.5 * fov_y).tan(), true)
            }
            Projection::Perspective { .. } => return refuse("its field of view must be above 0 and below 180 degrees"),
            Projection::Orthographic { height } if height > 0.0 && height.is_finite() => (0.5 * height, false),
            Projection::Orthographic { .. } => return refuse("its orthographic height must be above 0"),
        };
        let matrix = camera.view();
        let row = |index: usize| matrix.row(index).truncate();
        Ok(Self {
            position: camera.position,
            forward: -row(2),
            right: row(0) * half_height * view.aspect(),
            up: row(1) * half_height,
            perspective,
            size: Vec2::new(view.width as f32, view.height as f32),
            near: camera.near,
            far: camera.far,
        })
    }

    /// The ray through a point given in pixels from the picture's top left corner.
    pub(crate) fn ray(&self, pixel: Vec2) -> CameraRay {
        let x = pixel.x / self.size.x * 2.0 - 1.0;
        let y = 1.0 - pixel.y / self.size.y * 2.0;
        let offset = self.right * x + self.up * y;
        let change = [self.right * (2.0 / self.size.x), self.up * (-2.0 / self.size.y)];
        if self.perspective {
            CameraRay {
                origin: self.position,
                direction: self.forward + offset,
                origin_change: [Vec3::ZERO; 2],
                direction_change: change,
            }
        } else {
            CameraRay {
                origin: self.position + offset,
                direction: self.forward,
                origin_change: change,
                direction_change: [Vec3::ZERO; 2],
            }
        }
    }
}

impl CameraRay {
    /// How the point where the ray meets a plane moves for one pixel to the right and one down.
    pub(crate) fn footprint(&self, t: f32, normal: Vec3) -> [Vec3; 2] {
        let along = normal.dot(self.direction);
        [0, 1].map(|axis| {
            let moved = self.origin_change[axis] + t * self.direction_change[axis];
            moved - self.direction * (normal.dot(moved) / along)
        })
    }
}

/// Sample positions in a pixel: `n²` points, one in each cell of an `n` × `n` grid and no two in the same of `n²` rows
/// or columns (the canonical multi-jittered arrangement, Chiu, Shirley, Wang, Graphics Gems IV, 1994), so that an edge
/// along an axis has `n²` + 1 grey levels.
pub(crate) fn sample_pattern(samples: u32) -> Vec<Vec2> {
    let side = side(samples);
    let n = side as f32;
    (0..side * side)
        .map(|index| {
            let (i, j) = ((index % side) as f32, (index / side) as f32);
            Vec2::new((i + (j + 0.5) / n) / n, (j + (n - i - 0.5) / n) / n)
        })
        .collect()
}

/// The smallest `n` with `n² ≥ samples`.
pub(crate) fn side(samples: u32) -> u32 {
    (1..).find(|n| n * n >= samples).unwrap_or(1)
}
