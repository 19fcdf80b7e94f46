//! Derivatives with respect to parameters of forces, in forward and reverse mode, against each other and against differences.

use super::reverse::{Mixed, compare, skin};
use crate::support::worlds::{at, dynamic, falling, fixed, icosphere, plan_of};
use hydroelastic::contact::HalfSpace;
use hydroelastic::dynamics::{
    Drag, Force, ForceContext, Integrator, Plan, Spring, Trajectory, World, WorldError,
    WrenchAccumulator,
};
use hydroelastic::gradient::{Experiment, GradientError, Parameter};
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::Wrench;
use nalgebra::{Vector3, vector};
use std::slice;

/// Error of central differences with the best of four steps, relative to the derivative. Polygons change within the steps, because the body
/// slides.
const DIFFERENCES: f64 = 1e-6;

/// Pulls the first body to the origin, brakes its rotation, and pushes it along directions by a separate thrust each.
struct Rig;

const THRUSTS: usize = 14;

impl Force for Rig {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        let number = |name: &str| now.parameter(name).unwrap_or(lift(0.0));
        let state = &now.states[0];
        wrenches.apply_force_at_com(0, &(state.position() * -number("stiffness")));
        let brake = Wrench {
            torque: state.twist.angular * -number("brake"),
            force: Vector3::from_element(lift(0.0)),
        };
        wrenches.add(0, &brake);
        for index in 0..THRUSTS {
            let angle = index as f64;
            let thrust = number(&format!("thrust {index}"));
            let along = vector![angle.cos(), angle.sin(), 0.2].map(|x| thrust * x);
            wrenches.apply_force_at_com(0, &(along * state.position().x));
        }
    }
}

fn numbers() -> Vec<(String, f64)> {
    let thrusts = (0..THRUSTS).map(|index| (format!("thrust {index}"), 0.1 + 0.01 * index as f64));
    let others = [("stiffness", 30.0), ("brake", 2e-3)];
    let others = others.map(|(name, value)| (name.to_owned(), value));
    others.into_iter().chain(thrusts).collect()
}

/// Returns a ball that slides and rolls on a floor.
fn sliding() -> World {
    let law = [0.3, 0.4];
    let ball = icosphere(0.1, 1);
    let ball = dynamic("ball", ball, skin(1e5, law), 1.0);
    let ball = ball
        .with_pose(at(0.2, 0.1, 0.093))
        .with_velocity(vector![0.3, -0.2, -0.1])
        .with_angular_velocity(vector![1.0, 2.0, 3.0]);
    let floor = fixed("floor", HalfSpace::layer(0.05).unwrap(), skin(1e6, law));
    falling(vec![ball, floor])
}

fn world() -> World<f64, Rig> {
    let mut world = sliding().with_forces(Rig).unwrap();
    for (name, value) in numbers() {
        world = world.with_force_parameter(&name, value).unwrap();
    }
    world
}

/// Returns the ball with a spring and a drag whose coefficients are parameters.
fn sprung() -> World<f64, (Spring, Drag)> {
    let spring = Spring {
        bodies: ["ball".into(), "floor".into()],
        points: [[0.0, 0.05, 0.0], [0.0, 0.0, -0.1]],
        rest_length: "length".into(),
        stiffness: "stiffness".into(),
        damping: "damping".into(),
    };
    let drag = Drag {
        body: "ball".into(),
        linear: "drag".into(),
        angular: "brake".into(),
    };
    let numbers = [
        ("length", 0.2),
        ("stiffness", 30.0),
        ("damping", 0.3),
        ("drag", 0.2),
        ("brake", 2e-3),
    ];
    let mut world = sliding();
    for (name, value) in numbers {
        world = world.with_force_parameter(name, value).unwrap();
    }
    world.with_forces((spring, drag)).unwrap()
}

#[test]
fn both_ways_and_differences_agree() {
    assert_derivatives_agree(&world());
    assert_derivatives_agree(&sprung());
}

fn assert_derivatives_agree<F: Force>(world: &World<f64, F>) {
    let mixed = Mixed { every: 7 };
    let numbers = world.force_parameters();
    let of_forces = |(name, _): &(String, f64)| Parameter::ForceParameter(name.as_str().into());
    let mut by: Vec<_> = numbers.iter().map(of_forces).collect();
    by.extend([Parameter::Gravity, Parameter::mass("ball")]);
    for (integrator, time_step, steps) in [
        (Integrator::Leapfrog, 5e-4, 200),
        (Integrator::SymplecticEuler, 5e-4, 200),
        (Integrator::Sdirk3, 4e-3, 25),
        (Integrator::ImplicitEuler, 4e-3, 25),
    ] {
        let plan = plan_of(integrator, time_step, steps)
            .with_solver_tolerance(1e-13)
            .unwrap();
        let gradient = compare(world, &plan, &by, &mixed);
        let experiment = Experiment::new(world, &plan);
        for (index, (_, number)) in numbers.iter().enumerate() {
            let parameter = &by[index];
            let value = |change: f64| {
                let after =
                    experiment.value_perturbed(slice::from_ref(parameter), &[change], &mixed);
                after.unwrap()[0]
            };
            let error = |part: f64| {
                let step = part * number;
                let difference = (value(step) - value(-step)) / (2.0 * step);
                (difference - gradient[index]).abs() / gradient[index].abs()
            };
            let least = [1e-3, 1e-4, 1e-5, 1e-6]
                .map(error)
                .into_iter()
                .fold(1.0, f64::min);
            println!("{integrator:?}, {parameter}: {least:.1e}");
            assert!(
                least <= DIFFERENCES,
                "{integrator:?}, {parameter}: {least:e}"
            );
        }
    }
}

#[test]
fn what_is_not_there_or_not_finite_is_refused() {
    let experiment = Experiment::new(world(), &Plan::new(1e-3, 2).unwrap());
    let by = [Parameter::force_parameter("wind")];
    let refused = experiment.gradient(&by, &Mixed { every: 1 });
    assert_eq!(
        refused.unwrap_err(),
        GradientError::NoForceParameter("wind".into())
    );
    let refused = world().with_force_parameter("stiffness", f64::NAN);
    let message = refused.map(|_| ()).unwrap_err().to_string();
    assert!(message.contains("force parameter"), "{message}");
    let by = [Parameter::force_parameter("stiffness")];
    let refused = experiment.value_perturbed(&by, &[f64::INFINITY], &Mixed { every: 1 });
    assert!(refused.is_err());
}

#[test]
fn springs_whose_numbers_are_missing_or_out_of_range_are_refused() {
    let (spring, _) = sprung().forces().clone();
    let refused = sliding().with_forces(spring).map(|_| ()).unwrap_err();
    let expected = WorldError::UnknownForceParameter {
        name: "length".into(),
        known: Vec::new(),
    };
    assert_eq!(refused, expected);
    let refused = sprung().with_force_parameter("drag", -1.0);
    let message = refused.map(|_| ()).unwrap_err().to_string();
    assert!(message.contains("drag on the velocity"), "{message}");
    let by = [Parameter::force_parameter("stiffness")];
    let refused = sprung().perturbed(&by, &[-31.0]).map(|_| ()).unwrap_err();
    assert!(refused.to_string().contains("stiffness of a spring"));
}

/// Replacing a number by a named parameter changes no bit.
#[test]
fn springs_and_drags_by_name_equal_those_by_value() {
    let (spring, drag) = sprung().forces().clone();
    let spring = Spring {
        rest_length: 0.2.into(),
        stiffness: 30.0.into(),
        damping: 0.3.into(),
        ..spring
    };
    let drag = Drag {
        linear: 0.2.into(),
        angular: 2e-3.into(),
        ..drag
    };
    let constant = sliding().with_forces((spring, drag)).unwrap();
    let plan = Plan::new(5e-4, 100).unwrap();
    let actual = sprung().rollout(&plan).run().unwrap();
    let expected = constant.rollout(&plan).run().unwrap();
    let text = |trajectory: Trajectory| format!("{:?}", trajectory.states());
    assert_eq!(text(actual), text(expected));
}

/// The last value of a name counts, and a value can be changed like any other parameter.
#[test]
fn numbers_are_replaced_and_changed() {
    let plan = Plan::new(1e-3, 20).unwrap();
    let value = |world: World<f64, Rig>| {
        let experiment = Experiment::new(world, &plan);
        experiment.value(&Mixed { every: 5 }).unwrap()
    };
    let replaced = world().with_force_parameter("stiffness", 40.0).unwrap();
    let by = [Parameter::force_parameter("stiffness")];
    let changed = world().perturbed(&by, &[10.0]).unwrap();
    assert_eq!(value(replaced), value(changed.clone()));
    assert_ne!(value(world()), value(changed));
}
