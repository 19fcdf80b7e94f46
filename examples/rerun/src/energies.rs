//! Logging of the energies of a state, as lines in a plot.

use crate::layout::ENERGIES;
use crate::palette;
use hydroelastic::dynamics::Diagnostics;
use rerun::{RecordingStream, RecordingStreamResult, Scalars, SeriesLines};

const NAMES: [&str; 4] = ["kinetic", "gravitational", "contact", "total"];

/// Logs the names and colors of the lines.
pub fn log_styles(recording: &RecordingStream) -> RecordingStreamResult<()> {
    let lines = SeriesLines::new().with_names(NAMES);
    recording.log_static(ENERGIES, &lines.with_colors(palette::LINES))
}

/// Logs the energies (J).
pub fn log(recording: &RecordingStream, report: &Diagnostics) -> RecordingStreamResult<()> {
    let energies = [
        report.kinetic_energy,
        report.gravitational_energy,
        report.contact_energy,
        report.total_energy(),
    ];
    recording.log(ENERGIES, &Scalars::new(energies))
}
