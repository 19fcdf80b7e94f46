//! Which shape of a soft cushion catches a thrown ball, so that it comes to rest at a target? The parameters are hundreds of vertex
//! coordinates, and reverse mode differentiates through contact, friction and dissipation. The cushion keeps its volume.
//!
//! `cargo run --release -p hydroelastic-examples --example design_bumper [-- --record FILE.glb --plot FILE.svg]`

mod cushion;
#[path = "../show/mod.rs"]
mod show;

use cushion::Cushion;
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Mass, Material, Plan, State, Trajectory, World};
use hydroelastic::gradient::{Experiment, HoldFixed, Integrand, TimeIntegral};
use hydroelastic::io::Recording;
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{Scalar, lift, lift_vector};
use hydroelastic::spatial::Pose;
use indicatif::ProgressBar;
use nalgebra::{Vector3, vector};
use show::{Curve, Panel};
use std::error::Error;

/// Radius (m) and mass (kg) of the ball, initial position (m) and velocity (m/s).
const RADIUS: f64 = 0.06;
const MASS: f64 = 0.3;
const START: Vector3<f64> = Vector3::new(-0.2, -0.05, 0.3);
const VELOCITY: Vector3<f64> = Vector3::new(0.7, 0.25, 0.0);
/// Target of the ball (m), as seen from above.
const TARGET: Vector3<f64> = Vector3::new(0.06, 0.04, 0.0);
/// Time (s) from which distance and speed count, and time (s) that converts a speed (m/s) to a distance (m).
const SETTLED: f64 = 0.6;
const TAU: f64 = 0.1;
/// Time step (s) and number of steps.
const TIME_STEP: f64 = 5e-4;
const STEPS: usize = 1_800;
/// Largest change (m) of a vertex in an iteration, and number of iterations.
const LARGEST_CHANGE: f64 = 1e-2;
const ITERATIONS: usize = 30;
/// Largest final miss, as a fraction of the initial miss.
const LEFT: f64 = 0.2;

/// Squared distance from the target plus scaled squared speed (m²), after the settling time.
struct Unrest;

impl Integrand for Unrest {
    fn at<T: Scalar>(&self, state: &State<T>) -> T {
        if state.time < SETTLED {
            return lift(0.0);
        }
        let ball = &state.bodies[0];
        let mut miss = ball.position() - lift_vector::<T>(&TARGET);
        miss.z = lift(0.0);
        let speed = ball.velocity();
        miss.dot(&miss) + speed.dot(speed) * (TAU * TAU)
    }
}

/// A cushion, its world, and the root of the mean unrest (m).
struct Design {
    cushion: Cushion,
    world: World,
    miss: f64,
}

impl Design {
    fn flight(&self) -> Result<Trajectory, Box<dyn Error>> {
        Ok(self.world.rollout(&plan()?).run()?)
    }
}

fn plan() -> Result<Plan, Box<dyn Error>> {
    Ok(Plan::new(TIME_STEP, STEPS)?.recording_every(10))
}

fn main() -> Result<(), Box<dyn Error>> {
    let wanted = show::wanted()?;
    let designs = descent()?;
    let (first, last) = (&designs[0], &designs[designs.len() - 1]);
    let flights = [first.flight()?, last.flight()?];
    let count = last.cushion.free_count();
    println!("{count} coordinates, {} iterations", designs.len() - 1);
    for (name, design, flight) in [
        ("flat", first, &flights[0]),
        ("designed", last, &flights[1]),
    ] {
        let end = flight.last().bodies[0];
        println!(
            "{name}: off by {:.4} m, at {:.4} m/s; in the mean {:.4} m; volume {:.6} m³, thinnest tetrahedron {:.2} of what it was",
            (end.position() - TARGET).xy().norm(),
            end.velocity().norm(),
            design.miss,
            design.cushion.volume(),
            design.cushion.thinnest(&first.cushion),
        );
    }
    wanted.record(|| {
        let recording = Recording::new(&last.world, &flights[1]).slowed(2.0);
        let recording = recording.with_target("target", TARGET + Vector3::z() * 0.1, 0.01);
        let paths = flights.iter().map(|flight| show::path(flight, 0));
        let drawn = paths.fold(recording, |recording, path| {
            recording.with_path("flight", path)
        });
        Ok(drawn.seen_from(vector![-0.2, -0.9, 0.7], vector![0.0, 0.0, 0.1]))
    })?;
    let misses = Curve::counted("mean miss (m)", designs.iter().map(|design| design.miss));
    wanted.plot(|| {
        vec![
            section([first, last], &flights),
            Panel::counted("iteration", vec![misses]),
        ]
    })?;
    let kept = (last.cushion.volume() / first.cushion.volume() - 1.0).abs();
    assert!(kept <= 1e-9, "the volume changed by {kept:e}");
    assert!(
        last.miss <= LEFT * first.miss,
        "{} of {}",
        last.miss,
        first.miss
    );
    Ok(())
}

/// Plots the path of the ball from the side, and the top of the cushion near the target, before and after optimization.
fn section(designs: [&Design; 2], flights: &[Trajectory; 2]) -> Panel {
    let mut curves = Vec::new();
    for ((name, design), flight) in ["flat", "designed"].into_iter().zip(designs).zip(flights) {
        let way = flight.states().iter().map(|state| {
            let place = state.bodies[0].position();
            (place.x, place.z)
        });
        curves.push(Curve::new(&format!("ball, {name}"), way));
        let top = design.cushion.top_near(TARGET.y, &designs[0].cushion);
        curves.push(Curve::new(&format!("cushion, {name}"), top));
    }
    Panel {
        x_label: "x (m)",
        y_label: "z (m)",
        is_log: false,
        curves,
    }
}

fn thrown_on(cushion: &Cushion) -> Result<World, Box<dyn Error>> {
    let skin = |modulus: f64| {
        let material = Material::elastic(modulus).with_dissipation(1.0);
        material.with_friction(0.4)
    };
    let ball = Shape::new(shapes::icosphere(RADIUS, 2)?);
    let ball = Body::dynamic("ball", ball, skin(2e5), Mass::Total(MASS))?
        .with_pose(Pose::from_translation(START))
        .with_velocity(VELOCITY);
    let cushion = Body::fixed("cushion", Shape::new(cushion.field()?), skin(5e4))?;
    let world = World::new(vec![ball, cushion])?;
    let world = world.with_gravity(vector![0.0, 0.0, -9.81])?;
    Ok(world.with_slip_tolerance(2e-2)?)
}

/// Performs steepest descent on smoothed gradients. A step that does not reduce the unrest is shortened.
fn descent() -> Result<Vec<Design>, Box<dyn Error>> {
    let plan = plan()?;
    let tried = |cushion: Cushion| {
        let world = thrown_on(&cushion)?;
        let value = Experiment::new(&world, &plan).value(&TimeIntegral(Unrest))?[0];
        let duration = STEPS as f64 * TIME_STEP - SETTLED;
        let miss = (value / duration).sqrt();
        Ok::<_, Box<dyn Error>>(Design {
            cushion,
            world,
            miss,
        })
    };
    let mut designs = vec![tried(Cushion::flat()?)?];
    let (bar, mut size) = (ProgressBar::new(ITERATIONS as u64), LARGEST_CHANGE);
    while designs.len() <= ITERATIONS && size > 1e-3 * LARGEST_CHANGE {
        let design = &designs[designs.len() - 1];
        let found = Experiment::new(&design.world, &plan).full_gradient(&TimeIntegral(Unrest))?;
        let slope = found.by_shape("cushion", HoldFixed::MassProperties)?;
        let direction = design.cushion.smoothed(&slope.by_vertices);
        // The step starts at twice the last accepted size, at most `LARGEST_CHANGE`, and shrinks until it helps.
        size = (2.0 * size).min(LARGEST_CHANGE);
        while size > 1e-3 * LARGEST_CHANGE {
            if let Some(next) = design.cushion.moved(&direction, -size) {
                let next = tried(next)?;
                if next.miss < design.miss {
                    designs.push(next);
                    break;
                }
            }
            size /= 2.0;
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(designs)
}
