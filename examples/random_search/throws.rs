//! Throws, known by their velocities (m/s): how far they miss, and how they are improved.

use hydroelastic::dynamics::{Batch, World};
use hydroelastic::gradient::{FinalPosition, Parameter};
use nalgebra::Vector3;
use std::error::Error;

/// Where the ball should be at the end (m).
pub const TARGET: Vector3<f64> = Vector3::new(0.6, 0.4, 0.3);
pub const BY_VELOCITY: [Parameter; 1] = [Parameter::InitialVelocity("ball".into())];
const NEWTON_STEPS: usize = 12;

/// How far (m) throws of some velocities (m/s) end from the target.
pub fn misses(
    batch: &Batch,
    world: &World,
    throws: &[Vector3<f64>],
) -> Result<Vec<f64>, Box<dyn Error>> {
    let end = FinalPosition::of_body(world, "ball")?;
    let ends = batch.values_after(world, &BY_VELOCITY, throws, &end);
    let miss = |end: Vec<f64>| (Vector3::from_vec(end) - TARGET).norm();
    ends.into_iter().map(|end| Ok(miss(end?))).collect()
}

/// Takes throws nearer to the target, by Newton's method.
pub fn improve(
    batch: &Batch,
    world: &World,
    throws: &mut [Vector3<f64>],
) -> Result<(), Box<dyn Error>> {
    let end = FinalPosition::of_body(world, "ball")?;
    for _ in 0..NEWTON_STEPS {
        let ends = batch.jacobians_after(world, &BY_VELOCITY, throws, &end);
        for (throw, end) in throws.iter_mut().zip(ends) {
            let end = end?;
            let miss = end.value - TARGET;
            if let Some(change) = end.jacobian.lu().solve(&miss) {
                *throw -= change.fixed_rows::<3>(0);
            }
        }
    }
    Ok(())
}
