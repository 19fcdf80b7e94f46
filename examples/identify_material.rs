//! Can Gauss–Newton tell a ball's modulus, dissipation and friction from a recorded bounce?
//!
//! `cargo run --example identify_material`

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Mass, Material, State, Trajectory, World};
use hydroelastic::gradient::Parameter::{Dissipation, Friction, Modulus};
use hydroelastic::gradient::{Experiment, Outcome, OutcomeJacobian};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::Scalar;
use hydroelastic::spatial::Pose;
use nalgebra::{DVector, Vector3, vector};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::error::Error;

/// Modulus (Pa), dissipation (s/m) and friction of the ball, as they are and as first guessed, and
/// of the floor, which are known. A pair has the harmonic mean of both frictions.
const TRUTH: Vector3<f64> = Vector3::new(1e5, 0.3, 0.2);
const GUESS: Vector3<f64> = Vector3::new(1.5e5, 0.15, 0.4);
const FLOOR: Vector3<f64> = Vector3::new(1e6, 0.1, 0.4);
/// Time step (s), steps, and one record in so many: every millisecond.
const TIME_STEP: f64 = 2e-4;
const STEPS: usize = 2_000;
const RECORD_EVERY: usize = 5;
/// How far the ball gets along the floor and upwards (m), how fast (m/s), and the standard deviation
/// of the noise relative to these.
const RANGE: [f64; 4] = [1.5, 0.1, 4.0, 1.0];
const NOISE: f64 = 0.01;
/// Relative errors allowed. With noise the Jacobian predicts a standard deviation of 0.005.
const CLEAN_ERROR: f64 = 1e-3;
const NOISY_ERROR: f64 = 0.02;
/// The last two iterations change nothing but round-off.
const ITERATIONS: usize = 7;

/// Positions and velocities in the plane of the flight, over their ranges.
struct Track;

impl Outcome for Track {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let numbers = |state: &State<T>| {
            let ball = &state.bodies[0];
            let (p, v) = (ball.position(), ball.velocity());
            let numbers = [p.x, p.z, v.x, v.z];
            [0, 1, 2, 3].map(|i| numbers[i] / RANGE[i])
        };
        trajectory.states().iter().flat_map(numbers).collect()
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let clean = linearised(&TRUTH)?.value;
    let mut random = StdRng::seed_from_u64(1);
    // Uniform numbers between ∓√3 have standard deviation 1.
    let mut noise = || NOISE * 3.0_f64.sqrt() * random.random_range(-1.0..1.0);
    let noisy = clean.map(|number| number + noise());
    for (track, allowed) in [(clean, CLEAN_ERROR), (noisy, NOISY_ERROR)] {
        let numbers = fitted(&track)?;
        let errors = numbers.component_div(&TRUTH).add_scalar(-1.0);
        println!("modulus, dissipation, friction: {:.5?}", numbers.as_slice());
        assert!(errors.amax() < allowed);
    }
    Ok(())
}

/// The three numbers whose track is nearest to a recorded one.
fn fitted(recorded: &DVector<f64>) -> Result<Vector3<f64>, Box<dyn Error>> {
    let mut numbers = GUESS;
    for _ in 0..ITERATIONS {
        let OutcomeJacobian { value, jacobian } = linearised(&numbers)?;
        let step = jacobian.svd(true, true).solve(&(recorded - value), 0.0)?;
        numbers = numbers.zip_map(&step.fixed_rows::<3>(0), |number, step| number * step.exp());
    }
    Ok(numbers)
}

/// The track and its derivatives by the logarithms of the three numbers.
fn linearised(numbers: &Vector3<f64>) -> Result<OutcomeJacobian, Box<dyn Error>> {
    let material = |of: &Vector3<f64>| {
        let elastic = Material::elastic(of.x);
        elastic.with_dissipation(of.y).with_friction(of.z)
    };
    let at_height = |z| Pose::from_translation(vector![0.0, 0.0, z]);
    let ball = Shape::new(shapes::icosphere(0.05, 2)?);
    let floor = Shape::new(shapes::cuboid([6.0, 2.0, 0.5])?);
    let ball = Body::dynamic("ball", ball, material(numbers), Mass::Total(0.2))?
        .at(at_height(0.1))
        .with_velocity(vector![4.0, 0.0, 0.0]);
    let floor = Body::fixed("floor", floor, material(&FLOOR))?.at(at_height(-0.25));
    let world = World::new(vec![ball, floor])?.with_gravity(vector![0.0, 0.0, -9.81])?;
    let throw = Experiment::new(&world, TIME_STEP, STEPS)?.recording_every(RECORD_EVERY);
    let by = [Modulus("ball"), Dissipation("ball"), Friction("ball")];
    let mut linear = throw.jacobian(&by, &Track)?;
    for (mut column, number) in linear.jacobian.column_iter_mut().zip(numbers) {
        column *= *number;
    }
    Ok(linear)
}
