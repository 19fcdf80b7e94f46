//! The check of the time step during a rollout: which rollouts it ends, and which it does not affect.

use super::scenes::falling_cube;
use crate::support::worlds::{EXPLICIT, at, cuboid, dynamic, falling, fixed, icosphere, plan_of};
use hydroelastic::contact::HalfSpace;
use hydroelastic::dynamics::{Batch, Body, Mass, Material, Plan, RolloutError, State, World};
use hydroelastic::gradient::{Experiment, FinalPosition, GradientError, Parameter};
use nalgebra::vector;
use num_dual::Dual64;
use std::sync::Arc;

const TOO_LONG: f64 = 6e-3;
const SHORT_ENOUGH: f64 = 3e-3;

/// Returns the step, time and limit at which a rollout ended.
fn ended(error: &RolloutError) -> (usize, f64, f64) {
    let RolloutError::TimeStepTooLong {
        step,
        time,
        time_step,
        limit,
        bodies,
    } = error
    else {
        panic!("{error}")
    };
    assert_eq!(time_step.to_bits(), TOO_LONG.to_bits());
    assert_eq!(bodies, &["cube", "slab"]);
    (*step, *time, *limit)
}

#[test]
fn a_rollout_whose_step_is_too_long_ends_before_the_first_kick_that_shows_it() {
    let world = falling_cube();
    let plan = Plan::new(TOO_LONG, 0).unwrap();
    let mut rollout = world.rollout(&plan);
    let states: Vec<State> = rollout.by_ref().map_while(Result::ok).collect();
    let (step, time, limit) = ended(&rollout.advance().unwrap_err());
    // A fall of 5 mm takes 31.9 ms. The middle of the sixth step is the first point in the slab at which a kick acts.
    assert_eq!((states.len(), step), (5, 6));
    assert_eq!(time.to_bits(), rollout.state().time.to_bits());
    let mut there = rollout.state().clone();
    let fall = there.bodies[0].twist.linear * (TOO_LONG / 2.0);
    let pose = &mut there.bodies[0].pose;
    *pose = pose.with_translation(pose.translation() + fall);
    let expected = world.largest_stable_step(&there).unwrap().unwrap();
    assert!(
        (limit / expected - 1.0).abs() < 1e-12,
        "{limit:e} {expected:e}"
    );
    assert!(limit < TOO_LONG);
    assert!(rollout.next().is_none());
    let message = rollout.advance().unwrap_err().to_string();
    assert!(message.contains("6.000e-3 s exceeds"), "{message}");
    assert!(message.contains("\"cube\" and \"slab\""), "{message}");
}

/// A light ball hits the floor at 3 m/s in steps of 1 ms. The impact lasts two steps, one step, or a fraction of a step.
#[test]
fn impacts_that_would_make_energy_are_stopped() {
    /// At half the limit, the energy of an undamped oscillation varies by a third; at the limit, by any amount.
    const MOST: f64 = 1.5;
    let ball = Arc::new(icosphere(0.1, 1));
    let slab = Arc::new(cuboid([4.0, 4.0, 0.4]));
    for modulus in [1e6, 1e7, 1e8, 1e9, 1e10, 1e11] {
        let skin = Material::elastic(modulus);
        let (mut stopped, mut worst, mut unchecked) = (0, 0.0_f64, 0.0_f64);
        for phase in 0..100 {
            let height = 0.12 + 3e-5 * f64::from(phase);
            let ball = dynamic("ball", Arc::clone(&ball), skin, 0.1);
            let slab = fixed("slab", Arc::clone(&slab), skin);
            let world = World::new(vec![
                ball.with_pose(at(0.0, 0.0, height))
                    .with_velocity(vector![0.0, 0.0, -3.0]),
                slab.with_pose(at(0.013, 0.021, -0.2)),
            ])
            .unwrap();
            let checked = Plan::new(1e-3, 40).unwrap().recording_every(40);
            let plan = checked.without_stability_check();
            let energy = |end: &State| (end.bodies[0].twist.linear.norm() / 3.0).powi(2);
            unchecked = unchecked.max(energy(world.rollout(&plan).run().unwrap().last()));
            match world.rollout(&checked).run() {
                Ok(trajectory) => worst = worst.max(energy(trajectory.last())),
                Err(_) => stopped += 1,
            }
        }
        println!("{modulus:e} Pa: {stopped} stopped, energy {worst:.3}, unchecked {unchecked:.3}");
        assert!(worst < MOST, "{modulus:e} Pa: {worst}");
        assert_eq!(stopped > 0, unchecked > MOST, "{modulus:e} Pa: {stopped}");
    }
}

#[test]
fn what_was_recorded_before_is_kept() {
    let world = falling_cube();
    let plan = Plan::new(TOO_LONG, 100).unwrap();
    let step = 6;
    for every in [1, 2, 4] {
        let plan = plan.recording_every(every);
        let interrupted = world.rollout(&plan).run().unwrap_err();
        assert_eq!(ended(&interrupted.error).0, step);
        let recorded = interrupted.trajectory.states().len();
        assert_eq!(recorded, 1 + (step - 1) / every);
    }
    let rollout = world.rollout(&plan.without_stability_check());
    assert!(rollout.run().is_ok());
}

#[test]
fn a_rollout_whose_step_is_short_enough_goes_on_with_the_same_states() {
    let world = falling_cube();
    let plan = Plan::new(SHORT_ENOUGH, 200).unwrap();
    let checked = world.rollout(&plan).run().unwrap();
    let unchecked = world.rollout(&plan.without_stability_check());
    let unchecked = unchecked.run().unwrap();
    for (checked, unchecked) in checked.states().iter().zip(unchecked.states()) {
        let [a, b] = [checked, unchecked].map(|state| state.bodies[0].position().z);
        assert_eq!(a.to_bits(), b.to_bits());
    }
}

#[test]
fn batches_and_experiments_check_too_and_so_do_dual_numbers() {
    let world = falling_cube();
    let lifted = world.lifted::<Dual64>();
    let plan = Plan::new(TOO_LONG, 100).unwrap();
    let unchecked = Batch::new(&plan.without_stability_check());
    assert!(unchecked.rollouts(std::slice::from_ref(&world))[0].is_ok());
    let batch = Batch::new(&plan);
    let results = batch.rollouts(std::slice::from_ref(&lifted));
    assert_eq!(ended(&results[0].as_ref().unwrap_err().error).0, 6);

    let outcome = FinalPosition::of_body(&world, "cube").unwrap();
    let by = [Parameter::initial_velocity("cube")];
    let of_samples = batch.map(&[[0.0; 3]], |job, sample| {
        job.experiment(world.perturbed(&by, sample)?)
            .gradient(&by, &outcome)
    });
    let experiment = Experiment::new(&world, &plan);
    let errors = [
        of_samples[0].as_ref().unwrap_err().clone(),
        experiment.jacobian(&by, &outcome).unwrap_err(),
        experiment.value(&outcome).unwrap_err(),
    ];
    for error in errors {
        let GradientError::Rollout(error) = error else {
            panic!("{error}")
        };
        assert_eq!(ended(&error).0, 6);
    }
}

/// The scene is a light, stiff ball with the time steps of robot simulators. Without the check, a default plan threw the ball to 845 m.
#[test]
fn default_plans_end_with_an_error_that_names_the_remedy_or_give_a_correct_motion() {
    let ball = Arc::new(icosphere(0.1, 2));
    let (mut ended, mut right) = (0, 0);
    for (modulus, mass, height, friction) in [
        (1e7, 0.01, 0.2, 0.5),
        (1e7, 0.01, 0.13, 0.0),
        (1e6, 0.1, 0.2, 0.5),
        (1e5, 1.0, 0.15, 0.0),
        (1e5, 10.0, 0.2, 0.0),
        (1e6, 1.0, 0.2, 0.0),
        (1e9, 1.0, 0.3, 0.0),
    ] {
        for (time_step, steps) in [
            (5e-3, 200),
            (2e-3, 500),
            (1e-3, 1_000),
            (5e-4, 2_000),
            (1e-4, 10_000),
        ] {
            for integrator in EXPLICIT {
                let skin = Material::elastic(modulus).with_friction(friction);
                let hard = Material::rigid().with_friction(friction);
                let ball = Body::dynamic("ball", Arc::clone(&ball), skin, Mass::Total(mass));
                let world = falling(vec![
                    ball.unwrap().with_pose(at(0.0, 0.0, height)),
                    fixed("floor", HalfSpace::rigid(), hard),
                ]);
                let plan = plan_of(integrator, time_step, steps);
                match world.rollout(&plan).run() {
                    Err(interrupted) => {
                        let message = interrupted.error.to_string();
                        let states = interrupted.trajectory.states();
                        assert!(message.contains("Sdirk3") && message.contains("shorter"));
                        assert!(
                            states
                                .iter()
                                .all(|state| state.bodies[0].position().z < 1.02 * height)
                        );
                        ended += 1;
                    }
                    Ok(trajectory) => {
                        let states = trajectory.states().iter();
                        let highest = states.clone().map(|state| state.bodies[0].position().z);
                        let highest = highest.skip(states.len() / 2).fold(0.0, f64::max);
                        let rise = (highest - 0.1) / (height - 0.1);
                        println!("{modulus:e} {mass} {height} {time_step} {integrator:?}: {rise}");
                        assert!(rise > 0.6 && rise < 1.3, "{rise}");
                        right += 1;
                    }
                }
            }
        }
    }
    println!("{ended} {right}");
    assert!(ended > 5 && right > 5);
}

/// A small, fast ball hits a thin plate. A step moves it into the plate or through the plate.
#[test]
fn steps_that_lead_through_a_plate_make_no_energy() {
    let ball = Arc::new(icosphere(0.01, 2));
    let plate = Arc::new(cuboid([0.2, 0.2, 0.01]));
    let mut reasons = [0; 3];
    for modulus in [1e5, 1e6, 1e7, 1e9] {
        for phase in 0..60 {
            let skin = Material::elastic(modulus);
            let height = 0.03 + 4.2e-4 * f64::from(phase);
            let ball = Body::dynamic("ball", Arc::clone(&ball), skin, Mass::Density(1000.0));
            let world = World::new(vec![
                ball.unwrap()
                    .with_pose(at(0.001, 0.002, height))
                    .with_velocity(vector![0.0, 0.0, -5.0]),
                fixed("plate", Arc::clone(&plate), skin),
            ]);
            let plan = Plan::new(5e-3, 8).unwrap();
            match world.unwrap().rollout(&plan).run() {
                Ok(trajectory) => {
                    let speed = trajectory.last().bodies[0].twist.linear.norm();
                    // Twice the energy, and the energy of a fall during a step.
                    assert!(speed < 5.1 * 2_f64.sqrt(), "{speed}");
                    reasons[0] += 1;
                }
                Err(interrupted) => match interrupted.error {
                    RolloutError::TimeStepTooLong { .. } => reasons[1] += 1,
                    RolloutError::EnergyGained {
                        absorbed, returned, ..
                    } => {
                        assert!(returned > 2.0 * absorbed);
                        reasons[2] += 1;
                    }
                    unexpected => panic!("{unexpected}"),
                },
            }
        }
    }
    println!("{reasons:?}");
    assert!(reasons.iter().all(|&count| count > 0), "{reasons:?}");
}
