//! Bodies that touch are solved together, and other bodies separately, with the same bits on any number of threads.

use super::scenes::{IMPLICIT, brick, ground, on_slope, rollout, run, stack};
use crate::scenes::{at, bits};
use crate::support::worlds::{plan_of, rubbing};
use hydroelastic::dynamics::{Integrator, Material, World};
use nalgebra::vector;
use rayon::ThreadPoolBuilder;

fn skin() -> Material {
    rubbing(1e7, 0.5, 0.5)
}

/// Returns bricks at rest side by side, a tenth of a meter apart, and two bricks on top of each other.
fn apart(count: usize) -> World {
    let pose = |index: usize| {
        at(
            0.2 * (index % 6) as f64 - 0.5,
            0.2 * (index / 6) as f64 - 0.5,
            0.049_99,
        )
    };
    let name = |index: usize| format!("{index}");
    let mut bodies: Vec<_> = (0..count)
        .map(|index| brick(&name(index), [0.1; 3], skin()).with_pose(pose(index)))
        .collect();
    bodies.push(brick("above", [0.1; 3], skin()).with_pose(at(-0.5, -0.5, 0.149_98)));
    bodies.push(ground([3.0, 3.0, 0.4], skin()));
    on_slope(bodies, 0.0, 1e-4)
}

#[test]
fn bodies_that_touch_only_the_ground_are_islands_of_their_own() {
    let world = apart(4);
    let mut rollout = rollout(&world, Integrator::Sdirk3, 5e-3);
    rollout.advance().unwrap();
    let report = rollout.step_report().unwrap();
    assert_eq!(report.islands, 4);
    assert!(report.work.solves >= 8);
}

#[test]
fn an_island_moves_as_it_does_alone() {
    let together = apart(4);
    let alone = on_slope(
        vec![
            brick("0", [0.1; 3], skin()).with_pose(at(-0.3, -0.5, 0.049_99)),
            ground([3.0, 3.0, 0.4], skin()),
        ],
        0.0,
        1e-4,
    );
    for integrator in IMPLICIT {
        let mut all = rollout(&together, integrator, 5e-3);
        run(&mut all, 5e-3, 0.1);
        let mut single = rollout(&alone, integrator, 5e-3);
        run(&mut single, 5e-3, 0.1);
        let [all, single] = [&all.state().bodies[1], &single.state().bodies[0]];
        assert_eq!(all.position(), single.position());
        assert_eq!(all.twist.linear, single.twist.linear);
    }
}

/// Twenty bodies in a chain have a sparse matrix.
#[test]
fn threads_change_no_bit() {
    for world in [apart(20), stack(18, 1e7, 1e-3)] {
        let runs = [1, 2, 3].map(|threads| {
            let pool = ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let mut rollout = rollout(&world, Integrator::ImplicitEuler, 5e-3);
                run(&mut rollout, 5e-3, 0.05);
                bits(rollout.state())
            })
        });
        assert!(runs[0] == runs[1] && runs[0] == runs[2]);
    }
}

/// A brick at 10 m/s is 5 cm from a brick at rest, which is half a step.
#[test]
fn a_fast_body_meets_another_within_a_step() {
    let elastic = Material::elastic(1e7);
    let fast = brick("fast", [0.1; 3], elastic).with_pose(at(0.0, 0.0, 0.0));
    let fast = fast.with_velocity(vector![10.0, 0.0, 0.0]);
    let resting = brick("resting", [0.1; 3], elastic).with_pose(at(0.15, 0.013, 0.007));
    let world = World::new(vec![fast, resting]).unwrap();
    let state = |integrator, time_step| {
        let mut rollout = rollout(&world, integrator, time_step);
        run(&mut rollout, time_step, 0.05);
        rollout.state().bodies[1].twist.linear.x
    };
    let expected = state(Integrator::Leapfrog, 1e-5);
    let actual = state(Integrator::Sdirk3, 1e-2);
    println!("10 m/s against a brick at rest: {actual:.4} m/s, explicitly {expected:.4} m/s");
    assert!((actual / expected - 1.0).abs() < 0.02);
}

#[test]
fn a_step_by_itself_is_that_of_a_rollout() {
    let world = stack(3, 1e7, 1e-3);
    for integrator in IMPLICIT {
        let plan = plan_of(integrator, 5e-3, 1);
        let mut rollout = world.rollout(&plan);
        let first = world.step(&world.initial_state(), &plan).unwrap();
        assert!(bits(&first) == bits(rollout.advance().unwrap()));
    }
}
