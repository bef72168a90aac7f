//! Changing which `TI:` lines the triangles of an object have.

use aam::document::{Faces, Layer, Object, TexCounts};
use aam::meaning::Materials;

/// A triangle's texture coordinates, on the way from one set of layers to another.
pub(crate) struct Lines<'a> {
    /// The leaf material, if it has one.
    pub(crate) leaf: Option<usize>,
    /// The layers that the lines belong to, in order.
    pub(crate) layers: &'a [Layer],
    /// The lines that are there; they may be more or fewer than the layers.
    pub(crate) lines: &'a [[u32; 3]],
}

/// Puts the lines that `new` pushes in the place of those that each triangle has.
///
/// # Errors
/// The first that `new` gives; the object is then unchanged.
pub(crate) fn rewrite<E>(
    object: &mut Object,
    materials: &Materials,
    mut new: impl FnMut(&Lines, &mut Vec<[u32; 3]>) -> Result<(), E>,
) -> Result<(), E> {
    let Some(faces) = &mut object.faces else { return Ok(()) };
    let mut lines = Vec::with_capacity(faces.tex_indices.len());
    let mut counts = Vec::with_capacity(faces.triangles.len());
    let mut old = faces.tex_indices_of_triangles();
    let mut left = faces.triangles.len();
    let rest = aam::document::Group { id: 0, triangles: usize::MAX };
    for group in faces.groups.iter().chain([&rest]) {
        let leaf = materials.lookup(object.material, group.id).leaf();
        let layers: Vec<Layer> = leaf.map_or_else(Vec::new, |leaf| materials.leaves()[leaf].present_layers().collect());
        for given in old.by_ref().take(group.triangles.min(left)) {
            let first = lines.len();
            new(&Lines { leaf, layers: &layers, lines: given }, &mut lines)?;
            counts.push((lines.len() - first) as u8);
        }
        left -= group.triangles.min(left);
    }
    drop(old);
    faces.tex_indices = lines;
    faces.tex_counts = tex_counts(counts);
    Ok(())
}

/// The shortest form of one count for each triangle.
pub(crate) fn tex_counts(counts: Vec<u8>) -> TexCounts {
    let first = counts.first().copied().unwrap_or(0);
    if counts.iter().all(|count| *count == first) { TexCounts::Uniform(first) } else { TexCounts::Each(counts) }
}

/// Takes out the texture coordinates that no line names; the others keep their order.
pub(crate) fn drop_unused(faces: &mut Faces) {
    let mut numbers = vec![u32::MAX; faces.tex_coords.len()];
    for index in faces.tex_indices.iter().flatten() {
        if let Some(number) = numbers.get_mut(*index as usize) {
            *number = 0;
        }
    }
    for (next, number) in (0..).zip(numbers.iter_mut().filter(|number| **number == 0)) {
        *number = next;
    }
    let mut at = 0;
    faces.tex_coords.retain(|_| {
        at += 1;
        numbers[at - 1] != u32::MAX
    });
    for index in faces.tex_indices.iter_mut().flatten() {
        *index = numbers.get(*index as usize).copied().unwrap_or(*index);
    }
}
