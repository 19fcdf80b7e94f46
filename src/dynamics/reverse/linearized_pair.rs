//! Linearized contacts of a step.

use crate::contact::{LinearizedContact, ShapeResponse};
use crate::dynamics::BodyState;
use crate::dynamics::model::Model;
use crate::parallel::mapped_into;
use crate::spatial::Wrench;
use nalgebra::Vector3;

/// Linearized contact of two bodies of the world, A first.
pub(super) struct LinearizedPair<'w> {
    pub bodies: [usize; 2],
    pub contact: LinearizedContact,
    /// Whether dissipation or friction adds to the wrenches.
    pub is_dissipative: bool,
    /// Response to changes of shape, if requested.
    pub shapes: Option<ShapeResponse<'w>>,
}

/// Gradient of a number with respect to a wrench: torque and force.
pub(super) type WrenchGradient = Wrench;

impl<'w> LinearizedPair<'w> {
    /// Contacts of pairs of bodies, in the order of the pairs, with or without their responses to changes of shape.
    pub fn of_pairs(
        model: &'w Model,
        states: &[BodyState],
        pairs: &[(usize, usize)],
        with_shapes: bool,
    ) -> Vec<Option<Self>> {
        let mut linearized = Vec::new();
        mapped_into(&mut linearized, pairs, |&(i, j)| {
            let (bodies, states) = ([i, j], [&states[i], &states[j]]);
            let pair = model.pair_of(bodies, states)?;
            let (contact, shapes) = if with_shapes {
                let (contact, shapes) = pair.linearized_with_shapes();
                (contact, Some(shapes))
            } else {
                (pair.linearized(), None)
            };
            Some(Self {
                bodies,
                contact,
                is_dissipative: pair.motion().is_some(),
                shapes,
            })
        });
        linearized
    }

    /// Net contact wrench on each body, about its center of mass.
    pub fn net_wrenches(contacts: &[Self], model: &Model, states: &[BodyState]) -> Vec<Wrench> {
        let mut wrenches = vec![Wrench::zero(); states.len()];
        for pair in contacts {
            for (body, wrench) in pair.sides() {
                wrenches[body] += wrench.about(&model.arm(body, &states[body]));
            }
        }
        wrenches
    }

    /// Both bodies, with the wrench on each body about its origin.
    pub fn sides(&self) -> [(usize, &Wrench); 2] {
        let [a, b] = self.bodies;
        [
            (a, &self.contact.wrench.on_a),
            (b, &self.contact.wrench.on_b),
        ]
    }
}

impl Model {
    /// Vector from the origin of a body to its center of mass, in the world, or zero for a body
    /// that is not dynamic.
    pub(super) fn arm(&self, body: usize, state: &BodyState) -> Vector3<f64> {
        self.bodies[body].center_in(state) - state.pose.translation()
    }
}
