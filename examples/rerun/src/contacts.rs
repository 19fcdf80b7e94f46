//! Logging of contacts: surfaces and arrows in space, forces in a plot.

use crate::layout::{FORCES, WORLD};
use crate::{force, palette, surface};
use hydroelastic::dynamics::{Contact, State, World};
use rerun::{RecordingStream, RecordingStreamResult, Scalars, SeriesLines};

/// Logs the names and colors of the lines in the plot.
pub fn log_styles(recording: &RecordingStream, world: &World) -> RecordingStreamResult<()> {
    let mut colors = palette::LINES.into_iter().cycle();
    for bodies in pairs(world) {
        let name = name(world, bodies);
        let names = ["normal", "friction"].map(|part| format!("{name} {part}"));
        let lines = SeriesLines::new()
            .with_colors(colors.by_ref().take(names.len()))
            .with_names(names);
        recording.log_static(format!("{FORCES}/{name}"), &lines)?;
    }
    Ok(())
}

/// Logs all pairs of bodies. Pairs that do not touch are logged too, because the viewer otherwise keeps showing their last contact.
pub fn log(recording: &RecordingStream, world: &World, state: &State) -> RecordingStreamResult<()> {
    let contacts = world.contacts(state).expect("a state of this world");
    for bodies in pairs(world) {
        let contact = contacts.iter().find(|contact| contact.bodies == bodies);
        log_pair(recording, &name(world, bodies), contact)?;
    }
    Ok(())
}

fn log_pair(
    recording: &RecordingStream,
    name: &str,
    contact: Option<&Contact>,
) -> RecordingStreamResult<()> {
    let place = format!("{WORLD}/contacts/{name}");
    let surface = surface::mesh(contact.map(|contact| &contact.surface));
    recording.log(format!("{place}/surface"), &surface)?;
    recording.log(format!("{place}/force"), &force::arrow(contact))?;
    let parts = Scalars::new(force::normal_and_friction(contact));
    recording.log(format!("{FORCES}/{name}"), &parts)
}

/// Yields the pairs of bodies that can touch, smaller index first. At least one body of a pair moves.
fn pairs(world: &World) -> impl Iterator<Item = [usize; 2]> {
    let count = world.bodies().len();
    let all = (0..count).flat_map(move |i| (i + 1..count).map(move |j| [i, j]));
    all.filter(|pair| pair.iter().any(|&i| world.bodies()[i].inertia().is_some()))
}

fn name(world: &World, bodies: [usize; 2]) -> String {
    bodies.map(|i| world.bodies()[i].name()).join("-")
}
