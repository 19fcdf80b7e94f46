//! Growth of cost with the contact polygons of a pair, the bodies of a world, the parameters of a derivative (up to a hundred thousand),
//! and the steps of a rollout.
//!
//! Helps to estimate the cost of a scene before it is built: one measured time and the exponents give all other times. An exponent above
//! the expected value means that some cost grows although it should not. Run `cargo bench --bench growth` (about a minute), or with
//! `-- --quick`. Add `-- --svg ../docs/growth.svg` to write the figure; the bench writes no other file.
//!
//! Times are medians of processor time on one thread. Exponents are least-squares slopes in log-log coordinates.

mod backwards;
mod bodies;
mod log_axis;
mod panel;
mod parameters;
mod picture;
mod polygons;
mod scenes;
mod steps;
#[path = "../timing/mod.rs"]
mod timing;

use panel::Panel;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Options of the command line.
struct Wanted {
    is_quick: bool,
    svg: Option<PathBuf>,
}

fn wanted() -> Result<Wanted, String> {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let position_of = |name: &str| arguments.iter().position(|argument| argument == name);
    let svg = match position_of("--svg") {
        Some(index) => Some(arguments.get(index + 1).ok_or("--svg needs a path")?.into()),
        None => None,
    };
    Ok(Wanted {
        // `cargo test` runs benches too, without `--bench`. The bench is then quick.
        is_quick: position_of("--quick").is_some() || position_of("--bench").is_none(),
        svg,
    })
}

fn print_exponents(panels: &[Panel]) {
    println!("\n| time grows with | of a | exponent | fitted from |");
    println!("| --- | --- | --- | --- |");
    for panel in panels {
        for curve in panel.curves.iter().filter(|curve| curve.is_measured) {
            let (exponent, first) = (curve.exponent_text(), curve.fitted()[0].0);
            let (title, name) = (panel.title, &curve.name);
            println!("| {title} | {name} | {exponent} | {first} |");
        }
    }
}

fn save(path: &Path, panels: &[Panel]) -> Result<(), Box<dyn Error>> {
    picture::draw(path, panels)?;
    println!("\npicture: {}", path.display());
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let Wanted { is_quick, svg } = wanted()?;
    timing::use_one_thread();
    let panels = [
        polygons::measured(is_quick),
        bodies::measured(is_quick),
        parameters::measured(is_quick),
        steps::measured(is_quick),
    ];
    print_exponents(&panels);
    svg.map_or(Ok(()), |path| save(&path, &panels))
}
