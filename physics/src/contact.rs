//! Where bodies touch.

use aam_scene::NodeId;
use glam::Vec3;
use rapier3d::math::Pose as EnginePose;

use crate::Simulator;
use crate::world::World;

/// A point where two bodies press on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The two bodies.
    pub bodies: [NodeId; 2],
    /// Where, in the world, in metres.
    pub point: Vec3,
    /// Unit direction from the first body to the second.
    pub normal: Vec3,
    /// How strongly they press along it, in newtons, as a mean over the last step.
    pub force: f32,
}

impl Simulator {
    /// Where bodies press on each other now: contacts that bore a load in the last step. Bodies that sleep keep those that
    /// they fell asleep with.
    pub fn contacts(&self) -> Vec<Contact> {
        self.peek().map_or_else(Vec::new, World::contacts)
    }
}

impl World {
    fn contacts(&self) -> Vec<Contact> {
        let mut contacts = Vec::new();
        let rate = self.time_step().recip();
        for pair in self.engine.contact_pairs() {
            let colliders = [pair.collider1, pair.collider2].map(|handle| self.engine.colliders.get(handle));
            let [Some(first), Some(second)] = colliders else { continue };
            let bodies = [first, second].map(|collider| self.body_of_collider(collider));
            let [Some(a), Some(b)] = bodies else { continue };
            for manifold in pair.solver_manifolds() {
                let part = |pose: Option<&EnginePose>| pose.copied().unwrap_or_default();
                let place1 = *first.position() * part(manifold.subshape_pos1());
                let place2 = *second.position() * part(manifold.subshape_pos2());
                for point in manifold.points.iter().filter(|point| point.data.impulse > 0.0) {
                    let middle =
                        0.5 * (place1.transform_point(point.local_p1) + place2.transform_point(point.local_p2));
                    contacts.push(Contact {
                        bodies: [a, b].map(|index| self.bodies[index].node),
                        point: middle,
                        normal: manifold.data.normal,
                        force: point.data.impulse * rate,
                    });
                }
            }
        }
        contacts
    }
}
