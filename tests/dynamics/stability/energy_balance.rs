//! Contact that creates energy ends a rollout, independent of other bodies and of the motion of the frame.

use crate::support::worlds::{cuboid, dynamic, falling, fixed, icosphere, rubbing, sliding_at};
use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{Body, BodyState, Mass, Material, Plan, RolloutError};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Vector3, vector};
use std::sync::Arc;

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(vector![x, y, z])
}

fn rigid_floor() -> Body {
    fixed("floor", HalfSpace::rigid(), Material::rigid())
}

/// Returns a path at constant velocity.
fn steady(start: Pose, twist: Twist) -> Arc<dyn Fn(f64) -> BodyState + Send + Sync> {
    Arc::new(move |time| BodyState {
        pose: start.with_translation(start.translation() + twist.linear * time),
        twist,
    })
}

/// Returns a light ball that a step of 20 ms moves deep into the floor.
fn thrown_ball() -> Body {
    let ball = icosphere(0.05, 2);
    let ball = dynamic("ball", ball, Material::elastic(1e5), 0.01);
    let turn = vector![-0.4, -0.6, -0.5];
    ball.with_pose(Pose::from_rotation_vector(
        &turn,
        vector![0.013, 0.017, 1.05],
    ))
    .with_velocity(vector![0.0, 0.0, -3.0])
}

/// Returns bodies that move beside the ball and never touch it.
fn companions() -> Vec<(&'static str, Vec<Body>)> {
    let ball = || icosphere(0.05, 0);
    let heavy = || dynamic("other", ball(), Material::elastic(1e5), 10.0);
    let skin = rubbing(2e4, 0.1, 0.5);
    let belt = cuboid([1.0, 1.0, 0.2]);
    let moving = sliding_at(vector![0.1, 0.0, 0.0]);
    let path = steady(at(5.0, 0.0, -0.1), moving);
    let block = cuboid([0.2, 0.2, 0.1]);
    let block = dynamic("block", block, skin, 5.0);
    vec![
        ("nothing", vec![]),
        (
            "a fast body",
            vec![
                heavy()
                    .with_pose(at(5.0, 0.0, 50.0))
                    .with_velocity(vector![30.0, 0.0, 0.0]),
            ],
        ),
        (
            "a spinning body",
            vec![
                heavy()
                    .with_pose(at(5.0, 0.0, 50.0))
                    .with_angular_velocity(vector![0.0, 0.0, 1000.0]),
            ],
        ),
        (
            "a block on a belt",
            vec![
                Body::kinematic("belt", belt, skin, path).unwrap(),
                block.with_pose(at(5.0, 0.0, 0.047)),
            ],
        ),
    ]
}

/// Asserts that a rollout ended because its time step is too long.
fn assert_step_is_too_long(error: &RolloutError) {
    assert!(
        matches!(
            error,
            RolloutError::EnergyGained { .. } | RolloutError::TimeStepTooLong { .. }
        ),
        "{error}"
    );
}

#[test]
fn created_energy_ends_a_rollout_whatever_other_bodies_do() {
    let mut steps = Vec::new();
    for (name, others) in companions() {
        let bodies = [thrown_ball(), rigid_floor()].into_iter().chain(others);
        let world = falling(bodies.collect());
        let plan = Plan::new(2e-2, 50).unwrap();
        let error = world.rollout(&plan).run().unwrap_err().error;
        let RolloutError::EnergyGained {
            step,
            bodies,
            absorbed,
            returned,
            ..
        } = error
        else {
            panic!("{name}: {error}")
        };
        assert_eq!(bodies, ["ball", "floor"]);
        assert!(returned > 2.0 * absorbed, "{name}: {returned} {absorbed}");
        steps.push(step);
    }
    assert!(steps.iter().all(|step| *step == steps[0]), "{steps:?}");
}

/// The scenes are flat elastic impacts on a block of the same material or on a rigid floor, below the stability limit. Single bounces may
/// return more energy than they absorbed, and the gains accumulate.
#[test]
fn bounces_do_not_add_energy_up_in_silence() {
    let cube = Arc::new(cuboid([0.1; 3]));
    let block = Arc::new(cuboid([2.0, 2.0, 0.2]));
    let (mut ended, mut right) = (0, 0);
    for (mass, modulus, time_step, steps) in [
        (0.5, 1e6, 5e-3, 2_000),
        (2.0, 1e7, 2e-3, 5_000),
        (1.0, 1e7, 2e-3, 5_000),
        (1.0, 1e6, 2e-3, 5_000),
    ] {
        for dissipation in [0.0, 0.1, 0.3] {
            for drop in [0.01, 0.03, 0.05] {
                let skin = Material::elastic(modulus).with_dissipation(dissipation);
                let cube = dynamic("cube", Arc::clone(&cube), skin, mass);
                let floor = fixed("floor", Arc::clone(&block), skin);
                let world = falling(vec![
                    cube.with_pose(at(0.0, 0.0, 0.05 + drop)),
                    floor.with_pose(at(0.0, 0.0, -0.1)),
                ]);
                let plan = Plan::new(time_step, steps).unwrap();
                match world.rollout(&plan).run() {
                    Ok(trajectory) => {
                        let states = trajectory.states().iter();
                        let heights = states.map(|state| state.bodies[0].position().z - 0.05);
                        let highest = heights.fold(0.0, f64::max);
                        assert!(
                            highest < 2.1 * drop,
                            "{mass} {modulus:e} {dissipation} {drop}: {highest}"
                        );
                        right += 1;
                    }
                    Err(interrupted) => {
                        assert_step_is_too_long(&interrupted.error);
                        ended += 1;
                    }
                }
            }
        }
    }
    assert!(ended > 5 && right > 5, "{ended} {right}");
}

/// The scenes are thrown coins and dice with friction. At fast rotation, friction may create energy below the limit of the normal contact.
#[test]
fn thrown_coins_and_dice_gain_no_energy_in_silence() {
    let coin = Arc::new(Shape::new(shapes::cylinder(0.0125, 0.002, 24).unwrap()));
    let die = Arc::new(cuboid([0.016; 3]));
    let (mut ended, mut right) = (0, 0);
    for throw in 0..60 {
        let number = |factor: f64| (factor * f64::from(throw + 1)).fract() - 0.5;
        let (shape, mass) = if throw % 2 == 0 {
            (&coin, 0.008)
        } else {
            (&die, 0.006)
        };
        let friction = 0.5 + 0.6 * (number(0.618_034) + 0.5);
        let skin = rubbing(1e6, 0.5, friction);
        let turn = vector![number(0.414), number(0.732), number(0.236)] * 6.0;
        let velocity = vector![number(0.646), number(0.317), 0.0] * 4.0;
        let spin = vector![number(0.162), number(0.485), number(0.873)] * 10.0;
        let body = dynamic("body", Arc::clone(shape), skin, mass);
        let start = Pose::from_rotation_vector(&turn, vector![0.0, 0.0, 0.17]);
        let body = body
            .with_pose(start)
            .with_velocity(velocity)
            .with_angular_velocity(spin);
        let world = falling(vec![body, rigid_floor()]);
        let plan = Plan::new([1e-3, 5e-4][usize::from(throw % 4 > 1)], 3000).unwrap();
        let energy = |state: &_| world.diagnostics(state).unwrap().total_energy();
        match world.rollout(&plan).run() {
            Ok(trajectory) => {
                let energies = trajectory.states().iter().map(energy);
                let most = energies.fold(0.0, f64::max);
                let first = energy(&world.initial_state());
                assert!(most < 2.1 * first, "{throw}: {most} of {first}");
                right += 1;
            }
            Err(interrupted) => {
                assert_step_is_too_long(&interrupted.error);
                ended += 1;
            }
        }
    }
    println!("{ended} ended, {right} right");
    assert!(ended > 0 && right > 0, "{ended} {right}");
}

/// The check rejects the same plans in a moving elevator as at rest. Rounding errors differ, so the steps may differ.
#[test]
fn the_check_does_not_depend_on_the_frame() {
    let ball = Arc::new(icosphere(0.1, 2));
    let ends =
        |modulus: f64, mass: f64, (time_step, steps): (f64, usize), velocity: Vector3<f64>| {
            let ball = Body::dynamic(
                "ball",
                Arc::clone(&ball),
                Material::elastic(modulus),
                Mass::Total(mass),
            );
            let lift = sliding_at(velocity);
            let path = steady(Pose::identity(), lift);
            let floor =
                Body::kinematic("floor", HalfSpace::rigid(), Material::rigid(), path).unwrap();
            let ball = ball
                .unwrap()
                .with_pose(at(0.0, 0.0, 0.12))
                .with_velocity(velocity);
            let world = falling(vec![ball, floor]);
            let plan = Plan::new(time_step, steps).unwrap();
            world.rollout(&plan).run().is_err()
        };
    let (mut refused, mut differing) = (0, 0);
    for modulus in [1e6, 5e6, 1e7, 1e8] {
        for mass in [0.05, 0.2, 1.0] {
            for plan in [(5e-4, 4_000), (1e-3, 2_000), (3e-3, 700)] {
                let at_rest = ends(modulus, mass, plan, Vector3::zeros());
                refused += usize::from(at_rest);
                for velocity in [
                    vector![0.0, 0.0, 10.0],
                    vector![0.0, 0.0, 30.0],
                    vector![30.0, 0.0, 0.0],
                ] {
                    differing += usize::from(ends(modulus, mass, plan, velocity) != at_rest);
                }
            }
        }
    }
    println!("{refused} refused, {differing} of 108 differ");
    assert!(refused > 5 && refused < 36, "{refused}");
    assert!(differing <= 2, "{differing}");
}
