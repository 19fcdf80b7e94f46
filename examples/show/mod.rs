//! Optional output files of an example: `--record FILE.glb` and `--plot FILE.svg`.

#![allow(dead_code, unused_imports, reason = "each example uses a part")]

mod chart;
mod panel;
mod series;

pub use panel::{Curve, Panel};
pub use series::{contact_force, energies, path};

use hydroelastic::io::Recording;
use std::error::Error;
use std::path::PathBuf;

/// Output files requested on the command line.
pub struct Wanted {
    record: Option<PathBuf>,
    plot: Option<PathBuf>,
}

/// Reads the command line.
pub fn wanted() -> Result<Wanted, Box<dyn Error>> {
    let mut wanted = Wanted {
        record: None,
        plot: None,
    };
    let mut arguments = std::env::args_os().skip(1);
    while let Some(name) = arguments.next() {
        let place = match name.to_str() {
            Some("--record") => &mut wanted.record,
            Some("--plot") => &mut wanted.plot,
            _ => return Err("only --record FILE.glb and --plot FILE.svg are known".into()),
        };
        let file = arguments.next();
        *place = Some(file.ok_or("a file is missing")?.into());
    }
    Ok(wanted)
}

impl Wanted {
    /// Creates a request of a plot only, if there is a path.
    pub fn only_plot(plot: Option<PathBuf>) -> Self {
        Self { record: None, plot }
    }

    /// Writes the recording if requested.
    pub fn record(
        &self,
        recording: impl FnOnce() -> Result<Recording, Box<dyn Error>>,
    ) -> Result<(), Box<dyn Error>> {
        if let Some(path) = &self.record {
            recording()?.write(path)?;
            println!("recording: {}", path.display());
        }
        Ok(())
    }

    /// Returns true if a plot was requested.
    pub fn has_plot(&self) -> bool {
        self.plot.is_some()
    }

    /// Draws the panels below each other if a plot was requested.
    pub fn plot(&self, panels: impl FnOnce() -> Vec<Panel>) -> Result<(), Box<dyn Error>> {
        if let Some(path) = &self.plot {
            chart::draw(path, &panels())?;
            println!("plot: {}", path.display());
        }
        Ok(())
    }
}
