use crate::tosses::{TRUTH, clean, noise, noisy, nuisances, plan, unknowns, world};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Integrator, Joint, Mass, Material, Plan, World};
use hydroelastic::gradient::{JointQuantity, Parameter};
use hydroelastic::identification::{
    Identification, Measurement, Nuisance, StartingState, Termination, Unknown,
};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::MassProperties;
use nalgebra::{Matrix3, Vector3, vector};
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};

/// A guess that is wrong by factors of 2.
const GUESS: [f64; 3] = [2e5, 0.5, 0.1];
/// Relative error of estimates from recordings without noise. The fit ends at a predicted decrease of 1e-3 in ½χ². The last step leaves
/// a smaller error, because convergence is quadratic.
const CLEAN: f64 = 1e-4;

fn assert_near(values: &[f64], expected: &[f64], relative: f64) {
    assert_eq!(values.len(), expected.len());
    for (value, expected) in values.iter().zip(expected) {
        let error = (value / expected - 1.0).abs();
        assert!(error < relative, "{value} instead of {expected}");
    }
}

#[test]
fn clean_recordings_give_the_true_values() {
    let identification = Identification::new(&world(GUESS), &plan(), &unknowns()).unwrap();
    let fit = identification.with_noise(noise()).fit(&clean(3)).unwrap();
    assert_eq!(fit.termination, Termination::Converged);
    assert_near(&fit.values(), &TRUTH, CLEAN);
}

#[test]
fn errors_of_initial_states_do_not_bias_estimates() {
    let identification = Identification::new(&world(GUESS), &plan(), &unknowns()).unwrap();
    let identification = identification.with_noise(noise());
    let identification = identification.with_nuisances(&nuisances()).unwrap();
    let measurements = noisy(&clean(4), 0);
    let fit = identification.fit(&measurements).unwrap();
    // Four standard deviations.
    for (estimate, truth) in fit.estimates.iter().zip(TRUTH) {
        let [lower, upper] = estimate.interval.map(f64::ln);
        let deviation = (upper - lower) / 3.92;
        assert!(
            (estimate.value / truth).ln().abs() < 4.0 * deviation,
            "{estimate}"
        );
    }
    // Each prediction from a fitted start is nearer to the recording than one from the measured start.
    for measurement in &measurements {
        let error = |start| {
            let prediction = identification
                .predict(&fit.values(), measurement, start)
                .unwrap();
            let errors = prediction.position_errors.iter().flatten();
            errors.map(|error| error * error).sum::<f64>()
        };
        assert!(error(StartingState::Fitted(0.15)) < error(StartingState::Measured));
    }
}

#[test]
fn predictions_at_the_true_values_have_no_errors() {
    let identification = Identification::new(&world(GUESS), &plan(), &unknowns()).unwrap();
    for measurement in clean(2) {
        let prediction = identification
            .predict(&TRUTH, &measurement, StartingState::Measured)
            .unwrap();
        let errors = prediction
            .position_errors
            .iter()
            .chain(&prediction.rotation_errors);
        assert_eq!(prediction.position_errors.len(), 31);
        assert!(errors.flatten().all(|&error| error < 1e-9));
    }
}

#[test]
fn a_direction_without_information_is_named() {
    // Motions under contact and gravity depend on the ratio of modulus and mass only.
    let unknowns = [Parameter::modulus("ball"), Parameter::mass("ball")];
    let unknowns = unknowns.map(|parameter| Unknown::new(parameter).logarithmic());
    let identification = Identification::new(&world(TRUTH), &plan(), &unknowns).unwrap();
    let fit = identification.with_noise(noise()).fit(&clean(2)).unwrap();
    let [least, most] = &fit.directions[..] else {
        panic!("two unknowns have two directions");
    };
    assert!(least.standard_deviation > 1e3 * most.standard_deviation);
    for (_, weight) in &least.weights {
        assert!((weight.abs() - 0.5_f64.sqrt()).abs() < 1e-3);
    }
    assert!(least.weights[0].1 * least.weights[1].1 > 0.0);
    assert!(
        least.to_string().contains("+0.71 the mass of \"ball\""),
        "{least}"
    );
}

#[test]
fn an_unknown_without_effect_has_an_infinite_interval() {
    let unknown = Unknown::new(Parameter::dissipation("table"));
    let identification = Identification::new(&world(TRUTH), &plan(), &[unknown]).unwrap();
    let fit = identification.fit(&clean(1)).unwrap();
    assert_eq!(fit.termination, Termination::Converged);
    assert!(fit.directions[0].standard_deviation.is_infinite());
    assert!(fit.estimates[0].interval[1].is_infinite());
}

#[test]
fn an_unknown_without_effect_does_not_change_the_intervals_of_other_unknowns() {
    let fit_of = |unknowns: &[Unknown]| {
        let identification = Identification::new(&world(GUESS), &plan(), unknowns).unwrap();
        let fit = identification.with_noise(noise()).fit(&clean(3));
        fit.unwrap().estimates
    };
    let without = fit_of(&unknowns());
    let mut unknowns = unknowns().to_vec();
    unknowns.insert(1, Unknown::new(Parameter::dissipation("table")));
    let mut with = fit_of(&unknowns);
    let no_effect = with.remove(1);
    assert!(no_effect.interval[1].is_infinite() && no_effect.sandwich_interval[1].is_infinite());
    assert_eq!(with, without);
}

#[test]
fn a_fit_continues_from_its_checkpoint() {
    let identification = Identification::new(&world(GUESS), &plan(), &unknowns()).unwrap();
    let identification = identification
        .with_noise(noise())
        .with_horizons(&[0.15])
        .unwrap();
    let whole = identification.fit(&clean(2)).unwrap();
    let last = Arc::new(Mutex::new(None));
    let seen = Arc::clone(&last);
    let stopped = identification.clone().with_progress(move |iteration| {
        *seen.lock().unwrap() = Some(iteration.checkpoint.clone());
        if iteration.index == 3 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    let stopped = stopped.fit(&clean(2)).unwrap();
    assert_eq!(stopped.termination, Termination::Stopped);
    let checkpoint = last.lock().unwrap().take().unwrap();
    assert_eq!(checkpoint, stopped.checkpoint);
    let resumed = identification.resume(&clean(2), checkpoint).unwrap();
    assert_near(&resumed.values(), &whole.values(), CLEAN);
}

#[test]
fn the_height_of_a_table_and_its_tilt_are_found() {
    let mut tilted = world(TRUTH).initial_state();
    let (height, tilt) = (0.003, 0.02);
    tilted.bodies[0].twist.linear = vector![0.5, 0.3, -0.5];
    let table = [
        Parameter::initial_position("table"),
        Parameter::initial_orientation("table"),
    ];
    let truth = world(TRUTH).with_initial_state(&tilted).unwrap();
    let moved = truth
        .perturbed(&table, &[0.0, 0.0, height, 0.0, tilt, 0.0])
        .unwrap();
    let recorded = Measurement::new("toss", moved.rollout(&plan()).run().unwrap());
    let [position, orientation] = table;
    let unknowns = [
        Unknown::new(position).component(2).named("height"),
        Unknown::new(orientation)
            .component(1)
            .bounded(-0.3, 0.3)
            .named("tilt"),
    ];
    let identification = Identification::new(&truth, &plan(), &unknowns).unwrap();
    let fit = identification.with_noise(noise()).fit(&[recorded]).unwrap();
    assert_near(&fit.values(), &[height, tilt], 1e-3);
}

/// Returns a pendulum of 0.3 kg and 0.1 m on a hinge with friction (N m) and damping (N m s/rad).
fn pendulum(friction: f64, damping: f64) -> World {
    let bob = MassProperties {
        mass: 0.3,
        center_of_mass: vector![0.0, 0.0, -0.1],
        inertia: Matrix3::from_diagonal_element(1e-3),
    };
    let hinge = Joint::revolute("hinge", Vector3::x_axis())
        .with_friction(friction, 1e-3)
        .with_damping(damping)
        .with_position(1.0);
    let shape = Shape::new(shapes::icosphere(0.02, 1).unwrap());
    let bob = Body::dynamic("bob", shape, Material::elastic(1e6), Mass::Properties(bob)).unwrap();
    let world = World::new(vec![bob.with_joint(hinge).unwrap()]).unwrap();
    world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap()
}

#[test]
fn friction_and_damping_of_a_hinge_are_found() {
    let plan = Plan::new(0.01, 150)
        .unwrap()
        .with_integrator(Integrator::Sdirk3);
    let truth = [0.01, 0.004];
    let recorded = pendulum(truth[0], truth[1]).rollout(&plan).run().unwrap();
    let quantities = [JointQuantity::Friction, JointQuantity::Damping];
    let unknowns =
        quantities.map(|quantity| Unknown::new(Parameter::joint("hinge", quantity)).logarithmic());
    let start = Parameter::joint("hinge", JointQuantity::InitialPosition);
    let identification = Identification::new(&pendulum(0.02, 0.001), &plan, &unknowns).unwrap();
    let identification = identification
        .with_nuisances(&[Nuisance::new(start, 0.01)])
        .unwrap();
    let fit = identification
        .fit(&[Measurement::new("swing", recorded)])
        .unwrap();
    assert_near(&fit.values(), &truth, 1e-3);
}

#[test]
fn the_friction_of_a_hinge_without_friction_remains_positive() {
    let plan = Plan::new(0.01, 50).unwrap();
    let plan = plan.with_integrator(Integrator::Sdirk3);
    let recorded = pendulum(0.0, 0.004).rollout(&plan).run().unwrap();
    let recorded = Measurement::new("swing", recorded);
    let friction = Parameter::joint("hinge", JointQuantity::Friction);
    let unknowns = [Unknown::new(friction).logarithmic()];
    let identification = Identification::new(&pendulum(0.02, 0.004), &plan, &unknowns).unwrap();
    let fit = identification.fit(std::slice::from_ref(&recorded)).unwrap();
    assert!(0.0 < fit.values()[0] && fit.values()[0] < 1e-5, "{fit:?}");
    identification
        .predict(&fit.values(), &recorded, StartingState::Measured)
        .unwrap();
}

#[test]
fn windows_cover_a_measurement() {
    let measurement = &clean(1)[0];
    let windows = measurement.windows(11);
    let times: Vec<[f64; 2]> = windows
        .iter()
        .map(|window| {
            [
                window.trajectory().states()[0].time,
                window.trajectory().last().time,
            ]
        })
        .collect();
    assert_eq!(times.len(), 3);
    assert!(
        times
            .windows(2)
            .all(|pair| (pair[0][1] - pair[1][0]).abs() < 1e-12)
    );
    let identification = Identification::new(&world(GUESS), &plan(), &unknowns()).unwrap();
    let fit = identification.with_noise(noise()).fit(&windows).unwrap();
    assert_near(&fit.values(), &TRUTH, CLEAN);
}
