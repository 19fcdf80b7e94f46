//! Reverse-mode gradients through implicit steps against forward mode: islands, divided steps, sparse matrices and stiff contacts.

use super::reverse::{END, compare, skin, with_forces_and_controls};
use crate::support::worlds::{IMPLICIT, cuboid, dynamic, falling, fixed, icosphere};
use hydroelastic::contact::HalfSpace;
use hydroelastic::dynamics::{Control, Drag, Integrator, Material, Plan, Spring, World};
use hydroelastic::gradient::{Experiment, Mode, Parameter};
use hydroelastic::spatial::{Pose, Wrench};
use nalgebra::{Vector3, vector};
use std::sync::Arc;

fn plans(time_step: f64, steps: usize) -> [Plan; 2] {
    let plan = Plan::new(time_step, steps).unwrap().recording_every(steps);
    IMPLICIT.map(|integrator| plan.with_integrator(integrator))
}

/// Returns the largest and the smallest number of islands in a step, and the number of rejected substeps.
fn islands_and_rejections<F: hydroelastic::dynamics::Force>(
    world: &World<f64, F>,
    plan: &Plan,
) -> ([usize; 2], usize) {
    let mut rollout = world.rollout(plan);
    let (mut islands, mut rejections) = (Vec::new(), 0);
    for _ in 0..plan.steps() {
        rollout.advance().unwrap();
        let report = rollout.step_report().unwrap();
        islands.push(report.islands);
        rejections += report.work.rejections;
    }
    let [least, most] = [islands.iter().min(), islands.iter().max()].map(|count| *count.unwrap());
    ([least, most], rejections)
}

/// Returns bricks side by side with a floor and forces on some of them. The first brick slides to the second.
fn bricks(law: [f64; 2], speed: f64) -> World<f64, (Spring, Drag)> {
    let shape = Arc::new(cuboid([0.1; 3]));
    let brick = |name: &str, x: f64| {
        let shape = Arc::clone(&shape);
        let body = dynamic(name, shape, skin(1e6, law), 1.0);
        let turn = vector![0.0, 0.0, 0.1 + x];
        body.with_pose(Pose::from_rotation_vector(
            &turn,
            vector![x, 0.013 * x, 0.0499],
        ))
    };
    let bodies = vec![
        brick("first", -0.2).with_velocity(vector![speed, 0.0, 0.0]),
        brick("second", 0.0),
        brick("third", 0.4),
        brick("fourth", 0.6).with_velocity(vector![0.0, -0.1, -0.2]),
        fixed("floor", HalfSpace::layer(0.05).unwrap(), skin(2e6, law)),
    ];
    let push = Wrench {
        torque: vector![0.0, 0.0, 0.01],
        force: vector![0.1, 0.2, 0.0],
    };
    let spring = Spring {
        bodies: ["third".into(), "fourth".into()],
        points: [[0.05, 0.0, 0.0], [-0.05, 0.01, 0.0]],
        rest_length: 0.05.into(),
        stiffness: 30.0.into(),
        damping: 0.3.into(),
    };
    let drag = Drag {
        body: "second".into(),
        linear: 0.3.into(),
        angular: 1e-3.into(),
    };
    falling(bodies)
        .with_slip_tolerance(0.01)
        .and_then(|world| world.with_control(Control::new("first", 0.05, vec![push; 2])?))
        .and_then(|world| world.with_control(Control::new("fourth", 0.05, vec![push; 2])?))
        .and_then(|world| world.with_forces((spring, drag)))
        .unwrap()
}

fn by_bricks(rubs: bool) -> Vec<Parameter> {
    let mut parameters = vec![Parameter::Gravity, Parameter::modulus("floor")];
    for name in ["first", "second", "third", "fourth"] {
        parameters.extend([
            Parameter::initial_position(name),
            Parameter::initial_orientation(name),
            Parameter::initial_velocity(name),
            Parameter::initial_angular_velocity(name),
            Parameter::mass(name),
            Parameter::radius_of_gyration(name),
            Parameter::modulus(name),
        ]);
        if rubs {
            parameters.push(Parameter::friction(name));
            parameters.push(Parameter::dissipation(name));
        }
    }
    for name in ["first", "fourth"] {
        parameters.extend((0..2).map(|interval| Parameter::control(name, interval)));
    }
    parameters
}

#[test]
fn islands_that_merge_and_steps_that_are_divided() {
    for law in [[0.0; 2], [0.3, 0.3]] {
        let world = bricks(law, 2.0);
        for plan in plans(5e-3, 20) {
            let (islands, rejections) = islands_and_rejections(&world, &plan);
            assert_eq!(islands, [2, 3]);
            let is_adaptive = plan.integrator() == Integrator::Sdirk3;
            assert!(!is_adaptive || rejections > 0);
            compare(&world, &plan, &by_bricks(law[1] > 0.0), &END);
        }
    }
}

/// With twenty bodies, the matrix is sparse.
#[test]
fn a_chain_of_twenty() {
    let shape = Arc::new(icosphere(0.1, 1));
    let ball = |place: usize| {
        let (name, count) = (place.to_string(), place as f64);
        let shape = Arc::clone(&shape);
        let body = dynamic(&name, shape, skin(1e5, [0.2, 0.3]), 1.0);
        let turned = Vector3::z() * (0.3 * count);
        body.with_pose(Pose::from_rotation_vector(
            &turned,
            vector![0.19 * count, 0.003 * count.sin(), 0.002 * count.cos()],
        ))
    };
    let world = World::new((0..20).map(ball).collect()).unwrap();
    let world = world.with_slip_tolerance(0.05).unwrap();
    let mut parameters = Vec::new();
    for name in ["0", "7", "19"] {
        parameters.extend([
            Parameter::initial_position(name),
            Parameter::initial_velocity(name),
            Parameter::initial_angular_velocity(name),
            Parameter::modulus(name),
            Parameter::friction(name),
        ]);
    }
    for plan in plans(5e-3, 10) {
        let (islands, _) = islands_and_rejections(&world, &plan);
        assert_eq!(islands, [1, 1]);
        compare(&world, &plan, &parameters, &END);
    }
}

/// Mass and modulus are excluded. The motion of a brick that slides to a stop depends on them through a difference of terms a million times
/// as large. Their derivatives have the rounding errors of these terms.
#[test]
fn stiff_skins_that_stick() {
    let shape = cuboid([0.2, 0.2, 0.1]);
    let law = [0.5, 0.4];
    let brick = dynamic("brick", shape, skin(1e7, law), 1.0);
    let start = Pose::from_rotation_vector(&vector![0.0, 0.0, 0.3], vector![-0.3, 0.02, 0.04999]);
    let world = falling(vec![
        brick
            .with_pose(start)
            .with_velocity(vector![0.5, 0.1, 0.0])
            .with_angular_velocity(vector![0.0, 0.0, 1.0]),
        fixed(
            "floor",
            HalfSpace::rigid(),
            Material::rigid().with_friction(0.4),
        ),
    ])
    .with_slip_tolerance(1e-4)
    .unwrap();
    let parameters = [
        Parameter::initial_position("brick"),
        Parameter::initial_orientation("brick"),
        Parameter::initial_velocity("brick"),
        Parameter::initial_angular_velocity("brick"),
        Parameter::dissipation("brick"),
        Parameter::friction("brick"),
        Parameter::Gravity,
    ];
    for plan in plans(5e-3, 60) {
        compare(&world, &plan, &parameters, &END);
    }
}

#[test]
fn many_parameters_are_taken_backwards() {
    let (world, parameters) = with_forces_and_controls();
    // More than 96 components, each of them twice.
    let parameters = [&parameters[..], &parameters[..]].concat();
    let [plan, _] = plans(2.5e-3, 10);
    let experiment = Experiment::new(&world, &plan);
    let chosen = experiment.gradient(&parameters, &END).unwrap();
    let reverse = experiment.gradient_with_mode(Mode::Reverse, &parameters, &END);
    assert_eq!(chosen, reverse.unwrap());
}
