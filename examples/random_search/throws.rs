//! Throws, given by their velocities (m/s): their misses and their improvement.

use hydroelastic::dynamics::{Batch, RolloutError, World};
use hydroelastic::gradient::{FinalPosition, GradientError, Parameter};
use nalgebra::Vector3;
use std::error::Error;

/// Target of the ball at the end (m).
pub const TARGET: Vector3<f64> = Vector3::new(0.6, 0.4, 0.3);
const NEWTON_STEPS: usize = 12;

type Answer<T> = Result<T, Box<dyn Error>>;

pub fn by_velocity() -> [Parameter; 1] {
    [Parameter::initial_velocity("ball")]
}

/// Returns the final distances (m) from the target of throws with these velocities (m/s). The distance is infinite for throws that did not
/// start.
pub fn misses(batch: &Batch, world: &World, throws: &[Vector3<f64>]) -> Answer<Vec<f64>> {
    let end = FinalPosition::of_body(world, "ball")?;
    let ends = batch.map(throws, |job, sample| {
        job.experiment(world.perturbed(&by_velocity(), sample.as_slice())?)
            .value(&end)
    });
    let miss = |end| match end {
        Err(GradientError::Rollout(RolloutError::Stopped)) => Ok(f64::INFINITY),
        end => Ok((Vector3::from_vec(end?) - TARGET).norm()),
    };
    ends.into_iter().map(miss).collect()
}

/// Moves throws closer to the target by Newton's method.
pub fn improve(batch: &Batch, world: &World, throws: &mut [Vector3<f64>]) -> Answer<()> {
    let end = FinalPosition::of_body(world, "ball")?;
    for _ in 0..NEWTON_STEPS {
        let ends = batch.map(throws, |job, sample| {
            job.experiment(world.perturbed(&by_velocity(), sample.as_slice())?)
                .jacobian(&by_velocity(), &end)
        });
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
