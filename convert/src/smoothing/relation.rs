//! Which faces must be smooth with which, read from authored normals vertex by vertex.
//!
//! At most vertices the faces fall into classes of equal normals, and each class's mean is that normal. Masks are not
//! transitive, so a vertex may also have A smooth with B and B with C but not A with C; there each corner's normal is
//! matched against the means of all sets of faces, and a symmetric choice among the matches is searched for.

use std::collections::HashMap;

use glam::DVec3;

use super::MEASURABLE;
use super::surface::{Surface, angle};

/// No class: [`Relation::apart`] says what must not be smooth.
pub(super) const NO_CLASS: u32 = u32::MAX;

/// What masks must bring about.
#[derive(Default)]
pub(super) struct Relation {
    /// For each corner its class, or [`NO_CLASS`]. Faces of different classes at a vertex must not overlap.
    pub(super) classes: Vec<u32>,
    /// For each class, whether its faces are coplanar, so that it matters not which of them are smooth.
    pub(super) flat: Vec<bool>,
    /// Faces that must share a bit, set after set.
    pub(super) sets: Vec<Vec<u32>>,
    /// Further pairs of faces that must not overlap.
    pub(super) apart: Vec<(u32, u32)>,
}

/// Vertices with more faces than this are not searched for sets of faces: it is exponential.
const MOST_FACES: usize = 10;
/// The matching sets of faces that are kept for each corner.
const MOST_OPTIONS: usize = 64;
/// Steps of the search for a symmetric choice.
const MOST_STEPS: usize = 4096;
/// Faces within this angle in radians of a class's normal are coplanar.
const COPLANAR: f64 = 4e-4;

pub(super) fn find(surface: &Surface, triangles: &[[u32; 3]], authored: &[DVec3], tolerance: f64) -> Relation {
    let mut relation = Relation { classes: vec![NO_CLASS; authored.len()], ..Relation::default() };
    let mut unsolved: Vec<usize> = Vec::new();
    for vertex in 0..surface.vertex_count() {
        let corners = surface.corners_at(vertex);
        // Exactly equal normals first: a wider net may take two classes for one whose normals happen to be close.
        let classes = [MEASURABLE, 0.5 * tolerance]
            .into_iter()
            .map(|same| Classes::of(corners, authored, same))
            .find(|classes| classes.give(surface, corners, authored, tolerance));
        match classes {
            Some(classes) => relation.add_classes(&classes, surface, corners, tolerance),
            None => unsolved.push(vertex),
        }
    }

    // Once one vertex has no solution, explicit normals are certain and the classes are a good enough remainder.
    let mut matches = Matches::default();
    let mut hopeless = false;
    let mut ambiguous: Vec<usize> = Vec::new();
    let mut decided: HashMap<(u32, u32), bool> = HashMap::new();
    for &vertex in &unsolved {
        let corners = surface.corners_at(vertex);
        hopeless = hopeless || corners.len() > MOST_FACES || !matches.find(surface, corners, authored, tolerance, true);
        let open = hopeless || matches.options.iter().any(|options| options.len() > 1);
        if open || !relation.solve(&matches, triangles, corners, &mut decided) {
            ambiguous.push(vertex);
        }
    }
    for &vertex in &ambiguous {
        let corners = surface.corners_at(vertex);
        let solved = !hopeless
            && [true, false].into_iter().any(|best| {
                matches.find(surface, corners, authored, tolerance, best)
                    && relation.solve(&matches, triangles, corners, &mut decided)
            });
        if !solved {
            relation.add_classes(&Classes::of(corners, authored, 0.5 * tolerance), surface, corners, tolerance);
        }
    }
    relation
}

impl Relation {
    fn add_classes(&mut self, classes: &Classes, surface: &Surface, corners: &[u32], tolerance: f64) {
        let first = self.flat.len() as u32;
        let coplanar = COPLANAR.min(0.5 * tolerance);
        for (class, leader) in classes.leaders.iter().enumerate() {
            let members = || corners.iter().zip(&classes.of).filter(move |(_, of)| **of == class as u32);
            let flat = *leader == DVec3::ZERO
                || members().all(|(&corner, _)| angle(surface.face_normal(corner), *leader) <= coplanar);
            self.flat.push(flat);
            if !flat && members().nth(1).is_some() {
                self.sets.push(members().map(|(corner, _)| corner / 3).collect());
            }
        }
        for (&corner, class) in corners.iter().zip(&classes.of) {
            self.classes[corner as usize] = first + class;
        }
    }

    /// Whether two faces must (true) or must not (false) overlap for the sake of a vertex other than this one.
    fn known(
        &self,
        triangles: &[[u32; 3]],
        (a, b): (u32, u32),
        vertex: u32,
        decided: &HashMap<(u32, u32), bool>,
    ) -> Option<bool> {
        for (at, shared) in triangles[a as usize].into_iter().enumerate().filter(|(_, index)| *index != vertex) {
            let Some(other) = triangles[b as usize].into_iter().position(|index| index == shared) else { continue };
            let (ours, theirs) = (self.classes[3 * a as usize + at], self.classes[3 * b as usize + other]);
            if ours != NO_CLASS && theirs != NO_CLASS {
                if ours != theirs {
                    return Some(false);
                } else if !self.flat[ours as usize] {
                    return Some(true);
                }
            }
        }
        decided.get(&(a, b)).copied()
    }

    /// Chooses one match for each corner, symmetric and in keeping with what is decided, and adds it; false if none is.
    fn solve(
        &mut self,
        matches: &Matches,
        triangles: &[[u32; 3]],
        corners: &[u32],
        decided: &mut HashMap<(u32, u32), bool>,
    ) -> bool {
        let faces: Vec<u32> = corners.iter().map(|corner| corner / 3).collect();
        let vertex = triangles[faces[0] as usize][corners[0] as usize % 3];
        let mut rows = Rows::default();
        for a in 0..faces.len() {
            for b in a + 1..faces.len() {
                if let Some(smooth) = self.known(triangles, (faces[a], faces[b]), vertex, decided) {
                    rows.set(a, b, smooth);
                }
            }
        }
        let mut order: Vec<usize> = (0..faces.len()).filter(|at| !matches.options[*at].is_empty()).collect();
        order.sort_by_key(|at| matches.options[*at].len());
        let mut steps = 0;
        let Some(rows) = choose(&order, matches, rows, &mut steps) else { return false };

        for a in 0..faces.len() {
            for b in a + 1..faces.len() {
                let smooth = rows.value[a] & (1 << b) != 0;
                decided.insert((faces[a], faces[b]), smooth);
                if !smooth {
                    self.apart.push((faces[a], faces[b]));
                }
            }
        }
        // Cover the smooth pairs by few sets whose members are all smooth with each other.
        let mut covered = [0_u16; MOST_FACES];
        for a in 0..faces.len() {
            for b in a + 1..faces.len() {
                if rows.value[a] & !covered[a] & (1 << b) == 0 {
                    continue;
                }
                let mut members: u16 = 1 << a | 1 << b;
                for c in 0..faces.len() {
                    if rows.value[c] & members == members {
                        members |= 1 << c;
                    }
                }
                let listed = || (0..faces.len()).filter(move |at| members & (1 << at) != 0);
                listed().for_each(|at| covered[at] |= members);
                self.sets.push(listed().map(|at| faces[at]).collect());
            }
        }
        true
    }
}

/// Faces at one vertex grouped by equal authored normals.
struct Classes {
    /// The class of each corner.
    of: Vec<u32>,
    /// The normal of each class, zero for a corner without one.
    leaders: Vec<DVec3>,
}

impl Classes {
    fn of(corners: &[u32], authored: &[DVec3], same: f64) -> Self {
        /// Above this many distinct normals only identical ones are grouped, to stay linear.
        const FEW: usize = 64;
        let mut found = Self { of: Vec::with_capacity(corners.len()), leaders: Vec::new() };
        let mut identical: HashMap<[u64; 3], u32> = HashMap::new();
        for &corner in corners {
            let normal = authored[corner as usize];
            let bits = normal.to_array().map(f64::to_bits);
            let known = if normal == DVec3::ZERO {
                None
            } else if let Some(class) = identical.get(&bits) {
                Some(*class)
            } else if found.leaders.len() <= FEW {
                found.leaders.iter().position(|leader| angle(*leader, normal) <= same).map(|class| class as u32)
            } else {
                None
            };
            let class = known.unwrap_or_else(|| {
                found.leaders.push(normal);
                found.leaders.len() as u32 - 1
            });
            if corners.len() > FEW {
                identical.insert(bits, class);
            }
            found.of.push(class);
        }
        found
    }

    /// Whether the mean of each class's faces is the authored normal of each of its corners.
    fn give(&self, surface: &Surface, corners: &[u32], authored: &[DVec3], tolerance: f64) -> bool {
        let mut sums = vec![DVec3::ZERO; self.leaders.len()];
        for (&corner, class) in corners.iter().zip(&self.of) {
            sums[*class as usize] += surface.face_normal(corner);
        }
        corners.iter().zip(&self.of).all(|(&corner, class)| {
            let wanted = authored[corner as usize];
            wanted == DVec3::ZERO
                || sums[*class as usize].try_normalize().is_some_and(|mean| angle(mean, wanted) <= tolerance)
        })
    }
}

/// For each corner of a vertex the sets of faces (bits) whose mean is its authored normal, its own face in each.
#[derive(Default)]
struct Matches {
    /// Best first; empty for a corner that has no authored normal.
    options: Vec<Vec<u16>>,
    sums: Vec<DVec3>,
    found: Vec<Vec<(f64, u16)>>,
}

impl Matches {
    /// False if some corner has no match. With `best`, only matches about as good as the best of each corner count.
    fn find(&mut self, surface: &Surface, corners: &[u32], authored: &[DVec3], tolerance: f64, best: bool) -> bool {
        self.sums.clear();
        self.sums.push(DVec3::ZERO);
        for &corner in corners {
            for set in 0..self.sums.len() {
                self.sums.push(self.sums[set] + surface.face_normal(corner));
            }
        }
        self.found.iter_mut().for_each(Vec::clear);
        self.found.resize_with(corners.len(), Vec::new);
        for (set, sum) in self.sums.iter().enumerate().skip(1) {
            let Some(mean) = sum.try_normalize() else { continue };
            for (at, &corner) in corners.iter().enumerate().filter(|(at, _)| set & (1 << at) != 0) {
                let off = angle(mean, authored[corner as usize]);
                if off <= tolerance {
                    self.found[at].push((off, set as u16));
                }
            }
        }
        self.options.clear();
        for (found, &corner) in self.found.iter_mut().zip(corners) {
            let free = authored[corner as usize] == DVec3::ZERO;
            if found.is_empty() && !free {
                return false;
            }
            found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let limit = if best { found.first().map_or(0.0, |(off, _)| 1.5 * off + 2e-6) } else { tolerance };
            let near = found.iter().take_while(|(off, _)| *off <= limit).take(MOST_OPTIONS);
            self.options.push(if free { Vec::new() } else { near.map(|(_, set)| *set).collect() });
        }
        true
    }
}

/// The symmetric relation among the faces of a vertex, as far as it is known.
#[derive(Clone, Copy, Default)]
struct Rows {
    /// For each face, with which others the relation is known.
    known: [u16; MOST_FACES],
    /// For each face, with which others it is smooth.
    value: [u16; MOST_FACES],
}

impl Rows {
    fn set(&mut self, a: usize, b: usize, smooth: bool) {
        for (a, b) in [(a, b), (b, a)] {
            self.known[a] |= 1 << b;
            self.value[a] |= u16::from(smooth) << b;
        }
    }
}

/// Depth-first search through the corners in `order`; the depth is at most [`MOST_FACES`].
fn choose(order: &[usize], matches: &Matches, rows: Rows, steps: &mut usize) -> Option<Rows> {
    let Some((&at, rest)) = order.split_first() else { return Some(rows) };
    for option in &matches.options[at] {
        *steps += 1;
        if *steps > MOST_STEPS {
            return None;
        }
        if option & rows.known[at] == rows.value[at] & rows.known[at] {
            let mut next = rows;
            (0..matches.options.len()).filter(|other| *other != at).for_each(|other| {
                next.set(at, other, option & (1 << other) != 0);
            });
            if let Some(found) = choose(rest, matches, next, steps) {
                return Some(found);
            }
        }
    }
    None
}
