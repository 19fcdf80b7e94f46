//! Linearized rollouts of worlds with joints.

use crate::joints::{arm, gripper, pendulum};
use hydroelastic::dynamics::{
    Accuracy, Body, BodyShape, Integrator, Joint, Mass, Material, Plan, State, World,
};
use hydroelastic::gradient::{Experiment, JointQuantity, LinearizedRollout, Parameter};
use hydroelastic::spatial::MassProperties;
use nalgebra::{DMatrix, DVector, Matrix2, Vector3};

/// Error of differences of fourth order, relative to the largest entry.
const DIFFERENCES: f64 = 1e-6;

/// Rounding error of the product of ten linearized steps, relative to the largest entry.
const PRODUCT: f64 = 1e-13;

/// Plan without error control, because durations of substeps may jump within differences.
fn plan(steps: usize) -> Plan {
    let plan = Plan::new(2e-3, steps).unwrap();
    let plan = plan.with_integrator(Integrator::ImplicitEuler);
    plan.with_accuracy(Accuracy::new(1e9, 1e9).unwrap())
}

/// Worlds and the parameters of B.
fn cases() -> [(World, Vec<Parameter>); 3] {
    use JointQuantity::{ScheduledTarget, ScheduledTorque, TargetPosition, Torque};
    let by = |joint: &str, quantities: &[JointQuantity]| {
        let quantities = quantities.iter();
        quantities
            .map(|quantity| Parameter::joint(joint, *quantity))
            .collect::<Vec<_>>()
    };
    let of_arm = [
        by("shoulder", &[ScheduledTorque(0), ScheduledTorque(1)]),
        by("elbow", &[Torque, TargetPosition]),
        by("wrist", &[ScheduledTarget(0), ScheduledTarget(1)]),
    ];
    [
        (arm(), of_arm.concat()),
        (pendulum(), by("hinge", &[Torque])),
        (gripper(), by("left", &[Torque])),
    ]
}

fn linearize(world: &World, steps: usize, by: &[Parameter]) -> LinearizedRollout {
    let experiment = Experiment::new(world.clone(), &plan(steps));
    experiment.linearize(by).unwrap()
}

fn from(world: &World, state: &State) -> World {
    world.clone().with_initial_state(state).unwrap()
}

/// Central difference of fourth order.
fn central(step: f64, value: impl Fn(f64) -> DVector<f64>) -> DVector<f64> {
    let [far, near] = [2.0, 1.0].map(|times| value(times * step) - value(-times * step));
    (near * 8.0 - far) / (12.0 * step)
}

#[test]
fn linearized_worlds_with_joints_agree_with_differences() {
    for (world, by) in cases() {
        let found = linearize(&world, 10, &by);
        let start = world.initial_state();
        let end = |world: &World| world.rollout(&plan(10)).run().unwrap().last().clone();
        let change = |world: &World| world.difference(&found.end, &end(world)).unwrap();
        let unit = |size: usize, index: usize, step: f64| {
            let mut unit = vec![0.0; size];
            unit[index] = step;
            unit
        };
        let moved = |index: usize, step: f64| {
            let moved = unit(world.tangent_dimension(), index, step);
            change(&from(&world, &world.integrate(&start, &moved).unwrap()))
        };
        let pushed = |index: usize, step: f64| {
            change(&world.perturbed(&by, &unit(by.len(), index, step)).unwrap())
        };
        let off = |jacobian: &DMatrix<f64>, by: &dyn Fn(usize, f64) -> DVector<f64>, step: f64| {
            let columns = jacobian.column_iter().enumerate();
            let errors = columns.map(|(index, column)| {
                // The best of several steps counts, because facets begin and end contact.
                let steps = [1.0, 0.1, 0.01].map(|part| part * step);
                let errors =
                    steps.map(|step| (central(step, |change| by(index, change)) - column).amax());
                errors.into_iter().fold(f64::INFINITY, f64::min)
            });
            errors.fold(0.0, f64::max) / jacobian.amax()
        };
        let errors = [
            off(&found.by_state, &moved, 1e-4),
            off(&found.by_parameters, &pushed, 1e-2),
        ];
        println!("relative errors of A and B: {errors:?}");
        assert!(
            errors.iter().all(|error| *error < DIFFERENCES),
            "{errors:?}"
        );
    }
}

#[test]
fn a_linearized_rollout_is_the_product_of_its_steps() {
    for (world, by) in cases() {
        let whole = linearize(&world, 10, &by);
        let mut state = world.initial_state();
        let size = world.tangent_dimension();
        let mut product = [
            DMatrix::identity(size, size),
            DMatrix::zeros(size, by.len()),
        ];
        for _ in 0..10 {
            let step = linearize(&from(&world, &state), 1, &by);
            product = product.map(|factor| &step.by_state * factor);
            product[1] += step.by_parameters;
            state = step.end;
        }
        let off = |found: &DMatrix<f64>, expected: &DMatrix<f64>| {
            (found - expected).amax() / expected.amax()
        };
        let errors = [
            off(&product[0], &whole.by_state),
            off(&product[1], &whole.by_parameters),
        ];
        println!("relative errors of the products: {errors:?}");
        assert!(errors.iter().all(|error| *error < PRODUCT), "{errors:?}");
    }
}

#[test]
fn a_linearized_step_of_a_servo_has_its_closed_form() {
    let (mass, stiffness, damping, step) = (2.0, 300.0, 5.0, 2e-3);
    let slide = Joint::prismatic("slide", Vector3::x_axis()).with_servo(stiffness, damping);
    let properties = Mass::Properties(MassProperties::solid_ball(mass, 0.1));
    let body = Body::dynamic("mass", BodyShape::None, Material::rigid(), properties).unwrap();
    let world = World::new(vec![body.with_joint(slide).unwrap()]).unwrap();
    let by = [JointQuantity::Torque, JointQuantity::TargetPosition]
        .map(|quantity| Parameter::joint("slide", quantity));
    let found = linearize(&world, 1, &by);
    // Implicit Euler: (m + h·d + h²·k)·u⁺ = m·u − h·k·(q − q*) + h·τ and q⁺ = q + h·u⁺.
    let inertia = mass + step * (damping + step * stiffness);
    let [by_position, by_velocity] = [-step * stiffness / inertia, mass / inertia];
    let a = Matrix2::new(
        1.0 + step * by_position,
        step * by_velocity,
        by_position,
        by_velocity,
    );
    let velocities = [step / inertia, -by_position];
    let b = Matrix2::from_columns(&velocities.map(|u| nalgebra::vector![step * u, u]));
    assert!((found.by_state - a).amax() < 1e-14);
    assert!((found.by_parameters - b).amax() < 1e-14);
}
