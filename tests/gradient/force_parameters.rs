//! Derivatives by numbers that forces read, forwards and backwards, against each other and against differences.

use super::reverse::{Mixed, compare, skin};
use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{Body, Force, Integrator, Mass, Plan, Situation, World, Wrenches};
use hydroelastic::gradient::{Experiment, GradientError, Parameter};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::{Pose, Wrench};
use nalgebra::{Vector3, vector};
use std::slice;

/// Central differences with the best of four steps, of the derivative: polygons change on the way, as the body slides.
const DIFFERENCES: f64 = 1e-6;

/// Pulls the first body to the origin, brakes its spin, and pushes it along directions by thrusts of its own each.
struct Rig;

const THRUSTS: usize = 14;

impl Force for Rig {
    fn add_to<T: Scalar>(&self, wrenches: &mut Wrenches<T>, now: &Situation<T>) {
        let number = |name: &str| now.parameter(name).unwrap_or(lift(0.0));
        let state = &now.states[0];
        wrenches.push_center(0, &(state.position() * -number("stiffness")));
        let brake = Wrench {
            torque: state.twist.angular * -number("brake"),
            force: Vector3::from_element(lift(0.0)),
        };
        wrenches.add(0, &brake);
        for place in 0..THRUSTS {
            let angle = place as f64;
            let thrust = number(&format!("thrust {place}"));
            let along = vector![angle.cos(), angle.sin(), 0.2].map(|x| thrust * x);
            wrenches.push_center(0, &(along * state.position().x));
        }
    }
}

fn numbers() -> Vec<(String, f64)> {
    let thrusts = (0..THRUSTS).map(|place| (format!("thrust {place}"), 0.1 + 0.01 * place as f64));
    let others = [("stiffness", 30.0), ("brake", 2e-3)];
    let others = others.map(|(name, value)| (name.to_owned(), value));
    others.into_iter().chain(thrusts).collect()
}

/// A ball that slides and rolls on a floor.
fn world() -> World<f64, Rig> {
    let law = [0.3, 0.4];
    let ball = Shape::new(shapes::icosphere(0.1, 1).unwrap());
    let ball = Body::dynamic("ball", ball, skin(1e5, law), Mass::Total(1.0)).unwrap();
    let ball = ball
        .at(Pose::from_translation(vector![0.2, 0.1, 0.093]))
        .with_velocity(vector![0.3, -0.2, -0.1])
        .with_spin(vector![1.0, 2.0, 3.0]);
    let floor = Body::fixed("floor", HalfSpace::layer(0.05).unwrap(), skin(1e6, law)).unwrap();
    let world = World::new(vec![ball, floor]).unwrap();
    let world = world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap();
    let mut world = world.with_forces(Rig).unwrap();
    for (name, value) in numbers() {
        world = world.with_force_parameter(&name, value).unwrap();
    }
    world
}

fn parameters() -> Vec<Parameter> {
    let names = numbers().into_iter().map(|(name, _)| name);
    names.map(|name| Parameter::OfForces(name.into())).collect()
}

#[test]
fn both_ways_and_differences_agree() {
    let mixed = Mixed { every: 7 };
    let with_others = [Parameter::Gravity, Parameter::Mass("ball".into())];
    let by: Vec<_> = parameters().into_iter().chain(with_others).collect();
    for (integrator, time_step, steps) in [
        (Integrator::Leapfrog, 5e-4, 200),
        (Integrator::SymplecticEuler, 5e-4, 200),
        (Integrator::Sdirk2, 4e-3, 25),
        (Integrator::ImplicitEuler, 4e-3, 25),
    ] {
        let plan = Plan::new(time_step, steps).unwrap();
        let plan = plan
            .with_integrator(integrator)
            .with_solver_tolerance(1e-13)
            .unwrap();
        let found = compare(&world(), &plan, &by, &mixed);
        let experiment = Experiment::new(world(), &plan);
        for (place, (_, own)) in numbers().into_iter().enumerate() {
            let parameter = &parameters()[place];
            let value = |change: f64| {
                let after = experiment.value_after(slice::from_ref(parameter), &[change], &mixed);
                after.unwrap()[0]
            };
            let error = |part: f64| {
                let step = part * own;
                let difference = (value(step) - value(-step)) / (2.0 * step);
                (difference - found[place]).abs() / found[place].abs()
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
    let by = [Parameter::OfForces("wind".into())];
    let refused = experiment.gradient(&by, &Mixed { every: 1 });
    assert_eq!(
        refused.unwrap_err(),
        GradientError::NoForceParameter("wind".into())
    );
    let refused = world().with_force_parameter("stiffness", f64::NAN);
    let message = refused.map(|_| ()).unwrap_err().to_string();
    assert!(message.contains("force parameter"), "{message}");
    let by = [Parameter::OfForces("stiffness".into())];
    let refused = experiment.value_after(&by, &[f64::INFINITY], &Mixed { every: 1 });
    assert!(refused.is_err());
}

/// The last one of a name counts, and a value is changed as that of any parameter.
#[test]
fn numbers_are_replaced_and_changed() {
    let plan = Plan::new(1e-3, 20).unwrap();
    let value = |world: World<f64, Rig>| {
        let experiment = Experiment::new(world, &plan);
        experiment.value(&Mixed { every: 5 }).unwrap()
    };
    let replaced = world().with_force_parameter("stiffness", 40.0).unwrap();
    let by = [Parameter::OfForces("stiffness".into())];
    let changed = world().changed(&by, &[10.0]).unwrap();
    assert_eq!(value(replaced), value(changed.clone()));
    assert_ne!(value(world()), value(changed));
}
