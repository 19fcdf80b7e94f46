//! Which of 1,000 random throws ends nearest to a target, and does Newton's method meet it from the
//! best eight?
//!
//! `cargo run --release --example random_search`

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Batch, Body, Mass, Material, World};
use hydroelastic::gradient::{FinalPosition, Parameter};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use indicatif::ProgressBar;
use nalgebra::{Vector3, vector};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::error::Error;

/// Where the ball starts, and where it should be at the end (m).
const START: Vector3<f64> = Vector3::new(0.0, 0.0, 0.5);
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
    let (world, by_velocity) = (room()?, [Parameter::InitialVelocity("ball")]);
    let end = FinalPosition::of_body(&world, "ball")?;
    let bar = ProgressBar::new(THROWS as u64);
    let batch = Batch::new(TIME_STEP, STEPS)?
        .recording_every(STEPS)
        .with_progress(|progress| bar.set_position(progress.finished as u64));

    let mut random = StdRng::seed_from_u64(7);
    let mut throw = |_| Vector3::from_fn(|_, _| random.random_range(-FASTEST..FASTEST));
    let mut throws: Vec<Vector3<f64>> = (0..THROWS).map(&mut throw).collect();
    let ends = batch.values_after(&world, &by_velocity, &throws, &end);
    let misses: Vec<f64> = ends
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
    let hits = (ends.into_iter().flatten())
        .filter(|end| (Vector3::from_column_slice(end) - TARGET).norm() < HIT)
        .count();
    bar.finish_and_clear();
    println!("from {hits} of the best {BEST} Newton's method meets the target");
    assert!(nearest > HIT && hits >= BEST / 2);
    Ok(())
}

/// A ball of 0.1 kg above the floor z = 0 and in front of the wall x = 1 m.
fn room() -> Result<World, Box<dyn Error>> {
    let skin = Material::elastic(1e5)
        .with_dissipation(0.05)
        .with_friction(0.3);
    let ball = Shape::new(shapes::icosphere(0.05, 2)?);
    let ball = Body::dynamic("ball", ball, skin, Mass::Total(0.1))?;
    let slab = |name, lengths, [x, z]: [f64; 2]| {
        let slab = Body::fixed(name, Shape::new(shapes::cuboid(lengths)?), skin)?;
        Ok::<_, Box<dyn Error>>(slab.at(Pose::from_translation(vector![x, 0.0, z])))
    };
    let bodies = vec![
        ball.at(Pose::from_translation(START)),
        slab("floor", [8.0, 8.0, 0.5], [0.0, -0.25])?,
        slab("wall", [0.5, 8.0, 4.0], [1.25, 1.5])?,
    ];
    Ok(World::new(bodies)?.with_gravity(vector![0.0, 0.0, -9.81])?)
}
