//! Destination of the recording.

use crate::layout;
use rerun::{RecordingStream, RecordingStreamBuilder, RecordingStreamResult};
use std::path::PathBuf;

/// A viewer or a file.
pub enum Destination {
    /// A viewer that is already listening, or a new viewer.
    Viewer,
    /// A file for the viewer.
    File(PathBuf),
}

impl Destination {
    /// Reads the destination from the command line.
    pub fn from_arguments(arguments: impl Iterator<Item = String>) -> Result<Self, &'static str> {
        let arguments: Vec<_> = arguments.collect();
        match &arguments[..] {
            [] => Ok(Self::Viewer),
            [option, file] if option == "--save" => Ok(Self::File(file.into())),
            _ => Err("expected no arguments, or: --save FILE.rrd"),
        }
    }

    /// Creates a recording to the destination, with its layout.
    pub fn recording(&self) -> RecordingStreamResult<RecordingStream> {
        let builder =
            RecordingStreamBuilder::new("hydroelastic").with_blueprint(layout::blueprint());
        match self {
            Self::Viewer => builder.spawn(),
            Self::File(path) => builder.save(path),
        }
    }
}
