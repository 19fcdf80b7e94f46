//! Which of 1,000 random throws ends nearest to a target, and does Newton's method meet it from the
//! best eight?
//!
//! `cargo run --release --example random_search [-- --record FILE.glb --plot FILE.svg]`

mod room;
mod show;

use hydroelastic::dynamics::Batch;
use hydroelastic::gradient::{Experiment, FinalPosition, Parameter};
use hydroelastic::io::Recording;
use indicatif::ProgressBar;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use show::{Curve, Panel};
use std::error::Error;

/// Where the ball should be at the end (m).
const TARGET: Vector3<f64> = Vector3::new(0.6, 0.4, 0.3);
/// Time step (s) and steps.
const TIME_STEP: f64 = 1e-3;
const STEPS: usize = 600;
/// Throws, and the largest component of their velocities (m/s).
const THROWS: usize = 1_000;
const FASTEST: f64 = 4.0;
/// How many of them go on, and for how many steps of Newton's method.
const BEST: usize = 8;
const NEWTON_STEPS: usize = 12;
/// A miss (m) that counts as a hit.
const HIT: f64 = 1e-6;

fn main() -> Result<(), Box<dyn Error>> {
    let (world, by_velocity) = (
        room::with_ball(2, Vector3::zeros())?,
        [Parameter::InitialVelocity("ball")],
    );
    let end = FinalPosition::of_body(&world, "ball")?;
    let bar = ProgressBar::new(THROWS as u64);
    let batch = Batch::new(TIME_STEP, STEPS)?
        .recording_every(STEPS)
        .with_progress(|progress| bar.set_position(progress.finished as u64));

    let mut random = StdRng::seed_from_u64(7);
    let mut throw = |_| Vector3::from_fn(|_, _| random.random_range(-FASTEST..FASTEST));
    let mut throws: Vec<Vector3<f64>> = (0..THROWS).map(&mut throw).collect();
    let ends = batch.values_after(&world, &by_velocity, &throws, &end);
    let mut misses: Vec<f64> = ends
        .into_iter()
        .map(|end| Ok((Vector3::from_vec(end?) - TARGET).norm()))
        .collect::<Result<_, Box<dyn Error>>>()?;
    let mut ranking: Vec<usize> = (0..THROWS).collect();
    ranking.sort_by(|&i, &j| misses[i].total_cmp(&misses[j]));
    let nearest = misses[ranking[0]];
    println!("throw {} is nearest, {nearest:.3} m off", ranking[0]);

    throws = ranking[..BEST].iter().map(|&i| throws[i]).collect();
    for _ in 0..NEWTON_STEPS {
        let ends = batch.jacobians_after(&world, &by_velocity, &throws, &end);
        for (throw, end) in throws.iter_mut().zip(ends) {
            let end = end?;
            let miss = end.value - TARGET;
            if let Some(change) = end.jacobian.lu().solve(&miss) {
                *throw -= change.fixed_rows::<3>(0);
            }
        }
    }
    let ends = batch.values_after(&world, &by_velocity, &throws, &end);
    let ends = ends.into_iter().collect::<Result<Vec<_>, _>>()?;
    let is_hit = |end: &[f64]| (Vector3::from_column_slice(end) - TARGET).norm() < HIT;
    let hits = throws.into_iter().zip(ends).filter(|(_, end)| is_hit(end));
    let hits: Vec<_> = hits.map(|(throw, _)| throw).collect();
    bar.finish_and_clear();
    let count = hits.len();
    println!("from {count} of the best {BEST} Newton's method meets the target");
    assert!(nearest > HIT && count >= BEST / 2);

    let flights = hits.iter().map(|throw| {
        let world = world.changed(&by_velocity, throw.as_slice())?;
        Ok(Experiment::new(&world, TIME_STEP, STEPS)?.trajectory()?)
    });
    let flights = flights.collect::<Result<Vec<_>, Box<dyn Error>>>()?;
    let wanted = show::wanted()?;
    wanted.record(|| {
        let recording = Recording::new(&world, &flights[0]).slowed(4.0);
        let recording = recording.with_target("target", TARGET, room::RADIUS);
        Ok(room::seen(
            flights.iter().fold(recording, |recording, flight| {
                recording.with_path("throw", show::path(&flight.thinned(5), 0))
            }),
        ))
    })?;
    misses.sort_by(|a, b| b.total_cmp(a));
    let misses = Panel::of_iterations(vec![Curve::counted("miss (m)", misses.into_iter())]);
    wanted.plot(|| vec![misses, show::energies(&world, &flights[0])])
}
