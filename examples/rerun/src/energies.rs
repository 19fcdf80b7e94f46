//! The energies of a state, as lines in a plot.

use crate::layout::ENERGIES;
use hydroelastic::dynamics::Report;
use rerun::{RecordingStream, RecordingStreamResult, Scalars, SeriesLines};

const NAMES: [&str; 4] = ["kinetic", "gravitational", "contact", "total"];

/// Logs the names of the lines.
pub fn log_styles(recording: &RecordingStream) -> RecordingStreamResult<()> {
    recording.log_static(ENERGIES, &SeriesLines::new().with_names(NAMES))
}

/// Logs the energies (J).
pub fn log(recording: &RecordingStream, report: &Report) -> RecordingStreamResult<()> {
    let energies = [
        report.kinetic_energy,
        report.gravitational_energy,
        report.contact_energy,
        report.total_energy(),
    ];
    recording.log(ENERGIES, &Scalars::new(energies))
}
