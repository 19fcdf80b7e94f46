//! Rollouts in `f64`, and with their derivatives by 6 and 12 numbers: 100 steps of a ball (0.1 m,
//! 1 kg) that stays in contact with a box, by the leapfrog.
//!
//! Serves the decision whether a gradient of a rollout is affordable: the time of `Jacobian by n`
//! over that of `f64` is the price of n derivatives, to hold against n + 1 rollouts for
//! differences. A Jacobian takes one rollout in `f64` and one on duals, 6 or 12 wide. Run
//! `cargo bench --bench rollout`; throughput is in steps, and ratios are good within one run.
//!
//! `elastic` has neither dissipation nor friction, `rubbing` has both.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Integrator, Mass, Material, State, World};
use hydroelastic::gradient::{Experiment, FinalState, Parameter};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

const ORDERS: [usize; 2] = [2, 3];
const STEPS: usize = 100;
const TIME_STEP: f64 = 2e-4;

const MATERIALS: [(&str, Material); 2] = [
    (
        "elastic",
        Material {
            modulus: 1e5,
            dissipation: 0.0,
            friction: 0.0,
        },
    ),
    (
        "rubbing",
        Material {
            modulus: 1e5,
            dissipation: 0.5,
            friction: 0.4,
        },
    ),
];

const START: [Parameter<'static>; 4] = [
    Parameter::InitialVelocity("ball"),
    Parameter::InitialSpin("ball"),
    Parameter::InitialPosition("ball"),
    Parameter::InitialOrientation("ball"),
];

/// A ball about as deep in the box as it rests there, sinking, sliding and spinning.
fn ball_on_box(order: usize, skin: Material) -> World {
    let ball = Arc::new(Shape::new(shapes::icosphere(0.1, order).unwrap()));
    let slab = Arc::new(Shape::new(shapes::cuboid([1.0, 1.0, 0.5]).unwrap()));
    let at = |x, y, z| Pose::from_translation(Vector3::new(x, y, z));
    let ball = Body::dynamic("ball", ball, skin, Mass::Total(1.0)).unwrap();
    let slab = Body::fixed("slab", slab, skin).unwrap();
    let ball = ball
        .at(at(0.02, 0.05, 0.095))
        .with_velocity(Vector3::new(0.2, 0.1, -0.1))
        .with_spin(Vector3::new(1.0, 2.0, 0.5));
    let world = World::new(vec![ball, slab.at(at(0.0, 0.0, -0.25))]).unwrap();
    world.with_gravity(Vector3::new(0.0, 0.0, -9.81)).unwrap()
}

fn final_state(world: &World) -> State {
    let rollout = world.rollout(TIME_STEP, Integrator::Leapfrog).unwrap();
    let trajectory = rollout.recorded(STEPS, STEPS).unwrap();
    trajectory.last().clone()
}

fn assert_touches_throughout(world: &World) {
    let rollout = world.rollout(TIME_STEP, Integrator::Leapfrog).unwrap();
    for state in rollout.take(STEPS) {
        assert!(world.topology(&state.unwrap()).polygon_count() > 0);
    }
}

fn rollout(criterion: &mut Criterion) {
    for (name, skin) in MATERIALS {
        let mut group = criterion.benchmark_group(name);
        group
            .sample_size(10)
            .warm_up_time(Duration::from_millis(300))
            .measurement_time(Duration::from_secs(2))
            .throughput(Throughput::Elements(STEPS as u64));
        for order in ORDERS {
            let world = ball_on_box(order, skin);
            assert_touches_throughout(&world);
            let id = |name: &str| BenchmarkId::new(name, order);
            group.bench_function(id("f64"), |b| b.iter(|| final_state(black_box(&world))));
            let experiment = Experiment::new(&world, TIME_STEP, STEPS).unwrap();
            let experiment = experiment.recording_every(STEPS);
            for (name, parameters) in [("Jacobian by 6", &START[..2]), ("Jacobian by 12", &START)] {
                let jacobian = || {
                    experiment.jacobian(
                        black_box(parameters),
                        &FinalState::of_body(&world, "ball").unwrap(),
                    )
                };
                group.bench_function(id(name), |b| b.iter(|| jacobian().unwrap()));
            }
        }
        group.finish();
    }
}

criterion_group!(benches, rollout);
criterion_main!(benches);
