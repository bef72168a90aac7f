//! Joins parts whose common hull is still good enough.

use glam::DVec3;
use rayon::prelude::*;

use super::field::Field;
use super::mesh::Mesh;
use super::quickhull::Polyhedron;
use super::split::{Excess, FINE, Part, Parts, look};

/// The most times that the worst group is cut again.
const ROUNDS: usize = 12;
/// What the worst group must become better by for another round.
const GAIN: f64 = 0.99;
/// Parts that are farther apart than this (of a box of longest side 1) are joined only if they must.
const APART: f64 = 1e-2;

/// A set of parts with one hull.
#[derive(Clone)]
pub(super) struct Group {
    pub(super) parts: Vec<usize>,
    pub(super) hull: Polyhedron,
    pub(super) excess: Excess,
}

struct Join {
    a: usize,
    b: usize,
    hull: Polyhedron,
    excess: Excess,
    cost: f64,
}

fn joined(groups: &[Option<Group>], (a, b): (usize, usize), field: &Field) -> Option<Join> {
    let (first, second) = (groups[a].as_ref()?, groups[b].as_ref()?);
    let points: Vec<DVec3> = first.hull.vertices.iter().chain(&second.hull.vertices).copied().collect();
    let (hull, excess) = look(&points, field, FINE);
    let hull = hull?;
    let added = (excess.sum - first.excess.sum - second.excess.sum).max(0.0);
    Some(Join { a, b, hull, excess, cost: excess.most + added })
}

fn touch(a: &Polyhedron, b: &Polyhedron, margin: f64) -> bool {
    let ((a_low, a_high), (b_low, b_high)) = (a.bounds(), b.bounds());
    (a_low - margin).cmple(b_high).all() && (b_low - margin).cmple(a_high).all()
}

/// Joins two at a time, those first whose common hull is best: all that stay within `limit`, and more until there are no
/// more than `most`.
pub(super) fn merge(groups: Vec<Group>, field: &Field, limit: f64, most: usize) -> Vec<Group> {
    let mut groups: Vec<Option<Group>> = groups.into_iter().map(Some).collect();
    let mut count = groups.len();
    let mut margin = APART;
    let pairs = |groups: &[Option<Group>], margin: f64, a: usize| -> Vec<(usize, usize)> {
        let Some(group) = &groups[a] else { return Vec::new() };
        let near = |b: &usize| groups[*b].as_ref().is_some_and(|other| touch(&group.hull, &other.hull, margin));
        (0..a).filter(near).map(|b| (b, a)).collect()
    };
    let all = |groups: &[Option<Group>], margin: f64| -> Vec<Join> {
        let pairs: Vec<(usize, usize)> = (0..groups.len()).flat_map(|a| pairs(groups, margin, a)).collect();
        pairs.into_par_iter().filter_map(|pair| joined(groups, pair, field)).collect()
    };
    let mut joins = all(&groups, margin);
    loop {
        let best = joins.iter().enumerate().min_by(|(_, a), (_, b)| a.cost.total_cmp(&b.cost)).map(|(at, _)| at);
        let within = |join: &Join| join.excess.most <= limit || count > most;
        let fitting = || {
            let within = joins.iter().enumerate().filter(|(_, join)| within(join));
            within.min_by(|(_, a), (_, b)| a.cost.total_cmp(&b.cost)).map(|(at, _)| at)
        };
        let Some(at) = best.filter(|at| within(&joins[*at])).or_else(fitting) else {
            if count > most && margin < 4.0 {
                margin *= 8.0;
                joins = all(&groups, margin);
                continue;
            }
            return groups.into_iter().flatten().collect();
        };
        let Join { a, b, hull, excess, .. } = joins.swap_remove(at);
        let mut parts = Vec::new();
        for index in [a, b] {
            parts.extend(groups[index].take().map(|group| group.parts).unwrap_or_default());
        }
        joins.retain(|join| ![a, b].contains(&join.a) && ![a, b].contains(&join.b));
        groups.push(Some(Group { parts, hull, excess }));
        count -= 1;
        let fresh = pairs(&groups, margin, groups.len() - 1);
        joins.par_extend(fresh.into_par_iter().filter_map(|pair| joined(&groups, pair, field)));
    }
}

/// Where there are no more groups allowed: cuts the worst one anew, and joins what then costs least, as long as the worst
/// becomes better. Gives the groups, and the parts that came of it, whose numbers follow those of `parts`.
pub(super) fn refine(parts: &Parts, mut groups: Vec<Group>, field: &Field, most: usize) -> (Vec<Group>, Vec<Part>) {
    let mut halves: Vec<Part> = Vec::new();
    let error = |groups: &[Group]| groups.iter().map(|group| group.excess.most).fold(0.0, f64::max);
    if most == 1 || groups.len() < most {
        return (groups, halves);
    }
    for _ in 0..ROUNDS {
        let before = error(&groups);
        let Some(worst) =
            (0..groups.len()).rev().max_by(|a, b| groups[*a].excess.most.total_cmp(&groups[*b].excess.most))
        else {
            break;
        };
        let mut mesh = Mesh::default();
        for index in &groups[worst].parts {
            mesh.append(&parts.0.get(*index).unwrap_or_else(|| &halves[index - parts.0.len()]).mesh);
        }
        let Some(pair) = Part::new(mesh, field).halves(field) else { break };
        let mut trial = groups.clone();
        trial.swap_remove(worst);
        let first = parts.0.len() + halves.len();
        for (index, part) in pair.iter().enumerate() {
            if let Some(hull) = part.hull.clone() {
                trial.push(Group { parts: vec![first + index], hull, excess: part.excess });
            }
        }
        halves.extend(pair);
        let trial = merge(trial, field, 0.0, most);
        if error(&trial) > GAIN * before {
            break;
        }
        groups = trial;
    }
    (groups, halves)
}
