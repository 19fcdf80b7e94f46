//! Does a ball on a slope roll or slide with the accelerations of the textbook?
//!
//! `cargo run --release -p hydroelastic-examples --example ball_on_incline [-- --record FILE.glb --plot FILE.svg]`
//!
//! A solid ball that rolls gains (5/7)·g·sin θ; one with too little friction for that slides and
//! gains g·(sin θ − μ·cos θ). Both are means of the contact force, whatever its course, so they hold
//! for a ball that was dropped and still bounces a little.

mod show;

use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{Body, BodyState, Mass, Material, Plan, Trajectory, World};
use hydroelastic::io::Recording;
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{MassProperties, Pose};
use nalgebra::{Vector3, vector};
use std::error::Error;

const GRAVITY: f64 = 9.81;
/// Angle θ of the slope (rad).
const SLOPE: f64 = 0.2;
/// Radius (m) and mass (kg) of the ball.
const RADIUS: f64 = 0.1;
const MASS: f64 = 1.0;

/// Coefficients of friction that grip and slip: a ball rolls from (2/7)·tan θ = 0.058 on.
const GRIPPING: f64 = 0.5;
const SLIPPING: f64 = 0.03;

/// Time step (s), and the steps between which the acceleration is measured, after most bounces.
const TIME_STEP: f64 = 4e-4;
const SETTLED: usize = 2_000;
const END: usize = 4_000;

/// How far an acceleration may be from the textbook's, where the ball is rigid too. The skin resists
/// rolling (1 %), the ball is a polyhedron, and the last bounces do not end with the measurement
/// (1 %). The two accelerations are 19 % apart.
const TOLERANCE: f64 = 0.03;

/// Speed of the surface where it touches, relative to the ball's, that counts as rolling.
const NO_SLIP: f64 = 0.02;

fn main() -> Result<(), Box<dyn Error>> {
    let down_pull = GRAVITY * SLOPE.sin();
    let textbook = [
        (GRIPPING, 5.0 / 7.0 * down_pull),
        (SLIPPING, down_pull - SLIPPING * GRAVITY * SLOPE.cos()),
    ];
    let wanted = show::wanted()?;
    for (friction, expected) in textbook {
        let (world, trajectory) = rolled_down(friction)?;
        let [settled, end] = [SETTLED, END].map(|step| trajectory.states()[step].bodies[0]);
        let speed = |ball: &BodyState| ball.velocity().dot(&downhill());
        let duration = (END - SETTLED) as f64 * TIME_STEP;
        let acceleration = (speed(&end) - speed(&settled)) / duration;
        let slip = 1.0 - end.twist.angular.y * RADIUS / speed(&end);
        println!("friction {friction}: {acceleration:.3} m/s², textbook {expected:.3}");
        println!("  slip at the end: {:.1} % of the speed", 100.0 * slip);
        assert!((acceleration / expected - 1.0).abs() < TOLERANCE);
        assert_eq!(slip.abs() < NO_SLIP, friction == GRIPPING);
        if friction == GRIPPING {
            let (eye, middle) = (vector![-1.6, -2.6, 0.9], vector![-1.6, 0.0, 0.25]);
            wanted.record(|| Ok(Recording::new(&world, &trajectory).seen_from(eye, middle)))?;
            let shown = trajectory.thinned(10);
            wanted.plot(|| vec![show::energies(&world, &shown)])?;
        }
    }
    Ok(())
}

/// Direction down the slope: x, turned about y.
fn downhill() -> Vector3<f64> {
    vector![SLOPE.cos(), 0.0, -SLOPE.sin()]
}

/// The ball and the slope, and every state of the ball's way.
fn rolled_down(friction: f64) -> Result<(World, Trajectory), Box<dyn Error>> {
    let elastic = Material::elastic(1e7);
    let skin = elastic.with_dissipation(0.5).with_friction(friction);
    let hard = Material::rigid().with_friction(friction);
    let ball = Shape::new(shapes::icosphere(RADIUS, 3)?);
    let solid = MassProperties::solid_ball(MASS, RADIUS);
    // The slope is z = 0 in its frame; the ball falls 1 cm onto it.
    let turned = Pose::from_rotation_vector(&vector![0.0, SLOPE, 0.0], Vector3::zeros());
    let at = |x, z| turned * Pose::from_translation(vector![x, 0.0, z]);
    let world = World::new(vec![
        Body::dynamic("ball", ball, skin, Mass::Properties(solid))?
            .with_pose(at(-3.0, RADIUS + 0.01)),
        Body::fixed("slope", HalfSpace::rigid(), hard)?.with_pose(turned),
    ])?
    .with_gravity(vector![0.0, 0.0, -GRAVITY])?;
    let trajectory = world.rollout(&Plan::new(TIME_STEP, END)?).run()?;
    Ok((world, trajectory))
}
