//! The node hierarchy: who is whose parent, which nodes are in the scene, and where they are.

use glam::{DAffine3, DVec3};

use super::fault::{Checked, Fault};
use super::model::Model;

/// A point or direction in AAM's axes: (x, y, z) → (x, −z, y). Exact: no number changes but one sign.
pub(super) const fn to_aam(v: DVec3) -> DVec3 {
    // Adding zero turns -0 into 0.
    DVec3::new(v.x + 0.0, -v.z + 0.0, v.y + 0.0)
}

/// The nodes, checked: each has one parent at most, and no node is its own ancestor.
#[derive(Debug)]
pub(super) struct Graph {
    /// The parent of each node.
    pub parents: Vec<Option<usize>>,
    /// All nodes of the file, parents before children.
    pub order: Vec<usize>,
    /// The visible nodes of the scene, parents before children, children in the file's order.
    pub scene: Vec<usize>,
    /// How many nodes of the scene, with their descendants, the file hides.
    pub hidden: usize,
    /// How many nodes the scene lists as roots that have a parent.
    pub false_roots: usize,
}

impl Graph {
    pub(super) fn of(model: &Model) -> Checked<Self> {
        let count = model.nodes.len();
        let mut parents: Vec<Option<usize>> = vec![None; count];
        for (number, node) in model.nodes.iter().enumerate() {
            for (at, &child) in node.children.iter().enumerate() {
                if let Some(other) = parents[child] {
                    let message = format!("node {child} has a second parent: it is a child of node {other} too");
                    return Err(Fault::broken(format!("{}/children/{at}", node.place), message));
                }
                parents[child] = Some(number);
            }
        }
        let roots = (0..count).filter(|&node| parents[node].is_none());
        let order = depth_first(model, roots, |_| true);
        if order.len() < count {
            // With one parent each, nodes that no root reaches run in circles.
            let mut reached = vec![false; count];
            for &node in &order {
                reached[node] = true;
            }
            let lost = reached.iter().position(|reached| !reached).unwrap_or(0);
            let parent = parents[lost].unwrap_or(lost);
            let child = model.nodes[parent].children.iter().position(|&child| child == lost).unwrap_or(0);
            let place = format!("{}/children/{child}", model.nodes[parent].place);
            return Err(Fault::broken(place, format!("node {lost} is its own ancestor")));
        }
        let mut graph = Self { parents, order, scene: Vec::new(), hidden: 0, false_roots: 0 };
        let roots = match model.scene {
            Some(scene) => graph.scene_roots(model, scene)?,
            None => (0..count).filter(|&node| graph.parents[node].is_none()).collect(),
        };
        graph.scene = depth_first(model, roots.iter().copied(), |node| !model.nodes[node].hidden);
        graph.hidden = depth_first(model, roots.into_iter(), |_| true).len() - graph.scene.len();
        Ok(graph)
    }

    /// The nodes that a scene starts from. It should list roots alone, but exporters list nodes whose parent is not in the
    /// scene; these stand as roots. A node whose ancestor is listed too comes with that one.
    fn scene_roots(&mut self, model: &Model, scene: usize) -> Checked<Vec<usize>> {
        let mut listed = vec![false; model.nodes.len()];
        for (at, &root) in model.scenes[scene].roots.iter().enumerate() {
            if std::mem::replace(&mut listed[root], true) {
                let place = format!("/scenes/{scene}/nodes/{at}");
                return Err(Fault::broken(place, format!("node {root} stands twice in the scene")));
            }
        }
        let mut below = vec![false; model.nodes.len()];
        for &node in &self.order {
            below[node] = self.parents[node].is_some_and(|parent| listed[parent] || below[parent]);
        }
        let mut roots = model.scenes[scene].roots.clone();
        let all = roots.len();
        roots.retain(|&root| !below[root]);
        self.false_roots = all - roots.len();
        for &root in &roots {
            self.false_roots += usize::from(self.parents[root].take().is_some());
        }
        Ok(roots)
    }

    /// Node to world for every node, from each one's transform to its parent.
    pub(super) fn worlds(&self, local: impl Fn(usize) -> DAffine3) -> Vec<DAffine3> {
        let mut worlds = vec![DAffine3::IDENTITY; self.parents.len()];
        for &node in &self.order {
            let local = local(node);
            worlds[node] = self.parents[node].map_or(local, |parent| worlds[parent] * local);
        }
        worlds
    }
}

/// Nodes with their descendants, parents before children; a node that is not wanted is left out with all below it.
fn depth_first(
    model: &Model,
    roots: impl DoubleEndedIterator<Item = usize>,
    wanted: impl Fn(usize) -> bool,
) -> Vec<usize> {
    let mut order = Vec::new();
    let mut pending: Vec<usize> = roots.rev().collect();
    while let Some(node) = pending.pop() {
        if wanted(node) {
            order.push(node);
            pending.extend(model.nodes[node].children.iter().rev());
        }
    }
    order
}
