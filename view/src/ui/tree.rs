//! The objects as a tree.

use std::collections::BTreeSet;

use aam_scene::{NodeId, Scene};
use egui::{Align, Layout, RichText, ScrollArea, Sense, UiBuilder};

use super::icons::{self, Icon};
use super::theme;

/// Which parts of the tree are closed, and what is searched.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    closed: BTreeSet<NodeId>,
    filter: String,
    /// Scrolls to the selected row once.
    pub(crate) reveal: bool,
}

/// One visible row.
struct Row {
    node: NodeId,
    depth: usize,
    parent_of_some: bool,
}

/// What the user did in the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TreeEvent {
    Selected(NodeId),
    Focused(NodeId),
    VisibilityChanged(NodeId),
}

impl Tree {
    /// Draws the tree; rows out of sight cost nothing.
    pub(crate) fn show(&mut self, ui: &mut egui::Ui, scene: &mut Scene, selected: Option<NodeId>) -> Option<TreeEvent> {
        if scene.nodes.len() > 12 {
            ui.add(
                egui::TextEdit::singleline(&mut self.filter).hint_text("Search objects").desired_width(f32::INFINITY),
            );
        }
        let rows = self.rows(scene);
        if rows.is_empty() {
            ui.label(theme::weak(if scene.nodes.is_empty() { "No objects" } else { "No object has this name" }));
            return None;
        }
        let height = ui.spacing().interact_size.y;
        let mut scroll = ScrollArea::vertical().auto_shrink([false, false]);
        if std::mem::take(&mut self.reveal)
            && let Some(position) = rows.iter().position(|row| Some(row.node) == selected)
        {
            let step = height + ui.spacing().item_spacing.y;
            scroll = scroll.vertical_scroll_offset((position as f32 * step - 0.4 * ui.available_height()).max(0.0));
        }
        let visible = scene.visibility();
        let mut event = None;
        scroll.show_rows(ui, height, rows.len(), |ui, range| {
            for row in &rows[range] {
                let shown = visible[row.node.index()];
                event = self.row(ui, scene, row, shown, selected == Some(row.node)).or(event);
            }
        });
        event
    }

    fn rows(&self, scene: &Scene) -> Vec<Row> {
        let mut children: Vec<Vec<NodeId>> = vec![Vec::new(); scene.nodes.len()];
        let mut roots = Vec::new();
        for (index, node) in scene.nodes.iter().enumerate() {
            let id = NodeId(index as u32);
            match node.parent.filter(|parent| parent.index() < index) {
                Some(parent) => children[parent.index()].push(id),
                None => roots.push(id),
            }
        }
        let filter = self.filter.trim().to_lowercase();
        if !filter.is_empty() {
            let matching = |index: &usize| scene.nodes[*index].name.to_lowercase().contains(&filter);
            return (0..scene.nodes.len())
                .filter(matching)
                .map(|index| Row { node: NodeId(index as u32), depth: 0, parent_of_some: false })
                .collect();
        }
        let mut rows = Vec::with_capacity(scene.nodes.len());
        let mut stack: Vec<(NodeId, usize)> = roots.into_iter().rev().map(|id| (id, 0)).collect();
        while let Some((node, depth)) = stack.pop() {
            let below = &children[node.index()];
            rows.push(Row { node, depth, parent_of_some: !below.is_empty() });
            if !self.closed.contains(&node) {
                stack.extend(below.iter().rev().map(|id| (*id, depth + 1)));
            }
        }
        rows
    }

    fn row(
        &mut self,
        ui: &mut egui::Ui,
        scene: &mut Scene,
        row: &Row,
        shown: bool,
        selected: bool,
    ) -> Option<TreeEvent> {
        let mut event = None;
        let node = &mut scene.nodes[row.node.index()];
        let (rect, _) =
            ui.allocate_exact_size([ui.available_width(), ui.spacing().interact_size.y].into(), Sense::hover());
        let mut line = ui.new_child(UiBuilder::new().max_rect(rect).layout(Layout::right_to_left(Align::Center)));
        let icon = if node.visible { Icon::Shown } else { Icon::Hidden };
        if icons::button(&mut line, icon, false).on_hover_text(if node.visible { "Hide" } else { "Show" }).clicked() {
            node.visible = !node.visible;
            event = Some(TreeEvent::VisibilityChanged(row.node));
        }
        line.with_layout(Layout::left_to_right(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            // Deep trees stay within the panel.
            ui.add_space(12.0 * row.depth.min(12) as f32);
            if row.parent_of_some {
                let open = !self.closed.contains(&row.node);
                if icons::arrow(ui, open).clicked() && !self.closed.remove(&row.node) {
                    self.closed.insert(row.node);
                }
            } else {
                ui.add_space(18.0);
            }
            let name = if node.name.is_empty() { format!("object {}", row.node.0) } else { node.name.clone() };
            let text = match (shown, node.mesh.is_some()) {
                (true, true) => RichText::new(name),
                _ => RichText::new(name).color(theme::WEAK),
            };
            let label = ui.add(egui::Button::selectable(selected, text).truncate());
            if label.double_clicked() {
                event = Some(TreeEvent::Focused(row.node));
            } else if label.clicked() {
                event = Some(TreeEvent::Selected(row.node));
            }
        });
        event
    }
}
