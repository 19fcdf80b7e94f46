//! User-defined forces: the resulting motion and derivatives.

use crate::scenes::{GRAVITY, ROUND_OFF, at, ball};
use crate::support::worlds::{IMPLICIT, falling, plan_of};
use hydroelastic::dynamics::{
    Body, Force, ForceContext, Plan, RolloutError, World, WorldError, WrenchAccumulator,
};
use hydroelastic::gradient::{Experiment, FinalState, Parameter};
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::{Twist, Wrench};
use nalgebra::{Vector3, vector};

/// Linear drag with a coefficient (N s/m).
struct ViscousAir(f64);

impl Force for ViscousAir {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        for (body, state) in now.states.iter().enumerate() {
            wrenches.apply_force_at_com(body, &(state.twist.linear * lift::<T>(-self.0)));
        }
    }
}

type AiryWorld = World<f64, ViscousAir>;

/// Drag (N s/m) and mass (kg): velocities decay in 0.5 s.
const DRAG: f64 = 2.0;
const RELAXATION: f64 = 1.0 / DRAG;

fn in_air(velocity: f64, gravity: f64) -> AiryWorld {
    let thrown = ball("ball").with_velocity(vector![velocity, 0.0, 0.0]);
    let world = World::new(vec![thrown]).unwrap();
    let world = world.with_gravity(vector![-gravity, 0.0, 0.0]).unwrap();
    world.with_forces(ViscousAir(DRAG)).unwrap()
}

fn final_speed(world: &AiryWorld, steps: usize, duration: f64) -> f64 {
    let mut rollout = world.rollout(&Plan::new(duration / steps as f64, steps).unwrap());
    let last = rollout.nth(steps - 1).unwrap().unwrap();
    last.bodies[0].twist.linear.x
}

#[test]
fn a_ball_in_viscous_air_falls_at_its_terminal_velocity() {
    let speed = final_speed(&in_air(0.0, GRAVITY), 20_000, 20.0);
    assert!((speed + GRAVITY * RELAXATION).abs() < ROUND_OFF, "{speed}");
}

#[test]
fn drag_decays_exponentially_to_first_order_in_the_time_step() {
    let exact = 3.0 * (-1.0 / RELAXATION).exp();
    let error = |steps| final_speed(&in_air(3.0, 0.0), steps, 1.0) / exact - 1.0;
    // To first order, the relative error is half the duration times the step over RELAXATION².
    let (coarse, fine) = (error(1_000), error(10_000));
    assert!(
        (fine / (-0.5 * 1e-4 / RELAXATION.powi(2)) - 1.0).abs() < 1e-3,
        "{fine:e}"
    );
    assert!((coarse / fine / 10.0 - 1.0).abs() < 1e-2, "{coarse:e}");
}

#[test]
fn derivatives_flow_through_forces_of_the_users_own() {
    let (speed, steps, time_step) = (3.0, 1_000, 1e-3_f64);
    let world = in_air(speed, 0.0);
    let experiment = Experiment::new(&world, &Plan::new(time_step, steps).unwrap());
    let parameters = [
        Parameter::initial_velocity("ball"),
        Parameter::mass("ball"),
        Parameter::Gravity,
    ];
    let outcome = FinalState::of_body(&world, "ball").unwrap();
    let jacobian = experiment.jacobian(&parameters, &outcome).unwrap().jacobian;
    let (position, velocity) = (0, 12);
    // In the scheme, each kick leaves a fraction q of the velocity, and each step moves by the mean velocity.
    let q = 1.0 - time_step / RELAXATION;
    let kept_share = q.powi(i32::try_from(steps).unwrap());
    let distance = time_step * (1.0 + q) / 2.0 * (1.0 - kept_share) / (1.0 - q);
    assert!((jacobian[(velocity, 0)] - kept_share).abs() < ROUND_OFF);
    assert!((jacobian[(position, 0)] - distance).abs() < ROUND_OFF);
    // In the exact motion, v = v₀ exp(−c t/m), with derivatives with respect to the mass m and gravity g.
    let decayed = (-1.0 / RELAXATION).exp();
    let by_mass = speed * DRAG * decayed;
    let by_gravity = RELAXATION * (1.0 - decayed);
    assert!((jacobian[(velocity, 3)] / by_mass - 1.0).abs() < 2e-3);
    assert!((jacobian[(velocity, 4)] / by_gravity - 1.0).abs() < 2e-3);
    let check = experiment.difference_check(&parameters, &outcome).unwrap();
    assert!(check.best() < 1e-8, "{check}");
}

/// Thrust along x on the body named "rocket" that grows with time (m/s³), and no gravity. As in the paper, a body's accelerations are a
/// function of the accelerations due to contact.
struct Rocket(f64);

impl Rocket {
    fn true_acceleration<T: Scalar>(&self, time: f64, body: &str, contact: Twist<T>) -> Twist<T> {
        let mut linear = contact.linear;
        if body == "rocket" {
            linear.x += lift::<T>(self.0 * time);
        }
        Twist { linear, ..contact }
    }
}

impl Force for Rocket {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        for (index, body) in now.bodies.iter().enumerate() {
            let Some(inertia) = body.inertia() else {
                continue;
            };
            let rotation = now.states[index].pose.rotation();
            let contact = Twist {
                angular: inertia.angular_velocity(rotation, &now.contact[index].torque),
                linear: now.contact[index].force / inertia.mass,
            };
            let wanted = self.true_acceleration(now.time, body.name(), contact);
            let linear = wanted.linear - contact.linear - now.gravity;
            let angular = wanted.angular - contact.angular;
            let wrench = Wrench {
                torque: inertia.angular_momentum(rotation, &angular),
                force: linear * inertia.mass,
            };
            wrenches.add(index, &wrench);
        }
    }
}

#[test]
fn forces_of_the_users_own_know_the_time_and_the_body() {
    let rocket = ball("rocket").with_pose(at(0.0, 1.0, 0.0));
    let world = falling(vec![ball("ball"), rocket]);
    let world = world.with_forces(Rocket(4.0)).unwrap();
    let plan = Plan::new(1e-2, 100).unwrap().recording_every(100);
    let last = world.rollout(&plan).run().unwrap().last().clone();
    // Kicks are in the middle of steps, where the midpoint rule is exact for a linear force.
    let thrust = last.bodies[1].twist.linear - vector![2.0, 0.0, 0.0];
    assert!(thrust.amax() < ROUND_OFF, "{thrust}");
    assert_eq!(
        last.bodies[0].twist.linear,
        Vector3::zeros(),
        "the force cancels gravity"
    );
}

/// A force on one body that is NaN after a time (s), and returns an index from `coupling_groups`.
struct Broken {
    from: f64,
    coupled: usize,
}

impl Force for Broken {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        if now.time > self.from {
            wrenches.apply_force_at_com(1, &Vector3::x().map(|_: f64| lift::<T>(f64::NAN)));
        }
    }

    fn coupling_groups(&self, _: &[Body]) -> Vec<Vec<usize>> {
        vec![vec![self.coupled]]
    }
}

fn with_broken(force: Broken) -> Result<World<f64, Broken>, WorldError> {
    let bodies = vec![ball("one"), ball("other").with_pose(at(0.0, 1.0, 0.0))];
    World::new(bodies)?.with_forces(force)
}

#[test]
fn a_force_that_couples_an_index_out_of_range_is_refused() {
    let refused = with_broken(Broken {
        from: 1.0,
        coupled: 2,
    });
    let expected = WorldError::CoupledBody {
        index: 2,
        bodies: 2,
    };
    assert_eq!(refused.err(), Some(expected));
}

#[test]
fn implicit_steps_name_a_force_that_is_not_finite() {
    for integrator in IMPLICIT {
        let world = with_broken(Broken {
            from: 0.25,
            coupled: 1,
        });
        let plan = plan_of(integrator, 0.1, 5);
        let interrupted = world.unwrap().rollout(&plan).run().unwrap_err();
        let RolloutError::ForceNotFinite { step, time, body } = interrupted.error else {
            panic!("{integrator:?}: {}", interrupted.error);
        };
        assert_eq!((step, body.as_str()), (3, "other"));
        // The end of the last substep that was tried.
        assert!((0.25..0.26).contains(&time), "{integrator:?}: {time}");
    }
}
