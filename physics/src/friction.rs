//! Two friction coefficients for an engine that has one.

use glam::Vec3;
use rapier3d::prelude::{ColliderHandle, ContactModificationContext, PhysicsHooks, RigidBodyHandle};

/// Speed of sliding, in m/s for bodies of a metre, below which two surfaces count as sticking.
const STICKING: f32 = 0.01;

/// Static and dynamic friction of a collider, kept in its user data.
pub(crate) fn pack(static_friction: f32, dynamic_friction: f32) -> u128 {
    u128::from(static_friction.to_bits()) << 32 | u128::from(dynamic_friction.to_bits())
}

fn unpack(data: u128) -> [f32; 2] {
    [f32::from_bits((data >> 32) as u32), f32::from_bits(data as u32)]
}

/// Gives each contact the mean of both bodies' static coefficients while it sticks, and that of the dynamic ones while it
/// slides. It is asked only where a body's two coefficients differ.
pub(crate) struct TwoCoefficients {
    /// The speed in m/s between sticking and sliding.
    pub(crate) sticking: f32,
}

impl TwoCoefficients {
    pub(crate) fn new(length_unit: f32) -> Self {
        Self { sticking: STICKING * length_unit }
    }
}

impl PhysicsHooks for TwoCoefficients {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        let coefficients = |handle: ColliderHandle| {
            context.colliders.get(handle).map_or([0.0; 2], |collider| unpack(collider.user_data))
        };
        let ([static1, dynamic1], [static2, dynamic2]) =
            (coefficients(context.collider1), coefficients(context.collider2));
        let (bodies, body1, body2) = (context.bodies, context.rigid_body1, context.rigid_body2);
        let velocity = |body: Option<RigidBodyHandle>, point: Vec3| {
            body.and_then(|handle| bodies.get(handle)).map_or(Vec3::ZERO, |body| body.velocity_at_point(point))
        };
        let Some(manifold) = context.rigid_mut() else { return };
        let normal = *manifold.normal;
        let sliding = manifold.solver_contacts.iter().any(|contact| {
            let relative = velocity(body1, contact.anchor1) - velocity(body2, contact.anchor2);
            relative.reject_from(normal).length_squared() > self.sticking * self.sticking
        });
        *manifold.friction = 0.5 * if sliding { dynamic1 + dynamic2 } else { static1 + static2 };
    }
}
