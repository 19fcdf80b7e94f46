//! The contacts of a step, backwards.

use super::StateGradient;
use super::pullback::Pullback;
use crate::contact::{LinearizedContact, ShapeResponse};
use crate::dynamics::model::Model;
use crate::dynamics::{BodyState, Material};
use crate::parallel::mapped_into;
use crate::scalar::DenseDual;
use crate::spatial::{Twist, Wrench};
use nalgebra::{SVector, Vector3, Vector6};

/// A contact of two bodies of the world, A first.
pub(super) struct LinearizedPair<'w> {
    pub bodies: [usize; 2],
    pub contact: LinearizedContact,
    /// Whether the law of the surfaces adds to it.
    is_dissipative: bool,
    /// How it answers to changes of shape, if that is asked for.
    shapes: Option<ShapeResponse<'w>>,
}

/// The derivative of a number by a wrench: by torque and force.
pub(super) type WrenchCovector = Wrench;

impl<'w> LinearizedPair<'w> {
    /// The contacts of pairs of bodies, in their order; with their answers to changes of shape or without.
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

    /// The net wrench of contacts on each body, about its center of mass.
    pub fn net_wrenches(contacts: &[Self], model: &Model, states: &[BodyState]) -> Vec<Wrench> {
        let mut wrenches = vec![Wrench::zero(); states.len()];
        for linearized_pair in contacts {
            for (body, wrench) in linearized_pair.sides() {
                wrenches[body] += wrench.about(&model.arm(body, &states[body]));
            }
        }
        wrenches
    }

    /// Both bodies, and the wrench on each about its origin.
    fn sides(&self) -> [(usize, &Wrench); 2] {
        let [a, b] = self.bodies;
        [
            (a, &self.contact.wrench.on_a),
            (b, &self.contact.wrench.on_b),
        ]
    }
}

impl Model {
    /// From a body's origin to its center of mass, in the world; nothing for a body that forces do not move.
    pub(super) fn arm(&self, body: usize, state: &BodyState) -> Vector3<f64> {
        self.bodies[body].center_in(state) - state.pose.translation()
    }
}

impl Pullback<'_> {
    /// Adds what follows from the derivatives by the net wrenches of contact about the centers of mass.
    pub(super) fn pull_back_contacts(
        &mut self,
        states: &[BodyState],
        contacts: &[LinearizedPair],
        by_net: &[WrenchCovector],
    ) {
        for linearized_pair in contacts {
            let [on_a, on_b] = linearized_pair
                .sides()
                .map(|(body, wrench)| self.by_wrench(body, &states[body], wrench, &by_net[body]));
            let by_both = SVector::from_fn(|i, _| if i < 6 { on_a[i] } else { on_b[i - 6] });
            self.record_kinks(linearized_pair);
            self.add_by_shapes(linearized_pair, &by_both);
            let numbers = linearized_pair.contact.pullback(&by_both);
            for (side, body) in linearized_pair.bodies.into_iter().enumerate() {
                let six = |row: usize| numbers.fixed_rows::<6>(row + 6 * side).into_owned();
                self.add_by_motion(body, &states[body], [six(0), six(12)]);
                self.gradient.bodies[body].modulus += numbers[24 + side];
            }
            if linearized_pair.is_dissipative {
                self.add_by_law(linearized_pair.bodies, [numbers[26], numbers[27]]);
            }
        }
    }

    /// The derivative by a wrench about a body's origin, from that by the wrench about its center of mass.
    fn by_wrench(
        &mut self,
        body: usize,
        state: &BodyState,
        wrench: &Wrench,
        by_wrench: &WrenchCovector,
    ) -> Vector6<f64> {
        let (arm, Wrench { torque, force }) = (self.model().arm(body, state), *by_wrench);
        // τ about the center of mass is τ − arm × F.
        self.add_by_arm(body, state, &torque.cross(&wrench.force));
        let force = force + arm.cross(&torque);
        Wrench { torque, force }.to_vector()
    }

    /// Adds what follows from the derivatives by the pose and the twist of a body's origin.
    fn add_by_motion(
        &mut self,
        body: usize,
        state: &BodyState,
        [by_pose, by_twist]: [Vector6<f64>; 2],
    ) {
        let arm = self.model().arm(body, state);
        let [by_pose, by_twist] = [by_pose, by_twist].map(|six| Twist::from_vector(&six));
        let by_state = &mut self.states[body];
        by_state.add(&StateGradient {
            turn: by_pose.angular,
            shift: by_pose.linear,
            spin: by_twist.angular - arm.cross(&by_twist.linear),
            velocity: by_twist.linear,
        });
        // The origin's velocity is that of the center of mass less ω × arm.
        self.add_by_arm(body, state, &state.twist.angular.cross(&by_twist.linear));
    }

    /// Adds what follows from the derivative by the arm from a body's origin to its center of mass, in the axes of the world.
    fn add_by_arm(&mut self, body: usize, state: &BodyState, by_arm: &Vector3<f64>) {
        if self.model().bodies[body].inertia().is_some() {
            let arm = self.model().arm(body, state);
            self.states[body].add_by_arm(&arm, by_arm);
            self.gradient.bodies[body].center += state.pose.rotation().tr_mul(by_arm);
        }
    }

    /// Counts the kinks of a contact in this step.
    fn record_kinks(&mut self, linearized_pair: &LinearizedPair) {
        let kinks = linearized_pair.contact.kinks;
        if kinks.is_any() {
            let (gradient, step) = (&mut self.gradient, self.step);
            gradient.record_contact_kinks(linearized_pair.bodies, kinks, step);
        }
    }

    /// Adds what follows for the shapes from the derivatives by the wrenches of a contact, if they are asked for.
    fn add_by_shapes(&mut self, linearized_pair: &LinearizedPair, by_wrenches: &SVector<f64, 12>) {
        let shapes = &mut self.gradient.shapes;
        if let Some(response) = &linearized_pair.shapes
            && let Ok(gradients) = shapes.get_disjoint_mut(linearized_pair.bodies)
        {
            response.pull_back(by_wrenches, gradients);
        }
    }

    /// Adds what follows from the derivatives by dissipation and friction of the law of two bodies.
    fn add_by_law(&mut self, bodies: [usize; 2], [by_dissipation, by_friction]: [f64; 2]) {
        let model = self.model();
        let [a, b] = bodies.map(|body| model.bodies[body].material());
        let law = a
            .seeded(0)
            .combined_with(&b.seeded(3), model.slip_tolerance);
        let by = |number: usize| {
            by_dissipation * law.dissipation().eps[number]
                + by_friction * law.friction().eps[number]
        };
        for (side, body) in bodies.into_iter().enumerate() {
            let body_gradient = &mut self.gradient.bodies[body];
            body_gradient.modulus += by(3 * side);
            body_gradient.dissipation += by(3 * side + 1);
            body_gradient.friction += by(3 * side + 2);
        }
    }
}

impl Material {
    /// With modulus, dissipation and friction as variables, the first of them counted as this one.
    fn seeded(&self, first: usize) -> Material<DenseDual<6>> {
        let seed = |value: f64, index: usize| DenseDual::variable(value, first + index);
        Material {
            modulus: self.modulus.map(|modulus| seed(modulus, 0)),
            dissipation: seed(self.dissipation, 1),
            friction: self.friction.map(|friction| seed(friction, 2)),
        }
    }
}
