//! Single rays.

use aam_scene::{NodeId, Scene};
use glam::Vec3;

use crate::bvh::Ray;
use crate::frame;
use crate::geometry::{Geometry, Hits};
use crate::options::Error;
use crate::surface::Surfaces;

/// The triangles of a scene at a frame, to be asked with single rays. Both sides of a triangle count, and all of it:
/// where an alpha cutoff makes holes is not looked at.
#[derive(Debug)]
pub struct Tracer<'a>(Geometry<'a>);

impl<'a> Tracer<'a> {
    /// Puts the visible meshes at a frame of the animation into a hierarchy.
    ///
    /// # Errors
    /// The scene has more than [`MAX_TRIANGLES`](crate::MAX_TRIANGLES).
    pub fn new(scene: &'a Scene, frame: f32) -> Result<Self, Error> {
        let mut surfaces = Surfaces::new(scene, scene.shading);
        Ok(Self(Geometry::new(scene, frame::index(frame), &mut surfaces)?))
    }

    /// How many triangles there are.
    pub fn triangles(&self) -> usize {
        self.0.faces.len()
    }

    /// Where a ray first meets a triangle: above 0, in lengths of `direction`.
    pub fn nearest(&self, origin: Vec3, direction: Vec3) -> Option<f32> {
        self.0.nearest(&Ray::new(origin, direction), (0.0, f32::INFINITY))
    }

    /// Whether a triangle lies on a ray above 0 and before `distance`, in lengths of `direction`.
    pub fn blocked(&self, origin: Vec3, direction: Vec3, distance: f32) -> bool {
        let mut blocked = false;
        self.0.any(&Ray::new(origin, direction), (0.0, distance), |_, _| {
            blocked = true;
            false
        });
        blocked
    }

    /// Calls `visit` with the node of each triangle on a ray above 0 and before `distance`, in lengths of `direction`,
    /// the nearest first, up to and with the first whose material lets nothing through anywhere.
    pub fn along(&self, origin: Vec3, direction: Vec3, distance: f32, mut visit: impl FnMut(NodeId)) {
        let ray = Ray::new(origin, direction);
        let mut hits = Hits::new();
        let mut last = None;
        loop {
            self.0.collect(&ray, (f32::MIN_POSITIVE, distance), last, &mut hits);
            for hit in hits.as_slice() {
                let instance = self.0.faces[hit.face as usize].instance;
                visit(NodeId(self.0.instances[instance as usize].node));
            }
            last = hits.as_slice().last().copied();
            if !hits.may_go_on() {
                return;
            }
        }
    }
}
