//! Forces, controls and paths in implicit steps.

use super::scenes::{IMPLICIT, brick, ground, on_slope, rollout, run, undivided};
use crate::scenes::{asymmetric, at, box_shape};
use crate::support::worlds::{plan_of, rubbing};
use hydroelastic::dynamics::{
    Body, BodyState, Control, Drag, Force, ForceContext, Integrator, Mass, Material, Plan,
    RolloutError, Spring, Thruster, World, WorldError, WrenchAccumulator,
};
use hydroelastic::gradient::{Experiment, Parameter};
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::{Pose, Twist, Wrench};
use nalgebra::{DMatrix, DVector, vector};
use std::sync::Arc;

/// A force that depends on contact: along x, a fraction of the net contact force along z.
struct Leaning;

impl Force for Leaning {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        let contact = now.contact[0].force.z;
        let zero = lift(0.0);
        wrenches.apply_force_at_com(0, &vector![contact * 0.05, zero, zero]);
    }
}

/// Returns a body with an offset center of mass that slides on the ground. A damped spring connects it to another body. The world also has
/// drag, a thruster, a force that depends on contact, and a control.
fn everything() -> World<f64, ((Spring, Drag, Thruster), Leaning)> {
    let skin = rubbing(1e6, 0.3, 0.3);
    let start = Pose::from_rotation_vector(&vector![0.0, 0.0, 0.3], vector![-0.3, 0.02, 0.0495]);
    let askew = Body::dynamic(
        "askew",
        box_shape([0.2, 0.2, 0.1]),
        skin,
        Mass::Properties(asymmetric()),
    );
    let askew = askew
        .unwrap()
        .with_pose(start)
        .with_velocity(vector![0.4, 0.1, 0.0]);
    let second_brick = brick("other", [0.2, 0.2, 0.1], skin).with_pose(at(0.3, 0.0, 0.0495));
    let spring = Spring {
        bodies: ["askew", "other"].map(str::to_owned),
        points: [[0.05, 0.03, 0.01], [-0.05, 0.0, 0.0]],
        rest_length: 0.5.into(),
        stiffness: 200.0.into(),
        damping: 1.0.into(),
    };
    let drag = Drag {
        body: "askew".into(),
        linear: 0.5.into(),
        angular: 0.01.into(),
    };
    let thruster = Thruster {
        body: "other".into(),
        point: [0.02, 0.0, 0.0],
        force: [0.0, 1.0, 0.0],
    };
    let push = |x| Wrench {
        force: vector![x, 0.5, 0.0],
        torque: vector![0.0, 0.0, 0.1],
    };
    let control = Control::new("other", 0.02, vec![push(1.0), push(-2.0)]).unwrap();
    on_slope(
        vec![askew, second_brick, ground([2.0, 2.0, 0.4], skin)],
        0.0,
        1e-2,
    )
    .with_control(control)
    .and_then(|world| world.with_forces(((spring, drag, thruster), Leaning)))
    .unwrap()
}

/// Returns the states after 40 ms.
fn ends<F: Force>(world: &World<f64, F>, integrator: Integrator, time_step: f64) -> Vec<BodyState> {
    let plan = plan_of(integrator, time_step, 0);
    let mut rollout = world.rollout(&undivided(plan));
    run(&mut rollout, time_step, 0.04);
    rollout.state().bodies.clone()
}

fn farthest(actual: &[BodyState], expected: &[BodyState]) -> f64 {
    let off = actual.iter().zip(expected).map(|(actual, expected)| {
        let position = actual.position() - expected.position();
        position.norm() + (actual.pose.rotation() - expected.pose.rotation()).norm() * 0.1
    });
    off.fold(0.0, f64::max)
}

#[test]
fn steps_converge_to_those_of_short_explicit_steps() {
    let world = everything();
    let expected = ends(&world, Integrator::Leapfrog, 2e-6);
    for (integrator, order, least) in [
        // The errors decrease by factors of 4 and 16 from step to step here; the bound is that of second order.
        (Integrator::Sdirk3, 2, 1e-6),
        (Integrator::ImplicitEuler, 1, 3e-4),
    ] {
        let off = [5e-4, 2.5e-4, 1.25e-4]
            .map(|time_step| farthest(&ends(&world, integrator, time_step), &expected));
        println!("{integrator:?}: off by {off:?} m at 0.5, 0.25 and 0.125 ms");
        assert!(off[2] < off[0] / 2_f64.powi(2 * order) * 2.0);
        assert!(off[2] < least);
    }
}

/// Error of differences of these steps, relative to the largest entry.
const A_AND_B: f64 = 1e-8;

#[test]
fn linearized_steps_agree_with_differences() {
    let world = everything();
    let control = [0, 1].map(|interval| Parameter::control("other", interval));
    for integrator in IMPLICIT {
        let plan = plan_of(integrator, 5e-3, 8);
        // Durations of substeps may jump within the differences.
        let plan = undivided(plan);
        let linearization = Experiment::new(&world, &plan).linearize(&control).unwrap();
        let start = world.initial_state();
        let end = |world: &World<f64, _>| world.rollout(&plan).run().unwrap().last().clone();
        let middle = end(&world);
        let moved = |index: usize, step: f64| {
            let mut change = vec![0.0; 24];
            change[index] = step;
            let start = world.integrate(&start, &change).unwrap();
            world
                .difference(
                    &middle,
                    &end(&world.clone().with_initial_state(&start).unwrap()),
                )
                .unwrap()
        };
        let pushed = |index: usize, step: f64| {
            let mut change = vec![0.0; 12];
            change[index] = step;
            world
                .difference(&middle, &end(&world.perturbed(&control, &change).unwrap()))
                .unwrap()
        };
        // The best of several steps counts, because a brick leaves the ground edge by edge.
        let off = |by: &dyn Fn(usize, f64) -> DVector<f64>, jacobian: &DMatrix<f64>, step: f64| {
            let column = |index: usize| {
                let best = [1.0, 0.1, 0.01, 1e-3].map(|part| {
                    let step = step * part;
                    let ends = [2.0, 1.0, -1.0, -2.0].map(|times| by(index, times * step));
                    let [far, more, less, back] = ends;
                    let difference = ((more - less) * 8.0 - (far - back)) / (12.0 * step);
                    (difference - jacobian.column(index)).amax() / jacobian.amax()
                });
                best.into_iter().fold(f64::INFINITY, f64::min)
            };
            (0..jacobian.ncols()).map(column).fold(0.0, f64::max)
        };
        let off = [
            off(&moved, &linearization.by_state, 1e-5),
            off(&pushed, &linearization.by_parameters, 1e-2),
        ];
        println!("{integrator:?}: A and B off by {off:?}");
        assert!(off.iter().all(|&off| off < A_AND_B));
    }
}

/// A fraction of the contact force on the body. With `is_coupled` false, the force declares no coupling, although it depends on contact.
struct Boosting {
    is_coupled: bool,
}

impl Force for Boosting {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        wrenches.apply_force_at_com(0, &(now.contact[0].force * lift::<T>(0.5)));
    }

    fn coupling_groups(&self, bodies: &[Body]) -> Vec<Vec<usize>> {
        let all = (0..bodies.len()).collect();
        if self.is_coupled { vec![all] } else { vec![] }
    }
}

/// Tolerance, relative to the largest entry. The iterations end with different rounding errors.
const SAME_SOLUTION: f64 = 1e-9;

#[test]
fn what_a_force_makes_of_contact_needs_no_group() {
    let skin = rubbing(1e6, 0.3, 0.3);
    let turned = Pose::from_rotation_vector(&vector![0.1, 0.0, 0.3], vector![0.0, 0.0, 0.12]);
    let block = brick("block", [0.2; 3], skin)
        .with_pose(turned)
        .with_velocity(vector![0.5, 0.1, -0.5]);
    let bodies = vec![block, ground([2.0, 2.0, 0.4], skin)];
    let world = on_slope(bodies, 0.0, 1e-2);
    for integrator in IMPLICIT {
        let plan = plan_of(integrator, 2e-3, 40);
        let [with, without] = [true, false].map(|is_coupled| {
            let world = world.clone().with_forces(Boosting { is_coupled }).unwrap();
            let experiment = Experiment::new(&world, &plan);
            experiment.linearize(&[]).unwrap().by_state
        });
        assert!((&with - &without).amax() < SAME_SOLUTION * with.amax());
    }
}

#[test]
fn a_path_that_is_lost_and_bad_settings_are_typed_errors() {
    let skin = Material::elastic(1e6);
    let path = |time: f64| BodyState {
        pose: at(if time > 0.02 { f64::NAN } else { 0.0 }, 0.0, 0.0),
        twist: Twist::zero(),
    };
    let table = Body::kinematic("table", box_shape([1.0, 1.0, 0.2]), skin, Arc::new(path)).unwrap();
    let block = brick("block", [0.1; 3], skin).with_pose(at(0.0, 0.0, 0.149));
    let world = on_slope(vec![block, table], 0.0, 1e-3);
    let mut rollout = rollout(&world, Integrator::Sdirk3, 5e-3);
    let error = (0..10).find_map(|_| rollout.advance().err()).unwrap();
    assert!(
        matches!(error, RolloutError::PathNotFinite { step: 5, .. }),
        "{error}"
    );
    assert!((rollout.state().time - 0.02).abs() < 1e-12);
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let plan = Plan::new(5e-3, 1).unwrap().with_solver_tolerance(tolerance);
        assert!(matches!(plan, Err(WorldError::Setting { .. })));
    }
}
