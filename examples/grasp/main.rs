//! Do two soft fingers lift and tilt a mug, and what is the least squeeze with which it does not slip?
//!
//! `cargo run --release -p hydroelastic-examples --example grasp [-- --record FILE.glb --plot FILE.svg]`
//!
//! The mug is a mesh of Gmsh, not convex. One finger follows a path, the other is pressed against the mug from the other side.
//! Newton's method finds the least squeeze from the exact derivative of the slip by the force of that finger.

mod guide;
mod least_squeeze;
mod path;
mod scene;
#[path = "../show/mod.rs"]
mod show;

use hydroelastic::dynamics::{State, Trajectory};
use hydroelastic::io::Recording;
use hydroelastic::spatial::Pose;
use least_squeeze::{Lift, MAY_SLIP, held, on_face};
use nalgebra::vector;
use scene::{MUG, PRESSED, STEPPING};
use show::{Curve, Panel};
use std::error::Error;

/// Tenths of a second: until the fingers have closed, and until all is done.
const CLOSED: usize = 1;
const DONE: usize = 12;
/// How far the mug may slip (m) and tilt by itself (rad): at the slip tolerance all the time, once along the faces and once
/// about their middles.
const CREEP: f64 = STEPPING.2 * (DONE - CLOSED) as f64 / 10.0;
const TURN: f64 = CREEP / (scene::FINGER[2] / 2.0);
/// Relative error allowed in the squeeze by hand, which knows neither the handle nor that the mug turns.
const BY_HAND_ERROR: f64 = 0.2;
/// Relative error allowed in the derivative by differences.
const DIFFERENCE_ERROR: f64 = 1e-4;

fn main() -> Result<(), Box<dyn Error>> {
    let (wanted, world) = (show::wanted()?, scene::squeezed()?);
    let (_, rate, _) = STEPPING;
    let plan = scene::plan(DONE)?.recording_every(rate / 100);
    let trajectory = world.rollout(&plan).run()?;
    let [closed, last] = [&trajectory.states()[10 * CLOSED], trajectory.last()];
    let slip = (on_face(last) - on_face(closed)).norm();
    let (rise, tilted) = (height(last) - height(closed), tilt(last));
    println!(
        "lifted by {:.2} mm, tilted by {:.2}°, slipped by {:.2} mm",
        1e3 * rise,
        tilted.to_degrees(),
        1e3 * slip
    );
    assert!(slip < CREEP);
    assert!((rise - (path::HEIGHT.to - path::HEIGHT.from)).abs() < CREEP);
    assert!((tilted - path::TILT.to).abs() < TURN);

    let lift = Lift::new(&world, closed)?;
    let iterations = lift.least_squeeze()?;
    for found in &iterations {
        println!(
            "{:.6} N: slips by {:.6} mm, {:.6} mm/N",
            found.squeeze,
            1e3 * found.slip,
            1e3 * found.slope
        );
    }
    let found = &iterations[iterations.len() - 1];
    let by_hand = least_squeeze::by_hand(&world);
    println!("by hand: {by_hand:.2} N");
    assert!((found.squeeze / by_hand - 1.0).abs() < BY_HAND_ERROR);
    let difference = lift.difference(found.squeeze)?;
    println!("by differences: {:.6} mm/N", 1e3 * difference);
    assert!((difference / found.slope - 1.0).abs() < DIFFERENCE_ERROR);

    wanted.record(|| {
        let recording = Recording::new(&world, &trajectory).slowed(2.0);
        Ok(recording.seen_from(vector![0.35, -0.35, 0.25], vector![0.0, 0.0, 0.1]))
    })?;
    wanted.plot(|| {
        let misses = iterations
            .iter()
            .map(|found| (found.slip / MAY_SLIP - 1.0).abs());
        let newton = Curve::counted("slip/allowed − 1", misses);
        vec![
            over_time("height (m)", &trajectory, height),
            over_time("tilt (rad)", &trajectory, tilt),
            show::contact_force(&world, &trajectory, PRESSED),
            Panel::counted("iteration", vec![newton]),
        ]
    })
}

fn height(state: &State) -> f64 {
    held(state).z
}

/// Angle (rad) of the mug's axis to the vertical.
fn tilt(state: &State) -> f64 {
    let pose: &Pose = &state.bodies[MUG].pose;
    pose.rotation()[(2, 2)].clamp(-1.0, 1.0).acos()
}

fn over_time(y_label: &'static str, trajectory: &Trajectory, number: fn(&State) -> f64) -> Panel {
    let points = trajectory
        .states()
        .iter()
        .map(|state| (state.time, number(state)));
    Panel {
        x_label: "time (s)",
        y_label,
        is_log: false,
        curves: vec![Curve::new("mug", points)],
    }
}
