//! Shadow volumes: the space behind each caster as a closed surface, counted where it is behind what the camera sees
//! (depth fail: Bilodeau, Songy 1999; Carmack 2000).
//!
//! The surface is a chain: the triangles that face the source, moved away on the other side, and a wall along each edge
//! where the chain ends. Of a mesh that is not closed, triangles that face away take part too, turned round; edges
//! then count as often as the chain ends there. So any mesh gives a closed volume, and holes do not leak.

use std::collections::HashMap;

use aam_scene::Mesh;
use glam::{DVec3, DVec4, Vec3};

/// How triangles hang together: which edges each has, between positions that are equal.
#[derive(Debug)]
pub(crate) struct Topology {
    /// Ends of each edge, as positions in [`Mesh::positions`].
    edges: Vec<[u32; 2]>,
    /// Three for each triangle: the edge, and whether it is run along from its second end to its first.
    sides: Vec<(u32, bool)>,
    is_closed: bool,
}

impl Topology {
    /// Of a mesh whose vertices are at these positions.
    pub(crate) fn of(mesh: &Mesh, positions: &[Vec3]) -> Self {
        let mut welded: HashMap<[u32; 3], u32> = HashMap::new();
        let ids: Vec<u32> = (0..)
            .zip(positions)
            .map(|(index, position)| *welded.entry(position.to_array().map(|c| (c + 0.0).to_bits())).or_insert(index))
            .collect();
        let id = |index: u32| ids.get(index as usize).copied().unwrap_or(0);
        let mut known: HashMap<[u32; 2], u32> = HashMap::new();
        let mut topology = Self { edges: Vec::new(), sides: Vec::new(), is_closed: true };
        let mut sums: Vec<i32> = Vec::new();
        for triangle in mesh.indices.chunks_exact(3) {
            for side in 0..3 {
                let (from, to) = (id(triangle[side]), id(triangle[(side + 1) % 3]));
                let edge = *known.entry([from.min(to), from.max(to)]).or_insert_with(|| {
                    topology.edges.push([from.min(to), from.max(to)]);
                    sums.push(0);
                    topology.edges.len() as u32 - 1
                });
                topology.sides.push((edge, from > to));
                sums[edge as usize] += if from > to { -1 } else { 1 };
            }
        }
        topology.is_closed = sums.iter().all(|sum| *sum == 0);
        topology
    }

    /// The volume's triangles as corners: positions in the mesh's coordinates, w = 1 where they are moved away without
    /// end. `source` is in the mesh's coordinates too: a position with w = 1, or the direction towards it with w = 0.
    pub(crate) fn volume(&self, mesh: &Mesh, positions: &[Vec3], source: DVec4) -> Volume {
        let at = |index: u32| positions.get(index as usize).copied().filter(|p| p.is_finite()).unwrap_or_default();
        let mut volume = Volume::default();
        let mut sums = vec![0_i32; self.edges.len()];
        let from_afar = source.w == 0.0;
        for (triangle, sides) in mesh.indices.chunks_exact(3).zip(self.sides.chunks_exact(3)) {
            let [a, b, c] = [at(triangle[0]), at(triangle[1]), at(triangle[2])];
            let [p, q, r]: [DVec3; 3] = [a, b, c].map(|corner| corner.as_dvec3());
            let facing = (q - p).cross(r - p).dot(source.truncate() - p * source.w);
            let turn = if facing > 0.0 {
                1
            } else if self.is_closed || facing == 0.0 {
                continue;
            } else {
                -1
            };
            let [a, b, c] = if turn > 0 { [a, b, c] } else { [a, c, b] };
            volume.corners.extend([a.extend(0.0), b.extend(0.0), c.extend(0.0)]);
            // From afar all corners meet at infinity, and the far side has no area.
            if !from_afar {
                volume.corners.extend([c.extend(1.0), b.extend(1.0), a.extend(1.0)]);
            }
            for (edge, backwards) in sides {
                sums[*edge as usize] += if *backwards { -turn } else { turn };
            }
        }
        for ([from, to], sum) in self.edges.iter().zip(sums) {
            let [a, b] = if sum > 0 { [at(*from), at(*to)] } else { [at(*to), at(*from)] };
            for _ in 0..sum.abs() {
                volume.silhouette += 1;
                if from_afar {
                    volume.corners.extend([a.extend(0.0), a.extend(1.0), b.extend(0.0)]);
                } else {
                    volume.corners.extend([a.extend(0.0), a.extend(1.0), b.extend(1.0)]);
                    volume.corners.extend([a.extend(0.0), b.extend(1.0), b.extend(0.0)]);
                }
            }
        }
        volume
    }
}

/// A volume as triangles.
#[derive(Debug, Default)]
pub(crate) struct Volume {
    pub corners: Vec<glam::Vec4>,
    /// Edges that walls stand on.
    pub silhouette: u32,
}

#[cfg(test)]
mod tests {
    use glam::Vec4;

    use super::*;

    fn tetrahedron() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
            indices: vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3],
            ..Mesh::default()
        }
    }

    /// Every edge of a closed surface is run along as often one way as the other.
    fn is_closed_surface(corners: &[Vec4]) -> bool {
        let mut sums: HashMap<[[u32; 4]; 2], i32> = HashMap::new();
        let bits = |corner: Vec4| corner.to_array().map(f32::to_bits);
        for triangle in corners.chunks_exact(3) {
            for side in 0..3 {
                let (a, b) = (bits(triangle[side]), bits(triangle[(side + 1) % 3]));
                let (key, way) = if a < b { ([a, b], 1) } else { ([b, a], -1) };
                *sums.entry(key).or_default() += way;
            }
        }
        sums.values().all(|sum| *sum == 0)
    }

    #[test]
    fn volumes_are_closed_whatever_the_mesh() {
        let solid = tetrahedron();
        let mut open = solid.clone();
        open.indices.truncate(9);
        let mut single = solid.clone();
        single.indices.truncate(3);
        let mut reversed = solid.clone();
        reversed.indices.chunks_exact_mut(3).for_each(|triangle| triangle.swap(1, 2));
        let mut doubled = solid.clone();
        doubled.indices.extend_from_within(..3);
        for mesh in [solid, open, single, reversed, doubled] {
            for source in
                [DVec4::new(3.0, 2.0, 5.0, 1.0), DVec4::new(0.2, 0.2, 0.2, 1.0), DVec4::new(-2.0, 0.4, -9.0, 1.0)]
            {
                let volume = Topology::of(&mesh, &mesh.positions).volume(&mesh, &mesh.positions, source);
                assert!(is_closed_surface(&volume.corners), "{source}");
            }
        }
    }

    #[test]
    fn silhouettes_of_closed_meshes_have_each_edge_once() {
        let mesh = tetrahedron();
        let topology = Topology::of(&mesh, &mesh.positions);
        assert!(topology.is_closed);
        // One face is seen: its three edges are the silhouette.
        let volume = topology.volume(&mesh, &mesh.positions, DVec4::new(5.0, 5.0, 5.0, 1.0));
        assert_eq!((volume.silhouette, volume.corners.len()), (3, 3 * 2 + 3 * 6));
        // From infinity the far side is a point.
        let volume = topology.volume(&mesh, &mesh.positions, DVec4::new(1.0, 1.0, 1.0, 0.0));
        assert_eq!((volume.silhouette, volume.corners.len()), (3, 3 + 3 * 3));
        // A single triangle casts from both sides.
        let mut single = mesh;
        single.indices.truncate(3);
        let topology = Topology::of(&single, &single.positions);
        assert!(!topology.is_closed);
        for z in [-1.0, 1.0] {
            let volume = topology.volume(&single, &single.positions, DVec4::new(0.2, 0.2, z, 1.0));
            assert_eq!(volume.silhouette, 3);
        }
    }
}
