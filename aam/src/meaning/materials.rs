//! Materials with resolved values.

use std::collections::BTreeMap;

use glam::{DMat2, DVec2, Mat3, Vec3};

use crate::Document;
use crate::document::{Layer, Material, MaterialBody, NormalSpace, Rgb, SingleMaterial, Texture};

/// The largest colour component; larger ones are cut to it, so that products stay finite.
const MAX_COLOR: f32 = 1e6;

/// A single material, resolved: Multi materials are flattened to the singles in them.
///
/// Colours are as written; a component that is negative or not a number is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct LeafMaterial {
    /// The name.
    pub name: String,
    /// Emission E, non-negative.
    pub emission: Vec3,
    /// Ambient reflectance A.
    pub ambient: Vec3,
    /// Diffuse reflectance D.
    pub diffuse: Vec3,
    /// Specular reflectance S.
    pub specular: Vec3,
    /// Phong exponent n, at least 0; 0 means no highlight.
    pub exponent: f32,
    /// 1 − `Tr`, in `[0, 1]`.
    pub opacity: f32,
    /// Fragments with alpha below it are discarded.
    pub alpha_cutoff: Option<f32>,
    /// The layers that are present, by [`Layer`]. Where a light map and a normal map are both there, the light map wins:
    /// it replaces lighting, for which alone normals are needed.
    pub layers: [Option<TextureLayer>; 4],
}

/// A present texture layer, resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureLayer {
    /// The file's name as the document gives it.
    pub file: String,
    /// Applied to `(u, v, 1)` before sampling; v is 0 at the bottom. Always finite.
    pub transform: Mat3,
    /// Scales xy of a tangent-space normal map.
    pub intensity: f32,
    /// Space of a normal map; [`NormalSpace::Object`] where the file says nothing.
    pub normal_space: NormalSpace,
}

/// Which material a group of an object gets. Numbers are positions in [`Materials::leaves`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lookup {
    /// The one that the ids name.
    Named(usize),
    /// The group's id is no sub-material's number: the sub at position `id mod count` stands in, as in 3ds Max.
    Substitute(usize),
    /// `MatID: -1`: the default material.
    Default,
    /// The id names nothing (beyond the list, or an empty Multi): the default material.
    Missing,
}

impl Lookup {
    /// The leaf, or `None` for the default material.
    pub const fn leaf(self) -> Option<usize> {
        match self {
            Self::Named(leaf) | Self::Substitute(leaf) => Some(leaf),
            Self::Default | Self::Missing => None,
        }
    }
}

/// The materials of a document, flattened.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Materials {
    leaves: Vec<LeafMaterial>,
    slots: Vec<Slot>,
    /// The slot of each material of the document.
    roots: Vec<usize>,
}

#[derive(Clone, Debug, PartialEq)]
enum Slot {
    Leaf(usize),
    Multi {
        /// The slots of the sub-materials, in file order.
        subs: Vec<usize>,
        /// The slot of the first sub-material with each number.
        by_number: BTreeMap<i32, usize>,
    },
}

impl Materials {
    /// Resolves a document's materials.
    pub fn of(document: &Document) -> Self {
        let mut materials = Self::default();
        // Parents wait with their children's places reserved, so that nesting of any depth needs no call stack; leaves
        // get their numbers in file order because children are pushed last to first.
        let mut pending: Vec<(usize, &Material)> = Vec::new();
        materials.roots = materials.reserve(&document.materials, &mut pending);
        while let Some((slot, material)) = pending.pop() {
            materials.slots[slot] = match &material.body {
                MaterialBody::Single(single) => {
                    materials.leaves.push(LeafMaterial::of(material, single));
                    Slot::Leaf(materials.leaves.len() - 1)
                }
                MaterialBody::Multi(children) => {
                    let subs = materials.reserve(children, &mut pending);
                    let mut by_number = BTreeMap::new();
                    for (child, &slot) in children.iter().zip(&subs) {
                        by_number.entry(child.number).or_insert(slot);
                    }
                    Slot::Multi { subs, by_number }
                }
            };
        }
        materials
    }

    fn reserve<'a>(&mut self, children: &'a [Material], pending: &mut Vec<(usize, &'a Material)>) -> Vec<usize> {
        let first = self.slots.len();
        self.slots.extend(children.iter().map(|_| Slot::Leaf(usize::MAX)));
        pending.extend(children.iter().enumerate().rev().map(|(index, child)| (first + index, child)));
        (first..self.slots.len()).collect()
    }

    /// The single materials, in file order.
    pub fn leaves(&self) -> &[LeafMaterial] {
        &self.leaves
    }

    /// The material of an object's group: `material` is the object's `MatID:`, `group` its `NEWGROUP:` id.
    ///
    /// `MatID` is a position in [`Document::materials`]. A single material takes every group, whatever its id. In a
    /// Multi the id chooses the sub-material with that number; an id that no sub has takes the one at position `id mod
    /// count`, as 3ds Max does. A Multi inside a Multi is asked with the same id.
    pub fn lookup(&self, material: i32, group: i32) -> Lookup {
        if material == -1 {
            return Lookup::Default;
        }
        let root = usize::try_from(material).ok().and_then(|index| self.roots.get(index));
        let Some(&(mut slot)) = root else {
            return Lookup::Missing;
        };
        let mut named = true;
        loop {
            match &self.slots[slot] {
                Slot::Leaf(leaf) if named => return Lookup::Named(*leaf),
                Slot::Leaf(leaf) => return Lookup::Substitute(*leaf),
                Slot::Multi { subs, .. } if subs.is_empty() => return Lookup::Missing,
                Slot::Multi { subs, by_number } => {
                    slot = by_number.get(&group).copied().unwrap_or_else(|| {
                        named = false;
                        subs[i64::from(group).rem_euclid(subs.len() as i64) as usize]
                    });
                }
            }
        }
    }
}

impl LeafMaterial {
    fn of(material: &Material, single: &SingleMaterial) -> Self {
        Self {
            name: material.name.decoded(),
            emission: single.emission.map_or(Vec3::ZERO, color),
            ambient: color(single.ambient),
            diffuse: color(single.diffuse),
            specular: color(single.specular),
            exponent: exponent(single.shininess),
            opacity: if single.transparency.is_finite() { (1.0 - single.transparency).clamp(0.0, 1.0) } else { 1.0 },
            alpha_cutoff: single.alpha_cutoff.filter(|cutoff| cutoff.is_finite()),
            layers: Layer::ALL
                .map(|layer| single.layers[layer as usize].as_ref().map(|texture| TextureLayer::of(texture))),
        }
    }

    /// The layers that are present, in the order in which a triangle's `TI:` lines follow.
    pub fn present_layers(&self) -> impl Iterator<Item = Layer> {
        Layer::ALL.into_iter().filter(|&layer| self.layers[layer as usize].is_some())
    }
}

impl TextureLayer {
    fn of(texture: &Texture) -> Self {
        Self {
            file: texture.file.decoded(),
            transform: uv_transform(texture),
            intensity: finite_or(texture.intensity, 1.0),
            normal_space: texture.normal_space.unwrap_or(NormalSpace::Object),
        }
    }
}

/// The Phong exponent that a `Sh:` means: a fraction of 128 (fixed-function OpenGL's range) up to 1, else the exponent
/// itself. 0, negative values and those that are not finite mean no highlight.
fn exponent(shininess: f32) -> f32 {
    if !shininess.is_finite() || shininess <= 0.0 {
        0.0
    } else if shininess <= 1.0 {
        128.0 * shininess
    } else {
        shininess
    }
}

fn color(rgb: Rgb) -> Vec3 {
    Vec3::from(rgb.map(|value| if value > 0.0 { value.min(MAX_COLOR) } else { 0.0 }))
}

fn finite_or(value: f32, otherwise: f32) -> f32 {
    if value.is_finite() { value } else { otherwise }
}

/// uv' = c + R(WA)·S(UT, VT)·(uv − c − (UO, VO)) with c = (½, ½), as a matrix on (u, v, 1).
fn uv_transform(texture: &Texture) -> Mat3 {
    let center = DVec2::splat(0.5);
    let offset = DVec2::from(texture.offset.map(|value| f64::from(finite_or(value, 0.0))));
    let tiling = DVec2::from(texture.tiling.map(|value| f64::from(finite_or(value, 1.0))));
    let linear = DMat2::from_angle(f64::from(finite_or(texture.rotation[2], 0.0))) * DMat2::from_diagonal(tiling);
    let shift = center - linear * (center + offset);
    let matrix = Mat3::from_cols(
        linear.x_axis.extend(0.0).as_vec3(),
        linear.y_axis.extend(0.0).as_vec3(),
        shift.extend(1.0).as_vec3(),
    );
    if matrix.is_finite() { matrix } else { Mat3::IDENTITY }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::document::Flagged;

    fn single(name: &str) -> Material {
        let body = MaterialBody::Single(Box::default());
        Material { number: 0, name: name.into(), body, unknown: Vec::new() }
    }

    fn multi(subs: Vec<(i32, Material)>) -> Material {
        let subs = subs.into_iter().map(|(number, sub)| Material { number, ..sub }).collect();
        Material { number: 0, name: "multi".into(), body: MaterialBody::Multi(subs), unknown: Vec::new() }
    }

    fn resolve(materials: Vec<Material>) -> Materials {
        Materials::of(&Document { materials, ..Document::default() })
    }

    #[test]
    fn shininess_becomes_an_exponent() {
        for (written, expected) in [
            (0.0, 0.0),
            (0.25, 32.0),
            (1.0, 128.0),
            (1.5, 1.5),
            (100.0, 100.0),
            (128.0, 128.0),
            (1000.0, 1000.0),
            (-1.0, 0.0),
            (f32::NAN, 0.0),
            (f32::INFINITY, 0.0),
        ] {
            assert_eq!(exponent(written), expected, "Sh: {written}");
        }
    }

    #[test]
    fn bad_numbers_become_harmless() {
        let mut texture = Texture::new("a.png");
        texture.rotation[2] = f32::NAN;
        texture.tiling = [f32::INFINITY, 2.0];
        texture.offset = [f32::NEG_INFINITY, 0.0];
        texture.intensity = f32::NAN;
        let mut layers: [Flagged<Box<Texture>>; 4] = Default::default();
        layers[Layer::Normal as usize] = Flagged::Yes(Box::new(texture));
        let written = SingleMaterial {
            ambient: [f32::NAN, -1.0, f32::INFINITY],
            diffuse: [0.25, 1.0, 3.0],
            transparency: f32::NAN,
            alpha_cutoff: Some(f32::NAN),
            layers,
            ..SingleMaterial::default()
        };
        let leaf = LeafMaterial::of(&single("m"), &written);
        assert_eq!(leaf.ambient, Vec3::new(0.0, 0.0, MAX_COLOR));
        assert_eq!(leaf.diffuse, Vec3::new(0.25, 1.0, 3.0), "colours are kept as written");
        assert_eq!((leaf.opacity, leaf.alpha_cutoff), (1.0, None));
        assert_eq!(leaf.present_layers().collect::<Vec<_>>(), [Layer::Normal]);
        let layer = leaf.layers[Layer::Normal as usize].as_ref().unwrap();
        assert_eq!(layer.intensity, 1.0);
        assert_eq!(layer.normal_space, NormalSpace::Object);
        let tiled = layer.transform * Vec3::new(0.5, 0.75, 1.0);
        assert!(tiled.abs_diff_eq(Vec3::new(0.5, 1.0, 1.0), 1e-6), "{tiled}");
        let written = SingleMaterial { transparency: 1.5, ..SingleMaterial::default() };
        assert_eq!(LeafMaterial::of(&single("m"), &written).opacity, 0.0);
    }

    #[test]
    fn texture_coordinates_turn_about_the_middle() {
        let at = |texture: &Texture, u: f32, v: f32| {
            let moved = uv_transform(texture) * Vec3::new(u, v, 1.0);
            Vec2::new(moved.x, moved.y)
        };
        let mut texture = Texture::new("a.png");
        assert_eq!(uv_transform(&texture), Mat3::IDENTITY);
        texture.rotation[2] = std::f32::consts::FRAC_PI_2;
        assert!(at(&texture, 1.0, 0.5).abs_diff_eq(Vec2::new(0.5, 1.0), 1e-6));
        texture.rotation[2] = 0.0;
        texture.tiling = [2.0, 3.0];
        assert!(at(&texture, 1.0, 1.0).abs_diff_eq(Vec2::new(1.5, 2.0), 1e-6));
        texture.offset = [0.25, -0.5];
        // ½ + 2·(1 − ½ − ¼) = 1, ½ + 3·(1 − ½ + ½) = 3.5
        assert!(at(&texture, 1.0, 1.0).abs_diff_eq(Vec2::new(1.0, 3.5), 1e-6));
        // Rotation comes after tiling: (½, ½) + R(90°)·(2·¼, 3·1) = (½ − 3, ½ + ½).
        texture.rotation[2] = std::f32::consts::FRAC_PI_2;
        assert!(at(&texture, 1.0, 1.0).abs_diff_eq(Vec2::new(-2.5, 1.0), 1e-5));
    }

    #[test]
    fn ids_choose_materials() {
        let nested = multi(vec![(0, single("c")), (1, single("d"))]);
        let materials = resolve(vec![
            single("a"),
            multi(vec![(0, single("b")), (1, nested), (7, single("e")), (7, single("f"))]),
            multi(Vec::new()),
        ]);
        let names: Vec<_> = materials.leaves().iter().map(|leaf| leaf.name.as_str()).collect();
        assert_eq!(names, ["a", "b", "c", "d", "e", "f"]);
        assert_eq!(materials.lookup(0, 46), Lookup::Named(0), "a single material takes every group");
        assert_eq!(materials.lookup(1, 0), Lookup::Named(1));
        assert_eq!(materials.lookup(1, 1), Lookup::Named(3), "a nested Multi is asked with the same id");
        assert_eq!(materials.lookup(1, 7), Lookup::Named(4), "numbers decide, the first of two equal ones wins");
        assert_eq!(materials.lookup(1, 8), Lookup::Substitute(1), "8 mod 4");
        assert_eq!(materials.lookup(1, -1), Lookup::Substitute(5), "-1 mod 4");
        assert_eq!(materials.lookup(1, 5), Lookup::Substitute(3), "5 mod 4 is the nested one, and there 5 mod 2");
        assert_eq!(materials.lookup(1, i32::MIN), Lookup::Substitute(1));
        assert_eq!(materials.lookup(2, 0), Lookup::Missing);
        assert_eq!(materials.lookup(-1, 0), Lookup::Default);
        for beyond in [3, i32::MAX, -2, i32::MIN] {
            assert_eq!(materials.lookup(beyond, 0), Lookup::Missing);
        }
    }

    #[test]
    fn deep_nesting_needs_no_stack() {
        let mut material = single("bottom");
        for _ in 0..1000 {
            material = multi(vec![(0, material)]);
        }
        let materials = resolve(vec![material]);
        assert_eq!(materials.lookup(0, 0), Lookup::Named(0));
    }
}
