//! Axis-aligned boxes.

use glam::{Affine3A, Vec3};
use serde::Serialize;

/// An axis-aligned box around at least one point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bounds {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Bounds {
    /// The box around points; points that are not finite are left out, and `None` means that none remained.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Option<Self> {
        points.into_iter().filter(|point| point.is_finite()).fold(None, |bounds: Option<Self>, point| {
            Some(bounds.map_or(Self { min: point, max: point }, |bounds| Self {
                min: bounds.min.min(point),
                max: bounds.max.max(point),
            }))
        })
    }

    /// The box around two boxes.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The middle.
    pub fn center(self) -> Vec3 {
        self.min + 0.5 * (self.max - self.min)
    }

    /// The box around this box's eight corners after a transform; `None` if they leave the range of numbers.
    pub fn transformed(self, transform: &Affine3A) -> Option<Self> {
        let corners = (0..8).map(|corner| {
            let pick = |bit: usize| {
                let side = if corner >> bit & 1 == 0 { self.min } else { self.max };
                side[bit]
            };
            transform.transform_point3(Vec3::new(pick(0), pick(1), pick(2)))
        });
        Self::of(corners)
    }
}
