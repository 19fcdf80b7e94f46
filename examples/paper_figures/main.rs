//! The figures of the paper, drawn from what this library computes: SVG files in a folder.
//!
//! `cargo run --release -p hydroelastic-examples --example paper_figures [FOLDER]`
//!
//! Without a folder they go to `hydroelastic_figures` in the directory for temporary files. Every
//! figure is checked before it is drawn.

mod arrow;
mod ball_on_flat;
mod ball_on_incline;
mod bounce;
mod chart;
mod clipping;
mod color_bar;
mod energies;
mod figure_1;
mod figure_2;
mod figure_3;
mod figure_4;
mod half_planes;
mod half_planes_picture;
mod incline;
mod incline_view;
#[path = "../../benches/growth/log_axis.rs"]
mod log_axis;
mod names;
mod pressure_picture;
mod solid;
mod strobe;
mod style;
mod table_1;
mod table_1_times;
mod thinning;
mod trails;
mod view;

use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, SVGBackend};
use std::error::Error;
use std::path::{Path, PathBuf};

type Answer<T = ()> = Result<T, Box<dyn Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Draws a figure into a file, and says what it shows.
type Figure = fn(&Path) -> Answer<String>;

const FIGURES: [(&str, Figure); 7] = [
    ("figure_1.svg", figure_1::draw),
    ("figure_2.svg", figure_2::draw),
    ("figure_3.svg", figure_3::draw),
    ("figure_4.svg", figure_4::draw),
    ("table_1.svg", table_1::draw),
    ("ball_on_flat.svg", ball_on_flat::draw),
    ("ball_on_incline.svg", ball_on_incline::draw),
];

fn main() -> Answer {
    let folder = folder();
    std::fs::create_dir_all(&folder)?;
    for (name, draw) in FIGURES {
        let path = folder.join(name);
        let shown = draw(&path)?;
        println!("{}: {shown}", path.display());
    }
    Ok(())
}

/// The first argument, or the folder for those who gave none.
fn folder() -> PathBuf {
    let given = std::env::args_os().nth(1).map(PathBuf::from);
    given.unwrap_or_else(|| std::env::temp_dir().join("hydroelastic_figures"))
}
