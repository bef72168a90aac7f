//! Welding: corners that are equal become one vertex.

use std::collections::HashMap;
use std::hash::Hash;

use glam::{Vec2, Vec3, Vec4};

/// A vertex number for each corner, counted from 0 in the order in which keys first occur: whatever the hash, the same
/// corners give the same numbers.
pub(crate) fn weld<K: Eq + Hash>(keys: impl Iterator<Item = K>) -> Vec<u32> {
    // A closed mesh has about as many vertices as a sixth of its corners.
    let mut vertices: HashMap<K, u32> = HashMap::with_capacity(keys.size_hint().0 / 6);
    keys.map(|key| {
        let next = vertices.len() as u32;
        *vertices.entry(key).or_insert(next)
    })
    .collect()
}

/// The first corner of each vertex.
pub(crate) fn first_corners(vertices: &[u32]) -> Vec<u32> {
    let mut first = Vec::new();
    for (corner, &vertex) in vertices.iter().enumerate() {
        if vertex as usize == first.len() {
            first.push(corner as u32);
        }
    }
    first
}

/// The bits of a number, the same for 0 and −0.
fn bits(value: f32) -> u32 {
    (value + 0.0).to_bits()
}

/// The bits of a vector, equal for equal vectors.
pub(crate) trait Bits<const N: usize> {
    fn bits(self) -> [u32; N];
}

impl Bits<2> for Vec2 {
    fn bits(self) -> [u32; 2] {
        self.to_array().map(bits)
    }
}

impl Bits<3> for Vec3 {
    fn bits(self) -> [u32; 3] {
        self.to_array().map(bits)
    }
}

impl Bits<4> for Vec4 {
    fn bits(self) -> [u32; 4] {
        self.to_array().map(bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_keys_are_one_vertex_in_order_of_appearance() {
        let vertices = weld("abcabdda".chars());
        assert_eq!(vertices, [0, 1, 2, 0, 1, 3, 3, 0]);
        assert_eq!(first_corners(&vertices), [0, 1, 2, 5]);
        assert_eq!(first_corners(&[]), []);
    }

    #[test]
    fn both_zeros_are_one_number() {
        assert_eq!(Vec2::new(0.0, 1.0).bits(), Vec2::new(-0.0, 1.0).bits());
        assert_ne!(Vec2::new(0.0, 1.0).bits(), Vec2::new(0.0, -1.0).bits());
    }
}
