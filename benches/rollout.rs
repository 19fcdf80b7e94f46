//! Rollouts in `f64`, and with derivatives with respect to 6, 12 and 96 parameters: 100 leapfrog steps of a ball (0.1 m, 1 kg) that stays
//! in contact with a box, and of eight balls on the box.
//!
//! Helps to decide whether a gradient of a rollout is affordable. The time of `Jacobian by n` divided by that of `f64` is the price of n
//! derivatives; finite differences cost n + 1 rollouts. A Jacobian takes one rollout on dual numbers of width 6, 12 or 96. Run
//! `cargo bench --bench rollout`. Throughput is in steps; compare times within one run only.
//!
//! `elastic` has neither dissipation nor friction, `rubbing` has both. `generic` is the wrench of the first ball and the box by the generic
//! pipeline, in `f64` and in dual numbers of width 8.

use criterion::measurement::WallTime;
use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main,
};
use hydroelastic::contact::{ContactBody, ContactPair, ContactWrench, Shape};
use hydroelastic::dynamics::{Body, Mass, Material, Plan, State, World};
use hydroelastic::gradient::{Experiment, FinalState, Parameter};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{DenseDual, Scalar};
use hydroelastic::spatial::{Pose, Twist};
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
            modulus: Some(1e5),
            dissipation: 0.0,
            friction: Some(0.0),
        },
    ),
    (
        "rubbing",
        Material {
            modulus: Some(1e5),
            dissipation: 0.5,
            friction: Some(0.4),
        },
    ),
];

fn start(name: &str) -> [Parameter; 4] {
    [
        Parameter::initial_velocity(name),
        Parameter::initial_angular_velocity(name),
        Parameter::initial_position(name),
        Parameter::initial_orientation(name),
    ]
}

const EIGHT: [&str; 8] = ["ball", "b", "c", "d", "e", "f", "g", "h"];

/// Returns balls about as deep in the box as at rest, which sink, slide and spin.
fn balls_on_box(names: &[&str], order: usize, skin: Material) -> World {
    let shape = Arc::new(Shape::new(shapes::icosphere(0.1, order).unwrap()));
    let slab = Arc::new(Shape::new(shapes::cuboid([1.0, 1.0, 0.5]).unwrap()));
    let at = |x, y, z| Pose::from_translation(Vector3::new(x, y, z));
    let ball = |(index, name): (usize, &&str)| {
        let (column, row) = ((index % 3) as f64, (index / 3) as f64);
        Body::dynamic(name, Arc::clone(&shape), skin, Mass::Total(1.0))
            .unwrap()
            .with_pose(at(0.02 - 0.25 * column, 0.05 - 0.25 * row, 0.095))
            .with_velocity(Vector3::new(0.2, 0.1, -0.1))
            .with_angular_velocity(Vector3::new(1.0, 2.0, 0.5))
    };
    let mut bodies: Vec<Body> = names.iter().enumerate().map(ball).collect();
    let slab = Body::fixed("slab", slab, skin).unwrap();
    bodies.push(slab.with_pose(at(0.0, 0.0, -0.25)));
    let world = World::new(bodies).unwrap();
    world.with_gravity(Vector3::new(0.0, 0.0, -9.81)).unwrap()
}

fn final_state(world: &World) -> State {
    let plan = Plan::new(TIME_STEP, STEPS).unwrap().recording_every(STEPS);
    world.rollout(&plan).run().unwrap().last().clone()
}

fn assert_touches_throughout(world: &World) {
    let rollout = world.rollout(&Plan::new(TIME_STEP, STEPS).unwrap());
    for state in rollout.take(STEPS) {
        assert!(world.topology(&state.unwrap()).unwrap().polygon_count() > 0);
    }
}

fn group<'c>(criterion: &'c mut Criterion, name: &str) -> BenchmarkGroup<'c, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2))
        .throughput(Throughput::Elements(STEPS as u64));
    group
}

/// Measures the rollout in `f64`, and its Jacobians with respect to each list of parameters.
fn compare(
    group: &mut BenchmarkGroup<WallTime>,
    order: usize,
    world: &World,
    lists: &[(&str, &[Parameter])],
) {
    assert_touches_throughout(world);
    let id = |name: &str| BenchmarkId::new(name, order);
    group.bench_function(id("f64"), |b| b.iter(|| final_state(black_box(world))));
    let plan = Plan::new(TIME_STEP, STEPS).unwrap();
    let experiment = Experiment::new(world, &plan.recording_every(STEPS));
    let outcome = FinalState::of_body(world, "ball").unwrap();
    for (name, parameters) in lists {
        let jacobian = || experiment.jacobian(black_box(parameters), &outcome);
        group.bench_function(id(name), |b| b.iter(|| jacobian().unwrap()));
    }
}

fn rollout(criterion: &mut Criterion) {
    let start = start("ball");
    for (name, skin) in MATERIALS {
        let mut group = group(criterion, name);
        for order in ORDERS {
            let world = balls_on_box(&EIGHT[..1], order, skin);
            let lists: [(&str, &[Parameter]); 2] =
                [("Jacobian by 6", &start[..2]), ("Jacobian by 12", &start)];
            compare(&mut group, order, &world, &lists);
        }
        group.finish();
    }
}

fn eight(criterion: &mut Criterion) {
    let parameters: Vec<Parameter> = EIGHT.into_iter().flat_map(start).collect();
    for (name, skin) in MATERIALS {
        let mut group = group(criterion, &format!("eight, {name}"));
        for order in ORDERS {
            let world = balls_on_box(&EIGHT, order, skin);
            let lists: [(&str, &[Parameter]); 1] = [("Jacobian by 96", &parameters)];
            compare(&mut group, order, &world, &lists);
        }
        group.finish();
    }
}

/// Returns the wrench after a motion of the ball and changes of both moduli.
fn wrench_after<T: Scalar>(pair: &ContactPair, changes: [T; 8]) -> ContactWrench<T> {
    let [angular, linear] =
        [0, 3].map(|first| Vector3::new(changes[first], changes[first + 1], changes[first + 2]));
    let pose_a = Pose::<T>::lifted(pair.a().pose()).moved_by(&Twist { angular, linear });
    let pose_b = Pose::lifted(pair.b().pose());
    let a = ContactBody::new(pair.a().shape(), pose_a, changes[6] + pair.a().modulus()).unwrap();
    let b = ContactBody::new(
        pair.b().shape().unwrap(),
        pose_b,
        changes[7] + pair.b().modulus().unwrap(),
    )
    .unwrap();
    ContactPair::new(a, b).pipeline().wrench()
}

fn generic(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("generic");
    group
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));
    for order in ORDERS {
        let world = balls_on_box(&EIGHT[..1], order, Material::elastic(1e5));
        let pair = world.contact_between(&world.initial_state(), "ball", "slab");
        let pair = pair.unwrap();
        let id = |name: &str| BenchmarkId::new(name, order);
        group.bench_function(id("f64"), |b| {
            b.iter(|| wrench_after(black_box(&pair), [0.0; 8]));
        });
        group.bench_function(id("dual 8"), |b| {
            let variables = std::array::from_fn(|number| DenseDual::<8>::variable(0.0, number));
            b.iter(|| wrench_after(black_box(&pair), variables));
        });
    }
    group.finish();
}

criterion_group!(benches, rollout, eight, generic);
criterion_main!(benches);
