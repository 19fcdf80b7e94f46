//! How cost grows: with the contact polygons of a pair, the bodies of a world, the parameters of a
//! derivative, up to a hundred thousand, and the steps of a rollout.
//!
//! Serves the decision whether a scene can be afforded before it is built: from one time and the
//! exponents the others follow. An exponent above the expected one means that something grows that
//! should not. Run `cargo bench --bench growth`, a minute or so, or with `-- --quick`; add
//! `-- --svg docs/growth.svg` for the picture. Nothing else is written.
//!
//! Medians of processor time, on one thread; exponents are least-squares slopes in log-log.

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

/// What the command line asks for.
struct Wanted {
    is_quick: bool,
    svg: Option<PathBuf>,
}

fn wanted() -> Result<Wanted, String> {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let place = |name: &str| arguments.iter().position(|argument| argument == name);
    let svg = match place("--svg") {
        Some(place) => Some(arguments.get(place + 1).ok_or("--svg needs a path")?.into()),
        None => None,
    };
    Ok(Wanted {
        // Without `cargo bench`, as a test, it is quick too.
        is_quick: place("--quick").is_some() || place("--bench").is_none(),
        svg,
    })
}

fn print_exponents(panels: &[Panel]) {
    println!("\n| time grows with | of a | exponent | fitted from |");
    println!("| --- | --- | --- | --- |");
    for panel in panels {
        for curve in panel.curves.iter().filter(|curve| curve.is_measured) {
            let (exponent, first) = (curve.exponent_text(), curve.fitted()[0].0);
            let (what, name) = (panel.title, &curve.name);
            println!("| {what} | {name} | {exponent} | {first} |");
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
