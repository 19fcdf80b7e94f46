//! Logs a rollout with the Rerun SDK: a soft ball that is thrown on the floor and bounces against a wall.
//!
//! `cargo run --release` shows the rollout in a Rerun viewer while it is computed; `cargo run --release -- --save FILE.rrd` writes it to a
//! file.

mod bodies;
mod contacts;
mod destination;
mod energies;
mod force;
mod layout;
mod palette;
mod scene;
mod surface;

use destination::Destination;
use hydroelastic::dynamics::Plan;
use std::env;
use std::error::Error;
use std::iter;
use std::process::ExitCode;

/// Time step (s), steps per frame, and number of frames after the first: one second.
const TIME_STEP: f64 = 1e-4;
const STEPS_A_FRAME: usize = 20;
const FRAMES: usize = 500;

fn main() -> ExitCode {
    match log() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Logs static data once, then each frame.
fn log() -> Result<(), Box<dyn Error>> {
    let recording = Destination::from_arguments(env::args().skip(1))?.recording()?;
    let world = scene::world()?;
    bodies::log_shapes(&recording, &world)?;
    contacts::log_styles(&recording, &world)?;
    energies::log_styles(&recording)?;

    let rollout = world.rollout(&Plan::new(TIME_STEP, STEPS_A_FRAME * FRAMES)?);
    let states = iter::once(Ok(world.initial_state())).chain(rollout);
    for state in states.step_by(STEPS_A_FRAME).take(FRAMES + 1) {
        let state = state?;
        recording.set_duration_secs(layout::TIMELINE, state.time);
        bodies::log_poses(&recording, &world, &state)?;
        contacts::log(&recording, &world, &state)?;
        energies::log(&recording, &world.report(&state)?)?;
    }
    Ok(recording.flush_blocking()?)
}
