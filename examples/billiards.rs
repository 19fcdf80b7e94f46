//! How much does the aim of a shot matter after three collisions?
//!
//! `cargo run --release -p hydroelastic-examples --example billiards [-- --record FILE.glb --plot FILE.svg]`
//!
//! The first ball hits the second, that the third, and that the last, each off center. The
//! derivative of where the last ball gets by the first one's velocity is held against differences.

mod show;

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Mass, Material, Plan, World, WorldError};
use hydroelastic::gradient::{Experiment, FinalPosition, OutcomeJacobian, Parameter};
use hydroelastic::io::Recording;
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::vector;
use std::error::Error;
use std::sync::Arc;

/// Where the balls lie (m), in the order in which they are hit.
const PLACES: [[f64; 2]; 4] = [[0.0, 0.0], [0.2, 0.02], [0.35, 0.06], [0.5, 0.05]];
const NAMES: [&str; 4] = ["first", "second", "third", "last"];
const LAST: &str = NAMES[3];

/// Radius (m) and mass (kg) of the balls, speed of the shot (m/s).
const RADIUS: f64 = 0.03;
const MASS: f64 = 0.2;
const SPEED: f64 = 2.0;

/// Time step (s) and steps.
const TIME_STEP: f64 = 1e-4;
const STEPS: usize = 6_000;

/// Deviation from central differences at the best step, relative to the largest derivative by the
/// same number: round-off grows in the collisions, and facets that meet or part bend the function.
const TOLERANCE: f64 = 1e-6;

/// A ball that was hit is faster (m/s).
const HIT: f64 = 0.1;

fn main() -> Result<(), Box<dyn Error>> {
    let (world, plan) = (table()?, Plan::new(TIME_STEP, STEPS)?);
    let experiment = Experiment::new(&world, &plan.recording_every(STEPS));
    let by_shot = [Parameter::InitialVelocity(NAMES[0].into())];
    let place = FinalPosition::of_body(&world, LAST)?;
    let OutcomeJacobian { value, jacobian } = experiment.jacobian(&by_shot, &place)?;
    println!("place of the last ball (m): {:.4?}", value.as_slice());
    println!("by the shot's velocity (m per m/s): {jacobian:.4}");
    let by_aim = jacobian.column(1).norm() * SPEED;
    println!("a shot turned by 1 mrad takes it {by_aim:.1} mm elsewhere");
    let check = experiment.difference_check(&by_shot, &place)?;
    println!("relative deviation from differences:\n{check}");

    let shot = world.rollout(&plan.recording_every(10)).run()?;
    let wanted = show::wanted()?;
    wanted.record(|| {
        let paths = NAMES.into_iter().enumerate();
        let recording = Recording::new(&world, &shot).slowed(8.0);
        let recording = recording.seen_from(vector![0.35, -0.7, 0.5], vector![0.35, 0.0, 0.0]);
        Ok(paths.fold(recording, |recording, (ball, name)| {
            recording.with_path(name, show::path(&shot, ball))
        }))
    })?;
    let last = world.index_of(LAST)?;
    wanted.plot(|| {
        vec![
            show::energies(&world, &shot),
            show::contact_force(&world, &shot, last),
        ]
    })?;

    // All but the first were at rest: each that moves was hit.
    let mut struck = shot.last().bodies[1..].iter();
    assert!(struck.all(|ball| ball.velocity().norm() > HIT));
    assert!(check.best() < TOLERANCE);
    Ok(())
}

/// Equal balls in a plane, without gravity and friction.
fn table() -> Result<World, Box<dyn Error>> {
    let shape = Arc::new(Shape::new(shapes::icosphere(RADIUS, 2)?));
    let ball = |(name, [x, y]): (&str, [f64; 2])| {
        let (shape, skin) = (Arc::clone(&shape), Material::elastic(1e7));
        let ball = Body::dynamic(name, shape, skin, Mass::Total(MASS))?;
        Ok(ball.with_pose(Pose::from_translation(vector![x, y, 0.0])))
    };
    let balls = NAMES.into_iter().zip(PLACES).map(ball);
    let mut balls = balls.collect::<Result<Vec<Body>, WorldError>>()?;
    balls[0] = balls[0].clone().with_velocity(vector![SPEED, 0.0, 0.0]);
    Ok(World::new(balls)?)
}
