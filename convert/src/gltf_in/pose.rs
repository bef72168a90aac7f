//! Where a surface is: in its node's own coordinates, in the world, or bent by bones.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use super::accessor::Reader;
use super::fault::{Checked, Fault};
use super::graph::to_aam;
use super::primitive::Influence;
use super::surface::Surface;

/// From a surface's own coordinates to where it is to stand, both in glTF's axes.
#[derive(Clone, Debug)]
pub(super) enum Placement {
    /// As a whole.
    Rigid(DAffine3),
    /// By bones: for each joint of the skin its inverse bind matrix and then its place in the world.
    Bones(Arc<[DAffine3]>),
}

impl Placement {
    /// Whether left and right are exchanged.
    pub(super) fn mirrors(&self) -> bool {
        match self {
            Self::Rigid(place) => place.matrix3.determinant() < 0.0,
            Self::Bones(_) => false,
        }
    }

    fn of(&self, bones: &[Influence]) -> DAffine3 {
        let joints = match self {
            Self::Rigid(place) => return *place,
            Self::Bones(joints) => joints,
        };
        let mut matrix = DMat3::ZERO;
        let mut translation = DVec3::ZERO;
        for bone in bones {
            if bone.weight > 0.0
                && let Some(joint) = joints.get(bone.joint as usize)
            {
                matrix += joint.matrix3 * f64::from(bone.weight);
                translation += joint.translation * f64::from(bone.weight);
            }
        }
        DAffine3::from_mat3_translation(matrix, translation)
    }

    /// The vertices of a surface in AAM's axes.
    pub(super) fn vertices(&self, surface: &Surface, weights: &[f32]) -> Vec<[f32; 3]> {
        surface
            .sources
            .iter()
            .map(|&source| {
                let source = source as usize;
                let place = self.of(surface.bones(source));
                to_aam(place.transform_point3(surface.position(source, weights))).as_vec3().to_array()
            })
            .collect()
    }

    /// The unit normals of sources in AAM's axes; zero where there is none.
    pub(super) fn normals(&self, surface: &Surface, weights: &[f32], sources: &[u32]) -> Vec<[f32; 3]> {
        let rigid = match self {
            Self::Rigid(place) => Some(normal_matrix(&place.matrix3)),
            Self::Bones(_) => None,
        };
        sources
            .iter()
            .map(|&source| {
                let source = source as usize;
                let matrix = rigid.unwrap_or_else(|| normal_matrix(&self.of(surface.bones(source)).matrix3));
                let normal = matrix * surface.normal(source, weights);
                to_aam(normal.normalize_or_zero()).as_vec3().to_array()
            })
            .collect()
    }
}

/// What takes normals where a matrix takes points: its inverse transposed, up to a positive factor. It exists for
/// matrices without an inverse too.
pub(super) fn normal_matrix(matrix: &DMat3) -> DMat3 {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = *matrix;
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if matrix.determinant() < 0.0 { cofactors * -1.0 } else { cofactors }
}

/// The inverse bind matrices of each skin.
pub(super) fn inverse_binds(reader: Reader<'_>) -> Checked<Vec<Vec<DAffine3>>> {
    reader
        .model
        .skins
        .iter()
        .map(|skin| {
            let Some(accessor) = skin.inverse_bind else { return Ok(vec![DAffine3::IDENTITY; skin.joints.len()]) };
            let place = format!("{}/inverseBindMatrices", skin.place);
            let count = reader.model.accessors[accessor].count;
            if count < skin.joints.len() {
                return Err(Fault::broken(place, format!("{count} matrices for {} joints", skin.joints.len())));
            }
            let matrices = reader.matrices(accessor, skin.joints.len(), "inverseBindMatrices")?;
            Ok(matrices
                .iter()
                .map(|columns| DAffine3::from_mat4(glam::DMat4::from_cols_array(&columns.map(f64::from))))
                .collect())
        })
        .collect()
}

/// Checks that every bone of a surface is a joint of the skin that it is shown with.
pub(super) fn check_bones(surface: &Surface, joints: usize, place: &str) -> Checked<()> {
    if surface.influences_per_source == 0 {
        return Err(Fault::broken(place, "the node has a skin, but its mesh has no JOINTS_0 and WEIGHTS_0"));
    }
    match surface.influences.iter().find(|bone| bone.joint as usize >= joints) {
        None => Ok(()),
        Some(bone) => {
            let message = format!("a vertex is bound to joint {}, but the skin has {joints}", bone.joint);
            Err(Fault::broken(place, message))
        }
    }
}
