//! Adjoint of forces other than contact, by dual numbers with the derivatives with respect to the state of one body.

use super::BodyStateGradient;
use super::linearized_pair::WrenchGradient;
use super::pullback::{EvaluationPoint, Pullback};
use super::seeded_forces::SeededForces;
use crate::dynamics::dyn_world::{BodyDual, DynForce};
use crate::dynamics::model::Model;
use crate::dynamics::{BodyState, Motion, STATE_DIM};
use crate::scalar::{SplitMix64, lift, real_part};
use crate::spatial::{Twist, Wrench};
use nalgebra::{SVector, Vector3, Vector6};

/// Number of inputs of a force for each body, besides states: the contact wrench on the body (6), mass, modulus, dissipation and friction.
const NUMBER_COUNT: usize = 10;

/// Variables with the value 0, numbered from `first`.
fn seeds<const COUNT: usize>(first: usize) -> SVector<BodyDual, COUNT> {
    SVector::from_fn(|i, _| BodyDual::variable(0.0, first + i))
}

impl Pullback<'_> {
    /// Propagates the gradient with respect to the wrenches of forces about the centers of mass. Forces may depend on the net contact
    /// wrenches. This part of the gradient is added to `by_contact`.
    pub(super) fn pull_back_forces(
        &mut self,
        point: EvaluationPoint,
        by_wrenches: &[WrenchGradient],
        by_contact: &mut [WrenchGradient],
    ) {
        let Some(SeededForces { model, coupled }) = &mut self.forces else {
            return;
        };
        let mut seeded =
            SeededForceContext::of(point, model, (self.world.real_forces(), by_wrenches));
        for body in point.bodies {
            if coupled.binary_search(body).is_ok() {
                let by_state = seeded.by_state(*body);
                self.states[*body].add(&BodyStateGradient::from_vector(&by_state));
            }
        }
        let all: Vec<usize> = (0..by_contact.len()).collect();
        seeded.visit_number_gradients(&all, &mut |body, by_numbers| {
            by_contact[body] += Wrench::from_vector(&by_numbers.fixed_rows::<6>(0).into_owned());
            let body_gradient = &mut self.gradient.bodies[body];
            body_gradient.mass += by_numbers[6];
            body_gradient.modulus += by_numbers[7];
            body_gradient.dissipation += by_numbers[8];
            body_gradient.friction += by_numbers[9];
        });
        self.gradient.gravity += seeded.by_gravity();
        let numbers = self.gradient.force_parameters.iter_mut();
        for (sum, by_number) in numbers.zip(seeded.by_force_parameters()) {
            *sum += by_number;
        }
    }
}

/// Inputs of the forces at one evaluation point, which are seeded for differentiation.
struct SeededForceContext<'a> {
    time: f64,
    model: &'a mut Model<BodyDual>,
    states: Vec<BodyState<BodyDual>>,
    contact: Vec<Wrench<BodyDual>>,
    forces: &'a dyn DynForce,
    by_wrenches: &'a [WrenchGradient],
}

impl<'a> SeededForceContext<'a> {
    fn of(
        point: EvaluationPoint,
        model: &'a mut Model<BodyDual>,
        (forces, by_wrenches): (&'a dyn DynForce, &'a [WrenchGradient]),
    ) -> Self {
        let constant = |vector: &Vector3<f64>| vector.map(lift::<BodyDual>);
        let wrench = |wrench: &Wrench| Wrench {
            torque: constant(&wrench.torque),
            force: constant(&wrench.force),
        };
        Self {
            time: point.time,
            model,
            states: point.states.iter().map(BodyState::lifted).collect(),
            contact: point.net.iter().map(wrench).collect(),
            forces,
            by_wrenches,
        }
    }

    /// Gradient with respect to the state of a body.
    fn by_state(&mut self, body: usize) -> SVector<f64, STATE_DIM> {
        let constant = self.states[body];
        let state = &mut self.states[body];
        state.pose = state.pose.moved_by(&Twist::from_vector(&seeds::<6>(0)));
        state.twist = Twist::from_vector(&(state.twist.to_vector() + seeds::<6>(6)));
        let gradient = self.seeded_derivatives();
        self.states[body] = constant;
        gradient
    }

    fn by_gravity(&mut self) -> Vector3<f64> {
        let constant = self.model.gravity;
        self.model.gravity += seeds::<3>(0);
        let gradient = self.seeded_derivatives();
        self.model.gravity = constant;
        gradient.fixed_rows::<3>(0).into_owned()
    }

    /// Derivative with respect to each force parameter.
    fn by_force_parameters(&mut self) -> Vec<f64> {
        let mut gradient = Vec::new();
        for first in (0..self.model.force_parameters.len()).step_by(STATE_DIM) {
            let seeded = self.model.force_parameters.iter_mut().skip(first);
            for ((_, number), seed) in seeded.zip(&seeds::<STATE_DIM>(0)) {
                *number += *seed;
            }
            gradient.extend_from_slice(self.seeded_derivatives().as_slice());
            for (_, number) in &mut self.model.force_parameters {
                *number = lift(real_part(*number));
            }
        }
        gradient
    }

    /// Calls `visit` for the bodies of a list whose gradient with respect to their [`NUMBER_COUNT`]
    /// numbers is not zero. To find these bodies, the list is divided into parts. A part is skipped
    /// if its derivative along one generic direction is zero. Most parts are skipped, because most
    /// forces depend on none of the numbers.
    fn visit_number_gradients(
        &mut self,
        bodies: &[usize],
        visit: &mut impl FnMut(usize, &SVector<f64, STATE_DIM>),
    ) {
        if let [body] = *bodies {
            let gradient = self.by_numbers(&[bodies], |_, number| BodyDual::variable(0.0, number));
            visit(body, &gradient);
            return;
        }
        let parts: Vec<&[usize]> = bodies
            .chunks(bodies.len().div_ceil(STATE_DIM).max(1))
            .collect();
        let mut direction = SplitMix64::default();
        let slopes = self.by_numbers(&parts, |part, _| {
            BodyDual::variable(0.0, part) * direction.next()
        });
        for (part, slope) in parts.into_iter().zip(&slopes) {
            if *slope != 0.0 {
                self.visit_number_gradients(part, visit);
            }
        }
    }

    /// Derivatives with respect to the numbers of all bodies, divided into parts. `seed` gets the part of a body and the index of the
    /// number.
    fn by_numbers(
        &mut self,
        parts: &[&[usize]],
        mut seed: impl FnMut(usize, usize) -> BodyDual,
    ) -> SVector<f64, STATE_DIM> {
        let mut constants = Vec::new();
        for (part, bodies) in parts.iter().enumerate() {
            for &body in *bodies {
                constants.push((body, self.model.bodies[body].clone(), self.contact[body]));
                let seeds = SVector::from_fn(|number, _| seed(part, number));
                self.seed_numbers(body, &seeds);
            }
        }
        let gradient = self.seeded_derivatives();
        for (body, constant, wrench) in constants {
            self.model.bodies[body] = constant;
            self.contact[body] = wrench;
        }
        gradient
    }

    fn seed_numbers(&mut self, body: usize, seeds: &SVector<BodyDual, NUMBER_COUNT>) {
        let wrench = &mut self.contact[body];
        *wrench = Wrench::from_vector(&(wrench.to_vector() + seeds.fixed_rows::<6>(0)));
        let seeded = &mut self.model.bodies[body];
        if let Motion::Dynamic { inertia, .. } = &mut seeded.motion {
            inertia.mass += seeds[6];
        }
        if let Some(modulus) = &mut seeded.material.modulus {
            *modulus += seeds[7];
        }
        seeded.material.dissipation += seeds[8];
        if let Some(friction) = &mut seeded.material.friction {
            *friction += seeds[9];
        }
    }

    /// Derivatives with respect to the seeds.
    fn seeded_derivatives(&self) -> SVector<f64, STATE_DIM> {
        let mut sums = vec![Wrench::zero(); self.by_wrenches.len()];
        let inputs = (self.time, &*self.states, &*self.contact);
        self.model.with_forces(inputs, &mut sums, |wrenches, now| {
            self.forces.add_seeded(wrenches, now);
        });
        let mut gradient = SVector::zeros();
        for (by_wrench, wrench) in self.by_wrenches.iter().zip(&sums) {
            let numbers: Vector6<BodyDual> = wrench.to_vector();
            for (factor, number) in by_wrench.to_vector().iter().zip(&numbers) {
                // A wrench without influence may have derivatives that are not finite, so it is skipped.
                if *factor != 0.0 {
                    gradient += SVector::from(number.eps) * *factor;
                }
            }
        }
        gradient
    }
}
