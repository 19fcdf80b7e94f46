//! Where the recording goes.

use crate::layout;
use rerun::{RecordingStream, RecordingStreamBuilder, RecordingStreamResult};
use std::path::PathBuf;

/// A running program, or a file.
pub enum Destination {
    /// The viewer that is listening, or else a new one.
    Viewer,
    /// A file for the viewer.
    File(PathBuf),
}

impl Destination {
    /// What the command line asks for.
    pub fn from_arguments(arguments: impl Iterator<Item = String>) -> Result<Self, &'static str> {
        let arguments: Vec<_> = arguments.collect();
        match &arguments[..] {
            [] => Ok(Self::Viewer),
            [option, file] if option == "--save" => Ok(Self::File(file.into())),
            _ => Err("expected no arguments, or: --save FILE.rrd"),
        }
    }

    /// A recording that goes there, with its layout.
    pub fn recording(&self) -> RecordingStreamResult<RecordingStream> {
        let builder =
            RecordingStreamBuilder::new("hydroelastic").with_blueprint(layout::blueprint());
        match self {
            Self::Viewer => builder.spawn(),
            Self::File(path) => builder.save(path),
        }
    }
}
