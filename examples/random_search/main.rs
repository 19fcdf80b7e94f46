//! Which of 1,000 random throws ends nearest to a target, and does Newton's method meet it from the
//! best eight? Ctrl-C ends the search with the throws that were finished.
//!
//! `cargo run --release -p hydroelastic-examples --example random_search [-- --record FILE.glb --plot FILE.svg]`

#[path = "../room/mod.rs"]
mod room;
#[path = "../show/mod.rs"]
mod show;
mod throws;

use hydroelastic::dynamics::{Batch, Plan};
use hydroelastic::io::Recording;
use indicatif::ProgressBar;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use show::{Curve, Panel};
use std::error::Error;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use throws::{TARGET, by_velocity};

/// Time step (s) and steps.
const TIME_STEP: f64 = 5e-4;
const STEPS: usize = 1_200;
/// Throws, and the largest component of their velocities (m/s).
const THROWS: usize = 1_000;
const FASTEST: f64 = 4.0;
/// How many of them go on.
const BEST: usize = 8;
/// A miss (m) that counts as a hit.
const HIT: f64 = 1e-6;

fn main() -> Result<(), Box<dyn Error>> {
    let wanted = show::wanted()?;
    let world = room::with_ball(2, Vector3::zeros())?;
    let plan = Plan::new(TIME_STEP, STEPS)?;
    let bar = ProgressBar::new(THROWS as u64);
    let shown = bar.clone();
    let is_stopped = Arc::new(AtomicBool::new(false));
    let [stopping, stopped] = [0, 1].map(|_| Arc::clone(&is_stopped));
    ctrlc::set_handler(move || stopping.store(true, Ordering::Relaxed))?;
    let batch = Batch::new(&plan.recording_every(STEPS)).with_progress(move |progress| {
        shown.set_position(progress.finished as u64);
        if stopped.load(Ordering::Relaxed) {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    });
    let mut random = StdRng::seed_from_u64(7);
    let throw = |_| Vector3::from_fn(|_, _| random.random_range(-FASTEST..FASTEST));
    let mut throws: Vec<Vector3<f64>> = (0..THROWS).map(throw).collect();
    let misses = throws::misses(&batch, &world, &throws)?;
    let mut ranking: Vec<usize> = (0..THROWS).collect();
    ranking.sort_by(|&i, &j| misses[i].total_cmp(&misses[j]));
    let nearest = misses[ranking[0]];
    println!("throw {} is nearest, {nearest:.3} m off", ranking[0]);
    if is_stopped.load(Ordering::Relaxed) {
        return Ok(());
    }

    throws = ranking[..BEST].iter().map(|&i| throws[i]).collect();
    throws::improve(&batch, &world, &mut throws)?;
    let ends = throws.iter().zip(throws::misses(&batch, &world, &throws)?);
    let hits: Vec<_> = ends
        .filter(|(_, miss)| *miss < HIT)
        .map(|(throw, _)| throw)
        .collect();
    bar.finish_and_clear();
    let count = hits.len();
    println!("from {count} of the best {BEST} Newton's method meets the target");
    assert!(nearest > HIT && count >= BEST / 2);

    let flights = hits.iter().map(|throw| {
        let world = world.perturbed(&by_velocity(), throw.as_slice())?;
        Ok(world.rollout(&plan).run()?)
    });
    let flights = flights.collect::<Result<Vec<_>, Box<dyn Error>>>()?;
    wanted.record(|| {
        let recording = Recording::new(&world, &flights[0]).slowed(4.0);
        let recording = recording.with_target("target", TARGET, room::RADIUS);
        let paths = flights.iter().map(|flight| flight.thinned(10));
        Ok(room::seen(paths.fold(recording, |recording, flight| {
            recording.with_path("throw", show::path(&flight, 0))
        })))
    })?;
    wanted.plot(|| {
        let misses = Curve::counted("miss (m)", ranking.iter().map(|&throw| misses[throw]));
        let misses = Panel::counted("throw, by its miss", vec![misses]);
        vec![misses, show::energies(&world, &flights[0])]
    })
}
