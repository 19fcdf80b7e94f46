//! Can gradient descent find the throw that hits a target after bouncing off floor and wall, if it starts with a throw that misses the
//! wall?
//!
//! `cargo run --release -p hydroelastic-examples --example throw_to_target [-- --record FILE.glb --plot FILE.svg]`

mod room;
mod show;

use hydroelastic::dynamics::{Plan, State, Trajectory, World};
use hydroelastic::gradient::{Experiment, FirstContact, Outcome, Parameter};
use hydroelastic::io::Recording;
use hydroelastic::scalar::{Scalar, lift_vector};
use indicatif::ProgressBar;
use nalgebra::Vector3;
use show::{Curve, Panel};
use std::error::Error;

/// Target of the ball at the end (m), and the velocity of the first guess (m/s).
const TARGET: Vector3<f64> = Vector3::new(0.5, 0.3, 0.5);
const GUESS: Vector3<f64> = Vector3::new(1.0, 0.0, -2.0);
/// Target (m) of the clearance between ball and wall in the first steps. It is negative, so that the ball has time to bounce.
const AIM: f64 = -0.3;
/// Time step (s) and number of steps.
const TIME_STEP: f64 = 5e-4;
const STEPS: usize = 1_200;
/// Largest miss (m) that counts as a hit, a large miss (m), and the largest number of iterations.
const HIT: f64 = 1e-3;
const FAR: f64 = 0.1;
const ITERATIONS: usize = 60;
/// Fraction of the predicted decrease that a change must achieve. A change that achieves less is halved.
const SHARE: f64 = 0.1;

/// Squared distance (m²) of the ball's final position from the target.
struct SquaredMiss;

impl Outcome for SquaredMiss {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let position = trajectory.last().bodies[0].position();
        let miss = position - lift_vector::<T>(&TARGET);
        vec![miss.dot(&miss)]
    }
}

/// A throw, its flight, its miss (m) and the gradient norm of the squared miss (m² per m/s).
type Iteration = (World, Trajectory, f64, f64);

fn main() -> Result<(), Box<dyn Error>> {
    let (wanted, descent) = (show::wanted()?, descent()?);
    let (count, first) = (descent.len() - 1, descent[0].2);
    let (world, flight, last, _) = &descent[count];
    println!("miss (m): {first:.3}, after {count} iterations {last:.1e}");

    wanted.record(|| {
        let recording = Recording::new(world, flight).slowed(4.0);
        let recording = recording.with_target("target", TARGET, room::RADIUS);
        Ok(room::seen(
            descent.iter().fold(recording, |recording, throw| {
                recording.with_path("throw", show::path(&throw.1.thinned(10), 0))
            }),
        ))
    })?;
    let misses = Curve::counted("miss (m)", descent.iter().map(|throw| throw.2));
    let slopes = Curve::counted("slope (m²/(m/s))", descent.iter().map(|throw| throw.3));
    let descent = Panel::counted("iteration", vec![misses, slopes]);
    wanted.plot(|| vec![descent, show::energies(world, flight)])?;

    assert!(first > FAR && *last < HIT);
    let meets = |state: &State, other| {
        world
            .topology(state)
            .expect("a state of this world")
            .touches(0, other)
    };
    assert!(flight.states().iter().any(|state| meets(state, 1)), "floor");
    assert!(flight.states().iter().any(|state| meets(state, 2)), "wall");
    Ok(())
}

/// Finds a throw that reaches the wall, by Newton steps on the clearance.
fn throw_at_wall(plan: &Plan) -> Result<World, Box<dyn Error>> {
    let (mut world, by_velocity) = (
        room::with_ball(3, GUESS)?,
        [Parameter::initial_velocity("ball")],
    );
    for _ in 0..ITERATIONS {
        let throw = Experiment::new(&world, &plan.recording_every(10));
        match throw.first_contact(&by_velocity, ["ball", "wall"])? {
            FirstContact::Apart {
                least_clearance,
                gradient,
                ..
            } => {
                println!("misses the wall by {least_clearance:.3} m");
                let change = &gradient * ((AIM - least_clearance) / gradient.norm_squared());
                world = world.perturbed(&by_velocity, change.as_slice())?;
            }
            FirstContact::Touching { time, .. } => {
                println!("reaches the wall after {time:.3} s");
                return Ok(world);
            }
        }
    }
    Err("no throw reaches the wall".into())
}

fn descent() -> Result<Vec<Iteration>, Box<dyn Error>> {
    let (by_velocity, loss) = ([Parameter::initial_velocity("ball")], SquaredMiss);
    let plan = Plan::new(TIME_STEP, STEPS)?;
    let (mut world, mut rate, mut descent) = (throw_at_wall(&plan)?, 1.0, Vec::new());
    let bar = ProgressBar::new(ITERATIONS as u64);
    loop {
        let flight = world.rollout(&plan).run()?;
        let throw = Experiment::new(&world, &plan.recording_every(STEPS));
        let (value, slope) = throw.gradient(&by_velocity, &loss)?;
        let (miss, steepness) = (value.sqrt(), slope.norm());
        if miss < HIT || descent.len() == ITERATIONS {
            bar.finish_and_clear();
            descent.push((world, flight, miss, steepness));
            return Ok(descent);
        }
        let value_at = |rate: f64| {
            let change = &slope * -rate;
            throw.value_perturbed(&by_velocity, change.as_slice(), &loss)
        };
        rate *= 2.0;
        while value_at(rate)?[0] > value - SHARE * rate * slope.norm_squared() {
            rate /= 2.0;
        }
        let next = world.perturbed(&by_velocity, (slope * -rate).as_slice())?;
        descent.push((std::mem::replace(&mut world, next), flight, miss, steepness));
        bar.inc(1);
    }
}
