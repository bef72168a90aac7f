//! Smoothing masks as OBJ's numbers.

use std::collections::BTreeMap;

use aam::document::Faces;
use aam::meaning::SmoothingRule;

/// An `s` number for each triangle.
pub(super) struct Numbers {
    /// 0 is off.
    pub(super) numbers: Vec<u32>,
    /// Whether equal numbers say the same as the document's smoothing.
    pub(super) exact: bool,
}

pub(super) fn numbers(faces: &Faces, vertices: usize, rule: SmoothingRule) -> Numbers {
    let masks = || faces.triangles.iter().map(|triangle| triangle.smoothing.cast_unsigned());
    match rule {
        SmoothingRule::Flat => Numbers { numbers: vec![0; faces.triangles.len()], exact: true },
        SmoothingRule::Numbers => Numbers { numbers: masks().collect(), exact: true },
        SmoothingRule::Masks if masks().all(|mask| mask.count_ones() <= 1) => {
            Numbers { numbers: masks().map(lowest).collect(), exact: true }
        }
        SmoothingRule::Masks => overlapping(faces, vertices),
    }
}

/// 1 for the lowest bit, 0 for none.
fn lowest(mask: u32) -> u32 {
    if mask == 0 { 0 } else { mask.trailing_zeros() + 1 }
}

/// Faces that are smooth with each other, directly or through others, get one number. That is exact if of all faces at a
/// vertex those of one number overlap.
fn overlapping(faces: &Faces, vertices: usize) -> Numbers {
    // Faces by vertex; those of equal masks do as one.
    let mut at: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * faces.triangles.len());
    for (face, triangle) in faces.triangles.iter().enumerate() {
        let mask = triangle.smoothing.cast_unsigned();
        for vertex in triangle.vertices.into_iter().filter(|vertex| mask != 0 && (*vertex as usize) < vertices) {
            at.push((vertex, mask, face as u32));
        }
    }
    at.sort_unstable();
    let mut root: Vec<u32> = (0..faces.triangles.len() as u32).collect();
    let smooth_pairs = |join: &mut dyn FnMut(u32, u32, bool)| {
        for corners in at.chunk_by(|a, b| a.0 == b.0) {
            let groups: Vec<&[(u32, u32, u32)]> = corners.chunk_by(|a, b| a.1 == b.1).collect();
            for (index, group) in groups.iter().enumerate() {
                group.iter().for_each(|corner| join(group[0].2, corner.2, true));
                // Beyond this many masks at a vertex, what is not looked at counts as not smooth.
                for other in groups[index + 1..].iter().take(64) {
                    join(group[0].2, other[0].2, group[0].1 & other[0].1 != 0);
                }
            }
        }
    };
    smooth_pairs(&mut |a, b, smooth| {
        let (a, b) = (find(&mut root, a), find(&mut root, b));
        if smooth {
            root[a.max(b) as usize] = a.min(b);
        }
    });
    let mut exact = true;
    smooth_pairs(&mut |a, b, smooth| exact &= smooth || find(&mut root, a) != find(&mut root, b));
    if !exact {
        // No numbers say it; the lowest bit is as good as any.
        let numbers = faces.triangles.iter().map(|triangle| lowest(triangle.smoothing.cast_unsigned())).collect();
        return Numbers { numbers, exact };
    }
    let mut known: BTreeMap<u32, u32> = BTreeMap::new();
    let numbers = (0..faces.triangles.len() as u32)
        .map(|face| {
            if faces.triangles[face as usize].smoothing == 0 {
                return 0;
            }
            let next = known.len() as u32 + 1;
            *known.entry(find(&mut root, face)).or_insert(next)
        })
        .collect();
    Numbers { numbers, exact }
}

fn find(root: &mut [u32], mut face: u32) -> u32 {
    while root[face as usize] != face {
        root[face as usize] = root[root[face as usize] as usize];
        face = root[face as usize];
    }
    face
}

#[cfg(test)]
mod tests {
    use super::*;
    use aam::document::Triangle;

    /// A fan around vertex 0: each triangle touches the next along an edge, and all meet at 0.
    fn fan(masks: &[i32]) -> Faces {
        let triangle = |(index, mask): (usize, &i32)| Triangle {
            vertices: [0, index as u32 + 1, index as u32 + 2],
            smoothing: *mask,
        };
        Faces { triangles: masks.iter().enumerate().map(triangle).collect(), ..Faces::default() }
    }

    fn of(masks: &[i32]) -> (Vec<u32>, bool) {
        let Numbers { numbers, exact } = numbers(&fan(masks), 20, SmoothingRule::Masks);
        (numbers, exact)
    }

    #[test]
    fn single_bits_keep_their_numbers() {
        assert_eq!(of(&[1, 4, 0, i32::MIN]), (vec![1, 3, 0, 32], true));
    }

    #[test]
    fn overlaps_that_are_transitive_become_numbers() {
        assert_eq!(of(&[3, 1, 3, 8, 0, 24]), (vec![1, 1, 1, 2, 0, 2], true));
        // Not overlapping, but never at one vertex either.
        let mut faces = fan(&[1, 3, 2]);
        faces.triangles[2].vertices = [9, 10, 3];
        faces.triangles[0].vertices = [0, 1, 2];
        faces.triangles[1].vertices = [2, 3, 8];
        let Numbers { numbers, exact } = numbers(&faces, 20, SmoothingRule::Masks);
        assert_eq!((numbers, exact), (vec![1, 1, 1], true));
    }

    #[test]
    fn overlaps_that_are_not_transitive() {
        assert_eq!(of(&[1, 3, 2]), (vec![1, 1, 2], false));
    }

    #[test]
    fn other_rules() {
        let faces = fan(&[7, 7, -1]);
        assert_eq!(numbers(&faces, 20, SmoothingRule::Numbers).numbers, [7, 7, u32::MAX]);
        assert_eq!(numbers(&faces, 20, SmoothingRule::Flat).numbers, [0; 3]);
    }
}
