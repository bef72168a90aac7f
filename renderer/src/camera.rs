//! The camera as the shaders see it.

use aam_scene::{Camera, Projection, View};
use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec4, Mat4, Vec3};

use crate::RenderError;

/// `Frame` in `shaders/frame.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct FrameUniform {
    clip_from_relative: Mat4,
    pub eye: Vec3,
    normal_length: f32,
    backwards: Vec3,
    /// Factor for the light of surfaces.
    pub exposure: f32,
}

impl FrameUniform {
    /// # Errors
    /// When the camera has no picture.
    pub(crate) fn new(view: &View, normal_length: f32) -> Result<Self, RenderError> {
        let camera = &view.camera;
        check(camera).map_err(|reason| RenderError::Camera { name: camera.name.clone(), reason })?;
        // The rotation alone: positions come relative to the eye.
        let mut rotation = camera.view().as_dmat4();
        rotation.w_axis = DVec4::W;
        let clip = reversed_projection(camera, f64::from(view.aspect())) * rotation;
        Ok(Self {
            clip_from_relative: clip.as_mat4(),
            eye: camera.position,
            normal_length,
            backwards: -view_direction(camera),
            exposure: 1.0,
        })
    }
}

/// World to clip space, depth 0 to 1; `None` if the far plane is at infinity.
pub(crate) fn clip_from_world(view: &View) -> Option<DMat4> {
    let camera = &view.camera;
    let matrix = reversed_projection(camera, f64::from(view.aspect())) * camera.view().as_dmat4();
    (matrix.is_finite() && camera.far.is_finite()).then_some(matrix)
}

/// Eye-relative world to clip space for shadow volumes, which end beyond anything: at infinity, or for a camera without
/// perspective at this distance from the eye.
pub(crate) fn boundless_clip(view: &View, reach: f32) -> Mat4 {
    let far = match view.camera.projection {
        Projection::Perspective { .. } => f32::INFINITY,
        Projection::Orthographic { .. } => view.camera.far.max(reach),
    };
    let camera = Camera { far, ..view.camera.clone() };
    let mut rotation = camera.view().as_dmat4();
    rotation.w_axis = DVec4::W;
    (reversed_projection(&camera, f64::from(view.aspect())) * rotation).as_mat4()
}

/// The unit vector in which the camera looks.
pub(crate) fn view_direction(camera: &Camera) -> Vec3 {
    -camera.view().row(2).truncate()
}

fn check(camera: &Camera) -> Result<(), String> {
    if !camera.position.is_finite() || !camera.target.is_finite() || !camera.up.is_finite() {
        return Err("its position, target or up is not finite".into());
    }
    let (near, far) = (camera.near, camera.far);
    if near.is_nan() || far.is_nan() || near >= far {
        return Err(format!("near is {near} and far is {far}; near must be less"));
    }
    match camera.projection {
        Projection::Perspective { fov_y } => {
            if near <= 0.0 {
                return Err(format!("near is {near}; a perspective camera needs more than 0"));
            }
            if !(fov_y > 0.0 && fov_y < std::f32::consts::PI) {
                return Err(format!("its field of view is {fov_y}; it must lie between 0 and π radians"));
            }
        }
        Projection::Orthographic { height } => {
            if !(height > 0.0 && height.is_finite()) {
                return Err(format!("its height is {height}; it must be more than 0"));
            }
            if !(near.is_finite() && far.is_finite()) {
                return Err(format!("near is {near} and far is {far}; an orthographic camera needs finite ones"));
            }
        }
    }
    Ok(())
}

/// Camera to clip space with depth 1 near … 0 far. With a float depth buffer this keeps the relative precision of
/// distances the same over the whole range, since the density of floats near 0 makes up for the division by distance
/// (Reed, "Depth Precision Visualized", 2015). Only wgpu's GL backend, which takes depth through −1 … 1, gains nothing.
fn reversed_projection(camera: &Camera, aspect: f64) -> DMat4 {
    let (near, far) = (f64::from(camera.near), f64::from(camera.far));
    match camera.projection {
        Projection::Perspective { fov_y } => {
            let scale = 1.0 / (0.5 * f64::from(fov_y)).tan();
            // 0 for an infinite far plane.
            let a = near / (far - near);
            let b = near * (1.0 + a);
            DMat4::from_cols(
                DVec4::new(scale / aspect, 0.0, 0.0, 0.0),
                DVec4::new(0.0, scale, 0.0, 0.0),
                DVec4::new(0.0, 0.0, a, -1.0),
                DVec4::new(0.0, 0.0, b, 0.0),
            )
        }
        Projection::Orthographic { height } => {
            let height = f64::from(height);
            let depth = 1.0 / (far - near);
            DMat4::from_cols(
                DVec4::new(2.0 / (height * aspect), 0.0, 0.0, 0.0),
                DVec4::new(0.0, 2.0 / height, 0.0, 0.0),
                DVec4::new(0.0, 0.0, depth, 0.0),
                DVec4::new(0.0, 0.0, far * depth, 1.0),
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(projection: Projection, near: f32, far: f32) -> Camera {
        let (position, target) = (Vec3::ZERO, Vec3::NEG_Z);
        Camera { name: String::new(), position, target, up: Vec3::Y, projection, near, far }
    }

    #[test]
    fn depth_is_one_near_and_zero_far_and_xy_are_the_scene_crates() {
        for projection in [Projection::Perspective { fov_y: 0.9 }, Projection::Orthographic { height: 3.0 }] {
            let camera = camera(projection, 0.5, 40.0);
            let ours = reversed_projection(&camera, 1.5);
            let theirs = camera.projection_matrix(1.5).as_dmat4();
            for point in [DVec4::new(0.1, -0.2, -0.5, 1.0), DVec4::new(3.0, 1.0, -40.0, 1.0)] {
                let (a, b) = (ours * point, theirs * point);
                assert!((a / a.w).truncate().truncate().distance((b / b.w).truncate().truncate()) < 1e-6);
                assert!((a.z / a.w + b.z / b.w - 1.0).abs() < 1e-5, "{a} {b}");
            }
        }
    }

    #[test]
    fn a_far_plane_at_infinity_is_allowed() {
        let matrix = reversed_projection(&camera(Projection::Perspective { fov_y: 1.0 }, 0.1, f32::INFINITY), 1.0);
        let clip = matrix * DVec4::new(0.0, 0.0, -1e6, 1.0);
        assert!(clip.is_finite() && clip.z > 0.0);
    }

    #[test]
    fn cameras_without_a_picture_are_refused() {
        let perspective = Projection::Perspective { fov_y: 1.0 };
        for (camera, part) in [
            (camera(perspective, 0.0, 1.0), "near is 0"),
            (camera(perspective, 2.0, 1.0), "near must be less"),
            (camera(perspective, 0.1, f32::NAN), "near must be less"),
            (camera(Projection::Perspective { fov_y: 4.0 }, 0.1, 1.0), "field of view"),
            (camera(Projection::Orthographic { height: 0.0 }, 0.1, 1.0), "height"),
            (Camera { target: Vec3::NAN, ..camera(perspective, 0.1, 1.0) }, "not finite"),
        ] {
            let error = FrameUniform::new(&View { camera, width: 4, height: 4, frame: 0.0 }, 0.0).unwrap_err();
            assert!(error.to_string().contains(part), "{error}");
        }
    }
}
