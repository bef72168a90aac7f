//! The points that a light with a size shines from.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use aam_scene::LightShape;
use glam::{Vec2, Vec3};

/// A light's shape, turned to where it faces.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Extent {
    Flat(Flat),
    /// Of this radius.
    Sphere(f32),
}

/// A flat shape around the light's place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flat {
    round: bool,
    /// Two radii, or halves of two sides.
    axes: [Vec3; 2],
}

/// A direction to a sphere of light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    /// Unit vector.
    pub(crate) towards: Vec3,
    /// 1 minus the cosine of the angle to the cone's axis.
    pub(crate) aside: f32,
    /// The density of cosine-weighted light over the density of directions: the mean of this times the cosine with any
    /// normal is that normal's cosine with the axis, if all of the cone is above the horizon.
    pub(crate) weight: f32,
}

impl Extent {
    /// `None` where a length is not above 0 and finite: such a light is a point.
    pub(crate) fn new(shape: &LightShape, facing: Vec3, up: Vec3) -> Option<Self> {
        let usable = |length: f32| length > 0.0 && length.is_finite();
        let (round, half) = match *shape {
            LightShape::Sphere { radius } => return usable(radius).then_some(Self::Sphere(radius)),
            LightShape::Disc { radius } => (true, Vec2::splat(radius)),
            LightShape::Rectangle { width, height } => (false, 0.5 * Vec2::new(width, height)),
        };
        let level = up.cross(facing).try_normalize().filter(|_| up.cross(facing).length() > 1e-3);
        let across = level.unwrap_or(Vec3::X).reject_from_normalized(facing).normalize_or(Vec3::Y);
        let axes = [across * half.x, facing.cross(across) * half.y];
        (usable(half.x) && usable(half.y)).then_some(Self::Flat(Flat { round, axes }))
    }
}

impl Flat {
    /// A point, as an offset from the light's place, from a point of the unit square; equal areas from equal areas.
    pub(crate) fn offset(&self, sample: Vec2) -> Vec3 {
        let square = 2.0 * sample - 1.0;
        let at = if self.round { disc(square) } else { square };
        self.axes[0] * at.x + self.axes[1] * at.y
    }
}

/// Takes the square −1..1 to the unit disc, areas kept and neighbours kept (Shirley and Chiu, 1997).
pub(crate) fn disc(square: Vec2) -> Vec2 {
    let Vec2 { x, y } = square;
    if x == 0.0 && y == 0.0 {
        return Vec2::ZERO;
    }
    let (radius, angle) =
        if x.abs() > y.abs() { (x, FRAC_PI_4 * (y / x)) } else { (y, FRAC_PI_2 - FRAC_PI_4 * (x / y)) };
    radius * Vec2::from_angle(angle)
}

/// A direction of the cone around an axis in which a sphere is seen, from a point of the unit square; equal solid
/// angles from equal areas. `sine` is that of the cone's half angle, at most 1.
pub(crate) fn cone(axis: Vec3, sine: f32, sample: Vec2) -> Cone {
    let squared = sine * sine;
    let cosine = (1.0 - squared).max(0.0).sqrt();
    // 1 − cos, without the cancellation for small angles.
    let height = squared / (1.0 + cosine);
    let aside = sample.x * height;
    let radius = (aside * (2.0 - aside)).max(0.0).sqrt();
    let (x, y) = axis.any_orthonormal_pair();
    let around = Vec2::from_angle(TAU * sample.y) * radius;
    let towards = x * around.x + y * around.y + axis * (1.0 - aside);
    Cone { towards, aside, weight: 2.0 / (1.0 + cosine) }
}

/// A direction around a unit normal with a density of its cosine over π.
pub(crate) fn cosine_direction(normal: Vec3, sample: Vec2) -> Vec3 {
    let at = disc(2.0 * sample - 1.0);
    let (x, y) = normal.any_orthonormal_pair();
    x * at.x + y * at.y + normal * (1.0 - at.length_squared()).max(0.0).sqrt()
}

/// A direction around a unit axis with a density of `(n + 1) / 2π` times its cosine to the power of `n`.
pub(crate) fn lobe_direction(axis: Vec3, exponent: f32, sample: Vec2) -> Vec3 {
    let cosine = (1.0 - sample.x).powf(1.0 / (exponent + 1.0));
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (x, y) = axis.any_orthonormal_pair();
    let around = Vec2::from_angle(TAU * sample.y) * sine;
    x * around.x + y * around.y + axis * cosine
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::Points;

    /// The mean of a function over 2¹² points of the square.
    fn mean(of: impl Fn(Vec2) -> f32) -> f64 {
        let points = Points::new(3);
        (0..4096).map(|index| f64::from(of(points.point(index, 0)))).sum::<f64>() / 4096.0
    }

    #[test]
    fn shapes_face_where_they_should_and_have_their_size() {
        let facing = Vec3::new(0.6, 0.0, -0.8);
        let flat = |shape: LightShape, facing| {
            let Some(Extent::Flat(flat)) = Extent::new(&shape, facing, Vec3::Z) else { panic!("a flat shape") };
            flat
        };
        let rectangle = flat(LightShape::Rectangle { width: 4.0, height: 2.0 }, facing);
        let corner = rectangle.offset(Vec2::ONE);
        assert!(corner.dot(facing).abs() < 1e-6);
        assert!((corner.y.abs() - 2.0).abs() < 1e-6, "the width runs level: {corner}");
        assert!((corner.length() - 5.0_f32.sqrt()).abs() < 1e-6);
        let up = flat(LightShape::Rectangle { width: 4.0, height: 2.0 }, Vec3::Z).offset(Vec2::ONE);
        assert!(up.abs().abs_diff_eq(Vec3::new(2.0, 1.0, 0.0), 1e-6), "along X where it faces up: {up}");
        let disc = flat(LightShape::Disc { radius: 3.0 }, facing);
        assert!((mean(|at| disc.offset(at).length_squared()) - 4.5).abs() < 1e-3, "the mean of r² over a disc is R²/2");
        assert!(mean(|at| disc.offset(at).length()) < 3.0 && mean(|at| disc.offset(at).y).abs() < 1e-3);
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(Extent::new(&LightShape::Disc { radius: bad }, facing, Vec3::Z).is_none());
            assert!(Extent::new(&LightShape::Rectangle { width: 1.0, height: bad }, facing, Vec3::Z).is_none());
            assert!(Extent::new(&LightShape::Sphere { radius: bad }, facing, Vec3::Z).is_none());
        }
    }

    #[test]
    fn the_cosine_over_a_sphere_is_that_of_its_middle() {
        for sine in [1e-4_f32, 0.3, 0.9] {
            let axis = Vec3::new(0.2, -0.3, 1.0).normalize();
            let normal = Vec3::new(0.1, 0.1, 1.0).normalize();
            let found = mean(|at| {
                let cone = cone(axis, sine, at);
                cone.weight * cone.towards.dot(normal)
            });
            // At a sine of 0.9 a part is below this normal's horizon, but the identity holds for signed cosines.
            assert!((found - f64::from(axis.dot(normal))).abs() < 1e-3, "{sine}: {found}");
            let widest = cone(axis, sine, Vec2::new(0.999_999, 0.3));
            assert!((widest.towards.cross(axis).length() - sine).abs() < 1e-4);
        }
    }

    #[test]
    fn directions_have_their_densities() {
        let normal = Vec3::new(1.0, 2.0, 2.0) / 3.0;
        // Under the density cos/π the mean cosine is 2/3; under (n + 1)/2π cosⁿ it is (n + 1)/(n + 2).
        assert!((mean(|at| cosine_direction(normal, at).dot(normal)) - 2.0 / 3.0).abs() < 1e-3);
        for exponent in [0.0_f32, 1.0, 10.0, 500.0] {
            let expected = f64::from((exponent + 1.0) / (exponent + 2.0));
            let found = mean(|at| lobe_direction(normal, exponent, at).dot(normal));
            assert!((found - expected).abs() < 1e-3, "{exponent}: {found}");
        }
    }
}
