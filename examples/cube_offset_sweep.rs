//! The paper's Figure 3: the force between two unit cubes against their offset, as an SVG.
//!
//! `cargo run --release --example cube_offset_sweep [FILE.svg]`

use hydroelastic::contact::{ContactBody, ContactPair, Shape};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;
use plotters::prelude::*;
use std::error::Error;
use std::path::{Path, PathBuf};

/// The paper's cubes have pressure ½ at their centres.
const MODULUS: f64 = 0.5;

/// Offsets from −1 to 1.
const STEPS: i32 = 200;

/// How far a force may be from the closed form (1 − |x|³)/6.
const EXACT: f64 = 1e-12;

fn main() -> Result<(), Box<dyn Error>> {
    let cube = Shape::new(shapes::cuboid([1.0; 3])?);
    let mut sweep = Vec::new();
    for step in -STEPS..=STEPS {
        let offset = f64::from(step) / f64::from(STEPS);
        sweep.push((offset, force_between(&cube, offset)?));
    }
    let path = output_path("cube_offset_sweep.svg");
    draw(&path, &sweep)?;
    println!("force against offset: {}", path.display());

    for (offset, force) in sweep {
        // Wholly coincident cubes push nowhere: the one point off the curve.
        let expected = if offset == 0.0 {
            0.0
        } else {
            (1.0 - offset.abs().powi(3)) / 6.0
        };
        assert!(
            (force - expected).abs() <= EXACT,
            "{force} at {offset}, not {expected}"
        );
    }
    println!("every force is (1 − |x|³)/6 to {EXACT:e}, and 0 at x = 0");
    Ok(())
}

/// Magnitude of the force (N) on a cube moved along y.
fn force_between(cube: &Shape, offset: f64) -> Result<f64, Box<dyn Error>> {
    let moved = Pose::from_translation(Vector3::new(0.0, offset, 0.0));
    let pair = ContactPair::new(
        ContactBody::new(cube, moved, MODULUS)?,
        ContactBody::new(cube, Pose::identity(), MODULUS)?,
    );
    Ok(pair.wrench().on_a.force.norm())
}

fn draw(path: &Path, sweep: &[(f64, f64)]) -> Result<(), Box<dyn Error>> {
    let area = SVGBackend::new(path, (720, 400)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption("Force between two unit cubes", ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d(-1.0..1.0, 0.0..0.18)?;
    chart
        .configure_mesh()
        .x_desc("offset (m)")
        .y_desc("force (N)")
        .draw()?;
    chart.draw_series(LineSeries::new(sweep.iter().copied(), BLUE.stroke_width(2)))?;
    area.present()?;
    Ok(())
}

/// The first argument, or the file in the directory for temporary files.
fn output_path(file: &str) -> PathBuf {
    let given = std::env::args_os().nth(1).map(PathBuf::from);
    given.unwrap_or_else(|| std::env::temp_dir().join(file))
}
