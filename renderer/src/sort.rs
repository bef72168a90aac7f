//! Transparent triangles, back to front.

use std::ops::Range;

use aam_scene::Scene;
use glam::{DVec3, Vec3};

use crate::RenderError;
use crate::displacement::DisplacementTable;
use crate::draws::{DrawList, Instance, mesh_of};
use crate::meshes::{MeshTable, cpu_positions};

/// The most transparent triangles in one picture, all instances counted.
pub(crate) const MAX_SORTED: usize = 1 << 25;

/// Consecutive triangles of one batch and instance: one draw.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    /// Position in [`DrawList::blended`].
    pub batch: usize,
    pub instance: u32,
    /// In [`Sorted::indices`].
    pub indices: Range<u32>,
}

/// Transparent triangles in their order.
#[derive(Debug, Default)]
pub(crate) struct Sorted {
    /// Triples, of the mesh of the run that they belong to.
    pub indices: Vec<u32>,
    pub runs: Vec<Run>,
    /// What the order was found from.
    found_from: Option<Signature>,
}

/// Equal signatures have equal orders.
#[derive(Debug, PartialEq)]
struct Signature {
    eye: Vec3,
    direction: Vec3,
    items: Vec<Item>,
}

/// A batch in one instance.
#[derive(Debug, PartialEq)]
struct Item {
    batch: usize,
    instance: u32,
    placed: Instance,
    mesh_serial: u64,
    /// Of its displaced surface, 0 if it has none.
    surface_serial: u64,
    frame: usize,
    indices: Range<u32>,
}

impl Sorted {
    /// Sorts the blended batches of a list as seen from `eye` along `direction`. Returns false if the order was known.
    #[expect(clippy::too_many_arguments, reason = "all of it decides about the order")]
    pub(crate) fn update(
        &mut self,
        scene: &Scene,
        list: &DrawList,
        meshes: &MeshTable,
        displacements: &DisplacementTable,
        frame: usize,
        eye: Vec3,
        direction: Vec3,
    ) -> Result<bool, RenderError> {
        let signature = Signature { eye, direction, items: items(scene, list, meshes, displacements, frame) };
        if self.found_from.as_ref() == Some(&signature) {
            return Ok(false);
        }
        self.found_from = None;
        self.sort(scene, list, meshes, displacements, &signature)?;
        self.found_from = Some(signature);
        Ok(true)
    }

    fn sort(
        &mut self,
        scene: &Scene,
        list: &DrawList,
        meshes: &MeshTable,
        displacements: &DisplacementTable,
        signature: &Signature,
    ) -> Result<(), RenderError> {
        let total: usize = signature.items.iter().map(|item| item.indices.len() / 3).sum();
        if total > MAX_SORTED {
            return Err(RenderError::Limit {
                what: "the number of transparent triangles".into(),
                needed: total as u64,
                limit: "of sorted triangles",
                allowed: MAX_SORTED as u64,
            });
        }
        // The key's upper half sorts by depth, farthest first; its lower half keeps the scene's order among equals.
        let mut triangles: Vec<(u32, [u32; 3])> = Vec::with_capacity(total);
        let mut keys: Vec<u64> = Vec::with_capacity(total);
        for (number, item) in (0..).zip(&signature.items) {
            let batch = &list.blended[item.batch];
            let mesh = mesh_of(scene, batch);
            let surface = batch.displaced.and_then(|key| displacements.get(key)?.sorting.as_ref());
            let (positions, indices) = match (surface, meshes.get(mesh)) {
                (Some(surface), _) => (&surface.positions[..], &surface.indices[..]),
                (None, Some(gpu_mesh)) => (cpu_positions(mesh, item.frame), gpu_mesh.cpu_indices(mesh)),
                (None, None) => continue,
            };
            let (gradient, offset) = depth_function(&item.placed, signature.eye, signature.direction);
            let indices = &indices[item.indices.start as usize..item.indices.end as usize];
            for triangle in indices.chunks_exact(3) {
                let triangle = [triangle[0], triangle[1], triangle[2]];
                if triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0] {
                    continue;
                }
                let corner = |which: usize| positions[triangle[which] as usize];
                let centroid = (corner(0) + corner(1) + corner(2)) / 3.0;
                let depth = gradient.dot(centroid) + offset;
                keys.push(u64::from(!ordered_bits(depth)) << 32 | triangles.len() as u64);
                triangles.push((number, triangle));
            }
        }
        keys.sort_unstable();

        self.indices.clear();
        self.runs.clear();
        let mut open: Option<u32> = None;
        for key in keys {
            let (number, triangle) = triangles[(key & 0xffff_ffff) as usize];
            let start = self.indices.len() as u32;
            self.indices.extend(triangle);
            let end = self.indices.len() as u32;
            match self.runs.last_mut().filter(|_| open == Some(number)) {
                Some(run) => run.indices.end = end,
                None => {
                    let item = &signature.items[number as usize];
                    self.runs.push(Run { batch: item.batch, instance: item.instance, indices: start..end });
                    open = Some(number);
                }
            }
        }
        Ok(())
    }
}

/// Batches by instance, in the order of the scene's nodes and their subsets.
fn items(
    scene: &Scene,
    list: &DrawList,
    meshes: &MeshTable,
    displacements: &DisplacementTable,
    frame: usize,
) -> Vec<Item> {
    let mut items: Vec<Item> = Vec::new();
    for (number, batch) in list.blended.iter().enumerate() {
        let mesh = mesh_of(scene, batch);
        let mesh_serial = meshes.get(mesh).map_or(0, |mesh| mesh.serial);
        let surface = batch.displaced.and_then(|key| displacements.get(key)?.sorting.as_ref());
        let surface_serial = surface.map_or(0, |surface| surface.serial);
        items.extend(batch.instances.clone().map(|instance| Item {
            batch: number,
            instance,
            placed: list.instances[instance as usize],
            mesh_serial,
            surface_serial,
            frame: frame.min(mesh.frames.len()),
            indices: surface.map_or(batch.indices.clone(), |surface| 0..surface.indices.len() as u32),
        }));
    }
    items.sort_by_key(|item| (list.nodes[item.instance as usize], list.blended[item.batch].subset));
    items
}

/// Depth along `direction` from `eye`, of a position p in the node's coordinates: `gradient · p + offset`.
fn depth_function(placed: &Instance, eye: Vec3, direction: Vec3) -> (Vec3, f32) {
    let direction = direction.as_dvec3();
    let rows = placed.rows.map(|row| DVec3::new(f64::from(row[0]), f64::from(row[1]), f64::from(row[2])));
    let gradient = rows[0] * direction.x + rows[1] * direction.y + rows[2] * direction.z;
    let origin = DVec3::from_array(placed.rows.map(|row| f64::from(row[3])));
    (gradient.as_vec3(), direction.dot(origin - eye.as_dvec3()) as f32)
}

/// Unsigned integers in the order of the floats.
fn ordered_bits(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 0 { bits | 0x8000_0000 } else { !bits }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_have_the_order_of_the_floats() {
        let values = [f32::NEG_INFINITY, -2.0, -1e-30, 0.0, 1e-30, 1.0, 3.5, f32::INFINITY];
        assert!(values.windows(2).all(|pair| ordered_bits(pair[0]) < ordered_bits(pair[1])));
    }

    #[test]
    fn depth_is_measured_along_the_view() {
        let world = glam::Affine3A::from_scale_rotation_translation(
            Vec3::new(2.0, 3.0, 4.0),
            glam::Quat::from_rotation_y(0.4),
            Vec3::new(1e4, 5.0, -3.0),
        );
        let (eye, direction) = (Vec3::new(1e4 - 7.0, 0.0, 1.0), Vec3::new(0.6, 0.0, 0.8));
        let (gradient, offset) = depth_function(&Instance::new(&world), eye, direction);
        let p = Vec3::new(0.3, -0.2, 0.9);
        let exact = direction.dot(world.transform_point3(p) - eye);
        assert!((gradient.dot(p) + offset - exact).abs() < 2e-3, "{exact}");
    }
}
