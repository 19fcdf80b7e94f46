//! Can Gauss–Newton tell a ball's modulus, dissipation and friction from a recorded bounce?
//!
//! `cargo run --release -p hydroelastic-examples --example identify_material [-- --record FILE.glb --plot FILE.svg]`

mod bounce;
#[path = "../show/mod.rs"]
mod show;

use bounce::Track;
use hydroelastic::dynamics::Plan;
use hydroelastic::gradient::Parameter::{Dissipation, Friction, Modulus};
use hydroelastic::gradient::{Experiment, OutcomeJacobian};
use hydroelastic::io::Recording;
use nalgebra::{DVector, Vector3};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use show::{Curve, Panel};
use std::error::Error;

/// Modulus (Pa), dissipation (s/m) and friction of the ball, as they are and as first guessed.
const TRUTH: Vector3<f64> = Vector3::new(1e5, 0.3, 0.2);
const GUESS: Vector3<f64> = Vector3::new(1.5e5, 0.15, 0.4);
/// Time step (s), steps, and one record in so many: every millisecond.
const TIME_STEP: f64 = 2e-4;
const STEPS: usize = 2_000;
const RECORD_EVERY: usize = 5;
/// Standard deviation of the noise, relative to how far and how fast the ball gets.
const NOISE: f64 = 0.01;
/// Relative errors allowed. With noise the Jacobian predicts a standard deviation of 0.005.
const CLEAN_ERROR: f64 = 1e-3;
const NOISY_ERROR: f64 = 0.02;
/// The last two iterations change nothing but round-off.
const ITERATIONS: usize = 7;

fn main() -> Result<(), Box<dyn Error>> {
    let clean = linearized(&TRUTH)?.value;
    let mut random = StdRng::seed_from_u64(1);
    // Uniform numbers between ∓√3 have standard deviation 1.
    let mut noise = || NOISE * 3.0_f64.sqrt() * random.random_range(-1.0..1.0);
    let noisy = clean.map(|number| number + noise());
    let mut misfits = Vec::new();
    for (track, allowed) in [(clean, CLEAN_ERROR), (noisy, NOISY_ERROR)] {
        let (numbers, norms) = fitted(&track)?;
        misfits.push(norms);
        let errors = numbers.component_div(&TRUTH).add_scalar(-1.0);
        println!("modulus, dissipation, friction: {:.5?}", numbers.as_slice());
        assert!(errors.amax() < allowed);
    }
    let world = bounce::world(&TRUTH)?;
    let bounce = Experiment::new(&world, &Plan::new(TIME_STEP, STEPS)?).trajectory()?;
    let wanted = show::wanted()?;
    wanted.record(|| Ok(Recording::new(&world, &bounce).slowed(8.0)))?;
    wanted.plot(|| {
        let both = ["clean", "noisy"].into_iter().zip(misfits);
        let curves = both.map(|(name, norms)| Curve::counted(name, norms.into_iter()));
        let misfits = Panel::counted("iteration", curves.collect());
        let force = show::contact_force(&world, &bounce.thinned(RECORD_EVERY), 0);
        vec![misfits, force]
    })
}

/// The three numbers whose track is nearest to a recorded one, and how far it was before each step.
fn fitted(recorded: &DVector<f64>) -> Result<(Vector3<f64>, Vec<f64>), Box<dyn Error>> {
    let (mut numbers, mut misfits) = (GUESS, Vec::new());
    for _ in 0..ITERATIONS {
        let OutcomeJacobian { value, jacobian } = linearized(&numbers)?;
        let misfit = recorded - value;
        misfits.push(misfit.norm());
        let step = jacobian.svd(true, true).solve(&misfit, 0.0)?;
        numbers = numbers.zip_map(&step.fixed_rows::<3>(0), |number, step| number * step.exp());
    }
    Ok((numbers, misfits))
}

/// The track and its derivatives by the logarithms of the three numbers.
fn linearized(numbers: &Vector3<f64>) -> Result<OutcomeJacobian, Box<dyn Error>> {
    let plan = Plan::new(TIME_STEP, STEPS)?.recording_every(RECORD_EVERY);
    let throw = Experiment::new(bounce::world(numbers)?, &plan);
    let by = [Modulus, Dissipation, Friction].map(|of| of("ball".into()));
    let mut linear = throw.jacobian(&by, &Track)?;
    for (mut column, number) in linear.jacobian.column_iter_mut().zip(numbers) {
        column *= *number;
    }
    Ok(linear)
}
