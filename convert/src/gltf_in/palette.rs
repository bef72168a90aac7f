//! The document's material list: single materials as in the file, and one Multi material for each set of materials that
//! a mesh uses together.

use std::collections::{BTreeMap, BTreeSet};

use aam::Text;
use aam::document::{Material, MaterialBody};

use super::material::Mapped;
use super::names::Names;
use super::surface::Surface;

/// The materials of the document and how surfaces refer to them.
#[derive(Debug, Default)]
pub(super) struct Palette {
    pub materials: Vec<Material>,
    singles: BTreeMap<usize, i32>,
    multis: BTreeMap<Vec<usize>, i32>,
}

impl Palette {
    /// Arranges materials for surfaces: in the file's order, those that only Multi materials use inside these alone.
    /// `mapped` ends with the default material, which is left out where nothing uses it.
    pub(super) fn of(mapped: &[Mapped], names: &[String], surfaces: &[Option<Surface>], mesh_names: &[String]) -> Self {
        let mut alone = BTreeSet::new();
        let mut together: BTreeMap<Vec<usize>, usize> = BTreeMap::new();
        for (mesh, surface) in surfaces.iter().enumerate() {
            let slots = slots(surface.as_ref());
            match slots.as_slice() {
                [] => {}
                [slot] => {
                    alone.insert(*slot);
                }
                _ => {
                    together.entry(slots).or_insert(mesh);
                }
            }
        }
        let inside: BTreeSet<usize> = together.keys().flatten().copied().collect();
        let mut taken = Names::default();
        let mut palette = Self::default();
        for (slot, material) in mapped.iter().enumerate() {
            let unused_default = slot + 1 == mapped.len() && !alone.contains(&slot);
            if alone.contains(&slot) || !inside.contains(&slot) && !unused_default {
                let number = palette.materials.len() as i32;
                palette.singles.insert(slot, number);
                palette.materials.push(single(number, taken.unique(&names[slot], ""), material));
            }
        }
        let mut by_mesh: Vec<(usize, Vec<usize>)> = together.into_iter().map(|(slots, mesh)| (mesh, slots)).collect();
        by_mesh.sort();
        for (mesh, slots) in by_mesh {
            let number = palette.materials.len() as i32;
            let subs =
                slots.iter().zip(0..).map(|(&slot, sub)| single(sub, names[slot].clone(), &mapped[slot])).collect();
            palette.materials.push(Material {
                number,
                name: Text::from(taken.unique(&mesh_names[mesh], "")),
                body: MaterialBody::Multi(subs),
                unknown: Vec::new(),
            });
            palette.multis.insert(slots, number);
        }
        palette
    }

    /// `MatID:` of a surface, and the `NEWGROUP:` id of each of its materials.
    pub(super) fn ids(&self, surface: &Surface) -> (i32, BTreeMap<usize, i32>) {
        let slots = slots(Some(surface));
        if let [slot] = slots.as_slice() {
            let number = self.singles.get(slot).copied().unwrap_or(-1);
            return (number, BTreeMap::from([(*slot, number)]));
        }
        let number = self.multis.get(&slots).copied().unwrap_or(-1);
        (number, slots.into_iter().zip(0..).collect())
    }
}

fn slots(surface: Option<&Surface>) -> Vec<usize> {
    surface.map_or_else(Vec::new, |surface| surface.groups.iter().map(|(slot, _)| *slot).collect())
}

fn single(number: i32, name: String, mapped: &Mapped) -> Material {
    Material {
        number,
        name: Text::from(name),
        body: MaterialBody::Single(Box::new(mapped.single.clone())),
        unknown: Vec::new(),
    }
}
