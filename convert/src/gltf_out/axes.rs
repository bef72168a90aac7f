//! From AAM's axes (Z up) to glTF's (Y up): (x, y, z) → (x, z, −y), a turn about X; and transforms in parts.

use glam::{Affine3A, DMat3, DQuat, DVec3, Vec3};

/// A point or direction in glTF's axes.
pub(super) fn vector(v: Vec3) -> Vec3 {
    Vec3::new(v.x, v.z, -v.y)
}

/// A rotation, x y z w, in glTF's axes.
pub(super) fn rotation([x, y, z, w]: [f32; 4]) -> [f32; 4] {
    [x, z, -y, w]
}

/// The lengths along the axes, in glTF's order.
pub(super) fn lengths([x, y, z]: [f32; 3]) -> [f32; 3] {
    [x, z, y]
}

/// Translation, rotation and scale in glTF's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parts {
    pub translation: Vec3,
    /// A unit quaternion.
    pub rotation: DQuat,
    pub scale: DVec3,
    /// The largest entry of the matrix that the parts do not give back, relative to its largest: not 0 where it shears.
    pub error: f64,
}

impl Parts {
    /// Takes a transform in AAM's axes apart. A reflection becomes a negative scale on all three axes.
    pub(super) fn of(transform: &Affine3A) -> Self {
        let linear = DMat3::from_cols(
            transform.matrix3.x_axis.as_dvec3(),
            transform.matrix3.y_axis.as_dvec3(),
            transform.matrix3.z_axis.as_dvec3(),
        );
        let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
        let lengths = DVec3::new(linear.x_axis.length(), linear.y_axis.length(), linear.z_axis.length());
        let basis = orthonormal([linear.x_axis, linear.y_axis, linear.z_axis].map(|axis| sign * axis));
        let scale = sign * lengths;
        let rest = linear - basis * DMat3::from_diagonal(scale);
        let largest = |matrix: DMat3| matrix.to_cols_array().iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let turn = DQuat::from_mat3(&basis).normalize();
        Self {
            translation: vector(transform.translation.into()),
            rotation: DQuat::from_xyzw(turn.x, turn.z, -turn.y, turn.w),
            scale: DVec3::new(scale.x, scale.z, scale.y),
            error: largest(rest) / largest(linear).max(f64::MIN_POSITIVE),
        }
    }
}

/// The right-handed orthonormal basis nearest to three directions; those without length are filled in.
fn orthonormal(axes: [DVec3; 3]) -> DMat3 {
    let mut unit = axes.map(|axis| axis.try_normalize());
    // What is missing must be perpendicular to what is there.
    match unit {
        [None, None, None] => return DMat3::IDENTITY,
        [Some(x), None, None] => unit[1] = Some(x.any_orthonormal_vector()),
        [None, Some(y), None] => unit[2] = Some(y.any_orthonormal_vector()),
        [None, None, Some(z)] => unit[0] = Some(z.any_orthonormal_vector()),
        _ => {}
    }
    match unit {
        [Some(x), Some(y), None] => unit[2] = x.cross(y).try_normalize(),
        [Some(x), None, Some(z)] => unit[1] = z.cross(x).try_normalize(),
        [None, Some(y), Some(z)] => unit[0] = y.cross(z).try_normalize(),
        _ => {}
    }
    let [Some(x), Some(y), Some(z)] = unit else { return DMat3::IDENTITY };
    // The rotation of the polar decomposition: the mean of a matrix and its inverse transpose converges to it (Higham,
    // "Computing the Polar Decomposition", 1986).
    let mut basis = DMat3::from_cols(x, y, z);
    for _ in 0..20 {
        if basis.determinant().abs() < 1e-9 {
            return DMat3::IDENTITY;
        }
        let next = (basis + basis.inverse().transpose()) * 0.5;
        let change = (next - basis).to_cols_array().iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        basis = next;
        if change < 1e-15 {
            break;
        }
    }
    basis
}

#[cfg(test)]
mod tests {
    use glam::{Mat3, Quat, Vec4};

    use super::*;

    /// What the parts do to a point of AAM's axes, in AAM's axes.
    fn apply(parts: &Parts, point: Vec3) -> Vec3 {
        let moved = parts.rotation * (parts.scale * vector(point).as_dvec3()) + parts.translation.as_dvec3();
        Vec3::new(moved.x as f32, -moved.z as f32, moved.y as f32)
    }

    #[test]
    fn parts_move_points_as_the_transform_does() {
        let turn = Quat::from_xyzw(0.3, -0.5, 0.1, 0.8).normalize();
        for scale in [
            Vec3::ONE,
            Vec3::new(2.0, 0.5, 3.0),
            Vec3::new(-1.0, 1.0, 1.0),
            Vec3::splat(-2.0),
            Vec3::new(1.0, 0.0, 2.0),
        ] {
            let transform = Affine3A::from_scale_rotation_translation(scale, turn, Vec3::new(1.0, 2.0, 3.0));
            let parts = Parts::of(&transform);
            assert!(parts.error < 1e-6, "{scale}: {parts:?}");
            assert!((parts.rotation.length() - 1.0).abs() < 1e-12);
            for point in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(-1.0, 0.3, 5.0)] {
                let expected = transform.transform_point3(point);
                assert!((apply(&parts, point) - expected).length() < 1e-5, "{scale} {point}");
            }
        }
    }

    #[test]
    fn a_rotation_turns_with_its_axes() {
        // A turn about AAM's up is a turn about glTF's up.
        let quarter = Quat::from_rotation_z(0.5);
        assert_eq!(rotation(quarter.to_array()), Quat::from_rotation_y(0.5).to_array());
        assert_eq!(vector(Vec3::Z), Vec3::Y);
        assert_eq!(vector(Vec3::Y), Vec3::NEG_Z);
        assert_eq!(Vec4::from(rotation([0.0, 1.0, 0.0, 0.0])), Vec4::new(0.0, 0.0, -1.0, 0.0));
    }

    #[test]
    fn shear_is_measured_and_nothing_is_not_a_number() {
        let shear = Affine3A::from_mat3(Mat3::from_cols(Vec3::X, Vec3::new(0.5, 1.0, 0.0), Vec3::Z));
        let error = Parts::of(&shear).error;
        assert!(error > 0.1 && error < 0.6, "{error}");
        for linear in
            [Mat3::ZERO, Mat3::from_cols(Vec3::X, Vec3::X, Vec3::X), Mat3::from_cols(Vec3::X, Vec3::ZERO, Vec3::ZERO)]
        {
            let parts = Parts::of(&Affine3A::from_mat3(linear));
            assert!(parts.rotation.is_finite() && parts.scale.is_finite() && parts.error.is_finite(), "{parts:?}");
        }
    }
}
