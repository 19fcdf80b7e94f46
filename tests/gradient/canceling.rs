//! Losses and forces that combine several states and bodies with canceling factors. The dependence must still be detected.

use super::reverse::{compare, skin};
use crate::support::worlds::{falling, icosphere, plan_of};
use hydroelastic::contact::HalfSpace;
use hydroelastic::dynamics::{
    Body, Force, ForceContext, Integrator, Mass, Plan, Trajectory, World, WrenchAccumulator,
};
use hydroelastic::gradient::{Outcome, Parameter};
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::sync::Arc;

/// Returns `count` balls that sink into a floor, each slightly smaller than the previous ball, and the floor.
fn balls(count: usize) -> World {
    let shape = Arc::new(icosphere(0.1, 1));
    let law = [0.1, 0.3];
    let ball = |index: usize| {
        let (name, along) = (index.to_string(), index as f64);
        let body = Body::dynamic(&name, Arc::clone(&shape), skin(1e5, law), Mass::Total(1.0));
        let at = vector![0.5 * along, 0.0, 0.09 + 3e-4 * along];
        let start = Pose::from_rotation_vector(&(Vector3::x() * 0.3), at);
        body.unwrap()
            .with_pose(start)
            .with_velocity(vector![0.1, 0.2, -0.3])
    };
    let floor = Body::fixed("floor", HalfSpace::layer(0.05).unwrap(), skin(1e6, law));
    let mut bodies: Vec<Body> = (0..count).map(ball).collect();
    bodies.push(floor.unwrap());
    falling(bodies).with_slip_tolerance(0.05).unwrap()
}

/// Upward acceleration (m/s²) of the first body around a recorded state, by a second difference.
struct Acceleration {
    record: usize,
    time_step: f64,
}

impl Outcome for Acceleration {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let height = |record: usize| trajectory.states()[record].bodies[0].position().z;
        let [before, here, after] = [self.record - 1, self.record, self.record + 1].map(height);
        let change = after - here * lift::<T>(2.0) + before;
        vec![change / lift::<T>(self.time_step * self.time_step)]
    }
}

#[test]
fn differences_of_states_in_time() {
    let (world, time_step) = (balls(1), 1e-3);
    let plan = Plan::new(time_step, 100).unwrap();
    let parameters = [
        Parameter::initial_position("0"),
        Parameter::initial_velocity("0"),
        Parameter::modulus("0"),
    ];
    for record in 1..100 {
        compare(
            &world,
            &plan,
            &parameters,
            &Acceleration { record, time_step },
        );
    }
}

/// Force on the third body: the difference between the contact forces on the first and the second body, and between their masses.
struct Balance;

impl Force for Balance {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        let mass = |body: usize| now.bodies[body].inertia().unwrap().mass;
        let more = now.contact[0].force - now.contact[1].force;
        let heavier = now.gravity * (mass(0) - mass(1));
        wrenches.apply_force_at_com(2, &(more + heavier));
    }
}

/// Final height (m) of the third body.
struct Height;

impl Outcome for Height {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        vec![trajectory.last().bodies[2].position().z]
    }
}

#[test]
fn differences_of_bodies_that_forces_see() {
    for count in [3, 11, 12, 30] {
        let world = balls(count).with_forces(Balance).unwrap();
        let mut parameters = Vec::new();
        for name in ["0", "1", "2"] {
            parameters.push(Parameter::initial_position(name));
            parameters.push(Parameter::mass(name));
            parameters.push(Parameter::modulus(name));
        }
        for integrator in [Integrator::Leapfrog, Integrator::Sdirk3] {
            let plan = plan_of(integrator, 1e-3, 20);
            compare(&world, &plan, &parameters, &Height);
        }
    }
}
