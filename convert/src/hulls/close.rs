//! What an open mesh is made of before it is cut: its components, and the holes of a scan that are closed.

use std::collections::BTreeMap;

use glam::DVec3;

use super::mesh::Mesh;

/// A hole is closed if its area is no more than this part of its component's. A scan misses less than that; the mouth of
/// a bowl or pipe is more.
const HOLE: f64 = 0.01;

impl Mesh {
    /// Edges that only one triangle has, in its direction.
    fn boundary(&self) -> Vec<(u32, u32)> {
        let mut edges: Vec<(u32, u32)> =
            self.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        edges.sort_unstable();
        let alone = |&(a, b): &(u32, u32)| edges.binary_search(&(b, a)).is_err();
        edges.iter().copied().filter(alone).collect()
    }

    /// Closes small holes with fans; whether larger ones stay.
    pub(super) fn close_holes(&mut self) -> bool {
        let boundary = self.boundary();
        if boundary.is_empty() {
            return false;
        }
        let labels = self.labels();
        let mut areas: BTreeMap<u32, f64> = BTreeMap::new();
        for triangle in &self.triangles {
            let [a, b, c] = self.corners(*triangle);
            *areas.entry(labels[triangle[0] as usize]).or_default() += 0.5 * (b - a).cross(c - a).length();
        }
        // The way on from a vertex; where two holes meet in one, neither is closed.
        let mut next: BTreeMap<u32, u32> = BTreeMap::new();
        let mut double = Vec::new();
        for (from, to) in &boundary {
            if next.insert(*from, *to).is_some() {
                double.push(*from);
            }
        }
        for vertex in double {
            next.remove(&vertex);
        }
        let mut closed = 0;
        while let Some((&start, _)) = next.first_key_value() {
            let mut ring = vec![start];
            while let Some(to) = next.remove(ring.last().unwrap_or(&start)) {
                if to == start {
                    closed += self.cap(&ring, areas.get(&labels[start as usize]).copied().unwrap_or(0.0));
                    break;
                }
                ring.push(to);
            }
        }
        closed < boundary.len()
    }

    /// Closes one hole if it is small; how many edges that closes.
    fn cap(&mut self, ring: &[u32], component: f64) -> usize {
        let middle = ring.iter().map(|index| self.vertices[*index as usize]).sum::<DVec3>() / ring.len() as f64;
        let edges = || ring.iter().copied().zip(ring.iter().copied().cycle().skip(1));
        let area = |(a, b): (u32, u32)| {
            0.5 * (self.vertices[a as usize] - middle).cross(self.vertices[b as usize] - middle).length()
        };
        if ring.len() < 3 || edges().map(area).sum::<f64>() > HOLE * component {
            return 0;
        }
        let center = self.vertices.len() as u32;
        self.vertices.push(middle);
        self.triangles.extend(edges().map(|(a, b)| [b, a, center]));
        ring.len()
    }

    /// For each vertex the least vertex that edges join it with.
    fn labels(&self) -> Vec<u32> {
        fn root(labels: &mut [u32], mut at: u32) -> u32 {
            while labels[at as usize] != at {
                labels[at as usize] = labels[labels[at as usize] as usize];
                at = labels[at as usize];
            }
            at
        }
        let mut labels: Vec<u32> = (0..self.vertices.len() as u32).collect();
        for &[a, b, c] in &self.triangles {
            for other in [b, c] {
                let (from, to) = (root(&mut labels, a), root(&mut labels, other));
                labels[from.max(to) as usize] = from.min(to);
            }
        }
        (0..labels.len() as u32).map(|at| root(&mut labels, at)).collect()
    }

    /// The parts that no edge joins, if there are from 2 to `most`.
    pub(super) fn components(&self, most: usize) -> Option<Vec<Self>> {
        let labels = self.labels();
        let mut found: BTreeMap<u32, (Self, BTreeMap<u32, u32>)> = BTreeMap::new();
        for triangle in &self.triangles {
            let (component, numbers) = found.entry(labels[triangle[0] as usize]).or_default();
            let triangle = triangle.map(|index| {
                *numbers.entry(index).or_insert_with(|| {
                    component.vertices.push(self.vertices[index as usize]);
                    component.vertices.len() as u32 - 1
                })
            });
            component.triangles.push(triangle);
            if found.len() > most {
                return None;
            }
        }
        (found.len() > 1).then(|| found.into_values().map(|(component, _)| component).collect())
    }
}
