//! Cost of the gradient of a loss, in rollouts without derivatives, in forward mode with dual numbers and in reverse mode. The gradients
//! are with respect to ten to a hundred thousand parameters.
//!
//! Helps to choose between both values of `Mode`: shows above how many parameters reverse mode is cheaper. The scene is a ball (0.1 m,
//! 1 kg) that slides on a box, with 1,000 leapfrog steps of 0.2 ms or 40 implicit steps of 5 ms. The parameters are the wrenches of its
//! control, or the vertices and extents of both bodies as well. Run `cargo bench --bench reverse` (two minutes). The bench uses one thread.
//! Ratios are medians over rounds that run each variant once.

#[path = "timing/mod.rs"]
mod timing;

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Control, Integrator, Mass, Material, Plan, Trajectory, World};
use hydroelastic::gradient::{Experiment, Mode, Outcome, Parameter};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::Scalar;
use hydroelastic::spatial::{Pose, Wrench};
use nalgebra::{Vector3, vector};
use std::hint::black_box;
use std::time::Instant;
use timing::{count, median};

const STEPS: usize = 1_000;
const TIME_STEP: f64 = 2e-4;
const NUMBERS_A_WRENCH: usize = 6;

const MATERIALS: [(&str, [f64; 2]); 2] = [("elastic", [0.0, 0.0]), ("rubbing", [0.5, 0.4])];

/// Squared distance (m²) from a target at the end.
struct Miss;

impl Outcome for Miss {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let position = trajectory.last().bodies[0].position();
        let miss = position.map(|x| x - hydroelastic::scalar::lift::<T>(0.1));
        vec![miss.dot(&miss)]
    }
}

/// Returns the world with a control of `intervals` intervals.
fn sliding(order: usize, [dissipation, friction]: [f64; 2], intervals: usize) -> World {
    let skin = Material::elastic(1e5);
    let skin = skin.with_dissipation(dissipation).with_friction(friction);
    let ball = Shape::new(shapes::icosphere(0.1, order).unwrap());
    let slab = Shape::new(shapes::cuboid([1.0, 1.0, 0.5]).unwrap());
    let at = |z: f64| Pose::from_translation(vector![0.02, 0.05, z]);
    let ball = Body::dynamic("ball", ball, skin, Mass::Total(1.0)).unwrap();
    let slab = Body::fixed("slab", slab, skin)
        .unwrap()
        .with_pose(at(-0.25));
    let ball = ball
        .with_pose(at(0.095))
        .with_velocity(vector![0.2, 0.1, -0.1]);
    let duration = STEPS as f64 * TIME_STEP / intervals as f64;
    let control = Control::new("ball", duration, vec![Wrench::zero(); intervals]).unwrap();
    let world = World::new(vec![
        ball.with_angular_velocity(vector![1.0, 2.0, 0.5]),
        slab,
    ])
    .unwrap();
    let world = world.with_gravity(Vector3::z() * -9.81).unwrap();
    world
        .with_slip_tolerance(0.01)
        .unwrap()
        .with_control(control)
        .unwrap()
}

fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

/// Returns the median ratio of the time of the work to that of the rollout.
fn in_rollouts(experiment: &Experiment, mut work: impl FnMut()) -> f64 {
    const ROUNDS: usize = 5;
    let ratio = |_| {
        let rollout = seconds(|| drop(black_box(experiment.value(&Miss).unwrap())));
        seconds(&mut work) / rollout
    };
    median((0..ROUNDS).map(ratio).collect())
}

fn main() {
    timing::use_one_thread();
    println!("| ball | numbers | forwards | backwards |\n|---|---|---|---|");
    let plan = Plan::new(TIME_STEP, STEPS).unwrap().recording_every(STEPS);
    for (order, (name, law)) in [2, 3]
        .into_iter()
        .flat_map(|order| MATERIALS.map(|material| (order, material)))
    {
        for intervals in [2, 16, 167, 1_667, 16_667] {
            let world = sliding(order, law, intervals);
            let experiment = Experiment::new(&world, &plan);
            let numbers = NUMBERS_A_WRENCH * intervals;
            let controls = (0..intervals).map(|interval| Parameter::control("ball", interval));
            let parameters: Vec<_> = controls.collect();
            let by = |mode: Mode| {
                in_rollouts(&experiment, || {
                    drop(black_box(
                        experiment
                            .gradient_with_mode(mode, &parameters, &Miss)
                            .unwrap(),
                    ));
                })
            };
            let forwards = if numbers <= 96 {
                format!("{:.2}", by(Mode::Forward))
            } else {
                String::new()
            };
            let backwards = by(Mode::Reverse);
            println!(
                "| order {order}, {name} | {} | {forwards} | {backwards:.2} |",
                count(numbers)
            );
        }
        let world = sliding(order, law, 1_667);
        let experiment = Experiment::new(&world, &plan);
        let vertices = world
            .bodies()
            .iter()
            .filter_map(|body| body.shape().compliant());
        let numbers: usize = vertices
            .map(|shape| 4 * shape.field().mesh().vertex_count())
            .sum();
        let backwards = in_rollouts(&experiment, || {
            drop(black_box(experiment.full_gradient(&Miss).unwrap()));
        });
        let numbers = count(numbers + NUMBERS_A_WRENCH * 1_667);
        println!("| order {order}, {name}, with shapes | {numbers} | | {backwards:.2} |");
    }
    implicit();
}

/// Measures implicit steps over the same duration.
fn implicit() {
    for integrator in [Integrator::Sdirk3, Integrator::ImplicitEuler] {
        for (name, law) in MATERIALS {
            let world = sliding(2, law, 167);
            let plan = Plan::new(25.0 * TIME_STEP, STEPS / 25).unwrap();
            let plan = plan.recording_every(STEPS).with_integrator(integrator);
            let experiment = Experiment::new(&world, &plan);
            let parameters: Vec<_> = (0..167)
                .map(|interval| Parameter::control("ball", interval))
                .collect();
            let [forwards, backwards] =
                [(Mode::Forward, 2), (Mode::Reverse, 167)].map(|(mode, intervals)| {
                    in_rollouts(&experiment, || {
                        let by = &parameters[..intervals];
                        drop(black_box(
                            experiment.gradient_with_mode(mode, by, &Miss).unwrap(),
                        ));
                    })
                });
            println!(
                "| order 2, {name}, {integrator:?} | 12 or 1,002 | {forwards:.2} | {backwards:.2} |"
            );
        }
    }
}
