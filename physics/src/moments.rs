//! Volume, centre and inertia of solid shapes.

use glam::{DAffine3, DMat3, DVec3};

/// The integrals over a solid that its mass, centre of mass and inertia follow from, at density 1.
///
/// They carry over exactly through any linear map, shear and reflection included, which is why shapes are measured before
/// they are scaled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// ∫ dV, not negative.
    pub volume: f64,
    /// ∫ x dV.
    pub first: DVec3,
    /// ∫ x xᵀ dV.
    pub second: DMat3,
}

impl Moments {
    /// Those of nothing.
    pub const ZERO: Self = Self { volume: 0.0, first: DVec3::ZERO, second: DMat3::ZERO };

    /// A closed surface of triangles, counter-clockwise seen from outside.
    pub fn of_surface(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        // Tetrahedra from a point amid the surface keep the digits that far coordinates would cost.
        let origin = vertices.iter().sum::<DVec3>() / vertices.len().max(1) as f64;
        let mut moments = Self::ZERO;
        for triangle in triangles {
            let [a, b, c] = triangle.map(|index| vertices[index as usize] - origin);
            let six_volumes = a.dot(b.cross(c));
            let sum = a + b + c;
            moments.volume += six_volumes / 6.0;
            moments.first += sum * (six_volumes / 24.0);
            let squares = [a, b, c, sum].map(outer).into_iter().fold(DMat3::ZERO, |all, square| all + square);
            moments.second += squares * (six_volumes / 120.0);
        }
        moments.transformed(&DAffine3::from_translation(origin))
    }

    /// A box of half extents around the origin.
    pub fn of_box(half: DVec3) -> Self {
        let volume = 8.0 * half.x * half.y * half.z;
        Self { volume, first: DVec3::ZERO, second: DMat3::from_diagonal(half * half * (volume / 3.0)) }
    }

    /// A ball around the origin.
    pub fn of_ball(radius: f64) -> Self {
        let volume = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        Self { volume, first: DVec3::ZERO, second: DMat3::IDENTITY * (volume * radius * radius / 5.0) }
    }

    /// A capsule around the origin: the points within `radius` of the segment of `half` to both sides along y.
    pub fn of_capsule(half: f64, radius: f64) -> Self {
        let (area, square) = (std::f64::consts::PI * radius * radius, radius * radius);
        let (cylinder, ball) = (2.0 * half * area, Self::of_ball(radius));
        let across = cylinder * square / 4.0 + ball.second.x_axis.x;
        // The half balls' own centres lie 3/8 of the radius beyond the ends.
        let along = cylinder * half * half / 3.0 + ball.volume * (square / 5.0 + half * half + 0.75 * half * radius);
        Self {
            volume: cylinder + ball.volume,
            first: DVec3::ZERO,
            second: DMat3::from_diagonal(DVec3::new(across, along, across)),
        }
    }

    /// Those of the transformed solid. Volume stays positive under reflections.
    #[must_use]
    pub fn transformed(&self, map: &DAffine3) -> Self {
        let size = map.matrix3.determinant().abs();
        let first = map.matrix3 * self.first;
        let second = map.matrix3 * self.second * map.matrix3.transpose();
        let shift = map.translation;
        let mixed = DMat3::from_cols(first * shift.x, first * shift.y, first * shift.z);
        Self {
            volume: size * self.volume,
            first: size * (first + shift * self.volume),
            second: (second + mixed + mixed.transpose() + outer(shift) * self.volume) * size,
        }
    }

    /// Those of both together. What they share counts twice.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self { volume: self.volume + other.volume, first: self.first + other.first, second: self.second + other.second }
    }

    /// The centre of mass; the origin for what has no volume.
    pub fn center(&self) -> DVec3 {
        if self.volume > 0.0 { self.first / self.volume } else { DVec3::ZERO }
    }

    /// The inertia tensor about the centre, for this mass spread evenly. Zero for what has no volume.
    pub fn inertia(&self, mass: f64) -> DMat3 {
        let valid = self.volume > 0.0;
        let central = (self.second * self.volume.recip() - outer(self.center())) * if valid { mass } else { 0.0 };
        if !valid {
            return DMat3::ZERO;
        }
        let trace = central.x_axis.x + central.y_axis.y + central.z_axis.z;
        DMat3::from_diagonal(DVec3::splat(trace)) - central
    }
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    fn close(a: DMat3, b: DMat3) {
        let scale = b.to_cols_array().into_iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        assert!((a - b).to_cols_array().into_iter().all(|v| v.abs() < 1e-9 * scale), "{a} against {b}");
    }

    fn cube(center: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let corner = |i: u32| center + DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) - 0.5;
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        ((0..8).map(corner).collect(), quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
    }

    #[test]
    fn a_cube_far_away_has_the_inertia_of_a_cube() {
        let center = DVec3::new(1000.0, -2000.0, 500.0);
        let (vertices, triangles) = cube(center);
        let moments = Moments::of_surface(&vertices, &triangles);
        assert!((moments.volume - 1.0).abs() < 1e-12 && moments.center().distance(center) < 1e-9);
        let inertia = moments.inertia(6.0);
        assert!((inertia - DMat3::IDENTITY).to_cols_array().into_iter().all(|v| v.abs() < 1e-6), "{inertia}");
    }

    #[test]
    fn solids_have_the_textbook_inertia() {
        let ball = Moments::of_ball(2.0);
        close(ball.inertia(5.0), DMat3::IDENTITY * (0.4 * 5.0 * 4.0));
        let boxed = Moments::of_box(DVec3::new(1.0, 2.0, 3.0));
        close(boxed.inertia(3.0), DMat3::from_diagonal(DVec3::new(4.0 + 9.0, 1.0 + 9.0, 1.0 + 4.0)));
        // A capsule without length is a ball; a long thin one is a rod.
        close(Moments::of_capsule(0.0, 2.0).inertia(5.0), ball.inertia(5.0));
        let rod = Moments::of_capsule(1.0, 1e-4).inertia(3.0);
        assert!((rod.x_axis.x - 1.0).abs() < 1e-3 && rod.y_axis.y < 1e-6, "{rod}");
        // Against an integral by slices.
        let (half, radius, slices) = (0.7, 0.4, 200_000);
        let (mut volume, mut along) = (0.0, 0.0);
        for slice in 0..slices {
            let step = 2.0 * (half + radius) / slices as f64;
            let y = -half - radius + (slice as f64 + 0.5) * step;
            let beyond = (y.abs() - half).max(0.0);
            let area = std::f64::consts::PI * (radius * radius - beyond * beyond);
            volume += area * step;
            along += y * y * area * step;
        }
        let capsule = Moments::of_capsule(half, radius);
        assert!((capsule.volume - volume).abs() < 1e-6 && (capsule.second.y_axis.y - along).abs() < 1e-6);
    }

    #[test]
    fn moments_follow_any_map() {
        let map =
            DAffine3::from_scale_rotation_translation(
                DVec3::new(-2.0, 0.5, 3.0),
                DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.2, 2.0),
                DVec3::new(4.0, -5.0, 6.0),
            ) * DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::new(0.4, 1.0, 0.0), DVec3::new(-0.2, 0.1, 1.0)));
        let (vertices, triangles) = cube(DVec3::new(0.3, 0.2, -0.7));
        let mapped: Vec<DVec3> = vertices.iter().map(|v| map.transform_point3(*v)).collect();
        // The map reflects, so that outside becomes inside.
        let turned: Vec<[u32; 3]> = triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        let direct = Moments::of_surface(&mapped, &turned);
        let carried = Moments::of_surface(&vertices, &triangles).transformed(&map);
        assert!((direct.volume - carried.volume).abs() < 1e-12 && (direct.volume - 3.0).abs() < 1e-9);
        assert!(direct.center().distance(carried.center()) < 1e-12);
        close(direct.inertia(2.0), carried.inertia(2.0));
    }
}
