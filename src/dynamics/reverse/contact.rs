//! Adjoint of the contacts of a step.

use super::BodyStateGradient;
use super::linearized_pair::{LinearizedPair, WrenchGradient};
use super::pullback::Pullback;
use crate::dynamics::{BodyState, Material};
use crate::scalar::DenseDual;
use crate::spatial::{Twist, Wrench};
use nalgebra::{SVector, Vector3, Vector6};

impl Pullback<'_> {
    /// Propagates the gradient with respect to the net contact wrenches about the centers of mass.
    pub(super) fn pull_back_contacts(
        &mut self,
        states: &[BodyState],
        contacts: &[LinearizedPair],
        by_net: &[WrenchGradient],
    ) {
        for pair in contacts {
            let [on_a, on_b] = pair
                .sides()
                .map(|(body, wrench)| self.by_wrench(body, &states[body], wrench, &by_net[body]));
            let by_both = SVector::from_fn(|i, _| if i < 6 { on_a[i] } else { on_b[i - 6] });
            self.record_kinks(pair);
            self.add_by_shapes(pair, &by_both);
            let numbers = pair.contact.pullback(&by_both);
            for (side, body) in pair.bodies.into_iter().enumerate() {
                let six = |row: usize| numbers.fixed_rows::<6>(row + 6 * side).into_owned();
                self.add_by_motion(body, &states[body], [six(0), six(12)]);
                self.gradient.bodies[body].modulus += numbers[24 + side];
            }
            if pair.is_dissipative {
                self.add_by_law(pair.bodies, [numbers[26], numbers[27]]);
            }
        }
    }

    /// Gradient with respect to a wrench about the origin of a body, from the gradient with respect to the wrench about its center of mass.
    fn by_wrench(
        &mut self,
        body: usize,
        state: &BodyState,
        wrench: &Wrench,
        by_wrench: &WrenchGradient,
    ) -> Vector6<f64> {
        let (arm, Wrench { torque, force }) = (self.model().arm(body, state), *by_wrench);
        // The torque about the center of mass is τ − arm × F.
        self.add_by_arm(body, state, &torque.cross(&wrench.force));
        let force = force + arm.cross(&torque);
        Wrench { torque, force }.to_vector()
    }

    /// Propagates the gradient with respect to the pose and the twist of the origin of a body.
    fn add_by_motion(
        &mut self,
        body: usize,
        state: &BodyState,
        [by_pose, by_twist]: [Vector6<f64>; 2],
    ) {
        let arm = self.model().arm(body, state);
        let [by_pose, by_twist] = [by_pose, by_twist].map(|six| Twist::from_vector(&six));
        let by_state = &mut self.states[body];
        by_state.add(&BodyStateGradient {
            turn: by_pose.angular,
            shift: by_pose.linear,
            spin: by_twist.angular - arm.cross(&by_twist.linear),
            velocity: by_twist.linear,
        });
        // The velocity of the origin is the velocity of the center of mass minus ω × arm.
        self.add_by_arm(body, state, &state.twist.angular.cross(&by_twist.linear));
    }

    /// Propagates the gradient with respect to the arm from the origin of a body to its center of mass, in world axes.
    fn add_by_arm(&mut self, body: usize, state: &BodyState, by_arm: &Vector3<f64>) {
        if self.model().bodies[body].inertia().is_some() {
            let arm = self.model().arm(body, state);
            self.states[body].add_by_arm(&arm, by_arm);
            self.gradient.bodies[body].center += state.pose.rotation().tr_mul(by_arm);
        }
    }

    /// Records the kinks of a contact in this step.
    fn record_kinks(&mut self, pair: &LinearizedPair) {
        let kinks = pair.contact.kinks;
        if kinks.is_any() {
            let (gradient, step) = (&mut self.gradient, self.step);
            gradient.record_contact_kinks(pair.bodies, kinks, step);
        }
    }

    /// Propagates the gradient with respect to the wrenches of a contact to the shapes, if requested.
    fn add_by_shapes(&mut self, pair: &LinearizedPair, by_wrenches: &SVector<f64, 12>) {
        let shapes = &mut self.gradient.shapes;
        if let Some(response) = &pair.shapes
            && let Ok(gradients) = shapes.get_disjoint_mut(pair.bodies)
        {
            response.pull_back(by_wrenches, gradients);
        }
    }

    /// Propagates the gradient with respect to dissipation and friction of the contact law of two bodies.
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
    /// Material with modulus, dissipation and friction as variables, numbered from `first`.
    fn seeded(&self, first: usize) -> Material<DenseDual<6>> {
        let seed = |value: f64, index: usize| DenseDual::variable(value, first + index);
        Material {
            modulus: self.modulus.map(|modulus| seed(modulus, 0)),
            dissipation: seed(self.dissipation, 1),
            friction: self.friction.map(|friction| seed(friction, 2)),
        }
    }
}
