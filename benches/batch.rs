//! A batch of 10,000 small worlds. Each world is a rollout of 100 steps of a ball that rolls on a half-space or a box, with friction and
//! dissipation, from its own initial state.
//!
//! Helps to decide whether a batch is worthwhile for many small worlds. The bench measures the overhead of a batch on one thread relative
//! to sequential rollouts, and the speedup with a second thread. Run `cargo bench --bench batch` (four minutes), or with `-- --quick` for a
//! tenth of the worlds.
//!
//! Steps per second are totals, computed from the shortest wall time. Ratios are medians over rounds, and each round runs every variant
//! once. If other programs use the cores, two threads get less than two cores. In that case the ratio of processor times still measures how
//! much two threads slow each other down.

#[path = "timing/mod.rs"]
mod timing;

use cpu_time::ProcessTime;
use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{Batch, Body, Mass, Material, Plan, State, World};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::f64::consts::TAU;
use std::hint::black_box;
use std::time::Instant;
use timing::{count, median};

const WORLDS: usize = 10_000;
const STEPS: usize = 100;
const TIME_STEP: f64 = 2e-4;
/// Steps until the ball is at rest: half a second.
const SETTLING_STEPS: usize = 2_500;
const ROUNDS: usize = 5;

/// Number of refinements of the ball's mesh, which then has 80 tetrahedra.
const ORDER: usize = 1;

fn main() {
    let is_asked = |option: &str| std::env::args().any(|argument| argument == option);
    // `cargo test` runs benches too, but does not pass `--bench`.
    let is_quick = is_asked("--quick") || !is_asked("--bench");
    let (worlds, rounds) = if is_quick {
        (WORLDS / 10, 3)
    } else {
        (WORLDS, ROUNDS)
    };
    println!("{} worlds, {STEPS} steps each:\n", count(worlds));
    println!(
        "| ball of order {ORDER} on a | polygons | steps a second, one after the other | in a batch, one thread | two threads | batch on one thread over one after the other | two threads, times as fast as one | their processor time over that of one |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (name, floor) in floors() {
        let settled = settled(floor);
        let worlds: Vec<World> = (0..worlds).map(|index| started(&settled, index)).collect();
        let polygons = assert_touches_throughout(&worlds[worlds.len() / 3]);
        let rounds: Vec<Round> = (0..rounds).map(|_| Round::of(&worlds)).collect();
        print_row(name, polygons, worlds.len() * STEPS, &rounds);
    }
}

fn skin() -> Material {
    Material::elastic(1e5)
        .with_dissipation(0.5)
        .with_friction(0.4)
}

/// Creates the floors, whose upper side is z = 0.
fn floors() -> [(&'static str, Body); 2] {
    let hard = Material::rigid().with_friction(0.4).with_dissipation(0.5);
    let slab = Shape::new(shapes::cuboid([1.0, 1.0, 0.5]).unwrap());
    let slab = Body::fixed("floor", slab, skin()).unwrap();
    [
        (
            "half-space",
            Body::fixed("floor", HalfSpace::rigid(), hard).unwrap(),
        ),
        (
            "box",
            slab.with_pose(Pose::from_translation(Vector3::z() * -0.25)),
        ),
    ]
}

/// Returns a world with a ball that has come to rest on the floor.
fn settled(floor: Body) -> World {
    let ball = Shape::new(shapes::icosphere(0.1, ORDER).unwrap());
    let ball = Body::dynamic("ball", ball, skin(), Mass::Total(1.0)).unwrap();
    let turned = Pose::from_rotation_vector(&vector![0.3, -0.5, 0.2], vector![0.02, 0.05, 0.095]);
    let world = World::new(vec![ball.with_pose(turned), floor]).unwrap();
    let world = world.with_gravity(Vector3::z() * -9.81).unwrap();
    let world = world.with_slip_tolerance(0.01).unwrap();
    let settling = Plan::new(TIME_STEP, SETTLING_STEPS).unwrap();
    let states = world.rollout(&settling.recording_every(SETTLING_STEPS));
    let rest = states.run().unwrap().last().clone();
    world.with_initial_state(&rest).unwrap()
}

/// Returns the world with the ball pushed and spun in a direction that depends on `index`.
fn started(world: &World, index: usize) -> World {
    let mut state = world.initial_state();
    let (sine, cosine) = (index as f64 * TAU / WORLDS as f64).sin_cos();
    state.bodies[0].twist.linear += vector![cosine, sine, 0.0] * 0.3;
    state.bodies[0].twist.angular += vector![cosine, -sine, 1.0];
    world.clone().with_initial_state(&state).unwrap()
}

/// Asserts that bodies touch in every state of the rollout. Returns the number of contact polygons at its start.
fn assert_touches_throughout(world: &World) -> usize {
    let polygons = |state: &State| world.topology(state).unwrap().polygon_count();
    for state in world.rollout(&plan()).take(STEPS) {
        assert!(polygons(&state.unwrap()) > 0);
    }
    polygons(&world.initial_state())
}

fn plan() -> Plan {
    Plan::new(TIME_STEP, STEPS).unwrap().recording_every(STEPS)
}

/// Times (s) of one run of each variant.
struct Round {
    one_after_the_other: f64,
    one_thread: f64,
    two_threads: f64,
    /// Processor time (s).
    work_of_one: f64,
    work_of_two: f64,
}

impl Round {
    fn of(worlds: &[World]) -> Self {
        let [one_pool, two_pool] = [1, 2].map(pool);
        let (one_after_the_other, _) = one_pool.install(|| {
            times(|| {
                for world in worlds {
                    black_box(world.rollout(&plan()).run().unwrap());
                }
            })
        });
        let batch = || {
            let results = black_box(Batch::new(&plan()).rollouts(worlds));
            assert!(results.iter().all(Result::is_ok));
        };
        let (one_thread, work_of_one) = one_pool.install(|| times(batch));
        let (two_threads, work_of_two) = two_pool.install(|| times(batch));
        Self {
            one_after_the_other,
            one_thread,
            two_threads,
            work_of_one,
            work_of_two,
        }
    }
}

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
}

/// Returns the wall time and the processor time (s) of the work.
fn times(work: impl FnOnce()) -> (f64, f64) {
    let (start, processor) = (Instant::now(), ProcessTime::now());
    work();
    (
        start.elapsed().as_secs_f64(),
        processor.elapsed().as_secs_f64(),
    )
}

fn print_row(name: &str, polygons: usize, steps: usize, rounds: &[Round]) {
    let speed = |of: fn(&Round) -> f64| {
        let shortest = rounds.iter().map(of).fold(f64::INFINITY, f64::min);
        count(steps as f64 / shortest)
    };
    let ratio = |of: fn(&Round) -> f64| median(rounds.iter().map(of).collect());
    println!(
        "| {name} | {polygons} | {} | {} | {} | {:.3} | {:.2} | {:.2} |",
        speed(|round| round.one_after_the_other),
        speed(|round| round.one_thread),
        speed(|round| round.two_threads),
        ratio(|round| round.one_thread / round.one_after_the_other),
        ratio(|round| round.one_thread / round.two_threads),
        ratio(|round| round.work_of_two / round.work_of_one),
    );
}
