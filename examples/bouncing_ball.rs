//! Does a ball come back to the height it was dropped from (the paper's first video)?
//!
//! `cargo run --release -p hydroelastic-examples --example bouncing_ball [-- --record FILE.glb --plot FILE.svg]`

mod show;

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Mass, Material, Plan, State, Trajectory, World};
use hydroelastic::io::Recording;
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::vector;
use std::error::Error;

/// Radius of the ball and height of its center over the block at the start (m).
const RADIUS: f64 = 0.1;
const DROP_HEIGHT: f64 = 0.4;

/// Hydroelastic modulus (Pa) of ball and block, and the dissipation (s/m) of the lossy ones.
const MODULUS: f64 = 2e5;
const DISSIPATION: f64 = 0.1;
/// Time step (s), and steps: three lossless bounces.
const TIME_STEP: f64 = 2e-4;
const STEPS: usize = 9_000;
const BOUNCES: usize = 3;

/// How far an apex may be from the height of the drop (m): half a step lies between, g·Δt²/8 = 5e-8.
const SAME_HEIGHT: f64 = 1e-6;
/// Change of the total energy, relative to it: a leapfrog step is off by the square of Δt over the
/// time of contact, which is two hundred steps.
const SAME_ENERGY: f64 = 1e-4;

/// Each lossy bounce must cost so much of the height (m).
const LOST_HEIGHT: f64 = 0.01;

fn main() -> Result<(), Box<dyn Error>> {
    let (world, trajectory) = drop_with(0.0)?;
    let heights = apexes(&trajectory);
    println!("apexes without dissipation (m): {heights:.6?}");
    let energy_of = |state: &State| {
        world
            .diagnostics(state)
            .expect("a state of this world")
            .total_energy()
    };
    let energy = energy_of(&trajectory.states()[0]);
    let changes = trajectory.states().iter();
    let change = changes.fold(0.0_f64, |largest, state| {
        largest.max((energy_of(state) / energy - 1.0).abs())
    });
    println!("largest relative change of the energy: {change:.1e}");

    let wanted = show::wanted()?;
    wanted.record(|| Ok(Recording::new(&world, &trajectory).slowed(4.0)))?;
    wanted.plot(|| {
        let shown = trajectory.thinned(10);
        vec![
            show::energies(&world, &shown),
            show::contact_force(&world, &shown, 0),
        ]
    })?;

    let (_, trajectory) = drop_with(DISSIPATION)?;
    let lossy_heights = apexes(&trajectory);
    println!("apexes with dissipation (m): {lossy_heights:.6?}");

    assert_eq!(heights.len(), BOUNCES);
    let returns = |height: &f64| (height - DROP_HEIGHT).abs() < SAME_HEIGHT;
    assert!(heights.iter().all(returns));
    assert!(change < SAME_ENERGY);
    assert!(lossy_heights.len() >= BOUNCES);
    let all_heights = [vec![DROP_HEIGHT], lossy_heights].concat();
    let loses = |pair: &[f64]| pair[1] < pair[0] - LOST_HEIGHT;
    assert!(all_heights.windows(2).all(loses));
    Ok(())
}

/// A ball of 1 kg dropped on a block whose upper face is z = 0.
fn drop_with(dissipation: f64) -> Result<(World, Trajectory), Box<dyn Error>> {
    let skin = Material::elastic(MODULUS).with_dissipation(dissipation);
    let ball = Shape::new(shapes::icosphere(RADIUS, 3)?);
    let block = Shape::new(shapes::cuboid([1.0, 1.0, 0.4])?);
    let at_height = |z| Pose::from_translation(vector![0.0, 0.0, z]);
    let ball =
        Body::dynamic("ball", ball, skin, Mass::Total(1.0))?.with_pose(at_height(DROP_HEIGHT));
    let block = Body::fixed("block", block, skin)?.with_pose(at_height(-0.2));
    let world = World::new(vec![ball, block])?.with_gravity(vector![0.0, 0.0, -9.81])?;
    let trajectory = world.rollout(&Plan::new(TIME_STEP, STEPS)?).run()?;
    Ok((world, trajectory))
}

/// The heights (m) at which the ball turns from rising to falling.
fn apexes(trajectory: &Trajectory) -> Vec<f64> {
    let ball = |state: &State| state.bodies[0];
    let is_rising = |state: &State| ball(state).velocity().z > 0.0;
    let pairs = trajectory.states().windows(2);
    pairs
        .filter(|pair| is_rising(&pair[0]) && !is_rising(&pair[1]))
        .map(|pair| {
            let height = |state| ball(state).position().z;
            height(&pair[0]).max(height(&pair[1]))
        })
        .collect()
}
