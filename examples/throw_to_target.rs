//! Can gradient descent find the throw that meets a target after bouncing off floor and wall?
//!
//! `cargo run --example throw_to_target`

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Mass, Material, State, Trajectory, World};
use hydroelastic::gradient::{Experiment, Outcome, Parameter};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{Scalar, lift_vector};
use hydroelastic::spatial::Pose;
use indicatif::ProgressBar;
use nalgebra::{Vector3, vector};
use std::error::Error;

/// Where the ball starts, and where it should be at the end (m); the velocity to begin with (m/s).
const START: Vector3<f64> = Vector3::new(0.0, 0.0, 0.5);
const TARGET: Vector3<f64> = Vector3::new(0.5, 0.3, 0.5);
const GUESS: Vector3<f64> = Vector3::new(3.0, 0.0, -2.0);
/// Time step (s) and steps.
const TIME_STEP: f64 = 5e-4;
const STEPS: usize = 1_200;
/// A miss (m) that counts as a hit, one that is far from it, and the iterations allowed.
const HIT: f64 = 1e-3;
const FAR: f64 = 0.1;
const ITERATIONS: usize = 60;
/// A change must bring this share of what the slope promises, or it is halved.
const SHARE: f64 = 0.1;

/// Squared distance (m²) of the ball's last position from the target.
struct SquaredMiss;

impl Outcome for SquaredMiss {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let position = trajectory.last().bodies[0].position();
        let miss = position - lift_vector::<T>(&TARGET);
        vec![miss.dot(&miss)]
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let (by_velocity, loss) = ([Parameter::InitialVelocity("ball")], SquaredMiss);
    let (mut world, mut rate, mut misses) = (room()?, 1.0, Vec::new());
    let bar = ProgressBar::new(ITERATIONS as u64);
    for _ in 0..=ITERATIONS {
        let throw = Experiment::new(&world, TIME_STEP, STEPS)?.recording_every(STEPS);
        let (value, slope) = throw.gradient(&by_velocity, &loss)?;
        misses.push(value.sqrt());
        if value.sqrt() < HIT {
            break;
        }
        let value_at = |rate: f64| {
            let change = &slope * -rate;
            throw.value_after(&by_velocity, change.as_slice(), &loss)
        };
        rate *= 2.0;
        while value_at(rate)?[0] > value - SHARE * rate * slope.norm_squared() {
            rate /= 2.0;
        }
        world = world.changed(&by_velocity, (slope * -rate).as_slice())?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let (count, first, last) = (misses.len() - 1, misses[0], misses[misses.len() - 1]);
    println!("miss (m): {first:.3}, after {count} iterations {last:.1e}");
    assert!(first > FAR && last < HIT);

    let flight = Experiment::new(&world, TIME_STEP, STEPS)?.trajectory()?;
    let meets = |state: &State, other| world.topology(state).touches(0, other);
    assert!(flight.states().iter().any(|state| meets(state, 1)), "floor");
    assert!(flight.states().iter().any(|state| meets(state, 2)), "wall");
    Ok(())
}

/// A ball of 0.1 kg in a room with the floor z = 0 and the wall x = 1 m.
fn room() -> Result<World, Box<dyn Error>> {
    let skin = Material::elastic(1e5)
        .with_dissipation(0.05)
        .with_friction(0.3);
    let ball = Shape::new(shapes::icosphere(0.05, 3)?);
    let ball = Body::dynamic("ball", ball, skin, Mass::Total(0.1))?
        .at(Pose::from_translation(START))
        .with_velocity(GUESS);
    let slab = |name, lengths, [x, z]: [f64; 2]| {
        let shape = Shape::new(shapes::cuboid(lengths)?);
        let slab = Body::fixed(name, shape, skin)?;
        Ok::<_, Box<dyn Error>>(slab.at(Pose::from_translation(vector![x, 0.0, z])))
    };
    let floor = slab("floor", [3.0, 3.0, 0.5], [0.0, -0.25])?;
    let wall = slab("wall", [0.5, 3.0, 3.0], [1.25, 1.5])?;
    Ok(World::new(vec![ball, floor, wall])?.with_gravity(vector![0.0, 0.0, -9.81])?)
}
