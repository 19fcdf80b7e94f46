//! Do ten blocks dropped on each other come to rest, and how far does a push slide those above one that is slippery?
//!
//! `cargo run --release -p hydroelastic-examples --example stack [-- --record FILE.glb --plot FILE.svg]`

mod show;

use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{
    Body, Control, Integrator, Mass, Material, Plan, State, Trajectory, World,
};
use hydroelastic::io::Recording;
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, Wrench};
use nalgebra::{Vector3, vector};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use show::{Curve, Panel};
use std::error::Error;
use std::sync::Arc;

/// Integrator, steps per second, and the speed (m/s) below which friction is not full.
/// Implicit Euler is quicker, but it steps over the start of the slide, where friction is less than full.
const STEPPING: (Integrator, usize, f64) = (Integrator::Sdirk3, 200, 1e-3);

const GRAVITY: f64 = 9.81;
/// A block (m, kg), how many there are, and the one that is pushed, which lies on the slippery one.
const SIZE: [f64; 3] = [0.2, 0.2, 0.03];
const MASS: f64 = 0.5;
const COUNT: usize = 10;
const PUSHED: usize = 4;
const SLIPPERY: usize = PUSHED - 1;
/// Friction of the others, and of the slippery one.
const FRICTIONS: [f64; 2] = [0.4, 0.2];
/// Gaps to fall through (m), shifts along x and y (m), turns about the vertical (rad).
const GAPS: [f64; 2] = [1e-4, 1e-3];
const SHIFT: f64 = 1e-3;
const TURN: f64 = 0.05;

/// Tenths of a second: until the push, of the push, after it.
const BEFORE: usize = 5;
const PUSHING: usize = 1;
const AFTER: usize = 3;
/// The push (N), along x.
const PUSH: f64 = 16.0;

/// A speed (m/s) that counts as rest.
const AT_REST: f64 = 1e-4;
/// How far the blocks below the push may creep (m): at the slip tolerance, all of them the same way, while the others slide.
const CREEP: f64 = STEPPING.2 * PUSHED as f64 * (PUSHING + AFTER) as f64 / 10.0;
/// Relative error allowed in the way of the others: friction is less than full when they begin to slide.
const WAY_ERROR: f64 = 0.01;

fn main() -> Result<(), Box<dyn Error>> {
    let (wanted, world) = (show::wanted()?, stacked()?);
    let (integrator, rate, _) = STEPPING;
    let steps = (BEFORE + PUSHING + AFTER) * rate / 10;
    let plan = Plan::new(1.0 / rate as f64, steps)?.with_integrator(integrator);
    let trajectory = world.rollout(&plan.recording_every(rate / 100)).run()?;
    let states = trajectory.states();
    let (settled, last) = (&states[10 * BEFORE], trajectory.last());
    let ways: Vec<Vector3<f64>> = (settled.bodies.iter().zip(&last.bodies))
        .map(|(before, after)| after.position() - before.position())
        .take(COUNT)
        .collect();
    println!(
        "fastest block: {:.1e} m/s before the push, {:.1e} m/s after it",
        fastest(settled),
        fastest(last)
    );
    println!(
        "ways along x (mm): {:.2?}",
        ways.iter().map(|way| 1e3 * way.x).collect::<Vec<_>>()
    );

    assert!(fastest(settled) < AT_REST && fastest(last) < AT_REST);
    let [stay, slide] = [&ways[..PUSHED], &ways[PUSHED..]];
    assert!(stay.iter().all(|way| way.norm() < CREEP));
    let expected = way_of_push();
    println!("expected of those above: {:.2} mm", 1e3 * expected);
    assert!(
        slide
            .iter()
            .all(|way| (way.x / expected - 1.0).abs() < WAY_ERROR)
    );

    wanted.record(|| {
        let recording = Recording::new(&world, &trajectory).slowed(2.0);
        Ok(recording.seen_from(vector![-0.5, -0.9, 0.45], vector![0.0, 0.0, 0.2]))
    })?;
    wanted.plot(|| panels(&world, &trajectory))
}

fn panels(world: &World, trajectory: &Trajectory) -> Vec<Panel> {
    let times = || trajectory.states().iter().map(|state| state.time);
    let panel = |y_label, curves| Panel {
        x_label: "time (s)",
        y_label,
        is_log: false,
        curves,
    };
    let place = |name, body| {
        let x = show::path(trajectory, body).map(|place| place.x);
        Curve::new(name, times().zip(x))
    };
    let fastest = times().zip(trajectory.states().iter().map(fastest));
    let fastest = Curve::new("fastest block", fastest);
    let places = vec![
        place("slippery", SLIPPERY),
        place("pushed", PUSHED),
        place("highest", COUNT - 1),
    ];
    vec![
        panel("speed (m/s)", vec![fastest]),
        panel("x (m)", places),
        show::contact_force(world, trajectory, PUSHED),
    ]
}

/// The blocks above each other, with the push to come.
fn stacked() -> Result<World, Box<dyn Error>> {
    let skin = |friction| {
        Material::elastic(5e6)
            .with_dissipation(50.0)
            .with_friction(friction)
    };
    let shape = Arc::new(Shape::new(shapes::distance_cuboid(SIZE)?));
    let (mut random, mut height, mut bodies) = (StdRng::seed_from_u64(1), 0.0, Vec::new());
    for number in 0..COUNT {
        let mut between = |[low, high]: [f64; 2]| random.random_range(low..high);
        let [gap, x, y, turn] =
            [GAPS, [-SHIFT, SHIFT], [-SHIFT, SHIFT], [-TURN, TURN]].map(&mut between);
        let middle = vector![x, y, height + gap + SIZE[2] / 2.0];
        let friction = FRICTIONS[usize::from(number == SLIPPERY)];
        let name = format!("block {number}");
        let block = Body::dynamic(&name, Arc::clone(&shape), skin(friction), Mass::Total(MASS))?;
        bodies.push(block.with_pose(Pose::from_rotation_vector(&vector![0.0, 0.0, turn], middle)));
        height += gap + SIZE[2];
    }
    let hard = Material::rigid().with_friction(FRICTIONS[0]);
    bodies.push(Body::fixed("floor", HalfSpace::rigid(), hard)?);

    let push = Wrench {
        force: vector![PUSH, 0.0, 0.0],
        ..Wrench::zero()
    };
    let mut wrenches = vec![Wrench::zero(); BEFORE];
    wrenches.extend([push; PUSHING]);
    let control = Control::new(&format!("block {PUSHED}"), 0.1, wrenches)?;
    let world = World::new(bodies)?.with_gravity(vector![0.0, 0.0, -GRAVITY])?;
    Ok(world
        .with_slip_tolerance(STEPPING.2)?
        .with_control(control)?)
}

/// How far (m) the push slides the blocks above the slippery one, all together: they gain the speed v = at in the time t
/// of the push, and lose it at μg.
fn way_of_push() -> f64 {
    let [rough, slippery] = FRICTIONS;
    let braking = 2.0 * rough * slippery / (rough + slippery) * GRAVITY;
    let acceleration = PUSH / ((COUNT - PUSHED) as f64 * MASS) - braking;
    let time = PUSHING as f64 / 10.0;
    let speed = acceleration * time;
    speed * time / 2.0 + speed * speed / (2.0 * braking)
}

/// The highest speed (m/s) of a block.
fn fastest(state: &State) -> f64 {
    let speeds = state.bodies.iter().map(|body| body.velocity().norm());
    speeds.fold(0.0, f64::max)
}
