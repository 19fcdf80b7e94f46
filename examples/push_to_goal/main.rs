//! Which pushes bring a block, sliding with friction, to rest at a goal pose?
//!
//! `cargo run --release --example push_to_goal [-- --record FILE.glb --plot FILE.svg]`
//!
//! An iterative linear-quadratic regulator: each iteration linearises the block's motion over every interval of the control,
//! and improves the pushes by the feedback that is optimal for the linearised motion.

mod regulator;
#[path = "../show/mod.rs"]
mod show;

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Control, Mass, Material, Plan, State, World, WorldError};
use hydroelastic::io::Recording;
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, Wrench};
use indicatif::ProgressBar;
use nalgebra::vector;
use regulator::{Iteration, Regulator};
use show::{Curve, Panel};
use std::error::Error;

const GRAVITY: f64 = 9.81;
/// The block (m, kg) and its friction.
const SIZE: [f64; 3] = [0.2, 0.2, 0.1];
const MASS: f64 = 1.0;
const FRICTION: f64 = 0.3;
/// Speed (m/s) below which friction is not full.
const SLIP_TOLERANCE: f64 = 1e-2;

/// Time step (s), steps until the block has settled, steps of an interval of the control, and intervals.
const TIME_STEP: f64 = 1e-3;
const SETTLING: usize = 500;
const INTERVAL: usize = 50;
const INTERVALS: usize = 20;

/// Where the block should be at rest in the end: place (m) and angle (rad).
const GOAL: [f64; 2] = [0.3, 0.2];
const ANGLE: f64 = 0.8;

/// What counts as there: place (m), angle (rad), speed (m/s).
const NEAR: [f64; 3] = [1e-3, 1e-2, 1e-2];
const ITERATIONS: usize = 40;

fn main() -> Result<(), Box<dyn Error>> {
    let wanted = show::wanted()?;
    let (world, start) = settled()?;
    let goal = goal(&start);
    let regulator = Regulator {
        goal,
        plan: Plan::new(TIME_STEP, INTERVAL)?,
    };
    let bar = ProgressBar::new(ITERATIONS as u64);
    let mut iterations = vec![regulator.begun(&world.starting_from(&start)?)?];
    let last = loop {
        let last = &iterations[iterations.len() - 1];
        let missed = missed(last, &regulator.goal)?;
        if missed.iter().zip(NEAR).all(|(missed, near)| *missed < near) {
            break last;
        }
        assert!(iterations.len() <= ITERATIONS, "{missed:?} from the goal");
        let better = regulator.improved(last)?;
        iterations.push(better.ok_or("no pushes are better")?);
        bar.inc(1);
    };
    bar.finish_and_clear();

    let trajectory = last
        .world
        .rollout(&Plan::new(TIME_STEP, INTERVAL * INTERVALS)?)
        .recorded()?;
    let [place, angle, speed] = missed(last, &regulator.goal)?;
    println!(
        "after {} iterations: {place:.1e} m and {angle:.1e} rad off, {speed:.1e} m/s",
        iterations.len() - 1
    );
    wanted.record(|| Ok(Recording::new(&last.world, &trajectory).slowed(2.0)))?;
    wanted.plot(|| {
        let costs = Curve::counted("cost", iterations.iter().map(|it| it.cost));
        let costs = Panel::counted("iteration", vec![costs]);
        vec![costs, show::energies(&last.world, &trajectory.thinned(10))]
    })?;
    Ok(())
}

/// The block on the floor, without pushes, and the state in which it has come to rest.
fn settled() -> Result<(World, State), Box<dyn Error>> {
    let skin = Material::elastic(1e6)
        .with_dissipation(1.0)
        .with_friction(FRICTION);
    let block = Shape::new(shapes::cuboid(SIZE)?);
    let floor = Shape::new(shapes::cuboid([3.0, 3.0, 0.2])?);
    let world = World::new(vec![
        Body::dynamic("block", block, skin, Mass::Total(MASS))?
            .at(Pose::from_translation(vector![0.0, 0.0, 0.15])),
        Body::fixed("floor", floor, skin)?,
    ])?
    .with_gravity(vector![0.0, 0.0, -GRAVITY])?
    .with_slip_tolerance(SLIP_TOLERANCE)?;
    let rest = world.rollout(&Plan::new(TIME_STEP, SETTLING)?.recording_every(SETTLING));
    let mut start = rest.recorded()?.last().clone();
    start.time = 0.0;
    let none = vec![Wrench::zero(); INTERVALS];
    let control = Control::new("block", TIME_STEP * INTERVAL as f64, none)?;
    Ok((world.with_control(control)?, start))
}

/// The block at rest at the goal, pressed into the floor as it was in the beginning.
fn goal(start: &State) -> State {
    let mut goal = start.clone();
    let height = start.bodies[0].position().z;
    let place = vector![GOAL[0], GOAL[1], height];
    goal.bodies[0].pose = Pose::from_rotation_vector(&vector![0.0, 0.0, ANGLE], place);
    goal.bodies[0].twist = hydroelastic::spatial::Twist::zero();
    goal
}

/// How far from the goal an iteration ends: place (m), angle (rad), speed (m/s).
fn missed(iteration: &Iteration, goal: &State) -> Result<[f64; 3], WorldError> {
    let end = &iteration.states[INTERVALS];
    let away = iteration.world.displacement(goal, end)?;
    let part = |first: usize| away.rows(first, 3).norm();
    Ok([part(3), part(0), part(9)])
}
