//! Bits for faces, so that those overlap that must and none that must not.
//!
//! Sets of faces that must share a bit and touch form a region. A region without inner edges to keep hard gets one bit
//! as a whole, the lowest that nothing next to it has, the largest region first: the colouring of a map. In other
//! regions the sets are covered one by one, each by a bit that then spreads to sets nearby as far as it may.

use super::relation::{NO_CLASS, Relation};
use super::surface::Surface;

/// A 32-bit mask for each face. Where bits run out, pairs that must be smooth go without; none that must not overlap do.
pub(super) fn color(surface: &Surface, triangles: &[[u32; 3]], relation: &Relation) -> Vec<u32> {
    let mut coloring = Coloring::new(surface, triangles, relation);
    let regions = Regions::new(triangles.len(), relation);
    let mut sets = None;
    for region in &regions.regions {
        match coloring.whole_region(region, &regions.root) {
            Some(bit) => region.faces.iter().for_each(|face| coloring.add(*face, bit)),
            None => {
                let sets = sets.get_or_insert_with(|| SetsOfFaces::new(triangles.len(), relation));
                region.sets.iter().for_each(|set| coloring.cover(*set, sets));
            }
        }
    }
    coloring.masks
}

struct Coloring<'a> {
    triangles: &'a [[u32; 3]],
    relation: &'a Relation,
    masks: Vec<u32>,
    /// The bits in use in each class, and at each vertex in any class: a face may not take those of another class.
    of_class: Vec<u32>,
    at_vertex: Vec<u32>,
    /// [`Relation::apart`] both ways, face by face.
    apart_starts: Vec<u32>,
    apart: Vec<u32>,
    /// The class that the region under test has at each vertex, and which region that was.
    seen: Vec<(u32, u32)>,
}

impl<'a> Coloring<'a> {
    fn new(surface: &Surface, triangles: &'a [[u32; 3]], relation: &'a Relation) -> Self {
        let both = || relation.apart.iter().flat_map(|&(a, b)| [(a, b), (b, a)]);
        let mut apart_starts = vec![0_u32; triangles.len() + 1];
        both().for_each(|(face, _)| apart_starts[face as usize + 1] += 1);
        for face in 0..triangles.len() {
            apart_starts[face + 1] += apart_starts[face];
        }
        let mut next = apart_starts.clone();
        let mut apart = vec![0; 2 * relation.apart.len()];
        for (face, other) in both() {
            apart[next[face as usize] as usize] = other;
            next[face as usize] += 1;
        }
        Self {
            triangles,
            relation,
            masks: vec![0; triangles.len()],
            of_class: vec![0; relation.flat.len()],
            at_vertex: vec![0; surface.vertex_count()],
            apart_starts,
            apart,
            seen: vec![(NO_CLASS, NO_CLASS); surface.vertex_count()],
        }
    }

    /// Vertex and class of a face's corners, where it has a class.
    fn classes(&self, face: u32) -> impl Iterator<Item = (usize, u32)> + use<'a> {
        let classes = &self.relation.classes[3 * face as usize..3 * face as usize + 3];
        let vertices = self.triangles[face as usize];
        (0..3).filter(|at| classes[*at] != NO_CLASS).map(move |at| (vertices[at] as usize, classes[at]))
    }

    fn apart(&self, face: u32) -> &[u32] {
        &self.apart[self.apart_starts[face as usize] as usize..self.apart_starts[face as usize + 1] as usize]
    }

    /// The bits of all faces that this one must not overlap.
    fn forbidden(&self, face: u32) -> u32 {
        let by_class = self
            .classes(face)
            .fold(0, |bits, (vertex, class)| bits | (self.at_vertex[vertex] & !self.of_class[class as usize]));
        self.apart(face).iter().fold(by_class, |bits, other| bits | self.masks[*other as usize])
    }

    fn add(&mut self, face: u32, bit: u32) {
        self.masks[face as usize] |= bit;
        for (vertex, class) in self.classes(face) {
            self.of_class[class as usize] |= bit;
            self.at_vertex[vertex] |= bit;
        }
    }

    /// The bit that a whole region may have: `None` if two of its faces must not overlap, or no bit is left.
    fn whole_region(&mut self, region: &Region, root: &[u32]) -> Option<u32> {
        let id = root[region.faces[0] as usize];
        let mut free = u32::MAX;
        for &face in &region.faces {
            free &= !self.forbidden(face);
            if free == 0 || self.apart(face).iter().any(|other| root[*other as usize] == id) {
                return None;
            }
            for (vertex, class) in self.classes(face) {
                let (region, known) = self.seen[vertex];
                if region != id {
                    self.seen[vertex] = (id, class);
                } else if known != class {
                    return None;
                }
            }
        }
        lowest(free)
    }

    /// Gives the faces of a set a common bit, or its pairs one each where no bit serves all. The bit then spreads to
    /// sets nearby as far as it can, so that few bits cover much.
    fn cover(&mut self, set: u32, sets: &SetsOfFaces) {
        /// Sets above this are not taken apart into pairs.
        const PAIRS_OF: usize = 16;
        let relation = self.relation;
        let faces = &relation.sets[set as usize];
        if self.common(faces) != 0 {
            return;
        }
        if let Some(bit) = self.best_bit(faces) {
            let mut grown = vec![set];
            while let Some(set) = grown.pop() {
                for &face in &relation.sets[set as usize] {
                    if self.masks[face as usize] & bit != 0 {
                        continue;
                    }
                    // Two faces of a set that must not overlap elsewhere: the first has it.
                    if self.forbidden(face) & bit == 0 {
                        self.add(face, bit);
                        for &near in sets.of(face) {
                            let faces = &relation.sets[near as usize];
                            if self.common(faces) == 0 && faces.iter().all(|face| self.forbidden(*face) & bit == 0) {
                                grown.push(near);
                            }
                        }
                    }
                }
            }
        } else if faces.len() <= PAIRS_OF {
            for (at, a) in faces.iter().enumerate() {
                for b in &faces[at + 1..] {
                    let pair = [*a, *b];
                    if let (0, Some(bit)) = (self.common(&pair), self.best_bit(&pair)) {
                        self.add(*a, bit);
                        if self.forbidden(*b) & bit == 0 {
                            self.add(*b, bit);
                        }
                    }
                }
            }
        }
    }

    /// The bits that all faces have.
    fn common(&self, faces: &[u32]) -> u32 {
        faces.iter().fold(u32::MAX, |bits, face| bits & self.masks[*face as usize])
    }

    /// Of the bits that all faces may have, the one that most have already, else the lowest.
    fn best_bit(&self, faces: &[u32]) -> Option<u32> {
        let free = faces.iter().fold(u32::MAX, |bits, face| bits & !self.forbidden(*face));
        let held = |bit: u32| faces.iter().filter(|face| self.masks[**face as usize] & bit != 0).count();
        (0..32).rev().map(|at| 1_u32 << at).filter(|bit| free & bit != 0).max_by_key(|bit| held(*bit))
    }
}

/// The sets that each face is in.
struct SetsOfFaces {
    starts: Vec<u32>,
    sets: Vec<u32>,
}

impl SetsOfFaces {
    fn new(faces: usize, relation: &Relation) -> Self {
        let mut starts = vec![0_u32; faces + 1];
        relation.sets.iter().flatten().for_each(|face| starts[*face as usize + 1] += 1);
        for face in 0..faces {
            starts[face + 1] += starts[face];
        }
        let mut next = starts.clone();
        let mut sets = vec![0; starts[faces] as usize];
        for (index, set) in relation.sets.iter().enumerate() {
            for face in set {
                sets[next[*face as usize] as usize] = index as u32;
                next[*face as usize] += 1;
            }
        }
        Self { starts, sets }
    }

    fn of(&self, face: u32) -> &[u32] {
        &self.sets[self.starts[face as usize] as usize..self.starts[face as usize + 1] as usize]
    }
}

fn lowest(bits: u32) -> Option<u32> {
    (bits != 0).then(|| bits & bits.wrapping_neg())
}

/// Faces that sets join, directly or through others.
struct Region {
    faces: Vec<u32>,
    /// Positions in [`Relation::sets`].
    sets: Vec<u32>,
}

struct Regions {
    /// Largest first.
    regions: Vec<Region>,
    /// The region of each face, as the number of one of its faces.
    root: Vec<u32>,
}

impl Regions {
    fn new(faces: usize, relation: &Relation) -> Self {
        let mut root: Vec<u32> = (0..faces as u32).collect();
        for set in &relation.sets {
            for pair in set.windows(2) {
                let (a, b) = (find(&mut root, pair[0]), find(&mut root, pair[1]));
                root[a.max(b) as usize] = a.min(b);
            }
        }
        for face in 0..faces as u32 {
            root[face as usize] = find(&mut root, face);
        }
        let mut number = vec![u32::MAX; faces];
        let mut regions: Vec<Region> = Vec::new();
        for (index, set) in relation.sets.iter().enumerate() {
            let slot = &mut number[root[set[0] as usize] as usize];
            if *slot == u32::MAX {
                *slot = regions.len() as u32;
                regions.push(Region { faces: Vec::new(), sets: Vec::new() });
            }
            regions[*slot as usize].sets.push(index as u32);
        }
        for (face, root) in root.iter().enumerate() {
            if let Some(region) = regions.get_mut(number[*root as usize] as usize) {
                region.faces.push(face as u32);
            }
        }
        regions.sort_by_key(|region| (std::cmp::Reverse(region.faces.len()), region.faces[0]));
        Self { regions, root }
    }
}

fn find(root: &mut [u32], mut face: u32) -> u32 {
    while root[face as usize] != face {
        root[face as usize] = root[root[face as usize] as usize];
        face = root[face as usize];
    }
    face
}
