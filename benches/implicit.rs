//! Implicit steps in `f64`, and with derivatives with respect to 12 parameters. The scenes are a brick at rest with friction, a ball that
//! is thrown on a floor and bounces, and three cubes that fall on each other. Each runs for 60 steps of 5 ms.
//!
//! Helps to decide whether long implicit steps are cheaper than short explicit ones, and whether a gradient through implicit steps is
//! affordable. For the former, group `rest` also has 60 leapfrog steps of 10 µs. For the latter, compare the time of `Jacobian by 12` with
//! that of `f64`. Run `cargo bench --bench implicit`, and compare times within one run only.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Integrator, Mass, Material, Plan, World};
use hydroelastic::gradient::{Experiment, FinalState, Parameter};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::hint::black_box;
use std::time::Duration;

const STEPS: usize = 60;
const TIME_STEP: f64 = 5e-3;
const IMPLICIT: [(Integrator, f64); 2] = [
    (Integrator::Sdirk3, TIME_STEP),
    (Integrator::ImplicitEuler, TIME_STEP),
];
const ALL: [(Integrator, f64); 3] = [(Integrator::Leapfrog, 1e-5), IMPLICIT[0], IMPLICIT[1]];
const SKIN: Material = Material {
    modulus: Some(1e7),
    dissipation: 0.5,
    friction: Some(0.5),
};

fn box_shape(edges: [f64; 3]) -> Shape {
    Shape::new(shapes::cuboid(edges).unwrap())
}

fn dynamic(name: &str, shape: Shape, turn: Vector3<f64>, position: Vector3<f64>) -> Body {
    let body = Body::dynamic(name, shape, SKIN, Mass::Total(1.0)).unwrap();
    body.with_pose(Pose::from_rotation_vector(&turn, position))
}

fn on_floor(mut bodies: Vec<Body>) -> World {
    let floor = Body::fixed("floor", box_shape([2.0, 2.0, 0.4]), SKIN).unwrap();
    bodies.push(floor.with_pose(Pose::from_translation(vector![0.011, 0.007, -0.2])));
    World::new(bodies)
        .and_then(|world| world.with_gravity(vector![0.0, 0.0, -9.81]))
        .and_then(|world| world.with_slip_tolerance(1e-4))
        .unwrap()
}

fn brick_at_rest() -> World {
    let start = vector![-0.5, 0.02, 0.05];
    let brick = dynamic(
        "body",
        box_shape([0.2, 0.2, 0.1]),
        Vector3::z() * 0.3,
        start,
    );
    let world = on_floor(vec![brick]);
    let plan = Plan::new(TIME_STEP, 200).unwrap();
    let settling = world.rollout(&plan.with_integrator(Integrator::ImplicitEuler));
    let settled = settling.run().unwrap().last().clone();
    world.with_initial_state(&settled).unwrap()
}

fn thrown_ball() -> World {
    let ball = Shape::new(shapes::icosphere(0.05, 2).unwrap());
    let ball = dynamic("body", ball, Vector3::zeros(), vector![-0.3, 0.02, 0.15]);
    let ball = ball.with_velocity(vector![1.0, 0.2, 0.0]);
    on_floor(vec![ball.with_angular_velocity(vector![3.0, 1.0, 0.5])])
}

fn falling_cubes() -> World {
    let cube = |(index, name): (usize, &str)| {
        let count = index as f64;
        let position = vector![
            0.004 * (1.7 * count).sin(),
            0.003 * count.cos(),
            0.05 + 0.1001 * count
        ];
        dynamic(
            name,
            box_shape([0.1; 3]),
            Vector3::z() * (0.2 * count),
            position,
        )
    };
    on_floor(
        ["body", "second", "third"]
            .into_iter()
            .enumerate()
            .map(cube)
            .collect(),
    )
}

fn implicit(criterion: &mut Criterion) {
    let by = [
        Parameter::initial_position("body"),
        Parameter::initial_orientation("body"),
        Parameter::initial_velocity("body"),
        Parameter::initial_angular_velocity("body"),
    ];
    for (name, world, methods) in [
        ("rest", brick_at_rest(), &ALL[..]),
        ("throw", thrown_ball(), &IMPLICIT),
        ("stack", falling_cubes(), &IMPLICIT),
    ] {
        let mut group = criterion.benchmark_group(name);
        group
            .sample_size(10)
            .warm_up_time(Duration::from_millis(300))
            .measurement_time(Duration::from_secs(2));
        let end = FinalState::of_body(&world, "body").unwrap();
        for &(integrator, time_step) in methods {
            let plan = Plan::new(time_step, STEPS).unwrap().recording_every(STEPS);
            let experiment = Experiment::new(&world, &plan.with_integrator(integrator));
            let id = |label: &str| BenchmarkId::new(label, format!("{integrator:?}"));
            group.bench_function(id("f64"), |b| {
                b.iter(|| black_box(&experiment).value(&end).unwrap());
            });
            group.bench_function(id("Jacobian by 12"), |b| {
                b.iter(|| black_box(&experiment).jacobian(&by, &end).unwrap());
            });
        }
        group.finish();
    }
}

criterion_group!(benches, implicit);
criterion_main!(benches);
