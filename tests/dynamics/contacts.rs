//! Contacts of a state: touching bodies and their contact forces.

use crate::scenes::GRAVITY;
use crate::support::worlds::{at, cuboid, dynamic, falling, fixed, icosphere, plan_of, rubbing};
use hydroelastic::dynamics::{Integrator, World};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::sync::Arc;

/// Relative rounding error of a velocity after one step, computed from its forces.
const ROUNDING: f64 = 1e-12;

const MASS: f64 = 0.5;
/// Returns two balls with friction, one on the floor and one on top, and a third ball far away.
fn pile() -> World {
    let skin = rubbing(1e5, 0.2, 0.5);
    let shape = Arc::new(icosphere(0.1, 2));
    let ball = |name, place| {
        dynamic(name, Arc::clone(&shape), skin, MASS).with_pose(Pose::from_translation(place))
    };
    let floor = cuboid([2.0, 2.0, 0.2]);
    falling(vec![
        ball("upper", vector![0.0, 0.0, 0.285]).with_velocity(vector![0.3, 0.1, -0.2]),
        ball("lower", vector![0.0, 0.0, 0.095]),
        fixed("floor", floor, skin).with_pose(at(0.0, 0.0, -0.1)),
        ball("away", vector![0.7, 0.0, 0.5]),
    ])
}

#[test]
fn contacts_are_those_of_bodies_that_touch() {
    let world = pile();
    let contacts = world.contacts(&world.initial_state()).unwrap();
    let bodies: Vec<_> = contacts.iter().map(|contact| contact.bodies).collect();
    assert_eq!(bodies, [[0, 1], [1, 2]]);
    assert!(contacts.iter().all(|contact| contact.surface.area() > 0.0));

    let ignoring = pile().with_ignored("floor", "lower").unwrap();
    let contacts = ignoring.contacts(&ignoring.initial_state()).unwrap();
    assert_eq!(contacts.len(), 1);
}

#[test]
fn forces_of_contacts_are_those_that_a_step_feels() {
    let world = pile();
    let start = world.initial_state();
    let time_step = 1e-4;
    let mut rollout = world.rollout(&plan_of(Integrator::SymplecticEuler, time_step, 1));
    let after = rollout.next().unwrap().unwrap();

    let mut forces = [Vector3::zeros(); 4];
    for contact in world.contacts(&start).unwrap() {
        let [a, b] = contact.bodies;
        forces[a] += contact.wrench.on_a.force;
        forces[b] += contact.wrench.on_b.force;
    }
    for body in [0, 1, 3] {
        let gained = after.bodies[body].velocity() - start.bodies[body].velocity();
        let expected = (forces[body] / MASS - Vector3::z() * GRAVITY) * time_step;
        let error = (gained - expected).norm();
        assert!(error < ROUNDING * start.bodies[0].velocity().norm());
    }
    // The upper ball slides over the lower ball, so the forces include friction.
    assert!(forces[0].x < 0.0 && forces[0].norm() > MASS * GRAVITY);
}
